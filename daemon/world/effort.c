/* effort: what it takes to put a body's boxes anew, in units of about a nanosecond, by counts: its shapes, and what the
 * boxes of these are found from. It decides how many poses are taken before a tick, and no answer. Tick thread. */
#include "calm.h"
#include "state.h"

#include "geom/compound.h"
#include "geom/hull.h"

enum {
    A_BODY = 400,
    A_SHAPE = 600, /* its box, found and put */
    A_VERTEX = 2,  /* of a hull that is scanned */
    A_WALK = 1000, /* in a hull that is searched, six times ... */
    NODES = 2,     /* ... and one for so many nodes: they lie beyond the caches */
    A_CHILD = 200, /* of a compound */
    WIDE = 8000    /* more than this takes a wide body */
};

static uint64_t of_hull(const hull *h)
{
    if (!h) return 0;
    return h->node_count ? A_WALK + h->node_count / NODES : A_VERTEX * h->vertex_count;
}

static uint64_t of_shape(const shape *s)
{
    uint64_t units = A_SHAPE + of_hull(s->hull);
    for (uint32_t i = 0; s->type == SHAPE_COMPOUND && i < s->compound->child_count; i++)
        units += A_CHILD + of_hull(s->compound->children[i].shape.hull);
    return units;
}

static bool is_wide(uint32_t effort)
{
    return effort > WIDE;
}

void effort_measure(world *w, body *b)
{
    uint64_t units = A_BODY;
    for (size_t i = 0; i < b->shape_count; i++) units += of_shape(&w->colliders.at[b->shapes[i]].shape);
    if (units > UINT32_MAX) units = UINT32_MAX;
    if (b->dirty) w->effort = w->effort - b->effort + units;
    w->wide = w->wide - is_wide(b->effort) + is_wide((uint32_t)units);
    b->effort = (uint32_t)units;
}

void effort_restored(world *w, const body *b)
{
    w->wide += is_wide(b->effort);
}

uint64_t world_effort(const world *w)
{
    return w->effort;
}

bool world_has_wide(const world *w)
{
    return w->wide > 0;
}

uint64_t world_effort_of(const world *w, uint32_t id, const pose *to)
{
    if (!body_is(w, id)) return 0;
    const body *b = &w->bodies.at[id];
    if (!to) return b->effort;
    bool glides = may_glide(w) && b->is_calm && !b->dirty && calm_holds(b, to);
    return b->dirty || glides ? 0 : b->effort;
}
