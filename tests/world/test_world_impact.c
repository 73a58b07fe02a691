/* What bodies did on their way between two ticks, and what is predicted of them; teleports. */
#include "scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static uint32_t ball(world *w, const char *name, vec3 at, double radius, world_ccd ccd)
{
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = radius}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = ccd,
        .stamp_ns = SECOND,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &s,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static uint32_t wall(world *w)
{
    world_shape s = {.shape = {.type = SHAPE_BOX, .half = {0.05, 5, 5}}, .local = POSE_IDENTITY};
    world_body def = {.name = "wall",
        .group = "",
        .fixed = true,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = POSE_IDENTITY,
        .shapes = &s,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static void move_to(world *w, uint32_t id, double x, int64_t stamp_ns)
{
    assert_int_equal(world_move_body(w, id, (pose){{x, 0, 0}, {1, 0, 0, 0}}, stamp_ns, NULL, NULL), WORLD_OK);
}

static world_subscription impacts(unsigned facts, double horizon)
{
    return (world_subscription){
        .facts = facts, .select_a = "*", .select_b = "*", .tolerance = 1e-9, .horizon = horizon};
}

static const world_event *only(const world_batch *b, uint8_t kind)
{
    assert_non_null(b);
    assert_int_equal(b->count, 1);
    assert_int_equal(b->events[0].kind, kind);
    return &b->events[0];
}

/* 2 m in 0.1 s, through a wall of 0.1 m: from x = -1, it touches at x = -0.15. */
static void a_bullet_meets_the_wall_that_it_flies_through(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t bullet = ball(w, "bullet", vec(-1, 0, 0), 0.1, WORLD_CCD_FULL);
    wall(w);
    world_subscription all = impacts(WORLD_IMPACT | WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move_to(w, bullet, 1, SECOND + SECOND / 10);
    const world_event *e = only(scene_tick(w, SECOND + SECOND / 10), EVENT_IMPACT);
    assert_string_equal(e->name_a, "bullet");
    assert_true(e->impact.lo <= 0.0425 && e->impact.hi >= 0.0425 && e->impact.hi - e->impact.lo < 1e-8);
    assert_int_equal(e->impact.start_ns, SECOND);
    assert_true(fabs(e->impact.pose_a.p.x + 0.15) < 1e-6 && e->impact.pose_b.p.x == 0);
    assert_true(fabs(e->closing - 20) < 1e-6 && e->axis.x > 0.999999);
    assert_true(fabs(e->point_a.x + 0.05) < 1e-6);
    assert_true(world_get_figures(w).impacts == 1);

    move_to(w, bullet, 1.5, SECOND + SECOND / 5); /* and goes on: nothing is there */
    assert_null(scene_tick(w, SECOND + SECOND / 5));
    world_destroy(w);
}

static void nobody_sweeps_what_nobody_asked_for(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t bullet = ball(w, "bullet", vec(-1, 0, 0), 0.1, WORLD_CCD_FULL);
    uint32_t slug = ball(w, "slug", vec(-1, 2, 0), 0.1, WORLD_CCD_OFF);
    wall(w);
    world_subscription touch = impacts(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(w, &touch);
    scene_tick(w, SECOND);
    move_to(w, bullet, 1, 2 * (int64_t)SECOND);
    assert_null(scene_tick(w, 2 * (int64_t)SECOND));
    assert_true(world_get_figures(w).sweeps == 0);

    touch.facts = WORLD_IMPACT;
    assert_int_equal(world_put_subscription(w, &id, &touch), WORLD_OK);
    pose across = {{1, 2, 0}, {1, 0, 0, 0}};
    assert_int_equal(world_move_body(w, slug, across, 3 * (int64_t)SECOND, NULL, NULL), WORLD_OK);
    const world_batch *b = scene_tick(w, 3 * (int64_t)SECOND);
    assert_int_equal(b->count, 0); /* the snapshot: the slug is OFF */
    world_figures f = world_get_figures(w);
    assert_true(f.sweeps == 0 && f.narrow_queries == 0);
    assert_true(f.stages[STAGE_UNASKED] > 0);
    world_destroy(w);
}

/* A rod that turns by a whole turn and a bit: only its angular velocity tells. */
static void given_velocities_tell_whole_turns(void **state)
{
    (void)state;
    for (int given = 0; given < 2; given++) {
        world *w = scene_world(1, true);
        world_shape rod = {.shape = {.type = SHAPE_CAPSULE, .radius = 0.01, .half = {0, 0, 1}}, .local = POSE_IDENTITY};
        world_body def = {.name = "rod",
            .group = "",
            .category = 1,
            .mask = 1,
            .ccd = WORLD_CCD_FULL,
            .stamp_ns = SECOND,
            .pose = POSE_IDENTITY,
            .shapes = &rod,
            .shape_count = 1};
        uint32_t id = WORLD_NONE;
        assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
        ball(w, "post", vec(0.9, 0, 0), 0.05, WORLD_CCD_OFF);
        world_subscription all = impacts(WORLD_IMPACT, 0);
        scene_subscription(w, &all);
        scene_tick(w, SECOND);
        double half = 0.05; /* 0.1 rad about y are seen, 2 pi more are not */
        vec3 still = VEC_ZERO, spin = {0, 10 * (2 * 3.14159265358979 + 2 * half), 0};
        pose to = {{0, 0, 0}, {cos(half), 0, sin(half), 0}};
        assert_int_equal(world_move_body(w, id, to, SECOND + SECOND / 10, &still, given ? &spin : NULL), WORLD_OK);
        const world_batch *b = scene_tick(w, SECOND + SECOND / 10);
        if (given)
            only(b, EVENT_IMPACT);
        else
            assert_null(b);
        world_destroy(w);
    }
}

static void what_will_meet_is_predicted_and_averted(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", vec(-3, 0, 0), 0.5, WORLD_CCD_OFF);
    ball(w, "b", vec(3, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = impacts(WORLD_PREDICT, 2);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    vec3 fast = {4, 0, 0}, slow = {0.1, 0, 0};
    pose at = {{-3, 0, 0}, {1, 0, 0, 0}};
    world_move_body(w, a, at, 2 * (int64_t)SECOND, &fast, NULL);
    const world_event *e = only(scene_tick(w, 2 * (int64_t)SECOND), EVENT_PREDICTED);
    assert_true(e->impact.lo <= 1.25 && e->impact.hi >= 1.25 && e->impact.hi - e->impact.lo < 1e-8);
    assert_true(e->impact.start_ns == 2 * (int64_t)SECOND && !e->impact.estimated && fabs(e->closing - 4) < 1e-9);
    int64_t contact = e->contact;

    at.p.x = -1;
    world_move_body(w, a, at, 5 * (int64_t)SECOND / 2, NULL, NULL); /* 2 m in half a second: estimated */
    e = only(scene_tick(w, 5 * (int64_t)SECOND / 2), EVENT_PREDICTED);
    assert_true(e->contact == contact && e->impact.estimated);
    assert_true(e->impact.lo <= 0.75 && e->impact.hi >= 0.75 && e->impact.hi - e->impact.lo < 1e-8);

    world_move_body(w, a, at, 3 * (int64_t)SECOND, &slow, NULL);
    e = only(scene_tick(w, 3 * (int64_t)SECOND), EVENT_AVERTED);
    assert_true(e->contact == contact && e->cause == CAUSE_MOTION);
    assert_true(world_get_figures(w).narrow_queries == 0);
    world_destroy(w);
}

/* The one that moves was heard of half a second before the other: it is that much nearer. */
static void poses_of_different_age_are_carried_on(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", vec(-3, 0, 0), 0.5, WORLD_CCD_OFF), b = ball(w, "b", vec(3, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = impacts(WORLD_PREDICT, 2);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    vec3 fast = {4, 0, 0};
    world_move_body(w, a, (pose){{-3, 0, 0}, {1, 0, 0, 0}}, 2 * (int64_t)SECOND, &fast, NULL);
    only(scene_tick(w, 2 * (int64_t)SECOND), EVENT_PREDICTED);
    world_move_body(w, b, (pose){{3, 0, 0}, {1, 0, 0, 0}}, 5 * (int64_t)SECOND / 2, &VEC_ZERO, NULL);
    const world_event *e = only(scene_tick(w, 5 * (int64_t)SECOND / 2), EVENT_PREDICTED);
    assert_true(e->impact.start_ns == 5 * (int64_t)SECOND / 2);
    assert_true(e->impact.lo <= 0.75 && e->impact.hi >= 0.75 && e->impact.hi - e->impact.lo < 1e-8);
    world_move_body(w, b, (pose){{3, 0, 0}, {1, 0, 0, 0}}, 5 * (int64_t)SECOND, &VEC_ZERO, NULL);
    only(scene_tick(w, 5 * (int64_t)SECOND), EVENT_AVERTED); /* nothing is known of a so far ahead */
    world_destroy(w);
}

/* At rest, 4 m apart, but free to accelerate by 2 m/s^2: they may meet after 2 s. */
static void stated_accelerations_are_predicted_for(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
    world_body def = {.name = "a",
        .group = "",
        .category = 1,
        .mask = 1,
        .acceleration = 2,
        .stamp_ns = SECOND,
        .pose = POSE_IDENTITY,
        .shapes = &s,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    ball(w, "b", vec(5, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = impacts(WORLD_PREDICT, 1.9);
    uint32_t subscription = scene_subscription(w, &all);
    assert_int_equal(scene_tick(w, SECOND)->count, 0);
    all.horizon = 2.1;
    assert_int_equal(world_put_subscription(w, &subscription, &all), WORLD_OK);
    world_move_body(w, id, POSE_IDENTITY, SECOND + 1, NULL, NULL);
    world_batches out;
    world_tick(w, SECOND + 1, &out);
    const world_event *e = only(&out.at[0], EVENT_PREDICTED);
    assert_true(e->impact.lo <= 2 && e->impact.lo > 1.9999 && isinf(e->impact.hi));
    world_destroy(w);
}

static void a_teleport_ends_and_begins_and_is_not_swept(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", vec(-0.1, 0, 0), 0.1, WORLD_CCD_FULL);
    wall(w);
    ball(w, "c", vec(3, 0, 0), 0.1, WORLD_CCD_OFF);
    world_subscription all = impacts(WORLD_IMPACT | WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    pose there = {{2.9, 0, 0}, {1, 0, 0, 0}};
    assert_int_equal(world_teleport_body(w, a, there, 2 * (int64_t)SECOND, NULL, NULL), WORLD_OK);
    const world_batch *b = scene_tick(w, 2 * (int64_t)SECOND);
    assert_int_equal(b->count, 2);
    assert_true(b->events[0].kind == EVENT_END && b->events[0].cause == CAUSE_TELEPORT);
    assert_int_equal(b->events[1].kind, EVENT_BEGIN);

    pose near = {{2.95, 0, 0}, {1, 0, 0, 0}}; /* within the same contact: it ends all the same */
    assert_int_equal(world_teleport_body(w, a, near, 3 * (int64_t)SECOND, NULL, NULL), WORLD_OK);
    b = scene_tick(w, 3 * (int64_t)SECOND);
    assert_int_equal(b->count, 2);
    assert_true(b->events[0].kind == EVENT_END && b->events[0].cause == CAUSE_TELEPORT);
    assert_true(b->events[1].kind == EVENT_BEGIN && b->events[1].contact != b->events[0].contact);
    world_destroy(w);
}

static void a_snapshot_tells_what_is_predicted(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", vec(-3, 0, 0), 0.5, WORLD_CCD_OFF);
    ball(w, "b", vec(3, 0, 0), 0.5, WORLD_CCD_OFF);
    world_subscription all = impacts(WORLD_PREDICT, 2);
    uint32_t id = scene_subscription(w, &all);
    vec3 fast = {4, 0, 0};
    scene_tick(w, SECOND);
    world_move_body(w, a, (pose){{-3, 0, 0}, {1, 0, 0, 0}}, 2 * (int64_t)SECOND, &fast, NULL);
    int64_t contact = only(scene_tick(w, 2 * (int64_t)SECOND), EVENT_PREDICTED)->contact;
    world_want_snapshot(w, id);
    const world_event *e = only(scene_tick(w, 3 * (int64_t)SECOND), EVENT_PREDICTED);
    assert_true(e->cause == CAUSE_SNAPSHOT && e->contact == contact);
    assert_int_equal(world_remove_body(w, a, CAUSE_REMOVED), WORLD_OK);
    e = only(scene_tick(w, 4 * (int64_t)SECOND), EVENT_AVERTED);
    assert_true(e->cause == CAUSE_REMOVED && e->contact == contact);
    world_destroy(w);
}

/* Bodies that fly about: the same events for any number of workers, with caches and without, and none is missed that
 * the sampled way shows. */
static uint64_t fly(unsigned workers, bool caches, uint64_t *sweeps)
{
    enum { BODIES = 60, TICKS = 60 };
    world *w = scene_world(workers, caches);
    uint64_t x = 88172645463325252u, hash = 0;
    uint32_t ids[BODIES];
    vec3 at[BODIES];
    char name[8];
    for (int i = 0; i < BODIES; i++) {
        double c[3];
        for (int k = 0; k < 3; k++) c[k] = (double)((x ^= x << 13, x ^= x >> 7, x ^= x << 17) % 1000) / 250;
        at[i] = vec(c[0], c[1], c[2]);
        name[0] = (char)('a' + i / 26);
        name[1] = (char)('a' + i % 26);
        name[2] = 0;
        ids[i] = ball(w, name, at[i], 0.1, (world_ccd)(i % 3));
    }
    world_subscription all = impacts(WORLD_IMPACT | WORLD_TOUCH | WORLD_PREDICT, 0.5);
    scene_subscription(w, &all);
    for (int t = 1; t <= TICKS; t++) {
        for (int i = 0; i < BODIES; i++) {
            double c[3];
            for (int k = 0; k < 3; k++) c[k] = (double)((x ^= x << 13, x ^= x >> 7, x ^= x << 17) % 1000) / 250;
            vec3 to = vec(c[0], c[1], c[2]);
            if ((x >> 20) % 4 == 0) continue;
            world_move_body(w, ids[i], (pose){to, {1, 0, 0, 0}}, (int64_t)SECOND * (t + 1), NULL, NULL);
        }
        world_batches out;
        world_tick(w, (int64_t)SECOND * (t + 1), &out);
        assert_null(world_validate(w));
        hash = out.hash;
    }
    *sweeps = world_get_figures(w).sweeps;
    assert_true(world_get_figures(w).impacts > 100 && world_get_figures(w).undecided == 0);
    world_destroy(w);
    return hash;
}

static void impacts_do_not_depend_on_workers_or_caches(void **state)
{
    (void)state;
    uint64_t sweeps, more, one = fly(1, true, &sweeps);
    for (unsigned workers = 2; workers <= 8; workers *= 2) {
        assert_true(fly(workers, true, &more) == one);
        assert_true(more == sweeps);
    }
    assert_true(fly(1, false, &more) == one);
}

/* Cylinders that fly by each other, 100 times a second over a second: the axis that kept a pair apart in one tick
 * spares it the search in the next, and nobody is told anything else. */
static uint64_t fly_by(bool caches, world_figures *f)
{
    enum { PAIRS = 40, TICKS = 50 };
    world *w = scene_world(1, caches);
    uint32_t ids[PAIRS];
    char name[8];
    uint64_t hash = 0;
    world_shape s = {.shape = {.type = SHAPE_CYLINDER, .half = {0.12, 0.12, 0.5}}, .local = POSE_IDENTITY};
    for (int i = 0; i < 2 * PAIRS; i++) {
        double aside = 0.2 + 0.02 * (i / 2); /* of its line */
        snprintf(name, sizeof name, "b%d", i);
        world_body def = {.name = name,
            .group = "",
            .category = (uint64_t)1 << (i / 2),
            .mask = (uint64_t)1 << (i / 2),
            .stamp_ns = SECOND,
            .pose = {i % 2 ? vec(-0.6 * aside, 0.8 * aside, 0.1) : vec(-1.6, -1.2, 0),
                quat_unit((quat){1, 0.1, 0.01 * i, 0.3})},
            .shapes = &s,
            .shape_count = 1};
        uint32_t id = WORLD_NONE;
        assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
        if (i % 2 == 0) ids[i / 2] = id;
    }
    world_subscription all = impacts(WORLD_PREDICT, 1);
    scene_subscription(w, &all);
    for (int t = 1; t <= TICKS; t++) {
        for (int i = 0; i < PAIRS; i++) {
            pose at = world_body_pose(w, ids[i]);
            vec3 v = {2, 1.5 + 0.01 * (i % 3), 0};
            at.p = vec_madd(at.p, 0.01, v);
            world_move_body(w, ids[i], at, SECOND + t * (int64_t)(SECOND / 100), &v, NULL);
        }
        world_batches out;
        world_tick(w, SECOND + t * (int64_t)(SECOND / 100), &out);
        hash = out.hash;
    }
    *f = world_get_figures(w);
    world_destroy(w);
    return hash;
}

static void an_axis_that_kept_them_apart_spares_the_next_search(void **state)
{
    (void)state;
    world_figures with, without;
    assert_true(fly_by(true, &with) == fly_by(false, &without));
    assert_true(with.sweeps == without.sweeps && with.predicted > 0 && with.predicted < 20);
    assert_true(with.sweeps_by_axis > without.sweeps_by_axis);
    assert_true(2 * with.sweep_queries < without.sweep_queries);
}

static void a_sweep_query_tells_what_would_be_met(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    uint32_t a = ball(w, "a", vec(-3, 0, 0), 0.5, WORLD_CCD_OFF);
    wall(w);
    ball(w, "behind", vec(2, 0, 0), 0.5, WORLD_CCD_OFF);
    scene_tick(w, SECOND);
    world_hits hits = {0};
    world_query_sweep(w, a, vec(2, 0, 0), VEC_ZERO, 10, 1e-9, SECOND, &hits);
    assert_int_equal(hits.count, 1);
    assert_string_equal(world_body_name(w, hits.at[0].body_a), "wall");
    assert_true(hits.at[0].lo <= 1.225 && hits.at[0].hi >= 1.225 && hits.at[0].hi - hits.at[0].lo < 1e-8);
    hits.count = 0;
    world_query_sweep(w, a, vec(-2, 0, 0), VEC_ZERO, 10, 1e-9, SECOND, &hits);
    assert_int_equal(hits.count, 0);
    free(hits.at);
    world_destroy(w);
}

/* From the first stamp that there is to the last one, in numbers. */
static void stamps_may_be_ages_apart(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    for (int i = 0; i < 2; i++) {
        world_shape s = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
        world_body def = {.name = i ? "b" : "a",
            .group = "",
            .category = 1,
            .mask = 1,
            .ccd = WORLD_CCD_FULL,
            .stamp_ns = 1,
            .pose = {{3 * i, 0, 0}, {1, 0, 0, 0}},
            .shapes = &s,
            .shape_count = 1};
        uint32_t id = WORLD_NONE;
        assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    }
    world_subscription all = impacts(WORLD_IMPACT, 0);
    scene_subscription(w, &all);
    scene_tick(w, SECOND);
    move_to(w, world_find_body(w, "a"), 6, INT64_MAX);
    const world_event *e = only(scene_tick(w, SECOND + 1), EVENT_IMPACT);
    assert_int_equal(e->impact.start_ns, 1);
    assert_true(e->impact.lo > 3e9 && e->impact.lo < 3.1e9); /* s: a third of the way */
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_bullet_meets_the_wall_that_it_flies_through),
        cmocka_unit_test(nobody_sweeps_what_nobody_asked_for),
        cmocka_unit_test(given_velocities_tell_whole_turns),
        cmocka_unit_test(what_will_meet_is_predicted_and_averted),
        cmocka_unit_test(poses_of_different_age_are_carried_on),
        cmocka_unit_test(stated_accelerations_are_predicted_for),
        cmocka_unit_test(a_teleport_ends_and_begins_and_is_not_swept),
        cmocka_unit_test(a_snapshot_tells_what_is_predicted),
        cmocka_unit_test(impacts_do_not_depend_on_workers_or_caches),
        cmocka_unit_test(an_axis_that_kept_them_apart_spares_the_next_search),
        cmocka_unit_test(a_sweep_query_tells_what_would_be_met),
        cmocka_unit_test(stamps_may_be_ages_apart),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
