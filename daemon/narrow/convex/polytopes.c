/* sat: separating axes of polytopes, for the depth. Pure; any thread. Ties go to the first candidate, in a fixed order.
 */
#include "polytopes.h"

#include "geom/hull_scan.h"
#include "narrow/math/scalar.h"

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
    bool reports = vec_dot(axis, middle_a) > ARC_SLACK;
    if (reports && vec_dot(axis, middle_b) > ARC_SLACK) return;
    /* the two edges alone bound the separation from above: most are ruled out without support points */
    double separation = vec_dot(axis, vec_sub(b->point, a->point));
    if (reports && separation <= best->lo - p->error) return;
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

/* ==== hulls that are sought apart ==== */

/* The search for the nearest features. Nearest points of simplices: Ericson, "Real-Time Collision
 * Detection", 2005, 5.1. */

enum { STEPS_MOST = 24 };

/* Of its square: a point that is no more than that below the nearest is on its plane. */
#define NO_NEARER 0x1p-40

typedef struct corner {
    vec3 w; /* of B - A */
    uint16_t a, b;
} corner;

typedef struct seeker {
    corner at[4];
    int count;
    vec3 nearest; /* of the simplex to the origin; points from A to B */
    double norm2;
} seeker;

static inline corner hull_seek_corner_along(const unit_pair *p, vec3 axis)
{
    uint32_t a, b = hull_scan(p->b.hull, mat_tmul(p->b_in_a.r, vec_neg(axis)));
    vec3 on_a, on_b = vec_madd(p->b_in_a.t, p->scale, mat_mul(p->b_in_a.r, hull_vertex(p->b.hull, b)));
    if (p->a.type == SHAPE_BOX) {
        a = (axis.x < 0 ? 0 : 1U) | (axis.y < 0 ? 0 : 2U) | (axis.z < 0 ? 0 : 4U);
        on_a = box_corner(p->a.half, a);
    } else {
        a = hull_scan(p->a.hull, axis);
        on_a = vec_scale(hull_vertex(p->a.hull, a), p->scale);
    }
    return (corner){vec_sub(on_b, on_a), (uint16_t)a, (uint16_t)b};
}

static inline bool known(const seeker *s, const corner *c)
{
    for (int i = 0; i < s->count; i++)
        if (s->at[i].a == c->a && s->at[i].b == c->b) return true;
    return false;
}

/* What a simplex has come down to. */
typedef struct part {
    int count;
    uint8_t index[3];
    vec3 nearest;
    double norm2;
} part;

static inline void take_vertex(const corner *at, uint8_t i, part *best)
{
    double norm2 = vec_norm2(at[i].w);
    if (norm2 < best->norm2) *best = (part){1, {i}, at[i].w, norm2};
}

/* The edge from i to j: its inner points, if the nearest is one. */
static inline void take_edge(const corner *at, uint8_t i, uint8_t j, part *best)
{
    vec3 e = vec_sub(at[j].w, at[i].w);
    double t = -vec_dot(at[i].w, e), length2 = vec_norm2(e);
    if (!(t > 0 && t < length2)) return;
    vec3 point = vec_madd(at[i].w, t / length2, e);
    double norm2 = vec_norm2(point);
    if (norm2 < best->norm2) *best = (part){2, {i, j}, point, norm2};
}

/* The inner points of a triangle. False if the nearest is none of them. */
static inline bool take_triangle(const corner *at, uint8_t i, uint8_t j, uint8_t k, vec3 n, part *best)
{
    vec3 p = at[i].w, q = at[j].w, r = at[k].w;
    double u = vec_dot(n, vec_cross(q, r)), v = vec_dot(n, vec_cross(r, p)), w = vec_dot(n, vec_cross(p, q));
    if (!(u > 0 && v > 0 && w > 0)) return false;
    double height = vec_dot(n, p), area2 = vec_norm2(n), norm2 = height * height / area2;
    if (norm2 < best->norm2) *best = (part){3, {i, j, k}, vec_scale(n, height / area2), norm2};
    return true;
}

static inline vec3 hull_seek_normal_of(const corner *at, uint8_t i, uint8_t j, uint8_t k)
{
    return vec_cross(vec_sub(at[j].w, at[i].w), vec_sub(at[k].w, at[i].w));
}

/* The newest point is the last: the nearest of the simplex is on a part that has it, for it was nearer than all others
 * along the axis. False when the origin is inside: of a tetrahedron, which is left as it is; or on a lesser part. */
static bool hull_seek_reduce(seeker *s)
{
    part best = {.norm2 = INFINITY};
    const corner *at = s->at;
    uint8_t last = (uint8_t)(s->count - 1);
    if (last == 3) {
        bool outside = false;
        for (uint8_t k = 0; k < 3; k++) {
            uint8_t i = k == 0 ? 1 : 0, j = k == 2 ? 1 : 2;
            vec3 n = hull_seek_normal_of(at, last, i, j);
            bool beyond = vec_dot(n, at[last].w) * vec_dot(n, vec_sub(at[k].w, at[last].w)) > 0;
            outside |= beyond;
            if (beyond) take_triangle(at, last, i, j, n, &best);
        }
        if (!outside) return false;
    } else if (last == 2) {
        take_triangle(at, 0, 1, 2, hull_seek_normal_of(at, 0, 1, 2), &best);
    }
    if (best.count != 3) {
        for (uint8_t i = 0; i < last; i++) take_edge(at, i, last, &best);
        take_vertex(at, last, &best);
    }
    for (int i = 0; i < best.count - 1; i++) /* in ascending order, in place */
        for (int k = i + 1; k < best.count; k++)
            if (best.index[k] < best.index[i]) {
                uint8_t swap = best.index[i];
                best.index[i] = best.index[k], best.index[k] = swap;
            }
    for (int i = 0; i < best.count; i++) s->at[i] = at[best.index[i]];
    s->count = best.count;
    s->nearest = best.nearest;
    s->norm2 = best.norm2;
    return best.norm2 > 0;
}

static hull_seek_end hull_seek_propose(const seeker *s, narrow_features *out)
{
    *out = (narrow_features){.count_a = 0};
    for (int i = 0; i < s->count; i++) {
        hull_features_include(s->at[i].a, out->a, &out->count_a);
        hull_features_include(s->at[i].b, out->b, &out->count_b);
    }
    return HULL_SEEK_PROPOSES;
}

static hull_seek_end report_inside(const seeker *s, hull_corners *holds)
{
    if (s->count < 4) return HULL_SEEK_UNKNOWN;
    for (int i = 0; i < 4; i++) holds->a[i] = s->at[i].a, holds->b[i] = s->at[i].b;
    return HULL_SEEK_INSIDE;
}

hull_seek_end hull_seek(const unit_pair *p, int patience, bool proposes, narrow_features *out, hull_corners *holds)
{
    seeker s;
    bool apart = false;
    s.count = 0;
    s.nearest = p->b_in_a.t;
    for (int i = 0; i < STEPS_MOST; i++) {
        corner c = hull_seek_corner_along(p, s.nearest);
        double along = vec_dot(c.w, s.nearest);
        apart |= along > 0;
        if (apart && !proposes) return HULL_SEEK_APART;
        if (!apart && i + 1 >= patience) return HULL_SEEK_UNKNOWN;
        if (s.count && (known(&s, &c) || !(along < s.norm2 * (1 - NO_NEARER)))) return hull_seek_propose(&s, out);
        s.at[s.count++] = c;
        if (!hull_seek_reduce(&s)) return apart ? HULL_SEEK_APART : report_inside(&s, holds);
    }
    return apart ? HULL_SEEK_APART : HULL_SEEK_UNKNOWN;
}
