/* move: poses come, by the million. Tick thread.
 *
 * Almost all of them are of calm bodies, in their regions, that have moved since the last tick before: of these a pose
 * looks at two cache lines of the body and writes one. */
#include "calm.h"
#include "state.h"

#include <stddef.h>
#include <string.h>

/* Given, or to be estimated from the motion since `before` where both are stamped. */
static inline void set_speed(body *b, const vec3 *linear, const vec3 *angular)
{
    bool stamped = b->stamp_ns && b->before_ns && b->stamp_ns > b->before_ns;
    b->speed = stamped ? SPEED_ESTIMATED : SPEED_NONE;
    if (!linear && !angular) return;
    b->speed = SPEED_GIVEN;
    b->linear = linear ? *linear : VEC_ZERO;
    b->angular = angular ? *angular : VEC_ZERO;
}

/* Of one that has not moved since the last tick. */
static inline void keep_before(const world *w, body *b)
{
    if (b->glided == w->round) return;
    b->before = b->pose;
    b->before_ns = b->stamp_ns;
}

/* A calm body that stays in its region: there is nothing that a tick could do about it. `to` is settled. */
static inline bool glide(const world *w, body *b, const pose *to, int64_t stamp_ns)
{
    if (!b->is_calm || b->dirty || !(calm_holds(b, to) || calm_find_again(b, to))) return false;
    if (b->glided != w->round) {
        b->before = b->pose;
        b->before_ns = b->stamp_ns;
        b->glided = w->round;
    }
    b->behind = true;
    b->pose = *to;
    b->stamp_ns = stamp_ns;
    return true;
}

static void move(world *w, uint32_t id, const pose *to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular)
{
    body *b = &w->bodies.at[id];
    w->figures.moves++;
    if (may_glide(w) && glide(w, b, to, stamp_ns)) {
        w->some_glided = true;
    } else {
        w->changed = true;
        if (b->moved)
            body_pass(w, b);
        else
            keep_before(w, b);
        if (!b->is_calm) b->held = false;
        b->pose = *to; /* settled */
        b->stamp_ns = stamp_ns;
        b->posed = true;
        b->moved = true;
        if (!b->dirty) {
            array_push(&w->dirty, id);
            w->effort += b->effort;
        }
        b->dirty = true;
    }
    set_speed(b, linear, angular);
}

world_status world_move_body(world *w, uint32_t id, pose to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    to.q = quat_settled(to.q);
    move(w, id, &to, stamp_ns, linear, angular);
    return WORLD_OK;
}

static void teleport(world *w, uint32_t id, const pose *to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular)
{
    body *b = &w->bodies.at[id];
    body_settle_shapes(w, b);
    past_stands(w, id);
    b->is_calm = false; /* it is a tick's business */
    move(w, id, to, stamp_ns, linear, angular);
    b->before = b->pose;
    b->before_ns = b->stamp_ns;
    b->moved = false;
    b->glided = 0;
    b->passed.count = 0;
    if (b->speed == SPEED_ESTIMATED) b->speed = SPEED_NONE;
    b->teleported = b->detours = true;
    b->teleport_tick = w->teleport_tick = w->figures.ticks + 1;
}

world_status world_teleport_body(
    world *w, uint32_t id, pose to, int64_t stamp_ns, const vec3 *linear, const vec3 *angular)
{
    if (!body_is(w, id)) return WORLD_UNKNOWN_ID;
    to.q = quat_settled(to.q);
    teleport(w, id, &to, stamp_ns, linear, angular);
    return WORLD_OK;
}

enum { AHEAD = 12 };

/* Bodies of a large world lie beyond the caches: those that come next are asked for while these are worked on. */
static inline void fetch_to_move(const world *w, uint32_t id)
{
    if (id >= w->bodies.count) return;
    const body *b = &w->bodies.at[id];
    __builtin_prefetch(&b->pose, 1);
    __builtin_prefetch(&b->region, 1);
    __builtin_prefetch(&b->before, 1);
}

static inline vec3 vec_of(const double *v)
{
    return vec(v[0], v[1], v[2]);
}

static void move_one(world *w, const world_poses *p, size_t i, size_t at, const pose *to)
{
    vec3 linear, angular;
    if (p->linear) linear = vec_of(p->linear + 3 * at);
    if (p->angular) angular = vec_of(p->angular + 3 * at);
    const vec3 *v = p->linear ? &linear : NULL, *spin = p->angular ? &angular : NULL;
    if (p->teleports && p->teleports[at])
        teleport(w, p->ids[i], to, p->stamp_ns, v, spin);
    else
        move(w, p->ids[i], to, p->stamp_ns, v, spin);
}

/* A stamp that is as much newer than the last tick is of a clock that has been set back since, or is wrong. */
static const int64_t AHEAD_NS = 2000000000;

/* A motion back in time is none. But nothing would be taken for a body whose stamp is ahead until that time comes. Held
 * against the last tick, as a replay does. When it was announced is no time of its pose, and may be by another clock
 * than those of its poses, a simulator's: the first that is older takes its place, and then there was no stamp. */
static inline bool is_older(const world *w, body *b, const world_poses *p, size_t at)
{
    if (!p->stamp_ns || p->stamp_ns >= b->stamp_ns || (p->teleports && p->teleports[at])) return false;
    if (b->stamp_ns != b->announced_ns) return b->stamp_ns <= w->last_tick_ns + AHEAD_NS;
    b->stamp_ns = 0;
    return false;
}

/* Written down for `glide_on`: the bits and the byte behind body.glided, as one number. */
enum { STATE_AT = offsetof(body, glided) + sizeof(uint64_t) };
_Static_assert(offsetof(body, speed) == STATE_AT + 1, "the bits fill one byte");

static inline uint16_t state_of(const body *b)
{
    uint16_t state;
    memcpy(&state, (const char *)b + STATE_AT, sizeof state);
    return state;
}

/* What has to be so, of a body that has glided since the last tick before, and what is looked at of it. */
static const body gliding = {.used = true, .is_calm = true, .behind = true, .speed = SPEED_ESTIMATED};
static const body looked_at = {
    .used = true, .ghost = true, .dirty = true, .is_calm = true, .behind = true, .speed = UINT8_MAX};

/* As quat_is_settled, with the squares added up in another order, where that makes no difference. */
static inline __attribute__((always_inline)) bool is_settled(const double *q, const calm_wide *of)
{
    calm_wide squares = *of * *of;
    double norm2 = (squares[0] + squares[2]) + (squares[1] + squares[3]);
    return fabs(norm2 - 1) <= 0x1p-51 || quat_is_settled((quat){q[0], q[1], q[2], q[3]});
}

/* How many of these poses, from that one on, are of bodies that are calm, have glided since the last tick before, by
 * stamps, and do not go back in time: here, what `glide` and `set_speed` would do comes to writing the pose down. The
 * last one is left to these, since a position is read as four numbers. */
static inline __attribute__((always_inline)) size_t glide_run(world *w, const world_poses *p, size_t from)
{
    body *bodies = w->bodies.at;
    const uint32_t *ids = p->ids;
    const int64_t stamp_ns = p->stamp_ns;
    const uint64_t round = w->round;
    const size_t last = p->count - 1, known = w->bodies.count;
    const uint16_t must = state_of(&gliding), look = state_of(&looked_at);
    const double *position = p->positions + 3 * from, *turn = p->orientations + 4 * from;
    size_t i = from;
    for (; i < last; i++, position += 3, turn += 4) {
        size_t ahead = ids[i + AHEAD < last ? i + AHEAD : last];
        body *b = &bodies[ids[i]];
        calm_wide to, q;
        if (ahead < known) {
            __builtin_prefetch(&bodies[ahead].pose, 1);
            __builtin_prefetch(&bodies[ahead].region);
        }
        if (ids[i] >= known || (state_of(b) & look) != must || b->glided != round || stamp_ns < b->stamp_ns) break;
        memcpy(&to, position, sizeof to);
        memcpy(&q, turn, sizeof q);
        if (!is_settled(turn, &q) || !calm_holds_at(&b->region, &to, &q)) break;
        memcpy(&b->pose.p, position, sizeof b->pose.p);
        memcpy(&b->pose.q, &q, sizeof b->pose.q);
        b->stamp_ns = stamp_ns;
    }
    w->figures.moves += i - from;
    w->some_glided |= i > from;
    return i - from;
}

static size_t glide_plain(world *w, const world_poses *p, size_t from)
{
    return glide_run(w, p, from);
}

#if defined(__x86_64__)

__attribute__((target("avx2"))) static size_t glide_avx2(world *w, const world_poses *p, size_t from)
{
    return glide_run(w, p, from);
}

static inline size_t glide_on(world *w, const world_poses *p, size_t from)
{
    return (__builtin_cpu_supports("avx2") ? glide_avx2 : glide_plain)(w, p, from);
}

#else

static inline size_t glide_on(world *w, const world_poses *p, size_t from)
{
    return glide_plain(w, p, from);
}

#endif

size_t world_move_bodies(world *w, const world_poses *p, uint32_t *left_out)
{
    bool plain = !p->linear && !p->angular && !p->teleports && may_glide(w), as_before = true;
    size_t left = 0, glided = 0;
    for (size_t i = 0; i < p->count; i++) {
        size_t run = plain && !p->places && as_before ? glide_on(w, p, i) : 0;
        as_before = !plain || run || i % 8 == 7; /* where one had to go another way, so may the next */
        i += run;
        if (i + AHEAD < p->count) fetch_to_move(w, p->ids[i + AHEAD]);
        size_t at = p->places ? p->places[i] : i;
        body *b = &w->bodies.at[p->ids[i]];
        if (!body_is(w, p->ids[i]) || is_older(w, b, p, at)) {
            left_out[left++] = (uint32_t)i;
            continue;
        }
        const double *q = p->orientations + 4 * at;
        const pose to = {vec_of(p->positions + 3 * at), quat_settled((quat){q[0], q[1], q[2], q[3]})};
        if (plain && glide(w, b, &to, p->stamp_ns)) {
            set_speed(b, NULL, NULL);
            glided++;
        } else {
            move_one(w, p, i, at, &to);
        }
    }
    w->figures.moves += glided;
    w->some_glided |= glided > 0;
    return left;
}
