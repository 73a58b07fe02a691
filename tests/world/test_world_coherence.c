/* Temporal coherence: in scenes that move as robots and crowds do, the first two rungs of the ladder settle nearly all
 * separated pairs, and with them off not one event is another. */
#include "coherence.h"
#include "scene.h"

enum { TICKS = 1000 };

typedef struct played {
    uint64_t hash, separated, cheap;
} played;

static played play(const coherence_scene *s, unsigned workers, bool caches)
{
    world *w = scene_world(workers, caches);
    uint32_t ids[COHERENCE_BODIES_MAX];
    world_interest all = scene_all(WORLD_TOUCH, 0);
    scene_interest(w, &all);
    s->create(w, ids);
    world_batches out = {0};
    uint64_t touching = 0;
    for (int t = 1; t <= TICKS; t++) {
        s->move(w, ids, t * s->step_s);
        world_tick(w, t, &out);
        for (size_t i = 0; i < out.count; i++)
            for (size_t k = 0; k < out.at[i].count; k++)
                touching += out.at[i].events[k].kind == EVENT_BEGIN || out.at[i].events[k].kind == EVENT_UPDATE;
    }
    world_figures f = world_get_figures(w);
    played p = {out.hash, f.pair_ticks - touching, f.rungs[RUNG_MOTION_BOUND] + f.rungs[RUNG_CACHED_AXIS]};
    print_message("%-10s caches %d: %llu pair-ticks, %llu touching, %llu by motion bound, %llu by cached axis\n",
        s->name, caches, (unsigned long long)f.pair_ticks, (unsigned long long)touching,
        (unsigned long long)f.rungs[RUNG_MOTION_BOUND], (unsigned long long)f.rungs[RUNG_CACHED_AXIS]);
    world_destroy(w);
    return p;
}

static void the_first_two_rungs_settle_98_percent_of_separated_pairs_and_change_nothing(void **state)
{
    (void)state;
    for (int i = 0; i < COHERENCE_SCENES; i++) {
        const coherence_scene *s = &coherence_scenes[i];
        played cached = play(s, 1, true), cold = play(s, 1, false);
        assert_true(cached.separated > 10000);
        assert_true(100 * cached.cheap >= 98 * cached.separated);
        assert_int_equal(cold.cheap, 0);
        assert_true(cached.hash == cold.hash);
        assert_true(play(s, 3, true).hash == cached.hash);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_first_two_rungs_settle_98_percent_of_separated_pairs_and_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
