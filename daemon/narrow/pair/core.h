/* core: support points of the cores of a unit_pair, inlined: the innermost loop of every search.
 *
 * The same points as geom/support.h, for directions whose squares are in range or zero. Pure; any thread. */
#ifndef COLLIDED_NARROW_PAIR_CORE_H
#define COLLIDED_NARROW_PAIR_CORE_H

#include "geom/compound.h"
#include "geom/hull_scan.h"
#include "geom/hull_support.h"
#include "narrow/math/scalar.h"

static inline vec3 core_disc(double r, double z, vec3 d)
{
    double norm2 = d.x * d.x + d.y * d.y, scale = norm2 > 0 ? r / sqrt(norm2) : 0;
    return vec(scale * d.x, scale * d.y, z);
}

/* The apex wins where the direction is steeper than the normal of the side, (2 h, r). */
static inline vec3 core_cone(vec3 half, vec3 d)
{
    bool apex = 2 * half.z * d.z >= half.x * sqrt(d.x * d.x + d.y * d.y);
    return apex ? vec(0, 0, half.z) : core_disc(half.x, -half.z, d);
}

static inline vec3 core_ellipsoid(vec3 half, vec3 d)
{
    vec3 w = direction_of(vec(half.x * d.x, half.y * d.y, half.z * d.z));
    return vec(half.x * w.x, half.y * w.y, half.z * w.z);
}

/* By a scan of all but the largest hulls: up to HULL_SCAN_MAX it is quicker than their tree. */
static inline uint32_t core_vertex(const hull *h, vec3 d, uint32_t *hint)
{
    bool few = h->padded_count <= HULL_SCAN_MAX;
    uint32_t vertex = few ? hull_scan(h, d) : hull_support(h, d, hint ? *hint : HULL_NO_START);
    if (hint) *hint = vertex;
    return vertex;
}

static inline vec3 core_hull(const hull *h, double scale, vec3 d, uint32_t *hint)
{
    return vec_scale(hull_vertex(h, core_vertex(h, d, hint)), scale);
}

/* `scale`: the unit_pair's, for the vertices of a hull. */
__attribute__((always_inline)) static inline vec3 core_support(const shape *s, double scale, vec3 d, uint32_t *hint)
{
    vec3 corner = {copysign(s->half.x, d.x), copysign(s->half.y, d.y), copysign(s->half.z, d.z)};
    switch (s->type) {
    case SHAPE_BOX:
        return corner;
    case SHAPE_CAPSULE:
        return vec(0, 0, corner.z);
    case SHAPE_CYLINDER:
        return core_disc(s->half.x, corner.z, d);
    case SHAPE_CONE:
        return core_cone(s->half, d);
    case SHAPE_ELLIPSOID:
        return core_ellipsoid(s->half, d);
    case SHAPE_MESH: /* by its convex hull */
    case SHAPE_HULL:
        return core_hull(s->hull, scale, d, hint);
    case SHAPE_COMPOUND: /* by its convex hull, too */
        return vec_scale(compound_support(s->compound, d), scale);
    default:
        return VEC_ZERO;
    }
}

/* Of a core that was shaved (unit_pair.h) by so much. */
__attribute__((always_inline)) static inline vec3 core_shaved(
    const shape *s, double scale, double shaved, vec3 d, uint32_t *hint)
{
    vec3 point = core_support(s, scale, d, hint);
    return shaved > 0 ? vec_madd(point, -shaved, direction_again(d)) : point;
}

#endif
