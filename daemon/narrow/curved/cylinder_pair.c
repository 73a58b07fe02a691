/* cylinder_pair: the directions along which the depth of two cylinders is found. Pure; any thread.
 *
 * A stands at the origin about z; u is minus B's axis, t its centre; a capsule is a cylinder without a radius. Along a
 * unit axis m from A towards B, with x = m.z and y = m.u, the cores overlap by
 *     h(m) = h_A |x| + r_A sqrt(1 - x^2) + h_B |y| + r_B sqrt(1 - y^2) - t.m,
 * which is smooth but along z and u and where x = 0 or y = 0. So it is least along one of the axes, on one of these two
 * great circles (revolved.h), or where it is stationary: there a point of a rim of A, less one of a rim of B, is h m.
 * Directions come in pairs that mirror each other in the plane of z and u; of a pair only that with the greater t.m
 * matters: that on the side of k, the unit vector across that plane with t.k >= 0. That halves both circles.
 *
 * Two rims: let b be the point of B's, D its distance from the rim of A. A stationary h is such a D: then b is inside
 * of A, beside the rim by at most the least h known: L. So its height z is within L of A's end and its distance from
 * A's axis, rho, is within L of r_A. Further m is stationary along B's rim, and on the side of k: so b is there, too,
 * on the half of its circle that is away from k. With b = centre + r_B (cos c + sin k), cos and sin of the angle along
 * the rim, the first is an interval of the cosine, in which the second rarely holds. Where it does, E = D^2 / 2 is
 * convex if the rims cross at an angle: E'' = r_B^2 - way^2 + (rho - r_A) rho'' + (z - h_A) z'',   way = the part of b'
 * along A's rim, so there is one place at most, which Newton's method finds, and E >= E(at) - |E'(at)| times the length
 * of the arc. */
#include "narrow/convex/gjk.h"
#include "revolved.h"

enum { PIECES_MAX = 24, NEWTON_MAX = 6 };

static const double PARALLEL = 0.01;  /* sine of the angle between the axes */
static const double DEEP = 0.15;      /* of the size: revolved.h answers such depths in fewer steps */
static const double INSIDE = 0x1p-30; /* of the size: rounding never reaches that far */
static const double ROUNDING = 1e-13; /* of the size: by which positions along a rim may be off */
static const double SURE = 1 + 1e-9;  /* covers the rounding of derivatives */
static const double STEEP = 1e-3;     /* of r_B^2: a least of E with less E'' is not known well */
static const double FAR = 1e-3;   /* of the size: the axis between points that are nearer than this is not known well */
static const double WIDE = 1;     /* chord of the unit circle: longer arcs are halved */
static const double ARC = 1.0472; /* of shorter ones the arc is at most this, per chord */

typedef struct scene {
    double g, s; /* cosine and sine between z and u */
    double half_a, half_b, r_a, r_b;
    vec3 t, u, k, a, b;        /* a: orthogonal to z and k; b: to u and k; both unit */
    double tz, tu, ta, tb, tk; /* t along them */
} scene;

static scene cylinders_scene_of(const unit_pair *p)
{
    vec3 u = vec_neg(p->b_in_a.r.z), t = p->b_in_a.t;
    scene c = {
        .g = u.z, .s = sqrt(u.x * u.x + u.y * u.y), .half_a = p->a.half.z, .half_b = p->b.half.z, .u = u, .t = t};
    if (!(c.s > PARALLEL)) return c;
    c.r_a = p->a.type == SHAPE_CAPSULE ? 0 : p->a.half.x;
    c.r_b = p->b.half.x;
    c.a = vec(u.x / c.s, u.y / c.s, 0);
    c.b = vec(-c.g * c.a.x, -c.g * c.a.y, c.s);
    c.tk = t.y * c.a.x - t.x * c.a.y;
    c.k = c.tk < 0 ? vec(c.a.y, -c.a.x, 0) : vec(-c.a.y, c.a.x, 0);
    c.tk = fabs(c.tk);
    c.tz = t.z;
    c.tu = vec_dot(t, u);
    c.ta = vec_dot(t, c.a);
    c.tb = vec_dot(t, c.b);
    return c;
}

static double sine_of(double cosine)
{
    return sqrt(max_of((1 - cosine) * (1 + cosine), 0));
}

/* ---- single directions ---- */

static void take_ends(arc_search *x, const scene *c)
{
    double reach = fabs(c->g), b = c->half_a + c->half_b * reach + c->r_b * c->s,
           a = c->half_b + c->half_a * reach + c->r_a * c->s;
    arc_take(x, b - c->tz, vec(0, 0, 1));
    arc_take(x, b + c->tz, vec(0, 0, -1));
    arc_take(x, a - c->tu, c->u);
    arc_take(x, a + c->tu, vec_neg(c->u));
}

static double cylinders_overlap_along(const scene *c, vec3 m)
{
    double x = min_of(fabs(m.z), 1), y = min_of(fabs(vec_dot(m, c->u)), 1);
    double sines = c->r_a * sine_of(x) + c->r_b * sine_of(y);
    return c->half_a * x + c->half_b * y + sines - vec_dot(c->t, m);
}

/* ---- the sides ---- */

/* The half of a great circle on the side of k, from -across to across: the side of one cylinder, of radius `round`,
 * with the rims of the other. */
static bool close_side(arc_search *x, const scene *c, vec3 across, double t, double half, double r, double round)
{
    for (int i = 0; i < 2; i++) {
        double sign = 1 - 2 * i;
        quadrant q = {.along = {c->k, vec_scale(across, sign)}, .u = {0, sign * c->s}, .v = {-c->tk, -sign * t}};
        q.c = (plane2){0, sign};
        q.d = (plane2){-sign, 0};
        q.ui2 = c->g * c->g;
        q.s = c->s;
        q.r = r, q.round = round;
        tip middle = arc_tip(&q, sign * half, (plane2){1, 0}), end = arc_tip(&q, sign * half, (plane2){0, 1});
        arc_take_at(x, &q, end.n, dot2(end.p, end.n));
        if (!arc_close(x, &q, sign * half, &middle, &end)) return false;
    }
    return true;
}

/* ---- two rims ---- */

typedef struct rims { /* of A at its end, which is turned to be above; of B at its */
    const scene *scene;
    double side_a, side_b;
    double z, along;  /* B's centre: less the height of A's end; along scene.a */
    double up, ahead; /* z and the place along scene.a, per cosine */
} rims;

typedef struct place {   /* of a point of B's rim */
    double cosine, sine; /* sine >= 0: away from k */
    double z, along, beside, rho;
} place;

static place cylinders_place_at(const rims *r, double cosine, double sine)
{
    const scene *c = r->scene;
    place p = {cosine, sine, r->z + r->up * cosine, r->along + r->ahead * cosine, c->tk - c->r_b * sine, 0};
    p.rho = sqrt(p.along * p.along + p.beside * p.beside);
    return p;
}

static double square(double v)
{
    return v * v;
}

/* E', and E''. */
static double slope_at(const rims *r, const place *p, double *bend)
{
    const scene *c = r->scene;
    double z1 = r->up * p->sine, along1 = r->ahead * p->sine, beside1 = c->r_b * p->cosine;
    double z2 = -r->up * p->cosine, along2 = -r->ahead * p->cosine, beside2 = c->r_b * p->sine;
    double per = p->rho > 0 ? 1 / p->rho : 0, out = p->rho - c->r_a;
    double rho1 = per * (p->along * along1 + p->beside * beside1);
    double way = per * (p->along * beside1 - p->beside * along1);
    double rho2 = per * (way * way + p->along * along2 + p->beside * beside2);
    *bend = rho1 * rho1 + out * rho2 + z1 * z1 + p->z * z2;
    return out * rho1 + p->z * z1;
}

/* The next place: by a turn of the angle, as nearly as it need be. */
static place cylinders_turned(const rims *r, const place *p, double angle)
{
    double half = 0.5 * angle, per = 1 / (1 + half * half), cosine = (1 - half * half) * per, sine = 2 * half * per;
    double next = p->cosine * cosine + p->sine * sine, beside = p->sine * cosine - p->cosine * sine;
    return cylinders_place_at(r, next, beside);
}

typedef struct bounds {
    double rho_least, rho_most, z_least, z_most, chord;
} bounds;

/* Of the arc between two places. */
static bounds bounds_of(const rims *r, const place *p, const place *q)
{
    const scene *c = r->scene;
    bool over = (p->cosine < 0) != (q->cosine < 0); /* over the place that is farthest from k */
    double nearest = c->tk - c->r_b * min_of(p->sine, q->sine),
           farthest = over ? c->tk - c->r_b : min_of(p->beside, q->beside);
    double most_beside = max_of(fabs(nearest), fabs(farthest));
    double least_beside = nearest > 0 && farthest > 0 ? min_of(nearest, farthest) : 0;
    double most_along = max_of(fabs(p->along), fabs(q->along));
    double least_along = p->along * q->along > 0 ? min_of(fabs(p->along), fabs(q->along)) : 0;
    return (bounds){sqrt(square(least_along) + square(least_beside)), sqrt(square(most_along) + square(most_beside)),
        min_of(p->z, q->z), max_of(p->z, q->z), sqrt(square(p->cosine - q->cosine) + square(p->sine - q->sine))};
}

/* Can b be as near inside of the rim of A as that? */
static bool is_beside(const rims *r, const bounds *b, double level, double noise)
{
    double r_a = r->scene->r_a;
    if (b->rho_least > r_a + noise || b->rho_most < r_a - level - noise) return false;
    double in = max_of(r_a - b->rho_most, 0), below = max_of(-b->z_most, 0);
    return b->z_most >= -level - noise && b->z_least <= noise && in * in + below * below < square(level + noise);
}

/* A bound of E'' from below; `mid`: a place of the arc. */
static double cylinders_least_bend(const rims *r, const bounds *b, const place *mid)
{
    const scene *c = r->scene;
    double r_b = c->r_b, arc = ARC * b->chord;
    if (!(b->rho_least > 0)) return -INFINITY;
    double way = fabs(mid->along * c->r_b * mid->cosine - mid->beside * r->ahead * mid->sine) / mid->rho;
    way = min_of(SURE * (way + r_b * (1 + r_b / b->rho_least) * arc), r_b);
    double off = max_of(fabs(b->rho_most - c->r_a), fabs(b->rho_least - c->r_a));
    double high = max_of(fabs(b->z_most), fabs(b->z_least));
    return r_b * r_b - SURE * (way * way + off * (way * way / b->rho_least + r_b) + high * fabs(r->up));
}

static vec3 axis_at(const rims *r, const place *p)
{
    const scene *c = r->scene;
    double per = (c->r_a - p->rho) / p->rho;
    vec3 m = vec_madd(vec_scale(c->a, per * p->along), per * p->beside, c->k);
    m.z = -r->side_a * p->z;
    return direction_of(m);
}

/* Does the axis surely leave one of the rims elsewhere than between its end and its side? */
static bool is_no_normal(const rims *r, const place *p, vec3 m, double noise)
{
    const scene *c = r->scene;
    vec3 out = vec_madd(vec_scale(c->b, p->cosine), -p->sine, c->k);
    bool of_a = p->rho <= c->r_a + noise && p->z <= noise;
    return !of_a || r->side_b * vec_dot(m, c->u) < -noise || vec_dot(m, out) > noise;
}

/* The least of E on an arc on which it is convex, nearly: how near its slope there says. */
static place cylinders_lowest_of(
    const rims *r, const place *p, double first, const place *q, double last, double *slope, double *bend)
{
    double share = last > first ? min_of(max_of(-first / (last - first), 0), 1) : 0.5;
    double cosine = p->cosine + share * (q->cosine - p->cosine), sine = p->sine + share * (q->sine - p->sine);
    double per = 1 / sqrt(cosine * cosine + sine * sine);
    place at = cylinders_place_at(r, per * cosine, per * sine);
    *slope = slope_at(r, &at, bend);
    for (int i = 0; i<NEWTON_MAX && * bend> 0; i++) {
        double next_bend;
        place next = cylinders_turned(r, &at, min_of(max_of(-*slope / *bend, -0.5), 0.5));
        double next_slope = slope_at(r, &next, &next_bend);
        if (!(fabs(next_slope) < fabs(*slope))) break;
        at = next;
        *slope = next_slope;
        *bend = next_bend;
    }
    return at;
}

static void close_bowl(arc_search *x, const rims *r, const place *p, const place *q, double arc)
{
    const scene *c = r->scene;
    double slope, bend, flat = ROUNDING * x->size * x->size, rounding = 16 * UNIT_ROUNDOFF * x->size * x->size;
    double first = slope_at(r, p, &bend), last = slope_at(r, q, &bend);
    if (first > flat || last < -flat) return; /* it rises or falls all along */
    place at = cylinders_lowest_of(r, p, first, q, last, &slope, &bend);
    double d2 = square(at.rho - c->r_a) + square(at.z);
    vec3 m = axis_at(r, &at);
    x->steps++;
    bool known = vec_norm2(m) > 0, sure = fabs(slope) <= flat && bend > STEEP * c->r_b * c->r_b;
    if (known) arc_take(x, cylinders_overlap_along(c, m), m);
    if (known && sure && d2 > square(FAR * x->size) && is_no_normal(r, &at, m, 1e-6 * x->size)) return;
    x->proved = min_of(x->proved, sqrt(max_of(d2 - 2 * (fabs(slope) + rounding) * arc, 0)));
}

/* The arc between two cosines. False: too many pieces. */
static bool close_arc(arc_search *x, const rims *r, double from, double to)
{
    place open[PIECES_MAX][2];
    int count = 1;
    double noise = ROUNDING * x->size;
    open[0][0] = cylinders_place_at(r, from, sine_of(from));
    open[0][1] = cylinders_place_at(r, to, sine_of(to));
    for (int tried = 0; count > 0; tried++) {
        place p = open[count - 1][0], q = open[count - 1][1];
        bounds b = bounds_of(r, &p, &q);
        count--;
        if (!is_beside(r, &b, x->least, noise)) continue;
        double cosine = p.cosine + q.cosine, sine = p.sine + q.sine, norm = sqrt(cosine * cosine + sine * sine);
        place mid = norm > 0 ? cylinders_place_at(r, cosine / norm, sine / norm) : cylinders_place_at(r, 0, 1);
        if (b.chord < WIDE && cylinders_least_bend(r, &b, &mid) > 0) {
            close_bowl(x, r, &p, &q, ARC * b.chord);
            continue;
        }
        if (tried >= PIECES_MAX || count + 2 > PIECES_MAX) return false;
        open[count][0] = p, open[count][1] = mid;
        open[count + 1][0] = mid, open[count + 1][1] = q;
        count += 2;
    }
    return true;
}

static bool close_rims(arc_search *x, const scene *c, double side_a, double side_b)
{
    rims r = {.scene = c, .side_a = side_a, .side_b = side_b};
    double noise = ROUNDING * x->size / c->r_b;
    r.z = side_a * (c->tz - side_b * c->half_b * c->g) - c->half_a;
    r.along = c->ta - side_b * c->half_b * c->s;
    r.up = side_a * c->r_b * c->s;
    r.ahead = -c->g * c->r_b;
    double one = -r.z / r.up, other = (-x->least - r.z) / r.up, away = min_of(c->tk / c->r_b + noise, 1);
    double from = max_of(min_of(one, other) - noise / c->s, -1), to = min_of(max_of(one, other) + noise / c->s, 1);
    double apart = sine_of(away); /* b is on the side of k where the cosine is beyond this */
    if (!(from <= to)) return true;
    if (!(apart > 0)) return close_arc(x, &r, from, to);
    if (from < -apart && !close_arc(x, &r, from, min_of(to, -apart))) return false;
    return to < apart || close_arc(x, &r, max_of(from, apart), to);
}

/* ---- all of it ---- */

/* False: apart, or nearly so. */
static bool cylinders_begin(arc_search *x, const scene *c)
{
    if (vec_norm2(c->t) > 0) {
        vec3 m = direction_of(c->t);
        arc_take(x, cylinders_overlap_along(c, m), m);
    }
    arc_take(x, c->r_a + c->r_b - c->tk, c->k);
    if (!arc_is_deep(x)) return false;
    take_ends(x, c);
    return arc_is_deep(x);
}

static bool cylinders_find_depth(arc_search *x, const scene *c)
{
    if (!close_side(x, c, c->a, c->ta, c->half_b, c->r_b, c->r_a)) return false;
    if (!close_side(x, c, c->b, c->tb, c->half_a, c->r_a, c->r_b)) return false;
    for (int i = 0; i < 4 && c->r_a > 0 && c->r_b > 0; i++)
        if (!close_rims(x, c, i & 1 ? -1 : 1, i & 2 ? -1 : 1)) return false;
    return arc_is_deep(x);
}

/* Is the point inside of the core by as much as rounding can never be? */
static bool cylinders_is_inside(const shape *s, vec3 at, double margin)
{
    double r = s->type == SHAPE_CAPSULE ? 0 : s->half.x - margin;
    return fabs(at.z) <= s->half.z - margin && r > 0 && at.x * at.x + at.y * at.y <= r * r;
}

static bool do_overlap(const unit_pair *p, const span *s)
{
    double margin = INSIDE * p->size;
    vec3 a_in_b = mat_tmul(p->b_in_a.r, vec_sub(s->point_a, p->b_in_a.t));
    return cylinders_is_inside(&p->a, s->point_b, margin) || cylinders_is_inside(&p->b, a_in_b, margin);
}

bool cylinder_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = cylinders_scene_of(p);
    arc_search x = arc_search_of(p, goal);
    minkowski top;
    out->axis = VEC_ZERO;
    if (!(c.s > PARALLEL) || !cylinders_begin(&x, &c)) return false;
    bool shallow = x.least < DEEP * p->size && goal->near == -INFINITY;
    if (shallow && cylinders_find_depth(&x, &c) && arc_search_report(&x, p, goal, &top, out) &&
        witness_facing(p, &top, out) && do_overlap(p, out))
        return true;
    out->axis = VEC_ZERO;
    return arc_is_deep(&x) && revolved_pair_measure(p, goal, out);
}
