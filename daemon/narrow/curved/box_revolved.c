/* box_revolved: the curves of directions on which the depth of a box and a body of revolution is found. Pure; any
 * thread.
 *
 * The box stands at the origin along the axes; u is minus the axis of B, t its centre. Along a unit axis m from A
 * towards B, with y = m.u, the cores overlap by
 *     h(m) = sum of half_i |m_i| + f(y) - t.m,   f the support function of B's outline (revolved.h),
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
 * A great circle, quadrant by quadrant: of B's apex h is a cosine about a fixed point, which is positive and so least
 * at an end; of a rim, see revolved.h. */
#include "geom/simd.h"
#include "narrow/convex/gjk.h"
#include "revolved.h"

static const double OUTSIDE = 1e-9; /* by which a direction may be outside of an octant and still counts there */

typedef struct scene {
    const unit_pair *p;
    outline b;
    double kink, kink_sine, at_kink; /* the cosine of the side's normal, its sine, f there */
    vec3 half, u, t;
    double sine[3]; /* between u and the axes */
} scene;

typedef struct search {
    const scene *scene;
    arc_search found;
} search;

/* ---- what has been found ---- */

static void take_along(search *x, vec3 m)
{
    const scene *c = x->scene;
    double y = min_of(max_of(vec_dot(m, c->u), -1), 1);
    arc_take(&x->found, vec_dot(c->half, vec_magnitudes(m)) + mark_at(&c->b, y).f - vec_dot(c->t, m), m);
}

/* ---- single directions ---- */

static void box_revolved_try_face(search *x, vec3 axis, double half, double t, double u, double sine)
{
    const outline *b = &x->scene->b;
    arc_take(&x->found, half - t + height(b, u, sine), axis);
    arc_take(&x->found, half + t + height(b, -u, sine), vec_neg(axis));
}

/* The faces of the box and the ends of B. False: apart, or nearly so. */
static bool box_revolved_try_faces(search *x)
{
    const scene *c = x->scene;
    vec3 t = c->t, u = c->u;
    if (vec_norm2(t) > 0) take_along(x, direction_of(t));
    if (!arc_is_deep(&x->found)) return false;
    box_revolved_try_face(x, vec(1, 0, 0), c->half.x, t.x, u.x, c->sine[0]);
    box_revolved_try_face(x, vec(0, 1, 0), c->half.y, t.y, u.y, c->sine[1]);
    box_revolved_try_face(x, vec(0, 0, 1), c->half.z, t.z, u.z, c->sine[2]);
    double both = vec_dot(c->half, vec_magnitudes(u)) + c->b.h, away = vec_dot(t, u);
    arc_take(&x->found, both - away, u);
    arc_take(&x->found, both + away, vec_neg(u));
    return arc_is_deep(&x->found);
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
    lane_mask lower = value < lanes_of(x->found.least);
    if (!lanes_bits(lower)) return;
    lanes per = lanes_choose(rest > lanes_of(0), c->kink_sine / rest, lanes_of(0)), outside = lanes_of(-OUTSIDE);
    lanes3 m = {kink * c->u.x - per * beside.x, kink * c->u.y - per * beside.y, kink * c->u.z - per * beside.z};
    lane_mask inside = (sign_x * m.x >= outside) & (sign_y * m.y >= outside) & (m.z * sign_z >= outside);
    unsigned left = lanes_bits(lower & inside);
    for (int k = 0; left; k++, left >>= 1) {
        if (!(left & 1)) continue;
        x->found.proved = min_of(x->found.proved, value[k]);
        bool level = !(rest[k] > 0); /* all along the circle: each of its directions is as good */
        vec3 any = vec_madd(vec_scale(c->u, c->kink), c->kink_sine, vec_unit_orthogonal(c->u));
        take_along(x, direction_of(level ? any : vec(m.x[k], m.y[k], m.z[k])));
    }
}

LANES_INLINE void try_all_octants(search *x)
{
    try_octants(x, 1);
    try_octants(x, -1);
}

LANES_TWINS(LANES_WIDE, void, try_circle, try_all_octants, (search *const x), (x));

/* ---- great circles ---- */

/* The directions of the kink in the plane: with a u of length s, the two with n.u = kink. */
static plane2 kink_at(const scene *c, const quadrant *q, int side)
{
    double along = c->kink / q->s, beside = side * sqrt(max_of(1 - along * along, 0));
    return unit2((plane2){along * q->c.x + beside * q->d.x, along * q->c.y + beside * q->d.y});
}

/* Both pieces count where they meet, as rounding may have put that a little beside. */
static tip box_revolved_meet(search *x, const quadrant *q, plane2 n, double slope)
{
    const scene *c = x->scene;
    tip t = arc_tip(q, slope, n);
    double rim = dot2(t.p, n), tip_h = c->b.cone ? dot2(madd2(q->v, c->b.h, q->u), n) : rim;
    x->found.proved = min_of(x->found.proved, tip_h);
    arc_take_at(&x->found, q, n, max_of(rim, tip_h));
    return t;
}

static bool in_quadrant(plane2 n)
{
    return n.x > 0 && n.y > 0;
}

/* One end sees the apex (or B's other end), the other does not: which kink lies between? */
static plane2 kink_between(const scene *c, const quadrant *q)
{
    plane2 n = kink_at(c, q, 1), other = kink_at(c, q, -1);
    return min_of(n.x, n.y) >= min_of(other.x, other.y) ? n : other;
}

static bool close_cone(search *x, const quadrant *q, plane2 e1, plane2 e2)
{
    const scene *c = x->scene;
    double rim = -c->b.h, steep = c->kink;
    bool apex_1 = q->u.x >= steep, apex_2 = q->u.y >= steep;
    if (apex_1 && apex_2) return true;
    if (apex_1 || apex_2) {
        tip k = box_revolved_meet(x, q, kink_between(c, q), rim), e = arc_tip(q, rim, apex_1 ? e2 : e1);
        return apex_1 ? arc_close(&x->found, q, rim, &k, &e) : arc_close(&x->found, q, rim, &e, &k);
    }
    tip from = arc_tip(q, rim, e1), to = arc_tip(q, rim, e2);
    if (!(q->s > steep && in_quadrant(q->c))) return arc_close(&x->found, q, rim, &from, &to);
    tip first = box_revolved_meet(x, q, kink_at(c, q, -1), rim),
        second = box_revolved_meet(x, q, kink_at(c, q, 1), rim);
    return arc_close(&x->found, q, rim, &from, &first) && arc_close(&x->found, q, rim, &second, &to);
}

static bool close_cylinder(search *x, const quadrant *q, plane2 e1, plane2 e2)
{
    const scene *c = x->scene;
    double slope_1 = copysign(c->b.h, q->u.x), slope_2 = copysign(c->b.h, q->u.y);
    tip from = arc_tip(q, slope_1, e1), to = arc_tip(q, slope_2, e2);
    bool level = !(q->s > 0); /* all of the arc is across u: either end will do, and there is no kink */
    if (slope_1 == slope_2 || level) return arc_close(&x->found, q, slope_1, &from, &to);
    plane2 n = kink_between(c, q);
    tip first = box_revolved_meet(x, q, n, slope_1), second = box_revolved_meet(x, q, n, slope_2);
    return arc_close(&x->found, q, slope_1, &from, &first) && arc_close(&x->found, q, slope_2, &second, &to);
}

/* A quadrant of m_i = 0, between the signed axes j and k. */
static quadrant quadrant_of(const scene *c, int i, double sign_j, double sign_k)
{
    int j = (i + 1) % 3, k = (i + 2) % 3;
    quadrant q = {.along = {vec_on_axis(j, sign_j), vec_on_axis(k, sign_k)}, .r = c->b.r};
    q.u = (plane2){sign_j * vec_at(c->u, j), sign_k * vec_at(c->u, k)};
    q.v = (plane2){vec_at(c->half, j) - sign_j * vec_at(c->t, j), vec_at(c->half, k) - sign_k * vec_at(c->t, k)};
    q.s = c->sine[i];
    q.c = q.s > 0 ? (plane2){q.u.x / q.s, q.u.y / q.s} : (plane2){1, 0};
    q.d = (plane2){-q.c.y, q.c.x};
    q.ui2 = vec_at(c->u, i) * vec_at(c->u, i);
    return q;
}

static bool close_quadrant(search *x, int i, double sign_j, double sign_k)
{
    quadrant q = quadrant_of(x->scene, i, sign_j, sign_k);
    const plane2 e1 = {1, 0}, e2 = {0, 1};
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
    lanes uj = sign_j * vec_at(c->u, j), uk = sign_k * vec_at(c->u, k), level = lanes_of(arc_level(&x->found));
    lanes vj = vec_at(c->half, j) - sign_j * vec_at(c->t, j), vk = vec_at(c->half, k) - sign_k * vec_at(c->t, k);
    lanes x1, y1, x2, y2;
    end_of_quadrants(c, uj, uk, c->sine[j], &x1, &y1);
    end_of_quadrants(c, uk, uj, c->sine[k], &y2, &x2);
    x1 += vj, y1 += vk, x2 += vj, y2 += vk;
    lanes dx = x2 - x1, dy = y2 - y1, cross = x1 * dy - y1 * dx, length = lanes_sqrt(dx * dx + dy * dy);
    lanes away = cross / length;
    lane_mask closed = (dx <= zero) & (dy >= zero) & (away > zero) & (away >= level);
    unsigned bits = lanes_bits(closed);
    for (int n = 0; n < LANES; n++)
        if (bits >> n & 1) x->found.proved = min_of(x->found.proved, away[n]);
    return ~bits & 15;
}

LANES_TWINS(LANES_WIDE, unsigned, open_quadrants, open_quadrants, (search *const x, int i), (x, i));

static bool close_circle(search *x, bool wide, int i)
{
    unsigned open = (wide ? open_quadrants_wide : open_quadrants_narrow)(x, i);
    for (int k = 0; open; k++, open >>= 1)
        if (open & 1 && !close_quadrant(x, i, k & 1 ? -1 : 1, k & 2 ? -1 : 1)) return false;
    return true;
}

/* ---- all of it ---- */

static bool box_revolved_find_depth(search *x, bool wide)
{
    if (!box_revolved_try_faces(x)) return false;
    (wide ? try_circle_wide : try_circle_narrow)(x);
    if (!arc_is_deep(&x->found)) return false;
    for (int i = 0; i < 3; i++)
        if (!close_circle(x, wide, i)) return false;
    return arc_is_deep(&x->found);
}

static scene box_revolved_scene_of(const unit_pair *p)
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

bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = box_revolved_scene_of(p);
    search x = {&c, arc_search_of(p, goal)};
    minkowski top;
    out->axis = VEC_ZERO;
    if (!(c.kink >= 0) || !box_revolved_find_depth(&x, lanes_wide()) ||
        !arc_search_report(&x.found, p, goal, &top, out))
        return false;
    if (!witness_facing(p, &top, out) && goal->near == -INFINITY) witness_deepest(p, out);
    return true;
}
