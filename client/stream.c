/* stream: batches of events in, callbacks and receipts out. The batches of a stream are numbered: after a gap nothing
 * is delivered until the daemon, by a receipt that says how far we have got, has sent on from there, or a snapshot;
 * that one says how many were lost. So what a callback has heard is always a state that the world was in. Receipts also
 * pace what is large: the daemon sends only so much beyond them. A callback whose stream starves, since nothing whole
 * comes for long, hears of it. A stream that is silent although the daemon is heard is asked for by announcing the
 * subscription again: heartbeats may be rarer than that, so after longer and longer silences. The caller's thread,
 * without the lock.
 */
#include "allocate.h"
#include "announce.h"
#include "message.h"
#include "observe.h"
#include "session.h"
#include "session_run.h"

#include <stdlib.h>
#include <string.h>

enum {
    FIRST_RESYNC_MS = 250,
    LONGEST_RESYNC_S = 16,
    RECEIPTS_MOST = 4,         /* in vain: then the subscription is announced again */
    LONGEST_PATIENCE_S = 3600, /* a daemon's heartbeat has no longer period */
    STARVED_S = 3,
    RECEIPT_EACH = 64,      /* messages, while the stream is up to date: half of what the daemon sends without */
    RECEIPT_EACH_BEHIND = 8 /* and at the end of each turn, while it is not */
};

static const char *cause_name(uint8_t cause)
{
    static const char *const names[] = {[WIRE_CAUSE_MOTION] = "motion",
        [WIRE_CAUSE_REMOVED] = "removed",
        [WIRE_CAUSE_OWNER_LOST] = "owner_lost",
        [WIRE_CAUSE_FILTER] = "filter",
        [WIRE_CAUSE_SHAPE] = "shape",
        [WIRE_CAUSE_SUBSCRIPTION] = "subscription",
        [WIRE_CAUSE_SHUTDOWN] = "shutdown",
        [WIRE_CAUSE_STALE] = "stale",
        [WIRE_CAUSE_SNAPSHOT] = "snapshot",
        [WIRE_CAUSE_TELEPORT] = "teleport"};
    return cause < sizeof names / sizeof names[0] ? names[cause] : "unknown";
}

void stream_drop_parts(subscription_record *i)
{
    while (i->part_count) free(i->parts[--i->part_count]);
}

/* Parts of a batch that will not be whole were not delivered: they count as lost. */
static void give_up_parts(subscription_record *i)
{
    if (!i->gathering) i->next_batch -= (int64_t)i->part_count;
    i->gathering = false;
    stream_drop_parts(i);
}

static double age_s(int64_t age_ns)
{
    return age_ns < 0 ? -1.0 : (double)age_ns * 1e-9;
}

/* Said by a later daemon: the callback gets it as it came. */
static bool is_unknown(const wire_event_batch *b, uint32_t i)
{
    return b->kinds.at[i] > WIRE_EVENT_AVERTED || b->causes.at[i] > WIRE_CAUSE_TELEPORT ||
           b->achieved.at[i] > WIRE_STOPPED;
}

static void fill_event(collided_event *e, const wire_event_batch *b, uint32_t i)
{
    *e = (collided_event){.kind = (collided_event_kind)b->kinds.at[i],
        .cause = cause_name(b->causes.at[i]),
        .contact = b->contacts.at[i],
        .name_a = b->names_a.at[i],
        .name_b = b->names_b.at[i],
        .shape_a = b->shapes_a.at[i],
        .shape_b = b->shapes_b.at[i],
        .lo = b->lo.at[i],
        .hi = b->hi.at[i],
        .age_a_s = age_s(b->ages_a_ns.at[i]),
        .age_b_s = age_s(b->ages_b_ns.at[i]),
        .closing_m_s = b->closings.at[i],
        .achieved = (collided_achieved)b->achieved.at[i],
        .point_count = b->manifold_counts.at[i]};
    memcpy(e->axis, b->axes.at + 3 * (size_t)i, sizeof e->axis);
    memcpy(e->point_a, b->points_a.at + 3 * (size_t)i, sizeof e->point_a);
    memcpy(e->point_b, b->points_b.at + 3 * (size_t)i, sizeof e->point_b);
}

static void fill_point(collided_contact_point *p, const wire_event_batch *b, uint32_t i)
{
    memcpy(p->point, b->manifold_points.at + 3 * (size_t)i, sizeof p->point);
    p->distance = b->manifold_distances.at[i];
    p->feature = b->manifold_features.at[i];
}

static bool has_impact(const collided_event *e)
{
    return e->kind == COLLIDED_EVENT_IMPACT || e->kind == COLLIDED_EVENT_PREDICTED;
}

static void fill_pose(collided_pose *p, const double numbers[7])
{
    memcpy(p->position, numbers, sizeof p->position);
    memcpy(p->orientation, numbers + 3, sizeof p->orientation);
}

static void fill_impact(collided_impact *x, const wire_event_batch *b, uint32_t i)
{
    *x = (collided_impact){.lo_s = b->impact_times.at[2 * (size_t)i],
        .hi_s = b->impact_times.at[2 * (size_t)i + 1],
        .start_ns = b->impact_starts_ns.at[i],
        .estimated = b->impact_estimated.at[i] != 0};
    fill_pose(&x->pose_a, b->impact_poses.at + 14 * (size_t)i);
    fill_pose(&x->pose_b, b->impact_poses.at + 14 * (size_t)i + 7);
}

static void count_unknown(collided *c, int64_t events)
{
    pthread_mutex_lock(&c->lock);
    c->counters.unknown_events += events;
    pthread_mutex_unlock(&c->lock);
}

/* The parts' events, one after the other, into the client's arrays; what they name stays in the parts. */
static size_t gather(collided *c, const wire_message *const *parts, size_t part_count)
{
    size_t events = 0, points = 0, impacts = 0;
    int64_t unknown = 0;
    for (size_t k = 0; k < part_count; k++) {
        events += parts[k]->event_batch.kinds.count;
        points += parts[k]->event_batch.manifold_distances.count;
        impacts += parts[k]->event_batch.impact_starts_ns.count;
    }
    c->events = reserve(c->events, &c->event_capacity, events, sizeof *c->events);
    c->points = reserve(c->points, &c->point_capacity, points, sizeof *c->points);
    c->impacts = reserve(c->impacts, &c->impact_capacity, impacts, sizeof *c->impacts);
    collided_impact *x = c->impacts;
    collided_event *e = c->events;
    collided_contact_point *p = c->points;
    for (size_t k = 0; k < part_count; k++) {
        const wire_event_batch *b = &parts[k]->event_batch;
        uint32_t used = 0, met = 0;
        for (uint32_t i = 0; i < b->kinds.count; i++, e++) {
            fill_event(e, b, i);
            unknown += is_unknown(b, i);
            e->points = p;
            for (size_t n = 0; n < e->point_count; n++) fill_point(p++, b, used++);
            if (!has_impact(e)) continue;
            e->impact = x;
            fill_impact(x++, b, met++);
        }
    }
    if (unknown) count_unknown(c, unknown);
    return events;
}

static void deliver(collided *c, subscription_record *i, const wire_message *const *parts, size_t part_count)
{
    const wire_event_batch *b = &parts[part_count - 1]->event_batch;
    if (i->observed) {
        i->reported_epoch = b->epoch;
        observe_deliver(c, i, b);
        return;
    }
    size_t count = gather(c, parts, part_count);
    const collided_batch batch = {.subscription = {i->id},
        .stream = b->stream,
        .epoch = b->epoch,
        .batch = b->batch,
        .tick = b->tick,
        .stamp_ns = b->stamp_ns,
        .latest_pose_ns = b->latest_pose_ns,
        .step = b->step,
        .simulation_ns = b->simulation_ns,
        .missing = b->missing,
        .refused = b->refused,
        .refusal = b->refused ? wire_reason_name((wire_reason)b->refusal) : "",
        .undone = b->undone,
        .heartbeat = b->heartbeat,
        .oldest_pose_ns = b->oldest_pose_ns,
        .snapshot = b->snapshot,
        .closing = b->closing,
        .lost = i->lost,
        .behind = parts[0]->event_batch.behind,
        .event_count = count,
        .events = c->events,
        .poses = i->has_poses ? observe_event_poses(c, parts, part_count) : NULL};
    i->lost = 0;
    i->reported_epoch = b->epoch;
    step_answered(c, i, b);
    size_t soft = i->soft_callback ? soft_gather(&c->soft, parts, part_count) : 0;
    c->in_callback = true;
    if (soft) soft_deliver(i, c->soft, b);
    i->callback(i->context, &batch);
    c->in_callback = false;
    c->delivered++;
}

static void count_lost(collided *c, subscription_record *i, int64_t batches)
{
    i->lost += batches;
    pthread_mutex_lock(&c->lock);
    c->counters.batches_lost += batches;
    pthread_mutex_unlock(&c->lock);
    (void)session_fail(c, COLLIDED_TRANSPORT, "stream '%s': %lld batches were lost, and a snapshot came in their place",
        i->stream, (long long)batches);
}

/* ---- what we have, and what is missing ---- */

static bool lacks(const subscription_record *i)
{
    return i->waiting || i->gathering;
}

/* False: nothing has come yet that it could name, or we may not write it. */
static bool send_receipt(collided *c, subscription_record *i, bool missing)
{
    bool names = i->next_batch > 0 || i->gathering, before = i->unsure || i->reported_more;
    if (!names || (c->link->ops->permits && !c->link->ops->permits(c->link, WIRE_RECEIPT))) return false;
    wire_message m = {.kind = WIRE_RECEIPT,
        .receipt = {.version = WIRE_VERSION,
            .client = c->id,
            .subscription = i->id,
            .epoch = before ? i->unsure_epoch : i->epoch,
            .batch = i->reported_more   ? i->reported_more
                     : i->snapshot_tick ? i->snapshot_batch
                                        : i->next_batch - 1,
            .tick = i->snapshot_tick,
            .part = i->snapshot_part,
            .missing = missing}};
    pthread_mutex_lock(&c->lock);
    message_set_sequence(&m, ++c->sequence);
    (void)session_send(c, &m);
    pthread_mutex_unlock(&c->lock);
    i->owed = 0;
    return true;
}

/* Announcing the subscription again makes the daemon send a snapshot. Not while it is pending: then one comes by
 * itself. */
static bool announce_subscription_again(collided *c, subscription_record *i)
{
    pthread_mutex_lock(&c->lock);
    bool asked = i->announced.state == ANNOUNCE_ACKED;
    if (asked) announce_again(c, &i->announced);
    pthread_mutex_unlock(&c->lock);
    return asked;
}

static void ask_for_missing(collided *c, subscription_record *i, int64_t now_ns)
{
    bool asked = i->receipts < RECEIPTS_MOST && send_receipt(c, i, true);
    i->receipts += asked;
    if (!asked) asked = announce_subscription_again(c, i);
    i->asked = true;
    i->resync_ns = now_ns + i->resync_wait_ns;
    if (asked && i->resync_wait_ns < LONGEST_RESYNC_S * NS_PER_S) i->resync_wait_ns *= 2;
}

/* Once for each place: what follows there is of no use either. */
static void note_missing(collided *c, subscription_record *i)
{
    int64_t now = session_monotonic_ns();
    if (!lacks(i)) i->lacks_ns = now;
    if (!i->waiting) i->resync_wait_ns = FIRST_RESYNC_MS * NS_PER_MS;
    i->waiting = true;
    if (!i->asked) ask_for_missing(c, i, now);
}

static void take_in_order(collided *c, subscription_record *i, const wire_event_batch *b)
{
    i->asked = false;
    i->receipts = 0;
    i->waiting = i->gathering;
    i->resync_wait_ns = FIRST_RESYNC_MS * NS_PER_MS;
    i->resync_ns = i->last_seen_ns + i->resync_wait_ns;
    i->eager = b->behind || b->snapshot;
    if (++i->owed >= (i->eager ? RECEIPT_EACH_BEHIND : RECEIPT_EACH)) (void)send_receipt(c, i, false);
}

static void notify_starved(collided *c, subscription_record *i)
{
    i->starved = true;
    if (i->observed) return;
    const collided_batch notice = {.subscription = {i->id},
        .stream = i->stream,
        .epoch = i->epoch,
        .batch = i->next_batch - 1,
        .tick = i->tick,
        .behind = i->behind > 0 ? i->behind : 1,
        .starved = true,
        .events = c->events};
    c->in_callback = true;
    i->callback(i->context, &notice);
    c->in_callback = false;
    c->delivered++;
}

static int64_t starves_ns(const subscription_record *i)
{
    return lacks(i) && !i->starved ? i->lacks_ns + STARVED_S * NS_PER_S : INT64_MAX;
}

/* Not while its announcement, or the daemon, is what one waits for. */
static void report_starving(collided *c, subscription_record *i, int64_t now_ns)
{
    pthread_mutex_lock(&c->lock);
    bool expected = i->announced.state == ANNOUNCE_ACKED;
    pthread_mutex_unlock(&c->lock);
    if (!expected || session_unheard(c)) {
        i->lacks_ns = now_ns;
        return;
    }
    (void)session_fail(
        c, COLLIDED_TIMEOUT, "stream '%s' starves: nothing whole has come for %d s", i->stream, STARVED_S);
    notify_starved(c, i);
}

/* It was asked for, and acknowledged, and not even a snapshot has come: our reader takes all that comes for old, as it
 * does when packets were forged. It is opened anew, and the callback hears that it has heard nothing for long. */
static void read_anew(collided *c, subscription_record *i)
{
    c->link->ops->stream_close(c->link, i->stream);
    bool closed = c->link->ops->stream_open(c->link, i->stream) != 0;
    pthread_mutex_lock(&c->lock);
    c->counters.silent_streams++;
    pthread_mutex_unlock(&c->lock);
    (void)session_fail(c, closed ? COLLIDED_TRANSPORT : COLLIDED_TIMEOUT,
        "stream '%s' is silent, though the daemon is heard: it %s", i->stream,
        closed ? "cannot be read any more" : "is read anew");
    notify_starved(c, i);
}

/* A daemon that is not heard at all is silent on all streams, and need not be asked. One that is answers within
 * moments: the second look comes soon. */
static void look_into_silence(collided *c, subscription_record *i, int64_t now_ns)
{
    i->last_seen_ns = now_ns;
    if (session_unheard(c) || !announce_subscription_again(c, i)) return;
    if (i->patience_ns < LONGEST_PATIENCE_S * NS_PER_S) i->patience_ns *= 2;
    if (!i->silences++)
        i->last_seen_ns -= i->patience_ns - SESSION_SILENCE_NS;
    else
        read_anew(c, i);
}

static int64_t due_ns(const subscription_record *i)
{
    int64_t asks_ns = lacks(i) ? i->resync_ns : i->last_seen_ns + i->patience_ns;
    return starves_ns(i) < asks_ns ? starves_ns(i) : asks_ns;
}

void stream_tend(collided *c, int64_t now_ns)
{
    for (subscription_record *i = c->subscriptions; i; i = i->next) {
        if (!i->removed && i->owed && i->eager) (void)send_receipt(c, i, false);
        if (i->removed || now_ns < due_ns(i)) continue;
        if (now_ns >= starves_ns(i)) report_starving(c, i, now_ns);
        if (lacks(i) && now_ns >= i->resync_ns)
            ask_for_missing(c, i, now_ns);
        else if (!lacks(i))
            look_into_silence(c, i, now_ns);
    }
}

int64_t stream_next_ns(const collided *c)
{
    int64_t next = INT64_MAX;
    for (const subscription_record *i = c->subscriptions; i; i = i->next)
        if (!i->removed && due_ns(i) < next) next = due_ns(i);
    return next;
}

static subscription_record *addressee(collided *c, const wire_event_batch *b)
{
    if (b->client != c->id) return NULL; /* another client publishes a stream of the same name */
    pthread_mutex_lock(&c->lock);
    bool ours = session_hear(c, b->epoch);
    pthread_mutex_unlock(&c->lock);
    subscription_record *i = ours ? c->subscriptions : NULL;
    while (i && (i->id != b->subscription || i->removed)) i = i->next;
    if (i) i->last_seen_ns = session_monotonic_ns();
    if (i) i->silences = 0;
    return i;
}

static void follow_epoch(subscription_record *i, const wire_event_batch *b)
{
    if (b->epoch == i->epoch) return;
    if (wire_same_line(b->epoch, i->epoch)) { /* a standby has taken over, and goes on with the same numbers */
        if (!i->unsure && !i->reported_more) i->unsure_epoch = i->epoch;
        i->epoch = b->epoch;
        i->unsure = !lacks(i);
        return;
    }
    give_up_parts(i);
    i->unsure = i->asked = false;
    i->reported_more = 0;
    if (!i->waiting) i->lacks_ns = session_monotonic_ns();
    i->waiting = true;
    i->receipts = 0;
    i->resync_wait_ns = NS_PER_S;
    i->resync_ns = session_monotonic_ns() + i->resync_wait_ns;
    i->epoch = b->epoch;
    i->next_batch = i->snapshot_tick = i->snapshot_batch = i->snapshot_part = 0;
}

/* ---- snapshots: as of the batch whose number they have ---- */

static bool is_of_snapshot(const subscription_record *i, const wire_event_batch *b)
{
    return i->snapshot_tick && b->batch == i->snapshot_batch && b->tick == i->snapshot_tick;
}

/* The daemon numbers ticks from 1; 0 stands for none. */
static void begin_gathering(subscription_record *i, const wire_event_batch *b)
{
    if (!lacks(i)) i->lacks_ns = session_monotonic_ns();
    give_up_parts(i);
    i->gathering = true;
    i->unsure = false;
    i->reported_more = 0;
    i->snapshot_batch = b->batch;
    i->snapshot_tick = b->tick;
    i->snapshot_part = 0;
}

static void end_gathering(collided *c, subscription_record *i, const wire_event_batch *b)
{
    int64_t lost = i->next_batch && !i->closed ? b->batch + 1 - i->next_batch : 0;
    if (lost > 0) count_lost(c, i, lost);
    i->gathering = false;
    i->next_batch = b->batch + 1;
}

/* One that others have overtaken is none: within an epoch numbers only rise, also where the stream began anew. */
static bool takes_part(collided *c, subscription_record *i, const wire_event_batch *b)
{
    bool same = is_of_snapshot(i, b);
    if (same && b->part <= i->snapshot_part) return false; /* a copy */
    if (same && i->gathering && b->part == i->snapshot_part + 1)
        i->snapshot_part = b->part;
    else if (!same && b->part == 0 && (i->unsure || b->batch + 1 >= i->next_batch))
        begin_gathering(i, b);
    else {
        if (lacks(i) || b->batch >= i->next_batch) note_missing(c, i);
        return false;
    }
    if (b->part + 1 == b->parts) end_gathering(c, i, b);
    return true;
}

/* ---- batches ---- */

/* A standby that has taken over tells again what readers may have missed, snapshots too; its ticks go on. */
static bool was_reported(const subscription_record *i, const wire_event_batch *b)
{
    return b->tick < i->tick || (b->tick == i->tick && b->batch < i->next_batch);
}

/* True if the batch continues what was delivered, or begins anew. */
static bool in_order(collided *c, subscription_record *i, const wire_event_batch *b)
{
    follow_epoch(i, b);
    if (i->unsure && was_reported(i, b)) return false;
    if (b->snapshot) return takes_part(c, i, b);
    if (!i->gathering && !i->reported_more && i->next_batch && b->batch == i->next_batch) {
        i->next_batch++;
        i->snapshot_tick = i->snapshot_batch = i->snapshot_part = 0;
        return true;
    }
    bool had = i->gathering ? b->batch <= i->snapshot_batch : b->batch < i->next_batch;
    if (!had && (i->next_batch || i->gathering)) note_missing(c, i);
    return false;
}

/* It has the number of the last batch that there is, which may be one that has not come, or waits to be sent. */
static void receive_heartbeat(collided *c, subscription_record *i, const wire_message *m)
{
    const wire_event_batch *b = &m->event_batch;
    follow_epoch(i, b);
    i->behind = b->behind;
    bool names = i->next_batch > 0 || i->gathering;
    if (!names) return;
    if (b->behind) { /* what it waits for is a receipt, or was lost */
        if (session_monotonic_ns() >= i->resync_ns) note_missing(c, i);
    } else if (i->gathering || b->batch >= i->next_batch) {
        note_missing(c, i);
    } else if (b->batch == i->next_batch - 1) {
        i->unsure = false;
        if (!i->waiting) deliver(c, i, &m, 1);
    } else if (i->unsure) { /* we were told more than the standby knew of when it took over: it is told so */
        i->unsure = false;
        i->reported_more = i->next_batch - 1;
        i->next_batch = b->batch + 1;
        i->snapshot_tick = 0;
        note_missing(c, i);
    }
}

void stream_receive(collided *c, const wire_message *m)
{
    const wire_event_batch *b = &m->event_batch;
    subscription_record *i = addressee(c, b);
    if (i && b->heartbeat) receive_heartbeat(c, i, m);
    if (!i || b->heartbeat || !in_order(c, i, b)) return;
    i->behind = b->behind;
    i->tick = b->tick;
    i->closed = b->closing && b->part + 1 == b->parts;
    take_in_order(c, i, b);
    if (b->parts > 1) {
        i->parts = reserve(i->parts, &i->part_capacity, i->part_count + 1, sizeof(wire_message *));
        i->parts[i->part_count++] = message_copy(m);
    }
    if (b->part + 1 < b->parts) return;
    i->starved = false;
    if (b->parts <= 1)
        deliver(c, i, &m, 1);
    else
        deliver(c, i, (const wire_message *const *)i->parts, i->part_count);
    stream_drop_parts(i);
}
