/* steps: lock-step of simulators in several processes. Poses of a member that carry a step wait here; an empty batch
 * with the step's number ends what it publishes of it. When every member has ended a step, it is applied as a whole,
 * and one tick follows, in which each of them is answered. Tick thread.
 *
 * What is applied when follows from the messages and from where the ticks end alone, so that a replay does the same: a
 * member that misses a step by the clock is let miss it by a message in its name, which is recorded like those that
 * come. */
#include "clients.h"
#include "commands.h"
#include "recordings.h"
#include "service.h"
#include "standby.h"
#include "vertices.h"

#include "base/hash.h"
#include "base/log.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool is_member(const session *c)
{
    return c->lock_step > 0;
}

/* ---- members ---- */

static void drop_held_step(session *c)
{
    c->held.step = c->held.simulation_ns = 0;
    c->held.bytes.count = c->held.poses = 0;
    c->held.newest = 0;
    c->held.broken = false;
    c->held.digests.list.count = 0;
    c->held.digests.sorted = false;
}

void steps_free(session *c)
{
    array_free(&c->held.bytes);
    array_free(&c->owed);
    array_free(&c->held.digests.list);
    array_free(&c->done.list);
}

/* ---- what a batch says, so that a copy of it under another sequence is known ---- */

static uint64_t mix(uint64_t h, const void *data, size_t size)
{
    const char *at = data;
    for (; size >= sizeof h; size -= sizeof h, at += sizeof h) {
        uint64_t word;
        memcpy(&word, at, sizeof word);
        h = (h ^ word) * UINT64_C(0x9e3779b97f4a7c15);
        h ^= h >> 32;
    }
    return hash_bytes(h, at, size);
}

static uint64_t digest_of(const wire_pose_batch *m)
{
    const uint32_t counts[] = {m->bodies.count, m->linear.count, m->angular.count, m->teleports.count};
    uint64_t h = mix(HASH_START, counts, sizeof counts);
    h = mix(h, m->bodies.at, m->bodies.count * sizeof *m->bodies.at);
    h = mix(h, m->positions.at, m->positions.count * sizeof *m->positions.at);
    h = mix(h, m->orientations.at, m->orientations.count * sizeof *m->orientations.at);
    h = mix(h, m->linear.at, m->linear.count * sizeof *m->linear.at);
    h = mix(h, m->angular.at, m->angular.count * sizeof *m->angular.at);
    return mix(h, m->teleports.at, m->teleports.count * sizeof *m->teleports.at);
}

static int compare_digests(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

/* Was it in the step that was done last? */
static bool was_done(session *c, const wire_pose_batch *m)
{
    digests *d = &c->done;
    uint64_t digest = digest_of(m);
    if (!d->list.count) return false;
    if (!d->sorted) qsort(d->list.at, d->list.count, sizeof *d->list.at, compare_digests);
    d->sorted = true;
    return bsearch(&digest, d->list.at, d->list.count, sizeof *d->list.at, compare_digests);
}

typedef struct roll {
    size_t wanted, ready; /* so many are to be there before the first step; have published the next one */
    int64_t least, next;  /* step that all have published; the least that some have and that is not done */
} roll;

static roll call_roll(const service *s)
{
    roll r = {.least = INT64_MAX, .next = INT64_MAX};
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        if (!is_member(c)) continue;
        if ((size_t)c->lock_step > r.wanted) r.wanted = (size_t)c->lock_step;
        if (c->published < r.least) r.least = c->published;
        if (c->published <= s->lock_step.done) continue;
        r.ready++;
        if (c->published < r.next) r.next = c->published;
    }
    return r;
}

static bool all_are_there(const service *s, const roll *r)
{
    return s->lock_step.begun || s->lock_step.members >= r->wanted;
}

static bool is_complete(const service *s, const roll *r)
{
    return s->lock_step.members && r->ready == s->lock_step.members && all_are_there(s, r) && !s->lock_step.pending;
}

/* Whoever comes has what is left of the others' time: else comings and goings would postpone it for ever. Only the
 * first step is waited for from the moment on when all are there. */
void steps_join(service *s, session *c, int32_t lock_step)
{
    if (c->lock_step == lock_step) return;
    bool was = is_member(c);
    roll before = call_roll(s);
    bool all_were_there = all_are_there(s, &before);
    c->lock_step = lock_step;
    if (was != is_member(c)) {
        drop_held_step(c);
        c->idle = c->missed = false;
        c->published = s->lock_step.done;
        c->ended = 0;
        s->lock_step.members += was ? (size_t)-1 : 1;
    }
    roll after = call_roll(s);
    if (!all_were_there && all_are_there(s, &after)) s->lock_step.since_ns = 0;
    if (!s->lock_step.members) s->lock_step = (struct lock_step){.members = 0}; /* others may count from the start */
}

/* ---- what is published ---- */

__attribute__((format(printf, 5, 6))) static bool refuse_step(
    service *s, struct link *to, const wire_pose_batch *m, wire_reason reason, const char *format, ...)
{
    wire_refusal why = {.reason = reason};
    va_list args;
    va_start(args, format);
    vsnprintf(why.text, sizeof why.text, format, args);
    va_end(args);
    apply_reject(s, to, WIRE_POSE_BATCH, m->client, m->sequence, -1, &why);
    return true;
}

static void each_message(
    const uint8_t *bytes, size_t count, void (*call)(void *context, const wire_message *m), void *context)
{
    wire_memory *memory = count ? wire_memory_create() : NULL;
    for (size_t at = 0, size; at < count; at += sizeof size + size) {
        wire_message m;
        wire_refusal why;
        memcpy(&size, bytes + at, sizeof size);
        wire_memory_reset(memory);
        if (wire_lcm_decode(bytes + at + sizeof size, size, memory, &m, &why) == WIRE_OK) call(context, &m);
    }
    wire_memory_destroy(memory);
}

enum { A_POSE = 1000 }; /* units, see world_effort */

/* Poses of bodies of many shapes count as so many as would take as long. */
static size_t weight_of(const service *s, session *c, const wire_pose_batch *m)
{
    size_t weight = m->bodies.count;
    for (uint32_t i = 0; i < m->bodies.count && world_has_wide(s->world); i++) {
        const owned_body *b = session_body(c, m->bodies.at[i]);
        weight += b ? (size_t)(world_effort_of(s->world, b->world_id, NULL) / (A_POSE + 1)) : 0;
    }
    return weight;
}

/* A step is carried out at once: all members together have so many poses in it. But each may have an equal share of
 * them, whatever others have. */
static bool is_too_much(service *s, const session *c, size_t more, wire_refusal *why)
{
    size_t all = more, most = (size_t)s->config.max_step_poses;
    for (size_t i = 0; i < s->sessions.count; i++)
        if (is_member(s->sessions.at[i])) all += s->sessions.at[i]->held.poses;
    if (c->held.poses + more <= most / s->lock_step.members) return false;
    return apply_limit(s, all - 1, s->config.max_step_poses, "max_step_poses", why);
}

static void hold_poses(session *c, const wire_pose_batch *poses, size_t weight)
{
    const wire_message m = {.kind = WIRE_POSE_BATCH, .pose_batch = *poses};
    size_t size = wire_lcm_size(&m), at = c->held.bytes.count;
    array_reserve(&c->held.bytes, at + sizeof size + size);
    memcpy(c->held.bytes.at + at, &size, sizeof size);
    wire_lcm_encode(&m, c->held.bytes.at + at + sizeof size, size);
    c->held.bytes.count += sizeof size + size;
    if (poses->sequence > c->held.newest) c->held.newest = poses->sequence;
    c->held.poses += weight;
    array_push(&c->held.digests.list, digest_of(poses));
}

/* The answer may have been lost, and all is sent again: copies of what was in the step are no news, and anything else
 * is not in it. Who missed the step is told how far the others are. */
static bool answer_again(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    if (c->missed)
        refuse_step(s, from, m, WIRE_BAD_STEP, "step %" PRId64 " is done, without this client", m->step);
    else if (m->bodies.count && !was_done(c, m)) {
        apply_count_refused(c, m->bodies.count, WIRE_BAD_STEP);
        refuse_step(
            s, from, m, WIRE_BAD_STEP, "step %" PRId64 " is done, without these poses: its end came first", m->step);
    } else
        metric_count(s->count.duplicates, 1);
    if (m->bodies.count) return true;
    c->idle = false;
    c->stepped = s->lock_step.asked_again = true;
    return true;
}

/* In a replay it is the daemon's own. */
bool steps_admit(const service *s, const wire_message *m, wire_refusal *why)
{
    if (s->replaying || m->kind != WIRE_POSE_BATCH || m->pose_batch.sequence != STEP_IN_ITS_NAME) return true;
    why->reason = WIRE_MALFORMED;
    snprintf(why->text, sizeof why->text, "sequence is %" PRId64 ": less is allowed", m->pose_batch.sequence);
    return false;
}

static bool ends_in_its_name(const wire_pose_batch *m)
{
    return m->sequence == STEP_IN_ITS_NAME && !m->bodies.count;
}

/* That some of the step's poses were refused before they came here. */
static bool is_mark(const wire_pose_batch *m)
{
    return m->sequence == STEP_IN_ITS_NAME && m->bodies.count;
}

/* ---- what a step owes: nothing that was sent for it may be left out in silence ---- */

static void owe(service *s, session *c, const wire_pose_batch *m)
{
    for (uint32_t i = 0; i < m->bodies.count && c->owed.count < (size_t)s->config.max_step_poses; i++)
        array_push(&c->owed, ((owed_pose){m->step, m->bodies.at[i]}));
}

typedef struct owner {
    service *service;
    session *session;
} owner;

static void owe_one(void *context, const wire_message *m)
{
    const owner *of = context;
    owe(of->service, of->session, &m->pose_batch);
}

/* What comes behind its end begins it anew: all of it is to come again. */
static void reopen(service *s, session *c)
{
    int64_t step = c->held.step;
    each_message(c->held.bytes.at, c->held.bytes.count, owe_one, &(owner){s, c});
    drop_held_step(c);
    c->held.step = step;
    c->published = s->lock_step.done;
}

static void note_bodies(void *context, const wire_message *m)
{
    pair_map *bodies = context;
    for (uint32_t i = 0; i < m->pose_batch.bodies.count; i++)
        pair_map_put(bodies, (uint64_t)m->pose_batch.bodies.at[i] + 1, 1);
}

/* How many bodies have no pose among those that are held, and should: settled by that, for this step and those before.
 */
static size_t settle_owed(session *c, int64_t step, int32_t *first)
{
    size_t lacking = 0, kept = 0;
    pair_map bodies;
    if (!c->owed.count) return 0;
    pair_map_init(&bodies);
    each_message(c->held.bytes.at, c->held.bytes.count, note_bodies, &bodies);
    for (size_t i = 0; i < c->owed.count; i++) {
        owed_pose o = c->owed.at[i];
        if (o.step > step) c->owed.at[kept++] = o;
        if (o.step != step || !pair_map_put(&bodies, (uint64_t)o.body + 1, 1)) continue;
        if (!lacking++) *first = o.body;
    }
    pair_map_free(&bodies);
    c->owed.count = kept;
    return lacking;
}

/* What is there is not taken for the whole: it has to be sent again. */
static bool end_step(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    if (!ends_in_its_name(m)) c->ended = m->sequence;
    if (c->held.broken) {
        drop_held_step(c);
        return refuse_step(s, from, m, WIRE_BAD_STEP,
            "step %" PRId64 ": some of its poses were refused: send all of it again", m->step);
    }
    int32_t first = 0;
    size_t lacking = settle_owed(c, m->step, &first);
    if (lacking && !ends_in_its_name(m)) {
        drop_held_step(c);
        return refuse_step(s, from, m, WIRE_BAD_STEP,
            "step %" PRId64 ": poses of %zu bodies were refused or replaced, and did not come again, the first is %d: "
            "send all of it again",
            m->step, lacking, first);
    }
    c->published = m->step;
    c->idle = ends_in_its_name(m);
    return true;
}

/* Nothing has come since it was ended: it is not ended by this, and nothing of it is sent again. */
static bool is_ended_twice(const service *s, const session *c, const wire_pose_batch *m)
{
    return !m->bodies.count && c->published > s->lock_step.done && m->sequence > c->ended;
}

bool steps_take(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    int64_t done = s->lock_step.done;
    if (!is_member(c) || !m->step) return false;
    if (m->step == done) return answer_again(s, c, from, m);
    if (m->step < done)
        return refuse_step(s, from, m, WIRE_BAD_STEP, "step %" PRId64 ": %" PRId64 " is done", m->step, done);
    bool in_its_name = ends_in_its_name(m);
    if (in_its_name && c->published > done) return true; /* it came in time after all */
    if (in_its_name) drop_held_step(c);
    if (c->held.step && m->step != c->held.step) {
        owe(s, c, m);
        return refuse_step(
            s, from, m, WIRE_BAD_STEP, "step %" PRId64 ": %" PRId64 " is not done", m->step, c->held.step);
    }
    bool is_copy = !m->bodies.count && m->sequence <= c->ended; /* it is not the end of what came since */
    if (is_copy || is_ended_twice(s, c, m)) {
        if (!is_copy) c->ended = m->sequence;
        metric_count(s->count.duplicates, 1);
        return true;
    }
    /* What the end has overtaken belongs to the step. */
    if (c->published > done && m->sequence > c->ended) reopen(s, c);
    c->held.step = m->step;
    if (m->simulation_ns > c->held.simulation_ns) c->held.simulation_ns = m->simulation_ns;
    if (!m->bodies.count) return end_step(s, c, from, m);
    wire_refusal why;
    c->held.broken |= is_mark(m);
    if (is_mark(m)) return true;
    size_t weight = weight_of(s, c, m);
    if (is_too_much(s, c, weight, &why)) {
        c->held.broken = true;
        c->published = c->published < done ? c->published : done; /* if it was ended */
        apply_reject(s, from, WIRE_POSE_BATCH, m->client, m->sequence, -1, &why);
    } else {
        hold_poses(c, m, weight);
    }
    return true;
}

void steps_refused(service *s, struct link *from, const wire_message *m)
{
    const wire_pose_batch *refused = &m->pose_batch;
    const session *c = m->kind == WIRE_POSE_BATCH ? session_find(s, refused->client) : NULL;
    if (!c || !is_member(c) || refused->step <= s->lock_step.done || !refused->bodies.count) return;
    if (c->held.step && c->held.step != refused->step) return; /* it would have been refused here, too */
    static const double nowhere[3] = {0}, unturned[4] = {1};
    const wire_message mark = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = refused->client,
            .sequence = STEP_IN_ITS_NAME,
            .step = refused->step,
            .bodies = {1, refused->bodies.at},
            .positions = {3, nowhere},
            .orientations = {4, unturned}}};
    record_message(s, &mark);
    standby_journal_message(s, from, &mark);
    apply_poses(s, from, &mark.pose_batch, true); /* as in a replay */
}

/* ---- when it is complete ---- */

bool steps_due(const service *s)
{
    if (!s->lock_step.members) return false;
    roll r = call_roll(s);
    return s->lock_step.asked_again || is_complete(s, &r);
}

static void apply_one(void *context, const wire_message *m)
{
    const owner *of = context;
    apply_poses_now(of->service, of->session, of->session->link, &m->pose_batch);
}

static void apply_held(service *s, session *c)
{
    digests before = c->done;
    each_message(c->held.bytes.at, c->held.bytes.count, apply_one, &(owner){s, c});
    c->done = c->held.digests;
    c->held.digests = before;
    drop_held_step(c);
}

/* What time it is in the step that all have published: the latest that any of them says; 0: nobody does. */
static int64_t simulation_of(const service *s, int64_t step)
{
    int64_t latest_ns = 0;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        if (is_member(c) && c->held.step <= step && c->held.simulation_ns > latest_ns)
            latest_ns = c->held.simulation_ns;
    }
    return latest_ns;
}

uint64_t steps_effort(const service *s)
{
    uint64_t poses = 0;
    if (!s->lock_step.members) return 0;
    roll r = call_roll(s);
    for (size_t i = 0; i < s->sessions.count && is_complete(s, &r); i++) {
        const session *c = s->sessions.at[i];
        if (is_member(c) && c->held.step <= r.least) poses += c->held.poses;
    }
    return A_POSE * poses;
}

/* A member that is ahead of the others keeps what it has published. */
void steps_complete(service *s)
{
    s->lock_step.asked_again = false;
    if (!s->lock_step.members) return;
    roll r = call_roll(s);
    if (!is_complete(s, &r)) return;
    s->lock_step.missing = 0;
    int64_t simulation_ns = simulation_of(s, r.least);
    apply_note_simulation(&s->simulation, s->tick, simulation_ns);
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (!is_member(c)) continue;
        apply_forget_refused(c, s->tick, r.least);
        c->done.list.count = 0;
        if (c->held.step <= r.least) apply_held(s, c);
        vertices_step(s, c, r.least);
        c->missed = c->idle;
        s->lock_step.missing += c->missed;
        c->step = (step_mark){r.least, s->tick};
        apply_note_simulation(&c->simulation, s->tick, simulation_ns);
        c->stepped = true;
    }
    world_part_moves(s->world);
    s->latest_step = (step_mark){r.least, s->tick};
    s->lock_step.done = r.least;
    s->lock_step.begun = true;
    s->lock_step.since_ns = 0;
    metric_count(s->count.steps, 1);
}

/* ---- when all of it is reported ---- */

static bool has_pending(const service *s, const session *c)
{
    return world_pending_of(s->world, (uint64_t)c->client) > 0;
}

/* Of those that are in lock-step with each other all are answered in one tick. */
void steps_settle(service *s)
{
    s->lock_step.pending = false;
    for (size_t i = 0; i < s->sessions.count; i++)
        s->lock_step.pending |= is_member(s->sessions.at[i]) && has_pending(s, s->sessions.at[i]);
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        c->withheld = c->stepped && (is_member(c) ? s->lock_step.pending : has_pending(s, c));
        if (!c->withheld) c->answered_step = c->step.step;
    }
}

/* ---- who misses it ---- */

static void report_members(service *s, const char *text)
{
    log_warning("lock-step: %s", text);
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        const wire_message m = {.kind = WIRE_REJECT,
            .reject = {WIRE_VERSION, c->client, .epoch = s->epoch, .kind = WIRE_POSE_BATCH, .object = -1,
                .reason = WIRE_STEP_MISSED, .text = text}};
        if (is_member(c)) c->link->ops->publish(c->link, &m);
    }
}

static void report_missing(service *s, bool goes_on)
{
    char text[512], others[48] = "";
    const session *first = NULL;
    size_t missing = 0;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        if (!is_member(c) || c->published > s->lock_step.done || c->idle) continue;
        metric_count(s->count.steps_missed, 1);
        if (!missing++) first = c;
    }
    if (!first) return;
    if (missing > 1) snprintf(others, sizeof others, " and %zu others", missing - 1);
    snprintf(text, sizeof text, "step %" PRId64 ": client %016" PRIx64 " \"%s\"%s did not publish it within %g s: %s",
        s->lock_step.waited, (uint64_t)first->client, first->name, others, s->config.step_timeout,
        goes_on ? "it is done without" : "all wait on");
    report_members(s, text);
}

static void miss(service *s, session *c)
{
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {
            .version = WIRE_VERSION, .client = c->client, .sequence = STEP_IN_ITS_NAME, .step = s->lock_step.waited}};
    c->idle = true;
    record_message(s, &m);
    standby_journal_message(s, c->link, &m);
    apply_poses(s, c->link, &m.pose_batch, true); /* as in a replay */
}

static bool begin_waiting(service *s, const roll *r)
{
    if (!r->ready || is_complete(s, r)) {
        s->lock_step.since_ns = 0;
        return false;
    }
    s->lock_step.waited = r->next;
    if (s->lock_step.since_ns) return true; /* also if who waited for another step has gone */
    s->lock_step.since_ns = s->monotonic_ns;
    s->lock_step.reported = false;
    return true;
}

static bool takes_long(const service *s)
{
    return s->config.step_timeout > 0 &&
           s->monotonic_ns - s->lock_step.since_ns >= (int64_t)(1e9 * s->config.step_timeout);
}

void steps_watch(service *s)
{
    if (!s->lock_step.members) return;
    roll r = call_roll(s);
    if (!begin_waiting(s, &r)) return;
    bool late = takes_long(s), goes_on = strcmp(s->config.step_policy, "go_on") == 0;
    if (!all_are_there(s, &r)) {
        char text[128];
        snprintf(text, sizeof text, "step %" PRId64 " waits: %zu of %zu clients are there", s->lock_step.waited,
            s->lock_step.members, r.wanted);
        if (late && !s->lock_step.reported) report_members(s, text);
        s->lock_step.reported |= late;
        return;
    }
    if (late && !s->lock_step.reported) report_missing(s, goes_on);
    s->lock_step.reported |= late;
    for (size_t i = 0; goes_on && i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (is_member(c) && c->published <= s->lock_step.done && (late || c->idle)) miss(s, c);
    }
}

int64_t steps_next_ns(const service *s)
{
    if (!s->lock_step.since_ns || s->lock_step.reported || !(s->config.step_timeout > 0)) return INT64_MAX;
    return s->lock_step.since_ns + (int64_t)(1e9 * s->config.step_timeout);
}

/* ---- a recording that begins in the middle ---- */

static void record_held_poses(void *context, const wire_message *m)
{
    record_message(context, m);
}

void steps_began(service *s, int64_t done)
{
    s->lock_step.begun = true;
    s->lock_step.done = done;
}

/* In the client's name. Commands of a tick are sorted by their sequences. */
static void record_word(service *s, session *c, int64_t sequence, int64_t step, const int32_t *body)
{
    const double nowhere[3] = {0}, unturned[4] = {1};
    uint32_t bodies = body != NULL;
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = c->client,
            .sequence = sequence,
            .step = step,
            .simulation_ns = c->held.simulation_ns,
            .bodies = {bodies, body},
            .positions = {3 * bodies, nowhere},
            .orientations = {4 * bodies, unturned}}};
    record_message(s, &m);
}

/* Of a step that is sent again: as if what was replaced had been elsewhere. Of a later one: it is refused again. */
static void record_owed(service *s, session *c)
{
    bool again = false;
    for (size_t i = 0; i < c->owed.count; i++) {
        const owed_pose *o = &c->owed.at[i];
        bool is_of_this = c->ended && o->step == c->held.step && o->step > s->lock_step.done;
        if (is_of_this || o->step > c->held.step)
            record_word(s, c, is_of_this ? c->ended - 1 : STEP_IN_ITS_NAME - 1, o->step, &o->body);
        again |= is_of_this;
    }
    if (again) record_word(s, c, c->ended, c->held.step, NULL);
}

void steps_record(service *s, session *c)
{
    if (!is_member(c)) return;
    const int32_t any = 0;
    int64_t last = c->ended ? c->ended : c->held.newest ? c->held.newest : 1;
    record_owed(s, c);
    each_message(c->held.bytes.at, c->held.bytes.count, record_held_poses, s);
    if (c->held.broken) record_word(s, c, STEP_IN_ITS_NAME, c->held.step, &any);
    if (c->published > s->lock_step.done) record_word(s, c, last, c->held.step, NULL);
}
