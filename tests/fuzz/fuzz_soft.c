/* Whole sessions with soft bodies: two clients announce small surfaces, crumple them frame by frame (in parts, in
 * single precision, proposed, teleported, half, old, of no numbers), move a ball through them, subscribe, remove and
 * come again, with slices so short that steps take many ticks. What does not pass wire_check is not given, as links do.
 * Of what is told each contact has one begin and one end, each step is whole, nothing that is unfinished is called
 * free, and when everybody has fallen still nothing waits. */
#include "one_daemon.h"
#include "take.h"
#include "wire/wire_soft.h"

enum {
    CLIENTS = 2,
    BODIES = 3, /* of a client; the last one is a ball */
    SIDE = 4,
    POINTS = SIDE * SIDE,
    NUMBERS = WIRE_SOFT_HEAD + 3 * POINTS,
    INDICES = 6 * (SIDE - 1) * (SIDE - 1),
    STEPS_MAX = 200,
    CONTACTS_MAX = 4096
};

typedef enum life { UNSEEN, OPEN, OVER } life;

typedef struct soft_session {
    one_daemon daemon;
    taking bytes;
    life contacts[CONTACTS_MAX];
    int64_t sequence, frames, hash;
} soft_session;

static void give(soft_session *s, const wire_message *m)
{
    wire_refusal why;
    if (wire_check(m, &why) == WIRE_OK) one_daemon_give(&s->daemon, m);
}

/* ---- what is told ---- */

static void look_at_events(soft_session *s, const wire_event_batch *b)
{
    for (uint32_t i = 0; i < b->kinds.count; i++) {
        PROMISE(b->contacts.at[i] > 0 && b->contacts.at[i] < CONTACTS_MAX);
        life *l = &s->contacts[b->contacts.at[i]];
        if (b->kinds.at[i] == WIRE_EVENT_BEGIN) {
            PROMISE(b->snapshot ? *l != OVER : *l == UNSEEN);
            *l = OPEN;
        } else {
            PROMISE(*l == OPEN);
            if (b->kinds.at[i] == WIRE_EVENT_END) *l = OVER;
        }
    }
}

static void look_at_steps(wire_u8s extensions)
{
    static wire_soft_reader at;
    wire_soft_pair p;
    wire_soft_feature f;
    if (!wire_soft_read(extensions, &at)) return;
    while (wire_soft_next_pair(&at, &p)) {
        bool unfinished = p.flags & WIRE_SOFT_UNFINISHED;
        PROMISE(p.safe_lo >= 0 && p.safe_lo <= 1 && p.safe_hi >= p.safe_lo);
        PROMISE(!unfinished || p.safe_lo == 0);
        PROMISE(p.within + p.undecided <= p.vertex_face + p.edge_edge + p.face_shape);
        PROMISE(p.left_out + p.features <= p.vertex_face + p.edge_edge + p.face_shape);
        while (wire_soft_next_feature(&at, &f)) PROMISE(f.t_lo <= f.t_hi && (double)f.t_lo >= p.safe_lo - 1e-7);
    }
}

static void tick(soft_session *s)
{
    wire_message m;
    one_daemon_tick(&s->daemon, 10000000);
    while (one_daemon_hear(&s->daemon, &m)) {
        if (m.kind != WIRE_EVENT_BATCH) continue;
        look_at_events(s, &m.event_batch);
        look_at_steps(m.event_batch.extensions);
    }
}

/* ---- what clients say ---- */

static void say_client(soft_session *s, int64_t client)
{
    const wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .lease_ns = INT64_C(3600000000000),
            .name = "fuzz"}};
    give(s, &m);
}

static void say_surface(soft_session *s, int64_t client)
{
    double numbers[NUMBERS] = {1, 0, 0};
    int32_t indices[INDICES], *to = indices;
    for (int i = 0; i < 3 * POINTS; i++)
        numbers[WIRE_SOFT_HEAD + i] = i % 3 == 0 ? 0.25 * (i / 3 % SIDE) : i % 3 == 1 ? 0.25 * (i / 3 / SIDE) : 0;
    for (int32_t v = 0; v + SIDE < POINTS; v++) {
        if (v % SIDE == SIDE - 1) continue;
        const int32_t two[6] = {v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE};
        memcpy(to, two, sizeof two);
        to += 6;
    }
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .kind = WIRE_GEOMETRY_SOFT,
            .vertex_numbers = NUMBERS,
            .index_numbers = INDICES,
            .pieces = 1,
            .vertices = {NUMBERS, numbers},
            .indices = {INDICES, indices}}};
    m.geometry.hash = s->hash = wire_geometry_hash(m.geometry.kind, m.geometry.vertices, m.geometry.indices);
    give(s, &m);
}

static void say_body(soft_session *s, int64_t client, int32_t body, bool removed)
{
    char name[8];
    const uint8_t type[1] = {body == BODIES - 1 ? WIRE_SHAPE_SPHERE : WIRE_SHAPE_SOFT};
    const double pose[7] = {0, 0, 0, 1}, sizes[3] = {0}, radius[1] = {type[0] == WIRE_SHAPE_SPHERE ? 0.2 : 0.01};
    const int64_t geometry[1] = {type[0] == WIRE_SHAPE_SOFT ? s->hash : 0};
    snprintf(name, sizeof name, "%c%d", (char)('a' + client), (int)body);
    const wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .body = body,
            .removed = removed,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .stamp_ns = s->daemon.now_ns,
            .pose = {7, pose},
            .shape_types = {1, type},
            .shape_sizes = {3, sizes},
            .shape_radii = {1, radius},
            .shape_poses = {7, pose},
            .shape_geometries = {1, geometry}}};
    give(s, &m);
}

static void say_frame(soft_session *s, int64_t client)
{
    static uint8_t octets[WIRE_SOFT_FRAME_BYTES + 12 * (POINTS + 2)];
    double at[3 * (POINTS + 2)];
    float singles[3 * (POINTS + 2)];
    uint8_t how = take_byte(&s->bytes), size = take_byte(&s->bytes), drawn = 1 + take_byte(&s->bytes) % 12;
    uint32_t count = size < 160 ? POINTS : size % (POINTS + 2);
    for (uint32_t i = 0; i < 3 * count; i++) {
        at[i] = i < drawn ? take_number(&s->bytes) : 0.1 * ((int)(i * (how + 7u) % 23) - 11); /* crumpled, quickly */
        singles[i] = fabs(at[i]) < 1e30 ? (float)at[i] : INFINITY;
    }
    const wire_soft_frame f = {.frame = size % 32 == 31 ? s->frames / 2 : ++s->frames,
        .part = how % 16 == 15 ? how / 16 % 3 : 0,
        .parts = how % 16 >= 14 ? 2 : 1,
        .mode = how / 16 % 8 < 5 ? WIRE_SOFT_MOVE : how / 16 % 8 - 5,
        .vertices = count,
        .single = how % 2,
        .origin = {0, 0, how % 4 == 1 ? take_number(&s->bytes) : 0}};
    wire_message m = {.kind = WIRE_VERTEX_BATCH,
        .vertex_batch = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .stamp_ns = s->daemon.now_ns,
            .body = how % BODIES,
            .first_vertex = size < 200 ? 0 : size % 8}};
    if (!f.single) m.vertex_batch.vertices = (wire_f64s){3 * count, at};
    m.vertex_batch.extensions = (wire_u8s){wire_soft_put_frame(&f, f.single ? singles : NULL, octets), octets};
    give(s, &m);
}

static void say_pose(soft_session *s, int64_t client)
{
    const int32_t body[1] = {take_byte(&s->bytes) % BODIES};
    const double at[3] = {take_number(&s->bytes), 0.25, 0}, turn[4] = {1, 0, 0, 0};
    const wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .stamp_ns = s->daemon.now_ns,
            .bodies = {1, body},
            .positions = {3, at},
            .orientations = {4, turn}}};
    give(s, &m);
}

static void say_subscription(soft_session *s, int64_t client)
{
    uint8_t octets[WIRE_SOFT_INTEREST_BYTES], how = take_byte(&s->bytes);
    const wire_soft_interest i = {.grain = how % 2, .most = how / 4 % 4};
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = client,
            .sequence = ++s->sequence,
            .subscription = how % 3,
            .removed = how >= 230,
            .facts = how % 5 ? WIRE_FACT_TOUCH | WIRE_FACT_FEATURES | WIRE_FACT_SAFE_STEP : WIRE_FACT_SAFE_STEP,
            .stream = "",
            .select_a = how % 7 ? "*" : "b*",
            .select_b = "*",
            .threshold_m = how % 3 ? 0 : 0.05,
            .tolerance_m = 1e-6}};
    m.subscription.extensions = (wire_u8s){wire_soft_put_interest(&i, octets), octets};
    give(s, &m);
}

static void act(soft_session *s)
{
    uint8_t what = take_byte(&s->bytes);
    int64_t client = 1 + what % CLIENTS;
    switch (what / CLIENTS % 12) {
    case 0:
        say_body(s, client, take_byte(&s->bytes) % BODIES, take_byte(&s->bytes) % 2);
        break;
    case 1:
        say_subscription(s, client);
        break;
    case 2:
    case 3:
        say_pose(s, client);
        break;
    case 4:
    case 5:
    case 6:
        tick(s);
        break;
    case 7:
        s->daemon.service->config.slice_us = take_byte(&s->bytes) % 2 ? 12000 : 1;
        break;
    default:
        say_frame(s, client);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    soft_session *s = calloc(1, sizeof *s);
    if (!s) abort();
    s->bytes = (taking){.at = data, .left = size};
    one_daemon_begin(&s->daemon);
    for (int64_t client = 1; client <= CLIENTS; client++) {
        say_client(s, client);
        say_surface(s, client);
        for (int32_t i = 0; i < BODIES; i++) say_body(s, client, i, false);
    }
    say_subscription(s, 1);
    for (int i = 0; i < STEPS_MAX && s->bytes.left; i++) act(s);
    const service *of = s->daemon.service;
    for (int i = 0; i < 5000 && (world_changed(of->world) || shares_next_ns(s->daemon.service) != INT64_MAX); i++)
        tick(s);
    PROMISE(world_get_figures(of->world).soft_waiting == 0);
    one_daemon_end(&s->daemon);
    free(s);
    return 0;
}
