/* A world that grows and shrinks, so that auto changes its broad phase: the events are those of every other choice. */
#include "scene.h"

#include <stdio.h>

enum { BODIES = 400, FEW = 60, TICKS = 240, PHASE = 40 };

typedef struct played {
    uint64_t hash, events;
    unsigned changes; /* of the broad phase that stands */
} played;

/* Ball `k` swings by its own period about its own place. */
static double place_at(int k, int tick)
{
    int period = 20 + k % 17, at = (tick + 3 * k) % period;
    int swing = at < period / 2 ? at : period - at;
    return 0.9 * k + 0.1 * swing;
}

static void grow_to(world *w, uint32_t *ids, int *count, int wanted)
{
    char name[16];
    for (; *count < wanted; ++*count) {
        snprintf(name, sizeof name, "ball%d", *count);
        ids[*count] = scene_sphere(w, name, place_at(*count, 0), 0.4);
    }
    for (; *count > wanted; --*count) world_remove_body(w, ids[*count - 1], CAUSE_REMOVED);
}

static played play(broad_kind kind)
{
    world_options options = world_options_default();
    options.broad = kind;
    world *w = world_create(&options);
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
    uint32_t ids[BODIES];
    int count = 0;
    played p = {0};
    broad_kind stood = world_broad_kind(w);
    for (int t = 1; t <= TICKS; t++) {
        world_batches b;
        grow_to(w, ids, &count, t / PHASE % 2 ? BODIES : FEW);
        for (int k = 0; k < count; k++) scene_move(w, ids[k], place_at(k, t), t);
        world_tick(w, t, &b);
        p.hash = b.hash;
        p.changes += world_broad_kind(w) != stood;
        stood = world_broad_kind(w);
        if (t % 20 == 0) assert_null(world_validate(w));
    }
    p.events = world_get_figures(w).events;
    world_destroy(w);
    return p;
}

static void the_events_are_the_same_while_auto_changes(void **state)
{
    (void)state;
    played tree = play(BROAD_TREE);
    assert_true(tree.events > 1000);
    assert_int_equal(tree.changes, 0);
    for (broad_kind kind = BROAD_AUTO; kind <= BROAD_SWEEP1; kind++) {
        played other = play(kind);
        assert_true(other.hash == tree.hash);
        assert_int_equal(other.changes, kind == BROAD_AUTO ? TICKS / PHASE : 0);
    }
}

static void it_says_which_one_stands(void **state)
{
    (void)state;
    char text[96];
    world_options options = world_options_default();
    options.broad = BROAD_SWEEP1;
    world *w = world_create(&options);
    world_report_broad(w, text);
    assert_string_equal(text, "sweep1 (as configured)");
    world_destroy(w);
    w = world_create(&(world_options){.workers = 1, .broad = BROAD_AUTO});
    world_report_broad(w, text);
    assert_string_equal(text, "sweep3 (auto: 0 proxies; tree for more than 256)");
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_events_are_the_same_while_auto_changes),
        cmocka_unit_test(it_says_which_one_stands),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
