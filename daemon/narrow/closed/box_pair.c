/* box_pair: the separating-axis test of two boxes in A's frame, and the points that face each other. Pure; any thread.
 */
#include "closed.h"
#include "narrow/convex/gjk.h"
#include "narrow/math/scalar.h"

enum { FACES_B = 3, EDGES = BOX_FACES, AXES = 15, ROUNDS = 4 };

/* One of the fifteen: A's faces, B's faces, edge i of A with edge j of B at EDGES + 3 i + j. */
typedef struct box_axis {
    double separation;
    int index;
} box_axis;

static void box_pair_of(const unit_pair *p, box_pair *x)
{
    const mat3 *r = &p->b_in_a.r;
    const vec3 column[3] = {r->x, r->y, r->z};
    x->p = p;
    vec_to(shape_core_half(&p->a), x->a);
    vec_to(shape_core_half(&p->b), x->b);
    vec_to(p->b_in_a.t, x->t);
    for (int j = 0; j < 3; j++) {
        x->u[j] = vec_dot(column[j], p->b_in_a.t);
        x->r[0][j] = column[j].x, x->r[1][j] = column[j].y, x->r[2][j] = column[j].z;
        for (int i = 0; i < 3; i++) x->abs[i][j] = fabs(x->r[i][j]);
    }
}

static void keep_greater(box_axis *best, double separation, int index)
{
    if (!(separation > best->separation)) return;
    best->separation = separation;
    best->index = index;
}

static box_axis box_pair_faces(const box_pair *x)
{
    box_axis best = {-INFINITY, 0};
    for (int i = 0; i < 3; i++) keep_greater(&best, box_face_of_a(x, i), i);
    for (int j = 0; j < 3; j++) keep_greater(&best, box_face_of_b(x, j), FACES_B + j);
    return best;
}

/* What an axis gives before the division by |n| <= 1 bounds an overlap already. */
static inline void edge_pair(const box_pair *x, int i, int j, box_axis *best)
{
    box_edge_axis e = box_edge_axis_of(x, i, j);
    if ((e.separation <= 0 && e.separation <= best->separation) || !(e.norm2 > 0)) return;
    keep_greater(best, e.separation / sqrt(e.norm2), EDGES + 3 * i + j);
}

/* Written out, so that each has its indices for constants. */
static void edges(const box_pair *x, box_axis *best)
{
    edge_pair(x, 0, 0, best), edge_pair(x, 0, 1, best), edge_pair(x, 0, 2, best);
    edge_pair(x, 1, 0, best), edge_pair(x, 1, 1, best), edge_pair(x, 1, 2, best);
    edge_pair(x, 2, 0, best), edge_pair(x, 2, 1, best), edge_pair(x, 2, 2, best);
}

/* Unit, from A towards B. */
static vec3 direction(const box_pair *x, int index)
{
    double n[3] = {0, 0, 0};
    if (index < FACES_B) {
        n[index] = x->t[index] < 0 ? -1 : 1;
        return vec_from(n);
    }
    if (index < EDGES) {
        int j = index - FACES_B;
        vec3 normal = vec(x->r[0][j], x->r[1][j], x->r[2][j]);
        return x->u[j] < 0 ? vec_neg(normal) : normal;
    }
    int i = (index - EDGES) / 3, j = (index - EDGES) % 3, h = (i + 1) % 3, k = (i + 2) % 3;
    n[h] = -x->r[k][j], n[k] = x->r[h][j];
    vec3 across = direction_of(vec_from(n));
    return vec_dot(across, vec_from(x->t)) < 0 ? vec_neg(across) : across;
}

static vec3 box_pair_corner(const double half[3], vec3 d)
{
    return vec(copysign(half[0], d.x), copysign(half[1], d.y), copysign(half[2], d.z));
}

/* unit_pair_nearest_along, for boxes. */
static minkowski corners_along(const box_pair *x, vec3 axis)
{
    minkowski m;
    m.a = box_pair_corner(x->a, axis);
    m.b_local = box_pair_corner(x->b, mat_tmul(x->p->b_in_a.r, vec_neg(axis)));
    m.b = transform_point(&x->p->b_in_a, m.b_local);
    m.w = vec_sub(m.b, m.a);
    return m;
}

/* A corner of the one box and the point of the other box that is nearest to it. */
static void face_points(const box_pair *x, const minkowski *top, int index, span *out)
{
    const unit_pair *p = x->p;
    vec3 corner = index < FACES_B ? top->b : mat_tmul(p->b_in_a.r, vec_sub(top->a, p->b_in_a.t)), on_face = corner;
    const double *half = index < FACES_B ? x->a : x->b;
    double *at[3] = {&on_face.x, &on_face.y, &on_face.z};
    int facing = index % 3;
    bool upward = index < FACES_B ? !(x->t[facing] < 0) : x->u[facing] < 0; /* as direction(): -0 is no less than 0 */
    for (int i = 0; i < 3; i++) *at[i] = i == facing ? (upward ? half[i] : -half[i]) : clamp_to(*at[i], half[i]);
    out->point_a = index < FACES_B ? on_face : top->a;
    out->point_b = index < FACES_B ? top->b : transform_point(&p->b_in_a, on_face);
}

/* The nearest points of the two lines on which the edges lie, moved into the edges. */
static void edge_points(const box_pair *x, const minkowski *top, int index, span *out)
{
    const unit_pair *p = x->p;
    int i = (index - EDGES) / 3, j = (index - EDGES) % 3, h = (i + 1) % 3, k = (i + 2) % 3;
    double a[3], b[3], w[3], rj[3] = {x->r[0][j], x->r[1][j], x->r[2][j]};
    vec_to(top->a, a);
    vec_to(top->b_local, b);
    a[i] = b[j] = 0;
    vec_to(vec_sub(transform_point(&p->b_in_a, vec_from(b)), vec_from(a)), w);
    double cosine = rj[i], sine2 = rj[h] * rj[h] + rj[k] * rj[k], along_b = vec_dot(vec_from(w), vec_from(rj));
    double across = w[i] - cosine * along_b; /* w less its part along r_j, along e_i */
    a[i] = clamp_to(across / sine2, x->a[i]);
    b[j] = clamp_to(a[i] * cosine - along_b, x->b[j]);
    out->point_a = vec_from(a);
    out->point_b = transform_point(&p->b_in_a, vec_from(b));
}

/* Certifies the axis by support points, and finds the points that face each other along it. */
static void box_pair_measure(const box_pair *x, box_axis best, span *out)
{
    out->axis = direction(x, best.index);
    minkowski top = corners_along(x, out->axis);
    out->lo = vec_dot(out->axis, top.w);
    out->hi = max_of(out->lo, best.separation);
    if (best.index < EDGES)
        face_points(x, &top, best.index, out);
    else
        edge_points(x, &top, best.index, out);
}

/* The depth: the greatest of all fifteen, none of which separates. */
static void measure_depth(const box_pair *x, box_axis best, span *out)
{
    box_pair_measure(x, best, out);
    if (span_aside(out) > x->p->error) witness_apart(x->p, out);
}

static vec3 box_pair_clamped(vec3 v, const double half[3])
{
    return vec(clamp_to(v.x, half[0]), clamp_to(v.y, half[1]), clamp_to(v.z, half[2]));
}

/* The bounds differ by their rounding only, or by no more than is asked. */
static bool met(const unit_pair *p, const narrow_goal *goal, const span *s)
{
    return s->hi - s->lo <= 0.25 * p->error || narrow_goal_reached(goal, s->lo, s->hi);
}

/* Two boxes that are apart are nearest at a corner of one and a point of the other, or at two edges. This tries the
 * corners that face each other, and from the line that it finds the next ones. True when the bounds meet. */
static bool corners_meet(const box_pair *x, const narrow_goal *goal, span *out)
{
    const unit_pair *p = x->p;
    vec3 axis = out->axis;
    out->lo = -INFINITY;
    out->hi = INFINITY;
    for (int i = 0; i < ROUNDS; i++) {
        minkowski top = corners_along(x, axis);
        double separation = vec_dot(axis, top.w);
        if (separation > out->lo) out->lo = separation, out->axis = axis;
        vec3 on_a = box_pair_clamped(top.b, x->a), local = mat_tmul(p->b_in_a.r, vec_sub(top.a, p->b_in_a.t));
        vec3 on_b = transform_point(&p->b_in_a, box_pair_clamped(local, x->b));
        bool corner_of_b = vec_norm2(vec_sub(top.b, on_a)) <= vec_norm2(vec_sub(on_b, top.a));
        vec3 point_a = corner_of_b ? on_a : top.a, point_b = corner_of_b ? top.b : on_b;
        vec3 line = vec_sub(point_b, point_a);
        double distance = vec_norm(line);
        out->iterations++;
        if (distance < out->hi) out->hi = distance, out->point_a = point_a, out->point_b = point_b;
        if (met(p, goal, out)) return true;
        if (!(distance > 0)) return false; /* they touch: that is no direction */
        axis = direction_of(line);
    }
    return false;
}

/* Apart: the corners, then the two edges whose axis separates most. */
static bool measure_distance(const box_pair *x, box_axis best, const narrow_goal *goal, span *out)
{
    out->axis = direction(x, best.index);
    if (corners_meet(x, goal, out)) return true;
    double by_corners = out->lo;
    edges(x, &best);
    out->iterations += AXES - EDGES;
    if (!(best.separation > by_corners) || best.index < EDGES) return false;
    box_pair_measure(x, best, out);
    out->hi = max_of(out->lo, vec_norm(vec_sub(out->point_b, out->point_a)));
    return met(x->p, goal, out);
}

void box_pair_axes(const unit_pair *p, span *out)
{
    box_pair x;
    box_pair_of(p, &x);
    box_axis best = box_pair_faces(&x);
    edges(&x, &best);
    out->method = NARROW_BY_SAT;
    out->iterations += AXES;
    measure_depth(&x, best, out);
}

bool closed_box_box(const unit_pair *p, const narrow_goal *goal, span *out)
{
    box_pair x;
    box_pair_of(p, &x);
    box_axis best = box_pair_faces(&x);
    out->method = NARROW_BY_SAT;
    out->iterations = EDGES;
    if (best.separation > 0) return measure_distance(&x, best, goal, out);
    edges(&x, &best);
    out->iterations = AXES;
    if (best.separation > 0) return measure_distance(&x, best, goal, out);
    measure_depth(&x, best, out);
    return true;
}

/* Rounding moves what is computed of an axis by less than `slack` before it is divided by its length, and the length by
 * less than `slack` / size; an overlap is at most the size. */
unsigned box_pair_near_best(const unit_pair *p)
{
    box_pair x;
    box_pair_of(p, &x);
    box_axis best = box_pair_faces(&x);
    edges(&x, &best);
    double slack = 4 * p->error, least = best.separation - p->error;
    unsigned near = 0;
    for (int i = 0; i < 3; i++) {
        if (box_face_of_a(&x, i) >= least - slack) near |= 1u << i;
        if (box_face_of_b(&x, i) >= least - slack) near |= 1u << (FACES_B + i);
        for (int j = 0; j < 3; j++) {
            box_edge_axis e = box_edge_axis_of(&x, i, j);
            if (e.separation >= least * sqrt(e.norm2) - slack) near |= 1u << (EDGES + 3 * i + j);
        }
    }
    return near;
}
