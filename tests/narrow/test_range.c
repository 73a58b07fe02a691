/* The ends of the range of doubles: the same pairs from sizes of 2^-1066, whose numbers are subnormal, to 2^480, whose
 * squares are just finite.
 *
 * As long as nothing that is put in is rounded, scaling by a power of two must change no bit but the scale. Where the
 * numbers themselves are rounded (below 2^-1022 each is a multiple of 2^-1074), the interval must still be one, hold
 * no NaN, and hold the scaled answer to within what the rounding of the shapes moves it. */
#include "samples.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static const double LEAST = 0x1p-1074;

static hull *scaled_hull(const hull *h, int power)
{
    double points[3 * 64];
    hull *out = NULL;
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        points[3 * i] = ldexp(h->x[i], power);
        points[3 * i + 1] = ldexp(h->y[i], power);
        points[3 * i + 2] = ldexp(h->z[i], power);
    }
    return hull_build(points, h->vertex_count, 0, &out) == HULL_OK ? out : NULL;
}

static bool scale_shape(shape *s, int power)
{
    s->radius = ldexp(s->radius, power);
    s->half = vec(ldexp(s->half.x, power), ldexp(s->half.y, power), ldexp(s->half.z, power));
    if (s->hull) s->hull = scaled_hull(s->hull, power);
    return !s->hull || s->hull->vertex_count;
}

static void scale_place(pose *at, int power)
{
    at->p = vec(ldexp(at->p.x, power), ldexp(at->p.y, power), ldexp(at->p.z, power));
}

/* Whether the scaled hulls could be built: of a few quanta they may be flat, and then there is nothing to ask. */
static bool scaled(const sample *s, int power, sample *out)
{
    *out = *s;
    scale_place(&out->pa, power);
    scale_place(&out->pb, power);
    scale_shape(&out->a, power);
    scale_shape(&out->b, power);
    return (!s->a.hull || out->a.hull) && (!s->b.hull || out->b.hull);
}

static void release(const sample *s)
{
    if (s->a.hull) hull_destroy((hull *)(uintptr_t)s->a.hull);
    if (s->b.hull) hull_destroy((hull *)(uintptr_t)s->b.hull);
}

typedef void judge(const sample *s, int power, const narrow_result *one, const narrow_result *other);

static void for_all(int from, int to, int step, judge *holds)
{
    unsigned count = samples_each() / 8;
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++)
            for (unsigned i = 0; i < count; i++) {
                sample s = sample_of(ta, tb, i);
                narrow_result one = sample_ask(&s);
                for (int power = from; power <= to; power += step) {
                    sample t;
                    if (scaled(&s, power, &t)) {
                        narrow_result other = sample_ask(&t);
                        holds(&s, power, &one, &other);
                    }
                    release(&t);
                }
            }
}

static bool same(double x, double y, int power)
{
    return ldexp(x, power) == y;
}

static void is_only_scaled(const sample *s, int power, const narrow_result *one, const narrow_result *other)
{
    bool axis = one->axis.x == other->axis.x && one->axis.y == other->axis.y && one->axis.z == other->axis.z;
    if (!axis || !same(one->lo, other->lo, power) || !same(one->hi, other->hi, power))
        fail_msg(
            "%s times 2^%d: [%a, %a] became [%a, %a]", sample_name(s), power, one->lo, one->hi, other->lo, other->hi);
}

static void scale_changes_no_bit_within_the_range(void **state)
{
    (void)state;
    for_all(-460, 460, 92, is_only_scaled);
}

static void is_an_answer(const sample *s, int power, const narrow_result *one, const narrow_result *other)
{
    if (isinf(one->lo) && isinf(other->lo)) return;
    if (!(other->lo <= other->hi)) fail_msg("%s times 2^%d: [%a, %a]", sample_name(s), power, other->lo, other->hi);
    double quanta = 24 * LEAST; /* each of the numbers of the two shapes and poses moves by at most one */
    double slack = quanta + ldexp(sample_slack(s, one), power);
    if (!(other->lo <= ldexp(one->hi, power) + slack && ldexp(one->lo, power) - slack <= other->hi))
        fail_msg("%s times 2^%d: [%a, %a] holds nothing of [%a, %a]", sample_name(s), power, other->lo, other->hi,
            ldexp(one->lo, power), ldexp(one->hi, power));
}

static void subnormal_and_huge_shapes_are_answered(void **state)
{
    (void)state;
    for_all(-1066, -1000, 11, is_an_answer);
    for_all(470, 490, 10, is_an_answer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(scale_changes_no_bit_within_the_range),
        cmocka_unit_test(subnormal_and_huge_shapes_are_answered),
    };
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
