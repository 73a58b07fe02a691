/* Soft bodies and the service: frames in parts, double and single; frames that are bad, half, old, of another topology
 * or too many are refused by name and change nothing; limits; steps of lock-step; a session of crumpled noise, in which
 * steps take several ticks, is recorded and replays with the same results for any number of workers. */
#include "cell.h"

#include "base/prng.h"
#include "wire/wire_soft.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

enum {
    ALICE = 21,
    BOB = 22,
    SIDE = 12,
    POINTS = SIDE * SIDE,
    NUMBERS = WIRE_SOFT_HEAD + 3 * POINTS,
    INDICES = 6 * (SIDE - 1) * (SIDE - 1)
};

typedef struct room {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
    double at[2 * 3 * POINTS]; /* twice the room: bad frames name vertices beyond */
} room;

static void hello(room *r, int64_t client, int32_t lock_step)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .lock_step = lock_step,
            .lease_ns = INT64_C(600000000000),
            .name = "soft"}};
    memory_send(r->end, &m);
}

static void rest(room *r)
{
    for (int i = 0; i < POINTS; i++)
        r->at[3 * i] = 0.1 * (i % SIDE), r->at[3 * i + 1] = 0.1 * (i / SIDE), r->at[3 * i + 2] = 0;
}

static int64_t send_surface(room *r, int64_t client)
{
    double numbers[NUMBERS] = {1, 0, 0};
    int32_t indices[INDICES], *to = indices;
    rest(r);
    memcpy(numbers + WIRE_SOFT_HEAD, r->at, 3 * POINTS * sizeof *r->at);
    for (int32_t v = 0; v + SIDE < POINTS; v++) {
        if (v % SIDE == SIDE - 1) continue;
        const int32_t two[6] = {v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE};
        memcpy(to, two, sizeof two);
        to += 6;
    }
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .kind = WIRE_GEOMETRY_SOFT,
            .vertex_numbers = NUMBERS,
            .index_numbers = INDICES,
            .pieces = 1,
            .vertices = {NUMBERS, numbers},
            .indices = {INDICES, indices}}};
    m.geometry.hash = wire_geometry_hash(m.geometry.kind, m.geometry.vertices, m.geometry.indices);
    memory_send(r->end, &m);
    return m.geometry.hash;
}

static void subscribe(room *r, int64_t client, int32_t number)
{
    uint8_t octets[WIRE_SOFT_INTEREST_BYTES];
    const wire_soft_interest each = {.grain = WIRE_SOFT_EACH};
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++r->sequence,
            .subscription = number,
            .facts = WIRE_FACT_TOUCH | WIRE_FACT_FEATURES | WIRE_FACT_SAFE_STEP,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-9}};
    m.subscription.extensions = (wire_u8s){wire_soft_put_interest(&each, octets), octets};
    memory_send(r->end, &m);
}

static void settle(room *r)
{
    cell_settle(r->end, r->memory, ALICE, ++r->sequence);
}

static int64_t counter(room *r, const char *name)
{
    cell_await(r->end, r->memory, WIRE_STATUS);
    wire_message m = cell_await(r->end, r->memory, WIRE_STATUS);
    return cell_counter(&m.status, name);
}

static void until(room *r, const char *name, int64_t value)
{
    for (int i = 0; i < 600 && counter(r, name) != value; i++) {
    }
    assert_int_equal(counter(r, name), value);
}

static void open_with(room *r, config c, int32_t lock_step)
{
    *r = (room){.cell = cell_start(&c), .memory = wire_memory_create()};
    r->end = cell_client(r->cell);
    hello(r, ALICE, lock_step);
    int64_t hash = send_surface(r, ALICE);
    cell_body_of(r->end, ALICE, ++r->sequence, 0, "cloth", WIRE_SHAPE_SOFT, hash, 0);
    cell_sphere(r->end, ALICE, ++r->sequence, 1, "ball", 0.5);
    settle(r);
    until(r, "bodies", 2);
}

static void open_room(room *r)
{
    open_with(r, cell_config(), 0);
}

static void close_room(room *r)
{
    memory_disconnect(r->end);
    assert_int_equal(cell_stop(r->cell), 0);
    wire_memory_destroy(r->memory);
}

typedef struct frame {
    int64_t frame, step;
    int32_t part, parts, mode, body, first;
    uint32_t count; /* vertices; 0: all */
    bool single;
} frame;

static void send(room *r, frame f)
{
    static float singles[3 * POINTS];
    static uint8_t octets[WIRE_SOFT_FRAME_BYTES + 12 * POINTS];
    uint32_t count = f.count ? f.count : POINTS;
    const double *from = r->at + 3 * (size_t)f.first % (3 * POINTS);
    const wire_soft_frame is = {.frame = f.frame,
        .part = f.part,
        .parts = f.parts ? f.parts : 1,
        .mode = f.mode,
        .vertices = count,
        .single = f.single,
        .origin = {0, 0, 1}};
    for (uint32_t i = 0; i < 3 * count && f.single; i++) singles[i] = (float)(from[i] - is.origin[i % 3]);
    wire_message m = {.kind = WIRE_VERTEX_BATCH,
        .vertex_batch = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .step = f.step,
            .body = f.body,
            .first_vertex = f.first}};
    if (!f.single) m.vertex_batch.vertices = (wire_f64s){3 * count, from};
    m.vertex_batch.extensions = (wire_u8s){wire_soft_put_frame(&is, f.single ? singles : NULL, octets), octets};
    memory_send(r->end, &m);
}

static void expect_refusal(room *r, frame f, wire_reason reason, const char *text)
{
    send(r, f);
    wire_message m = cell_await(r->end, r->memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, reason);
    const char *told = m.reject.text ? m.reject.text : "";
    if (!strstr(told, text)) fail_msg("it is refused so: %s", told);
}

/* The next step that is told of the cloth with itself. */
static wire_soft_pair await_step(room *r)
{
    for (;;) {
        static wire_soft_reader at;
        wire_soft_pair p;
        wire_message m = cell_await(r->end, r->memory, WIRE_EVENT_BATCH);
        if (!wire_soft_read(m.event_batch.extensions, &at)) continue;
        while (wire_soft_next_pair(&at, &p))
            if (strcmp(p.name_a, p.name_b) == 0) return p;
    }
}

static void lift(room *r, double z)
{
    rest(r);
    for (int i = 0; i < POINTS; i++) r->at[3 * i + 2] = z;
}

static void bad_frames_are_refused_and_change_nothing(void **state)
{
    (void)state;
    room r;
    open_room(&r);
    subscribe(&r, ALICE, 0);
    (void)await_step(&r); /* as it stands */
    lift(&r, 5);
    r.at[7] = NAN;
    expect_refusal(&r, (frame){.frame = 1}, WIRE_BAD_NUMBER, "not a number");
    expect_refusal(&r, (frame){.frame = 1, .single = true}, WIRE_BAD_NUMBER, "not a number");
    r.at[7] = 2e9;
    expect_refusal(&r, (frame){.frame = 1}, WIRE_TOO_LARGE, "");
    lift(&r, 5);
    expect_refusal(&r, (frame){.frame = 1, .first = POINTS, .count = 1}, WIRE_MALFORMED, "the body has 144");
    expect_refusal(&r, (frame){.frame = 1, .first = 1}, WIRE_MALFORMED, "the body has 144");
    expect_refusal(&r, (frame){.frame = 1, .first = -1, .count = 1}, WIRE_MALFORMED, "");
    expect_refusal(&r, (frame){.frame = -1}, WIRE_MALFORMED, "frame");
    expect_refusal(&r, (frame){.frame = 1, .mode = 3}, WIRE_MALFORMED, "mode");
    expect_refusal(&r, (frame){.frame = 1, .part = 2, .parts = 2}, WIRE_MALFORMED, "part");
    expect_refusal(&r, (frame){.frame = 0, .parts = 2, .count = 10}, WIRE_MALFORMED, "number 0");
    expect_refusal(&r, (frame){.frame = 1, .body = 1}, WIRE_UNKNOWN_BODY, "no soft body");
    expect_refusal(&r, (frame){.frame = 1, .body = 7}, WIRE_UNKNOWN_BODY, "no soft body");
    settle(&r);
    assert_int_equal(counter(&r, "soft_waiting"), 0);
    send(&r, (frame){.frame = 3});
    assert_int_equal(await_step(&r).frame_a, 3);
    expect_refusal(&r, (frame){.frame = 3}, WIRE_OLD_POSE, "newer");
    expect_refusal(&r, (frame){.frame = 2}, WIRE_OLD_POSE, "newer");
    send(&r, (frame){.frame = 2, .mode = WIRE_SOFT_TELEPORT}); /* which may */
    assert_int_equal(await_step(&r).frame_a, 2);
    close_room(&r);
}

/* Half a mesh, its other half, a copy; and halves of which the other never comes. */
static void a_frame_is_taken_whole_or_not_at_all(void **state)
{
    (void)state;
    room r;
    open_room(&r);
    subscribe(&r, ALICE, 0);
    (void)await_step(&r);
    lift(&r, 5);
    const frame second = {.frame = 1, .part = 1, .parts = 2, .first = POINTS / 2, .count = POINTS / 2, .single = true};
    const frame first = {.frame = 1, .part = 0, .parts = 2, .count = POINTS / 2, .single = true};
    send(&r, second), send(&r, second);
    settle(&r);
    assert_int_equal(counter(&r, "soft_waiting"), 0);
    send(&r, first);
    wire_soft_pair p = await_step(&r);
    assert_int_equal(p.frame_a, 1);
    assert_true(p.safe_lo == 1 && p.vertex_face + p.edge_edge == 0);
    send(&r, (frame){.frame = 2, .parts = 2, .count = POINTS / 2});
    expect_refusal(&r, (frame){.frame = 3}, WIRE_MALFORMED, "1 of 2 parts have come");
    assert_int_equal(await_step(&r).frame_a, 3);
    assert_int_equal(counter(&r, "incomplete_frames"), 1);
    send(&r, (frame){.frame = 9, .parts = 3, .count = POINTS / 2});
    expect_refusal(&r, (frame){.frame = 8, .parts = 3, .part = 1, .count = 1}, WIRE_OLD_POSE, "have come");
    send(&r, (frame){.frame = 9, .parts = 3, .part = 1, .count = POINTS / 2});
    expect_refusal(&r, (frame){.frame = 9, .parts = 3, .part = 2, .count = 1}, WIRE_TOO_LARGE, "more than the body's");
    close_room(&r);
}

static void limits_have_names(void **state)
{
    (void)state;
    room r;
    config c = cell_config();
    c.max_soft_vertices = 3 * 2048;
    c.share = 75;
    open_with(&r, c, 0);
    assert_int_equal(counter(&r, "soft_vertices"), 2048); /* what a body counts for at least */
    int64_t hash = send_surface(&r, ALICE);
    cell_body_of(r.end, ALICE, ++r.sequence, 2, "second", WIRE_SHAPE_SOFT, hash, 0);
    settle(&r);
    cell_body_of(r.end, ALICE, ++r.sequence, 3, "third", WIRE_SHAPE_SOFT, hash, 0);
    wire_message m = cell_await(r.end, r.memory, WIRE_REJECT);
    assert_int_equal(m.reject.reason, WIRE_LIMIT);
    assert_non_null(strstr(m.reject.text, "max_soft_vertices"));
    room bob = {.end = cell_client(r.cell), .sequence = r.sequence};
    hello(&bob, BOB, 0);
    hash = send_surface(&bob, BOB);
    cell_body_of(bob.end, BOB, ++bob.sequence, 0, "bobs", WIRE_SHAPE_SOFT, hash, 0); /* his share is free */
    settle(&r);
    until(&r, "soft_vertices", 3 * 2048);
    wire_message gone = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION, .client = ALICE, .sequence = ++r.sequence, .body = 2, .removed = 1}};
    memory_send(r.end, &gone);
    until(&r, "soft_vertices", 2 * 2048);
    memory_disconnect(bob.end);
    close_room(&r);
}

/* Proposals that wait, and frames for steps to come, are bounded. */
static void what_waits_is_bounded(void **state)
{
    (void)state;
    room r;
    open_with(&r, cell_config(), 2);
    lift(&r, 5);
    send(&r, (frame){.frame = 1, .step = 1});
    send(&r, (frame){.frame = 2, .step = 2});
    expect_refusal(&r, (frame){.frame = 3, .step = 3}, WIRE_LIMIT, "wait for their step");
    assert_int_equal(counter(&r, "soft_waiting"), 0); /* nobody ended a step */
    close_room(&r);
}

static void end_step(room *r, int64_t client, int64_t step)
{
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION, .client = client, .sequence = ++r->sequence, .step = step}};
    memory_send(r->end, &m);
}

/* Frames of a step are taken with it, those of the next one are not; the answer to the step comes when the soft body is
 * there. */
static void frames_go_in_lock_step(void **state)
{
    (void)state;
    room r;
    open_with(&r, cell_config(), 2);
    subscribe(&r, ALICE, 0);
    (void)await_step(&r);
    hello(&r, BOB, 2);
    settle(&r);
    lift(&r, 5);
    send(&r, (frame){.frame = 1, .step = 1});
    lift(&r, 6);
    send(&r, (frame){.frame = 2, .step = 2, .single = true});
    end_step(&r, ALICE, 1);
    settle(&r);
    assert_int_equal(counter(&r, "soft_waiting"), 0);
    end_step(&r, BOB, 1);
    assert_int_equal(await_step(&r).frame_a, 1);
    assert_int_equal(counter(&r, "steps"), 1);
    end_step(&r, BOB, 2), end_step(&r, ALICE, 2);
    assert_int_equal(await_step(&r).frame_a, 2);
    close_room(&r);
}

/* ---- recorded ---- */

static char folder[] = "/tmp/collided-soft-XXXXXX";

static void make_noise(room *r, uint64_t *seed)
{
    for (int i = 0; i < 3 * POINTS; i++) r->at[i] = prng_in(seed, 0, 0.3);
}

static void begin_recording(room *r)
{
    wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ALICE,
            .sequence = ++r->sequence,
            .kind = WIRE_QUERY_RECORD,
            .name_a = "middle",
            .name_b = ""}};
    memory_send(r->end, &q);
    assert_int_equal(cell_await(r->end, r->memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_OK);
}

/* Slices of 0.2 ms: a step of noise takes many ticks. From the middle: while one is under way. */
static void play_noise(config c, bool from_the_middle)
{
    enum { FRAMES = 9 };
    room r;
    uint64_t seed = 5, contacts = 0;
    c.slice_us = 200;
    open_with(&r, c, 0);
    subscribe(&r, ALICE, 0);
    (void)await_step(&r);
    for (int k = 1; k <= FRAMES; k++) {
        make_noise(&r, &seed);
        send(&r, (frame){.frame = k, .mode = k % 3 == 2 ? WIRE_SOFT_PROPOSE : WIRE_SOFT_MOVE, .single = k % 2});
        if (from_the_middle && k == FRAMES / 2) begin_recording(&r);
        cell_pose(r.end, ALICE, ++r.sequence, 1, 0.1 * (k % 4));
        wire_soft_pair p = await_step(&r);
        while (p.frame_a < k) p = await_step(&r); /* how it stands there may be told, too */
        assert_int_equal(p.frame_a, k);
        contacts += p.vertex_face + p.edge_edge;
    }
    assert_true(contacts > 1000);
    assert_true(counter(&r, "sliced_ticks") > FRAMES);
    close_room(&r);
}

static void replay_noise(const char *path)
{
    assert_int_equal(cell_replay(path, 1, true), 0);
    assert_int_equal(cell_replay(path, 3, true), 0);
    assert_int_equal(cell_replay(path, 1, false), 0);
    assert_int_equal(unlink(path), 0);
}

static void noise_replays_with_the_same_results(void **state)
{
    (void)state;
    config c = cell_config();
    assert_non_null(mkdtemp(folder));
    snprintf(c.record, sizeof c.record, "%s/whole.lcmlog", folder);
    play_noise(c, false);
    replay_noise(c.record);
}

static void a_recording_may_begin_in_a_step(void **state)
{
    (void)state;
    char path[96];
    config c = cell_config();
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    snprintf(path, sizeof path, "%s/middle.lcmlog", folder);
    play_noise(c, true);
    replay_noise(path);
    rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bad_frames_are_refused_and_change_nothing),
        cmocka_unit_test(a_frame_is_taken_whole_or_not_at_all),
        cmocka_unit_test(limits_have_names),
        cmocka_unit_test(what_waits_is_bounded),
        cmocka_unit_test(frames_go_in_lock_step),
        cmocka_unit_test(noise_replays_with_the_same_results),
        cmocka_unit_test(a_recording_may_begin_in_a_step),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
