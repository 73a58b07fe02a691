/* What must hold between times of impact: the same verdict for every split of the span, the same bits at every scale
 * and place, with any guess, and with room left for acceleration (wander) no accelerated motion touches before. */
#include "toi_pairs.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum {
    SPLITS = 1500,
    SCALED = 1500,
    WANDERING = 600,
    GUESSED = 1500,
    SAMPLES = 60
}; /* COLLIDED_NIGHTLY: 20 times as many */

static uint64_t times(uint64_t count)
{
    return getenv("COLLIDED_NIGHTLY") ? 20 * count : count;
}

static bool same(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

/* ---- splits ---- */

static motion from_then_on(const motion *m, double time)
{
    return (motion){motion_pose(m, time), m->linear, m->angular};
}

/* The first of the pieces that is not free, *from = when it begins; TOI_FREE: all are. */
static toi_result in_pieces(const toi_pair *p, int pieces, double *from)
{
    toi_result t = {.status = TOI_FREE};
    for (int k = 0; k < pieces && t.status == TOI_FREE; k++) {
        *from = p->request.span * k / pieces;
        toi_mover a = p->a, b = p->b;
        a.motion = from_then_on(&p->a.motion, *from);
        b.motion = from_then_on(&p->b.motion, *from);
        toi_request r = p->request;
        r.span = p->request.span * (k + 1) / pieces - *from;
        toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
    }
    return t;
}

/* Whether a touch of less than the tolerance is a contact may depend on where the steps fall. */
static bool within_tolerance(const toi_pair *p, const toi_result *whole)
{
    if (whole->status == TOI_NEAR) return true;
    toi_truth e = toi_truth_of(&p->a, &p->b, p->request.span, case_scratch());
    if (e.verdict != TRUTH_HIT) return e.nearest <= 2 * p->request.tolerance;
    for (int k = 1; k <= 200; k++) /* a contact that goes deeper must be found by all */
        if (toi_truth_at(&p->a, &p->b, fmin(e.hi + 0.005 * k, p->request.span), 0, case_scratch()).hi <
            -2 * p->request.tolerance)
            return false;
    return true;
}

static void every_split_gives_the_same_verdict(void **state)
{
    (void)state;
    static const int PIECES[] = {1, 2, 3, 7};
    uint32_t excused = 0, hits = 0;
    uint64_t count = times(SPLITS);
    for (uint64_t i = 0; i < count; i++) {
        toi_pair p;
        toi_pair_any(0x5911700000 + i, &toi_manners[i % TOI_MANNERS], &p);
        toi_result whole = toi_pair_find(&p);
        hits += whole.status == TOI_HIT;
        for (size_t k = 0; k < sizeof PIECES / sizeof *PIECES; k++) {
            double from = 0;
            toi_result part = in_pieces(&p, PIECES[k], &from);
            bool agrees = part.status == whole.status;
            if (agrees && whole.status == TOI_HIT) /* the brackets share the contact: they overlap */
                agrees = from + part.lo <= whole.hi + 1e-12 && from + part.hi >= whole.lo - 1e-12;
            if (agrees) continue;
            if (!within_tolerance(&p, &whole))
                fail_msg("pair %llu in %d pieces: %s [%.17g, %.17g], whole: %s [%.17g, %.17g]", (unsigned long long)i,
                    PIECES[k], toi_status_name(part.status), from + part.lo, from + part.hi,
                    toi_status_name(whole.status), whole.lo, whole.hi);
            excused++;
        }
    }
    print_message("%llu pairs, %u hits; %u splits differ where the touch is less than the tolerance\n",
        (unsigned long long)count, hits, excused);
    assert_true(hits > count / 4);
    assert_true(excused <= count / 200);
}

/* ---- scale and place ---- */

static shape scaled_shape(const shape *s, double by)
{
    shape out = *s;
    out.radius *= by;
    out.half = vec_scale(s->half, by);
    return out;
}

static toi_mover scaled(const toi_mover *m, const shape *s, double by)
{
    toi_mover out = *m;
    out.shape = s;
    out.local.p = vec_scale(m->local.p, by);
    out.motion.start.p = vec_scale(m->motion.start.p, by);
    out.motion.linear = vec_scale(m->motion.linear, by);
    return out;
}

static void check_scaled(const toi_pair *p, const toi_result *one, int exponent)
{
    double by = ldexp(1, exponent);
    shape a = scaled_shape(&p->shapes[0], by), b = scaled_shape(&p->shapes[1], by);
    toi_mover ma = scaled(&p->a, &a, by), mb = scaled(&p->b, &b, by);
    toi_request r = p->request;
    r.tolerance *= by;
    toi_result t, expected = *one;
    toi_find(&ma, &mb, &r, VEC_ZERO, case_scratch(), &t);
    assert_int_equal(t.status, expected.status);
    assert_true(same(&t.lo, &expected.lo, sizeof t.lo) && same(&t.hi, &expected.hi, sizeof t.hi));
    assert_int_equal(t.queries, expected.queries);
    if (t.status == TOI_FREE) return;
    assert_true(t.gap_lo == by * expected.gap_lo && t.gap_hi == by * expected.gap_hi);
    assert_true(same(&t.axis, &expected.axis, sizeof t.axis));
    assert_true(t.closing == by * expected.closing);
    vec3 pa = vec_scale(expected.point_a, by), pb = vec_scale(expected.point_b, by);
    assert_true(same(&t.point_a, &pa, sizeof pa) && same(&t.point_b, &pb, sizeof pb));
}

static double on_grid(double x)
{
    return nearbyint(x * 0x1p20) * 0x1p-20;
}

static vec3 vec_on_grid(vec3 v)
{
    return vec(on_grid(v.x), on_grid(v.y), on_grid(v.z));
}

/* Only how near it is to the origin changes: what rounds with the place (the points) is not looked at. */
static void check_shifted(toi_pair *p, vec3 by)
{
    p->a.motion.start.p = vec_on_grid(p->a.motion.start.p);
    p->b.motion.start.p = vec_on_grid(p->b.motion.start.p);
    toi_result here = toi_pair_find(p);
    p->a.motion.start.p = vec_add(p->a.motion.start.p, by);
    p->b.motion.start.p = vec_add(p->b.motion.start.p, by);
    toi_result there = toi_pair_find(p);
    assert_int_equal(here.status, there.status);
    assert_true(same(&here.lo, &there.lo, sizeof here.lo) && same(&here.hi, &there.hi, sizeof here.hi));
    if (here.status == TOI_FREE) return;
    assert_true(here.gap_lo == there.gap_lo && here.gap_hi == there.gap_hi && here.closing == there.closing);
    assert_true(same(&here.axis, &there.axis, sizeof here.axis));
}

static void scale_and_place_change_no_bit(void **state)
{
    (void)state;
    static const int EXPONENTS[] = {-40, -7, 1, 30};
    uint32_t hits = 0;
    for (uint64_t i = 0; i < times(SCALED); i++) {
        toi_pair p;
        toi_pair_any(0x5ca1e00000 + i, &toi_manners[i % TOI_MANNERS], &p);
        bool hulls = p.shapes[0].type == SHAPE_HULL || p.shapes[1].type == SHAPE_HULL;
        toi_result one = toi_pair_find(&p);
        hits += one.status == TOI_HIT;
        for (size_t k = 0; k < sizeof EXPONENTS / sizeof *EXPONENTS && !hulls; k++)
            check_scaled(&p, &one, EXPONENTS[k]);
        check_shifted(&p, vec(1024, -77, 65536));
    }
    assert_true(hits > times(SCALED) / 4);
}

/* ---- wander ---- */

/* Where all of B's points are besides, relative to A, for an acceleration that changes its mind at `turn`. */
static vec3 wandered(vec3 first, vec3 then, double turn, double time)
{
    if (time <= turn) return vec_scale(first, 0.5 * time * time);
    double rest = time - turn;
    vec3 at_turn = vec_madd(vec_scale(first, 0.5 * turn * turn), turn * rest, first);
    return vec_madd(at_turn, 0.5 * rest * rest, then);
}

static void accelerated_motions_do_not_touch_before(void **state)
{
    (void)state;
    uint32_t ended = 0, frees = 0;
    for (uint64_t i = 0; i < times(WANDERING); i++) {
        toi_pair p;
        toi_pair_any(0x3a0de00000 + i, &toi_manners[i % TOI_MANNERS], &p);
        random_state r = {i};
        p.request.wander = random_in(&r, 0, 0.5) * p.size;
        toi_result t = toi_pair_find(&p);
        assert_true(t.status == TOI_FREE || t.status == TOI_NEAR);
        ended += t.status == TOI_NEAR, frees += t.status == TOI_FREE;
        double end = fmin(t.lo, p.request.span), turn = random_in(&r, 0, end);
        vec3 towards = t.status == TOI_FREE ? random_direction(&r) : vec_neg(t.axis);
        vec3 first = vec_scale(towards, p.request.wander), then = vec_scale(random_direction(&r), p.request.wander);
        for (int k = 0; k < SAMPLES && end > 0; k++) {
            double time = end * k / SAMPLES;
            toi_mover moved = p.b;
            moved.motion.start.p = vec_add(moved.motion.start.p, wandered(first, i % 2 ? first : then, turn, time));
            double gap = toi_truth_at(&p.a, &moved, time, 1e-9 * p.size, case_scratch()).hi;
            if (gap <= -1e-13 * p.size)
                fail_msg("pair %llu: at %g, before %g, it is %g", (unsigned long long)i, time, t.lo, gap);
        }
    }
    print_message("%u free, %u end\n", frees, ended);
    assert_true(ended > times(WANDERING) / 4 && frees > times(WANDERING) / 20);
}

/* The bound is used up, not only kept: towards each other at full acceleration they meet soon after. */
static void the_room_for_acceleration_is_what_it_says(void **state)
{
    (void)state;
    shape ball = {.type = SHAPE_SPHERE, .radius = 1};
    toi_mover a = {&ball, POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, VEC_ZERO}}, b = a;
    b.motion.start.p.x = 4;
    toi_request r = {.span = 10, .tolerance = 1e-9, .wander = 1};
    toi_result t;
    toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
    assert_int_equal(t.status, TOI_NEAR);
    assert_true(t.lo <= 2 && t.lo > 2 - 1e-6); /* 2 m at 1 m/s^2 */
    r.span = 1.999;
    toi_find(&a, &b, &r, VEC_ZERO, case_scratch(), &t);
    assert_int_equal(t.status, TOI_FREE);
}

/* ---- guesses ---- */

static bool same_answer(const toi_result *x, const toi_result *y)
{
    if (x->status != y->status || !same(&x->lo, &y->lo, sizeof x->lo) || !same(&x->hi, &y->hi, sizeof x->hi))
        return false;
    if (x->status == TOI_FREE) return true;
    return x->gap_lo == y->gap_lo && x->gap_hi == y->gap_hi && x->closing == y->closing &&
           same(&x->axis, &y->axis, sizeof x->axis) && same(&x->point_a, &y->point_a, sizeof x->point_a) &&
           same(&x->point_b, &y->point_b, sizeof x->point_b) && same(&x->body_a, &y->body_a, sizeof x->body_a) &&
           same(&x->body_b, &y->body_b, sizeof x->body_b);
}

/* A cache may change the time, never the answer: with the axes of the least distances at several times, of what passes
 * by closely, slowly or at a thousand sizes a second. */
static void a_guess_changes_no_answer(void **state)
{
    (void)state;
    static const double SPEEDS[] = {0.01, 1, 1, 1000};
    uint32_t frees = 0, believed = 0;
    for (uint64_t i = 0; i < times(GUESSED); i++) {
        toi_pair p;
        toi_pair_any(0x6e55000000 + i, &toi_manners[i % TOI_MANNERS], &p);
        p.b.motion.linear = vec_scale(p.b.motion.linear, SPEEDS[i / TOI_MANNERS % 4]);
        p.request.wander = i % 7 == 0 ? 0.1 * p.size : 0;
        toi_result cold = toi_pair_find(&p);
        frees += cold.status == TOI_FREE;
        for (int k = 0; k <= 4; k++) {
            toi_result t;
            vec3 guess = toi_truth_at(&p.a, &p.b, 0.25 * k, 1e-9 * p.size, case_scratch()).axis;
            toi_find(&p.a, &p.b, &p.request, guess, case_scratch(), &t);
            if (!same_answer(&cold, &t))
                fail_msg("pair %llu: %s [%.17g, %.17g] becomes %s [%.17g, %.17g]", (unsigned long long)i,
                    toi_status_name(cold.status), cold.lo, cold.hi, toi_status_name(t.status), t.lo, t.hi);
            believed += t.queries < cold.queries && t.queries == 0;
        }
    }
    print_message("%u free, %u guesses spared a search\n", frees, believed);
    assert_true(frees > times(GUESSED) / 8 && believed > times(GUESSED) / 60);
}

/* A cylinder that slides by over another: a guess is believed where what it keeps is above a 400th of the way, so that
 * a search surely ends with the same. */
static void a_guess_is_believed_where_a_search_surely_ends(void **state)
{
    (void)state;
    static const double GAPS[] = {0.0026, 0.0024}; /* of a way of 1 m */
    shape round = {.type = SHAPE_CYLINDER, .half = {0.1, 0.1, 0.1}};
    for (size_t i = 0; i < sizeof GAPS / sizeof *GAPS; i++) {
        toi_mover a = {&round, POSE_IDENTITY, {POSE_IDENTITY, VEC_ZERO, VEC_ZERO}}, b = a;
        b.motion = (motion){{{-0.5, 0, 0.2 + GAPS[i]}, POSE_IDENTITY.q}, {1, 0, 0}, VEC_ZERO};
        toi_request r = {.span = 1, .tolerance = 1e-6};
        toi_result t;
        toi_find(&a, &b, &r, vec(0, 0, 1), case_scratch(), &t);
        assert_int_equal(t.status, TOI_FREE);
        assert_int_equal(t.queries == 0, GAPS[i] * 400 > 1);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_guess_changes_no_answer),
        cmocka_unit_test(a_guess_is_believed_where_a_search_surely_ends),
        cmocka_unit_test(every_split_gives_the_same_verdict),
        cmocka_unit_test(scale_and_place_change_no_bit),
        cmocka_unit_test(accelerated_motions_do_not_touch_before),
        cmocka_unit_test(the_room_for_acceleration_is_what_it_says),
    };
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
