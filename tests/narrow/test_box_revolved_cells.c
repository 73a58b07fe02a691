/* The bounds of arcs in narrow/curved/great_arc.c and narrow/curved/box_revolved.c, which are compiled in here: along
 * no direction of an arc of a great circle do the cores overlap by less, by 113-bit support functions; random arcs of
 * all sizes and of both pieces. And what the whole search rests on: no direction at all is below what it proves. */
#define box_revolved_measure the_copy_under_test
#include "narrow/curved/box_revolved.c" /* NOLINT(bugprone-suspicious-include): its inside is what is tested */
#include "narrow/curved/great_arc.c"    /* NOLINT(bugprone-suspicious-include): its inside is what is tested */

#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { PAIRS = 2000, ARCS = 12, DIRECTIONS = 20 };

typedef struct pair {
    shape a, b;
    unit_pair p;
    placed oa, ob;
} pair;

static void prepare(pair *x, random_state *r, uint64_t seed)
{
    static const quat LYING = {M_SQRT1_2, M_SQRT1_2, 0, 0};
    pose pa, pb;
    x->a = random_shape(r, SHAPE_BOX);
    x->b = random_shape(r, seed & 1 ? SHAPE_CYLINDER : SHAPE_CONE);
    x->a.radius = x->b.radius = 0;
    random_poses(r, &x->a, &x->b, seed % 3 ? REGIME_DEEP : REGIME_SHALLOW, &pa, &pb);
    pose b_in_a = pose_relative(pa, pb);
    if (seed % 7 == 0) b_in_a.q = LYING;            /* the axis in a face */
    if (seed % 11 == 0) b_in_a.q = POSE_IDENTITY.q; /* along an edge */
    if (seed % 13 == 0) b_in_a.q = quat_unit((quat){b_in_a.q.w, b_in_a.q.x, b_in_a.q.y, b_in_a.q.z + 1e-9});
    unit_pair_init(&x->p, &x->a, &x->b, &b_in_a);
    x->oa = oracle_place(&x->a, POSE_IDENTITY, VEC_ZERO);
    x->ob = oracle_place(&x->b, b_in_a, VEC_ZERO);
}

static double overlap(const pair *x, vec3 axis)
{
    return -(double)oracle_separation(&x->oa, &x->ob, real3_of(axis)) * x->p.scale;
}

static vec3 in_space(const quadrant *q, plane2 n)
{
    return vec_madd(vec_scale(q->along[0], n.x), n.y, q->along[1]);
}

static plane2 at_angle(double angle)
{
    return (plane2){cos(angle), sin(angle)};
}

/* Two directions of a quadrant: its ends now and then; close together as often as not. */
static void random_arc(random_state *r, double *from, double *to)
{
    double a = random_bits(r) % 3 ? random_in(r, 0, M_PI_2) : 0,
           b = random_bits(r) % 3 ? random_in(r, a, M_PI_2) : M_PI_2;
    if (random_bits(r) & 1) b = a + random_unit(r) * random_unit(r) * (b - a);
    *from = a;
    *to = b;
}

static unsigned check_arc(random_state *r, const pair *x, const scene *c, uint64_t seed)
{
    arc_search s = {.size = c->p->size, .least = INFINITY, .proved = INFINITY, .enough = INFINITY};
    unsigned bits = (unsigned)random_bits(r), near = 0;
    quadrant q = quadrant_of(c, (int)(bits % 3), bits & 64 ? -1 : 1, bits & 128 ? -1 : 1);
    double slope = bits & 256 && !c->b.cone ? c->b.h : -c->b.h, from, to;
    random_arc(r, &from, &to);
    arc a = {.a = arc_tip(&q, slope, at_angle(from)), .b = arc_tip(&q, slope, at_angle(to))};
    bound_arc(&s, &q, &a);
    if (!(cross2(a.a.n, a.at) >= -1e-12 && cross2(a.at, a.b.n) >= -1e-12))
        fail_msg("seed %zu: cut outside", (size_t)seed);
    for (int k = 0; k <= DIRECTIONS; k++) {
        double h = overlap(x, in_space(&q, at_angle(from + (to - from) * k / DIRECTIONS)));
        if (h < a.bound - x->p.error) fail_msg("seed %zu: %g below", (size_t)seed, a.bound - h);
        near += h < a.bound + 1e-3;
    }
    return near;
}

static void no_direction_is_below_its_arc(void **state)
{
    (void)state;
    unsigned near = 0;
    for (uint64_t seed = 0; seed < PAIRS; seed++) {
        random_state r = {seed};
        pair x;
        prepare(&x, &r, seed);
        scene c = box_revolved_scene_of(&x.p);
        for (int i = 0; i < ARCS; i++) near += check_arc(&r, &x, &c, seed) > 0;
    }
    assert_true(near > PAIRS * ARCS / 10);
}

/* All over the sphere, and beside the least that was found: there the least of others would show. */
static void no_direction_is_below_what_is_proved(void **state)
{
    (void)state;
    unsigned deep = 0;
    const narrow_goal finest = {.far = INFINITY, .near = -INFINITY, .above = -INFINITY, .below = INFINITY};
    for (uint64_t seed = 0; seed < PAIRS; seed++) {
        random_state r = {seed};
        pair x;
        prepare(&x, &r, seed);
        scene c = box_revolved_scene_of(&x.p);
        search wide = {&c, arc_search_of(&x.p, &finest)}, narrow = wide;
        bool found = box_revolved_find_depth(&wide, lanes_wide());
        if (box_revolved_find_depth(&narrow, false) != found) fail_msg("seed %zu: another answer", (size_t)seed);
        if (!found) continue;
        const arc_search s = wide.found, other = narrow.found;
        assert_true(s.least == other.least && s.proved == other.proved && s.steps == other.steps);
        assert_true(vec_norm2(vec_sub(s.axis, other.axis)) == 0);
        double proved = min_of(s.proved, s.least) - NOISE * UNIT_ROUNDOFF * x.p.size - x.p.error;
        deep += overlap(&x, s.axis) - proved < 1e-12;
        for (int k = 0; k < DIRECTIONS; k++) {
            vec3 m = random_direction(&r);
            if (k & 1) m = vec_unit(vec_madd(s.axis, random_unit(&r) * random_unit(&r), m));
            double h = overlap(&x, m);
            if (h < proved) fail_msg("seed %zu: %g below", (size_t)seed, proved - h);
        }
    }
    assert_true(deep > PAIRS / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_direction_is_below_its_arc), cmocka_unit_test(no_direction_is_below_what_is_proved)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
