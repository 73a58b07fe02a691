/* Formulas against general methods: what they answer for balls, capsules and boxes agrees; boxes
 * set on a grid, where faces, edges and corners meet in every tie, are right and name points of both; ellipsoids, of
 * which a ball is shaved off, are certified as whole ones at any depth; where shapes stand in the world, the formulas
 * without a relative pose prove what they say, at every size the same. */
#include "cases.h"
#include "oracle.h"
#include "where_they_stand.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

static double pick(random_state *r, const double *from, unsigned count)
{
    return from[random_bits(r) % count];
}

static shape small_shape(random_state *r, shape_type type, int exponent)
{
    shape s = {.type = type, .radius = type == SHAPE_BOX && random_bits(r) % 2 ? 0 : ldexp(random_unit(r), exponent)};
    if (type != SHAPE_SPHERE)
        s.half = vec_scale(vec(random_unit(r), random_unit(r), 0.1 + random_unit(r)), ldexp(1, exponent));
    if (type == SHAPE_CAPSULE) s.half = vec(0, 0, random_bits(r) % 50 ? s.half.z : 0); /* without length: a ball */
    return s;
}

/* Turns about the common axis, too: parallel capsules, faces across the line. */
static quat some_rotation(random_state *r)
{
    static const quat STRAIGHT[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    return random_bits(r) % 10 ? random_rotation(r) : STRAIGHT[random_bits(r) % 4];
}

/* Does the formula answer; and is what it says as narrow as asked, proven by its axis, and not contradicted by the
 * general method? The latter is taken for a manifold, which no formula makes; the threshold leaves its list empty. */
static epa_scratch scratch;

static bool agrees_with_the_general_method(
    const shape *a, const shape *b, const pose *b_in_a, const narrow_request *asked)
{
    narrow_request request = *asked;
    narrow_result quick, general;
    if (!primitives_answer(a, b, b_in_a, &request, NULL, &scratch, &quick)) return false;
    request.facts |= NARROW_MANIFOLD;
    narrow_query(a, b, b_in_a, &request, NULL, case_scratch(), &general);
    placed oa = oracle_place(a, POSE_IDENTITY, VEC_ZERO), ob = oracle_place(b, *b_in_a, VEC_ZERO);
    assert_true(quick.lo <= quick.hi && quick.lo <= general.hi && general.lo <= quick.hi);
    assert_true((double)oracle_separation(&oa, &ob, real3_of(quick.axis)) >= quick.lo);
    assert_true(quick.status == NARROW_CERTAIN);
    bool measure = asked->facts & NARROW_DISTANCE;
    if (measure && quick.lo <= asked->range) assert_true(quick.hi - quick.lo <= asked->tolerance);
    if (asked->facts != NARROW_DISTANCE) assert_true(quick.lo > asked->threshold || quick.hi <= asked->threshold);
    return true;
}

static void the_formulas_agree_with_the_general_method(void **state)
{
    (void)state;
    static const shape_type PAIRS[][2] = {{SHAPE_SPHERE, SHAPE_SPHERE}, {SHAPE_SPHERE, SHAPE_CAPSULE},
        {SHAPE_SPHERE, SHAPE_BOX}, {SHAPE_CAPSULE, SHAPE_CAPSULE}, {SHAPE_CAPSULE, SHAPE_BOX}, {SHAPE_BOX, SHAPE_BOX}};
    enum { PAIR_COUNT = 6, SEEDS = 24000 };
    unsigned asked[PAIR_COUNT] = {0}, answered[PAIR_COUNT] = {0};
    for (uint64_t seed = 1; seed <= SEEDS; seed++) {
        random_state r = {seed};
        size_t k = seed % PAIR_COUNT;
        int exponent = (int)(seed % 37) - 18;
        shape a = small_shape(&r, PAIRS[k][0], exponent),
              b = small_shape(&r, PAIRS[k][1], exponent + (int)(seed % 7) - 3);
        if (!narrow_ordered(&a, 0, &b, 1)) continue;
        double reach = shape_reach(&a) + shape_reach(&b), away = random_bits(&r) % 20 ? random_in(&r, 0, 2) : 0;
        const pose b_in_a = {vec_scale(random_direction(&r), reach * away), some_rotation(&r)};
        static const unsigned FACTS[] = {0, NARROW_VERDICT, NARROW_DISTANCE, NARROW_DISTANCE | NARROW_VERDICT};
        static const double TOLERANCES[] = {INFINITY, 0.1, 1e-3, 1e-6, 1e-9};
        const narrow_request request = {.facts = FACTS[random_bits(&r) % 4],
            .tolerance = reach * pick(&r, TOLERANCES, 5),
            .range = seed % 4 ? INFINITY : 0.2 * reach,
            .threshold = seed % 5 ? 0 : reach * random_in(&r, -0.1, 0.5)};
        const narrow_request finest = {.facts = NARROW_DISTANCE, .tolerance = 1e-20 * reach, .range = INFINITY};
        asked[k]++;
        answered[k] += agrees_with_the_general_method(&a, &b, &b_in_a, &request);
        assert_false(agrees_with_the_general_method(&a, &b, &b_in_a, &finest)); /* not within reach of doubles */
    }
    for (size_t k = 0; k < PAIR_COUNT; k++)
        if (!(answered[k] > asked[k] * 0.8)) fail_msg("pair %zu: %u of %u", k, answered[k], asked[k]);
}

/* The separation of two boxes of one frame: per axis, then the longest way round a corner. */
static double aligned_distance(vec3 a, vec3 b, vec3 at)
{
    vec3 gap = vec(fabs(at.x) - a.x - b.x, fabs(at.y) - a.y - b.y, fabs(at.z) - a.z - b.z);
    double most = fmax(gap.x, fmax(gap.y, gap.z));
    return most <= 0 ? most : vec_norm(vec_max(gap, VEC_ZERO));
}

static void boxes_on_a_grid_are_right_in_every_tie(void **state)
{
    (void)state;
    static const double SIDES[] = {0, 0.25, 0.5, 1, 2}, STEPS[] = {-3, -1.5, -1, -0.75, -0.5, 0, 0.5, 0.75, 1, 1.5, 3};
    static const quat TURNS[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    for (uint64_t seed = 1; seed <= 4000; seed++) {
        random_state r = {seed};
        shape a = {.type = SHAPE_BOX, .half = {pick(&r, SIDES, 5), pick(&r, SIDES, 5), pick(&r, SIDES, 5)}};
        shape b = {.type = SHAPE_BOX, .half = {pick(&r, SIDES, 5), pick(&r, SIDES, 5), pick(&r, SIDES, 5)}};
        vec3 at = vec(pick(&r, STEPS, 11), pick(&r, STEPS, 11), pick(&r, STEPS, 11));
        pose pa = POSE_IDENTITY, pb = {at, TURNS[seed % 4]};
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
        narrow_result x;
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &x);
        double truth = aligned_distance(a.half, b.half, at), size = shape_reach(&a) + shape_reach(&b) + vec_norm(at);
        if (!(x.lo <= truth && truth <= x.hi && x.hi - x.lo <= 1e-14 * size))
            fail_msg("seed %llu: %.17g outside [%.17g, %.17g]", (unsigned long long)seed, truth, x.lo, x.hi);
        placed oa = oracle_place(&a, pa, pa.p), ob = oracle_place(&b, pb, pa.p);
        assert_true(oracle_outside(&oa, x.point_a) <= 1e-14 * size && oracle_outside(&ob, x.point_b) <= 1e-14 * size);
        vec3 line = vec_sub(x.point_b, x.point_a);
        if (truth < 0) assert_true(fabs(vec_dot(line, x.axis) - truth) <= 1e-13 * size);
    }
}

/* Centres that coincide along the axis of the depth, by a zero of either sign: axis and witnesses agree on the side. */
static void minus_zero_is_a_side_like_zero(void **state)
{
    (void)state;
    static const quat TURNS[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    static const vec3 HALVES[] = {{0.25, 2, 1}, {2, 0.25, 1}, {2, 1, 0.25}};
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    for (int i = 0; i < 3 * 8 * 16; i++) {
        vec3 half = HALVES[i % 3], at = vec(i & 1 ? -0.0 : 0, i & 2 ? -0.0 : 0, i & 4 ? -0.0 : 0);
        shape a = {.type = SHAPE_BOX, .half = half}, b = {.type = SHAPE_BOX, .half = vec_scale(half, 0.75)};
        pose pa = {at, TURNS[i / 8 % 4]}, pb = {VEC_ZERO, TURNS[i / 32 % 4]}, b_in_a = {at, pb.q};
        narrow_result r[3];
        narrow_query(&a, &b, &b_in_a, &request, NULL, case_scratch(), &r[0]);
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &r[1]);
        query_where_they_stand(&a, pa, &b, pb, &request, NULL, &r[2]);
        for (int k = 0; k < 3; k++) {
            double along = vec_dot(vec_sub(r[k].point_b, r[k].point_a), r[k].axis);
            if (!(fabs(along + 0.4375) <= 1e-14)) fail_msg("case %d, road %d: %g", i, k, along);
        }
    }
}

/* The oracle knows nothing of shaving: the axis proves lo of the whole ellipsoids, no direction separates by more than
 * hi, and the points are of the whole ones. */
static void shaved_ellipsoids_measure_as_whole_ones(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 600; seed++) {
        random_state r = {seed};
        shape a = random_shape(&r, SHAPE_ELLIPSOID), b = random_shape(&r, seed % 2 ? SHAPE_ELLIPSOID : SHAPE_BOX);
        pose pa, pb;
        random_poses(&r, &a, &b, (enum regime)(seed % REGIME_COUNT), &pa, &pb);
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-7, .range = INFINITY};
        narrow_result x;
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &x);
        placed oa = oracle_place(&a, pa, pa.p), ob = oracle_place(&b, pb, pa.p);
        double size = shape_reach(&a) + shape_reach(&b) + vec_norm(vec_sub(pb.p, pa.p));
        assert_int_equal(x.status, NARROW_CERTAIN);
        assert_true((double)oracle_separation(&oa, &ob, real3_of(x.axis)) >= x.lo);
        if (seed % 10 == 0) assert_true((double)oracle_search(&oa, &ob) <= x.hi);
        assert_true(oracle_outside(&oa, x.point_a) <= 1e-13 * size && oracle_outside(&ob, x.point_b) <= 1e-13 * size);
        if (x.lo > 0) assert_true(vec_norm(vec_sub(x.point_b, x.point_a)) <= x.hi * (1 + 1e-15));
    }
}

static narrow_result ask_placed(const shape *a, pose pa, const shape *b, pose pb, const narrow_request *request)
{
    narrow_result r;
    query_where_they_stand(a, pa, b, pb, request, NULL, &r);
    return r;
}

static shape scaled(shape s, double by)
{
    s.radius *= by;
    s.half = vec_scale(s.half, by);
    return s;
}

/* At 2^exponent of the size: the same bits but for the exponent. */
static void scales(const shape *a, pose pa, const shape *b, pose pb, const narrow_result *r, double width, int exponent)
{
    double by = ldexp(1, exponent);
    shape x = scaled(*a, by), y = scaled(*b, by);
    pa.p = vec_scale(pa.p, by), pb.p = vec_scale(pb.p, by);
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = by * width, .range = INFINITY};
    narrow_result s = ask_placed(&x, pa, &y, pb, &request);
    vec3 point_a = vec_scale(r->point_a, by), point_b = vec_scale(r->point_b, by);
    assert_true(s.lo == by * r->lo && s.hi == by * r->hi && s.status == r->status);
    assert_memory_equal(&s.axis, &r->axis, sizeof s.axis);
    assert_memory_equal(&s.point_a, &point_a, sizeof point_a);
    assert_memory_equal(&s.point_b, &point_b, sizeof point_b);
}

static void where_they_stand_the_answer_is_proven(void **state)
{
    (void)state;
    static const shape_type PAIRS[][2] = {{SHAPE_SPHERE, SHAPE_SPHERE}, {SHAPE_SPHERE, SHAPE_CAPSULE},
        {SHAPE_SPHERE, SHAPE_BOX}, {SHAPE_CAPSULE, SHAPE_CAPSULE}, {SHAPE_CAPSULE, SHAPE_BOX}, {SHAPE_BOX, SHAPE_BOX}};
    for (uint64_t seed = 1; seed <= 12000; seed++) {
        random_state r = {seed};
        const shape_type *types = PAIRS[seed % 6];
        shape a = small_shape(&r, types[0], 0), b = small_shape(&r, types[1], (int)(seed % 7) - 3);
        if (!narrow_ordered(&a, 0, &b, 1)) continue;
        double reach = shape_reach(&a) + shape_reach(&b), away = random_bits(&r) % 20 ? random_in(&r, 0, 2) : 0;
        pose pa = {random_direction(&r), some_rotation(&r)};
        pose pb = {vec_madd(pa.p, reach * away, random_direction(&r)), some_rotation(&r)};
        const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-7 * reach, .range = INFINITY};
        narrow_result x = ask_placed(&a, pa, &b, pb, &request), general;
        narrow_query_world(&a, pa, &b, pb, &request, case_scratch(), &general);
        double size = reach + vec_norm(vec_sub(pb.p, pa.p));
        placed oa = oracle_place(&a, pa, pa.p), ob = oracle_place(&b, pb, pa.p);
        assert_true(x.status == NARROW_CERTAIN && x.lo <= general.hi && general.lo <= x.hi);
        assert_true((double)oracle_separation(&oa, &ob, real3_of(x.axis)) >= x.lo);
        assert_true(oracle_outside(&oa, x.point_a) <= 1e-14 * size && oracle_outside(&ob, x.point_b) <= 1e-14 * size);
        if (x.lo > 0) assert_true(vec_norm(vec_sub(x.point_b, x.point_a)) <= x.hi);
        static const int EXPONENTS[] = {-340, -50, -30, 3, 40, 300};
        for (int i = 0; i < 6; i++) scales(&a, pa, &b, pb, &x, request.tolerance, EXPONENTS[i]);
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
        cmocka_unit_test(the_formulas_agree_with_the_general_method),
        cmocka_unit_test(boxes_on_a_grid_are_right_in_every_tie),
        cmocka_unit_test(minus_zero_is_a_side_like_zero),
        cmocka_unit_test(shaved_ellipsoids_measure_as_whole_ones),
        cmocka_unit_test(where_they_stand_the_answer_is_proven),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
