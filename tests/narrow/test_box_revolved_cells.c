/* The bounds of the cells in narrow/box_revolved.c, which is compiled in here: along no direction of an octant whose
 * cosine is in a strip do the cores overlap by less, by 113-bit support functions; random strips of all sizes, and
 * directions on faces and rims as often as inside; the same bits in wide and in narrow registers. */
#define box_revolved_measure the_copy_under_test
#include "narrow/box_revolved.c" /* NOLINT(bugprone-suspicious-include): its inside is what is tested */

#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

enum { PAIRS = 1500, CELLS = 8, DIRECTIONS = 60 };

typedef struct pair {
    shape a, b;
    unit_pair p;
    placed oa, ob;
} pair;

static void prepare(pair *x, random_state *r, uint64_t seed)
{
    pose pa, pb;
    x->a = random_shape(r, SHAPE_BOX);
    x->b = random_shape(r, seed & 1 ? SHAPE_CYLINDER : SHAPE_CONE);
    x->a.radius = x->b.radius = 0;
    random_poses(r, &x->a, &x->b, REGIME_DEEP, &pa, &pb);
    pose b_in_a = pose_relative(pa, pb);
    if (seed % 7 == 0) b_in_a.q = (quat){M_SQRT1_2, M_SQRT1_2, 0, 0}; /* the axis in a face */
    unit_pair_init(&x->p, &x->a, &x->b, &b_in_a);
    x->oa = oracle_place(&x->a, POSE_IDENTITY, VEC_ZERO);
    x->ob = oracle_place(&x->b, b_in_a, VEC_ZERO);
}

static double overlap(const pair *x, vec3 axis)
{
    return -(double)oracle_separation(&x->oa, &x->ob, real3_of(axis)) * x->p.scale;
}

static void random_strip(random_state *r, const outline *o, mark *from, mark *to)
{
    bool upper = random_bits(r) & 1;
    double lo = upper ? o->kink : -1, hi = upper ? 1 : o->kink;
    double a = random_bits(r) % 3 ? random_in(r, lo, hi) : lo, b = random_bits(r) % 3 ? random_in(r, lo, hi) : hi;
    if (random_bits(r) & 1) b = a + 0.05 * (b - a);
    *from = mark_at(o, min_of(a, b));
    *to = mark_at(o, max_of(a, b));
}

/* In the octant n >= 0; as often as not on a face, now and then at a corner or at a rim of the strip. */
static vec3 random_in_octant(random_state *r, vec3 u, const mark *rim)
{
    vec3 n = magnitudes(random_direction(r));
    unsigned kind = random_bits(r) % 8;
    if (kind < 3 || kind == 6) *(kind % 3 == 0 ? &n.x : kind == 1 ? &n.y : &n.z) = 0;
    if (kind == 3) n = vec(0, 0, 1);
    n = vec_unit(n);
    if (kind < 5) return n;
    vec3 beside = vec_unit(vec_madd(n, -vec_dot(n, u), u)); /* turned towards u, or away, up to the rim */
    return vec_madd(vec_scale(u, rim->v), rim->sine, beside);
}

static void no_direction_is_below_its_cell(void **state)
{
    (void)state;
    unsigned tried = 0, near = 0;
    for (uint64_t seed = 0; seed < PAIRS; seed++) {
        random_state r = {seed};
        pair x;
        prepare(&x, &r, seed);
        scene c = scene_of(&x.p);
        for (int i = 0; i < CELLS; i++) {
            search s = {.scene = &c, .least = INFINITY, .proved = INFINITY, .enough = INFINITY, .wide = lanes_wide()};
            cell q = {.sign = {i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1}}, other;
            random_strip(&r, &c.b, &q.y1, &q.y2);
            if (!(q.y1.v < q.y2.v)) continue;
            other = q;
            bool any = bound_cell(&s, &q);
            search narrow = {.scene = &c, .least = INFINITY, .proved = INFINITY, .enough = INFINITY};
            assert_true(bound_cell(&narrow, &other) == any && (!any || other.bound == q.bound));
            vec3 u = times(q.sign, c.u);
            for (int k = 0; k < DIRECTIONS; k++) {
                vec3 n = random_in_octant(&r, u, k & 1 ? &q.y1 : &q.y2);
                double y = vec_dot(n, u);
                if (n.x < 0 || n.y < 0 || n.z < 0 || y < q.y1.v || y > q.y2.v) continue;
                if (!any) fail_msg("seed %llu: a direction in an empty cell", (unsigned long long)seed);
                double h = overlap(&x, times(q.sign, n));
                if (h < q.bound - x.p.error) fail_msg("seed %llu: %g below", (unsigned long long)seed, q.bound - h);
                tried++;
                near += h < q.bound + 0.02;
            }
        }
    }
    assert_true(tried > PAIRS && near > PAIRS / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(no_direction_is_below_its_cell)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
