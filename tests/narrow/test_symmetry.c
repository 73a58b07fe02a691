/* The same pair seen otherwise: turned as a whole, axes renamed, in a mirror, its corners in another order, far from
 * the origin. The signed distance must be the same, but for what the rounding of the new numbers moves: positions and
 * orientations are rounded once more where they are turned (`rounded`), which moves the shapes by that much. */
#include "samples.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

typedef void view(sample *s, random_state *r);

/* Two roundings of each coordinate, and of each number of the quaternion, which turns what is `reach` away. */
static const double ROUNDED = 6; /* ulp of the size of the whole, positions included */

static void turned(sample *s, random_state *r)
{
    quat q = random_rotation(r);
    pose *at[2] = {&s->pa, &s->pb};
    for (int i = 0; i < 2; i++) *at[i] = (pose){quat_rotate(q, at[i]->p), quat_mul(q, at[i]->q)};
}

/* x, y, z become y, z, x: a third of a turn about (1, 1, 1), whose quaternion is exact. */
static void renamed(sample *s, random_state *r)
{
    quat q = {0.5, 0.5, 0.5, 0.5};
    pose *at[2] = {&s->pa, &s->pb};
    (void)r;
    for (int i = 0; i < 2; i++) *at[i] = (pose){vec(at[i]->p.z, at[i]->p.x, at[i]->p.y), quat_mul(q, at[i]->q)};
}

static const hull *rebuilt(const hull *h, const uint32_t *order, double mirror)
{
    double points[3 * 64];
    hull *out;
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        uint32_t from = order ? order[i] : i;
        points[3 * i] = mirror * h->x[from], points[3 * i + 1] = h->y[from], points[3 * i + 2] = h->z[from];
    }
    assert_int_equal(hull_build(points, h->vertex_count, 0, &out), HULL_OK);
    return out;
}

/* In the mirror x = 0. Cones stand along z, which it leaves alone; half-spaces too; hulls are built anew. */
static void mirrored(sample *s, random_state *r)
{
    pose *at[2] = {&s->pa, &s->pb};
    shape *of[2] = {&s->a, &s->b};
    (void)r;
    for (int i = 0; i < 2; i++) {
        at[i]->p.x = -at[i]->p.x;
        at[i]->q.y = -at[i]->q.y;
        at[i]->q.z = -at[i]->q.z;
        if (of[i]->hull) of[i]->hull = rebuilt(of[i]->hull, NULL, -1);
    }
}

static void shuffled(sample *s, random_state *r)
{
    shape *of[2] = {&s->a, &s->b};
    for (int i = 0; i < 2; i++) {
        if (!of[i]->hull) continue;
        uint32_t order[64];
        for (uint32_t k = 0; k < of[i]->hull->vertex_count; k++) {
            uint32_t j = (uint32_t)(random_bits(r) % (k + 1));
            order[k] = order[j];
            order[j] = k;
        }
        of[i]->hull = rebuilt(of[i]->hull, order, 1);
    }
}

static void moved_far(sample *s, random_state *r)
{
    vec3 by = vec_scale(random_direction(r), 1000);
    s->pa.p = vec_add(s->pa.p, by);
    s->pb.p = vec_add(s->pb.p, by);
}

static void for_all(view *change, double whole, int first)
{
    unsigned count = samples_each();
    for (int ta = first; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = first; tb < SHAPE_CONVEX_COUNT; tb++)
            for (unsigned i = 0; i < count; i++) {
                sample s = sample_of(ta, tb, i), t = s;
                random_state r = {i + 1};
                change(&t, &r);
                narrow_result x = sample_ask(&s), y = sample_ask(&t);
                if (t.a.hull != s.a.hull) hull_destroy((hull *)(uintptr_t)t.a.hull);
                if (t.b.hull != s.b.hull) hull_destroy((hull *)(uintptr_t)t.b.hull);
                if (isinf(x.lo) && isinf(y.lo)) continue;
                double reaches = s.size + vec_norm(s.pa.p) + vec_norm(s.pb.p) + whole;
                double slack = sample_slack(&s, &x) + (whole < 0 ? 0 : ROUNDED * 0x1p-52 * reaches);
                double change_m = fabs(middle(&x) - middle(&y));
                if (!sample_agrees(&x, &y, slack))
                    fail_msg("%s: %.17g became %.17g: %g of what is allowed", sample_name(&s), middle(&x), middle(&y),
                        change_m / slack);
            }
}

static void the_same_turned_as_a_whole(void **state)
{
    (void)state;
    for_all(turned, 0, 0);
}

static void the_same_with_axes_renamed(void **state)
{
    (void)state;
    for_all(renamed, 0, 0);
}

static void the_same_in_a_mirror(void **state)
{
    (void)state;
    for_all(mirrored, -INFINITY, 0);
}

static void the_same_with_corners_in_another_order(void **state)
{
    (void)state;
    for_all(shuffled, -INFINITY, SHAPE_HULL);
}

static void the_same_a_kilometre_away(void **state)
{
    (void)state;
    for_all(moved_far, 1000, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_turned_as_a_whole),
        cmocka_unit_test(the_same_with_axes_renamed),
        cmocka_unit_test(the_same_in_a_mirror),
        cmocka_unit_test(the_same_with_corners_in_another_order),
        cmocka_unit_test(the_same_a_kilometre_away),
    };
    cases_create();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    cases_destroy();
    return failed;
}
