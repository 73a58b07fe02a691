/* Compounds over the wire: one contact of the whole, explained as one shape, counted with their children, met by every
 * query, recorded and replayed. */
#include "cell.h"

#include "service/server.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum { ALICE = 11, ROOM = 100 };

typedef struct room {
    cell *cell;
    memory_end *alice;
    wire_memory *memory;
} room;

static room open_with(config c)
{
    room r = {.cell = cell_start(&c), .memory = wire_memory_create()};
    r.alice = cell_client(r.cell);
    cell_hello(r.alice, ALICE, 1, 60, WIRE_LOST_REMOVE);
    return r;
}

static int open_room(void **state)
{
    static room r;
    config c = cell_config();
    c.max_shapes = ROOM;
    c.share = 100; /* the world's own limit is meant */
    r = open_with(c);
    *state = &r;
    return 0;
}

static void leave(room *r)
{
    memory_disconnect(r->alice);
    wire_memory_destroy(r->memory);
}

static int close_room(void **state)
{
    leave(*state);
    return cell_stop(((room *)*state)->cell);
}

static const double FIRST_DEVIATION = 0.001;

/* A row of `count` unit cubes along x, from x = 0 on: a compound. Their boxes touch. The first deviates. */
static void send_row(const room *r, int64_t sequence, int32_t body, uint32_t count, double radius, const char *name)
{
    uint8_t types[WIRE_SHAPES_MAX] = {WIRE_SHAPE_COMPOUND};
    double sizes[3 * WIRE_SHAPES_MAX] = {count, 0, 0}, radii[WIRE_SHAPES_MAX] = {radius}, poses[7 * WIRE_SHAPES_MAX];
    double deviations[WIRE_SHAPES_MAX] = {0, FIRST_DEVIATION};
    int64_t none[WIRE_SHAPES_MAX] = {0};
    const double pose[7] = {0, 0, 0, 1, 0, 0, 0};
    memcpy(poses, pose, sizeof pose);
    for (uint32_t i = 1; i <= count; i++) {
        types[i] = WIRE_SHAPE_BOX;
        for (uint32_t k = 0; k < 3; k++) sizes[3 * i + k] = 0.5;
        memcpy(poses + 7 * i, (double[7]){i - 0.5, 0, 0, 1, 0, 0, 0}, sizeof pose);
    }
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .body = body,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, pose},
            .shape_types = {1 + count, types},
            .shape_sizes = {3 * (1 + count), sizes},
            .shape_radii = {1 + count, radii},
            .shape_deviations = {1 + count, deviations},
            .shape_poses = {7 * (1 + count), poses},
            .shape_geometries = {1 + count, none}}};
    memory_send(r->alice, &m);
}

static wire_event_batch await_event(room *r, uint8_t kind)
{
    for (;;) {
        wire_message m = cell_await(r->alice, r->memory, WIRE_EVENT_BATCH);
        for (uint32_t i = 0; i < m.event_batch.kinds.count; i++)
            if (m.event_batch.kinds.at[i] == kind) return m.event_batch;
    }
}

static wire_answer ask(room *r, int64_t sequence, uint8_t kind, const char *a, const char *b, const double *direction)
{
    const double origin[3] = {-5, 0.25, 0.25}, turn[4] = {1, 0, 0, 0}, half[3] = {0.1, 0.1, 0.1};
    uint32_t sized = kind == WIRE_QUERY_CAST || kind == WIRE_QUERY_BOX, placed = sized || kind == WIRE_QUERY_RAY;
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = sequence,
            .kind = kind,
            .name_a = a,
            .name_b = b,
            .origin = {3 * placed, origin},
            .orientation = {4 * sized, turn},
            .half = {3 * sized, half},
            .direction = {direction ? 3 : 0, direction},
            .length_m = 20,
            .tolerance_m = 1e-6,
            .most = 4}};
    memory_send(r->alice, &q);
    return cell_await(r->alice, r->memory, WIRE_ANSWER).answer;
}

/* Spheres have radius 1: on x = 3 the sphere overlaps three cubes at once, and that is one contact. */
static void a_compound_touches_once(void **state)
{
    room *r = *state;
    send_row(r, 2, 7, 8, 0, "row");
    cell_touches(r->alice, ALICE, 3, 0);
    cell_sphere(r->alice, ALICE, 4, 0, "ball", 3);
    wire_event_batch b = await_event(r, WIRE_EVENT_BEGIN);
    int begins = 0;
    for (uint32_t i = 0; i < b.kinds.count; i++) begins += b.kinds.at[i] == WIRE_EVENT_BEGIN;
    assert_int_equal(begins, 1);
    assert_true(b.shapes_a.at[0] == 0 && b.shapes_b.at[0] == 0);
    assert_true(b.lo.at[0] <= -1.5 && b.lo.at[0] > -1.6); /* out through the side: 0.5 + 1 */
    assert_true(b.hi.at[0] <= -1 + 1e-9);                 /* as deep as in either of the cubes that meet there */
    send_row(r, 5, 7, 8, 0, "row");                       /* the same again: the contact goes on */
    cell_pose(r->alice, ALICE, 6, 0, 30);
    wire_event_batch e = await_event(r, WIRE_EVENT_END);
    assert_int_equal(e.contacts.at[0], b.contacts.at[0]);
    assert_int_equal(e.causes.at[0], WIRE_CAUSE_MOTION);
}

static void another_compound_under_the_same_name_ends_the_contact(void **state)
{
    room *r = *state;
    send_row(r, 2, 7, 8, 0, "row");
    cell_touches(r->alice, ALICE, 3, 0);
    cell_sphere(r->alice, ALICE, 4, 0, "ball", 7);
    await_event(r, WIRE_EVENT_BEGIN);
    send_row(r, 5, 7, 5, 0, "row");
    assert_int_equal(await_event(r, WIRE_EVENT_END).causes.at[0], WIRE_CAUSE_SHAPE);
}

static void queries_meet_it_and_explain_tells_what_it_is(void **state)
{
    room *r = *state;
    send_row(r, 2, 7, 8, 0.1, "row");
    cell_sphere(r->alice, ALICE, 3, 0, "ball", 12);
    wire_answer a = ask(r, 4, WIRE_QUERY_EXPLAIN, "row", "ball", NULL);
    if (!strstr(a.text, "compound of 8")) fail_msg("%s", a.text);
    a = ask(r, 5, WIRE_QUERY_DISTANCE, "row", "ball", NULL);
    assert_true(a.lo.at[0] <= 2.9 && 2.9 <= a.hi.at[0] && a.hi.at[0] - a.lo.at[0] < 1e-5);
    const double right[3] = {1, 0, 0};
    a = ask(r, 6, WIRE_QUERY_RAY, "", "", right);
    assert_true(a.lo.count == 1 && fabs(a.lo.at[0] - 4.9) < 1e-5);
    a = ask(r, 7, WIRE_QUERY_CAST, "", "", right);
    assert_true(a.lo.count == 1 && fabs(a.lo.at[0] - 4.8) < 1e-5);
    a = ask(r, 8, WIRE_QUERY_NEAREST, "row", "", NULL);
    assert_true(a.lo.count == 1 && fabs(a.lo.at[0] - 2.9) < 1e-5);
    a = ask(r, 9, WIRE_QUERY_BOX, "", "", NULL);
    assert_int_equal(a.lo.count, 0);
}

static void children_count_to_the_limit(void **state)
{
    room *r = *state;
    send_row(r, 2, 1, ROOM - 1, 0, "row");
    cell_sphere(r->alice, ALICE, 3, 2, "ball", 12);
    wire_message m = cell_await(r->alice, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_LIMIT);
    assert_non_null(strstr(m.reject.text, "max_shapes"));
    send_row(r, 4, 1, ROOM - 2, 0, "row"); /* what it replaces makes room */
    cell_sphere(r->alice, ALICE, 5, 2, "ball", 12);
    for (int i = 0; i < 100; i++) {
        m = cell_await(r->alice, r->memory, WIRE_STATUS);
        if (cell_counter(&m.status, "bodies") == 2) break;
    }
    assert_int_equal(cell_counter(&m.status, "shapes"), ROOM);
}

/* ---- recordings ---- */

static char folder[] = "/tmp/collided-compounds-XXXXXX";

typedef struct findings {
    int64_t hash;  /* the last one */
    bool deviates; /* the last Body of a compound says what its first child is off by */
} findings;

static void look(void *context, const wire_log_entry *e)
{
    findings *found = context;
    const wire_body *m = &e->message.body;
    bool whole = e->kind == WIRE_LOG_MESSAGE && e->message.kind == WIRE_BODY && m->shape_types.count > 1;
    if (e->kind == WIRE_LOG_TICK) found->hash = e->tick.events_hash;
    if (whole) found->deviates = m->shape_deviations.count > 1 && m->shape_deviations.at[1] == FIRST_DEVIATION;
}

static void replay_tells_contacts(const char *path)
{
    config c = cell_config();
    char why[512] = "";
    strcpy(c.links, "");
    strcpy(c.replay, path);
    server *s = server_create(&c, why, sizeof why);
    if (!s) fail_msg("%s", why);
    assert_int_equal(server_run(s), 0);
    server_destroy(s);
}

/* Recorded from its middle: the compound comes as its own Body, and the replay agrees with itself. */
static void a_recording_from_the_middle_keeps_compounds(void **state)
{
    (void)state;
    assert_non_null(mkdtemp(folder));
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    room r = open_with(c);
    char path[256];
    send_row(&r, 2, 7, 8, 0.1, "row");
    cell_touches(r.alice, ALICE, 3, 0);
    cell_sphere(r.alice, ALICE, 4, 0, "ball", 40);
    assert_int_equal(ask(&r, 5, WIRE_QUERY_RECORD, "middle", "", NULL).status, WIRE_ANSWER_OK);
    cell_pose(r.alice, ALICE, 6, 0, 4);
    await_event(&r, WIRE_EVENT_BEGIN);
    leave(&r);
    assert_int_equal(cell_stop(r.cell), 0);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    findings found = {0};
    cell_read(path, look, &found);
    assert_true(found.hash != 0 && found.deviates);
    replay_tells_contacts(path);
    unlink(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(a_compound_touches_once, open_room, close_room),
        cmocka_unit_test_setup_teardown(another_compound_under_the_same_name_ends_the_contact, open_room, close_room),
        cmocka_unit_test_setup_teardown(queries_meet_it_and_explain_tells_what_it_is, open_room, close_room),
        cmocka_unit_test_setup_teardown(children_count_to_the_limit, open_room, close_room),
        cmocka_unit_test(a_recording_from_the_middle_keeps_compounds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
