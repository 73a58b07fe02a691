/* exact: support heights, distances of points from cores, and the fifteen axes of boxes, in double-double. Pure; any
 * thread. Nothing here searches: the axis and the features come from the search in doubles. */
#include "exact.h"

#include "exact_core.h"
#include "gjk.h"
#include "scalar.h"

/* Of the pair's size: sums of at most a hundred terms, each rounded to 2^-100. */
#define EXACT_ERROR 0x1p-96

/* Of a cross product of two unit vectors: 2^-104 and room. */
#define CROSS_ERROR 0x1p-100

/* R(q / |q|) */
static dd_mat rotation_of(quat q)
{
    dd ww = dd_two_product(q.w, q.w), xx = dd_two_product(q.x, q.x), yy = dd_two_product(q.y, q.y);
    dd zz = dd_two_product(q.z, q.z), xy = dd_two_product(q.x, q.y), xz = dd_two_product(q.x, q.z);
    dd yz = dd_two_product(q.y, q.z), wx = dd_two_product(q.w, q.x), wy = dd_two_product(q.w, q.y);
    dd wz = dd_two_product(q.w, q.z), s = dd_div(dd_of(2), dd_add(dd_add(ww, xx), dd_add(yy, zz))), one = dd_of(1);
    dd3 x = {dd_add(yy, zz), dd_add(xy, wz), dd_sub(xz, wy)}, y = {dd_sub(xy, wz), dd_add(xx, zz), dd_add(yz, wx)};
    dd3 z = {dd_add(xz, wy), dd_sub(yz, wx), dd_add(xx, yy)};
    dd_mat m = {dd3_scale(x, s), dd3_scale(y, s), dd3_scale(z, s)};
    m.x.x = dd_sub(one, m.x.x);
    m.y.y = dd_sub(one, m.y.y);
    m.z.z = dd_sub(one, m.z.z);
    return m;
}

/* What unit_pair counted as radius, without its rounding. */
static dd radius_of(const shape *given, shape_type reduced)
{
    bool ball = given->type == SHAPE_ELLIPSOID && reduced == SHAPE_SPHERE;
    return dd_two_sum(given->radius, ball ? given->half.x : 0);
}

exact_pair exact_pair_of(const unit_pair *p, const shape *a, pose pose_a, const shape *b, pose pose_b)
{
    vec3 pa = pose_a.p, pb = pose_b.p;
    dd3 t = {dd_two_sum(pb.x, -pa.x), dd_two_sum(pb.y, -pa.y), dd_two_sum(pb.z, -pa.z)};
    return (exact_pair){
        .p = p,
        .ra = rotation_of(pose_a.q),
        .rb = rotation_of(pose_b.q),
        .t = {dd_scale(t.x, p->scale), dd_scale(t.y, p->scale), dd_scale(t.z, p->scale)},
        .radius = dd_scale(dd_add(radius_of(a, p->a.type), radius_of(b, p->b.type)), p->scale),
    };
}

/* The cores' separation along n, of any length. */
static dd separation(const exact_pair *e, dd3 n)
{
    dd top_a = exact_height(&e->p->a, e->p->scale, dd_mat_tmul(&e->ra, n));
    dd top_b = exact_height(&e->p->b, e->p->scale, dd3_neg(dd_mat_tmul(&e->rb, n)));
    return dd_div(dd_sub(dd_sub(dd3_dot(n, e->t), top_a), top_b), dd3_norm(n));
}

/* Along the plane's normal, which is the only axis there is. `low` is the least of what the normal says and what the
 * returned axis says, which is that normal rounded. */
static void plane_bounds(const exact_pair *e, vec3 axis, dd *low, dd *high)
{
    bool a_is_plane = e->p->a.type == SHAPE_HALFSPACE;
    const shape *other = a_is_plane ? &e->p->b : &e->p->a;
    const dd_mat *frame = a_is_plane ? &e->rb : &e->ra;
    const dd3 wide = dd3_of(axis),
              n[2] = {a_is_plane ? e->ra.z : dd3_neg(e->rb.z), dd3_scale(wide, dd_div(dd_of(1), dd3_norm(wide)))};
    dd origin[2], top[2];
    for (int i = 0; i < 2; i++) {
        dd3 local = dd_mat_tmul(frame, n[i]);
        origin[i] = dd3_dot(n[i], e->t);
        top[i] = exact_height(other, e->p->scale, a_is_plane ? dd3_neg(local) : local);
    }
    *high = dd_sub(origin[0], top[0]);
    *low = dd_sub(dd_min(origin[0], origin[1]), dd_max(top[0], top[1]));
}

/* What the separation along the cross product of two edges may lack, of the pair's size. The nearer to parallel they
 * are, the less the product's direction is known; but the narrower is also their facet of B - A, and the less it adds
 * to what lies beside it (at most eight such facets in a row). */
static double lack_of_edges(double sine)
{
    return fmin(CROSS_ERROR / sine, 16 * sine);
}

static dd separation_both_ways(const exact_pair *e, dd3 n)
{
    return dd_max(separation(e, n), separation(e, dd3_neg(n)));
}

/* A box's three axes and the other's, and their cross products: not below the greatest separation, which for
 * overlapping boxes is minus the depth. */
static dd box_separation(const exact_pair *e)
{
    const dd3 axes_a[3] = {e->ra.x, e->ra.y, e->ra.z}, axes_b[3] = {e->rb.x, e->rb.y, e->rb.z};
    dd best = dd_of(-INFINITY);
    for (int i = 0; i < 3; i++) {
        best = dd_max(best, separation_both_ways(e, axes_a[i]));
        best = dd_max(best, separation_both_ways(e, axes_b[i]));
        for (int j = 0; j < 3; j++) {
            dd3 n = dd3_cross(axes_a[i], axes_b[j]);
            double sine = dd3_norm(n).hi;
            if (!(sine > 0)) continue;
            dd lack = dd_of(lack_of_edges(sine) * e->p->size);
            best = dd_max(best, dd_add(separation_both_ways(e, n), lack));
        }
    }
    return best;
}

static dd3 into(const dd_mat *r, dd3 origin, dd3 point)
{
    return dd_mat_tmul(r, dd3_sub(point, origin));
}

static dd3 out_of(const dd_mat *r, dd3 origin, dd3 local)
{
    return dd3_add(dd_mat_mul(r, local), origin);
}

enum { PROJECTIONS = 3 };

/* The point of A's core (of a sphere, capsule or box) that is nearest to the witness, without its rounding. */
static dd3 core_point_a(const exact_pair *e, const narrow_result *r)
{
    const shape *a = &e->p->a;
    const dd3 origin = dd3_of(VEC_ZERO);
    vec3 witness = vec_madd(vec_scale(r->point_a, e->p->scale), -a->radius, r->axis);
    return out_of(&e->ra, origin, exact_clamp(a, into(&e->ra, origin, dd3_of(witness))));
}

/* Points that start within rounding of the nearest ones are projected to and fro: each time nearer, and always in their
 * cores. */
static dd box_distance(const exact_pair *e, dd3 on_a)
{
    const dd3 origin = dd3_of(VEC_ZERO);
    dd3 on_b = e->t;
    for (int i = 0; i < PROJECTIONS; i++) {
        if (i > 0) on_a = out_of(&e->ra, origin, exact_clamp(&e->p->a, into(&e->ra, origin, on_b)));
        on_b = out_of(&e->rb, e->t, exact_clamp(&e->p->b, into(&e->rb, e->t, on_a)));
    }
    return dd3_norm(dd3_sub(on_b, on_a));
}

static dd3 corner(const exact_pair *e, const minkowski *m)
{
    return dd3_sub(out_of(&e->rb, e->t, dd3_of(m->b_local)), dd_mat_mul(&e->ra, dd3_of(m->a)));
}

/* Of the point with the weights that the search found. */
static dd weighted_distance(const dd3 *w, const double *weight, int count)
{
    dd3 sum = dd3_of(VEC_ZERO);
    dd whole = dd_of(0);
    for (int i = 0; i < count; i++) {
        sum = dd3_add(sum, dd3_scale(w[i], dd_of(weight[i])));
        whole = dd_add(whole, dd_of(weight[i]));
    }
    return dd_div(dd3_norm(sum), whole);
}

/* Of the point of a line, or of a plane, that is nearest to the origin; infinite where it is outside of the corners. */
static dd edge_distance(const dd3 *w)
{
    dd3 e = dd3_sub(w[1], w[0]);
    dd s = dd_div(dd_neg(dd3_dot(w[0], e)), dd3_dot(e, e));
    return s.hi >= 0 && s.hi <= 1 ? dd3_norm(dd3_add(w[0], dd3_scale(e, s))) : dd_of(INFINITY);
}

static dd triangle_distance(const dd3 *w)
{
    dd3 e1 = dd3_sub(w[1], w[0]), e2 = dd3_sub(w[2], w[0]);
    dd a = dd3_dot(e1, e1), b = dd3_dot(e1, e2), c = dd3_dot(e2, e2), x = dd3_dot(w[0], e1), y = dd3_dot(w[0], e2);
    dd whole = dd_sub(dd_mul(a, c), dd_mul(b, b));
    dd s = dd_div(dd_sub(dd_mul(b, y), dd_mul(c, x)), whole), t = dd_div(dd_sub(dd_mul(b, x), dd_mul(a, y)), whole);
    if (!(s.hi >= 0 && t.hi >= 0 && dd_add(s, t).hi <= 1)) return dd_of(INFINITY);
    return dd3_norm(dd3_add(w[0], dd3_add(dd3_scale(e1, s), dd3_scale(e2, t))));
}

/* The corners of B - A between which the search in doubles finds the nearest point, and that point again. */
static dd corner_distance(const exact_pair *e, vec3 axis_in_a)
{
    const narrow_goal exactly = {.far = INFINITY, .near = -INFINITY, .above = INFINITY, .below = INFINITY};
    gjk_result g;
    gjk_distance(e->p, &exactly, axis_in_a, &g);
    simplex *s = &g.simplex;
    if (s->count == 0) *s = (simplex){{unit_pair_nearest_along(e->p, axis_in_a)}, {1}, 1}; /* the first was nearest */
    dd3 w[4];
    for (int i = 0; i < s->count; i++) w[i] = corner(e, &s->v[i]);
    dd distance = weighted_distance(w, s->weight, s->count);
    if (s->count == 2) distance = dd_min(distance, edge_distance(w));
    if (s->count == 3) distance = dd_min(distance, triangle_distance(w));
    return distance;
}

static bool is_polytope(const shape *s)
{
    return s->type <= SHAPE_BOX || s->type == SHAPE_HULL;
}

bool exact_applies(const unit_pair *p)
{
    if (p->b.type == SHAPE_COMPOUND) return false; /* its parts have been asked */
    bool plane_a = p->a.type == SHAPE_HALFSPACE, plane_b = p->b.type == SHAPE_HALFSPACE;
    if (plane_a || plane_b) return !(plane_a && plane_b);
    bool point = p->a.type == SHAPE_SPHERE && exact_has_distance(&p->b);
    return point || (is_polytope(&p->a) && is_polytope(&p->b));
}

/* An upper bound of the cores' signed distance; infinite where there is no formula. */
static dd upper_bound(const exact_pair *e, const narrow_result *r)
{
    const unit_pair *p = e->p;
    bool apart = r->lo * p->scale + e->radius.hi > p->error;
    if (p->a.type == SHAPE_SPHERE && exact_has_distance(&p->b))
        return exact_distance(&p->b, into(&e->rb, e->t, dd3_of(VEC_ZERO)));
    if (p->a.type <= SHAPE_BOX && p->b.type <= SHAPE_BOX) {
        dd s = apart ? dd_of(INFINITY) : box_separation(e);
        return s.hi <= 0 ? s : box_distance(e, core_point_a(e, r));
    }
    if (r->hi * p->scale + e->radius.hi < -p->error) return dd_of(INFINITY);
    return corner_distance(e, dd3_round(dd_mat_tmul(&e->ra, dd3_of(r->axis))));
}

enum { DRAWS = 8 };

void exact_draw_together(const unit_pair *p, narrow_result *r)
{
    double hi = r->hi * p->scale, least = UNIT_ROUNDOFF * vec_greatest(r->point_b) * p->scale; /* that moves it */
    for (int i = 0; i < DRAWS; i++) {
        vec3 gap = vec_sub(r->point_b, r->point_a);
        dd3 between = {dd_two_sum(r->point_b.x, -r->point_a.x), dd_two_sum(r->point_b.y, -r->point_a.y),
            dd_two_sum(r->point_b.z, -r->point_a.z)};
        double far = dd_up(dd3_norm(dd3_scale(between, dd_of(p->scale))));
        if (far <= hi) return;
        r->point_b = vec_madd(r->point_b, -ldexp(max_of(far - hi, least), i) / far, gap);
    }
    r->point_b = r->point_a;
}

void exact_narrow(const exact_pair *e, narrow_result *r)
{
    const unit_pair *p = e->p;
    bool plane_a = p->a.type == SHAPE_HALFSPACE, plane_b = p->b.type == SHAPE_HALFSPACE;
    dd error = dd_of(EXACT_ERROR * p->size), low, high;
    if (plane_a || plane_b) {
        plane_bounds(e, r->axis, &low, &high);
    } else {
        low = separation(e, dd3_of(r->axis));
        high = upper_bound(e, r);
    }
    r->lo = fmax(r->lo, dd_down(dd_sub(dd_sub(low, e->radius), dd_add(error, dd_of(p->excess)))) * p->unit);
    if (isfinite(high.hi)) r->hi = fmin(r->hi, dd_up(dd_add(dd_sub(high, e->radius), error)) * p->unit);
    r->hi = fmax(r->lo, r->hi);
    r->refined = true;
}
