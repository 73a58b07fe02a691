/* Very much that ends: a subscription that closes or changes, bodies that go or get other shapes, snapshots. With a
 * slice no tick tells more of it than the slice allows; in the end all has begun and ended once, for each number of
 * workers, each way of finding boxes that meet, and after a state was handed over in the middle. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

enum { BALLS = 60, SLICE = 20000, IDS = 1 << 19, SUBSCRIPTIONS = 8, A_TICK_AT_MOST = 150 };
enum { PAIRS = BALLS * (BALLS - 1) / 2 };

typedef struct crowd {
    world *w;
    world_options options;
    uint64_t slice;
    uint32_t balls[BALLS];
    bool there[BALLS];
    vec3 at[BALLS];
    double radius[BALLS];
    uint8_t ids[IDS];                        /* 0: never begun, 1: begun, 2: ended */
    bool touch[SUBSCRIPTIONS][BALLS][BALLS]; /* as told; a < b */
    size_t ends_most;                        /* of a tick */
    size_t begins, ends, closed, lost;
    size_t undone[SUBSCRIPTIONS];
} crowd;

static crowd *set_up(uint64_t slice, unsigned workers, broad_kind kind)
{
    crowd *c = calloc(1, sizeof *c);
    c->options = world_options_default();
    c->options.workers = workers;
    c->options.broad = kind;
    c->slice = slice;
    c->w = world_create(&c->options);
    world_set_slice(c->w, slice);
    return c;
}

static void tear_down(crowd *c)
{
    world_destroy(c->w);
    free(c);
}

static void put_ball(crowd *c, int i, vec3 at, double radius)
{
    char name[8];
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = radius}, .local = POSE_IDENTITY};
    snprintf(name, sizeof name, "b%02d", i);
    world_body def = {.name = name,
        .group = "",
        .owner = (uint64_t)(i % 3),
        .category = 1,
        .mask = UINT64_MAX,
        .pose = {at, {1, 0, 0, 0}},
        .shapes = &ball,
        .shape_count = 1};
    if (!c->there[i]) c->balls[i] = WORLD_NONE;
    assert_int_equal(world_put_body(c->w, &c->balls[i], &def), WORLD_OK);
    c->at[i] = at;
    c->radius[i] = radius;
    c->there[i] = true;
}

static void remove_ball(crowd *c, int i)
{
    assert_int_equal(world_remove_body(c->w, c->balls[i], CAUSE_REMOVED), WORLD_OK);
    c->there[i] = false;
}

static void hear(crowd *c, uint32_t subscription, const world_event *e)
{
    if (e->kind != EVENT_BEGIN && e->kind != EVENT_END) return;
    int a = atoi(e->name_a + 1), b = atoi(e->name_b + 1);
    bool begins = e->kind == EVENT_BEGIN, *touch = &c->touch[subscription][a < b ? a : b][a < b ? b : a];
    assert_true(e->contact > 0 && e->contact < IDS);
    assert_int_equal(c->ids[e->contact], begins ? 0 : 1); /* each id begins once, and ends once */
    c->ids[e->contact]++;
    assert_int_equal(*touch, !begins); /* under its names, too, one ends before another begins */
    *touch = begins;
    c->begins += begins;
    c->ends += !begins;
    c->lost += !begins && e->cause == CAUSE_OWNER_LOST;
}

static uint64_t tick(crowd *c, int64_t now_ns)
{
    world_batches batches;
    size_t ends = c->ends;
    world_tick(c->w, now_ns, &batches);
    const char *fault = world_validate(c->w);
    if (fault) fail_msg("%s", fault);
    for (size_t i = 0; i < batches.count; i++) {
        const world_batch *b = &batches.at[i];
        c->undone[b->subscription] = b->undone;
        c->closed += b->closing;
        for (size_t k = 0; !b->snapshot && k < b->count; k++) hear(c, b->subscription, &b->events[k]);
    }
    if (c->ends - ends > c->ends_most) c->ends_most = c->ends - ends;
    return batches.hash;
}

static bool is_at_rest(const crowd *c)
{
    return !world_changed(c->w);
}

static int64_t settle(crowd *c, int64_t now_ns)
{
    for (int n = 0; !is_at_rest(c); n++) {
        assert_true(n < 5000);
        tick(c, ++now_ns);
    }
    return now_ns;
}

static void is_told_what_is_so(const crowd *c, uint32_t subscription)
{
    for (int a = 0; a < BALLS; a++)
        for (int b = a + 1; b < BALLS; b++) {
            bool meet = vec_norm(vec_sub(c->at[a], c->at[b])) <= c->radius[a] + c->radius[b];
            assert_int_equal(c->touch[subscription][a][b], c->there[a] && c->there[b] && meet);
        }
    assert_int_equal(c->undone[subscription], 0);
}

static void nothing_stands(const crowd *c)
{
    for (int id = 0; id < IDS; id++) assert_int_not_equal(c->ids[id], 1);
    assert_int_equal(world_get_figures(c->w).contacts, 0);
    assert_int_equal(c->begins, c->ends);
}

static int64_t begin_in_one_place(crowd *c)
{
    for (int i = 0; i < BALLS; i++) put_ball(c, i, vec(0.001 * i, 0, 0), 1);
    return settle(c, 1);
}

static void an_subscription_closes_in_slices(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(c->w, &all);
    int64_t now = begin_in_one_place(c);
    is_told_what_is_so(c, id);
    assert_int_equal(world_remove_subscription(c->w, id, CAUSE_OWNER_LOST), WORLD_OK);
    tick(c, ++now);
    assert_true(world_is_closing(c->w));
    assert_true(c->ends > 0);
    assert_int_equal(c->closed, 0);
    settle(c, now);
    assert_int_equal(c->closed, 1); /* with the last of it */
    assert_int_equal(c->ends, PAIRS);
    assert_int_equal(c->lost, PAIRS); /* whoever ends a pair that nobody wants any more */
    assert_true(c->ends_most <= A_TICK_AT_MOST);
    nothing_stands(c);
    tick(c, now + 5001);
    assert_int_equal(world_get_figures(c->w).subscriptions, 0);
    tear_down(c);
}

/* Who has little to close does not wait for who has much. */
static void who_closes_little_is_closed_at_once(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription all = scene_all(WORLD_TOUCH, 0), few = all;
    few.select_a = "b00";
    few.select_b = "b0*";
    uint32_t much = scene_subscription(c->w, &all), little = scene_subscription(c->w, &few);
    int64_t now = begin_in_one_place(c);
    world_remove_subscription(c->w, much, CAUSE_SUBSCRIPTION);
    tick(c, ++now);
    world_remove_subscription(c->w, little, CAUSE_SUBSCRIPTION);
    tick(c, ++now);
    assert_int_equal(c->closed, 1);
    assert_true(world_is_closing(c->w));
    settle(c, now);
    nothing_stands(c);
    tear_down(c);
}

/* What was told under the old terms ends before anything is told of it under the new ones. */
static void terms_change_in_slices(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription terms = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(c->w, &terms);
    int64_t now = begin_in_one_place(c);
    for (int i = 1; i <= 4; i++) {
        terms.hysteresis = 0.001 * i;
        assert_int_equal(world_put_subscription(c->w, &id, &terms), WORLD_OK);
        for (int n = 0; n < 7 * i; n++) tick(c, ++now);
        assert_true(i == 4 || c->undone[id]);
    }
    assert_true(c->ends_most <= A_TICK_AT_MOST);
    now = settle(c, now);
    assert_true(c->begins >= 2 * (size_t)PAIRS);
    is_told_what_is_so(c, id);
    tear_down(c);
}

static void bodies_leave_in_slices(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(c->w, &all);
    int64_t now = begin_in_one_place(c);
    for (int i = 0; i < BALLS; i++) remove_ball(c, i);
    tick(c, ++now);
    assert_true(world_changed(c->w));
    assert_true(c->undone[id] > 0);
    assert_true(world_pending_of(c->w, 1) > 0);
    assert_int_equal(world_pending_of(c->w, 7), 0);
    settle(c, now);
    assert_int_equal(c->ends, PAIRS);
    assert_true(c->ends_most <= A_TICK_AT_MOST);
    is_told_what_is_so(c, id);
    nothing_stands(c);
    assert_int_equal(world_get_figures(c->w).pairs, 0);
    tear_down(c);
}

/* The same names again, at once, and in the middle of it: and of those that stay, other shapes. */
static void what_comes_again_waits_for_what_leaves(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(c->w, &all);
    int64_t now = begin_in_one_place(c);
    for (int i = 0; i < BALLS; i += 2) remove_ball(c, i);
    for (int i = 0; i < BALLS; i += 4) put_ball(c, i, vec(0.002 * i, 0, 0), 1);
    tick(c, ++now);
    tick(c, ++now);
    for (int i = 2; i < BALLS; i += 4) put_ball(c, i, vec(0.002 * i, 0, 0), 1);
    for (int i = 1; i < BALLS; i += 2) put_ball(c, i, c->at[i], 0.5);
    tick(c, ++now);
    for (int i = 0; i < BALLS; i += 5) remove_ball(c, i);
    tick(c, ++now);
    for (int i = 0; i < BALLS; i += 5) put_ball(c, i, vec(0.003 * i, 0, 0), 1);
    now = settle(c, now);
    is_told_what_is_so(c, id);
    for (int i = 0; i < BALLS; i++) remove_ball(c, i);
    settle(c, now);
    is_told_what_is_so(c, id);
    nothing_stands(c);
    tear_down(c);
}

/* Whose poses stop all at once are unknown within some ticks, each of which is due. */
static void many_become_stale_in_slices(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(c->w, &all);
    begin_in_one_place(c);
    for (int i = 0; i < BALLS; i++) assert_int_equal(world_hold_body(c->w, c->balls[i]), WORLD_OK);
    size_t most = 0, before = 0;
    int64_t now = 6000;
    for (; before < BALLS; now++) {
        assert_true(now < 6200);
        assert_true(world_next_due_ns(c->w) <= now);
        tick(c, now);
        size_t stale = world_get_figures(c->w).stale_bodies;
        most = stale - before > most ? stale - before : most;
        before = stale;
    }
    assert_true(most <= 2);
    assert_true(world_next_due_ns(c->w) > now);
    tear_down(c);
}

/* ---- snapshots ---- */

/* What stands by the events of ticks, when the snapshot begins, is what its portions tell, though all goes on. */
typedef struct image {
    uint8_t ids[IDS]; /* 1: stood when it began */
    size_t told, most, portions;
} image;

static void hear_image(image *m, const world_batch *b)
{
    assert_int_equal(b->goes_on, m->portions > 0);
    m->portions++;
    if (b->count > m->most) m->most = b->count;
    for (size_t k = 0; k < b->count; k++) {
        const world_event *e = &b->events[k];
        assert_int_equal(e->kind, EVENT_BEGIN);
        assert_int_equal(e->cause, CAUSE_SNAPSHOT);
        assert_int_equal(m->ids[e->contact], 1); /* each once, and none that began later */
        m->ids[e->contact] = 2;
        m->told++;
    }
}

/* Until it is whole. Balls go away, and come again, all the while; nothing of that is in it. */
static int64_t take_snapshot(crowd *c, uint32_t id, int64_t now, bool stirs, image *m)
{
    bool over = false;
    *m = (image){.told = 0};
    world_want_snapshot(c->w, id);
    for (int n = 0; !over; n++) {
        world_batches batches;
        assert_true(n < 1000);
        for (int i = n % 5; stirs && n && i < BALLS; i += 5) put_ball(c, i, vec(n % 2 ? 9 : 0.001 * i, 0, 0), 1);
        world_tick(c->w, ++now, &batches);
        const char *fault = world_validate(c->w);
        if (fault) fail_msg("%s", fault);
        for (size_t i = 0; i < batches.count; i++) {
            const world_batch *b = &batches.at[i];
            for (size_t k = 0; !b->snapshot && k < b->count; k++) hear(c, b->subscription, &b->events[k]);
            if (b->snapshot && !b->goes_on) memcpy(m->ids, c->ids, sizeof m->ids);
            if (b->snapshot) hear_image(m, b);
            over |= b->snapshot && !b->more;
        }
    }
    return now;
}

static void a_snapshot_is_told_in_portions(void **state)
{
    (void)state;
    crowd *c = set_up(SLICE, 1, BROAD_AUTO);
    image *m = calloc(1, sizeof *m);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    uint32_t id = scene_subscription(c->w, &all);
    int64_t now = begin_in_one_place(c);
    for (int stirs = 0; stirs < 2; stirs++) {
        now = take_snapshot(c, id, now, stirs, m);
        assert_true(m->portions > 10);
        assert_true(m->most <= A_TICK_AT_MOST);
        assert_int_equal(m->told, PAIRS);
        for (int k = 0; k < IDS; k++) assert_int_not_equal(m->ids[k], 1); /* all that stood then */
        now = settle(c, now);
        is_told_what_is_so(c, id);
        for (int i = 0; i < BALLS; i++) put_ball(c, i, vec(0.001 * i, 0, 0), 1);
        now = settle(c, now);
    }
    free(m);
    tear_down(c);
}

/* Nobody's asking for one changes an event. */
static void who_asks_for_snapshots_changes_nothing(void **state)
{
    (void)state;
    crowd *c[2];
    uint32_t id[2];
    for (int k = 0; k < 2; k++) {
        world_subscription all = scene_all(WORLD_TOUCH, 0);
        c[k] = set_up(SLICE, 1, BROAD_AUTO);
        id[k] = scene_subscription(c[k]->w, &all);
        begin_in_one_place(c[k]);
    }
    for (int64_t now = 6000; now < 6100; now++) {
        for (int k = 0; k < 2; k++)
            for (int i = (int)now % 7; i < BALLS; i += 7) put_ball(c[k], i, vec(now % 3 ? 9 : 0, 0, 0), 1);
        if (now % 10 == 0) world_want_snapshot(c[1]->w, id[1]);
        assert_true(tick(c[0], now) == tick(c[1], now));
    }
    tear_down(c[0]);
    tear_down(c[1]);
}

/* ---- the same for all ---- */

static double draw(uint64_t *seed)
{
    *seed = *seed * 6364136223846793005u + 1442695040888963407u;
    return (double)(*seed >> 11) * 0x1p-53;
}

static vec3 somewhere(uint64_t *seed)
{
    double x = draw(seed), y = draw(seed);
    return vec(3 * x, 3 * y, 0);
}

/* One of a few balls goes, comes, changes; now and then all of them, and subscriptions as well. */
static void stir(crowd *c, int64_t now, uint64_t *seed, uint32_t subscriptions[3])
{
    double many = now % 25 == 0 ? 0.7 : 0.03;
    for (int i = 0; i < BALLS; i++) {
        vec3 at = somewhere(seed);
        double what = draw(seed);
        if (draw(seed) > many) continue;
        if (!c->there[i])
            put_ball(c, i, at, 1);
        else if (what < 0.5)
            remove_ball(c, i);
        else
            put_ball(c, i, at, what < 0.75 ? c->radius[i] : 0.5 + 0.5 * (double)(now % 2));
    }
    int k = (int)(3 * draw(seed));
    world_subscription terms = scene_all(WORLD_TOUCH, 0);
    terms.hysteresis = 0.01 * draw(seed);
    double what = draw(seed);
    if (now % 11) return;
    if (subscriptions[k] != WORLD_NONE && what < 0.5) {
        assert_int_equal(world_remove_subscription(c->w, subscriptions[k], CAUSE_SUBSCRIPTION), WORLD_OK);
        subscriptions[k] = WORLD_NONE;
    } else {
        assert_int_equal(world_put_subscription(c->w, &subscriptions[k], &terms), WORLD_OK);
    }
}

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

static void all_kinds_and_workers_tell_the_same(void **state)
{
    (void)state;
    enum { WORLDS = 5, TICKS = 300 };
    static const broad_kind kinds[WORLDS] = {BROAD_TREE, BROAD_SWEEP1, BROAD_SWEEP3, BROAD_AUTO, BROAD_TREE};
    static const unsigned workers[WORLDS] = {1, 2, 3, 8, 1};
    crowd *c[WORLDS];
    uint32_t subscriptions[WORLDS][3];
    uint64_t seeds[WORLDS];
    size_t closing = 0;
    for (int k = 0; k < WORLDS; k++) {
        c[k] = set_up(SLICE, workers[k], kinds[k]);
        seeds[k] = 5;
        for (int i = 0; i < 3; i++) subscriptions[k][i] = WORLD_NONE;
        world_subscription all = scene_all(WORLD_TOUCH, 0);
        subscriptions[k][0] = scene_subscription(c[k]->w, &all);
    }
    for (int64_t now = 1; now <= TICKS; now++) {
        uint64_t hash = 0;
        for (int k = 0; k < WORLDS; k++) {
            if (k == WORLDS - 1 && now % 3 == 0) be_reborn(c[k]);
            stir(c[k], now, &seeds[k], subscriptions[k]);
            uint64_t is = tick(c[k], now);
            if (k == 0) hash = is;
            if (is != hash) fail_msg("tick %d: world %d tells something else", (int)now, k);
        }
        closing += world_is_closing(c[0]->w);
    }
    assert_true(closing > 10);
    for (int k = 0; k < WORLDS; k++) {
        settle(c[k], TICKS + 1);
        for (int i = 0; i < 3; i++)
            if (subscriptions[k][i] != WORLD_NONE) is_told_what_is_so(c[k], subscriptions[k][i]);
        tear_down(c[k]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_subscription_closes_in_slices),
        cmocka_unit_test(who_closes_little_is_closed_at_once),
        cmocka_unit_test(terms_change_in_slices),
        cmocka_unit_test(bodies_leave_in_slices),
        cmocka_unit_test(what_comes_again_waits_for_what_leaves),
        cmocka_unit_test(many_become_stale_in_slices),
        cmocka_unit_test(a_snapshot_is_told_in_portions),
        cmocka_unit_test(who_asks_for_snapshots_changes_nothing),
        cmocka_unit_test(all_kinds_and_workers_tell_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
