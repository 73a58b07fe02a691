/* What a transport has lost is noticed: counted, in the health with its cause until it is some seconds past, and told
 * to those whose it may have been, who write anew. */
#include "cell.h"

#include "wire/wire_lcm.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { ALICE = 1, BOB = 2 };

typedef struct room {
    cell *cell;
    memory_end *alice, *bob;
    wire_memory *memory;
} room;

static void room_open(room *r)
{
    config c = cell_config();
    *r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r->alice = cell_client(r->cell);
    r->bob = cell_client(r->cell);
    cell_hello(r->alice, ALICE, 1, 600, WIRE_LOST_REMOVE);
    cell_hello(r->bob, BOB, 1, 600, WIRE_LOST_REMOVE);
    cell_settle(r->alice, r->memory, ALICE, 2);
    cell_settle(r->bob, r->memory, BOB, 2);
}

static void room_close(room *r)
{
    memory_disconnect(r->alice);
    memory_disconnect(r->bob);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

/* A message of that kind, which is more than the link can carry: it is lost, as in a network. */
static void lose(memory_end *e, const wire_message *kind_of)
{
    enum { TOO_MUCH = 33 << 20 }; /* bytes: the queue of the memory link holds fewer */
    size_t size = TOO_MUCH;
    uint8_t *bytes = calloc(size, 1);
    assert_non_null(bytes);
    wire_lcm_encode(kind_of, bytes, wire_lcm_size(kind_of));
    memory_send_bytes(e, bytes, size);
    free(bytes);
}

static void lose_poses(memory_end *e)
{
    const int32_t body = 0;
    const double at[3] = {0}, turn[4] = {1};
    lose(e, &(wire_message){.kind = WIRE_POSE_BATCH,
                .pose_batch = {.version = WIRE_VERSION,
                    .client = ALICE,
                    .sequence = 3,
                    .bodies = {1, &body},
                    .positions = {3, at},
                    .orientations = {4, turn}}});
}

static bool is_told(memory_end *e, wire_memory *memory, int64_t client, wire_kind kind)
{
    for (int tries = 0; tries < 100; tries++) {
        wire_message m = cell_await(e, memory, WIRE_REJECT);
        if (m.reject.client == client && m.reject.reason == WIRE_UNHEARD) return m.reject.kind == kind;
    }
    return false;
}

/* The next Status, or one of those that follow, has that health. */
static wire_message await_health(room *r, uint8_t health)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    time_t end = now.tv_sec + 30;
    wire_message m;
    do {
        m = cell_await(r->bob, r->memory, WIRE_STATUS);
        clock_gettime(CLOCK_MONOTONIC, &now);
    } while (m.status.health != health && now.tv_sec < end);
    assert_int_equal(m.status.health, health);
    return m;
}

static void lost_poses_degrade_the_health_and_are_told(void **state)
{
    (void)state;
    room r;
    room_open(&r);
    await_health(&r, WIRE_HEALTH_READY);
    lose_poses(r.alice);
    assert_true(is_told(r.alice, r.memory, ALICE, WIRE_POSE_BATCH));
    wire_message m = await_health(&r, WIRE_HEALTH_DEGRADED);
    assert_non_null(strstr(m.status.limits, "messages of kind PoseBatch were lost on their way"));
    assert_int_equal(cell_counter(&m.status, "messages_lost"), 1);
    m = await_health(&r, WIRE_HEALTH_READY); /* some seconds later: nothing more was lost */
    assert_null(strstr(m.status.limits, "lost on their way"));
    room_close(&r);
}

/* Nobody knows whose it was: each of them may have sent it. */
static void all_that_may_have_sent_it_are_told_once(void **state)
{
    (void)state;
    room r;
    room_open(&r);
    lose(r.bob, &(wire_message){.kind = WIRE_RECEIPT, .receipt = {.version = WIRE_VERSION, .client = BOB}});
    assert_true(is_told(r.alice, r.memory, ALICE, WIRE_RECEIPT));
    assert_true(is_told(r.bob, r.memory, BOB, WIRE_RECEIPT));
    assert_false(cell_hears(r.bob, r.memory, WIRE_REJECT, 1500));
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(lost_poses_degrade_the_health_and_are_told),
        cmocka_unit_test(all_that_may_have_sent_it_are_told_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
