/* A step that moves very many bodies at once: no tick puts more of them anew than its slice allows, in turns of their
 * owners; nothing is told free, or to have ended, that is not so; and in the end all is as in a world that is not cut,
 * for any number of workers, and for one that was saved and restored in the middle. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

enum { ROW = 2000, FEW = 20, SLICE = 200000, A_BALL = 1000 /* units */, A_MOVE = 150, MANY_OWNER = 1, FEW_OWNER = 2 };

typedef struct row {
    world *w;
    uint32_t ids[ROW + FEW];
    bool touch[ROW + FEW]; /* this one and the next, as told */
    double gap;            /* between two that follow each other */
    int64_t now_ns;
    size_t begun, over, of_few, undone;
    bool removes; /* then they end although they touch */
    uint64_t hash;
} row;

/* Those of few bodies stand apart. */
static double place(const row *r, int i)
{
    return (i < ROW ? 0 : 1e5) + (1 + r->gap) * (i + 1);
}

static void set_up(row *r, unsigned workers, uint64_t slice)
{
    char name[16];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
    *r = (row){.w = scene_world(workers, true), .gap = 0.5};
    scene_subscription(r->w, &all);
    for (int i = 0; i < ROW + FEW; i++) {
        snprintf(name, sizeof name, "%04d", i);
        world_body def = {.name = name,
            .group = "",
            .owner = i < ROW ? MANY_OWNER : FEW_OWNER,
            .category = 1,
            .mask = UINT64_MAX,
            .pose = {{place(r, i), 0, 0}, {1, 0, 0, 0}},
            .shapes = &ball,
            .shape_count = 1};
        r->ids[i] = WORLD_NONE;
        assert_int_equal(world_put_body(r->w, &r->ids[i], &def), WORLD_OK);
    }
    world_batches b;
    world_tick(r->w, ++r->now_ns, &b);
    world_set_slice(r->w, slice);
}

static void move_all(row *r, double gap, int64_t stamp_ns)
{
    r->gap = gap;
    for (int i = 0; i < ROW + FEW; i++) {
        pose to = {{place(r, i), 0, 0}, {1, 0, 0, 0}};
        assert_int_equal(world_move_body(r->w, r->ids[i], to, stamp_ns, NULL, NULL), WORLD_OK);
    }
}

static void step(row *r, double gap, int64_t stamp_ns)
{
    move_all(r, gap, stamp_ns);
    world_part_moves(r->w);
}

static void hear(row *r, const world_event *e)
{
    int a = atoi(e->name_a), b = atoi(e->name_b), first = a < b ? a : b;
    if (e->kind != EVENT_BEGIN && e->kind != EVENT_END) return;
    assert_int_equal(abs(a - b), 1);
    assert_int_equal(r->touch[first], e->kind == EVENT_END);
    r->touch[first] = e->kind == EVENT_BEGIN;
    assert_true(r->removes || r->touch[first] == (r->gap <= 0)); /* nothing is told of where they have been */
    r->begun += e->kind == EVENT_BEGIN;
    r->over += e->kind == EVENT_END;
    r->of_few += first >= ROW;
}

static void tick(row *r)
{
    world_batches b;
    world_tick(r->w, ++r->now_ns, &b);
    const char *fault = world_validate(r->w);
    if (fault) fail_msg("%s", fault);
    r->hash = b.hash;
    for (size_t i = 0; i < b.count; i++) {
        r->undone = b.at[i].undone;
        for (size_t k = 0; k < b.at[i].count && !b.at[i].snapshot; k++) hear(r, &b.at[i].events[k]);
    }
}

static size_t differing(const row *r)
{
    size_t count = 0;
    for (int i = 0; i + 1 < ROW + FEW; i++) count += i + 1 != ROW && r->touch[i] != (r->gap <= 0);
    return count;
}

/* What is not told yet is said to be pending; how many ticks it took. */
static int finish(row *r)
{
    int ticks = 0;
    do {
        tick(r);
        world_figures f = world_get_figures(r->w);
        if (differing(r)) assert_true(f.pending_bodies > 0 && f.pending_pairs > 0 && r->undone > 0);
        if (differing(r)) assert_true(world_changed(r->w) && world_was_sliced(r->w));
        if (differing(r)) assert_true(world_pending_of(r->w, MANY_OWNER) > 0);
        assert_true(++ticks < 5000);
    } while (world_get_figures(r->w).pending_bodies);
    assert_int_equal(differing(r), 0);
    assert_int_equal(r->undone, 0);
    return ticks;
}

static void no_tick_settles_more_than_its_slice(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1, SLICE);
    step(&r, -0.1, 0);
    uint64_t all = world_effort(r.w);
    assert_int_equal(all, (ROW + FEW) * A_BALL);
    tick(&r);
    uint64_t left = world_effort(r.w);
    uint64_t moves = A_MOVE * (ROW + FEW);
    assert_in_range(all - left, SLICE / 8, 2 * SLICE - moves + 2 * A_BALL); /* to move them took the rest */
    for (all = left; left; all = left) {
        tick(&r);
        left = world_effort(r.w);
        assert_in_range(all - left, 1, 2 * SLICE + 2 * A_BALL);
    }
    assert_in_range(finish(&r), 1, 100);
    assert_int_equal(r.begun, ROW + FEW - 2);
    step(&r, 0.5, 0);
    assert_true(finish(&r) > ROW * A_BALL / (2 * SLICE) - 1);
    assert_int_equal(r.over, ROW + FEW - 2);
    world_destroy(r.w);
}

static void who_moves_few_does_not_wait(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1, SLICE);
    for (int n = 0; n < 6; n++) {
        size_t before = r.of_few;
        step(&r, n % 2 ? 0.5 : -0.1, 0);
        tick(&r);
        assert_int_equal(r.of_few - before, FEW - 1);
        assert_true(differing(&r) > ROW / 2);
        assert_int_equal(world_pending_of(r.w, FEW_OWNER), 0);
        finish(&r);
    }
    world_destroy(r.w);
}

/* Without a step none is left: of two that never rest one might always be. */
static void poses_that_are_no_step_are_settled_at_once(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1, 10 * SLICE);
    step(&r, -0.1, 0);
    finish(&r);
    move_all(&r, 0.5, 0);
    tick(&r);
    assert_int_equal(world_effort(r.w), 0);
    finish(&r);
    world_destroy(r.w);
}

/* A body that is left to the next tick, and goes, and another that gets its id. */
static void what_is_left_may_go(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1, SLICE);
    step(&r, -0.1, 0);
    tick(&r);
    r.removes = true;
    for (int i = 0; i < ROW; i += 2) assert_int_equal(world_remove_body(r.w, r.ids[i], CAUSE_REMOVED), WORLD_OK);
    for (int n = 0; n < 3; n++) tick(&r);
    for (int i = 0; i < ROW; i += 2) {
        char name[16];
        snprintf(name, sizeof name, "%04d", i);
        r.ids[i] = scene_sphere(r.w, name, place(&r, i), 0.5);
    }
    step(&r, -0.1, 0);
    for (int n = 0; n < 5000 && world_changed(r.w); n++) tick(&r);
    assert_int_equal(differing(&r), 0);
    world_destroy(r.w);
}

/* A pose that has come is no older for having to wait: nothing becomes unknown. Nor is it told as newer than it is. */
static void ages_are_of_what_is_told(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1, SLICE);
    step(&r, 0.4, 1000);
    finish(&r);
    r.now_ns = 5000;
    step(&r, 0.3, 5000);
    tick(&r);
    size_t old = 0;
    for (int i = 0; i + 1 < ROW; i++) {
        world_hits hits = {.at = NULL};
        world_query_distance(r.w, r.ids[i], r.ids[i + 1], 1e-9, r.now_ns, &hits);
        assert_int_equal(hits.count, 1);
        bool newest = hits.at[0].lo<0.35, before = hits.at[0].lo> 0.39;
        if (newest) assert_in_range(hits.at[0].age_ns, 0, r.now_ns - 1000);
        if (before) assert_int_equal(hits.at[0].age_ns, r.now_ns - 1000);
        assert_true(newest || before || i == 0 || old);
        old += before;
        free(hits.at);
    }
    assert_true(old > ROW / 2);
    world_destroy(r.w);
}

static void workers_and_a_restored_world_tell_the_same(void **state)
{
    (void)state;
    row r[3];
    for (unsigned k = 0; k < 3; k++) set_up(&r[k], k == 1 ? 8 : 1, SLICE);
    for (int n = 0; n < 60; n++) {
        for (int k = 0; k < 3; k++) {
            if (n % 20 == 0) step(&r[k], n % 40 ? 0.5 : -0.1, 0);
            tick(&r[k]);
        }
        assert_true(r[0].hash == r[1].hash);
        assert_true(r[0].hash == r[2].hash);
        if (n != 22) continue;
        bytes_out bytes = {0};
        world_lender nobody = {.context = NULL};
        assert_true(world_effort(r[2].w) > 0);
        world_save(r[2].w, &nobody, &bytes);
        world_destroy(r[2].w);
        r[2].w = scene_world(1, true);
        bytes_in from = {.at = bytes.at, .left = bytes.count};
        const char *wrong = world_restore(r[2].w, &nobody, &from);
        if (wrong) fail_msg("%s", wrong);
        world_set_slice(r[2].w, SLICE);
        array_free(&bytes);
    }
    for (int k = 0; k < 3; k++) assert_int_equal(differing(&r[k]), 0);
    for (int k = 0; k < 3; k++) world_destroy(r[k].w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_tick_settles_more_than_its_slice),
        cmocka_unit_test(who_moves_few_does_not_wait),
        cmocka_unit_test(poses_that_are_no_step_are_settled_at_once),
        cmocka_unit_test(what_is_left_may_go),
        cmocka_unit_test(ages_are_of_what_is_told),
        cmocka_unit_test(workers_and_a_restored_world_tell_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
