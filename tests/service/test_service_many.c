/* Many subscriptions of many clients: all of them are answered, a movement is told to those that it concerns alone, and
 * what is left takes no time from a tick. In CI 10,000 subscriptions; with COLLIDED_NIGHTLY 100,000. */
#include "cell.h"

#include <stdio.h>
#include <stdlib.h>

enum { EACH = 100, FIRST = 1000, MOST = 1000 };

typedef struct room {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
    int clients;
    uint8_t *told; /* by client and subscription: batches with events, at most 255 */
} room;

/* The subscriptions of client k are in its own two bodies, each under a name of its own for them. */
static void put_subscription(room *r, int k, int32_t number)
{
    char own[32], other[32];
    snprintf(own, sizeof own, "c%d/*", k);
    snprintf(other, sizeof other, number % 2 ? "*" : "c%d/%d", k, number / 2 % 2);
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = FIRST + k,
            .sequence = ++r->sequence,
            .subscription = number,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = own,
            .select_b = other,
            .tolerance_m = 1e-6}};
    memory_send(r->end, &m);
}

static room enter(void)
{
    config c = cell_config();
    room r = {.memory = wire_memory_create(), .clients = getenv("COLLIDED_NIGHTLY") ? MOST : MOST / 10};
    c.max_subscriptions = c.max_client_subscriptions = EACH * MOST;
    r.cell = cell_start(&c);
    r.end = cell_client(r.cell);
    r.told = calloc((size_t)r.clients, EACH);
    return r;
}

static void leave(room *r)
{
    memory_disconnect(r->end);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
    free(r->told);
}

/* Until so many batches with events have come: which subscriptions they are of. */
static void hear(room *r, int batches)
{
    memset(r->told, 0, (size_t)r->clients * EACH);
    while (batches > 0) {
        wire_event_batch b = cell_await(r->end, r->memory, WIRE_EVENT_BATCH).event_batch;
        if (!b.kinds.count) continue;
        assert_in_range(b.client, FIRST, FIRST + r->clients - 1);
        assert_in_range(b.subscription, 0, EACH - 1);
        uint8_t *told = &r->told[(b.client - FIRST) * EACH + b.subscription];
        if (*told < 255) ++*told;
        batches--;
    }
}

static void what_concerns_one_client_is_told_to_its_subscriptions_alone(void **state)
{
    (void)state;
    room r = enter();
    char name[32];
    for (int k = 0; k < r.clients; k++) {
        cell_hello(r.end, FIRST + k, ++r.sequence, 60, WIRE_LOST_REMOVE);
        for (int body = 0; body < 2; body++) {
            snprintf(name, sizeof name, "c%d/%d", k, body);
            cell_sphere(r.end, FIRST + k, ++r.sequence, body, name, 10.0 * k + 1.5 * body);
        }
        for (int32_t i = 0; i < EACH; i++) put_subscription(&r, k, i);
        cell_settle(r.end, r.memory, FIRST + k, ++r.sequence);
    }
    cell_settle(r.end, r.memory, FIRST, ++r.sequence);
    wire_message s = cell_await(r.end, r.memory, WIRE_STATUS);
    while (cell_counter(&s.status, "subscriptions") < r.clients * EACH) s = cell_await(r.end, r.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&s.status, "subscriptions"), r.clients * EACH);
    assert_int_equal(cell_counter(&s.status, "streams"), r.clients * EACH);
    assert_int_equal(cell_counter(&s.status, "contacts"), r.clients * EACH);

    /* Whatever is still on its way is of the beginning: one body goes, and each subscription of its client hears it. */
    cell_pose(r.end, FIRST + 7, ++r.sequence, 1, 10.0 * 7 + 5);
    cell_settle(r.end, r.memory, FIRST + 7, ++r.sequence);
    cell_pose(r.end, FIRST + 7, ++r.sequence, 1, 10.0 * 7 + 1.5);
    hear(&r, EACH);
    for (int k = 0; k < r.clients; k++)
        for (int i = 0; i < EACH; i++) assert_int_equal(r.told[k * EACH + i], k == 7);
    leave(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_concerns_one_client_is_told_to_its_subscriptions_alone),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
