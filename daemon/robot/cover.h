/* cover: balls that together contain a shape, at most a few, for quick proofs that it is free.
 *
 * A shape is cut into slabs across its longest axis; what lies in a slab is the convex hull of the shape's vertices
 * there and of the points where its edges meet the two planes, or for primitives a formula, and one ball contains it. A
 * mesh that is a solid needs no inner points: what is inside of it and in a slab is inside of the hull of its surface
 * there. Each ball is grown for rounding, so containment is certain. Pure, but for the array that grows; any thread. */
#ifndef COLLIDED_ROBOT_COVER_H
#define COLLIDED_ROBOT_COVER_H

#include "base/array.h"
#include "geom/shape.h"

enum {
    COVER_SLABS_MAX = 8,   /* balls of one convex shape or mesh */
    COVER_EDGES_MAX = 1024 /* of a hull, or triangles of a mesh: of what has more, the box around it is covered */
};

typedef struct cover_ball {
    vec3 centre;
    double radius;
} cover_ball;

typedef ARRAY(cover_ball) cover;

/* Appends balls that contain the shape at a pose; false if it has no end (half-spaces, also within compounds). */
bool cover_shape(const shape *s, pose at, cover *out);

/* One ball that contains all balls of a non-empty array. */
cover_ball cover_whole(const cover_ball *balls, size_t count);

#endif
