/* link_dds_take: messages from Cyclone's readers to the sink, decoded where they lie: in the loan, poses in the bytes
 * that came. The tick thread, or the thread of Cyclone's that stands in for it (link_dds_receive_poses). */
#include "link_dds_own.h"
#include "wire/dds/wire_dds.h"
#include "wire/dds/wire_dds_qos.h"

#define asm __asm__ /* the next header is in GNU C */
#include <dds/ddsi/ddsi_serdata.h>
#undef asm
#include <stdlib.h>
#include <string.h>

enum {
    TAKE_MAX = 32, /* samples a take. One constant: a loan writes as many pointers as the largest ever asked for */
    RECEIVE_MAX =
        2048, /* samples a reader and receive: a flood on one topic must not keep the tick from running, ... */
    POSES_MAX = 200000, /* ... nor one of poses: some 10 ms */
    POSES_TAKE = 4,     /* batches a take, of at most WIRE_POSES_MAX poses each */
    /* Bytes of poses. Where more come than a round takes, they wait here, by participant: in the reader's own history
     * one who floods would stand before all others. */
    ROUND_BYTES = 6 << 20,      /* that a receive hands over: 100,000 poses, 5 to 10 ms ... */
    DIRECT_BYTES = 1 << 20,     /* without waiting, if there are no more */
    READ_BYTES = 24 << 20,      /* ... and reads, which costs a tenth of that */
    ONE_WAITS_BYTES = 32 << 20, /* of one participant; then its oldest are lost, as in a history that is full */
    ALL_WAIT_BYTES = 128 << 20,
    ONE_WAITS = 1024, /* batches, whole or in parts ... */
    LOST_WAITS = 64,  /* receives in a row: so long a loss is not told while what came before it may wait */
    PART = 4096       /* ... of so many poses: of a larger one, if it is no step, which is one thing */
};

typedef struct batch_waiting { /* poses, decoded where they lie, and admitted */
    struct ddsi_serdata *data, *held;
    ddsrt_iovec_t bytes;
    wire_message m;
    int64_t origin;
    size_t poses;         /* in all of the bytes */
    bool unclaimed, lost; /* lost: its client is */
} batch_waiting;

static void refuse(link_dds *l, const link_sink *sink, wire_kind kind, const wire_message *m, const wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    metric_count(l->refused, 1);
    sink->refused(sink->context, &l->whole->head, kind, client, sequence, why);
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
    case WIRE_SUBSCRIPTION:
        m->subscription.removed = 1;
        break;
    default:
        break;
    }
}

static bool is_admitted(link_dds *l, const wire_message *m, const dds_sample_info_t *info, wire_refusal *why)
{
    bool admitted =
        speakers_admit(&l->whole->speakers, &l->ear, m, info->publication_handle, &l->whole->head.unclaimed, why);
    l->whole->head.origin = speakers_origin(&l->whole->speakers, info->publication_handle);
    if (!admitted && why->reason == WIRE_NOT_YOURS) metric_count(l->foreign, 1);
    return admitted;
}

static void hand_over(link_dds *l, const link_sink *sink, const wire_message *m)
{
    if (m->kind == WIRE_POSE_BATCH) l->poses += m->pose_batch.bodies.count;
    sink->message(sink->context, &l->whole->head, m);
    if (m->kind == WIRE_CLIENT && m->client.removed) speakers_release(&l->whole->speakers, m->client.client);
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

/* ---- poses that wait ---- */

static void free_waiting(batch_waiting *b)
{
    ddsi_serdata_to_ser_unref(b->held, &b->bytes);
    ddsi_serdata_unref(b->data);
    free(b);
}

static void lose_oldest(link_dds *l, const link_sink *sink, uint64_t source)
{
    batch_waiting *b = turns_oldest_of(&l->waiting, source);
    metric_count(l->history_full, 1);
    if (!b) return;
    if (!b->lost && sink->lost) sink->lost(sink->context, &l->whole->head, WIRE_POSE_BATCH, b->m.pose_batch.client, 1);
    free_waiting(b);
}

static void wait_in_line(link_dds *l, const link_sink *sink, batch_waiting *b, uint64_t source, size_t bytes)
{
    turns_put(&l->waiting, source, b, bytes);
    bool full =
        turns_count_of(&l->waiting, source) > ONE_WAITS || turns_bytes_of(&l->waiting, source) > ONE_WAITS_BYTES;
    if (full) lose_oldest(l, sink, source);
    while (l->waiting.bytes > ALL_WAIT_BYTES) lose_oldest(l, sink, turns_longest(&l->waiting));
}

/* Its first poses, as a batch of their own under the same sequence; the rest stays in `b`. */
static void wait_in_part(link_dds *l, const link_sink *sink, batch_waiting *b, uint64_t source, size_t bytes)
{
    wire_pose_batch *rest = &b->m.pose_batch;
    batch_waiting *part = base_zalloc(1, sizeof *part);
    *part = *b;
    part->data = ddsi_serdata_ref(b->data);
    part->held = ddsi_serdata_to_ser_ref(part->data, 0, ddsi_serdata_size(part->data), &part->bytes);
    link_cut_poses(rest, PART, &part->m.pose_batch);
    wait_in_line(l, sink, part, source, bytes);
}

/* What is refused, or is in an encoding that has to be copied, does not wait. The number of messages handed over. */
static size_t put_off(
    link_dds *l, const link_sink *sink, wire_kind kind, struct ddsi_serdata *data, const dds_sample_info_t *info)
{
    batch_waiting *b = base_zalloc(1, sizeof *b);
    wire_reason reason;
    wire_refusal why = {0};
    b->data = ddsi_serdata_ref(data);
    b->held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &b->bytes);
    bool plain = wire_dds_decode_bytes(kind, b->bytes.iov_base, b->bytes.iov_len, &b->m, &reason, &why);
    if (!plain || reason != WIRE_OK || !is_admitted(l, &b->m, info, &why)) {
        if (plain) refuse(l, sink, kind, &b->m, &why);
        free_waiting(b);
        return plain ? 0 : receive_copy(l, sink, kind, data, info);
    }
    uint64_t source = l->whole->head.origin ? (uint64_t)l->whole->head.origin : info->publication_handle;
    b->origin = l->whole->head.origin;
    b->unclaimed = l->whole->head.unclaimed;
    size_t bytes = b->bytes.iov_len, poses = b->m.pose_batch.bodies.count, a_pose = poses ? bytes / poses : bytes;
    b->poses = poses;
    while (!b->m.pose_batch.step && b->m.pose_batch.bodies.count > PART)
        wait_in_part(l, sink, b, source, a_pose * PART);
    wait_in_line(l, sink, b, source, poses ? a_pose * b->m.pose_batch.bodies.count : bytes);
    return 0;
}

/* Of poses that are more than this round takes the rest waits. */
static size_t receive_bytes(
    link_dds *l, const link_sink *sink, wire_kind kind, struct ddsi_serdata *data, const dds_sample_info_t *info)
{
    ddsrt_iovec_t bytes;
    wire_message m;
    wire_reason reason;
    wire_refusal why = {0};
    struct ddsi_serdata *held = ddsi_serdata_to_ser_ref(data, 0, ddsi_serdata_size(data), &bytes);
    bool plain = wire_dds_decode_bytes(kind, bytes.iov_base, bytes.iov_len, &m, &reason, &why);
    uint64_t work;
    bool waits = plain && reason == WIRE_OK && link_room_for(sink, &m, &work) != SIZE_MAX;
    bool taken = waits   ? put_off(l, sink, kind, data, info)
                 : plain ? hand_over_or_refuse(l, sink, &m, info, reason, &why)
                         : receive_copy(l, sink, kind, data, info);
    ddsi_serdata_to_ser_unref(held, &bytes);
    return taken;
}

static bool is_enough(const link_sink *sink)
{
    return sink->enough && sink->enough(sink->context);
}

/* The first one that waits, or as many of its poses as there is room for. */
static void hand_over_first(link_dds *l, const link_sink *sink, batch_waiting *b)
{
    uint64_t work = 0;
    l->whole->head.origin = b->origin;
    l->whole->head.unclaimed = b->unclaimed;
    size_t room = b->lost ? SIZE_MAX : link_room_for(sink, &b->m, &work);
    size_t more = link_bytes_of_work(work);
    if (room != SIZE_MAX) {
        wire_message part = b->m;
        size_t a_pose = b->bytes.iov_len / b->poses;
        link_cut_poses(&b->m.pose_batch, (uint32_t)room, &part.pose_batch);
        turns_part(&l->waiting, room * a_pose, more);
        l->whole->head.in_parts = true;
        hand_over(l, sink, &part);
        l->whole->head.in_parts = false;
        return;
    }
    turns_take(&l->waiting, more);
    if (!b->lost) hand_over(l, sink, &b->m);
    free_waiting(b);
}

/* By turns of those who sent them, as many as a round may have. */
static size_t hand_over_waiting(link_dds *l, const link_sink *sink)
{
    size_t before = l->waiting.bytes, messages = 0;
    batch_waiting *b;
    while (before - l->waiting.bytes < ROUND_BYTES && !(messages && is_enough(sink)) &&
           (b = turns_first(&l->waiting)) != NULL) {
        messages += !b->lost;
        hand_over_first(l, sink, b);
    }
    return messages;
}

static void forget_batch(void *context, void *message)
{
    batch_waiting *b = message;
    b->lost |= b->m.pose_batch.client == *(const int64_t *)context;
}

/* Nothing of a lost client comes after the news of its loss. */
static void report_lost(link_dds *l, const link_sink *sink, int64_t client)
{
    unsigned number = 1;
    turns_each(&l->waiting, forget_batch, &client);
    for (link_dds *room; (room = link_dds_next_room(l, &number)) != NULL;)
        turns_each(&room->waiting, forget_batch, &client);
    sink->client_lost(sink->context, &l->whole->head, client);
}

void link_dds_drop_waiting(link_dds *l)
{
    batch_waiting *b;
    while ((b = turns_next(&l->waiting)) != NULL) free_waiting(b);
}

/* ---- taking ---- */

/* Poses are read where Cyclone has put them: a copy would cost a third of what receiving them does. They have no key,
 * so there is no news of them but samples. Those of a take that is full may not be the last. */
static int take_poses(link_dds *l, const link_sink *sink, const reader *r, size_t *messages)
{
    struct ddsi_serdata *data[POSES_TAKE];
    dds_sample_info_t infos[POSES_TAKE];
    int n = dds_takecdr(r->entity, data, POSES_TAKE, infos, DDS_ANY_STATE);
    for (int i = 0; i < n; i++) l->read_bytes += ddsi_serdata_size(data[i]);
    bool many = n == POSES_TAKE || l->waiting.count || l->read_bytes > DIRECT_BYTES || is_enough(sink);
    for (int i = 0; i < n; i++) {
        if (infos[i].valid_data) *messages += (many ? put_off : receive_bytes)(l, sink, r->kind, data[i], &infos[i]);
        ddsi_serdata_unref(data[i]);
    }
    return n > 0 ? n : 0;
}

/* As many as one take may have: between takes it is asked whether so much has come that the rest has to wait, and one
 * body of a thousand rules, or one piece of a geometry, may take a millisecond. */
static int take_max(const reader *r)
{
    enum { BODIES_TAKE = 8, PIECES_TAKE = 2 };
    switch (r->kind) {
    case WIRE_POSE_BATCH:
        return POSES_TAKE;
    case WIRE_BODY:
        return BODIES_TAKE;
    case WIRE_GEOMETRY:
        return PIECES_TAKE;
    default:
        return TAKE_MAX;
    }
}

/* Samples taken from one reader; *messages of them were messages. */
static int take(link_dds *l, const link_sink *sink, const reader *r, size_t *messages)
{
    if (r->kind == WIRE_POSE_BATCH) return take_poses(l, sink, r, messages);
    void *samples[TAKE_MAX] = {NULL};
    dds_sample_info_t infos[TAKE_MAX];
    int n = dds_take(r->entity, samples, infos, TAKE_MAX, (uint32_t)take_max(r));
    if (n <= 0) return 0;
    for (int i = 0; i < n; i++) *messages += receive_sample(l, sink, r->kind, samples[i], &infos[i]);
    dds_return_loan(r->entity, samples, n);
    return n;
}

static size_t take_all(link_dds *l, const link_sink *sink, reader *r)
{
    size_t messages = 0;
    int total = 0, n;
    bool poses = r->kind == WIRE_POSE_BATCH; /* which have bounds of their own */
    l->poses = l->read_bytes = 0;
    do {
        n = take(l, sink, r, &messages);
        total += n;
    } while (n == take_max(r) && total < RECEIVE_MAX && l->poses < POSES_MAX && l->read_bytes < READ_BYTES &&
             (poses || !link_has_much(sink)));
    l->is_behind |= !poses && n == take_max(r);
    if (poses) messages += hand_over_waiting(l, sink);
    if (n == take_max(r) || (poses && l->waiting.count)) link_dds_notice(l, &r->arrived); /* more, for the next tick */
    const wire_dds_profile *p = wire_dds_profile_of(r->kind);
    if (!p->late_joiners && total >= p->reader_depth) metric_count(l->history_full, 1);
    return messages;
}

/* At most as much as TAKE_MAX batches: a flood is the tick thread's. */
size_t link_dds_receive_poses(struct link *head, const link_sink *sink)
{
    link_dds *l = link_dds_of(head);
    reader *r = l->readers;
    size_t messages = 0;
    int total = 0, n = 0;
    while (r->kind != WIRE_POSE_BATCH) r++;
    l->on_arrival = true;
    l->poses = l->read_bytes = 0;
    if (atomic_exchange(&r->arrived, false)) do
            total += n = take(l, sink, r, &messages);
        while (n == POSES_TAKE && total < TAKE_MAX && l->poses < POSES_MAX && l->read_bytes < READ_BYTES);
    messages += hand_over_waiting(l, sink);
    if (n == POSES_TAKE || l->waiting.count) link_dds_notice(l, &r->arrived);
    metric_count(l->messages_in, messages);
    return messages;
}

static void report_lost_samples(link_dds *l, const link_sink *sink)
{
    if (!atomic_exchange(&l->has_lost, false)) return;
    for (int kind = 0; kind < WIRE_KIND_COUNT; kind++) {
        size_t count = atomic_exchange(&l->lost[kind], 0);
        if (count && sink->lost) sink->lost(sink->context, &l->whole->head, (wire_kind)kind, 0, count);
    }
}

static size_t receive_in(link_dds *l, const link_sink *sink)
{
    size_t messages = 0;
    l->on_arrival = l->is_behind = false;
    if (atomic_exchange(&l->has_discovered, false)) speakers_discover(&l->whole->speakers, &l->ear);
    atomic_store(&l->has_news, false);
    report_lost_samples(l, sink);
    for (size_t i = 0; i < LINK_DDS_IN; i++)
        if (atomic_exchange(&l->readers[i].arrived, false)) messages += take_all(l, sink, &l->readers[i]);
    if (atomic_exchange(&l->status_matched, false) && sink->status_reader)
        sink->status_reader(sink->context, &l->whole->head);
    return messages;
}

/* The link, and its rooms: each time it begins with another one, since who comes last may find the round full. */
static size_t receive_everywhere(link_dds *l, const link_sink *sink, bool *behind)
{
    size_t messages = 0;
    unsigned from = l->first++ % (WIRE_DDS_ROOMS + 1);
    for (unsigned i = 0; i <= WIRE_DDS_ROOMS; i++) {
        unsigned number = (from + i) % (WIRE_DDS_ROOMS + 1);
        link_dds *one = number ? atomic_load(&l->rooms[number]) : l;
        if (!one) continue;
        messages += receive_in(one, sink);
        *behind |= one->is_behind;
    }
    return messages;
}

size_t link_dds_receive(struct link *head, const link_sink *sink)
{
    link_dds *l = link_dds_of(head);
    int64_t client;
    bool behind = false;
    atomic_store(&l->woken, false); /* first: what arrives from now on wakes again */
    size_t messages = receive_everywhere(l, sink, &behind);
    link_dds_streams_report(l, sink);
    /* Last, so that nothing of a lost client comes after the news of its loss. */
    l->loss_waited = behind ? l->loss_waited + 1 : 0;
    if (!behind || l->loss_waited % LOST_WAITS == 0)
        while (speakers_lost(&l->speakers, &client)) report_lost(l, sink, client);
    metric_count(l->messages_in, messages);
    return messages;
}
