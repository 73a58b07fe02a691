/* body_shapes: the shapes of a body, which are colliders: they are made when a definition brings others, and stay as
 * ghosts as a removed body does. Tick thread. */
#include "cascade.h"
#include "state.h"

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
    bool same = a->type == b->type && a->radius == b->radius && a->deviation == b->deviation &&
                vec_equal(a->half, b->half) && a->hull == b->hull && pose_same(s->local, def->local);
    return same && (a->type != SHAPE_COMPOUND || compound_equal(a->compound, b->compound));
}

bool body_same_shapes(const world *w, const body *b, const world_body *def)
{
    if (b->shape_count != def->shape_count) return false;
    for (size_t i = 0; i < b->shape_count; i++)
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
    for (size_t i = 0; body_is(w, id) && i < w->bodies.at[id].shape_count; i++)
        sum += shapes_in(&w->colliders.at[w->bodies.at[id].shapes[i]].shape);
    return sum;
}

void body_drop_shapes(world *w, body *b)
{
    w->shapes_edition++;
    for (size_t i = 0; i < b->shape_count; i++) {
        collider *s = &w->colliders.at[b->shapes[i]];
        s->ghost = true;
        w->dear -= slices_is_dear(s);
        w->figures.shapes -= shapes_in(&s->shape);
        array_push(&w->ghost_colliders, b->shapes[i]);
        broad_remove(w->broad, b->shapes[i]);
    }
    body_free_shapes(b);
    effort_measure(w, b);
}

void body_add_shapes(world *w, uint32_t id, const world_body *def)
{
    body *b = &w->bodies.at[id];
    assert(def->shape_count <= SHAPES_OF_A_BODY_MOST);
    body_make_shapes(b, def->shape_count);
    w->shapes_edition++;
    for (size_t i = 0; i < def->shape_count; i++) {
        uint32_t s = id_pool_take(&w->collider_ids);
        array_reserve_in_place(&w->colliders, (size_t)s + 1);
        if (s >= w->colliders.count) w->colliders.count = s + 1;
        const shape *given = &def->shapes[i].shape;
        compound *own = given->type == SHAPE_COMPOUND ? compound_copy(given->compound) : NULL;
        w->colliders.at[s] = (collider){.shape = *given,
            .local = def->shapes[i].local,
            .reach = shape_reach(given),
            .body = id,
            .index = (int32_t)(i & SHAPES_OF_A_BODY_MOST),
            .at_origin = is_identity(def->shapes[i].local),
            .used = true};
        w->colliders.at[s].world = collider_at(b->pose, &w->colliders.at[s]);
        w->colliders.at[s].shape.compound = own;
        work_price(&w->colliders.at[s]);
        w->dear += slices_is_dear(&w->colliders.at[s]);
        w->figures.shapes += shapes_in(&w->colliders.at[s].shape);
        b->shapes[i] = s;
    }
    effort_measure(w, b);
}

void collider_free(collider *s)
{
    if (s->shape.type == SHAPE_COMPOUND) compound_destroy((compound *)s->shape.compound); /* it is its own */
    *s = (collider){.used = false};
}
