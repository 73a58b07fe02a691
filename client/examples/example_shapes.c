/* example_shapes: what the bodies of the cell are made of, the arm's apart (arm.urdf), and how near they may come. In
 * metres; plain functions. */
#include "example.h"

#include <math.h>

#include <string.h>

const double EXAMPLE_PROTECTIVE_M = 0.35, EXAMPLE_RESUME_M = 0.4;
const double EXAMPLE_PERIOD_S = 0.01, EXAMPLE_BRAKING_S = 0.1;

double example_separation_left(const collided_event *e)
{
    double oldest_s = fmax(0, fmax(e->age_a_s, e->age_b_s));
    return e->lo - fmax(0, e->closing_m_s) * (oldest_s + EXAMPLE_PERIOD_S + EXAMPLE_BRAKING_S);
}
const double EXAMPLE_WORKPIECE_M = 0.05;

const double EXAMPLE_WEDGE[3 * EXAMPLE_WEDGE_POINTS] = {-0.05, -0.04, -0.02, 0.05, -0.04, -0.02, -0.05, 0.04, -0.02,
    0.05, 0.04, -0.02, -0.05, -0.04, 0.02, -0.05, 0.04, 0.02};

static collided_shape placed(collided_shape shape, double x, double y, double z)
{
    shape.pose = (collided_pose){{x, y, z}, {1, 0, 0, 0}};
    return shape;
}

/* Its frame is in the middle of its top. */
static size_t table(collided_shape *shapes)
{
    const double length = 1.2, width = 0.85, thickness = 0.05, leg = 0.7, leg_z = -thickness - leg / 2;
    size_t count = 0;
    shapes[count++] = placed(collided_box(length, width, thickness), 0, 0, -thickness / 2);
    for (int i = 0; i < 4; i++) {
        double x = length / 2 - 0.05, y = width / 2 - 0.05;
        shapes[count++] = placed(collided_cylinder(0.03, leg), i & 2 ? x : -x, i & 1 ? y : -y, leg_z);
    }
    return count;
}

static size_t vehicle(collided_shape *shapes)
{
    const double length = 0.9;
    shapes[0] = placed(collided_box(length, 0.5, 0.25), 0, 0, 0.175);    /* the chassis */
    shapes[1] = placed(collided_box(length - 0.1, 0.4, 0.7), 0, 0, 0.7); /* the shelf that it carries */
    shapes[2] = placed(collided_capsule(0.03, 0.2), 0, 0, 1.15);         /* the mast of its scanner */
    return 3;
}

size_t example_shapes(const char *body, collided_shape shapes[EXAMPLE_SHAPES])
{
    const struct {
        const char *name;
        collided_shape shape;
    } parts[] = {
        {"workpiece", collided_box(0.06, 0.06, EXAMPLE_WORKPIECE_M)},
        {"bolt", collided_cylinder(0.03, 0.08)},
        {"crate", collided_box(0.2, 0.15, 0.1)},
        {"wedge", collided_hull((collided_geometry){0})},
        {"parcel_west", collided_box(0.2, 0.3, 0.2)},
        {"parcel_east", collided_box(0.2, 0.3, 0.2)},
    };
    if (strcmp(body, "table") == 0) return table(shapes);
    if (strcmp(body, "vehicle") == 0) return vehicle(shapes);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (strcmp(body, parts[i].name) == 0) return shapes[0] = parts[i].shape, 1;
    return 0;
}
