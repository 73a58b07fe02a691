/* Is a point in a hull, and if not, how far out at most? A point o strictly inside is known from four vertices. The ray
 * from o through p leaves the polytope by some face; the corners of a triangle of that face and o are a tetrahedron in
 * the hull, and four exact signs say whether p is in it. If not, p is about on the surface: some point of that face, or
 * of one beside it, is nearest. Which face is looked at is found in doubles, and is no part of the proof: whatever
 * triangle or side is taken, it belongs to the hull, so that its distance is an upper bound. */
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
    const vec3 *dual;   /* of each face: its normal, divided by how far o is below it */
    uint32_t *adjacent; /* of face f from its `first` on: the faces beyond its sides */
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

static void add_minor(sum *s, const difference *b, const difference *c, int i, int j, double sign)
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
    add_minor(out, b, c, i, j, 1);
    add_minor(out, b, c, j, i, -1);
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
static int side_of(vec3 a, vec3 b, vec3 c, vec3 d)
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
static bool holds(vec3 o, vec3 a, vec3 b, vec3 c, vec3 p)
{
    return side_of(a, b, p, o) >= 0 && side_of(b, c, p, o) >= 0 && side_of(c, a, p, o) >= 0 &&
           side_of(a, b, c, p) >= 0 && side_of(a, b, c, o) > 0;
}

static vec3 corner(const body *k, const hull_face *f, uint32_t i)
{
    return k->vertex[k->h->face_vertices[f->first + i % f->count]];
}

/* Is p in the tetrahedron of o and some triangle of the face's fan about corner `start`? */
static bool face_holds(const body *k, const hull_face *f, uint32_t start, vec3 p)
{
    for (uint32_t i = 1; i + 1 < f->count; i++)
        if (holds(k->inside, corner(k, f, start), corner(k, f, start + i), corner(k, f, start + i + 1), p)) return true;
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
static void area_of(vec3 p, vec3 q, vec3 r, int axis, sum *out)
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
        area_of(corners[i], corners[(i + 1) % 3], p, axis, &area);
        int side = sign_of(&area);
        if (side * seen < 0) return INFINITY;
        if (side) seen = side;
    }
    area_of(a, b, c, axis, &area);
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

/* The face by which the ray from o through p leaves: where dot(dual, p - o) is greatest. That is a linear function on
 * the vertices of the dual polytope, whose edges lead there from any of them. */
static uint32_t face_towards(const body *k, vec3 p, uint32_t from)
{
    const hull *h = k->h;
    vec3 d = vec_sub(p, k->inside);
    double most = vec_dot(k->dual[from], d);
    for (bool moved = true; moved;) {
        moved = false;
        const hull_face *f = &h->faces[from];
        for (uint32_t i = 0; i < f->count; i++) {
            uint32_t next = k->adjacent[f->first + i];
            double far = vec_dot(k->dual[next], d);
            if (far > most) most = far, from = next, moved = true;
        }
    }
    return from;
}

/* Where rays through p and through some vertex of many faces cannot be told apart in doubles, the face may be any of
 * these. Other faces cannot hold p. */
static const double NEARLY_LEAVES = 1 - 0x1p-20;

static bool any_face_holds(const body *k, uint32_t towards, vec3 p)
{
    vec3 d = vec_sub(p, k->inside);
    double most = vec_dot(k->dual[towards], d);
    for (uint32_t f = 0; f < k->h->face_count; f++)
        if (vec_dot(k->dual[f], d) >= NEARLY_LEAVES * most && face_holds(k, &k->h->faces[f], 0, p)) return true;
    return false;
}

enum { FANS_MAX = 8 }; /* of a face whose corners are not in one plane: triangles between any of them are in the hull */

/* Not below the distance of p from the hull; 0 where it is known to be in it. When it is found not to be above `known`,
 * it is not made less. */
static double outside(const body *k, uint32_t face, vec3 p, double known)
{
    const hull_face *f = &k->h->faces[face];
    if (k->has_inside && face_holds(k, f, 0, p)) return 0;
    double least = from_face(k, f, 0, p);
    for (uint32_t i = 0; i < f->count && least > known; i++) {
        const hull_face *beside = &k->h->faces[k->adjacent[f->first + i]];
        if (k->has_inside && face_holds(k, beside, 0, p)) return 0;
        least = fmin(least, from_face(k, beside, 0, p));
    }
    for (uint32_t start = 1; f->count > 3 && start < f->count && start < FANS_MAX && least > known; start++) {
        if (k->has_inside && face_holds(k, f, start, p)) return 0;
        least = fmin(least, from_face(k, f, start, p));
    }
    return k->has_inside && least > known && any_face_holds(k, face, p) ? 0 : least;
}

/* The vertex farthest from what is known: a point, a line, a plane. */
static uint32_t farthest(const body *k, const vec3 *known, int count)
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
    for (int i = 1; i < 4; i++) v[i] = k->vertex[farthest(k, v, i)];
    k->inside = vec_scale(vec_add(vec_add(v[0], v[1]), vec_add(v[2], v[3])), 0.25);
    int way = side_of(v[0], v[1], v[2], v[3]);
    k->has_inside = way != 0 && side_of(v[0], v[1], v[2], k->inside) == way &&
                    side_of(v[0], v[3], v[1], k->inside) == way && side_of(v[1], v[3], v[2], k->inside) == way &&
                    side_of(v[2], v[3], v[0], k->inside) == way;
}

static void find_adjacent(body *k)
{
    const hull *h = k->h;
    uint32_t *used = base_zalloc(h->face_count, sizeof *used);
    for (uint32_t e = 0; e < h->edge_count; e++) {
        uint32_t f0 = h->edges[e].f0, f1 = h->edges[e].f1;
        k->adjacent[h->faces[f0].first + used[f0]++] = f1;
        k->adjacent[h->faces[f1].first + used[f1]++] = f0;
    }
    free(used);
}

static vec3 *duals_of(const body *k)
{
    vec3 *dual = base_alloc(k->h->face_count, sizeof *dual);
    for (uint32_t f = 0; f < k->h->face_count; f++) {
        const hull_face *face = &k->h->faces[f];
        double below = vec_dot(face->normal, vec_sub(corner(k, face, 0), k->inside));
        dual[f] = vec_scale(face->normal, 1 / fmax(below, 0x1p-100)); /* less is noise, of a hull almost flat */
    }
    return dual;
}

static double snapped(double x, int exponent, bool *moved)
{
    double y = ldexp(x, -exponent);
    if (y == 0 || fabs(y) >= LEAST_COORDINATE) return y;
    *moved = true;
    return 0;
}

static vec3 at_unit_size(vec3 p, int exponent, bool *moved)
{
    return vec(snapped(p.x, exponent, moved), snapped(p.y, exponent, moved), snapped(p.z, exponent, moved));
}

double hull_excess_of(const hull *h, const vec3 *points, uint32_t count)
{
    if (count == 0) return 0;
    int exponent;
    bool moved = false;
    frexp(h->max_abs, &exponent);
    vec3 *vertex = base_alloc(h->vertex_count, sizeof *vertex);
    for (uint32_t i = 0; i < h->vertex_count; i++) vertex[i] = at_unit_size(hull_vertex(h, i), exponent, &moved);
    body k = {.h = h, .vertex = vertex};
    find_inside(&k);
    vec3 *dual = duals_of(&k);
    k.dual = dual;
    k.adjacent = base_alloc(2 * h->edge_count + 1, sizeof *k.adjacent);
    find_adjacent(&k);
    double most = 0;
    uint32_t face = 0;
    for (uint32_t i = 0; i < count; i++) {
        vec3 p = at_unit_size(points[i], exponent, &moved);
        face = face_towards(&k, p, face);
        most = fmax(most, outside(&k, face, p, most));
    }
    free(k.adjacent);
    free(dual);
    free(vertex);
    if (moved) most = add_up(most, SNAPPED);
    double real = ldexp(most, exponent);
    return ldexp(real, -exponent) < most ? next_above(real) : real;
}
