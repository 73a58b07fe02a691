/* closed: formulas for a point and a body of revolution, for half-spaces, and for ellipsoids. Pure; any thread. */
#include "closed.h"

#include "narrow/math/scalar.h"

/* The same number proves both bounds. */
static bool exact(span *out, double distance, vec3 axis, vec3 point_a, vec3 point_b)
{
    *out = (span){.lo = distance,
        .hi = distance,
        .axis = axis,
        .point_a = point_a,
        .point_b = point_b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = 1};
    return true;
}

static vec3 unit_or(vec3 v, vec3 otherwise)
{
    vec3 n = direction_of(v);
    return vec_norm2(n) > 0 ? n : otherwise;
}

/* The profile of a body of revolution in the half-plane (radius, z), from the axis round to the axis: corners, and the
 * edges between them, none of which is without length. A disc has two, back to back. */
typedef struct profile {
    int edges;
    double r[4], z[4];
} profile;

static profile profile_of(const shape *s)
{
    double r = s->half.x, h = s->half.z;
    if (s->type == SHAPE_CONE || h == 0) return (profile){2, {0, r, 0}, {s->type == SHAPE_CONE ? h : 0, -h, -h}};
    return (profile){3, {0, r, r, 0}, {h, h, -h, -h}};
}

/* Of an edge as a point sees it: how high the point is above its line, how far it is past its beginning and past its
 * end, and the outward normal. However short it is, an edge has a direction. */
typedef struct edge_view {
    double height, past_begin, past_end, nr, nz;
} edge_view;

static edge_view edge_seen(const profile *f, int i, double r, double z)
{
    vec3 e = direction_of(vec(f->r[i + 1] - f->r[i], f->z[i + 1] - f->z[i], 0));
    double dr = r - f->r[i], dz = z - f->z[i], next_r = r - f->r[i + 1], next_z = z - f->z[i + 1];
    return (edge_view){dz * e.x - dr * e.y, dr * e.x + dz * e.y, next_r * e.x + next_z * e.y, -e.y, e.x};
}

/* Signed distance of the point (r, z) from the profile, and the unit direction (*nr, *nz) in which it leaves.
 *
 * Outside: of the nearest point. That is in an edge, beyond which the point is; or at a corner, of which the point is
 * past both edges. That is asked of the very vector from the corner to the point, however short it is: so the direction
 * is always one of the corner's normals, and proves the distance. Inside: of the nearest line of an edge, for the
 * profile is convex; rounding may also have put a point there that is as near to the outline as that. */
static double profile_distance(const profile *f, double r, double z, double *nr, double *nz)
{
    double inside = -INFINITY, outside = INFINITY, out_r = 0, out_z = 1;
    bool past = true; /* of the edge before, as is `before` */
    double before = -INFINITY;
    for (int i = 0; i <= f->edges; i++) {
        edge_view e = i < f->edges ? edge_seen(f, i, r, z) : (edge_view){.height = -INFINITY};
        double cr = r - f->r[i], cz = z - f->z[i], corner = sqrt(cr * cr + cz * cz);
        bool above = before >= 0 || e.height >= 0;
        if (past && above && e.past_begin <= 0 && corner > 0 && corner < outside)
            outside = corner, out_r = cr / corner, out_z = cz / corner;
        if (e.height >= 0 && e.past_begin > 0 && e.past_end < 0 && e.height < outside)
            outside = e.height, out_r = e.nr, out_z = e.nz;
        if (e.height > inside) inside = e.height, *nr = e.nr, *nz = e.nz;
        past = e.past_end >= 0, before = e.height;
    }
    if (inside < 0 || !(outside > 0) || isinf(outside)) return inside;
    *nr = out_r, *nz = out_z;
    return outside;
}

bool closed_sphere_revolved(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    profile f = profile_of(&p->b);
    vec3 c = vec_neg(mat_tmul(p->b_in_a.r, p->b_in_a.t));
    vec3 radial = unit_or(vec(c.x, c.y, 0), vec(1, 0, 0));
    double nr = 0, nz = 1, distance = profile_distance(&f, vec_norm(vec(c.x, c.y, 0)), c.z, &nr, &nz);
    vec3 axis = mat_mul(p->b_in_a.r, vec(-nr * radial.x, -nr * radial.y, -nz));
    return exact(out, distance, axis, VEC_ZERO, vec_scale(axis, distance));
}

bool closed_any_halfspace(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 axis = vec_neg(p->b_in_a.r.z), point = unit_pair_support_a(p, axis, NULL);
    double distance = vec_dot(axis, vec_sub(p->b_in_a.t, point));
    return exact(out, distance, axis, point, vec_madd(point, distance, axis));
}

bool closed_halfspace_any(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 axis = vec(0, 0, 1), point = unit_pair_support_b(p, vec(0, 0, -1), NULL);
    return exact(out, point.z, axis, vec(point.x, point.y, 0), point);
}

/* Planes that are not parallel meet: no translation separates. Parallel, back to back: the slab between (or shared). */
bool closed_halfspace_halfspace(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 n = p->b_in_a.r.z, t = p->b_in_a.t;
    bool opposite = n.z < 0 && fabs(n.x) <= 4 * UNIT_ROUNDOFF && fabs(n.y) <= 4 * UNIT_ROUNDOFF;
    return exact(out, opposite ? t.z : -INFINITY, vec(0, 0, 1), vec(t.x, t.y, 0), t);
}

/* ==== ellipsoids ==== */

/* The search, and the proof.
 *
 * A and B stand for the half axes of each ellipsoid, in its own frame: A n for half * n by coordinates, B n for half *
 * (R' n). A ball has none: its radius is not of its core. */

enum { NEWTON_MAX = 16, HALVINGS_MAX = 6, TURNS_MAX = 4, STARTS_MAX = 4 };

static const double STRIDE = 0.7; /* a longer step leaves what the derivatives know */
static const double FLAT = 1e-9;  /* of the steeper second derivative: the least that the other one counts */
static const double BOWL = 1e-3;  /* a second derivative with less of a determinant is taken without its -h */
static const double MOST = 1e-6;  /* by which a proof falls short of the truth, whatever was asked */
static const double ROUGH = 1e-9; /* by which it may where less was asked and is not proven; then its status is WIDE */
static const double NOISE = 1024; /* rounding of products of lengths, in units of the last place, rounded up */
static const double SLACK = 0.1;  /* for the rounding of a quotient of determinants */
static const double FARTHER = 3;  /* against 1 of all directions along the sphere; measured */

/* h and its derivatives along the sphere at n; x and y span the plane orthogonal to n. */
typedef struct place {
    vec3 n, x, y;
    vec3 xb, yb;   /* x and y in B's frame */
    vec3 u, v;     /* A n and B n, of unit length; zero for a ball */
    double na, nb; /* and their lengths */
    double h;
    double gx, gy;     /* gradient */
    double xx, xy, yy; /* second derivative + h */
} place;

/* Duff et al., "Building an Orthonormal Basis, Revisited", 2017. */
static void plane_of(vec3 n, vec3 *x, vec3 *y)
{
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    *x = vec(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *y = vec(b, sign + n.y * n.y * a, -n.y);
}

/* What one ellipsoid adds: h += |A n|; its unit vector. */
static vec3 add_height(vec3 half, vec3 n, double *length, place *at)
{
    vec3 w = vec_times(half, n);
    *length = sqrt(vec_norm2(w));
    at->h += *length;
    return *length > 0 ? vec_scale(w, 1 / *length) : VEC_ZERO;
}

/* The second derivative of |A n| is (A'A - (A'u) (A'u)') / |A n|, with u = A n / |A n|. */
static void add_slopes(vec3 half, vec3 u, double length, vec3 x, vec3 y, place *at)
{
    if (!(length > 0)) return;
    vec3 ax = vec_times(half, x), ay = vec_times(half, y);
    double ux = vec_dot(u, ax), uy = vec_dot(u, ay), per = 1 / length;
    at->gx += ux, at->gy += uy;
    at->xx += (vec_norm2(ax) - ux * ux) * per;
    at->xy += (vec_dot(ax, ay) - ux * uy) * per;
    at->yy += (vec_norm2(ay) - uy * uy) * per;
}

static place ellipsoids_look(const unit_pair *p, vec3 n)
{
    place at = {.n = n, .h = vec_dot(p->b_in_a.t, n)};
    at.u = add_height(shape_core_half(&p->a), n, &at.na, &at);
    at.v = add_height(shape_core_half(&p->b), mat_tmul(p->b_in_a.r, n), &at.nb, &at);
    return at;
}

static void look_closer(const unit_pair *p, place *at)
{
    plane_of(at->n, &at->x, &at->y);
    at->xb = mat_tmul(p->b_in_a.r, at->x);
    at->yb = mat_tmul(p->b_in_a.r, at->y);
    at->gx = vec_dot(p->b_in_a.t, at->x);
    at->gy = vec_dot(p->b_in_a.t, at->y);
    at->xx = at->xy = at->yy = 0;
    add_slopes(shape_core_half(&p->a), at->u, at->na, at->x, at->y, at);
    add_slopes(shape_core_half(&p->b), at->v, at->nb, at->xb, at->yb, at);
}

/* ---- proof ---- */

/* Symmetric; in the frame n, x, y. */
typedef struct form {
    double k00, k01, k02, k11, k12, k22;
} form;

/* A and B along n, x and y, by coordinates of which the first is along u (or v); `gain`: of each turn of B's last two
 * to A's, which is to be as great as it can. */
typedef struct turn {
    vec3 a[3], b[3];
    double gain[2][2];
} turn;

static void gain_along(turn *t, double weight, vec3 a, vec3 b)
{
    t->gain[0][0] += weight * a.y * b.y, t->gain[0][1] += weight * a.y * b.z;
    t->gain[1][0] += weight * a.z * b.y, t->gain[1][1] += weight * a.z * b.z;
}

static vec3 seen_from(vec3 u, vec3 u1, vec3 u2, vec3 w)
{
    return vec(vec_dot(u, w), vec_dot(u1, w), vec_dot(u2, w));
}

static turn turn_of(const unit_pair *p, const place *at)
{
    turn t = {.gain = {{0, 0}, {0, 0}}};
    vec3 half_a = shape_core_half(&p->a), half_b = shape_core_half(&p->b), u1, u2, v1, v2;
    plane_of(at->u, &u1, &u2);
    plane_of(at->v, &v1, &v2);
    t.a[0] = vec(at->na, 0, 0);
    t.b[0] = vec(at->nb, 0, 0);
    t.a[1] = seen_from(at->u, u1, u2, vec_times(half_a, at->x));
    t.a[2] = seen_from(at->u, u1, u2, vec_times(half_a, at->y));
    t.b[1] = seen_from(at->v, v1, v2, vec_times(half_b, at->xb));
    t.b[2] = seen_from(at->v, v1, v2, vec_times(half_b, at->yb));
    for (int i = 1; i < 3; i++) gain_along(&t, 1, t.a[i], t.b[i]);
    return t;
}

/* m = M n, M x, M y with M = A + S B; of the rotations and reflections S the one that gains most. */
static void inner_ellipsoid(const turn *t, vec3 m[3])
{
    const double(*g)[2] = t->gain;
    double c = g[0][0] + g[1][1], s = g[1][0] - g[0][1], mirror = 1;
    double mirrored_c = g[0][0] - g[1][1], mirrored_s = g[1][0] + g[0][1];
    if (mirrored_c * mirrored_c + mirrored_s * mirrored_s > c * c + s * s) c = mirrored_c, s = mirrored_s, mirror = -1;
    double norm = sqrt(c * c + s * s);
    c = norm > 0 ? c / norm : 1, s = norm > 0 ? s / norm : 0;
    for (int i = 0; i < 3; i++) {
        vec3 a = t->a[i], b = t->b[i];
        b.z *= mirror;
        m[i] = vec(a.x + b.x, a.y + c * b.y - s * b.z, a.z + s * b.y + c * b.z);
    }
}

/* Symmetric, too: its inverse times its determinant. */
static form adjugate_of(const form *k)
{
    return (form){.k00 = k->k11 * k->k22 - k->k12 * k->k12,
        .k01 = k->k02 * k->k12 - k->k01 * k->k22,
        .k02 = k->k01 * k->k12 - k->k02 * k->k11,
        .k11 = k->k00 * k->k22 - k->k02 * k->k02,
        .k12 = k->k01 * k->k02 - k->k00 * k->k12,
        .k22 = k->k00 * k->k11 - k->k01 * k->k01};
}

/* r.inverse(K) r by K = L D L'; infinite unless all of D is above `noise`, and so K > 0. Where centres are one and many
 * directions are equally deep, two of D are next to nothing and a determinant is lost in rounding: these are not. */
static double value_of_inverse(const form *k, vec3 r, double noise)
{
    double d0 = k->k00, l1 = k->k01 / d0, l2 = k->k02 / d0;
    double d1 = k->k11 - l1 * k->k01, l3 = (k->k12 - l1 * k->k02) / d1;
    double d2 = k->k22 - l2 * k->k02 - l3 * (k->k12 - l1 * k->k02);
    double x = r.x, y = r.y - l1 * x, z = r.z - l2 * x - l3 * y;
    return d0 > noise && d1 > noise && d2 > noise ? x * x / d0 + y * y / d1 + z * z / d2 : INFINITY;
}

/* Where a form is negative, or nearly: the longest column of its adjugate. Unit, or zero. Of one that is negative to
 * all sides of n0, as on the far side of a centre that lies on an axis, the one that leads to -x. */
static vec3 weakest_of(const form *k)
{
    const form adjugate = adjugate_of(k);
    if (k->k11 < 0 && adjugate.k00 > 0) return vec(0.70710678118654752, 0.70710678118654752, 0);
    vec3 x = {adjugate.k00, adjugate.k01, adjugate.k02}, y = {adjugate.k01, adjugate.k11, adjugate.k12};
    vec3 z = {adjugate.k02, adjugate.k12, adjugate.k22}, longest = vec_norm2(x) >= vec_norm2(y) ? x : y;
    return direction_of(vec_norm2(z) > vec_norm2(longest) ? z : longest);
}

/* Is h >= at->h - short_by for all unit directions? With d = at->h - short_by, c the centre and H = M'M - cc', it is
 * enough that F(n) = n.H n + 2 d c.n - d^2 >= 0 for all unit n. For any l let K = H - l and r = K n0 + d c: then
 *     F(n) = (n - n0).K (n - n0) + 2 r.(n - n0) + F(n0),   F(n0) = |M n0|^2 - (d - c.n0)^2,
 * and K > 0 makes the first two at least -r.inverse(K) r. That is least at the l which leaves r orthogonal to n0; but
 * there K has no room when the centres are one, so half of F(n0) is given up for some. *weakest: where K is negative,
 * or nearly. */
static bool proves(const unit_pair *p, const place *at, const vec3 m[3], double short_by, vec3 *weakest)
{
    vec3 c = {vec_dot(p->b_in_a.t, at->n), vec_dot(p->b_in_a.t, at->x), vec_dot(p->b_in_a.t, at->y)};
    double d = at->h - short_by, noise = NOISE * UNIT_ROUNDOFF * p->size * p->size;
    double have = short_by * (2 * m[0].x - short_by), room = 0.5 * have;
    double l = vec_norm2(m[0]) - c.x * c.x + d * c.x - room;
    const form k = {.k00 = room - d * c.x,
        .k01 = vec_dot(m[0], m[1]) - c.x * c.y,
        .k02 = vec_dot(m[0], m[2]) - c.x * c.z,
        .k11 = vec_norm2(m[1]) - c.y * c.y - l,
        .k12 = vec_dot(m[1], m[2]) - c.y * c.z,
        .k22 = vec_norm2(m[2]) - c.z * c.z - l};
    vec3 r = {room, k.k01 + d * c.y, k.k02 + d * c.z};
    double value = value_of_inverse(&k, r, noise);
    if (have >= (1 + SLACK) * value + noise / 16) return true; /* of a few products */
    *weakest = weakest_of(&k);
    return false;
}

/* By ellipsoids that are made to reach farther where the last one did not far enough. *beyond: where h may be less. */
static bool is_least(const unit_pair *p, const place *at, double short_by, vec3 *beyond)
{
    turn t = turn_of(p, at);
    for (int i = 0; i < TURNS_MAX; i++) {
        vec3 m[3], e;
        inner_ellipsoid(&t, m);
        if (proves(p, at, m, short_by, &e)) return true;
        vec3 a = vec_madd(vec_madd(vec_scale(t.a[0], e.x), e.y, t.a[1]), e.z, t.a[2]);
        vec3 b = vec_madd(vec_madd(vec_scale(t.b[0], e.x), e.y, t.b[1]), e.z, t.b[2]);
        gain_along(&t, FARTHER, a, b);
        *beyond = vec_madd(vec_madd(vec_scale(at->n, 1 - 2 * e.x * e.x), -2 * e.x * e.y, at->x), -2 * e.x * e.z, at->y);
    }
    return false;
}

/* ---- search ---- */

/* Where h is a gutter, which of bodies of revolution has no slope along it: Newton's step by its two principal
 * directions, of which the flat one counts as bent by a little, or as much as it is bent the wrong way. */
static void step_in_gutter(const place *at, double xx, double yy, double *dx, double *dy)
{
    double mean = 0.5 * (xx + yy), half = 0.5 * (xx - yy), root = sqrt(half * half + at->xy * at->xy);
    double steep = mean + root, flat = max_of(fabs(mean - root), FLAT * steep);
    double ux = half >= 0 ? half + root : at->xy, uy = half >= 0 ? at->xy : root - half;
    double norm = sqrt(ux * ux + uy * uy);
    ux = norm > 0 ? ux / norm : 1, uy = norm > 0 ? uy / norm : 0;
    double down = -(ux * at->gx + uy * at->gy) / steep, along = (uy * at->gx - ux * at->gy) / flat;
    *dx = down * ux - along * uy, *dy = down * uy + along * ux;
}

static void shorten(double *dx, double *dy)
{
    double norm2 = *dx * *dx + *dy * *dy, shorter = norm2 > STRIDE * STRIDE ? STRIDE / sqrt(norm2) : 1;
    *dx *= shorter, *dy *= shorter;
}

/* Newton's step; where h is no bowl, that of the sum of norms alone, which is convex. */
static void step_of(const place *at, double *dx, double *dy)
{
    double xx = at->xx - at->h, yy = at->yy - at->h, whole = xx * yy - at->xy * at->xy;
    if (!(xx > 0 && whole > BOWL * xx * xx)) {
        if (xx + yy > 0) {
            step_in_gutter(at, xx, yy, dx, dy);
            shorten(dx, dy);
            return;
        }
        double least = BOWL * (at->xx + at->yy);
        xx = at->xx + least, yy = at->yy + least, whole = xx * yy - at->xy * at->xy;
    }
    double x = (at->xy * at->gy - yy * at->gx) / whole, y = (at->xy * at->gx - xx * at->gy) / whole;
    if (!(whole > 0)) x = y = 0; /* a point has no slopes */
    *dx = x, *dy = y;
    shorten(dx, dy);
}

/* A step that does not lower h is halved. */
static bool ellipsoids_advance(const unit_pair *p, place *at)
{
    double dx, dy;
    step_of(at, &dx, &dy);
    for (int i = 0; i < HALVINGS_MAX; i++, dx *= 0.5, dy *= 0.5) {
        place next = ellipsoids_look(p, direction_of(vec_madd(vec_madd(at->n, dx, at->x), dy, at->y)));
        if (!(next.h <= at->h + 4 * UNIT_ROUNDOFF * p->size)) continue;
        *at = next;
        look_closer(p, at);
        return true;
    }
    return false;
}

/* The centres' line; of the axes of both the lowest when there is none. */
static vec3 ellipsoids_first_direction(const unit_pair *p)
{
    const mat3 *r = &p->b_in_a.r;
    const vec3 axes[6] = {vec(1, 0, 0), vec(0, 1, 0), vec(0, 0, 1), r->x, r->y, r->z};
    vec3 best = vec_neg(direction_of(p->b_in_a.t));
    double least = vec_norm2(best) > 0 ? -INFINITY : INFINITY;
    for (int i = 0; i < 6 && least > -INFINITY; i++) {
        double h = ellipsoids_look(p, axes[i]).h;
        if (h < least) least = h, best = axes[i];
    }
    return best;
}

/* Down to where the slope is lost in rounding, or `close` is enough, or to a height below `enough`. */
static void ellipsoids_descend(const unit_pair *p, place *at, double close, double enough, uint32_t *steps)
{
    if (at->h < enough) return;
    look_closer(p, at);
    for (int i = 0; i < NEWTON_MAX; i++, ++*steps)
        if (at->h < enough || at->gx * at->gx + at->gy * at->gy <= close || !ellipsoids_advance(p, at)) return;
}

/* What the place that was found says. False: it is not proven to be the least. */
static bool ellipsoids_report(const unit_pair *p, const place *at, double short_by, vec3 *beyond, span *out)
{
    minkowski m = unit_pair_nearest_along(p, vec_neg(at->n));
    double lo = -vec_dot(at->n, m.w), shaved = p->shaved_a + p->shaved_b;
    *out = (span){.lo = lo,
        .axis = vec_neg(at->n),
        .point_a = m.a,
        .point_b = m.b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = out->iterations};
    bool least = lo > 0 || is_least(p, at, short_by, beyond);
    out->hi = max_of(lo, lo > 0 ? vec_norm(m.w) : short_by + shaved - at->h);
    return least;
}

bool ellipsoid_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    double rounding = NOISE * UNIT_ROUNDOFF * p->size, short_by = max_of(min_of(0.5 * goal->tolerance, MOST), rounding);
    double close = 0.01 * short_by, enough = p->shaved_a + p->shaved_b - max_of(goal->far, 0) - rounding;
    double highest = -INFINITY;
    vec3 beyond = ellipsoids_first_direction(p);
    out->iterations = 1;
    for (int i = 0; i < STARTS_MAX; i++) {
        place at = ellipsoids_look(p, beyond);
        ellipsoids_descend(p, &at, close, enough, &out->iterations);
        bool reported = ellipsoids_report(p, &at, short_by, &beyond, out);
        if (out->lo <= highest) return false; /* the same place again, or a higher one */
        if (!reported) {                      /* where h is bent by little, a slope of little is far from the least */
            ellipsoids_descend(p, &at, 0, enough, &out->iterations);
            reported = ellipsoids_report(p, &at, short_by, &beyond, out);
        }
        highest = out->lo;
        for (double s = 2 * short_by; !reported && s < ROUGH; s *= 2)
            reported = ellipsoids_report(p, &at, s, &beyond, out);
        if (reported && out->lo < 0 && out->hi - out->lo < 2 * ROUGH) return true; /* no other method comes closer */
        if (reported) return narrow_goal_reached(goal, out->lo, out->hi) || out->hi - out->lo <= 2 * rounding;
    }
    return false;
}
