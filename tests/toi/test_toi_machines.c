/* What machines do is decided, and truly: sliding with little clearance, lifting off, turning about a hinge, coming to
 * a stop. And what takes more than a search may ends in time, with what is proven of the time before. */
#include "machines.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>
#include <stdio.h>

enum { SAMPLES = 24, CLOSELY = 30 /* the scene that takes more than a search may */, OPENS = 8, SPINS = 15 };

static bool is_door(int scene)
{
    return scene == 9 || scene == 10;
}

static narrow_scratch *scratch;

/* Apart at samples of the time before lo, and just before it. */
static void apart_before(const machine *m, const toi_result *t)
{
    double end = fmin(t->lo, m->request.span);
    for (int k = 0; k <= SAMPLES; k++) {
        double time = k < SAMPLES ? end * k / SAMPLES : end * (1 - 1e-9);
        narrow_result n = toi_truth_at(&m->movers[0], &m->movers[1], time, 1e-9, scratch);
        if (n.hi < 0) fail_msg("%s: apart before %.12g, but at %.12g the distance is %g", m->name, t->lo, time, n.hi);
    }
}

static void decided(int scene, int size, double shrink)
{
    machine m;
    machine_make(scene, size, shrink, &m);
    toi_result t = machine_find(&m, scratch);
    bool truly = isinf(m.hit) ? t.status == TOI_FREE
                              : (t.status == TOI_HIT || t.status == TOI_NEAR) && t.lo <= m.hit && t.hi >= m.hit;
    if (!truly)
        fail_msg("%s, size %d, clearance times %g: %s [%.12g, %.12g] for %.12g, work %u", m.name, size, shrink,
            toi_status_name(t.status), t.lo, t.hi, m.hit, t.work);
    if (t.status == TOI_HIT || t.status == TOI_NEAR) { /* not early by more than the tolerance takes */
        double gap = toi_truth_at(&m.movers[0], &m.movers[1], t.lo, 1e-9, scratch).lo;
        if (gap > 2 * m.request.tolerance) fail_msg("%s: %g m apart at lo", m.name, gap);
    }
    if (size == 1) apart_before(&m, &t);
    machine_free(&m);
}

static void what_machines_do_is_decided(void **state)
{
    (void)state;
    for (int scene = 0; scene < MACHINES; scene++)
        if (scene != CLOSELY) decided(scene, 1, 1);
}

/* Down to 1e-8 m, a hundredth of the tolerance; a door keeps that at its hinge while it turns, which is near; and what
 * spins by turns is a cylinder only as well as doubles tell. */
static void the_clearance_does_not_matter(void **state)
{
    (void)state;
    static const double SHRINKS[] = {1.5, 0.3, 0.01, 1e-3};
    for (int scene = 0; scene < 24; scene++)
        for (size_t k = 0; k < sizeof SHRINKS / sizeof *SHRINKS; k++)
            if (SHRINKS[k] > (is_door(scene) ? 0.1 : scene == SPINS ? 0.005 : 0)) decided(scene, 1, SHRINKS[k]);
}

/* 300 plates, 10,000 triangles that lie on each other all but for 1e-5. */
static void large_ones_are_decided(void **state)
{
    (void)state;
    static const int SCENES[][2] = {{0, 15}, {1, 15}, {2, 15}, {3, 15}, {4, 3}, {5, 3}, {7, 4}, {11, 8}, {24, 3}};
    for (size_t k = 0; k < sizeof SCENES / sizeof *SCENES; k++) decided(SCENES[k][0], SCENES[k][1], 1);
}

/* As much as a search may take, and not much more: what overshoots is the last pair of parts. */
static toi_result ends_in_time(const machine *m)
{
    toi_result t = machine_find(m, scratch), again = machine_find(m, scratch);
    assert_memory_equal(&t, &again, sizeof t);
    assert_int_equal(t.status, TOI_UNDECIDED);
    assert_true(isinf(t.hi) && t.work <= TOI_WORK_MAX + TOI_WORK_MAX / 50);
    narrow_result n = toi_truth_at(&m->movers[0], &m->movers[1], t.lo, 1e-9, scratch);
    assert_true(t.gap_lo <= n.hi && n.lo <= t.gap_hi); /* one query may not have the effort to tell them apart */
    apart_before(m, &t);
    return t;
}

/* Two rings of 352 triangles that tumble one within the other, by 1,850 rad: the time is told up to which they are
 * proven to be apart, which is many turns. */
static void many_turns_end_in_time(void **state)
{
    (void)state;
    machine m;
    machine_make(CLOSELY, 1, 1, &m);
    toi_result t = ends_in_time(&m);
    if (!(t.lo * 1850 > 50)) fail_msg("only %g rad are free", t.lo * 1850);
    machine_free(&m);
}

/* So much lies so close that it cannot all be looked at: no time is proven to be free, and that is told. */
static void too_much_ends_in_time(void **state)
{
    (void)state;
    machine m;
    machine_make(OPENS, 4, 1, &m);
    (void)ends_in_time(&m);
    machine_free(&m);
}

/* Of what a search may take the legs before have taken some: then less is decided, and never anything else. */
static void less_is_decided_with_less(void **state)
{
    (void)state;
    static const uint32_t LEFT[] = {0, 1, 1000, 100000, 400000};
    static const int SCENES[] = {0, OPENS, 10, 13, 20, 28};
    for (size_t i = 0; i < sizeof SCENES / sizeof *SCENES; i++) {
        machine m;
        machine_make(SCENES[i], 1, 1, &m);
        for (size_t k = 0; k < sizeof LEFT / sizeof *LEFT; k++) {
            m.request.spent = TOI_WORK_MAX - LEFT[k];
            toi_result t = machine_find(&m, scratch);
            bool undecided = t.status == TOI_UNDECIDED, contact = t.status == TOI_HIT || t.status == TOI_NEAR;
            assert_true(t.work <= LEFT[k] + TOI_WORK_MAX / 50);
            assert_true(undecided || contact == isfinite(m.hit));
            if (undecided || contact) assert_true(t.lo <= m.hit && t.hi >= m.hit);
            apart_before(&m, &t);
        }
        machine_free(&m);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_machines_do_is_decided),
        cmocka_unit_test(the_clearance_does_not_matter), cmocka_unit_test(large_ones_are_decided),
        cmocka_unit_test(many_turns_end_in_time), cmocka_unit_test(too_much_ends_in_time),
        cmocka_unit_test(less_is_decided_with_less)};
    scratch = aligned_alloc(64, narrow_scratch_size());
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    free(scratch);
    return failed;
}
