/* spheres: two spheres, of which nothing but the line of their centres is looked at. Pure; any thread. */
#ifndef COLLIDED_NARROW_SPHERES_H
#define COLLIDED_NARROW_SPHERES_H

#include "narrow.h"

/* The answer of narrow_query, to the bit, when both are spheres and doubles suffice for what is asked; false otherwise.
 */
bool spheres_answer(
    const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request, narrow_result *out);

#endif
