/* placed_boxes: two boxes where they stand. Pure; any thread.
 *
 * Depths by the fifteen axes (box_pair.h), of which the edges' are looked at closely only where they may win; verdicts
 * that a face decides. What is apart otherwise goes on in A's frame, as on the short road, but by the product of the
 * two matrices in place of that of the quaternions.
 *
 * Rounding, in u = 2^-53, of the half diagonals g of both and |t|, with e <= |t| the gap. A matrix is off by less than
 * 6.5 u (test_placed_boxes), its product with t by 4.7 u, with the other's axes by 3.7 u.
 *   lo along one axis: the heights by 6.5 and 13.9 g, t by 4.7, the product with it by 3, four sums by 4, the length of
 *     the axis by 11 e: less than 24 of them all.
 *   hi of a gap, between two points: t by 11.2, B's point by 20.4 of its length, of which that is at most g, or |t| + e
 *     and the other g, with e^2 and it below their square: less than 24 of them all.
 *   hi of a depth. Along a face's normal: the product with t by 11.2, the other's height by 16.7 and its sum by 3.
 * Along an edge's: what is computed is that of two bodies that are off by 11.2 |t| + 16.7 g, A's a box, B's one with
 * axes that are not quite orthogonal, by less than 16.7, so that its faces' normals are off by 33.4 from those that are
 *     asked about: 44.6 |t| + 33.4 g + 16.7 g and a few sums, less than 48 of them all. */
#include "placed_formula.h"

#include "box_axes.h"
#include "box_pair.h"
#include "short_road.h"

INLINE void put(double out[3], vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

INLINE void multiply(const placed *q, box_pair *x)
{
    const mat3 *a = &q->at_a->turn, *b = &q->at_b->turn;
    put(x->r[0], mat_tmul(*b, a->x));
    put(x->r[1], mat_tmul(*b, a->y));
    put(x->r[2], mat_tmul(*b, a->z));
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) x->abs[i][j] = fabs(x->r[i][j]);
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

/* The corner of the one box, and a point that is on the other's face, not far from it: all that a verdict needs. */
INLINE void points_apart(const placed *q, const unit_pair *p, const box_pair *x, int index, span *s)
{
    (void)points_of_face(q, p, x, index, s->lo, INFINITY, s);
    if (index < 3)
        s->point_a = vec_scale(s->axis, x->a[index]);
    else
        s->point_b = vec_madd(p->b_in_a.t, -x->b[index - 3], s->axis);
    s->hi = max_of(s->lo, vec_norm(vec_sub(s->point_b, s->point_a)));
}

/* Apart along a face's normal, by more than the verdict needs. */
INLINE bool apart_by_face(
    const placed *q, const unit_pair *p, const box_pair *x, int index, double by, narrow_result *out)
{
    span s = {.lo = by, .method = NARROW_BY_SAT, .iterations = BOX_FACES};
    points_apart(q, p, x, index, &s);
    bool by_line = p->radius > 0 && s.hi > p->radius;
    return end(q, p, &s, by_line ? direction_of(vec_sub(s.point_b, s.point_a)) : s.axis, out);
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

/* False where edges separate, or where the points that face each other are not where they are looked for. */
INLINE bool depth_of_boxes(const placed *q, unit_pair *p, const box_pair *x, double best, int index, narrow_result *out)
{
    span s = {.method = NARROW_BY_SAT, .iterations = 15};
    unsigned in_question = edges_in_question(x, best, 4 * p->error);
    if (in_question) try_edges(x, in_question, &best, &index);
    if (!(best < -0x1p-8 * p->error)) return false; /* touching, or apart */
    s.lo = s.hi = best;
    bool found =
        index < BOX_FACES ? points_of_face(q, p, x, index, best, p->error, &s) : points_of_edges(q, p, x, index, &s);
    if (!found) return false;
    p->error = 3 * unit_error(p->size);
    return end(q, p, &s, s.axis, out);
}

/* The greatest separation by a face; ties go to the first. */
INLINE double most_by_faces(const box_pair *x, int *index)
{
    double most = box_face_of_a(x, 0);
    *index = 0;
    for (int i = 1; i < BOX_FACES; i++) {
        double by = i < 3 ? box_face_of_a(x, i) : box_face_of_b(x, i - 3);
        bool more = by > most;
        *index = more ? i : *index;
        most = more ? by : most;
    }
    return most;
}

/* The face that is the farthest below the other's centre. */
INLINE int likeliest_face(const box_pair *x)
{
    double most = fabs(x->t[0]) - x->a[0];
    int best = 0;
    for (int i = 1; i < BOX_FACES; i++) {
        double above = i < 3 ? fabs(x->t[i]) - x->a[i] : fabs(x->u[i - 3]) - x->b[i - 3];
        bool more = above > most;
        best = more ? i : best;
        most = more ? above : most;
    }
    return best;
}

/* One face's axis without the others'. */
INLINE double face_alone(const placed *q, box_pair *x, int index)
{
    vec3 a[3], b[3];
    columns_of(&q->at_a->turn, a);
    columns_of(&q->at_b->turn, b);
    if (index < 3) {
        put(x->r[index], mat_tmul(q->at_b->turn, a[index]));
        for (int j = 0; j < 3; j++) x->abs[index][j] = fabs(x->r[index][j]);
        return box_face_of_a(x, index);
    }
    int j = index - 3;
    vec3 seen = mat_tmul(q->at_a->turn, b[j]);
    x->r[0][j] = seen.x, x->r[1][j] = seen.y, x->r[2][j] = seen.z;
    for (int i = 0; i < 3; i++) x->abs[i][j] = fabs(x->r[i][j]);
    return box_face_of_b(x, j);
}

/* Both in each other's frame. */
INLINE void see(const placed *q, const unit_pair *p, box_pair *x)
{
    x->p = p;
    put(x->a, vec_scale(q->a->half, p->scale));
    put(x->b, vec_scale(q->b->half, p->scale));
    put(x->t, mat_tmul(q->at_a->turn, p->b_in_a.t));
    put(x->u, mat_tmul(q->at_b->turn, p->b_in_a.t));
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

/* What is apart, and to be measured: from the features that the pair remembers, ... */
static bool gap_again(const placed *q, const unit_pair *from, narrow_cache *cache, narrow_result *out)
{
    unit_pair p;
    const mat3 *a = &q->at_a->turn, *b = &q->at_b->turn,
               r = {mat_tmul(*a, b->x), mat_tmul(*a, b->y), mat_tmul(*a, b->z)};
    to_frame_of_a(q, from, &r, mat_tmul(*a, from->b_in_a.t), &p);
    return short_road_boxes_again(&p, q->request, cache, out) && turned(q, out);
}

/* ... or by a search, given the face that separates most. */
static bool gap_of_boxes(const placed *q, const unit_pair *from, box_pair *x, double most, int index,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *out)
{
    unit_pair p;
    const mat3 r = {vec(x->r[0][0], x->r[1][0], x->r[2][0]), vec(x->r[0][1], x->r[1][1], x->r[2][1]),
        vec(x->r[0][2], x->r[1][2], x->r[2][2])};
    double by = to_frame_of_a(q, from, &r, vec(x->t[0], x->t[1], x->t[2]), &p);
    x->p = &p;
    for (int i = 0; i < 3; i++) x->a[i] *= by, x->b[i] *= by, x->t[i] *= by, x->u[i] *= by;
    return placed_boxes_apart(x, most * by, index, q->request, cache, scratch, out) && turned(q, out);
}

INLINE bool two_boxes(const placed *q, narrow_cache *cache, narrow_scratch *scratch, narrow_result *out)
{
    unit_pair p;
    box_pair x;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    p.error = 1.5 * unit_error(p.size);
    bool measure = q->request->facts & NARROW_DISTANCE;
    if (measure && cache && cache->nearest.count_a && gap_again(q, &p, cache, out)) return true;
    see(q, &p, &x);
    double enough = max_of(q->request->threshold * p.scale + p.radius + p.error, 0);
    int index;
    if (!measure) {
        index = likeliest_face(&x);
        double by = face_alone(q, &x, index);
        if (by > enough) return apart_by_face(q, &p, &x, index, by, out);
    }
    multiply(q, &x);
    double most = most_by_faces(&x, &index);
    if (most < 0 && depth_of_boxes(q, &p, &x, most, index, out)) return true;
    if (most > enough && !measure) return apart_by_face(q, &p, &x, index, most, out);
    return measure && scratch && gap_of_boxes(q, &p, &x, most, index, cache, scratch, out);
}

APART bool two_boxes_otherwise(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    unit_pair p;
    placed q = {a->shape, b->shape, a, b, request, true};
    begin(&q, &p);
    bool tried = is_in_range(&q, &p);
    q.everyday = false;
    if (!tried && two_boxes(&q, cache, scratch, result)) return true;
    return placed_by_relative_pose(a, b, request, cache, scratch, result);
}

bool two_boxes_placed(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    const placed q = {a->shape, b->shape, a, b, request, true};
    return two_boxes(&q, cache, scratch, result) || two_boxes_otherwise(a, b, request, cache, scratch, result);
}
