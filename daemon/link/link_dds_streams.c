/* link_dds_streams: each stream has a writer of its own, in a partition of its name, or, of many, a share in one. The
 * tick thread, but for the listener that sees its readers come, and the thread that deletes writers. */
#include "base/clock.h"
#include "base/log.h"
#include "link_dds_own.h"
#include "wire/dds/wire_dds_qos.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* Where the stream of that name is, or would be. */
static size_t stream_place(const link_dds *l, const char *name, bool *found)
{
    size_t from = 0, to = l->streams.count;
    *found = false;
    while (from < to && !*found) {
        size_t middle = (from + to) / 2;
        int order = strcmp(name, l->streams.at[middle]->name);
        if (order > 0)
            from = middle + 1;
        else
            to = middle;
        *found = order == 0;
    }
    return to;
}

stream *link_dds_stream_find(const link_dds *l, const char *name)
{
    bool found;
    size_t i = stream_place(l, name, &found);
    return found ? l->streams.at[i] : NULL;
}

/* ---- shared writers ---- */

enum { OWN_STREAMS = 16 /* so many have a writer of their own, whoever reads them */, SHARED_DEPTH = 1024 };

/* The first readers' participants, at most so many as `most`. */
static size_t participants_of(dds_entity_t writer, dds_instance_handle_t *participants, size_t most)
{
    dds_return_t count = dds_get_matched_subscriptions(writer, participants, most);
    size_t found = 0;
    for (size_t i = 0; count > 0 && i < (size_t)count && i < most; i++) {
        dds_builtintopic_endpoint_t *reader = dds_get_matched_subscription_data(writer, participants[i]);
        if (!reader) continue;
        participants[found++] = reader->participant_instance_handle;
        dds_builtintopic_free_endpoint(reader);
    }
    return found;
}

static bool is_among(uint64_t participant, const dds_instance_handle_t *participants, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (participants[i] == participant) return true;
    return false;
}

/* Those of its streams whose client reads there. */
static void report_shared(link_dds *l, shared_events *shared, const link_sink *sink)
{
    enum { MOST = 4096 };
    dds_instance_handle_t *participants = base_alloc(MOST, sizeof *participants);
    size_t count = participants_of(shared->out.entity, participants, MOST);
    for (size_t i = 0; i < l->streams.count; i++) {
        stream *s = l->streams.at[i];
        if (s->shared != shared || s->reported) continue;
        s->reported = is_among(speakers_participant(&l->speakers, s->client), participants, count);
        if (s->reported) sink->stream_reader(sink->context, &l->head, s->name);
    }
    free(participants);
}

static void report_all_shared(link_dds *l, link_dds *in, const link_sink *sink)
{
    for (size_t i = 0; i < WIRE_DDS_EVENTS; i++)
        if (atomic_exchange(&in->shared[i].matched, false)) report_shared(l, &in->shared[i], sink);
}

void link_dds_streams_report(link_dds *l, const link_sink *sink)
{
    for (size_t i = 0; i < l->streams.count; i++) {
        stream *s = l->streams.at[i];
        if (atomic_exchange(&s->matched, false)) sink->stream_reader(sink->context, &l->head, s->name);
    }
    report_all_shared(l, l, sink);
    unsigned number = 1;
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;) report_all_shared(l, room, sink);
}

/* One of Cyclone's threads. */
static void on_shared_matched(dds_entity_t entity, const dds_publication_matched_status_t status, void *context)
{
    (void)entity;
    shared_events *shared = context;
    if (status.current_count_change <= 0) return;
    atomic_store(&shared->out.fresh, true);
    link_dds_notice(shared->owner, &shared->matched);
}

/* A stream has its client's id and a number as its name, unless that named it. */
static bool is_unnamed(const char *name, int64_t *client)
{
    char *end;
    if (strspn(name, "0123456789abcdef") != 16 || name[16] != '.') return false;
    *client = (int64_t)strtoull(name, &end, 16);
    return name[17] && strspn(name + 17, "0123456789") == strlen(name + 17);
}

/* NULL: this stream has a writer of its own, and no other. */
static shared_events *shared_for(link_dds *l, link_dds *home, const char *name, int64_t client)
{
    int64_t named_after;
    int group = speakers_events_group(&l->speakers, client);
    if (home->room) return link_dds_shared(home, group > 0 ? ((unsigned)group - 1) % WIRE_DDS_ROOM_GROUPS : 0);
    if (l->own_streams < OWN_STREAMS || !group || !is_unnamed(name, &named_after)) return NULL;
    return link_dds_shared(l, (unsigned)group - 1);
}

shared_events *link_dds_shared(link_dds *l, unsigned group)
{
    shared_events *shared = &l->shared[group];
    if (shared->out.entity > 0) return shared;
    char partition[WIRE_DDS_PARTITION_MAX];
    wire_dds_events(group, partition);
    shared->owner = l;
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_publication_matched_arg(listener, on_shared_matched, shared, true);
    dds_qos_t *qos = wire_dds_qos(WIRE_EVENT_BATCH, WIRE_DDS_WRITER, NULL, 0);
    dds_qset_partition1(qos, partition);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, SHARED_DEPTH);
    shared->out.entity = dds_create_writer(l->participant, link_dds_topic(l, WIRE_EVENT_BATCH), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    return shared->out.entity > 0 ? shared : NULL;
}

/* Each packet wakes all who share it, and each of them acknowledges it: so one has the heartbeats of nearly a period.
 * Of so many streams there is a heartbeat every few dozen milliseconds: what waits is not forgotten. */
enum { CROWD = 32 /* streams */, HEARTBEATS_WAIT_MS = 800 };

static bool may_wait(const link_dds *l, const shared_events *shared)
{
    return shared && shared->idle_ns && l->streams.count >= CROWD &&
           clock_monotonic_ns() - shared->idle_ns < HEARTBEATS_WAIT_MS * INT64_C(1000000);
}

void link_dds_stream_note(const stream *s, const wire_message *m)
{
    shared_events *shared = s->shared;
    if (!shared) return;
    if (!m->event_batch.heartbeat)
        shared->idle_ns = 0;
    else if (!shared->out.dirty)
        shared->idle_ns = clock_monotonic_ns();
}

static void flush_stream(link_dds *l, writer *w)
{
    link_dds_flush_writer(w);
    if (atomic_exchange(&w->fresh, false)) reminder_put(&l->reminder, w->entity);
}

void link_dds_streams_flush(link_dds *l)
{
    for (size_t i = 0; i < l->streams.count; i++) {
        stream *s = l->streams.at[i];
        if (s->out->dirty && !may_wait(l, s->shared)) flush_stream(l, s->out);
        if (s->own.dirty) flush_stream(l, &s->own);
    }
}

/* ---- streams ---- */

/* One of Cyclone's threads. */
static void on_matched(dds_entity_t entity, const dds_publication_matched_status_t status, void *context)
{
    (void)entity;
    stream *s = context;
    if (status.current_count_change <= 0) return;
    atomic_store(&s->own.fresh, true);
    link_dds_notice(s->owner, &s->matched);
}

static stream *stream_create(link_dds *l, const char *name, int64_t client)
{
    int64_t named_after;
    stream *s = base_zalloc(1, sizeof *s);
    s->owner = l;
    s->name = base_strdup(name);
    s->out = &s->own;
    s->client = client;
    s->home = link_dds_home(l, client);
    s->shared = shared_for(l, s->home, name, client);
    if (s->shared) {
        s->out = &s->shared->out;
        atomic_store(&s->out->fresh, true);
        link_dds_notice(l, &s->shared->matched);
        if (!s->home->room || is_unnamed(name, &named_after)) return s; /* one with a name others may read, too */
    }
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_publication_matched_arg(listener, on_matched, s, true);
    dds_qos_t *qos = wire_dds_qos(WIRE_EVENT_BATCH, WIRE_DDS_WRITER, name, 0);
    s->own.entity = dds_create_writer(l->participant, link_dds_topic(l, WIRE_EVENT_BATCH), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    l->own_streams += s->own.entity > 0;
    if (s->own.entity <= 0) log_error("DDS: stream %s: %s", name, dds_strretcode(s->own.entity));
    return s;
}

static const int64_t STREAM_LAST_WORDS_NS = 1000000000;

/* Cyclone waits until the readers of a writer have acknowledged what was flushed, for a second at most (a reader that
 * was killed never does), and does not say again meanwhile what was lost: so before that, we do. */
static void stream_destroy(stream *s)
{
    if (s->own.entity > 0) {
        reminder_forget(&s->owner->reminder, s->own.entity);
        link_dds_await(s->own.entity, clock_monotonic_ns() + STREAM_LAST_WORDS_NS);
        dds_delete(s->own.entity);
    }
    free(s->name);
    free(s);
}

/* ---- the thread that waits for that ---- */

static void *delete_closed(void *context)
{
    stream_closer *c = context;
    pthread_mutex_lock(&c->lock);
    for (;;) {
        while (!c->closed.count && !c->ends) pthread_cond_wait(&c->wake, &c->lock);
        if (!c->closed.count) break;
        stream *s = c->closed.at[0];
        memmove(c->closed.at, c->closed.at + 1, --c->closed.count * sizeof c->closed.at[0]);
        pthread_mutex_unlock(&c->lock);
        stream_destroy(s);
        pthread_mutex_lock(&c->lock);
    }
    pthread_mutex_unlock(&c->lock);
    return NULL;
}

void link_dds_closer_start(stream_closer *c)
{
    pthread_mutex_init(&c->lock, NULL);
    pthread_cond_init(&c->wake, NULL);
    c->runs = pthread_create(&c->thread, NULL, delete_closed, c) == 0;
    if (!c->runs) log_error("no thread to close streams with: ticks wait for their readers");
}

/* Its last words are on their way; its writer goes when they have arrived. */
static void close_stream(link_dds *l, stream *s)
{
    link_dds_flush_writer(s->out);
    link_dds_flush_writer(&s->own);
    l->own_streams -= s->own.entity > 0;
    if (!l->closer.runs || s->own.entity <= 0) {
        stream_destroy(s);
        return;
    }
    pthread_mutex_lock(&l->closer.lock);
    array_push(&l->closer.closed, s);
    pthread_cond_signal(&l->closer.wake);
    pthread_mutex_unlock(&l->closer.lock);
}

static void closer_end(stream_closer *c)
{
    pthread_mutex_lock(&c->lock);
    c->ends = true;
    pthread_cond_signal(&c->wake);
    pthread_mutex_unlock(&c->lock);
    if (c->runs) pthread_join(c->thread, NULL);
    array_free(&c->closed);
    pthread_cond_destroy(&c->wake);
    pthread_mutex_destroy(&c->lock);
}

/* The sink may have been told when it had no such stream. */
static void report_readers_again(link_dds *l, stream *s)
{
    dds_publication_matched_status_t status;
    s->reported = false;
    if (s->shared)
        link_dds_notice(l, &s->shared->matched);
    else if (dds_get_publication_matched_status(s->own.entity, &status) == DDS_RETCODE_OK && status.current_count)
        link_dds_notice(l, &s->matched);
}

/* Who comes back may do so in another room. */
static bool is_at_home(link_dds *l, const stream *s, int64_t client)
{
    return s->client == client && s->home == link_dds_home(l, client);
}

void link_dds_stream_open(struct link *head, const char *name, int64_t client)
{
    link_dds *l = link_dds_of(head);
    bool found;
    assert(!l->on_arrival);
    size_t i = stream_place(l, name, &found);
    if (found && is_at_home(l, l->streams.at[i], client)) {
        report_readers_again(l, l->streams.at[i]);
        return;
    }
    if (found) { /* its last words may still be under way where he was */
        close_stream(l, l->streams.at[i]);
        l->streams.at[i] = stream_create(l, name, client);
        return;
    }
    array_reserve(&l->streams, l->streams.count + 1);
    memmove(l->streams.at + i + 1, l->streams.at + i, (l->streams.count - i) * sizeof l->streams.at[0]);
    l->streams.at[i] = stream_create(l, name, client);
    l->streams.count++;
}

void link_dds_stream_close(struct link *head, const char *name)
{
    link_dds *l = link_dds_of(head);
    bool found;
    assert(!l->on_arrival);
    size_t i = stream_place(l, name, &found);
    if (!found) return;
    close_stream(l, l->streams.at[i]);
    l->streams.count--;
    memmove(l->streams.at + i, l->streams.at + i + 1, (l->streams.count - i) * sizeof l->streams.at[0]);
}

void link_dds_streams_close(link_dds *l)
{
    for (size_t i = 0; i < l->streams.count; i++) close_stream(l, l->streams.at[i]);
    array_free(&l->streams);
    closer_end(&l->closer);
}
