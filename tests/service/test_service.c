/* The daemon as its clients see it, over the memory link: acknowledged, refused, told, lost, ended in order. */
#include "cell.h"

#include <math.h>
#include <stdio.h>

enum { ALICE = 11, BOB = 22 };

typedef struct room {
    cell *cell;
    memory_end *alice, *bob;
    wire_memory *memory;
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    r.bob = cell_client(r.cell);
    cell_hello(r.alice, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_hello(r.bob, BOB, 1, 60, WIRE_LOST_REMOVE);
    *state = &r;
    return 0;
}

static int close_room(void **state)
{
    room *r = *state;
    memory_disconnect(r->alice);
    memory_disconnect(r->bob);
    int status = cell_stop(r->cell);
    wire_memory_destroy(r->memory);
    return status;
}

/* Acknowledgements of others come too: the end hears all that the link sends. */
static void await_ack(room *r, memory_end *e, int64_t client, int64_t sequence)
{
    for (;;) {
        wire_message m = cell_await(e, r->memory, WIRE_ACK);
        for (uint32_t i = 0; m.ack.client == client && i < m.ack.sequences.count; i++)
            if (m.ack.sequences.at[i] == sequence) return;
    }
}

static wire_event_batch await_event(room *r, memory_end *e, uint8_t kind)
{
    for (;;) {
        wire_message m = cell_await(e, r->memory, WIRE_EVENT_BATCH);
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            if (m.event_batch.kinds.at[i] == kind) return m.event_batch;
    }
}

static void expect_reject(room *r, memory_end *e, wire_reason reason, wire_kind kind, const char *says)
{
    wire_message m = cell_await(e, r->memory, WIRE_REJECT);
    if (m.reject.reason != reason)
        fail_msg("refused for %s: %s; expected %s", wire_reason_name((wire_reason)m.reject.reason), m.reject.text,
            wire_reason_name(reason));
    assert_int_equal(m.reject.kind, kind);
    if (!strstr(m.reject.text, says)) fail_msg("\"%s\" does not say \"%s\"", m.reject.text, says);
}

static int64_t status_counter(room *r, memory_end *e, const char *name)
{
    cell_await(e, r->memory, WIRE_STATUS); /* may be older than what the caller did */
    wire_message m = cell_await(e, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static bool status_has(room *r, memory_end *e, const char *name)
{
    cell_await(e, r->memory, WIRE_STATUS);
    wire_message m = cell_await(e, r->memory, WIRE_STATUS);
    for (uint32_t i = 0; i < m.status.counter_names.count; i++)
        if (strcmp(m.status.counter_names.at[i], name) == 0) return true;
    return false;
}

static void a_contact_of_two_clients_bodies_reaches_the_subscriber(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->bob, BOB, 2, 0, "b", 5);
    cell_touches(r->bob, BOB, 3, 0);
    await_ack(r, r->bob, BOB, 3);
    cell_pose(r->alice, ALICE, 3, 0, 3.5);
    wire_event_batch b = await_event(r, r->bob, WIRE_EVENT_BEGIN);
    assert_int_equal(b.client, BOB);
    assert_string_equal(b.stream, "0000000000000016.0");
    assert_string_equal(b.names_a.at[0], "a");
    assert_string_equal(b.names_b.at[0], "b");
    assert_true(b.lo.at[0] <= -0.5 && b.lo.at[0] > -0.5 - 1e-6);
    cell_pose(r->alice, ALICE, 4, 0, 0);
    await_event(r, r->bob, WIRE_EVENT_END);
}

static void poses_that_come_before_their_body_are_applied(void **state)
{
    room *r = *state;
    cell_sphere(r->bob, BOB, 2, 0, "b", 5);
    cell_touches(r->bob, BOB, 3, 0);
    await_ack(r, r->bob, BOB, 3);
    cell_pose(r->alice, ALICE, 3, 0, 5.5); /* a network has no order: the newer one first */
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    wire_message m;
    while (!cell_next(r->alice, r->memory, WIRE_REJECT, 10, &m)) { /* fails by the test's time */
        if (!cell_next(r->bob, r->memory, WIRE_EVENT_BATCH, 10, &m)) continue;
        if (m.event_batch.kinds.count && m.event_batch.kinds.at[0] == WIRE_EVENT_BEGIN) return; /* one tick took both */
    }
    /* two ticks: the pose was refused by name, and the client sends it again on the Ack */
    assert_int_equal(m.reject.reason, WIRE_UNKNOWN_BODY);
    cell_pose(r->alice, ALICE, 4, 0, 5.5);
    wire_event_batch b = await_event(r, r->bob, WIRE_EVENT_BEGIN);
    assert_true(strcmp(b.names_a.at[0], "a") == 0 || strcmp(b.names_b.at[0], "a") == 0);
}

static void an_older_pose_never_overtakes_a_newer_one(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->bob, BOB, 2, 0, "b", 5);
    cell_touches(r->bob, BOB, 3, 0);
    await_ack(r, r->bob, BOB, 3);
    cell_pose(r->alice, ALICE, 9, 0, 4.5);
    await_event(r, r->bob, WIRE_EVENT_BEGIN);
    cell_pose(r->alice, ALICE, 8, 0, 0);
    assert_false(cell_hears(r->bob, r->memory, WIRE_EVENT_BATCH, 100));
    assert_int_equal(status_counter(r, r->bob, "late_poses"), 1);
}

static void step_pose(memory_end *e, int64_t client, int64_t sequence, double x, int64_t step)
{
    const int32_t body = 0;
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .step = step,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(e, &m);
}

/* Lock-step: each tick with a step of its own is told to a client, nothing happened or not; and of its own steps only.
 */
static void a_step_is_answered_though_nothing_happened(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->bob, BOB, 2, 0, "b", 5);
    cell_touches(r->bob, BOB, 3, 0);
    await_ack(r, r->bob, BOB, 3);
    wire_event_batch b = cell_await(r->bob, r->memory, WIRE_EVENT_BATCH).event_batch;
    assert_int_equal(b.snapshot, 1);
    for (int64_t step = 1; step <= 3; step++) {
        step_pose(r->bob, BOB, 10 + step, 5, step);
        b = cell_await(r->bob, r->memory, WIRE_EVENT_BATCH).event_batch;
        assert_int_equal(b.step, step);
        assert_int_equal(b.kinds.count, 0);
        assert_int_equal(b.snapshot, 0);
    }
    step_pose(r->alice, ALICE, 10, 0.5, 700); /* another simulator: bob hears nothing of it ... */
    assert_false(cell_hears(r->bob, r->memory, WIRE_EVENT_BATCH, 100));
    step_pose(r->bob, BOB, 20, 2, 4); /* ... and one batch a step where something happens */
    b = cell_await(r->bob, r->memory, WIRE_EVENT_BATCH).event_batch;
    assert_int_equal(b.step, 4);
    assert_int_equal(b.kinds.count, 1);
    assert_false(cell_hears(r->bob, r->memory, WIRE_EVENT_BATCH, 100));
}

static void a_name_belongs_to_one_body(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    await_ack(r, r->alice, ALICE, 2);
    cell_sphere(r->bob, BOB, 2, 0, "a", 0);
    expect_reject(r, r->bob, WIRE_NAME_TAKEN, WIRE_BODY, "\"a\"");
    cell_sphere(r->bob, BOB, 2, 0, "a", 0); /* nothing else is answered: what is lost is asked for again */
    expect_reject(r, r->bob, WIRE_NAME_TAKEN, WIRE_BODY, "\"a\"");
    assert_int_equal(status_counter(r, r->bob, "bodies"), 1);
    assert_int_equal(status_counter(r, r->bob, "reject_name_taken"), 2);
}

static void nobody_moves_what_is_not_his(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    await_ack(r, r->alice, ALICE, 2);
    cell_pose(r->bob, BOB, 2, 0, 100);
    expect_reject(r, r->bob, WIRE_UNKNOWN_BODY, WIRE_POSE_BATCH, "1 of 1");
}

static void bad_input_is_refused_by_name_and_disturbs_nothing(void **state)
{
    room *r = *state;
    const double nan_at[3] = {0, NAN, 0}, at[3] = {0, 0, 0}, turn[4] = {1, 0, 0, 0}, zero[4] = {0};
    const int32_t body = 0;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    await_ack(r, r->alice, ALICE, 2);
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 3,
            .bodies = {1, &body},
            .positions = {3, nan_at},
            .orientations = {4, turn}}};
    memory_send(r->alice, &m);
    expect_reject(r, r->alice, WIRE_BAD_NUMBER, WIRE_POSE_BATCH, "positions[1]");
    m.pose_batch.positions.at = at;
    m.pose_batch.orientations.at = zero;
    memory_send(r->alice, &m);
    expect_reject(r, r->alice, WIRE_BAD_ROTATION, WIRE_POSE_BATCH, "orientations");
    m.pose_batch.orientations.at = turn;
    m.pose_batch.version = WIRE_VERSION + 1;
    memory_send(r->alice, &m);
    expect_reject(r, r->alice, WIRE_WRONG_VERSION, WIRE_POSE_BATCH, "version");
    memory_send_bytes(r->alice, "not a message at all", 20);
    wire_message refused = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_int_equal(refused.reject.reason, WIRE_WRONG_VERSION);
    assert_int_equal(status_counter(r, r->alice, "bodies"), 1);
    assert_int_equal(status_counter(r, r->alice, "reject_bad_number"), 1);
}

static void send_hull(memory_end *e, int64_t sequence, const double *points, uint32_t numbers, int64_t hash)
{
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .vertex_numbers = (int32_t)numbers,
            .pieces = 1,
            .vertices = {numbers, points}}};
    memory_send(e, &m);
}

static void flat_hulls_and_false_hashes_are_refused(void **state)
{
    room *r = *state;
    const double flat[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 2, 1, 0};
    wire_f64s points = {15, flat};
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, points, (wire_i32s){0, NULL});
    send_hull(r->alice, 2, flat, 15, hash);
    expect_reject(r, r->alice, WIRE_FLAT_HULL, WIRE_GEOMETRY, "vertices");
    send_hull(r->alice, 3, flat, 15, hash + 1);
    expect_reject(r, r->alice, WIRE_BAD_HASH, WIRE_GEOMETRY, "hash");
}

static void a_lost_clients_bodies_go_and_watchers_get_the_ends(void **state)
{
    room *r = *state;
    memory_end *carol = cell_client(r->cell);
    cell_hello(carol, 33, 1, 1, WIRE_LOST_REMOVE);
    cell_sphere(carol, 33, 2, 0, "c", 0);
    cell_sphere(r->bob, BOB, 2, 0, "b", 1);
    cell_touches(r->bob, BOB, 3, 0);
    await_event(r, r->bob, WIRE_EVENT_BEGIN);
    wire_event_batch b = await_event(r, r->bob, WIRE_EVENT_END); /* carol is silent */
    assert_int_equal(b.causes.at[0], WIRE_CAUSE_OWNER_LOST);
    assert_int_equal(status_counter(r, r->bob, "clients_lost"), 1);
    assert_int_equal(status_counter(r, r->bob, "clients"), 2);
    memory_disconnect(carol);
}

static void a_lost_clients_bodies_are_held_or_kept_as_it_said(void **state)
{
    room *r = *state;
    memory_end *carol = cell_client(r->cell), *dave = cell_client(r->cell);
    cell_hello(carol, 33, 1, 1, WIRE_LOST_HOLD);
    cell_sphere(carol, 33, 2, 0, "held", 0);
    cell_hello(dave, 44, 1, 1, WIRE_LOST_KEEP);
    cell_sphere(dave, 44, 2, 0, "kept", 10);
    cell_sphere(r->bob, BOB, 2, 0, "b", 1);
    cell_sphere(r->bob, BOB, 3, 1, "b1", 11);
    cell_touches(r->bob, BOB, 4, 0);
    wire_event_batch b = await_event(r, r->bob, WIRE_EVENT_UNKNOWN); /* held: unknown at once, never free */
    for (uint32_t i = 0; i < b.kinds.count; i++)
        assert_true(strcmp(b.names_a.at[i], "held") == 0 || strcmp(b.names_b.at[i], "held") == 0);
    assert_int_equal(status_counter(r, r->bob, "contacts"), 2);
    assert_int_equal(status_counter(r, r->bob, "stale_bodies"), 1);
    cell_hello(carol, 33, 3, 60, WIRE_LOST_HOLD); /* it was only stalled */
    cell_pose(carol, 33, 4, 0, 0.5);
    await_event(r, r->bob, WIRE_EVENT_KNOWN);
    memory_disconnect(carol);
    memory_disconnect(dave);
}

static void a_subscriber_that_asks_again_gets_the_whole_state(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->bob, BOB, 2, 0, "b", 1);
    cell_touches(r->bob, BOB, 3, 0);
    wire_event_batch first = await_event(r, r->bob, WIRE_EVENT_BEGIN);
    int64_t contact = first.contacts.at[0], batch = first.batch, tick = first.tick;
    cell_touches(r->bob, BOB, 4, 0);
    wire_event_batch again = await_event(r, r->bob, WIRE_EVENT_BEGIN);
    while (again.tick == tick) again = await_event(r, r->bob, WIRE_EVENT_BEGIN);
    assert_true(again.snapshot);
    assert_int_equal(again.contacts.at[0], contact);
    assert_int_equal(again.causes.at[0], WIRE_CAUSE_SNAPSHOT);
    assert_int_equal(again.batch, batch); /* as of which it tells the state */
}

static void copies_are_acknowledged_and_change_nothing(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    await_ack(r, r->alice, ALICE, 2);
    wire_message gone = {.kind = WIRE_BODY,
        .body = {
            .version = WIRE_VERSION, .client = ALICE, .sequence = 3, .body = 0, .removed = 1, .name = "", .group = ""}};
    memory_send(r->alice, &gone);
    await_ack(r, r->alice, ALICE, 3);
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0); /* a late copy does not bring it back */
    await_ack(r, r->alice, ALICE, 2);
    assert_int_equal(status_counter(r, r->alice, "bodies"), 0);
    assert_int_equal(status_counter(r, r->alice, "duplicates"), 1);
}

static void queries_are_answered(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->alice, ALICE, 3, 1, "b", 5);
    await_ack(r, r->alice, ALICE, 3);
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 4,
            .kind = WIRE_QUERY_DISTANCE,
            .name_a = "a",
            .name_b = "b",
            .tolerance_m = 1e-9}};
    memory_send(r->alice, &q);
    wire_answer a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.sequence, 4);
    assert_int_equal(a.names_a.count, 1);
    assert_true(a.lo.at[0] <= 3 && 3 <= a.hi.at[0]);
    q.query.kind = WIRE_QUERY_NEAREST;
    q.query.length_m = INFINITY;
    q.query.most = 5;
    memory_send(r->alice, &q);
    a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.status, WIRE_ANSWER_OK);
    assert_int_equal(a.names_a.count, 1); /* b, and not a itself */
    assert_string_equal(a.names_a.at[0], "b");
    assert_true(a.lo.at[0] <= 3 && 3 <= a.hi.at[0]);
    static const double from[3] = {-10, 0, 0}, half[3] = {0.5, 0.5, 0.5}, along[3] = {1, 0, 0};
    q.query.kind = WIRE_QUERY_CAST;
    q.query.origin = (wire_f64s){3, from};
    q.query.half = (wire_f64s){3, half};
    q.query.direction = (wire_f64s){3, along};
    q.query.tolerance_m = 1e-6;
    memory_send(r->alice, &q);
    a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.names_a.count, 1);
    assert_string_equal(a.names_a.at[0], "a");
    assert_true(a.lo.at[0] <= 8.5 && 8.5 <= a.hi.at[0] && a.hi.at[0] - a.lo.at[0] < 1e-4);
    q.query.kind = WIRE_QUERY_DISTANCE;
    q.query.name_b = "nobody";
    memory_send(r->alice, &q);
    a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.status, WIRE_ANSWER_UNKNOWN_NAME);
    assert_non_null(strstr(a.text, "nobody"));
    q.query.kind = WIRE_QUERY_RECORD;
    q.query.name_a = "";
    memory_send(r->alice, &q);
    a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
    assert_non_null(strstr(a.text, "nothing is being recorded"));
    q.query.name_a = "../../etc/passwd";
    memory_send(r->alice, &q);
    a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.status, WIRE_ANSWER_UNSUPPORTED);
}

static void a_hull_that_two_announce_stays_when_one_leaves(void **state)
{
    room *r = *state;
    const double corners[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, (wire_f64s){12, corners}, (wire_i32s){0, NULL});
    send_hull(r->alice, 2, corners, 12, hash);
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = 2,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .vertex_numbers = 12,
            .pieces = 1,
            .vertices = {12, corners}}};
    memory_send(r->bob, &m);
    await_ack(r, r->bob, BOB, 2);
    m.geometry.removed = 1;
    m.geometry.sequence = 3;
    memory_send(r->bob, &m);
    await_ack(r, r->bob, BOB, 3);
    assert_int_equal(status_counter(r, r->alice, "geometries"), 1);
    m.geometry.client = ALICE;
    m.geometry.sequence = 4;
    memory_send(r->alice, &m);
    await_ack(r, r->alice, ALICE, 4);
    assert_int_equal(status_counter(r, r->alice, "geometries"), 0);
}

static void a_stream_name_is_free_as_soon_as_its_subscription_is_taken_back(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->alice, ALICE, 3, 1, "b", 1);
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 4,
            .facts = WIRE_FACT_TOUCH,
            .stream = "cell",
            .select_a = "*",
            .select_b = "*"}};
    memory_send(r->alice, &m);
    await_event(r, r->alice, WIRE_EVENT_BEGIN);
    m.subscription.removed = 1;
    m.subscription.sequence = 5;
    memory_send(r->alice, &m);
    m.subscription.removed = 0;
    m.subscription.sequence = 6;
    m.subscription.subscription = 1;
    memory_send(r->alice, &m);
    wire_event_batch b = await_event(r, r->alice, WIRE_EVENT_BEGIN);
    assert_int_equal(b.subscription, 1);
    assert_true(b.snapshot);
}

static void what_one_client_says_is_applied_in_its_order(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    await_ack(r, r->alice, ALICE, 2);
    wire_message gone = {.kind = WIRE_BODY,
        .body = {
            .version = WIRE_VERSION, .client = ALICE, .sequence = 3, .body = 0, .removed = 1, .name = "", .group = ""}};
    memory_send(r->alice, &gone);
    cell_sphere(r->alice, ALICE, 4, 0, "a", 1);
    cell_pose(r->alice, ALICE, 5, 0, 5); /* most often in one receive with the two before it */
    await_ack(r, r->alice, ALICE, 4);
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 6,
            .kind = WIRE_QUERY_BODIES,
            .name_a = "a",
            .name_b = ""}};
    memory_send(r->alice, &q);
    wire_answer a = cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.names_a.count, 1);
    assert_true(a.points_a.at[0] == 5);
}

/* As `collidectl load` does: the bodies stay, and it is told whose they are, but not that he is silent. */
static void who_left_and_kept_his_bodies_is_named(void **state)
{
    room *r = *state;
    memory_end *carol = cell_client(r->cell);
    cell_hello(carol, 33, 1, 1, WIRE_LOST_KEEP);
    cell_sphere(carol, 33, 2, 0, "kept", 10);
    assert_int_equal(status_counter(r, r->bob, "client_bodies_0000000000000021"), 1);
    assert_false(status_has(r, r->bob, "client_left_0000000000000021"));
    wire_message goodbye = {.kind = WIRE_CLIENT,
        .client = {
            .version = WIRE_VERSION, .client = 33, .sequence = 3, .removed = 1, .name = "", .on_loss = WIRE_LOST_KEEP}};
    memory_send(carol, &goodbye);
    assert_int_equal(status_counter(r, r->bob, "client_left_0000000000000021"), 1);
    assert_int_equal(status_counter(r, r->bob, "client_bodies_0000000000000021"), 1);
    assert_false(status_has(r, r->bob, "client_silent_ns_0000000000000021"));
    memory_disconnect(carol);
}

static void a_lost_client_that_kept_nothing_is_forgotten(void **state)
{
    room *r = *state;
    memory_end *carol = cell_client(r->cell);
    cell_hello(carol, 33, 1, 0.1, WIRE_LOST_KEEP);
    while (status_counter(r, r->bob, "clients_lost") < 1) {
    }
    assert_int_equal(status_counter(r, r->bob, "clients"), 2);
    memory_disconnect(carol);
}

static void nobody_interested_means_no_narrow_phase_and_status_shows_it(void **state)
{
    room *r = *state;
    cell_sphere(r->alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r->alice, ALICE, 3, 1, "b", 1);
    await_ack(r, r->alice, ALICE, 3);
    for (int i = 0; i < 50; i++) cell_pose(r->alice, ALICE, 4 + i, 0, 0.01 * i);
    while (status_counter(r, r->alice, "moves") < 50) {
    }
    assert_int_equal(status_counter(r, r->alice, "narrow_queries"), 0);
    assert_int_equal(status_counter(r, r->alice, "pairs"), 0);
}

static void an_end_in_order_ends_contacts_and_closes_streams(void **state)
{
    (void)state;
    config c = cell_config();
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, 1, 60, WIRE_LOST_REMOVE);
    cell_sphere(r.alice, ALICE, 2, 0, "a", 0);
    cell_sphere(r.alice, ALICE, 3, 1, "b", 1);
    cell_touches(r.alice, ALICE, 4, 0);
    await_event(&r, r.alice, WIRE_EVENT_BEGIN);
    assert_int_equal(cell_stop(r.cell), 0);
    wire_event_batch b = await_event(&r, r.alice, WIRE_EVENT_END);
    assert_int_equal(b.closing, 1);
    assert_int_equal(b.causes.at[0], WIRE_CAUSE_SHUTDOWN);
    memory_disconnect(r.alice);
    wire_memory_destroy(r.memory);
}

static void limits_are_named(void **state)
{
    (void)state;
    config c = cell_config();
    c.max_bodies = 2;
    c.share = 100; /* the world's own limit is meant */
    c.max_subscriptions = 1;
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, 1, 60, WIRE_LOST_REMOVE);
    for (int i = 0; i < 3; i++) {
        char name[16];
        snprintf(name, sizeof name, "b%d", i);
        cell_sphere(r.alice, ALICE, 2 + i, i, name, 5 * i);
    }
    expect_reject(&r, r.alice, WIRE_LIMIT, WIRE_BODY, "max_bodies = 2");
    cell_touches(r.alice, ALICE, 10, 0);
    cell_touches(r.alice, ALICE, 11, 1);
    expect_reject(&r, r.alice, WIRE_LIMIT, WIRE_SUBSCRIPTION, "max_subscriptions = 1");
    cell_await(r.alice, r.memory, WIRE_STATUS);
    wire_message s = cell_await(r.alice, r.memory, WIRE_STATUS);
    assert_non_null(strstr(s.status.limits, "max_bodies"));
    assert_int_equal(s.status.health, WIRE_HEALTH_DEGRADED);
    memory_disconnect(r.alice);
    cell_stop(r.cell);
    wire_memory_destroy(r.memory);
}

#define IN_A_ROOM(test) cmocka_unit_test_setup_teardown(test, open_room, close_room)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_ROOM(a_contact_of_two_clients_bodies_reaches_the_subscriber),
        IN_A_ROOM(poses_that_come_before_their_body_are_applied),
        IN_A_ROOM(an_older_pose_never_overtakes_a_newer_one),
        IN_A_ROOM(a_step_is_answered_though_nothing_happened),
        IN_A_ROOM(a_name_belongs_to_one_body),
        IN_A_ROOM(nobody_moves_what_is_not_his),
        IN_A_ROOM(bad_input_is_refused_by_name_and_disturbs_nothing),
        IN_A_ROOM(flat_hulls_and_false_hashes_are_refused),
        IN_A_ROOM(a_lost_clients_bodies_go_and_watchers_get_the_ends),
        IN_A_ROOM(a_lost_clients_bodies_are_held_or_kept_as_it_said),
        IN_A_ROOM(who_left_and_kept_his_bodies_is_named),
        IN_A_ROOM(a_subscriber_that_asks_again_gets_the_whole_state),
        IN_A_ROOM(copies_are_acknowledged_and_change_nothing),
        IN_A_ROOM(queries_are_answered),
        IN_A_ROOM(a_hull_that_two_announce_stays_when_one_leaves),
        IN_A_ROOM(a_stream_name_is_free_as_soon_as_its_subscription_is_taken_back),
        IN_A_ROOM(what_one_client_says_is_applied_in_its_order),
        IN_A_ROOM(a_lost_client_that_kept_nothing_is_forgotten),
        IN_A_ROOM(nobody_interested_means_no_narrow_phase_and_status_shows_it),
        cmocka_unit_test(an_end_in_order_ends_contacts_and_closes_streams),
        cmocka_unit_test(limits_are_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
