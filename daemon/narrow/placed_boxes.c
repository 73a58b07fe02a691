/* placed_boxes: two boxes where they stand. Pure; any thread.
 *
 * Depths by the fifteen axes (box_pair.h), of which the edges' are looked at closely only where they may win. Verdicts
 * by the greatest separation of six faces side by side (box_view.h), else by the edges'. Distances by the features that
 * the pair remembers, or by a guess at them (placed_box_features.h); else a search in A's frame finds them, as on the
 * short road, but by the product of the two matrices in place of that of the quaternions. Whoever names them, the same
 * formula answers: a cache changes no bit.
 *
 * Rounding, in u = 2^-53, of the half diagonals g of both and |t|, with e <= |t| the gap. A matrix is off by less than
 * 6.5 u (test_placed_boxes), its product with t by 4.7 u, with the other's axes by 3.7 u.
 *   lo along one axis: the heights by 6.5 and 13.9 g, t by 4.7, the product with it by 3, four sums by 4, the length of
 *     the axis by 11 e: less than 24 of them all.
 *   lo along an axis as it is told, of edges: t by 4, the heights by 6.5 (the matrix), 5.2 (the product) and 3 g, and
 * lo by 3 for the axis: less than 24 of them all. hi of a gap, between two points: t by 11.2, B's point by 20.4 of its
 * length, of which that is at most g, or |t| + e and the other g, with e^2 and it below their square: less than 24 of
 * them all. Of points that are put in the world each by its own matrix: each by 11.7 g, t by 2, the distance by 4. hi
 * of a depth. Along a face's normal: the product with t by 11.2, the other's height by 16.7 and its sum by 3. Along an
 * edge's: what is computed is that of two bodies that are off by 11.2 |t| + 16.7 g, A's a box, B's one with axes that
 * are not quite orthogonal, by less than 16.7, so that its faces' normals are off by 33.4 from those that are asked
 * about: 44.6 |t| + 33.4 g + 16.7 g and a few sums, less than 48 of them all. */
#include "placed_formula.h"

#include "box_axes.h"
#include "box_pair.h"
#include "box_view.h"
#include "placed_box_features.h"

/* What the view tells, for the axes of edges. */
INLINE void multiply(const unit_pair *p, const box_view *v, box_pair *x)
{
    const lanes columns[3] = {v->b_from_a.x, v->b_from_a.y, v->b_from_a.z};
    x->p = p;
    for (int i = 0; i < 3; i++) {
        x->a[i] = v->half_a[i], x->b[i] = v->half_b[i], x->t[i] = v->t[i], x->u[i] = v->u[i];
        for (int j = 0; j < 3; j++) x->r[i][j] = columns[j][i], x->abs[i][j] = fabs(x->r[i][j]);
    }
}

/* A box's face that the other faces with a corner: the normal from A to B, and which corner. */
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
    const placed *q, const unit_pair *p, const box_pair *x, int index, double by, double slack, span *s)
{
    vec3 a[3], b[3], half_a = vec(x->a[0], x->a[1], x->a[2]), half_b = vec(x->b[0], x->b[1], x->b[2]);
    columns_of(&q->at_a->turn, a);
    columns_of(&q->at_b->turn, b);
    bool on = true;
    if (index < 3) {
        facing f = facing_of(a, index, x->t[index] < 0 ? -1 : 1, x->r, b, half_b);
        s->axis = f.normal;
        s->point_b = vec_add(p->b_in_a.t, f.corner);
        s->point_a = vec_madd(s->point_b, -by, f.normal);
        for (int k = 0; k < 3; k++) on &= (k == index) | (fabs(x->t[k] + f.local[k]) <= x->a[k] + slack);
    } else {
        int j = index - 3;
        const double rows[3][3] = {{x->r[0][0], x->r[1][0], x->r[2][0]}, {x->r[0][1], x->r[1][1], x->r[2][1]},
            {x->r[0][2], x->r[1][2], x->r[2][2]}};
        facing f = facing_of(b, j, x->u[j] < 0 ? 1 : -1, rows, a, half_a);
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

/* Apart by more than the verdict needs: the bounds, and between them points that are not far from each other. */
INLINE bool tell_apart(const placed *q, const unit_pair *p, span *s, narrow_result *out)
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

/* Three vectors that lie one behind the other: each takes a number of the next along, which is written after it. */
INLINE void write_vectors(narrow_result *out, lanes axis, lanes point_a, lanes point_b)
{
    lanes_store(&out->axis.x, axis);
    lanes_store(&out->point_a.x, point_a);
    out->point_b = vec_of(point_b);
}

/* The answer by an axis and points of the cores, which are `hi` apart. */
INLINE void tell_points(const unit_pair *p, const span *s, lanes axis, lanes point_a, lanes point_b, narrow_result *out)
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

/* Along a face's normal; of each box the point that is nearest to the other's centre, which is outside. Nothing waits
 * for which face it is but the axis. */
INLINE bool apart_by_face(
    const placed *q, const unit_pair *p, const box_view *v, unsigned face, double by, narrow_result *out)
{
    double centre[2 * LANES];
    const narrow_placed *own = face < LANES ? q->at_a : q->at_b;
    lanes_store(centre, v->t), lanes_store(centre + LANES, v->u);
    lanes axis = lanes_load(&own->turn.x.x + 3 * (face % LANES));
    axis = (lanes)((lane_mask)axis ^ lanes_sign(lanes_of(centre[face])));
    if (!own->unit) axis = axis * (1 / sqrt(lanes_norm2(axis)));
    lanes point_a = lanes3_mul(box_view_axes(q->at_a), lanes_clamp(v->t, v->half_a));
    lanes point_b = v->between - lanes3_mul(box_view_axes(q->at_b), lanes_clamp(v->u, v->half_b));
    span s = {.lo = by, .hi = sqrt(lanes_norm2(point_b - point_a)), .method = NARROW_BY_SAT, .iterations = BOX_FACES};
    s.hi = max_of(s.lo, s.hi);
    tell_points(p, &s, axis, point_a, point_b, out);
    return out->lo > q->request->threshold;
}

/* Can edges separate more than `best` < 0? By the products that orthogonal axes would have; `slack` is more than what
 * these are off. */
INLINE unsigned may_exceed(const box_pair *x, int i, int j, double best2, double slack)
{
    int h = (i + 1) % 3, k = (i + 2) % 3, l = (j + 1) % 3, m = (j + 2) % 3;
    double nh = -x->r[k][j], nk = x->r[h][j];
    double reach = x->a[h] * x->abs[k][j] + x->a[k] * x->abs[h][j] + x->b[l] * x->abs[i][m] + x->b[m] * x->abs[i][l];
    double most = fabs(nh * x->t[h] + nk * x->t[k]) - reach + slack;
    return (unsigned)((most >= 0) | (most * most < best2 * (nh * nh + nk * nk)));
}

/* Those that can, as bits 3 i + j. */
INLINE unsigned edges_in_question(const box_pair *x, double best, double slack)
{
    double best2 = best * best;
    return may_exceed(x, 0, 0, best2, slack) | may_exceed(x, 0, 1, best2, slack) << 1 |
           may_exceed(x, 0, 2, best2, slack) << 2 | may_exceed(x, 1, 0, best2, slack) << 3 |
           may_exceed(x, 1, 1, best2, slack) << 4 | may_exceed(x, 1, 2, best2, slack) << 5 |
           may_exceed(x, 2, 0, best2, slack) << 6 | may_exceed(x, 2, 1, best2, slack) << 7 |
           may_exceed(x, 2, 2, best2, slack) << 8;
}

INLINE void try_edge(const box_pair *x, int i, int j, unsigned in_question, double *best, int *index)
{
    if (!(in_question >> (3 * i + j) & 1)) return;
    box_edge_axis e = box_edge_axis_of(x, i, j);
    bool less = e.separation < 0 && e.separation * e.separation >= *best * *best * e.norm2;
    if (less || !(e.norm2 > 0)) return;
    double separation = e.separation / sqrt(e.norm2);
    if (separation > *best) *best = separation, *index = BOX_FACES + 3 * i + j;
}

/* Written out, so that each has its indices for constants. */
INLINE void try_edges(const box_pair *x, unsigned asked, double *best, int *index)
{
    try_edge(x, 0, 0, asked, best, index), try_edge(x, 0, 1, asked, best, index), try_edge(x, 0, 2, asked, best, index);
    try_edge(x, 1, 0, asked, best, index), try_edge(x, 1, 1, asked, best, index), try_edge(x, 1, 2, asked, best, index);
    try_edge(x, 2, 0, asked, best, index), try_edge(x, 2, 1, asked, best, index), try_edge(x, 2, 2, asked, best, index);
}

/* In A's frame, as the general road wants them: of unit size, `by` of what it was. */
INLINE double to_frame_of_a(const placed *q, const unit_pair *from, const mat3 *rotation, vec3 t, unit_pair *p)
{
    double by = 1;
    p->unit = from->unit, p->scale = from->scale;
    if (q->everyday) {
        unit_of(max_of(max_of(q->at_a->reach, q->at_b->reach), vec_greatest(from->b_in_a.t)), &p->unit, &p->scale);
        by = p->scale;
    }
    p->a = (shape){.type = SHAPE_BOX, .radius = q->a->radius * p->scale, .half = vec_scale(q->a->half, p->scale)};
    p->b = (shape){.type = SHAPE_BOX, .radius = q->b->radius * p->scale, .half = vec_scale(q->b->half, p->scale)};
    p->b_in_a.t = vec_scale(t, by);
    p->b_in_a.r = *rotation;
    p->radius = p->a.radius + p->b.radius;
    p->size = from->size * by, p->error = from->error * by;
    p->shaved_a = p->shaved_b = p->deviation = p->excess = 0;
    p->shell = NULL;
    p->stand = NULL;
    p->apart_along = VEC_ZERO;
    p->remembers = false;
    return by;
}

/* The same of two edges: the nearest points of the lines on which they lie, which are in the edges where the two lines
 * are not all but parallel. */
INLINE bool points_of_edges(const placed *q, const unit_pair *p, const box_pair *x, int index, span *s)
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
    vec3 a[3];
    columns_of(&q->at_a->turn, a);
    s->axis = direction_again(vec_madd(vec_scale(a[h], nh), nk, a[k]));
    s->point_a = vec_madd(vec_madd(vec_scale(a[h], a_h), a_k, a[k]), a_i, a[i]);
    s->point_b = vec_madd(s->point_a, s->lo, s->axis);
    return v_i * v_i + v_h * v_h + v_k * v_k <= p->error * p->error;
}

/* How far a box reaches from its centre along a unit vector, and the corner that is there. */
INLINE double reach_along(const mat3 *turn, vec3 half, vec3 axis, vec3 *corner)
{
    vec3 seen = mat_tmul(*turn, axis);
    *corner = mat_mul(*turn, vec(copysign(half.x, seen.x), copysign(half.y, seen.y), copysign(half.z, seen.z)));
    return half.x * fabs(seen.x) + half.y * fabs(seen.y) + half.z * fabs(seen.z);
}

/* Apart along the axis of two edges, and by more than `enough`: what the axis proves as it is told, not by the products
 * that named it. */
INLINE bool apart_by_edges(
    const placed *q, const unit_pair *p, const box_pair *x, int index, double enough, narrow_result *out)
{
    span s = {.method = NARROW_BY_SAT, .iterations = 15};
    int i = (index - BOX_FACES) / 3, j = (index - BOX_FACES) % 3, h = i == 2 ? 0 : i + 1, k = i == 0 ? 2 : i - 1;
    double nh = -x->r[k][j], nk = x->r[h][j];
    vec3 a[3], half_a = vec(x->a[0], x->a[1], x->a[2]), half_b = vec(x->b[0], x->b[1], x->b[2]);
    vec3 between = vec_scale(vec_sub(q->at_b->at.p, q->at_a->at.p), p->scale), corner;
    columns_of(&q->at_a->turn, a);
    s.axis = direction_of(vec_madd(vec_scale(a[h], nh), nk, a[k]));
    double along = vec_dot(s.axis, between);
    if (along < 0) s.axis = vec_neg(s.axis), along = -along;
    s.lo = along - reach_along(&q->at_a->turn, half_a, s.axis, &s.point_a);
    s.lo -= reach_along(&q->at_b->turn, half_b, s.axis, &corner);
    if (!(s.lo > enough)) return false;
    s.point_b = vec_sub(between, corner);
    s.hi = vec_norm(vec_sub(s.point_b, s.point_a));
    s.axis = direction_again(s.axis);
    return tell_apart(q, p, &s, out);
}

/* The greatest of all fifteen, given that of the faces, where the boxes may overlap. */
INLINE void try_all(const unit_pair *p, const box_pair *x, double *best, int *index)
{
    unsigned in_question = edges_in_question(x, *best, 4 * p->error);
    if (in_question) try_edges(x, in_question, best, index);
}

/* False where edges separate, or where the points that face each other are not where they are looked for. */
INLINE bool depth_of_boxes(const placed *q, unit_pair *p, const box_pair *x, double best, int index, narrow_result *out)
{
    span s = {.method = NARROW_BY_SAT, .iterations = 15};
    if (!(best < -0x1p-8 * p->error)) return false; /* touching, or apart */
    s.lo = s.hi = best;
    bool found =
        index < BOX_FACES ? points_of_face(q, p, x, index, best, p->error, &s) : points_of_edges(q, p, x, index, &s);
    if (!found) return false;
    p->error = 3 * unit_error(p->size);
    return end(q, p, &s, s.axis, out);
}

/* From A's frame to world axes. */
INLINE bool turned(const placed *q, narrow_result *out)
{
    const mat3 *turn = &q->at_a->turn;
    out->axis = direction_again(mat_mul(*turn, out->axis));
    out->point_a = mat_mul(*turn, out->point_a);
    out->point_b = mat_mul(*turn, out->point_b);
    return true;
}

/* What is apart, and to be measured: by the features that are named, if they are strict (near_features.h), ... */
INLINE bool gap_by_features(const placed *q, const unit_pair *p, narrow_features *f, narrow_result *out)
{
    box_facing m;
    narrow_goal g = goal_of(p, q->request);
    if (!near_features_apply_to_boxes(&g, p->size)) return false;
    if (!placed_box_facing(q->at_a, q->at_b, p->scale, p->size, BOX_STEPS, f, &m)) return false;
    if (!(m.hi + 2 * p->error <= g.far)) return false; /* or else a search may have ended beyond it */
    span s = {.lo = m.lo, .hi = m.hi, .method = NARROW_BY_SAT, .iterations = 1};
    tell_points(p, &s, m.axis, m.point_a, m.point_b, out);
    return status_of(p, &g, q->request, &s) == NARROW_CERTAIN && suffices(q->request, out);
}

/* ... which are found by a search, given the face that separates most. Where there are none, the search's answer. */
__attribute__((noinline)) static bool gap_by_search(const placed *q, const unit_pair *from, box_pair *x, double most,
    int index, narrow_scratch *scratch, narrow_features *nearest, narrow_result *out)
{
    unit_pair p;
    const box_stand stand = {q->at_a, q->at_b};
    const mat3 r = {vec(x->r[0][0], x->r[1][0], x->r[2][0]), vec(x->r[0][1], x->r[1][1], x->r[2][1]),
        vec(x->r[0][2], x->r[1][2], x->r[2][2])};
    double by = to_frame_of_a(q, from, &r, vec(x->t[0], x->t[1], x->t[2]), &p);
    p.stand = &stand;
    x->p = &p;
    for (int i = 0; i < 3; i++) x->a[i] *= by, x->b[i] *= by, x->t[i] *= by, x->u[i] *= by;
    return placed_boxes_apart(x, most * by, index, q->request, scratch, nearest, out) &&
           (nearest->count_a || turned(q, out));
}

/* Of the two in doubles: where they stand, and the bound of rounding. */
INLINE bool prepare(const placed *q, unit_pair *p)
{
    begin(q, p);
    if (!is_in_range(q, p)) return false;
    p->error = 1.5 * unit_error(p->size);
    p->deviation = 0;
    return true;
}

INLINE int face_index(unsigned face)
{
    return (int)(face < LANES ? face : face - 1);
}

/* The verdict alone, by a face. */
INLINE bool verdict_by_face(const placed *q, narrow_result *out)
{
    unit_pair p;
    box_view v;
    unsigned face;
    if (!prepare(q, &p)) return false;
    box_view_of(q->at_a, q->at_b, p.scale, &v);
    double enough = q->request->threshold * p.scale + p.radius + p.error, most = box_view_most_above(&v, &face);
    return most > enough && most > 0 && apart_by_face(q, &p, &v, face, most, out);
}

/* Where no face decides it. */
INLINE bool verdict_by_all(const placed *q, narrow_result *out)
{
    unit_pair p;
    box_view v;
    box_pair x;
    unsigned face;
    if (!prepare(q, &p)) return false;
    box_view_of(q->at_a, q->at_b, p.scale, &v);
    double enough = max_of(q->request->threshold * p.scale + p.radius + p.error, 0), most = box_view_most(&v, &face);
    if (!(most < 0)) return false;
    int index = face_index(face);
    multiply(&p, &v, &x);
    try_all(&p, &x, &most, &index);
    if (most > enough) return apart_by_edges(q, &p, &x, index, enough, out);
    return depth_of_boxes(q, &p, &x, most, index, out);
}

/* The distance, from what the pair remembers. */
INLINE bool distance_again(const placed *q, narrow_cache *cache, narrow_result *out)
{
    unit_pair p;
    if (!cache || !cache->nearest.count_a || !prepare(q, &p)) return false;
    return gap_by_features(q, &p, &cache->nearest, out);
}

/* From nothing. */
INLINE bool distance_of_boxes(const placed *q, narrow_cache *cache, narrow_scratch *scratch, narrow_result *out)
{
    unit_pair p;
    box_view v;
    box_pair x;
    if (!prepare(q, &p)) return false;
    narrow_features nearest = {.count_a = 0}, likely;
    if (cache) cache->nearest = nearest; /* the general road need not try again */
    box_view_of(q->at_a, q->at_b, p.scale, &v);
    unsigned face;
    double most = box_view_most(&v, &face), deepest = most;
    int index = face_index(face), axis = index;
    if (most > 0) {
        box_view_features(&v, &likely);
        bool found = gap_by_features(q, &p, &likely, out);
        if (cache && found) cache->nearest = likely;
        if (found) return true;
    }
    multiply(&p, &v, &x);
    if (most < 0) try_all(&p, &x, &deepest, &axis);
    if (most < 0 && depth_of_boxes(q, &p, &x, deepest, axis, out)) return true;
    if (!scratch || !gap_by_search(q, &p, &x, most, index, scratch, &nearest, out)) return false;
    if (cache) cache->nearest = nearest;
    return !nearest.count_a || gap_by_features(q, &p, &nearest, out);
}

INLINE bool two_boxes(const placed *q, narrow_cache *cache, narrow_scratch *scratch, narrow_result *out)
{
    bool measure = q->request->facts & NARROW_DISTANCE;
    if (!measure) return verdict_by_face(q, out) || verdict_by_all(q, out);
    return distance_again(q, cache, out) || distance_of_boxes(q, cache, scratch, out);
}

APART bool two_boxes_otherwise(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    unit_pair p;
    placed q = {a->shape, b->shape, a, b, request, true};
    begin(&q, &p);
    bool tried = is_in_range(&q, &p);
    q.everyday = false;
    return !tried && two_boxes(&q, cache, scratch, result);
}

/* A road by `formula`, and on by `otherwise` where that does not answer: for wide processors, and for all. */
#define ROADS(kind, name, formula, otherwise)                                                                          \
    kind LANES_WHOLE static bool name##_wide(const narrow_placed *a, const narrow_placed *b,                           \
        const narrow_request *request, narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)            \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula || otherwise##_wide(a, b, request, cache, scratch, result);                                     \
    }                                                                                                                  \
    kind static bool name##_narrow(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,      \
        narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)                                           \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula || otherwise##_narrow(a, b, request, cache, scratch, result);                                   \
    }
#define two_boxes_otherwise_wide two_boxes_otherwise
#define two_boxes_otherwise_narrow two_boxes_otherwise

ROADS(__attribute__((noinline)), distance_closely, distance_of_boxes(&q, cache, scratch, result), two_boxes_otherwise)
ROADS(, distance, distance_again(&q, cache, result), distance_closely)
ROADS(__attribute__((noinline)), verdict_closely, verdict_by_all(&q, result), two_boxes_otherwise)
ROADS(, verdict, verdict_by_face(&q, result), verdict_closely)

bool two_boxes_placed(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    bool wide = lanes_wide();
    if (request->facts & NARROW_DISTANCE)
        return (wide ? distance_wide : distance_narrow)(a, b, request, cache, scratch, result);
    return (wide ? verdict_wide : verdict_narrow)(a, b, request, cache, scratch, result);
}
