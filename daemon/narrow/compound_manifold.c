/* compound_manifold: up to four contact points over all pairs of parts. Pure; any thread.
 *
 * The parts that may touch are clipped against each other along the one axis of the answer, so that no pair brings a
 * normal of its own; the best four of all points are kept (manifold.h). Parts that overlap from another side, as
 * the wall beside a floor, would show as points far deeper than the whole: those are left out. */
#include "compound_pair.h"
#include "feature_code.h"
#include "manifold.h"
#include "mesh_pair.h"
#include "order.h"
#include "scalar.h"

/* Points nearer to each other than this share of the pair's size are one: neighbours meet at a seam. */
static const double SAME_POINT = 1e-9;

/* The witness of two parts counts while their own axis is this near to that of the answer (cosine). */
static const double SAME_SIDE = 0.9;

/* Puts manifold_build's own witness so far off that it comes only where there is no other point. */
static const double NO_WITNESS = 0x1p500;

enum { INDEX_BITS = 30 }; /* of feature_code.h */

typedef struct point_search {
    const narrow_result *answer;
    narrow_scratch *scratch;
    double threshold;
    effort *effort;
    manifold_choice choice;
} point_search;

/* Two parts in canonical order, and their contact in the frame of the first. */
typedef struct part_pair {
    shape first, second;
    pose second_in_first, frame; /* frame: of the first in A */
    bool turned;                 /* the first is B's */
} part_pair;

static part_pair pair_of(const compound_walk *w, uint32_t part_a, uint32_t part_b)
{
    bool composed;
    pose local_a, local_b, relative = compound_parts_pose(w, part_a, part_b, &composed);
    part_pair out = {.first = compound_part(&w->a, part_a, &local_a),
        .second = compound_part(&w->b, part_b, &local_b),
        .second_in_first = relative,
        .frame = local_a};
    if (order_shapes(&out.first, &out.second) <= 0) return out;
    shape swap = out.first;
    out.first = out.second;
    out.second = swap;
    quat back = quat_conj(relative.q);
    out.second_in_first = (pose){vec_neg(quat_rotate(back, relative.p)), back};
    out.frame = pose_mul(local_a, relative);
    out.turned = true;
    return out;
}

static vec3 into(const transform *t, vec3 point)
{
    return mat_tmul(t->r, vec_sub(point, t->t));
}

static bool is_curved(const shape *s)
{
    return s->type != SHAPE_BOX && s->type != SHAPE_HULL && s->type != SHAPE_HALFSPACE;
}

/* Where clipping polygons does not find the deepest point: the parts' own witnesses, in A's frame. */
static bool own_witness(
    const compound_walk *w, const point_search *q, uint32_t part_a, uint32_t part_b, narrow_result *r)
{
    const narrow_request request = {
        .facts = NARROW_DISTANCE, .range = max_of(q->threshold, 0), .tolerance = 1e-9 * w->size * w->unit};
    compound_parts_query(w, part_a, part_b, &request, q->scratch, r);
    return vec_dot(r->axis, q->answer->axis) >= SAME_SIDE;
}

static void clip_parts(
    const part_pair *pair, const point_search *q, const narrow_result *witness, const transform *frame, manifold *out)
{
    transform t = pose_transform(pair->second_in_first);
    const narrow_result *from = witness ? witness : q->answer;
    narrow_result here = {.axis = direction_again(mat_tmul(frame->r, q->answer->axis))};
    here.point_a = into(frame, pair->turned ? from->point_b : from->point_a);
    here.point_b = into(frame, pair->turned ? from->point_a : from->point_b);
    if (pair->turned) here.axis = vec_neg(here.axis);
    if (!witness) here.point_b = vec_madd(here.point_a, NO_WITNESS, here.axis);
    if (pair->second.type == SHAPE_MESH) {
        unit_pair p;
        unit_pair_init(&p, &pair->first, &pair->second, &pair->second_in_first);
        mesh_pair_prepare(&p, &pair->first);
        p.effort = q->effort;
        mesh_pair_manifold(&p, &pair->first, &pair->second, &pair->second_in_first, &here, q->threshold, out);
    } else {
        manifold_build(&pair->first, &pair->second, &t, here.axis, here.point_a, here.point_b, q->threshold, out);
    }
}

/* The child in as many of the high bits of the index as number the children, and its own index, which is of a hull at
 * most and fits below. */
static uint32_t code_in_compound(const compound_side *s, uint32_t part, uint32_t code)
{
    uint32_t bits = 0, count = compound_part_count(s);
    while (count > 1u << bits) bits++;
    uint32_t own = feature_index(code) & ((1u << (INDEX_BITS - bits)) - 1);
    return feature_code(feature_kind(code), bits ? part << (INDEX_BITS - bits) | own : own);
}

static bool clip(compound_walk *w, uint32_t part_a, uint32_t part_b, void *context)
{
    point_search *q = context;
    part_pair pair = pair_of(w, part_a, part_b);
    effort_spend(w->effort, EFFORT_CLIP + compound_vertices(&pair.first, &pair.second) * EFFORT_PARTS_VERTICES);
    transform frame = pose_transform(pair.frame);
    manifold points;
    narrow_result own;
    bool curved = is_curved(&pair.first) || is_curved(&pair.second);
    bool witness = curved && own_witness(w, q, part_a, part_b, &own);
    double deepest = q->answer->lo - w->error * w->unit;
    clip_parts(&pair, q, witness ? &own : NULL, &frame, &points);
    for (uint32_t i = 0; i < points.count; i++) {
        manifold_point *p = &points.points[i];
        uint32_t first = feature_code_a(p->feature), second = feature_code_b(p->feature);
        if ((p->feature == feature_witness() && !witness) || p->distance > q->threshold || p->distance < deepest)
            continue;
        p->point = transform_point(&frame, p->point);
        p->feature = feature_id(code_in_compound(&w->a, part_a, pair.turned ? second : first),
            code_in_compound(&w->b, part_b, pair.turned ? first : second));
        manifold_choice_offer(&q->choice, p);
    }
    return true;
}

void compound_manifold(
    compound_walk *w, const narrow_result *answer, double threshold, narrow_scratch *scratch, manifold *out)
{
    point_search q = {.answer = answer, .scratch = scratch, .threshold = threshold, .effort = w->effort};
    double within = max_of(threshold * w->scale, 0) + 2 * w->error;
    manifold_choice_begin(&q.choice, answer->axis, SAME_POINT * w->size * w->unit);
    int64_t share = w->effort->left / MANIFOLD_POINTS_MAX, left = w->effort->left;
    bool cut = false;
    do { /* each walk sees as much as the others, where the effort does not suffice for all */
        w->effort->left = share;
        compound_walk_run(w, within, clip, &q);
        left -= share - w->effort->left;
        cut |= w->cut || w->effort->left < 0;
    } while (manifold_choice_next(&q.choice));
    w->effort->left = cut ? -1 : left;
    if (q.choice.chosen.count == 0) q.choice.chosen.points[q.choice.chosen.count++] = manifold_witness(answer);
    manifold_choice_write(&q.choice, out);
}
