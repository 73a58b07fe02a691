/* link_dds: one participant with a reader for each kind that clients send and a writer for each kind that the daemon
 * sends; each stream has a writer in a partition of its own.
 *
 * Cyclone's threads run the listeners: these set a flag, and wake the tick thread if no flag was set before. All else
 * is the tick thread's, but for poses: when nothing else waits, their listener offers the round to the service, which
 * takes them, ticks and writes there and then (link_options.poses). That is the thread that processes acknowledgements,
 * and Cyclone holds the lock of the poses' writer's proxy meanwhile. So nothing may be done there that waits for an
 * acknowledgement or for another thread of Cyclone's: all writers keep the last (wire_dds_qos.c), whose cache has no
 * high-water mark, so that a write never waits (q_entity.c, writer_new; tests/link/test_link_dds.c holds it to that),
 * and entities are created and deleted by the tick thread alone. Messages are decoded where they lie: in the loan,
 * poses in the bytes that came. */
#include "link_dds.h"

#include "base/array.h"
#include "base/clock.h"
#include "base/log.h"
#include "interface.h"
#include "link_dds_peers.h"
#include "link_dds_speakers.h"
#include "wake.h"
#include "wire/dds/wire_dds.h"
#include "wire/dds/wire_dds_leave.h"
#include "wire/dds/wire_dds_qos.h"
#include "wire/dds/wire_dds_security.h"

#include <assert.h>
#include <dds/dds.h>
#define asm __asm__ /* the next header is in GNU C */
#include <dds/ddsi/ddsi_serdata.h>
#undef asm
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

enum {
    TAKE_MAX = 64,      /* samples a take. One constant: a loan writes as many pointers as the largest ever asked for */
    RECEIVE_MAX = 8192, /* samples a reader and receive: a flood on one topic must not keep the tick from running */
    DOMAIN_MAX = 230,   /* above, the port numbers run out */
    CONFIG_BYTES = 8192,
    LAST_WORDS_MS = 500 /* closing: for acknowledgements still to come */
};

static const wire_kind kinds_in[] = {
    WIRE_CLIENT, WIRE_GEOMETRY, WIRE_BODY, WIRE_INTEREST, WIRE_POSE_BATCH, WIRE_VERTEX_BATCH, WIRE_QUERY};
static const wire_kind kinds_out[] = {WIRE_ANSWER, WIRE_STATUS, WIRE_REJECT, WIRE_ACK};
enum { IN_COUNT = sizeof kinds_in / sizeof kinds_in[0], OUT_COUNT = sizeof kinds_out / sizeof kinds_out[0] };

typedef struct link_dds link_dds;

typedef struct reader {
    link_dds *owner;
    wire_kind kind;
    dds_entity_t entity;
    atomic_bool arrived;
} reader;

typedef struct writer {
    dds_entity_t entity;
    bool dirty; /* written to since the last flush */
} writer;

typedef struct stream {
    link_dds *owner;
    char *name;
    writer out;
    atomic_bool matched; /* a reader has come, and the sink has not been told */
} stream;

struct link_dds {
    struct link head;
    dds_entity_t domain; /* 0 = the process had it already */
    dds_entity_t participant;
    dds_entity_t topics[WIRE_KIND_COUNT];
    reader readers[IN_COUNT];
    writer writers[OUT_COUNT];
    ARRAY(stream *) streams; /* sorted by name */
    speakers speakers;
    atomic_bool has_discovered, has_news; /* for speakers */
    dds_peers peers;
    atomic_bool peers_arrived;
    void *sample; /* room for a sample of any kind, to be written */
    atomic_bool woken;
    bool on_arrival; /* a thread of Cyclone's stands in for the tick thread */
    metric *messages_in, *refused, *foreign, *history_full, *messages_out, *write_failed, *no_stream;
};

static link_dds *self_of(struct link *l)
{
    return (link_dds *)l;
}

/* ---- Cyclone's threads ---- */

static void notice(link_dds *l, atomic_bool *flag)
{
    atomic_store(flag, true);
    if (!atomic_exchange(&l->woken, true)) wake(l->head.options.wake_fd);
}

static void on_data(dds_entity_t entity, void *context)
{
    (void)entity;
    reader *r = context;
    notice(r->owner, &r->arrived);
}

static void on_discovery(dds_entity_t entity, void *context)
{
    (void)entity;
    link_dds *l = context;
    notice(l, &l->has_discovered);
}

static bool others_wait(link_dds *l)
{
    bool wait = atomic_load(&l->has_discovered) || atomic_load(&l->has_news) || atomic_load(&l->peers_arrived);
    for (size_t i = 0; i < IN_COUNT; i++)
        wait |= l->readers[i].kind != WIRE_POSE_BATCH && atomic_load(&l->readers[i].arrived);
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
    if (!alone || !o->poses(o->poses_context, &r->owner->head)) notice(r->owner, &r->arrived);
}

static void on_matched(dds_entity_t entity, const dds_publication_matched_status_t status, void *context)
{
    (void)entity;
    stream *s = context;
    if (status.current_count_change > 0) notice(s->owner, &s->matched);
}

/* A client's liveliness is that of its writer of Client. */
static void on_liveliness(dds_entity_t entity, const dds_liveliness_changed_status_t status, void *context)
{
    (void)entity;
    link_dds *l = ((reader *)context)->owner;
    speakers_heartbeat(&l->speakers, &status);
    notice(l, &l->has_news);
}

static void on_peers(void *context)
{
    link_dds *l = context;
    notice(l, &l->peers_arrived);
}

/* While a domain is joined, the first complaint is kept: it says why it could not be. */
typedef struct complaint {
    char text[256];
} complaint;

/* Forged packets make Cyclone write 100 MB of log a minute; ours has a limit for each site. */
static void on_log(void *context, const dds_log_data_t *line)
{
    complaint *first = context; /* NULL: joined */
    int length = (int)strcspn(line->message, "\n");
    if (first && line->priority & (DDS_LC_FATAL | DDS_LC_ERROR)) {
        if (!*first->text) snprintf(first->text, sizeof first->text, "%.*s", length, line->message);
    } else if (line->priority & (DDS_LC_FATAL | DDS_LC_ERROR))
        log_error("DDS: %.*s", length, line->message);
    else if (line->priority & DDS_LC_WARNING)
        log_warning("DDS: %.*s", length, line->message);
    else
        log_debug("DDS: %.*s", length, line->message);
}

/* ---- opening ---- */

static dds_entity_t topic_of(link_dds *l, wire_kind kind)
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
    if (kind == WIRE_CLIENT) dds_lset_liveliness_changed_arg(listener, on_liveliness, r, true);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_READER, NULL, 0);
    r->entity = dds_create_reader(l->participant, topic_of(l, kind), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    return r->entity > 0;
}

static bool open_speakers(link_dds *l)
{
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_data_available_arg(listener, on_discovery, l, true);
    bool opened = speakers_open(&l->speakers, l->participant, listener);
    dds_delete_listener(listener);
    return opened;
}

static bool open_writer(link_dds *l, writer *w, wire_kind kind)
{
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, 0);
    w->entity = dds_create_writer(l->participant, topic_of(l, kind), qos, NULL);
    dds_delete_qos(qos);
    return w->entity > 0;
}

static bool open_topics(link_dds *l)
{
    bool ok = open_speakers(l) && topic_of(l, WIRE_EVENT_BATCH) > 0;
    for (size_t i = 0; i < IN_COUNT && ok; i++) ok = open_reader(l, &l->readers[i], kinds_in[i]);
    for (size_t i = 0; i < OUT_COUNT && ok; i++) ok = open_writer(l, &l->writers[i], kinds_out[i]);
    return ok;
}

/* Domain and participant: 0, or DDS's error. */
static dds_return_t join(link_dds *l, dds_domainid_t domain, const char *config, complaint *first)
{
    dds_set_log_sink(on_log, first);
    dds_set_trace_sink(on_log, first);
    dds_entity_t made = dds_create_domain(domain, config);
    if (made < 0 && made != DDS_RETCODE_PRECONDITION_NOT_MET) return made;
    if (made > 0) l->domain = made;
    dds_qos_t *secured = wire_dds_security_qos(l->head.options.security);
    l->participant = dds_create_participant(domain, secured, NULL);
    dds_delete_qos(secured);
    if (l->participant < 0) return l->participant;
    dds_set_log_sink(on_log, NULL);
    dds_set_trace_sink(on_log, NULL);
    return DDS_RETCODE_OK;
}

static void leave(link_dds *l)
{
    if (l->participant > 0) dds_delete(l->participant);
    if (!wire_dds_leave(l->domain)) log_warning("%s", WIRE_DDS_LEFT_BEHIND);
    dds_set_log_sink(NULL, NULL);
    dds_set_trace_sink(NULL, NULL);
}

static bool parse_domain(const char *text, dds_domainid_t *domain)
{
    char *end;
    unsigned long number = strtoul(text, &end, 10);
    *domain = (dds_domainid_t)number;
    return strspn(text, "0123456789") == strlen(text) && *end == '\0' && number <= DOMAIN_MAX;
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
    l->no_stream = metrics_add(m, "dds_no_stream", "event batches for a stream that is not open");
}

static int dds_link_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    dds_domainid_t domain;
    char config[CONFIG_BYTES];
    if (!parse_domain(options->address, &domain))
        snprintf(
            why, why_size, "dds://%.60s: expected a domain from 0 to %d, as in dds://0", options->address, DOMAIN_MAX);
    else if (!wire_dds_config(config, sizeof config, options->interface, true))
        snprintf(why, why_size,
            "interface = \"%.60s\" is no name or address, or CYCLONEDDS_URI is too long: let it name a file: "
            "file:///path",
            options->interface);
    else if (!interface_is_there(options->interface, why, why_size))
        return EX_NOHOST;
    else if (options->security && *options->security && !wire_dds_security_check(options->security, why, why_size))
        return EX_NOINPUT;
    else
        return snprintf(key, LINK_KEY_MAX, "dds %u", domain) > 0 ? EX_OK : EX_SOFTWARE;
    return EX_CONFIG;
}

/* Cyclone's own words, and what to do about those that are met in practice. */
static void say_why(
    const link_options *options, const complaint *first, dds_return_t joined, char *why, size_t why_size)
{
    if (*options->security &&
        wire_dds_security_explain(options->security, *first->text ? first->text : NULL, why, why_size))
        return;
    const char *said = *first->text ? first->text : joined < 0 ? dds_strretcode(joined) : "no readers and writers";
    const char *mend = "check the interface and CYCLONEDDS_URI";
    if (strstr(said, "participant index"))
        mend = "its UDP ports are all taken: end processes that use the domain (ss -ulp lists them), or use another "
               "one: links = dds://1";
    else if (strstr(said, "available interface") || strstr(said, "multicast-capable"))
        mend = "is it up? do: ip link set lo up (or the interface that was asked for)";
    snprintf(why, why_size, "dds://%s: DDS does not start: %s: %s", options->address, said, mend);
}

static void free_own(link_dds *l)
{
    speakers_free(&l->speakers);
    dds_peers_free(&l->peers);
    free(l->sample);
}

static int dds_link_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_dds *l = self_of(head);
    dds_domainid_t domain = 0;
    char config[CONFIG_BYTES], key[LINK_KEY_MAX];
    complaint first = {""};
    if (dds_link_check(options, key, why, why_size) != EX_OK) return -1;
    parse_domain(options->address, &domain);
    wire_dds_config(config, sizeof config, options->interface, true);
    register_counters(l, options->counters);
    l->sample = base_zalloc(1, largest_sample());
    speakers_init(&l->speakers, options->max_clients ? options->max_clients : SIZE_MAX);
    dds_peers_init(&l->peers, on_peers, l);
    dds_return_t joined = join(l, domain, config, &first);
    if (joined == DDS_RETCODE_OK && open_topics(l)) return 0;
    leave(l);
    say_why(options, &first, joined, why, why_size);
    free_own(l);
    return -1;
}

/* ---- receiving ---- */

static void refuse(link_dds *l, const link_sink *sink, wire_kind kind, const wire_message *m, const wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    metric_count(l->refused, 1);
    sink->refused(sink->context, &l->head, kind, client, sequence, why);
}

/* All kinds begin alike; only those that are kept can be taken back. */
static void mark_removed(wire_message *m, int64_t sequence)
{
    m->version = WIRE_VERSION;
    m->client.sequence = sequence;
    switch (m->kind) {
    case WIRE_CLIENT:
        m->client.removed = 1;
        break;
    case WIRE_GEOMETRY:
        m->geometry.removed = 1;
        break;
    case WIRE_BODY:
        m->body.removed = 1;
        break;
    case WIRE_INTEREST:
        m->interest.removed = 1;
        break;
    default:
        break;
    }
}

static bool is_admitted(link_dds *l, const wire_message *m, const dds_sample_info_t *info, wire_refusal *why)
{
    bool admitted = speakers_admit(&l->speakers, m, info->publication_handle, why);
    if (!admitted && why->reason == WIRE_NOT_YOURS) metric_count(l->foreign, 1);
    return admitted;
}

static void hand_over(link_dds *l, const link_sink *sink, const wire_message *m)
{
    sink->message(sink->context, &l->head, m);
    if (m->kind == WIRE_CLIENT && m->client.removed) speakers_release(&l->speakers, m->client.client);
}

/* News of an instance without a sample (dds_dispose): its keys are all that is known. A disposed one was taken back;
 * the time at its source, in microseconds, stands in for the sequence number, as clients under a fixed id count. One
 * without writers says nothing: what becomes of it is its client's choice, when that is lost. */
static bool receive_state(link_dds *l, const link_sink *sink, wire_message *m, const dds_sample_info_t *info)
{
    if (info->instance_state != DDS_IST_NOT_ALIVE_DISPOSED || !wire_dds_profile_of(m->kind)->late_joiners) return false;
    wire_refusal why;
    mark_removed(m, info->source_timestamp / 1000);
    if (wire_check(m, &why) != WIRE_OK || !is_admitted(l, m, info, &why)) {
        refuse(l, sink, m->kind, m, &why);
        return false;
    }
    hand_over(l, sink, m);
    return true;
}

static bool hand_over_or_refuse(link_dds *l, const link_sink *sink, const wire_message *m,
    const dds_sample_info_t *info, wire_reason reason, wire_refusal *why)
{
    bool taken = reason == WIRE_OK && is_admitted(l, m, info, why);
    if (taken)
        hand_over(l, sink, m);
    else
        refuse(l, sink, m->kind, m, why);
    return taken;
}

static bool receive_sample(
    link_dds *l, const link_sink *sink, wire_kind kind, const void *sample, const dds_sample_info_t *info)
{
    wire_message m = {.kind = kind};
    wire_refusal why = {0};
    wire_reason reason = wire_dds_decode(kind, sample, &m, &why);
    if (!info->valid_data) return receive_state(l, sink, &m, info);
    return hand_over_or_refuse(l, sink, &m, info, reason, &why);
}

/* Cyclone's own decoding, which copies. */
static bool receive_copy(
    link_dds *l, const link_sink *sink, wire_kind kind, const struct ddsi_serdata *data, const dds_sample_info_t *info)
{
    void *sample = dds_alloc(wire_dds_sample_size(kind));
    memset(sample, 0, wire_dds_sample_size(kind));
    bool taken = ddsi_serdata_to_sample(data, sample, NULL, NULL) && receive_sample(l, sink, kind, sample, info);
    dds_sample_free(sample, wire_dds_descriptor(kind), DDS_FREE_ALL);
    return taken;
}

static bool receive_bytes(
    link_dds *l, const link_sink *sink, wire_kind kind, const struct ddsi_serdata *data, const dds_sample_info_t *info)
{
    ddsrt_iovec_t bytes;
    wire_message m;
    wire_reason reason;
    wire_refusal why = {0};
    struct ddsi_serdata *held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &bytes);
    bool plain = wire_dds_decode_bytes(kind, bytes.iov_base, bytes.iov_len, &m, &reason, &why);
    bool taken = plain ? hand_over_or_refuse(l, sink, &m, info, reason, &why) : receive_copy(l, sink, kind, data, info);
    ddsi_serdata_to_ser_unref(held, &bytes);
    return taken;
}

/* Poses are read where Cyclone has put them: a copy would cost a third of what receiving them does. They have no key,
 * so there is no news of them but samples. */
static int take_poses(link_dds *l, const link_sink *sink, const reader *r, size_t *messages)
{
    struct ddsi_serdata *data[TAKE_MAX];
    dds_sample_info_t infos[TAKE_MAX];
    int n = dds_takecdr(r->entity, data, TAKE_MAX, infos, DDS_ANY_STATE);
    for (int i = 0; i < n; i++) {
        if (infos[i].valid_data) *messages += receive_bytes(l, sink, r->kind, data[i], &infos[i]);
        ddsi_serdata_unref(data[i]);
    }
    return n > 0 ? n : 0;
}

/* Samples taken from one reader; *messages of them were messages. */
static int take(link_dds *l, const link_sink *sink, const reader *r, size_t *messages)
{
    if (r->kind == WIRE_POSE_BATCH) return take_poses(l, sink, r, messages);
    void *samples[TAKE_MAX] = {NULL};
    dds_sample_info_t infos[TAKE_MAX];
    int n = dds_take(r->entity, samples, infos, TAKE_MAX, TAKE_MAX);
    if (n <= 0) return 0;
    for (int i = 0; i < n; i++) *messages += receive_sample(l, sink, r->kind, samples[i], &infos[i]);
    dds_return_loan(r->entity, samples, n);
    return n;
}

static size_t take_all(link_dds *l, const link_sink *sink, reader *r)
{
    size_t messages = 0;
    int total = 0, n;
    do {
        n = take(l, sink, r, &messages);
        total += n;
    } while (n == TAKE_MAX && total < RECEIVE_MAX);
    if (n == TAKE_MAX) notice(l, &r->arrived); /* there is more: for the next tick */
    const wire_dds_profile *p = wire_dds_profile_of(r->kind);
    if (!p->late_joiners && total >= p->reader_depth) metric_count(l->history_full, 1);
    return messages;
}

/* One take: a flood is the tick thread's. */
static size_t dds_link_receive_poses(struct link *head, const link_sink *sink)
{
    link_dds *l = self_of(head);
    reader *r = l->readers;
    size_t messages = 0;
    while (r->kind != WIRE_POSE_BATCH) r++;
    l->on_arrival = true;
    if (atomic_exchange(&r->arrived, false) && take(l, sink, r, &messages) == TAKE_MAX) notice(l, &r->arrived);
    metric_count(l->messages_in, messages);
    return messages;
}

static void report_readers(link_dds *l, const link_sink *sink)
{
    for (size_t i = 0; i < l->streams.count; i++) {
        stream *s = l->streams.at[i];
        if (atomic_exchange(&s->matched, false)) sink->stream_reader(sink->context, &l->head, s->name);
    }
}

static size_t dds_link_receive(struct link *head, const link_sink *sink)
{
    link_dds *l = self_of(head);
    size_t messages = 0;
    int64_t client;
    atomic_store(&l->woken, false); /* first: what arrives from now on wakes again */
    l->on_arrival = false;
    if (atomic_exchange(&l->has_discovered, false)) speakers_discover(&l->speakers);
    atomic_store(&l->has_news, false);
    for (size_t i = 0; i < IN_COUNT; i++)
        if (atomic_exchange(&l->readers[i].arrived, false)) messages += take_all(l, sink, &l->readers[i]);
    report_readers(l, sink);
    /* Last, so that nothing of a lost client comes after the news of its loss. */
    while (speakers_lost(&l->speakers, &client)) sink->client_lost(sink->context, head, client);
    metric_count(l->messages_in, messages);
    return messages;
}

/* ---- publishing ---- */

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

static writer *writer_for(link_dds *l, const wire_message *m)
{
    if (m->kind == WIRE_EVENT_BATCH) {
        bool found;
        size_t i = stream_place(l, m->event_batch.stream, &found);
        if (!found) metric_count(l->no_stream, 1);
        return found ? &l->streams.at[i]->out : NULL;
    }
    for (size_t i = 0; i < OUT_COUNT; i++)
        if (kinds_out[i] == m->kind) return &l->writers[i];
    return NULL;
}

static void dds_link_publish(struct link *head, const wire_message *m)
{
    link_dds *l = self_of(head);
    writer *w = writer_for(l, m);
    if (!w) return;
    wire_dds_encode(m, l->sample);
    dds_return_t written = dds_write(w->entity, l->sample);
    w->dirty = true;
    metric_count(written == DDS_RETCODE_OK ? l->messages_out : l->write_failed, 1);
    if (written != DDS_RETCODE_OK) log_warning("DDS: %s: %s", wire_kind_name(m->kind), dds_strretcode(written));
}

static void flush_writer(writer *w)
{
    if (w->dirty) dds_write_flush(w->entity);
    w->dirty = false;
}

static void dds_link_flush(struct link *head)
{
    link_dds *l = self_of(head);
    for (size_t i = 0; i < OUT_COUNT; i++) flush_writer(&l->writers[i]);
    for (size_t i = 0; i < l->streams.count; i++) flush_writer(&l->streams.at[i]->out);
}

/* ---- streams ---- */

static stream *stream_create(link_dds *l, const char *name)
{
    stream *s = base_zalloc(1, sizeof *s);
    s->owner = l;
    s->name = base_strdup(name);
    dds_listener_t *listener = dds_create_listener(NULL);
    dds_lset_publication_matched_arg(listener, on_matched, s, true);
    dds_qos_t *qos = wire_dds_qos(WIRE_EVENT_BATCH, WIRE_DDS_WRITER, name, 0);
    s->out.entity = dds_create_writer(l->participant, topic_of(l, WIRE_EVENT_BATCH), qos, listener);
    dds_delete_qos(qos);
    dds_delete_listener(listener);
    if (s->out.entity <= 0) log_error("DDS: stream %s: %s", name, dds_strretcode(s->out.entity));
    return s;
}

/* Cyclone keeps a writer until its readers have acknowledged what was flushed, for a second at most. */
static void stream_destroy(stream *s)
{
    flush_writer(&s->out);
    if (s->out.entity > 0) dds_delete(s->out.entity);
    free(s->name);
    free(s);
}

/* The sink may have been told when it had no such stream. */
static void tell_readers_again(link_dds *l, stream *s)
{
    dds_publication_matched_status_t status;
    if (dds_get_publication_matched_status(s->out.entity, &status) == DDS_RETCODE_OK && status.current_count)
        notice(l, &s->matched);
}

static void dds_link_stream_open(struct link *head, const char *name)
{
    link_dds *l = self_of(head);
    bool found;
    assert(!l->on_arrival);
    size_t i = stream_place(l, name, &found);
    if (found) {
        tell_readers_again(l, l->streams.at[i]);
        return;
    }
    array_reserve(&l->streams, l->streams.count + 1);
    memmove(l->streams.at + i + 1, l->streams.at + i, (l->streams.count - i) * sizeof l->streams.at[0]);
    l->streams.at[i] = stream_create(l, name);
    l->streams.count++;
}

static void dds_link_stream_close(struct link *head, const char *name)
{
    link_dds *l = self_of(head);
    bool found;
    assert(!l->on_arrival);
    size_t i = stream_place(l, name, &found);
    if (!found) return;
    stream_destroy(l->streams.at[i]);
    l->streams.count--;
    memmove(l->streams.at + i, l->streams.at + i + 1, (l->streams.count - i) * sizeof l->streams.at[0]);
}

/* ---- the other daemon of a pair ---- */

static int dds_link_peer_join(struct link *head, int64_t lease_ns)
{
    link_dds *l = self_of(head);
    return dds_peers_join(&l->peers, l->participant, lease_ns) ? 0 : -1;
}

static void dds_link_peer_say(struct link *head, const peer_card *card)
{
    dds_peers_say(&self_of(head)->peers, card);
}

static bool dds_link_peer_send(struct link *head, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size)
{
    return dds_peers_send(&self_of(head)->peers, sender, kind, bytes, size);
}

static void dds_link_peer_receive(struct link *head, const peer_sink *sink)
{
    link_dds *l = self_of(head);
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
    snprintf(text, size, "DDS domain %s on %s: %s%s%s", o->address[0] ? o->address : "0",
        o->interface[0] ? o->interface : "lo",
        o->security[0]    ? "whoever has a certificate of this site"
        : o->interface[0] ? "anyone on that network: no security is set up"
                          : "programs on this machine, of any user",
        user && user[0] ? ", and as CYCLONEDDS_URI says: " : "", user && user[0] ? user : "");
}

/* The last words of the daemon (ends of streams, status) may still be under way. */
static void wait_for_acknowledgements(link_dds *l)
{
    int64_t until = clock_monotonic_ns() + DDS_MSECS(LAST_WORDS_MS);
    for (size_t i = 0; i < OUT_COUNT + l->streams.count; i++) {
        const writer *w = i < OUT_COUNT ? &l->writers[i] : &l->streams.at[i - OUT_COUNT]->out;
        int64_t left = until - clock_monotonic_ns();
        if (w->entity > 0) dds_wait_for_acks(w->entity, left > 0 ? left : 0);
    }
}

static void dds_link_close(struct link *head)
{
    link_dds *l = self_of(head);
    wait_for_acknowledgements(l);
    for (size_t i = 0; i < l->streams.count; i++) stream_destroy(l->streams.at[i]);
    leave(l);
    array_free(&l->streams);
    free_own(l);
}

const link_ops link_dds_ops = {
    .scheme = "dds",
    .size = sizeof(link_dds),
    .has_liveliness = true,
    .acknowledges = false,
    .announces = true,
    .check = dds_link_check,
    .open = dds_link_open,
    .receive = dds_link_receive,
    .receive_poses = dds_link_receive_poses,
    .publish = dds_link_publish,
    .flush = dds_link_flush,
    .stream_open = dds_link_stream_open,
    .stream_close = dds_link_stream_close,
    .describe = dds_link_describe,
    .peers = &dds_peer_ops,
    .close = dds_link_close,
};
