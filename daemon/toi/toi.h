/* toi: the time of impact of two moving and turning shapes, bracketed: they are proven to be apart before `lo`, and to
 * touch at `hi`. Pure, as narrow.h; any thread, each with its own scratch.
 *
 * The chord certificate: over a time h a point of a body that turns at w about an axis rho away leaves its chord by at
 * most w^2 rho h^2 / 8. So a direction along which two convex shapes are apart by more than the sum of that, both at
 * the beginning and at the end, proves that they do not meet between. The search proposes directions and steps (by
 * certified distances and Newton's method); what it proposes only decides how many steps it takes. It misses no contact
 * and reports none late, for whatever the steps are. (Conservative advancement: Mirtich, 1996; Zhang, Lee and Kim,
 * 2006; the chord in place of the speed bound is METHODS.md's.)
 *
 * Two balls, and a ball and a box that do not turn, have closed forms, proven at both ends (primitives.c).
 * Balls, capsules and boxes march by separating axes in place of distances (course.h).
 *
 * Meshes and compounds are walked: boxes of their hierarchy, then parts, each a convex shape that moves with the body;
 * what that may take is bounded, by a count and not by a clock (TOI_WORK_MAX). */
#ifndef COLLIDED_TOI_TOI_H
#define COLLIDED_TOI_TOI_H

#include "narrow/narrow.h"
#include "request.h"

/* Finds the time of impact. A and B must be in canonical order (narrow_ordered). `guess` is a world direction that may
 * prove the motion free, such as a cached axis, or zero. It changes the time of the search and never the answer: it
 * counts only if the gap along it stays above twice the tolerance, so that a search without it reports no hit and no
 * near miss, and above a 400th of the length of the relative motion, so that such a search is certain to end decided.
 * Balls, capsules, boxes, meshes and compounds need no guess. */
void toi_find(const toi_mover *a, const toi_mover *b, const toi_request *request, vec3 guess, narrow_scratch *scratch,
    toi_result *out);

const char *toi_status_name(toi_status status);

#endif
