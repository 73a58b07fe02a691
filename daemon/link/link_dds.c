/* link_dds: one participant with a reader for each kind that clients send and a writer for each kind that the daemon
 * sends. What belongs to it by subject: link_dds_own.h.
 *
 * Cyclone's threads run the listeners: these set a flag, and wake the tick thread if no flag was set before. All else
 * is the tick thread's, but for poses: when nothing else waits, their listener offers the round to the service, which
 * takes them, ticks and writes there and then (link_options.poses). That is the thread that processes acknowledgements,
 * and Cyclone holds the lock of the poses' writer's proxy meanwhile. So nothing may be done there that waits for an
 * acknowledgement or for another thread of Cyclone's: all writers keep the last (wire_dds_qos.c), whose cache has no
 * high-water mark, so that a write never waits (q_entity.c, writer_new; tests/link/test_link_dds.c holds it to that),
 * and entities are created and deleted by the tick thread alone. */
#include "link_dds.h"

#include "base/clock.h"
#include "base/log.h"
#include "link_dds_own.h"
#include "wake.h"
#include "wire/dds/wire_dds.h"
#include "wire/dds/wire_dds_qos.h"
#include "wire/dds/wire_dds_security.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

enum { LAST_WORDS_MS = 500 /* closing: for acknowledgements still to come */ };

static const wire_kind kinds_in[] = {WIRE_CLIENT, WIRE_GEOMETRY, WIRE_BODY, WIRE_SUBSCRIPTION, WIRE_POSE_BATCH,
    WIRE_VERTEX_BATCH, WIRE_QUERY, WIRE_RECEIPT};
static const wire_kind kinds_out[] = {WIRE_ANSWER, WIRE_STATUS, WIRE_REJECT, WIRE_ACK, WIRE_ANSWER};
static const wire_kind kinds_reply[] = {WIRE_ANSWER, WIRE_ANSWER, WIRE_REJECT, WIRE_ACK};
static_assert(sizeof kinds_in / sizeof kinds_in[0] == LINK_DDS_IN, "a reader each");
static_assert(sizeof kinds_out / sizeof kinds_out[0] == LINK_DDS_OUT, "a writer each");
static_assert(sizeof kinds_reply / sizeof kinds_reply[0] == LINK_DDS_REPLIES, "a writer each, in each group");

/* ---- Cyclone's threads ---- */

void link_dds_notice(link_dds *l, atomic_bool *flag)
{
    atomic_store(flag, true);
    if (!atomic_exchange(&l->whole->woken, true)) wake(l->whole->head.options.wake_fd);
}

static void on_data(dds_entity_t entity, void *context)
{
    (void)entity;
    reader *r = context;
    link_dds_notice(r->owner, &r->arrived);
}

static void on_discovery(dds_entity_t entity, void *context)
{
    (void)entity;
    link_dds *l = context;
    link_dds_notice(l, &l->has_discovered);
}

static bool others_wait(link_dds *l)
{
    bool wait = atomic_load(&l->has_discovered) || atomic_load(&l->has_news) || atomic_load(&l->peers_arrived) ||
                atomic_load(&l->has_lost);
    for (size_t i = 0; i < LINK_DDS_IN; i++)
        wait |= l->readers[i].kind != WIRE_POSE_BATCH && l->readers[i].kind != WIRE_RECEIPT &&
                atomic_load(&l->readers[i].arrived);
    return wait;
}

/* Behind something else that waits, poses wait as well: what was said first is heard first. Poses that wait are taken
 * with those that come. */
static void on_poses(dds_entity_t entity, void *context)
{
    (void)entity;
    reader *r = context;
    const link_options *o = &r->owner->head.options;
    bool alone = o->poses && !others_wait(r->owner);
    atomic_store(&r->arrived, true);
    if (!alone || !o->poses(o->poses_context, &r->owner->head)) link_dds_notice(r->owner, &r->arrived);
}

/* What Cyclone itself notices: samples that were to come and are gone. What was forged it does not: see unheard.c. On a
 * thread of Cyclone's. */
static void on_sample_lost(dds_entity_t entity, const dds_sample_lost_status_t status, void *context)
{
    (void)entity;
    const reader *r = context;
    if (status.total_count_change > 0) link_dds_note_lost(r->owner, r->kind, (size_t)status.total_count_change);
}

void link_dds_note_lost(link_dds *l, wire_kind kind, size_t count)
{
    metric_count(l->samples_lost, count);
    atomic_fetch_add(&l->lost[kind], count);
    link_dds_notice(l, &l->has_lost);
}

/* A client's liveliness is that of its writer of Client. */
static void on_liveliness(dds_entity_t entity, const dds_liveliness_changed_status_t status, void *context)
{
    (void)entity;
    link_dds *l = ((reader *)context)->owner;
    speakers_heartbeat(&l->whole->speakers, &status);
    link_dds_notice(l, &l->has_news);
}

static void on_peers(void *context)
{
    link_dds *l = context;
    link_dds_notice(l, &l->peers_arrived);
}

/* ---- opening ---- */

dds_entity_t link_dds_topic(link_dds *l, wire_kind kind)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    if (l->topics[kind] <= 0)
        l->topics[kind] = dds_create_topic(l->participant, wire_dds_descriptor(kind), name, NULL, NULL);
    return l->topics[kind];
}

static bool open_reader(link_dds *l, reader *r, wire_kind kind)
{
    r->owner = l;
    r->kind = kind;
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_data_available_arg(listener, kind == WIRE_POSE_BATCH ? on_poses : on_data, r, true);
    dds_lset_sample_lost_arg(listener, on_sample_lost, r, true);
    if (kind == WIRE_CLIENT) dds_lset_liveliness_changed_arg(listener, on_liveliness, r, true);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_READER, NULL, 0);
    r->entity = dds_create_reader(l->participant, link_dds_topic(l, kind), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    return r->entity > 0;
}

static bool open_speakers(link_dds *l)
{
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_data_available_arg(listener, on_discovery, l, true);
    bool opened = speakers_open(&l->ear, l->participant, l->room, listener);
    dds_delete_listener(listener);
    return opened;
}

/* A reader that does not acknowledge makes a writer keep as many answers as its history holds, of up to 1.6 MB each. So
 * the large ones, which are few, have a writer with a short one: 16 MB and 51 MB at most. */
enum {
    ANSWERS_LARGE = LINK_DDS_OUT - 1,
    REPLIES_LARGE = 1,
    ANSWER_SMALL_HITS = 40,
    ANSWERS_LARGE_DEPTH = 32,
    REPLIES_LARGE_DEPTH = 4 /* of one group */
};

static bool is_large(const wire_message *m)
{
    return m->kind == WIRE_ANSWER && m->answer.lo.count > ANSWER_SMALL_HITS;
}

/* One of Cyclone's threads. */
static void on_status_matched(dds_entity_t entity, const dds_publication_matched_status_t status, void *context)
{
    (void)entity;
    link_dds *l = context;
    if (status.current_count_change > 0) link_dds_notice(l, &l->status_matched);
}

static dds_entity_t create_writer(link_dds *l, wire_kind kind, const dds_qos_t *qos)
{
    dds_listener_t *listener = dds_create_listener(NULL);
    if (kind == WIRE_STATUS) dds_lset_publication_matched_arg(listener, on_status_matched, l, true);
    dds_entity_t entity = dds_create_writer(l->participant, link_dds_topic(l, kind), qos, listener);
    dds_delete_listener(listener);
    return entity;
}

static bool open_writer(link_dds *l, writer *w, wire_kind kind)
{
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, 0);
    if (w == &l->writers[ANSWERS_LARGE]) dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, ANSWERS_LARGE_DEPTH);
    w->entity = create_writer(l, kind, qos);
    w->kind = kind;
    dds_delete_qos(qos);
    return w->entity > 0;
}

static bool open_replies(link_dds *l, writer *w, wire_kind kind, unsigned group)
{
    char partition[WIRE_DDS_PARTITION_MAX];
    wire_dds_replies(group, partition);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, 0);
    dds_qset_partition1(qos, partition);
    if (w == &l->replies[group][REPLIES_LARGE]) dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, REPLIES_LARGE_DEPTH);
    w->entity = dds_create_writer(l->participant, link_dds_topic(l, kind), qos, NULL);
    dds_delete_qos(qos);
    return w->entity > 0;
}

/* Writers are discovered in the order of their creation: by the time that a client knows that of the acks of its group,
 * it knows the others of its group. */
bool link_dds_open_ends(link_dds *l)
{
    unsigned groups = l->room ? WIRE_DDS_ROOM_GROUPS : WIRE_DDS_REPLIES;
    bool ok = open_speakers(l) && link_dds_topic(l, WIRE_EVENT_BATCH) > 0;
    for (unsigned g = 0; g < groups; g++)
        for (size_t i = 0; i < LINK_DDS_REPLIES && ok; i++) ok = open_replies(l, &l->replies[g][i], kinds_reply[i], g);
    for (size_t i = 0; i < LINK_DDS_IN && ok; i++) ok = open_reader(l, &l->readers[i], kinds_in[i]);
    for (size_t i = 0; i < LINK_DDS_OUT && ok; i++) /* in a room everybody is in a group */
        ok = (l->room && kinds_out[i] != WIRE_STATUS) || open_writer(l, &l->writers[i], kinds_out[i]);
    for (unsigned g = 0; g < WIRE_DDS_ROOM_GROUPS && l->room && ok; g++) ok = link_dds_shared(l, g) != NULL;
    return ok;
}

/* The first of that kind, which is for all. */
static writer *writer_of(link_dds *l, wire_kind kind)
{
    size_t i = 0;
    while (i < LINK_DDS_OUT && kinds_out[i] != kind) i++;
    return i < LINK_DDS_OUT ? &l->writers[i] : NULL;
}

static size_t largest_sample(void)
{
    size_t most = 0;
    for (wire_kind k = WIRE_CLIENT; k < WIRE_KIND_COUNT; k++)
        if (wire_dds_sample_size(k) > most) most = wire_dds_sample_size(k);
    return most;
}

static void register_counters(link_dds *l, metrics *m)
{
    l->messages_in = metrics_add(m, "dds_messages_in", "messages of clients taken from DDS");
    l->refused = metrics_add(m, "dds_refused", "messages from DDS that were refused: out of range");
    l->foreign = metrics_add(m, "dds_foreign", "messages from DDS in the name of a client that another one speaks for");
    l->history_full = metrics_add(m, "dds_history_full", "takes that found a reader's history full: older were lost");
    l->messages_out = metrics_add(m, "dds_messages_out", "messages written to DDS");
    l->write_failed = metrics_add(m, "dds_write_failed", "messages that DDS refused to write");
    l->samples_lost = metrics_add(m, "dds_samples_lost", "messages that DDS found to be lost on their way to us");
    l->no_stream = metrics_add(m, "dds_no_stream", "event batches for a stream that is not open");
}

static void free_own(link_dds *l)
{
    speakers_free(&l->speakers);
    dds_peers_free(&l->peers);
    turns_free(&l->waiting);
    free(l->sample);
}

static int dds_link_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_dds *l = link_dds_of(head);
    char key[LINK_KEY_MAX];
    link_dds_complaint first = {""};
    l->whole = l;
    if (link_dds_check(options, key, why, why_size) != EX_OK) return -1;
    register_counters(l, options->counters);
    l->sample = base_zalloc(1, largest_sample());
    turns_init(&l->waiting);
    speakers_init(&l->speakers, options->max_clients, options->client_share);
    dds_peers_init(&l->peers, on_peers, l);
    dds_return_t joined = link_dds_join(l, &first);
    if (*options->security) {
        l->certificate_days = metrics_add(
            options->counters, "certificate_days", "days until the first certificate of the security folder expires");
        l->certificate_end_s = wire_dds_security_ends_s(options->security);
    }
    if (joined == DDS_RETCODE_OK && link_dds_open_ends(l)) {
        link_dds_closer_start(&l->closer);
        if (options->interface && *options->interface) return 0;
        const joiners_rooms rooms = link_dds_rooms(l);
        joiners_start(&l->joiners, link_dds_domain(l), l->participant, &rooms, options->counters);
        reminder_start(&l->reminder);
        return 0;
    }
    link_dds_leave(l);
    link_dds_say_why(options, &first, joined, why, why_size);
    free_own(l);
    return -1;
}

/* ---- publishing ---- */

/* In that group, from 1; NULL: it is no reply, or there is no group. */
static writer *reply_writer(link_dds *l, const wire_message *m, int group)
{
    for (size_t i = 0; group && i < LINK_DDS_REPLIES; i++)
        if (kinds_reply[i] == m->kind) return &l->replies[group - 1][is_large(m) ? REPLIES_LARGE : i];
    return NULL;
}

static int64_t client_of(const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    return client;
}

static bool is_not_yours(const wire_message *m)
{
    return m->kind == WIRE_REJECT && m->reject.reason == WIRE_NOT_YOURS;
}

/* In the group of the client that it is for; NULL: it is for all, or for one in no group. Who speaks under the name of
 * another may read elsewhere than that one does. */
static writer *reply_writer_for(link_dds *l, const wire_message *m)
{
    if (is_not_yours(m) || !reply_writer(l, m, 1)) return NULL;
    int64_t client = client_of(m);
    link_dds *home = link_dds_home(l, client);
    int group = speakers_group(&l->speakers, client);
    if (home->room && (group < 1 || group > WIRE_DDS_ROOM_GROUPS)) group = 1; /* it is none of the library's */
    return reply_writer(home, m, group);
}

static writer *writer_for(link_dds *l, const wire_message *m)
{
    writer *reply = reply_writer_for(l, m);
    if (reply) return reply;
    return is_large(m) ? &l->writers[ANSWERS_LARGE] : writer_of(l, m->kind);
}

static void write_to(link_dds *l, writer *w, wire_kind kind)
{
    dds_return_t written = dds_write(w->entity, l->whole->sample);
    w->dirty = true;
    metric_count(written == DDS_RETCODE_OK ? l->messages_out : l->write_failed, 1);
    if (written != DDS_RETCODE_OK) log_warning("DDS: %s: %s", wire_kind_name(kind), dds_strretcode(written));
}

/* What is for someone who does not speak for that client (there is no place for him, he has left, the name is
 * another's) goes to the partition without a name, and to the groups that the library puts this client's number into,
 * everywhere: nobody knows where he is. */
static void write_to_presumed(link_dds *l, const wire_message *m)
{
    int64_t client = client_of(m);
    unsigned number = 1, group = wire_dds_replies_of(client);
    if (!reply_writer(l, m, 1) || (!is_not_yours(m) && speakers_participant(&l->speakers, client))) return;
    write_to(l, reply_writer(l, m, 1 + (int)group), m->kind);
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;)
        write_to(l, reply_writer(room, m, 1 + (int)(group % WIRE_DDS_ROOM_GROUPS)), m->kind);
}

static void write_status_in_rooms(link_dds *l)
{
    unsigned number = 1;
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;)
        write_to(l, writer_of(room, WIRE_STATUS), WIRE_STATUS);
}

static void publish_batch(link_dds *l, const wire_message *m)
{
    stream *s = link_dds_stream_find(l, m->event_batch.stream);
    if (!s) {
        metric_count(l->no_stream, 1);
        return;
    }
    link_dds_stream_note(s, m);
    wire_dds_encode(m, l->sample);
    write_to(l, s->out, m->kind);
    if (s->shared && s->own.entity > 0) write_to(l, &s->own, m->kind);
}

static void dds_link_publish(struct link *head, const wire_message *m)
{
    link_dds *l = link_dds_of(head);
    if (m->kind == WIRE_EVENT_BATCH) {
        publish_batch(l, m);
        return;
    }
    writer *w = writer_for(l, m);
    if (!w) return;
    wire_dds_encode(m, l->sample);
    write_to(l, w, m->kind);
    if (m->kind == WIRE_STATUS) write_status_in_rooms(l);
    write_to_presumed(l, m);
}

void link_dds_flush_writer(writer *w)
{
    if (w->dirty) dds_write_flush(w->entity);
    w->dirty = false;
}

static void flush_in(link_dds *l)
{
    for (size_t i = 0; i < LINK_DDS_OUT; i++) link_dds_flush_writer(&l->writers[i]);
    for (size_t i = 0; i < (size_t)WIRE_DDS_REPLIES * LINK_DDS_REPLIES; i++)
        link_dds_flush_writer(&l->replies[0][0] + i);
}

static void dds_link_flush(struct link *head)
{
    link_dds *l = link_dds_of(head);
    unsigned number = 1;
    flush_in(l);
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;) flush_in(room);
    link_dds_streams_flush(l);
}

/* ---- the other daemon of a pair ---- */

static int dds_link_peer_join(struct link *head, int64_t lease_ns)
{
    link_dds *l = link_dds_of(head);
    return dds_peers_join(&l->peers, l->participant, lease_ns) ? 0 : -1;
}

static void dds_link_peer_say(struct link *head, const peer_announcement *announcement)
{
    dds_peers_say(&link_dds_of(head)->peers, announcement);
}

static bool dds_link_peer_send(struct link *head, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size)
{
    return dds_peers_send(&link_dds_of(head)->peers, sender, kind, bytes, size);
}

static void dds_link_peer_receive(struct link *head, const peer_sink *sink)
{
    link_dds *l = link_dds_of(head);
    if (atomic_exchange(&l->peers_arrived, false)) dds_peers_receive(&l->peers, sink);
}

static const peer_ops dds_peer_ops = {
    .join = dds_link_peer_join,
    .say = dds_link_peer_say,
    .send = dds_link_peer_send,
    .receive = dds_link_peer_receive,
};

/* ---- the rest ---- */

static void dds_link_describe(struct link *head, char *text, size_t size)
{
    const link_options *o = &head->options;
    const char *user = getenv("CYCLONEDDS_URI");
    link_dds *l = link_dds_of(head);
    char expiry[64] = "";
    if (l->certificate_days) snprintf(expiry, sizeof expiry, ", for %lld days more", (long long)link_dds_days_left(l));
    snprintf(text, size, "DDS domain %s on %s: %s%s%s%s", o->address[0] ? o->address : "0",
        o->interface[0] ? o->interface : "lo",
        o->security[0]    ? "whoever has a certificate of this site"
        : o->interface[0] ? "anyone on that network: no security is set up"
                          : "programs on this machine, of any user",
        expiry, user && user[0] ? ", and as CYCLONEDDS_URI says: " : "", user && user[0] ? user : "");
}

/* Who has not heard all asks for it when there is a heartbeat, and those of Cyclone are rare (wire_dds_qos.c). */
void link_dds_await(dds_entity_t writer, int64_t until_ns)
{
    enum { AGAIN_MS = 50 };
    for (int64_t left; (left = until_ns - clock_monotonic_ns()) > 0;) {
        if (dds_wait_for_acks(writer, left < DDS_MSECS(AGAIN_MS) ? left : DDS_MSECS(AGAIN_MS)) != DDS_RETCODE_TIMEOUT)
            return;
        (void)dds_assert_liveliness(writer); /* Cyclone's only way to send a heartbeat now */
    }
}

static void wait_for(const writer *w, int64_t until)
{
    if (w->entity > 0) link_dds_await(w->entity, until);
}

static void wait_in(const link_dds *l, int64_t until)
{
    for (size_t i = 0; i < LINK_DDS_OUT; i++) wait_for(&l->writers[i], until);
    for (size_t i = 0; i < (size_t)WIRE_DDS_REPLIES * LINK_DDS_REPLIES; i++) wait_for(&l->replies[0][0] + i, until);
}

/* The last words of the daemon (ends of streams, status) may still be under way. */
static void wait_for_acknowledgements(link_dds *l)
{
    int64_t until = clock_monotonic_ns() + DDS_MSECS(LAST_WORDS_MS);
    unsigned number = 1;
    wait_in(l, until);
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;) wait_in(room, until);
    for (size_t i = 0; i < l->streams.count; i++) wait_for(l->streams.at[i]->out, until);
}

static void dds_link_close(struct link *head)
{
    link_dds *l = link_dds_of(head);
    joiners_end(&l->joiners);
    wait_for_acknowledgements(l);
    link_dds_streams_close(l);
    reminder_end(&l->reminder);
    link_dds_drop_waiting(l);
    link_dds_rooms_close(l);
    link_dds_leave(l);
    free_own(l);
}

const link_ops link_dds_ops = {
    .scheme = "dds",
    .size = sizeof(link_dds),
    .has_liveliness = true,
    .acknowledges = false,
    .announces = true,
    .check = link_dds_check,
    .open = dds_link_open,
    .receive = link_dds_receive,
    .receive_poses = link_dds_receive_poses,
    .publish = dds_link_publish,
    .flush = dds_link_flush,
    .stream_open = link_dds_stream_open,
    .stream_close = link_dds_stream_close,
    .describe = dds_link_describe,
    .peers = &dds_peer_ops,
    .close = dds_link_close,
};
