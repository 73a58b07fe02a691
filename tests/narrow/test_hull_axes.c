/* hull_axes: what it answers is, to the bit, what the search finds that hulls without a map are left to; and which
 * hulls have a map. That depths are true is asked of narrow_query by test_narrow_polytopes, in 113 bits. */
#include "cases.h"
#include "geom/hull_map.h"
#include "narrow/convex/near_features.h"
#include "narrow/convex/polytopes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { POINTS_MOST = 48 };

/* A thirtieth of them in CI, all with COLLIDED_NIGHTLY=1 in the environment, few with COLLIDED_BRIEF=1. */
static size_t test_size(size_t nightly)
{
    return getenv("COLLIDED_NIGHTLY") ? nightly : nightly / (getenv("COLLIDED_BRIEF") ? 200 : 30);
}

static hull *build(const vec3 *points, size_t count)
{
    hull *h = NULL;
    assert_int_equal(hull_build(&points->x, count, 0, &h), HULL_OK);
    return h;
}

static vec3 scaled(vec3 half, vec3 v)
{
    return vec(half.x * v.x, half.y * v.y, half.z * v.z);
}

/* Points on an ellipsoid, anywhere near the origin. */
static hull *ball(random_state *r, size_t count)
{
    vec3 points[POINTS_MOST], half = vec(random_in(r, 0.3, 1), random_in(r, 0.3, 1), random_in(r, 0.3, 1));
    vec3 centre = vec_scale(random_direction(r), random_in(r, 0, 0.5));
    for (size_t i = 0; i < count; i++) points[i] = vec_add(centre, scaled(half, random_direction(r)));
    return build(points, count);
}

/* Opposite points in pairs: opposite faces and edges are parallel. */
static hull *symmetric(random_state *r, size_t count)
{
    vec3 points[POINTS_MOST];
    for (size_t i = 0; i + 1 < count; i += 2) {
        points[i] = random_direction(r);
        points[i + 1] = vec_neg(points[i]);
    }
    return build(points, count / 2 * 2);
}

/* A few pairs of points that almost coincide: needles among the faces, short edges. */
static hull *chipped(random_state *r, size_t count)
{
    vec3 points[POINTS_MOST];
    double by = pow(2, random_in(r, -40, -3));
    for (size_t i = 0; i < count; i++)
        points[i] = i % 3 ? random_direction(r) : vec_add(points[i ? i - 1 : 0], vec_scale(random_direction(r), by));
    points[0] = random_direction(r);
    return build(points, count);
}

static hull *octahedron(void)
{
    static const vec3 POINTS[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
    return build(POINTS, 6);
}

static hull *random_hull(random_state *r, int kind)
{
    size_t count = 4 + random_bits(r) % 29;
    if (kind == 1) return symmetric(r, count + 4);
    if (kind == 2) return chipped(r, count + 4);
    return kind == 3 ? octahedron() : ball(r, count);
}

/* Some turned by little, so that what is parallel is so almost. */
static pose random_place(random_state *r, int kind)
{
    vec3 at = vec_scale(random_direction(r), random_in(r, 0.02, 1.8));
    double angle = pow(2, random_in(r, -45, 0));
    if (kind == 0) return (pose){at, random_rotation(r)};
    if (kind == 1) return (pose){at, {1, 0, 0, 0}};
    return (pose){at, quat_unit((quat){1, angle * random_unit(r), angle * random_unit(r), angle})};
}

/* Does hull_axes answer? */
static bool answers(const shape *a, const shape *b, const pose *at, const narrow_request *request, span *out)
{
    unit_pair p;
    unit_pair_init(&p, a, b, at);
    double tolerance = request->tolerance * p.scale - 2 * p.error - p.excess;
    narrow_goal goal = {.tolerance = tolerance, .far = INFINITY, .near = -INFINITY};
    if (!near_features_reach_depths(&p, &goal) || !hull_axes_apply(&p)) return false;
    return hull_axes_depth(&p, &goal, out);
}

static void ask(const shape *a, const shape *b, const pose *at, const narrow_request *request, narrow_result *out)
{
    memset(out, 0, sizeof *out);
    narrow_query(a, b, at, request, NULL, case_scratch(), out);
}

/* With the maps, and without them. */
static bool compare(hull *a, hull *b, const pose *at)
{
    shape sa = {.type = SHAPE_HULL, .hull = a}, sb = {.type = SHAPE_HULL, .hull = b};
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result with, without;
    span by_axes;
    bool answered = answers(&sa, &sb, at, &request, &by_axes);
    ask(&sa, &sb, at, &request, &with);
    hull_map *map_a = a->map, *map_b = b->map;
    a->map = b->map = NULL;
    ask(&sa, &sb, at, &request, &without);
    a->map = map_a;
    b->map = map_b;
    assert_memory_equal(&with, &without, sizeof with);
    return answered;
}

static void answers_what_the_search_answers(void **state)
{
    (void)state;
    random_state r = {61};
    size_t asked[4] = {0}, answered[4] = {0}, rounds = test_size(20000);
    for (size_t i = 0; i < rounds; i++) {
        int kind = (int)(i % 4);
        hull *a = random_hull(&r, kind), *b = random_hull(&r, i % 8 < 4 ? kind : 0);
        for (int k = 0; k < 20; k++) {
            pose at = random_place(&r, kind == 0 ? 0 : k % 3);
            asked[kind]++;
            answered[kind] += compare(a, b, &at);
        }
        hull_destroy(a);
        hull_destroy(b);
    }
    for (int kind = 0; kind < 4; kind++) assert_true(20 * answered[kind] > asked[kind]);
    assert_true(5 * answered[0] > 2 * asked[0]); /* a part of the rest is apart */
}

/* A cube's faces have four corners; a plate is too sharp; a large hull has too many points. */
static void only_small_hulls_of_triangles_have_a_map(void **state)
{
    (void)state;
    random_state r = {62};
    static const vec3 CUBE[8] = {
        {-1, -1, -1}, {-1, -1, 1}, {-1, 1, -1}, {-1, 1, 1}, {1, -1, -1}, {1, -1, 1}, {1, 1, -1}, {1, 1, 1}};
    static const vec3 PLATE[5] = {{1, 1, 0}, {1, -1, 0}, {-1, -1, 0}, {-1, 1, 0}, {0, 0, 1e-3}};
    static const vec3 NEEDLE[5] = {{1, 0, 0}, {-1, 0.5, 0.1}, {-1, -0.5, 0.1}, {0, 0, 1}, {0x1p-30, 0, 1}};
    hull *many = ball(&r, HULL_MAP_VERTICES_MAX + 1), *few = ball(&r, HULL_MAP_VERTICES_MAX), *one;
    assert_null(many->map);
    assert_non_null(few->map);
    assert_true(few->map->padded_faces >= (int)few->face_count && few->map->padded_faces <= HULL_MAP_FACES_MAX);
    assert_true(few->map->padded_arcs >= (int)few->edge_count && few->map->padded_arcs <= HULL_MAP_ARCS_MAX);
    one = build(CUBE, 8);
    assert_null(one->map);
    hull_destroy(one);
    one = build(PLATE, 5);
    assert_null(one->map);
    hull_destroy(one);
    one = build(NEEDLE, 5);
    assert_null(one->map);
    hull_destroy(one);
    hull_destroy(many);
    hull_destroy(few);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_what_the_search_answers),
        cmocka_unit_test(only_small_hulls_of_triangles_have_a_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
