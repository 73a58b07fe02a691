/* defaults: definitions as they are meant to be used, the makers of shapes, and names for people. Pure; any thread. */
#include "collided.h"

const char *collided_version(void)
{
    return COLLIDED_VERSION_TEXT;
}

const char *collided_status_text(collided_status status)
{
    static const char *const texts[] = {[COLLIDED_OK] = "ok",
        [COLLIDED_BAD_ARGUMENT] = "bad argument",
        [COLLIDED_UNKNOWN_ID] = "unknown id",
        [COLLIDED_REJECTED] = "rejected by the daemon",
        [COLLIDED_TIMEOUT] = "timeout",
        [COLLIDED_NO_DAEMON] = "no daemon is heard",
        [COLLIDED_TRANSPORT] = "the transport failed",
        [COLLIDED_UNSUPPORTED] = "unsupported"};
    return (size_t)status < sizeof texts / sizeof texts[0] ? texts[status] : "unknown status";
}

collided_def collided_def_default(void)
{
    return (collided_def){.lease_s = 2.0, .on_loss = COLLIDED_REMOVE, .connect_timeout_s = 5.0};
}

collided_pose collided_pose_identity(void)
{
    return (collided_pose){.position = {0.0, 0.0, 0.0}, .orientation = {1.0, 0.0, 0.0, 0.0}};
}

collided_body_def collided_body_def_default(void)
{
    return (collided_body_def){.id = COLLIDED_NONE,
        .name = "",
        .group = "",
        .motion = COLLIDED_MOVING,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = collided_pose_identity()};
}

collided_subscription_def collided_subscription_def_default(void)
{
    return (collided_subscription_def){
        .facts = COLLIDED_TOUCH, .select_a = "*", .select_b = "*", .relative_tolerance = 1e-6};
}

static collided_shape shape(collided_shape_type type, double x, double y, double z, double radius)
{
    return (collided_shape){.type = type, .half = {x, y, z}, .radius = radius, .pose = collided_pose_identity()};
}

collided_shape collided_sphere(double radius)
{
    return shape(COLLIDED_SPHERE, 0, 0, 0, radius);
}
collided_shape collided_capsule(double radius, double length)
{
    return shape(COLLIDED_CAPSULE, 0, 0, length / 2, radius);
}
collided_shape collided_box(double x, double y, double z)
{
    return shape(COLLIDED_BOX, x / 2, y / 2, z / 2, 0);
}
collided_shape collided_cylinder(double radius, double height)
{
    return shape(COLLIDED_CYLINDER, radius, radius, height / 2, 0);
}
collided_shape collided_cone(double radius, double height)
{
    return shape(COLLIDED_CONE, radius, radius, height / 2, 0);
}
collided_shape collided_ellipsoid(double x, double y, double z)
{
    return shape(COLLIDED_ELLIPSOID, x, y, z, 0);
}
collided_shape collided_halfspace(void)
{
    return shape(COLLIDED_HALFSPACE, 0, 0, 0, 0);
}

collided_shape collided_hull(collided_geometry points)
{
    collided_shape hull = shape(COLLIDED_HULL, 0, 0, 0, 0);
    hull.geometry = points;
    return hull;
}

collided_shape collided_compound(const collided_shape *children, size_t count)
{
    collided_shape whole = shape(COLLIDED_COMPOUND, 0, 0, 0, 0);
    whole.children = children;
    whole.child_count = count;
    return whole;
}

collided_shape collided_mesh(collided_geometry triangles)
{
    collided_shape mesh = shape(COLLIDED_MESH, 0, 0, 0, 0);
    mesh.geometry = triangles;
    return mesh;
}

collided_shape collided_height_field(collided_geometry heights)
{
    collided_shape field = shape(COLLIDED_HEIGHT_FIELD, 0, 0, 0, 0);
    field.geometry = heights;
    return field;
}
