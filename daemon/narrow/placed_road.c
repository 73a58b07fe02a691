/* placed_road: the formulas of capsules with balls and capsules, and the tables of all. Pure; any thread. */
#include "placed_formula.h"

#include "lanes.h"

INLINE bool ball_and_capsule(const placed *q, narrow_result *out)
{
    unit_pair p;
    span s;
    begin(q, &p);
    if (!is_in_range(q, &p)) return false;
    p.b_in_a.r.z = q->at_b->turn.z;
    p.b.half.z = q->at_b->half.z * p.scale;
    formula_sphere_capsule(&p, &s);
    vec3 towards = s.hi > p.radius ? vec_scale(s.point_b, 1 / s.hi) : s.axis;
    return (!q->everyday || s.hi > NOTICEABLE) && end(q, &p, &s, towards, out);
}

/* Two segments: p_a(s) = s a, p_b(s) = t + s b, with unit a and b, and |s| <= h. See formulas.h, of which this is the
 * one case of two that are not parallel, where they are not in A's frame. */
typedef struct lines {
    vec3 a, b, t;
    double ha, hb;
} lines;

INLINE double apart_along(const lines *g, vec3 axis)
{
    return vec_dot(axis, g->t) - fabs(vec_dot(axis, g->a)) * g->ha - fabs(vec_dot(axis, g->b)) * g->hb;
}

/* The nearest points of the two lines, the one on B moved into its segment, and the point of A's that is nearest to
 * that. */
INLINE void nearest_of_lines(const lines *g, vec3 across, double *s_a, double *s_b)
{
    double ab = vec_dot(g->a, g->b), at = vec_dot(g->a, g->t), bt = vec_dot(g->b, g->t);
    *s_a = clamp_to((at - ab * bt) / vec_norm2(across), g->ha), *s_b = *s_a * ab - bt;
    if (fabs(*s_b) > g->hb) {
        *s_b = clamp_to(*s_b, g->hb);
        *s_a = clamp_to(at + *s_b * ab, g->ha);
    }
}

/* Where rounding keeps the line between the points from proving their distance, for it is short: across both segments,
 * across the one whose end has no part in it, or from end to end. Zero where nothing is left of that: where one ends on
 * the other's line, or they are parallel. */
INLINE vec3 sharper_axis(const lines *g, vec3 across, double s_a, double s_b, vec3 v)
{
    bool inner_a = fabs(s_a) < g->ha, inner_b = fabs(s_b) < g->hb;
    if (inner_a && inner_b) return direction_of(vec_dot(across, v) < 0 ? vec_neg(across) : across);
    return direction_of(inner_a ? orthogonal_part(v, g->a) : inner_b ? orthogonal_part(v, g->b) : v);
}

/* Nearly parallel ones are not proven by any of these, and go another way.
 *
 * Rounding, in u = 2^-53, with h the sum of the half lengths, r that of the radii, e the gap of the cores, |t| <= e +
 * h. A direction is off by less than 6.5 u (test_placed_boxes). hi: each point by 7.5 u of its place on the segment,
 * B's by the sum and by t, 2 |t| + h; |v| by 3.5 e, set_bounds by 2 e + 2 r: less than 8 e + 11 h + 2 r. lo: n.t by 4
 * |t|, the segments' heights by 9.5 h, two sums by 2 |t| + 2 h; set_bounds by 2 e + 2 r; the length of n, made 1,
 * by 5.5 e + 5.5 r: less than 14 e + 18 h + 8 r. The error is 16 e + 20 h + 20 r. */
INLINE bool two_capsules(const placed *q, narrow_result *out)
{
    unit_pair p;
    span s = {.method = NARROW_BY_CLOSED_FORM, .iterations = 1};
    begin(q, &p);
    const lines g = {
        q->at_a->turn.z, q->at_b->turn.z, p.b_in_a.t, q->at_a->half.z * p.scale, q->at_b->half.z * p.scale};
    vec3 across = vec_cross(g.a, g.b);
    double s_a, s_b;
    nearest_of_lines(&g, across, &s_a, &s_b);
    s.point_a = vec_scale(g.a, s_a);
    s.point_b = vec_madd(g.t, s_b, g.b);
    vec3 v = vec_sub(s.point_b, s.point_a);
    double norm2 = vec_norm2(v);
    s.hi = sqrt(norm2);
    p.size = (q->at_a->reach + q->at_b->reach) * p.scale;
    if (q->everyday && !(p.size > LEAST_EVERYDAY && max_of(p.size, norm2) < GREATEST_EVERYDAY)) return false;
    if (!is_noticed(q, norm2)) return false;
    p.error = unit_error(1.25) * p.size + unit_error(1) * s.hi;
    double per = s.hi * (1 / norm2); /* the quotient and the root are found side by side, and what is along v, too */
    vec3 towards = s.axis = vec_scale(v, per);
    s.lo = apart_along(&g, v) * per;
    if (!(s.hi - s.lo <= 0.25 * p.error)) {
        s.axis = sharper_axis(&g, across, s_a, s_b, v);
        s.lo = apart_along(&g, s.axis);
        if (!(s.hi - s.lo <= 0.25 * p.error) || !(vec_norm2(s.axis) > 0)) return false;
        if (s.hi <= p.radius) towards = s.axis;
    }
    return end(q, &p, &s, towards, out);
}

ROAD(ball_and_capsule)
ROAD(two_capsules)

/* Where there is none, or they are not in canonical order. */
static bool no_formula(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    (void)a, (void)b, (void)request, (void)cache, (void)scratch, (void)result;
    return false;
}
#define GENERAL no_formula

/* Of ellipsoids the verdict alone has a formula. */
static bool ellipsoids_placed(const narrow_placed *a, const narrow_placed *b, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    bool measure = request->facts & NARROW_DISTANCE;
    return !measure && two_ellipsoids_placed(a, b, request, cache, scratch, result);
}

#define ALL_ROWS(two_balls, ball_and_box, two_capsules)                                                                \
    {                                                                                                                  \
        [PLACED_BALL] = {{two_balls, ball_and_capsule_placed, ball_and_box, GENERAL, GENERAL}},                        \
        [PLACED_CAPSULE] = {{GENERAL, two_capsules, capsule_and_box_placed, GENERAL, GENERAL}},                        \
        [PLACED_BOX] = {{GENERAL, GENERAL, two_boxes_placed, GENERAL, GENERAL}},                                       \
        [PLACED_ELLIPSOID] = {{GENERAL, GENERAL, GENERAL, ellipsoids_placed, GENERAL}},                                \
        [PLACED_OTHER] = {{GENERAL, GENERAL, GENERAL, GENERAL, GENERAL}},                                              \
    }
static const placed_row ROWS[PLACED_KINDS] = ALL_ROWS(two_balls_placed, ball_and_box_placed, two_capsules_placed);
static const placed_row ROWS_WIDE[PLACED_KINDS] =
    ALL_ROWS(two_balls_placed_wide, ball_and_box_placed_wide, two_capsules_placed_wide);

static uint32_t kind_of(const shape *s)
{
    static const uint32_t KINDS[SHAPE_ELLIPSOID + 1] = {[SHAPE_SPHERE] = PLACED_BALL,
        [SHAPE_CAPSULE] = PLACED_CAPSULE,
        [SHAPE_BOX] = PLACED_BOX,
        [SHAPE_CYLINDER] = PLACED_OTHER,
        [SHAPE_CONE] = PLACED_OTHER,
        [SHAPE_ELLIPSOID] = PLACED_ELLIPSOID};
    return s->type <= SHAPE_ELLIPSOID && !(s->deviation > 0) ? KINDS[s->type] : PLACED_OTHER;
}

narrow_placed narrow_placed_at(const shape *s, pose at)
{
    uint32_t kind = kind_of(s);
    const placed_row *row = &(lanes_wide() ? ROWS_WIDE : ROWS)[kind];
    mat3 turn = quat_matrix(at.q);
    bool unit = is_direction(turn.x) && is_direction(turn.y) && is_direction(turn.z);
    return (narrow_placed){row, kind, unit, s->radius, at, s->half, turn, shape_reach(s), s};
}

/* Of balls what the formulas read, and no more; A is not turned. */
bool placed_road_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    uint32_t kind_a = kind_of(a), kind_b = kind_of(b);
    placed_road *formula = (lanes_wide() ? ROWS_WIDE : ROWS)[kind_a].with[kind_b];
    if (formula == GENERAL) return false;
    narrow_placed on_a, on_b;
    on_a.unit = true, on_a.radius = a->radius, on_a.half = a->half, on_a.shape = a;
    on_a.at = POSE_IDENTITY, on_a.turn = (mat3){{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    on_a.reach = kind_a == PLACED_BALL ? a->radius : shape_reach(a);
    on_b.radius = b->radius, on_b.half = b->half, on_b.shape = b, on_b.at = *b_in_a;
    on_b.reach = kind_b == PLACED_BALL ? b->radius : shape_reach(b);
    if (kind_b != PLACED_BALL) {
        on_b.turn = quat_matrix(b_in_a->q);
        on_b.unit = is_direction(on_b.turn.x) && is_direction(on_b.turn.y) && is_direction(on_b.turn.z);
    }
    return formula(&on_a, &on_b, request, cache, scratch, result);
}
