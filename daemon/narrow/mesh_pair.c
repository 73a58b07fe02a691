/* Pairs with a mesh: the surfaces' distance decides, unless they overlap. Pure; any thread. */
#include "mesh_pair.h"

#include "mesh_depth.h"
#include "scalar.h"

bool mesh_pair_applies(const shape *a, const shape *b)
{
    return b->type == SHAPE_MESH && a->type != SHAPE_HALFSPACE;
}

/* Triangles and boxes are brought into the other frame and back: twice the error of one pose. The hull of a mesh is no
 * part of its surface. */
void mesh_pair_prepare(unit_pair *p, const shape *a)
{
    p->error *= 2;
    p->excess = a->type == SHAPE_MESH ? 0 : shape_excess(a) * p->scale;
}

void mesh_pair_measure(
    const unit_pair *p, const shape *a, const shape *b, const narrow_goal *goal, epa_scratch *scratch, span *out)
{
    mesh_walk w;
    mesh_gap gap;
    mesh_walk_init(&w, p, a, b);
    mesh_gap_find(&w, goal, &gap);
    bool apart = gap.relation == MESH_APART && gap.nearest.lo > p->radius + p->error + p->excess;
    *out = gap.nearest;
    if (apart) return;
    if (gap.relation < MESH_HOLDS_A && gap.nearest.hi <= goal->near)
        mesh_depth_rough(p, out);
    else
        mesh_depth_find(p, &w, goal, &gap, scratch, out);
}
