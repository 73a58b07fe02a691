/* vehicle_simulator: a table with parts, and a vehicle that crosses the cell from end to end. At each end it pushes a
 * parcel along; rollers bring the parcel back. Shows how a simulator publishes: all poses of a step in one batch with
 * one stamp and velocities, and a deadline, so that nobody trusts poses that are old. One thread, 100 Hz.
 *
 * Frame: the origin is on the floor below the foot of the arm (arm_controller.c), z up, the lane along x. */
#include "example.h"

#include <math.h>
#include <stdio.h>
#include <sysexits.h>

static const double PERIOD_S = 0.01;
static const double DEADLINE_S = 0.2; /* twenty poses missing: where the vehicle is, is then unknown */

/* m, m/s, m/s^2. The lane passes the table at 0.1 m, and what the arm can reach in its work at 0.2 m. */
static const double TABLE_TOP = 0.75;
static const double LANE_Y = 0.6, LANE_END = 1.3;
static const double SPEED = 1.0, ACCELERATION = 2.0;
static const double VEHICLE_LENGTH = 0.9, PARCEL_LENGTH = 0.2;
static const double PARCEL_HOME = 1.4, ROLLER_SPEED = 0.4;
static const double PUSHING_GAP = 0.0005; /* what is pushed is this far ahead: within the contact threshold */

typedef struct simulation {
    double vehicle_x, vehicle_speed, direction;
    double parcel_x[2], parcel_speed[2]; /* west, east */
} simulation;

enum { VEHICLE, PARCEL_WEST, PARCEL_EAST, MOVING_BODIES };

/* ---- the bodies ---- */

static collided_pose at(double x, double y, double z)
{
    return (collided_pose){{x, y, z}, {1, 0, 0, 0}};
}

static void create_table(collided *c)
{
    collided_shape shapes[EXAMPLE_SHAPES];
    const size_t count = example_shapes("table", shapes);
    const collided_rule bolted = {.pattern = "base_link", .allow = true, .reason = "the arm is bolted to the table"};
    collided_body_def def = collided_body_def_default();
    def.name = "table";
    def.motion = COLLIDED_FIXED;
    def.pose = at(0.3, -0.175, TABLE_TOP);
    def.shapes = shapes;
    def.shape_count = count;
    def.rules = &bolted;
    def.rule_count = 1;
    collided_create_body(c, &def);
}

static void create_part(collided *c, const char *name, collided_geometry hull, double x, double y, double height)
{
    collided_shape shape[EXAMPLE_SHAPES];
    const size_t count = example_shapes(name, shape);
    shape[0].geometry = hull;
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.group = "part";
    def.motion = COLLIDED_FIXED;
    def.pose = at(x, y, TABLE_TOP + height / 2);
    def.shapes = shape;
    def.shape_count = count;
    collided_create_body(c, &def);
}

/* A bolt, a crate and a wedge: the last is a convex hull of six points. */
static void create_parts(collided *c)
{
    const collided_geometry none = {0}, wedge = collided_create_hull(c, EXAMPLE_WEDGE, EXAMPLE_WEDGE_POINTS);
    create_part(c, "bolt", none, 0.60, -0.45, 0.08);
    create_part(c, "crate", none, 0.70, -0.20, 0.1);
    create_part(c, "wedge", wedge, 0.05, -0.45, 0.04);
}

static collided_body create_moving(collided *c, const char *name, const char *group, collided_pose pose)
{
    collided_shape shapes[EXAMPLE_SHAPES];
    const size_t count = example_shapes(name, shapes);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.group = group;
    def.deadline_s = DEADLINE_S;
    def.pose = pose;
    def.shapes = shapes;
    def.shape_count = count;
    return collided_create_body(c, &def);
}

static void create_all(collided *c, const simulation *s, collided_body moving[MOVING_BODIES])
{
    create_table(c);
    create_parts(c);
    moving[VEHICLE] = create_moving(c, "vehicle", "vehicle", at(s->vehicle_x, LANE_Y, 0));
    moving[PARCEL_WEST] = create_moving(c, "parcel_west", "part", at(s->parcel_x[0], LANE_Y, 0.15));
    moving[PARCEL_EAST] = create_moving(c, "parcel_east", "part", at(s->parcel_x[1], LANE_Y, 0.15));
}

/* ---- the motion ---- */

static double toward(double from, double to, double most)
{
    return from + fmin(fmax(to - from, -most), most);
}

/* `side`: -1 west, +1 east. The rollers bring the parcel home, unless the vehicle is in the way: then that pushes it.
 */
static void step_parcel(simulation *s, int side, double dt)
{
    int i = side > 0;
    double before = s->parcel_x[i];
    double rolled = toward(before, side * PARCEL_HOME, ROLLER_SPEED * dt);
    double pushed = s->vehicle_x + side * (VEHICLE_LENGTH / 2 + PUSHING_GAP + PARCEL_LENGTH / 2);
    s->parcel_x[i] = side > 0 ? fmax(rolled, pushed) : fmin(rolled, pushed);
    s->parcel_speed[i] = (s->parcel_x[i] - before) / dt;
}

static void step(simulation *s, double dt)
{
    if (s->vehicle_x > LANE_END) s->direction = -1;
    if (s->vehicle_x < -LANE_END) s->direction = 1;
    s->vehicle_speed = toward(s->vehicle_speed, s->direction * SPEED, ACCELERATION * dt);
    s->vehicle_x += s->vehicle_speed * dt;
    step_parcel(s, -1, dt);
    step_parcel(s, +1, dt);
}

static collided_status publish(
    collided *c, const simulation *s, const collided_body moving[MOVING_BODIES], int64_t count)
{
    const double positions[3 * MOVING_BODIES] = {
        s->vehicle_x, LANE_Y, 0, s->parcel_x[0], LANE_Y, 0.15, s->parcel_x[1], LANE_Y, 0.15};
    const double orientations[4 * MOVING_BODIES] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    const double linear[3 * MOVING_BODIES] = {
        s->vehicle_speed, 0, 0, s->parcel_speed[0], 0, 0, s->parcel_speed[1], 0, 0};
    const double angular[3 * MOVING_BODIES] = {0};
    return collided_publish(c, MOVING_BODIES, moving, positions, orientations, linear, angular, 0, count);
}

/* If this process dies, its vehicle has not left the cell: the daemon holds it, as unknown. The fixed id lets the next
 * process go on with the same bodies, from where it puts them. */
static collided *connect_simulator(const example *e)
{
    collided_def def = collided_def_default();
    def.name = "vehicle_simulator";
    def.id = 77000001;
    def.on_loss = COLLIDED_HOLD;
    return example_connect(e, &def);
}

int main(int argc, char **argv)
{
    const example e = example_start(argc, argv);
    collided *c = connect_simulator(&e);
    if (!c) return EX_UNAVAILABLE;

    simulation s = {.vehicle_x = -LANE_END, .direction = 1, .parcel_x = {-LANE_END - 0.56, PARCEL_HOME}};
    collided_body moving[MOVING_BODIES];
    create_all(c, &s, moving);
    bool good = example_ok(c, collided_sync(c, 5), "vehicle_simulator: creating the cell");

    int64_t next_ns = example_now_ns();
    for (int64_t count = 1; good && example_running(&e); count++) {
        step(&s, PERIOD_S);
        good = example_ok(c, publish(c, &s, moving, count), "vehicle_simulator: publishing");
        next_ns += (int64_t)(PERIOD_S * 1e9);
        (void)example_poll_until(c, next_ns); /* without a daemon it drives on; the library announces all again */
    }
    collided_close(c);
    return good ? EX_OK : EX_SOFTWARE;
}
