/* poses: batches of poses to the world, by arrays: first who is meant, then which of them are newer than what is known,
 * then all of these at once. Messages have been checked by the link (wire_check). Tick thread. */
#include "clients.h"
#include "commands.h"
#include "models.h"
#include "service.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define UNKNOWN UINT32_MAX

void poses_free(service *s)
{
    array_free(&s->posing.owned);
    array_free(&s->posing.ids);
    array_free(&s->posing.places);
    array_free(&s->posing.sequences);
    array_free(&s->posing.left_out);
}

static void make_room_for_poses(posing *p, size_t count)
{
    array_reserve(&p->owned, count);
    array_reserve(&p->ids, count);
    array_reserve(&p->places, count);
    array_reserve(&p->sequences, count);
    array_reserve(&p->left_out, count);
}

/* Clients publish their bodies, or parts of them, in the order of making. */
static bool is_run(session *c, const wire_pose_batch *m, size_t first)
{
    size_t count = m->bodies.count;
    uint32_t none = 0;
    if (first >= c->bodies.count || count > c->bodies.count - first ||
        memcmp(c->rows.numbers.at + first, m->bodies.at, count * sizeof m->bodies.at[0]) != 0)
        return false;
    for (size_t i = 0; i < count; i++) none |= c->rows.world_ids.at[first + i] == WORLD_NONE;
    return !none;
}

static bool find_run(session *c, const wire_pose_batch *m, size_t *first)
{
    if (!m->bodies.count) return false;
    *first = c->rows.next;
    if (*first >= c->bodies.count || c->rows.numbers.at[*first] != m->bodies.at[0]) {
        const owned_body *b = session_body(c, m->bodies.at[0]);
        if (!b) return false;
        *first = (size_t)(b - c->bodies.at);
    }
    if (!is_run(c, m, *first)) return false;
    c->rows.next = *first + m->bodies.count;
    return true;
}

/* Fills `owned`, unless they are a run. The number of bodies that the client has never told of. */
static size_t find_bodies(service *s, session *c, const wire_pose_batch *m)
{
    posing *p = &s->posing;
    size_t next = 0, unknown = 0;
    make_room_for_poses(p, m->bodies.count);
    p->is_run = c && find_run(c, m, &p->first);
    if (p->is_run) return 0;
    for (uint32_t i = 0; i < m->bodies.count; i++) {
        if (c && next < c->bodies.count && c->bodies.at[next].number == m->bodies.at[i]) { /* in the order of making */
            p->owned.at[i] = (uint32_t)next++;
            continue;
        }
        const owned_body *b = c ? session_body(c, m->bodies.at[i]) : NULL;
        p->owned.at[i] = b ? (uint32_t)(b - c->bodies.at) : UNKNOWN;
        next = b ? p->owned.at[i] + 1 : next;
        unknown += !b;
    }
    return unknown;
}

typedef struct tally { /* of what is not carried out; first: the body's number */
    uint32_t unknown, older, late;
    uint32_t waiting; /* for a build: kept */
    int32_t first_unknown, first_older;
    int64_t newest; /* sequence that those are late for; 0: none is */
} tally;

/* Of a run of which all are newer, as they mostly are. */
static bool choose_run(posing *p, session *c, const wire_pose_batch *m)
{
    size_t count = m->bodies.count;
    int64_t *last = c->rows.sequences.at + p->first, newest = 0;
    for (size_t i = 0; i < count; i++) newest = last[i] > newest ? last[i] : newest;
    if (newest >= m->sequence) return false;
    memcpy(p->sequences.at, last, count * sizeof *last);
    for (size_t i = 0; i < count; i++) last[i] = m->sequence;
    return true;
}

/* The newest sequence wins. The number of those that are newer. */
static size_t choose_newer(service *s, session *c, const wire_pose_batch *m, tally *t)
{
    posing *p = &s->posing;
    size_t chosen = 0;
    if (p->is_run && choose_run(p, c, m)) return m->bodies.count;
    for (uint32_t i = 0; p->is_run && i < m->bodies.count; i++) p->owned.at[i] = (uint32_t)p->first + i;
    p->is_run = false;
    for (uint32_t i = 0; i < m->bodies.count; i++) {
        uint32_t at = p->owned.at[i], id = at == UNKNOWN ? WORLD_NONE : c->rows.world_ids.at[at];
        int64_t *last = id == WORLD_NONE ? NULL : &c->rows.sequences.at[at];
        if (!last && c && pending_keeps_pose(s, c, m, i)) {
            t->waiting++;
        } else if (!last) {
            if (!t->unknown++) t->first_unknown = m->bodies.at[i];
        } else if (m->sequence <= *last) {
            t->late++;
            if (*last > t->newest && *last != STEP_IN_ITS_NAME) t->newest = *last;
        } else {
            p->ids.at[chosen] = id;
            p->places.at[chosen] = i;
            p->sequences.at[chosen++] = *last;
            *last = m->sequence;
        }
    }
    return chosen;
}

/* Those that the world leaves out, because they are older than what it has by their stamps, never came. */
static void move(service *s, session *c, const wire_pose_batch *m, size_t chosen, tally *t)
{
    posing *p = &s->posing;
    const world_poses poses = {.ids = p->is_run ? c->rows.world_ids.at + p->first : p->ids.at,
        .places = chosen < m->bodies.count ? p->places.at : NULL,
        .count = chosen,
        .positions = m->positions.at,
        .orientations = m->orientations.at,
        .linear = m->linear.count ? m->linear.at : NULL,
        .angular = m->angular.count ? m->angular.at : NULL,
        .teleports = m->teleports.count ? m->teleports.at : NULL,
        .stamp_ns = m->stamp_ns};
    t->older = (uint32_t)world_move_bodies(s->world, &poses, p->left_out.at);
    for (uint32_t k = 0; k < t->older; k++) {
        uint32_t i = p->left_out.at[k], place = p->is_run ? i : p->places.at[i];
        size_t row = p->is_run ? p->first + i : p->owned.at[place];
        c->rows.sequences.at[row] = p->sequences.at[i];
        if (k == 0) t->first_older = m->bodies.at[place];
    }
}

/* Of a body that has waited and is there now: it has not moved. */
void poses_give(service *s, session *c, const owned_body *b, const kept_pose *p)
{
    static const uint8_t teleports[1] = {1};
    int64_t *last = session_pose_sequence(c, b);
    const world_poses poses = {.ids = &b->world_id,
        .count = 1,
        .positions = p->position,
        .orientations = p->orientation,
        .linear = p->has_linear ? p->linear : NULL,
        .angular = p->has_angular ? p->angular : NULL,
        .teleports = teleports,
        .stamp_ns = p->stamp_ns};
    if (p->sequence <= *last) return;
    make_room_for_poses(&s->posing, 1);
    world_move_bodies(s->world, &poses, s->posing.left_out.at);
    *last = p->sequence;
}

/* ---- as many as a tick takes ---- */

/* Units of putting bodies anew, see world_effort: at most, and at least, however long they take. */
static const uint64_t ENOUGH = 12000000, ENOUGH_WIDE = 4000000, ENOUGH_LEAST = 2000000;
static const uint32_t MANY = 16384,
                      MANY_MORE = 2048; /* poses of a batch: a tick's worth of any bodies; behind others */

/* What takes about as long as a slice, as far as ticks have shown. Of bodies of many shapes more is to be done than to
 * put them. */
static uint64_t enough(const service *s)
{
    uint64_t most = world_has_wide(s->world) ? ENOUGH_WIDE : ENOUGH;
    double units = 1e3 * s->config.slice_us / fmax(s->effort_unit_ns, 1);
    if (!(s->config.slice_us > 0) || units >= (double)most) return most;
    return units > (double)ENOUGH_LEAST ? (uint64_t)units : ENOUGH_LEAST;
}

bool poses_are_enough(const service *s)
{
    return world_effort(s->world) + s->inbox.effort >= enough(s);
}

/* Clients publish their bodies in the order of making, as a rule: `next` is looked at first. */
static uint64_t effort_of(const service *s, session *c, const wire_pose_batch *m, uint32_t i, size_t *next)
{
    size_t at = *next;
    if (at >= c->bodies.count || c->bodies.at[at].number != m->bodies.at[i]) {
        const owned_body *b = session_body(c, m->bodies.at[i]);
        if (!b) return 0;
        at = (size_t)(b - c->bodies.at);
    }
    *next = at + 1;
    const double *p = m->positions.at + 3 * (size_t)i, *q = m->orientations.at + 4 * (size_t)i;
    const pose to = {{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
    return world_effort_of(s->world, c->rows.world_ids.at[at], &to);
}

/* Of members in lock-step poses are only kept. */
size_t poses_room(service *s, const wire_pose_batch *m, uint64_t *work)
{
    uint32_t count = m->bodies.count, i = 0;
    session *c = session_find(s, m->client);
    uint64_t before = world_effort(s->world) + s->inbox.effort, sum = 0;
    bool is_kept = c && c->lock_step > 0 && m->step;
    bool counts = world_has_wide(s->world) || count > (before ? MANY_MORE : MANY);
    if (!c || is_kept || !counts || m->extensions.count) return count; /* joints are not parted */
    for (size_t next = 0; i < count; i++) {
        uint64_t effort = effort_of(s, c, m, i, &next);
        if (i && effort && before + sum + effort > enough(s)) break;
        sum += effort;
    }
    *work = sum;
    return i;
}

/* One that waits for the commands of this tick. */
static void put_into_inbox(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    size_t next = 0;
    for (uint32_t i = 0; c && i < m->bodies.count; i++) s->inbox.effort += effort_of(s, c, m, i, &next);
    inbox_put(s, from, &(wire_message){.kind = WIRE_POSE_BATCH, .pose_batch = *m});
}

void apply_forget_refused(session *c, int64_t tick, int64_t step)
{
    if (step != c->step.step && tick != c->step.tick) c->refused = (refused_poses){0};
}

/* The answer to the step says so, too: a Reject may come later than that. */
void apply_count_refused(session *c, uint32_t more, wire_reason reason)
{
    uint32_t room = INT32_MAX - (uint32_t)c->refused.count;
    if (more && !c->refused.count) c->refused.reason = (uint8_t)reason;
    c->refused.count += (int32_t)(more < room ? more : room);
}

static void report_of_poses(service *s, struct link *from, const wire_pose_batch *m, const tally *t)
{
    wire_refusal why;
    if (t->late) metric_count(s->count.late_poses, t->late);
    if (t->unknown) {
        why.reason = WIRE_UNKNOWN_BODY;
        snprintf(why.text, sizeof why.text, "%u of %u bodies are not announced, the first is %d", t->unknown,
            m->bodies.count, t->first_unknown);
        apply_reject(s, from, WIRE_POSE_BATCH, m->client, m->sequence, t->first_unknown, &why);
    }
    if (t->older) {
        why.reason = WIRE_OLD_POSE;
        snprintf(why.text, sizeof why.text,
            "stamp_ns: %u of %u bodies have a newer pose already, the first is %d; a teleport may go back in time",
            t->older, m->bodies.count, t->first_older);
        apply_reject(s, from, WIRE_POSE_BATCH, m->client, m->sequence, t->first_older, &why);
    }
}

/* A simulator that begins anew counts from the start, so that a later tick's step may be lower. Kept beyond the tick: a
 * snapshot tells the step that the world is at, whether a pose came just then or not. */
static void note_step(step_mark *last, int64_t tick, int64_t step)
{
    if (step && (last->tick != tick || step >= last->step)) *last = (step_mark){step, tick};
}

void poses_note_step(service *s, session *c, int64_t step)
{
    note_step(&s->latest_step, s->tick, step);
    apply_forget_refused(c, s->tick, step);
    note_step(&c->step, s->tick, step);
    s->stepped = c->stepped = true;
}

/* As with steps: what time it is stays known beyond the tick, and a simulation that begins anew goes back. */
void apply_note_simulation(simulation_mark *last, int64_t tick, int64_t simulation_ns)
{
    if (simulation_ns && (last->tick != tick || simulation_ns > last->now_ns))
        *last = (simulation_mark){simulation_ns, tick};
}

/* A network has overtaken them, which the client knows; or they are of a new process under the same id whose clock was
 * set back, and poses of the one before came last, with nothing that would have told of it. This tells it, as an older
 * Client would (apply.c): it goes on from there. */
static void report_newest(const service *s, struct link *to, int64_t client, int64_t newest)
{
    const wire_message m = {
        .kind = WIRE_ACK, .ack = {WIRE_VERSION, client, s->epoch, .sequences = {newest != 0, &newest}}};
    if (newest) to->ops->publish(to, &m); /* no tick may come of them */
}

/* The bodies have been found. */
static void apply_poses_of(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    tally t = {.first_unknown = -1, .first_older = -1};
    if (m->stamp_ns > s->latest_pose_ns) s->latest_pose_ns = m->stamp_ns;
    note_step(&s->latest_step, s->tick, m->step);
    if (c && m->step) apply_forget_refused(c, s->tick, m->step);
    if (c) note_step(&c->step, s->tick, m->step);
    apply_note_simulation(&s->simulation, s->tick, m->simulation_ns);
    if (c) apply_note_simulation(&c->simulation, s->tick, m->simulation_ns);
    if (m->step) s->stepped = true;
    if (c && m->step) c->stepped = true;
    if (c && m->stamp_ns > c->latest_pose_ns) c->latest_pose_ns = m->stamp_ns;
    if (c) c->pose_count += m->bodies.count;
    move(s, c, m, choose_newer(s, c, m, &t), &t);
    report_newest(s, from, m->client, t.newest);
    if (c && m->step) apply_count_refused(c, t.unknown + t.waiting, WIRE_UNKNOWN_BODY);
    if (c && m->step) apply_count_refused(c, t.older, WIRE_OLD_POSE);
    report_of_poses(s, from, m, &t);
}

void apply_poses_now(service *s, session *c, struct link *from, const wire_pose_batch *m)
{
    find_bodies(s, c, m);
    apply_poses_of(s, c, from, m);
}

/* A batch waits for the commands of this tick, once, if some of its client are among them or it has a body that is not
 * known yet. */
void apply_poses(service *s, struct link *from, const wire_pose_batch *m, bool may_wait)
{
    session *c = session_find(s, m->client);
    bool is_mark = m->sequence == STEP_IN_ITS_NAME && m->bodies.count; /* it comes before what waits */
    bool may = may_wait && !(c && is_mark);
    if (may && (!c || c->commands_tick == s->tick || !models_are_known(c, m))) {
        put_into_inbox(s, c, from, m);
        return;
    }
    wire_pose_batch whole;
    models_expand(s, c, from, m, &whole);
    if (find_bodies(s, c, &whole) && may) { /* what was refused of it has been told */
        put_into_inbox(s, c, from, &whole);
        return;
    }
    if (c && m->sequence != STEP_IN_ITS_NAME) c->last_seen_ns = s->monotonic_ns;
    if (m->extensions.count && !whole.bodies.count) return; /* all of it was refused: no end of a step */
    if (c && steps_take(s, c, from, &whole)) return;
    apply_poses_of(s, c, from, &whole);
}
