/* features: which pairs and goals they answer for, and their answer. Pure; any thread. */
#include "features.h"

#include "geom/hull_scan.h"
#include "polytopes.h"

/* Of hulls a search stops so little sooner that features, which the next frame begins with, are worth more. */
#define CLOSE_TOLERANCE_OF_HULLS 0x1p-9

static bool is_scanned(const shape *s)
{
    return s->type == SHAPE_HULL && s->hull->face_count > 0 && s->hull->padded_count <= HULL_SCAN_MAX;
}

bool near_features_scans(const shape *a, const shape *b)
{
    return is_scanned(a) && is_scanned(b);
}

static bool near_features_name_depths(const shape *a, const shape *b)
{
    if (a->type == SHAPE_BOX) return is_scanned(b);
    return near_features_scans(a, b) && sat_affords(a->hull, b->hull);
}

bool near_features_apply(const unit_pair *p, const narrow_goal *goal)
{
    if (goal->near != -INFINITY) return false;
    if (features_are_of_boxes(p)) return near_features_apply_to_boxes(goal, p->size);
    return goal->tolerance <= CLOSE_TOLERANCE_OF_HULLS * p->size && near_features_scans(&p->a, &p->b);
}

bool near_features_reach_depths(const unit_pair *p, const narrow_goal *goal)
{
    bool close = goal->near == -INFINITY && goal->tolerance <= ROUGH_TOLERANCE * p->size &&
                 goal->tolerance >= 4 * NEAR_DEPTH_WIDTHS * p->error;
    return close && near_features_name_depths(&p->a, &p->b);
}

/* May GJK end, its bounds closed to the tolerance, before it knows that the two overlap? */
static bool is_shallow(const unit_pair *p, const narrow_goal *goal, const span *of)
{
    double depth = -0.5 * (of->lo + of->hi);
    return !(depth > goal->tolerance + 2 * p->error);
}

bool near_features_span(const unit_pair *p, const narrow_goal *goal, const narrow_features *f, span *out)
{
    if (!(features_are_of_boxes(p) ? box_features_span : hull_features_span)(p, f, out)) return false;
    if (f->deep && is_shallow(p, goal, out)) return false;
    out->nearest = *f;
    out->iterations = 1;
    return out->hi + 2 * p->error <= goal->far; /* or else a search may have ended beyond it */
}
