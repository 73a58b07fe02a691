/* mesh_held: which component of one mesh is inside of another, a solid. Pure; any thread. */
#ifndef COLLIDED_NARROW_MESH_HELD_H
#define COLLIDED_NARROW_MESH_HELD_H

#include "mesh_walk.h"

#define MESH_NOT_HELD UINT32_MAX
#define MESH_HELD_UNKNOWN (UINT32_MAX - 1) /* the effort of the query ended */

/* No surface is within rounding of the other. The first component of B (`of_a`: of A) in the order of its mesh that is
 * inside of the other, whatever the walk is aimed at and within; it is moved to where it is, and forgets its axis.
 * Or one of the two above. */
uint32_t mesh_held_component(mesh_walk *w, bool of_a);

/* A point of a component, in A's frame and units of the pair. */
vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component);

/* How far a component reaches along a direction of A's frame, from its one end to the other: no less than it does. */
double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction);

#endif
