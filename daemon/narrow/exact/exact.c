/* exact: support heights, distances of points from cores, and the fifteen axes of boxes, in double-double. Pure; any
 * thread. Nothing here searches: the axis and the features come from the search in doubles. */
#include "exact.h"

#include "geom/hull.h"
#include "narrow/closed/closed.h"
#include "narrow/convex/gjk.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/finish.h"

/* ---- exact core ---- */

/* One core in its own frame: how high it reaches, and how far a point is from it. */

/* Relative to the largest coordinate: vertices this close to the highest in doubles may be the highest. */
#define VERTEX_SLACK 0x1p-48

static dd times(double a, dd b)
{
    return dd_mul_double(b, a);
}

static dd length2(dd x, dd y)
{
    return dd_sqrt(dd_add(dd_mul(x, x), dd_mul(y, y)));
}

static dd hull_height(const hull *h, double scale, dd3 n)
{
    vec3 rough = dd3_round(n);
    double best = -INFINITY, slack = VERTEX_SLACK * h->max_abs * vec_norm(rough);
    for (uint32_t i = 0; i < h->vertex_count; i++) best = max_of(best, vec_dot(rough, hull_vertex(h, i)));
    dd top = dd_of(-INFINITY);
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        vec3 v = hull_vertex(h, i);
        if (vec_dot(rough, v) >= best - slack) top = dd_max(top, dd3_dot(n, dd3_of(vec_scale(v, scale))));
    }
    return top;
}

static dd ellipsoid_height(vec3 half, dd3 n)
{
    dd3 stretched = {times(half.x, n.x), times(half.y, n.y), times(half.z, n.z)};
    return dd3_norm(stretched);
}

/* Greatest dot(n, x) over the core; n of any length. The vertices of a hull are scaled by `scale`, a power of two. Not
 * for half-spaces. */
static dd exact_height(const shape *s, double scale, dd3 n)
{
    vec3 h = shape_core_half(s);
    dd along = times(h.z, dd_abs(n.z));
    switch (s->type) {
    case SHAPE_CYLINDER:
        return dd_add(times(h.x, length2(n.x, n.y)), along);
    case SHAPE_CONE:
        return dd_max(times(h.z, n.z), dd_sub(times(h.x, length2(n.x, n.y)), times(h.z, n.z)));
    case SHAPE_ELLIPSOID:
        return ellipsoid_height(h, n);
    case SHAPE_HULL:
        return hull_height(s->hull, scale, n);
    default:
        return dd_add(dd_add(times(h.x, dd_abs(n.x)), times(h.y, dd_abs(n.y))), along);
    }
}

static dd clamp(dd x, double h)
{
    return dd_max(dd_min(x, dd_of(h)), dd_of(-h));
}

/* The nearest point of a sphere's, capsule's or box's core. */
static dd3 exact_clamp(const shape *s, dd3 point)
{
    vec3 h = shape_core_half(s);
    return (dd3){clamp(point.x, h.x), clamp(point.y, h.y), clamp(point.z, h.z)};
}

/* From a box (a rectangle, without z) whose sides the point passes by so much: negative inside. */
static dd passed(dd x, dd y, dd z)
{
    dd most = dd_max(dd_max(x, y), z), zero = dd_of(0);
    if (!dd_less(zero, most)) return most;
    dd3 outside = {dd_max(x, zero), dd_max(y, zero), dd_max(z, zero)};
    return dd3_norm(outside);
}

/* In the half-plane (rho, z): the side runs from the apex (0, h) to the rim (r, -h), `length` long. */
static dd cone_distance(double r, double h, dd rho, dd z)
{
    dd below_apex = dd_sub(dd_of(h), z), length = length2(dd_of(r), dd_of(2 * h));
    dd off_side = dd_div(dd_sub(times(2 * h, rho), times(r, below_apex)), length);
    dd down_side = dd_div(dd_add(times(r, rho), times(2 * h, below_apex)), length);
    dd below_base = dd_sub(dd_of(-h), z);
    if (off_side.hi <= 0 && below_base.hi <= 0) return dd_max(off_side, below_base);
    if (off_side.hi > 0 && down_side.hi <= 0) return length2(rho, below_apex);
    if (off_side.hi > 0 && dd_less(down_side, length)) return off_side;
    return dd_less(rho, dd_of(r)) ? below_base : length2(dd_sub(rho, dd_of(r)), below_base);
}

static bool exact_has_distance(const shape *s)
{
    return s->type <= SHAPE_CONE;
}

/* Signed distance of a point from the core, where exact_has_distance. */
static dd exact_distance(const shape *s, dd3 point)
{
    vec3 h = shape_core_half(s);
    dd z = dd_sub(dd_abs(point.z), dd_of(h.z));
    if (s->type == SHAPE_CONE) return cone_distance(h.x, h.z, length2(point.x, point.y), point.z);
    if (s->type == SHAPE_CYLINDER) return passed(dd_sub(length2(point.x, point.y), dd_of(h.x)), dd_of(-INFINITY), z);
    return passed(dd_sub(dd_abs(point.x), dd_of(h.x)), dd_sub(dd_abs(point.y), dd_of(h.y)), z);
}

/* ---- exact ---- */

/* Of the pair's size: sums of at most a hundred terms, each rounded to 2^-100. */
#define EXACT_ERROR 0x1p-96

/* Of what is computed from cosines of edges before it is divided by their sine: a dozen terms, rounded up. */
#define CROSS_ERROR 0x1p-98

/* 1 / x for x near 1 is 1 - part, 1 / sqrt(x) is 1 - root_part, to more than the digits of dd. */
typedef struct near_one {
    bool is;
    double part, root_part;
} near_one;

static near_one near_one_of(dd x)
{
    double over = (x.hi - 1) + x.lo;
    return (near_one){fabs(over) < 0x1p-48, over - over * over, over * 0.5 - 0.375 * over * over};
}

/* An entry of the matrix, less the identity's, of a quaternion whose norm may not quite be 1. */
static dd normed(dd twice, const near_one *n, dd norm2)
{
    return dd_scale(n->is ? dd_less_part(twice, n->part) : dd_div(twice, norm2), 2);
}

static dd one_less(dd x)
{
    return dd_sub(dd_of(1), x);
}

/* R(q / |q|), or its last column alone. */
static dd_mat rotation_of(quat q, bool only_z)
{
    dd ww = dd_two_product(q.w, q.w), xx = dd_two_product(q.x, q.x), yy = dd_two_product(q.y, q.y);
    dd zz = dd_two_product(q.z, q.z), xz = dd_two_product(q.x, q.z), yz = dd_two_product(q.y, q.z);
    dd wx = dd_two_product(q.w, q.x), wy = dd_two_product(q.w, q.y), norm2 = dd_add(dd_add(ww, xx), dd_add(yy, zz));
    near_one n = near_one_of(norm2);
    dd_mat m = {.z = {normed(dd_add(xz, wy), &n, norm2), normed(dd_sub(yz, wx), &n, norm2),
                    one_less(normed(dd_add(xx, yy), &n, norm2))}};
    if (only_z) return m;
    dd xy = dd_two_product(q.x, q.y), wz = dd_two_product(q.w, q.z);
    m.x = (dd3){one_less(normed(dd_add(yy, zz), &n, norm2)), normed(dd_add(xy, wz), &n, norm2),
        normed(dd_sub(xz, wy), &n, norm2)};
    m.y = (dd3){normed(dd_sub(xy, wz), &n, norm2), one_less(normed(dd_add(xx, zz), &n, norm2)),
        normed(dd_add(yz, wx), &n, norm2)};
    return m;
}

/* A ball is the same however it is turned. */
static dd_mat core_rotation(const shape *core, quat q, bool only_z)
{
    static const dd_mat STRAIGHT = {{{1, 0}, {0, 0}, {0, 0}}, {{0, 0}, {1, 0}, {0, 0}}, {{0, 0}, {0, 0}, {1, 0}}};
    bool straight = q.w == 1 && q.x == 0 && q.y == 0 && q.z == 0;
    return straight || core->type == SHAPE_SPHERE ? STRAIGHT : rotation_of(q, only_z);
}

/* What unit_pair counted as radius, without its rounding. */
static dd exact_radius_of(const shape *given, shape_type reduced)
{
    bool ball = given->type == SHAPE_ELLIPSOID && reduced == SHAPE_SPHERE;
    return dd_two_sum(given->radius, ball ? given->half.x : 0);
}

exact_pair exact_pair_of(const unit_pair *p, const shape *a, pose pose_a, const shape *b, pose pose_b)
{
    vec3 pa = pose_a.p, pb = pose_b.p;
    dd3 t = {dd_two_sum(pb.x, -pa.x), dd_two_sum(pb.y, -pa.y), dd_two_sum(pb.z, -pa.z)};
    bool rods = p->a.type == SHAPE_CAPSULE && p->b.type == SHAPE_CAPSULE;
    return (exact_pair){
        .p = p,
        .qa = pose_a.q,
        .qb = pose_b.q,
        .ra = core_rotation(&p->a, pose_a.q, rods),
        .rb = core_rotation(&p->b, pose_b.q, rods),
        .t = {dd_scale(t.x, p->scale), dd_scale(t.y, p->scale), dd_scale(t.z, p->scale)},
        .radius = dd_scale(dd_add(exact_radius_of(a, p->a.type), exact_radius_of(b, p->b.type)), p->scale),
    };
}

/* How high a core reaches along n, seen from its origin: only as much of n in its frame as its kind asks for. */
static dd exact_height_along(const shape *core, double scale, const dd_mat *r, vec3 n)
{
    vec3 h = core->half;
    switch (core->type) {
    case SHAPE_SPHERE:
        return dd_of(0);
    case SHAPE_CAPSULE:
        return dd_mul_double(dd_abs(dd3_dot_vec(r->z, n)), h.z);
    default:
        return exact_height(core, scale, (dd3){dd3_dot_vec(r->x, n), dd3_dot_vec(r->y, n), dd3_dot_vec(r->z, n)});
    }
}

/* The cores' separation along n, of any length. */
static dd exact_separation(const exact_pair *e, vec3 n)
{
    const unit_pair *p = e->p;
    dd norm2 = dd_add(dd_add(dd_two_product(n.x, n.x), dd_two_product(n.y, n.y)), dd_two_product(n.z, n.z));
    dd top_a = exact_height_along(&p->a, p->scale, &e->ra, n),
       top_b = exact_height_along(&p->b, p->scale, &e->rb, vec_neg(n));
    dd gap = dd_sub(dd_sub(dd3_dot_vec(e->t, n), top_a), top_b);
    near_one one = near_one_of(norm2);
    return one.is ? dd_less_part(gap, one.root_part) : dd_div(gap, dd_sqrt(norm2));
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
    return min_of(CROSS_ERROR / sine, 16 * sine);
}

static dd3 column(const dd_mat *m, int i)
{
    return i == 0 ? m->x : i == 1 ? m->y : m->z;
}

static dd exact_reach_along(dd cosine, double half)
{
    return dd_mul_double(dd_abs(cosine), half);
}

/* Along the normal of a face of one box (`r`, `half`), column i: how far the other's centre is, less both reaches. */
static dd face_separation(const dd_mat *r, vec3 half, const dd_mat *other, vec3 other_half, dd3 t, int i)
{
    dd3 n = column(r, i);
    dd gap = dd_sub(dd_abs(dd3_dot(n, t)), dd_of(vec_at(half, i)));
    for (int j = 0; j < 3; j++)
        if (vec_at(other_half, j) > 0)
            gap = dd_sub(gap, exact_reach_along(dd3_dot(n, column(other, j)), vec_at(other_half, j)));
    return gap;
}

/* Along n = e_i x r_j, as box_pair.c has it: n, its length and both reaches are products of five cosines. */
static dd edge_separation(const exact_pair *e, vec3 half_a, vec3 half_b, int i, int j)
{
    int h = (i + 1) % 3, k = (i + 2) % 3, l = (j + 1) % 3, m = (j + 2) % 3;
    dd3 ai = column(&e->ra, i), ah = column(&e->ra, h), ak = column(&e->ra, k), bj = column(&e->rb, j);
    dd hj = dd3_dot(ah, bj), kj = dd3_dot(ak, bj), sine = dd_sqrt(dd_add(dd_mul(hj, hj), dd_mul(kj, kj)));
    if (!(sine.hi > 0)) return dd_of(-INFINITY);
    dd il = dd3_dot(ai, column(&e->rb, l)), im = dd3_dot(ai, column(&e->rb, m));
    dd gap = dd_abs(dd_sub(dd_mul(hj, dd3_dot(ak, e->t)), dd_mul(kj, dd3_dot(ah, e->t))));
    gap = dd_sub(dd_sub(gap, exact_reach_along(kj, vec_at(half_a, h))), exact_reach_along(hj, vec_at(half_a, k)));
    gap = dd_sub(dd_sub(gap, exact_reach_along(im, vec_at(half_b, l))), exact_reach_along(il, vec_at(half_b, m)));
    return dd_add(dd_div(gap, sine), dd_of(lack_of_edges(sine.hi) * e->p->size));
}

/* The faces' normals of either box and their edges' cross products: not below the greatest separation, which for
 * overlapping boxes is minus the depth. Of the fifteen only those that doubles cannot rule out: mostly the winner. */
static dd box_separation(const exact_pair *pair)
{
    exact_pair whole = *pair, *e = &whole;
    if (e->p->a.type == SHAPE_CAPSULE && e->p->b.type == SHAPE_CAPSULE) {
        e->ra = rotation_of(e->qa, false);
        e->rb = rotation_of(e->qb, false);
    }
    vec3 half_a = shape_core_half(&e->p->a), half_b = shape_core_half(&e->p->b);
    unsigned near = box_pair_near_best(e->p);
    dd best = dd_of(-INFINITY);
    for (int i = 0; near; i++, near >>= 1) {
        if (!(near & 1)) continue;
        if (i < 3)
            best = dd_max(best, face_separation(&e->ra, half_a, &e->rb, half_b, e->t, i));
        else if (i < BOX_FACES)
            best = dd_max(best, face_separation(&e->rb, half_b, &e->ra, half_a, e->t, i - 3));
        else
            best = dd_max(best, edge_separation(e, half_a, half_b, (i - BOX_FACES) / 3, (i - BOX_FACES) % 3));
    }
    return best;
}

static dd3 exact_into(const dd_mat *r, dd3 origin, dd3 point)
{
    return dd_mat_tmul(r, dd3_sub(point, origin));
}

static dd3 exact_out_of(const dd_mat *r, dd3 origin, dd3 local)
{
    return dd3_add(dd_mat_mul(r, local), origin);
}

/* The point of a core (of a sphere, capsule or box) that is nearest to another. */
static dd3 exact_nearest_in(const shape *core, const dd_mat *r, dd3 origin, dd3 point)
{
    if (core->type == SHAPE_SPHERE) return origin;
    if (core->type == SHAPE_BOX) return exact_out_of(r, origin, exact_clamp(core, exact_into(r, origin, point)));
    dd3 along = {dd_of(0), dd_of(0), dd3_dot(r->z, dd3_sub(point, origin))};
    return dd3_add(origin, dd3_scale(r->z, exact_clamp(core, along).z));
}

/* An upper bound, and points of the cores that are so far apart, but for the rounding of their coordinates. */
typedef struct proof {
    dd high;
    bool by_points;
    vec3 a, b;
} proof;

enum { PROJECTIONS = 2 };

/* Points that start at the witness on A, within rounding of the nearest ones, are projected to and fro: each time
 * nearer, and always in their cores. */
static proof box_distance(const exact_pair *e, const narrow_result *r)
{
    const unit_pair *p = e->p;
    const dd3 origin = dd3_of(VEC_ZERO);
    dd3 on_b = dd3_of(vec_madd(vec_scale(r->point_a, p->scale), -p->a.radius, r->axis)), on_a = origin;
    for (int i = 0; i < PROJECTIONS; i++) {
        on_a = exact_nearest_in(&p->a, &e->ra, origin, on_b);
        on_b = exact_nearest_in(&p->b, &e->rb, e->t, on_a);
    }
    return (proof){dd3_norm(dd3_sub(on_b, on_a)), true, dd3_round(on_a), dd3_round(on_b)};
}

static dd3 exact_corner(const exact_pair *e, const minkowski *m)
{
    return dd3_sub(exact_out_of(&e->rb, e->t, dd3_of(m->b_local)), dd_mat_mul(&e->ra, dd3_of(m->a)));
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

/* From 0 to 1, to the last digit: a share whose upper half is 1 may be above it. */
static bool is_share(dd s)
{
    return s.hi >= 0 && !dd_less(dd_of(1), s);
}

/* Of the point of a line, or of a plane, that is nearest to the origin; infinite where it is outside of the corners.
 * `weight`: theirs in that point. */
static dd edge_distance(const dd3 *w, double *weight)
{
    dd3 e = dd3_sub(w[1], w[0]);
    dd s = dd_div(dd_neg(dd3_dot(w[0], e)), dd3_dot(e, e));
    weight[0] = 1 - s.hi, weight[1] = s.hi;
    return is_share(s) ? dd3_norm(dd3_add(w[0], dd3_scale(e, s))) : dd_of(INFINITY);
}

static dd triangle_distance(const dd3 *w, double *weight)
{
    dd3 e1 = dd3_sub(w[1], w[0]), e2 = dd3_sub(w[2], w[0]);
    dd a = dd3_dot(e1, e1), b = dd3_dot(e1, e2), c = dd3_dot(e2, e2), x = dd3_dot(w[0], e1), y = dd3_dot(w[0], e2);
    dd whole = dd_sub(dd_mul(a, c), dd_mul(b, b));
    dd s = dd_div(dd_sub(dd_mul(b, y), dd_mul(c, x)), whole), t = dd_div(dd_sub(dd_mul(b, x), dd_mul(a, y)), whole);
    weight[0] = 1 - dd_add(s, t).hi, weight[1] = s.hi, weight[2] = t.hi;
    if (!(is_share(s) && is_share(t) && is_share(dd_add(s, t)))) return dd_of(INFINITY);
    return dd3_norm(dd3_add(w[0], dd3_add(dd3_scale(e1, s), dd3_scale(e2, t))));
}

/* The corners of B - A between which the search in doubles finds the nearest point, and that point again. */
static proof corner_distance(const exact_pair *e, vec3 axis_in_a)
{
    const narrow_goal exactly = {.far = INFINITY, .near = -INFINITY, .above = INFINITY, .below = INFINITY};
    gjk_result g;
    gjk_distance(e->p, &exactly, axis_in_a, &g);
    simplex *s = &g.simplex;
    if (s->count == 0) *s = (simplex){{unit_pair_nearest_along(e->p, axis_in_a)}, {1}, 1}; /* the first was nearest */
    dd3 w[4];
    for (int i = 0; i < s->count; i++) w[i] = exact_corner(e, &s->v[i]);
    proof found = {.high = weighted_distance(w, s->weight, s->count), .by_points = true};
    double weight[3];
    dd again = dd_of(INFINITY);
    if (s->count == 2) again = edge_distance(w, weight);
    if (s->count == 3) again = triangle_distance(w, weight);
    if (again.hi < found.high.hi || (again.hi == found.high.hi && again.lo < found.high.lo)) {
        found.high = again;
        memcpy(s->weight, weight, (size_t)s->count * sizeof *weight);
    }
    simplex_witness(s, &found.a, &found.b); /* in A's frame, which of a ball has been left out */
    const mat3 frame = quat_matrix(e->qa);
    found.a = mat_mul(frame, found.a);
    found.b = mat_mul(frame, found.b);
    return found;
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
static proof upper_bound(const exact_pair *e, const narrow_result *r)
{
    const unit_pair *p = e->p;
    bool apart = r->lo * p->scale + e->radius.hi > p->error;
    if (p->b.type == SHAPE_SPHERE) return (proof){.high = dd3_norm(e->t)};
    if (p->a.type == SHAPE_SPHERE && exact_has_distance(&p->b))
        return (proof){.high = exact_distance(&p->b, exact_into(&e->rb, e->t, dd3_of(VEC_ZERO)))};
    if (p->a.type <= SHAPE_BOX && p->b.type <= SHAPE_BOX) {
        dd s = apart ? dd_of(INFINITY) : box_separation(e);
        return s.hi <= 0 ? (proof){.high = s} : box_distance(e, r);
    }
    if (r->hi * p->scale + e->radius.hi < -p->error) return (proof){.high = dd_of(INFINITY)};
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
        r->point_b = vec_madd(r->point_b, -max_of(far - hi, least) * power_of_two(i) / far, gap);
    }
    r->point_b = r->point_a;
}

/* The points that the search in doubles found may be others, and farther apart than they are; of shapes that overlap by
 * their radii less deep. */
static void exact_take_points(const unit_pair *p, const proof *found, narrow_result *r)
{
    vec3 between = vec_sub(r->point_b, r->point_a), line = direction_of(vec_sub(found->b, found->a));
    bool farther =
        r->lo > 0 ? vec_norm(between) > r->hi * (1 + 0x1p-46) : vec_dot(between, r->axis) > r->hi + p->error * p->unit;
    if (!(r->lo > 0)) line = r->axis; /* these may be so near that the line is of rounding */
    if (!found->by_points || !farther || !(vec_norm2(line) > 0)) return;
    r->point_a = vec_scale(vec_madd(found->a, p->a.radius, line), p->unit);
    r->point_b = vec_scale(vec_madd(found->b, -p->b.radius, line), p->unit);
}

void exact_narrow(const exact_pair *e, narrow_result *r)
{
    const unit_pair *p = e->p;
    bool plane_a = p->a.type == SHAPE_HALFSPACE, plane_b = p->b.type == SHAPE_HALFSPACE;
    dd error = dd_of(EXACT_ERROR * p->size), low, high;
    proof found = {.by_points = false};
    if (plane_a || plane_b) {
        plane_bounds(e, r->axis, &low, &high);
    } else {
        low = exact_separation(e, r->axis);
        found = upper_bound(e, r);
        high = found.high;
    }
    double lo = dd_down(dd_sub(dd_sub(low, e->radius), dd_add(error, dd_of(p->excess))));
    r->lo = max_of(r->lo, real_below(p, lo));
    if (isfinite(high.hi)) r->hi = min_of(r->hi, real_above(p, dd_up(dd_add(dd_sub(high, e->radius), error))));
    r->hi = max_of(r->lo, r->hi);
    exact_take_points(p, &found, r);
    r->refined = true;
}
