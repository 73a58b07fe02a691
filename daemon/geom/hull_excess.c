/* Is a point p in a hull, and if not, how far out at most? A point o strictly inside is known from four vertices. The
 * ray from o through p leaves the polytope by some face, which a walk over the faces finds. The corners of a triangle
 * of that face and o are a tetrahedron in the hull, and exact signs say whether p is in it. If not, p is beyond the
 * face: its distance from it is an upper bound, whatever face it is. */
#include "hull_excess.h"

#include "base/array.h"
#include "expansion.h"
#include "round.h"

#include <stdlib.h>

/* Of unit size, with no digit below 2^-352: products of three differences are exact (and of a share, two). */
static const double LEAST_COORDINATE = 0x1p-300;

/* What taking smaller coordinates for 0 moves a point and a face by. */
static const double SNAPPED = 0x1p-297;

typedef struct body {
    const hull *h;
    const vec3 *vertex;
    vec3 inside;        /* o; strictly in the hull of four vertices, if `has_inside` */
    bool has_inside;    /* else no point is shown to be inside */
    uint32_t *adjacent; /* of face f from its `first` on: the faces beyond its sides, from corner i to i + 1 */
} body;

typedef struct sum { /* an expansion without zeros */
    int count;
    double at[192];
} sum;

static void sum_grow(sum *s, double b)
{
    double carry = b, rest;
    int kept = 0;
    for (int i = 0; i < s->count; i++) {
        expansion_two_sum(carry, s->at[i], &carry, &rest);
        if (rest != 0) s->at[kept++] = rest;
    }
    if (carry != 0) s->at[kept++] = carry;
    s->count = kept;
}

static void sum_grow_product(sum *s, double a, double b)
{
    double product, rest;
    expansion_two_product(a, b, &product, &rest);
    sum_grow(s, rest);
    sum_grow(s, product);
}

static void sum_add_scaled(sum *s, const sum *t, double b)
{
    for (int i = 0; b != 0 && i < t->count; i++) sum_grow_product(s, t->at[i], b);
}

/* Relative error: less than 4 u, for growing by two-sums leaves no neighbouring bits. */
static double sum_estimate(const sum *s)
{
    double total = 0;
    for (int i = 0; i < s->count; i++) total += s->at[i];
    return total;
}

typedef struct difference { /* hi + lo, exactly */
    double hi[3], lo[3];
} difference;

static difference difference_of(vec3 a, vec3 b)
{
    difference d;
    expansion_two_sum(a.x, -b.x, &d.hi[0], &d.lo[0]);
    expansion_two_sum(a.y, -b.y, &d.hi[1], &d.lo[1]);
    expansion_two_sum(a.z, -b.z, &d.hi[2], &d.lo[2]);
    return d;
}

static void grow_by_minor(sum *s, const difference *b, const difference *c, int i, int j, double sign)
{
    const double left[2] = {b->lo[i], b->hi[i]}, right[2] = {sign * c->lo[j], sign * c->hi[j]};
    for (int k = 0; k < 4; k++)
        if (left[k / 2] != 0 && right[k % 2] != 0) sum_grow_product(s, left[k / 2], right[k % 2]);
}

/* b x c, component k. */
static void minor_of(const difference *b, const difference *c, int k, sum *out)
{
    int i = (k + 1) % 3, j = (k + 2) % 3;
    out->count = 0;
    grow_by_minor(out, b, c, i, j, 1);
    grow_by_minor(out, b, c, j, i, -1);
}

/* Six volumes of the tetrahedron: > 0 where d is on the inner side of a, b, c, counter-clockwise from outside. */
static void volume_of(vec3 a, vec3 b, vec3 c, vec3 d, sum *out)
{
    difference da = difference_of(a, d), db = difference_of(b, d), dc = difference_of(c, d);
    sum minor;
    out->count = 0;
    for (int k = 0; k < 3; k++) {
        minor_of(&db, &dc, k, &minor);
        sum_add_scaled(out, &minor, da.lo[k]);
        sum_add_scaled(out, &minor, da.hi[k]);
    }
}

static int sign_of(const sum *s)
{
    return s->count == 0 ? 0 : s->at[s->count - 1] > 0 ? 1 : -1;
}

/* Shewchuk's orient3d: doubles where 8 u of the greatest sum of products (his bound is a little above 7) say enough. */
static int side_of_plane(vec3 a, vec3 b, vec3 c, vec3 d)
{
    vec3 p = vec_sub(a, d), q = vec_sub(b, d), r = vec_sub(c, d);
    double most = (fabs(q.y * r.z) + fabs(q.z * r.y)) * fabs(p.x) + (fabs(q.z * r.x) + fabs(q.x * r.z)) * fabs(p.y) +
                  (fabs(q.x * r.y) + fabs(q.y * r.x)) * fabs(p.z);
    double volume = vec_dot(p, vec_cross(q, r));
    if (volume > 8 * ROUND_U * most) return 1;
    if (volume < -8 * ROUND_U * most) return -1;
    sum exact;
    volume_of(a, b, c, d, &exact);
    return sign_of(&exact);
}

static double coordinate(vec3 v, int k)
{
    return k == 0 ? v.x : k == 1 ? v.y : v.z;
}

/* Is p in the tetrahedron of o and the triangle? */
static bool tetrahedron_holds(vec3 o, vec3 a, vec3 b, vec3 c, vec3 p)
{
    return side_of_plane(a, b, p, o) >= 0 && side_of_plane(b, c, p, o) >= 0 && side_of_plane(c, a, p, o) >= 0 &&
           side_of_plane(a, b, c, p) >= 0 && side_of_plane(a, b, c, o) > 0;
}

static vec3 corner(const body *k, const hull_face *f, uint32_t i)
{
    return k->vertex[k->h->face_vertices[f->first + i % f->count]];
}

/* Is p in the tetrahedron of o and some triangle of the face's fan about corner `start`? */
static bool face_holds(const body *k, const hull_face *f, uint32_t start, vec3 p)
{
    for (uint32_t i = 1; i + 1 < f->count; i++)
        if (tetrahedron_holds(k->inside, corner(k, f, start), corner(k, f, start + i), corner(k, f, start + i + 1), p))
            return true;
    return false;
}

/* Not below |p - q| for the q of the segment that is nearest to p but for rounding. */
static double from_side(vec3 a, vec3 b, vec3 p)
{
    vec3 along = vec_sub(b, a);
    double share = vec_dot(vec_sub(p, a), along) / vec_norm2(along), gap[3];
    if (!(share > LEAST_COORDINATE)) share = 0;
    if (share > 1) share = 1;
    for (int i = 0; i < 3; i++) {
        sum s = {.count = 0};
        sum_grow(&s, coordinate(p, i));
        sum_grow(&s, -coordinate(a, i));
        sum_grow_product(&s, coordinate(a, i), share);
        sum_grow_product(&s, -coordinate(b, i), share);
        gap[i] = sum_estimate(&s);
    }
    return length_up(vec(gap[0], gap[1], gap[2])) * (1 + 8 * ROUND_U);
}

static int greatest_axis(vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

/* Seen along an axis: the area, with a sign, of p, q, r. */
static void exact_area_of(vec3 p, vec3 q, vec3 r, int axis, sum *out)
{
    difference b = difference_of(q, p), c = difference_of(r, p);
    minor_of(&b, &c, axis, out);
}

/* Not below the distance along the axis; INFINITY where the triangle is not above, below or at p. */
static double from_triangle(vec3 a, vec3 b, vec3 c, int axis, vec3 p)
{
    const vec3 corners[3] = {a, b, c};
    int seen = 0;
    sum area, volume;
    for (int i = 0; i < 3; i++) {
        exact_area_of(corners[i], corners[(i + 1) % 3], p, axis, &area);
        int side = sign_of(&area);
        if (side * seen < 0) return INFINITY;
        if (side) seen = side;
    }
    exact_area_of(a, b, c, axis, &area);
    if (area.count == 0) return INFINITY;
    volume_of(a, b, c, p, &volume);
    if (volume.count == 0) return 0;
    return fabs(sum_estimate(&volume) / sum_estimate(&area)) * (1 + 16 * ROUND_U) + DBL_TRUE_MIN; /* if subnormal */
}

/* Not below the distance of p from the face. */
static double from_face(const body *k, const hull_face *f, uint32_t start, vec3 p)
{
    int axis = greatest_axis(f->normal);
    double least = INFINITY;
    for (uint32_t i = 1; i + 1 < f->count; i++)
        least = fmin(
            least, from_triangle(corner(k, f, start), corner(k, f, start + i), corner(k, f, start + i + 1), axis, p));
    bool beside = least == INFINITY;
    for (uint32_t i = 0; beside && i < f->count; i++)
        least = fmin(least, from_side(corner(k, f, i), corner(k, f, i + 1), p));
    return least;
}

/* Is p, seen from o, not to the right of the line from corner i to corner j? */
static bool is_left(const body *k, const hull_face *f, uint32_t i, uint32_t j, vec3 p)
{
    return side_of_plane(corner(k, f, i), corner(k, f, j), p, k->inside) >= 0;
}

/* Of the fan about corner 0: the i of the triangle 0, i, i + 1 in whose wedge p is, seen from o. In the logarithm of
 * the corners; p is not beyond the sides at corner 0. */
static uint32_t wedge_of(const body *k, const hull_face *f, vec3 p)
{
    uint32_t low = 1, high = f->count - 1;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        if (is_left(k, f, 0, middle, p))
            low = middle;
        else
            high = middle;
    }
    return low;
}

static const uint32_t NOWHERE = UINT32_MAX;

/* A side that p is beyond, seen from o; NOWHERE: p is beyond none. */
static uint32_t side_beyond(const body *k, const hull_face *f, vec3 p)
{
    if (!is_left(k, f, 0, 1, p)) return 0;
    if (!is_left(k, f, f->count - 1, 0, p)) return f->count - 1;
    uint32_t i = wedge_of(k, f, p);
    return is_left(k, f, i, i + 1, p) ? NOWHERE : i;
}

/* The face by which the ray from o through p leaves: inside of the planes through o and its sides. Each step over a
 * side that p is beyond leads to a face whose plane the ray meets earlier, so that it ends; but for faces that are
 * convex only to rounding, of which it might turn in a circle: NOWHERE. */
static uint32_t walk(const body *k, uint32_t from, vec3 p)
{
    for (uint32_t steps = 0; steps < k->h->face_count; steps++) {
        const hull_face *f = &k->h->faces[from];
        uint32_t i = side_beyond(k, f, p);
        if (i == NOWHERE) return from;
        from = k->adjacent[f->first + i];
    }
    return NOWHERE;
}

/* Not below the distance of p from the hull; 0 where it is known to be in it. For want of a walk. */
static double outside_of_all(const body *k, vec3 p)
{
    double least = INFINITY;
    for (uint32_t f = 0; f < k->h->face_count; f++) {
        if (k->has_inside && face_holds(k, &k->h->faces[f], 0, p)) return 0;
        least = fmin(least, from_face(k, &k->h->faces[f], 0, p));
    }
    return least;
}

enum {
    FANS_MAX = 8,     /* of a face whose corners are not in one plane: triangles between any of them are in the hull */
    MANY_CORNERS = 64 /* of a face of which not all triangles are looked at for each point */
};

/* By the triangle that p is above, and its neighbours. */
static double outside_of_wedge(const body *k, const hull_face *f, vec3 p)
{
    int axis = greatest_axis(f->normal);
    uint32_t middle = wedge_of(k, f, p), first = middle > 1 ? middle - 1 : 1;
    double least = INFINITY;
    for (uint32_t i = first; i <= middle + 1 && i + 1 < f->count; i++) {
        if (tetrahedron_holds(k->inside, corner(k, f, 0), corner(k, f, i), corner(k, f, i + 1), p)) return 0;
        least = fmin(least, from_triangle(corner(k, f, 0), corner(k, f, i), corner(k, f, i + 1), axis, p));
    }
    return least;
}

/* Of p beyond the face. When it is found not to be above `known`, it is not made less. */
static double outside_of_face(const body *k, const hull_face *f, vec3 p, double known)
{
    double least = f->count > MANY_CORNERS ? outside_of_wedge(k, f, p) : INFINITY;
    if (least < INFINITY) return least;
    uint32_t fans = f->count == 3 ? 1 : f->count < FANS_MAX ? f->count : FANS_MAX;
    for (uint32_t start = 0; start < fans && least > known; start++) {
        if (face_holds(k, f, start, p)) return 0;
        least = fmin(least, from_face(k, f, start, p));
    }
    return least;
}

/* The vertex farthest from what is known: a point, a line, a plane. */
static uint32_t farthest_vertex(const body *k, const vec3 *known, int count)
{
    uint32_t best = 0;
    double most = -1;
    for (uint32_t i = 0; i < k->h->vertex_count; i++) {
        vec3 d = vec_sub(k->vertex[i], known[0]);
        double far = count == 1 ? vec_norm2(d)
                     : count == 2
                         ? vec_norm2(vec_cross(vec_sub(known[1], known[0]), d))
                         : fabs(vec_dot(vec_cross(vec_sub(known[1], known[0]), vec_sub(known[2], known[0])), d));
        if (far > most) most = far, best = i;
    }
    return best;
}

static void find_inside(body *k)
{
    vec3 v[4] = {k->vertex[0]};
    for (int i = 1; i < 4; i++) v[i] = k->vertex[farthest_vertex(k, v, i)];
    k->inside = vec_scale(vec_add(vec_add(v[0], v[1]), vec_add(v[2], v[3])), 0.25);
    int way = side_of_plane(v[0], v[1], v[2], v[3]);
    k->has_inside = way != 0 && side_of_plane(v[0], v[1], v[2], k->inside) == way &&
                    side_of_plane(v[0], v[3], v[1], k->inside) == way &&
                    side_of_plane(v[1], v[3], v[2], k->inside) == way &&
                    side_of_plane(v[2], v[3], v[0], k->inside) == way;
}

/* Edges are in the order of their vertices. */
static const hull_edge *edge_between(const hull *h, uint32_t a, uint32_t b)
{
    uint32_t v0 = a < b ? a : b, v1 = a < b ? b : a, low = 0, high = h->edge_count;
    while (high - low > 1) {
        uint32_t middle = low + (high - low) / 2;
        const hull_edge *e = &h->edges[middle];
        if (e->v0 < v0 || (e->v0 == v0 && e->v1 <= v1))
            low = middle;
        else
            high = middle;
    }
    return &h->edges[low];
}

static uint32_t *find_adjacent(const hull *h)
{
    uint32_t *adjacent = base_alloc(2 * (size_t)h->edge_count, sizeof *adjacent);
    for (uint32_t f = 0; f < h->face_count; f++) {
        const uint32_t *loop = &h->face_vertices[h->faces[f].first], count = h->faces[f].count;
        for (uint32_t i = 0; i < count; i++) {
            const hull_edge *e = edge_between(h, loop[i], loop[(i + 1) % count]);
            adjacent[h->faces[f].first + i] = e->f0 == f ? e->f1 : e->f0;
        }
    }
    return adjacent;
}

static double without_tiny(double x, int exponent, bool *moved)
{
    double y = ldexp(x, -exponent);
    if (y == 0 || fabs(y) >= LEAST_COORDINATE) return y;
    *moved = true;
    return 0;
}

static vec3 at_unit_size(vec3 p, int exponent, bool *moved)
{
    return vec(
        without_tiny(p.x, exponent, moved), without_tiny(p.y, exponent, moved), without_tiny(p.z, exponent, moved));
}

double hull_excess_of(const hull *h, const vec3 *points, uint32_t count)
{
    if (count == 0) return 0;
    int exponent;
    bool moved = false;
    frexp(h->max_abs, &exponent);
    vec3 *vertex = base_alloc(h->vertex_count, sizeof *vertex);
    for (uint32_t i = 0; i < h->vertex_count; i++) vertex[i] = at_unit_size(hull_vertex(h, i), exponent, &moved);
    body k = {.h = h, .vertex = vertex, .adjacent = find_adjacent(h)};
    find_inside(&k);
    double most = 0;
    uint32_t last = 0;
    for (uint32_t i = 0; i < count; i++) {
        vec3 p = at_unit_size(points[i], exponent, &moved);
        uint32_t face = k.has_inside ? walk(&k, last, p) : NOWHERE;
        most = fmax(most, face == NOWHERE ? outside_of_all(&k, p) : outside_of_face(&k, &h->faces[face], p, most));
        if (face != NOWHERE) last = face;
    }
    free(k.adjacent);
    free(vertex);
    if (moved) most = add_up(most, SNAPPED);
    double real = ldexp(most, exponent);
    return ldexp(real, -exponent) < most ? next_above(real) : real;
}
