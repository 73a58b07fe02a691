/* dispatch: which method answers for which two types. Pure; any thread. */
#ifndef COLLIDED_NARROW_DISPATCH_H
#define COLLIDED_NARROW_DISPATCH_H

#include "narrow/closed/closed.h"
#include "narrow/convex/epa.h"

/* The formula for two types in canonical order, or NULL if the general method answers. */
closed_form *dispatch_closed_form(shape_type a, shape_type b);

/* Does the request need a verdict alone, for two types whose verdict the general method decides sooner than the
 * formula? */
bool dispatch_gjk_decides(const unit_pair *p, const narrow_goal *goal);

/* The general method. Distances are found by GJK, which Newton's method continues for pairs with rims. Depths of boxes,
 * points and segments are found by their separating axes, those of other polytopes by polytope_depth.h. In all other
 * cases, and if that gives up, the expanding polytope of epa.h answers; if it ends wide, the separating axes of hulls
 * do. With `only_general` GJK and epa.h alone are used. For `seed` see gjk_distance. */
void dispatch_general(
    const unit_pair *p, const narrow_goal *goal, bool only_general, vec3 seed, epa_scratch *scratch, span *out);

#endif
