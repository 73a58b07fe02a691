/* short_road: only what its formula reads is computed. What holds: unit_pair's scale and error and narrow.c's finish,
 * the very same inline functions, so that the bits are those of the general method. Pure; any thread. */
#include "short_road.h"

#include "box_pair.h"
#include "dispatch.h"
#include "finish.h"
#include "formulas.h"
#include "geom/round.h"
#include "near_features.h"

static inline bool answers(const narrow_request *r, const narrow_result *out)
{
    bool verdict = r->facts == 0 || (r->facts & NARROW_VERDICT), measure = r->facts & NARROW_DISTANCE;
    bool decided = out->lo > r->threshold || out->hi <= r->threshold;
    bool measured = out->hi - out->lo <= r->tolerance || out->lo > r->range;
    return (decided || !verdict) && (measured || !measure);
}

/* Is the interval enough, without more than doubles? */
static inline bool suffices(const unit_pair *p, const narrow_request *r, const span *s, const narrow_result *out)
{
    return is_narrow(p, r, s) && answers(r, out);
}

/* unit_pair_init of shapes that are no smaller kind in disguise, and of which `reach_a` and `reach_b` are the reaches.
 */
static inline void pair_of(
    const shape *a, double reach_a, const shape *b, double reach_b, const pose *b_in_a, unit_pair *p)
{
    unit_of(max_of(max_of(reach_a, reach_b), vec_greatest(b_in_a->p)), &p->unit, &p->scale);
    p->a =
        (shape){.type = a->type, .radius = a->radius * p->scale, .half = vec_scale(a->half, p->scale), .hull = a->hull};
    p->b =
        (shape){.type = b->type, .radius = b->radius * p->scale, .half = vec_scale(b->half, p->scale), .hull = b->hull};
    p->b_in_a.r = quat_matrix(b_in_a->q);
    p->b_in_a.t = vec_scale(b_in_a->p, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->size = reach_a * p->scale + reach_b * p->scale + vec_norm(p->b_in_a.t);
    p->error = unit_error(p->size);
    p->stand = NULL;
    p->shell = NULL;
    p->apart_along = VEC_ZERO;
    p->remembers = false;
    p->shaved_a = p->shaved_b = p->excess = p->deviation = 0;
}

static inline bool settle(const unit_pair *p, const narrow_request *r, const span *s, narrow_result *out)
{
    finish(p, s, out);
    out->status = NARROW_CERTAIN;
    return suffices(p, r, s, out);
}

static bool settle_boxes(
    const unit_pair *p, const narrow_goal *g, const narrow_request *r, const span *s, narrow_result *out)
{
    finish(p, s, out);
    out->status = NARROW_CERTAIN;
    return status_of(p, g, r, s) == NARROW_CERTAIN && answers(r, out);
}

bool short_road_boxes_apart(const box_pair *x, double most, int face, const narrow_request *r, epa_scratch *scratch,
    narrow_features *nearest, narrow_result *out)
{
    const unit_pair *p = x->p;
    narrow_goal g = goal_of(p, r);
    span s = {.nearest = {.count_a = 0}};
    bool named = near_features_apply(p, &g);
    if (!box_pair_apart(x, most, face, &g, &s)) dispatch_general(p, &g, false, s.axis, scratch, &s);
    if (named) near_features_settle(p, &g, &s);
    *nearest = named ? s.nearest : (narrow_features){.count_a = 0};
    return nearest->count_a || settle_boxes(p, &g, r, &s, out);
}

static double reach_of(const shape *s)
{
    return add_up(s->type == SHAPE_HULL ? s->hull->reach : length_up(s->half), s->radius);
}

/* goal_of (narrow.c), as far as features look at it. */
static narrow_goal goal_of_distance(const unit_pair *p, const shape *a, const shape *b, const narrow_request *r)
{
    double tolerance = r->tolerance * p->scale - 2 * p->error - p->excess;
    double deviation = (a->deviation + b->deviation) * p->scale;
    if (deviation < tolerance) tolerance -= deviation;
    return (narrow_goal){.tolerance = tolerance, .far = INFINITY, .near = -INFINITY};
}

bool short_road_recall(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_result *out)
{
    narrow_features *nearest = &cache->nearest;
    bool like = a->type == b->type ? near_features_scans(a, b)
                                   : nearest->deep && a->type == SHAPE_BOX && near_features_name_depths(a, b);
    bool plain =
        request->facts == NARROW_DISTANCE && request->range == INFINITY && request->engine == NARROW_ENGINE_AUTO;
    if (!nearest->count_a || !like || !plain) return false;
    unit_pair p;
    pair_of(a, reach_of(a), b, reach_of(b), b_in_a, &p);
    if (b->type == SHAPE_HULL) p.excess = ((a->type == SHAPE_HULL ? a->hull->excess : 0) + b->hull->excess) * p.scale;
    narrow_goal goal = goal_of_distance(&p, a, b, request);
    span s;
    p.shell = cache->shell;
    bool applies = nearest->deep ? near_features_reach_depths(&p, &goal) : near_features_apply(&p, &goal);
    if (!applies || !near_features_recall(&p, &goal, nearest, &s)) {
        *nearest = (narrow_features){.count_a = 0}; /* the general road need not try again */
        return false;
    }
    *nearest = s.nearest;
    return settle(&p, request, &s, out);
}
