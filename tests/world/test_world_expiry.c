/* Deadlines: a body is stale exactly when a plain model says so, whatever moves, holds, redefines and removes it. */
#include "base/prng.h"
#include "scene.h"

#include <stdio.h>

enum { BODIES = 60, TICKS = 20000 };

typedef struct model { /* of one body, by the words of world.h alone */
    uint32_t id;
    bool alive, held;
    int64_t deadline_ns, since_ns;
} model;

static void put(world *w, model *m, int number, int64_t deadline_ns, int64_t now_ns)
{
    char name[16];
    snprintf(name, sizeof name, "b%d", number);
    world_shape ball = {.shape = {.type = SHAPE_SPHERE, .radius = 1}, .local = POSE_IDENTITY};
    world_body def = {.name = name,
        .group = "",
        .category = 1,
        .mask = 1,
        .pose = POSE_IDENTITY,
        .deadline_ns = deadline_ns,
        .stamp_ns = now_ns,
        .shapes = &ball,
        .shape_count = 1};
    if (!m->alive) m->id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &m->id, &def), WORLD_OK);
    *m = (model){m->id, true, false, deadline_ns, now_ns};
}

static void command(world *w, model *m, int number, uint64_t random, int64_t now_ns)
{
    static const int64_t DEADLINES[] = {0, 7, 50, 1000, INT64_MAX};
    switch (random % 16) {
    case 0:
        if (m->alive) world_remove_body(w, m->id, CAUSE_REMOVED);
        m->alive = false;
        return;
    case 1:
        if (!m->alive) return;
        world_hold_body(w, m->id);
        m->held = true;
        return;
    case 2:
        put(w, m, number, DEADLINES[random / 16 % 5], now_ns);
        return;
    default:
        if (!m->alive) return;
        assert_int_equal(world_move_body(w, m->id, POSE_IDENTITY, now_ns, NULL, NULL), WORLD_OK);
        m->held = false;
        m->since_ns = now_ns;
    }
}

static bool is_stale(const model *m, int64_t now_ns)
{
    return m->alive && (m->held || (m->deadline_ns && m->deadline_ns <= now_ns - m->since_ns));
}

static void a_body_is_stale_exactly_past_its_deadline_or_while_it_is_held(void **state)
{
    (void)state;
    world *w = scene_world(1, true);
    model bodies[BODIES] = {0};
    uint64_t random = 7;
    size_t seen = 0;
    int64_t now = 1;
    world_batches out;
    for (int t = 0; t < TICKS; t++) {
        for (int c = 0; c < 3; c++) {
            int i = (int)(prng_bits(&random) % BODIES);
            command(w, &bodies[i], i, prng_bits(&random), now);
        }
        world_tick(w, now, &out);
        size_t stale = 0;
        for (int i = 0; i < BODIES; i++) stale += is_stale(&bodies[i], now);
        assert_int_equal(world_get_figures(w).stale_bodies, stale);
        seen += stale;

        int64_t due = world_next_due_ns(w);
        for (int i = 0; i < BODIES; i++) /* nobody's deadline passes before the next tick is due */
            if (bodies[i].alive && bodies[i].deadline_ns && !is_stale(&bodies[i], now))
                assert_true(due - bodies[i].since_ns <= bodies[i].deadline_ns);
        now += 1 + (int64_t)(prng_bits(&random) % 8);
    }
    assert_true(seen > TICKS);
    world_destroy(w);
}

/* Deadlines of thirty years, of bodies that are gone or have teleported to and fro in time, do not pile up: see
 * world_validate. And the clock may be set back meanwhile. */
static void deadlines_do_not_pile_up(void **state)
{
    (void)state;
    const int64_t ages = INT64_C(1000000000000000000);
    model passing = {.alive = false}, staying = {.alive = false};
    world *w = scene_world(1, true);
    int64_t now = 20 * (int64_t)SECOND;
    put(w, &staying, 1, ages, now);
    for (int i = 0; i < 300; i++) {
        put(w, &passing, 0, ages, now);
        world_teleport_body(w, staying.id, POSE_IDENTITY, now - (i % 2 ? 5 : 1) * (int64_t)SECOND, NULL, NULL);
        scene_tick(w, ++now);
        world_remove_body(w, passing.id, CAUSE_REMOVED);
        passing.alive = false;
        scene_tick(w, ++now);
        if (i % 50) continue;
        world_clock_back(w, SECOND);
        now -= SECOND;
    }
    put(w, &staying, 1, 100, now); /* a short one is still found */
    scene_tick(w, now + 50);
    assert_int_equal(world_get_figures(w).stale_bodies, 0);
    assert_true(world_next_due_ns(w) > now && world_next_due_ns(w) <= now + 100);
    scene_tick(w, now + 101);
    assert_int_equal(world_get_figures(w).stale_bodies, 1);
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_body_is_stale_exactly_past_its_deadline_or_while_it_is_held),
        cmocka_unit_test(deadlines_do_not_pile_up),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
