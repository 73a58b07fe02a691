/* Which points does the checker take for points of a shape? Held against a second way that shares no formula with it:
 * the distance of a point is the greatest n.q - support(n) over all directions n, found by looking at many. Shapes
 * include those of which an extent or a radius is 0, or all are; points lie on a lattice of their sizes, and around it.
 */
#include "cmocka_c.h"

#include <collided.h>
#include <math.h>
#include <stdio.h>

enum { DIRECTIONS = 64, REFINEMENTS = 52 };
static const double PI = 3.14159265358979323846;
static const double SIZES[] = {0, 1e-9, 0.05, 1};
enum { SIZE_COUNT = sizeof SIZES / sizeof *SIZES };

/* Of the core, along (cos, sin) in the plane of x and z, in which all points here lie. */
static double support(const collided_shape *s, double x, double z)
{
    const double *h = s->half;
    switch (s->type) {
    case COLLIDED_CAPSULE:
        return h[2] * fabs(z);
    case COLLIDED_BOX:
    case COLLIDED_CYLINDER:
        return h[0] * fabs(x) + h[2] * fabs(z);
    case COLLIDED_CONE:
        return fmax(h[2] * z, h[0] * fabs(x) - h[2] * z);
    case COLLIDED_ELLIPSOID:
        return hypot(h[0] * x, h[2] * z);
    default:
        return 0;
    }
}

static double beyond(const collided_shape *s, double x, double z, double angle)
{
    double c = cos(angle), n = sin(angle);
    return c * x + n * z - support(s, c, n);
}

/* Signed: inside it is minus the distance to the nearest supporting plane. */
static double distance(const collided_shape *s, double x, double z)
{
    double best = -INFINITY, at = 0, step = 2 * PI / DIRECTIONS;
    for (int i = 0; i < DIRECTIONS; i++) {
        double d = beyond(s, x, z, i * step);
        if (d > best) best = d, at = i * step;
    }
    for (int i = 0; i < REFINEMENTS; i++, step /= 2) {
        double more = beyond(s, x, z, at + step), less = beyond(s, x, z, at - step);
        if (more > best) best = more, at += step;
        if (less > best) best = less, at -= step;
    }
    return best - s->radius;
}

static collided_status claim_that_it_holds(const collided_shape *s, double x, double z)
{
    collided_shape point = collided_sphere(0);
    collided_pose here = collided_pose_identity(), there = here;
    there.position[0] = x, there.position[2] = z;
    collided_certificate claim = {.lo = -INFINITY, .hi = 0, .point_a = {x, 0, z}, .point_b = {x, 0, z}};
    return collided_verify(s, &here, NULL, 0, &point, &there, NULL, 0, &claim);
}

static size_t judged, held;

static void look(const collided_shape *s, double x, double z)
{
    double d = distance(s, x, z), size = hypot(x, z) + s->half[0] + s->half[2] + s->radius;
    bool is_in = d <= 1e-15 * size, is_out = d > 1e-9 * size;
    if (!is_in && !is_out) return;
    collided_status said = claim_that_it_holds(s, x, z);
    judged++;
    held += is_in;
    if ((said == COLLIDED_OK) == is_in) return;
    printf("type %d, half %a %a, radius %a, point %a %a, distance %a: %s\n", s->type, s->half[0], s->half[2], s->radius,
        x, z, d, said == COLLIDED_OK ? "accepted" : "refused");
    fail();
}

static void points_of(collided_shape s)
{
    const double places[] = {0, 0.5, 1 - 1e-12, 1, 1 + 1e-6, 2, 1000};
    const double scales[] = {s.half[0], s.half[2], s.radius, 1};
    for (size_t i = 0; i < sizeof places / sizeof *places; i++)
        for (size_t k = 0; k < sizeof places / sizeof *places; k++)
            for (int turn = 0; turn < 16; turn++) {
                double x = places[i] * scales[turn & 3], z = places[k] * scales[turn >> 2];
                look(&s, x, z);
                look(&s, x, -z);
                look(&s, s.half[0] + s.radius * x, z);
                look(&s, x, s.half[2] + s.radius * z);
            }
}

static void shapes_without_extent_hold_only_their_points(void **state)
{
    (void)state;
    for (int r = 0; r < SIZE_COUNT; r++)
        for (int h = 0; h < SIZE_COUNT; h++)
            for (int round = 0; round < SIZE_COUNT; round++) {
                double half = SIZES[h], wide = SIZES[r];
                collided_shape shapes[] = {collided_sphere(0), collided_capsule(0, half),
                    collided_box(wide, wide, half), collided_cylinder(wide, half), collided_cone(wide, half),
                    collided_ellipsoid(wide, wide, half)};
                for (size_t i = 0; i < sizeof shapes / sizeof *shapes; i++) {
                    shapes[i].radius = SIZES[round];
                    points_of(shapes[i]);
                }
            }
    printf("%zu points judged, %zu of them in the shape\n", judged, held);
    assert_true(held > 10000 && judged - held > 10000);
}

/* The claim that a strangers' test made: a ball a kilometre off touches a cone of height 0. */
static void a_flat_cone_does_not_reach_everywhere_in_its_plane(void **state)
{
    (void)state;
    collided_shape cone = collided_cone(1, 0), ball = collided_sphere(0.1);
    collided_pose here = collided_pose_identity(), there = here;
    there.position[0] = 1000;
    collided_certificate claim = {
        .lo = -INFINITY, .hi = 0, .axis = {1, 0, 0}, .point_a = {999.9, 0, 0}, .point_b = {999.9, 0, 0}};
    assert_int_equal(collided_verify(&cone, &here, NULL, 0, &ball, &there, NULL, 0, &claim), COLLIDED_REJECTED);
    claim = (collided_certificate){
        .lo = 998.9, .hi = 998.9, .axis = {1, 0, 0}, .point_a = {1, 0, 0}, .point_b = {999.9, 0, 0}};
    assert_int_equal(collided_verify(&cone, &here, NULL, 0, &ball, &there, NULL, 0, &claim), COLLIDED_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(shapes_without_extent_hold_only_their_points),
        cmocka_unit_test(a_flat_cone_does_not_reach_everywhere_in_its_plane)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
