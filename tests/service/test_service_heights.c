/* Height fields over the wire: in pieces, touched and explained, told again by a recording that begins in the middle;
 * what cannot be one is refused by name. */
#include "cell.h"
#include "wire/one_shape.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { ALICE = 11, ROWS = 220, COLUMNS = 300, NUMBERS = WIRE_FIELD_HEAD + ROWS * COLUMNS, INDICES = 2 };

static char folder[] = "/tmp/collided-heights-XXXXXX";

typedef struct room {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
    int64_t sequence;
} room;

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    if (!mkdtemp(strcpy(folder, "/tmp/collided-heights-XXXXXX"))) return -1;
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, ++r.sequence, 60, WIRE_LOST_REMOVE);
    *state = &r;
    return 0;
}

static int close_room(void **state)
{
    room *r = *state;
    char path[sizeof folder + 32];
    memory_disconnect(r->alice);
    int status = cell_stop(r->cell);
    wire_memory_destroy(r->memory);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    unlink(path);
    return rmdir(folder) ? -1 : status;
}

/* A floor at z = -0.9, 2 cm between its points; two pieces, the second with some heights and all indices. */
static wire_geometry floor_of(double *numbers, int32_t sizes[INDICES])
{
    numbers[0] = numbers[1] = 0.02;
    numbers[2] = 0.5;
    for (int i = WIRE_FIELD_HEAD; i < NUMBERS; i++) numbers[i] = -0.9;
    sizes[0] = COLUMNS;
    sizes[1] = ROWS;
    wire_geometry g = {.version = WIRE_VERSION,
        .client = ALICE,
        .kind = WIRE_GEOMETRY_HEIGHT_FIELD,
        .vertex_numbers = NUMBERS,
        .index_numbers = INDICES,
        .pieces = 2,
        .vertices = {NUMBERS, numbers},
        .indices = {INDICES, sizes}};
    g.hash = wire_geometry_hash(g.kind, g.vertices, g.indices);
    return g;
}

static void send_piece(room *r, const wire_geometry *whole, int32_t piece)
{
    wire_message m = {.kind = WIRE_GEOMETRY, .geometry = *whole};
    m.geometry.piece = piece;
    m.geometry.sequence = ++r->sequence;
    if (piece == 0)
        m.geometry.vertices.count = WIRE_PIECE_MAX, m.geometry.indices.count = 0;
    else
        m.geometry.vertices = (wire_f64s){NUMBERS - WIRE_PIECE_MAX, whole->vertices.at + WIRE_PIECE_MAX};
    memory_send(r->alice, &m);
}

static void send_small(room *r, uint8_t kind, const double *numbers, uint32_t count, const int32_t *indices, uint32_t n)
{
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = kind,
            .vertex_numbers = (int32_t)count,
            .index_numbers = (int32_t)n,
            .pieces = 1,
            .vertices = {count, numbers},
            .indices = {n, indices}}};
    m.geometry.hash = wire_geometry_hash(kind, m.geometry.vertices, m.geometry.indices);
    memory_send(r->alice, &m);
}

static void send_body(room *r, uint8_t type, int64_t hash)
{
    one_shape s = one_shape_at(type, 0);
    s.geometry[0] = hash;
    wire_message m = one_shape_body(&s, ALICE, ++r->sequence, 100, "floor");
    m.body.motion = WIRE_MOTION_FIXED;
    memory_send(r->alice, &m);
}

static wire_answer ask(room *r, uint8_t kind, const char *a, const char *b)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = kind,
            .name_a = a,
            .name_b = b}};
    memory_send(r->alice, &q);
    return cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
}

static void expect_reject(room *r, wire_reason reason, const char *words)
{
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    if (m.reject.reason != reason || !strstr(m.reject.text, words))
        fail_msg("%s: %s", wire_reason_name(m.reject.reason), m.reject.text);
}

static void await_begin(room *r)
{
    for (;;) {
        wire_message m = cell_await(r->alice, r->memory, WIRE_EVENT_BATCH);
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            if (m.event_batch.kinds.at[i] == WIRE_EVENT_BEGIN) return;
    }
}

typedef struct findings { /* of the floor, as it was announced */
    int64_t hash;
    int pieces, bodies;
} findings;

static void look(void *context, const wire_log_entry *e)
{
    findings *found = context;
    const wire_message *m = &e->message;
    if (e->kind != WIRE_LOG_MESSAGE) return;
    found->pieces +=
        m->kind == WIRE_GEOMETRY && m->geometry.kind == WIRE_GEOMETRY_HEIGHT_FIELD && m->geometry.hash == found->hash;
    found->bodies += m->kind == WIRE_BODY && m->body.shape_types.at[0] == WIRE_SHAPE_HEIGHT_FIELD &&
                     m->body.shape_geometries.at[0] == found->hash;
}

static void expect_floor_in(const char *path, int64_t hash)
{
    findings found = {.hash = hash};
    cell_read(path, look, &found);
    assert_int_equal(found.pieces, 2);
    assert_int_equal(found.bodies, 1);
}

static void a_height_field_is_touched_explained_and_recorded(void **state)
{
    room *r = *state;
    double *numbers = malloc(NUMBERS * sizeof *numbers);
    int32_t sizes[INDICES];
    char path[sizeof folder + 32];
    wire_geometry floor = floor_of(numbers, sizes);
    cell_sphere(r->alice, ALICE, ++r->sequence, 0, "ball", 0.3);
    send_piece(r, &floor, 1);
    send_piece(r, &floor, 0);
    send_body(r, WIRE_SHAPE_HEIGHT_FIELD, floor.hash); /* it waits until they are built */
    cell_touches(r->alice, ALICE, ++r->sequence, 0);
    await_begin(r);
    wire_answer gap = ask(r, WIRE_QUERY_DISTANCE, "floor", "ball");
    assert_int_equal(gap.status, WIRE_ANSWER_OK);
    assert_true(gap.lo.at[0] <= -0.1 && -0.1 <= gap.hi.at[0] + 1e-12 && gap.hi.at[0] - gap.lo.at[0] < 1e-6);
    wire_answer text = ask(r, WIRE_QUERY_EXPLAIN, "floor", "ball");
    if (!strstr(text.text, "shape 0 (height field, 220 x 300) and shape 0 (sphere)")) fail_msg("%s", text.text);
    assert_int_equal(ask(r, WIRE_QUERY_RECORD, "middle", "").status, WIRE_ANSWER_OK);
    assert_int_equal(ask(r, WIRE_QUERY_RECORD, "", "").status, WIRE_ANSWER_OK);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    expect_floor_in(path, floor.hash);
    free(numbers);
}

static void what_is_no_height_field_is_refused(void **state)
{
    room *r = *state;
    static const double LOST[7] = {1, 1, 1e-9, 1e9, 1e9, 1e9, 1e9}, FAR[7] = {1e-200, 1, 1, 0, 0, 0, 0};
    static const int32_t SQUARE[2] = {2, 2};
    send_small(r, WIRE_GEOMETRY_HEIGHT_FIELD, LOST, 7, SQUARE, 2);
    expect_reject(r, WIRE_BAD_SIZE, "the base of a height field");
    send_small(r, WIRE_GEOMETRY_HEIGHT_FIELD, FAR, 7, SQUARE, 2);
    expect_reject(r, WIRE_BAD_SIZE, "the spacing of a height field");
}

/* Before memory is set aside for it. */
static void a_field_that_is_too_large_is_refused_at_its_first_piece(void **state)
{
    room *r = *state;
    double *numbers = malloc(NUMBERS * sizeof *numbers);
    int32_t sizes[INDICES];
    wire_geometry floor = floor_of(numbers, sizes);
    wire_message m = {.kind = WIRE_GEOMETRY, .geometry = floor};
    m.geometry.sequence = ++r->sequence;
    m.geometry.vertex_numbers = (1 << 24) - 2; /* 16 million heights */
    m.geometry.pieces = 256;
    m.geometry.vertices.count = WIRE_PIECE_MAX;
    m.geometry.indices.count = 0;
    memory_send(r->alice, &m);
    expect_reject(r, WIRE_TOO_LARGE, "a height field has at most");
    free(numbers);
}

static void a_height_field_is_not_a_mesh(void **state)
{
    room *r = *state;
    static const double FIELD[7] = {1, 1, 1, 0, 0, 0, 0};
    static const int32_t SQUARE[2] = {2, 2};
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_HEIGHT_FIELD, (wire_f64s){7, FIELD}, (wire_i32s){2, SQUARE});
    send_small(r, WIRE_GEOMETRY_HEIGHT_FIELD, FIELD, 7, SQUARE, 2);
    send_body(r, WIRE_SHAPE_MESH, hash);
    expect_reject(r, WIRE_UNKNOWN_GEOMETRY, "mesh");
    send_body(r, WIRE_SHAPE_HEIGHT_FIELD, hash + 1);
    expect_reject(r, WIRE_UNKNOWN_GEOMETRY, "height field");
    send_body(r, WIRE_SHAPE_HEIGHT_FIELD, hash);
    assert_true(cell_hears(r->alice, r->memory, WIRE_ACK, 30000));
    assert_int_equal(ask(r, WIRE_QUERY_BODIES, "floor", "").names_a.count, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_height_field_is_touched_explained_and_recorded, open_room, close_room),
        cmocka_unit_test_setup_teardown(what_is_no_height_field_is_refused, open_room, close_room),
        cmocka_unit_test_setup_teardown(a_field_that_is_too_large_is_refused_at_its_first_piece, open_room, close_room),
        cmocka_unit_test_setup_teardown(a_height_field_is_not_a_mesh, open_room, close_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
