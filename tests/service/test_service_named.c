/* Two simulators that race: whoever of them is first, and in whichever order what they announce comes, the same steps
 * bring the same events, bit for bit, as long as the bodies have the same names. Only contacts may have other numbers.
 * The service is driven tick by tick with a clock of the test's own. One thread. */
#include "base/log.h"
#include "base/prng.h"
#include "cell.h"
#include "service/server.h"
#include "service/service.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { ALICE = 11, BOB = 22, WATCHER = 33, BODIES = 8, STEPS = 40, RACES = 12, LINE = 1200, LINES = 4096 };
static const int64_t STEP_NS = 10000000, START_NS = 1000000000000;

typedef struct race {
    server *server;
    service *service;
    link_sink sink;
    memory_end *end;
    wire_memory *memory;
    int64_t now_ns, sequences[3];
    uint64_t random;
    char (*lines)[LINE];
    size_t count;
} race;

static uint64_t next(race *r)
{
    return prng_bits(&r->random);
}

static int64_t sequence_of(race *r, int64_t client)
{
    return ++r->sequences[client / 11 - 1];
}

/* ---- what they say ---- */

static void hello(race *r, int64_t client)
{
    wire_message c = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence_of(r, client),
            .lease_ns = 3600000000000,
            .lock_step = client == WATCHER ? 0 : 2,
            .name = "racer"}};
    memory_send(r->end, &c);
}

/* About a place of its own, near to another one of the same shape: of the other client, and of the same. */
static void place_of(int64_t client, int body, int step, double position[3], double orientation[4])
{
    double phase = 0.3 * step + body + (client == BOB ? 0.5 : 0);
    position[0] = 0.45 * body + 0.1 * sin(phase);
    position[1] = (client == BOB ? 0.45 : 0) + 0.1 * cos(1.3 * phase);
    position[2] = 0.05 * sin(0.7 * phase);
    double angle = body % 3 == 2 ? 0 : 0.4 * sin(0.2 * phase); /* some stay parallel to each other */
    orientation[0] = cos(angle);
    orientation[1] = 0.6 * sin(angle);
    orientation[2] = 0.8 * sin(angle);
    orientation[3] = 0;
}

static void put(race *r, int64_t client, int body, bool removed)
{
    static const uint8_t TYPES[4] = {WIRE_SHAPE_BOX, WIRE_SHAPE_CAPSULE, WIRE_SHAPE_CYLINDER, WIRE_SHAPE_ELLIPSOID};
    static const double SIZES[4][3] = {{.2, .22, .25}, {0, 0, .2}, {.2, .2, .2}, {.2, .25, .3}};
    static const double LOCAL[7] = {0, 0, 0, 1, 0, 0, 0};
    static const int64_t NONE[1] = {0};
    char name[32];
    double pose[7];
    int kind = body / 2 % 4;
    const double radius = TYPES[kind] == WIRE_SHAPE_CAPSULE ? 0.15 : 0;
    snprintf(name, sizeof name, "%s/part %d", client == ALICE ? "left" : "right", body);
    place_of(client, body, 0, pose, pose + 3);
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence_of(r, client),
            .body = body,
            .removed = removed,
            .name = removed ? "" : name,
            .group = "",
            .category = 1,
            .mask = -1,
            .ccd = body % 2 ? 2 : 0,
            .pose = {removed ? 0 : 7, pose},
            .shape_types = {!removed, &TYPES[kind]},
            .shape_sizes = {removed ? 0 : 3, SIZES[kind]},
            .shape_radii = {!removed, &radius},
            .shape_poses = {removed ? 0 : 7, LOCAL},
            .shape_geometries = {!removed, NONE}}};
    memory_send(r->end, &m);
}

static void move_some(race *r, int64_t client, int from, int to, int step)
{
    int32_t bodies[BODIES];
    double positions[3 * BODIES], orientations[4 * BODIES];
    uint32_t n = (uint32_t)(to - from);
    for (uint32_t i = 0; i < n; i++) {
        bodies[i] = from + (int)i;
        place_of(client, bodies[i], step, positions + 3 * i, orientations + 4 * i);
    }
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence_of(r, client),
            .stamp_ns = START_NS + step * STEP_NS,
            .step = step,
            .bodies = {n, bodies},
            .positions = {3 * n, positions},
            .orientations = {4 * n, orientations}}};
    memory_send(r->end, &m);
}

static void subscribe(race *r)
{
    wire_message i = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = WATCHER,
            .sequence = sequence_of(r, WATCHER),
            .subscription = 1,
            .facts = WIRE_FACT_TOUCH + WIRE_FACT_DISTANCE + WIRE_FACT_MANIFOLD + WIRE_FACT_IMPACT + WIRE_FACT_PREDICT,
            .stream = "all",
            .select_a = "*",
            .select_b = "*",
            .range_m = 0.1,
            .horizon_s = 0.1,
            .tolerance_m = 1e-9}};
    memory_send(r->end, &i);
}

/* ---- what is told ---- */

static char *add(char *at, const char *what, const double *numbers, uint32_t count)
{
    at += sprintf(at, " %s", what);
    for (uint32_t i = 0; i < count; i++) at += sprintf(at, " %a", numbers[i]);
    return at;
}

static void tell(race *r, const wire_event_batch *b)
{
    uint32_t points = 0, impacts = 0;
    for (uint32_t i = 0; i < b->kinds.count; i++) {
        assert_true(r->count < LINES);
        char *at = r->lines[r->count++];
        bool impact = b->kinds.at[i] == WIRE_EVENT_IMPACT || b->kinds.at[i] == WIRE_EVENT_PREDICTED;
        at += sprintf(at, "step %d: %u %u %u %s/%d %s/%d %d %d", (int)b->step, b->kinds.at[i], b->causes.at[i],
            b->achieved.at[i], b->names_a.at[i], b->shapes_a.at[i], b->names_b.at[i], b->shapes_b.at[i],
            (int)b->ages_a_ns.at[i], (int)b->ages_b_ns.at[i]);
        at = add(at, "in", (double[]){b->lo.at[i], b->hi.at[i], b->closings.at[i]}, 3);
        at = add(at, "axis", b->axes.at + 3 * i, 3);
        at = add(at, "from", b->points_a.at + 3 * i, 3);
        at = add(at, "to", b->points_b.at + 3 * i, 3);
        for (uint32_t k = 0; k < b->manifold_counts.at[i]; k++, points++) {
            at = add(at, "point", b->manifold_points.at + 3 * points, 3);
            at = add(at, "", b->manifold_distances.at + points, 1);
            at += sprintf(at, " %llx", (unsigned long long)b->manifold_features.at[points]);
        }
        if (impact) at = add(at, "at", b->impact_times.at + 2 * impacts, 2);
        if (impact) add(at, "there", b->impact_poses.at + 14 * impacts, 14);
        impacts += impact;
    }
}

static void tick(race *r)
{
    service *s = r->service;
    wire_message m;
    r->now_ns += STEP_NS;
    s->now_ns = s->monotonic_ns = r->now_ns;
    s->links[0]->ops->receive(s->links[0], &r->sink);
    s->tick++;
    service_tick(s);
    for (wire_memory_reset(r->memory); memory_receive(r->end, r->memory, &m); wire_memory_reset(r->memory))
        if (m.kind == WIRE_EVENT_BATCH) tell(r, &m.event_batch);
}

/* ---- a race ---- */

/* Each in an order and in ticks of its own; some bodies come, go, and come back. */
static void announce(race *r)
{
    bool here[2][BODIES] = {0};
    for (size_t left = 2 * BODIES; left;) {
        int who = (int)(next(r) % 2), body = (int)(next(r) % BODIES);
        int64_t client = who ? BOB : ALICE;
        bool gone = next(r) % 4 == 0;
        if (next(r) % 5 == 0) tick(r);
        if (here[who][body]) continue;
        put(r, client, body, false);
        if (gone && next(r) % 2) tick(r);
        if (gone) put(r, client, body, true);
        here[who][body] = !gone;
        left -= !gone;
    }
    tick(r);
}

static void run(race *r, uint64_t seed)
{
    char why[256] = "";
    config c = cell_config();
    log_setup(LOG_ERROR, 0);
    r->server = server_create(&c, why, sizeof why);
    if (!r->server) fail_msg("%s", why);
    r->service = server_service(r->server);
    r->sink = server_sink(r->server);
    r->end = memory_connect("cell");
    r->memory = wire_memory_create();
    r->lines = calloc(LINES, sizeof *r->lines);
    r->random = seed;
    r->now_ns = START_NS - 1000 * STEP_NS;
    bool bob_first = next(r) % 2;
    hello(r, bob_first ? BOB : ALICE);
    hello(r, bob_first ? ALICE : BOB);
    hello(r, WATCHER);
    announce(r);
    subscribe(r);
    r->now_ns = START_NS - STEP_NS;
    tick(r);
    for (int step = 1; step <= STEPS; step++) {
        bool turned = next(r) % 2;
        int cut[2] = {(int)(next(r) % (BODIES + 1)), (int)(next(r) % (BODIES + 1))};
        for (int part = 0; part < 4; part++) { /* each in two batches, or one, between each other's */
            int who = turned ? part % 2 : part / 2, second = turned ? part / 2 : part % 2;
            int from = second ? cut[who] : 0, to = second ? BODIES : cut[who];
            if (from < to) move_some(r, who ? BOB : ALICE, from, to, step);
        }
        move_some(r, turned ? BOB : ALICE, 0, 0, step); /* the end */
        move_some(r, turned ? ALICE : BOB, 0, 0, step);
        r->now_ns = START_NS + (step - 1) * STEP_NS;
        tick(r);
    }
    assert_int_equal(r->service->lock_step.done, STEPS);
    memory_disconnect(r->end);
    server_destroy(r->server);
    wire_memory_destroy(r->memory);
}

static int by_text(const void *a, const void *b)
{
    return strcmp(a, b);
}

static void whoever_comes_first_the_same_steps_tell_the_same(void **state)
{
    (void)state;
    race first = {.count = 0};
    run(&first, 1);
    qsort(first.lines, first.count, LINE, by_text);
    assert_true(first.count > 1000);
    for (uint64_t seed = 2; seed < RACES; seed++) {
        race other = {.count = 0};
        run(&other, seed);
        qsort(other.lines, other.count, LINE, by_text);
        for (size_t i = 0; i < first.count && i < other.count; i++)
            if (strcmp(first.lines[i], other.lines[i]) != 0)
                fail_msg("%d:\n%s\nis not\n%s", (int)seed, first.lines[i], other.lines[i]);
        assert_int_equal(first.count, other.count);
        free(other.lines);
    }
    free(first.lines);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whoever_comes_first_the_same_steps_tell_the_same),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
