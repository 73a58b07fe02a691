/* shape: what a body is made of. A core (point, segment, box, ...) rounded by a radius: the set of all points within
 * `radius` of the core. All lengths in metres (or any one unit), in the shape's own frame, axis of revolution = z.
 *
 * A shape is plain data. It borrows its hull, mesh or compound, which is immutable and outlives it. */
#ifndef COLLIDED_GEOM_SHAPE_H
#define COLLIDED_GEOM_SHAPE_H

#include "vec.h"

#include <stddef.h>
#include <stdint.h>

typedef enum shape_type { /* the order is part of the canonical order of a pair: append only */
    SHAPE_SPHERE,         /* core: the origin; radius = the sphere's */
    SHAPE_CAPSULE,        /* core: segment from (0,0,-half.z) to (0,0,+half.z); radius = the capsule's */
    SHAPE_BOX,            /* core: |x| <= half.x, |y| <= half.y, |z| <= half.z */
    SHAPE_CYLINDER,       /* core: x^2+y^2 <= half.x^2, |z| <= half.z (half.y = half.x) */
    SHAPE_CONE,           /* core: apex (0,0,+half.z), base disc of radius half.x at z = -half.z (half.y = half.x) */
    SHAPE_ELLIPSOID,      /* core: semi-axes half.x, half.y, half.z */
    SHAPE_HALFSPACE,      /* core: z <= 0, outward normal +z */
    SHAPE_HULL,           /* core: convex hull of hull->x[], y[], z[] */
    SHAPE_CONVEX_COUNT,   /* the types up to here are convex */
    SHAPE_MESH = SHAPE_CONVEX_COUNT, /* core: the triangles of mesh, and its inside if it is a solid */
    SHAPE_COMPOUND = 10, /* core: the union of the children of compound. 9, the wire's height field, is a mesh here */
    SHAPE_SOFT,          /* a soft surface: the world's own (soft.h). Nothing asks the narrow phase about it */
    SHAPE_TYPE_COUNT
} shape_type;

typedef struct hull hull;           /* hull.h */
typedef struct mesh mesh;           /* mesh.h */
typedef struct compound compound;   /* compound.h */
typedef struct soft_mesh soft_mesh; /* soft/soft.h */

typedef struct shape {
    shape_type type;
    double radius;    /* rounding; >= 0 */
    double deviation; /* >= 0: what it stands for is in it, and no point of it is farther than this from that */
    vec3 half;
    const hull *hull;         /* of SHAPE_HULL, and of SHAPE_MESH: mesh->hull */
    const mesh *mesh;         /* SHAPE_MESH only */
    const compound *compound; /* SHAPE_COMPOUND only */
    const soft_mesh *soft;    /* SHAPE_SOFT only, with ... */
    const vec3 *span; /* ... the lowest and the highest corner of a box about all of it, in the world; NULL: it is
                         at the origin */
} shape;

const char *shape_type_name(shape_type type); /* "sphere", ... */

/* What is wrong with it (a static text: "size is negative", ...), or NULL. Zero sizes are allowed (a box may be flat,
 * a sphere a point); NaN, infinities, negatives and sizes beyond SHAPE_SIZE_MAX (of a
 * sphere: a radius beyond SPHERE_RADIUS_MAX) are not. */
const char *shape_check(const shape *s);
#define SHAPE_SIZE_MAX 1e150    /* squares of sizes must stay finite */
#define SPHERE_RADIUS_MAX 1e160 /* the radius of a sphere is never squared */

/* By how much points that a hull (of a mesh or a child, too) was made of may be outside of it; 0 for all else. */
double shape_excess(const shape *s);

/* Distance from the frame's origin to the farthest point, rounded up; INFINITY for half-spaces. */
double shape_reach(const shape *s);

#endif
