/* scene: what bodies there are and where, for who looks at the world: the stream of a subscription to a scene
 * (WIRE_FACT_SCENE) has no events, but records in `extensions` of its batches. First all bodies that its pattern
 * matches, then those that come, change or go, and of the others the poses and flags that differ from what was told.
 * Batches are numbered, acknowledged and sent again like all (backlog.c), so nothing has to be told twice; while some
 * wait no more is made, and then what has changed since: a slow reader gets fewer states, each of them new, and no more
 * waits for him than one. After a loss, or a standby has taken over, all is told again. The world is not asked for
 * pairs by it. None of it is a command; it is in no recording. Nobody looks: nothing is done, and scene_batches stays
 * 0. Tick thread. */
#include "body_message.h"
#include "clients.h"
#include "service.h"
#include "standby.h"
#include "streams.h"
#include "wire/wire_extensions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char SCENE_NO_BODY[] = "\x01"; /* names have no control characters */

enum {
    POSES_A_BATCH = 900,     /* of 61 octets each: below what DDS sends as one fragment, and LCM as one datagram */
    SCENE_BYTES = 48 * 1024, /* and no more bodies in a batch than begin within so many */
    RETRY_NS = 20000000      /* its reader has not read what waits: later */
};

typedef struct seen_body { /* under the world's id: what was told of it */
    int64_t client, sequence;
    int32_t number;
    bool told, matches;
    uint8_t flags;
    uint32_t scan; /* the last one that found it */
    double pose[7];
} seen_body;

typedef struct owner_and_body {
    const session *owner;
    const owned_body *body;
} owner_and_body;

typedef struct scene_view {
    ARRAY(seen_body) bodies;
    ARRAY(owner_and_body) changed; /* scratch of a scan */
    ARRAY(uint32_t) moved, gone;
    bytes_out out;
    int64_t revision, next_ns, tick;
    uint32_t scan;
    bool anew; /* all is told, and what was told before is to be forgotten */
    body_columns columns;
} scene_view;

void scene_subscribed(service *s, stream *to, const wire_subscription *m)
{
    bool scene = m->facts & WIRE_FACT_SCENE;
    s->scenes += (size_t)scene - (size_t)to->scene;
    to->scene = scene;
    to->tells_poses = m->facts & WIRE_FACT_POSES;
    if (!scene) return;
    static const double LONGEST_NS = 1e18;
    snprintf(to->scene_select, sizeof to->scene_select, "%s", m->select_a);
    to->scene_period_ns = m->rate_hz > 0 ? llround(fmin(1e9 / m->rate_hz, LONGEST_NS)) : 0;
    if (to->view) to->view->anew = true;
}

void scene_read_anew(stream *to)
{
    if (to->view) to->view->anew = true;
}

void scene_free(scene_view *v)
{
    if (!v) return;
    array_free(&v->bodies);
    array_free(&v->changed);
    array_free(&v->moved);
    array_free(&v->gone);
    array_free(&v->out);
    free(v);
}

/* ---- what has changed ---- */

static bool same_bits(const void *a, const void *b, size_t size)
{
    return memcmp(a, b, size) == 0;
}

static uint8_t flags_of(const world_glance *g)
{
    return (uint8_t)((g->stale ? WIRE_SEEN_STALE : 0) | (g->held ? WIRE_SEEN_HELD : 0) |
                     (g->pending ? WIRE_SEEN_PENDING : 0) | (g->fixed ? WIRE_SEEN_FIXED : 0) |
                     (g->swept ? WIRE_SEEN_SWEPT : 0) | (g->one_way ? WIRE_SEEN_ONE_WAY : 0));
}

static seen_body *scene_place_of(scene_view *v, uint32_t id)
{
    array_reserve(&v->bodies, (size_t)id + 1);
    while (v->bodies.count <= id) v->bodies.at[v->bodies.count++] = (seen_body){.told = false};
    return &v->bodies.at[id];
}

static bool is_selected(const service *s, const stream *to, uint32_t id)
{
    world_body def;
    return world_get_body(s->world, id, &def, NULL) == WORLD_OK &&
           world_pattern_matches(to->scene_select, def.name, def.group ? def.group : "");
}

static void look_at(service *s, const stream *to, scene_view *v, const session *c, const owned_body *b)
{
    world_glance g;
    if (b->world_id == WORLD_NONE || !world_glance_at(s->world, b->world_id, &g)) return;
    seen_body *e = scene_place_of(v, b->world_id);
    bool other = e->client != c->client || e->number != b->number || e->sequence != b->sequence;
    if (other || v->anew) e->matches = is_selected(s, to, b->world_id);
    bool announce = e->matches && (other || v->anew || !e->told);
    e->client = c->client;
    e->number = b->number;
    e->sequence = b->sequence;
    if (!e->matches) return; /* one that was told under this id is gone */
    e->scan = v->scan;
    const double pose[7] = {g.pose->p.x, g.pose->p.y, g.pose->p.z, g.pose->q.w, g.pose->q.x, g.pose->q.y, g.pose->q.z};
    uint8_t flags = flags_of(&g);
    bool moved = flags != e->flags || !same_bits(pose, e->pose, sizeof pose);
    e->flags = flags;
    memcpy(e->pose, pose, sizeof pose);
    if (announce)
        array_push(&v->changed, ((owner_and_body){c, b}));
    else if (moved)
        array_push(&v->moved, b->world_id);
}

static void scene_look(service *s, const stream *to, scene_view *v)
{
    v->changed.count = v->moved.count = v->gone.count = 0;
    v->scan++;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        for (size_t k = 0; k < c->bodies.count; k++) look_at(s, to, v, c, &c->bodies.at[k]);
    }
    for (uint32_t id = 0; id < v->bodies.count; id++) {
        seen_body *e = &v->bodies.at[id];
        if (!e->told || e->scan == v->scan) continue;
        if (!v->anew) array_push(&v->gone, id);
        *e = (seen_body){.told = false};
    }
}

/* ---- records: numbers little-endian, as this machine has them, without padding ---- */

static void begin_record(scene_view *v, uint32_t id)
{
    const uint32_t head[2] = {id, 0};
    v->out.count = 0;
    bytes_put(&v->out, head, sizeof head);
    bytes_put(&v->out, &v->revision, sizeof v->revision);
}

static void put_i32(scene_view *v, int32_t n)
{
    bytes_put(&v->out, &n, sizeof n);
}

static void scene_put_text(scene_view *v, const char *text)
{
    size_t length = strlen(text);
    const uint8_t size = (uint8_t)(length > UINT8_MAX ? UINT8_MAX : length);
    bytes_put(&v->out, &size, 1);
    bytes_put(&v->out, text, size);
}

static bool send_record(service *s, stream *to, scene_view *v)
{
    uint32_t octets = (uint32_t)v->out.count - WIRE_EXTENSION_HEAD;
    memcpy(v->out.at + 4, &octets, sizeof octets);
    metric_count(s->count.scene_batches, 1);
    return stream_tell(s, to, (wire_u8s){(uint32_t)v->out.count, v->out.at});
}

static void put_shapes(scene_view *v, const wire_body *m)
{
    const uint16_t count = (uint16_t)m->shape_types.count;
    bytes_put(&v->out, &count, sizeof count);
    for (uint32_t i = 0; i < count; i++) {
        bytes_put(&v->out, &m->shape_types.at[i], 1);
        bytes_put(&v->out, &m->shape_sizes.at[3 * (size_t)i], 3 * sizeof(double));
        bytes_put(&v->out, &m->shape_radii.at[i], sizeof(double));
        bytes_put(&v->out, &m->shape_deviations.at[i], sizeof(double));
        bytes_put(&v->out, &m->shape_poses.at[7 * (size_t)i], 7 * sizeof(double));
        bytes_put(&v->out, &m->shape_geometries.at[i], sizeof(int64_t));
    }
}

/* False: the world does not have it any more. */
static bool scene_put_body(const service *s, scene_view *v, const owner_and_body *at)
{
    world_body def;
    seen_body *e = &v->bodies.at[at->body->world_id];
    if (world_get_body(s->world, at->body->world_id, &def, v->columns.shapes) != WORLD_OK) return false;
    const wire_message m = body_message_of(s, at->owner->client, at->body, &def, &v->columns);
    put_i32(v, (int32_t)at->body->world_id);
    bytes_put(&v->out, &e->flags, 1);
    bytes_put(&v->out, &at->owner->client, sizeof(int64_t));
    bytes_put(&v->out, &def.deadline_ns, sizeof(int64_t));
    bytes_put(&v->out, e->pose, sizeof e->pose);
    scene_put_text(v, def.name);
    scene_put_text(v, def.group ? def.group : "");
    scene_put_text(v, at->owner->name ? at->owner->name : "");
    put_shapes(v, &m.body);
    e->told = true;
    return true;
}

static bool send_bodies(service *s, stream *to, scene_view *v)
{
    size_t next = 0;
    bool first = true, kept = true;
    while (kept && (first ? v->anew || v->gone.count || v->changed.count : next < v->changed.count)) {
        const uint8_t whole = first && v->anew;
        int32_t count = 0;
        v->revision++;
        begin_record(v, WIRE_EXTENSION_SCENE);
        bytes_put(&v->out, &whole, 1);
        put_i32(v, first ? (int32_t)v->gone.count : 0);
        if (first) bytes_put(&v->out, v->gone.at, v->gone.count * sizeof *v->gone.at);
        size_t at = v->out.count;
        put_i32(v, 0);
        while (next < v->changed.count && v->out.count < SCENE_BYTES)
            count += scene_put_body(s, v, &v->changed.at[next++]);
        memcpy(v->out.at + at, &count, sizeof count);
        kept = send_record(s, to, v);
        first = false;
    }
    return kept;
}

static bool send_poses(service *s, stream *to, scene_view *v)
{
    bool kept = true;
    for (size_t from = 0; kept && from < v->moved.count; from += POSES_A_BATCH) {
        size_t n = v->moved.count - from < POSES_A_BATCH ? v->moved.count - from : POSES_A_BATCH;
        begin_record(v, WIRE_EXTENSION_BODY_POSES);
        put_i32(v, (int32_t)n);
        bytes_put(&v->out, v->moved.at + from, n * sizeof *v->moved.at);
        for (size_t i = 0; i < n; i++) bytes_put(&v->out, v->bodies.at[v->moved.at[from + i]].pose, 7 * sizeof(double));
        for (size_t i = 0; i < n; i++) bytes_put(&v->out, &v->bodies.at[v->moved.at[from + i]].flags, 1);
        kept = send_record(s, to, v);
        metric_count(s->count.scene_poses, n);
    }
    return kept;
}

/* What was not kept is followed by a snapshot, with which all is told again. */
static void tell(service *s, stream *to)
{
    if (!to->view) {
        to->view = base_zalloc(1, sizeof *to->view);
        to->view->anew = true;
    }
    scene_view *v = to->view;
    scene_look(s, to, v);
    bool kept = send_bodies(s, to, v) && send_poses(s, to, v);
    v->anew = !kept;
    v->tick = s->tick;
    v->next_ns = s->monotonic_ns + to->scene_period_ns;
}

void scene_watch(service *s)
{
    if (!s->scenes || standby_waits(s) || s->monotonic_ns < scene_next_ns(s)) return;
    int64_t next = INT64_MAX;
    bool told = false;
    s->scene_behind = false;
    for (size_t i = 0; i < s->streams.count; i++) {
        stream *to = &s->streams.at[i];
        if (!to->live || !to->scene || !to->read || !to->reported || to->ending) continue;
        bool behind = backlog_is_behind(&to->backlog), due = !to->view || to->view->next_ns <= s->monotonic_ns;
        if (due && !behind) {
            tell(s, to);
            told = true;
        }
        bool waits = backlog_is_behind(&to->backlog);
        int64_t again = waits ? s->monotonic_ns + RETRY_NS : to->view->next_ns;
        s->scene_behind |= waits || to->view->tick != s->tick;
        if (again < next) next = again;
    }
    s->scene_tick = s->tick;
    s->next_scene_ns = next;
    for (size_t i = 0; told && i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
}

/* What is put or moved is followed by a tick: without one, nothing has changed. */
int64_t scene_next_ns(const service *s)
{
    bool waits = s->next_scene_ns != INT64_MAX && s->next_scene_ns > s->monotonic_ns;
    if (!s->scenes) return INT64_MAX;
    if (s->scene_tick == s->tick) return s->scene_behind ? s->next_scene_ns : INT64_MAX;
    return waits ? s->next_scene_ns : s->monotonic_ns;
}
