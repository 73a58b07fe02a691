/* The bounds of the cells in narrow/curved/revolved_pair.c, which is compiled in here: along no direction whose cosines
 * are in a cell do the cores overlap by less, by 113-bit support functions; random cells of all sizes, and directions
 * on their rims as often as inside. What flat ends are said to hold, they hold. */
#define revolved_pair_measure the_copy_under_test
#include "narrow/curved/revolved_pair.c" /* NOLINT(bugprone-suspicious-include): its inside is what is tested */

#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { PAIRS = 1500, CELLS = 8, DIRECTIONS = 24 };

static const shape_type KINDS[] = {SHAPE_CAPSULE, SHAPE_CYLINDER, SHAPE_CONE};

typedef struct pair {
    shape a, b;
    unit_pair p;
    placed oa, ob;
} pair;

static void prepare(pair *x, random_state *r, uint64_t seed)
{
    pose pa, pb;
    x->a = random_shape(r, KINDS[seed % 3]);
    x->b = random_shape(r, KINDS[seed / 3 % 3]);
    x->a.radius = x->b.radius = 0;
    random_poses(r, &x->a, &x->b, REGIME_DEEP, &pa, &pb);
    const pose b_in_a = pose_relative(pa, pb);
    unit_pair_init(&x->p, &x->a, &x->b, &b_in_a);
    x->oa = oracle_place(&x->a, POSE_IDENTITY, VEC_ZERO);
    x->ob = oracle_place(&x->b, b_in_a, VEC_ZERO);
}

static double overlap(const pair *x, vec3 axis)
{
    return -(double)oracle_separation(&x->oa, &x->ob, real3_of(axis)) * x->p.scale;
}

/* On one side of the kink; now and then up to it, or to an end. */
static void random_strip(random_state *r, const outline *o, mark *from, mark *to)
{
    bool upper = random_bits(r) & 1;
    double lo = upper ? o->kink : -1, hi = upper ? 1 : o->kink;
    double a = random_bits(r) % 3 ? random_in(r, lo, hi) : lo, b = random_bits(r) % 3 ? random_in(r, lo, hi) : hi;
    if (random_bits(r) & 1) b = a + 0.05 * (b - a);
    *from = mark_at(o, min_of(a, b));
    *to = mark_at(o, max_of(a, b));
}

static double random_cosine(random_state *r, const mark *from, const mark *to)
{
    unsigned kind = random_bits(r) % 4;
    return kind == 0 ? from->v : kind == 1 ? to->v : random_in(r, from->v, to->v);
}

static void no_direction_is_below_its_cell(void **state)
{
    (void)state;
    unsigned tried = 0, near = 0;
    for (uint64_t seed = 0; seed < PAIRS; seed++) {
        random_state r = {seed};
        pair x;
        prepare(&x, &r, seed);
        scene c = revolved_scene_of(&x.p);
        if (!(c.s > PARALLEL)) continue;
        for (int i = 0; i < CELLS; i++) {
            cell q;
            random_strip(&r, &c.a, &q.x1, &q.x2);
            random_strip(&r, &c.b, &q.y1, &q.y2);
            if (!(q.x1.v < q.x2.v && q.y1.v < q.y2.v)) continue;
            bound_cell(&c, &q);
            for (int k = 0; k < DIRECTIONS; k++) {
                double at_x = random_cosine(&r, &q.x1, &q.x2), at_y = random_cosine(&r, &q.y1, &q.y2);
                double e = (at_y - c.g * at_x) / c.s;
                if (at_x * at_x + e * e > 1) continue;
                double h = overlap(&x, direction_at(&c, at_x, at_y));
                if (h < q.bound - x.p.error) fail_msg("seed %llu: %g below", (unsigned long long)seed, q.bound - h);
                tried++;
                near += h < q.bound + 0.02;
            }
        }
    }
    assert_true(tried > PAIRS && near > PAIRS / 10);
}

static void a_flat_end_holds_what_it_says(void **state)
{
    (void)state;
    unsigned tried = 0;
    for (uint64_t seed = 0; seed < PAIRS; seed++) {
        random_state r = {seed};
        pair x;
        prepare(&x, &r, seed);
        double side = random_bits(&r) & 1 ? 1 : -1;
        vec3 n = vec(0, 0, side);
        outline o = outline_of(&x.p.a);
        end e = end_of(&o, side, n, unit_pair_support_b(&x.p, vec_neg(n), NULL));
        double level = e.h * random_in(&r, 0.3, 1);
        if (!(level > 0)) continue;
        double cosine = outline_reach_of(&e, level);
        for (int k = 0; k < DIRECTIONS && cosine < 1; k++) {
            double z = k % 2 ? cosine : random_in(&r, cosine, 1), s = sqrt(1 - z * z);
            vec3 d = random_direction(&r), across = vec_unit(vec(d.x, d.y, 0));
            double h = overlap(&x, vec_unit(vec(s * across.x, s * across.y, side * z)));
            if (h < level - x.p.error) fail_msg("seed %llu: %g below", (unsigned long long)seed, level - h);
            tried++;
        }
    }
    assert_true(tried > PAIRS);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_direction_is_below_its_cell),
        cmocka_unit_test(a_flat_end_holds_what_it_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
