/* hull_features: the formulas for vertices, edges and triangles of two hulls, and the proof that nothing else is as
 * near (features.h); where they overlap, A may also be a box. Pure; any thread. */
#include "features.h"
#include "geom/hull_scan.h"
#include "gjk.h"
#include "narrow/math/scalar.h"
#include "polytopes.h"

enum { SIDE_MOST = 3, BOTH_MOST = 4 };

/* The vertices of a feature pair in A's frame, and what the formula makes of them. */
typedef struct meeting {
    vec3 a[SIDE_MOST], b[SIDE_MOST];
    int count_a, count_b;
    double weight_a[SIDE_MOST], weight_b[SIDE_MOST];
    vec3 n;        /* unit, from A towards B */
    double inside; /* of a facet of B - A: how far the nearest point is inside of it, at least */
} meeting;

static bool are_vertices(const hull *h, const uint16_t *vertex, uint8_t count)
{
    for (uint8_t i = 0; i < count; i++)
        if (vertex[i] >= h->vertex_count || (i && vertex[i] <= vertex[i - 1])) return false;
    return true;
}

/* ---- a box as A: for each of its axes the side, or between (features.h) ---- */

static const double SIGN[NEAR_SIDES] = {0, 1, -1};

static inline void put_along(vec3 *v, int axis, double x)
{
    *(axis == 0 ? &v->x : axis == 1 ? &v->y : &v->z) = x;
}

static inline int free_axes(const uint16_t side[3])
{
    return (side[0] == NEAR_BETWEEN) + (side[1] == NEAR_BETWEEN) + (side[2] == NEAR_BETWEEN);
}

static bool are_box_features(const unit_pair *p, const narrow_features *f)
{
    if (!f->deep || f->count_a != 3) return false;
    for (int k = 0; k < 3; k++)
        if (f->a[k] >= NEAR_SIDES) return false;
    return f->count_b + free_axes(f->a) == 3 && are_vertices(p->b.hull, f->b, f->count_b);
}

/* A corner, the ends of an edge, or the middle of a face. */
static int place_box(const shape *box, const uint16_t side[3], vec3 at[2])
{
    at[0] = vec(SIGN[side[0]] * box->half.x, SIGN[side[1]] * box->half.y, SIGN[side[2]] * box->half.z);
    if (free_axes(side) != 1) return 1;
    int axis = side[0] == NEAR_BETWEEN ? 0 : side[1] == NEAR_BETWEEN ? 1 : 2;
    double half = vec_at(box->half, axis);
    at[1] = at[0];
    put_along(&at[0], axis, -half);
    put_along(&at[1], axis, half);
    return 2;
}

/* A vertex of B below a face of A. */
static bool nearest_on_side(const shape *box, const uint16_t side[3], meeting *m)
{
    int axis = side[0] != NEAR_BETWEEN ? 0 : side[1] != NEAR_BETWEEN ? 1 : 2;
    vec3 face = m->a[0];
    m->a[0] = m->b[0];
    put_along(&m->a[0], axis, vec_at(face, axis));
    m->n = VEC_ZERO;
    put_along(&m->n, axis, SIGN[side[axis]]);
    m->inside = INFINITY;
    for (int k = 0; k < 3; k++)
        if (k != axis) m->inside = min_of(m->inside, vec_at(box->half, k) - fabs(vec_at(m->b[0], k)));
    return m->inside > 0;
}

/* Is the box higher at the sides that are named than at those across, by more than the margin? */
static bool are_top_sides(const shape *box, vec3 n, double margin, const uint16_t side[3])
{
    for (int k = 0; k < 3; k++)
        if (side[k] != NEAR_BETWEEN && !(2 * SIGN[side[k]] * vec_at(n, k) * vec_at(box->half, k) > margin))
            return false;
    return true;
}

static void hull_features_sides_along(const shape *box, vec3 n, double slab, uint16_t side[3])
{
    for (int k = 0; k < 3; k++) {
        double higher = 2 * vec_at(n, k) * vec_at(box->half, k);
        side[k] = higher > slab ? NEAR_HIGH : higher < -slab ? NEAR_LOW : NEAR_BETWEEN;
    }
}

/* ---- two hulls, or one and a box ---- */

static bool are_features(const unit_pair *p, const narrow_features *f)
{
    if (p->a.type == SHAPE_BOX) return are_box_features(p, f);
    if (f->count_a < 1 || f->count_b < 1 || f->count_a > SIDE_MOST || f->count_b > SIDE_MOST) return false;
    return f->count_a + f->count_b <= BOTH_MOST && are_vertices(p->a.hull, f->a, f->count_a) &&
           are_vertices(p->b.hull, f->b, f->count_b);
}

static void hull_features_place(const unit_pair *p, const narrow_features *f, meeting *m)
{
    m->count_a = f->count_a, m->count_b = f->count_b;
    if (p->a.type == SHAPE_BOX)
        m->count_a = place_box(&p->a, f->a, m->a);
    else
        for (uint8_t i = 0; i < f->count_a; i++) m->a[i] = vec_scale(hull_vertex(p->a.hull, f->a[i]), p->scale);
    for (uint8_t i = 0; i < f->count_b; i++)
        m->b[i] = transform_point(&p->b_in_a, vec_scale(hull_vertex(p->b.hull, f->b[i]), p->scale));
}

static double hull_features_least_of(const double *weight, int count)
{
    double least = weight[0];
    for (int i = 1; i < count; i++) least = min_of(least, weight[i]);
    return least;
}

static bool are_inside(const double *weight, int count)
{
    return hull_features_least_of(weight, count) > NEAR_WEIGHT_MARGIN;
}

/* From A towards B: towards w when they are apart, away from it when they overlap. */
static vec3 outward(vec3 n, vec3 w, bool deep)
{
    return (vec_dot(n, w) < 0) != deep ? vec_neg(n) : n;
}

/* An edge and a vertex: `w` are the edge's ends in B - A. Made orthogonal to the edge twice, as in gjk.c. */
static bool hull_features_nearest_on_edge(const vec3 w[2], double least2, double weight[2], vec3 *n)
{
    vec3 e = vec_sub(w[1], w[0]);
    double to_1 = -vec_dot(w[0], e), to_0 = vec_dot(w[1], e), length2 = vec_norm2(e);
    if (!(length2 > least2)) return false;
    double whole = 1 / (to_0 + to_1), per_length2 = 1 / length2;
    weight[0] = to_0 * whole, weight[1] = to_1 * whole;
    vec3 point = vec_madd(vec_scale(w[0], weight[0]), weight[1], w[1]);
    point = vec_madd(point, -vec_dot(point, e) * per_length2, e);
    *n = direction_of(vec_madd(point, -vec_dot(point, e) * per_length2, e));
    return are_inside(weight, 2);
}

static bool nearest_on_triangle(const vec3 w[3], double least2, bool deep, double weight[3], meeting *m)
{
    vec3 across = triangle_normal(w[0], w[1], w[2]);
    double longest2 =
        max_of(max_of(vec_norm2(vec_sub(w[1], w[0])), vec_norm2(vec_sub(w[2], w[1]))), vec_norm2(vec_sub(w[0], w[2])));
    if (!(longest2 > least2) || !(vec_norm2(across) > NEAR_SLIVER2 * longest2 * longest2)) return false;
    weight[0] = vec_dot(across, vec_cross(w[1], w[2]));
    weight[1] = vec_dot(across, vec_cross(w[2], w[0]));
    weight[2] = vec_dot(across, vec_cross(w[0], w[1]));
    double whole = 1 / (weight[0] + weight[1] + weight[2]);
    for (int i = 0; i < 3; i++) weight[i] *= whole;
    double area2 = vec_norm2(across);
    m->inside = hull_features_least_of(weight, 3) * sqrt(area2 / longest2);
    m->n = outward(direction_of(across), w[0], deep);
    return are_inside(weight, 3);
}

/* a0 + s ea + d n = b0 + t eb: cross the differences of the first ends with the other edge. */
static bool nearest_edges(meeting *m, double least2, bool deep)
{
    vec3 ea = vec_sub(m->a[1], m->a[0]), eb = vec_sub(m->b[1], m->b[0]), r = vec_sub(m->b[0], m->a[0]);
    vec3 across = vec_cross(ea, eb);
    double a2 = vec_norm2(ea), b2 = vec_norm2(eb), across2 = vec_norm2(across);
    if (!(a2 > least2) || !(b2 > least2) || !(across2 > NEAR_SLIVER2 * a2 * b2)) return false;
    double per2 = 1 / across2, s = vec_dot(vec_cross(r, eb), across) * per2;
    double t = vec_dot(vec_cross(r, ea), across) * per2;
    m->weight_a[0] = 1 - s, m->weight_a[1] = s;
    m->weight_b[0] = 1 - t, m->weight_b[1] = t;
    m->inside = min_of(hull_features_least_of(m->weight_a, 2), hull_features_least_of(m->weight_b, 2)) *
                sqrt(across2 / max_of(a2, b2));
    m->n = outward(direction_of(across), r, deep);
    return are_inside(m->weight_a, 2) && are_inside(m->weight_b, 2);
}

static bool hull_features_meet(const unit_pair *p, const narrow_features *f, meeting *m)
{
    double least2 = NEAR_SLIVER2 * p->size * p->size;
    vec3 w[SIDE_MOST];
    m->weight_a[0] = m->weight_b[0] = 1;
    if (m->count_a == 2 && m->count_b == 2) return nearest_edges(m, least2, f->deep);
    if (p->a.type == SHAPE_BOX && m->count_b == 1) return nearest_on_side(&p->a, f->a, m);
    bool on_a = m->count_a > 1;
    int count = on_a ? m->count_a : m->count_b;
    double *weight = on_a ? m->weight_a : m->weight_b;
    for (int i = 0; i < count; i++) w[i] = vec_sub(m->b[on_a ? 0 : i], m->a[on_a ? i : 0]);
    if (count == 3) return nearest_on_triangle(w, least2, f->deep, weight, m);
    if (f->deep) return false;
    if (count == 2) return hull_features_nearest_on_edge(w, least2, weight, &m->n);
    m->n = direction_of(w[0]);
    return true;
}

/* Are these all the vertices that are within the margin of the lowest of them, or higher? */
static bool are_top(const hull *h, vec3 d, double margin, const uint16_t *vertex, uint8_t count)
{
    uint16_t found[SIDE_MOST];
    double least = INFINITY;
    for (uint8_t i = 0; i < count; i++) least = min_of(least, vec_dot(hull_vertex(h, vertex[i]), d));
    if (hull_scan_above(h, d, least - margin, found, count) != count) return false;
    for (uint8_t i = 0; i < count; i++)
        if (found[i] != vertex[i]) return false;
    return true;
}

static bool is_a_top(const unit_pair *p, vec3 n, const narrow_features *f)
{
    double margin = NEAR_HEIGHT_MARGIN * p->size;
    if (p->a.type == SHAPE_BOX) return are_top_sides(&p->a, n, margin, f->a);
    return are_top(p->a.hull, n, margin * p->unit, f->a, f->count_a);
}

static vec3 mean(const vec3 *at, const double *weight, int count)
{
    vec3 sum = vec_scale(at[0], weight[0]);
    for (int i = 1; i < count; i++) sum = vec_madd(sum, weight[i], at[i]);
    return sum;
}

bool hull_features_span(const unit_pair *p, const narrow_features *f, span *out)
{
    meeting m;
    if (!are_features(p, f)) return false;
    hull_features_place(p, f, &m);
    if (!hull_features_meet(p, f, &m)) return false;
    double top_a = -INFINITY, bottom_b = INFINITY, margin = NEAR_HEIGHT_MARGIN * p->size * p->unit;
    for (int i = 0; i < m.count_a; i++) top_a = max_of(top_a, vec_dot(m.n, m.a[i]));
    for (int j = 0; j < m.count_b; j++) bottom_b = min_of(bottom_b, vec_dot(m.n, m.b[j]));
    double lo = bottom_b - top_a;
    double least = (f->deep ? NEAR_LEAST_DEPTH : NEAR_LEAST_DISTANCE) * p->size;
    if (f->deep ? !(lo <= -least && m.inside >= NEAR_INSIDE * p->size) : !(lo >= least)) return false;
    if (!is_a_top(p, m.n, f) || !are_top(p->b.hull, mat_tmul(p->b_in_a.r, vec_neg(m.n)), margin, f->b, f->count_b))
        return false;
    out->point_a = mean(m.a, m.weight_a, m.count_a);
    out->point_b = mean(m.b, m.weight_b, m.count_b);
    out->axis = m.n;
    double apart = vec_norm(vec_sub(out->point_b, out->point_a)), either_side = NEAR_DEPTH_WIDTHS * p->error;
    out->lo = f->deep ? lo - either_side : lo; /* a depth: what it is most likely is in the middle */
    out->hi = f->deep ? lo + either_side : max_of(lo, apart);
    out->method = f->deep ? NARROW_BY_EPA : NARROW_BY_GJK;
    return true;
}

static bool hull_features_top_of(const hull *h, vec3 d, double slab, uint16_t vertex[SIDE_MOST], uint8_t *count)
{
    double top = vec_dot(hull_vertex(h, hull_scan(h, d)), d);
    uint32_t found = hull_scan_above(h, d, top - slab, vertex, SIDE_MOST);
    *count = (uint8_t)found;
    return found <= SIDE_MOST;
}

bool hull_features_along(const unit_pair *p, vec3 axis, narrow_features *out)
{
    double slab = 0.5 * NEAR_HEIGHT_MARGIN * p->size, unscaled = slab * p->unit;
    if (p->a.type == SHAPE_BOX)
        out->count_a = 3, hull_features_sides_along(&p->a, axis, slab, out->a);
    else if (!hull_features_top_of(p->a.hull, axis, unscaled, out->a, &out->count_a))
        return false;
    return hull_features_top_of(p->b.hull, mat_tmul(p->b_in_a.r, vec_neg(axis)), unscaled, out->b, &out->count_b);
}

void hull_features_of(const minkowski *const *m, int count, narrow_features *out)
{
    *out = (narrow_features){.count_a = 0};
    for (int i = 0; i < count; i++) {
        hull_features_include(m[i]->vertex_a, out->a, &out->count_a);
        hull_features_include(m[i]->vertex_b, out->b, &out->count_b);
    }
}

/* The sides that all of these corners are on. */
static void hull_features_sides_of(const minkowski *const *m, int count, uint16_t side[3])
{
    uint32_t all = UINT32_MAX, any = 0;
    for (int i = 0; i < count; i++) all &= m[i]->vertex_a, any |= m[i]->vertex_a;
    for (int k = 0; k < 3; k++) side[k] = all >> k & 1 ? NEAR_HIGH : any >> k & 1 ? NEAR_BETWEEN : NEAR_LOW;
}

void hull_features_of_facet(const unit_pair *p, const minkowski *const *m, narrow_features *out)
{
    hull_features_of(m, 3, out);
    if (p->a.type == SHAPE_BOX) out->count_a = 3, hull_features_sides_of(m, 3, out->a);
}

/* ---- from where the pair was, to where it is ---- */

/* No neighbour is higher: of a hull that is sound, the highest of all. */
static uint32_t climb(const hull *h, vec3 d, uint32_t vertex)
{
    double height = vec_dot(hull_vertex(h, vertex), d);
    for (bool higher = true; higher;) {
        const uint32_t *first = h->neighbours + h->neighbour_first[vertex];
        const uint32_t *end = h->neighbours + h->neighbour_first[vertex + 1];
        higher = false;
        for (; first < end; first++) {
            double there = vec_dot(hull_vertex(h, *first), d);
            if (there > height) height = there, vertex = *first, higher = true;
        }
    }
    return vertex;
}

/* A point that is nearer along the axis joins the simplex. False if it is not, or if the simplex then holds the origin.
 */
static bool join(const unit_pair *p, simplex *s, uint32_t a, uint32_t b, nearest_feature *n)
{
    s->v[s->count] = hull_pair_of(p, a, b);
    if (s->count && !(vec_dot(n->axis, s->v[s->count].w) < n->norm - p->error)) return false;
    s->count++;
    *n = simplex_reduce(s);
    return !n->inside;
}

/* GJK (gjk.h) that begins with the vertices of `from` and climbs to support points: nothing here has to be right, for
 * what it ends at is proven afterwards. */
bool hull_features_descend(const unit_pair *p, const narrow_features *from, narrow_features *out)
{
    enum { STEPS_MOST = 24 };
    const hull *a = p->a.hull, *b = p->b.hull;
    simplex s = {.count = 0};
    nearest_feature n = {.inside = false};
    if (!are_features(p, from)) return false;
    for (int i = 0; i < from->count_a && !n.inside; i++)
        for (int k = 0; k < from->count_b && !n.inside; k++) join(p, &s, from->a[i], from->b[k], &n);
    for (int i = 0; i < STEPS_MOST && !n.inside; i++) {
        uint32_t top_a = climb(a, n.axis, s.v[0].vertex_a);
        uint32_t top_b = climb(b, mat_tmul(p->b_in_a.r, vec_neg(n.axis)), s.v[0].vertex_b);
        if (!join(p, &s, top_a, top_b, &n)) break;
    }
    if (n.inside || s.count == 0) return false;
    const minkowski *m[SIDE_MOST] = {&s.v[0], &s.v[1], &s.v[2]};
    hull_features_of(m, s.count, out); /* a simplex that does not hold the origin has three points at most */
    return true;
}

uint32_t hull_features_count(const hull *h)
{
    return h->vertex_count + h->edge_count + h->face_count;
}

static void swap_if_greater(uint16_t *x, uint16_t *y)
{
    uint16_t least = *x < *y ? *x : *y, most = *x < *y ? *y : *x;
    *x = least, *y = most;
}

uint8_t hull_feature(const hull *h, uint32_t i, uint16_t vertex[3])
{
    if (i < h->vertex_count) {
        vertex[0] = (uint16_t)i;
        return 1;
    }
    i -= h->vertex_count;
    if (i < h->edge_count) {
        vertex[0] = (uint16_t)h->edges[i].v0, vertex[1] = (uint16_t)h->edges[i].v1;
        return 2;
    }
    const hull_face *face = &h->faces[i - h->edge_count];
    if (face->count != 3) return 0;
    for (uint32_t k = 0; k < 3; k++) vertex[k] = (uint16_t)h->face_vertices[face->first + k];
    swap_if_greater(&vertex[0], &vertex[1]);
    swap_if_greater(&vertex[1], &vertex[2]);
    swap_if_greater(&vertex[0], &vertex[1]);
    return 3;
}
