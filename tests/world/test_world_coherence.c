/* Temporal coherence: in scenes that move as robots and crowds do, the first two stages of the cascade settle nearly
 * all separated pairs, and with them off not one event is another. */
#include "coherence.h"
#include "scene.h"

#include <stdlib.h>

enum { TICKS = 1000, MEASURED_TICKS = 400 };

typedef struct played {
    uint64_t hash, separated, cheap;
} played;

static played play(const coherence_scene *s, unsigned workers, bool caches)
{
    world *w = scene_world(workers, caches);
    uint32_t ids[COHERENCE_BODIES_MAX];
    world_subscription all = scene_all(WORLD_TOUCH, 0);
    scene_subscription(w, &all);
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
    played p = {out.hash, f.pair_ticks - touching, f.stages[STAGE_MOTION_BOUND] + f.stages[STAGE_CACHED_AXIS]};
    print_message("%-10s caches %d: %llu pair-ticks, %llu touching, %llu by motion bound, %llu by cached axis\n",
        s->name, caches, (unsigned long long)f.pair_ticks, (unsigned long long)touching,
        (unsigned long long)f.stages[STAGE_MOTION_BOUND], (unsigned long long)f.stages[STAGE_CACHED_AXIS]);
    world_destroy(w);
    return p;
}

static void the_first_two_stages_settle_98_percent_of_separated_pairs_and_change_nothing(void **state)
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

/* Everything that can be told of a pair: verdict, interval, axis, points, and manifolds with their ids, each tick. */
static world_figures play_all(const coherence_scene *s, unsigned workers, bool caches, int ticks, uint64_t *hash)
{
    world *w = scene_world(workers, caches);
    uint32_t ids[COHERENCE_BODIES_MAX];
    world_subscription all = scene_all(WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD, 0.02);
    scene_subscription(w, &all);
    s->create(w, ids);
    world_batches out = {0};
    for (int t = 1; t <= ticks; t++) {
        s->move(w, ids, t * s->step_s);
        world_tick(w, t, &out);
    }
    *hash = out.hash;
    world_figures f = world_get_figures(w);
    world_destroy(w);
    return f;
}

/* 10^5 frames of pairs, and ten times as many with COLLIDED_NIGHTLY=1. */
static void intervals_and_manifolds_are_those_of_a_cold_run(void **state)
{
    (void)state;
    uint64_t frames = 0, manifolds = 0, cheap = 0;
    int ticks = getenv("COLLIDED_NIGHTLY") ? 10 * MEASURED_TICKS : MEASURED_TICKS;
    for (int i = 0; i < COHERENCE_SCENES; i++) {
        const coherence_scene *s = &coherence_scenes[i];
        uint64_t warm_hash, cold_hash;
        world_figures warm = play_all(s, 2, true, ticks, &warm_hash), cold = play_all(s, 1, false, ticks, &cold_hash);
        assert_true(warm_hash == cold_hash);
        assert_true(warm.pair_ticks == cold.pair_ticks && warm.manifolds == cold.manifolds);
        assert_true(warm.narrow_queries < cold.narrow_queries);
        frames += warm.pair_ticks;
        manifolds += warm.manifolds;
        cheap += warm.stages[STAGE_MOTION_BOUND] + warm.stages[STAGE_CACHED_AXIS];
    }
    print_message("%llu frames of pairs: %llu settled by caches, %llu manifolds\n", (unsigned long long)frames,
        (unsigned long long)cheap, (unsigned long long)manifolds);
    assert_true(frames >= 100000 && manifolds >= 5000 && cheap >= frames / 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(intervals_and_manifolds_are_those_of_a_cold_run),
        cmocka_unit_test(the_first_two_stages_settle_98_percent_of_separated_pairs_and_change_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
