/* soft_bodies: where the vertices of soft bodies are, and the frames that say where they go. Tick thread. */
#include "soft_state.h"

#include <stdlib.h>

static void drop_place(soft_place *p)
{
    free(p->from), free(p->at);
    soft_drop_frame(&p->next), soft_drop_frame(&p->after);
    for (size_t i = 0; i < p->proposal_count; i++) soft_drop_frame(&p->proposals[i]);
    soft_body_destroy(p->engine);
    free(p);
}

void soft_drop_frame(soft_frame *f)
{
    free(f->at);
    *f = (soft_frame){.at = NULL};
}

void soft_bodies_free(world *w)
{
    for (size_t i = 0; i < w->soft->places.count; i++)
        if (w->soft->places.at[i]) drop_place(w->soft->places.at[i]);
    array_free(&w->soft->places);
}

aabb soft_box_of(const vec3 *at, size_t count)
{
    aabb b = {at[0], at[0]};
    for (size_t i = 1; i < count; i++) b.lo = vec_min(b.lo, at[i]), b.hi = vec_max(b.hi, at[i]);
    return b;
}

/* The box of its last way: what the broad phase and the search for partners go by. */
void soft_measure(soft_place *p)
{
    aabb from = soft_box_of(p->from, p->count);
    p->box = soft_box_of(p->at, p->count);
    vec3 lo = vec_min(from.lo, p->box.lo), hi = vec_max(from.hi, p->box.hi);
    double by = p->half_thickness * (1 + 0x1p-50) + 0x1p-50 * fmax(vec_max_abs(lo), vec_max_abs(hi));
    p->span[0] = vec_sub(lo, vec(by, by, by));
    p->span[1] = vec_add(hi, vec(by, by, by));
}

/* At rest, where the body's pose puts that, until a frame says otherwise. */
soft_place *soft_place_create(world *w, uint32_t id, uint32_t collider_id, uint32_t shadow)
{
    const shape *s = &w->colliders.at[collider_id].shape;
    soft_place *p = base_zalloc(1, sizeof *p);
    p->body = id, p->collider = collider_id, p->shadow = shadow;
    p->mesh = s->soft, p->half_thickness = s->radius;
    p->count = soft_mesh_vertex_count(p->mesh);
    p->at = base_alloc(p->count, sizeof *p->at), p->from = base_alloc(p->count, sizeof *p->from);
    const vec3 *rest = soft_mesh_rest(p->mesh);
    for (size_t i = 0; i < p->count; i++) p->from[i] = p->at[i] = pose_point(w->bodies.at[id].pose, rest[i]);
    p->engine = soft_body_create(p->mesh);
    soft_body_set_thickness(p->engine, p->half_thickness);
    w->colliders.at[collider_id].shape.span = w->colliders.at[shadow].shape.span = p->span;
    soft_measure(p);
    return p;
}

static size_t weight_of_surface(const soft_place *p)
{
    return p->count > WORLD_SOFT_LEAST ? p->count : WORLD_SOFT_LEAST;
}

void soft_enter(world *w, uint32_t id, uint32_t collider_id, uint32_t shadow)
{
    size_t place = 0;
    while (place < w->soft->places.count && w->soft->places.at[place]) place++;
    if (place == w->soft->places.count) array_push(&w->soft->places, NULL);
    w->soft->places.at[place] = soft_place_create(w, id, collider_id, shadow);
    w->soft->count++;
    w->figures.soft_vertices += weight_of_surface(w->soft->places.at[place]);
    w->bodies.at[id].soft = (uint32_t)place + 1;
}

void soft_leave(world *w, body *b)
{
    soft_place *p = soft_place_of(w, b);
    if (!p) return;
    soft_forget_jobs(w, p);
    collider *s[] = {&w->colliders.at[p->collider], &w->colliders.at[p->shadow]};
    for (int i = 0; i < 2; i++) s[i]->shape.soft = NULL, s[i]->shape.span = NULL;
    w->soft->places.at[b->soft - 1] = NULL;
    w->soft->count--;
    w->figures.soft_vertices -= weight_of_surface(p);
    b->soft = 0;
    drop_place(p);
}

/* ---- frames ---- */

/* What it is to be after all that has come. */
static const vec3 *newest_of(const soft_place *p)
{
    return p->after.at ? p->after.at : p->next.at ? p->next.at : p->at;
}

static int64_t newest_frame_of(const soft_place *p)
{
    return p->after.at ? p->after.frame : p->next.at ? p->next.frame : p->frame;
}

static bool frame_fits(const soft_place *p, const world_frame *f)
{
    for (size_t i = 0; i < f->range_count; i++)
        if (f->ranges[i].first > p->count || f->ranges[i].count > p->count - f->ranges[i].first) return false;
    return true;
}

static soft_frame compose(const soft_place *p, const world_frame *f)
{
    soft_frame made = {.at = base_alloc(p->count, sizeof *made.at),
        .frame = f->frame,
        .stamp_ns = f->stamp_ns,
        .teleports = f->mode == WORLD_FRAME_TELEPORTS};
    const vec3 *newest = f->mode == WORLD_FRAME_PROPOSES ? p->at : newest_of(p);
    memcpy(made.at, newest, p->count * sizeof *made.at);
    for (size_t i = 0; i < f->range_count; i++)
        if (f->ranges[i].count)
            memcpy(made.at + f->ranges[i].first, f->ranges[i].at, f->ranges[i].count * sizeof *made.at);
    made.box = soft_box_of(made.at, p->count);
    return made;
}

/* Several before its step begins are one: a way that begins with a teleport ends with one. */
static void put_into(world *w, soft_frame *to, soft_frame f)
{
    if (to->at) {
        w->figures.frames_skipped++;
        f.teleports |= to->teleports;
        soft_drop_frame(to);
    }
    *to = f;
}

world_frame_status world_put_frame(world *w, uint32_t id, const world_frame *f)
{
    soft_place *p = body_is(w, id) ? soft_place_of(w, &w->bodies.at[id]) : NULL;
    if (!p) return WORLD_FRAME_NOT_SOFT;
    if (!frame_fits(p, f)) return WORLD_FRAME_NO_VERTEX;
    w->changed = true;
    if (f->mode == WORLD_FRAME_PROPOSES) {
        if (p->proposal_count == SOFT_PROPOSALS_MAX) return WORLD_FRAME_CROWDED;
        p->proposals[p->proposal_count++] = compose(p, f);
        return WORLD_FRAME_TAKEN;
    }
    if (f->frame && f->frame <= newest_frame_of(p) && f->mode != WORLD_FRAME_TELEPORTS) return WORLD_FRAME_OLD;
    put_into(w, p->under_way ? &p->after : &p->next, compose(p, f));
    return WORLD_FRAME_TAKEN;
}

/* Its step is done. */
void soft_arrive(world *w, soft_place *p)
{
    body *b = &w->bodies.at[p->body];
    vec3 *was = p->from;
    p->from = p->at;
    p->at = p->next.at;
    if (p->next.teleports) memcpy(p->from, p->at, p->count * sizeof *p->at);
    p->frame = p->next.frame;
    b->stamp_ns = p->next.stamp_ns;
    b->posed = true;
    free(was);
    p->next = p->after;
    p->after = (soft_frame){.at = NULL};
    p->way_tick = w->figures.ticks;
    soft_measure(p);
    body_mark_dirty(w, p->body, false);
    w->figures.moves++;
}

size_t world_soft_vertices(const world *w, uint32_t id)
{
    const soft_place *p = body_is(w, id) ? soft_place_of(w, &w->bodies.at[id]) : NULL;
    return p ? p->count : 0;
}

const vec3 *world_soft_positions(const world *w, uint32_t id, int64_t *frame)
{
    const soft_place *p = body_is(w, id) ? soft_place_of(w, &w->bodies.at[id]) : NULL;
    if (p && frame) *frame = p->frame;
    return p ? p->at : NULL;
}
