/* A million ticks of a world that rests, and of one that goes round and round: nothing drifts.
 *
 * Caches, fat boxes and trees have a history; the answers must have none. The resting world begins its contacts once
 * and ends none, and what it tells when a pose is sent again it told before; the orbiting one tells in each lap what it
 * told in the lap before, bit for bit but for the ids of contacts, which are never used twice. At the end both answer
 * as a world that was just created. */
#include "world/world.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

enum { LAP = 1000, BODIES = 8 };

static unsigned ticks_in_all(void)
{
    return getenv("COLLIDED_BRIEF") ? 50 * LAP : 1000 * LAP;
}

static const int64_t TICK_NS = 1000000;

static uint32_t put(world *w, const char *name, shape s, pose at)
{
    world_shape one = {.shape = s, .local = POSE_IDENTITY};
    world_body def = {
        .name = name, .group = "", .category = 1, .mask = UINT64_MAX, .pose = at, .shapes = &one, .shape_count = 1};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_body(w, &id, &def), WORLD_OK);
    return id;
}

static world *create(double range)
{
    world_options o = world_options_default();
    o.workers = 1;
    world *w = world_create(&o);
    world_subscription all = {.facts = WORLD_TOUCH | WORLD_DISTANCE | WORLD_MANIFOLD,
        .select_a = "*",
        .select_b = "*",
        .range = range,
        .tolerance = 1e-9};
    uint32_t id = WORLD_NONE;
    assert_int_equal(world_put_subscription(w, &id, &all), WORLD_OK);
    return w;
}

/* FNV-1a of what an event says, without its contact id. */
static uint64_t mixed(uint64_t h, const void *bytes, size_t size)
{
    const unsigned char *at = bytes;
    for (size_t i = 0; i < size; i++) h = (h ^ at[i]) * UINT64_C(1099511628211);
    return h;
}

static uint64_t mixed_event(uint64_t h, const world_event *e)
{
    h = mixed(h, &e->kind, 1);
    h = mixed(h, e->name_a, strlen(e->name_a));
    h = mixed(h, e->name_b, strlen(e->name_b));
    h = mixed(h, &e->lo, sizeof e->lo);
    h = mixed(h, &e->hi, sizeof e->hi);
    h = mixed(h, &e->axis, sizeof e->axis);
    h = mixed(h, &e->point_a, sizeof e->point_a);
    h = mixed(h, &e->point_b, sizeof e->point_b);
    for (uint32_t i = 0; i < e->manifold.count; i++) {
        h = mixed(h, &e->manifold.points[i].point, sizeof e->manifold.points[i].point);
        h = mixed(h, &e->manifold.points[i].distance, sizeof e->manifold.points[i].distance);
        h = mixed(h, &e->manifold.points[i].feature, sizeof e->manifold.points[i].feature);
    }
    return h;
}

static uint64_t mixed_tick(uint64_t h, world *w, unsigned tick, size_t *events)
{
    world_batches batches;
    world_tick(w, (int64_t)tick * TICK_NS, &batches);
    for (size_t i = 0; i < batches.count; i++)
        for (size_t k = 0; k < batches.at[i].count; k++, ++*events) h = mixed_event(h, &batches.at[i].events[k]);
    return h;
}

static void same_distances(const world *x, const world *y, const uint32_t *ids, size_t count)
{
    for (size_t a = 0; a < count; a++)
        for (size_t b = a + 1; b < count; b++) {
            world_hits one = {0}, other = {0};
            world_query_distance(x, ids[a], ids[b], 1e-12, 0, &one);
            world_query_distance(y, ids[a], ids[b], 1e-12, 0, &other);
            assert_int_equal(one.count, other.count);
            for (size_t i = 0; i < one.count; i++) {
                assert_true(one.at[i].lo == other.at[i].lo && one.at[i].hi == other.at[i].hi);
                assert_memory_equal(&one.at[i].axis, &other.at[i].axis, sizeof(vec3));
            }
            free(one.at);
            free(other.at);
        }
}

/* ---- a pile: a floor, boxes on it and on each other, a cylinder that leans, a ball in the corner ---- */

static pose upright(double x, double y, double z)
{
    return (pose){vec(x, y, z), {1, 0, 0, 0}};
}

static void pile(world *w, uint32_t *ids)
{
    const shape brick = {.type = SHAPE_BOX, .half = vec(0.5, 0.3, 0.1)}, ball = {.type = SHAPE_SPHERE, .radius = 0.2},
                can = {.type = SHAPE_CYLINDER, .half = vec(0.1, 0.1, 0.3)},
                egg = {.type = SHAPE_ELLIPSOID, .half = vec(0.1, 0.15, 0.2)};
    ids[0] = put(w, "floor", (shape){.type = SHAPE_HALFSPACE}, POSE_IDENTITY);
    ids[1] = put(w, "brick0", brick, upright(0, 0, 0.1));
    ids[2] = put(w, "brick1", brick, upright(0.2, 0.1, 0.3));
    ids[3] = put(w, "brick2", brick, (pose){vec(0.1, 0, 0.5), {0.9689124217106447, 0, 0, 0.24740395925452294}});
    ids[4] = put(w, "can", can, upright(-0.3, 0, 0.5));
    ids[5] = put(w, "ball", ball, upright(0.9, 0, 0.2));
    ids[6] = put(w, "egg", egg, upright(0.3, 0, 0.8));
    ids[7] = put(w, "brick3", brick, upright(0, 0.6, 0.1));
}

static void a_resting_world_repeats_itself(void **state)
{
    uint32_t ids[BODIES], again[BODIES];
    size_t first = 0;
    uint64_t second = 0;
    world *w = create(0.05), *fresh = create(0.05);
    (void)state;
    pile(w, ids);
    pile(fresh, again);
    mixed_tick(0, w, 1, &first);
    size_t contacts = world_get_figures(w).contacts;
    assert_true(contacts >= 6 && first >= contacts);
    for (unsigned round = 0; round < ticks_in_all() / BODIES; round++) { /* each body sent again, where it is */
        uint64_t hash = UINT64_C(14695981039346656037);
        size_t events = 0;
        for (unsigned i = 0; i < BODIES; i++) {
            assert_int_equal(world_move_body(w, ids[i], world_body_pose(w, ids[i]), 0, NULL, NULL), WORLD_OK);
            hash = mixed_tick(hash, w, 2 + round * BODIES + i, &events);
        }
        if (round == 0) second = hash;
        if (hash != second) fail_msg("round %u tells something else", round);
    }
    assert_int_equal(world_get_figures(w).contacts, contacts);
    same_distances(w, fresh, ids, BODIES);
    world_destroy(w);
    world_destroy(fresh);
}

/* ---- a carousel: two bodies that pass by, and through, what stands at its rim ---- */

static pose on_the_rim(unsigned tick, double radius, double phase)
{
    double turn = 2 * M_PI * (tick % LAP) / LAP + phase;
    return (pose){vec(radius * cos(turn), radius * sin(turn), 0), {cos(turn / 2), 0, 0, sin(turn / 2)}};
}

static void carousel(world *w, uint32_t *ids, unsigned tick)
{
    ids[0] = put(w, "box", (shape){.type = SHAPE_BOX, .half = vec(0.3, 0.2, 0.1)}, on_the_rim(tick, 2, 0));
    ids[1] = put(w, "can", (shape){.type = SHAPE_CYLINDER, .half = vec(0.2, 0.2, 0.3)}, on_the_rim(tick, 2, 3));
    ids[2] = put(w, "post", (shape){.type = SHAPE_CAPSULE, .half = vec(0, 0, 1), .radius = 0.1}, upright(2.2, 0, 0));
    ids[3] = put(w, "cone", (shape){.type = SHAPE_CONE, .half = vec(0.3, 0.3, 0.4)}, upright(0, -1.6, 0));
    ids[4] = put(w, "wall", (shape){.type = SHAPE_BOX, .half = vec(0.1, 1, 1)}, upright(-2.5, 0, 0));
}

static void turn(world *w, const uint32_t *ids, unsigned tick)
{
    assert_int_equal(world_move_body(w, ids[0], on_the_rim(tick, 2, 0), 0, NULL, NULL), WORLD_OK);
    assert_int_equal(world_move_body(w, ids[1], on_the_rim(tick, 2, 3), 0, NULL, NULL), WORLD_OK);
}

static void every_lap_tells_the_same(void **state)
{
    uint32_t ids[BODIES], again[BODIES];
    uint64_t second = 0;
    size_t told = 0;
    world *w = create(0.3);
    unsigned laps = ticks_in_all() / LAP;
    (void)state;
    carousel(w, ids, 0);
    for (unsigned lap = 0; lap < laps; lap++) {
        uint64_t hash = UINT64_C(14695981039346656037);
        size_t events = 0;
        for (unsigned tick = lap * LAP; tick < (lap + 1) * LAP; tick++) {
            turn(w, ids, tick);
            hash = mixed_tick(hash, w, tick + 1, &events);
        }
        if (lap == 1) second = hash, told = events; /* the first begins with nothing near */
        if (lap > 1 && (hash != second || events != told)) fail_msg("lap %u of %u is another", lap, laps);
    }
    assert_true(told > LAP / 10);
    world *fresh = create(0.3);
    carousel(fresh, again, laps * LAP - 1);
    same_distances(w, fresh, ids, 5);
    const char *fault = world_validate(w);
    if (fault) fail_msg("%s", fault);
    world_destroy(fresh);
    world_destroy(w);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_resting_world_repeats_itself),
        cmocka_unit_test(every_lap_tells_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
