/* Two daemons of a pair that are active at the same time, because the network between them was parted, or because one
 * began without hearing of the other: the one that clients follow stays, and nobody takes what it tells for the
 * continuation of what the other one told.
 *
 * Clients speak by the memory link, the daemons by peers.h; each has a client of its own, and the clock is the test's.
 * One thread. */
#include "base/log.h"
#include "cell.h"
#include "peers.h"
#include "service/clients.h"
#include "service/server.h"
#include "service/service.h"
#include "service/standby.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <time.h>

enum { CLIENT = 7 };
static const int64_t TICK_NS = 10000000, S_NS = 1000000000;

typedef struct side {
    server *server; /* NULL: there is none */
    service *service;
    link_sink sink;
    link_ops ops;
    memory_end *end;
    bool stands_still;
    int64_t epoch;                       /* that the client on this side was told of last ... */
    bool snapshot;                       /* ... with a snapshot */
    bool closed;                         /* its stream of subscription 0 */
    size_t begun, told_lost, batches[2]; /* batches: of each subscription */
} side;

static side sides[2];
static int64_t now_ns;
static wire_memory *memory;

static void start(int k)
{
    char why[256] = "";
    side *a = &sides[k];
    config c = cell_config();
    snprintf(c.links, sizeof c.links, "memory://%d", k);
    *a = (side){.server = server_create(&c, why, sizeof why)};
    if (!a->server) fail_msg("%s", why);
    service *s = a->service = server_service(a->server);
    a->sink = server_sink(a->server);
    a->end = memory_connect(c.links + strlen("memory://"));
    s->now_ns = s->monotonic_ns = now_ns;
    peers_pair_up(s, &a->ops);
    a->ops.has_liveliness = true; /* as DDS: clients need not say that they are there */
}

static void end(int k)
{
    if (!sides[k].server) return;
    peers_die(sides[k].service->links[0]);
    memory_disconnect(sides[k].end);
    server_destroy(sides[k].server);
    sides[k].server = NULL;
}

static void learn(side *a)
{
    wire_message m;
    for (wire_memory_reset(memory); memory_receive(a->end, memory, &m); wire_memory_reset(memory)) {
        a->told_lost += m.kind == WIRE_REJECT && m.reject.reason == WIRE_UNKNOWN_CLIENT;
        if (m.kind != WIRE_EVENT_BATCH || m.event_batch.heartbeat) continue;
        a->snapshot = (a->snapshot && m.event_batch.epoch == a->epoch) || m.event_batch.snapshot;
        a->epoch = m.event_batch.epoch;
        a->batches[m.event_batch.subscription]++;
        a->closed |= m.event_batch.closing && m.event_batch.subscription == 0;
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            a->begun += m.event_batch.kinds.at[i] == WIRE_EVENT_BEGIN;
    }
}

static bool is_active(int k)
{
    return sides[k].server && !standby_waits(sides[k].service);
}

static void round_of(side *a)
{
    service *s = a->service;
    s->now_ns = s->monotonic_ns = now_ns;
    s->links[0]->ops->receive(s->links[0], &a->sink);
    if (!standby_round(s, &a->sink)) peers_work(s);
    learn(a);
}

static void pass(int64_t ns)
{
    for (int64_t until_ns = now_ns + ns; now_ns < until_ns;) {
        now_ns += TICK_NS;
        for (int k = 0; k < 2; k++)
            if (sides[k].server && !sides[k].stands_still) round_of(&sides[k]);
    }
}

static bool has_standby(int k)
{
    return peers_have_standby(sides[k].service);
}

static void announce(side *a)
{
    cell_hello(a->end, CLIENT, 1, 1, WIRE_LOST_REMOVE);
    cell_sphere(a->end, CLIENT, 2, 0, "a", 0);
    cell_sphere(a->end, CLIENT, 3, 1, "b", 5);
    cell_touches(a->end, CLIENT, 4, 0);
}

/* The one is active and the other its standby, and a client is told of two balls that are apart. */
static void pair_up(void)
{
    start(0);
    pass(2 * S_NS);
    start(1);
    pass(S_NS);
    assert_true(is_active(0) && has_standby(0) && !is_active(1));
    for (int k = 0; k < 2; k++) announce(&sides[k]); /* the network brings it to both */
    pass(S_NS / 10);
    assert_true(sides[0].snapshot && sides[0].epoch == sides[0].service->epoch && sides[0].begun == 0);
}

static int set_up(void **state)
{
    (void)state;
    log_setup(LOG_ERROR, 0);
    memory = wire_memory_create();
    now_ns = 1000 * S_NS;
    return 0;
}

static int tear_down(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) end(k);
    peers_forget();
    wire_memory_destroy(memory);
    return 0;
}

/* ---- who stays ---- */

/* It is the later one, although the other began first: clients that hear both follow the higher epoch. */
static void of_two_active_ones_the_one_with_the_higher_epoch_stays(void **state)
{
    (void)state;
    peers_part(true);
    start(0);
    start(1);
    pass(2 * S_NS);
    assert_true(is_active(0) && is_active(1));
    int higher = sides[1].service->epoch > sides[0].service->epoch;
    if (*state) higher = !higher;
    sides[higher].service->epoch += S_NS * 3600; /* the clock of that one was ahead */
    int64_t epoch = sides[higher].service->epoch;
    pass(S_NS);
    peers_part(false);
    pass(2 * S_NS);
    assert_true(is_active(higher) && !is_active(!higher) && has_standby(higher));
    assert_int_equal(sides[higher].service->epoch, epoch);
}

/* Whoever followed that one would not believe a lower one until he had heard nothing for a while. */
static void who_begins_anew_is_above_all_that_it_has_heard_of(void **state)
{
    (void)state;
    start(0);
    pass(2 * S_NS);
    int64_t epoch = sides[0].service->epoch += S_NS * 3600; /* and now the clock is set back by an hour */
    pass(S_NS);
    start(1);
    now_ns += TICK_NS;
    round_of(&sides[1]); /* it has heard of it, and has nothing of it yet */
    end(0);
    pass(4 * S_NS);
    assert_true(is_active(1));
    assert_true(sides[1].service->epoch > epoch && !wire_same_line(sides[1].service->epoch, epoch));
}

/* ---- what was told ---- */

/* Each of them tells its own clients of a contact, under the same numbers. */
static void what_one_told_alone_is_not_continued_by_the_other(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    peers_part(true);
    pass(S_NS);
    assert_true(is_active(0) && is_active(1) && sides[1].service->epoch == epoch + 1);
    for (int k = 0; k < 2; k++) cell_pose(sides[k].end, CLIENT, 5 + k, 1, 1.0 + 0.5 * k);
    pass(S_NS);
    assert_true(sides[0].begun == 1 && sides[1].begun == 1);
    peers_part(false);
    pass(2 * S_NS);
    assert_true(!is_active(0) && is_active(1) && has_standby(1));
    assert_true(sides[1].service->epoch > epoch + 1 && !wire_same_line(sides[1].service->epoch, epoch));
    assert_true(sides[1].epoch == sides[1].service->epoch && sides[1].snapshot && sides[1].begun == 2);
}

/* It told nothing meanwhile: streams go on. */
static void who_stood_still_disturbs_nobody(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    peers_part(true);
    sides[0].stands_still = true;
    pass(S_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
    peers_part(false);
    sides[0].stands_still = false;
    pass(2 * S_NS);
    assert_true(!is_active(0) && is_active(1) && has_standby(1));
    assert_int_equal(sides[1].service->epoch, epoch + 1);
}

/* ---- one that gives no sign of life ---- */

enum { LEASE_NS = 100000000 }; /* the default */

static const struct link *link_of(int k)
{
    return sides[k].service->links[0];
}

static void fall_silent(int k)
{
    sides[k].stands_still = true;
    pass(LEASE_NS);
    peers_flicker(link_of(k), false);
}

static void be_back(int k)
{
    sides[k].stands_still = false;
    peers_flicker(link_of(k), true);
}

/* It may be about to take over, and would not know of it. */
static void nothing_is_told_that_a_silent_standby_does_not_have(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    cell_pose(sides[1].end, CLIENT, 5, 1, 1);
    pass(LEASE_NS / 2);
    assert_int_equal(sides[0].begun, 0);
    sides[0].stands_still = true; /* and it is lost in its turn, just when the other one is back */
    peers_flicker(link_of(0), false);
    be_back(1);
    pass(3 * LEASE_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
    assert_int_equal(sides[1].begun, 1);
    be_back(0);
    pass(2 * S_NS);
    assert_true(!is_active(0) && has_standby(1));
    assert_int_equal(sides[0].begun, 0);
    assert_int_equal(sides[1].service->epoch, epoch + 1); /* nobody was told anything else: the line goes on */
}

/* It is back before it would have been given up, and need not join anew. */
static void a_standby_that_is_soon_back_is_waited_for(void **state)
{
    (void)state;
    pair_up();
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(LEASE_NS / 2);
    be_back(1);
    pass(LEASE_NS / 5);
    assert_true(is_active(0) && has_standby(0) && !is_active(1));
    assert_int_equal(sides[0].begun, 1);
}

/* Nor is anybody kept waiting for ever. */
static void a_standby_that_stays_silent_is_given_up(void **state)
{
    (void)state;
    pair_up();
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(3 * LEASE_NS);
    assert_true(is_active(0) && !has_standby(0));
    assert_int_equal(sides[0].begun, 1);
    be_back(1);
    pass(S_NS);
    assert_true(is_active(0) && has_standby(0));
}

/* The word that it is waited for no more was lost, and it believes the other one alive for as long as its last words
 * take to be read. */
static void who_stood_still_for_long_asks_before_it_goes_on_from_there(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    peers_deafen(link_of(1), true);
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(S_NS);
    assert_int_equal(sides[0].begun, 1); /* alone */
    sides[0].stands_still = true;
    sides[1].stands_still = false;
    pass(2 * LEASE_NS);
    end(0);
    pass(3 * S_NS);
    assert_true(is_active(1));
    assert_false(wire_same_line(sides[1].service->epoch, epoch));
}

/* One that stood still for long, and is waited for all the same, is told so, and takes over as ever. */
static void who_stood_still_for_long_and_is_waited_for_takes_over(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    sides[1].stands_still = true;
    pass(5 * LEASE_NS); /* its liveliness is its link's, and not lost; nothing was told meanwhile */
    sides[1].stands_still = false;
    pass(3 * LEASE_NS);
    assert_true(is_active(0) && has_standby(0));
    end(0);
    pass(2 * LEASE_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
}

/* All that was told while it was alone is known to the next standby. */
static void who_was_alone_once_does_not_begin_a_new_line_later(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch;
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(3 * LEASE_NS);
    assert_int_equal(sides[0].begun, 1);
    be_back(1);
    pass(S_NS);
    assert_true(has_standby(0));
    sides[0].stands_still = true;
    peers_flicker(link_of(0), false);
    pass(S_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
    be_back(0);
    pass(2 * S_NS);
    assert_true(is_active(1) && has_standby(1));
    assert_int_equal(sides[1].service->epoch, epoch + 1);
}

/* A standby that ends in order says so: nobody waits for it. */
static void a_standby_that_leaves_is_not_waited_for(void **state)
{
    (void)state;
    pair_up();
    server_stop(sides[1].server);
    assert_int_equal(server_run(sides[1].server), 0);
    end(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(LEASE_NS / 5);
    assert_true(is_active(0) && !has_standby(0));
    assert_int_equal(sides[0].begun, 1);
}

/* It ends in order while it waits for a standby that is lost: clients are told so. */
static void who_ends_while_it_waits_tells_of_it(void **state)
{
    (void)state;
    pair_up();
    fall_silent(1);
    cell_pose(sides[0].end, CLIENT, 5, 1, 1);
    pass(LEASE_NS / 2);
    assert_int_equal(sides[0].begun, 0);
    server_stop(sides[0].server);
    assert_int_equal(server_run(sides[0].server), 0);
    learn(&sides[0]);
    assert_true(sides[0].begun == 1 && sides[0].closed);
}

/* ---- clients ---- */

static void lose(side *a)
{
    a->sink.client_lost(a->sink.context, a->service->links[0], CLIENT);
}

static bool knows(const side *a)
{
    return session_find(a->service, CLIENT) != NULL;
}

/* The active one opened the stream, and stood still before it heard of the reader. */
static void a_reader_that_came_long_before_the_take_over_is_told(void **state)
{
    (void)state;
    pair_up();
    for (int k = 0; k < 2; k++) cell_touches(sides[k].end, CLIENT, 5, 1);
    now_ns += TICK_NS;
    round_of(&sides[0]);
    sides[0].stands_still = true;
    pass(7 * S_NS);
    assert_true(!is_active(1) && sides[0].batches[1] == 0);
    peers_part(true);
    pass(S_NS);
    assert_true(is_active(1) && sides[1].batches[1] > 0);
}

/* It has nothing to say, and was heard by this daemon only while that was active. */
static void a_silent_client_outlives_two_take_overs(void **state)
{
    (void)state;
    pair_up();
    for (int k = 0; k < 2; k++) {
        peers_part(true);
        sides[k].stands_still = true;
        pass(S_NS);
        assert_true(is_active(!k));
        peers_part(false);
        sides[k].stands_still = false;
        pass(2 * S_NS);
        assert_true(!is_active(k) && has_standby(!k));
    }
    pass(3 * S_NS); /* more than its lease */
    assert_true(is_active(0) && knows(&sides[0]));
    assert_true(sides[0].told_lost == 0 && sides[1].told_lost == 0);
}

/* It was told so while it was active itself, and takes over the state of one that was not told. */
static void a_client_that_is_gone_does_not_come_back_with_a_state(void **state)
{
    (void)state;
    pair_up();
    peers_part(true);
    pass(S_NS);
    assert_true(is_active(0) && is_active(1));
    lose(&sides[1]);
    pass(S_NS);
    assert_true(knows(&sides[0]) && !knows(&sides[1]));
    sides[0].service->epoch += S_NS * 3600;
    pass(S_NS);
    peers_part(false);
    pass(2 * S_NS);
    assert_true(is_active(0) && has_standby(0) && knows(&sides[1]));
    end(0);
    pass(3 * S_NS);
    assert_true(is_active(1) && !knows(&sides[1]));
}

/* Both have come here alone: what it said is applied, and then its loss. */
static void what_a_lost_client_said_last_does_not_bring_it_back(void **state)
{
    (void)state;
    pair_up();
    sides[0].stands_still = true;
    cell_pose(sides[1].end, CLIENT, 5, 1, 1);
    now_ns += TICK_NS;
    round_of(&sides[1]);
    assert_true(!is_active(1));
    lose(&sides[1]);
    peers_part(true);
    pass(S_NS);
    assert_true(is_active(1) && !knows(&sides[1]));
}

/* It came late, and tells nothing of its sender: a link that has told of a loss tells of no second one. */
static void what_a_lost_client_said_late_does_not_bring_it_back(void **state)
{
    bool joins = *state != NULL; /* nothing was taken over */
    if (joins) {
        start(0);
        announce(&sides[0]);
    } else {
        pair_up();
    }
    side *a = &sides[!joins];
    if (!joins) sides[0].stands_still = true;
    now_ns += TICK_NS;
    round_of(a);
    lose(a);
    cell_pose(a->end, CLIENT, 5, 1, 1);
    now_ns += TICK_NS;
    round_of(a);
    assert_true(standby_waits(a->service));
    if (!joins) peers_part(true);
    pass(4 * S_NS);
    assert_true(!standby_waits(a->service) && !knows(a));
}

/* The active one may be gone before that has gone out: a client that lives would wait for its streams for ever. */
static void the_standby_tells_a_client_that_it_was_lost(void **state)
{
    (void)state;
    pair_up();
    now_ns += TICK_NS;
    lose(&sides[0]);
    for (int k = 0; k < 2; k++) round_of(&sides[k]);
    assert_true(!knows(&sides[0]) && sides[1].told_lost == 0);
    end(0);
    pass(S_NS);
    assert_true(is_active(1) && !knows(&sides[1]));
    assert_int_equal(sides[1].told_lost, 1);
}

static void say_receipt(int k, int64_t sequence, int64_t epoch, int64_t batch)
{
    wire_message m = {.kind = WIRE_RECEIPT,
        .receipt = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = sequence,
            .epoch = epoch,
            .batch = batch,
            .missing = true}};
    memory_send(sides[k].end, &m);
    pass(S_NS / 10);
}

/* A reader has heard more of the one before than this one knows: whatever it said next would be something else under
 * the same numbers. Nobody can bring it to that a second time. */
static void a_reader_who_was_told_more_brings_about_a_new_line(void **state)
{
    (void)state;
    pair_up();
    int64_t epoch = sides[0].service->epoch, batch = sides[0].service->streams.at[0].batch;
    end(0);
    pass(S_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
    say_receipt(1, 50, epoch, batch); /* it knows that */
    assert_int_equal(sides[1].service->epoch, epoch + 1);
    say_receipt(1, 51, epoch + 1, batch + 1); /* of its own? It has told none */
    assert_int_equal(sides[1].service->epoch, epoch + 1);
    start(0);
    pass(S_NS);
    assert_true(has_standby(1));
    sides[1].snapshot = false;
    say_receipt(1, 52, epoch, batch + 1);
    int64_t anew = sides[1].service->epoch;
    assert_true(anew > epoch && !wire_same_line(anew, epoch));
    assert_true(sides[1].snapshot && sides[1].epoch == anew);
    say_receipt(1, 53, anew - 1, batch + 100);
    say_receipt(1, 54, epoch, batch + 100);
    assert_int_equal(sides[1].service->epoch, anew);
    pass(S_NS);
    assert_true(is_active(1) && has_standby(1)); /* which has joined anew */
    assert_int_equal(metric_get(sides[0].service->count.out_of_step), 0);
}

/* ---- a large state ---- */

enum { MANY = 10000, A_ROUND = 4 << 20 };

/* Apart from each other, but for two of them, that a pose brings together and apart. */
static void announce_many(side *a)
{
    char name[16];
    cell_hello(a->end, CLIENT, 1, 1000, WIRE_LOST_REMOVE);
    for (int i = 0; i < MANY; i++) {
        snprintf(name, sizeof name, "%d", i);
        cell_sphere(a->end, CLIENT, 2 + i, i, name, 5.0 * i);
    }
    cell_touches(a->end, CLIENT, MANY + 2, 0);
    pass(20 * TICK_NS);
    assert_int_equal(world_get_figures(a->service->world).bodies, MANY);
}

/* A tick, with something to tell. */
static void swing(int times)
{
    static int64_t sequence;
    for (int i = 0; i < times; i++) {
        sequence++;
        cell_pose(sides[0].end, CLIENT, MANY + 10 + sequence, 1, sequence % 2 ? 1.0 : 5.0);
        pass(TICK_NS);
    }
}

static bool is_reported(int k)
{
    return sides[k].service->standby && !is_active(k) && sides[k].service->tick;
}

/* No round has to say all of it, ticks go on meanwhile, and what they told is known when it is whole. */
static void a_large_state_goes_in_portions_while_ticks_go_on(void **state)
{
    (void)state;
    start(0);
    pass(2 * S_NS);
    announce_many(&sides[0]);
    start(1);
    size_t begun = sides[0].begun, rounds = 0;
    peers_most();
    for (; !is_reported(1); rounds++) {
        assert_true(rounds < 1000);
        swing(1);
    }
    assert_true(rounds > 4 && sides[0].begun > begun);
    assert_in_range(peers_most(), 1, A_ROUND);
    swing(20);
    assert_true(is_active(0) && has_standby(0));
    assert_int_equal(sides[1].service->tick, sides[0].service->tick);
    assert_true(sides[0].service->events_hash == sides[1].service->events_hash);
    assert_int_equal(metric_get(sides[1].service->count.out_of_step), 0);
    int64_t epoch = sides[0].service->epoch;
    end(0);
    pass(S_NS);
    assert_true(is_active(1) && sides[1].service->epoch == epoch + 1);
}

/* Portions that were lost are no state: it is asked for anew. */
static void a_state_that_lost_a_portion_is_asked_for_anew(void **state)
{
    (void)state;
    start(0);
    pass(2 * S_NS);
    announce_many(&sides[0]);
    start(1);
    for (int i = 0; peers_most() < A_ROUND / 4; i++) {
        assert_true(i < 1000);
        swing(1);
    }
    peers_deafen(link_of(1), true);
    swing(2);
    peers_deafen(link_of(1), false);
    pass(S_NS);
    swing(20);
    assert_true(is_active(0) && has_standby(0));
    assert_true(sides[0].service->events_hash == sides[1].service->events_hash);
    assert_int_equal(metric_get(sides[1].service->count.out_of_step), 0);
}

/* The active one is gone before all of it has come: whoever joins goes on from nothing, or waits for another. */
static void a_state_that_is_cut_off_is_none(void **state)
{
    (void)state;
    start(0);
    pass(2 * S_NS);
    announce_many(&sides[0]);
    int64_t epoch = sides[0].service->epoch;
    start(1);
    for (int i = 0; peers_most() < A_ROUND / 4; i++) {
        assert_true(i < 1000);
        swing(1);
    }
    end(0);
    pass(3 * S_NS);
    assert_true(is_active(1) && !wire_same_line(sides[1].service->epoch, epoch));
    assert_int_equal(world_get_figures(sides[1].service->world).bodies, 0);
}

/* ---- geometry that is being built ---- */

enum { SIDE = 12, NUMBERS = WIRE_FIELD_HEAD + SIDE * SIDE };

static _Atomic bool gates[2]; /* of each daemon: its builds go on */

static void at_gate(void *context, int64_t id)
{
    (void)id;
    while (!*(_Atomic bool *)context) nanosleep(&(struct timespec){0, 1000000}, NULL);
}

static void *open_soon(void *context)
{
    nanosleep(&(struct timespec){0, 300000000}, NULL);
    *(_Atomic bool *)context = true;
    return NULL;
}

/* Ground that reaches both balls, and is too large to be built within a tick. */
static void announce_ground(memory_end *to)
{
    static const uint8_t types[1] = {WIRE_SHAPE_HEIGHT_FIELD};
    static const double size[3] = {0, 0, 0}, radius[1] = {0}, local[7] = {0, 0, 0, 1, 0, 0, 0};
    static const int32_t sides_of[2] = {SIDE, SIDE};
    double numbers[NUMBERS] = {4, 4, 1};
    for (int i = WIRE_FIELD_HEAD; i < NUMBERS; i++) numbers[i] = 0.01 * (i % 7);
    wire_message g = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = 10,
            .kind = WIRE_GEOMETRY_HEIGHT_FIELD,
            .vertex_numbers = NUMBERS,
            .index_numbers = 2,
            .pieces = 1,
            .vertices = {NUMBERS, numbers},
            .indices = {2, sides_of}}};
    g.geometry.hash = wire_geometry_hash(g.geometry.kind, g.geometry.vertices, g.geometry.indices);
    wire_message b = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = CLIENT,
            .sequence = 11,
            .body = 9,
            .name = "ground",
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, local},
            .shape_types = {1, types},
            .shape_sizes = {3, size},
            .shape_radii = {1, radius},
            .shape_poses = {7, local},
            .shape_geometries = {1, &g.geometry.hash}}};
    memory_send(to, &g);
    memory_send(to, &b);
}

static void announce_ground_to_both(void)
{
    for (int k = 0; k < 2; k++) {
        gates[k] = false;
        builds_hold(sides[k].service->builds, at_gate, &gates[k]);
        announce_ground(sides[k].end);
    }
    pass(S_NS / 10);
    for (int k = 0; k < 2; k++) {
        assert_int_equal(sides[k].service->pending.count, 1);
        assert_int_equal(sides[k].service->geometries_building, 1);
    }
}

/* Its tick waits for its own build, which is slower; then both know the same. */
static void a_standby_has_a_build_in_the_tick_of_the_active_one(void **state)
{
    (void)state;
    pthread_t opener;
    pair_up();
    announce_ground_to_both();
    gates[0] = true;
    assert_int_equal(pthread_create(&opener, NULL, open_soon, &gates[1]), 0);
    for (int i = 0; i < 500 && sides[0].service->pending.count; i++) {
        nanosleep(&(struct timespec){0, 10000000}, NULL);
        pass(TICK_NS);
    }
    pass(S_NS / 10);
    pthread_join(opener, NULL);
    assert_true(is_active(0) && has_standby(0) && !is_active(1));
    for (int k = 0; k < 2; k++) assert_int_equal(sides[k].service->pending.count, 0);
    assert_true(sides[0].service->events_hash == sides[1].service->events_hash);
    assert_int_equal(sides[0].begun, 2);
    assert_int_equal(metric_get(sides[1].service->count.out_of_step), 0);
}

/* The active one dies before its build is over: whoever goes on has its own. */
static void a_standby_that_takes_over_ends_the_build(void **state)
{
    (void)state;
    pair_up();
    announce_ground_to_both();
    gates[1] = true;
    pass(S_NS);
    assert_int_equal(sides[1].service->pending.count, 1); /* nobody has said that it is over */
    gates[0] = true;
    sides[0].stands_still = true;
    end(0);
    for (int i = 0; i < 500 && sides[1].service->pending.count; i++) {
        nanosleep(&(struct timespec){0, 10000000}, NULL);
        pass(S_NS / 10);
    }
    assert_true(is_active(1));
    assert_int_equal(sides[1].service->pending.count, 0);
    pass(S_NS / 10);
    assert_int_equal(sides[1].begun, 2);
}

/* It gets the state while the active one builds, and builds it, too. */
static void a_standby_that_joins_meanwhile_builds_it_too(void **state)
{
    (void)state;
    start(0);
    pass(2 * S_NS);
    announce(&sides[0]);
    gates[0] = false;
    builds_hold(sides[0].service->builds, at_gate, &gates[0]);
    announce_ground(sides[0].end);
    pass(S_NS / 10);
    cell_pose(sides[0].end, CLIENT, 20, 9, 1000); /* it waits with its body */
    pass(S_NS / 10);
    assert_int_equal(sides[0].service->pending.count, 1);
    start(1);
    pass(S_NS);
    assert_true(has_standby(0));
    assert_int_equal(sides[1].service->pending.count, 1);
    gates[0] = true;
    for (int i = 0; i < 500 && sides[1].service->pending.count; i++) {
        nanosleep(&(struct timespec){0, 10000000}, NULL);
        pass(TICK_NS);
    }
    pass(S_NS / 10);
    assert_true(has_standby(0) && !is_active(1));
    assert_int_equal(world_get_figures(sides[1].service->world).bodies, 3);
    assert_true(sides[0].service->events_hash == sides[1].service->events_hash);
    assert_int_equal(sides[0].begun, 0); /* it is far away by its pose */
    assert_int_equal(metric_get(sides[1].service->count.out_of_step), 0);
}

int main(void)
{
    static int ahead = 1, joins = 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_prestate_setup_teardown(
            of_two_active_ones_the_one_with_the_higher_epoch_stays, set_up, tear_down, NULL),
        {"the_same_with_the_other_clock_ahead", of_two_active_ones_the_one_with_the_higher_epoch_stays, set_up,
            tear_down, &ahead},
        cmocka_unit_test_setup_teardown(a_standby_has_a_build_in_the_tick_of_the_active_one, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_standby_that_takes_over_ends_the_build, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_standby_that_joins_meanwhile_builds_it_too, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_begins_anew_is_above_all_that_it_has_heard_of, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_one_told_alone_is_not_continued_by_the_other, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_stood_still_disturbs_nobody, set_up, tear_down),
        cmocka_unit_test_setup_teardown(nothing_is_told_that_a_silent_standby_does_not_have, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_standby_that_is_soon_back_is_waited_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_standby_that_stays_silent_is_given_up, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_stood_still_for_long_asks_before_it_goes_on_from_there, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_stood_still_for_long_and_is_waited_for_takes_over, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_was_alone_once_does_not_begin_a_new_line_later, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_standby_that_leaves_is_not_waited_for, set_up, tear_down),
        cmocka_unit_test_setup_teardown(who_ends_while_it_waits_tells_of_it, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_reader_who_was_told_more_brings_about_a_new_line, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_large_state_goes_in_portions_while_ticks_go_on, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_state_that_lost_a_portion_is_asked_for_anew, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_state_that_is_cut_off_is_none, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_reader_that_came_long_before_the_take_over_is_told, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_silent_client_outlives_two_take_overs, set_up, tear_down),
        cmocka_unit_test_setup_teardown(a_client_that_is_gone_does_not_come_back_with_a_state, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_a_lost_client_said_last_does_not_bring_it_back, set_up, tear_down),
        cmocka_unit_test_setup_teardown(what_a_lost_client_said_late_does_not_bring_it_back, set_up, tear_down),
        {"the_same_before_anything_was_taken_over", what_a_lost_client_said_late_does_not_bring_it_back, set_up,
            tear_down, &joins},
        cmocka_unit_test_setup_teardown(the_standby_tells_a_client_that_it_was_lost, set_up, tear_down),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
