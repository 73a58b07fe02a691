/* A steady tick allocates nothing: poses of bodies in contact go in, events come out, and once every buffer has found
 * its size the heap is left alone: by the world, with one worker and with two, and by the whole service. */
#include "allocations.h"
#include "cell.h"

#include "base/whole.h"
#include "world/coherence.h"

enum { ALICE = 11, WARM_UP = 300, COUNTED = 300, ROUND_TICKS = 200, ROUNDS = 6 };

static void test_counts(void **state)
{
    (void)state;
    size_t before = allocations();
    allocations_leave_out(true);
    world_options options = world_options_default();
    world *w = world_create(&options);
    assert_int_equal(allocations(), before);
    world_destroy(w);
    allocations_leave_out(false);
    w = world_create(&options);
    assert_true(allocations() > before);
    world_destroy(w);
}

/* The same way again and again: what the second round needs, the first has had. */
static void steady_scene(const coherence_scene *scene, unsigned workers)
{
    static uint32_t ids[COHERENCE_BODIES_MAX];
    world_batches batches;
    uint32_t subscription = WORLD_NONE;
    size_t events = 0, before = 0;
    world_options options = world_options_default();
    options.workers = workers;
    world *w = world_create(&options);
    scene->create(w, ids);
    world_put_subscription(w, &subscription,
        &(world_subscription){
            .facts = WORLD_TOUCH | WORLD_MANIFOLD, .select_a = "*", .select_b = "*", .threshold = 0.01});
    for (int round = 0; round < ROUNDS; round++) {
        if (round == ROUNDS - 1) before = allocations();
        for (int i = 0; i < 2 * ROUND_TICKS; i++) { /* there and back */
            int step = i < ROUND_TICKS ? i : 2 * ROUND_TICKS - i;
            scene->move(w, ids, scene->step_s * step);
            world_tick(w, 1000000 * (int64_t)(2 * ROUND_TICKS * round + i + 1), &batches);
            for (size_t k = 0; k < batches.count; k++) events += batches.at[k].count;
        }
    }
    size_t taken = allocations() - before;
    world_destroy(w);
    assert_true(events > 0);
    if (taken) fail_msg("%s, %u worker(s): %zu allocations in %d ticks", scene->name, workers, taken, 2 * ROUND_TICKS);
}

static void test_world(void **state)
{
    (void)state;
    for (size_t i = 0; i < COHERENCE_SCENES; i++) steady_scene(&coherence_scenes[i], 1);
    steady_scene(&coherence_scenes[0], 2);
}

/* ---- the service, over the memory link ---- */

static void send_pose(memory_end *e, int64_t sequence, int64_t step)
{
    const int32_t bodies[2] = {0, 1};
    const double sway = step % 2 ? 0.1 : 0.0;
    const double positions[6] = {sway, 0, 0, 1.5, 0, 0}, orientations[8] = {1, 0, 0, 0, 1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .stamp_ns = 1000 * sequence,
            .step = step,
            .bodies = {2, bodies},
            .positions = {6, positions},
            .orientations = {8, orientations}}};
    memory_send(e, &m);
}

static void test_service(void **state)
{
    (void)state;
    config options = cell_config();
    options.status_period = 60;
    cell *c = cell_start(&options);
    memory_end *e = cell_client(c);
    wire_memory *memory = wire_memory_create();
    int64_t sequence = 0;
    cell_hello(e, ALICE, ++sequence, 60, WIRE_LOST_KEEP);
    cell_sphere(e, ALICE, ++sequence, 0, "a", 0);
    cell_sphere(e, ALICE, ++sequence, 1, "b", 1.5);
    cell_touches(e, ALICE, ++sequence, 1);
    cell_settle(e, memory, ALICE, ++sequence);
    size_t before = 0, events = 0;
    allocations_leave_out(true);
    for (int64_t step = 1; step <= WARM_UP + COUNTED; step++) {
        if (step == WARM_UP + 1) before = allocations();
        send_pose(e, ++sequence, step);
        wire_message m;
        do m = cell_await(e, memory, WIRE_EVENT_BATCH);
        while (m.event_batch.step < step);
        events += m.event_batch.kinds.count;
    }
    size_t taken = allocations() - before;
    allocations_leave_out(false);
    memory_disconnect(e);
    wire_memory_destroy(memory);
    assert_int_equal(cell_stop(c), 0);
    assert_true(events >= COUNTED);
    assert_int_equal(taken, 0);
}

int main(void)
{
    whole_rest(true);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),
        cmocka_unit_test(test_world),
        cmocka_unit_test(test_service),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
