/* dome: the bound of the curvature of the pieces of B - A. Pure; any thread.
 *
 * About n0 let n = n0 + d, d orthogonal to n0, |d| <= T. Of a disc let s = |P n0|, u = P n0 / s and t = axis x u. Then
 *     |P n| = u.n + v^2 / (|P n| + u.n) >= u.n + v^2 / (2 w),   v = t.d,   w = min(s + T, sqrt(1 + T^2)),
 * so h(n) >= E + G.d + d.M d / 2 with the height E and the gradient G at n0, and M the sum of (r / w) t t'. That is to
 * be at least L |n|, and |n| <= 1 + d^2 / 2: enough is E + G.d + d.(M - L) d / 2 >= L. */
#include "curved.h"
#include "narrow/math/scalar.h"

enum { WIDTHS = 6 };

static const double WIDEST = 0.8;    /* T to try first, then its halves */
static const double SURE = 1 - 1e-6; /* covers the rounding of curvatures */

/* The weighted sum of the pieces' M, over all |d| <= wide. */
static curvature curvature_within(const bundle *b, const view *v, const double *weight, double wide)
{
    curvature m = {0, 0, 0};
    double most = sqrt(1 + wide * wide);
    for (int i = 0; i < b->count; i++) {
        const piece *s = &b->piece[i];
        if (s->ra > 0) curvature_add(&m, weight[i], s->ra, min_of(v->sine[0] + wide, most), v->across[0]);
        if (s->rb > 0) curvature_add(&m, weight[i], s->rb, min_of(v->sine[1] + wide, most), v->across[1]);
    }
    return m;
}

static bool at_least(curvature m, double l)
{
    double xx = SURE * m.xx - l, yy = SURE * m.yy - l, xy = m.xy;
    return xx > 0 && xx * yy >= xy * xy;
}

static double least_height(const bundle *b)
{
    double least = b->height[0];
    for (int i = 1; i < b->count; i++) least = min_of(least, b->height[i]);
    return least;
}

/* What is left of the gradients: zero but for the last step of the search. */
static double slope(const bundle *b)
{
    plane2 sum = {0, 0};
    for (int i = 0; i < b->count; i++) {
        sum.x += b->weight[i] * b->gradient[i].x;
        sum.y += b->weight[i] * b->gradient[i].y;
    }
    return sqrt(dot2(sum, sum));
}

/* Two pieces part along i: with their weights shifted by `shift` to either side, they rise by shift |G0 - G1| |d.i|,
 * which is at least that / T times (d.i)^2. */
static bool two_bend_enough(const bundle *b, const view *v, double wide, double l)
{
    plane2 apart = sub2(b->gradient[0], b->gradient[1]);
    double length = sqrt(dot2(apart, apart)), shift = 0.5 * min_of(b->weight[0], b->weight[1]);
    plane2 i = {apart.x / length, apart.y / length};
    for (int side = -1; side <= 1; side += 2) {
        const double weight[2] = {b->weight[0] + side * shift, b->weight[1] - side * shift};
        curvature m = curvature_within(b, v, weight, wide);
        curvature_add(&m, 2 * shift, length, wide, i);
        if (!at_least(m, l)) return false;
    }
    return true;
}

/* The greatest T of those tried; 0 = none. */
static double width_of_bend(const bundle *b, const view *v, double l)
{
    double wide = WIDEST;
    for (int i = 0; i < WIDTHS; i++, wide *= 0.5) {
        bool enough =
            b->count == 1 ? at_least(curvature_within(b, v, b->weight, wide), l) : two_bend_enough(b, v, wide, l);
        if (enough) return wide;
    }
    return 0;
}

/* Three pieces rise by at least the inner radius of the triangle of their gradients, which holds the origin. */
static double width_of_corner(const bundle *b, double l)
{
    double inner = INFINITY;
    for (int i = 0; i < 3; i++) {
        plane2 from = b->gradient[i], to = b->gradient[(i + 1) % 3], edge = sub2(to, from);
        inner = min_of(inner, fabs(cross2(from, to)) / sqrt(dot2(edge, edge)));
    }
    return 2 * SURE * inner / l;
}

static bool close_dome(vec3 n, double wide, double depth, dome *out)
{
    out->direction = n;
    out->cosine = 1 / sqrt(1 + wide * wide);
    out->depth = depth;
    return depth > 0 && wide > 0;
}

static bool raise_on_pieces(const bundle *b, const view *v, dome *out)
{
    double l = least_height(b);
    if (!(l > 0)) return false;
    double wide = b->count == 3 ? width_of_corner(b, l) : width_of_bend(b, v, l);
    double lack = b->count == 3 ? 0 : slope(b) * wide;
    pieces_points(b, v, &out->point_a, &out->point_b);
    return close_dome(v->n, wide, l - lack, out);
}

/* E + G.d + r |d| >= L (1 + d^2 / 2) as far as |d| = 2 (r - |G|) / L. */
static bool raise_on_face(const pieces_face *f, dome *out)
{
    if (!(f->height > 0)) return false;
    out->point_a = f->point_a;
    out->point_b = f->point_b;
    return close_dome(f->normal, 2 * f->margin / f->height, f->height, out);
}

bool dome_raise(const unit_pair *p, const bundle *pieces, vec3 near, double close, dome *out)
{
    pieces_face face;
    if (pieces_find_face(p, pieces, near, &face)) return raise_on_face(&face, out);
    bundle b = *pieces;
    view v = pieces_view(p, near);
    return pieces_descend(p, &b, &v, min_of(0.02 * close, 1e-8)) && raise_on_pieces(&b, &v, out);
}

/* ---- what it covers ---- */

/* A direction that leaves the triangle at x, nearer than `depth`, and along which no corner w is as high, has
 * w.x < depth^2: what is left of the triangle is a convex polygon, and the dome is convex. */
enum { CORNERS_MAX = 9 }; /* six, and what rounding may add to them */

static int curved_clip(const vec3 *from, int count, vec3 w, double limit, vec3 *to)
{
    int kept = 0;
    for (int i = 0; i < count; i++) {
        vec3 here = from[i], next = from[i + 1 < count ? i + 1 : 0];
        double above = vec_dot(w, here) - limit, above_next = vec_dot(w, next) - limit;
        if (above <= 0) to[kept++] = here;
        if ((above <= 0) != (above_next <= 0))
            to[kept++] = vec_madd(here, above / (above - above_next), vec_sub(next, here));
    }
    return kept;
}

static bool curved_holds(const dome *d, vec3 x, double noise)
{
    return vec_dot(x, d->direction) >= d->cosine * vec_norm(x) + noise;
}

bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size)
{
    vec3 polygon[2][CORNERS_MAX] = {{w[0], w[1], w[2]}};
    double noise = 8 * UNIT_ROUNDOFF * size, limit = depth * depth + noise * size;
    int count = 3;
    bool left = vec_dot(nearest, w[0]) <= limit && vec_dot(nearest, w[1]) <= limit && vec_dot(nearest, w[2]) <= limit;
    if (left && !curved_holds(d, nearest, noise)) return false;
    for (int k = 0; k < 3; k++) count = curved_clip(polygon[k & 1], count, w[k], limit, polygon[~k & 1]);
    for (int i = 0; i < count; i++)
        if (!curved_holds(d, polygon[1][i], noise)) return false;
    return true;
}
