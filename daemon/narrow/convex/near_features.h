/* near_features: answers by the features at which two hulls or two boxes are nearest (features.h): by those that the
 * pair remembers, by those at which a search ends, or by a quick search for them. Pure; any thread. */
#ifndef COLLIDED_NARROW_CONVEX_NEAR_FEATURES_H
#define COLLIDED_NARROW_CONVEX_NEAR_FEATURES_H

#include "features.h"

/* Answers for two hulls, or for a box and a hull that overlap, without a cache and without GJK and EPA, if
 * near_features_apply or near_features_reach_depths is true. If it returns false, a search has to decide, and *out is
 * not valid. */
bool near_features_at_once(const unit_pair *p, const narrow_goal *goal, span *out);

/* Answers by what the pair remembers, for pairs and goals to which features apply: by its features, by those at which a
 * descent from them ends (for boxes: box_facing.h), or, if it overlapped, by the surface in p->shell
 * (polytope_depth.h). */
bool near_features_recall(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out);

/* Ends a search. *s is its interval, and may propose features. If the pair has strict features, *s becomes their
 * answer, and holds them. */
void near_features_settle(const unit_pair *p, const narrow_goal *goal, span *s);

/* Tries all features until one pair is strict, as near_features_settle does after a search that ended wide. Declared
 * for tests. */
bool near_features_try_all(const unit_pair *p, const narrow_goal *goal, span *out);

#endif
