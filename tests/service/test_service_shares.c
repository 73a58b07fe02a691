/* Shares: what one participant may take under all its names, what others still get, and what waits for its turn. Each
 * end of the memory link is a participant. */
#include "cell.h"

#include "base/clock.h"

#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { CROWD = 11, NAMES = 20, BOB = 9000 };

typedef struct room {
    cell *cell;
    memory_end *crowd, *bob; /* one with many names, and his neighbour */
    wire_memory *memory;
    int64_t sequence;
} room;

static void room_open(room *r, const config *c)
{
    *r = (room){.cell = cell_start(c), .memory = wire_memory_create()};
    r->crowd = cell_client(r->cell);
    r->bob = cell_client(r->cell);
}

static void room_close(room *r)
{
    memory_disconnect(r->crowd);
    memory_disconnect(r->bob);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

static void ask(memory_end *e, int64_t client, int64_t sequence, const char *pattern)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .kind = WIRE_QUERY_BODIES,
            .most = 1,
            .name_a = pattern,
            .name_b = ""}};
    memory_send(e, &q);
}

typedef struct heard {
    int rejects, answers; /* answers: to others */
    char last[256];       /* Reject */
    char text[256];       /* of the answer that was waited for */
} heard;

/* What comes until that query is answered, as one of the ends hears it: both hear all. */
static heard hear_until(room *r, memory_end *e, int64_t client, int64_t sequence)
{
    heard h = {0};
    int64_t until = clock_monotonic_ns() + INT64_C(30000000000);
    while (clock_monotonic_ns() < until) {
        wire_message m;
        wire_memory_reset(r->memory);
        if (!memory_receive(e, r->memory, &m)) {
            usleep(200);
            continue;
        }
        if (m.kind == WIRE_REJECT) {
            h.rejects++;
            snprintf(h.last, sizeof h.last, "%s", m.reject.text);
        }
        bool is_it = m.kind == WIRE_ANSWER && m.answer.client == client && m.answer.sequence == sequence;
        if (is_it) snprintf(h.text, sizeof h.text, "%s", m.answer.text);
        if (is_it) return h;
        h.answers += m.kind == WIRE_ANSWER;
    }
    fail_msg("no answer within 30 s");
    return h;
}

/* All that the crowd has sent until now is carried out, or refused. */
static heard settle(room *r)
{
    ask(r->crowd, CROWD, ++r->sequence, "nobody");
    return hear_until(r, r->crowd, CROWD, r->sequence);
}

static heard settle_bob(room *r)
{
    ask(r->bob, BOB, ++r->sequence, "nobody");
    return hear_until(r, r->bob, BOB, r->sequence);
}

static void forget(room *r, memory_end *e)
{
    wire_message m;
    do wire_memory_reset(r->memory);
    while (memory_receive(e, r->memory, &m));
}

static void put(room *r, memory_end *e, int64_t client, int32_t body)
{
    char name[32];
    snprintf(name, sizeof name, "%d.%d", (int)client, (int)body);
    cell_sphere(e, client, ++r->sequence, body, name, 5.0 * body + 100000.0 * (double)(client % 100));
}

static void expect(const heard *h, int rejects, const char *says)
{
    assert_int_equal(h->rejects, rejects);
    if (!strstr(h->last, says)) fail_msg("\"%s\" does not say \"%s\"", h->last, says);
}

static void clients_of_one_participant(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_clients = 8;
    room_open(&r, &c);
    for (int i = 0; i < NAMES; i++) cell_hello(r.crowd, CROWD + i, ++r.sequence, 60, WIRE_LOST_REMOVE);
    heard h = settle(&r);
    expect(&h, NAMES - 6, "max_clients: 6 of 8 are the share of one participant");
    forget(&r, r.bob);
    cell_hello(r.bob, BOB, ++r.sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(r.bob, BOB + 1, ++r.sequence, 60, WIRE_LOST_REMOVE);
    h = settle_bob(&r);
    expect(&h, 0, "");
    wire_message m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&m.status, "clients"), 8);
    assert_non_null(strstr(m.status.limits, "max_clients"));
    assert_int_equal(cell_counter(&m.status, "share_refused"), NAMES - 6);
    room_close(&r);
}

static void bodies_and_shapes_of_one_participant(void **state)
{
    (void)state;
    room r;
    for (int shapes = 0; shapes < 2; shapes++) {
        config c = cell_config();
        *(shapes ? &c.max_shapes : &c.max_bodies) = 8;
        room_open(&r, &c);
        for (int i = 0; i < NAMES; i++) put(&r, r.crowd, CROWD + i, 0);
        heard h = settle(&r);
        expect(&h, NAMES - 6, shapes ? "max_shapes: 6 of 8 are the share" : "max_bodies: 6 of 8 are the share");
        forget(&r, r.bob);
        put(&r, r.bob, BOB, 0);
        put(&r, r.bob, BOB, 1);
        h = settle_bob(&r);
        expect(&h, 0, "");
        forget(&r, r.crowd);
        wire_message gone = {.kind = WIRE_BODY,
            .body = {.version = WIRE_VERSION,
                .client = CROWD,
                .sequence = ++r.sequence,
                .body = 0,
                .removed = 1,
                .name = "",
                .group = ""}};
        memory_send(r.crowd, &gone); /* makes room for one */
        put(&r, r.crowd, CROWD + 1, 1);
        put(&r, r.crowd, CROWD + 2, 1);
        h = settle(&r);
        expect(&h, 1, "6 of 8");
        room_close(&r);
    }
}

static void subscriptions_of_one_participant(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_subscriptions = 4;
    room_open(&r, &c);
    for (int i = 0; i < 6; i++) cell_touches(r.crowd, CROWD + i, ++r.sequence, i);
    heard h = settle(&r);
    expect(&h, 3, "max_subscriptions: 3 of 4 are the share");
    forget(&r, r.bob);
    cell_touches(r.bob, BOB, ++r.sequence, 0);
    h = settle_bob(&r);
    expect(&h, 0, "");
    room_close(&r);
}

/* The last piece of a height field, which counts from then on. */
static void field(room *r, memory_end *e, int64_t client, int32_t columns)
{
    int32_t rows = 65536;
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HEIGHT_FIELD,
            .hash = 5 + columns,
            .vertex_numbers = 3 + columns * rows,
            .index_numbers = 2,
            .piece = columns,
            .pieces = columns + 1,
            .vertices = {3, (const double[3]){1, 1, 1}},
            .indices = {2, (const int32_t[2]){columns, rows}}}};
    memory_send(e, &m);
}

static void geometries_of_one_participant(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_geometries = 4;
    room_open(&r, &c);
    for (int i = 0; i < 6; i++) field(&r, r.crowd, CROWD + i, 2 + i);
    heard h = settle(&r);
    expect(&h, 3, "max_geometries: 3 of 4 are the share");
    forget(&r, r.bob);
    field(&r, r.bob, BOB, 2);
    h = settle_bob(&r);
    expect(&h, 0, "");
    room_close(&r);
}

/* A limit that is named for one client holds for all that a participant calls itself. */
static void a_named_limit_holds_for_all_names(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_bodies = 2;
    room_open(&r, &c);
    for (int i = 0; i < 3; i++) put(&r, r.crowd, CROWD + i, 0);
    heard h = settle(&r);
    expect(&h, 1, "max_client_bodies = 2 is reached by this participant");
    room_close(&r);
}

static void greet(memory_end *e, int64_t client, int64_t sequence, const char *name)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .lease_ns = INT64_C(2000000000),
            .name = name}};
    memory_send(e, &m);
}

/* No place is left: the operator's tool is let ask all the same, and takes none; others are told why not. */
static void the_operator_may_ask_in_any_crowd(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_clients = 2;
    c.share = 100;
    room_open(&r, &c);
    cell_hello(r.crowd, CROWD, ++r.sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(r.crowd, CROWD + 1, ++r.sequence, 60, WIRE_LOST_REMOVE);
    (void)settle(&r);
    forget(&r, r.bob);
    for (int i = 0; i < 10; i++) greet(r.bob, BOB + i, ++r.sequence, "collidectl");
    wire_message m = cell_await(r.bob, r.memory, WIRE_ACK);
    assert_int_equal(m.ack.client, BOB);
    heard h = settle_bob(&r);
    expect(&h, 0, "");
    cell_touches(r.bob, BOB, ++r.sequence, 0);
    greet(r.bob, BOB + 1, ++r.sequence, "somebody");
    h = settle_bob(&r);
    expect(&h, 2, "max_clients = 2 is reached");
    m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&m.status, "clients"), 2);
    assert_int_equal(cell_counter(&m.status, "operators_greeted"), 10);
    room_close(&r);
}

static void leases_of_an_hour(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    room_open(&r, &c);
    cell_hello(r.bob, BOB, ++r.sequence, 3600, WIRE_LOST_REMOVE);
    heard h = settle_bob(&r);
    expect(&h, 0, "");
    cell_hello(r.bob, BOB, ++r.sequence, 3601, WIRE_LOST_REMOVE);
    h = settle_bob(&r);
    expect(&h, 1, "lease_ns: 3601 s is longer than the longest lease of an hour");
    room_close(&r);
}

/* Ten thousand queries of one come before one of his neighbour, who is answered long before they are. */
static void a_flood_of_queries(void **state)
{
    enum { BODIES = 3000, QUERIES = 10000 };
    (void)state;
    room r;
    for (int visits = 0; visits < 2; visits++) { /* by clients; by those who are none */
        config c = cell_config();
        room_open(&r, &c);
        for (int i = 0; i < BODIES; i++) put(&r, r.bob, 7777, i);
        for (int i = 0; !visits && i < 2; i++)
            cell_hello(i ? r.bob : r.crowd, i ? BOB : CROWD, ++r.sequence, 60, WIRE_LOST_REMOVE);
        ask(r.bob, 7777, ++r.sequence, "nobody");
        (void)hear_until(&r, r.bob, 7777, r.sequence);
        forget(&r, r.bob);
        for (int i = 0; i < QUERIES; i++) ask(r.crowd, CROWD, ++r.sequence, "*");
        heard h = settle_bob(&r);
        expect(&h, 0, "");
        assert_in_range(h.answers, 0, QUERIES / 4);
        room_close(&r);
    }
}

static wire_message ask_space(room *r, wire_query q)
{
    static const double origin[3] = {0, 0, 0}, half[3] = {1e7, 1e7, 1e7}, turned[4] = {1, 0, 0, 0};
    q.version = WIRE_VERSION;
    q.client = BOB;
    q.sequence = ++r->sequence;
    q.name_a = q.name_b = "";
    q.origin = (wire_f64s){3, origin};
    q.half = (wire_f64s){3, half};
    q.orientation = (wire_f64s){4, turned};
    memory_send(r->bob, &(wire_message){.kind = WIRE_QUERY, .query = q});
    return cell_await(r->bob, r->memory, WIRE_ANSWER);
}

/* A search through all of a large world is given up: what it found of all in a box is true, and said to be a part; of
 * the nearest nothing is said. */
static void searches_that_are_given_up(void **state)
{
    enum { BODIES = 60000 };
    (void)state;
    room r;
    config c = cell_config();
    room_open(&r, &c);
    for (int i = 0; i < BODIES; i++) put(&r, r.crowd, CROWD, i);
    (void)settle(&r);
    forget(&r, r.bob);
    wire_message m = ask_space(&r, (wire_query){.kind = WIRE_QUERY_BOX});
    assert_int_equal(m.answer.status, WIRE_ANSWER_TRUNCATED);
    assert_in_range(m.answer.lo.count, 1, WIRE_ANSWERS_MAX);
    if (!strstr(m.answer.text, "took too long")) fail_msg("%s", m.answer.text);
    m = ask_space(&r, (wire_query){.kind = WIRE_QUERY_NEAREST, .length_m = 1e7, .tolerance_m = 1e-6});
    assert_int_equal(m.answer.status, WIRE_ANSWER_UNSUPPORTED);
    assert_int_equal(m.answer.lo.count, 0);
    if (!strstr(m.answer.text, "given up")) fail_msg("%s", m.answer.text);
    m = cell_await(r.bob, r.memory, WIRE_STATUS);
    m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_in_range(cell_counter(&m.status, "queries_cut"), 2, 9); /* some to settle, too, where all is slow */
    room_close(&r);
}

/* Poses of clients that nobody knows, under ever new names, leave nothing behind. */
static void strangers_leave_no_purse(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    room_open(&r, &c);
    for (int i = 0; i < 20000; i++) cell_pose(r.crowd, 100000 + i, ++r.sequence, 0, i);
    (void)settle(&r);
    forget(&r, r.bob);
    put(&r, r.bob, BOB, 0);
    wire_message m = cell_await(r.bob, r.memory, WIRE_STATUS);
    m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_in_range(cell_counter(&m.status, "purses"), 1, 4);
    room_close(&r);
}

/* What a large scene exceeds its share by waits, in its order, while others go on; a recording has it as it was taken,
 * and a pose of a body that waits waits with it. */
static void what_waits_keeps_its_order(void **state)
{
#if defined(__SANITIZE_THREAD__) /* a query takes too long for more of them, and says so */
    enum { BODIES = 2000 };
#else
    enum { BODIES = 8000 };
#endif
    static const char path[] = "shares.lcmlog";
    char name[16];
    snprintf(name, sizeof name, "%d.%d", CROWD, BODIES - 1);
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_work = 10;
    (void)unlink(path);
    snprintf(c.record, sizeof c.record, "%s", path);
    room_open(&r, &c);
    cell_touches(r.bob, BOB, ++r.sequence, 0);
    (void)settle_bob(&r);
    forget(&r, r.crowd);
    for (int i = 0; i < BODIES; i++) put(&r, r.crowd, CROWD, i);
    int64_t copy = r.sequence;
    cell_sphere(r.crowd, CROWD, copy, BODIES - 1, name, 0);                /* of the last one: it waits once */
    cell_pose(r.crowd, CROWD, ++r.sequence, BODIES - 1, 100000.0 * CROWD); /* into the first one */
    int64_t last = ++r.sequence;
    ask(r.crowd, CROWD, last, "*");
    ask(r.bob, BOB, ++r.sequence, "*");
    heard h = hear_until(&r, r.bob, BOB, r.sequence);
    int there = atoi(h.text);
    assert_in_range(there, 0, BODIES - 1);
    h = hear_until(&r, r.crowd, CROWD, last);
    expect(&h, 0, "");
    assert_int_equal(atoi(h.text), BODIES);
    wire_message m = cell_await(r.bob, r.memory, WIRE_EVENT_BATCH);
    while (!m.event_batch.names_a.count) m = cell_await(r.bob, r.memory, WIRE_EVENT_BATCH);
    assert_true(cell_await(r.bob, r.memory, WIRE_STATUS).kind == WIRE_STATUS);
    m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_in_range(cell_counter(&m.status, "commands_waited"), 100, BODIES + 2);
    assert_int_equal(cell_counter(&m.status, "duplicates"), 1);
    assert_int_equal(cell_counter(&m.status, "waiting_messages"), 0);
    assert_in_range(cell_counter(&m.status, "client_spent_ms_000000000000000b"), 20, 1000);
    room_close(&r);
    assert_int_equal(cell_replay(path, 1, true), 0);
    assert_int_equal(cell_replay(path, 2, false), 0);
    (void)unlink(path);
}

/* Behind that it is refused, by the name of the limit, and its neighbour has room. */
static void what_waits_has_a_limit(void **state)
{
    enum { BODIES = 10000 };
    (void)state;
    room r;
    config c = cell_config();
    c.max_client_work = 1;
    c.max_waiting = 1;
    room_open(&r, &c);
    for (int i = 0; i < BODIES; i++) put(&r, r.crowd, CROWD, i);
    wire_message m;
    do m = cell_await(r.bob, r.memory, WIRE_STATUS);
    while (!cell_counter(&m.status, "share_refused"));
    assert_non_null(strstr(m.status.limits, "max_waiting"));
    assert_in_range(cell_counter(&m.status, "waiting_bytes"), 1, 3 << 18);
    m = cell_await(r.crowd, r.memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_LIMIT);
    assert_non_null(strstr(m.reject.text, "max_waiting"));
    forget(&r, r.bob);
    put(&r, r.bob, BOB, 0);
    ask(r.bob, BOB, ++r.sequence, "9000.0");
    for (int64_t asked = r.sequence;;) { /* others' refusals are heard, too */
        wire_memory_reset(r.memory);
        if (!memory_receive(r.bob, r.memory, &m)) continue;
        assert_false(m.kind == WIRE_REJECT && m.reject.client == BOB);
        if (m.kind != WIRE_ANSWER || m.answer.sequence != asked) continue;
        assert_int_equal(m.answer.lo.count, 1);
        break;
    }
    room_close(&r);
}

/* A tick takes so much work of all together; poses, which are never refused for that, do not use up what others are to
 * have of it. */
static void poses_leave_room_for_queries(void **state)
{
    enum { POSES = 65536, BATCHES = 8 }; /* by their price, twice what a tick takes */
    static int32_t bodies[POSES];
    static double positions[3 * POSES], orientations[4 * POSES];
    (void)state;
    room r;
    config c = cell_config();
    c.rate = 2; /* all of them, and the query, between two ticks */
    room_open(&r, &c);
    cell_hello(r.crowd, CROWD, ++r.sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(r.bob, BOB, ++r.sequence, 60, WIRE_LOST_REMOVE);
    wire_message flood = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = CROWD,
            .bodies = {POSES, bodies},
            .positions = {3 * POSES, positions},
            .orientations = {4 * POSES, orientations}}};
    for (int32_t i = 0; i < POSES; i++) {
        bodies[i] = i;
        orientations[4 * i] = 1;
    }
    settle_bob(&r);
    for (int i = 0; i < BATCHES; i++) {
        flood.pose_batch.sequence = ++r.sequence;
        memory_send(r.crowd, &flood);
    }
    settle_bob(&r);
    forget(&r, r.bob);
    wire_message m = cell_await(r.bob, r.memory, WIRE_STATUS);
    assert_int_equal(cell_counter(&m.status, "commands_waited"), 0);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(clients_of_one_participant),
        cmocka_unit_test(bodies_and_shapes_of_one_participant),
        cmocka_unit_test(subscriptions_of_one_participant),
        cmocka_unit_test(geometries_of_one_participant),
        cmocka_unit_test(a_named_limit_holds_for_all_names),
        cmocka_unit_test(the_operator_may_ask_in_any_crowd),
        cmocka_unit_test(leases_of_an_hour),
        cmocka_unit_test(a_flood_of_queries),
        cmocka_unit_test(searches_that_are_given_up),
        cmocka_unit_test(strangers_leave_no_purse),
        cmocka_unit_test(what_waits_keeps_its_order),
        cmocka_unit_test(what_waits_has_a_limit),
        cmocka_unit_test(poses_leave_room_for_queries),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
