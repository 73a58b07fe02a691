/* Pairs with a mesh: the surfaces' distance decides, unless they overlap. Pure; any thread. */
#include "mesh_pair.h"

#include "narrow/convex/gjk.h"

/* Triangles and boxes are brought into the other frame and back: twice the error of one pose. The hull of a mesh is no
 * part of its surface. */
void mesh_pair_prepare(unit_pair *p, const shape *a)
{
    p->error *= 2;
    p->excess = a->type == SHAPE_MESH ? 0 : shape_excess(a) * p->scale;
}

static const mesh_seed *seed_of(const narrow_cache *cache, mesh_seed *seed)
{
    if (!cache || cache->triangle_b == 0) return NULL;
    *seed = (mesh_seed){cache->triangle_a - 1, cache->triangle_b - 1};
    return seed;
}

static void mesh_pair_remember(narrow_cache *cache, const mesh_gap *gap)
{
    if (!cache || gap->triangle_b == MESH_NO_TRIANGLE) return;
    cache->triangle_a = gap->triangle_a + 1;
    cache->triangle_b = gap->triangle_b + 1;
}

/* The effort ended before it was known whether the surfaces meet: what the convex hulls prove, along the axis that
 * parts them, or that of the nearest parts that were found. */
static void bound_by_hulls(const unit_pair *p, span *out)
{
    const narrow_goal rough = {.tolerance = 1e-3 * p->size,
        .finest = 1e-3 * p->size,
        .far = INFINITY,
        .near = 0,
        .above = -INFINITY,
        .below = INFINITY};
    unit_pair hulls = mesh_depth_hulls(p);
    gjk_result r;
    gjk_distance(&hulls, &rough, VEC_ZERO, &r);
    if (r.span.lo > 0) out->axis = r.span.axis;
    mesh_depth_rough(p, out);
}

void mesh_pair_measure(const unit_pair *p, const shape *a, const shape *b, const narrow_goal *goal, narrow_cache *cache,
    epa_scratch *scratch, union_scratch *pieces, span *out)
{
    mesh_walk w;
    mesh_gap gap;
    mesh_seed seed;
    mesh_walk_init(&w, p, a, b);
    mesh_gap_find(&w, goal, seed_of(cache, &seed), &gap);
    mesh_pair_remember(cache, &gap);
    bool apart = gap.relation == MESH_APART && gap.nearest.lo > p->radius + p->error + p->excess;
    *out = gap.nearest;
    if (apart) return;
    if (p->effort) p->effort->counts = true; /* from here on it is a matter of shapes and poses alone */
    if (gap.cut) {
        bound_by_hulls(p, out);
        return;
    }
    if (gap.relation < MESH_HOLDS_A && gap.nearest.hi <= goal->near)
        mesh_depth_rough(p, out);
    else
        mesh_depth_find(p, &w, goal, &gap, scratch, pieces, out);
}
