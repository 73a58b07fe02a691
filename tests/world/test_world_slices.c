/* Slices: a tick takes no more pairs than it is allowed to; what is left is pending, is said, and comes: in the end all
 * is as in a world that is not cut, for each way of finding boxes that meet and any number of workers. */
#include "geom/compound.h"
#include "scene.h"
#include "world/saved.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { BALLS = 90, SLICE = 20000, OWNERS = 3 };

typedef struct crowd {
    world *w;
    world_options options;
    uint64_t slice;
    uint32_t balls[BALLS];
    vec3 at[BALLS];
    bool touch[BALLS][BALLS]; /* as told; a < b */
    size_t begins, undone;
} crowd;

static void set_up(crowd *c, uint64_t slice, unsigned workers, broad_kind kind)
{
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    *c = (crowd){.options = world_options_default(), .slice = slice};
    c->options.workers = workers;
    c->options.broad = kind;
    c->w = world_create(&c->options);
    world_set_slice(c->w, slice);
    scene_subscription(c->w, &all);
}

static void put_ball(crowd *c, int i, uint64_t owner, vec3 at)
{
    char name[8];
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    snprintf(name, sizeof name, "b%02d", i);
    world_body def = {.name = name,
        .group = "",
        .owner = owner,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    c->balls[i] = WORLD_NONE;
    assert_int_equal(world_put_body(c->w, &c->balls[i], &def), WORLD_OK);
    c->at[i] = at;
}

static void move_ball(crowd *c, int i, vec3 at)
{
    assert_int_equal(world_move_body(c->w, c->balls[i], (pose){at, {1, 0, 0, 0}}, 0, NULL, NULL), WORLD_OK);
    c->at[i] = at;
}

static void hear(crowd *c, const world_event *e)
{
    int a = atoi(e->name_a + 1), b = atoi(e->name_b + 1);
    bool *touch = a < b ? &c->touch[a][b] : &c->touch[b][a];
    if (e->kind != EVENT_BEGIN && e->kind != EVENT_END) return;
    assert_int_equal(*touch, e->kind == EVENT_END); /* one begin and one end, in turns */
    *touch = e->kind == EVENT_BEGIN;
    c->begins += e->kind == EVENT_BEGIN;
}

static bool truly_touch(const crowd *c, int a, int b)
{
    return vec_norm(vec_sub(c->at[a], c->at[b])) <= 2;
}

/* What differs from what is so has to be said to be undone. */
static void nothing_pending_is_told_free(const crowd *c)
{
    bool differs = false;
    for (int a = 0; a < BALLS; a++)
        for (int b = a + 1; b < BALLS; b++) differs |= c->touch[a][b] != truly_touch(c, a, b);
    world_figures f = world_get_figures(c->w);
    if (!differs) return;
    assert_true(f.pending_pairs > 0);
    assert_true(f.pending_bodies > 0);
    assert_true(c->undone >= f.pending_pairs);
    assert_true(world_changed(c->w)); /* it goes on by itself */
}

static uint64_t tick(crowd *c, int64_t now_ns)
{
    world_batches batches;
    world_tick(c->w, now_ns, &batches);
    const char *fault = world_validate(c->w);
    if (fault) fail_msg("%s", fault);
    for (size_t i = 0; i < batches.count; i++) {
        c->undone = batches.at[i].undone;
        for (size_t k = 0; !batches.at[i].snapshot && k < batches.at[i].count; k++) hear(c, &batches.at[i].events[k]);
    }
    nothing_pending_is_told_free(c);
    return batches.hash;
}

static int64_t finish(crowd *c, int64_t now_ns)
{
    for (int n = 0; world_get_figures(c->w).pending_bodies; n++) {
        assert_true(n < 5000);
        tick(c, ++now_ns);
    }
    assert_int_equal(c->undone, 0);
    for (int a = 0; a < BALLS; a++)
        for (int b = a + 1; b < BALLS; b++) assert_int_equal(c->touch[a][b], truly_touch(c, a, b));
    return now_ns;
}

static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static vec3 somewhere(uint64_t *seed, double room)
{
    double x = draw(seed), y = draw(seed);
    return vec(room * x, room * y, 0);
}

/* All in one place: the surge that simulators begin with. */
static void begin_in_one_place(crowd *c)
{
    for (int i = 0; i < BALLS; i++) put_ball(c, i, (uint64_t)(i % OWNERS), vec(0.001 * i, 0, 0));
}

static void no_tick_takes_more_than_its_slice(void **state)
{
    (void)state;
    crowd c;
    size_t most = 0, ticks = 0;
    set_up(&c, SLICE, 1, BROAD_AUTO);
    begin_in_one_place(&c);
    for (int64_t now = 1; now == 1 || world_get_figures(c.w).pending_bodies; now++, ticks++) {
        size_t before = c.begins;
        tick(&c, now);
        most = c.begins - before > most ? c.begins - before : most;
    }
    assert_int_equal(c.begins, BALLS * (BALLS - 1) / 2);
    assert_true(ticks > 10);
    assert_true(most < 200); /* of 4,005 */
    world_destroy(c.w);
}

/* Some move, some at each tick; now and then all stand elsewhere, or in one place. */
static void stir(crowd *c, int64_t now, uint64_t *seed)
{
    double room = now / 40 % 2 ? 4 : 60;
    bool all = now % 40 == 0;
    for (int i = 0; i < BALLS; i++) {
        vec3 at = somewhere(seed, room);
        if (all || draw(seed) < 0.1) move_ball(c, i, at);
    }
}

/* As a standby gets it. */
static void be_reborn(crowd *c)
{
    bytes_out bytes = {0};
    world_lender none = {0};
    world_save(c->w, &none, &bytes);
    world_destroy(c->w);
    c->w = world_create(&c->options);
    world_set_slice(c->w, c->slice);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    const char *wrong = world_restore(c->w, &none, &from);
    if (wrong) fail_msg("%s", wrong);
    array_free(&bytes);
}

/* The same bits for each kind and number of workers, and after a state was handed over in the middle of a surge. */
static void all_kinds_and_workers_tell_the_same(void **state)
{
    (void)state;
    enum { WORLDS = 5 };
    static const broad_kind kinds[WORLDS] = {BROAD_TREE, BROAD_SWEEP1, BROAD_SWEEP3, BROAD_AUTO, BROAD_TREE};
    static const unsigned workers[WORLDS] = {1, 2, 3, 8, 1};
    static crowd c[WORLDS];
    uint64_t seeds[WORLDS], pending_ticks = 0;
    for (int k = 0; k < WORLDS; k++) {
        set_up(&c[k], SLICE, workers[k], kinds[k]);
        begin_in_one_place(&c[k]);
        seeds[k] = 7;
    }
    int64_t now = 1;
    for (; now <= 400; now++) {
        uint64_t hash = 0;
        for (int k = 0; k < WORLDS; k++) {
            if (k == 4 && now % 7 == 0) be_reborn(&c[k]);
            if (now > 1) stir(&c[k], now, &seeds[k]);
            uint64_t is = tick(&c[k], now);
            if (k == 0) hash = is;
            if (is != hash) fail_msg("tick %d: world %d tells something else", (int)now, k);
        }
        pending_ticks += world_get_figures(c[0].w).pending_bodies > 0;
    }
    assert_true(pending_ticks > 100);
    for (int k = 0; k < WORLDS; k++) {
        finish(&c[k], now);
        world_destroy(c[k].w);
    }
}

/* Where no tick is cut, a slice changes nothing. */
static void a_slice_that_suffices_changes_nothing(void **state)
{
    (void)state;
    static crowd cut, whole;
    uint64_t seed = 3, same = 3;
    set_up(&cut, UINT64_C(1000000000), 1, BROAD_AUTO);
    set_up(&whole, UINT64_MAX, 1, BROAD_AUTO);
    begin_in_one_place(&cut);
    begin_in_one_place(&whole);
    for (int64_t now = 1; now <= 200; now++) {
        stir(&cut, now, &seed);
        stir(&whole, now, &same);
        assert_true(tick(&cut, now) == tick(&whole, now));
        assert_false(world_was_sliced(cut.w));
        assert_int_equal(world_get_figures(cut.w).pending_pairs, 0);
    }
    world_destroy(cut.w);
    world_destroy(whole.w);
}

/* Eighty balls of one owner in one place, that move all the while; two of another meet each other elsewhere. */
static void who_has_few_is_not_kept_waiting(void **state)
{
    (void)state;
    crowd c;
    set_up(&c, SLICE, 1, BROAD_AUTO);
    for (int i = 0; i < BALLS; i++) put_ball(&c, i, 1, vec(0.001 * i, 0, 0));
    world_remove_body(c.w, c.balls[BALLS - 1], CAUSE_REMOVED);
    world_remove_body(c.w, c.balls[BALLS - 2], CAUSE_REMOVED);
    put_ball(&c, BALLS - 2, 2, vec(1000, 0, 0));
    put_ball(&c, BALLS - 1, 2, vec(1010, 0, 0));
    tick(&c, 1);
    for (int64_t now = 2; now < 60; now++) {
        bool together = now % 2;
        move_ball(&c, BALLS - 1, vec(together ? 1001 : 1010, 0, 0));
        for (int i = 0; i < BALLS - 2; i++) move_ball(&c, i, vec(0.001 * i, 0.0001 * (double)now, 0));
        tick(&c, now);
        assert_true(world_pending_of(c.w, 1) > 0);
        assert_int_equal(world_pending_of(c.w, 2), 0);
        assert_int_equal(c.touch[BALLS - 2][BALLS - 1], together); /* in that tick */
    }
    world_destroy(c.w);
}

/* What nobody asked for is not looked at; who is asked for later is found. */
static void nobody_asked_nothing_is_searched(void **state)
{
    (void)state;
    crowd c;
    set_up(&c, SLICE, 1, BROAD_AUTO);
    world_batches none;
    world_remove_subscription(c.w, 0, CAUSE_SUBSCRIPTION);
    begin_in_one_place(&c);
    world_tick(c.w, 1, &none);
    world_figures f = world_get_figures(c.w);
    assert_int_equal(f.pairs, 0);
    assert_true(f.slice_units <= BALLS * 200); /* a look at each, and none at each two */
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(c.w, &all);
    tick(&c, 2);
    finish(&c, 3);
    assert_int_equal(world_get_figures(c.w).contacts, BALLS * (BALLS - 1) / 2);
    world_destroy(c.w);
}

/* Bodies go, rules and places change in the middle of it. */
static void what_changes_meanwhile_is_kept(void **state)
{
    (void)state;
    crowd c;
    uint64_t seed = 11;
    set_up(&c, SLICE, 2, BROAD_AUTO);
    begin_in_one_place(&c);
    int64_t now = 1;
    for (; now <= 300; now++) {
        int i = (int)(draw(&seed) * BALLS);
        if (now % 3 == 0) {
            world_remove_body(c.w, c.balls[i], CAUSE_REMOVED);
            tick(&c, now * 10);
            put_ball(&c, i, (uint64_t)(i % OWNERS), somewhere(&seed, 3));
        } else if (now % 3 == 1) {
            pose to = {somewhere(&seed, 30), {1, 0, 0, 0}};
            world_teleport_body(c.w, c.balls[i], to, 0, NULL, NULL);
            c.at[i] = to.p;
        } else {
            stir(&c, now, &seed);
        }
        tick(&c, now * 10 + 1);
    }
    finish(&c, now * 10);
    world_destroy(c.w);
}

/* A state says what there is, not what there was: how much of its slice a tick needs must not follow from the latter.
 * What is left of many bodies goes somewhere else together, and one more comes to them: near the end of the slice. */
static void what_was_there_once_changes_nothing(void **state)
{
    (void)state;
    enum { LEFT = 18, ENOUGH = 28000 };
    static crowd c[2];
    world_batches told;
    for (int k = 0; k < 2; k++) {
        set_up(&c[k], UINT64_MAX, 1, BROAD_AUTO);
        begin_in_one_place(&c[k]);
        move_ball(&c[k], LEFT, (vec3){100, 0, 0});
        world_tick(c[k].w, 1, &told);
        for (int i = LEFT + 1; i < BALLS; i++) world_remove_body(c[k].w, c[k].balls[i], CAUSE_REMOVED);
        world_tick(c[k].w, 2, &told);
        c[k].slice = ENOUGH;
        world_set_slice(c[k].w, ENOUGH);
    }
    be_reborn(&c[1]);
    uint64_t hashes[2];
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i <= LEFT; i++) move_ball(&c[k], i, (vec3){50 + 0.01 * i, 0, 0});
        world_tick(c[k].w, 3, &told);
        hashes[k] = told.hash;
    }
    assert_int_equal(world_was_sliced(c[0].w), world_was_sliced(c[1].w));
    assert_int_equal(world_get_figures(c[0].w).slice_units, world_get_figures(c[1].w).slice_units);
    assert_true(hashes[0] == hashes[1]);
    for (int k = 0; k < 2; k++) world_destroy(c[k].w);
}

static size_t count_of(const world_batches *batches, uint8_t kind)
{
    size_t count = 0;
    for (size_t i = 0; i < batches->count; i++)
        for (size_t k = 0; k < batches->at[i].count; k++) count += batches->at[i].events[k].kind == kind;
    return count;
}

/* A ball flies through another one in a tick that has no time for it: it is told when it is looked at, and once. */
static void no_impact_is_missed_for_a_cut(void **state)
{
    (void)state;
    enum { WALL = BALLS - 2, BULLET = BALLS - 1 };
    crowd c;
    size_t impacts = 0;
    world_batches batches;
    set_up(&c, SLICE, 1, BROAD_AUTO);
    world_subscription meet = {.facts = WORLD_IMPACT, .select_a = "b89", .select_b = "b88"};
    scene_subscription(c.w, &meet);
    for (int i = 0; i < WALL; i++) put_ball(&c, i, 1, vec(3.0 * i, 0, 0));
    put_ball(&c, WALL, 1, vec(0, 1000, 0));
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = "b89",
        .group = "",
        .owner = 1,
        .category = 1,
        .mask = UINT64_MAX,
        .ccd = WORLD_CCD_FULL,
        .pose = {vec(-20, 1000, 0), {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    c.balls[BULLET] = WORLD_NONE;
    assert_int_equal(world_put_body(c.w, &c.balls[BULLET], &def), WORLD_OK);
    int64_t now = 1;
    do world_tick(c.w, now++, &batches);
    while (world_get_figures(c.w).pending_bodies);
    for (int i = 0; i < WALL; i++) move_ball(&c, i, vec(0.001 * i, 0, 0)); /* the others, to one place */
    move_ball(&c, BULLET, vec(20, 1000, 0));
    do {
        world_tick(c.w, now++, &batches);
        impacts += count_of(&batches, EVENT_IMPACT);
    } while (world_get_figures(c.w).pending_bodies);
    assert_int_equal(impacts, 1);
    world_destroy(c.w);
}

/* ---- compounds: which of two equal ones is the first is found child by child, for each pair that begins ---- */

enum { CHILDREN = 255, A_CHILD = 40, COMPOUND_UNITS = 2000000 };

static compound *make_rake(void)
{
    static shape parts[CHILDREN];
    static pose locals[CHILDREN];
    compound *c;
    for (int i = 0; i < CHILDREN; i++) {
        parts[i] = (shape){.type = SHAPE_BOX, .half = {0.05, 0.1, 0.15}};
        locals[i] = (pose){{0.05 * i, 0, 0}, {1, 0, 0, 0}};
    }
    assert_int_equal(compound_build(parts, locals, CHILDREN, &c), COMPOUND_OK);
    return c;
}

static void put_rakes(world *w, const compound *rake, int from, int to)
{
    world_shape one = {.shape = {.type = SHAPE_COMPOUND, .compound = rake}, .local = POSE_IDENTITY};
    for (int i = from; i < to; i++) {
        char name[16];
        uint32_t id = WORLD_NONE;
        snprintf(name, sizeof name, "rake %d", i);
        world_body def = {.name = name,
            .group = "",
            .owner = 1,
            .category = 1,
            .mask = UINT64_MAX,
            .pose = POSE_IDENTITY,
            .shapes = &one,
            .shape_count = 1};
        assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    }
}

/* Some, and then as many as would have been taken in one tick. */
static void no_tick_puts_more_compounds_in_order_than_it_pays_for(void **state)
{
    enum { SOME = 60, ALL = 85 };
    (void)state;
    crowd c;
    compound *rake = make_rake();
    set_up(&c, COMPOUND_UNITS, 1, BROAD_AUTO);
    size_t before = 0;
    for (int there = SOME, from = 0, now = 1; from < ALL; from = there, there = ALL) {
        put_rakes(c.w, rake, from, there);
        for (size_t pairs = (size_t)there * (size_t)(there - 1) / 2; before < pairs; now++) {
            world_batches batches;
            world_tick(c.w, now, &batches);
            assert_in_range(world_get_figures(c.w).pairs - before, 0, 2 * COMPOUND_UNITS / (A_CHILD * CHILDREN));
            before = world_get_figures(c.w).pairs;
            assert_true(now < 10000);
        }
    }
    world_destroy(c.w);
    compound_destroy(rake);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_tick_takes_more_than_its_slice),
        cmocka_unit_test(all_kinds_and_workers_tell_the_same),
        cmocka_unit_test(a_slice_that_suffices_changes_nothing),
        cmocka_unit_test(who_has_few_is_not_kept_waiting),
        cmocka_unit_test(nobody_asked_nothing_is_searched),
        cmocka_unit_test(what_changes_meanwhile_is_kept),
        cmocka_unit_test(what_was_there_once_changes_nothing),
        cmocka_unit_test(no_impact_is_missed_for_a_cut),
        cmocka_unit_test(no_tick_puts_more_compounds_in_order_than_it_pays_for),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
