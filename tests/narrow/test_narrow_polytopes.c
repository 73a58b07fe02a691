/* Distance and depth of spheres, capsules, boxes and hulls against brute force over all features in 113 bits
 * (polytope_oracle.c): the interval contains the truth and its middle is right to a few ulp of the size. */
#include "cases.h"
#include "polytope_oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS_EACH = 24 }; /* NARROW_PAIRS in the environment: more */

static double check(const shape *a, pose pa, const shape *b, pose pb, narrow_engine engine, const char *what)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    request.engine = engine;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &r);
    placed oa = oracle_place(a, pa, pa.p), ob = oracle_place(b, pb, pa.p);
    real truth = polytope_signed_distance(&oa, &ob);
    double size = shape_reach(a) + shape_reach(b) + vec_norm(vec_sub(pb.p, pa.p));
    double below = (double)(truth - r.lo), above = (double)(r.hi - truth);
    if (below < 0 || above < 0)
        fail_msg("%s: truth %.17g outside [%.17g, %.17g] by %s", what, (double)truth, r.lo, r.hi,
            narrow_method_name(r.method));
    return fabs(below - above) / 2 / size;
}

static void any_two_polytopes_match_brute_force(void **state)
{
    static const shape_type TYPES[] = {SHAPE_SPHERE, SHAPE_CAPSULE, SHAPE_BOX, SHAPE_HULL};
    const char *more = getenv("NARROW_PAIRS");
    int pairs = more ? atoi(more) : PAIRS_EACH;
    double worst = 0;
    (void)state;
    for (int ta = 0; ta < 4; ta++)
        for (int tb = 0; tb < 4; tb++)
            for (int i = 0; i < pairs; i++) {
                random_state r = {((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i + 12345};
                shape a = random_shape(&r, TYPES[ta]), b = random_shape(&r, TYPES[tb]);
                pose pa, pb;
                char what[96];
                random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
                for (int engine = NARROW_ENGINE_AUTO; engine <= NARROW_ENGINE_GJK; engine++) {
                    snprintf(what, sizeof what, "%s-%s, case %d, engine %d", shape_type_name(a.type),
                        shape_type_name(b.type), i, engine);
                    double error = check(&a, pa, &b, pb, (narrow_engine)engine, what);
                    if (engine == NARROW_ENGINE_AUTO && error > 2e-15)
                        fail_msg("%s: error %g of the size", what, error);
                    if (error > 1e-12) fail_msg("%s: error %g of the size", what, error);
                    worst = fmax(worst, error);
                }
            }
    if (getenv("NARROW_TALLY")) print_message("worst error of the middle: %.2g of the size\n", worst);
}

/* Boxes turned by next to nothing, faces almost parallel, gaps and depths down to 1e-12. */
static void nearly_parallel_boxes_match_brute_force(void **state)
{
    (void)state;
    for (int i = 0; i < 160; i++) {
        random_state r = {(uint64_t)i + 777};
        shape a = {.type = SHAPE_BOX, .half = {1, random_in(&r, 0.2, 2), 0.5}};
        shape b = {.type = SHAPE_BOX, .half = {random_in(&r, 0.2, 2), 1, 0.25}};
        double tilt = pow(10, -random_in(&r, 1, 16)), gap = pow(10, -random_in(&r, 1, 15)) * (i % 2 ? 1 : -1);
        vec3 about = random_direction(&r);
        pose pa = POSE_IDENTITY, pb = {{random_in(&r, -1, 1), random_in(&r, -1, 1), 0.75 + gap},
                                     quat_unit((quat){1, tilt * about.x, tilt * about.y, tilt * about.z})};
        char what[64];
        snprintf(what, sizeof what, "tilt %g, gap %g", tilt, gap);
        double error = check(&a, pa, &b, pb, NARROW_ENGINE_AUTO, what);
        if (error > 2e-15) fail_msg("%s: error %g of the size", what, error);
    }
}

static int create(void **state)
{
    (void)state;
    cases_create();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    cases_destroy();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(any_two_polytopes_match_brute_force),
        cmocka_unit_test(nearly_parallel_boxes_match_brute_force),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
