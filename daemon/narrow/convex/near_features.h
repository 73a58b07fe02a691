/* near_features: the answer of the features that two hulls, or two boxes, are nearest at (features.h): from what the
 * pair remembers, at the end of a search, or in place of one. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_NEAR_FEATURES_H
#define COLLIDED_NARROW_CONVEX_NEAR_FEATURES_H

#include "features.h"

/* Two hulls, or where they overlap a box and a hull, from nothing, for goals of which one of the two above is true: the
 * answer, by the quickest means. False: these cannot decide it, and *out counts for nothing. */
bool near_features_at_once(const unit_pair *p, const narrow_goal *goal, span *out);

/* The answer from what the pair remembers: its features, those that a descent from them ends at (hulls here; boxes
 *, box_facing.h), or where it overlapped the surface in p->shell (polytope_depth.h). For
 * pairs and goals that apply. */
bool near_features_recall(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out);

/* The end of a search from nothing: *s is its bracket and may hold a proposal; it becomes the answer of the strict
 * features if there are any: then it holds them. */
void near_features_settle(const unit_pair *p, const narrow_goal *goal, span *s);

/* The strict features among all, for tests: what near_features_settle does with a search that ended wide. */
bool near_features_try_all(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
