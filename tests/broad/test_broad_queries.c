/* Box and ray queries against all stored boxes, and the ray test itself against a separating-axis test. */
#include "broad/tree.h"
#include "broad_world.h"

#include <string.h>

enum { PROXIES = 300, FLOOR = PROXIES, ALL = PROXIES + 1 };

typedef struct scene {
    broad *broad;
    double center;
    broad_stored stored[ALL];
    unsigned char visits[ALL];
    int left; /* visits until it says stop */
} scene;

static bool note(void *context, uint32_t proxy)
{
    scene *s = context;
    s->visits[proxy]++;
    return --s->left != 0;
}

static void build(scene *s, prng *r, double center)
{
    s->broad = broad_create(accept_all, NULL);
    s->center = center;
    vec3 offset = vec(center, center, center);
    for (uint32_t i = 0; i < PROXIES; i++) {
        vec3 half = vec(prng_between(r, 0, 1), prng_between(r, 0, 1), prng_between(r, 0, 1));
        aabb box = box_at(vec_add(offset, random_vec(r, 10)), half);
        broad_put(s->broad, &(broad_move){.proxy = i, .fixed = i % 2 == 0, .box = box, .margin = 0.05});
    }
    aabb ground = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, center - 9}};
    broad_put(s->broad, &(broad_move){.proxy = FLOOR, .fixed = true, .box = ground});
    broad_changes c;
    broad_update(s->broad, &c);
    for (uint32_t i = 0; i < ALL; i++) assert_true(broad_peek(s->broad, i, &s->stored[i]));
}

static void box_queries_equal_brute_force(void **state)
{
    (void)state;
    static const double centers[] = {0, -1e5, 1e12};
    static scene s;
    prng r = {1};
    for (int c = 0; c < 3; c++) {
        build(&s, &r, centers[c]);
        for (int i = 0; i < 2000; i++) {
            vec3 half = vec(prng_between(&r, 0, 2), prng_between(&r, 0, 2), prng_between(&r, 0, 2));
            vec3 at = vec_add(vec(s.center, s.center, s.center), random_vec(&r, 10));
            aabb query = box_at(at, half);
            memset(s.visits, 0, sizeof s.visits);
            s.left = -1;
            broad_query_box(s.broad, query, note, &s);
            for (uint32_t p = 0; p < ALL; p++)
                assert_int_equal(s.visits[p], aabb_overlap(fbox_aabb(&s.stored[p].fat), query));
        }
        broad_destroy(s.broad);
    }
}

static vec3 random_direction(prng *r)
{
    vec3 d = random_vec(r, 1);
    uint32_t kind = prng_below(r, 8); /* some along an axis, some in a plane of axes */
    if (kind < 2) d.x = 0;
    if (kind < 1) d.y = -0.0;
    return d;
}

static void ray_queries_equal_brute_force(void **state)
{
    (void)state;
    static scene s;
    prng r = {2};
    size_t met = 0;
    build(&s, &r, 100);
    for (int i = 0; i < 4000; i++) {
        vec3 from = vec_add(vec(s.center, s.center, s.center), random_vec(&r, 14)), d = random_direction(&r);
        double length = i % 3 == 0 ? INFINITY : prng_between(&r, 0, 30);
        memset(s.visits, 0, sizeof s.visits);
        s.left = -1;
        broad_query_ray(s.broad, from, d, length, note, &s);
        tree_ray ray = {{from.x, from.y, from.z}, {d.x, d.y, d.z}, length};
        for (uint32_t p = 0; p < ALL; p++) {
            assert_int_equal(s.visits[p], tree_ray_meets(&ray, &s.stored[p].fat));
            met += s.visits[p];
        }
    }
    assert_true(met > 2000);
    broad_destroy(s.broad);
}

static void a_visit_that_says_stop_is_the_last(void **state)
{
    (void)state;
    static scene s;
    prng r = {3};
    build(&s, &r, 0);
    aabb everything = cube_at(0, 0, 0, 100);
    for (int most = 1; most <= ALL; most += 50) {
        memset(s.visits, 0, sizeof s.visits);
        s.left = most;
        broad_query_box(s.broad, everything, note, &s);
        int visits = 0;
        for (uint32_t p = 0; p < ALL; p++) visits += s.visits[p];
        assert_int_equal(visits, most);
    }
    broad_destroy(s.broad);
}

/* By how much a segment and a box are apart along their best separating axis (Ericson, Real-Time Collision Detection,
 * 5.3.3): negative when they meet. The axes are the box's and their products with the segment, made unit vectors. */
static double separation(vec3 from, vec3 to, const fbox *box)
{
    aabb b = fbox_aabb(box);
    vec3 half = vec_scale(vec_sub(b.hi, b.lo), 0.5), center = vec_scale(vec_add(b.hi, b.lo), 0.5);
    vec3 arm = vec_scale(vec_sub(to, from), 0.5), middle = vec_sub(vec_scale(vec_add(from, to), 0.5), center);
    const vec3 axes[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, vec_unit(vec(0, arm.z, -arm.y)),
        vec_unit(vec(arm.z, 0, -arm.x)), vec_unit(vec(arm.y, -arm.x, 0))};
    double best = -INFINITY;
    for (int i = 0; i < 6; i++) {
        vec3 n = axes[i];
        if (vec_norm2(n) == 0) continue;
        double reach = half.x * fabs(n.x) + half.y * fabs(n.y) + half.z * fabs(n.z) + fabs(vec_dot(arm, n));
        best = fmax(best, fabs(vec_dot(middle, n)) - reach);
    }
    return best;
}

static void the_ray_test_agrees_with_separating_axes(void **state)
{
    (void)state;
    prng r = {4};
    int met = 0, missed = 0;
    for (int i = 0; i < 100000; i++) {
        vec3 half = vec(prng_between(&r, 0, 1), prng_between(&r, 0, 1), prng_between(&r, 0, 1));
        fbox box = fbox_outward(box_at(random_vec(&r, 0.5), half));
        vec3 from = random_vec(&r, 1), d = random_direction(&r);
        double length = prng_between(&r, 0, 4), apart = separation(from, vec_madd(from, length, d), &box);
        tree_ray ray = {{from.x, from.y, from.z}, {d.x, d.y, d.z}, length};
        bool meets = tree_ray_meets(&ray, &box);
        if (apart < -1e-12) assert_true(meets);
        if (apart > 1e-12) assert_false(meets);
        met += meets;
        missed += !meets;
    }
    assert_true(met > 10000 && missed > 10000);
}

/* Rays that enter by one face where they leave by another. Oracle: the two parameters in extended precision, where they
 * are clear; a double alone cannot tell them apart. */
static void a_ray_that_grazes_an_edge_is_not_lost(void **state)
{
    (void)state;
    prng r = {5};
    const fbox box = fbox_outward((aabb){{1, 0, -1}, {2, 1, 1}});
    int grazes = 0;
    for (int i = 0; i < 100000; i++) {
        tree_ray ray = {{prng_between(&r, -1, 0), 0, 0}, {prng_between(&r, 0.5, 1), prng_between(&r, 0.5, 1), 0}, 100};
        double at = (1 - ray.from[0]) / ray.direction[0];
        ray.from[1] = (1 - ray.direction[1] * at) * (1 + ((int)prng_below(&r, 9) - 4) * 0x1p-53);
        long double enter = (1.0L - ray.from[0]) / ray.direction[0], leave = (1.0L - ray.from[1]) / ray.direction[1];
        if (enter > leave - 0x1p-60L) continue;
        assert_true(tree_ray_meets(&ray, &box));
        grazes++;
    }
    assert_true(grazes > 10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_queries_equal_brute_force),
        cmocka_unit_test(ray_queries_equal_brute_force),
        cmocka_unit_test(a_visit_that_says_stop_is_the_last),
        cmocka_unit_test(the_ray_test_agrees_with_separating_axes),
        cmocka_unit_test(a_ray_that_grazes_an_edge_is_not_lost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
