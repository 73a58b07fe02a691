/* bounds: axis-aligned boxes in doubles, rounded outward. Infinite extents are allowed (half-spaces). */
#ifndef COLLIDED_GEOM_BOUNDS_H
#define COLLIDED_GEOM_BOUNDS_H

#include "shape.h"

typedef struct aabb {
    vec3 lo, hi;
} aabb;

/* The box of a shape at a pose, never smaller than the true one. An axis-aligned half-space is bounded on its one
 * side; any other is infinite on all. */
aabb shape_bounds(const shape *s, pose at);

static inline aabb aabb_grow(aabb b, double by)
{
    return (aabb){{b.lo.x - by, b.lo.y - by, b.lo.z - by}, {b.hi.x + by, b.hi.y + by, b.hi.z + by}};
}
static inline aabb aabb_union(aabb a, aabb b)
{
    return (aabb){vec_min(a.lo, b.lo), vec_max(a.hi, b.hi)};
}
static inline bool aabb_overlap(aabb a, aabb b)
{
    return a.lo.x <= b.hi.x && b.lo.x <= a.hi.x && a.lo.y <= b.hi.y && b.lo.y <= a.hi.y && a.lo.z <= b.hi.z &&
           b.lo.z <= a.hi.z;
}
static inline bool aabb_contains(aabb outer, aabb inner)
{
    return outer.lo.x <= inner.lo.x && inner.hi.x <= outer.hi.x && outer.lo.y <= inner.lo.y &&
           inner.hi.y <= outer.hi.y && outer.lo.z <= inner.lo.z && inner.hi.z <= outer.hi.z;
}

#endif
