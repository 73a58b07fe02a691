/* curved_depth: the search over a surface (surface.h), with domes. Pure; any thread. About 20 kB on the stack. */
#include "curved.h"
#include "narrow/convex/surface.h"
#include "narrow/math/scalar.h"

/* ---- dome ---- */

/* The bound of the curvature of the pieces of B - A.
 *
 * About n0 let n = n0 + d, d orthogonal to n0, |d| <= T. Of a disc let s = |P n0|, u = P n0 / s and t = axis x u. Then
 *     |P n| = u.n + v^2 / (|P n| + u.n) >= u.n + v^2 / (2 w),   v = t.d,   w = min(s + T, sqrt(1 + T^2)),
 * so h(n) >= E + G.d + d.M d / 2 with the height E and the gradient G at n0, and M the sum of (r / w) t t'. That is to
 * be at least L |n|, and |n| <= 1 + d^2 / 2: enough is E + G.d + d.(M - L) d / 2 >= L. */

enum { WIDTHS = 6 };

static const double WIDEST = 0.8;    /* T to try first, then its halves */
static const double SURE = 1 - 1e-6; /* room for the rounding of curvatures */

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
    return close_dome(f->normal, 2 * f->room / f->height, f->height, out);
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

/* ---- curved depth ---- */

enum { DOMES_MAX = 8, RAISES_MAX = 16 };

/* A dome is raised only for a direction whose depth is less than this times the best depth so far, */
static const double PROMISING = 1.1;
/* and only where its support point lies above the facet by less than this fraction of the size. */
static const double RIPE = 0.01;

typedef struct search {
    const unit_pair *p;
    const narrow_goal *goal;
    surface *s;
    span *best;
    double eps;    /* a point that is no farther out than this is on the facet */
    double proved; /* the least distance that is known of all facets that are final */
    support_hints hints;
    bool won;          /* best->lo is that of a direction that was tried */
    uint8_t corner[3]; /* its facet: the nearest point of it is the witness, unless `domed` */
    bool domed;        /* the points are those of the last dome that lowered the depth, already in *best */
    int raises;
    int dome_count;
    dome dome[DOMES_MAX];
} search;

/* Of a facet: how far it is from the origin, and where. */
typedef struct foot {
    double distance;
    vec3 nearest;
} foot;

static vec3 curved_corner_of(const surface *s, int f, int i)
{
    return s->point[s->corner[f][i]].w;
}

static foot curved_foot_of(const surface *s, int f)
{
    double weight[3], distance = measure(s, f, weight);
    vec3 at = vec_scale(curved_corner_of(s, f, 0), weight[0]);
    at = vec_madd(at, weight[1], curved_corner_of(s, f, 1));
    return (foot){distance, vec_madd(at, weight[2], curved_corner_of(s, f, 2))};
}

static void curved_close_facet(search *x, int f, double distance)
{
    x->s->bound[f] = INFINITY;
    x->proved = min_of(x->proved, distance);
}

/* The support point along the unit direction `n` (from the origin outward); its height is an upper bound of the depth.
 * True: the least so far. */
static bool curved_probe(search *x, vec3 n, minkowski *m)
{
    vec3 axis = vec_neg(n);
    *m = unit_pair_nearest_from(x->p, axis, &x->hints);
    double height = vec_dot(n, m->w);
    x->best->iterations++;
    if (!(-height > x->best->lo)) return false;
    x->best->lo = -height;
    x->best->axis = axis;
    return true;
}

/* ---- domes ---- */

/* Within so much of the truth a dome ends the search. */
static double curved_close_enough(const search *x)
{
    double lo = x->best->lo, width = 0.5 * x->goal->tolerance;
    return max_of(narrow_goal_reached(x->goal, lo, lo + width) ? width : 0, x->p->error);
}

static bool within(const dome *d, vec3 n)
{
    return vec_dot(d->direction, n) >= d->cosine;
}

/* What a dome covers is not nearer than the depth that it proves, or the one found so far. */
static bool curved_settle_by(search *x, int f, const foot *at, const dome *d)
{
    double depth = min_of(d->depth, -x->best->lo);
    const vec3 w[3] = {curved_corner_of(x->s, f, 0), curved_corner_of(x->s, f, 1), curved_corner_of(x->s, f, 2)};
    if (!(depth > at->distance) || !dome_covers(d, w, at->nearest, depth, x->p->size)) return false;
    curved_close_facet(x, f, depth);
    return true;
}

/* A facet is looked at by the domes that its normal is in. *inside: there are such domes. */
static bool curved_settle(search *x, int f, vec3 n, bool *inside)
{
    foot at;
    *inside = false;
    for (int i = 0; i < x->dome_count; i++) {
        if (!within(&x->dome[i], n)) continue;
        if (!*inside) at = curved_foot_of(x->s, f);
        *inside = true;
        if (curved_settle_by(x, f, &at, &x->dome[i])) return true;
    }
    return false;
}

static void probe_dome(search *x, const dome *d)
{
    minkowski m;
    if (!curved_probe(x, d->direction, &m)) return;
    x->best->point_a = d->point_a;
    x->best->point_b = d->point_b;
    x->won = x->domed = true;
}

/* A dome is worth its while when the farthest point along the facet's normal, `m`, lies on pieces that it knows. True:
 * it was raised, and covers the facet. */
static bool curved_raise_over(search *x, int f, vec3 n, const minkowski *m)
{
    if (x->dome_count == DOMES_MAX || x->raises == RAISES_MAX) return false;
    double height = vec_dot(n, m->w);
    if (height > -PROMISING * x->best->lo || height - x->s->offset[f] > RIPE * x->p->size) return false;
    bundle pieces;
    pieces.count = 0;
    for (int i = 0; i < 3; i++) pieces_add(x->p, &pieces, &x->s->point[x->s->corner[f][i]]);
    if (!pieces_know(x->p, &pieces, m)) return false;
    dome *d = &x->dome[x->dome_count];
    x->raises++;
    if (!dome_raise(x->p, &pieces, n, curved_close_enough(x), d)) return false;
    probe_dome(x, d);
    if (d->depth < -x->best->lo - curved_close_enough(x)) return false;
    x->dome_count++;
    foot at = curved_foot_of(x->s, f);
    return curved_settle_by(x, f, &at, d);
}

/* ---- search ---- */

/* Tries the facet's normal: a dome, a new point of the surface, or the facet is on that of B - A. */
LANES_INLINE bool curved_refine(search *x, int f, vec3 n, bool in_dome)
{
    surface *s = x->s;
    minkowski *m = &s->point[s->point_count];
    if (curved_probe(x, n, m)) {
        for (int i = 0; i < 3; i++) x->corner[i] = s->corner[f][i];
        x->won = true;
        x->domed = false;
    }
    if (!in_dome && curved_raise_over(x, f, n, m)) return true;
    if (vec_dot(n, m->w) - s->offset[f] > x->eps) return expand(s, x->eps);
    double weight[3];
    curved_close_facet(x, f, measure(s, f, weight));
    return true;
}

/* False when the surface cannot be grown any more. */
LANES_INLINE bool curved_advance(search *x, int f)
{
    surface *s = x->s;
    vec3 n = vec(s->nx[f], s->ny[f], s->nz[f]);
    bool estimated = s->bound[f] == s->offset[f] - PLANE_SLACK, in_dome;
    if (curved_settle(x, f, n, &in_dome)) return true;
    if (estimated && s->offset[f] > -x->best->lo - PLANE_SLACK) {
        double weight[3];
        s->bound[f] = measure(s, f, weight);
        return true;
    }
    return curved_refine(x, f, n, in_dome);
}

/* False: no answer. *least: what all facets are away from the origin, and what domes say. */
LANES_INLINE bool curved_search_from(search *x, const simplex *from, double *least)
{
    if (!start_tetrahedron(x->s, from)) return false;
    for (;;) {
        double bound = least_bound(x->s);
        *least = min_of(bound, x->proved);
        if (-x->best->lo - *least <= x->p->error || narrow_goal_reached(x->goal, x->best->lo, -*least)) return true;
        if (bound == INFINITY) return true;
        if (!curved_advance(x, nearest_of(x->s, bound))) return false;
    }
}

LANES_TWINS(LANES_WIDE, bool, curved_search, curved_search_from, (search *const x, const simplex *from, double *least),
    (x, from, least));

static void curved_write_witnesses(const search *x)
{
    simplex s = {.count = 3};
    vec3 normal, axis;
    if (!x->won || x->domed) return;
    for (int i = 0; i < 3; i++) s.v[i] = x->s->point[x->corner[i]];
    triangle_nearest(s.v[0].w, s.v[1].w, s.v[2].w, s.weight, &normal, &axis);
    simplex_witness(&s, &x->best->point_a, &x->best->point_b);
}

bool curved_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    if (start->simplex.count < 4 || start->state != GJK_INSIDE) return false;
    surface s;
    search x;
    x.p = p;
    x.goal = goal;
    x.s = &s;
    x.best = out;
    x.eps = 4 * UNIT_ROUNDOFF * p->size;
    x.proved = INFINITY;
    x.hints = NO_HINTS;
    x.won = x.domed = false;
    x.raises = x.dome_count = 0;
    const span before = *out;
    double least;
    if (!LANES_CHOSEN(curved_search)(&x, &start->simplex, &least)) {
        uint32_t iterations = out->iterations;
        *out = before;
        out->iterations = iterations;
        return false;
    }
    out->method = NARROW_BY_EPA;
    out->hi = max_of(out->lo, min_of(out->hi, -least));
    curved_write_witnesses(&x);
    return true;
}
