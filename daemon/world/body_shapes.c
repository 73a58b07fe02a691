/* body_shapes: the shapes of a body, which are colliders: they are made when a definition brings others, and stay as
 * ghosts as a removed body does. Tick thread. */
#include "cascade.h"
#include "soft_state.h"

#include "geom/bounds.h"
#include "geom/compound.h"

#include <assert.h>
#include <stdlib.h>

static bool is_identity(pose p)
{
    const vec3 at = p.p;
    return at.x == 0 && at.y == 0 && at.z == 0 && p.q.w == 1 && p.q.x == 0 && p.q.y == 0 && p.q.z == 0;
}

static bool same_shape(const collider *s, const world_shape *def)
{
    const shape *a = &s->shape, *b = &def->shape;
    if (a->type == SHAPE_SOFT || b->type == SHAPE_SOFT)
        return a->type == b->type && a->soft == b->soft && a->radius == b->radius;
    bool same = a->type == b->type && a->radius == b->radius && a->deviation == b->deviation &&
                vec_equal(a->half, b->half) && a->hull == b->hull && pose_same(s->local, def->local);
    return same && (a->type != SHAPE_COMPOUND || compound_equal(a->compound, b->compound));
}

bool body_same_shapes(const world *w, const body *b, const world_body *def)
{
    if (body_visible_shapes(b) != def->shape_count) return false;
    for (size_t i = 0; i < def->shape_count; i++)
        if (!same_shape(&w->colliders.at[b->shapes[i]], &def->shapes[i])) return false;
    return true;
}

/* It and its children. */
static size_t shapes_in(const shape *s)
{
    return 1 + (s->type == SHAPE_COMPOUND ? s->compound->child_count : 0);
}

size_t world_body_shapes(const world *w, uint32_t id)
{
    size_t sum = 0;
    for (size_t i = 0; body_is(w, id) && i < body_visible_shapes(&w->bodies.at[id]); i++)
        sum += shapes_in(&w->colliders.at[w->bodies.at[id].shapes[i]].shape);
    return sum;
}

void body_drop_shapes(world *w, body *b)
{
    soft_leave(w, b);
    w->shapes_edition++;
    for (size_t i = 0; i < b->shape_count; i++) {
        collider *s = &w->colliders.at[b->shapes[i]];
        s->ghost = true;
        soft_rigid_forget(w, b->shapes[i]);
        w->dear -= slices_is_dear(s);
        w->figures.shapes -= s->shadow ? 0 : shapes_in(&s->shape);
        array_push(&w->ghost_colliders, b->shapes[i]);
        broad_remove(w->broad, b->shapes[i]);
    }
    body_free_shapes(b);
    effort_measure(w, b);
}

static uint32_t add_collider(world *w, uint32_t id, const shape *given, pose local, int32_t index, bool shadow)
{
    uint32_t at = id_pool_take(&w->collider_ids);
    array_reserve_in_place(&w->colliders, (size_t)at + 1);
    if (at >= w->colliders.count) w->colliders.count = at + 1;
    compound *own = given->type == SHAPE_COMPOUND ? compound_copy(given->compound) : NULL;
    collider *s = &w->colliders.at[at];
    *s = (collider){.shape = *given,
        .local = local,
        .reach = shape_reach(given),
        .body = id,
        .index = index & SHAPES_OF_A_BODY_MOST,
        .at_origin = is_identity(local),
        .shadow = shadow,
        .used = true};
    s->world = collider_at(w->bodies.at[id].pose, s);
    s->shape.compound = own;
    work_price(s);
    w->dear += slices_is_dear(s);
    w->figures.shapes += shadow ? 0 : shapes_in(&s->shape);
    return at;
}

/* A soft surface is its body's only shape, and has a shadow. */
void body_add_shapes(world *w, uint32_t id, const world_body *def)
{
    body *b = &w->bodies.at[id];
    assert(def->shape_count < SHAPES_OF_A_BODY_MOST);
    bool soft = def->shape_count == 1 && def->shapes[0].shape.type == SHAPE_SOFT;
    body_make_shapes(b, def->shape_count + soft);
    w->shapes_edition++;
    for (size_t i = 0; i < def->shape_count; i++)
        b->shapes[i] = add_collider(w, id, &def->shapes[i].shape, def->shapes[i].local, (int32_t)i, false);
    if (soft) b->shapes[1] = add_collider(w, id, &def->shapes[0].shape, def->shapes[0].local, 1, true);
    if (soft) soft_enter(w, id, b->shapes[0], b->shapes[1]);
    effort_measure(w, b);
}

void collider_free(collider *s)
{
    if (s->shape.type == SHAPE_COMPOUND) compound_destroy((compound *)s->shape.compound); /* it is its own */
    *s = (collider){.used = false};
}
