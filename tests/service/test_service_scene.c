/* Scenes as who observes is told them: all bodies first, then what comes, changes and goes, and the poses that differ;
 * and events with the poses that they are proven for. Nobody observes: nothing is done for it. */
#include "cell.h"

#include "wire/wire_extensions.h"

#include <stdio.h>

enum { ALICE = 11, BOB = 12, SCENE = 3 };

typedef struct hall {
    cell *cell;
    memory_end *alice, *bob;
    wire_memory *memory;
    int64_t sequence;
} hall;

static hall enter(void)
{
    config c = cell_config();
    c.heartbeat = 60;
    c.status_period = 0.05;
    hall h = {.cell = cell_start(&c), .memory = wire_memory_create()};
    h.alice = cell_client(h.cell);
    h.bob = cell_client(h.cell);
    cell_hello(h.alice, ALICE, ++h.sequence, 60, WIRE_LOST_REMOVE);
    cell_hello(h.bob, BOB, ++h.sequence, 60, WIRE_LOST_REMOVE);
    return h;
}

static void leave(hall *h)
{
    memory_disconnect(h->alice);
    memory_disconnect(h->bob);
    assert_int_equal(cell_stop(h->cell), 0);
    wire_memory_destroy(h->memory);
}

static void observe(hall *h, const char *select)
{
    const wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++h->sequence,
            .subscription = SCENE,
            .facts = WIRE_FACT_SCENE,
            .stream = "",
            .select_a = select,
            .select_b = "*"}};
    memory_send(h->bob, &m);
}

static void move(hall *h, int32_t body, double x)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++h->sequence,
            .stamp_ns = 1000 + h->sequence,
            .bodies = {1, &body},
            .positions = {3, position},
            .orientations = {4, orientation}}};
    memory_send(h->alice, &m);
}

static wire_u8s record_of(const wire_event_batch *b, uint32_t id)
{
    wire_u8s rest = b->extensions;
    wire_extension e;
    while (wire_extension_next(&rest, &e))
        if (e.id == id) return e.bytes;
    return (wire_u8s){0, NULL};
}

/* The next one of a scene; batches of a tick that told nothing are passed over. */
static wire_u8s await_record(hall *h, uint32_t id)
{
    for (;;) {
        wire_event_batch b = cell_await(h->bob, h->memory, WIRE_EVENT_BATCH).event_batch;
        if (b.client != BOB || b.subscription != SCENE) continue;
        assert_int_equal(b.kinds.count, 0); /* no pair is asked about */
        wire_u8s bytes = record_of(&b, id);
        if (bytes.count) return bytes;
    }
}

typedef struct told { /* what one record of a scene says */
    int64_t revision;
    uint8_t whole;
    int32_t gone, bodies, first_id;
    uint8_t flags;
    int64_t client;
    double x;
    char name[16];
} told;

static told read_scene(wire_u8s b)
{
    told t = {0};
    memcpy(&t.revision, b.at, 8);
    t.whole = b.at[8];
    memcpy(&t.gone, b.at + 9, 4);
    size_t at = 13 + 4 * (size_t)t.gone;
    memcpy(&t.bodies, b.at + at, 4);
    at += 4;
    if (!t.bodies) return t;
    memcpy(&t.first_id, b.at + at, 4);
    t.flags = b.at[at + 4];
    memcpy(&t.client, b.at + at + 5, 8);
    memcpy(&t.x, b.at + at + 21, 8);
    memcpy(t.name, b.at + at + 78, b.at[at + 77] < 15 ? b.at[at + 77] : 15);
    return t;
}

static int64_t counter(hall *h, const char *name)
{
    for (;;) {
        wire_status s = cell_await(h->alice, h->memory, WIRE_STATUS).status;
        for (uint32_t i = 0; i < s.counter_names.count; i++)
            if (strcmp(s.counter_names.at[i], name) == 0) return s.counter_values.at[i];
    }
}

static void all_bodies_come_first_and_then_what_changes(void **state)
{
    (void)state;
    hall h = enter();
    cell_sphere(h.alice, ALICE, ++h.sequence, 0, "a", 0);
    cell_sphere(h.alice, ALICE, ++h.sequence, 1, "b", 5);
    observe(&h, "*");
    told t = {0};
    int32_t bodies = 0;
    bool whole = false;
    while (bodies < 2) { /* they may have come before Bob, or after him */
        t = read_scene(await_record(&h, WIRE_EXTENSION_SCENE));
        if (t.whole) bodies = 0;
        whole |= t.whole;
        bodies += t.bodies;
        assert_int_equal(t.client, ALICE);
    }
    assert_true(whole);
    int64_t revision = t.revision;

    move(&h, 1, 7);
    wire_u8s poses = await_record(&h, WIRE_EXTENSION_BODY_POSES);
    int32_t count;
    double x;
    memcpy(&count, poses.at + 8, 4);
    memcpy(&x, poses.at + 8 + 4 + 4, 8);
    assert_int_equal(count, 1); /* the other one has not moved */
    assert_true(x == 7);
    assert_int_equal(poses.count, 8 + 4 + 4 + 56 + 1);

    cell_sphere(h.alice, ALICE, ++h.sequence, 2, "c", -5);
    t = read_scene(await_record(&h, WIRE_EXTENSION_SCENE));
    assert_false(t.whole);
    assert_int_equal(t.bodies, 1);
    assert_string_equal(t.name, "c");
    assert_true(t.x == -5);
    assert_int_equal(t.revision, revision + 1);

    const wire_message gone = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++h.sequence,
            .body = 2,
            .removed = 1,
            .name = "",
            .group = ""}};
    memory_send(h.alice, &gone);
    int32_t id = t.first_id, was;
    wire_u8s b = await_record(&h, WIRE_EXTENSION_SCENE);
    t = read_scene(b);
    memcpy(&was, b.at + 13, 4);
    assert_int_equal(t.gone, 1);
    assert_int_equal(was, id);
    assert_int_equal(t.bodies, 0);
    leave(&h);
}

static void a_pattern_chooses_the_bodies(void **state)
{
    (void)state;
    hall h = enter();
    observe(&h, "arm*");
    told t = read_scene(await_record(&h, WIRE_EXTENSION_SCENE));
    assert_true(t.whole && t.bodies == 0); /* that there are none is told, too */
    cell_sphere(h.alice, ALICE, ++h.sequence, 0, "table", 0);
    cell_sphere(h.alice, ALICE, ++h.sequence, 1, "arm_1", 5);
    t = read_scene(await_record(&h, WIRE_EXTENSION_SCENE));
    assert_int_equal(t.bodies, 1);
    assert_string_equal(t.name, "arm_1");
    leave(&h);
}

/* The promise that nothing is computed which nobody asked for: an observer asks for no pairs, and without one nothing
 * is told of scenes. */
static void nobody_looks_and_it_costs_nothing(void **state)
{
    (void)state;
    hall h = enter();
    cell_sphere(h.alice, ALICE, ++h.sequence, 0, "a", 0);
    cell_sphere(h.alice, ALICE, ++h.sequence, 1, "b", 0.1);
    for (int i = 0; i < 50; i++) move(&h, 1, 0.1 + 0.001 * i);
    while (counter(&h, "in_PoseBatch") < 50) continue;
    assert_int_equal(counter(&h, "scene_batches"), 0);
    assert_int_equal(counter(&h, "scene_poses"), 0);
    observe(&h, "*");
    (void)await_record(&h, WIRE_EXTENSION_SCENE);
    move(&h, 1, 0.2);
    (void)await_record(&h, WIRE_EXTENSION_BODY_POSES);
    while (counter(&h, "scene_poses") < 1) continue;
    assert_int_equal(counter(&h, "narrow_queries"), 0);
    assert_int_equal(counter(&h, "pairs"), 0);

    const wire_message removed = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++h.sequence,
            .subscription = SCENE,
            .removed = 1,
            .stream = "",
            .select_a = "",
            .select_b = ""}};
    memory_send(h.bob, &removed);
    while (counter(&h, "subscriptions") > 0) move(&h, 1, 0.25); /* it is gone in the tick after its last word */
    int64_t told_before = counter(&h, "scene_batches");
    int64_t moved_before = counter(&h, "in_PoseBatch");
    move(&h, 1, 0.3);
    while (counter(&h, "in_PoseBatch") == moved_before) continue;
    assert_int_equal(counter(&h, "scene_batches"), told_before);
    leave(&h);
}

static void a_scene_that_is_asked_for_again_is_told_again(void **state)
{
    (void)state;
    hall h = enter();
    cell_sphere(h.alice, ALICE, ++h.sequence, 0, "a", 0);
    observe(&h, "*");
    while (read_scene(await_record(&h, WIRE_EXTENSION_SCENE)).bodies == 0) continue;
    observe(&h, "*");
    told t = read_scene(await_record(&h, WIRE_EXTENSION_SCENE));
    assert_true(t.whole && t.bodies == 1);
    leave(&h);
}

/* The poses of an event are those of its tick: they differ by what lo says of two spheres of radius 1. */
static void events_carry_the_poses_that_they_are_proven_for(void **state)
{
    (void)state;
    hall h = enter();
    cell_sphere(h.alice, ALICE, ++h.sequence, 0, "a", 0);
    cell_sphere(h.alice, ALICE, ++h.sequence, 1, "b", 1.5);
    const wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++h.sequence,
            .subscription = 4,
            .facts = WIRE_FACT_TOUCH | WIRE_FACT_POSES,
            .stream = "",
            .select_a = "*",
            .select_b = "*"}};
    memory_send(h.bob, &m);
    int seen = 0;
    for (int i = 1; seen < 3; i++) {
        move(&h, 1, 1.5 + 0.01 * i);
        wire_event_batch b = cell_await(h.bob, h.memory, WIRE_EVENT_BATCH).event_batch;
        wire_u8s poses = record_of(&b, WIRE_EXTENSION_POSES);
        if (b.snapshot) assert_int_equal(poses.count, 0);
        for (uint32_t k = 0; !b.snapshot && k < b.kinds.count; k++) {
            double xa, xb;
            assert_int_equal(poses.count, 14 * 8 * b.kinds.count);
            if (b.kinds.at[k] != WIRE_EVENT_UPDATE) continue;
            memcpy(&xa, poses.at + (size_t)k * 112, 8);
            memcpy(&xb, poses.at + (size_t)k * 112 + 56, 8);
            double apart = (xa > xb ? xa - xb : xb - xa) - 2;
            assert_true(b.lo.at[k] <= apart + 1e-12 && apart <= b.hi.at[k] + 1e-12);
            seen++;
        }
    }
    leave(&h);
}

static void a_geometry_is_told_on_request(void **state)
{
    (void)state;
    hall h = enter();
    const double points[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
    const uint8_t hull = WIRE_SHAPE_HULL;
    const double zeros[3] = {0}, pose[7] = {0, 0, 0, 1, 0, 0, 0};
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, (wire_f64s){12, points}, (wire_i32s){0, NULL});
    const wire_message g = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++h.sequence,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .vertex_numbers = 12,
            .pieces = 1,
            .vertices = {12, points}}};
    const wire_message body = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++h.sequence,
            .body = 0,
            .name = "wedge",
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, pose},
            .shape_types = {1, &hull},
            .shape_sizes = {3, zeros},
            .shape_radii = {1, zeros},
            .shape_poses = {7, pose},
            .shape_geometries = {1, &hash}}};
    memory_send(h.alice, &g);
    memory_send(h.alice, &body);
    char name[24];
    snprintf(name, sizeof name, "%016llx", (unsigned long long)hash);
    for (uint8_t status = 1; status;) { /* until the hull is there */
        const wire_message q = {.kind = WIRE_QUERY,
            .query = {.version = WIRE_VERSION,
                .client = BOB,
                .sequence = ++h.sequence,
                .kind = WIRE_QUERY_GEOMETRY,
                .name_a = "wedge",
                .name_b = name}};
        memory_send(h.bob, &q);
        wire_answer a = cell_await(h.bob, h.memory, WIRE_ANSWER).answer;
        status = a.status;
        if (status) continue;
        wire_u8s rest = a.extensions;
        wire_extension e;
        assert_true(wire_extension_next(&rest, &e));
        assert_int_equal(e.id, WIRE_EXTENSION_GEOMETRY);
        assert_int_equal(e.bytes.count, 1 + 8 + 16 + sizeof points);
        assert_int_equal(e.bytes.at[0], WIRE_GEOMETRY_HULL);
        assert_memory_equal(e.bytes.at + 25, points, sizeof points);
    }
    const wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = BOB,
            .sequence = ++h.sequence,
            .kind = WIRE_QUERY_GEOMETRY,
            .name_a = "wedge",
            .name_b = "0000000000000001"}};
    memory_send(h.bob, &q);
    assert_int_equal(cell_await(h.bob, h.memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_UNKNOWN_NAME);
    leave(&h);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_bodies_come_first_and_then_what_changes),
        cmocka_unit_test(a_pattern_chooses_the_bodies),
        cmocka_unit_test(nobody_looks_and_it_costs_nothing),
        cmocka_unit_test(a_scene_that_is_asked_for_again_is_told_again),
        cmocka_unit_test(events_carry_the_poses_that_they_are_proven_for),
        cmocka_unit_test(a_geometry_is_told_on_request),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
