/* dispatch: which method answers for which two types. Pure; any thread. */
#ifndef COLLIDED_NARROW_DISPATCH_H
#define COLLIDED_NARROW_DISPATCH_H

#include "narrow/closed/closed.h"
#include "narrow/convex/epa.h"

/* The formula for two types (in canonical order), or NULL: the general method. */
closed_form *dispatch_closed_form(shape_type a, shape_type b);

/* Is a verdict alone asked for, and of a pair that the general method decides sooner than the formula? */
bool dispatch_gjk_decides(const unit_pair *p, const narrow_goal *goal);

/* The general method: GJK, of pairs with rims Newton's method from where it has got to; for the depth of boxes (and
 * points and segments) their separating axes, of other polytopes polytope_depth.h, of all else and where that gives up
 * the expanding polytope of epa.h, and where that ends wide the separating axes of hulls. With `only_general` GJK and
 * epa.h alone. `seed`: see gjk_distance. */
void dispatch_general(
    const unit_pair *p, const narrow_goal *goal, bool only_general, vec3 seed, epa_scratch *scratch, span *out);

#endif
