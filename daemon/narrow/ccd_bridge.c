/* libccd behind its bridge. Pure; any thread: everything that its callbacks need travels in the object pointers, and
 * its memory lives for one call.
 *
 * libccd limits the iterations of its GJK, but neither those of its EPA nor of MPR's portal search. So the callbacks
 * count: past CALLS_MAX they answer with a point far behind the direction, at which each of its loops gives up. */
#include "ccd_bridge.h"

#include "geom/support.h"

#include <assert.h>
#include <ccd/ccd.h>

/* ---- ccd peer ---- */

/* What libccd proposes, held against our certificate. */

static bool ccd_propose(
    const shape *a, const shape *b, const pose *b_in_a, narrow_engine engine, ccd_proposal *out, narrow_method *method)
{
    transform t = pose_transform(*b_in_a);
    if (engine == NARROW_ENGINE_CCD) {
        *method = NARROW_BY_CCD;
        ccd_bridge_gjk(a, b, &t, VEC_ZERO, out);
    } else {
        *method = NARROW_BY_MPR;
        ccd_bridge_mpr(a, b, &t, out);
    }
    return out->answered;
}

ccd_peer_opinion ccd_peer_ask(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    narrow_engine engine, const narrow_goal *goal, span *out)
{
    ccd_peer_opinion peer = {.asked = false};
    ccd_proposal proposal = {.answered = false};
    if (engine != NARROW_ENGINE_CCD && engine != NARROW_ENGINE_MPR) return peer;
    if (a->type == SHAPE_HALFSPACE || b->type == SHAPE_HALFSPACE) return peer;
    peer.asked = true;
    peer.failed = !ccd_propose(a, b, b_in_a, engine, &proposal, &peer.method);
    peer.overlap = proposal.overlap;
    if (peer.failed || peer.overlap || !(vec_norm2(proposal.axis) > 0)) return peer;
    minkowski m = unit_pair_nearest_along(p, proposal.axis);
    double separation = vec_dot(proposal.axis, m.w);
    peer.failed = separation < p->radius - p->error;
    peer.settled = separation > goal->far;
    if (peer.settled) *out = (span){separation, vec_norm(m.w), proposal.axis, m.a, m.b, peer.method, 1, {.count_a = 0}};
    return peer;
}

uint32_t ccd_peer_failures(const ccd_peer_opinion *peer, const unit_pair *p, const span *proved)
{
    if (!peer->asked) return 0;
    bool apart = proved->lo > p->radius + p->error, overlap = proved->hi < p->radius - p->error;
    return peer->failed || (peer->overlap && apart) || (!peer->overlap && overlap);
}

bool ccd_peer_agreed(const ccd_peer_opinion *peer, const narrow_request *request, const narrow_result *result)
{
    if (!peer->asked || peer->failed || result->peer_failures) return false;
    return peer->settled || (request->facts & ~(unsigned)NARROW_VERDICT) == 0;
}

/* ---- ccd bridge ---- */

static_assert(sizeof(ccd_real_t) == sizeof(double), "libccd must be built with double precision");

enum {
    ITERATIONS_MAX = 100, /* of its GJK: hulls take 5 to 15 */
    CALLS_MAX = 200       /* support queries a shape, all phases together */
};

typedef struct ccd_pair {
    vec3 seed;
    vec3 last; /* direction of the last support query of A */
    uint32_t calls;
} ccd_pair;

typedef struct ccd_side {
    const shape *s;
    transform at; /* in A's frame, scaled */
    double scale;
    ccd_pair *pair;
} ccd_side;

static vec3 from_ccd(const ccd_vec3_t *v)
{
    return vec(v->v[0], v->v[1], v->v[2]);
}

static void to_ccd(vec3 from, ccd_vec3_t *to)
{
    ccdVec3Set(to, from.x, from.y, from.z);
}

static void support(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    const ccd_side *side = object;
    vec3 unit = vec_unit(from_ccd(direction)), far_behind = vec_scale(unit, -1e3);
    if (side->pair->calls > CALLS_MAX) {
        to_ccd(far_behind, out);
        return;
    }
    vec3 local = mat_tmul(side->at.r, unit);
    vec3 p = vec_scale(support_core(side->s, local, NULL), side->scale);
    to_ccd(vec_madd(transform_point(&side->at, p), side->s->radius * side->scale, unit), out);
}

/* libccd asks A first, in the direction that it then tests. */
static void support_of_a(const void *object, const ccd_vec3_t *direction, ccd_vec3_t *out)
{
    ccd_pair *pair = ((const ccd_side *)object)->pair;
    if (pair->calls <= CALLS_MAX) pair->last = from_ccd(direction);
    pair->calls++;
    support(object, direction, out);
}

/* Any point well inside. */
static vec3 core_centre(const shape *s)
{
    vec3 sum = VEC_ZERO;
    if (s->type == SHAPE_CONE) return vec(0, 0, -0.5 * s->half.z);
    if (s->type != SHAPE_HULL) return VEC_ZERO;
    double share = 1.0 / s->hull->vertex_count;
    for (uint32_t i = 0; i < s->hull->vertex_count; i++) sum = vec_madd(sum, share, hull_vertex(s->hull, i));
    return sum;
}

static vec3 side_centre(const ccd_side *side)
{
    return transform_point(&side->at, vec_scale(core_centre(side->s), side->scale));
}

static void centre(const void *object, ccd_vec3_t *out)
{
    to_ccd(side_centre(object), out);
}

static void ccd_first_direction(const void *a, const void *b, ccd_vec3_t *out)
{
    const ccd_side *first = a;
    vec3 seed = first->pair->seed;
    if (vec_max_abs(seed) == 0) seed = vec_sub(side_centre(b), side_centre(a));
    if (vec_max_abs(seed) == 0) seed = vec(1, 0, 0);
    to_ccd(vec_unit(seed), out);
}

/* The exponent of the pair's size: its larger shape's, or the distance of two points. */
static int size_exponent(const shape *a, const shape *b, vec3 between)
{
    int exponent;
    double size = fmax(shape_reach(a), shape_reach(b));
    frexp(size > 0 ? size : vec_max_abs(between), &exponent);
    return exponent;
}

typedef struct ccd_setup {
    ccd_t options;
    ccd_pair pair;
    ccd_side a, b;
    int exponent; /* the pair is computed 2^-exponent times its size */
} ccd_setup;

static void set_up(ccd_setup *u, const shape *a, const shape *b, const transform *b_in_a, vec3 seed)
{
    const mat3 same = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    u->exponent = size_exponent(a, b, b_in_a->t);
    double scale = ldexp(1, -u->exponent);
    u->pair = (ccd_pair){.seed = seed};
    u->a = (ccd_side){a, {same, VEC_ZERO}, scale, &u->pair};
    u->b = (ccd_side){b, {b_in_a->r, vec_scale(b_in_a->t, scale)}, scale, &u->pair};
    CCD_INIT(&u->options);
    u->options.max_iterations = ITERATIONS_MAX;
    u->options.first_dir = ccd_first_direction;
    u->options.support1 = support_of_a;
    u->options.support2 = support;
    u->options.center1 = centre;
    u->options.center2 = centre;
}

/* libccd's results: 0 = overlap, -1 = none found (a miss, or its iterations ended), -2 = out of memory. */
static void report(const ccd_setup *u, int result, double depth, const ccd_vec3_t *direction, ccd_proposal *out)
{
    bool ended = u->pair.calls > (result == 0 ? CALLS_MAX : ITERATIONS_MAX);
    *out = (ccd_proposal){.answered = result != -2 && !ended, .overlap = result == 0};
    if (result == 0) {
        out->axis = vec_unit(from_ccd(direction));
        out->depth = ldexp(depth, u->exponent);
    } else if (result == -1) {
        out->axis = vec_unit(u->pair.last);
    }
}

void ccd_bridge_gjk(const shape *a, const shape *b, const transform *b_in_a, vec3 seed, ccd_proposal *out)
{
    ccd_setup u;
    ccd_real_t depth = 0;
    ccd_vec3_t direction = {{0, 0, 0}}, position = {{0, 0, 0}};
    set_up(&u, a, b, b_in_a, seed);
    int result = ccdGJKPenetration(&u.a, &u.b, &u.options, &depth, &direction, &position);
    report(&u, result, depth, &direction, out);
}

void ccd_bridge_mpr(const shape *a, const shape *b, const transform *b_in_a, ccd_proposal *out)
{
    ccd_setup u;
    ccd_real_t depth = 0;
    ccd_vec3_t direction = {{0, 0, 0}}, position = {{0, 0, 0}};
    set_up(&u, a, b, b_in_a, VEC_ZERO);
    int result = ccdMPRPenetration(&u.a, &u.b, &u.options, &depth, &direction, &position);
    report(&u, result, depth, &direction, out);
}
