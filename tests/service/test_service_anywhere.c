/* A recording may begin at any tick, whatever is under way then: geometry of which pieces are missing, that is shared,
 * claimed by several, or held by bodies though it was taken back; bodies that wait for it; clients that were lost, left
 * or came back; steps of which a half is there. It replays equal. And after each tick the books are true: who claims
 * and holds which geometry, and what a client's limit counts. Driven tick by tick with a clock of its own. One thread.
 */
#include "base/log.h"
#include "base/prng.h"
#include "cell.h"
#include "service/commands.h"
#include "service/geometries.h"
#include "service/recordings.h"
#include "service/replay.h"
#include "service/server.h"
#include "service/service.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <sysexits.h>
#include <unistd.h>

enum { CLIENTS = 3, BODIES = 5, CONTENTS = 5, LARGE = 3 * (WIRE_PIECE_MAX / 3 + 100), KEPT = 64 };

/* Two hulls of four points with one FNV-1a hash (test_service_geometry). */
static const double LOW[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.e5ceed43p+0, 0x1.36e7a321p+0};
static const double HIGH[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0x1.8e2a310fp+0, 0x1.53a20b52p+0};
static const double PLAIN[12] = {-1, 0, 0, 1, 0, 0, 0, -1, 0, 0, 1, 1.5};
static double large[LARGE], flat[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}; /* flat: is refused */
static const int32_t TRIANGLES[12] = {0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

typedef struct content {
    const double *numbers;
    uint32_t count, indices;
    uint8_t kind;
} content;

static const content contents[CONTENTS] = {{LOW, 12, 0, WIRE_GEOMETRY_HULL}, {HIGH, 12, 0, WIRE_GEOMETRY_HULL},
    {PLAIN, 12, 12, WIRE_GEOMETRY_MESH}, {large, LARGE, 12, WIRE_GEOMETRY_MESH}, {flat, 12, 0, WIRE_GEOMETRY_HULL}};

typedef struct play {
    server *server;
    service *service;
    link_sink sink;
    memory_end *end;
    wire_memory *memory;
    int64_t now_ns, sequences[CLIENTS], step[CLIENTS];
    wire_message words[KEPT]; /* on geometry, some of which come again, late */
    size_t said;
    uint64_t random;
    long refused[WIRE_REASON_COUNT], shared, held, waiting, missing;
} play;

static uint64_t next(play *p)
{
    return prng_bits(&p->random);
}

static uint32_t below(play *p, uint32_t n)
{
    return (uint32_t)(next(p) % n);
}

static int64_t hash_of(const content *c)
{
    return wire_geometry_hash(c->kind, (wire_f64s){c->count, c->numbers}, (wire_i32s){c->indices, TRIANGLES});
}

static void send(play *p, const wire_message *m)
{
    memory_send(p->end, m);
}

/* ---- what they say ---- */

static void hello(play *p, int who)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .lease_ns = 3600000000000,
            .on_loss = (uint8_t)below(p, 3),
            .lock_step = below(p, 2) ? 2 : 0,
            .name = "test"}};
    send(p, &m);
}

static void leave(play *p, int who)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .removed = 1,
            .lease_ns = 1,
            .name = ""}};
    send(p, &m);
    p->sequences[who] += 10;
}

static void send_piece(play *p, int who, const content *c, int32_t piece)
{
    uint32_t all = c->count + c->indices, from = (uint32_t)piece * WIRE_PIECE_MAX;
    uint32_t end = from + WIRE_PIECE_MAX < all ? from + WIRE_PIECE_MAX : all;
    uint32_t vertex_end = end < c->count ? end : c->count;
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .kind = c->kind,
            .hash = hash_of(c),
            .vertex_numbers = (int32_t)c->count,
            .index_numbers = (int32_t)c->indices,
            .piece = piece,
            .pieces = (int32_t)((all + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX),
            .vertices = {vertex_end - from, c->numbers + from},
            .indices = {end - vertex_end, TRIANGLES + (vertex_end - c->count)}}};
    p->words[p->said++ % KEPT] = m;
    send(p, &m);
}

static void say_again(play *p)
{
    if (p->said) send(p, &p->words[below(p, p->said < KEPT ? (uint32_t)p->said : KEPT)]);
}

static void send_geometry(play *p, int who)
{
    const content *c = &contents[below(p, CONTENTS)];
    bool two = c->count > WIRE_PIECE_MAX, turned = below(p, 2);
    send_piece(p, who, c, two && turned);
    if (two && below(p, 3)) send_piece(p, who, c, !turned);
}

static void remove_geometry(play *p, int who)
{
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .removed = 1,
            .kind = WIRE_GEOMETRY_HULL,
            .vertex_numbers = 0,
            .pieces = 1,
            .hash = hash_of(&contents[below(p, CONTENTS)])}};
    p->words[p->said++ % KEPT] = m;
    send(p, &m);
}

static void put_body(play *p, int who, bool removed)
{
    uint8_t types[3];
    int64_t hashes[3];
    double sizes[9] = {0}, radii[3] = {0}, local[21] = {0}, pose[7] = {0.3 * below(p, 12), 0.1 * below(p, 3), 0, 1};
    uint32_t count = removed ? 0 : 1 + below(p, 3), compound = count == 3 && below(p, 2);
    char name[16] = "";
    if (!removed) snprintf(name, sizeof name, "body %u", below(p, 8));
    for (uint32_t i = 0; i < count; i++) {
        const content *c = &contents[below(p, CONTENTS - below(p, 2))];
        bool hull = c->kind == WIRE_GEOMETRY_HULL;
        if (compound && !hull) c = &contents[0], hull = true;
        types[i] = hull ? WIRE_SHAPE_HULL : WIRE_SHAPE_MESH;
        hashes[i] = hash_of(c);
        local[7 * i + 3] = 1;
    }
    if (compound) types[0] = WIRE_SHAPE_COMPOUND, hashes[0] = 0, sizes[0] = 2;
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .body = (int32_t)below(p, BODIES),
            .removed = removed,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .ccd = compound ? 0 : (uint8_t)below(p, 3),
            .pose = {removed ? 0 : 7, pose},
            .shape_types = {count, types},
            .shape_sizes = {3 * count, sizes},
            .shape_radii = {count, radii},
            .shape_poses = {7 * count, local},
            .shape_geometries = {count, hashes}}};
    send(p, &m);
}

static void move(play *p, int who, int64_t step, bool end)
{
    double positions[3 * BODIES], orientations[4 * BODIES], linear[3 * BODIES];
    int32_t bodies[BODIES];
    uint32_t count = end ? 0 : 1 + below(p, BODIES - 1), first = below(p, BODIES - count + 1);
    for (uint32_t i = 0; i < count; i++) {
        bodies[i] = (int32_t)(first + i);
        for (uint32_t k = 0; k < 3; k++) positions[3 * i + k] = 0.01 * below(p, k ? 20 : 300);
        for (uint32_t k = 0; k < 3; k++) linear[3 * i + k] = 0.1 * below(p, 5);
        double angle = 0.1 * below(p, 30);
        const double q[4] = {cos(angle), 0, 0.6 * sin(angle), 0.8 * sin(angle)};
        memcpy(orientations + 4 * i, q, sizeof q);
    }
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .stamp_ns = below(p, 8) ? p->now_ns : p->now_ns - 50000000,
            .step = step,
            .bodies = {count, bodies},
            .positions = {3 * count, positions},
            .orientations = {4 * count, orientations},
            .linear = {below(p, 2) ? 3 * count : 0, linear}}};
    send(p, &m);
}

static void subscribe(play *p, int who, bool removed)
{
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = who + 1,
            .sequence = ++p->sequences[who],
            .subscription = (int32_t)below(p, 3),
            .removed = removed,
            .facts = WIRE_FACT_TOUCH + WIRE_FACT_DISTANCE + WIRE_FACT_MANIFOLD + WIRE_FACT_IMPACT + WIRE_FACT_PREDICT,
            .stream = "",
            .select_a = removed ? "" : "*",
            .select_b = removed ? "" : "*",
            .range_m = 0.3,
            .hysteresis_m = 0.05 * below(p, 2),
            .rate_hz = below(p, 2) ? 10 : 0,
            .horizon_s = 0.5,
            .tolerance_m = 1e-6}};
    send(p, &m);
}

static void say_something(play *p)
{
    int who = (int)below(p, CLIENTS);
    int64_t *step = &p->step[who], done = p->service->lock_step.done;
    switch (below(p, 30)) {
    case 0:
        hello(p, who);
        break;
    case 1:
        if (below(p, 3) == 0) leave(p, who);
        break;
    case 2:
        if (below(p, 2) == 0) p->sink.client_lost(p->sink.context, p->service->links[0], who + 1);
        break;
    case 3:
    case 4:
    case 5:
        send_geometry(p, who);
        break;
    case 6:
    case 7:
        remove_geometry(p, who);
        break;
    case 26:
    case 27:
        say_again(p);
        break;
    case 8:
    case 9:
    case 10:
    case 11:
        put_body(p, who, false);
        break;
    case 12:
        put_body(p, who, true);
        break;
    case 13:
        subscribe(p, who, false);
        break;
    case 14:
        if (below(p, 3) == 0) subscribe(p, who, true);
        break;
    case 15:
    case 16:
    case 17:
    case 18:
    case 19:
        move(p, who, 0, false);
        break;
    case 20:
    case 21:
    case 22:
    case 23:
    case 24:
    case 25:
        if (*step <= done || below(p, 20) == 0) *step = done + 1 + below(p, 2) * below(p, 2);
        move(p, who, *step, below(p, 2));
        break;
    default:
        break;
    }
}

/* ---- the books ---- */

static size_t claims_of(const service *s, int64_t id, int64_t client, int64_t *bytes)
{
    size_t count = 0;
    for (size_t i = 0; i < s->sessions.count; i++)
        for (size_t k = 0; k < s->sessions.at[i]->claims.count; k++) {
            const geometry_claim *c = &s->sessions.at[i]->claims.at[k];
            assert_true(c->client == s->sessions.at[i]->client);
            if (c->client == client && c->geometry) {
                const geometry *g = geometry_at(s, c->geometry);
                assert_non_null(g);
                assert_true(g->hash == c->hash);
                *bytes += geometry_bytes((int64_t)g->vertex_numbers, (int64_t)g->index_numbers);
            }
            count += c->geometry == id;
        }
    return count;
}

static void audit(play *p)
{
    service *s = p->service;
    int64_t unused = 0;
    for (size_t i = 0; i < s->geometries.count; i++) {
        const geometry *g = &s->geometries.at[i];
        size_t users = 0;
        if (!g->id) continue;
        for (size_t k = 0; k < s->sessions.count; k++)
            for (size_t n = 0; n < s->sessions.at[k]->bodies.count; n++) {
                const owned_body *b = &s->sessions.at[k]->bodies.at[n];
                for (size_t j = 0; j < b->geometries.count; j++) users += b->geometries.at[j] == g->id;
            }
        assert_int_equal(users, g->users);
        assert_int_equal(claims_of(s, g->id, 0, &unused), g->claims);
        assert_true(users || g->claims); /* or it is gone */
        p->shared += g->claims > 1;
        p->held += users && !g->claims;
        p->missing += g->has != NULL;
        for (size_t k = 0; k < i; k++) {
            const geometry *o = &s->geometries.at[k];
            bool equal = o->id && !o->has && !g->has && o->vertex_numbers == g->vertex_numbers && o->kind == g->kind &&
                         memcmp(o->vertices, g->vertices, g->vertex_numbers * sizeof *g->vertices) == 0;
            assert_false(equal); /* kept once */
        }
    }
    for (size_t i = 0; i < s->sessions.count; i++) {
        int64_t bytes = 0;
        size_t taken_back = 0;
        claims_of(s, 0, s->sessions.at[i]->client, &bytes);
        assert_int_equal(bytes, s->sessions.at[i]->geometry_bytes);
        for (size_t k = 0; k < s->sessions.at[i]->claims.count; k++)
            taken_back += !s->sessions.at[i]->claims.at[k].geometry;
        assert_int_equal(taken_back, s->sessions.at[i]->geometries_taken_back);
    }
    p->waiting += s->pending.count > 0;
}

/* ---- a session, recorded from some tick on ---- */

static void tick(play *p)
{
    service *s = p->service;
    wire_message m;
    p->now_ns += below(p, 25) ? 10000000 : 1200000000;
    s->now_ns = s->monotonic_ns = p->now_ns;
    s->links[0]->ops->receive(s->links[0], &p->sink);
    if (below(p, 10) == 0) steps_watch(s);
    s->tick++;
    service_tick(s);
    for (wire_memory_reset(p->memory); memory_receive(p->end, p->memory, &m); wire_memory_reset(p->memory))
        if (m.kind == WIRE_REJECT) p->refused[m.reject.reason]++;
    audit(p);
}

/* A replay takes them from the recording. */
static void set_others(config *c)
{
    strcpy(c->engine, "gjk");
    c->max_geometries = 3;
    c->max_bodies = 6;
    c->max_client_bodies = 3;
    c->max_client_shapes = 5;
    c->max_subscriptions = 2;
    c->max_pairs = 10;
    c->max_step_poses = 9;
}

static void run(uint64_t seed, int ticks, const char *path, play *sum)
{
    char why[512] = "";
    config c = cell_config();
    static play p;
    p = (play){.random = seed, .now_ns = 1000000000000};
    c.step_timeout = 0.5;
    if (seed % 3 == 1) set_others(&c);
    log_setup(LOG_ERROR, 0);
    p.server = server_create(&c, why, sizeof why);
    if (!p.server) fail_msg("%s", why);
    p.service = server_service(p.server);
    p.sink = server_sink(p.server);
    p.end = memory_connect("cell");
    p.memory = wire_memory_create();
    int begins = (int)below(&p, (uint32_t)ticks);
    for (int i = 0; i < CLIENTS; i++) hello(&p, i);
    subscribe(&p, 0, false);
    for (int i = 0; i < ticks; i++) {
        for (uint32_t n = below(&p, 8); n; n--) say_something(&p);
        if (i == begins && record_start(p.service, path, NULL, why, sizeof why) != 0) fail_msg("%s", why);
        tick(&p);
    }
    record_stop_now(p.service);
    for (int i = 0; i < WIRE_REASON_COUNT; i++) sum->refused[i] += p.refused[i];
    sum->shared += p.shared, sum->held += p.held, sum->waiting += p.waiting, sum->missing += p.missing;
    memory_disconnect(p.end);
    server_destroy(p.server);
    wire_memory_destroy(p.memory);
}

/* Another release leaves the state out, and begins with what was announced: its books are true as well. */
static void replay_what_was_announced(const char *path)
{
    char why[512] = "";
    config c = cell_config();
    wire_log_tick t;
    play p = {.random = 1};
    snprintf(c.replay, sizeof c.replay, "%s", path);
    p.server = server_create(&c, why, sizeof why);
    if (!p.server) fail_msg("%s", why);
    p.service = server_service(p.server);
    p.sink = server_sink(p.server);
    p.sink.state = NULL;
    while (replay_take(p.service, &p.sink, &t, why, sizeof why)) {
        service_tick(p.service);
        audit(&p);
    }
    assert_string_equal(why, "");
    server_destroy(p.server);
}

static void from_any_tick_on(void **state)
{
    (void)state;
    char path[64];
    play sum = {.random = 0};
    int sessions = getenv("COLLIDED_NIGHTLY") ? 1000 : 30;
    for (int i = 0; i < LARGE; i += 3) large[i] = sin(i), large[i + 1] = cos(i), large[i + 2] = sin(2.0 * i + 1);
    snprintf(path, sizeof path, "/tmp/collided-anywhere-%d.lcmlog", (int)getpid());
    for (int seed = 1; seed <= sessions; seed++) {
        run((uint64_t)seed, 150, path, &sum);
        int status = cell_replay(path, 1, true);
        if (status != EX_OK) fail_msg("seed %d: the replay ends with %d, see %s", seed, status, path);
        replay_what_was_announced(path);
        unlink(path);
    }
    assert_true(sum.shared && sum.held && sum.waiting && sum.missing); /* all of it was there */
    assert_true(sum.refused[WIRE_LIMIT] && sum.refused[WIRE_BAD_HASH] && sum.refused[WIRE_FLAT_HULL] &&
                sum.refused[WIRE_UNKNOWN_GEOMETRY] && sum.refused[WIRE_BAD_STEP]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(from_any_tick_on)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
