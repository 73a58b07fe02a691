/* descent: an active set of at most three pieces, that grows by support points. Pure; any thread. */
#include "curved.h"
#include "narrow/convex/features.h"
#include "narrow/math/scalar.h"
#include "pieces.h"

enum { ROUNDS_MAX = 6 };

/* Of the pair's size: bounds that are apart by less leave the descent to find the rest. Beside a polytope GJK soon has
 * the very pieces; between two rims it never has the places on them. */
static const double ROUGH = 0.006, ROUGH_BETWEEN_RIMS = 0.02;

/* The square of the last step: per root of what is close, for what is left after it is of the size of that square, and
 * the distance is off by its square; and, where that was too bold, per what is close. */
static const double LAST_STEP2 = 0.03, LAST_STEP2_MOST = 1e-3, FINE_STEP2 = 1e-3;

static void lower_upper(span *s, vec3 point_a, vec3 point_b)
{
    double distance = vec_norm(vec_sub(point_b, point_a));
    if (!(distance < s->hi)) return;
    s->hi = distance;
    s->point_a = point_a;
    s->point_b = point_b;
}

/* Where the highest of the pieces is lowest, from `n`: that direction, and the points there. */
static bool descent_settle(const unit_pair *p, bundle *b, vec3 *n, double near2, span *s)
{
    pieces_face face;
    if (pieces_find_face(p, b, *n, &face)) {
        lower_upper(s, face.point_a, face.point_b);
        *n = face.normal;
        return true;
    }
    view v = pieces_view(p, *n);
    if (!pieces_descend(p, b, &v, near2)) return false;
    vec3 point_a, point_b;
    pieces_points(b, &v, &point_a, &point_b);
    lower_upper(s, point_a, point_b);
    *n = v.n;
    return true;
}

/* False: no more to be had from pieces. */
static bool descent_descend(const unit_pair *p, const narrow_goal *goal, const simplex *from, span *s)
{
    bundle b;
    support_hints hints = NO_HINTS;
    vec3 n = vec_neg(s->axis);
    double close = max_of(goal->tolerance, p->error), near2 = min_of(LAST_STEP2 * sqrt(close), LAST_STEP2_MOST);
    b.count = 0;
    pieces_add(p, &b, &from->v[0]); /* is there even when GJK ended before it counted its first point */
    for (int i = 1; i < from->count; i++) pieces_add(p, &b, &from->v[i]);
    for (int i = 0; i < ROUNDS_MAX; i++) {
        if (!descent_settle(p, &b, &n, near2, s)) return false;
        vec3 axis = vec_neg(n);
        minkowski m = unit_pair_nearest_from(p, axis, &hints);
        span_raise_lower(s, vec_dot(axis, m.w), axis);
        s->iterations++;
        if (narrow_goal_reached(goal, s->lo, s->hi)) return true;
        bool known = pieces_know(p, &b, &m);
        if (known && near2 <= FINE_STEP2 * close) return false;
        if (known)
            near2 = FINE_STEP2 * close;
        else
            pieces_add(p, &b, &m);
    }
    return false;
}

void descent_distance(const unit_pair *p, const narrow_goal *goal, vec3 seed, gjk_result *out)
{
    narrow_goal rough = *goal;
    bool between_rims = shape_has_rim(&p->a) && shape_has_rim(&p->b);
    rough.tolerance = max_of(goal->tolerance, (between_rims ? ROUGH_BETWEEN_RIMS : ROUGH) * p->size);
    rough.above = max_of(goal->above, 0);
    rough.below = -INFINITY;
    gjk_distance(p, &rough, seed, out);
    bool reached = narrow_goal_reached(goal, out->span.lo, out->span.hi);
    if (reached || out->state != GJK_APART || rim_features_at(p, goal, &out->span)) return;
    if (descent_descend(p, goal, &out->simplex, &out->span)) return;
    span best = out->span;
    gjk_distance(p, goal, best.axis, out);
    span_raise_lower(&out->span, best.lo, best.axis);
    lower_upper(&out->span, best.point_a, best.point_b);
    out->span.iterations += best.iterations;
    if (out->span.lo > 0) out->state = GJK_APART;
}

/* ---- the features of rims, from nothing ---- */

/* An axis that is so near to n* names the features. */
static const double NAMING_ANGLE = 0x1p-14;

static bool find_rims(const unit_pair *p, const narrow_goal *goal, span *s, span *out)
{
    if (rim_features_find_at(p, goal, s, out)) return true;
    if (rim_features_angle(s) > NAMING_ANGLE) {
        gjk_narrow_down(descent_distance, p, goal, s);
        if (rim_features_find_at(p, goal, s, out)) return true;
    }
    return rim_features_find_along(p, goal, s, out);
}

void descent_settle_rims(const unit_pair *p, const narrow_goal *goal, span *s)
{
    span out;
    if (s->nearest.count_a) return;
    if (!(s->hi >= 0.5 * NEAR_LEAST_DISTANCE * p->size) || s->lo > goal->far) return;
    if (find_rims(p, goal, s, &out)) *s = out;
}
