/* sat: separating axes of polytopes, for the depth. Pure; any thread. Ties go to the first candidate, in a fixed order.
 */
#include "narrow/math/scalar.h"
#include "polytopes.h"

static bool is_box_like(const shape *s)
{
    return s->type <= SHAPE_BOX;
}
static bool has_faces(const shape *s)
{
    return s->type == SHAPE_HULL && s->hull->face_count > 0;
}

bool sat_applies(const unit_pair *p)
{
    if (sat_is_quick(p)) return true;
    if (has_faces(&p->a) && has_faces(&p->b)) return sat_affords(p->a.hull, p->b.hull);
    return (is_box_like(&p->a) && has_faces(&p->b)) || (has_faces(&p->a) && is_box_like(&p->b));
}

bool sat_is_quick(const unit_pair *p)
{
    return is_box_like(&p->a) && is_box_like(&p->b);
}

static void sat_try_axis(const unit_pair *p, vec3 axis, span *best)
{
    double separation = vec_dot(axis, unit_pair_nearest_along(p, axis).w);
    best->iterations++;
    if (!(separation > best->lo)) return;
    best->lo = separation;
    best->axis = axis;
}

static void try_both_ways(const unit_pair *p, vec3 direction, span *best)
{
    vec3 axis = direction_of(direction);
    if (!(vec_norm2(axis) > 0)) return;
    sat_try_axis(p, axis, best);
    sat_try_axis(p, vec_neg(axis), best);
}

static const mat3 IDENTITY = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
static const transform SAME = {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}};

/* The faces of one shape, whose frame has the given axes in A's; `outward` = +1 for A, -1 for B. */
static void sat_faces(const unit_pair *p, const shape *s, const mat3 *frame, double outward, span *best)
{
    if (is_box_like(s)) {
        for (int i = 0; i < 3; i++) try_both_ways(p, mat_column(frame, i), best);
        return;
    }
    for (uint32_t i = 0; i < s->hull->face_count; i++)
        sat_try_axis(p, direction_of(mat_mul(*frame, vec_scale(s->hull->faces[i].normal, outward))), best);
}

/* An edge of a hull in A's frame: a point on it, its direction, the outward normals of its two faces. */
typedef struct arc {
    vec3 point, direction, n0, n1;
} arc;

static arc hull_arc(const hull *h, uint32_t i, double scale, const transform *to_a)
{
    const hull_edge *e = &h->edges[i];
    vec3 v0 = hull_vertex(h, e->v0), v1 = hull_vertex(h, e->v1);
    return (arc){
        .point = transform_point(to_a, vec_scale(v0, scale)),
        .direction = mat_mul(to_a->r, vec_scale(vec_sub(v1, v0), scale)),
        .n0 = mat_mul(to_a->r, h->faces[e->f0].normal),
        .n1 = mat_mul(to_a->r, h->faces[e->f1].normal),
    };
}

/* Cosines closer to 0 than this may have the wrong sign: such candidates are measured, not skipped. */
#define ARC_SLACK 1e-12

static bool opposite(double x, double y)
{
    return x * y <= 0 || fabs(x) < ARC_SLACK || fabs(y) < ARC_SLACK;
}

/* The axis of an edge pair points away from the hull, that is along the sum of the normals beside its edge. Where that
 * does not tell (a blade's edge, its faces back to back), both ways are tried. `outward` = +1 when the hull is A. */
static void try_outward(const unit_pair *p, vec3 axis, vec3 middle, double outward, span *best)
{
    double along = vec_dot(axis, middle);
    if (fabs(along) < ARC_SLACK)
        try_both_ways(p, axis, best);
    else
        sat_try_axis(p, vec_scale(axis, along < 0 ? -outward : outward), best);
}

/* Every edge of a hull that is a silhouette seen along an axis of the box. `outward` = +1 when the hull is A. */
static void box_hull_edges(
    const unit_pair *p, const hull *h, const transform *hull_to_a, const mat3 *box, double outward, span *best)
{
    for (uint32_t i = 0; i < h->edge_count; i++) {
        arc e = hull_arc(h, i, p->scale, hull_to_a);
        vec3 middle = vec_add(e.n0, e.n1);
        for (int k = 0; k < 3; k++) {
            vec3 u = mat_column(box, k);
            if (!opposite(vec_dot(e.n0, u), vec_dot(e.n1, u))) continue;
            try_outward(p, direction_of(vec_cross(e.direction, u)), middle, outward, best);
        }
    }
}

/* Each arc crosses the other's great circle. Whether they meet in one point or in two opposite ones is left to the
 * axis. */
static bool circles_cross(const arc *a, const arc *b)
{
    vec3 circle_a = vec_cross(a->n0, a->n1), circle_b = vec_cross(b->n0, b->n1);
    return opposite(vec_dot(b->n0, circle_a), vec_dot(b->n1, circle_a)) &&
           opposite(vec_dot(a->n0, circle_b), vec_dot(a->n1, circle_b));
}

/* The cross product of two edges is a facet's normal when it lies on A's arc and, turned round, on B's. */
static void sat_try_edges(const unit_pair *p, const arc *a, const arc *b, span *best)
{
    vec3 axis = direction_of(vec_cross(a->direction, b->direction));
    vec3 middle_a = vec_add(a->n0, a->n1), middle_b = vec_add(b->n0, b->n1);
    if (!(vec_norm2(axis) > 0)) return;
    if (vec_dot(axis, middle_a) < 0) axis = vec_neg(axis);
    bool tells = vec_dot(axis, middle_a) > ARC_SLACK;
    if (tells && vec_dot(axis, middle_b) > ARC_SLACK) return;
    /* the two edges alone bound the separation from above: most are ruled out without support points */
    double separation = vec_dot(axis, vec_sub(b->point, a->point));
    if (tells && separation <= best->lo - p->error) return;
    try_outward(p, axis, middle_a, 1, best);
}

static void hull_hull_edges(const unit_pair *p, span *best)
{
    const hull *a = p->a.hull, *b = p->b.hull;
    for (uint32_t j = 0; j < b->edge_count; j++) {
        arc eb = hull_arc(b, j, p->scale, &p->b_in_a);
        for (uint32_t i = 0; i < a->edge_count; i++) {
            arc ea = hull_arc(a, i, p->scale, &SAME);
            if (circles_cross(&ea, &eb)) sat_try_edges(p, &ea, &eb, best);
        }
    }
}

void sat_depth(const unit_pair *p, span *out)
{
    bool box_a = is_box_like(&p->a), box_b = is_box_like(&p->b);
    out->lo = -INFINITY;
    out->method = NARROW_BY_SAT;
    sat_faces(p, &p->a, &IDENTITY, 1, out);
    sat_faces(p, &p->b, &p->b_in_a.r, -1, out);
    if (box_a)
        box_hull_edges(p, p->b.hull, &p->b_in_a, &IDENTITY, -1, out);
    else if (box_b)
        box_hull_edges(p, p->a.hull, &SAME, &p->b_in_a.r, 1, out);
    else
        hull_hull_edges(p, out);
    out->hi = out->lo;
}
