/* What a calm body is spared changes no answer: two worlds under the same random commands, in one of which a
 * subscription that nobody matches keeps every body from being calm (it asks for bounds, so that all that moves is
 * looked at), tell the same events with the same bits, and answer queries alike, between ticks, too. */
#include "base/prng.h"
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BODIES = 40, CALM = 0, AWAKE = 1, WORLDS = 2, POSES_MOST = 4 };
static const int64_t TICK_NS = SECOND / 100;
static const double ROOM = 4; /* m, the cube in which they are */

typedef struct run {
    world *w[WORLDS];
    uint64_t random;
    uint32_t ids[BODIES], impacts;
    pose at[BODIES];
    int64_t now_ns;
    uint64_t events;
} run;

static vec3 anywhere(run *r, double most)
{
    return vec(prng_in(&r->random, -most, most), prng_in(&r->random, -most, most), prng_in(&r->random, -most, most));
}

static void put(run *r, size_t i)
{
    char name[16];
    vec3 beside = prng_bits(&r->random) % 2 ? anywhere(r, 0.3) : VEC_ZERO;
    world_shape shapes[2] = {{.shape = {.type = SHAPE_BOX, .half = {0.2, 0.3, 0.1}}, .local = {beside, {1, 0, 0, 0}}},
        {.shape = {.type = SHAPE_SPHERE, .radius = 0.2}, .local = POSE_IDENTITY}};
    snprintf(name, sizeof name, "b%zu", i);
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .fixed = i % 9 == 8,
        .deadline_ns = i % 7 == 6 ? 5 * TICK_NS : 0,
        .ccd = i % 3 ? WORLD_CCD_LINEAR : WORLD_CCD_OFF,
        .pose = r->at[i],
        .stamp_ns = r->now_ns,
        .shapes = shapes + i % 2,
        .shape_count = i % 6 == 0 ? 2 : 1};
    uint32_t ids[WORLDS] = {r->ids[i], r->ids[i]};
    for (int k = 0; k < WORLDS; k++) assert_int_equal(world_put_body(r->w[k], &ids[k], &def), WORLD_OK);
    assert_int_equal(ids[CALM], ids[AWAKE]);
    r->ids[i] = ids[CALM];
}

/* Mostly a little, so that fat boxes hold; sometimes far. */
static pose further(run *r, size_t i)
{
    double step = prng_bits(&r->random) % 16 ? 0.01 : prng_bits(&r->random) % 4 ? 0.2 : 2;
    pose to = r->at[i];
    to.p = vec_add(to.p, anywhere(r, step));
    to.p = vec(fmin(fmax(to.p.x, -ROOM), ROOM), fmin(fmax(to.p.y, -ROOM), ROOM), fmin(fmax(to.p.z, -ROOM), ROOM));
    if (prng_bits(&r->random) % 2) {
        vec3 turn = anywhere(r, step);
        to.q = quat_unit((quat){to.q.w + 0.1 * turn.x, to.q.x + turn.y, to.q.y + turn.z, to.q.z});
    }
    return r->at[i] = to;
}

/* By arrays in one of the worlds, one by one in the other. */
static void move_some(run *r, int64_t stamp_ns)
{
    uint32_t ids[BODIES], left_out[BODIES];
    double positions[3 * BODIES], orientations[4 * BODIES], linear[3 * BODIES];
    size_t count = 0;
    bool told = prng_bits(&r->random) % 8 == 0;
    for (size_t i = 0; i < BODIES; i++) {
        if (prng_bits(&r->random) % 4 == 0) continue;
        pose to = further(r, i);
        vec3 v = anywhere(r, 1);
        memcpy(positions + 3 * count, &to.p, sizeof to.p);
        memcpy(orientations + 4 * count, &to.q, sizeof to.q);
        memcpy(linear + 3 * count, &v, sizeof v);
        ids[count++] = r->ids[i];
        world_move_body(r->w[AWAKE], r->ids[i], to, stamp_ns, told ? &v : NULL, NULL);
    }
    const world_poses poses = {.ids = ids,
        .count = count,
        .positions = positions,
        .orientations = orientations,
        .linear = told ? linear : NULL,
        .stamp_ns = stamp_ns};
    assert_int_equal(world_move_bodies(r->w[CALM], &poses, left_out), 0);
}

static void do_something_else(run *r)
{
    size_t i = prng_bits(&r->random) % BODIES;
    world_subscription impacts = scene_all(WORLD_IMPACT | WORLD_PREDICT, 0);
    impacts.horizon = 0.1;
    impacts.select_a = "b*";
    uint64_t what = prng_bits(&r->random) % 16;
    pose nearby = r->at[i];
    nearby.p.x += 0.01;
    for (int k = 0; k < WORLDS; k++) {
        if (what == 0) world_hold_body(r->w[k], r->ids[i]);
        if (what == 1) world_teleport_body(r->w[k], r->ids[i], r->at[i == 0 ? 1 : 0], r->now_ns, NULL, NULL);
        if (what == 5) world_teleport_body(r->w[k], r->ids[i], nearby, r->now_ns, NULL, NULL);
        if (what == 2 && r->impacts != WORLD_NONE) world_remove_subscription(r->w[k], r->impacts, CAUSE_SUBSCRIPTION);
    }
    if (what == 1) r->at[i] = r->at[i == 0 ? 1 : 0];
    if (what == 5) r->at[i] = nearby;
    if (what == 2) r->impacts = WORLD_NONE;
    if (what == 3 && r->impacts == WORLD_NONE)
        for (int k = 0; k < WORLDS; k++) {
            uint32_t id = WORLD_NONE;
            assert_int_equal(world_put_subscription(r->w[k], &id, &impacts), WORLD_OK);
            if (k) assert_int_equal(id, r->impacts);
            r->impacts = id;
        }
    if (what == 4) put(r, i);
}

static void ask(run *r)
{
    uint32_t a = r->ids[prng_bits(&r->random) % BODIES];
    world_hits hits[WORLDS][2] = {0};
    for (int k = 0; k < WORLDS; k++) {
        world_query_nearest_to(r->w[k], a, 3, 4, 0, r->now_ns, &hits[k][0]);
        world_query_distance(r->w[k], r->ids[0], r->ids[1], 0, r->now_ns, &hits[k][1]);
    }
    for (int q = 0; q < 2; q++) {
        assert_int_equal(hits[CALM][q].count, hits[AWAKE][q].count);
        for (size_t i = 0; i < hits[CALM][q].count; i++) {
            const world_hit *x = &hits[CALM][q].at[i], *y = &hits[AWAKE][q].at[i];
            assert_int_equal(x->body_a, y->body_a);
            assert_true(x->lo == y->lo && x->hi == y->hi && x->axis.x == y->axis.x && x->point_a.x == y->point_a.x);
        }
        for (int k = 0; k < WORLDS; k++) free(hits[k][q].at);
    }
}

static void tick_both(run *r)
{
    world_batches told[WORLDS];
    r->now_ns += TICK_NS;
    for (int k = 0; k < WORLDS; k++) {
        world_tick(r->w[k], r->now_ns, &told[k]);
        const char *fault = world_validate(r->w[k]);
        if (fault) fail_msg("world %d: %s", k, fault);
    }
    assert_true(told[CALM].hash == told[AWAKE].hash);
    for (size_t i = 0; i < told[CALM].count; i++) r->events += told[CALM].at[i].count;
}

static void calm_changes_nothing(void **state)
{
    (void)state;
    bool brief = getenv("COLLIDED_BRIEF"), nightly = getenv("COLLIDED_NIGHTLY");
    int ticks = brief ? 500 : nightly ? 100000 : 5000;
    run r = {.random = 1, .impacts = WORLD_NONE, .now_ns = SECOND};
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE, 0.1);
    world_subscription none = {.facts = WORLD_DISTANCE,
        .select_a = "nobody",
        .select_b = "nobody",
        .range = 1,
        .accuracy = WORLD_BY_BOXES,
        .tolerance = 1e-9};
    for (int k = 0; k < WORLDS; k++) {
        r.w[k] = scene_world(1, true);
        scene_subscription(r.w[k], &all);
        none.facts = k == AWAKE ? WORLD_DISTANCE : WORLD_TOUCH;
        none.accuracy = k == AWAKE ? WORLD_BY_BOXES : WORLD_BY_TOLERANCE;
        scene_subscription(r.w[k], &none);
    }
    for (size_t i = 0; i < BODIES; i++) {
        r.ids[i] = WORLD_NONE;
        r.at[i] = (pose){anywhere(&r, ROOM), {1, 0, 0, 0}};
        put(&r, i);
    }
    tick_both(&r);
    for (int t = 0; t < ticks; t++) {
        uint64_t times = 1 + prng_bits(&r.random) % POSES_MOST;
        for (uint64_t k = 0; k < times; k++) move_some(&r, prng_bits(&r.random) % 8 ? r.now_ns + (int64_t)k : 0);
        do_something_else(&r);
        if (t % 3 == 0) ask(&r);
        tick_both(&r);
        if (t % 5 == 0) ask(&r);
    }
    assert_true(r.events > (uint64_t)ticks);
    for (int k = 0; k < WORLDS; k++) world_destroy(r.w[k]);
}

/* A body that was calm had a way, too, if somebody comes to ask for it before the tick: something else goes through its
 * place while it moves on a little. */
static void what_was_calm_has_a_way(void **state)
{
    (void)state;
    double times[WORLDS];
    for (int k = 0; k < WORLDS; k++) {
        world *w = scene_world(1, true);
        world_subscription all = scene_all(WORLD_TOUCH, 0), impacts = scene_all(WORLD_IMPACT, 0);
        world_subscription none = {
            .facts = WORLD_DISTANCE, .select_a = "nobody", .select_b = "nobody", .range = 1, .tolerance = 1e-9};
        none.accuracy = k == AWAKE ? WORLD_BY_BOXES : WORLD_BY_TOLERANCE;
        scene_subscription(w, &all);
        scene_subscription(w, &none);
        uint32_t ids[2] = {scene_sphere(w, "a", 0, 0.5), scene_sphere(w, "b", -8, 0.5)};
        for (uint32_t i = 0; i < 2; i++) {
            world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
            world_body def = {.name = i ? "b" : "a",
                .group = "",
                .category = 1,
                .mask = UINT64_MAX,
                .ccd = WORLD_CCD_LINEAR,
                .pose = {{i ? -8 : 0, 0, 0}, {1, 0, 0, 0}},
                .shapes = &ball,
                .shape_count = 1};
            assert_int_equal(world_put_body(w, &ids[i], &def), WORLD_OK);
        }
        for (int t = 1; t < 5; t++) { /* its box has been put, and it is calm */
            scene_move(w, ids[0], 1e-3 * (t % 2), 0);
            scene_tick(w, t * TICK_NS);
        }
        scene_subscription(w, &impacts);
        scene_move(w, ids[0], 0.04, 0);
        scene_move(w, ids[1], 8, 0);
        world_batches told;
        world_tick(w, 6 * TICK_NS, &told);
        times[k] = -1;
        for (size_t i = 0; i < told.count; i++)
            if (told.at[i].count && told.at[i].events[0].kind == EVENT_IMPACT)
                times[k] = told.at[i].events[0].impact.lo;
        world_destroy(w);
    }
    assert_true(times[CALM] > 0 && times[CALM] == times[AWAKE]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(calm_changes_nothing), cmocka_unit_test(what_was_calm_has_a_way)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
