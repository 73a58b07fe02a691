/* closed: distances that have a formula. Each fills the span of two cores; false when the two bounds were left
 * farther apart than the goal allows (by rounding, or at corners of boxes), and the general method takes over from
 * out->axis. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_CLOSED_H
#define COLLIDED_NARROW_CLOSED_H

#include "unit_pair.h"

typedef bool closed_form(const unit_pair *p, const narrow_goal *goal, span *out);

closed_form closed_sphere_sphere;
closed_form closed_sphere_capsule;
closed_form closed_capsule_capsule;
closed_form closed_sphere_box;
closed_form closed_sphere_revolved; /* cylinder or cone */
closed_form closed_any_halfspace;   /* B is the half-space */
closed_form closed_halfspace_any;   /* A is the half-space */
closed_form closed_halfspace_halfspace;

#endif
