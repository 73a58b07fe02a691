/* box_revolved: the curves of directions on which the depth of a box and a body of revolution is found. Pure; any
 * thread.
 *
 * The box stands at the origin along the axes; u is minus the axis of B, t its centre. Along a unit axis m from A
 * towards B, with y = m.u, the cores overlap by
 *     h(m) = sum of half_i |m_i| + f(y) - t.m,   f the support function of B's outline (outline.h),
 * the support function of C = A - B about the origin. C is the intersection of its supporting half-spaces at the points
 * of its boundary that have one normal only (Schneider, "Convex Bodies", theorem 2.2.6), so the cores overlap where
 * these are all above zero, and the least of them is the depth. Such a point is the difference of two points, whose
 * cones of normals, of A and turned round of B, have one direction in common:
 *   - B inside of a flat end: m = u or -u;
 *   - B on its side: the cosine of the side's normal, y = kink;
 *   - B on a rim, whose normals are a wedge, or at an apex, whose normals are a solid cone: the direction is on the
 *     boundary of either cone: y = kink, or -u, or on the boundary of A's, which are octants: m_i = 0.
 * What is left are two points, one circle, and three great circles.
 *
 * The circle y = kink: in each octant h is linear, its least is where that is least on the circle, or at the end of the
 * octant, which is on a great circle.
 *
 * A great circle, quadrant by quadrant: h is the support function of the projection of C along an axis. Of B's apex it
 * is a cosine about a fixed point, which is positive and so least at an end. Of a rim it is that of an ellipse and a
 * point, whose radius of curvature is rho(m) = r u_i^2 / (1 - y^2)^(3/2), i the axis that is projected along. Over an
 * arc where rho is at least rho_0, h - rho_0 is the support function of a convex curve, too; it holds
 * q_k = p_k - rho_0 n_k, p_k the support points at the ends n_k of the arc: so
 *     h(n) >= rho_0 + q_1.n   and   h(n) >= rho_0 + q_2.n,
 * and the least of the greater of them has a closed form. Where it falls short of the least h found by more than is
 * allowed, the arc is cut there. About a least rho > h: then q_k lies behind the origin, and the bound of an arc that
 * ends there is h. It takes two or three cuts. */
#include "box_revolved.h"

#include "lanes.h"
#include "outline.h"
#include "witness.h"

enum { ARCS_MAX = 32 /* open at a time */, STEPS_MAX = 200 };

static const double SHALLOW = 0x1p-24; /* of the size: less depth, or none, is found by other means */
static const double NOISE = 24;        /* rounding of a bound, in units of the last place, with room */
static const double OUTSIDE = 1e-9;    /* by which a direction may be outside of an octant and still counts there */
static const double CLOSE = 0x1p-20;   /* of the size: the search goes on to here, for its last steps cost less than to
                                          look for points that face each other along an axis that is a little off */
static const double FLATTEST = 4;      /* of the size: no greater radius of curvature is of use */
static const double LESS = 1 - 16 * UNIT_ROUNDOFF; /* a radius of curvature, rounded down */
static const double EDGE = 1e-9;                   /* an arc is not cut nearer to its end than this */

typedef struct plane {
    double x, y;
} plane;

typedef struct scene {
    const unit_pair *p;
    outline b;
    double kink, kink_sine, at_kink; /* the cosine of the side's normal, its sine, f there */
    vec3 half, u, t;
    double sine[3]; /* between u and the axes */
} scene;

typedef struct search {
    const scene *scene;
    double least;
    vec3 axis;     /* where the least h was found */
    double proved; /* of what was left out */
    double short_by, enough;
    uint32_t steps;
} search;

/* A quadrant of the great circle m_i = 0, turned so that its directions are (+, +) of the axes j and k. */
typedef struct quadrant {
    int j, k;
    double sign_j, sign_k;
    plane u, v, c, d; /* v: the box's corner less t; c: unit, along u; d: unit, a quarter turn from there */
    double ui2;       /* u_i^2 */
    double s;         /* |u| in the plane */
} quadrant;

typedef struct tip { /* a direction, the support point there of the piece that the arc is of, and the cosine and sine */
    plane n, p;
    double y, sine;
} tip;

typedef struct arc { /* counter-clockwise */
    tip a, b;
    double bound; /* no h on the arc is less */
    plane at;     /* where the bound is */
} arc;

static double dot2(plane a, plane b)
{
    return a.x * b.x + a.y * b.y;
}
static double cross2(plane a, plane b)
{
    return a.x * b.y - a.y * b.x;
}
static plane madd2(plane a, double s, plane b)
{
    return (plane){a.x + s * b.x, a.y + s * b.y};
}
static plane unit2(plane a)
{
    double per = 1 / sqrt(dot2(a, a));
    return (plane){per * a.x, per * a.y};
}

static vec3 magnitudes(vec3 v)
{
    return vec(fabs(v.x), fabs(v.y), fabs(v.z));
}

/* ---- what has been found ---- */

static void take(search *x, double h, vec3 m)
{
    if (!(h < x->least)) return;
    x->least = h;
    x->axis = m;
}

static void take_along(search *x, vec3 m)
{
    const scene *c = x->scene;
    double y = min_of(max_of(vec_dot(m, c->u), -1), 1);
    take(x, vec_dot(c->half, magnitudes(m)) + mark_at(&c->b, y).f - vec_dot(c->t, m), m);
}

static bool is_deep(const search *x)
{
    return x->least > SHALLOW * x->scene->p->size;
}

/* A bound that is not below it need not be raised. */
static double level_of(const search *x)
{
    return min_of(x->least - x->short_by, x->enough);
}

static bool is_closed(search *x, double bound)
{
    if (!(bound >= level_of(x))) return false;
    x->proved = min_of(x->proved, bound);
    return true;
}

/* ---- single directions ---- */

static void try_face(search *x, vec3 axis, double half, double t, double u, double sine)
{
    const outline *b = &x->scene->b;
    take(x, half - t + height(b, u, sine), axis);
    take(x, half + t + height(b, -u, sine), vec_neg(axis));
}

/* The faces of the box and the ends of B. False: apart, or nearly so. */
static bool try_faces(search *x)
{
    const scene *c = x->scene;
    vec3 t = c->t, u = c->u;
    if (vec_norm2(t) > 0) take_along(x, direction_of(t));
    if (!is_deep(x)) return false;
    try_face(x, vec(1, 0, 0), c->half.x, t.x, u.x, c->sine[0]);
    try_face(x, vec(0, 1, 0), c->half.y, t.y, u.y, c->sine[1]);
    try_face(x, vec(0, 0, 1), c->half.z, t.z, u.z, c->sine[2]);
    double both = vec_dot(c->half, magnitudes(u)) + c->b.h, away = vec_dot(t, u);
    take(x, both - away, u);
    take(x, both + away, vec_neg(u));
    return is_deep(x);
}

/* ---- the circle y = kink ---- */

/* Four octants: the least of what h is there over all of the circle, where that is in the octant. */
LANES_INLINE void try_octants(search *x, double sign_z)
{
    const scene *c = x->scene;
    const lanes sign_x = {1, -1, 1, -1}, sign_y = {1, 1, -1, -1}, kink = lanes_of(c->kink);
    lanes wx = sign_x * c->half.x - c->t.x, wy = sign_y * c->half.y - c->t.y,
          wz = lanes_of(sign_z * c->half.z - c->t.z);
    lanes along = wx * c->u.x + wy * c->u.y + wz * c->u.z;
    lanes3 beside = {wx - along * c->u.x, wy - along * c->u.y, wz - along * c->u.z};
    lanes rest = lanes_sqrt(lanes3_dot(beside, beside)), value = kink * along - rest * c->kink_sine + c->at_kink;
    lane_mask lower = value < lanes_of(x->least);
    if (!lanes_bits(lower)) return;
    lanes per = lanes_choose(rest > lanes_of(0), c->kink_sine / rest, lanes_of(0)), outside = lanes_of(-OUTSIDE);
    lanes3 m = {kink * c->u.x - per * beside.x, kink * c->u.y - per * beside.y, kink * c->u.z - per * beside.z};
    lane_mask inside = (sign_x * m.x >= outside) & (sign_y * m.y >= outside) & (m.z * sign_z >= outside);
    unsigned left = lanes_bits(lower & inside);
    for (int k = 0; left; k++, left >>= 1) {
        if (!(left & 1)) continue;
        x->proved = min_of(x->proved, value[k]);
        take_along(x, direction_of(vec(m.x[k], m.y[k], m.z[k])));
    }
}

LANES_WIDE static void try_circle_wide(search *x)
{
    try_octants(x, 1);
    try_octants(x, -1);
}

static void try_circle_narrow(search *x)
{
    try_octants(x, 1);
    try_octants(x, -1);
}

/* ---- arcs of great circles ---- */

/* `slope`: f is r sine + slope y on the piece. */
static tip tip_at(const scene *c, const quadrant *q, double slope, plane n)
{
    tip t = {.n = n, .y = dot2(q->u, n)};
    double along = dot2(q->c, n), beside = dot2(q->d, n);
    t.sine = sqrt(q->ui2 * along * along + beside * beside);
    double per = t.sine > 0 ? c->b.r / t.sine : 0, on_c = per * q->ui2 * along, off_c = per * beside;
    t.p = madd2(madd2(q->v, slope, q->u), on_c, q->c);
    t.p = madd2(t.p, off_c, q->d);
    return t;
}

static void take_at(search *x, const quadrant *q, plane n, double h)
{
    double m[3] = {0, 0, 0};
    if (!(h < x->least)) return;
    m[q->j] = q->sign_j * n.x;
    m[q->k] = q->sign_k * n.y;
    take(x, h, vec(m[0], m[1], m[2]));
}

/* The least p.n from n1 to n2. */
static double least_between(plane p, plane n1, plane n2, plane *at)
{
    if (cross2(n1, p) < 0 && cross2(n2, p) > 0) {
        double length = sqrt(dot2(p, p));
        *at = (plane){-p.x / length, -p.y / length};
        return -length;
    }
    double at_1 = dot2(p, n1), at_2 = dot2(p, n2);
    *at = at_1 < at_2 ? n1 : n2;
    return min_of(at_1, at_2);
}

/* Where one point takes over from the other, if that is in the arc; any direction of it would do. */
static plane change_at(const arc *a, plane from, plane to)
{
    plane n = {to.y - from.y, from.x - to.x};
    if (!(cross2(a->a.n, n) > 0 && cross2(n, a->b.n) > 0)) n = madd2(a->a.n, 1, a->b.n);
    return unit2(n);
}

static void bound_arc(search *x, const quadrant *q, arc *a)
{
    const scene *c = x->scene;
    bool turns = (a->a.y < 0) != (a->b.y < 0);
    double sine = turns ? 1 : max_of(a->a.sine, a->b.sine), cube = sine * sine * sine;
    double rho = cube > 0 ? min_of(LESS * c->b.r * q->ui2 / cube, FLATTEST * c->p->size) : 0;
    plane from = madd2(a->a.p, -rho, a->a.n), to = madd2(a->b.p, -rho, a->b.n), n = change_at(a, from, to), at;
    a->bound = least_between(from, a->a.n, n, &a->at);
    double other = least_between(to, n, a->b.n, &at);
    if (other < a->bound) a->bound = other, a->at = at;
    a->bound += rho;
    x->steps++;
}

static plane cut_at(const arc *a)
{
    double before = cross2(a->a.n, a->at), behind = cross2(a->at, a->b.n);
    return before > EDGE && behind > EDGE ? a->at : unit2(madd2(a->a.n, 1, a->b.n));
}

/* All of an arc of a rim. False: too many cuts, or not deep. */
static bool close_arc(search *x, const quadrant *q, double slope, const tip *from, const tip *to)
{
    arc open[ARCS_MAX];
    int count = 1;
    open[0] = (arc){.a = *from, .b = *to};
    bound_arc(x, q, &open[0]);
    while (count) {
        arc a = open[--count];
        if (is_closed(x, a.bound)) continue;
        if (count + 2 > ARCS_MAX || x->steps > STEPS_MAX) return false;
        tip cut = tip_at(x->scene, q, slope, cut_at(&a));
        take_at(x, q, cut.n, dot2(cut.p, cut.n));
        if (!is_deep(x)) return false;
        arc *l = &open[count++], *r = &open[count++];
        l->a = a.a, l->b = r->a = cut, r->b = a.b;
        bound_arc(x, q, l);
        bound_arc(x, q, r);
    }
    return true;
}

/* The directions of the kink in the plane: with a u of length s, the two with n.u = kink. */
static plane kink_at(const scene *c, const quadrant *q, int side)
{
    double along = c->kink / q->s, beside = side * sqrt(max_of(1 - along * along, 0));
    return unit2((plane){along * q->c.x + beside * q->d.x, along * q->c.y + beside * q->d.y});
}

/* Both pieces count where they meet, as rounding may have put that a little beside. */
static tip meet(search *x, const quadrant *q, plane n, double slope)
{
    const scene *c = x->scene;
    tip t = tip_at(c, q, slope, n);
    double rim = dot2(t.p, n), tip_h = c->b.cone ? dot2(madd2(q->v, c->b.h, q->u), n) : rim;
    x->proved = min_of(x->proved, tip_h);
    take_at(x, q, n, max_of(rim, tip_h));
    return t;
}

static bool in_quadrant(plane n)
{
    return n.x > 0 && n.y > 0;
}

/* One end sees the apex (or B's other end), the other does not: which kink lies between? */
static plane kink_between(const scene *c, const quadrant *q)
{
    plane n = kink_at(c, q, 1), other = kink_at(c, q, -1);
    return min_of(n.x, n.y) >= min_of(other.x, other.y) ? n : other;
}

static bool close_cone(search *x, const quadrant *q, plane e1, plane e2)
{
    const scene *c = x->scene;
    double rim = -c->b.h, steep = c->kink;
    bool apex_1 = q->u.x >= steep, apex_2 = q->u.y >= steep;
    if (apex_1 && apex_2) return true;
    if (apex_1 || apex_2) {
        tip k = meet(x, q, kink_between(c, q), rim), e = tip_at(c, q, rim, apex_1 ? e2 : e1);
        return apex_1 ? close_arc(x, q, rim, &k, &e) : close_arc(x, q, rim, &e, &k);
    }
    tip from = tip_at(c, q, rim, e1), to = tip_at(c, q, rim, e2);
    if (!(q->s > steep && in_quadrant(q->c))) return close_arc(x, q, rim, &from, &to);
    tip first = meet(x, q, kink_at(c, q, -1), rim), second = meet(x, q, kink_at(c, q, 1), rim);
    return close_arc(x, q, rim, &from, &first) && close_arc(x, q, rim, &second, &to);
}

static bool close_cylinder(search *x, const quadrant *q, plane e1, plane e2)
{
    const scene *c = x->scene;
    double slope_1 = copysign(c->b.h, q->u.x), slope_2 = copysign(c->b.h, q->u.y);
    tip from = tip_at(c, q, slope_1, e1), to = tip_at(c, q, slope_2, e2);
    if (slope_1 == slope_2) return close_arc(x, q, slope_1, &from, &to);
    plane n = kink_between(c, q);
    tip first = meet(x, q, n, slope_1), second = meet(x, q, n, slope_2);
    return close_arc(x, q, slope_1, &from, &first) && close_arc(x, q, slope_2, &second, &to);
}

static double part(vec3 v, int i)
{
    return i == 0 ? v.x : i == 1 ? v.y : v.z;
}

static quadrant quadrant_of(const scene *c, int i, double sign_j, double sign_k)
{
    quadrant q = {.j = (i + 1) % 3, .k = (i + 2) % 3, .sign_j = sign_j, .sign_k = sign_k};
    q.u = (plane){sign_j * part(c->u, q.j), sign_k * part(c->u, q.k)};
    q.v = (plane){part(c->half, q.j) - sign_j * part(c->t, q.j), part(c->half, q.k) - sign_k * part(c->t, q.k)};
    q.s = c->sine[i];
    q.c = q.s > 0 ? (plane){q.u.x / q.s, q.u.y / q.s} : (plane){1, 0};
    q.d = (plane){-q.c.y, q.c.x};
    q.ui2 = part(c->u, i) * part(c->u, i);
    return q;
}

static bool close_quadrant(search *x, int i, double sign_j, double sign_k)
{
    quadrant q = quadrant_of(x->scene, i, sign_j, sign_k);
    const plane e1 = {1, 0}, e2 = {0, 1};
    return x->scene->b.cone ? close_cone(x, &q, e1, e2) : close_cylinder(x, &q, e1, e2);
}

/* ---- the quadrants of a great circle side by side ---- */

/* The support points of B at an end of the quadrants, where the cosine is y and the sine the same in all: `along` the
 * end and across it. */
LANES_INLINE void end_of_quadrants(const scene *c, lanes y, lanes across, double sine, lanes *along, lanes *beside)
{
    const lanes zero = lanes_of(0), h = lanes_of(c->b.h), r = lanes_of(c->b.r);
    lane_mask up = c->b.cone ? y >= lanes_of(c->kink) : y >= zero;
    lanes slope = lanes_choose(up, h, -h), rim = c->b.cone ? lanes_choose(up, zero, r) : r;
    double per = sine > 0 ? 1 / sine : 0;
    *along = slope * y + rim * sine;
    *beside = slope * across - rim * y * across * per;
}

/* Bit k: nothing proves that quadrant k, which is that of the signs (k & 1, k & 2), has no lower h inside. The bound is
 * that of an arc with rho_0 = 0. */
LANES_INLINE unsigned open_quadrants(search *x, int i)
{
    const scene *c = x->scene;
    const lanes sign_j = {1, -1, 1, -1}, sign_k = {1, 1, -1, -1}, zero = lanes_of(0);
    int j = (i + 1) % 3, k = (i + 2) % 3;
    lanes uj = sign_j * part(c->u, j), uk = sign_k * part(c->u, k), level = lanes_of(level_of(x));
    lanes vj = part(c->half, j) - sign_j * part(c->t, j), vk = part(c->half, k) - sign_k * part(c->t, k);
    lanes x1, y1, x2, y2;
    end_of_quadrants(c, uj, uk, c->sine[j], &x1, &y1);
    end_of_quadrants(c, uk, uj, c->sine[k], &y2, &x2);
    x1 += vj, y1 += vk, x2 += vj, y2 += vk;
    lanes dx = x2 - x1, dy = y2 - y1, cross = x1 * dy - y1 * dx, length = lanes_sqrt(dx * dx + dy * dy);
    lanes away = cross / length;
    lane_mask closed = (dx <= zero) & (dy >= zero) & (away > zero) & (away >= level);
    unsigned bits = lanes_bits(closed);
    for (int n = 0; n < LANES; n++)
        if (bits >> n & 1) x->proved = min_of(x->proved, away[n]);
    return ~bits & 15;
}

LANES_WIDE static unsigned open_quadrants_wide(search *x, int i)
{
    return open_quadrants(x, i);
}

static unsigned open_quadrants_narrow(search *x, int i)
{
    return open_quadrants(x, i);
}

static bool close_circle(search *x, bool wide, int i)
{
    unsigned open = wide ? open_quadrants_wide(x, i) : open_quadrants_narrow(x, i);
    for (int k = 0; open; k++, open >>= 1)
        if (open & 1 && !close_quadrant(x, i, k & 1 ? -1 : 1, k & 2 ? -1 : 1)) return false;
    return true;
}

/* ---- all of it ---- */

static bool find_depth(search *x, bool wide)
{
    if (!try_faces(x)) return false;
    if (wide)
        try_circle_wide(x);
    else
        try_circle_narrow(x);
    if (!is_deep(x)) return false;
    for (int i = 0; i < 3; i++)
        if (!close_circle(x, wide, i)) return false;
    return is_deep(x);
}

static scene scene_of(const unit_pair *p)
{
    scene c = {.p = p, .b = outline_of(&p->b), .half = p->a.half, .u = vec_neg(p->b_in_a.r.z), .t = p->b_in_a.t};
    double r = c.b.r, h = c.b.h, slant = sqrt(r * r + 4 * h * h);
    c.kink = c.b.cone ? r / slant : 0;
    c.kink_sine = c.b.cone ? 2 * h / slant : 1;
    c.at_kink = c.b.cone ? h * c.kink : r;
    c.sine[0] = sqrt(c.u.y * c.u.y + c.u.z * c.u.z);
    c.sine[1] = sqrt(c.u.z * c.u.z + c.u.x * c.u.x);
    c.sine[2] = sqrt(c.u.x * c.u.x + c.u.y * c.u.y);
    return c;
}

static search search_of(const scene *c, const narrow_goal *goal)
{
    return (search){.scene = c,
        .least = INFINITY,
        .axis = VEC_ZERO,
        .proved = INFINITY,
        .short_by = max_of(0.5 * min_of(goal->tolerance, CLOSE * c->p->size), 2 * NOISE * UNIT_ROUNDOFF * c->p->size),
        .enough = -goal->near};
}

bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = scene_of(p);
    search x = search_of(&c, goal);
    double noise = NOISE * UNIT_ROUNDOFF * p->size;
    out->axis = VEC_ZERO;
    if (!(c.kink >= 0) || !find_depth(&x, lanes_wide())) return false;
    minkowski m = unit_pair_nearest_along(p, x.axis);
    double lo = vec_dot(x.axis, m.w), hi = max_of(lo, noise - min_of(x.proved, x.least));
    if (!narrow_goal_reached(goal, lo, hi) && !(hi - lo <= 4 * noise)) return false;
    *out = (span){.lo = lo, .hi = hi, .axis = x.axis, .method = NARROW_BY_CLOSED_FORM, .iterations = x.steps};
    witness_facing(p, goal, &m, out);
    return true;
}
