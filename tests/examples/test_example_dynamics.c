/* Impulses and the heap of impact_simulator, against what the textbooks say. */
#include "impact_heap.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

static rigid ball(double mass, double radius, double x, double speed)
{
    return (rigid){.inverse_mass = mass > 0 ? 1 / mass : 0,
        .inverse_inertia = radius > 0 ? 1 / (0.4 * mass * radius * radius) : 0,
        .position = {x, 0, 0},
        .linear = {speed, 0, 0},
        .orientation = {1, 0, 0, 0}};
}

static void expect(double is, double should_be)
{
    if (!(fabs(is - should_be) < 1e-12)) fail_msg("%.17g, not %.17g", is, should_be);
}

/* Newton's cradle of two: momentum stays, and they part at e times the speed at which they met. */
static void two_balls_part_at_the_restitution(void **state)
{
    (void)state;
    for (double e = 0; e <= 1; e += 0.25) {
        rigid bodies[2] = {ball(1, 0, 0, 3), ball(2, 0, 1, -1)};
        touch t = {.a = 0, .b = 1, .normal = {1, 0, 0}, .point = {0.5, 0, 0}, .restitution = e};
        dynamics_collide(bodies, &t, 1);
        expect(bodies[1].linear.x - bodies[0].linear.x, 4 * e);
        expect(dynamics_momentum(bodies, 2).x, 1);
    }
}

/* A solid ball with spin 0 meets the ground: while it slips, friction is mu times the normal impulse; with enough of it
 * the slip ends, and 5/7 of the speed is left. */
static void friction_slips_or_sticks(void **state)
{
    (void)state;
    for (int sticks = 0; sticks < 2; sticks++) {
        rigid bodies[2] = {ball(2, 0.5, 0, 3), {.orientation = {1, 0, 0, 0}}};
        bodies[0].linear.z = -1;
        bodies[0].position.z = 0.5;
        touch t = {.a = 0, .b = 1, .normal = {0, 0, -1}, .restitution = 0.5, .friction = sticks ? 5 : 0.1};
        dynamics_collide(bodies, &t, 1);
        expect(bodies[0].linear.z, 0.5);
        expect(bodies[0].linear.x, sticks ? 3 * 5 / 7.0 : 3 - 0.1 * 1.5);
        double slip = bodies[0].linear.x - bodies[0].angular.y * 0.5;
        if (sticks) expect(slip, 0);
        assert_true(slip > -1e-12);
    }
}

/* Five in a row, all touching: however the impulse goes through them, nothing is lost where nothing is to be. */
static void a_row_that_touches_keeps_energy_and_momentum(void **state)
{
    (void)state;
    rigid bodies[5];
    touch touches[4];
    for (int i = 0; i < 5; i++) bodies[i] = ball(1 + 0.3 * i, 0, i, i == 0 ? 2 : 0);
    for (int i = 0; i < 4; i++)
        touches[i] = (touch){.a = i, .b = i + 1, .normal = {1, 0, 0}, .point = {i + 0.5, 0, 0}, .restitution = 1};
    double energy = dynamics_kinetic(bodies, 5);
    dynamics_collide(bodies, touches, 4);
    assert_true(fabs(dynamics_kinetic(bodies, 5) - energy) < 1e-9 * energy);
    expect(dynamics_momentum(bodies, 5).x, 2);
    for (int i = 0; i < 4; i++) assert_true(dynamics_parting(bodies, &touches[i]) > -1e-11);
}

static void a_body_turns_about_its_axis(void **state)
{
    (void)state;
    rigid body = ball(1, 1, 0, 0);
    body.angular.z = 2;
    for (int i = 0; i < 100; i++) dynamics_advance(&body, (vector){1, 0, 0}, 0.01);
    expect(body.position.x, 1);
    expect(body.orientation[0], cos(1));
    expect(body.orientation[3], sin(1));
}

static void the_heap_gives_the_earliest_first_and_ties_by_number(void **state)
{
    (void)state;
    static impact_heap heap;
    impact e, last = {.lo_s = -1};
    srand(7);
    for (int i = 0; i < IMPACTS_MAX + 3; i++)
        impact_push(&heap, (impact){.lo_s = rand() % 50, .at = {.a = rand() % 9, .b = rand() % 9}});
    assert_int_equal(heap.dropped, 3);
    for (int i = 0; i < IMPACTS_MAX; i++) {
        assert_true(impact_pop(&heap, &e));
        double was = last.lo_s * 100 + last.at.a * 10 + last.at.b, is = e.lo_s * 100 + e.at.a * 10 + e.at.b;
        assert_true(is >= was);
        last = e;
    }
    assert_false(impact_pop(&heap, &e));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_balls_part_at_the_restitution),
        cmocka_unit_test(friction_slips_or_sticks),
        cmocka_unit_test(a_row_that_touches_keeps_energy_and_momentum),
        cmocka_unit_test(a_body_turns_about_its_axis),
        cmocka_unit_test(the_heap_gives_the_earliest_first_and_ties_by_number),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
