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
    double length;
} scene;

static bool note(void *context, uint32_t proxy)
{
    scene *s = context;
    s->visits[proxy]++;
    return --s->left != 0;
}

static void build(scene *s, prng *r, double center)
{
    s->broad = make_broad(accept_all, NULL);
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

static tree_ray ray_of(vec3 from, vec3 d, double length)
{
    return (tree_ray){{from.x, from.y, from.z}, {from.x, from.y, from.z}, {d.x, d.y, d.z}, length};
}

/* Relative slack for rounding: each of the two ends has a difference and a quotient, so 2^-52 each; this is four times
 * their sum. It is applied outward only, so a segment that meets a box is never said to miss it. */
static const double RAY_SLACK = 0x1p-49;

/* Slabs in doubles, widened by the moving box (Minkowski sum): what the walk in floats is held to. */
static bool ray_meets(const tree_ray *ray, const fbox *box)
{
    double near = 0, far = ray->length;
    for (int k = 0; k < 3; k++) {
        double ahead = box->lo[k] - ray->hi[k], behind = box->hi[k] - ray->lo[k], d = ray->direction[k];
        if (d == 0) {
            if (ahead > 0 || behind < 0) return false;
            continue;
        }
        double enter = (d > 0 ? ahead : behind) / d, leave = (d > 0 ? behind : ahead) / d;
        if (enter > near) near = enter;
        if (leave < far) far = leave;
    }
    return near <= far + far * RAY_SLACK;
}

static double note_on_way(void *context, uint32_t proxy)
{
    return note(context, proxy) ? ((scene *)context)->length : -1;
}

/* The box grown by what the walk's floats may add: each that meets is visited once, none that misses the grown one. */
static void check_visits(const scene *s, const tree_ray *ray)
{
    for (uint32_t p = 0; p < ALL; p++) {
        fbox grown = s->stored[p].fat;
        double far = 200 * vec_norm(vec(ray->direction[0], ray->direction[1], ray->direction[2])) + fabs(s->center);
        for (int k = 0; k < 3; k++) {
            grown.lo[k] = float_down(grown.lo[k] - far * 0x1p-19);
            grown.hi[k] = float_up(grown.hi[k] + far * 0x1p-19);
        }
        if (ray_meets(ray, &s->stored[p].fat)) assert_int_equal(s->visits[p], 1);
        if (!ray_meets(ray, &grown)) assert_int_equal(s->visits[p], 0);
    }
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
        s.length = length;
        broad_query_cast(s.broad, (aabb){from, from}, d, length, note_on_way, &s);
        tree_ray ray = ray_of(from, d, length);
        check_visits(&s, &ray);
        for (uint32_t p = 0; p < ALL; p++) met += s.visits[p];
    }
    assert_true(met > 2000);
    broad_destroy(s.broad);
}

/* The length at which a ray enters a box, by bisection of the test in doubles; INFINITY: never. */
static double entry(tree_ray ray, const fbox *box)
{
    double lo = 0, hi = 100;
    ray.length = hi;
    if (!ray_meets(&ray, box)) return INFINITY;
    for (int i = 0; i < 60; i++) {
        ray.length = 0.5 * (lo + hi);
        *(ray_meets(&ray, box) ? &hi : &lo) = ray.length;
    }
    return hi;
}

typedef struct first_search {
    const scene *s;
    tree_ray ray;
    double best;
    size_t visits;
} first_search;

static double shorten(void *context, uint32_t proxy)
{
    first_search *f = context;
    f->visits++;
    return f->best = fmin(f->best, entry(f->ray, &f->s->stored[proxy].fat));
}

/* Rays that start in corners of boxes, along their faces and edges, and near and far from the origin. */
static void the_first_box_is_found_while_the_way_is_made_shorter(void **state)
{
    (void)state;
    static const double centers[] = {0, -1e5, 1e7};
    static scene s;
    prng r = {8};
    size_t hits = 0, visits = 0, all = 0;
    for (int c = 0; c < 3; c++) {
        build(&s, &r, centers[c]);
        for (int i = 0; i < 1000; i++) {
            vec3 from = vec_add(vec(s.center, s.center, s.center), random_vec(&r, 14)), d = random_direction(&r);
            aabb other = fbox_aabb(&s.stored[prng_below(&r, PROXIES)].fat);
            if (i % 4 == 1) from.y = other.lo.y, d.y = 0;
            if (i % 4 == 2) d = vec_sub(other.hi, from);
            if (i % 4 == 3) from = vec(other.lo.x, other.hi.y, other.lo.z - 3), d = vec(0, 0, 1);
            d = vec_unit(d);
            first_search f = {.s = &s, .ray = ray_of(from, d, 100), .best = INFINITY};
            double truth = INFINITY;
            for (uint32_t p = 0; p < ALL; p++) {
                double t = entry(f.ray, &s.stored[p].fat);
                truth = fmin(truth, t);
                all += t < INFINITY;
            }
            broad_query_cast(s.broad, (aabb){from, from}, d, 100, shorten, &f);
            assert_true(f.best == truth);
            hits += truth < INFINITY;
            visits += f.visits;
        }
        if (broad_index_kind(s.broad) == BROAD_TREE) assert_true(visits < all); /* what lies behind is left out */
        broad_destroy(s.broad);
    }
    assert_true(hits > 1500);
}

/* Oracle: the box at a hundred places of its way. What it meets there must be visited; what is visited, it must nearly
 * meet between two of them. */
static void a_cast_finds_what_the_moving_box_meets(void **state)
{
    (void)state;
    enum { CASTS = 300, PLACES = 100 };
    static scene s;
    prng r = {6};
    size_t met = 0, unmet = 0;
    build(&s, &r, 100);
    for (int i = 0; i < CASTS; i++) {
        vec3 at = vec_add(vec(s.center, s.center, s.center), random_vec(&r, 14)), d = random_direction(&r);
        aabb box = box_at(at, vec(prng_between(&r, 0, 1), prng_between(&r, 0, 1), prng_between(&r, 0, 1)));
        double length = prng_between(&r, 0, 20), between = length / PLACES * vec_norm(d);
        memset(s.visits, 0, sizeof s.visits);
        s.left = -1;
        s.length = length;
        broad_query_cast(s.broad, box, d, length, note_on_way, &s);
        for (uint32_t p = 0; p < ALL; p++) {
            bool meets = false, nearly = false;
            aabb fat = fbox_aabb(&s.stored[p].fat);
            for (int k = 0; k <= PLACES; k++) {
                vec3 step = vec_scale(d, length * k / PLACES);
                aabb moved = {vec_add(box.lo, step), vec_add(box.hi, step)};
                meets |= aabb_overlap(aabb_grow(moved, -1e-9), fat);
                nearly |= aabb_overlap(aabb_grow(moved, between + 1e-3), fat); /* the walk's floats */
            }
            if (meets) assert_int_equal(s.visits[p], 1);
            if (!nearly) assert_int_equal(s.visits[p], 0);
            met += meets;
            unmet += !nearly;
        }
    }
    assert_true(met > CASTS && unmet > CASTS);
    broad_destroy(s.broad);
}

/* ---- nearest ---- */

typedef struct nearest {
    const scene *s;
    aabb from;
    double last, reach;
    size_t visits, most;
    unsigned char seen[ALL];
} nearest;

static double distance_between(aabb a, aabb b)
{
    double x = fmax(0, fmax(a.lo.x - b.hi.x, b.lo.x - a.hi.x)), y = fmax(0, fmax(a.lo.y - b.hi.y, b.lo.y - a.hi.y));
    double z = fmax(0, fmax(a.lo.z - b.hi.z, b.lo.z - a.hi.z));
    return vec_norm(vec(x, y, z));
}

static double near_visit(void *context, uint32_t proxy, double distance)
{
    nearest *n = context;
    double exact = distance_between(n->from, fbox_aabb(&n->s->stored[proxy].fat));
    assert_true(distance <= exact && distance >= exact * (1 - 1e-12));
    assert_true(distance >= n->last && distance <= n->reach);
    assert_int_equal(n->seen[proxy]++, 0);
    n->last = distance;
    return ++n->visits == n->most ? -1 : n->reach;
}

static void nearest_come_first_and_none_is_left_out(void **state)
{
    (void)state;
    static scene s;
    prng r = {7};
    build(&s, &r, 0);
    for (int i = 0; i < 1000; i++) {
        nearest n = {.s = &s, .reach = i % 5 ? prng_between(&r, 0, 10) : INFINITY};
        n.most = i % 3 ? SIZE_MAX : 1 + prng_below(&r, 20);
        n.from = box_at(random_vec(&r, 12), i % 2 ? VEC_ZERO : vec(0.3, 0.5, 0.1));
        broad_query_nearest(s.broad, n.from, n.reach, near_visit, &n);
        bool cut = n.visits == n.most;
        for (uint32_t p = 0; p < ALL; p++) {
            double exact = distance_between(n.from, fbox_aabb(&s.stored[p].fat));
            if (exact <= n.reach && (!cut || exact < n.last)) assert_int_equal(n.seen[p], 1);
        }
        assert_true(n.visits > 0 || n.reach < 10);
    }
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
    memset(s.visits, 0, sizeof s.visits);
    s.left = 2, s.length = INFINITY;
    broad_query_cast(s.broad, everything, vec(1, 0, 0), INFINITY, note_on_way, &s);
    int visits = 0;
    for (uint32_t p = 0; p < ALL; p++) visits += s.visits[p];
    assert_int_equal(visits, 2);
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
        tree_ray ray = ray_of(from, d, length);
        bool meets = ray_meets(&ray, &box);
        tree_slabs slabs = tree_slabs_of(&ray);
        bool visited = tree_slabs_meet(&slabs, &box);
        if (meets) assert_true(visited);
        if (apart > 1e-5) assert_false(visited);
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
        vec3 from = vec(prng_between(&r, -1, 0), 0, 0), d = vec(prng_between(&r, 0.5, 1), prng_between(&r, 0.5, 1), 0);
        from.y = (1 - d.y * ((1 - from.x) / d.x)) * (1 + ((int)prng_below(&r, 9) - 4) * 0x1p-53);
        long double enter = (1.0L - from.x) / d.x, leave = (1.0L - from.y) / d.y;
        if (enter > leave - 0x1p-60L) continue;
        tree_ray ray = ray_of(from, d, 100);
        tree_slabs slabs = tree_slabs_of(&ray);
        assert_true(ray_meets(&ray, &box) && tree_slabs_meet(&slabs, &box));
        grazes++;
    }
    assert_true(grazes > 10000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(box_queries_equal_brute_force),
        cmocka_unit_test(ray_queries_equal_brute_force),
        cmocka_unit_test(the_first_box_is_found_while_the_way_is_made_shorter),
        cmocka_unit_test(a_cast_finds_what_the_moving_box_meets),
        cmocka_unit_test(nearest_come_first_and_none_is_left_out),
        cmocka_unit_test(a_visit_that_says_stop_is_the_last),
        cmocka_unit_test(the_ray_test_agrees_with_separating_axes),
        cmocka_unit_test(a_ray_that_grazes_an_edge_is_not_lost),
    };
    return run_with_each_index(tests);
}
