/* Many streams whose subscribers all want a large snapshot at once: a round sends no more than its share of what waits,
 * the streams go by turns, and in the end each subscriber has all of it. The clock is the test's. One thread. */
#include "base/log.h"
#include "cell.h"
#include "peers.h"
#include "service/server.h"
#include "service/service.h"
#include "service/streams.h"

#include <stdio.h>
#include <stdlib.h>

enum {
    ALICE = 21,
    BALLS = 90,
    PAIRS = BALLS * (BALLS - 1) / 2,
    STREAMS = 100,
    ROUND_BYTES = 8 << 20,
    A_BURST = 8 * (64 << 10)
};
static const int64_t ROUND_NS = 1000000;

typedef struct crowd {
    server *server;
    service *service;
    link_sink sink;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence;
    bool acknowledges;
    size_t events[STREAMS], last_heard[STREAMS], rounds, most_bytes, longest_wait; /* rounds between two parts */
} crowd;

static void set_up(crowd *c)
{
    char why[256] = "";
    config g = cell_config();
    snprintf(g.links, sizeof g.links, "memory://crowd");
    *c = (crowd){.server = server_create(&g, why, sizeof why), .memory = wire_memory_create()};
    if (!c->server) fail_msg("%s", why);
    c->service = server_service(c->server);
    c->sink = server_sink(c->server);
    c->alice = memory_connect("crowd");
    c->service->now_ns = c->service->monotonic_ns = 1000000000000;
}

static void tear_down(crowd *c)
{
    memory_disconnect(c->alice);
    server_destroy(c->server);
    wire_memory_destroy(c->memory);
}

static void acknowledge(crowd *c, const wire_event_batch *b)
{
    wire_message m = {.kind = WIRE_RECEIPT,
        .receipt = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++c->sequence,
            .subscription = b->subscription,
            .epoch = b->epoch,
            .batch = b->batch,
            .tick = b->snapshot ? b->tick : 0,
            .part = b->snapshot ? b->part : 0}};
    memory_send(c->alice, &m);
}

static void hear(crowd *c)
{
    wire_message m;
    size_t bytes = 0;
    for (wire_memory_reset(c->memory); memory_receive(c->alice, c->memory, &m); wire_memory_reset(c->memory)) {
        const wire_event_batch *b = &m.event_batch;
        if (m.kind != WIRE_EVENT_BATCH || b->heartbeat) continue;
        size_t waited = c->rounds - c->last_heard[b->subscription];
        if (c->events[b->subscription] && waited > c->longest_wait) c->longest_wait = waited;
        c->last_heard[b->subscription] = c->rounds;
        c->events[b->subscription] += b->kinds.count;
        bytes += wire_lcm_size(&m);
        if (c->acknowledges) acknowledge(c, b);
    }
    if (bytes > c->most_bytes) c->most_bytes = bytes;
}

static void one_round(crowd *c)
{
    service *s = c->service;
    s->now_ns = s->monotonic_ns += ROUND_NS;
    c->rounds++;
    s->links[0]->ops->receive(s->links[0], &c->sink);
    peers_work(s);
    backlog_watch(s);
    hear(c);
}

static bool all_have(const crowd *c)
{
    for (int k = 0; k < STREAMS; k++)
        if (c->events[k] < PAIRS) return false;
    return true;
}

static void no_round_sends_more_than_its_share_of_what_waits(void **state)
{
    crowd c;
    char name[16];
    log_setup(LOG_ERROR, 0);
    set_up(&c);
    c.acknowledges = *state != NULL;
    cell_hello(c.alice, ALICE, ++c.sequence, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < BALLS; i++) {
        snprintf(name, sizeof name, "ball %d", i);
        cell_sphere(c.alice, ALICE, ++c.sequence, i, name, 1e-3 * i);
    }
    for (int i = 0; i < 10; i++) one_round(&c);
    for (int k = 0; k < STREAMS; k++) cell_touches(c.alice, ALICE, ++c.sequence, k);
    for (int i = 0; !all_have(&c); i++) {
        assert_true(i < 5000);
        one_round(&c);
    }
    for (int k = 0; k < STREAMS; k++) assert_int_equal(c.events[k], PAIRS);
    assert_in_range(c.most_bytes, ROUND_BYTES / 2, ROUND_BYTES + A_BURST);
    assert_true(c.longest_wait < 100);
    tear_down(&c);
}

int main(void)
{
    static int acknowledged = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_round_sends_more_than_its_share_of_what_waits),
        cmocka_unit_test_prestate(no_round_sends_more_than_its_share_of_what_waits, &acknowledged),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
