/* max_pairs: what exceeds it is left out, said, and comes in once others have parted; what is told stays true. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

/* Of MOST pairs a quarter is kept for owners who have few. */
enum { BALLS = 24, ALL_PAIRS = BALLS * (BALLS - 1) / 2, MOST = 52, ONE_HAS = MOST - MOST / 4 };

typedef struct crowd {
    world *w;
    uint32_t balls[BALLS];
    bool touch[BALLS][BALLS]; /* as told; a < b */
    size_t touching, undone;
} crowd;

static void set_up(crowd *c, size_t max_pairs, unsigned workers)
{
    world_options o = world_options_default();
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    *c = (crowd){0};
    o.max_pairs = max_pairs;
    o.workers = workers;
    c->w = world_create(&o);
    scene_subscription(c->w, &all);
    for (int i = 0; i < BALLS; i++) {
        char name[8] = {'b', (char)('a' + i)};
        c->balls[i] = scene_sphere(c->w, name, 10.0 * i, 1);
    }
}

static void hear(crowd *c, const world_event *e)
{
    int a = e->name_a[1] - 'a', b = e->name_b[1] - 'a';
    bool *touch = a < b ? &c->touch[a][b] : &c->touch[b][a];
    if (e->kind != EVENT_BEGIN && e->kind != EVENT_END) return;
    assert_int_equal(*touch, e->kind == EVENT_END); /* one begin and one end, in turns */
    *touch = e->kind == EVENT_BEGIN;
    c->touching += *touch ? 1 : (size_t)-1;
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
    return batches.hash;
}

static void gather(crowd *c, int from, int to, double x, double step, int64_t now_ns)
{
    for (int i = from; i < to; i++) scene_move(c->w, c->balls[i], x + step * i, now_ns);
}

static void what_exceeds_is_left_out_and_said(void **state)
{
    (void)state;
    crowd c;
    set_up(&c, MOST, 1);
    tick(&c, 1);
    assert_int_equal(world_get_figures(c.w).pairs_left_out, 0);
    assert_int_equal(c.undone, 0);
    gather(&c, 0, BALLS, 0, 0.01, 2);
    tick(&c, 2);
    assert_int_equal(world_get_figures(c.w).pairs, ONE_HAS);
    assert_int_equal(world_get_figures(c.w).pairs_left_out, ALL_PAIRS - ONE_HAS);
    assert_int_equal(c.undone, ALL_PAIRS - ONE_HAS);
    assert_int_equal(c.touching, ONE_HAS);
    world_destroy(c.w);
}

static void they_come_in_when_others_part(void **state)
{
    (void)state;
    crowd c;
    set_up(&c, MOST, 1);
    gather(&c, 0, BALLS, 0, 0.01, 1);
    tick(&c, 1);
    gather(&c, 8, BALLS, 1000, 10, 2); /* 28 pairs of the first eight are left: nobody of these moves */
    tick(&c, 2);
    assert_int_equal(world_get_figures(c.w).pairs, 28);
    assert_int_equal(world_get_figures(c.w).pairs_left_out, 0);
    assert_int_equal(c.touching, 28);
    assert_int_equal(c.undone, 0);
    for (int a = 0; a < 8; a++)
        for (int b = a + 1; b < 8; b++) assert_true(c.touch[a][b]);
    world_destroy(c.w);
}

static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

/* As a standby gets it. */
static void be_reborn(crowd *c, unsigned workers)
{
    bytes_out bytes = {0};
    world_options o = world_options_default();
    world_lender none = {0};
    world_save(c->w, &none, &bytes);
    world_destroy(c->w);
    o.max_pairs = MOST;
    o.workers = workers;
    c->w = world_create(&o);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    assert_null(world_restore(c->w, &none, &from));
    array_free(&bytes);
}

/* Beside a world without a limit, and one with other workers that is saved and restored: the same boxes meet, and what
 * is told is told there. */
static void what_is_told_is_true(void **state)
{
    (void)state;
    crowd few, many, same;
    uint64_t seed = 5;
    size_t full = 0, in = 0;
    set_up(&few, MOST, 1);
    set_up(&same, MOST, 3);
    set_up(&many, 0, 1);
    for (int64_t now = 1; now <= 2000; now++) {
        if (now % 150 == 0) be_reborn(&same, 3);
        double room = now / 100 % 2 ? 4 : 40;
        for (int n = 0; n < 4; n++) {
            int i = (int)(draw(&seed) * BALLS);
            double x = room * draw(&seed);
            scene_move(few.w, few.balls[i], x, now);
            scene_move(same.w, same.balls[i], x, now);
            scene_move(many.w, many.balls[i], x, now);
        }
        size_t most = (size_t)(now / 70 % 3 * 12); /* for want of memory: 0 is all of MOST */
        world_set_pairs_most(few.w, most);
        uint64_t hash = tick(&few, now);
        /* As a recording has it: only where some were left out. */
        world_set_pairs_most(same.w, world_get_figures(few.w).pairs_left_out ? most : 0);
        assert_true(tick(&same, now) == hash);
        if (now % 90 == 0) world_trim(same.w);
        tick(&many, now);
        world_figures f = world_get_figures(few.w), g = world_get_figures(many.w);
        assert_int_equal(f.pairs + f.pairs_left_out, g.pairs);
        assert_int_equal(f.pairs_left_out, few.undone);
        for (int a = 0; a < BALLS; a++)
            for (int b = 0; b < BALLS; b++) assert_true(!few.touch[a][b] || many.touch[a][b]);
        if (!f.pairs_left_out) assert_int_equal(few.touching, many.touching);
        full += f.pairs_left_out > 0;
        in += !f.pairs_left_out;
    }
    assert_true(full > 200 && in > 200);
    world_destroy(few.w);
    world_destroy(same.w);
    world_destroy(many.w);
}

static uint32_t put_ball(world *w, uint64_t owner, int number, double x, double y)
{
    char name[32];
    uint32_t id = WORLD_NONE;
    snprintf(name, sizeof name, "o%d b%d", (int)owner, number);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .owner = owner,
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {vec(x, y, 0), {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

typedef struct told { /* begins without ends */
    int flooder, own, mixed;
    uint64_t hash;
} told;

static void hear_of_all(world *w, int64_t now, told *t)
{
    world_batches batches;
    world_tick(w, now, &batches);
    const char *fault = world_validate(w);
    if (fault) fail_msg("%s", fault);
    t->hash = batches.hash;
    for (size_t i = 0; i < batches.count; i++) {
        for (size_t k = 0; !batches.at[i].snapshot && k < batches.at[i].count; k++) {
            const world_event *e = &batches.at[i].events[k];
            int change = e->kind == EVENT_BEGIN ? 1 : e->kind == EVENT_END ? -1 : 0;
            int others = (e->name_a[1] == '2') + (e->name_b[1] == '2');
            *(others == 2 ? &t->own : others ? &t->mixed : &t->flooder) += change;
        }
    }
}

/* Of 200 pairs one owner has 150; the others' own begin all the same, three of each (a 16th of what is kept), and not
 * those that he has with them: he pays for these. */
static void who_floods_leaves_room(uint64_t slice, unsigned workers, bool memory)
{
    enum { CROWD = 60, LIMIT = 200, OPEN = 150, SHARE = 3 };
    world_options o = world_options_default();
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    told t = {0}, again = {0};
    int64_t now = 1;
    o.max_pairs = memory ? 0 : LIMIT;
    o.workers = workers;
    world *w = world_create(&o);
    if (memory) world_set_pairs_most(w, LIMIT); /* then the boxes' pairs are few, too */
    scene_subscription(w, &all);
    hear_of_all(w, now++, &t);
    world_set_slice(w, slice);
    for (int i = 0; i < CROWD; i++) put_ball(w, 1, i, 0.001 * i, 0);
    while (now < 100 || world_get_figures(w).pending_bodies) hear_of_all(w, now++, &t);
    assert_int_equal(t.flooder, OPEN);
    uint32_t mine[SHARE];
    for (int i = 0; i < SHARE; i++) mine[i] = put_ball(w, 2, i, 100 + 0.001 * i, 0);
    put_ball(w, 2, SHARE, 0.5, 0); /* in the crowd */
    while (now < 200 || world_get_figures(w).pending_bodies) hear_of_all(w, now++, &t);
    assert_int_equal(t.own, SHARE);
    assert_int_equal(t.mixed, 0);
    assert_int_equal(t.flooder, OPEN);
    if (!memory) assert_int_equal(world_get_figures(w).pairs_left_out, CROWD * (CROWD - 1) / 2 - OPEN + CROWD);
    assert_int_equal(world_get_figures(w).parked_bodies > 0, memory);
    put_ball(w, 2, SHARE + 1, 100.5, 0); /* three more of his, which are more than his share */
    while (now < 300 || world_get_figures(w).pending_bodies) hear_of_all(w, now++, &t);
    assert_int_equal(t.own, SHARE);

    bytes_out bytes = {0}; /* and a standby goes on from here in the same way */
    world_lender none = {0};
    world_save(w, &none, &bytes);
    world *same = world_create(&o);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    assert_null(world_restore(same, &none, &from));
    array_free(&bytes);
    world_set_slice(same, slice);
    if (memory) world_set_pairs_most(same, LIMIT);
    for (int i = 0; i < 40; i++, now++) {
        for (int k = 0; k < 2; k++) {
            scene_move(k ? same : w, mine[0], i % 8 < 4 ? 1000 : 100, now); /* a place is free, and taken again */
            hear_of_all(k ? same : w, now, k ? &again : &t);
        }
        assert_true(t.hash == again.hash);
        assert_true(t.own >= 1 && t.own <= SHARE);
    }
    world_destroy(w);
    world_destroy(same);
}

static void who_floods_leaves_room_for_others(void **state)
{
    (void)state;
    who_floods_leaves_room(UINT64_MAX, 1, false);
    who_floods_leaves_room(2000, 2, false);
    who_floods_leaves_room(20000000, 1, false);
    who_floods_leaves_room(20000000, 3, true);
}

/* What is given back is had again: as much as it was, with the same events; in slices, too, where pairs come and are
 * decided in the order in which the broad phase has them. */
static void give_back(uint64_t slice, int moves, size_t limit)
{
    enum { HEAP = 350, ROUNDS = 8 };
    world *w[2];
    uint32_t ball[2][HEAP];
    size_t most = 0;
    for (int k = 0; k < 2; k++) {
        world_options o = world_options_default();
        world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE, 0.1);
        w[k] = world_create(&o);
        scene_subscription(w[k], &all);
        for (int i = 0; i < HEAP; i++) {
            char name[16];
            snprintf(name, sizeof name, "b%d", i);
            ball[k][i] = scene_sphere(w[k], name, 10.0 * i, 1);
        }
    }
    for (int64_t now = 1; now <= ROUNDS * moves; now++) {
        uint64_t hash[2];
        int64_t round = (now - 1) / moves;
        for (int k = 0; k < 2; k++) {
            world_batches batches;
            double step = round % 2 ? 10 : 0.001; /* all in one place, or each alone; some stay there */
            for (int i = round % 3 ? 20 : 0; i < HEAP && now % moves == 0; i++)
                scene_move(w[k], ball[k][i], step * i, now);
            world_set_slice(w[k], slice);
            world_set_pairs_most(w[k], limit);
            world_tick(w[k], now, &batches);
            hash[k] = batches.hash;
            if (k) world_trim(w[k]);
            const char *fault = world_validate(w[k]);
            if (fault) fail_msg("%s", fault);
        }
        if (hash[0] != hash[1]) fail_msg("tick %d differs", (int)now);
        size_t pairs = world_get_figures(w[1]).pairs;
        if (pairs > most) most = pairs;
        if (limit) assert_true(pairs <= limit);
    }
    assert_true(most > (limit ? limit / 2 : 50000));
    for (int k = 0; k < 2; k++) world_destroy(w[k]);
}

static void memory_given_back_changes_no_event(void **state)
{
    (void)state;
    give_back(UINT64_MAX, 1, 0);
    give_back(20000000, 10, 0);
    give_back(20000000, 10, 3000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_exceeds_is_left_out_and_said),
        cmocka_unit_test(they_come_in_when_others_part),
        cmocka_unit_test(what_is_told_is_true),
        cmocka_unit_test(who_floods_leaves_room_for_others),
        cmocka_unit_test(memory_given_back_changes_no_event),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
