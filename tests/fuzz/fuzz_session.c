/* Whole sessions: three clients of one daemon announce, move, change, remove, ask, leave, fall silent and come back, in
 * any order, with messages repeated, swapped, late and missing, while a watcher subscribes to all contacts. Each
 * message by itself is well-formed: what is looked for is in their sequence. Of what the watcher is told each contact
 * has one begin and one end, and batches are numbered without a gap; and when everybody has fallen still, what he
 * knows is what a fresh world says of the bodies that are there, compared all with all. */
#include "one_daemon.h"
#include "take.h"

#include <stdlib.h>
#include <time.h>

enum { CLIENTS = 3, WATCHER = 9, BODIES = 6, SHAPES = 3, STEPS_MAX = 400, HELD_MAX = 8, CONTACTS_MAX = 4096 };
enum { TETRAHEDRON, CUBE, GEOMETRIES };

/* ---- what the watcher knows ---- */

typedef enum life { UNSEEN, OPEN, OVER } life;

typedef struct contact {
    life life;
    bool in_snapshot;
    char a[8], b[8];
} contact;

typedef struct watcher {
    contact contacts[CONTACTS_MAX]; /* by id */
    int64_t batch, snapshot_tick;
    bool live;
} watcher;

typedef struct held_message { /* on its way */
    wire_kind kind;
    size_t size;
    uint8_t bytes[2048];
} held_message;

typedef struct session_of {
    one_daemon daemon;
    wire_memory *decoding;
    taking bytes;
    watcher watcher;
    held_message held[HELD_MAX];
    size_t held_count;
    int64_t sequences[WATCHER + 1];
    int64_t hashes[GEOMETRIES];
} session_of;

static void end_contact(contact *c)
{
    PROMISE(c->life == OPEN);
    c->life = OVER;
}

static void follow(watcher *w, const wire_event_batch *b, uint32_t i)
{
    PROMISE(b->contacts.at[i] > 0 && b->contacts.at[i] < CONTACTS_MAX);
    contact *c = &w->contacts[b->contacts.at[i]];
    switch (b->kinds.at[i]) {
    case WIRE_EVENT_BEGIN:
        PROMISE(b->snapshot ? c->life != OVER : c->life == UNSEEN);
        c->life = OPEN;
        c->in_snapshot = b->snapshot;
        snprintf(c->a, sizeof c->a, "%s", b->names_a.at[i]);
        snprintf(c->b, sizeof c->b, "%s", b->names_b.at[i]);
        break;
    case WIRE_EVENT_END:
        end_contact(c);
        break;
    default:
        PROMISE(c->life == OPEN);
    }
}

static void begin_snapshot(watcher *w)
{
    for (size_t i = 0; i < CONTACTS_MAX; i++) w->contacts[i].in_snapshot = false;
}

/* What was open and is not in it has ended meanwhile. */
static void end_snapshot(watcher *w)
{
    for (size_t i = 0; i < CONTACTS_MAX; i++)
        if (w->contacts[i].life == OPEN && !w->contacts[i].in_snapshot) w->contacts[i].life = OVER;
}

static void hear(watcher *w, const wire_event_batch *b)
{
    if (b->heartbeat) {
        PROMISE(b->batch == w->batch);
        return;
    }
    if (b->snapshot && b->part == 0) begin_snapshot(w);
    if (!b->snapshot) PROMISE(!w->live || b->batch == w->batch + 1);
    w->batch = b->batch;
    w->live = !b->closing;
    for (uint32_t i = 0; i < b->kinds.count; i++) follow(w, b, i);
    if (b->snapshot && b->part + 1 == b->parts) end_snapshot(w);
}

/* ---- messages ---- */

static void deliver(session_of *s, const held_message *h)
{
    wire_message m;
    wire_refusal why;
    wire_memory_reset(s->decoding);
    PROMISE(wire_lcm_decode(h->bytes, h->size, s->decoding, &m, &why) == WIRE_OK); /* they are well-formed */
    one_daemon_give(&s->daemon, &m);
}

/* On its way: it comes now, twice, later than what follows, or never. */
static void send(session_of *s, const wire_message *m)
{
    held_message h = {.kind = m->kind, .size = wire_lcm_size(m)};
    uint8_t fate = take_byte(&s->bytes);
    PROMISE(h.size <= sizeof h.bytes);
    wire_lcm_encode(m, h.bytes, h.size);
    if (fate >= 250) return;
    if (fate >= 220 && s->held_count < HELD_MAX)
        s->held[s->held_count++] = h;
    else
        deliver(s, &h);
    if (fate % 8 == 7) deliver(s, &h);
}

static void let_go(session_of *s, size_t which)
{
    if (!s->held_count) return;
    which %= s->held_count;
    held_message h = s->held[which];
    s->held[which] = s->held[--s->held_count];
    deliver(s, &h);
}

static int64_t next_sequence(session_of *s, int64_t client)
{
    return ++s->sequences[client];
}

static const double TETRAHEDRON_AT[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1};
static const double CUBE_AT[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1, 1, 1, 1};

static wire_f64s points_of(int which)
{
    return which == TETRAHEDRON ? (wire_f64s){12, TETRAHEDRON_AT} : (wire_f64s){24, CUBE_AT};
}

static void say_client(session_of *s, int64_t client)
{
    uint8_t how = take_byte(&s->bytes);
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION,
            .client = client,
            .removed = how >= 240,
            .on_loss = how % 2 ? WIRE_LOST_KEEP : WIRE_LOST_REMOVE,
            .lease_ns = INT64_C(200000000),
            .name = "fuzz"}};
    m.client.sequence = next_sequence(s, client);
    send(s, &m);
}

static void say_geometry(session_of *s, int64_t client)
{
    uint8_t how = take_byte(&s->bytes);
    int which = how % GEOMETRIES;
    wire_message m = {.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = client,
            .removed = how >= 230,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = s->hashes[which],
            .pieces = 1,
            .vertices = points_of(which)}};
    m.geometry.vertex_numbers = (int32_t)m.geometry.vertices.count;
    if (m.geometry.removed) m.geometry.vertices.count = 0;
    m.geometry.sequence = next_sequence(s, client);
    send(s, &m);
}

/* In steps of a quarter of a metre, so that some touch and none is within rounding of it. */
static double place(session_of *s)
{
    return 0.25 * (take_byte(&s->bytes) % 32) + 0.01;
}

static void say_body(session_of *s, int64_t client)
{
    static const char *const NAMES[] = {"a", "b", "c", "d", "e", "f", "g", "h"};
    static const char *const PATTERNS[] = {"a", "*", "b*", "group:g"};
    uint8_t types[SHAPES], actions[1], shapes = 1 + take_byte(&s->bytes) % SHAPES, how = take_byte(&s->bytes);
    double sizes[3 * SHAPES] = {0}, radii[SHAPES], poses[7 * SHAPES] = {0}, pose[7] = {place(s), 0, 0, 1};
    int64_t geometries[SHAPES] = {0};
    const double zero[1] = {0};
    const char *reasons[] = {""}, *patterns[] = {PATTERNS[how % 4]};
    for (int i = 0; i < shapes; i++) {
        uint8_t kind = take_byte(&s->bytes) % 4;
        bool hull = kind >= 2;
        types[i] = kind == 0 ? WIRE_SHAPE_SPHERE : kind == 1 ? WIRE_SHAPE_BOX : WIRE_SHAPE_HULL;
        radii[i] = kind == 0 ? 0.5 : 0;
        if (kind == 1) sizes[3 * i] = sizes[3 * i + 1] = sizes[3 * i + 2] = 0.3;
        if (hull) geometries[i] = s->hashes[kind - 2];
        poses[7 * i] = 0.5 * i;
        poses[7 * i + 3] = 1;
    }
    actions[0] = how % 3 ? WIRE_RULE_CHECK : WIRE_RULE_ALLOW;
    uint32_t rules = how % 5 == 0;
    wire_message m = {.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = client,
            .body = take_byte(&s->bytes) % BODIES,
            .removed = how >= 230,
            .motion = how % 11 == 0,
            .name = NAMES[take_byte(&s->bytes) % 8],
            .group = how % 7 ? "" : "g",
            .category = 1 + how % 2,
            .mask = how % 13 ? -1 : 1,
            .one_way = how % 17 == 0,
            .stamp_is_now = 1,
            .stamp_ns = s->daemon.now_ns,
            .pose = {7, pose},
            .shape_types = {shapes, types},
            .shape_sizes = {3u * shapes, sizes},
            .shape_radii = {shapes, radii},
            .shape_poses = {7u * shapes, poses},
            .shape_geometries = {shapes, geometries},
            .rule_patterns = {rules, patterns},
            .rule_actions = {rules, actions},
            .rule_reasons = {rules, reasons},
            .rule_paddings = {rules, zero},
            .rule_margins = {rules, zero}}};
    m.body.sequence = next_sequence(s, client);
    send(s, &m);
}

static void say_poses(session_of *s, int64_t client)
{
    int32_t bodies[BODIES];
    double positions[3 * BODIES] = {0}, orientations[4 * BODIES] = {0};
    uint8_t teleports[BODIES], count = 1 + take_byte(&s->bytes) % BODIES;
    for (int i = 0; i < count; i++) {
        bodies[i] = take_byte(&s->bytes) % BODIES;
        teleports[i] = take_byte(&s->bytes) > 200;
        positions[3 * i] = place(s);
        orientations[4 * i] = 1;
    }
    wire_message m = {.kind = WIRE_POSE_BATCH,
        .pose_batch = {.version = WIRE_VERSION,
            .client = client,
            .stamp_ns = s->daemon.now_ns,
            .bodies = {count, bodies},
            .positions = {3u * count, positions},
            .orientations = {4u * count, orientations},
            .teleports = {count, teleports}}};
    m.pose_batch.sequence = next_sequence(s, client);
    send(s, &m);
}

static void say_subscription(session_of *s, int64_t client)
{
    static const char *const PATTERNS[] = {"*", "a", "b*", "group:g"};
    uint8_t how = take_byte(&s->bytes);
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = client,
            .subscription = how % 4,
            .removed = how >= 220,
            .facts = 1 + take_byte(&s->bytes) % 31,
            .stream = "",
            .select_a = PATTERNS[how % 4],
            .select_b = PATTERNS[how / 4 % 4],
            .range_m = 1,
            .tolerance_m = 1e-6,
            .horizon_s = 0.5}};
    m.subscription.sequence = next_sequence(s, client);
    send(s, &m);
}

static void say_query(session_of *s, int64_t client)
{
    static const uint8_t KINDS[] = {WIRE_QUERY_DISTANCE, WIRE_QUERY_EXPLAIN, WIRE_QUERY_BODIES, WIRE_QUERY_NEAREST};
    uint8_t how = take_byte(&s->bytes);
    wire_message m = {.kind = WIRE_QUERY,
        .query = {.version = WIRE_VERSION,
            .client = client,
            .kind = KINDS[how % 4],
            .name_a = how % 4 == 2 ? "*" : "a",
            .name_b = "b",
            .length_m = 2,
            .tolerance_m = 1e-6,
            .most = how}};
    m.query.sequence = next_sequence(s, client);
    send(s, &m);
}

/* ---- the watcher ---- */

static void say_here(session_of *s)
{
    wire_message m = {.kind = WIRE_CLIENT,
        .client = {.version = WIRE_VERSION, .client = WATCHER, .lease_ns = INT64_C(3600000000000), .name = "watcher"}};
    m.client.sequence = next_sequence(s, WATCHER);
    one_daemon_give(&s->daemon, &m);
}

static void say_watch(session_of *s)
{
    wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = WATCHER,
            .facts = WIRE_FACT_TOUCH,
            .stream = "",
            .select_a = "*",
            .select_b = "*",
            .tolerance_m = 1e-6}};
    m.subscription.sequence = next_sequence(s, WATCHER);
    one_daemon_give(&s->daemon, &m);
}

static void acknowledge(session_of *s, const wire_event_batch *b)
{
    wire_message m = {.kind = WIRE_RECEIPT,
        .receipt = {.version = WIRE_VERSION, .client = WATCHER, .epoch = b->epoch, .batch = b->batch}};
    if (b->snapshot && b->part + 1 < b->parts) m.receipt.tick = b->tick, m.receipt.part = b->part;
    m.receipt.sequence = next_sequence(s, WATCHER);
    one_daemon_give(&s->daemon, &m);
}

static void read_all(session_of *s)
{
    wire_message m;
    while (one_daemon_hear(&s->daemon, &m)) {
        if (m.kind != WIRE_EVENT_BATCH || m.event_batch.client != WATCHER) continue;
        hear(&s->watcher, &m.event_batch);
        acknowledge(s, &m.event_batch);
    }
}

static void tick(session_of *s, int64_t by_ns)
{
    one_daemon_tick(&s->daemon, by_ns);
    read_all(s);
}

/* ---- the end of it ---- */

/* Of the watcher, or of the fresh world: "a b", with the lesser name first, each pair once. */
typedef struct pairs {
    char names[CONTACTS_MAX][8];
    size_t count;
} pairs;

static int by_name(const void *a, const void *b)
{
    return strcmp(a, b);
}

static void add_pair(pairs *p, const char *a, const char *b)
{
    bool in_order = strcmp(a, b) < 0;
    PROMISE(p->count < CONTACTS_MAX);
    snprintf(p->names[p->count++], sizeof p->names[0], "%.3s %.3s", in_order ? a : b, in_order ? b : a);
}

/* Shapes of two bodies make contacts of their own. */
static void sort_pairs(pairs *p)
{
    size_t kept = 0;
    qsort(p->names, p->count, sizeof p->names[0], by_name);
    for (size_t i = 0; i < p->count; i++)
        if (!kept || strcmp(p->names[kept - 1], p->names[i]) != 0) memmove(p->names[kept++], p->names[i], 8);
    p->count = kept;
}

static void copy_bodies(const world *from, world *to)
{
    world_shape shapes[WIRE_SHAPES_MAX];
    size_t left = world_get_figures(from).bodies;
    for (uint32_t id = 0; left && id < 10000; id++) {
        world_body def;
        uint32_t copy = WORLD_NONE;
        if (!world_body_name(from, id) || world_get_body(from, id, &def, NULL) != WORLD_OK) continue;
        PROMISE(world_get_body(from, id, &def, shapes) == WORLD_OK);
        def.deadline_ns = 0;
        PROMISE(world_put_body(to, &copy, &def) == WORLD_OK);
        left--;
    }
    PROMISE(!left);
}

static void compare_all_with_all(const session_of *s, pairs *p)
{
    world_options options = world_options_default();
    world_batches batches;
    world_subscription all = {.facts = WORLD_TOUCH, .select_a = "*", .select_b = "*", .tolerance = 1e-6};
    uint32_t subscription = WORLD_NONE;
    world *fresh = world_create(&options);
    copy_bodies(s->daemon.service->world, fresh);
    PROMISE(world_put_subscription(fresh, &subscription, &all) == WORLD_OK);
    for (int i = 0; i < 4; i++) { /* a snapshot, and what it may have left for later */
        world_tick(fresh, s->daemon.now_ns, &batches);
        for (size_t k = 0; k < batches.count; k++)
            for (size_t e = 0; e < batches.at[k].count; e++)
                if (batches.at[k].events[e].kind == EVENT_BEGIN)
                    add_pair(p, batches.at[k].events[e].name_a, batches.at[k].events[e].name_b);
    }
    world_destroy(fresh);
    sort_pairs(p);
}

/* Bodies wait for a geometry, commands for their share of work, or pairs for their turn. */
static bool is_busy(const session_of *s)
{
    return s->daemon.service->pending.count || s->daemon.service->geometries_building ||
           shares_next_ns(s->daemon.service) != INT64_MAX || world_get_figures(s->daemon.service->world).pending_pairs;
}

/* Everybody is heard, nobody says anything more, and what waits for a hull is refused. */
static void fall_still(session_of *s)
{
    while (s->held_count) let_go(s, 0);
    for (int i = 0; i < 30 || (i < 2000 && is_busy(s)); i++) {
        tick(s, INT64_C(100000000));
        if (is_busy(s)) nanosleep(&(struct timespec){0, 100000}, NULL);
    }
    PROMISE(!is_busy(s));
}

static void hold_against_all(session_of *s)
{
    static pairs told, truth;
    told.count = truth.count = 0;
    for (size_t i = 0; i < CONTACTS_MAX; i++) {
        const contact *c = &s->watcher.contacts[i];
        if (c->life == OPEN) add_pair(&told, c->a, c->b);
    }
    sort_pairs(&told);
    compare_all_with_all(s, &truth);
    bool same = told.count == truth.count;
    for (size_t i = 0; same && i < told.count; i++) same = strcmp(told.names[i], truth.names[i]) == 0;
    for (size_t i = 0; !same && i < told.count; i++) fprintf(stderr, "told: %s\n", told.names[i]);
    for (size_t i = 0; !same && i < truth.count; i++) fprintf(stderr, "truth: %s\n", truth.names[i]);
    PROMISE(same);
}

static void open_session(session_of *s)
{
    one_daemon_begin(&s->daemon);
    s->decoding = wire_memory_create();
    for (int g = 0; g < GEOMETRIES; g++)
        s->hashes[g] = wire_geometry_hash(WIRE_GEOMETRY_HULL, points_of(g), (wire_i32s){0, NULL});
}

static void close_session(session_of *s)
{
    one_daemon_end(&s->daemon);
    wire_memory_destroy(s->decoding);
}

static void act(session_of *s)
{
    uint8_t what = take_byte(&s->bytes);
    int64_t client = 1 + take_byte(&s->bytes) % CLIENTS;
    switch (what % 12) {
    case 0:
        say_client(s, client);
        break;
    case 1:
        say_geometry(s, client);
        break;
    case 2:
    case 3:
        say_body(s, client);
        break;
    case 4:
    case 5:
        say_poses(s, client);
        break;
    case 6:
        say_subscription(s, client);
        break;
    case 7:
        say_query(s, client);
        break;
    case 8:
        let_go(s, what / 12);
        break;
    case 9:
        if (what > 200) s->sequences[client] = 0;
        break; /* its process begins anew, and counts from 1 */
    default:
        tick(s, INT64_C(1000000) * (1 + (what > 230 ? 300 : what % 20)));
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static session_of s;
    memset(&s, 0, sizeof s);
    s.bytes = (taking){data, size, 1};
    open_session(&s);
    say_here(&s);
    say_watch(&s);
    for (int i = 0; i < STEPS_MAX && s.bytes.left; i++) act(&s);
    fall_still(&s);
    hold_against_all(&s);
    close_session(&s);
    return 0;
}
