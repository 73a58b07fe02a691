/* Bodies of very many shapes that are all moved by one message: as many as a tick takes are taken by each, all arrive,
 * a step is told when all of it is there, and a recording says what was taken when. */
#include "cell.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { BODIES = 300, SHAPES = 200, CLIENT = 7, A_TICK = 150 }; /* of some 120 us each: 12 ms are 100 */

static void put_wide(memory_end *e, int32_t body)
{
    char name[32];
    uint8_t types[SHAPES];
    double sizes[3 * SHAPES], radii[SHAPES] = {0}, places[7 * SHAPES] = {0};
    int64_t hashes[SHAPES] = {0};
    for (int i = 0; i < SHAPES; i++) {
        types[i] = WIRE_SHAPE_BOX;
        for (int k = 0; k < 3; k++) sizes[3 * i + k] = 0.01;
        places[7 * i] = 0.03 * i;
        places[7 * i + 3] = 1;
    }
    const double pose[7] = {0, 20.0 * body, 0, 1};
    snprintf(name, sizeof name, "wide %d", body);
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = 10 + body,
            .body = body,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .shape_types = {SHAPES, types},
            .shape_sizes = {3 * SHAPES, sizes},
            .shape_radii = {SHAPES, radii},
            .shape_geometries = {SHAPES, hashes},
            .shape_poses = {7 * SHAPES, places},
            .pose = {7, pose}}};
    memory_send(e, &m);
}

static void move_all(memory_end *e, int64_t sequence, int64_t step)
{
    static int32_t bodies[BODIES];
    static double at[3 * BODIES], turns[4 * BODIES];
    for (int i = 0; i < BODIES; i++) {
        bodies[i] = i;
        at[3 * i] = (double)sequence;
        at[3 * i + 1] = 20.0 * i;
        turns[4 * i] = 1;
    }
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = sequence,
            .step = step,
            .bodies = {BODIES, bodies},
            .positions = {3 * BODIES, at},
            .orientations = {4 * BODIES, turns}}};
    memory_send(e, &m);
}

enum { DEARER = 8 }; /* service_learn_effort: times, at most */

typedef struct taken { /* as recorded */
    size_t in_tick, most, all, parts;
    int64_t step;
} taken;

static void look(void *context, const wire_log_entry *e)
{
    taken *t = context;
    if (e->kind == WIRE_LOG_TICK) t->in_tick = 0;
    if (e->kind != WIRE_LOG_MESSAGE || e->message.kind != WIRE_POSE_BATCH) return;
    const wire_pose_batch *m = &e->message.pose_batch;
    t->in_tick += m->bodies.count;
    t->all += m->bodies.count;
    t->parts++;
    if (t->in_tick > t->most) t->most = t->in_tick;
    if (m->step) assert_int_equal(t->all, 2 * BODIES); /* with the last of them */
    if (m->step) t->step = m->step;
}

static void a_tick_takes_no_more_than_it_can(void **state)
{
    (void)state;
    char path[] = "/tmp/test_service_wide.XXXXXX";
    int file = mkstemp(path);
    assert_true(file >= 0);
    close(file);
    unlink(path);
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s", path);
    cell *cell = cell_start(&c);
    memory_end *e = cell_client(cell);
    wire_memory *memory = wire_memory_create();
    cell_hello(e, CLIENT, 1, 100, WIRE_LOST_REMOVE);
    cell_touches(e, CLIENT, 2, 1);
    for (int32_t i = 0; i < BODIES; i++) put_wide(e, i);
    cell_settle(e, memory, CLIENT, 1000);
    move_all(e, 2000, 0);
    cell_settle(e, memory, CLIENT, 2001);
    move_all(e, 3000, 5);
    cell_settle(e, memory, CLIENT, 3001);
    assert_int_equal(cell_stop(cell), 0);
    taken t = {0};
    cell_read(path, look, &t);
    assert_int_equal(t.all, 2 * BODIES);
    assert_int_equal(t.step, 5);
    if (t.most > A_TICK) fail_msg("a tick took %zu of %d poses", t.most, BODIES);
    assert_in_range(t.parts, 4, 20 * DEARER); /* a slow build learns that poses take longer, and takes fewer */
    assert_int_equal(cell_replay(path, 3, true), 0);
    unlink(path);
    memory_disconnect(e);
    wire_memory_destroy(memory);
}

/* A step is one thing, and carried out at once: what may be in it is limited by the same measure. */
static void a_step_of_many_shapes_is_limited(void **state)
{
    (void)state;
    config c = cell_config();
    c.max_step_poses = 50000;
    cell *cell = cell_start(&c);
    memory_end *e = cell_client(cell);
    wire_memory *memory = wire_memory_create();
    const wire_message hello = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = 1,
            .name = "wide",
            .lease_ns = 100000000000,
            .lock_step = 1}};
    memory_send(e, &hello);
    for (int32_t i = 0; i < BODIES; i++) put_wide(e, i);
    cell_settle(e, memory, CLIENT, 1000);
    move_all(e, 2000, 1);
    move_all(e, 2001, 1); /* 2 x 300 x 120, of 50,000 */
    wire_reject r = cell_await(e, memory, WIRE_REJECT).reject;
    assert_int_equal(r.reason, WIRE_LIMIT);
    assert_int_equal(r.sequence, 2001);
    assert_non_null(strstr(r.text, "max_step_poses"));
    assert_int_equal(cell_stop(cell), 0);
    memory_disconnect(e);
    wire_memory_destroy(memory);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_tick_takes_no_more_than_it_can),
        cmocka_unit_test(a_step_of_many_shapes_is_limited),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
