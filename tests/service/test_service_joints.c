/* Robots that bodies carry: their links stand where the joints put them, by formulas of the plane's own; what is
 * refused is refused by name and moves nothing; recordings, from their middle too, and copies of the state go on with
 * them. */
#include "base/log.h"
#include "cell.h"
#include "service/clients.h"
#include "service/models.h"
#include "service/recordings.h"
#include "service/server.h"
#include "service/service.h"
#include "service/state_parts.h"
#include "wire/wire_model.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { ARM = 5, LINKS = 3, SPINS = 0, SLIDES = 1, FOLLOWS = 2, BALL = 9 };

/* It turns about z at (1, 2, 3) by q0; slides along x by q1 from 1 m on; turns about z at its end by 0.1 - 2 q0. */
typedef struct plane {
    cell *cell;
    memory_end *end;
    wire_memory *memory;
    int64_t sequence;
    wire_model model;
    uint8_t record[4096];
} plane;

static void make_model(plane *t)
{
    static const double ORIGINS[LINKS] = {0, 1, 0.5};
    t->model = (wire_model){.base = {1, 2, 3, 1, 0, 0, 0}, .count = LINKS};
    for (int i = 0; i < LINKS; i++)
        t->model.links[i] = (wire_link){.parent = i - 1,
            .type = i == SLIDES ? WIRE_JOINT_PRISMATIC : WIRE_JOINT_REVOLUTE,
            .mimic = i == FOLLOWS ? SPINS : -1,
            .body = i,
            .origin = {ORIGINS[i], 0, 0, 1, 0, 0, 0},
            .axis = {i == SLIDES, 0, i != SLIDES},
            .lower = -1,
            .upper = 1,
            .factor = -2,
            .offset = 0.1};
}

static void send_body(plane *t, int32_t body, const char *name, wire_u8s extensions)
{
    const double none[3] = {0}, radius = 0.01, here[7] = {0, 0, 0, 1, 0, 0, 0},
                 at[7] = {10.0 * body, 50, 0, 1, 0, 0, 0};
    const uint8_t type = WIRE_SHAPE_SPHERE;
    const int64_t geometry = 0;
    const wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t->sequence,
            .body = body,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, at},
            .shape_types = {1, &type},
            .shape_sizes = {3, none},
            .shape_radii = {1, &radius},
            .shape_poses = {7, here},
            .shape_geometries = {1, &geometry},
            .extensions = extensions}};
    memory_send(t->end, &m);
}

static void begin_with(plane *t, const config *c)
{
    *t = (plane){.cell = cell_start(c)};
    t->end = cell_client(t->cell);
    t->memory = wire_memory_create();
    cell_hello(t->end, ARM, ++t->sequence, 60, WIRE_LOST_REMOVE);
    make_model(t);
    send_body(t, 1, "slides", (wire_u8s){0, NULL});
    send_body(t, 2, "follows", (wire_u8s){0, NULL});
    send_body(t, 0, "spins", (wire_u8s){wire_model_write(&t->model, t->record), t->record});
    cell_settle(t->end, t->memory, ARM, ++t->sequence);
}

static void begin(plane *t)
{
    config c = cell_config();
    begin_with(t, &c);
}

static void end(plane *t)
{
    memory_disconnect(t->end);
    wire_memory_destroy(t->memory);
    assert_int_equal(cell_stop(t->cell), 0);
}

static void send_raw(plane *t, wire_u8s extensions, int64_t step)
{
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {
            .version = WIRE_VERSION, .client = ARM, .sequence = ++t->sequence, .step = step, .extensions = extensions}};
    memory_send(t->end, &m);
}

static void send_joints(plane *t, const wire_joints *j)
{
    uint8_t record[sizeof *j];
    send_raw(t, (wire_u8s){wire_joints_write(j, record), record}, 0);
}

static wire_joints joints_of(double q0, double q1)
{
    return (wire_joints){.body = 0, .count = 2, .values = {q0, q1}};
}

/* x, y, z, and the angle about z. */
static void where_is(plane *t, const char *name, double out[4])
{
    const wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t->sequence,
            .kind = WIRE_QUERY_BODIES,
            .name_a = name,
            .name_b = ""}};
    memory_send(t->end, &q);
    wire_answer a = cell_await(t->end, t->memory, WIRE_ANSWER).answer;
    assert_int_equal(a.status, WIRE_ANSWER_OK);
    assert_int_equal(a.names_a.count, 1);
    memcpy(out, a.points_a.at, 3 * sizeof *out);
    out[3] = 2 * atan2(a.orientations.at[3], a.orientations.at[0]);
}

static void is_at(plane *t, const char *name, double x, double y, double z, double angle)
{
    double at[4];
    where_is(t, name, at);
    bool near = fabs(at[0] - x) < 1e-12 && fabs(at[1] - y) < 1e-12 && fabs(at[2] - z) < 1e-12 &&
                fabs(remainder(at[3] - angle, 2 * M_PI)) < 1e-12;
    if (!near)
        fail_msg("%s is at (%.17g, %.17g, %.17g), %.17g, not (%.17g, %.17g, %.17g), %.17g", name, at[0], at[1], at[2],
            at[3], x, y, z, angle);
}

static void robot_is_at(plane *t, const double base[3], double q0, double q1)
{
    double out = 1 + q1, x = base[0], y = base[1], z = base[2];
    is_at(t, "spins", x, y, z, q0);
    is_at(t, "slides", x + out * cos(q0), y + out * sin(q0), z, q0);
    is_at(t, "follows", x + (out + 0.5) * cos(q0), y + (out + 0.5) * sin(q0), z, q0 + 0.1 - 2 * q0);
}

static const double BASE[3] = {1, 2, 3}, ELSEWHERE[3] = {-4, 0, 7};

static void links_stand_where_the_joints_put_them(void **state)
{
    (void)state;
    plane t;
    begin(&t);
    for (int i = 0; i < 5; i++) {
        wire_joints j = joints_of(0.3 * i - 0.7, 0.1 * i);
        send_joints(&t, &j);
        robot_is_at(&t, BASE, j.values[0], j.values[1]);
    }
    wire_joints j = joints_of(1.5, -3); /* beyond its limits, and there it is */
    j.flags = WIRE_JOINTS_GIVE_BASE;
    memcpy(j.base, (const double[7]){-4, 0, 7, 1, 0, 0, 0}, sizeof j.base);
    send_joints(&t, &j);
    robot_is_at(&t, ELSEWHERE, 1.5, -3);
    wire_status s = cell_await(t.end, t.memory, WIRE_STATUS).status;
    assert_int_equal(cell_counter(&s, "joints_beyond"), 1);
    end(&t);
}

/* Bodies of its own, and joints, in one batch. */
static void poses_and_joints_come_together(void **state)
{
    (void)state;
    plane t;
    uint8_t record[sizeof(wire_joints)];
    begin(&t);
    cell_sphere(t.end, ARM, ++t.sequence, BALL, "ball", 0);
    wire_joints j = joints_of(0.5, 0.25);
    const int32_t ball = BALL;
    const double at[7] = {0, 0, 40, 1, 0, 0, 0};
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t.sequence,
            .bodies = {1, &ball},
            .positions = {3, at},
            .orientations = {4, at + 3},
            .extensions = {wire_joints_write(&j, record), record}}};
    memory_send(t.end, &m); /* it waits for the ball, which comes in the same tick, and the joints with it */
    is_at(&t, "ball", 0, 0, 40, 0);
    robot_is_at(&t, BASE, 0.5, 0.25);
    end(&t);
}

static void velocities_are_the_links_own(void **state)
{
    (void)state;
    plane t;
    begin(&t);
    cell_sphere(t.end, ARM, ++t.sequence, BALL, "ball", 0);
    const int32_t ball = BALL;
    const double place[7] = {1 + 2.3 * cos(0.8), 2 + 2.3 * sin(0.8), 3, 1, 0, 0, 0};
    const wire_message stand = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t.sequence,
            .bodies = {1, &ball},
            .positions = {3, place},
            .orientations = {4, place + 3}}};
    const wire_message want = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t.sequence,
            .subscription = 0,
            .facts = WIRE_FACT_PREDICT,
            .stream = "prediction",
            .select_a = "slides",
            .select_b = "ball",
            .horizon_s = 5,
            .tolerance_m = 1e-6}};
    memory_send(t.end, &stand);
    memory_send(t.end, &want);
    wire_joints j = joints_of(-1, 0.3);
    j.flags = WIRE_JOINTS_GIVE_RATES;
    j.rates[0] = 0, j.rates[1] = 0;
    send_joints(&t, &j);
    cell_settle(t.end, t.memory, ARM, ++t.sequence);
    j.values[0] = 0.8;
    j.values[1] = -0.7; /* 0.3 m from the axis; it slides outward by 1 m/s, to the ball of 1 m that is 2.3 m from it */
    j.rates[1] = 1;
    send_joints(&t, &j);
    wire_message m;
    do {
        m = cell_await(t.end, t.memory, WIRE_EVENT_BATCH);
    } while (!m.event_batch.kinds.count || m.event_batch.kinds.at[0] != WIRE_EVENT_PREDICTED);
    double lo = m.event_batch.impact_times.at[0], hi = m.event_batch.impact_times.at[1], exact = 2 - 1 - 0.01;
    if (!(lo <= exact + 1e-9 && hi >= exact - 1e-9 && hi - lo < 1e-3)) fail_msg("[%g, %g] for %g", lo, hi, exact);
    end(&t);
}

/* ---- refused by name ---- */

static void expect_reject(plane *t, uint8_t kind, const char *words)
{
    wire_reject r = cell_await(t->end, t->memory, WIRE_REJECT).reject;
    if (r.kind != kind || !strstr(r.text, words)) fail_msg("kind %u: %s", r.kind, r.text);
}

static void joints_that_are_none_are_refused_and_move_nothing(void **state)
{
    (void)state;
    plane t;
    uint8_t record[sizeof(wire_joints)];
    begin(&t);
    wire_joints j = joints_of(0.1, 0.2);
    send_joints(&t, &j);
    j = joints_of(0.5, 0.5), j.body = 1;
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "joints of body 1: it carries no robot");
    j.body = 77;
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "joints of body 77: it carries no robot");
    j.body = 0, j.count = 3;
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "3 values: its robot has 2 joints");
    j = joints_of(2e5, 0);
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "value 0 is 200000");
    j = joints_of(6e4, 0); /* the one that follows would turn by twice as much */
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "value 0 is 60000");
    j = joints_of(0, 0), j.flags = WIRE_JOINTS_GIVE_RATES, j.rates[0] = 1e300;
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "too fast");
    j = joints_of(NAN, 0);
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "not finite");
    j = joints_of(0, 0), j.flags = 64;
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "octets are no robot's");
    j = joints_of(0, 0), j.flags = WIRE_JOINTS_GIVE_BASE;
    send_joints(&t, &j); /* a base of zeros has no orientation */
    expect_reject(&t, WIRE_POSE_BATCH, "joints' base");
    j = joints_of(0.5, 0.5);
    uint32_t size = wire_joints_write(&j, record);
    record[4] -= 1; /* the record is shorter than what it holds */
    send_raw(&t, (wire_u8s){size - 1, record}, 0);
    expect_reject(&t, WIRE_POSE_BATCH, "octets are no robot's");
    j = joints_of(0.5, 0.5);
    enum { EACH = WIRE_JOINTS_HEAD + 16, MANY = WIRE_ROBOTS_MAX + 1 };
    uint8_t *many = calloc(1, WIRE_EXTENSION_HEAD + EACH * MANY);
    (void)wire_joints_write(&j, record);
    memcpy(many, record, WIRE_EXTENSION_HEAD);
    memcpy(many + 4, &(uint32_t){EACH * MANY}, 4);
    for (int i = 0; i < MANY; i++) memcpy(many + WIRE_EXTENSION_HEAD + EACH * i, record + WIRE_EXTENSION_HEAD, EACH);
    send_raw(&t, (wire_u8s){WIRE_EXTENSION_HEAD + EACH * MANY, many}, 0);
    expect_reject(&t, WIRE_POSE_BATCH, "more than the allowed 1024 robots");
    free(many);
    robot_is_at(&t, BASE, 0.1, 0.2);
    end(&t);
}

static void try_model(plane *t, const char *words)
{
    send_body(t, 0, "spins", (wire_u8s){wire_model_write(&t->model, t->record), t->record});
    expect_reject(t, WIRE_BODY, words);
    make_model(t);
}

static void models_that_are_none_are_refused(void **state)
{
    (void)state;
    plane t;
    begin(&t);
    wire_joints j = joints_of(0.1, 0.2);
    t.model.links[1].parent = 2;
    try_model(&t, "link 1 has a parent that does not come before it");
    t.model.links[1].body = 0;
    try_model(&t, "links 0 and 1 are both body 0");
    t.model.links[2].body = -2;
    try_model(&t, "link 2: body -2");
    t.model.links[0].axis[2] = 0;
    try_model(&t, "link 0 has an axis that is no direction");
    t.model.links[0].type = 17;
    try_model(&t, "link 0 has a type that is not known");
    t.model.links[2].mimic = 2;
    try_model(&t, "link 2 mimics a joint that does not move by itself");
    t.model.links[1].origin[0] = NAN;
    try_model(&t, "link 1 has an origin that is no pose");
    t.model.base[3] = 0;
    try_model(&t, "model's base");
    t.model.count = 0;
    try_model(&t, "0 links: 1 to 128");
    uint32_t size = wire_model_write(&t.model, t.record);
    t.record[4] -= 1;
    send_body(&t, 0, "spins", (wire_u8s){size - 1, t.record});
    expect_reject(&t, WIRE_BODY, "model: ");
    send_joints(&t, &j); /* the first one stays */
    robot_is_at(&t, BASE, 0.1, 0.2);
    send_body(&t, 0, "spins", (wire_u8s){0, NULL}); /* announced anew, without one */
    send_joints(&t, &j);
    expect_reject(&t, WIRE_POSE_BATCH, "joints of body 0: it carries no robot");
    end(&t);
}

/* It waits for a body that is not known yet, and is not refused a second time when that is over. */
static void what_is_refused_of_a_batch_that_waits_is_told_once(void **state)
{
    (void)state;
    plane t;
    uint8_t record[sizeof(wire_joints)];
    begin(&t);
    wire_joints j = joints_of(2e5, 0);
    const int32_t stranger = 55;
    const double at[7] = {0, 0, 0, 1, 0, 0, 0};
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t.sequence,
            .bodies = {1, &stranger},
            .positions = {3, at},
            .orientations = {4, at + 3},
            .extensions = {wire_joints_write(&j, record), record}}};
    memory_send(t.end, &m);
    expect_reject(&t, WIRE_POSE_BATCH, "value 0 is 200000");
    expect_reject(&t, WIRE_POSE_BATCH, "1 of 1 bodies are not announced");
    cell_settle(t.end, t.memory, ARM, ++t.sequence);
    wire_status s = cell_await(t.end, t.memory, WIRE_STATUS).status;
    assert_int_equal(cell_counter(&s, "reject_bad_number"), 1);
    end(&t);
}

/* ---- steps ---- */

/* The first step is ended without the robot, which was refused; sent again, it is done with it. */
static void a_step_waits_for_joints_that_were_refused(void **state)
{
    (void)state;
    plane t;
    uint8_t record[sizeof(wire_joints)];
    begin(&t);
    const wire_message join = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t.sequence,
            .on_loss = WIRE_LOST_REMOVE,
            .lease_ns = INT64_C(60000000000),
            .lock_step = 1,
            .name = "test"}};
    memory_send(t.end, &join);
    cell_touches(t.end, ARM, ++t.sequence, 0);
    cell_settle(t.end, t.memory, ARM, ++t.sequence);
    wire_joints j = joints_of(2e5, 0);
    send_raw(&t, (wire_u8s){wire_joints_write(&j, record), record}, 1);
    expect_reject(&t, WIRE_POSE_BATCH, "value 0 is 200000");
    send_raw(&t, (wire_u8s){0, NULL}, 1);
    expect_reject(&t, WIRE_POSE_BATCH, "step 1: poses of 1 bodies were refused or replaced, and did not come again");
    j = joints_of(0.5, 0.125);
    send_raw(&t, (wire_u8s){wire_joints_write(&j, record), record}, 1);
    is_at(&t, "spins", 0, 50, 0, 0); /* it is kept until the step is ended */
    send_raw(&t, (wire_u8s){0, NULL}, 1);
    wire_event_batch b;
    do {
        b = cell_await(t.end, t.memory, WIRE_EVENT_BATCH).event_batch;
    } while (b.step != 1);
    assert_int_equal(b.refused, 0);
    robot_is_at(&t, BASE, 0.5, 0.125);
    end(&t);
}

/* A simulator that counts steps alone is told with its answer. */
static void the_answer_to_a_step_counts_joints_that_were_refused(void **state)
{
    (void)state;
    plane t;
    uint8_t record[sizeof(wire_joints)];
    begin(&t);
    cell_touches(t.end, ARM, ++t.sequence, 0);
    cell_settle(t.end, t.memory, ARM, ++t.sequence);
    wire_joints j = joints_of(2e5, 0);
    send_raw(&t, (wire_u8s){wire_joints_write(&j, record), record}, 4);
    wire_event_batch b;
    do {
        b = cell_await(t.end, t.memory, WIRE_EVENT_BATCH).event_batch;
    } while (b.step != 4);
    assert_int_equal(b.refused, 1);
    assert_int_equal(b.refusal, WIRE_BAD_NUMBER);
    end(&t);
}

/* ---- recordings, and copies of the state ---- */

static char folder[] = "/tmp/collided-joints-XXXXXX";

static void begin_recording(plane *t)
{
    const wire_message q = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = ARM,
            .sequence = ++t->sequence,
            .kind = WIRE_QUERY_RECORD,
            .name_a = "middle",
            .name_b = ""}};
    memory_send(t->end, &q);
    assert_int_equal(cell_await(t->end, t->memory, WIRE_ANSWER).answer.status, WIRE_ANSWER_OK);
}

static void recordings_replay_from_their_middle_too(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    config c = cell_config();
    snprintf(c.record, sizeof c.record, "%s/whole.lcmlog", folder);
    snprintf(c.record_dir, sizeof c.record_dir, "%s", folder);
    for (int middle = 0; middle < 2; middle++) {
        plane t;
        if (middle) c.record[0] = '\0';
        begin_with(&t, &c);
        cell_sphere(t.end, ARM, ++t.sequence, BALL, "ball", 2);
        cell_touches(t.end, ARM, ++t.sequence, 0);
        for (int i = 0; i < 200; i++) {
            if (middle && i == 100) begin_recording(&t);
            wire_joints j = joints_of(sin(0.1 * i), cos(0.07 * i));
            j.flags = WIRE_JOINTS_GIVE_BASE;
            memcpy(j.base, (const double[7]){1, 0, 0, 1, 0, 0, 0}, sizeof j.base);
            send_joints(&t, &j);
            if (i % 10 == 0) cell_settle(t.end, t.memory, ARM, ++t.sequence);
        }
        cell_settle(t.end, t.memory, ARM, ++t.sequence);
        wire_status s = cell_await(t.end, t.memory, WIRE_STATUS).status;
        assert_true(cell_counter(&s, "events") > 4); /* they came and went */
        end(&t);
        snprintf(path, sizeof path, "%s/%s.lcmlog", folder, middle ? "middle" : "whole");
        for (long workers = 1; workers <= 2; workers++) assert_int_equal(cell_replay(path, workers, true), EX_OK);
    }
}

static server *make_server(const char *links)
{
    char why[256];
    config c = cell_config();
    snprintf(c.links, sizeof c.links, "%s", links);
    server *v = server_create(&c, why, sizeof why);
    if (!v) fail_msg("%s", why);
    server_service(v)->tick = 1;
    return v;
}

/* All of it, as a standby gets it. */
static void copy_state(server *from, server *to)
{
    state_parts parts = {0};
    bytes_out all = {0};
    uint8_t some[1000];
    char why[256] = "";
    state_put(server_service(from), &parts);
    state_parts_end(&parts);
    for (size_t n; (n = state_parts_read(&parts, some, sizeof some)) > 0;) bytes_put(&all, some, n);
    bytes_in in = {.at = all.at, .left = all.count};
    service_reset(server_service(to));
    if (!state_take(server_service(to), &in, why, sizeof why)) fail_msg("%s", why);
    state_parts_free(&parts, NULL);
    array_free(&all);
}

static void expand(server *v, const wire_joints *j, wire_pose_batch *out)
{
    service *s = server_service(v);
    uint8_t record[sizeof *j];
    const wire_pose_batch m = {.client = ARM, .sequence = 9, .extensions = {wire_joints_write(j, record), record}};
    models_expand(s, session_find(s, ARM), s->links[0], &m, out);
}

static void a_copy_of_the_state_has_the_robots(void **state)
{
    (void)state;
    server *first = make_server("memory://first"), *second = make_server("memory://second");
    service *s = server_service(first);
    plane t = {.end = memory_connect("first")};
    wire_pose_batch a, b;
    wire_joints j = joints_of(0.3, 0.4);
    make_model(&t);
    cell_hello(t.end, ARM, ++t.sequence, 60, WIRE_LOST_REMOVE);
    send_body(&t, 0, "spins", (wire_u8s){wire_model_write(&t.model, t.record), t.record});
    link_sink sink = server_sink(first);
    s->links[0]->ops->receive(s->links[0], &sink);
    service_tick(s);
    copy_state(first, second);
    expand(first, &j, &a);
    expand(second, &j, &b);
    assert_int_equal(a.bodies.count, LINKS);
    assert_int_equal(b.bodies.count, LINKS);
    assert_memory_equal(a.positions.at, b.positions.at, 3 * LINKS * sizeof(double));
    assert_memory_equal(a.orientations.at, b.orientations.at, 4 * LINKS * sizeof(double));
    memory_disconnect(t.end);
    server_destroy(first);
    server_destroy(second);
}

static int make_folder(void **state)
{
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state)
{
    (void)state;
    char path[sizeof folder + 32];
    static const char *const names[] = {"whole.lcmlog", "middle.lcmlog"};
    for (size_t i = 0; i < 2; i++) {
        snprintf(path, sizeof path, "%s/%s", folder, names[i]);
        (void)unlink(path);
    }
    return rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(links_stand_where_the_joints_put_them),
        cmocka_unit_test(poses_and_joints_come_together),
        cmocka_unit_test(velocities_are_the_links_own),
        cmocka_unit_test(joints_that_are_none_are_refused_and_move_nothing),
        cmocka_unit_test(models_that_are_none_are_refused),
        cmocka_unit_test(what_is_refused_of_a_batch_that_waits_is_told_once),
        cmocka_unit_test(a_step_waits_for_joints_that_were_refused),
        cmocka_unit_test(the_answer_to_a_step_counts_joints_that_were_refused),
        cmocka_unit_test(recordings_replay_from_their_middle_too),
        cmocka_unit_test(a_copy_of_the_state_has_the_robots),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
