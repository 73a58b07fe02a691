/* The figure that issue 2 names: in the SRDF's state `ready`, fingers closed, the panda's least self distance over the
 * pairs that its SRDF does not disable is 0.022134891 m, between link5 and link7. Files to hulls to certified distance.
 */
#include "fixture.h"

#include "geom/hull.h"
#include "narrow/narrow.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BODIES_MAX = 16 };

static pose to_pose(const collided_pose *p)
{
    const double *x = p->position, *q = p->orientation;
    return (pose){{x[0], x[1], x[2]}, {q[0], q[1], q[2], q[3]}};
}

static bool disabled(const load_body *a, const load_body *b)
{
    for (size_t i = 0; i < a->rule_count; i++)
        if (strcmp(a->rules[i].pattern, b->name) == 0) return a->rules[i].allow;
    return false;
}

typedef struct least {
    double lo, hi;
    const char *a, *b;
} least;

static least least_distance(const load_bodies *bodies, hull *const *hulls)
{
    least out = {INFINITY, INFINITY, "", ""};
    narrow_scratch *scratch = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64);
    narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    for (size_t i = 0; i < bodies->count; i++)
        for (size_t j = i + 1; j < bodies->count; j++) {
            const load_body *a = &bodies->at[i], *b = &bodies->at[j];
            if (disabled(a, b) || disabled(b, a)) continue;
            shape sa = {.type = SHAPE_HULL, .hull = hulls[i]}, sb = {.type = SHAPE_HULL, .hull = hulls[j]};
            narrow_result r;
            pose shape_a = to_pose(&a->shapes[0].shape.pose), shape_b = to_pose(&b->shapes[0].shape.pose);
            narrow_query_world(&sa, pose_mul(to_pose(&a->pose), shape_a), &sb, pose_mul(to_pose(&b->pose), shape_b),
                &request, scratch, &r);
            if (r.lo < out.lo) out = (least){r.lo, r.hi, a->name, b->name};
        }
    free(scratch);
    return out;
}

static bool least_in_state(fixture *f, const char *state, least *out)
{
    robot b;
    double values[64];
    load_bodies bodies = {0};
    hull *hulls[BODIES_MAX] = {0};
    fixture_begin(f);
    if (!fixture_panda(f, &b)) return false;
    robot_default_values(&b, values);
    if (!robot_state(&b, state, values, &f->report) ||
        !robot_bodies(&b, (collided_pose){{0}, {1}}, values, COLLIDED_MOVING, &f->pool, &bodies, &f->report))
        fail_msg("%s", f->report.error);
    assert_in_range(bodies.count, 1, BODIES_MAX);
    for (size_t i = 0; i < bodies.count; i++) {
        const mesh_points *points = &bodies.at[i].shapes[0].points;
        assert_int_equal(hull_build(points->at, points->count, 0, &hulls[i]), HULL_OK);
    }
    *out = least_distance(&bodies, hulls);
    for (size_t i = 0; i < bodies.count; i++) hull_destroy(hulls[i]);
    return true;
}

static void ready_is_22_mm_from_touching_itself(void **state)
{
    (void)state;
    fixture f = {0};
    least d = {0};
    if (!least_in_state(&f, "ready", &d)) skip();
    print_message("ready: [%.12f, %.12f] m, %s to %s\n", d.lo, d.hi, d.a, d.b);
    assert_string_equal(d.a, "panda_link5");
    assert_string_equal(d.b, "panda_link7");
    assert_true(fabs(d.lo - 0.022134891) < 1e-7 && fabs(d.hi - 0.022134891) < 1e-7);
    fixture_end(&f);
}

static void transport_touches_itself(void **state)
{
    (void)state;
    fixture f = {0};
    least d = {0};
    if (!least_in_state(&f, "transport", &d)) skip();
    assert_string_equal(d.a, "panda_link5");
    assert_string_equal(d.b, "panda_link7");
    assert_true(d.hi < 0);
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ready_is_22_mm_from_touching_itself),
        cmocka_unit_test(transport_touches_itself),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
