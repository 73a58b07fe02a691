/* One unit in the last place of one coordinate, and how little may come of it.
 *
 * The true signed distance changes by at most as much as B moved; so two intervals that hold the truth overlap to
 * within that. Their middles may differ by the slack of samples.h, the axis of a gap by 1e-6 rad as long as the gap is
 * above 1e-9 of the size (a gap's axis changes by at most the motion over the gap), and a verdict by nothing but within
 * the slack of touching. The axis of an overlap may jump where two depths are equal: nothing is asked of it. */
#include "samples.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const double LEAST_GAP = 1e-9, LARGEST_TURN = 1e-6;

static void compare(const sample *s, double moved, const narrow_result *x, const narrow_result *y)
{
    if (isinf(x->lo) && isinf(y->lo)) return; /* two half-spaces that nothing separates */
    double slack = sample_slack(s, x) + moved, change = fabs(middle(x) - middle(y));
    if (!(y->lo <= x->hi + moved && x->lo <= y->hi + moved))
        fail_msg("%s: [%a, %a] and [%a, %a] do not overlap", sample_name(s), x->lo, x->hi, y->lo, y->hi);
    if (!sample_agrees(x, y, slack))
        fail_msg("%s: %.17g became %.17g, %.1f ulp", sample_name(s), middle(x), middle(y), change / s->ulp);
    if (x->lo > LEAST_GAP * s->size && y->lo > LEAST_GAP * s->size) {
        double turn = vec_norm(vec_sub(x->axis, y->axis));
        if (!(turn < LARGEST_TURN)) fail_msg("%s: the axis turned by %g", sample_name(s), turn);
    }
    if (((x->lo > 0) != (y->lo > 0) && !(fabs(x->lo) <= slack)) ||
        ((x->hi < 0) != (y->hi < 0) && !(fabs(x->hi) <= slack)))
        fail_msg("%s: [%a, %a] has another verdict than [%a, %a]", sample_name(s), x->lo, x->hi, y->lo, y->hi);
}

static void one_ulp_of_a_coordinate_changes_next_to_nothing(void **state)
{
    unsigned count = samples_each();
    (void)state;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++)
            for (unsigned i = 0; i < count; i++) {
                sample s = sample_of(ta, tb, i);
                narrow_result before = sample_ask(&s);
                for (int k = 0; k < 3; k++) {
                    sample t = s;
                    double *at = k == 0 ? &t.pb.p.x : k == 1 ? &t.pb.p.y : &t.pb.p.z, was = *at;
                    *at = nextafter(was, i % 2 ? INFINITY : -INFINITY);
                    narrow_result after = sample_ask(&t);
                    compare(&s, fabs(*at - was), &before, &after);
                }
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(one_ulp_of_a_coordinate_changes_next_to_nothing),
    };
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
