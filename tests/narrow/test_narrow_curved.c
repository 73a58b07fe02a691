/* Cylinders and cones against each other, boxes, capsules and hulls: a dome (narrow/curved/curved.h) keeps what it
 * says, by 113-bit support functions along directions all over it, and covers what it says it covers; intervals are as
 * narrow as asked at 1e-6 and nearly to the last bit at 0, at random poses and at those where axes are parallel or one.
 */
#include "cases.h"
#include "oracle.h"

#include "narrow/convex/gjk.h"
#include "narrow/curved/curved.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { DOME_PAIRS = 400, DOME_DIRECTIONS = 40, INTERVAL_PAIRS = 40, SEARCH_EVERY = 20 };

static const shape_type OTHERS[] = {SHAPE_CAPSULE, SHAPE_BOX, SHAPE_CYLINDER, SHAPE_CONE, SHAPE_HULL};
enum { OTHER_COUNT = sizeof OTHERS / sizeof *OTHERS };

/* ---- domes ---- */

/* A unit vector at most so far from `middle`, as often near the rim as not. */
static vec3 direction_within(random_state *r, vec3 middle, double cosine)
{
    double c = random_unit(r) < 0.5 ? cosine : random_in(r, cosine, 1), s = sqrt(fmax(0, 1 - c * c));
    vec3 across = vec_unit(vec_cross(middle, random_direction(r)));
    return vec_unit(vec_madd(vec_scale(middle, c), s, across));
}

static bool raise_at(random_state *r, const unit_pair *p, vec3 near, dome *d)
{
    bundle pieces = {.count = 0};
    for (int i = 0; i < 3; i++) {
        minkowski m = unit_pair_nearest_along(p, vec_neg(direction_within(r, near, 0.95)));
        pieces_add(p, &pieces, &m);
    }
    return dome_raise(p, &pieces, near, 1e-6, d);
}

static void domes_are_nowhere_lower_than_they_say(void **state)
{
    (void)state;
    unsigned raised = 0;
    for (uint64_t seed = 1; seed <= DOME_PAIRS; seed++) {
        random_state r = {seed};
        shape a = random_shape(&r, seed & 1 ? SHAPE_CYLINDER : SHAPE_CONE);
        shape b = random_shape(&r, OTHERS[seed % OTHER_COUNT]);
        a.radius = b.radius = 0; /* a capsule's radius is not of its core */
        pose pa, pb;
        random_poses(&r, &a, &b, seed & 2 ? REGIME_SHALLOW : REGIME_DEEP, &pa, &pb);
        const pose b_in_a = pose_relative(pa, pb);
        unit_pair p;
        unit_pair_init(&p, &a, &b, &b_in_a);
        placed oa = oracle_place(&a, POSE_IDENTITY, VEC_ZERO), ob = oracle_place(&b, b_in_a, VEC_ZERO);
        for (int k = 0; k < 8; k++) {
            dome d;
            if (!raise_at(&r, &p, random_direction(&r), &d)) continue;
            raised++;
            for (int i = 0; i < DOME_DIRECTIONS; i++) {
                vec3 n = direction_within(&r, d.direction, d.cosine);
                double height = -(double)oracle_separation(&oa, &ob, real3_of(vec_neg(n))) * p.scale;
                if (height < d.depth - p.error)
                    fail_msg("seed %llu: %g below a dome of %g", (unsigned long long)seed, d.depth - height, d.depth);
            }
        }
    }
    assert_true(raised > DOME_PAIRS);
}

/* Of a triangle in front of the dome's middle: directions through it that the dome does not hold. */
static bool leaves_uncovered(random_state *r, const dome *d, const vec3 w[3], double depth)
{
    for (int i = 0; i < 400; i++) {
        double s = random_unit(r), t = random_unit(r);
        if (s + t > 1) s = 1 - s, t = 1 - t;
        vec3 n = vec_unit(vec_madd(vec_madd(vec_scale(w[0], 1 - s - t), s, w[1]), t, w[2]));
        bool lower = vec_dot(n, w[0]) < depth && vec_dot(n, w[1]) < depth && vec_dot(n, w[2]) < depth;
        if (lower && vec_dot(n, d->direction) < d->cosine - 1e-12) return true;
    }
    return false;
}

static void domes_cover_every_low_direction_through_a_triangle(void **state)
{
    (void)state;
    unsigned covered = 0, refused = 0;
    for (uint64_t seed = 1; seed <= 20000; seed++) {
        random_state r = {seed};
        dome d = {.direction = random_direction(&r), .cosine = random_in(&r, 0.5, 0.999), .depth = 1};
        vec3 w[3], normal, axis;
        double weight[3];
        for (int i = 0; i < 3; i++) w[i] = vec_scale(direction_within(&r, d.direction, 0.3), random_in(&r, 1, 3));
        double distance = triangle_nearest(w[0], w[1], w[2], weight, &normal, &axis);
        if (distance < d.depth && dome_covers(&d, w, vec_scale(axis, distance), d.depth, 1)) {
            covered++;
            assert_false(leaves_uncovered(&r, &d, w, d.depth));
        } else
            refused++;
    }
    assert_true(covered > 1000 && refused > 1000);
}

/* ---- intervals ---- */

static double size_of(const shape *a, pose pa, const shape *b, pose pb)
{
    return shape_reach(a) + shape_reach(b) + vec_norm(vec_sub(pb.p, pa.p));
}

static void check(const shape *a, pose pa, const shape *b, pose pb, double tolerance, bool search, uint64_t seed)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result x;
    narrow_query_world(a, pa, b, pb, &request, case_scratch(), &x);
    placed oa = oracle_place(a, pa, pa.p), ob = oracle_place(b, pb, pa.p);
    double size = size_of(a, pa, b, pb), wide = x.hi - x.lo;
    if (!(wide <= (tolerance > 0 ? tolerance : 1e-12 * size) && x.status == NARROW_CERTAIN))
        fail_msg("%s-%s, seed %llu: wide by %g", shape_type_name(a->type), shape_type_name(b->type),
            (unsigned long long)seed, wide);
    assert_true((double)oracle_separation(&oa, &ob, real3_of(x.axis)) >= x.lo);
    if (search && !((double)oracle_search(&oa, &ob) <= x.hi))
        fail_msg("%s-%s, seed %llu: a direction is beyond hi", shape_type_name(a->type), shape_type_name(b->type),
            (unsigned long long)seed);
    assert_true(oracle_outside(&oa, x.point_a) <= 1e-13 * size && oracle_outside(&ob, x.point_b) <= 1e-13 * size);
    double along = vec_dot(vec_sub(x.point_b, x.point_a), x.axis);
    if (x.hi < 0) assert_true(fabs(along - x.lo) <= 2 * wide + 1e-13 * size); /* the deepest points */
    if (x.lo > 0) assert_true(vec_norm(vec_sub(x.point_b, x.point_a)) <= x.hi * (1 + 1e-15));
}

static void check_both(const shape *a, pose pa, const shape *b, pose pb, bool search, uint64_t seed)
{
    check(a, pa, b, pb, 1e-6, search, seed);
    check(a, pa, b, pb, 0, search, seed);
}

static void random_intervals_are_as_narrow_as_asked(void **state)
{
    (void)state;
    for (unsigned k = 0; k < 2 * OTHER_COUNT; k++)
        for (uint64_t i = 0; i < INTERVAL_PAIRS; i++) {
            random_state r = {1000 * k + i};
            shape a = random_shape(&r, k & 1 ? SHAPE_CYLINDER : SHAPE_CONE), b = random_shape(&r, OTHERS[k / 2]);
            pose pa, pb;
            random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
            check_both(&a, pa, &b, pb, i % SEARCH_EVERY == 0, 1000 * k + i);
        }
}

/* Turns by quarters, and places on a grid: parallel axes, one axis, flat faces on each other, rims on edges. */
static void regular_poses_are_certified(void **state)
{
    (void)state;
    static const quat TURNS[] = {
        {1, 0, 0, 0}, {0, 1, 0, 0}, {M_SQRT1_2, M_SQRT1_2, 0, 0}, {M_SQRT1_2, 0, M_SQRT1_2, 0}, {0.5, 0.5, 0.5, 0.5}};
    static const double STEPS[] = {-2, -1, -0.75, -0.25, 0, 0.25, 0.5, 1, 1.5, 2};
    for (uint64_t seed = 0; seed < 1200; seed++) {
        random_state r = {seed};
        shape a = {.type = seed & 1 ? SHAPE_CYLINDER : SHAPE_CONE, .half = {0.5, 0.5, 1}};
        shape b = {.type = OTHERS[seed % (OTHER_COUNT - 1)], .half = {0.5, 0.5, 0.5}};
        if (b.type == SHAPE_CAPSULE) b.half = vec(0, 0, 0.5), b.radius = 0.25;
        vec3 at = vec(STEPS[random_bits(&r) % 10], STEPS[random_bits(&r) % 10], STEPS[random_bits(&r) % 10]);
        pose pb = {at, TURNS[seed % 5]};
        narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-6, .range = INFINITY};
        narrow_result x;
        narrow_query_world(&a, POSE_IDENTITY, &b, pb, &request, case_scratch(), &x);
        placed oa = oracle_place(&a, POSE_IDENTITY, VEC_ZERO), ob = oracle_place(&b, pb, VEC_ZERO);
        assert_true((double)oracle_separation(&oa, &ob, real3_of(x.axis)) >= x.lo);
        if (seed % SEARCH_EVERY == 0) assert_true((double)oracle_search(&oa, &ob) <= x.hi);
        if (!(x.hi - x.lo <= 1e-5 * size_of(&a, POSE_IDENTITY, &b, pb)))
            fail_msg("seed %llu: wide by %g", (unsigned long long)seed, x.hi - x.lo);
    }
}

/* A cylinder that lies on a plate but for 1e-12, as a pair on a lattice was: where the surface that the search grows is
 * thin, the nearest point of a facet was not found, and its depth told to be twice what it is. */
static void thin_facets_are_no_deeper_than_they_are(void **state)
{
    (void)state;
    static const double TOLERANCES[] = {0, 1e-12, 1e-11, 1e-9, 1e-6};
    const shape plate = {.type = SHAPE_BOX, .half = {1, 1, 0.25}},
                roll = {.type = SHAPE_CYLINDER, .half = {1, 1, 0.75}};
    const pose at = {{5.6100209372449377e-12, -7.8465782560255161e-12, 1.2500000000026379},
        {-0.27059805007596827, -0.27059805006557824, 0.65328148244323525, 0.65328148243506778}};
    placed a = oracle_place(&plate, POSE_IDENTITY, VEC_ZERO), b = oracle_place(&roll, at, VEC_ZERO);
    double upward = (double)oracle_separation(&a, &b, real3_of(vec(0, 0, 1)));
    for (size_t i = 0; i < sizeof TOLERANCES / sizeof *TOLERANCES; i++) {
        const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = TOLERANCES[i], .range = INFINITY};
        narrow_result r;
        narrow_query_world(&plate, POSE_IDENTITY, &roll, at, &request, case_scratch(), &r);
        assert_true(upward <= r.hi);
        check(&plate, POSE_IDENTITY, &roll, at, TOLERANCES[i], false, i);
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
        cmocka_unit_test(domes_are_nowhere_lower_than_they_say),
        cmocka_unit_test(domes_cover_every_low_direction_through_a_triangle),
        cmocka_unit_test(random_intervals_are_as_narrow_as_asked),
        cmocka_unit_test(regular_poses_are_certified),
        cmocka_unit_test(thin_facets_are_no_deeper_than_they_are),
    };
    return cmocka_run_group_tests(tests, create, destroy);
}
