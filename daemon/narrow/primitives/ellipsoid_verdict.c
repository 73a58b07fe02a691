/* ellipsoid_verdict: are two ellipsoids apart? Pure; any thread.
 *
 * Along a unit axis n they are apart by n.t - |A n| - |B n|, with A n the half axes of A times n, by the coordinates of
 * its frame: a lower bound of the distance, whatever led to n. And they overlap if both hold one point: midway between
 * the points of both that are the farthest along n and -n. Both are tried along the line of the centres, and then
 * where Newton's method along the gradient leads; what is left has to be measured.
 *
 * Rounding, in u = 2^-53. A matrix R is off by less than 19 u: the factor k of quat_matrix by 4 u (3 u of the norm, 1 u
 * of its own), times I - R, which is at most 2: 8 u; each entry is rounded twice before it is multiplied by k, on |xy|
 * + |wz| or the like, of which a row has 1/2 + sqrt(5) / 2 at most: 6.5 u; then twice more: 3.3 u and 1 u. A product
 * with it is off by 4 u. The separation: A n by 19 u, 4 u, 1 u of the half axes and 2.5 u of the length: 26.5 u of the
 * greatest half axis, for each; n.t by 1 u of the difference of the positions, 3 u of the product, 4.5 u by which n is
 * not unit, 4 u of two sums and of set_bounds: 12.5 u |t|. The error of 32 u of them all holds that; who asks for a
 * verdict does not mind its width. The point x: it is what it is in world axes from A's centre, of length at most the
 * size; from B's it is off by 2 u of the size; R'x by 23 u more. So |x| by half axes is off by less than e = error /
 * least half axis, and by 3 u of itself: if its square is computed as at most 1 - 4 e, with e >= 32 u, it is at most 1
 * - 2 e + 3 u + e < 1. */
#include "narrow/math/scalar.h"
#include "primitive_pair.h"

enum { TRIES = 3 };

#define STRIDE 0.7    /* a longer step leaves what the derivatives know */
#define FLAT 0x1p-100 /* sizes: lengths below this have squares that may be lost */

typedef struct ellipsoids {
    const mat3 *turn_b;
    vec3 half_a, half_b, t; /* t: from A's centre to B's */
    double size;
} ellipsoids;

/* One ellipsoid along n: |A n|, and A n by its length, in its frame, in which all vectors of these functions are. */
typedef struct bulge {
    vec3 along;
    double height;
} bulge;

INLINE bulge bulge_of(vec3 half, vec3 n)
{
    vec3 w = vec_times(half, n);
    double height = sqrt(vec_norm2(w));
    return (bulge){vec_scale(w, 1 / height), height};
}

/* The second derivative of |A n| along x, orthogonal to n, and |A n| itself. */
INLINE double bend_of(vec3 half, const bulge *b, vec3 x)
{
    vec3 ax = vec_times(half, x);
    double side = vec_dot(ax, b->along);
    return (vec_norm2(ax) - side * side) / b->height;
}

/* Newton's step from n, given the line between the points there. Zero where there is none. */
INLINE vec3 next_axis(const ellipsoids *g, vec3 n, const bulge *a, const bulge *b, vec3 line, double apart)
{
    vec3 slope = vec_madd(line, -vec_dot(line, n), n);
    double steep = vec_norm(slope);
    if (!(steep > FLAT * g->size)) return VEC_ZERO;
    vec3 x = vec_scale(slope, 1 / steep);
    double bend = bend_of(g->half_a, a, x) + bend_of(g->half_b, b, mat_tmul(*g->turn_b, x)) + apart;
    return direction_of(vec_madd(n, bend > 0 ? min_of(steep / bend, STRIDE) : STRIDE, x));
}

/* Is the point, as seen from its centre, in the ellipsoid, by more than rounding? */
INLINE bool ellipsoid_is_in(vec3 half, vec3 at, double error)
{
    double least = min_of(half.x, min_of(half.y, half.z));
    return vec_norm2(vec(at.x / half.x, at.y / half.y, at.z / half.z)) <= 1 - 4 * error / least;
}

INLINE bool ellipsoid_overlap(const ellipsoids *g, vec3 point, double error)
{
    return ellipsoid_is_in(g->half_a, point, error) &&
           ellipsoid_is_in(g->half_b, mat_tmul(*g->turn_b, vec_sub(point, g->t)), error);
}

bool ellipsoids_by_verdict(primitive_pair *q, narrow_result *out)
{
    if (q->request->facts & NARROW_DISTANCE) return false;
    unit_pair p;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    p.error = 2 * unit_error(p.size);
    double threshold = q->request->threshold * p.scale, enough = max_of(threshold + p.radius + p.error, 0);
    const ellipsoids g = {
        &q->turn_b, vec_scale(q->a->half, p.scale), vec_scale(q->b->half, p.scale), p.b_in_a.t, p.size};
    vec3 n = vec_greatest(g.t) > FLAT * p.size ? direction_of(g.t) : VEC_ZERO;
    for (uint32_t i = 1; i <= TRIES && vec_norm2(n) > 0.5; i++) {
        bulge a = bulge_of(g.half_a, n), b = bulge_of(g.half_b, mat_tmul(*g.turn_b, n));
        if (!(min_of(a.height, b.height) > FLAT * p.size)) return false;
        double apart = vec_dot(n, g.t) - a.height - b.height;
        vec3 top_a = vec_times(g.half_a, a.along),
             top_b = vec_sub(g.t, mat_mul(*g.turn_b, vec_times(g.half_b, b.along)));
        vec3 line = vec_sub(top_b, top_a);
        span s = {.lo = apart, .axis = direction_again(n), .point_a = top_a, .point_b = top_b, .iterations = i};
        s.hi = max_of(apart, vec_norm(line));
        s.method = NARROW_BY_CLOSED_FORM;
        if (apart > enough) return end(q, &p, &s, s.hi > p.radius ? direction_of(line) : s.axis, out);
        if (apart < 0 && threshold >= 0 && ellipsoid_overlap(&g, vec_scale(vec_add(top_a, top_b), 0.5), p.error)) {
            (void)end(q, &p, &s, s.axis, out);
            out->hi = 0;
            return true;
        }
        n = next_axis(&g, n, &a, &b, line, apart);
    }
    return false;
}
