/* Names, checks and the reach of shapes. Pure; any thread. shape_check is the boundary: what it lets pass, all other
 * code of the engine takes without looking again. */
#include "shape.h"

#include "compound.h"
#include "hull.h"
#include "round.h"

const char *shape_type_name(shape_type type)
{
    static const char *const names[SHAPE_TYPE_COUNT] = {
        [SHAPE_SPHERE] = "sphere",
        [SHAPE_CAPSULE] = "capsule",
        [SHAPE_BOX] = "box",
        [SHAPE_CYLINDER] = "cylinder",
        [SHAPE_CONE] = "cone",
        [SHAPE_ELLIPSOID] = "ellipsoid",
        [SHAPE_HALFSPACE] = "halfspace",
        [SHAPE_HULL] = "hull",
        [SHAPE_MESH] = "mesh",
        [SHAPE_COMPOUND] = "compound",
        [SHAPE_SOFT] = "soft surface",
    };
    return (unsigned)type < SHAPE_TYPE_COUNT && names[type] ? names[type] : "unknown";
}

static const char *size_fault(double size, double limit)
{
    if (!isfinite(size)) return "size is not a finite number";
    if (size < 0) return "size is negative";
    if (size > limit) return "size is beyond the limit";
    return NULL;
}

const char *shape_check(const shape *s)
{
    bool known = (unsigned)s->type <= SHAPE_MESH || s->type == SHAPE_COMPOUND || s->type == SHAPE_SOFT;
    if (!known) return "type of shape is unknown";
    const char *fault = size_fault(s->radius, s->type == SHAPE_SPHERE ? SPHERE_RADIUS_MAX : SHAPE_SIZE_MAX);
    if (!fault) fault = size_fault(s->half.x, SHAPE_SIZE_MAX);
    if (!fault) fault = size_fault(s->half.y, SHAPE_SIZE_MAX);
    if (!fault) fault = size_fault(s->half.z, SHAPE_SIZE_MAX);
    if (fault) return fault;
    if (!(s->deviation >= 0) || s->deviation > SHAPE_SIZE_MAX) return "deviation is negative or beyond the limit";
    bool round = s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE;
    if (round && s->half.y != s->half.x) return "a cylinder's or cone's two radii differ";
    if (s->type == SHAPE_HULL && !s->hull) return "hull is missing";
    if (s->type == SHAPE_MESH && (!s->hull || !s->mesh)) return "mesh is missing";
    if (s->type == SHAPE_COMPOUND && !s->compound) return "children are missing";
    if (s->type == SHAPE_SOFT && !s->soft) return "soft surface is missing";
    return NULL;
}

static double core_reach(const shape *s)
{
    switch (s->type) {
    case SHAPE_CAPSULE:
        return s->half.z;
    case SHAPE_BOX:
        return length_up(s->half);
    case SHAPE_CYLINDER:
    case SHAPE_CONE:
        return length_up(vec(s->half.x, 0, s->half.z));
    case SHAPE_ELLIPSOID:
        return vec_max_abs(s->half);
    case SHAPE_HALFSPACE:
    case SHAPE_SOFT:
        return INFINITY;
    case SHAPE_HULL:
    case SHAPE_MESH:
        return s->hull->reach;
    case SHAPE_COMPOUND:
        return s->compound->reach;
    default:
        return 0;
    }
}

double shape_excess(const shape *s)
{
    if (s->type == SHAPE_COMPOUND) return s->compound->excess;
    return s->type == SHAPE_HULL || s->type == SHAPE_MESH ? s->hull->excess : 0;
}

double shape_reach(const shape *s)
{
    return add_up(core_reach(s), s->radius);
}
