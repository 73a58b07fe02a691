/* narrow: the certified signed distance of any two shapes. It brings the pair to unit size, asks the method of the two
 * types about their cores, adds the radii and the bound of rounding, and scales back. Pure; any thread, each with its
 * own scratch; the cache is written and never read, so no answer depends on history. */
#include "narrow.h"

#include "ccd_peer.h"
#include "dispatch.h"
#include "manifold.h"
#include "order.h"

struct narrow_scratch {
    epa_scratch epa;
};

size_t narrow_scratch_size(void)
{
    return (sizeof(narrow_scratch) + 63) / 64 * 64;
}

/* With tolerance 0 an interval this narrow (relative to the pair's size) counts as narrow: curved pairs get no further.
 */
#define FINEST 1e-12

static narrow_goal goal_of(const unit_pair *p, const narrow_request *r)
{
    bool decide = r->facts == 0 || (r->facts & (NARROW_VERDICT | NARROW_MANIFOLD));
    bool measure = r->facts & (NARROW_DISTANCE | NARROW_MANIFOLD);
    double above = r->threshold * p->scale + p->radius + p->error, below = above - 2 * p->error;
    double finest = 2 * UNIT_ROUNDOFF * p->size, range = r->range * p->scale + p->radius + p->error;
    double far = decide ? above : -INFINITY;
    if (r->facts & NARROW_DISTANCE) far = fmax(far, range);
    return (narrow_goal){
        .tolerance = fmax(r->tolerance * p->scale - 2 * p->error, finest),
        .finest = finest,
        .far = far,
        .near = measure ? -INFINITY : below,
        .above = above,
        .below = decide ? below : INFINITY,
    };
}

/* From cores to shapes: radii along the line of the witnesses when the shapes are apart, along the axis when they are
 * not; bounds widened by the rounding; back to real size. */
static void finish(const unit_pair *p, const span *s, narrow_result *out)
{
    vec3 towards = s->axis;
    if (s->hi > p->radius) {
        vec3 line = vec_unit(vec_sub(s->point_b, s->point_a));
        if (vec_norm2(line) > 0) towards = line;
    }
    out->lo = (s->lo - p->radius - p->error) * p->unit;
    out->hi = (s->hi - p->radius + p->error) * p->unit;
    out->axis = s->axis;
    out->point_a = vec_scale(vec_madd(s->point_a, p->a.radius, towards), p->unit);
    out->point_b = vec_scale(vec_madd(s->point_b, -p->b.radius, towards), p->unit);
    out->method = s->method;
    out->iterations = s->iterations;
}

static narrow_status status_of(const unit_pair *p, const narrow_goal *g, const narrow_request *r, const span *s)
{
    double asked = r->tolerance > 0 ? r->tolerance * p->scale : FINEST * p->size;
    bool narrow = s->lo == s->hi || s->hi - s->lo + 2 * p->error <= asked;
    return narrow || s->lo > g->far || s->hi <= g->near ? NARROW_CERTAIN : NARROW_WIDE;
}

static void measure(const unit_pair *p, const narrow_goal *g, narrow_engine engine, narrow_scratch *scratch, span *s)
{
    bool plane = p->a.type == SHAPE_HALFSPACE || p->b.type == SHAPE_HALFSPACE;
    bool only_general = engine == NARROW_ENGINE_GJK && !plane;
    closed_form *formula = only_general ? NULL : dispatch_closed_form(p->a.type, p->b.type);
    if (formula && formula(p, g, s)) return;
    dispatch_general(p, g, only_general, VEC_ZERO, &scratch->epa, s);
}

void narrow_query(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)
{
    unit_pair p;
    span s;
    unit_pair_init(&p, a, b, b_in_a);
    narrow_goal g = goal_of(&p, request);
    ccd_peer_opinion peer = ccd_peer_ask(&p, a, b, b_in_a, request->engine, &g, &s);
    if (!peer.settled) measure(&p, &g, request->engine, scratch, &s);
    *result = (narrow_result){.peer_failures = ccd_peer_failures(&peer, &p, &s)};
    finish(&p, &s, result);
    if (ccd_peer_agreed(&peer, request, result)) result->method = peer.method;
    result->status = status_of(&p, &g, request, &s);
    if ((request->facts & NARROW_MANIFOLD) && result->lo <= request->threshold) {
        transform t = pose_transform(*b_in_a);
        manifold_build(a, b, &t, result->axis, result->point_a, result->point_b, request->threshold, &result->manifold);
    }
    if (cache) {
        cache->axis = result->axis;
        cache->b_in_a = *b_in_a;
        cache->lower = result->lo;
    }
}

/* A's frame to world axes, origin moved by `shift`. */
static void turn(narrow_result *r, quat q, vec3 shift)
{
    mat3 m = quat_matrix(q);
    r->axis = mat_mul(m, r->axis);
    r->point_a = vec_add(mat_mul(m, r->point_a), shift);
    r->point_b = vec_add(mat_mul(m, r->point_b), shift);
    for (uint32_t i = 0; i < r->manifold.count; i++)
        r->manifold.points[i].point = vec_add(mat_mul(m, r->manifold.points[i].point), shift);
}

static void swap_roles(narrow_result *r)
{
    vec3 point_a = r->point_a;
    r->axis = vec_neg(r->axis);
    r->point_a = r->point_b;
    r->point_b = point_a;
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        uint32_t f = r->manifold.points[i].feature;
        r->manifold.points[i].feature = f << 16 | f >> 16;
    }
}

void narrow_query_world(const shape *a, pose pose_a, const shape *b, pose pose_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *result)
{
    int order = order_shapes(a, b);
    bool swapped = order > 0 || (order == 0 && order_poses(pose_a, pose_b) > 0);
    pose first = swapped ? pose_b : pose_a, second = swapped ? pose_a : pose_b;
    pose relative = pose_relative(first, second);
    narrow_query(swapped ? b : a, swapped ? a : b, &relative, request, NULL, scratch, result);
    turn(result, first.q, vec_sub(first.p, pose_a.p));
    if (swapped) swap_roles(result);
}

const char *narrow_method_name(narrow_method method)
{
    static const char *const NAMES[NARROW_METHOD_COUNT] = {"closed form", "gjk", "epa", "sat", "ccd", "mpr"};
    return (unsigned)method < NARROW_METHOD_COUNT ? NAMES[method] : "unknown";
}
