/* Two balls against the root of the quadratic in 113 bits. */
#include "cases.h"
#include "oracle/quad.h"
#include "toi/toi.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { PAIRS = 20000 };

/* The first time within the span at which the centres are so near; infinite: never. Positions may turn with the bodies
 * only about the centres. */
static quad first_contact(vec3 from, vec3 velocity, quad reach, quad span)
{
    const double f[3] = {from.x, from.y, from.z}, v[3] = {velocity.x, velocity.y, velocity.z};
    quad far2 = 0, approach = 0, speed2 = 0;
    for (int k = 0; k < 3; k++) {
        far2 += (quad)f[k] * f[k];
        approach += (quad)f[k] * v[k];
        speed2 += (quad)v[k] * v[k];
    }
    quad spare = far2 - reach * reach, square = approach * approach - speed2 * spare;
    if (spare <= 0) return 0;
    if (approach >= 0 || square < 0) return INFINITY;
    quad time = spare / (q_sqrt(square) - approach);
    return time <= span ? time : INFINITY;
}

static void balls_meet_when_the_quadratic_says(void **state)
{
    (void)state;
    int hits = 0, free = 0, searched = 0;
    double scale = 1;
    for (int i = 0; i < PAIRS; i++) {
        random_state r = {(uint64_t)i};
        if (i % 4 == 0) scale = i % 8 ? 0x1p-40 : 0x1p40;
        if (i % 4 == 1) scale = 1;
        shape a = {.type = SHAPE_SPHERE, .radius = scale * random_in(&r, 0, 1)};
        shape b = {.type = SHAPE_SPHERE, .radius = scale * random_in(&r, 0.01, 1)};
        vec3 from = vec_scale(random_direction(&r), scale * random_in(&r, 1, 6));
        vec3 aim = vec_scale(random_direction(&r), scale * random_in(&r, 0, 2.5));
        vec3 velocity = vec_scale(vec_sub(aim, from), random_in(&r, 0.3, 3));
        vec3 spin = vec_scale(random_direction(&r), random_in(&r, 0, 30));
        toi_mover ma = {&a, {VEC_ZERO, random_rotation(&r)}, {POSE_IDENTITY, VEC_ZERO, spin}};
        toi_mover mb = {&b, POSE_IDENTITY, {{from, random_rotation(&r)}, velocity, VEC_ZERO}};
        toi_request request = {.span = 1, .tolerance = 1e-9 * scale};
        toi_result t;
        quad truth = first_contact(from, velocity, (quad)a.radius + b.radius, 1);
        toi_find(&ma, &mb, &request, VEC_ZERO, case_scratch(), &t);
        searched += t.queries > 0;
        if (t.status == TOI_FREE) {
            assert_true(isinf((double)truth));
            free++;
        } else {
            assert_true((quad)t.lo <= truth);
            assert_true(!isinf((double)truth) || t.status == TOI_NEAR);
            if (t.status == TOI_HIT) assert_true((quad)t.hi >= truth);
            hits += t.status == TOI_HIT;
        }
        if (t.status == TOI_HIT && t.hi > 0) {
            double gap = vec_norm(vec_sub(t.point_b, t.point_a));
            assert_true(gap <= t.gap_hi + 1e-14 * scale * 10 && t.closing >= 0);
        }
    }
    assert_true(hits > PAIRS / 4 && free > PAIRS / 8);
    assert_true(searched < PAIRS / 10); /* those that touch at the beginning, graze, or meet at the very end */
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(balls_meet_when_the_quadratic_says)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
