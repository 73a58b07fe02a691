/* The distance of surfaces by branch and bound, and containment by winding numbers. Pure; any thread. */
#include "mesh_gap.h"

#include "gjk.h"
#include "scalar.h"

typedef struct nearest_search {
    const narrow_goal *goal;
    mesh_gap *best;
    double least; /* lower bound of all parts that were looked at */
    bool ended;   /* before all were: it touches, or is as near as was asked */
} nearest_search;

static bool nearer(mesh_walk *w, void *context)
{
    nearest_search *q = context;
    span *best = &q->best->nearest;
    narrow_goal goal = *q->goal;
    gjk_result r;
    goal.far = min_of(max_of(goal.far, w->part.error), w->within); /* overlap is for mesh_depth to judge */
    mesh_walk_dress(w);
    gjk_distance(&w->part, &goal, w->axis, &r);
    q->least = min_of(q->least, r.span.lo);
    best->iterations += r.span.iterations;
    if (r.span.hi < best->hi) {
        uint32_t iterations = best->iterations;
        *best = r.span;
        best->iterations = iterations;
        q->best->triangle_a = w->triangle_a;
        q->best->triangle_b = w->triangle_b;
        w->within = r.span.hi;
        if (r.span.lo > 0) mesh_walk_aim(w, r.span.axis);
    }
    q->ended = best->hi <= w->part.error || best->hi <= q->goal->near;
    return !q->ended;
}

/* A point of A's core, or of its surface, in A's frame; and of B's. */
static vec3 some_point_a(const mesh_walk *w)
{
    if (w->ma) return vec_scale(w->ma->vertices[0], w->part.scale);
    bool hull = w->whole_a.type == SHAPE_HULL;
    return hull ? vec_scale(hull_vertex(w->whole_a.hull, 0), w->part.scale) : VEC_ZERO;
}
static vec3 some_point_b(const mesh_walk *w)
{
    return transform_point(&w->part.b_in_a, vec_scale(w->mb->vertices[0], w->part.scale));
}

/* No surface is within rounding of the other: so any one point tells for all, and its own rounding does not matter. */
static mesh_relation containment(const mesh_walk *w)
{
    const transform *t = &w->part.b_in_a;
    if (w->mb->solid) {
        vec3 in_b = mat_tmul(t->r, vec_sub(some_point_a(w), t->t));
        if (mesh_inside(w->mb, vec_scale(in_b, w->part.unit))) return MESH_HOLDS_A;
    }
    if (w->ma && w->ma->solid && mesh_inside(w->ma, vec_scale(some_point_b(w), w->part.unit))) return MESH_HOLDS_B;
    return MESH_APART;
}

/* The axis between the convex hulls, if they are apart, is a good one to begin with. */
static void aim_by_hulls(mesh_walk *w)
{
    const narrow_goal rough = {.tolerance = 1e-3 * w->part.size,
        .finest = 1e-3 * w->part.size,
        .far = INFINITY,
        .near = 0,
        .above = -INFINITY,
        .below = INFINITY};
    gjk_result r;
    mesh_walk_aim(w, VEC_ZERO);
    if (!w->ma) return;
    unit_pair hulls = w->part;
    hulls.a = w->whole_a;
    hulls.b = w->whole_b;
    hulls.a.type = hulls.b.type = SHAPE_HULL;
    gjk_distance(&hulls, &rough, VEC_ZERO, &r);
    if (r.span.lo > 0) mesh_walk_aim(w, r.span.axis);
}

void mesh_gap_find(mesh_walk *w, const narrow_goal *goal, mesh_gap *out)
{
    nearest_search q = {goal, out, INFINITY, false};
    *out = (mesh_gap){.nearest = {.lo = -INFINITY, .hi = INFINITY, .method = NARROW_BY_GJK},
        .triangle_a = MESH_NO_TRIANGLE,
        .triangle_b = MESH_NO_TRIANGLE};
    w->within = INFINITY;
    aim_by_hulls(w);
    mesh_walk_nearest(w, nearer, &q);
    span *s = &out->nearest;
    s->lo = q.ended ? -INFINITY : min_of(q.least, s->hi);
    out->relation = s->lo <= w->part.error ? MESH_CROSSING : containment(w);
}
