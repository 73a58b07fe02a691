/* near_features: when features answer, and how a search from nothing finds them. Pure; any thread. */
#include "near_features.h"

#include "geom/hull_scan.h"
#include "gjk.h"
#include "narrow/math/scalar.h"
#include "polytope_depth.h"
#include "polytopes.h"

/* Features by number: vertices, edges and triangles of a hull, or the 27 of a box. */
enum { BOX_FEATURES = 27 };

static uint32_t count_of(const shape *s)
{
    return s->type == SHAPE_HULL ? hull_features_count(s->hull) : BOX_FEATURES;
}

static uint8_t numbered(const shape *s, uint32_t i, uint16_t vertex[3])
{
    if (s->type == SHAPE_HULL) return hull_feature(s->hull, i, vertex);
    for (int k = 0; k < 3; k++, i /= 3) vertex[k] = (uint16_t)(i % 3);
    return 3;
}

bool near_features_try_all(const unit_pair *p, const narrow_goal *goal, span *out)
{
    narrow_features f = {.count_a = 0};
    for (uint32_t i = 0; i < count_of(&p->a); i++) {
        for (uint32_t k = 0; k < count_of(&p->b); k++) {
            f = (narrow_features){.count_a = 0};
            f.count_a = numbered(&p->a, i, f.a);
            f.count_b = numbered(&p->b, k, f.b);
            if (near_features_span(p, goal, &f, out)) return true;
        }
    }
    return false;
}

static bool names_features(const span *s)
{
    return s->hi - s->lo <= NEAR_NAMING_WIDTH * s->hi;
}

/* What is on top along the bracket's axis: the features, if the bracket names them; else a guess. */
static bool find_along(const unit_pair *p, const narrow_goal *goal, const span *s, span *out)
{
    narrow_features f = {.count_a = 0};
    if (features_are_of_boxes(p))
        box_features_along(p, s->axis, &f);
    else if (!hull_features_along(p, s->axis, &f))
        return false;
    return near_features_span(p, goal, &f, out);
}

static bool near_features_find(
    const unit_pair *p, const narrow_goal *goal, const narrow_features *proposed, span *s, span *out)
{
    if (proposed->count_a ? near_features_span(p, goal, proposed, out) : find_along(p, goal, s, out)) return true;
    if (!names_features(s)) gjk_narrow_down(gjk_distance, p, goal, s);
    s->nearest = (narrow_features){.count_a = 0};
    return names_features(s) ? find_along(p, goal, s, out) : near_features_try_all(p, goal, out);
}

static void settle_distance(const unit_pair *p, const narrow_goal *goal, const narrow_features *proposed, span *s)
{
    span out;
    if (!(s->hi >= 0.5 * NEAR_LEAST_DISTANCE * p->size) || s->lo > goal->far) return;
    if (near_features_find(p, goal, proposed, s, &out)) *s = out;
}

/* The depth has been found by a search that ended with its bounds closed: what is on top along the axis is the facet.
 */
static void settle_depth(const unit_pair *p, const narrow_goal *goal, const narrow_features *proposed, span *s)
{
    span out;
    narrow_features f = *proposed;
    if (!(s->hi - s->lo <= p->error)) return;
    if (!f.count_a && !hull_features_along(p, s->axis, &f)) return;
    f.deep = true;
    if (!near_features_span(p, goal, &f, &out) || !(s->hi <= out.hi)) return;
    out.iterations = 1;
    *s = out;
}

void near_features_settle(const unit_pair *p, const narrow_goal *goal, span *s)
{
    narrow_features proposed = s->nearest;
    s->nearest = (narrow_features){.count_a = 0};
    if (s->hi >= 0)
        settle_distance(p, goal, &proposed, s);
    else if (near_features_reach_depths(p, goal))
        settle_depth(p, goal, &proposed, s);
}

/* Along the line of their origins most that are apart are. */
enum { FIRST_LOOK = 1 };

/* The facet, if the search has ended on one that is strict; else its bounds. */
static bool near_features_finish_depth(const unit_pair *p, const narrow_goal *goal, span *out)
{
    near_features_settle(p, goal, out);
    if (out->lo < 0 && !out->nearest.deep) witness_deepest(p, out);
    return true;
}

/* From four corners of B - A with the origin between them; or, if features of a gap are to be proposed, by these. */
static bool settle_at_once(const unit_pair *p, const narrow_goal *goal, bool proposes, span *out)
{
    narrow_features f = {.count_a = 0};
    narrow_goal closely = *goal;
    hull_corners holds;
    closely.tolerance = goal->finest;
    hull_seek_end end = hull_seek(p, HULL_SEEK_ON, proposes, &f, &holds);
    if (end == HULL_SEEK_PROPOSES) return near_features_span(p, goal, &f, out);
    if (end != HULL_SEEK_INSIDE) return false;
    return polytope_depth_from(p, &closely, &holds, out) && near_features_finish_depth(p, goal, out);
}

/* And still are, surely. */
static bool were_apart(const unit_pair *p)
{
    vec3 axis = p->apart_along;
    return vec_norm2(axis) > 0 && vec_dot(axis, unit_pair_nearest_along(p, axis).w) > 2 * p->error;
}

bool near_features_at_once(const unit_pair *p, const narrow_goal *goal, span *out)
{
    narrow_features f = {.count_a = 0};
    hull_corners unused;
    if ((p->a.type != SHAPE_HULL && p->a.type != SHAPE_BOX) || p->b.type != SHAPE_HULL) return false;
    bool gaps = near_features_apply(p, goal), depths = near_features_reach_depths(p, goal);
    if (!gaps && !depths) return false;
    if (were_apart(p)) return false;
    bool proposes = gaps && !p->remembers;
    hull_seek_end end = gaps ? hull_seek(p, FIRST_LOOK, proposes, &f, &unused) : HULL_SEEK_UNKNOWN;
    if (end != HULL_SEEK_UNKNOWN) return end == HULL_SEEK_PROPOSES && near_features_span(p, goal, &f, out);
    if (!depths) return false;
    /* both give the same bits; if p->shell has memory for a surface, the search leaves one, and the next frame is
     * quicker */
    bool axes = !p->shell && hull_axes_apply(p) && (gaps || !hull_axes_parted(p));
    return (axes && hull_axes_depth(p, goal, out)) || settle_at_once(p, goal, proposes, out);
}

static bool seek(const unit_pair *p, const narrow_goal *goal, const narrow_features *from, span *out)
{
    narrow_features f = {.count_a = 0};
    return !features_are_of_boxes(p) && hull_features_descend(p, from, &f) && near_features_span(p, goal, &f, out);
}

bool near_features_recall(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out)
{
    if (nearest->deep) return polytope_depth_again(p, goal, nearest, out);
    return near_features_span(p, goal, nearest, out) || seek(p, goal, nearest, out);
}
