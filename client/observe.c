/* observe: looking at the world: the bodies that there are and where they stand, and the numbers of their geometries.
 * A scene comes on a stream like events do (stream.c), in records of octets (idl/README.md, "Scenes"), which are read
 * with bounds checked. The caller's thread. */
#include "observe.h"
#include "allocate.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- octets ---- */

typedef struct octets {
    const uint8_t *at;
    size_t left;
    bool broken; /* it says more than there is */
} octets;

static const void *next(octets *from, size_t size)
{
    if (from->broken || size > from->left) {
        from->broken = true;
        return NULL;
    }
    const uint8_t *at = from->at;
    from->at += size;
    from->left -= size;
    return at;
}

static void get(octets *from, void *to, size_t size)
{
    const void *at = next(from, size);
    if (at)
        memcpy(to, at, size);
    else
        memset(to, 0, size);
}

static int32_t get_i32(octets *from)
{
    int32_t n;
    get(from, &n, sizeof n);
    return n;
}

/* Of things that have at least `each` octets: no more than there may be. */
static size_t get_count(octets *from, size_t each)
{
    int32_t n = get_i32(from);
    if (n >= 0 && (size_t)n <= from->left / each) return (size_t)n;
    from->broken = true;
    return 0;
}

/* ---- what is handed to the callback, in memory that is used again ---- */

struct scene_room {
    collided_seen_body *bodies;
    size_t body_capacity;
    collided_shape *shapes;
    size_t shape_capacity;
    char *texts;
    size_t text_capacity;
    int32_t *removed, *ids;
    size_t removed_capacity, id_capacity;
    collided_pose *poses;
    size_t pose_capacity;
    unsigned *flags;
    size_t flag_capacity;
    collided_pose *event_poses;
    size_t event_pose_capacity;
};

void scene_room_free(scene_room *r)
{
    if (!r) return;
    free(r->bodies);
    free(r->shapes);
    free(r->texts);
    free(r->removed);
    free(r->ids);
    free(r->poses);
    free(r->flags);
    free(r->event_poses);
    free(r);
}

static scene_room *room_of(collided *c)
{
    if (!c->scene) c->scene = allocate(1, sizeof *c->scene);
    return c->scene;
}

static void get_pose(octets *from, collided_pose *p)
{
    get(from, p->position, sizeof p->position);
    get(from, p->orientation, sizeof p->orientation);
}

/* Offsets for pointers, until all have come: the arrays may move. */
static size_t get_text(octets *from, scene_room *r, size_t *used)
{
    uint8_t size;
    get(from, &size, 1);
    const void *text = next(from, size);
    size_t at = *used, length = text ? size : 0;
    r->texts = reserve(r->texts, &r->text_capacity, at + length + 1, 1);
    if (length) memcpy(r->texts + at, text, length);
    r->texts[at + length] = '\0';
    *used = at + length + 1;
    return at;
}

static void get_shape(octets *from, collided_shape *s)
{
    uint8_t type;
    *s = (collided_shape){0};
    get(from, &type, 1);
    s->type = (collided_shape_type)type;
    get(from, s->half, sizeof s->half);
    get(from, &s->radius, sizeof s->radius);
    get(from, &s->deviation, sizeof s->deviation);
    get_pose(from, &s->pose);
    get(from, &s->geometry.hash, sizeof s->geometry.hash);
}

typedef struct body_offsets {
    size_t name, group, owner, first, count;
} body_offsets;

enum { SHAPE_OCTETS = 1 + 13 * 8, BODY_OCTETS = 4 + 1 + 8 + 8 + 56 + 3 + 2 };

/* The children of a compound stand behind it: they become its own, and `count` less. Where they end after that. */
static size_t gather_children(collided_shape *shapes, size_t count, collided_shape *heads)
{
    size_t kept = 0;
    for (size_t i = 0; i < count;) {
        collided_shape s = shapes[i++];
        if (s.type == COLLIDED_COMPOUND) {
            double children = s.half[0];
            size_t n = children >= 0 && children <= (double)(count - i) ? (size_t)children : 0;
            s.half[0] = 0;
            s.children = shapes + i;
            s.child_count = n;
            i += n;
        }
        heads[kept++] = s;
    }
    return kept;
}

static void get_bodies(octets *from, scene_room *r, size_t count)
{
    body_offsets *where = allocate(count + 1, sizeof *where);
    size_t texts = 0, shapes = 0, all = 0;
    r->bodies = reserve(r->bodies, &r->body_capacity, count + 1, sizeof *r->bodies);
    for (size_t i = 0; i < count; i++) {
        collided_seen_body *b = &r->bodies[i];
        uint8_t flags;
        uint16_t n;
        int64_t deadline_ns;
        *b = (collided_seen_body){.id = get_i32(from)};
        get(from, &flags, 1);
        get(from, &b->client, sizeof b->client);
        get(from, &deadline_ns, sizeof deadline_ns);
        get_pose(from, &b->pose);
        b->flags = flags;
        b->deadline_s = 1e-9 * (double)deadline_ns;
        where[i].name = get_text(from, r, &texts);
        where[i].group = get_text(from, r, &texts);
        where[i].owner = get_text(from, r, &texts);
        get(from, &n, sizeof n);
        if ((size_t)n * SHAPE_OCTETS > from->left) from->broken = true;
        if (from->broken) n = 0;
        where[i].first = shapes;
        where[i].count = n;
        r->shapes = reserve(r->shapes, &r->shape_capacity, 2 * (shapes + n) + 2, sizeof *r->shapes);
        for (size_t k = 0; k < n; k++) get_shape(from, &r->shapes[shapes++]);
    }
    all = shapes; /* behind them, those that are no children */
    for (size_t i = 0; i < count; i++) {
        collided_seen_body *b = &r->bodies[i];
        b->name = r->texts + where[i].name;
        b->group = r->texts + where[i].group;
        b->owner = r->texts + where[i].owner;
        b->shapes = r->shapes + all;
        b->shape_count = gather_children(r->shapes + where[i].first, where[i].count, r->shapes + all);
        all += b->shape_count;
    }
    free(where);
}

static bool read_scene(octets from, scene_room *r, collided_scene *out)
{
    uint8_t whole;
    get(&from, &out->revision, sizeof out->revision);
    get(&from, &whole, 1);
    out->whole = whole != 0;
    out->removed_count = get_count(&from, sizeof(int32_t));
    r->removed = reserve(r->removed, &r->removed_capacity, out->removed_count + 1, sizeof *r->removed);
    get(&from, r->removed, out->removed_count * sizeof *r->removed);
    out->body_count = get_count(&from, BODY_OCTETS);
    get_bodies(&from, r, out->body_count);
    out->removed = r->removed;
    out->bodies = r->bodies;
    return !from.broken;
}

static bool read_poses(octets from, scene_room *r, collided_scene *out)
{
    get(&from, &out->revision, sizeof out->revision);
    size_t n = get_count(&from, 4 + 56 + 1);
    r->ids = reserve(r->ids, &r->id_capacity, n + 1, sizeof *r->ids);
    r->poses = reserve(r->poses, &r->pose_capacity, n + 1, sizeof *r->poses);
    r->flags = reserve(r->flags, &r->flag_capacity, n + 1, sizeof *r->flags);
    get(&from, r->ids, n * sizeof *r->ids);
    for (size_t i = 0; i < n; i++) get_pose(&from, &r->poses[i]);
    for (size_t i = 0; i < n; i++) {
        uint8_t flags;
        get(&from, &flags, 1);
        r->flags[i] = flags;
    }
    out->pose_count = n;
    out->ids = r->ids;
    out->poses = r->poses;
    out->flags = r->flags;
    return !from.broken;
}

static octets record_of(const wire_event_batch *b, uint32_t id)
{
    wire_u8s rest = b->extensions;
    wire_extension e;
    while (wire_extension_next(&rest, &e))
        if (e.id == id) return (octets){e.bytes.at, e.bytes.count, false};
    return (octets){NULL, 0, true};
}

void observe_deliver(collided *c, subscription_record *i, const wire_event_batch *b)
{
    octets scene = record_of(b, WIRE_EXTENSION_SCENE), poses = record_of(b, WIRE_EXTENSION_BODY_POSES);
    collided_scene out = {.subscription = {i->id}, .epoch = b->epoch, .tick = b->tick, .stamp_ns = b->stamp_ns};
    out.lost = i->lost;
    bool has_scene = !scene.broken && read_scene(scene, room_of(c), &out);
    bool has_poses = !poses.broken && read_poses(poses, room_of(c), &out);
    out.closing = b->closing;
    bool told = has_scene || has_poses || out.closing;
    if (!told) return; /* a heartbeat, a snapshot's head, or malformed: the daemon's own octets */
    i->lost = 0;
    c->in_callback = true;
    i->observed(i->context, &out);
    c->in_callback = false;
    c->delivered++;
}

/* Two an event, in its order; NULL: they were not told. */
const collided_pose *observe_event_poses(collided *c, const wire_message *const *parts, size_t part_count)
{
    scene_room *r = NULL;
    size_t at = 0;
    bool any = false;
    for (size_t k = 0; k < part_count; k++) {
        const wire_event_batch *b = &parts[k]->event_batch;
        octets from = record_of(b, WIRE_EXTENSION_POSES);
        if (from.broken && !any && k + 1 < part_count) {
            at += 2 * (size_t)b->kinds.count; /* perhaps the next part has some */
            continue;
        }
        if (from.broken && !any) return NULL;
        if (!any) {
            r = room_of(c);
            r->event_poses = reserve(r->event_poses, &r->event_pose_capacity, at + 1, sizeof *r->event_poses);
            memset(r->event_poses, 0, at * sizeof *r->event_poses);
            any = true;
        }
        size_t more = 2 * (size_t)b->kinds.count;
        r->event_poses = reserve(r->event_poses, &r->event_pose_capacity, at + more + 1, sizeof *r->event_poses);
        for (size_t n = 0; n < more; n++) get_pose(&from, &r->event_poses[at++]);
    }
    return any ? r->event_poses : NULL;
}

/* ---- geometry ---- */

static collided_status take_piece(collided *c, const wire_answer *a, collided_geometry_numbers *out, int32_t *pieces)
{
    wire_u8s rest = a->extensions;
    wire_extension e = {0};
    while (wire_extension_next(&rest, &e) && e.id != WIRE_EXTENSION_GEOMETRY) continue;
    octets from = {e.bytes.at, e.id == WIRE_EXTENSION_GEOMETRY ? e.bytes.count : 0, false};
    uint8_t kind;
    int64_t hash;
    int32_t counts[4]; /* vertex numbers, indices, piece, pieces */
    get(&from, &kind, 1);
    get(&from, &hash, sizeof hash);
    get(&from, counts, sizeof counts);
    bool sane = !from.broken && counts[0] >= 0 && counts[1] >= 0 && counts[0] <= WIRE_GEOMETRY_MAX &&
                counts[1] <= WIRE_GEOMETRY_MAX && counts[2] >= 0;
    if (!sane) return session_fail(c, COLLIDED_TRANSPORT, "an answer without a geometry came");
    size_t vertices = (size_t)counts[0], indices = (size_t)counts[1];
    if (!out->vertices) {
        out->kind = (collided_geometry_kind)kind;
        out->vertices = allocate(vertices + 1, sizeof(double));
        out->indices = allocate(indices + 1, sizeof(int32_t));
        out->vertex_numbers = vertices;
        out->index_count = indices;
    }
    size_t first = (size_t)counts[2] * WIRE_PIECE_MAX, end = first + WIRE_PIECE_MAX;
    bool same = out->vertex_numbers == vertices && out->index_count == indices;
    size_t all = vertices + indices, last = end < all ? end : all;
    for (size_t i = first; same && i < last; i++) {
        if (i < vertices)
            get(&from, &out->vertices[i], sizeof(double));
        else
            get(&from, &out->indices[i - vertices], sizeof(int32_t));
    }
    *pieces = counts[3];
    return same && !from.broken ? COLLIDED_OK : session_fail(c, COLLIDED_TRANSPORT, "a piece of a geometry is cut off");
}

collided_status collided_query_geometry(
    collided *c, const char *body, collided_geometry geometry, double timeout_s, collided_geometry_numbers *out)
{
    char hash[20];
    *out = (collided_geometry_numbers){0};
    (void)snprintf(hash, sizeof hash, "%016llx", (unsigned long long)geometry.hash);
    int64_t deadline = session_monotonic_ns() + session_seconds(timeout_s);
    int32_t pieces = 1;
    collided_status status = COLLIDED_OK;
    for (int32_t piece = 0; status == COLLIDED_OK && piece < pieces; piece++) {
        wire_query q = {.kind = WIRE_QUERY_GEOMETRY, .name_a = body, .name_b = hash, .most = piece};
        wire_message *answer = NULL;
        double left_s = 1e-9 * (double)(deadline - session_monotonic_ns());
        status = query_answer(c, q, left_s > 0 ? left_s : 0, &answer);
        if (status == COLLIDED_OK) status = take_piece(c, &answer->answer, out, &pieces);
        free(answer);
    }
    if (status != COLLIDED_OK) collided_geometry_numbers_free(out);
    return status;
}

void collided_geometry_numbers_free(collided_geometry_numbers *numbers)
{
    free(numbers->vertices);
    free(numbers->indices);
    *numbers = (collided_geometry_numbers){0};
}

collided_observation_def collided_observation_def_default(void)
{
    return (collided_observation_def){.select = "*", .rate_hz = 30};
}
