/* Meshes over the wire: in pieces, in any order, touched on their surface; what cannot be used is refused by name. */
#include "cell.h"

#include <math.h>
#include <stdlib.h>
#include <time.h>

enum { ALICE = 11, CUTS = 120, SIDE = CUTS + 1, NUMBERS = 3 * SIDE * SIDE, INDICES = 6 * CUTS * CUTS };

typedef struct room {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, 1, 60, WIRE_LOST_REMOVE);
    *state = &r;
    return 0;
}

static int close_room(void **state)
{
    room *r = *state;
    memory_disconnect(r->alice);
    int status = cell_stop(r->cell);
    wire_memory_destroy(r->memory);
    return status;
}

/* A square floor at z = 0, more than one piece large. */
static void make_floor(double *points, int32_t *corners)
{
    for (int i = 0; i < SIDE * SIDE; i++) {
        points[3 * i] = (double)(i / SIDE) / CUTS * 4 - 2;
        points[3 * i + 1] = (double)(i % SIDE) / CUTS * 4 - 2;
        points[3 * i + 2] = 0;
    }
    for (int i = 0; i < CUTS * CUTS; i++) {
        int32_t a = i / CUTS * SIDE + i % CUTS;
        const int32_t two[6] = {a, a + SIDE, a + SIDE + 1, a, a + SIDE + 1, a + 1};
        memcpy(corners + 6 * i, two, sizeof two);
    }
}

static void send_piece(
    const room *r, int64_t sequence, const double *points, const int32_t *corners, int64_t hash, int32_t piece)
{
    int32_t from = piece * WIRE_PIECE_MAX, end = from + WIRE_PIECE_MAX, whole = NUMBERS + INDICES;
    if (end > whole) end = whole;
    int32_t v0 = from < NUMBERS ? from : NUMBERS, v1 = end < NUMBERS ? end : NUMBERS;
    int32_t i0 = from > NUMBERS ? from - NUMBERS : 0, i1 = end > NUMBERS ? end - NUMBERS : 0;
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .kind = WIRE_GEOMETRY_MESH,
            .hash = hash,
            .vertex_numbers = NUMBERS,
            .index_numbers = INDICES,
            .piece = piece,
            .pieces = (whole + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX,
            .vertices = {(uint32_t)(v1 - v0), points + v0},
            .indices = {(uint32_t)(i1 - i0), corners + i0}}};
    memory_send(r->alice, &m);
}

static void send_body(const room *r, int64_t sequence, uint8_t type, int64_t hash)
{
    cell_body_of(r->alice, ALICE, sequence, 100, "floor", type, hash, 0);
}

static wire_event_batch await_event(room *r, uint8_t kind)
{
    for (;;) {
        wire_message m = cell_await(r->alice, r->memory, WIRE_EVENT_BATCH);
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            if (m.event_batch.kinds.at[i] == kind) return m.event_batch;
    }
}

/* On a slow machine the body has waited in vain for a second before its mesh came: its owner sends it again. */
static wire_event_batch await_begin(room *r, int64_t sequence, int64_t hash)
{
    wire_message m;
    for (int waited = 0; waited < 30000; waited++) {
        wire_memory_reset(r->memory);
        if (!memory_receive(r->alice, r->memory, &m)) {
            nanosleep(&(struct timespec){0, 1000000}, NULL);
            continue;
        }
        if (m.kind == WIRE_REJECT && m.reject.reason == WIRE_UNKNOWN_GEOMETRY)
            send_body(r, ++sequence, WIRE_SHAPE_MESH, hash);
        if (m.kind != WIRE_EVENT_BATCH) continue;
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            if (m.event_batch.kinds.at[i] == WIRE_EVENT_BEGIN) return m.event_batch;
    }
    fail_msg("no contact within 30 s");
    return (wire_event_batch){.version = 0};
}

static void expect_reject(room *r, wire_reason reason)
{
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    if (m.reject.reason != reason) fail_msg("%s: %s", wire_reason_name(m.reject.reason), m.reject.text);
}

static void a_mesh_comes_in_pieces_in_any_order_and_is_touched(void **state)
{
    room *r = *state;
    double *points = malloc(NUMBERS * sizeof *points);
    int32_t *corners = malloc(INDICES * sizeof *corners);
    make_floor(points, corners);
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_MESH, (wire_f64s){NUMBERS, points}, (wire_i32s){INDICES, corners});
    send_body(r, 2, WIRE_SHAPE_MESH, hash); /* it waits for its mesh */
    cell_sphere(r->alice, ALICE, 3, 0, "ball", 0.3);
    cell_touches(r->alice, ALICE, 4, 0);
    assert_true((NUMBERS + INDICES) / WIRE_PIECE_MAX == 1);
    send_piece(r, 6, points, corners, hash, 1);
    send_piece(r, 5, points, corners, hash, 0);
    wire_event_batch b = await_begin(r, 6, hash);
    assert_true(b.lo.at[0] <= 0 && b.hi.at[0] < 0);
    cell_pose(r->alice, ALICE, 60, 0, 9);
    await_event(r, WIRE_EVENT_END);
    free(points);
    free(corners);
}

static void what_is_no_mesh_is_refused(void **state)
{
    room *r = *state;
    static const double POINTS[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    static const int32_t LINE[3] = {0, 1, 1};
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 2,
            .kind = WIRE_GEOMETRY_MESH,
            .vertex_numbers = 12,
            .index_numbers = 3,
            .pieces = 1,
            .vertices = {12, POINTS},
            .indices = {3, LINE}}};
    m.geometry.hash = wire_geometry_hash(WIRE_GEOMETRY_MESH, m.geometry.vertices, m.geometry.indices);
    memory_send(r->alice, &m);
    expect_reject(r, WIRE_BAD_SIZE);
}

static void a_hull_is_not_a_mesh(void **state)
{
    room *r = *state;
    static const double POINTS[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = 2,
            .kind = WIRE_GEOMETRY_HULL,
            .vertex_numbers = 12,
            .pieces = 1,
            .vertices = {12, POINTS}}};
    m.geometry.hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, m.geometry.vertices, m.geometry.indices);
    memory_send(r->alice, &m);
    send_body(r, 3, WIRE_SHAPE_MESH, m.geometry.hash);
    expect_reject(r, WIRE_UNKNOWN_GEOMETRY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_mesh_comes_in_pieces_in_any_order_and_is_touched, open_room, close_room),
        cmocka_unit_test_setup_teardown(what_is_no_mesh_is_refused, open_room, close_room),
        cmocka_unit_test_setup_teardown(a_hull_is_not_a_mesh, open_room, close_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
