/* dome: Newton's method on the pieces of B - A, and the bound of their curvature. Pure; any thread.
 *
 * A piece is a sum of up to two discs and a point: h(n) = c.n + ra |Pa n| + rb |Pb n|, with P the projection along the
 * disc's axis. About n0 let n = n0 + d, d orthogonal to n0, |d| <= T. With s = |P n0|, u = P n0 / s and t = axis x u,
 *     |P n| = u.n + v^2 / (|P n| + u.n) >= u.n + v^2 / (2 w),   v = t.d,   w = min(s + T, sqrt(1 + T^2)),
 * so h(n) >= E + G.d + d.M d / 2 with the height E and the tangential gradient G at n0, and M the sum of (r / w) t t'.
 * That is to be at least L |n|, and |n| <= 1 + d^2 / 2: enough is E + G.d + d.(M - L) d / 2 >= L. */
#include "dome.h"

#include "scalar.h"

enum { PIECES_MAX = 3, NEWTON_MAX = 8, WIDTHS = 6 };

static const double WIDEST = 0.8;      /* T to try first, then its halves */
static const double KINK_COSINE = 0.7; /* a flat face is tried when its normal is this near */
static const double SURE = 1 - 1e-6;   /* room for the rounding of curvatures and radii */
static const double SLIM = 1e-5;       /* shorter differences of gradients and sines are not divided by */

typedef struct piece {
    vec3 a, b;     /* the discs' centres (or the points) of A and of B, in A's frame */
    double ra, rb; /* and radii */
} piece;

typedef struct plane2 {
    double x, y;
} plane2;

typedef struct curvature { /* symmetric */
    double xx, xy, yy;
} curvature;

/* A direction, the plane orthogonal to it, and both discs' frames in it. */
typedef struct view {
    vec3 n, x, y;
    vec3 u[2];
    double sine[2];
    plane2 across[2]; /* t */
} view;

typedef struct bundle { /* pieces, seen along one direction */
    int count;
    piece piece[PIECES_MAX];
    double height[PIECES_MAX], weight[PIECES_MAX];
    plane2 gradient[PIECES_MAX];
} bundle;

static double dot2(plane2 a, plane2 b)
{
    return a.x * b.x + a.y * b.y;
}

static double cross2(plane2 a, plane2 b)
{
    return a.x * b.y - a.y * b.x;
}

static plane2 sub2(plane2 a, plane2 b)
{
    return (plane2){a.x - b.x, a.y - b.y};
}

/* ---- pieces ---- */

static bool has_pieces(const shape *s)
{
    return s->type <= SHAPE_CONE || s->type == SHAPE_HULL;
}

static bool has_rim(const shape *s)
{
    return s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE;
}

bool dome_applies(const unit_pair *p)
{
    return has_pieces(&p->a) && has_pieces(&p->b) && (has_rim(&p->a) || has_rim(&p->b));
}

/* The disc, or the point, that the support point `at` belongs to: its centre and radius. */
static vec3 centre_of(const shape *s, vec3 at, double *radius)
{
    bool rim = s->type == SHAPE_CYLINDER || (s->type == SHAPE_CONE && at.z < 0);
    *radius = rim ? s->half.x : 0;
    return rim ? vec(0, 0, at.z) : at;
}

static bool same_point(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void add_piece(bundle *b, const unit_pair *p, const minkowski *m)
{
    piece new;
    new.a = centre_of(&p->a, m->a, &new.ra);
    new.b = transform_point(&p->b_in_a, centre_of(&p->b, m->b_local, &new.rb));
    for (int i = 0; i < b->count; i++)
        if (same_point(b->piece[i].a, new.a) && same_point(b->piece[i].b, new.b)) return;
    b->piece[b->count++] = new;
}

static void drop_piece(bundle *b, int i)
{
    b->count--;
    b->piece[i] = b->piece[b->count];
    b->height[i] = b->height[b->count];
    b->weight[i] = b->weight[b->count];
    b->gradient[i] = b->gradient[b->count];
}

static void see_disc(view *v, int i, vec3 axis)
{
    vec3 flat = vec_madd(v->n, -vec_dot(v->n, axis), axis);
    double sine = vec_norm(flat);
    v->sine[i] = sine;
    v->u[i] = sine > 0 ? vec_scale(flat, 1 / sine) : VEC_ZERO;
    vec3 across = vec_cross(axis, v->u[i]);
    v->across[i] = (plane2){vec_dot(across, v->x), vec_dot(across, v->y)};
}

/* Two unit vectors orthogonal to n and to each other: Duff et al., "Building an Orthonormal Basis, Revisited", 2017. */
static view view_along(const unit_pair *p, vec3 n)
{
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    view v = {.n = n, .x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, .y = {b, sign + n.y * n.y * a, -n.y}};
    if (has_rim(&p->a)) see_disc(&v, 0, vec(0, 0, 1));
    if (has_rim(&p->b)) see_disc(&v, 1, p->b_in_a.r.z);
    return v;
}

static vec3 top_a(const piece *s, const view *v)
{
    return vec_madd(s->a, -s->ra, v->u[0]);
}

static vec3 top_b(const piece *s, const view *v)
{
    return vec_madd(s->b, s->rb, v->u[1]);
}

static void look(bundle *b, const view *v)
{
    for (int i = 0; i < b->count; i++) {
        vec3 w = vec_sub(top_b(&b->piece[i], v), top_a(&b->piece[i], v));
        b->height[i] = vec_dot(w, v->n);
        b->gradient[i] = (plane2){vec_dot(w, v->x), vec_dot(w, v->y)};
    }
}

static void add_disc(curvature *m, double r, plane2 t, double width, double share)
{
    double k = share * r / width;
    m->xx += k * t.x * t.x;
    m->xy += k * t.x * t.y;
    m->yy += k * t.y * t.y;
}

/* The weighted sum of the pieces' M, over all |d| <= wide. */
static curvature curvature_of(const bundle *b, const view *v, const double *weight, double wide)
{
    curvature m = {0, 0, 0};
    double most = sqrt(1 + wide * wide);
    for (int i = 0; i < b->count; i++) {
        const piece *s = &b->piece[i];
        if (s->ra > 0) add_disc(&m, s->ra, v->across[0], min_of(v->sine[0] + wide, most), weight[i]);
        if (s->rb > 0) add_disc(&m, s->rb, v->across[1], min_of(v->sine[1] + wide, most), weight[i]);
    }
    return m;
}

/* ---- the least of the greatest ---- */

/* Of one piece: a plain Newton step; false where it is not a bowl. */
static bool step_of_one(const bundle *b, const view *v, plane2 *d)
{
    curvature m = curvature_of(b, v, b->weight, 0);
    double e = b->height[0], xx = m.xx - e, yy = m.yy - e, whole = xx * yy - m.xy * m.xy;
    plane2 g = b->gradient[0];
    if (!(xx > 0 && whole > SLIM * xx * xx)) return false;
    *d = (plane2){(m.xy * g.y - yy * g.x) / whole, (m.xy * g.x - xx * g.y) / whole};
    return true;
}

/* Of two: to where they are equally high, and along that line to its least. */
static bool step_of_two(bundle *b, const view *v, plane2 *d)
{
    plane2 apart = sub2(b->gradient[0], b->gradient[1]);
    double length2 = dot2(apart, apart);
    if (!(length2 > SLIM * SLIM)) return false;
    double length = sqrt(length2);
    plane2 i = {apart.x / length, apart.y / length}, j = {-i.y, i.x};
    b->weight[0] = min_of(max_of(-dot2(b->gradient[1], apart) / length2, 0), 1);
    b->weight[1] = 1 - b->weight[0];
    curvature m = curvature_of(b, v, b->weight, 0);
    double e = b->weight[0] * b->height[0] + b->weight[1] * b->height[1];
    plane2 mj = {m.xx * j.x + m.xy * j.y, m.xy * j.x + m.yy * j.y};
    double jj = dot2(j, mj) - e, ij = dot2(i, mj), along = (b->height[1] - b->height[0]) / length;
    if (!(jj > SLIM)) return false;
    double across = -(dot2(b->gradient[1], j) + ij * along) / jj;
    *d = (plane2){along * i.x + across * j.x, along * i.y + across * j.y};
    return true;
}

/* Of three: to where all are equally high. */
static bool step_of_three(bundle *b, plane2 *d)
{
    plane2 g0 = b->gradient[0], g1 = b->gradient[1], g2 = b->gradient[2], e1 = sub2(g1, g0), e2 = sub2(g2, g0);
    double whole = cross2(e1, e2);
    if (!(fabs(whole) > SLIM * SLIM)) return false;
    b->weight[0] = cross2(g1, g2) / whole;
    b->weight[1] = cross2(g2, g0) / whole;
    b->weight[2] = cross2(g0, g1) / whole;
    double h1 = b->height[0] - b->height[1], h2 = b->height[0] - b->height[2];
    *d = (plane2){(h1 * e2.y - h2 * e1.y) / whole, (h2 * e1.x - h1 * e2.x) / whole};
    return true;
}

static bool step(bundle *b, const view *v, plane2 *d)
{
    b->weight[0] = 1;
    if (b->count == 1) return step_of_one(b, v, d);
    return b->count == 2 ? step_of_two(b, v, d) : step_of_three(b, d);
}

static bool meets_edge_on(const bundle *b, const view *v)
{
    return (b->piece[0].ra > 0 && v->sine[0] < SLIM) || (b->piece[0].rb > 0 && v->sine[1] < SLIM);
}

/* From v->n to the least; false when it left the neighbourhood. At the end b and *v are those of where it ended. */
static bool descend(const unit_pair *p, bundle *b, view *v, double close)
{
    const double far2 = 0.5 * 0.5, near2 = min_of(0.02 * close, 1e-8);
    for (int i = 0; i < NEWTON_MAX; i++) {
        plane2 d;
        if (meets_edge_on(b, v) || !step(b, v, &d)) return false;
        double length2 = dot2(d, d);
        if (!(length2 < far2)) return false;
        *v = view_along(p, direction_of(vec_madd(vec_madd(v->n, d.x, v->x), d.y, v->y)));
        look(b, v);
        if (length2 <= near2) break;
    }
    plane2 unused;
    return !meets_edge_on(b, v) && step(b, v, &unused); /* for the weights */
}

/* ---- the dome ---- */

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

static plane2 residual(const bundle *b)
{
    plane2 sum = {0, 0};
    for (int i = 0; i < b->count; i++) {
        sum.x += b->weight[i] * b->gradient[i].x;
        sum.y += b->weight[i] * b->gradient[i].y;
    }
    return sum;
}

/* Two pieces part along i: with their weights shifted by `shift` to either side, they rise by shift |G0 - G1| |d.i|,
 * which is at least that / T times (d.i)^2. */
static bool bends_enough_for_two(const bundle *b, const view *v, double wide, double l)
{
    plane2 apart = sub2(b->gradient[0], b->gradient[1]);
    double length = sqrt(dot2(apart, apart)), shift = 0.5 * min_of(b->weight[0], b->weight[1]);
    plane2 i = {apart.x / length, apart.y / length};
    for (int side = -1; side <= 1; side += 2) {
        const double weight[2] = {b->weight[0] + side * shift, b->weight[1] - side * shift};
        curvature m = curvature_of(b, v, weight, wide);
        add_disc(&m, 2 * shift * length, i, wide, 1);
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
            b->count == 1 ? at_least(curvature_of(b, v, b->weight, wide), l) : bends_enough_for_two(b, v, wide, l);
        if (enough) return wide;
    }
    return 0;
}

/* Three pieces rise by at least the inner radius of the triangle of their gradients. */
static double width_of_corner(const bundle *b, double l)
{
    double inner = INFINITY;
    for (int i = 0; i < 3; i++) {
        plane2 from = b->gradient[i], to = b->gradient[(i + 1) % 3], edge = sub2(to, from);
        inner = min_of(inner, fabs(cross2(from, to)) / sqrt(dot2(edge, edge)));
    }
    return 2 * SURE * inner / l;
}

static void write_points(const bundle *b, const view *v, dome *out)
{
    vec3 a = VEC_ZERO, sum = VEC_ZERO;
    for (int i = 0; i < b->count; i++) {
        a = vec_madd(a, b->weight[i], top_a(&b->piece[i], v));
        sum = vec_madd(sum, b->weight[i], top_b(&b->piece[i], v));
    }
    out->point_a = a;
    out->point_b = sum;
}

static bool close_dome(vec3 n, double wide, double depth, dome *out)
{
    out->direction = n;
    out->cosine = 1 / sqrt(1 + wide * wide);
    out->depth = depth;
    return depth > 0 && wide > 0;
}

static bool raise_here(const bundle *b, const view *v, dome *out)
{
    double l = least_height(b);
    if (!(l > 0)) return false;
    double wide = b->count == 3 ? width_of_corner(b, l) : width_of_bend(b, v, l);
    plane2 rest = residual(b);
    double lack = b->count == 3 ? 0 : sqrt(dot2(rest, rest)) * wide;
    write_points(b, v, out);
    return close_dome(v->n, wide, l - lack, out);
}

/* The weight of a piece that pulls the wrong way is not positive. */
static int worst_of(const bundle *b)
{
    int worst = 0;
    for (int i = 1; i < b->count; i++)
        if (b->weight[i] < b->weight[worst]) worst = i;
    return worst;
}

static int lowest_of(const bundle *b)
{
    int lowest = 0;
    for (int i = 1; i < b->count; i++)
        if (b->height[i] < b->height[lowest]) lowest = i;
    return lowest;
}

/* All the pieces, then without the one that does not hold it, until one is left. */
static bool raise_on_pieces(const unit_pair *p, bundle *b, const view *start, double close, dome *out)
{
    for (; b->count > 0;) {
        view v = *start;
        look(b, &v);
        bundle here = *b;
        bool found = descend(p, &here, &v, close);
        int worst = worst_of(&here);
        if (found && here.weight[worst] > SLIM) return raise_here(&here, &v, out);
        drop_piece(b, found ? worst : lowest_of(b));
    }
    return false;
}

/* ---- flat faces ---- */

/* Along the normal of a disc the support function has a kink all round: E + G.d + r |d|, with the gradient G of all the
 * rest. So |d| may reach 2 (r - |G|) / L. */
static bool raise_on_face(const unit_pair *p, const bundle *b, int disc, vec3 normal, dome *out)
{
    view v = view_along(p, normal);
    v.u[disc] = VEC_ZERO;
    bundle at = *b;
    look(&at, &v);
    int top = 0;
    for (int i = 1; i < at.count; i++)
        if (at.height[i] > at.height[top]) top = i;
    const piece *s = &at.piece[top];
    double r = disc == 0 ? s->ra : s->rb, l = at.height[top], g = sqrt(dot2(at.gradient[top], at.gradient[top]));
    if (!(l > 0 && g < SURE * r)) return false;
    out->point_a = disc == 0 ? vec_madd(top_b(s, &v), -l, normal) : top_a(s, &v);
    out->point_b = disc == 0 ? top_b(s, &v) : vec_madd(top_a(s, &v), l, normal);
    return close_dome(normal, 2 * SURE * (r - g) / l, l, out);
}

static bool raise_on_faces(const unit_pair *p, const bundle *b, vec3 near, dome *out)
{
    const vec3 axes[2] = {vec(0, 0, 1), p->b_in_a.r.z};
    const bool rims[2] = {has_rim(&p->a), has_rim(&p->b)};
    for (int i = 0; i < 2; i++) {
        double cosine = vec_dot(near, axes[i]);
        if (!rims[i] || fabs(cosine) < KINK_COSINE) continue;
        if (raise_on_face(p, b, i, cosine < 0 ? vec_neg(axes[i]) : axes[i], out)) return true;
    }
    return false;
}

bool dome_knows(const unit_pair *p, const minkowski *const vertex[3], const minkowski *m)
{
    bundle b = {.count = 0};
    add_piece(&b, p, m);
    piece sought = b.piece[0];
    b.count = 0;
    for (int i = 0; i < 3; i++) add_piece(&b, p, vertex[i]);
    for (int i = 0; i < b.count; i++)
        if (same_point(b.piece[i].a, sought.a) && same_point(b.piece[i].b, sought.b)) return true;
    return false;
}

bool dome_raise(const unit_pair *p, const minkowski *const vertex[3], vec3 near, double close, dome *out)
{
    bundle b = {.count = 0};
    for (int i = 0; i < 3; i++) add_piece(&b, p, vertex[i]);
    if (raise_on_faces(p, &b, near, out)) return true;
    view v = view_along(p, near);
    return raise_on_pieces(p, &b, &v, close, out);
}

/* ---- what it covers ---- */

/* A direction that leaves the triangle at x, nearer than `depth`, and along which no corner w is as high, has
 * w.x < depth^2: what is left of the triangle is a convex polygon, and the dome is convex. */
enum { CORNERS_MAX = 9 }; /* six, and what rounding may add to them */

static int clip(const vec3 *from, int count, vec3 w, double limit, vec3 *to)
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

static bool holds(const dome *d, vec3 x, double noise)
{
    return vec_dot(x, d->direction) >= d->cosine * vec_norm(x) + noise;
}

bool dome_covers(const dome *d, const vec3 w[3], vec3 nearest, double depth, double size)
{
    vec3 polygon[2][CORNERS_MAX] = {{w[0], w[1], w[2]}};
    double noise = 8 * UNIT_ROUNDOFF * size, limit = depth * depth + noise * size;
    int count = 3;
    bool left = vec_dot(nearest, w[0]) <= limit && vec_dot(nearest, w[1]) <= limit && vec_dot(nearest, w[2]) <= limit;
    if (left && !holds(d, nearest, noise)) return false;
    for (int k = 0; k < 3; k++) count = clip(polygon[k & 1], count, w[k], limit, polygon[~k & 1]);
    for (int i = 0; i < count; i++) {
        if (!holds(d, polygon[1][i], noise)) return false;
    }
    return true;
}
