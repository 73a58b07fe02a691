/* Bodies that go because their client does: no tick removes more of them than its slice allows; until its turn each
 * stands, and is told of; in the end each contact has ended once, and the same is told for any number of workers, and
 * by a world that was saved and restored in the middle. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

enum { ROW = 2000, SLICE = 600000, A_BALL = 1500 /* units */, AT_ONCE = 4, LOST = 1, OTHER = 2 };

typedef struct row {
    world *w;
    uint32_t ids[ROW];
    int64_t now_ns;
    size_t begun, over, causes_wrong, undone;
    uint64_t hash;
} row;

static uint32_t put(row *r, const char *name, uint64_t owner, double x)
{
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .owner = owner,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {{x, 0, 0}, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(r->w, &id, &def), WORLD_OK);
    return id;
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
        for (size_t k = 0; k < b.at[i].count; k++) {
            const world_event *e = &b.at[i].events[k];
            r->begun += !b.at[i].snapshot && e->kind == EVENT_BEGIN;
            r->over += e->kind == EVENT_END;
            r->causes_wrong += e->kind == EVENT_END && e->cause != CAUSE_OWNER_LOST;
        }
    }
}

/* Every ball touches the next. */
static void set_up(row *r, unsigned workers)
{
    char name[16];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    *r = (row){.w = scene_world(workers, true)};
    scene_subscription(r->w, &all);
    for (int i = 0; i < ROW; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        r->ids[i] = put(r, name, LOST, 0.9 * i);
    }
    tick(r);
    assert_int_equal(r->begun, ROW - 1);
    world_set_slice(r->w, SLICE);
}

static void lose(row *r)
{
    for (int i = 0; i < ROW; i++) assert_int_equal(world_remove_soon(r->w, r->ids[i], CAUSE_OWNER_LOST), WORLD_OK);
}

static size_t standing(const row *r)
{
    char name[16];
    size_t count = 0;
    for (int i = 0; i < ROW; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        count += world_find_body(r->w, name) != WORLD_NONE;
    }
    return count;
}

static void no_tick_removes_more_than_its_slice(void **state)
{
    (void)state;
    row r;
    size_t ticks = 0, most = SLICE / 4 / A_BALL + AT_ONCE;
    set_up(&r, 1);
    lose(&r);
    assert_int_equal(world_get_figures(r.w).bodies, 0); /* there is room for others */
    for (size_t left = ROW; world_get_figures(r.w).pending_bodies || !ticks; ticks++) {
        tick(&r);
        size_t now = standing(&r);
        assert_in_range(left - now, now ? 1 : 0, most);
        if (now) assert_true(r.undone > 0); /* what is told of those that stand is not all that is so */
        if (now) assert_true(world_changed(r.w));
        if (now) assert_true(world_was_sliced(r.w));
        left = now;
    }
    assert_in_range(ticks, ROW / most, 10 * ROW / most);
    assert_int_equal(r.over, ROW - 1);
    assert_int_equal(r.causes_wrong, 0);
    assert_int_equal(r.undone, 0);
    assert_int_equal(world_get_figures(r.w).pairs, 0);
    assert_false(world_some_go(r.w));
    world_destroy(r.w);
}

/* As if they had been removed one by one. */
static void where_slices_suffice_all_go_at_once(void **state)
{
    (void)state;
    row soon, now;
    set_up(&soon, 1);
    set_up(&now, 1);
    world_set_slice(soon.w, UINT64_MAX);
    world_set_slice(now.w, UINT64_MAX);
    lose(&soon);
    for (int i = 0; i < ROW; i++) assert_int_equal(world_remove_body(now.w, now.ids[i], CAUSE_OWNER_LOST), WORLD_OK);
    tick(&soon);
    tick(&now);
    assert_int_equal(soon.over, ROW - 1);
    assert_false(world_was_sliced(soon.w));
    assert_true(soon.hash == now.hash);
    world_destroy(soon.w);
    world_destroy(now.w);
}

/* Who is lost with few does not wait for who is lost with many. */
static void owners_take_turns(void **state)
{
    (void)state;
    row r;
    set_up(&r, 1);
    uint32_t few = put(&r, "few", OTHER, -100);
    tick(&r);
    lose(&r);
    assert_int_equal(world_remove_soon(r.w, few, CAUSE_OWNER_LOST), WORLD_OK);
    tick(&r);
    assert_int_equal(world_find_body(r.w, "few"), WORLD_NONE);
    assert_true(standing(&r) > ROW / 2);
    world_destroy(r.w);
}

/* A simulator that was lost and is there again announces what it had: each body takes the place of the one that had its
 * name, which ends, and does not go twice. */
static void a_name_is_free_at_once(void **state)
{
    (void)state;
    row r;
    char name[16];
    set_up(&r, 1);
    lose(&r);
    tick(&r);
    assert_true(standing(&r) > ROW / 2);
    for (int i = 0; i < ROW; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        put(&r, name, LOST, 0.9 * i);
    }
    for (int n = 0; n < 1000 && world_changed(r.w); n++) tick(&r);
    assert_int_equal(standing(&r), ROW);
    assert_int_equal(world_get_figures(r.w).bodies, ROW);
    assert_int_equal(world_get_figures(r.w).shapes, ROW);
    assert_int_equal(r.over, ROW - 1);
    assert_int_equal(r.begun, 2 * (ROW - 1));
    assert_int_equal(r.undone, 0);
    world_destroy(r.w);
}

static void workers_and_a_restored_world_tell_the_same(void **state)
{
    (void)state;
    row r[3];
    for (unsigned k = 0; k < 3; k++) {
        set_up(&r[k], k == 1 ? 8 : 1);
        lose(&r[k]);
    }
    for (int n = 0; n < 400; n++) {
        for (int k = 0; k < 3; k++) tick(&r[k]);
        assert_true(r[0].hash == r[1].hash);
        assert_true(r[0].hash == r[2].hash);
        if (n != 3) continue;
        bytes_out bytes = {0};
        world_lender nobody = {.context = NULL};
        assert_true(world_some_go(r[2].w));
        world_save(r[2].w, &nobody, &bytes);
        world_destroy(r[2].w);
        r[2].w = scene_world(1, true);
        bytes_in from = {.at = bytes.at, .left = bytes.count};
        const char *wrong = world_restore(r[2].w, &nobody, &from);
        if (wrong) fail_msg("%s", wrong);
        world_set_slice(r[2].w, SLICE);
        array_free(&bytes);
    }
    for (int k = 0; k < 3; k++) assert_int_equal(world_get_figures(r[k].w).pairs, 0);
    for (int k = 0; k < 3; k++) world_destroy(r[k].w);
}

/* What they leave in memory goes as slowly, however they went: their ids are not free before. */
static void no_tick_frees_more_than_its_slice(void **state)
{
    (void)state;
    enum { RULED = 100, RULES = 100, A_RULE = 600, TICKS = 4 };
    filter_rule rules[RULES];
    uint32_t ids[RULED];
    char name[16];
    world *w = scene_world(1, true);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 0.5}, .local = POSE_IDENTITY};
    for (int i = 0; i < RULES; i++) rules[i] = (filter_rule){.pattern = "nobody", .reason = ""};
    for (int i = 0; i < RULED; i++) {
        snprintf(name, sizeof name, "ruled %d", i);
        world_body def = {.name = name,
            .group = "",
            .mask = UINT64_MAX,
            .pose = {{3.0 * i, 0, 0}, {1, 0, 0, 0}},
            .shapes = &ball,
            .shape_count = 1,
            .rules = rules,
            .rule_count = RULES};
        ids[i] = WORLD_NONE;
        assert_int_equal(world_put_body(w, &ids[i], &def), WORLD_OK);
    }
    scene_tick(w, 1);
    world_set_slice(w, SLICE);
    for (int i = 0; i < RULED; i++) assert_int_equal(world_remove_body(w, ids[i], CAUSE_REMOVED), WORLD_OK);
    for (int n = 0; n < TICKS; n++) scene_tick(w, 2 + n);
    assert_true(world_was_sliced(w));
    size_t again = 0;
    for (int i = 0; i < RULED; i++) {
        snprintf(name, sizeof name, "new %d", i);
        again += scene_sphere(w, name, 3.0 * i, 0.5) < RULED;
    }
    assert_in_range(again, 1, TICKS * (SLICE / 4 / (RULES * A_RULE) + 1));
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_tick_removes_more_than_its_slice),
        cmocka_unit_test(where_slices_suffice_all_go_at_once),
        cmocka_unit_test(owners_take_turns),
        cmocka_unit_test(a_name_is_free_at_once),
        cmocka_unit_test(no_tick_frees_more_than_its_slice),
        cmocka_unit_test(workers_and_a_restored_world_tell_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
