/* transport_dds: Cyclone DDS. Writers keep the newest announcement of each object for whoever comes later, and the
 * client's liveliness is its lease, so there are no heartbeats, and repetition is for lost answers alone. Listeners run
 * on threads of Cyclone's; they wake the two threads of the session through a descriptor each, or receive what has come
 * for streams in the place of one (transport_options.arrived): then nothing is created or deleted, and whatever is
 * written keeps the last and so never waits for an acknowledgement, which the very thread would have to process. */
#include "allocate.h"
#include "transport.h"
#include "turn.h"
#include "wire_dds/wire_dds.h"
#include "wire_dds/wire_dds_leave.h"
#include "wire_dds/wire_dds_qos.h"
#include "wire_dds/wire_dds_security.h"

#include <dds/dds.h>
#include <errno.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

enum {
    DDS_DOMAIN_LAST = 230,
    DDS_TAKE = 16 /* always the same: Cyclone writes as many loans as the most ever asked */
};
enum {
    DDS_PEERS = 32, /* writers or readers of daemons that are matched at one time */
    DDS_RETIRED = 8 /* writers that were replaced, and are not deleted yet */
};

typedef struct dds_inbox {
    dds_entity_t reader;
    wire_kind kind;
    transport_role role;
    dds_entity_t subscriber; /* of a stream: its partition; otherwise 0 */
    char *stream;            /* owned; otherwise NULL */
} dds_inbox;

typedef struct transport_dds {
    transport head;
    dds_domainid_t domain;
    dds_entity_t participant, group; /* group: the subscriber of what answers us (WIRE_DDS_REPLIES) */
    char user_data[WIRE_DDS_USER_DATA_MAX];
    uint8_t sought; /* so often, modulo 256 */
    dds_entity_t topics[WIRE_KIND_COUNT];
    dds_entity_t writers[WIRE_KIND_COUNT];
    dds_entity_t retired[DDS_RETIRED];
    size_t retired_count; /* the library's thread's */
    dds_inbox control[3]; /* Ack, Reject, Status */
    dds_inbox *streams;   /* Answer, shared events, then one a stream */
    size_t stream_count, stream_capacity;
    bool reads_shared; /* one of the streams is that of shared events */
    bool on_network;   /* where packets are lost, and not on loopback alone */
    int64_t client;
    unsigned room;       /* see wire_dds_qos.h; 0: in none */
    char *closed_stream; /* in a room, the last one: opened again, the shared reader is made anew; owned */
    int fds[TRANSPORT_ROLES];
    atomic_int turn;                /* see wire_dds_turn.h; below 0: none */
    bool (*arrived)(void *context); /* see transport_options */
    void *arrived_context;
    atomic_bool rematched; /* a listener saw a match: `matched` must be found anew */
    atomic_bool matched;
    void *sample; /* room for any kind; written under the client's mutex */
} transport_dds;

/* In the order in which their writers are made known: whoever has heard an announcement, and acknowledges it, has found
 * the writers of what is volatile before. */
static const wire_kind outgoing[] = {WIRE_POSE_BATCH, WIRE_VERTEX_BATCH, WIRE_QUERY, WIRE_RECEIPT, WIRE_CLIENT,
    WIRE_GEOMETRY, WIRE_BODY, WIRE_SUBSCRIPTION};
enum { OUTGOING = sizeof outgoing / sizeof outgoing[0] };

/* ---- the domain, shared by the clients of a process ---- */

static pthread_mutex_t domains_lock = PTHREAD_MUTEX_INITIALIZER;
static struct dds_shared_domain {
    dds_entity_t entity;
    unsigned users;
    unsigned room;    /* the process is in; 0: in none */
    char *security;   /* of its users: Cyclone holds one identity's rights a process and domain; NULL: no users */
    bool left_behind; /* Cyclone could not end it: whoever opened it again would wait for ever */
} domains[DDS_DOMAIN_LAST + 1];

/* To standard error: connecting works all the same, and nobody else would say it. */
static void warn_of_key(const char *security)
{
    static atomic_bool warned;
    char text[1024];
    if (wire_dds_security_key_is_private(security, text, sizeof text) || atomic_exchange(&warned, true)) return;
    (void)fprintf(stderr, "collided: warning: %s\n", text);
}

/* When the program has made this domain itself, its configuration stands, and it is not ours to delete. */
static dds_entity_t create_domain(dds_domainid_t id, unsigned room, wire_dds_role role, const char *config)
{
    char of_room[4096];
    if (!room || !wire_dds_config_room(of_room, sizeof of_room, id, room, role)) return dds_create_domain(id, config);
    return dds_create_domain(wire_dds_room_domain(id, room), of_room);
}

/* `room` is the one to be joined, if this process has not joined yet; that which it is in, afterwards. */
static bool domain_use(
    dds_domainid_t id, const transport_options *options, wire_dds_role role, unsigned *room, char *why, size_t why_size)
{
    char config[4096];
    const char *interface = options->interface, *security = options->security;
    if (!wire_dds_config(config, sizeof config, interface, role)) {
        (void)snprintf(why, why_size,
            "dds: '%s' is not the name or address of an interface, or CYCLONEDDS_URI is too long", interface);
        return false;
    }
    if (*security && !wire_dds_security_check(security, why, why_size)) return false;
    if (*security) warn_of_key(security);
    dds_return_t result = DDS_RETCODE_OK;
    pthread_mutex_lock(&domains_lock);
    bool left_behind = domains[id].left_behind,
         other = domains[id].users && strcmp(domains[id].security, security) != 0;
    if (left_behind || other)
        result = DDS_RETCODE_ERROR;
    else if (domains[id].entity <= 0) {
        result = domains[id].entity = create_domain(id, *room, role, config);
        domains[id].room = result > 0 ? *room : 0;
    }
    *room = domains[id].room;
    bool used = result >= 0 || result == DDS_RETCODE_PRECONDITION_NOT_MET;
    if (used && !domains[id].users++) domains[id].security = duplicate(security);
    pthread_mutex_unlock(&domains_lock);
    if (used) return true;
    (void)snprintf(why, why_size, "dds: cannot open domain %u: %s", (unsigned)id,
        left_behind ? WIRE_DDS_LEFT_BEHIND
        : other     ? "this process is there already with another security folder"
                    : dds_strretcode(-result));
    return false;
}

static void domain_leave(dds_domainid_t id)
{
    pthread_mutex_lock(&domains_lock);
    bool last = --domains[id].users == 0 && domains[id].entity > 0;
    dds_domainid_t number = domains[id].room ? wire_dds_room_domain(id, domains[id].room) : id;
    if (last && dds_lookup_participant(number, NULL, 0) == 0) {
        domains[id].left_behind = !wire_dds_leave(domains[id].entity);
        domains[id].entity = 0;
        domains[id].room = 0;
    }
    if (!domains[id].users) {
        free(domains[id].security);
        domains[id].security = NULL;
    }
    pthread_mutex_unlock(&domains_lock);
}

/* ---- waking ---- */

static void wake(transport_dds *t, transport_role role)
{
    uint64_t one = 1;
    ssize_t written = write(t->fds[role], &one, sizeof one);
    (void)written; /* it fails only when the counter is full: the reader is awake */
}

static void on_control(dds_entity_t reader, void *context)
{
    (void)reader;
    wake(context, TRANSPORT_CONTROL);
}

static void on_stream(dds_entity_t reader, void *context)
{
    (void)reader;
    transport_dds *t = context;
    if (!t->arrived || !t->arrived(t->arrived_context)) wake(t, TRANSPORT_STREAMS);
}

static void on_match(transport_dds *t)
{
    atomic_store(&t->rematched, true);
    wake(t, TRANSPORT_CONTROL); /* which looks whether we are ready */
}

static void on_reader_matched(dds_entity_t e, const dds_subscription_matched_status_t status, void *context)
{
    (void)e;
    (void)status;
    on_match(context);
}

static void on_writer_matched(dds_entity_t e, const dds_publication_matched_status_t status, void *context)
{
    (void)e;
    (void)status;
    on_match(context);
}

/* ---- who is matched ---- */

typedef struct dds_peers {
    int count;
    dds_guid_t participants[DDS_PEERS];
} dds_peers;

static void add_peer(dds_peers *peers, dds_builtintopic_endpoint_t *endpoint)
{
    if (!endpoint) return;
    peers->participants[peers->count++] = endpoint->participant_key;
    dds_builtintopic_free_endpoint(endpoint);
}

static dds_peers peers_of_reader(dds_entity_t reader)
{
    dds_instance_handle_t handles[DDS_PEERS];
    dds_return_t n = dds_get_matched_publications(reader, handles, DDS_PEERS);
    dds_peers peers = {0};
    for (int i = 0; i < n && i < DDS_PEERS; i++) add_peer(&peers, dds_get_matched_publication_data(reader, handles[i]));
    return peers;
}

static dds_peers peers_of_writer(dds_entity_t writer)
{
    dds_instance_handle_t handles[DDS_PEERS];
    dds_return_t n = dds_get_matched_subscriptions(writer, handles, DDS_PEERS);
    dds_peers peers = {0};
    for (int i = 0; i < n && i < DDS_PEERS; i++)
        add_peer(&peers, dds_get_matched_subscription_data(writer, handles[i]));
    return peers;
}

static bool all_among(const dds_peers *some, const dds_peers peers)
{
    for (int i = 0; i < some->count; i++) {
        bool found = false;
        for (int k = 0; k < peers.count; k++)
            found = found || memcmp(&some->participants[i], &peers.participants[k], sizeof(dds_guid_t)) == 0;
        if (!found) return false;
    }
    return true;
}

/* Discovery is over, of which turns are about: two who discover a daemon at the same time make it tell all who are
 * there. What follows goes to us alone. */
static void leave_turn(transport_dds *t)
{
    int turn = atomic_exchange(&t->turn, -1);
    if (turn >= 0) (void)close(turn);
}

/* Whoever acknowledges must also hear poses and queries and be heard answering and refusing. Discovery matches one
 * endpoint at a time, so acks are left in their reader until this holds: what they release (poses) is volatile. Matches
 * of others than these are nobody's news: discovery tells of some twenty, and whoever is woken by each costs a crowd
 * more than the messages do. */
static bool decides_readiness(wire_kind kind)
{
    return kind == WIRE_ACK || kind == WIRE_POSE_BATCH || kind == WIRE_QUERY || kind == WIRE_REJECT ||
           kind == WIRE_ANSWER;
}

static bool dds_ready(transport *base)
{
    transport_dds *t = (transport_dds *)base;
    if (!atomic_exchange(&t->rematched, false)) return atomic_load(&t->matched);
    dds_peers acking = peers_of_reader(t->control[0].reader);
    bool matched =
        acking.count > 0 &&
        (t->writers[WIRE_POSE_BATCH] <= 0 || all_among(&acking, peers_of_writer(t->writers[WIRE_POSE_BATCH]))) &&
        all_among(&acking, peers_of_writer(t->writers[WIRE_QUERY])) &&
        all_among(&acking, peers_of_reader(t->control[1].reader)) &&
        all_among(&acking, peers_of_reader(t->streams[0].reader));
    atomic_store(&t->matched, matched);
    if (!matched) return false;
    wake(t, TRANSPORT_STREAMS);
    leave_turn(t);
    return true;
}

/* Where there is no multicast, a daemon does not know where clients are, which have any port: they tell it, when they
 * begin, and then every 8 s. To change the participant's user data tells it at once. */
static void dds_seek(transport *base)
{
    transport_dds *t = (transport_dds *)base;
    dds_qos_t *qos = dds_create_qos();
    if (t->room) turn_knock(t->domain, t->room);
    t->sought++;
    dds_qset_userdata(qos, &t->sought, sizeof t->sought);
    (void)dds_set_qos(t->participant, qos); /* if it is refused, those 8 s remain */
    dds_delete_qos(qos);
}

static void dds_joined(transport *base)
{
    leave_turn((transport_dds *)base);
}

/* ---- opening and closing ---- */

static bool open_topic(transport_dds *t, wire_kind kind)
{
    char name[WIRE_DDS_TOPIC_MAX];
    wire_dds_topic(kind, name);
    t->topics[kind] = dds_create_topic(t->participant, wire_dds_descriptor(kind), name, NULL, NULL);
    return t->topics[kind] > 0;
}

/* What our permissions do not let us write has no writer: see dds_permits. Poses wait for the flush; all else goes out
 * with its write. The switch is Cyclone's and applies to the writers that are created while it is on. */
static dds_entity_t create_writer(transport_dds *t, wire_kind kind, int64_t lease_ns)
{
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_WRITER, NULL, kind == WIRE_CLIENT ? lease_ns : 0);
    if (kind == WIRE_CLIENT) dds_qset_userdata(qos, t->user_data, strlen(t->user_data));
    dds_listener_t *listener = dds_create_listener(t);
    if (decides_readiness(kind)) dds_lset_publication_matched(listener, on_writer_matched);
    if (kind == WIRE_POSE_BATCH) dds_write_set_batch(true);
    dds_entity_t writer = dds_create_writer(t->participant, t->topics[kind], qos, listener);
    if (kind == WIRE_POSE_BATCH) dds_write_set_batch(false);
    dds_delete_listener(listener);
    dds_delete_qos(qos);
    return writer;
}

static bool open_writer(transport_dds *t, wire_kind kind, int64_t lease_ns)
{
    if (!open_topic(t, kind)) return t->topics[kind] == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
    t->writers[kind] = create_writer(t, kind, lease_ns);
    return t->writers[kind] > 0 || t->writers[kind] == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY;
}

/* That of Client stays: its liveliness is our lease. */
static void dds_renew(transport *base, bool all)
{
    static const wire_kind flows[] = {
        WIRE_POSE_BATCH, WIRE_VERTEX_BATCH, WIRE_QUERY, WIRE_RECEIPT, WIRE_GEOMETRY, WIRE_BODY, WIRE_SUBSCRIPTION};
    enum { ALL = sizeof flows / sizeof flows[0], FLOWS = 4 };
    transport_dds *t = (transport_dds *)base;
    for (size_t i = 0; i < (all ? ALL : FLOWS); i++) {
        if (t->retired_count == DDS_RETIRED || t->writers[flows[i]] <= 0) continue;
        dds_entity_t fresh = create_writer(t, flows[i], 0), old = t->writers[flows[i]];
        if (fresh <= 0) continue;
        t->writers[flows[i]] = fresh;
        t->retired[t->retired_count++] = old;
    }
    atomic_store(&t->matched, false);
    atomic_store(&t->rematched, true);
}

/* A writer waits for acknowledgements that will not come, for a second at most. */
static void dds_retire(transport *base)
{
    transport_dds *t = (transport_dds *)base;
    while (t->retired_count) (void)dds_delete(t->retired[--t->retired_count]);
}

/* A thread of Cyclone's. Acks are for one of a group each: nobody else is woken by them. */
static bool is_our_ack(const void *sample, void *context)
{
    return wire_dds_client_of_ack(sample) == ((const transport_dds *)context)->client;
}

/* Status comes once a second, so that one that is lost need not be asked for: a crowd's acknowledgements of it, and the
 * heartbeats that ask for them, cost more than all else that it does while nothing happens. On a network, where not
 * just a machine without time loses packets, three in a row would be a silence (SESSION_SILENCE_NS). */
static void need_not_be_repeated(dds_qos_t *qos)
{
    dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
}

/* `stream`: whose partition is read; NULL: those of the group, or, of Status, the one without a name. */
static bool open_inbox(transport_dds *t, dds_inbox *inbox, wire_kind kind, transport_role role, const char *stream)
{
    *inbox = (dds_inbox){.kind = kind, .role = role};
    if (t->topics[kind] <= 0 && !open_topic(t, kind)) return false;
    if (kind == WIRE_ACK) (void)dds_set_topic_filter_and_arg(t->topics[kind], is_our_ack, t);
    dds_qos_t *qos = wire_dds_qos(kind, WIRE_DDS_READER, stream, 0);
    if (kind == WIRE_STATUS && !t->on_network) need_not_be_repeated(qos);
    dds_listener_t *listener = dds_create_listener(t);
    dds_lset_data_available(listener, role == TRANSPORT_CONTROL ? on_control : on_stream);
    if (decides_readiness(kind)) dds_lset_subscription_matched(listener, on_reader_matched);
    if (stream) inbox->subscriber = dds_create_subscriber(t->participant, qos, NULL);
    dds_entity_t parent = stream ? inbox->subscriber : kind == WIRE_STATUS ? t->participant : t->group;
    inbox->reader = dds_create_reader(parent, t->topics[kind], qos, listener);
    dds_delete_listener(listener);
    dds_delete_qos(qos);
    if (inbox->reader <= 0) return false;
    inbox->stream = stream ? duplicate(stream) : NULL;
    return true;
}

static bool add_stream(transport_dds *t, wire_kind kind, const char *stream)
{
    dds_inbox inbox;
    if (!open_inbox(t, &inbox, kind, TRANSPORT_STREAMS, stream)) {
        if (inbox.subscriber > 0) (void)dds_delete(inbox.subscriber);
        return false;
    }
    t->streams = reserve(t->streams, &t->stream_capacity, t->stream_count + 1, sizeof *t->streams);
    t->streams[t->stream_count++] = inbox;
    return true;
}

/* What is reported in the partition without a name is for those who have no group. */
static bool open_group(transport_dds *t, int64_t client)
{
    char replies[WIRE_DDS_PARTITION_MAX], events[WIRE_DDS_PARTITION_MAX];
    unsigned reply = wire_dds_replies_of(client), event = wire_dds_events_of(client);
    if (t->room) reply %= WIRE_DDS_ROOM_GROUPS, event %= WIRE_DDS_ROOM_GROUPS;
    wire_dds_replies(reply, replies);
    wire_dds_events(event, events);
    wire_dds_user_data(reply, event, t->user_data);
    const char *partitions[] = {replies, events};
    dds_qos_t *qos = dds_create_qos();
    dds_qset_partition(qos, 2, partitions);
    t->group = dds_create_subscriber(t->participant, qos, NULL);
    dds_delete_qos(qos);
    return t->group > 0;
}

/* Discovery tells of readers in the order of their creation. That of acks comes last: by the time that an ack reaches
 * us, its sender also knows who reads its answers and refusals, which are volatile as well. */
static bool open_entities(transport_dds *t, const transport_options *options)
{
    dds_qos_t *secured = wire_dds_security_qos(options->security);
    dds_domainid_t number = t->room ? wire_dds_room_domain(t->domain, t->room) : t->domain;
    t->participant = dds_create_participant(number, secured, NULL);
    dds_delete_qos(secured);
    if (t->participant <= 0 || !open_group(t, options->client)) return false;
    bool opened = add_stream(t, WIRE_ANSWER, NULL) &&
                  open_inbox(t, &t->control[1], WIRE_REJECT, TRANSPORT_CONTROL, NULL) &&
                  open_inbox(t, &t->control[2], WIRE_STATUS, TRANSPORT_CONTROL, NULL) &&
                  open_inbox(t, &t->control[0], WIRE_ACK, TRANSPORT_CONTROL, NULL);
    for (size_t i = 0; opened && i < OUTGOING; i++) opened = open_writer(t, outgoing[i], options->lease_ns);
    return opened && open_topic(t, WIRE_EVENT_BATCH);
}

static void *room_for_any_sample(void)
{
    size_t most = 0;
    for (size_t i = 0; i < OUTGOING; i++)
        if (wire_dds_sample_size(outgoing[i]) > most) most = wire_dds_sample_size(outgoing[i]);
    return allocate(1, most);
}

static void dds_close_transport(transport *base)
{
    transport_dds *t = (transport_dds *)base;
    dds_joined(base);
    if (t->participant > 0) (void)dds_delete(t->participant);
    domain_leave(t->domain);
    for (size_t i = 0; i < t->stream_count; i++) free(t->streams[i].stream);
    for (int role = 0; role < TRANSPORT_ROLES; role++)
        if (t->fds[role] >= 0) close(t->fds[role]);
    free(t->closed_stream);
    free(t->streams);
    free(t->sample);
    free(t);
}

static transport *dds_open_transport(const transport_options *options, char *why, size_t why_size)
{
    char *end;
    errno = 0;
    unsigned long domain = strtoul(options->address, &end, 10);
    if (*end || end == options->address || errno || options->address[0] == '-' || domain > DDS_DOMAIN_LAST) {
        (void)snprintf(why, why_size, "dds: '%s' is not a domain from 0 to %d", options->address, DDS_DOMAIN_LAST);
        return NULL;
    }
    turn_greeting greeting = {.room = 0};
    int turn = TURN_NOBODY;
    bool by_turns = options->until_ns && !*options->interface;
    if (by_turns) turn = turn_ask((uint32_t)domain, options->until_ns, &greeting, why, why_size);
    if (turn == TURN_NONE) return NULL;
    wire_dds_role as = greeting.crowd ? WIRE_DDS_CLIENT_OF_CROWD : WIRE_DDS_CLIENT_LIBRARY;
    bool has_rooms = greeting.room <= WIRE_DDS_ROOMS && wire_dds_has_rooms() && !*options->security;
    unsigned room = has_rooms ? greeting.room : 0;
    if (!domain_use((dds_domainid_t)domain, options, as, &room, why, why_size)) {
        if (turn >= 0) (void)close(turn);
        return NULL;
    }
    turn = turn_wait(turn, options->until_ns, why, why_size);
    if (turn == TURN_NONE) {
        domain_leave((dds_domainid_t)domain);
        return NULL;
    }
    transport_dds *t = allocate(1, sizeof *t);
    atomic_init(&t->turn, turn);
    t->head.ops = &transport_dds_ops;
    t->domain = (dds_domainid_t)domain;
    t->room = room;
    t->on_network = *options->interface != '\0';
    t->client = options->client;
    t->arrived = options->arrived;
    t->arrived_context = options->arrived_context;
    t->sample = room_for_any_sample();
    atomic_init(&t->rematched, true);
    for (int role = 0; role < TRANSPORT_ROLES; role++) t->fds[role] = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
    bool opened = t->fds[TRANSPORT_CONTROL] >= 0 && t->fds[TRANSPORT_STREAMS] >= 0 && open_entities(t, options);
    if (opened) return &t->head;
    /* What Cyclone says of it goes to the program's own sink, which cannot be borrowed: nobody can tell which it is. */
    if (*options->security && t->participant > 0)
        (void)wire_dds_security_explain(options->security, NULL, why, why_size);
    else if (*options->security)
        wire_dds_security_documents(options->security, why, why_size);
    else
        (void)snprintf(why, why_size, "dds: cannot create the entities of domain %lu%s%s", domain,
            options->interface[0] ? " on interface " : "", options->interface);
    dds_close_transport(&t->head);
    return NULL;
}

/* ---- sending ---- */

static bool is_removed(const wire_message *m)
{
    switch (m->kind) {
    case WIRE_CLIENT:
        return m->client.removed;
    case WIRE_GEOMETRY:
        return m->geometry.removed;
    case WIRE_BODY:
        return m->body.removed;
    case WIRE_SUBSCRIPTION:
        return m->subscription.removed;
    default:
        return false;
    }
}

static bool dds_permits(transport *base, wire_kind kind)
{
    return ((transport_dds *)base)->writers[kind] > 0;
}

static int dds_send(transport *base, const wire_message *m)
{
    transport_dds *t = (transport_dds *)base;
    if (t->writers[m->kind] <= 0) return -1;
    wire_dds_encode(m, t->sample);
    dds_entity_t writer = t->writers[m->kind];
    return is_removed(m) ? dds_writedispose(writer, t->sample) : dds_write(writer, t->sample);
}

static void dds_forget(transport *base, const wire_message *removed)
{
    transport_dds *t = (transport_dds *)base;
    wire_dds_encode(removed, t->sample);
    (void)dds_unregister_instance(t->writers[removed->kind], t->sample);
}

static void dds_flush(transport *base)
{
    if (dds_permits(base, WIRE_POSE_BATCH)) dds_write_flush(((transport_dds *)base)->writers[WIRE_POSE_BATCH]);
}

static void dds_drain(transport *base, int64_t timeout_ns)
{
    dds_flush(base);
    if (timeout_ns > 0 && dds_permits(base, WIRE_POSE_BATCH))
        (void)dds_wait_for_acks(((transport_dds *)base)->writers[WIRE_POSE_BATCH], timeout_ns);
}

/* ---- receiving ---- */

static int dds_fd(transport *base, transport_role role)
{
    return ((transport_dds *)base)->fds[role];
}

static void hand_over(const dds_inbox *inbox, const void *sample, const transport_sink *sink)
{
    wire_message m;
    wire_refusal why;
    if (wire_dds_decode(inbox->kind, sample, &m, &why) == WIRE_OK)
        sink->message(sink->context, &m);
    else
        sink->refused(sink->context, &why);
}

static void take_all(const dds_inbox *inbox, const transport_sink *sink)
{
    dds_return_t n;
    do {
        void *samples[DDS_TAKE] = {NULL};
        dds_sample_info_t infos[DDS_TAKE];
        n = dds_take(inbox->reader, samples, infos, DDS_TAKE, DDS_TAKE);
        for (int i = 0; i < n; i++)
            if (infos[i].valid_data) hand_over(inbox, samples[i], sink);
        if (n > 0) (void)dds_return_loan(inbox->reader, samples, n);
    } while (n == DDS_TAKE);
}

static void dds_receive(transport *base, transport_role role, const transport_sink *sink)
{
    transport_dds *t = (transport_dds *)base;
    uint64_t count;
    if (read(t->fds[role], &count, sizeof count) < 0) count = 0; /* nothing new; looking costs little */
    if (role == TRANSPORT_STREAMS) {
        /* A callback may open a stream and move the array: read it anew each time. */
        for (size_t i = 0; i < t->stream_count; i++) {
            dds_inbox inbox = t->streams[i];
            take_all(&inbox, sink);
        }
        return;
    }
    if (dds_ready(base)) take_all(&t->control[0], sink);
    take_all(&t->control[1], sink);
    take_all(&t->control[2], sink);
}

static void forget_stream(transport_dds *t, size_t i)
{
    dds_inbox *inbox = &t->streams[i];
    (void)dds_delete(inbox->subscriber > 0 ? inbox->subscriber : inbox->reader);
    free(inbox->stream);
    *inbox = t->streams[--t->stream_count];
}

/* In a room all streams come by the shared partition. One that is silent is opened anew (stream.c), and so is its
 * reader: what that may miss meanwhile, the daemon tells all of its streams again. */
static int open_shared(transport_dds *t, const char *stream)
{
    size_t i = 0;
    if (t->closed_stream && strcmp(t->closed_stream, stream) == 0) {
        while (i < t->stream_count && t->streams[i].kind != WIRE_EVENT_BATCH) i++;
        if (i < t->stream_count) forget_stream(t, i);
        t->reads_shared = false;
    }
    free(t->closed_stream);
    t->closed_stream = NULL;
    if (!t->reads_shared && !add_stream(t, WIRE_EVENT_BATCH, NULL)) return -1;
    t->reads_shared = true;
    return 0;
}

static int dds_stream_open(transport *base, const char *stream)
{
    transport_dds *t = (transport_dds *)base;
    if (open_shared(t, stream) != 0) return -1;
    return t->room || add_stream(t, WIRE_EVENT_BATCH, stream) ? 0 : -1;
}

static void dds_stream_close(transport *base, const char *stream)
{
    transport_dds *t = (transport_dds *)base;
    for (size_t i = 0; i < t->stream_count; i++) {
        if (!t->streams[i].stream || strcmp(t->streams[i].stream, stream) != 0) continue;
        forget_stream(t, i);
        return;
    }
    if (!t->room) return;
    free(t->closed_stream);
    t->closed_stream = duplicate(stream);
}

const transport_ops transport_dds_ops = {
    .scheme = "dds",
    .repeats = false,
    .poses_max = WIRE_POSES_MAX,
    .open = dds_open_transport,
    .send = dds_send,
    .permits = dds_permits,
    .flush = dds_flush,
    .drain = dds_drain,
    .ready = dds_ready,
    .seek = dds_seek,
    .joined = dds_joined,
    .fd = dds_fd,
    .receive = dds_receive,
    .stream_open = dds_stream_open,
    .stream_close = dds_stream_close,
    .renew = dds_renew,
    .retire = dds_retire,
    .forget = dds_forget,
    .close = dds_close_transport,
};
