/* box_box: the formulas of two boxes, in A's frame. Pure; any thread.
 *
 * Depths are found by the fifteen axes (closed.h); an edge's axis is computed in full only if it may be the greatest.
 * Verdicts are decided by the greatest separation of the six faces, computed side by side, or by the edges' axes.
 * Distances are found by the features that the pair remembers, or by a guess at them (box_facing.h), or by a search for
 * them. The same formula answers in all three cases, so that a cache changes no bit.
 *
 * Rounding, in u = 2^-53, of the half diagonals g of both and |t|, with e <= |t| the gap. A matrix is off by less than
 * 6.5 u (test_primitive_boxes), its product with t by 4.7 u, with the other's axes by 3.7 u.
 *   lo along one axis: the heights by 6.5 and 13.9 g, t by 4.7, the product with it by 3, four sums by 4, the length of
 *     the axis by 11 e: less than 24 of them all.
 *   lo along the reported axis of two edges: t by 4, the heights by 6.5 (the matrix), 5.2 (the product) and 3 g, and
 * lo by 3 for the axis: less than 24 of them all. hi of a gap, between two points: t by 11.2, B's point by 20.4 of its
 * length, of which that is at most g, or |t| + e and the other g, with e^2 and it below their square: less than 24 of
 * them all. Of points that are put in the world each by its own matrix: each by 11.7 g, t by 2, the distance by 4. hi
 * of a depth. Along a face's normal: the product with t by 11.2, the other's height by 16.7 and its sum by 3. Along an
 * edge's: what is computed is that of two bodies that are off by 11.2 |t| + 16.7 g, A's a box, B's one with axes that
 * are not quite orthogonal, by less than 16.7, so that its faces' normals are off by 33.4 from those that are asked
 * about: 44.6 |t| + 33.4 g + 16.7 g and a few sums, less than 48 of them all. */
#include "narrow/closed/closed.h"
#include "narrow/convex/box_facing.h"
#include "narrow/convex/near_features.h"
#include "narrow/dispatch.h"
#include "primitive_pair.h"

#include <string.h>

static const vec3 AXES_OF_A[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

/* ---- the boxes, each seen from the other: the axes of a box side by side, so that all six faces' separations are
 * found in about the instructions of two ---- */

/* Values of A's three axes are in the lanes 0 to 2 of one vector, values of B's in those of another; faces are numbered
 * 0 to 2 and 4 to 6. */
typedef struct box_view {
    box_lanes of;
    lanes u;          /* from A's centre to B's, along B's axes */
    lanes by_a, by_b; /* how far the faces separate */
} box_view;

/* The separations along three faces. The fourth lane repeats the third. */
LANES_INLINE lanes box_view_faces(lanes centre, lanes half, const lanes3 *others, const vec3 *others_half, double scale)
{
    const lanes3 sides = {lanes_abs(others->x), lanes_abs(others->y), lanes_abs(others->z)};
    const vec3 by = vec_scale(*others_half, scale);
    lanes apart = lanes_abs(centre) - half - lanes3_mul_vec(sides, &by);
    return __builtin_shufflevector(apart, apart, 0, 1, 2, 2);
}

/* Computes the view from v->of. */
LANES_INLINE void box_view_of(const primitive_pair *q, double scale, box_view *v)
{
    v->u = lanes3_mul(v->of.rows_b, v->of.t);
    v->by_a = box_view_faces(v->of.t, v->of.half_a, &v->of.axes_b, &q->b->half, scale);
    v->by_b = box_view_faces(v->u, v->of.half_b, &v->of.rows_b, &q->a->half, scale);
}

/* The greatest separation along a face's normal, and the number of that face. Ties go to the first. */
LANES_INLINE double box_view_most(const box_view *v, unsigned *face)
{
    double most = lanes_greatest(v->by_a, v->by_b);
    *face = (unsigned)__builtin_ctz(lanes_bits(v->by_a == most) | lanes_bits(v->by_b == most) << LANES | 1u << 7);
    return most;
}

/* The same if that is above 0, with its last three bits cleared: in the comparisons these bits carry the number of the
 * face, so that among faces that differ in these bits alone the first wins. */
LANES_INLINE double box_view_most_above(const box_view *v, unsigned *face)
{
    const lane_mask rest = {~7, ~7, ~7, ~7}, a = {7, 6, 5, 5}, b = {3, 2, 1, 1};
    double most = lanes_greatest((lanes)(((lane_mask)v->by_a & rest) | a), (lanes)(((lane_mask)v->by_b & rest) | b));
    uint64_t bits;
    memcpy(&bits, &most, sizeof bits);
    *face = 7 - (unsigned)(bits & 7);
    bits &= ~UINT64_C(7);
    memcpy(&most, &bits, sizeof most);
    return most;
}

/* Guesses the nearest features from where the other box's centre lies. */
LANES_INLINE void box_view_features(const box_view *v, narrow_features *f)
{
    const lanes none = {0, 0, 0, 0};
    unsigned out_a = lanes_bits(lanes_abs(v->of.t) > v->of.half_a) & 7,
             out_b = lanes_bits(lanes_abs(v->u) > v->of.half_b) & 7;
    unsigned high_a = lanes_bits(v->of.t > none), high_b = lanes_bits(v->u < none);
    int free_a = 3 - __builtin_popcount(out_a), free_b = 3 - __builtin_popcount(out_b);
    if (free_a && free_b && free_a + free_b > 2) out_b = 7;
    *f = (narrow_features){.count_a = 3, .count_b = 3};
    box_sides_write(out_a & high_a, out_a & ~high_a, f->a);
    box_sides_write(out_b & high_b, out_b & ~high_b, f->b);
}

/* Copies the view into the form that the edges' axes are computed from. */
INLINE void multiply(const unit_pair *p, const box_view *v, box_pair *x)
{
    const lanes columns[3] = {v->of.axes_b.x, v->of.axes_b.y, v->of.axes_b.z};
    x->p = p;
    for (int i = 0; i < 3; i++) {
        x->a[i] = v->of.half_a[i], x->b[i] = v->of.half_b[i], x->t[i] = v->of.t[i], x->u[i] = v->u[i];
        for (int j = 0; j < 3; j++) x->r[i][j] = columns[j][i], x->abs[i][j] = fabs(x->r[i][j]);
    }
}

/* A face of one box and the corner of the other that faces it; the normal is from A to B. */
typedef struct facing {
    vec3 normal, corner; /* the corner from the other's centre */
    double local[3];     /* the corner from the other's centre, in this box's frame */
    int i;
} facing;

/* `rows`: this box's axes by the other's; `side` 1 or -1: where the other is along axis i. */
INLINE facing facing_of(const vec3 *own, int i, double side, const double rows[3][3], const vec3 *others, vec3 half)
{
    facing f = {.normal = vec_scale(own[i], side), .i = i};
    double x = copysign(half.x, -side * rows[i][0]), y = copysign(half.y, -side * rows[i][1]);
    double z = copysign(half.z, -side * rows[i][2]);
    f.corner = vec_madd(vec_madd(vec_scale(others[0], x), y, others[1]), z, others[2]);
    for (int k = 0; k < 3; k++) f.local[k] = rows[k][0] * x + rows[k][1] * y + rows[k][2] * z;
    return f;
}

INLINE void columns_of(const mat3 *m, vec3 out[3])
{
    out[0] = m->x, out[1] = m->y, out[2] = m->z;
}

/* The corner and what is across from it on the face, at `by` along the normal; false when it is not on the face, by
 * more than `slack`. */
INLINE bool points_of_face(
    const primitive_pair *q, const unit_pair *p, const box_pair *x, int index, double by, double slack, span *s)
{
    vec3 b[3], half_a = vec(x->a[0], x->a[1], x->a[2]), half_b = vec(x->b[0], x->b[1], x->b[2]);
    columns_of(&q->turn_b, b);
    bool on = true;
    if (index < 3) {
        facing f = facing_of(AXES_OF_A, index, x->t[index] < 0 ? -1 : 1, x->r, b, half_b);
        s->axis = f.normal;
        s->point_b = vec_add(p->b_in_a.t, f.corner);
        s->point_a = vec_madd(s->point_b, -by, f.normal);
        for (int k = 0; k < 3; k++) on &= (k == index) | (fabs(x->t[k] + f.local[k]) <= x->a[k] + slack);
    } else {
        int j = index - 3;
        const double rows[3][3] = {{x->r[0][0], x->r[1][0], x->r[2][0]}, {x->r[0][1], x->r[1][1], x->r[2][1]},
            {x->r[0][2], x->r[1][2], x->r[2][2]}};
        facing f = facing_of(b, j, x->u[j] < 0 ? 1 : -1, rows, AXES_OF_A, half_a);
        s->axis = vec_neg(f.normal);
        s->point_a = f.corner;
        s->point_b = vec_madd(f.corner, by, s->axis);
        for (int k = 0; k < 3; k++) on &= (k == j) | (fabs(f.local[k] - x->u[k]) <= x->b[k] + slack);
    }
    s->axis = direction_again(s->axis);
    return on;
}

/* The points where the shapes' surfaces are, on from the cores': along the line between those where they are farther
 * apart than the radii, else along the axis. */
INLINE void add_radii(const unit_pair *p, span *s)
{
    vec3 towards = s->hi > p->radius ? direction_of(vec_sub(s->point_b, s->point_a)) : s->axis;
    s->point_a = vec_madd(s->point_a, p->a.radius, towards);
    s->point_b = vec_madd(s->point_b, -p->b.radius, towards);
}

/* Writes the answer for boxes that are farther apart than the verdict needs; the points need not be the nearest. */
INLINE bool report_apart(const primitive_pair *q, const unit_pair *p, span *s, narrow_result *out)
{
    s->hi = max_of(s->lo, s->hi);
    if (p->radius > 0) add_radii(p, s);
    set_bounds(p, s, out);
    out->axis = s->axis;
    out->point_a = q->everyday ? s->point_a : vec_scale(s->point_a, p->unit);
    out->point_b = q->everyday ? s->point_b : vec_scale(s->point_b, p->unit);
    out->status = NARROW_CERTAIN;
    return out->lo > q->request->threshold;
}

INLINE vec3 vec_of(lanes v)
{
    return vec(v[0], v[1], v[2]);
}

/* Writes three vectors that lie one behind the other. Each store writes a fourth number into the next vector, which is
 * therefore written after it. */
INLINE void write_vectors(narrow_result *out, lanes axis, lanes point_a, lanes point_b)
{
    lanes_store(&out->axis.x, axis);
    lanes_store(&out->point_a.x, point_a);
    out->point_b = vec_of(point_b);
}

/* Writes the answer from an axis and the points of the cores, whose distance is `hi`. */
INLINE void report_points(
    const unit_pair *p, const span *s, lanes axis, lanes point_a, lanes point_b, narrow_result *out)
{
    if (p->radius > 0) {
        lanes towards = s->hi > p->radius ? (point_b - point_a) * (1 / s->hi) : axis;
        point_a += towards * p->a.radius;
        point_b -= towards * p->b.radius;
    }
    set_bounds(p, s, out);
    write_vectors(out, axis, point_a * p->unit, point_b * p->unit);
    out->manifold.count = 0;
    out->status = NARROW_CERTAIN;
}

/* Writes the answer along a face's normal. The point of each box is the nearest one to the other's centre, which is
 * outside. Only the axis depends on which face it is. */
INLINE bool apart_by_face(
    const primitive_pair *q, const unit_pair *p, const box_view *v, unsigned face, double by, narrow_result *out)
{
    double centre[2 * LANES];
    lanes_store(centre, v->of.t), lanes_store(centre + LANES, v->u);
    vec3 normal = AXES_OF_A[face % LANES];
    if (face >= LANES) normal = direction_again((&q->turn_b.x)[face % LANES]);
    normal = vec_scale(normal, signbit(centre[face]) ? -1 : 1);
    lanes point_a = lanes_clamp(v->of.t, v->of.half_a);
    lanes point_b = v->of.t - lanes3_mul(v->of.axes_b, lanes_clamp(v->u, v->of.half_b));
    span s = {.lo = by, .hi = sqrt(lanes_norm2(point_b - point_a)), .method = NARROW_BY_SAT, .iterations = BOX_FACES};
    s.hi = max_of(s.lo, s.hi);
    report_points(p, &s, (lanes){normal.x, normal.y, normal.z, 0}, point_a, point_b, out);
    return out->lo > q->request->threshold;
}

/* Can the axis of two edges separate more than `best` < 0? This takes the products as if the axes were exactly
 * orthogonal; `slack` is above the error of that. */
INLINE unsigned may_exceed(const box_pair *x, int i, int j, double best2, double slack)
{
    int h = (i + 1) % 3, k = (i + 2) % 3, l = (j + 1) % 3, m = (j + 2) % 3;
    double nh = -x->r[k][j], nk = x->r[h][j];
    double reach = x->a[h] * x->abs[k][j] + x->a[k] * x->abs[h][j] + x->b[l] * x->abs[i][m] + x->b[m] * x->abs[i][l];
    double most = fabs(nh * x->t[h] + nk * x->t[k]) - reach + slack;
    return (unsigned)((most >= 0) | (most * most < best2 * (nh * nh + nk * nk)));
}

/* The pairs of edges that can, as bits 3 i + j. */
INLINE unsigned edges_in_question(const box_pair *x, double best, double slack)
{
    double best2 = best * best;
    return may_exceed(x, 0, 0, best2, slack) | may_exceed(x, 0, 1, best2, slack) << 1 |
           may_exceed(x, 0, 2, best2, slack) << 2 | may_exceed(x, 1, 0, best2, slack) << 3 |
           may_exceed(x, 1, 1, best2, slack) << 4 | may_exceed(x, 1, 2, best2, slack) << 5 |
           may_exceed(x, 2, 0, best2, slack) << 6 | may_exceed(x, 2, 1, best2, slack) << 7 |
           may_exceed(x, 2, 2, best2, slack) << 8;
}

INLINE void box_box_try_edge(const box_pair *x, int i, int j, unsigned in_question, double *best, int *index)
{
    if (!(in_question >> (3 * i + j) & 1)) return;
    box_edge_axis e = box_edge_axis_of(x, i, j);
    bool less = e.separation < 0 && e.separation * e.separation >= *best * *best * e.norm2;
    if (less || !(e.norm2 > 0)) return;
    double separation = e.separation / sqrt(e.norm2);
    if (separation > *best) *best = separation, *index = BOX_FACES + 3 * i + j;
}

/* The nine calls are written out, so that each has constant indices. */
INLINE void box_box_try_edges(const box_pair *x, unsigned asked, double *best, int *index)
{
    box_box_try_edge(x, 0, 0, asked, best, index), box_box_try_edge(x, 0, 1, asked, best, index),
        box_box_try_edge(x, 0, 2, asked, best, index);
    box_box_try_edge(x, 1, 0, asked, best, index), box_box_try_edge(x, 1, 1, asked, best, index),
        box_box_try_edge(x, 1, 2, asked, best, index);
    box_box_try_edge(x, 2, 0, asked, best, index), box_box_try_edge(x, 2, 1, asked, best, index),
        box_box_try_edge(x, 2, 2, asked, best, index);
}

/* Prepares the boxes for a search, at unit size. */
INLINE void as_unit_pair(const primitive_pair *q, const unit_pair *from, unit_pair *p)
{
    double by = 1;
    *p = (unit_pair){.unit = from->unit, .scale = from->scale};
    if (q->everyday) {
        unit_of(max_of(max_of(q->reach_a, q->reach_b), vec_greatest(q->between)), &p->unit, &p->scale);
        by = p->scale;
    }
    p->a = (shape){.type = SHAPE_BOX, .radius = q->a->radius * p->scale, .half = vec_scale(q->a->half, p->scale)};
    p->b = (shape){.type = SHAPE_BOX, .radius = q->b->radius * p->scale, .half = vec_scale(q->b->half, p->scale)};
    p->b_in_a.t = vec_scale(from->b_in_a.t, by);
    p->b_in_a.r = q->turn_b;
    p->radius = p->a.radius + p->b.radius;
    p->size = from->size * by, p->error = from->error * by;
}

/* Finds the nearest points of the lines on which two edges lie. Returns whether they lie within the edges, as they do
 * unless the lines are nearly parallel. */
INLINE bool points_of_edges(const unit_pair *p, const box_pair *x, int index, span *s)
{
    int i = (index - BOX_FACES) / 3, j = (index - BOX_FACES) % 3, l = j == 2 ? 0 : j + 1, m = j == 0 ? 2 : j - 1;
    int h = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
    double nh = -x->r[k][j], nk = x->r[h][j], norm2 = nh * nh + nk * nk, per = 1 / sqrt(norm2);
    per = nh * x->t[h] + nk * x->t[k] < 0 ? -per : per;
    nh *= per, nk *= per;
    double b_l = copysign(x->b[l], -(nh * x->r[h][l] + nk * x->r[k][l]));
    double b_m = copysign(x->b[m], -(nh * x->r[h][m] + nk * x->r[k][m]));
    double a_h = copysign(x->a[h], nh), a_k = copysign(x->a[k], nk), c = x->r[i][j];
    double w_i = x->t[i] + x->r[i][l] * b_l + x->r[i][m] * b_m;
    double w_h = x->t[h] + x->r[h][l] * b_l + x->r[h][m] * b_m - a_h;
    double w_k = x->t[k] + x->r[k][l] * b_l + x->r[k][m] * b_m - a_k;
    double along = w_i * c + w_h * x->r[h][j] + w_k * x->r[k][j];
    double a_i = clamp_to((w_i - c * along) * (per * per), x->a[i]), b_j = clamp_to(a_i * c - along, x->b[j]);
    double v_i = w_i + b_j * c - a_i, v_h = w_h + b_j * x->r[h][j] - s->lo * nh;
    double v_k = w_k + b_j * x->r[k][j] - s->lo * nk;
    const vec3 *a = AXES_OF_A;
    s->axis = direction_again(vec_madd(vec_scale(a[h], nh), nk, a[k]));
    s->point_a = vec_madd(vec_madd(vec_scale(a[h], a_h), a_k, a[k]), a_i, a[i]);
    s->point_b = vec_madd(s->point_a, s->lo, s->axis);
    return v_i * v_i + v_h * v_h + v_k * v_k <= p->error * p->error;
}

/* The height of a box above its centre along a unit vector of its frame, and the corner there. */
INLINE double box_reach_along(vec3 half, vec3 seen, vec3 *corner)
{
    *corner = vec(copysign(half.x, seen.x), copysign(half.y, seen.y), copysign(half.z, seen.z));
    return half.x * fabs(seen.x) + half.y * fabs(seen.y) + half.z * fabs(seen.z);
}

/* Are the boxes apart along the axis of two edges by more than `enough`? The bound is computed from the axis that is
 * reported, not from the products that selected it. */
INLINE bool apart_by_edges(
    const primitive_pair *q, const unit_pair *p, const box_pair *x, int index, double enough, narrow_result *out)
{
    span s = {.method = NARROW_BY_SAT, .iterations = 15};
    int i = (index - BOX_FACES) / 3, j = (index - BOX_FACES) % 3, h = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
    double nh = -x->r[k][j], nk = x->r[h][j];
    vec3 half_a = vec(x->a[0], x->a[1], x->a[2]), half_b = vec(x->b[0], x->b[1], x->b[2]);
    vec3 between = p->b_in_a.t, corner;
    s.axis = direction_of(vec_madd(vec_scale(AXES_OF_A[h], nh), nk, AXES_OF_A[k]));
    double along = vec_dot(s.axis, between);
    if (along < 0) s.axis = vec_neg(s.axis), along = -along;
    s.lo = along - box_reach_along(half_a, s.axis, &s.point_a);
    s.lo -= box_reach_along(half_b, mat_tmul(q->turn_b, s.axis), &corner);
    if (!(s.lo > enough)) return false;
    s.point_b = vec_sub(between, mat_mul(q->turn_b, corner));
    s.hi = vec_norm(vec_sub(s.point_b, s.point_a));
    s.axis = direction_again(s.axis);
    return report_apart(q, p, &s, out);
}

/* Raises the greatest separation of the faces to that of all fifteen axes, for boxes that may overlap. */
INLINE void try_all(const unit_pair *p, const box_pair *x, double *best, int *index)
{
    unsigned in_question = edges_in_question(x, *best, 4 * p->error);
    if (in_question) box_box_try_edges(x, in_question, best, index);
}

/* The depth of the boxes. It returns false if edges separate them, or if the facing points are not found by formula. */
INLINE bool depth_of_boxes(
    const primitive_pair *q, unit_pair *p, const box_pair *x, double best, int index, narrow_result *out)
{
    span s = {.method = NARROW_BY_SAT, .iterations = 15};
    if (!(best < -0x1p-8 * p->error)) return false; /* the boxes touch, or are apart */
    s.lo = s.hi = best;
    bool found =
        index < BOX_FACES ? points_of_face(q, p, x, index, best, p->error, &s) : points_of_edges(p, x, index, &s);
    if (!found) return false;
    p->error = 3 * unit_error(p->size);
    return end(q, p, &s, s.axis, out);
}

/* Measures separated boxes by the features *f, if these are strict (features.h). */
INLINE bool gap_by_features(
    const primitive_pair *q, const unit_pair *p, const box_lanes *of, narrow_features *f, narrow_result *out)
{
    box_facing m;
    narrow_goal g = goal_of(p, q->request);
    if (!near_features_apply_to_boxes(&g, p->size)) return false;
    if (!box_facing_of(of, p->size, BOX_STEPS, f, &m)) return false;
    if (!(m.hi + 2 * p->error <= g.far)) return false; /* if not, a search might have ended beyond it */
    span s = {.lo = m.lo, .hi = m.hi, .method = NARROW_BY_SAT, .iterations = 1};
    report_points(p, &s, m.axis, m.point_a, m.point_b, out);
    return status_of(p, &g, q->request, &s) == NARROW_CERTAIN && suffices(q->request, out);
}

/* The side of a box that is on top along a direction in which it reaches so far. */
INLINE uint16_t side_on_top(double along)
{
    return along < 0 ? NEAR_LOW : NEAR_HIGH;
}

/* A face as a feature, and the other box's corner that faces it. */
INLINE void features_of_face(const box_pair *x, int index, narrow_features *f)
{
    int k = index % 3;
    double side = (index < 3 ? x->t[k] : x->u[k]) < 0 ? -1 : 1;
    *f = (narrow_features){.count_a = 3, .count_b = 3};
    for (int i = 0; i < 3; i++) {
        if (index < 3)
            f->b[i] = side_on_top(-side * x->r[k][i]), f->a[i] = i == k ? side_on_top(side) : NEAR_BETWEEN;
        else
            f->a[i] = side_on_top(side * x->r[i][k]), f->b[i] = i == k ? side_on_top(-side) : NEAR_BETWEEN;
    }
}

/* Two edges as features, on the sides that face each other. */
INLINE void features_of_edges(const box_pair *x, int index, narrow_features *f)
{
    int i = (index - BOX_FACES) / 3, j = (index - BOX_FACES) % 3, l = (j + 1) % 3, m = (j + 2) % 3;
    int h = (i + 1) % 3, k = (i + 2) % 3;
    double nh = -x->r[k][j], nk = x->r[h][j], side = nh * x->t[h] + nk * x->t[k] < 0 ? -1 : 1;
    *f = (narrow_features){.count_a = 3, .count_b = 3};
    f->a[i] = f->b[j] = NEAR_BETWEEN;
    f->a[h] = side_on_top(side * nh), f->a[k] = side_on_top(side * nk);
    f->b[l] = side_on_top(-side * (nh * x->r[h][l] + nk * x->r[k][l]));
    f->b[m] = side_on_top(-side * (nh * x->r[h][m] + nk * x->r[k][m]));
}

/* Measures separated boxes by descents from the face and from the edges that separate most, neither of which depends on
 * what the pair remembers. Bounds that are close name the strict features, if there are any (features.h): then these
 * are written to *f and give the answer. If not, f->count_a is 0, and the bounds are the answer. It returns false if
 * the bounds are too wide for either. */
INLINE bool gap_by_descents(const primitive_pair *q, const unit_pair *p, const box_lanes *of, const box_pair *x,
    int face, narrow_features *f, narrow_result *out)
{
    narrow_goal g = goal_of(p, q->request);
    bool named = near_features_apply_to_boxes(&g, p->size);
    double close = 0.25 * p->error, most = 0;
    int edges = BOX_FACES;
    box_facing m = {.lo = -INFINITY, .hi = INFINITY};
    features_of_face(x, face, f);
    box_facing_search(of, p->size, close, f, &m);
    if (m.hi - m.lo > close) {
        box_box_try_edges(x, 511, &most, &edges);
        features_of_edges(x, edges, f);
        box_facing_search(of, p->size, close, f, &m);
    }
    m.hi = max_of(m.lo, m.hi);
    if (!(m.lo > 0) || (named && !(m.hi - m.lo <= NEAR_NAMING_WIDTH * m.hi))) return false;
    if (named) box_facing_along(of, m.axis, f);
    if (named && gap_by_features(q, p, of, f, out)) return true;
    f->count_a = 0;
    if (!(m.hi - m.lo <= close || narrow_goal_reached(&g, m.lo, m.hi))) return false;
    span s = {.lo = m.lo, .hi = m.hi, .method = NARROW_BY_SAT, .iterations = 15};
    report_points(p, &s, m.axis, m.point_a, m.point_b, out);
    return status_of(p, &g, q->request, &s) == NARROW_CERTAIN && suffices(q->request, out);
}

/* Measures boxes that touch, or of which neither descent comes near enough, by the methods of all shapes. If the search
 * ends at strict features, these are written to *nearest and give the answer; if not, the answer is the search's. */
__attribute__((noinline)) static bool gap_by_search(
    const primitive_pair *q, const unit_pair *from, epa_scratch *scratch, narrow_features *nearest, narrow_result *out)
{
    unit_pair p;
    span s = {.nearest = {.count_a = 0}};
    as_unit_pair(q, from, &p);
    narrow_goal g = goal_of(&p, q->request);
    bool named = near_features_apply(&p, &g);
    if (!closed_box_box(&p, &g, &s)) dispatch_general(&p, &g, false, s.axis, scratch, &s);
    if (named) near_features_settle(&p, &g, &s);
    *nearest = named ? s.nearest : (narrow_features){.count_a = 0};
    if (nearest->count_a) return true;
    finish(&p, &s, out);
    out->status = NARROW_CERTAIN;
    return status_of(&p, &g, q->request, &s) == NARROW_CERTAIN && suffices(q->request, out);
}

/* Prepares the pair and the bound of rounding. */
INLINE bool prepare(primitive_pair *q, unit_pair *p, box_lanes *of)
{
    begin(q, p);
    if (!is_in_range(q, p)) return false;
    p->error = 1.5 * unit_error(p->size);
    p->deviation = 0;
    *of = box_lanes_of(&q->a->half, &q->b->half, &q->between, &q->turn_b, p->scale);
    return true;
}

INLINE int face_index(unsigned face)
{
    return (int)(face < LANES ? face : face - 1);
}

/* Decides a verdict by one face, or by all axes. */
INLINE bool verdict_of_boxes(primitive_pair *q, narrow_result *out)
{
    unit_pair p;
    box_view v;
    box_pair x;
    unsigned face;
    if (!prepare(q, &p, &v.of)) return false;
    box_view_of(q, p.scale, &v);
    double enough = q->request->threshold * p.scale + p.radius + p.error, most = box_view_most_above(&v, &face);
    if (most > enough && most > 0 && apart_by_face(q, &p, &v, face, most, out)) return true;
    most = box_view_most(&v, &face), enough = max_of(enough, 0);
    if (!(most < 0)) return false;
    int index = face_index(face);
    multiply(&p, &v, &x);
    try_all(&p, &x, &most, &index);
    if (most > enough) return apart_by_edges(q, &p, &x, index, enough, out);
    return depth_of_boxes(q, &p, &x, most, index, out);
}

/* Measures the boxes, beginning with the features that the pair remembers. */
INLINE bool distance_of_boxes(primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    unit_pair p;
    box_view v;
    box_pair x;
    unsigned face;
    if (!prepare(q, &p, &v.of)) return false;
    if (cache && cache->nearest.count_a && gap_by_features(q, &p, &v.of, &cache->nearest, out)) return true;
    narrow_features nearest = {.count_a = 0}, likely = nearest;
    if (cache) cache->nearest = nearest; /* so that the general method does not try them again */
    box_view_of(q, p.scale, &v);
    double most = box_view_most(&v, &face), deepest = most;
    int index = face_index(face), axis = index;
    if (most > 0) {
        box_view_features(&v, &likely);
        bool found = gap_by_features(q, &p, &v.of, &likely, out);
        if (cache && found) cache->nearest = likely;
        if (found) return true;
    }
    multiply(&p, &v, &x);
    if (most < 0) try_all(&p, &x, &deepest, &axis);
    if (most < 0 && depth_of_boxes(q, &p, &x, deepest, axis, out)) return true;
    if (deepest > 0 && gap_by_descents(q, &p, &v.of, &x, index, &likely, out)) {
        if (cache) cache->nearest = likely;
        return true;
    }
    if (!scratch || !gap_by_search(q, &p, scratch, &nearest, out)) return false;
    if (cache) cache->nearest = nearest;
    return !nearest.count_a || gap_by_features(q, &p, &v.of, &nearest, out);
}

INLINE bool two_boxes(primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    return is_measured(q->request) ? distance_of_boxes(q, cache, scratch, out) : verdict_of_boxes(q, out);
}

LANES_TWINS(LANES_WHOLE, bool, two_boxes, two_boxes,
    (primitive_pair *const q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out), (q, cache, scratch, out));

bool box_beside_box(primitive_pair *q, narrow_cache *cache, epa_scratch *scratch, narrow_result *out)
{
    return LANES_CHOSEN(two_boxes)(q, cache, scratch, out);
}
