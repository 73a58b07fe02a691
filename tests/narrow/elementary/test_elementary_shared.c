/* The published and generated queries of the shared case files (COLLIDED_SHARED; absent: skipped, and said so): the
 * daemon's answers against the truth of the file, and the oracle against it too. */
#include "elementary_judge.h"
#include "elementary_sets.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

static void check(const char *name, size_t i, const elementary_case *c, elementary_tally *tally)
{
    elementary_truth own = elementary_oracle(&c->query);
    elementary_result r = elementary_ask(&c->query, 0);
    const char *fault = elementary_fault(&c->query, 0, &r, &c->truth);
    elementary_count(tally, &r, &c->truth);
    if (own.touches != c->truth.touches) fault = "the oracle contradicts the file";
    if (own.touches && !(own.lo <= c->truth.hi && c->truth.lo <= own.hi)) fault = "the oracle has another time";
    if (!fault) return;
    elementary_print(&c->query, &r, &own);
    fail_msg("%s, query %zu, file says [%.17g, %.17g]: %s", name, i + 1, c->truth.lo, c->truth.hi, fault);
}

static void run(const char *name)
{
    size_t count;
    elementary_tally tally = {0};
    elementary_case *cases = elementary_read(name, &count);
    if (!cases) {
        printf("skipped: cases/ccd/%s is not there (COLLIDED_SHARED)\n", name);
        skip();
    }
    for (size_t i = 0; i < count; i++) check(name, i, &cases[i], &tally);
    free(cases);
    elementary_print_tally(name, &tally);
    assert_true(count > 0);
}

static void vertex_face(void **state)
{
    (void)state;
    run("sample_vf.csv");
}

static void edge_edge(void **state)
{
    (void)state;
    run("sample_ee.csv");
}

static void generated(void **state)
{
    (void)state;
    run("fuzz.csv");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(vertex_face),
        cmocka_unit_test(edge_edge),
        cmocka_unit_test(generated),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
