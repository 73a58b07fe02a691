/* core: support points of the cores of a unit_pair, inlined: the innermost loop of every search.
 *
 * The same points as geom/support.h, for directions whose squares are in range or zero. Pure; any thread. */
#ifndef COLLIDED_NARROW_CORE_H
#define COLLIDED_NARROW_CORE_H

#include "geom/compound.h"
#include "geom/hull_support.h"
#include "scalar.h"
#include "unit_pair.h"

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

enum { SCAN_MAX = 512, SCAN_LANES = 4 };

/* hull_support of all but the largest hulls (measured: up to this size quicker than its tree): the heights once, the
 * greatest by columns side by side, then the first that has it. */
static inline uint32_t core_scan(const hull *h, vec3 d)
{
    const double *restrict x = h->x, *restrict y = h->y, *restrict z = h->z;
    double height[SCAN_MAX], m0 = -INFINITY, m1 = -INFINITY, m2 = -INFINITY, m3 = -INFINITY;
    uint32_t count = h->padded_count;
    for (uint32_t i = 0; i < count; i++) height[i] = x[i] * d.x + y[i] * d.y + z[i] * d.z;
    /* padded_count is a multiple of 8, and not less than vertex_count: clang-tidy 14 cannot know.
     * NOLINTBEGIN(clang-analyzer-core.CallAndMessage, clang-analyzer-core.UndefinedBinaryOperatorResult) */
    for (uint32_t i = 0; i < count; i += SCAN_LANES) {
        m0 = max_of(height[i], m0), m1 = max_of(height[i + 1], m1);
        m2 = max_of(height[i + 2], m2), m3 = max_of(height[i + 3], m3);
    }
    double top = max_of(max_of(m0, m1), max_of(m2, m3));
    for (uint32_t i = 0; i < h->vertex_count; i++)
        if (height[i] >= top) return i;
    /* NOLINTEND(clang-analyzer-core.CallAndMessage, clang-analyzer-core.UndefinedBinaryOperatorResult) */
    return 0; /* only for a direction that is not a number */
}

static inline uint32_t core_vertex(const hull *h, vec3 d, uint32_t *hint)
{
    if (h->padded_count <= SCAN_MAX) return core_scan(h, d);
    uint32_t vertex = hull_support(h, d, hint ? *hint : HULL_NO_START);
    if (hint) *hint = vertex;
    return vertex;
}

/* `scale`: the unit_pair's, for the vertices of a hull. */
static inline vec3 core_support(const shape *s, double scale, vec3 d, uint32_t *hint)
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
        return vec_scale(hull_vertex(s->hull, core_vertex(s->hull, d, hint)), scale);
    case SHAPE_COMPOUND: /* by its convex hull, too */
        return vec_scale(compound_support(s->compound, d), scale);
    default:
        return VEC_ZERO;
    }
}

/* Of a core that was shaved (unit_pair.h) by so much. */
static inline vec3 core_shaved(const shape *s, double scale, double shaved, vec3 d, uint32_t *hint)
{
    vec3 point = core_support(s, scale, d, hint);
    return shaved > 0 ? vec_madd(point, -shaved, direction_again(d)) : point;
}

#endif
