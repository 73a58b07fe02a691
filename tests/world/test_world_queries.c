/* Queries against closed forms. */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static uint32_t add(world *w, const char *name, shape s, vec3 at, const filter_rule *rule)
{
    world_shape one = {.shape = s, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &one,
        .shape_count = 1,
        .rules = rule,
        .rule_count = rule != NULL,
        .stamp_ns = SECOND};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static const shape BALL = {.type = SHAPE_SPHERE, .radius = 1};
static const shape CUBE = {.type = SHAPE_BOX, .half = {1, 1, 1}};

static void distance_brackets_the_truth_at_any_distance_from_the_origin(void **state)
{
    (void)state;
    for (double far = 0; far <= 1e12; far = far ? far * 1000 : 1) {
        world *w = scene_world(1, true);
        uint32_t a = add(w, "a", BALL, vec(far, 0, 0), NULL), b = add(w, "b", CUBE, vec(far, 4, 0), NULL);
        scene_tick(w, 2LL * SECOND);
        world_hits hits = {0};
        world_query_distance(w, a, b, 1e-9, 3LL * SECOND, &hits);
        assert_int_equal(hits.count, 1);
        assert_true(hits.at[0].lo <= 2 && 2 <= hits.at[0].hi && hits.at[0].hi - hits.at[0].lo <= 1e-9);
        assert_true(hits.at[0].axis.y > 0.999999);
        assert_int_equal(hits.at[0].age_ns, 2LL * SECOND);
        free(hits.at);
        world_destroy(w);
    }
}

/* Two bodies whose shapes lie off their origins and turned: what is answered of them does not depend on where they are,
 * as long as their positions are exact. The poses of the shapes in the world are not. */
typedef struct answers {
    double lo[5], hi[5];
} answers;

static answers ask_at(double far, int seed)
{
    world *w = scene_world(1, true);
    answers got;
    uint32_t ids[2];
    for (int i = 0; i < 2; i++) {
        double x = 0.3 + 0.01 * seed, y = 0.7 - 0.013 * seed;
        world_shape s = {.shape = i ? CUBE : BALL, .local = {{x, y, -0.37}, quat_unit((quat){1, y, x, 0.3})}};
        world_body def = {.name = i ? "b" : "a",
            .group = "",
            .category = 1,
            .mask = 1,
            .pose = {{far + 6 * i, far - 2 * i, i}, quat_unit((quat){x, 0.2, -0.5, y})},
            .shapes = &s,
            .shape_count = 1,
            .stamp_ns = SECOND};
        ids[i] = WORLD_NONE;
        assert_int_equal(world_put_body(w, &ids[i], &def), WORLD_OK);
    }
    scene_tick(w, 2LL * SECOND);
    const vec3 half = {0.1, 0.2, 0.3}, from = {far - 10, far, 0}, towards = {1, -0.1, 0};
    for (int k = 0; k < 5; k++) {
        world_hits hits = {0};
        if (k == 0) world_query_distance(w, ids[0], ids[1], 1e-9, 3LL * SECOND, &hits);
        if (k == 1) world_query_nearest_to(w, ids[1], INFINITY, 1, 1e-9, 3LL * SECOND, &hits);
        if (k == 2) world_query_ray(w, from, towards, INFINITY, 1e-9, 3LL * SECOND, &hits);
        if (k == 3) world_query_cast(w, (pose){from, {1, 0, 0, 0}}, half, towards, INFINITY, 1e-9, 3LL * SECOND, &hits);
        if (k == 4) world_query_nearest(w, (pose){from, {1, 0, 0, 0}}, half, INFINITY, 1, 1e-9, 3LL * SECOND, &hits);
        got.lo[k] = hits.count ? hits.at[0].lo : -1; /* the ray may miss */
        got.hi[k] = hits.count ? hits.at[0].hi : -1;
        free(hits.at);
    }
    world_destroy(w);
    return got;
}

static void answers_are_the_same_everywhere(void **state)
{
    (void)state;
    for (int seed = 0; seed < 20; seed++) {
        answers here = ask_at(0, seed);
        for (double far = 0x1p10; far <= 0x1p40; far *= 0x1p10) {
            answers there = ask_at(far, seed);
            for (int k = 0; k < 5; k++)
                if (here.lo[k] != there.lo[k] || here.hi[k] != there.hi[k])
                    fail_msg("query %d, seed %d: [%.17g, %.17g], at %g m [%.17g, %.17g]", k, seed, here.lo[k],
                        here.hi[k], far, there.lo[k], there.hi[k]);
        }
    }
}

/* A ray that grazes a ball, and shortly after meets another one or none, made before or after it. */
static world_hit graze(double y, double x, bool before)
{
    world *w = scene_world(1, true);
    const shape small = {.type = SHAPE_SPHERE, .radius = 0.1};
    if (x > 0 && before) add(w, "small", small, vec(x + 0.1, 0, 0), NULL);
    add(w, "grazed", BALL, vec(5, y, 0), NULL);
    if (x > 0 && !before) add(w, "small", small, vec(x + 0.1, 0, 0), NULL);
    scene_tick(w, 2LL * SECOND);
    world_hits hits = {0};
    world_query_ray(w, VEC_ZERO, vec(1, 0, 0), 20, 0.01, SECOND, &hits);
    assert_int_equal(hits.count, 1);
    world_hit hit = hits.at[0];
    free(hits.at);
    world_destroy(w);
    return hit;
}

static void where_a_ray_surely_touches_depends_on_nobody_else(void **state)
{
    (void)state;
    int same = 0;
    for (double y = 0.9; y < 1; y += 0.005) {
        world_hit alone = graze(y, -1, false);
        assert_true(alone.hi >= 5 - sqrt(1 - y * y) - 1e-12);
        for (double x = alone.lo + 0.0005; x < alone.lo + 0.05; x += 0.001)
            for (int before = 0; before < 2; before++) {
                world_hit hit = graze(y, x, before);
                if (hit.lo != alone.lo) continue; /* the small one comes first */
                same++;
                if (hit.hi != alone.hi)
                    fail_msg("%g aside, another one at %g m: hi %g, alone %g", y, x, hit.hi, alone.hi);
            }
    }
    assert_true(same > 500);
}

static void a_ray_hits_the_first_body_only(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    add(w, "far", BALL, vec(10, 0, 0), NULL);
    uint32_t near = add(w, "near", CUBE, vec(5, 0.3, 0.2), NULL);
    add(w, "aside", BALL, vec(3, 2.5, 0), NULL);
    scene_tick(w, 2LL * SECOND);
    world_hits hits = {0};
    world_query_ray(w, VEC_ZERO, vec(2, 0, 0), INFINITY, 1e-6, SECOND, &hits);
    assert_int_equal(hits.count, 1);
    assert_int_equal(hits.at[0].body_a, near);
    assert_true(hits.at[0].lo <= 4 && 4 <= hits.at[0].hi + 1e-6 && hits.at[0].lo > 4 - 1e-5);
    assert_true(hits.at[0].axis.x < -0.999);
    hits.count = 0;
    world_query_ray(w, VEC_ZERO, vec(1, 0, 0), 3.5, 1e-6, SECOND, &hits); /* ends before it */
    assert_int_equal(hits.count, 0);
    world_query_ray(w, VEC_ZERO, vec(-1, 0, 0), INFINITY, 1e-6, SECOND, &hits);
    assert_int_equal(hits.count, 0);
    world_query_ray(w, vec(0, 1.25, 0), vec(1, 0, 0), INFINITY, 1e-6, SECOND, &hits); /* inside the cube's shadow */
    assert_int_equal(hits.count, 1);
    free(hits.at);
    world_destroy(w);
}

static void a_box_finds_what_overlaps_it(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t in = add(w, "in", BALL, vec(2, 0, 0), NULL);
    add(w, "corner", BALL, vec(1.8, 1.8, 1.8), NULL); /* its box overlaps, it does not: sqrt(3) 0.8 > 1 */
    scene_tick(w, 2LL * SECOND);
    world_hits hits = {0};
    world_query_box(w, POSE_IDENTITY, vec(1.1, 1, 1), SECOND, &hits);
    assert_int_equal(hits.count, 1);
    assert_int_equal(hits.at[0].body_a, in);
    free(hits.at);
    world_destroy(w);
}

static void a_box_is_cast_to_the_first_body_on_its_way(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t wall = add(w, "wall", CUBE, vec(5, 0, 0), NULL);
    add(w, "behind", BALL, vec(9, 0, 0), NULL);
    uint32_t aside = add(w, "aside", BALL, vec(3, 2, 0), NULL); /* a ray misses it by 1, the box of half 1.5 meets it */
    scene_tick(w, 2LL * SECOND);
    world_hits hits = {0};
    world_query_cast(w, POSE_IDENTITY, vec(0.5, 0.5, 0.5), vec(3, 0, 0), INFINITY, 1e-6, SECOND, &hits);
    assert_int_equal(hits.count, 1);
    assert_int_equal(hits.at[0].body_a, wall);
    assert_true(hits.at[0].lo <= 3.5 && 3.5 <= hits.at[0].hi && hits.at[0].hi - hits.at[0].lo < 1e-4);
    assert_true(hits.at[0].axis.x < -0.999);
    hits.count = 0;
    world_query_cast(w, POSE_IDENTITY, vec(0.5, 1.5, 0.5), vec(1, 0, 0), INFINITY, 1e-6, SECOND, &hits);
    assert_int_equal(hits.at[0].body_a, aside);
    double free_length = 3 - 0.5 - sqrt(1 - 0.25); /* the ball's side at y = 1.5 */
    assert_true(hits.at[0].lo <= free_length && free_length <= hits.at[0].hi && hits.at[0].lo > free_length - 1e-4);
    hits.count = 0;
    world_query_cast(w, POSE_IDENTITY, vec(0.5, 0.5, 0.5), vec(1, 0, 0), 3.4, 1e-6, SECOND, &hits); /* ends before */
    world_query_cast(w, POSE_IDENTITY, vec(0.5, 0.5, 0.5), vec(-1, 0, 0), INFINITY, 1e-6, SECOND, &hits);
    assert_int_equal(hits.count, 0);
    world_query_cast(w, POSE_IDENTITY, VEC_ZERO, vec(0, 1, 0), 1e6, 1e-6, SECOND, &hits); /* a point, into nothing */
    assert_int_equal(hits.count, 0);
    free(hits.at);
    world_destroy(w);
}

enum { SCATTERED = 300 };

static void nearest_bodies_equal_those_of_all_pairs(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint64_t random = 3;
    vec3 at[SCATTERED];
    for (int i = 0; i < SCATTERED; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        for (int k = 0; k < 3; k++) {
            random = random * UINT64_C(6364136223846793005) + 1442695040888963407u;
            (&at[i].x)[k] = (double)(random >> 40) * 0x1p-24 * 200 - 100;
        }
        add(w, name, BALL, at[i], NULL);
    }
    scene_tick(w, 2LL * SECOND);
    static const size_t MOST[] = {1, 2, 17, SCATTERED, 1000};
    static const double RANGE[] = {0, 5, 60, INFINITY};
    for (size_t m = 0; m < sizeof MOST / sizeof *MOST; m++) {
        for (size_t r = 0; r < sizeof RANGE / sizeof *RANGE; r++) {
            world_hits point = {0}, body = {0};
            world_query_nearest(w, (pose){at[7], {1, 0, 0, 0}}, VEC_ZERO, RANGE[r], MOST[m], 1e-9, SECOND, &point);
            world_query_nearest_to(w, 7, RANGE[r], MOST[m], 1e-9, SECOND, &body);
            size_t within_point = 0, within_body = 0;
            for (int i = 0; i < SCATTERED; i++) {
                double centres = vec_norm(vec_sub(at[i], at[7]));
                within_point += centres - 1 <= RANGE[r];
                within_body += i != 7 && centres - 2 <= RANGE[r];
            }
            assert_int_equal(point.count, within_point < MOST[m] ? within_point : MOST[m]);
            assert_int_equal(body.count, within_body < MOST[m] ? within_body : MOST[m]);
            assert_int_equal(point.at[0].body_a, 7); /* the point is inside it */
            for (size_t i = 0; i < body.count; i++) {
                double truth = vec_norm(vec_sub(at[body.at[i].body_a], at[7])) - 2;
                assert_true(body.at[i].lo <= truth + 1e-12 && truth - 1e-12 <= body.at[i].hi);
                assert_true(i == 0 || body.at[i - 1].lo <= body.at[i].lo);
                size_t nearer = 0;
                for (int k = 0; k < SCATTERED; k++)
                    nearer += k != 7 && vec_norm(vec_sub(at[k], at[7])) - 2 < truth - 1e-8;
                assert_true(nearer <= i);
            }
            free(point.at);
            free(body.at);
        }
    }
    world_destroy(w);
}

static void explain_names_the_rule_and_its_reason(void **state)
{
    (void)state;
    char text[2048];
    world *w = scene_world(1, true);
    filter_rule rule = {.pattern = "link*", .allow = true, .reason = "Adjacent"};
    uint32_t a = add(w, "link1", BALL, VEC_ZERO, NULL), b = add(w, "base", BALL, vec(1, 0, 0), &rule);
    uint32_t c = add(w, "box", CUBE, vec(1, 0, 0), NULL);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    const world_batch *batch = scene_tick(w, 2LL * SECOND);
    assert_int_equal(batch->count, 2); /* box with both, not link1 with base */
    assert_true(world_explain(w, a, b, SECOND, text, sizeof text) > 0);
    assert_non_null(strstr(text, "not checked"));
    assert_non_null(strstr(text, "link*"));
    assert_non_null(strstr(text, "Adjacent"));
    assert_true(world_explain(w, a, c, SECOND, text, sizeof text) > 0);
    assert_non_null(strstr(text, "wanted by subscription 0"));
    int whole = world_explain(w, a, c, SECOND, NULL, 0);
    char tiny[8];
    assert_int_equal(world_explain(w, a, c, SECOND, tiny, sizeof tiny), whole); /* cut, and never beyond */
    assert_int_equal(strlen(tiny), sizeof tiny - 1);
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(distance_brackets_the_truth_at_any_distance_from_the_origin),
        cmocka_unit_test(answers_are_the_same_everywhere),
        cmocka_unit_test(where_a_ray_surely_touches_depends_on_nobody_else),
        cmocka_unit_test(a_ray_hits_the_first_body_only),
        cmocka_unit_test(a_box_finds_what_overlaps_it),
        cmocka_unit_test(a_box_is_cast_to_the_first_body_on_its_way),
        cmocka_unit_test(nearest_bodies_equal_those_of_all_pairs),
        cmocka_unit_test(explain_names_the_rule_and_its_reason),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
