/* narrow: the certified signed distance of any two shapes. The query brings the pair to unit size, calls the method of
 * the two types for their cores, adds the radii and the rounding error, and scales back. What it reads from the cache
 * is proven anew, so that the answer is the same without it. Pure; any thread, each with its own scratch. */
#include "narrow.h"

#include "ccd_bridge.h"
#include "dispatch.h"
#include "geom/hull.h"
#include "narrow/contact/manifold.h"
#include "narrow/convex/near_features.h"
#include "narrow/curved/curved.h"
#include "narrow/exact/exact.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/finish.h"
#include "narrow/pair/unit_pair.h"
#include "narrow/primitives/primitives.h"
#include "narrow/tree/compound_pair.h"
#include "narrow/tree/mesh_pair.h"

struct narrow_scratch {
    epa_scratch epa;
    effort effort; /* of the query that runs */
    union_scratch pieces;
};

size_t narrow_scratch_size(void)
{
    return (sizeof(narrow_scratch) + 63) / 64 * 64;
}

/* In errors of doubles. If an interval is wider, the search has left it wide, not rounding. (The depth of hulls is
 * reported NEAR_DEPTH_WIDTHS wider on either side.) */
#define ROUNDING_WIDTHS (2 + 2 * NEAR_DEPTH_WIDTHS)

/* As a share of the sizes: shapes whose gap or depth is smaller are treated as touching. */
#define LITTLE 0x1p-20

bool narrow_ordered(const shape *a, uint64_t tie_a, const shape *b, uint64_t tie_b)
{
    int c = order_shapes(a, b);
    return c ? c < 0 : tie_a <= tie_b;
}

static void query_measure(
    const unit_pair *p, const narrow_goal *g, narrow_engine engine, narrow_scratch *scratch, span *s)
{
    bool plane = p->a.type == SHAPE_HALFSPACE || p->b.type == SHAPE_HALFSPACE;
    bool only_general = engine == NARROW_ENGINE_GJK && !plane;
    if (!only_general && near_features_at_once(p, g, s)) return;
    bool by_search = only_general || dispatch_gjk_decides(p, g);
    closed_form *formula = by_search ? NULL : dispatch_closed_form(p->a.type, p->b.type);
    if (!formula || !formula(p, g, s))
        dispatch_general(p, g, only_general, formula ? s->axis : VEC_ZERO, &scratch->epa, s);
    if (only_general) return;
    if (rim_features_apply(p, g))
        descent_settle_rims(p, g, s);
    else if (!s->nearest.deep && near_features_apply(p, g))
        near_features_settle(p, g, s);
}

/* Answers from the features that the pair remembers, if these or neighbouring ones are still the nearest. */
static bool recall(const unit_pair *p, const narrow_request *request, const narrow_goal *g, bool near, bool rims,
    const narrow_cache *cache, span *s, narrow_result *result)
{
    if (!cache || !cache->nearest.count_a || request->engine != NARROW_ENGINE_AUTO) return false;
    if (!rims && !near && !cache->nearest.deep) return false;
    if (rims ? !rim_features_recall(p, g, &cache->nearest, cache->axis, s)
             : !near_features_recall(p, g, &cache->nearest, s))
        return false;
    finish(p, s, result);
    return true;
}

/* Answers in doubles: by libccd if the request names it and its proposal is certified, else by the methods of the
 * types. */
static void answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, const unit_pair *p, const narrow_goal *g, span *s,
    narrow_result *result)
{
    if (a->type == SHAPE_HULL && b->type == SHAPE_HULL) hull_fetch(a->hull), hull_fetch(b->hull);
    if (mesh_pair_applies(a, b)) {
        mesh_pair_measure(p, a, b, g, cache, &scratch->epa, &scratch->pieces, s);
        finish(p, s, result);
        return;
    }
    if (request->engine < NARROW_ENGINE_CCD) {
        query_measure(p, g, request->engine, scratch, s);
        finish(p, s, result);
        return;
    }
    ccd_peer_opinion peer = ccd_peer_ask(p, a, b, b_in_a, request->engine, g, s);
    if (!peer.settled) query_measure(p, g, request->engine, scratch, s);
    finish(p, s, result);
    result->peer_failures = ccd_peer_failures(&peer, p, s);
    if (ccd_peer_agreed(&peer, request, result)) result->method = peer.method;
}

__attribute__((noinline)) static void build_manifold(
    const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a, double threshold, narrow_result *result)
{
    transform t = pose_transform(*b_in_a);
    if (!mesh_pair_applies(a, b)) {
        manifold_build(a, b, &t, result->axis, result->point_a, result->point_b, threshold, &result->manifold);
        return;
    }
    p->effort->left = EFFORT_OF_POINTS;
    mesh_pair_manifold(p, a, b, b_in_a, result, threshold, &result->manifold);
    if (p->effort->left < 0) result->status = NARROW_WIDE; /* there may be better points among the parts not seen */
}

/* Does the request ask for contact points, and are the shapes near enough for them? */
static bool wants_manifold(const narrow_request *r, const narrow_result *result)
{
    return (r->facts & NARROW_MANIFOLD) && result->lo <= r->threshold;
}

/* Takes from the cache what changes the time of an answer and none of its bits. */
static void query_remember(unit_pair *p, const narrow_cache *cache)
{
    p->shell = cache->shell;
    p->remembers = vec_norm2(cache->axis) > 0;
    if (cache->lower > 0) p->apart_along = cache->axis;
}

static narrow_ask query_part;

/* The answer of the search in doubles, in A's frame. */
static void query_search(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, effort *effort, unit_pair *p, narrow_result *result)
{
    span s;
    shape hull; /* what a half-space sees of a mesh */
    s.nearest = (narrow_features){.count_a = 0};
    if (b->type == SHAPE_MESH && !mesh_pair_applies(a, b)) hull = *b, hull.type = SHAPE_HULL, b = &hull;
    unit_pair_init(p, a, b, b_in_a);
    p->effort = effort;
    if (compound_pair_applies(b)) {
        compound_pair_query(p, a, b, b_in_a, request, query_part, scratch, &scratch->epa, &scratch->pieces, result);
        return;
    }
    if (mesh_pair_applies(a, b)) mesh_pair_prepare(p, a);
    narrow_goal g = goal_of(p, request);
    bool near = near_features_apply(p, &g), rims = !near && rim_features_apply(p, &g), gaps = near || rims;
    bool by_features = gaps || near_features_reach_depths(p, &g);
    if (cache && by_features) query_remember(p, cache);
    if (!by_features || !recall(p, request, &g, near, rims, cache, &s, result))
        answer(a, b, b_in_a, request, cache, scratch, p, &g, &s, result);
    if (!gaps && !s.nearest.deep) s.nearest.count_a = 0; /* a proposal that nobody has tested */
    if (cache && by_features) cache->nearest = s.nearest;
    result->status = status_of(p, &g, request, &s);
    if (wants_manifold(request, result)) build_manifold(p, a, b, b_in_a, request->threshold, result);
}

static bool decided(const narrow_request *r, const narrow_result *result)
{
    return result->lo > r->threshold || result->hi <= r->threshold;
}

/* Is rounding of doubles the reason why the bounds are wider than asked? With tolerance 0 each bit counts. */
static bool wants_refining(const unit_pair *p, const narrow_request *r, const narrow_result *result)
{
    bool asks_verdict = r->facts == 0 || (r->facts & (NARROW_VERDICT | NARROW_MANIFOLD));
    bool too_wide =
        (r->facts & NARROW_DISTANCE) && result->lo <= r->range && !(result->hi - result->lo <= r->tolerance);
    bool undecided = asks_verdict && !decided(r, result);
    bool by_rounding = r->tolerance == 0 || result->hi - result->lo <= ROUNDING_WIDTHS * p->error * p->unit;
    return (too_wide || undecided) && by_rounding && exact_applies(p);
}

/* Sets status and manifold after double-double arithmetic has narrowed the bounds. */
static void query_settle(const unit_pair *p, const narrow_request *r, narrow_result *result)
{
    bool narrow = result->hi - result->lo <= asked_width(p, r);
    bool verdict_only = !(r->facts & NARROW_DISTANCE);
    if (narrow || (verdict_only && decided(r, result))) result->status = NARROW_CERTAIN;
    if (result->lo > r->threshold) result->manifold.count = 0;
    if (result->lo > 0) exact_draw_together(p, result);
}

/* Widens the answer about two shapes to the things that they approximate. Let A and B be within the shapes
 * A' and B', each point of A' within e_a of A, each of B' within e_b of B. A' holds A, so lo <= d(A', B') <= d(A, B),
 * and a translation that separates A' from B' separates A from B: lo stays. If A' and B' are apart, their nearest
 * points are within e_a and e_b of A and B: d(A, B) <= d(A', B') + e_a + e_b. If they overlap, a common point is within
 * e_a of A and e_b of B: d(A, B) <= e_a + e_b. Nothing below that holds: A may be a tube, A' the tube filled, and B in
 * the tube, as deep in A' as the tube is long, without touching it. (If A and B were convex, their support functions
 * would be within e_a and e_b of those of A' and B', and hi + e_a + e_b would hold there, too; but they need not be
 * convex.) The addition is rounded up. */
static void deviate(const shape *a, const shape *b, const narrow_request *r, narrow_result *result)
{
    double deviation = a->deviation + b->deviation;
    if (!(deviation > 0) || compound_pair_applies(b)) return; /* of a compound the parts have been asked */
    result->hi = (max_of(result->hi, 0) + deviation) * (1 + 4 * UNIT_ROUNDOFF);
    bool measure = r->facts & NARROW_DISTANCE, verdict = r->facts == 0 || (r->facts & ~(unsigned)NARROW_DISTANCE);
    bool measured = result->hi - result->lo <= r->tolerance || result->lo > r->range;
    bool settled = (measured || !measure) && (decided(r, result) || (measure && measured) || !verdict);
    result->status = settled ? NARROW_CERTAIN : NARROW_WIDE;
}

/* For shapes that almost touch, raises hi to the distance of the two points that are reported. Deeper overlaps are
 * known without points, and a common point gives hi = 0. A gap whose interval is narrower than itself has been proven
 * by points already. */
static void keep_to_points(const shape *a, const shape *b, const narrow_request *r, narrow_result *result)
{
    if (!(2 * result->lo < result->hi && result->hi > 0) || result->refined || !(r->facts & NARROW_DISTANCE)) return;
    double far = vec_norm(vec_sub(result->point_b, result->point_a)) * (1 + 4 * UNIT_ROUNDOFF);
    double little = LITTLE * (shape_reach(a) + shape_reach(b));
    if (!(far > result->hi && far <= little && -result->lo <= little)) return;
    result->hi = far;
    if (!(far - result->lo <= r->tolerance)) result->status = NARROW_WIDE;
}

static void query(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, effort *effort, narrow_result *result)
{
    if (!primitives_answer(a, b, b_in_a, request, cache, &scratch->epa, result)) {
        unit_pair p;
        query_search(a, b, b_in_a, request, cache, scratch, effort, &p, result);
        if (wants_refining(&p, request, result)) {
            exact_pair e = exact_pair_of(&p, a, POSE_IDENTITY, b, *b_in_a);
            exact_narrow(&e, result);
            query_settle(&p, request, result);
        }
    } else if (wants_manifold(request, result)) {
        build_manifold(NULL, a, b, b_in_a, request->threshold, result);
    }
    keep_to_points(a, b, request, result);
    deviate(a, b, request, result);
    if (cache) {
        cache->axis = result->axis;
        cache->b_in_a = *b_in_a;
        cache->lower = result->lo;
    }
}

static uint32_t vertices_of(const shape *s)
{
    return s->type == SHAPE_HULL ? s->hull->vertex_count : 0;
}

/* The effort of the query; NULL if no search of these shapes takes so long that its effort has to be counted. */
static effort *begin_effort(const shape *a, const shape *b, narrow_scratch *scratch)
{
    if (b->type < SHAPE_HULL || (b->type == SHAPE_HULL && vertices_of(a) + vertices_of(b) < EFFORT_LARGE_HULL))
        return NULL;
    scratch->effort = (effort){.left = EFFORT_OF_A_QUERY};
    return &scratch->effort;
}

void narrow_query(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    query(a, b, b_in_a, request, cache, scratch, begin_effort(a, b, scratch), result);
}

static void query_part(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result)
{
    query(a, b, b_in_a, request, NULL, scratch, &scratch->effort, result);
}

/* Turns the answer from A's frame to world axes. */
static void turn_by(narrow_result *r, const mat3 *m)
{
    r->axis = direction_again(mat_mul(*m, r->axis));
    r->point_a = mat_mul(*m, r->point_a);
    r->point_b = mat_mul(*m, r->point_b);
    for (uint32_t i = 0; i < r->manifold.count; i++)
        r->manifold.points[i].point = mat_mul(*m, r->manifold.points[i].point);
}

static void query_turn(narrow_result *r, quat q)
{
    mat3 m = quat_matrix(q);
    turn_by(r, &m);
}

static void move_origin(narrow_result *r, vec3 shift)
{
    r->point_a = vec_add(r->point_a, shift);
    r->point_b = vec_add(r->point_b, shift);
    for (uint32_t i = 0; i < r->manifold.count; i++)
        r->manifold.points[i].point = vec_add(r->manifold.points[i].point, shift);
}

static void swap_roles(narrow_result *r)
{
    vec3 point_a = r->point_a;
    r->axis = vec_neg(r->axis);
    r->point_a = r->point_b;
    r->point_b = point_a;
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        uint64_t *feature = &r->manifold.points[i].feature;
        *feature = feature_turned(*feature);
    }
}

void narrow_query_world(const shape *a, pose pose_a, const shape *b, pose pose_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result)
{
    int order = order_shapes(a, b);
    bool swapped = order > 0 || (order == 0 && order_poses(pose_a, pose_b) > 0), refine = false;
    pose first = swapped ? pose_b : pose_a, second = swapped ? pose_a : pose_b;
    const shape *shape_1 = swapped ? b : a, *shape_2 = swapped ? a : b;
    unit_pair p;
    if (request->facts & NARROW_MANIFOLD ||
        !primitives_answer_in_world(shape_1, &first, shape_2, &second, request, result)) {
        pose relative = pose_relative(first, second);
        effort *effort = begin_effort(shape_1, shape_2, scratch);
        query_search(shape_1, shape_2, &relative, request, NULL, scratch, effort, &p, result);
        query_turn(result, first.q);
        refine = wants_refining(&p, request, result);
    }
    if (refine) {
        exact_pair e = exact_pair_of(&p, shape_1, first, shape_2, second);
        exact_narrow(&e, result);
    }
    keep_to_points(shape_1, shape_2, request, result);
    move_origin(result, vec_sub(first.p, pose_a.p));
    if (refine) query_settle(&p, request, result);
    deviate(shape_1, shape_2, request, result);
    if (swapped) swap_roles(result);
}

const char *narrow_method_name(narrow_method method)
{
    static const char *const NAMES[NARROW_METHOD_COUNT] = {"closed form", "gjk", "epa", "sat", "ccd", "mpr"};
    return (unsigned)method < NARROW_METHOD_COUNT ? NAMES[method] : "unknown";
}
