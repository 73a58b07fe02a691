/* The time of impact against dense sampling of certified distances: what is called free is free, nothing touches before
 * lo, and at hi it does; for every two convex types, straight, turning, spinning and grazing, in one go or in pieces.
 */
#include "cases.h"
#include "narrow/toi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum { PAIRS_EACH = 12, SAMPLES = 160 }; /* COLLIDED_NIGHTLY: 100 times as many pairs */

typedef struct scene {
    const char *name;
    double turn; /* rad, the most over the span */
    bool aimed;  /* at each other */
} scene;

static const scene SCENES[] = {{"straight", 0, true}, {"turning", 0.7, true}, {"half a turn", 3, true},
    {"spinning", 60, true}, {"passing", 0.3, false}};

typedef struct sample {
    toi_mover a, b;
    toi_request request;
    double size;
} sample;

static narrow_result measure_at(const sample *s, double time, double tolerance)
{
    narrow_request r = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    pose a = pose_mul(motion_pose(&s->a.motion, time), s->a.local);
    pose b = pose_mul(motion_pose(&s->b.motion, time), s->b.local);
    narrow_result result;
    narrow_query_world(s->a.shape, a, s->b.shape, b, &r, case_scratch(), &result);
    return result;
}

static pose random_local(random_state *r, const shape *s)
{
    if (random_unit(r) < 0.5 || s->type == SHAPE_HALFSPACE) return POSE_IDENTITY;
    return (pose){vec_scale(random_direction(r), random_in(r, 0, 1)), random_rotation(r)};
}

static vec3 random_spin(random_state *r, double turn)
{
    return random_unit(r) < 0.25 ? VEC_ZERO : vec_scale(random_direction(r), random_in(r, 0, turn));
}

/* B flies past or through A, from one side to the other, in one second. */
static void make(random_state *r, const shape *a, const shape *b, const scene *how, sample *s)
{
    double ra = isfinite(shape_reach(a)) ? shape_reach(a) : 1, rb = isfinite(shape_reach(b)) ? shape_reach(b) : 1;
    double clear = random_in(r, 0.6, 2) * (ra + rb), far = 2 * clear;
    vec3 from = vec_scale(random_direction(r), far), aim = vec_scale(random_direction(r), how->aimed ? 0 : clear);
    vec3 common = vec_scale(random_direction(r), random_in(r, 0, 5));
    s->a = (toi_mover){
        a, random_local(r, a), {{random_direction(r), random_rotation(r)}, common, random_spin(r, how->turn)}};
    s->b = (toi_mover){b, random_local(r, b),
        {{vec_add(s->a.motion.start.p, from), random_rotation(r)}, VEC_ZERO, random_spin(r, how->turn)}};
    vec3 through = vec_scale(vec_sub(aim, from), random_in(r, 0.5, 2.5));
    s->b.motion.linear = vec_add(common, through);
    s->size = ra + rb + far;
    s->request = (toi_request){.span = 1, .threshold = 0, .tolerance = 1e-7 * s->size};
}

typedef struct tally {
    uint32_t count[4], queries, queries_most;
    double width;
} tally;

static void fail_at(const char *why, const sample *s, uint64_t seed, const toi_result *t, double time, double gap)
{
    fail_msg("%s: %s-%s, seed %llu: %s [%.17g, %.17g], at %.17g the distance is %g", why,
        shape_type_name(s->a.shape->type), shape_type_name(s->b.shape->type), (unsigned long long)seed,
        toi_status_name(t->status), t->lo, t->hi, time, gap);
}

static void check(const sample *s, uint64_t seed, tally *count)
{
    toi_result t;
    toi_find(&s->a, &s->b, &s->request, VEC_ZERO, case_scratch(), &t);
    double rounding = 1e-13 * s->size, end = fmin(t.lo, s->request.span);
    for (int k = 0; k < SAMPLES && end > 0; k++) {
        double time = end * k / SAMPLES;
        narrow_result n = measure_at(s, time, 1e-9 * s->size);
        if (n.hi <= -rounding) fail_at("it touches before", s, seed, &t, time, n.hi);
    }
    if (t.status == TOI_HIT) {
        if (!(t.lo <= t.hi && t.hi <= s->request.span)) fail_at("no bracket", s, seed, &t, t.hi, 0);
        narrow_result n = measure_at(s, t.hi, 1e-9 * s->size);
        if (n.lo > rounding) fail_at("it does not touch at hi", s, seed, &t, t.hi, n.lo);
        count->width = fmax(count->width, t.hi - t.lo);
    }
    if (t.status != TOI_FREE) {
        narrow_result n = measure_at(s, t.lo, 0);
        if (n.lo > t.gap_hi + rounding || n.hi < t.gap_lo - rounding) fail_at("gap", s, seed, &t, t.lo, n.lo);
    }
    if (t.status == TOI_UNDECIDED) fail_at("undecided", s, seed, &t, t.lo, 0);
    count->count[t.status]++;
    count->queries += t.queries;
    if (t.queries > count->queries_most) count->queries_most = t.queries;
}

static void nothing_is_missed_and_nothing_is_late(void **state)
{
    (void)state;
    int pairs = getenv("COLLIDED_NIGHTLY") ? 100 * PAIRS_EACH : PAIRS_EACH;
    for (size_t k = 0; k < sizeof SCENES / sizeof *SCENES; k++) {
        tally t = {.queries = 0};
        uint32_t all = 0;
        for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
            for (int tb = ta; tb < SHAPE_CONVEX_COUNT; tb++)
                for (int i = 0; i < pairs; i++) {
                    if (ta == SHAPE_HALFSPACE && tb == SHAPE_HALFSPACE) continue;
                    uint64_t seed = (((uint64_t)k * 16 + (uint64_t)ta) * 16 + (uint64_t)tb) * 100000 + (uint64_t)i;
                    random_state r = {seed};
                    shape a = random_shape(&r, (shape_type)ta), b = random_shape(&r, (shape_type)tb);
                    bool ordered = narrow_ordered(&a, 0, &b, 1);
                    sample s;
                    make(&r, ordered ? &a : &b, ordered ? &b : &a, &SCENES[k], &s);
                    check(&s, seed, &t);
                    all++;
                }
        print_message(
            "%-12s %5u pairs: %u free, %u hit, %u near; %.2f distances a pair, at most %u; brackets to %.2g s\n",
            SCENES[k].name, all, t.count[TOI_FREE], t.count[TOI_HIT], t.count[TOI_NEAR], (double)t.queries / all,
            t.queries_most, t.width);
        assert_true(t.count[TOI_HIT] > all / 20);
        assert_true(t.count[TOI_FREE] > all / 20);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(nothing_is_missed_and_nothing_is_late)};
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
