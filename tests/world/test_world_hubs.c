/* One body with very many partners, and pairs that there was no room for: what is to be told of them, or to begin,
 * comes in as many ticks as it takes, each once, and no tick has more of it than its slice allows. */
#include "scene.h"
#include "world/saved.h"

#include <stdio.h>
#include <stdlib.h>

enum { PARTNERS = 3000, SIDE = 15, SLICE = 400000, A_TICK = 100 /* pairs that are told to be unknown */, CAUSES = 10 };
static const int64_t DEADLINE_NS = 1000000000000;

typedef struct hub {
    world *w;
    uint32_t id;
    int64_t now_ns;
    size_t told[EVENT_AVERTED + 1], most, ticks; /* events of pairs, by kind; most: in one tick */
    bool unknown[PARTNERS];                      /* as told */
} hub;

static void hear(hub *h, const world_event *e)
{
    if (!e->contact) return; /* of a whole body */
    int k = atoi((e->name_a[0] == 'h' ? e->name_b : e->name_a) + 1);
    h->told[e->kind]++;
    if (e->kind == EVENT_UNKNOWN || e->kind == EVENT_KNOWN) {
        assert_int_equal(h->unknown[k], e->kind == EVENT_KNOWN);
        h->unknown[k] = e->kind == EVENT_UNKNOWN;
    }
}

static void tick(hub *h)
{
    world_batches batches;
    size_t before = h->told[EVENT_UNKNOWN];
    world_tick(h->w, ++h->now_ns, &batches);
    const char *fault = world_validate(h->w);
    if (fault) fail_msg("%s", fault);
    for (size_t i = 0; i < batches.count; i++)
        for (size_t k = 0; !batches.at[i].snapshot && k < batches.at[i].count; k++) hear(h, &batches.at[i].events[k]);
    size_t told = h->told[EVENT_UNKNOWN] - before;
    h->ticks += told > 0;
    if (told > h->most) h->most = told;
}

static void set_up(hub *h, uint64_t slice)
{
    char name[16];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    *h = (hub){.w = scene_world(1, true)};
    scene_subscription(h->w, &all);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    for (int i = 0; i < PARTNERS; i++) {
        snprintf(name, sizeof name, "b%d", i);
        scene_body(h->w, name, ball, (vec3){i % SIDE * 3.0, i / SIDE % SIDE * 3.0, i / SIDE / SIDE * 3.0});
    }
    ball.shape.radius = 10 * SIDE;
    world_body def = {.name = "hub",
        .group = "",
        .category = 1,
        .mask = UINT64_MAX,
        .pose = POSE_IDENTITY,
        .deadline_ns = DEADLINE_NS,
        .shapes = &ball,
        .shape_count = 1};
    h->id = WORLD_NONE;
    assert_int_equal(world_put_body(h->w, &h->id, &def), WORLD_OK);
    tick(h);
    assert_int_equal(h->told[EVENT_BEGIN], PARTNERS);
    world_set_slice(h->w, slice);
    h->now_ns += DEADLINE_NS;
}

static bool is_due(const hub *h)
{
    return world_changed(h->w) || world_next_due_ns(h->w) <= h->now_ns;
}

/* As a standby gets it. */
static void be_reborn(hub *h)
{
    bytes_out bytes = {0};
    world_lender none = {0};
    world_save(h->w, &none, &bytes);
    world_destroy(h->w);
    h->w = scene_world(1, true);
    world_set_slice(h->w, SLICE);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    const char *wrong = world_restore(h->w, &none, &from);
    if (wrong) fail_msg("%s", wrong);
    array_free(&bytes);
}

/* A body as a whole at once, its pairs in slices; the state goes to another world in the middle of it. */
static void that_a_body_is_unknown_is_told_of_its_pairs_in_slices(void **state)
{
    bool whole = *state != NULL;
    hub h;
    set_up(&h, whole ? UINT64_MAX : SLICE);
    tick(&h);
    for (int i = 0; is_due(&h); i++) {
        if (!whole && i == 10) be_reborn(&h);
        tick(&h);
    }
    assert_int_equal(h.told[EVENT_UNKNOWN], PARTNERS);
    assert_int_equal(h.most, whole ? PARTNERS : A_TICK);
    assert_int_equal(h.ticks, whole ? 1 : PARTNERS / A_TICK);
    world_destroy(h.w);
}

/* Of those that were told nothing yet, nothing was unknown. */
static void what_is_known_again_meanwhile_was_never_unknown(void **state)
{
    (void)state;
    hub h;
    set_up(&h, SLICE);
    for (int i = 0; i < 10; i++) tick(&h);
    assert_int_equal(h.told[EVENT_UNKNOWN], 10 * A_TICK);
    world_set_slice(h.w, UINT64_MAX);
    scene_move(h.w, h.id, 0.01, h.now_ns);
    do tick(&h);
    while (is_due(&h));
    assert_int_equal(h.told[EVENT_UNKNOWN], 10 * A_TICK);
    assert_int_equal(h.told[EVENT_KNOWN], 10 * A_TICK);
    assert_int_equal(h.told[EVENT_END], 0);
    world_destroy(h.w);
}

/* Some of them end meanwhile: nothing more is told of those. */
static void what_ends_meanwhile_is_not_told_to_be_unknown(void **state)
{
    (void)state;
    hub h;
    set_up(&h, SLICE);
    for (int i = 0; i < 10; i++) tick(&h);
    assert_int_equal(world_remove_body(h.w, h.id, CAUSE_REMOVED), WORLD_OK);
    do tick(&h);
    while (is_due(&h));
    assert_int_equal(h.told[EVENT_END], PARTNERS);
    assert_true(h.told[EVENT_UNKNOWN] < PARTNERS);
    world_destroy(h.w);
}

/* ---- a body of so many pairs that no tick can look at all of them ---- */

/* BESIDE: units of what a tick does beside its slice, a look at all bodies by their names among it. */
enum { MANY = 40000, MANY_SIDE = 35, MANY_SLICE = 2000000, BESIDE = 3000000 };

typedef struct plenty {
    world *w;
    uint32_t hub;
    int64_t now_ns;
    uint64_t most_units, hash;
    size_t begun, ended;
} plenty;

static void tick_plenty(plenty *h)
{
    world_batches batches;
    world_tick(h->w, ++h->now_ns, &batches);
    uint64_t units = world_get_figures(h->w).slice_units;
    if (units > h->most_units) h->most_units = units;
    h->hash = batches.hash;
    for (size_t i = 0; i < batches.count; i++)
        for (size_t k = 0; !batches.at[i].snapshot && k < batches.at[i].count; k++) {
            h->begun += batches.at[i].events[k].kind == EVENT_BEGIN;
            h->ended += batches.at[i].events[k].kind == EVENT_END;
        }
}

static void set_up_plenty(plenty *h, unsigned workers)
{
    char name[16];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    *h = (plenty){.w = scene_world(workers, true)};
    scene_subscription(h->w, &all);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "b%d", i);
        scene_body(h->w, name, ball,
            (vec3){i % MANY_SIDE * 3.0, i / MANY_SIDE % MANY_SIDE * 3.0, i / MANY_SIDE / MANY_SIDE * 3.0});
    }
    ball.shape.radius = 10 * MANY_SIDE;
    h->hub = scene_body(h->w, "hub", ball, (vec3){0, 0, 0});
    tick_plenty(h);
    assert_int_equal(h->begun, MANY);
    world_set_slice(h->w, MANY_SLICE);
    h->most_units = 0;
}

static void restore_plenty(plenty *h)
{
    bytes_out bytes = {0};
    world_lender none = {0};
    world_save(h->w, &none, &bytes);
    world_destroy(h->w);
    h->w = scene_world(1, true);
    world_set_slice(h->w, MANY_SLICE);
    bytes_in from = {.at = bytes.at, .left = bytes.count};
    const char *wrong = world_restore(h->w, &none, &from);
    if (wrong) fail_msg("%s", wrong);
    array_free(&bytes);
}

/* Half of them part from it; it moves again before all have had their turn, and so do some of the others. */
static void a_tick_looks_at_some_of_very_many_partners(void **state)
{
    (void)state;
    enum { WORLDS = 3, MOST_TICKS = 2000 };
    plenty h[WORLDS];
    size_t rounds = 0;
    for (int k = 0; k < WORLDS; k++) set_up_plenty(&h[k], k == 1 ? 3 : 1);
    for (bool due = true; due; rounds++) {
        assert_true(rounds < MOST_TICKS);
        for (int k = 0; k < WORLDS; k++) {
            if (rounds == 0) scene_move(h[k].w, h[k].hub, -10.0 * MANY_SIDE + 50, h[k].now_ns);
            if (rounds == 10) scene_move(h[k].w, h[k].hub, -10.0 * MANY_SIDE + 51, h[k].now_ns);
            if (k == 2 && rounds % 16 == 5) restore_plenty(&h[k]);
            tick_plenty(&h[k]);
            if (h[k].hash != h[0].hash) fail_msg("tick %zu: world %d tells something else", rounds, k);
        }
        due = rounds < 12 || world_changed(h[0].w);
    }
    plenty whole;
    set_up_plenty(&whole, 1);
    world_set_slice(whole.w, UINT64_MAX);
    scene_move(whole.w, whole.hub, -10.0 * MANY_SIDE + 51, whole.now_ns);
    for (int i = 0; i < 3; i++) tick_plenty(&whole);
    assert_in_range(whole.ended, MANY / 8, MANY - 1);
    for (int k = 0; k < WORLDS; k++) {
        assert_int_equal(h[k].ended - (h[k].begun - MANY), whole.ended);
        assert_in_range(h[k].most_units, 1, MANY_SLICE + BESIDE);
        assert_null(world_validate(h[k].w));
        world_destroy(h[k].w);
    }
    print_message("%zu ticks, at most %zu units in one\n", rounds, (size_t)h[0].most_units);
    world_destroy(whole.w);
}

/* ---- pairs that there was no room for ---- */

enum { CROWD = 200, MOST = 8000, LET_IN = 64 /* a tick */ };

typedef struct crowd {
    world *w;
    uint32_t balls[CROWD];
    int64_t now_ns;
} crowd;

static world_figures tick_crowd(crowd *c)
{
    world_batches batches;
    world_tick(c->w, ++c->now_ns, &batches);
    const char *fault = world_validate(c->w);
    if (fault) fail_msg("%s", fault);
    return world_get_figures(c->w);
}

static void set_up_crowd(crowd *c, uint64_t slice)
{
    char name[16];
    world_options o = world_options_default();
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    o.workers = 1;
    o.max_pairs = MOST;
    *c = (crowd){.w = world_create(&o)};
    scene_subscription(c->w, &all);
    for (int i = 0; i < CROWD; i++) {
        snprintf(name, sizeof name, "b%d", i);
        c->balls[i] = scene_sphere(c->w, name, 1e-3 * i, 1);
    }
    tick_crowd(c);
    world_set_slice(c->w, slice);
    /* Those that have pairs go: there is room for many others at once. */
    for (int i = 0; i < 30; i++) assert_int_equal(world_remove_body(c->w, c->balls[i], CAUSE_REMOVED), WORLD_OK);
}

/* In the end as many as without slices, and no tick lets in more than its own. */
static void what_was_left_out_is_let_in_in_slices(void **state)
{
    (void)state;
    crowd whole, cut;
    set_up_crowd(&whole, UINT64_MAX);
    set_up_crowd(&cut, SLICE);
    world_figures f = {0}, g = {0};
    for (int i = 0; i < 3 || world_changed(whole.w); i++) f = tick_crowd(&whole);
    size_t rounds = 0, before = world_get_figures(cut.w).pairs, most = 0;
    for (; rounds < 3 || world_changed(cut.w); rounds++) {
        g = tick_crowd(&cut);
        if (g.pairs > before && g.pairs - before > most) most = g.pairs - before;
        before = g.pairs;
    }
    assert_in_range(most, 1, LET_IN);
    assert_true(rounds > 20);
    assert_true(g.pairs_left_out > 0 && g.pairs + g.pairs_left_out == f.pairs + f.pairs_left_out);
    assert_in_range(g.pairs, f.pairs - MOST / 16, f.pairs + MOST / 16);
    world_destroy(whole.w);
    world_destroy(cut.w);
}

int main(void)
{
    static int whole = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(that_a_body_is_unknown_is_told_of_its_pairs_in_slices),
        cmocka_unit_test_prestate(that_a_body_is_unknown_is_told_of_its_pairs_in_slices, &whole),
        cmocka_unit_test(what_is_known_again_meanwhile_was_never_unknown),
        cmocka_unit_test(what_ends_meanwhile_is_not_told_to_be_unknown),
        cmocka_unit_test(a_tick_looks_at_some_of_very_many_partners),
        cmocka_unit_test(what_was_left_out_is_let_in_in_slices),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
