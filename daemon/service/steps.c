/* steps: lock-step of simulators in several processes. Poses of a member that carry a step wait here; an empty batch
 * with the step's number ends what it publishes of it. When every member has ended a step, it is applied as a whole,
 * and one tick follows, in which each of them is answered. Tick thread.
 *
 * What is applied when follows from the messages and from where the ticks end alone, so that a replay does the same: a
 * member that misses a step by the clock is let miss it by a message in its name, which is recorded like those that
 * come. */
#include "service.h"
#include "standby.h"

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

static void drop_held(session *c)
{
    c->held.step = 0;
    c->held.bytes.count = c->held.poses = 0;
}

void steps_free(session *c)
{
    array_free(&c->held.bytes);
}

void steps_join(service *s, session *c, int32_t lock_step)
{
    bool was = is_member(c);
    c->lock_step = lock_step;
    if (was == is_member(c)) return;
    drop_held(c);
    c->idle = false;
    c->published = s->lock_step.done;
    s->lock_step.since_ns = 0; /* whoever comes has as much time as the others */
    s->lock_step.members += was ? (size_t)-1 : 1;
    if (!s->lock_step.members) s->lock_step = (struct lock_step){.members = 0}; /* others may count from the start */
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
    return s->lock_step.members && r->ready == s->lock_step.members && all_are_there(s, r);
}

/* ---- what is published ---- */

__attribute__((format(printf, 5, 6))) static bool refuse(
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

static void hold(session *c, const wire_pose_batch *poses)
{
    const wire_message m = {.kind = WIRE_POSE_BATCH, .pose_batch = *poses};
    size_t size = wire_lcm_size(&m), at = c->held.bytes.count;
    array_reserve(&c->held.bytes, at + sizeof size + size);
    memcpy(c->held.bytes.at + at, &size, sizeof size);
    wire_lcm_encode(&m, c->held.bytes.at + at + sizeof size, size);
    c->held.bytes.count += sizeof size + size;
    c->held.poses += poses->bodies.count;
}

/* The answer may have been lost, or comes late for who missed the step. */
static bool answer_again(service *s, session *c, const wire_pose_batch *m)
{
    metric_count(s->count.duplicates, 1);
    if (m->bodies.count) return true;
    c->idle = false;
    c->stepped = s->lock_step.asked_again = true;
    return true;
}

bool steps_take(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    int64_t done = s->lock_step.done;
    if (!is_member(c) || !m->step) return false;
    if (m->step == done) return answer_again(s, c, m);
    if (m->step < done)
        return refuse(s, from, m, WIRE_BAD_STEP, "step %" PRId64 ": %" PRId64 " is done", m->step, done);
    bool in_its_name = m->sequence == STEP_IN_ITS_NAME;
    if (in_its_name && c->published > done) return true; /* it came in time after all */
    if (in_its_name) drop_held(c);
    if (c->held.step && m->step != c->held.step)
        return refuse(s, from, m, WIRE_BAD_STEP, "step %" PRId64 ": %" PRId64 " is not done", m->step, c->held.step);
    if (c->published > done) { /* sent again: it stands for what was sent */
        drop_held(c);
        c->published = done;
    }
    c->held.step = m->step;
    if (!m->bodies.count) {
        c->published = m->step;
        c->idle &= in_its_name;
        return true;
    }
    wire_refusal why;
    if (apply_limit(s, c->held.poses + m->bodies.count - 1, s->config.max_step_poses, "max_step_poses", &why))
        apply_reject(s, from, WIRE_POSE_BATCH, m->client, m->sequence, -1, &why);
    else
        hold(c, m);
    return true;
}

/* ---- when it is complete ---- */

bool steps_due(const service *s)
{
    if (!s->lock_step.members) return false;
    roll r = call_roll(s);
    return s->lock_step.asked_again || is_complete(s, &r);
}

static void each_held(service *s, session *c, void (*call)(service *s, session *c, const wire_message *m))
{
    wire_memory *memory = c->held.bytes.count ? wire_memory_create() : NULL;
    for (size_t at = 0, size; at < c->held.bytes.count; at += sizeof size + size) {
        wire_message m;
        wire_refusal why;
        memcpy(&size, c->held.bytes.at + at, sizeof size);
        wire_memory_reset(memory);
        if (wire_lcm_decode(c->held.bytes.at + at + sizeof size, size, memory, &m, &why) == WIRE_OK) call(s, c, &m);
    }
    wire_memory_destroy(memory);
}

static void apply_one(service *s, session *c, const wire_message *m)
{
    apply_poses_now(s, c, c->link, &m->pose_batch);
}

/* A member that is ahead of the others keeps what it has published. */
void steps_complete(service *s)
{
    s->lock_step.asked_again = false;
    if (!s->lock_step.members) return;
    roll r = call_roll(s);
    if (!is_complete(s, &r)) return;
    s->lock_step.missing = 0;
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (!is_member(c)) continue;
        if (c->held.step <= r.least) {
            each_held(s, c, apply_one);
            drop_held(c);
        }
        s->lock_step.missing += c->idle;
        c->step = (step_mark){r.least, s->tick};
        c->stepped = true;
    }
    s->latest_step = (step_mark){r.least, s->tick};
    s->lock_step.done = r.least;
    s->lock_step.begun = true;
    s->lock_step.since_ns = 0;
    metric_count(s->count.steps, 1);
}

/* ---- who misses it ---- */

static void tell_members(service *s, const char *text)
{
    log_warning("lock-step: %s", text);
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        const wire_message m = {.kind = WIRE_REJECT,
            .reject = {WIRE_VERSION, c->client, 0, s->epoch, WIRE_POSE_BATCH, -1, (uint8_t)WIRE_STEP_MISSED, text}};
        if (is_member(c)) c->link->ops->publish(c->link, &m);
    }
}

static void tell_missing(service *s, bool goes_on)
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
    tell_members(s, text);
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
    if (s->lock_step.since_ns && s->lock_step.waited == r->next) return true;
    s->lock_step.waited = r->next;
    s->lock_step.since_ns = s->monotonic_ns;
    s->lock_step.told = false;
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
        if (late && !s->lock_step.told) tell_members(s, text);
        s->lock_step.told |= late;
        return;
    }
    if (late && !s->lock_step.told) tell_missing(s, goes_on);
    s->lock_step.told |= late;
    for (size_t i = 0; goes_on && i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (is_member(c) && c->published <= s->lock_step.done && (late || c->idle)) miss(s, c);
    }
}

int64_t steps_next_ns(const service *s)
{
    if (!s->lock_step.since_ns || s->lock_step.told || !(s->config.step_timeout > 0)) return INT64_MAX;
    return s->lock_step.since_ns + (int64_t)(1e9 * s->config.step_timeout);
}

/* ---- a recording that begins in the middle ---- */

static void record_one(service *s, session *c, const wire_message *m)
{
    (void)c;
    record_message(s, m);
}

void steps_record(service *s, session *c)
{
    each_held(s, c, record_one);
    if (!is_member(c) || c->published <= s->lock_step.done) return;
    record_message(
        s, &(wire_message){.kind = WIRE_POSE_BATCH,
               .pose_batch = {.version = WIRE_VERSION, .client = c->client, .sequence = 1, .step = c->published}});
}
