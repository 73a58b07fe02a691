/* gjk: Gilbert-Johnson-Keerthi with a duality-gap stop. Pure; any thread.
 *
 * What holds: for every unit axis n tried, min over B - A of dot(n, w) is a lower bound; every convex combination of
 * points of B - A is an upper bound. The bracket of the best of both is kept apart from the search, which may stall. */
#include "gjk.h"

#include "features.h"
#include "narrow/math/dd.h"
#include "narrow/math/scalar.h"

enum { ITERATIONS_MAX = 128 };

static vec3 first_axis(const unit_pair *p, vec3 seed)
{
    vec3 axis = vec_norm2(seed) > 0 ? seed : direction_of(p->b_in_a.t);
    return vec_norm2(axis) > 0 ? axis : vec(1, 0, 0);
}

/* Before there is a simplex, the first point of B - A stands for the upper bound. */
static void first_upper(span *best, const minkowski *m)
{
    best->hi = vec_norm(m->w);
    best->point_a = m->a;
    best->point_b = m->b;
}

/* One step: the newest point, at s->v[s->count], joins; the simplex shrinks to its nearest feature. False when the
 * search is over. */
static bool gjk_advance(const unit_pair *p, gjk_result *out, support_hints *hints, vec3 *axis)
{
    simplex *s = &out->simplex;
    span *best = &out->span;
    double touch = 8 * UNIT_ROUNDOFF * p->size;
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        out->state = GJK_INSIDE;
        simplex_lower_upper(s, 0, best);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) simplex_lower_upper(s, n.norm, best);
    *axis = n.axis;
    if (best->hi > touch && decreased) return true;
    span_raise_lower(best, vec_dot(n.axis, unit_pair_nearest_from(p, n.axis, hints).w), n.axis);
    return false;
}

static void gjk_start(gjk_result *out)
{
    out->state = GJK_TOUCH;
    out->span.lo = -INFINITY;
    out->span.hi = INFINITY;
    out->span.method = NARROW_BY_GJK;
    out->span.nearest = (narrow_features){.count_a = 0};
    out->simplex.count = 0;
}

void gjk_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out)
{
    span *best = &out->span;
    support_hints hints = NO_HINTS;
    vec3 axis = first_axis(p, seed);
    gjk_start(out);
    for (best->iterations = 1; best->iterations <= ITERATIONS_MAX; best->iterations++) {
        minkowski *m = &out->simplex.v[out->simplex.count];
        unit_pair_nearest_to(p, axis, &hints, m);
        span_raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) first_upper(best, m);
        if (narrow_goal_reached(goal, best->lo, best->hi) || simplex_has(&out->simplex, m->w) ||
            !gjk_advance(p, out, &hints, &axis))
            break;
    }
    if (out->state == GJK_TOUCH && (best->lo > 0 || narrow_goal_reached(goal, best->lo, best->hi)))
        out->state = GJK_APART;
    const simplex *s = &out->simplex;
    const minkowski *m[3] = {&s->v[0], &s->v[1], &s->v[2]};
    if (out->state == GJK_APART && s->count <= 3 && p->a.type == SHAPE_HULL && p->b.type == SHAPE_HULL)
        hull_features_of(m, s->count, &best->nearest);
}

void gjk_narrow_down(gjk_search *by, const unit_pair *p, const narrow_goal *goal, span *s)
{
    const narrow_goal exactly = {goal->finest, goal->finest, INFINITY, -INFINITY, INFINITY, INFINITY, false};
    gjk_result r;
    by(p, &exactly, s->axis, &r);
    if (!(r.span.hi - r.span.lo < s->hi - s->lo)) return;
    r.span.method = s->method;
    r.span.iterations += s->iterations;
    *s = r.span;
}

/* ---- rough depth ---- */

/* Bounds from a tetrahedron that holds the origin. */

/* Twice a face's area, of the square of the size: with less its normal is not sure enough. A normal is off by at most a
 * few roundings of the square of the size, relative to that area; so its plane by far less than the slack. */
#define LEAST_AREA 0x1p-20
#define PLANE_SLACK 0x1p-24

enum { FACES = 4 };

typedef struct face {
    vec3 out; /* unit, away from the fourth corner */
    double offset;
} face;

static bool face_of(const simplex *s, int opposite, double size, face *out)
{
    vec3 a = s->v[(opposite + 1) % FACES].w, b = s->v[(opposite + 2) % FACES].w, c = s->v[(opposite + 3) % FACES].w;
    vec3 n = triangle_normal(a, b, c);
    double norm = vec_norm(n);
    if (!(norm >= LEAST_AREA * size * size)) return false;
    double side = vec_dot(n, vec_sub(s->v[opposite].w, a)) > 0 ? -1 : 1;
    out->out = vec_scale(n, side / norm);
    out->offset = vec_dot(out->out, a);
    return true;
}

/* The point along the known axis; or, for a measure, along the best of it and of those of the faces. */
static minkowski raise_by_faces(const unit_pair *p, bool measured, const face *faces, span *out)
{
    support_hints hints = NO_HINTS;
    minkowski top = unit_pair_nearest_from(p, out->axis, &hints), m;
    for (int i = 0; measured && i < FACES; i++) {
        vec3 axis = vec_neg(faces[i].out);
        unit_pair_nearest_to(p, axis, &hints, &m);
        double separation = vec_dot(axis, m.w);
        if (!(separation > out->lo)) continue;
        out->lo = separation;
        out->axis = axis;
        top = m;
    }
    return top;
}

bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    face faces[FACES];
    double least = INFINITY;
    if (start->state != GJK_INSIDE || start->simplex.count < FACES) return false;
    for (int i = 0; i < FACES; i++) {
        if (!face_of(&start->simplex, i, p->size, &faces[i])) return false;
        least = min_of(least, faces[i].offset);
    }
    double inside = least - PLANE_SLACK * p->size;
    if (!(inside > 0)) return false;
    span found = *out;
    minkowski top = raise_by_faces(p, goal->near == -INFINITY, faces, &found);
    found.hi = max_of(-inside, found.lo);
    found.iterations += FACES;
    found.point_a = top.a;
    found.point_b = top.b;
    if (!narrow_goal_reached(goal, found.lo, found.hi)) return false;
    *out = found;
    return true;
}

/* ---- moved apart ---- */

/* B is moved along the axis by twice the overlap that it proves, which leaves a gap; the axis of that gap
 * is known for certain, and it is off from the one that is looked for by as much as the surface bends over so short a
 * way. So the overlap along it is about the square of the overlap before, over the radius of the bend. */

enum { ROUNDS_MAX = 8 };

#define ALMOST_NOTHING 0x1p-10 /* of the size: deeper overlaps have other nearest faces */

void moved_apart_raise(const unit_pair *p, span *s)
{
    for (int k = 0; k < ROUNDS_MAX && s->lo < 0 && s->hi - s->lo > p->error; k++) {
        if (-s->lo > ALMOST_NOTHING * p->size) return;
        unit_pair moved = *p;
        moved.b_in_a.t = vec_madd(p->b_in_a.t, max_of(-2 * s->lo, 4 * p->error), s->axis);
        const narrow_goal measure = {p->error, p->error, INFINITY, -INFINITY, -INFINITY, INFINITY, false};
        gjk_result r;
        gjk_distance(&moved, &measure, s->axis, &r);
        s->iterations += r.span.iterations;
        if (r.state != GJK_APART) return;
        double proved = vec_dot(r.span.axis, unit_pair_nearest_along(p, r.span.axis).w);
        if (!(proved > s->lo)) return;
        s->lo = min_of(proved, s->hi);
        s->axis = r.span.axis;
    }
}

/* ==== the simplex ==== */

/* Nearest point of up to four points to the origin, by brute force over their faces. */

/* The nearest feature so far: its points by index, ascending, and their weights. */
typedef struct nearest {
    double norm2;
    vec3 point, normal; /* normal: of a face */
    double weight[3];
    int index[3], count;
} nearest;

static inline void start_at_vertex(nearest *best, const vec3 *p, int i)
{
    best->norm2 = vec_norm2(p[i]);
    best->point = p[i];
    best->normal = VEC_ZERO;
    best->weight[0] = 1;
    best->index[0] = i;
    best->count = 1;
}

/* Nothing when the projection of the origin is not between the two points. */
static inline void simplex_try_edge(nearest *best, const vec3 *p, int i, int j)
{
    vec3 e = vec_sub(p[j], p[i]);
    double to_j = -vec_dot(p[i], e), to_i = vec_dot(p[j], e);
    if (!(to_i > 0 && to_j > 0)) return;
    double whole = 1 / (to_i + to_j), weight_i = to_i * whole, weight_j = to_j * whole;
    vec3 point = vec_madd(vec_scale(p[i], weight_i), weight_j, p[j]);
    double norm2 = vec_norm2(point);
    if (!(norm2 < best->norm2)) return;
    best->norm2 = norm2;
    best->point = point;
    best->weight[0] = weight_i, best->weight[1] = weight_j;
    best->index[0] = i, best->index[1] = j;
    best->count = 2;
}

/* `n`: the triangle's normal. False when the projection of the origin is outside, or the triangle is a line. */
static inline bool simplex_try_face(nearest *best, const vec3 *p, vec3 n, int i, int j, int k)
{
    double w0 = vec_dot(n, vec_cross(p[j], p[k])), w1 = vec_dot(n, vec_cross(p[k], p[i]));
    double w2 = vec_dot(n, vec_cross(p[i], p[j]));
    if (!(w0 > 0 && w1 > 0 && w2 > 0)) return false;
    double whole = 1 / (w0 + w1 + w2);
    w0 *= whole, w1 *= whole, w2 *= whole;
    vec3 point = vec_madd(vec_madd(vec_scale(p[i], w0), w1, p[j]), w2, p[k]);
    double norm2 = vec_norm2(point);
    if (!(norm2 < best->norm2)) return false;
    best->norm2 = norm2;
    best->point = point;
    best->normal = n;
    best->weight[0] = w0, best->weight[1] = w1, best->weight[2] = w2;
    best->index[0] = i, best->index[1] = j, best->index[2] = k;
    best->count = 3;
    return true;
}

/* A triangle is fat when its normal is certain: then a nearest point inside needs no comparison with the edges. */
#define FAT_SINE2 1e-12

static inline bool is_fat(const vec3 *p, vec3 normal, int i, int j, int k)
{
    double l_ij = vec_norm2(vec_sub(p[j], p[i])), l_jk = vec_norm2(vec_sub(p[k], p[j]));
    return vec_norm2(normal) > FAT_SINE2 * l_ij * l_jk;
}

/* Orthogonal to the edge, twice: the first pass loses what cancels when the edge passes close to the origin. */
static vec3 edge_axis(const nearest *best, const vec3 *p)
{
    vec3 e = vec_sub(p[best->index[1]], p[best->index[0]]), n = best->point;
    double per_length2 = 1 / vec_norm2(e);
    n = vec_madd(n, -vec_dot(n, e) * per_length2, e);
    return vec_madd(n, -vec_dot(n, e) * per_length2, e);
}

/* Points at distance zero have no direction of their own; any is as good. */
static vec3 outward_axis(const nearest *best, const vec3 *p)
{
    vec3 along = best->count == 3 ? best->normal : best->count == 2 ? edge_axis(best, p) : best->point;
    vec3 axis = direction_of(along);
    if (!(vec_norm2(axis) > 0)) return vec(1, 0, 0);
    return vec_dot(axis, best->point) < 0 ? vec_neg(axis) : axis;
}

/* Four points and the origin. `share`: of the tetrahedra with the origin in place of one point; their sum is the whole.
 * A whole within rounding of flat says nothing. */
typedef struct tetrahedron {
    double share[4], whole;
    bool flat;
} tetrahedron;

static tetrahedron tetrahedron_of(const vec3 *p)
{
    vec3 p12 = vec_cross(p[1], p[2]), p31 = vec_cross(p[3], p[1]), p23 = vec_cross(p[2], p[3]);
    vec3 e1 = vec_sub(p[1], p[0]), e2 = vec_sub(p[2], p[0]), e3 = vec_sub(p[3], p[0]);
    double noise = 64 * UNIT_ROUNDOFF, cube2 = vec_norm2(e1) * vec_norm2(e2) * vec_norm2(e3);
    tetrahedron t = {.share = {-vec_dot(p[1], p23), vec_dot(p[0], p23), vec_dot(p[0], p31), vec_dot(p[0], p12)},
        .whole = vec_dot(e1, vec_cross(e3, e2))};
    t.flat = t.whole * t.whole <= noise * noise * cube2;
    return t;
}

double origin_volume(vec3 p0, vec3 p1, vec3 p2)
{
    return dd3_dot_vec(dd3_cross(dd3_of(p1), dd3_of(p2)), p0).hi;
}

/* Of a long tetrahedron, rounding can be more than a share: it is in doubt then. */
static bool is_sure(const tetrahedron *t, const vec3 *p)
{
    double far2 = vec_norm2(p[0]), least = fabs(t->share[0]);
    for (int i = 1; i < 4; i++) {
        far2 = max_of(far2, vec_norm2(p[i]));
        least = min_of(least, fabs(t->share[i]));
    }
    return least > 16 * UNIT_ROUNDOFF * far2 * sqrt(far2);
}

static bool same_sign(const double v[4])
{
    return (v[0] >= 0 && v[1] >= 0 && v[2] >= 0 && v[3] >= 0) || (v[0] <= 0 && v[1] <= 0 && v[2] <= 0 && v[3] <= 0);
}

/* All shares have the sign of the whole: they are the origin's weights. What is said to hold it does. */
static bool holds_origin(tetrahedron *t, const vec3 *p, double weight[4])
{
    double *v = t->share;
    if (t->flat || !same_sign(v)) return false;
    if (!is_sure(t, p)) {
        v[0] = -origin_volume(p[1], p[2], p[3]), v[1] = origin_volume(p[0], p[2], p[3]);
        v[2] = origin_volume(p[0], p[3], p[1]), v[3] = origin_volume(p[0], p[1], p[2]);
    }
    double sum = v[0] + v[1] + v[2] + v[3];
    if (!same_sign(v) || sum == 0) return false;
    for (int i = 0; i < 4; i++) weight[i] = v[i] / sum;
    return true;
}

/* Is the origin clearly on the inner side of the face without point k? Then the nearest point is not on it. */
#define INNER_SHARE 1e-9
static bool hidden(const tetrahedron *t, int k)
{
    return !t->flat && t->share[k] * t->whole > INNER_SHARE * t->whole * t->whole;
}

static bool surely_seen(const tetrahedron *t, int k)
{
    return !t->flat && t->share[k] * t->whole < -INNER_SHARE * t->whole * t->whole;
}

/* The faces and edges at p[3]; those between hidden faces only cannot win. The foot of the origin on a face that it
 * sees, if it is inside, is the nearest point of all: the tetrahedron is convex. */
static void search_tetrahedron(nearest *best, const vec3 *p, const tetrahedron *t)
{
    bool seen[3] = {!hidden(t, 0), !hidden(t, 1), !hidden(t, 2)};
    for (int k = 0; k < 3; k++) {
        int i = k == 0 ? 1 : 0, j = k == 2 ? 1 : 2;
        if (!seen[k]) continue;
        vec3 n = triangle_normal(p[i], p[j], p[3]);
        if (simplex_try_face(best, p, n, i, j, 3) && surely_seen(t, k) && is_fat(p, n, i, j, 3)) return;
    }
    for (int k = 0; k < 3; k++)
        if (seen[(k + 1) % 3] || seen[(k + 2) % 3]) simplex_try_edge(best, p, k, 3);
}

static void search_triangle(nearest *best, const vec3 *p)
{
    vec3 n = triangle_normal(p[0], p[1], p[2]);
    if (simplex_try_face(best, p, n, 0, 1, 2) && is_fat(p, n, 0, 1, 2)) return;
    simplex_try_edge(best, p, 0, 2);
    simplex_try_edge(best, p, 1, 2);
}

static void simplex_keep(simplex *s, const nearest *best)
{
    for (int i = 0; i < best->count; i++) {
        if (best->index[i] != i) s->v[i] = s->v[best->index[i]];
        s->weight[i] = best->weight[i];
    }
    s->count = best->count;
}

nearest_feature simplex_reduce(simplex *s)
{
    const vec3 p[4] = {s->v[0].w, s->v[1].w, s->v[2].w, s->v[3].w};
    nearest best;
    start_at_vertex(&best, p, s->count - 1);
    if (s->count == 4) {
        tetrahedron t = tetrahedron_of(p);
        if (holds_origin(&t, p, s->weight)) return (nearest_feature){.inside = true};
        search_tetrahedron(&best, p, &t);
    } else if (s->count == 3) {
        search_triangle(&best, p);
    } else if (s->count == 2) {
        simplex_try_edge(&best, p, 0, 1);
    }
    vec3 axis = outward_axis(&best, p);
    simplex_keep(s, &best);
    return (nearest_feature){.point = best.point, .norm = sqrt(best.norm2), .axis = axis};
}

static void simplex_try_edges(nearest *best, const vec3 *p)
{
    for (int i = 0; i < 3; i++)
        if (vec_norm2(p[i]) < best->norm2) start_at_vertex(best, p, i);
    simplex_try_edge(best, p, 0, 1);
    simplex_try_edge(best, p, 1, 2);
    simplex_try_edge(best, p, 0, 2);
}

/* Of a thin triangle rounding may have missed that the origin's foot is on the face: then the edge that was found is
 * too far, and corners are less high above the origin than it, along its own direction. The least of them is a lower
 * bound, and so is the height of the plane. */
static double edge_or_less(const vec3 p[3], double distance, vec3 axis, vec3 normal)
{
    double along = INFINITY, plane = INFINITY, size = 0;
    for (int i = 0; i < 3; i++) {
        along = min_of(along, vec_dot(axis, p[i]));
        plane = min_of(plane, fabs(vec_dot(normal, p[i])));
        size = max_of(size, vec_greatest(p[i]));
    }
    return along >= distance - 16 * UNIT_ROUNDOFF * size ? distance : min_of(distance, max_of(along, plane));
}

double triangle_nearest(vec3 p0, vec3 p1, vec3 p2, double weight[3], vec3 *normal, vec3 *axis)
{
    const vec3 p[3] = {p0, p1, p2};
    nearest best = {.norm2 = INFINITY};
    vec3 n = triangle_normal(p0, p1, p2);
    if (!simplex_try_face(&best, p, n, 0, 1, 2) || !is_fat(p, n, 0, 1, 2)) simplex_try_edges(&best, p);
    weight[0] = weight[1] = weight[2] = 0;
    for (int i = 0; i < best.count; i++) weight[best.index[i]] = best.weight[i];
    *normal = direction_of(n);
    *axis = best.count == 3 ? *normal : direction_of(best.point);
    /* On a face a weight errs by u / |n|, and the point slides in the plane: of a thin triangle close to the origin
     * farther than it is away. The height of the plane at that point knows nothing of it, nor is it ever more. */
    if (best.count == 3) return fabs(vec_dot(*normal, best.point));
    return edge_or_less(p, sqrt(best.norm2), *axis, *normal);
}

void simplex_witness(const simplex *s, vec3 *point_a, vec3 *point_b)
{
    vec3 a = vec_scale(s->v[0].a, s->weight[0]), b = vec_scale(s->v[0].b, s->weight[0]);
    for (int i = 1; i < s->count; i++) {
        a = vec_madd(a, s->weight[i], s->v[i].a);
        b = vec_madd(b, s->weight[i], s->v[i].b);
    }
    *point_a = a;
    *point_b = b;
}
