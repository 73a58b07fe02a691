/* collider: where the shapes of bodies stand: in the world, in the broad phase, and seen from each other. A calm body
 * moves without them: they follow when somebody asks. Tick thread; what is asked of a const world by the pool, too. */
#include "calm.h"
#include "cascade.h"
#include "state.h"

#include "base/sort.h"
#include "geom/bounds.h"

#include <stddef.h>

/* ---- in the world ---- */

/* Where the boxes of a body were put last. */
static pose settled_pose(const world *w, const body *b)
{
    bool is_newer = b->glided == w->round || (b->dirty && b->moved);
    return is_newer ? b->before : b->pose;
}

/* In a tick: what it did since the last one was nobody's business then, and is now. */
void body_account(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    body_settle_shapes(w, b);
    if (b->moved || b->glided != w->round - 1) return;
    b->moved = true;
    array_push(&w->glided, id);
}

pose collider_pose(const world *w, const collider *s)
{
    const body *b = &w->bodies.at[s->body];
    return b->behind ? collider_at(settled_pose(w, b), s) : s->world;
}

void collider_stand(const world *w, const collider *s, pose *body_pose, pose *local)
{
    const body *b = &w->bodies.at[s->body];
    *local = s->local;
    if (s->at_origin && !b->behind) { /* the same bits as below */
        *body_pose = s->world;
        return;
    }
    *body_pose = settled_pose(w, b);
    if (b->behind) return;
    pose is = collider_at(*body_pose, s);
    /* NOLINTNEXTLINE(bugprone-suspicious-memory-comparison): equal bits, as it was put */
    if (memcmp(&is, &s->world, sizeof is) == 0) return;
    *body_pose = s->world; /* it has teleported since */
    *local = POSE_IDENTITY;
}

void body_settle_shapes(world *w, body *b)
{
    if (!b->behind) return;
    b->behind = false;
    for (size_t i = 0; i < b->shape_count; i++) {
        collider *s = &w->colliders.at[b->shapes[i]];
        s->world = collider_at(settled_pose(w, b), s);
        s->box = shape_bounds(&s->shape, s->world);
    }
}

/* ---- in the broad phase ---- */

/* A tenth of the shape; what it moves, the broad phase adds ahead of it. */
double body_margin(const world *w, const collider *s)
{
    double reach = isfinite(s->reach) ? s->reach : 0;
    return w->options.margin * reach;
}

/* Dirty and calm: it took the full update because swept motions count, or else because it has left its region. */
static inline bool is_spared(const world *w, const body *b)
{
    return b->is_calm && !may_glide(w);
}

/* Those that come next are asked for while these are worked on; of one that is calm, no more than that is looked at. */
static inline void fetch_ahead(const world *w, size_t i)
{
    enum { CALM_AHEAD = 12, BODIES_AHEAD = 8, LISTS_AHEAD = 4, SHAPES_AHEAD = 2, LINE = 64 };
    if (i + CALM_AHEAD >= w->dirty.count) return;
    const body *b = &w->bodies.at[w->dirty.at[i + CALM_AHEAD]];
    __builtin_prefetch(&b->pose);
    __builtin_prefetch(&b->region, 1);
    b = &w->bodies.at[w->dirty.at[i + BODIES_AHEAD]];
    if (!is_spared(w, b))
        for (size_t at = offsetof(body, before); at < offsetof(body, name); at += LINE)
            __builtin_prefetch((const char *)b + at);
    b = &w->bodies.at[w->dirty.at[i + LISTS_AHEAD]];
    if (!is_spared(w, b)) __builtin_prefetch(b->shapes);
    b = &w->bodies.at[w->dirty.at[i + SHAPES_AHEAD]];
    if (is_spared(w, b) || !b->shape_count) return;
    const char *s = (const char *)&w->colliders.at[b->shapes[0]];
    for (size_t at = 0; at < sizeof(collider); at += LINE) __builtin_prefetch(s + at);
}

static void put_shapes(world *w, body *b)
{
    bool sweeps = !b->soft && (b->impacts || b->horizon > 0), passive = !b->match; /* nobody asks for it */
    for (size_t k = 0; k < b->shape_count; k++) {
        collider *s = &w->colliders.at[b->shapes[k]];
        s->world = collider_at(b->pose, s);
        s->box = shape_bounds(&s->shape, s->world);
        aabb box = sweeps ? body_swept_bounds(w, b, s, s->box) : s->box;
        broad_put(w->broad, &(broad_move){.proxy = b->shapes[k],
                                .fixed = b->fixed,
                                .passive = passive,
                                .box = aabb_grow(box, b->widen),
                                .margin = body_margin(w, s),
                                .motion = body_step(b)});
        if (b->refilter) broad_refilter(w->broad, b->shapes[k]);
    }
    b->refilter = b->behind = false;
    calm_find(w, b); /* until a pair begins that it is in */
}

static void settle_body(world *w, uint32_t id)
{
    body *b = &w->bodies.at[id];
    array_push(&w->awake, id);
    b->dirty = false;
    if (b->changed_tick != w->figures.ticks) b->changed_before = b->changed_tick;
    b->changed_tick = w->figures.ticks;
    b->moved |= b->glided == w->round - 1;
    if (b->ghost || !b->used) return;
    if (b->posed) expiry_set(w, id);
    b->posed = false;
    bounds_travel(w, b);
    put_shapes(w, b);
}

void body_settle_dirty(world *w)
{
    bool all = w->grant || w->bounds_asked; /* how far each goes is added up */
    array_reserve(&w->sort_scratch, w->dirty.count);
    sort_keys(w->dirty.at, w->sort_scratch.at, w->dirty.count);
    w->awake.count = 0;
    settling_choose(w);
    for (size_t i = 0; i < w->dirty.count; i++) {
        fetch_ahead(w, i);
        body *b = &w->bodies.at[w->dirty.at[i]];
        if (!b->dirty)
            continue; /* one that was left has gone since, and its id may be another's, who is in here, too */
        if (b->is_calm && !all && calm_holds(b, &b->pose)) {
            b->dirty = b->posed = false;
            b->behind = true;
        } else {
            settle_body(w, (uint32_t)w->dirty.at[i]);
        }
    }
}

/* ---- seen from each other ---- */

/* B's pose in A's frame, from the difference of the bodies' positions: exact where the bodies are near each other,
 * however far they are from the origin. */
static pose relative_of(pose body_a, pose local_a, pose body_b, pose local_b)
{
    pose bodies = pose_relative(body_a, body_b);
    pose b_in_body_a = pose_mul(bodies, local_b);
    pose relative = pose_relative(local_a, b_in_body_a);
    relative.q = quat_unit(relative.q);
    return relative;
}

/* Of two shapes at their bodies' origins the same numbers, without the products that change nothing. */
pose collider_relative(const world *w, const collider *a, const collider *b)
{
    if (a->at_origin && b->at_origin) {
        pose relative = pose_relative(w->bodies.at[a->body].pose, w->bodies.at[b->body].pose);
        relative.q = quat_unit(relative.q);
        return relative;
    }
    return relative_of(w->bodies.at[a->body].pose, a->local, w->bodies.at[b->body].pose, b->local);
}

pose collider_settled_relative(const world *w, const collider *a, const collider *b)
{
    pose body_a, local_a, body_b, local_b;
    collider_stand(w, a, &body_a, &local_a);
    collider_stand(w, b, &body_b, &local_b);
    return relative_of(body_a, local_a, body_b, local_b);
}

/* Two more products of poses and one more of matrices: the positions are off by some 20 roundoffs of the arms and of
 * what lies between the bodies, the directions by 8. */
double collider_relative_error(const world *w, const collider *a, const collider *b)
{
    if (a->at_origin && b->at_origin) return 0;
    vec3 between = vec_sub(w->bodies.at[b->body].pose.p, w->bodies.at[a->body].pose.p);
    return 0x1p-48 * (vec_norm(a->local.p) + vec_norm(b->local.p) + vec_norm(between)) + 0x1p-50 * pair_size(a, b);
}

bool colliders_in_order(const world *w, const collider *a, const collider *b)
{
    bool first = narrow_ordered(&a->shape, 0, &b->shape, 1);
    if (!first || !narrow_ordered(&b->shape, 0, &a->shape, 1)) return first;
    int c = strcmp(w->bodies.at[a->body].name, w->bodies.at[b->body].name); /* they are equal */
    return c ? c < 0 : a->index <= b->index;
}
