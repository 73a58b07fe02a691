/* Shapes far from their bodies' origins: what is told of them holds the distance of the poses as given, in 113 bits. */
#include "oracle.h"
#include "scene.h"

static double uniform(uint64_t *state, double lo, double hi)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return lo + (hi - lo) * (double)(*state >> 11) * 0x1p-53;
}

static vec3 somewhere(uint64_t *state, double length)
{
    for (;;) {
        vec3 v = {uniform(state, -1, 1), uniform(state, -1, 1), uniform(state, -1, 1)};
        if (vec_norm(v) > 0.1) return vec_scale(vec_unit(v), length);
    }
}

static quat turned(uint64_t *state)
{
    vec3 v = somewhere(state, 1);
    return quat_unit((quat){uniform(state, -1, 1), v.x, v.y, v.z});
}

static real3 centre(pose body, pose local, vec3 origin)
{
    placed at = oracle_place(&(shape){.type = SHAPE_SPHERE}, body, origin);
    return oracle_point(&at, real3_of(local.p));
}

static pose pose_of(const world *w, uint32_t id)
{
    world_body b;
    assert_int_equal(world_get_body(w, id, &b, NULL), WORLD_OK);
    return b.pose;
}

static void check(const world *w, uint32_t a, pose local_a, uint32_t b, pose local_b, double radii)
{
    pose at_a = pose_of(w, a), at_b = pose_of(w, b);
    real3 d = real3_sub(centre(at_b, local_b, at_a.p), centre(at_a, local_a, at_a.p));
    real truth = real_sqrt(real3_dot(d, d)) - (real)radii;
    world_answer told;
    assert_int_equal(world_answers(w), 1);
    world_get_answer(w, 0, &told);
    assert_true((real)told.lo <= truth && truth <= (real)told.hi);
    assert_true(told.hi - told.lo <= 1e-9);
}

static void answers_hold_what_the_bodies_poses_say(void **state)
{
    (void)state;
    static const double ARMS[] = {0, 0.3, 10, 1000};
    uint64_t seed = 5;
    for (int round = 0; round < 40; round++) {
        world *w = scene_world(1, round % 2);
        world_subscription all = scene_all(WORLD_DISTANCE | WORLD_TOUCH, 5);
        scene_subscription(w, &all);
        double arm = ARMS[round % 4], radius = 0.05;
        pose local_a = {somewhere(&seed, arm), turned(&seed)}, local_b = {somewhere(&seed, arm), turned(&seed)};
        shape ball = {.type = SHAPE_SPHERE, .radius = radius};
        uint32_t a = scene_body(w, "a", (world_shape){ball, local_a}, VEC_ZERO);
        uint32_t b = scene_body(w, "b", (world_shape){ball, local_b}, VEC_ZERO);
        for (int64_t t = 1; t <= 50; t++) {
            pose at_a = {somewhere(&seed, round % 8 < 4 ? 3 : 1e5), turned(&seed)}, at_b = {VEC_ZERO, turned(&seed)};
            vec3 near = vec_madd(pose_point(at_a, local_a.p), 0.2, somewhere(&seed, 1));
            at_b.p = vec_sub(near, quat_rotate(at_b.q, local_b.p));
            assert_int_equal(world_teleport_body(w, a, at_a, t * SECOND, NULL, NULL), WORLD_OK);
            assert_int_equal(world_teleport_body(w, b, at_b, t * SECOND, NULL, NULL), WORLD_OK);
            scene_tick(w, t * SECOND);
            check(w, a, local_a, b, local_b, 2 * radius);
        }
        world_destroy(w);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_hold_what_the_bodies_poses_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
