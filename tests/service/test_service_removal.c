/* A client with very many bodies leaves: what it had goes with several ticks, each contact ends once, and the hull that
 * its bodies are of is there until the last of them has gone. Whoever comes back under the same names is let in. */
#include "cell.h"

#include <stdio.h>
#include <unistd.h>

enum { ALICE = 1, BOB, BODIES = 2500, ON_THE_WAY = 100 };

typedef struct room {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
    size_t begun, over, acked; /* acked: commands of Alice */
} room;

static void hear(room *r, int ms)
{
    wire_message m;
    for (wire_memory_reset(r->memory); memory_receive(r->end, r->memory, &m); wire_memory_reset(r->memory)) {
        if (m.kind == WIRE_ACK && m.ack.client == ALICE) r->acked += m.ack.sequences.count;
        for (uint32_t i = 0; m.kind == WIRE_EVENT_BATCH && i < m.event_batch.kinds.count; i++) {
            r->begun +=
                m.event_batch.kinds.at[i] == WIRE_EVENT_BEGIN; /* also in the snapshot that a stream begins with */
            r->over += m.event_batch.kinds.at[i] == WIRE_EVENT_END;
        }
    }
    usleep(1000 * (unsigned)ms);
}

static void hear_until(room *r, const size_t *count, size_t wanted)
{
    for (int i = 0; i < 60000 && *count < wanted; i++) hear(r, 1);
    assert_int_equal(*count, wanted);
}

static int64_t send_hull(room *r)
{
    static const double corners[18] = {0.5, 0, 0, -0.5, 0, 0, 0, 0.5, 0, 0, -0.5, 0, 0, 0, 0.5, 0, 0, -0.5};
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .vertex_numbers = 18,
            .pieces = 1,
            .vertices = {18, corners}}};
    m.geometry.hash = wire_geometry_hash(m.geometry.kind, m.geometry.vertices, m.geometry.indices);
    memory_send(r->end, &m);
    return m.geometry.hash;
}

static void announce_all(room *r)
{
    char name[32];
    size_t before = r->acked;
    cell_hello(r->end, ALICE, ++r->sequence, 600, WIRE_LOST_REMOVE);
    int64_t hull = send_hull(r);
    for (int32_t i = 0; i < BODIES; i++) {
        snprintf(name, sizeof name, "body %d", (int)i);
        cell_body_of(r->end, ALICE, ++r->sequence, i, name, WIRE_SHAPE_HULL, hull, 0.9 * i);
        for (int k = 0; k < 60000 && before + (size_t)i > r->acked + ON_THE_WAY; k++) hear(r, 1);
    }
}

static void leave(room *r)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION, .client = ALICE, .sequence = ++r->sequence, .removed = 1, .name = ""}};
    memory_send(r->end, &m);
}

static int64_t counter(room *r, const char *name)
{
    cell_await(r->end, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->end, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static room room_open(void)
{
    config c = cell_config();
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.end = cell_client(r.cell);
    cell_hello(r.end, BOB, ++r.sequence, 600, WIRE_LOST_REMOVE);
    cell_touches(r.end, BOB, ++r.sequence, 0);
    announce_all(&r);
    hear_until(&r, &r.begun, BODIES - 1);
    return r;
}

static void room_close(room *r)
{
    memory_disconnect(r->end);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

static void what_many_bodies_were_of_stays_until_they_have_gone(void **state)
{
    (void)state;
    room r = room_open();
    int64_t before = counter(&r, "sliced_ticks");
    leave(&r);
    hear_until(&r, &r.over, BODIES - 1);
    for (int i = 0; i < 600 && counter(&r, "geometries"); i++) usleep(1000);
    assert_int_equal(counter(&r, "geometries"), 0);
    assert_int_equal(counter(&r, "bodies"), 0);
    assert_int_equal(counter(&r, "bodies_with_pending_pairs"), 0);
    assert_true(counter(&r, "sliced_ticks") > before);
    room_close(&r);
}

static void who_is_back_takes_the_names(void **state)
{
    (void)state;
    room r = room_open();
    leave(&r);
    announce_all(&r);
    hear_until(&r, &r.begun, 2 * (BODIES - 1));
    hear_until(&r, &r.over, BODIES - 1);
    assert_int_equal(counter(&r, "bodies"), BODIES);
    room_close(&r);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_many_bodies_were_of_stays_until_they_have_gone),
        cmocka_unit_test(who_is_back_takes_the_names),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
