/* frames: see frames.h. Numbers go out as this machine has them, which is little-endian. */
#include "frames.h"

#include "index.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "frames are little-endian");

enum { SKIPPED_POSES_AT = 64, SKIPPED_CONTACTS_AT = 44 };

unsigned char *frame_octets(const frame *f)
{
    return f->at + FRAME_ROOM;
}

void frame_free(frame *f)
{
    free(f->at);
    *f = (frame){0};
}

static void *frame_add(frame *f, size_t size)
{
    if (!f->at || f->capacity < FRAME_ROOM + f->count + size)
        f->at = web_reserve(f->at, &f->capacity, FRAME_ROOM + f->count + size, 1);
    void *at = f->at + FRAME_ROOM + f->count;
    f->count += size;
    return at;
}

static void frame_put(frame *f, const void *data, size_t size)
{
    void *at = frame_add(f, size);
    if (size) memcpy(at, data, size);
}

static void put_u32(frame *f, uint32_t n)
{
    frame_put(f, &n, sizeof n);
}

static void put_i64(frame *f, int64_t n)
{
    frame_put(f, &n, sizeof n);
}

static void put_f64(frame *f, double n)
{
    frame_put(f, &n, sizeof n);
}

static void frame_pad(frame *f)
{
    size_t more = (8 - f->count % 8) % 8;
    memset(frame_add(f, more), 0, more);
}

static void frame_begin(frame *f, uint8_t kind, const mirror *m)
{
    const uint16_t magic = 0xC011;
    const uint8_t what[2] = {kind, 1};
    f->count = 0;
    frame_put(f, &magic, sizeof magic);
    frame_put(f, what, sizeof what);
    put_u32(f, 0);
    put_i64(f, m->tick);
    put_i64(f, m->stamp_ns);
    put_i64(f, 0);
}

static void frame_end(frame *f)
{
    frame_pad(f);
    uint32_t size = (uint32_t)f->count;
    memcpy(frame_octets(f) + 4, &size, sizeof size);
}

void frame_number(frame *f, uint64_t number, uint32_t skipped)
{
    uint8_t kind = frame_octets(f)[2];
    memcpy(frame_octets(f) + 24, &number, sizeof number);
    size_t at = kind == FRAME_POSES ? SKIPPED_POSES_AT : kind == FRAME_CONTACTS ? SKIPPED_CONTACTS_AT : 0;
    if (at) memcpy(frame_octets(f) + at, &skipped, sizeof skipped);
}

void frame_text(frame *f, uint8_t kind, const mirror *m, const char *json)
{
    frame_begin(f, kind, m);
    frame_put(f, json, strlen(json));
    size_t more = (8 - f->count % 8) % 8;
    memset(frame_add(f, more), ' ', more);
    frame_end(f);
}

/* Of a ring of so many, how many are newer than `since`; more than the ring holds: some are forgotten. */
static bool ring_reaches(const mirror_gone *ring, uint64_t count, uint64_t since)
{
    return count <= MIRROR_GONE || ring[count % MIRROR_GONE].changed <= since;
}

static uint64_t ring_from(const mirror_gone *ring, uint64_t count, uint64_t since)
{
    uint64_t least = count > MIRROR_GONE ? count - MIRROR_GONE : 0, from = count;
    while (from > least && ring[(from - 1) % MIRROR_GONE].changed > since) from--;
    return from;
}

/* ---- the scene ---- */

typedef struct texts {
    frame at;
    uint32_t used;
} texts;

static void put_text(frame *f, frame *texts, const char *text)
{
    size_t size = strlen(text);
    put_u32(f, (uint32_t)texts->count);
    put_u32(f, (uint32_t)size);
    frame_put(texts, text, size);
}

static void frame_put_body(frame *f, frame *strings, const mirror_body *b, uint32_t id, uint32_t *first_shape)
{
    put_u32(f, id);
    put_u32(f, b->flags);
    put_u32(f, *first_shape);
    put_u32(f, (uint32_t)b->shape_count);
    put_text(f, strings, b->name);
    put_text(f, strings, b->group);
    put_text(f, strings, b->owner);
    put_f64(f, b->deadline_s);
    frame_put(f, b->pose.position, sizeof b->pose.position);
    frame_put(f, b->pose.orientation, sizeof b->pose.orientation);
    *first_shape += (uint32_t)b->shape_count;
}

static void frame_put_shapes(frame *f, const mirror_body *b)
{
    uint32_t number = 0, parent = UINT32_MAX;
    size_t children = 0;
    for (size_t i = 0; i < b->shape_count; i++) {
        const collided_shape *s = &b->shapes[i];
        bool child = children > 0;
        put_u32(f, (uint32_t)s->type);
        put_u32(f, b->geometries[i]);
        put_u32(f, child ? number - 1 : number);
        put_u32(f, child ? parent : UINT32_MAX);
        double size[3] = {s->half[0], s->half[1], s->half[2]};
        if (s->type == COLLIDED_COMPOUND) size[0] = (double)s->child_count;
        frame_put(f, size, sizeof size);
        put_f64(f, s->radius);
        put_f64(f, s->deviation);
        frame_put(f, s->pose.position, sizeof s->pose.position);
        frame_put(f, s->pose.orientation, sizeof s->pose.orientation);
        if (child) {
            children--;
        } else {
            number++;
            children = s->child_count;
            parent = (uint32_t)i;
        }
    }
}

static uint32_t frame_kind_of(const mirror_geometry *g)
{
    return g->type == COLLIDED_HULL   ? COLLIDED_GEOMETRY_HULL
           : g->type == COLLIDED_MESH ? COLLIDED_GEOMETRY_MESH
                                      : COLLIDED_GEOMETRY_HEIGHT_FIELD;
}

void frame_scene(frame *f, const mirror *m, uint64_t since, uint32_t revision)
{
    frame strings = {0};
    bool all = since < m->scene_since || since == 0 || !ring_reaches(m->bodies_gone, m->bodies_gone_count, since);
    uint64_t gone = all ? m->bodies_gone_count : ring_from(m->bodies_gone, m->bodies_gone_count, since);
    uint32_t r = 0, n = 0, shapes = 0, geometries = 0, first = 0;
    frame_begin(f, FRAME_SCENE, m);
    (void)frame_add(f, FRAME_HEADER);
    for (uint64_t i = gone; i < m->bodies_gone_count; i++) {
        int64_t id = m->bodies_gone[i % MIRROR_GONE].id;
        if (m->bodies[id].live) continue; /* it came back */
        put_u32(f, (uint32_t)id);
        r++;
    }
    frame_pad(f);
    for (uint32_t id = 0; id < m->body_count; id++) {
        const mirror_body *b = &m->bodies[id];
        if (!b->live || (!all && b->changed <= since)) continue;
        frame_put_body(f, &strings, b, id, &first);
        n++;
        shapes += (uint32_t)b->shape_count;
    }
    for (uint32_t id = 0; id < m->body_count; id++)
        if (m->bodies[id].live && (all || m->bodies[id].changed > since)) frame_put_shapes(f, &m->bodies[id]);
    for (uint32_t i = 0; i < m->geometry_count; i++) {
        const mirror_geometry *g = &m->geometries[i];
        if (!all && g->announced <= since) continue;
        const uint32_t numbers[2] = {i, frame_kind_of(g)}, sizes[2] = {0, 0};
        frame_put(f, numbers, sizeof numbers);
        put_i64(f, g->hash);
        frame_put(f, sizes, sizeof sizes);
        geometries++;
    }
    const uint32_t head[8] = {revision, all, r, n, shapes, geometries, (uint32_t)strings.count, 0};
    memcpy(frame_octets(f) + FRAME_HEADER, head, sizeof head);
    if (strings.count) frame_put(f, frame_octets(&strings), strings.count);
    frame_free(&strings);
    frame_end(f);
}

void frame_geometry(frame *f, const mirror *m, uint32_t number, uint32_t question, const collided_geometry_numbers *g)
{
    frame_begin(f, FRAME_GEOMETRY, m);
    const uint32_t head[6] = {number, g ? (uint32_t)g->kind : 0, g ? (uint32_t)g->vertex_numbers : 0,
        g ? (uint32_t)g->index_count : 0, question, 0};
    frame_put(f, head, sizeof head);
    if (g) frame_put(f, g->vertices, g->vertex_numbers * sizeof *g->vertices);
    if (g) frame_put(f, g->indices, g->index_count * sizeof *g->indices);
    frame_end(f);
}

/* ---- poses ---- */

void frame_poses(frame *f, const mirror *m, uint64_t since, bool all, const double origin[3], uint32_t revision)
{
    frame_begin(f, FRAME_POSES, m);
    frame_put(f, origin, 3 * sizeof *origin);
    uint32_t n = 0;
    const uint32_t head[4] = {0, all, 0, revision};
    size_t head_at = f->count;
    frame_put(f, head, sizeof head);
    for (uint32_t id = 0; id < m->body_count; id++) {
        if (!m->bodies[id].live || (!all && m->bodies[id].posed <= since)) continue;
        put_u32(f, id);
        n++;
    }
    frame_pad(f);
    size_t ids_at = head_at + sizeof head, poses_at = f->count;
    float *to = frame_add(f, (size_t)n * 8 * sizeof *to);
    (void)poses_at;
    const unsigned char *ids = frame_octets(f) + ids_at;
    for (uint32_t i = 0; i < n; i++, to += 8) {
        uint32_t id;
        memcpy(&id, ids + i * sizeof id, sizeof id);
        const mirror_body *b = &m->bodies[id];
        for (int k = 0; k < 3; k++) to[k] = (float)(b->pose.position[k] - origin[k]);
        to[3] = (float)b->flags;
        for (int k = 0; k < 4; k++) to[4 + k] = (float)b->pose.orientation[k];
    }
    memcpy(frame_octets(f) + head_at, &n, sizeof n);
    frame_end(f);
}

/* ---- contacts ---- */

typedef const mirror_contact *const *chosen;

static void put_poses_of(frame *f, chosen at, uint32_t n, bool b)
{
    static const double UNTOLD[7] = {NAN, NAN, NAN, NAN, NAN, NAN, NAN};
    for (uint32_t i = 0; i < n; i++) {
        const collided_pose *p = b ? &at[i]->pose_b : &at[i]->pose_a;
        frame_put(f, at[i]->has_poses ? p->position : UNTOLD, sizeof p->position);
        frame_put(f, at[i]->has_poses ? p->orientation : UNTOLD, sizeof p->orientation);
    }
}

#define COLUMN(member)                                                                                                 \
    for (uint32_t i = 0; i < n; i++) frame_put(f, &at[i]->member, sizeof at[i]->member);                               \
    frame_pad(f)

static void put_columns(frame *f, chosen at, uint32_t n)
{
    COLUMN(id);
    COLUMN(tick);
    COLUMN(lo);
    COLUMN(hi);
    COLUMN(closing);
    COLUMN(age_a);
    COLUMN(age_b);
    COLUMN(lo_s);
    COLUMN(hi_s);
    COLUMN(start_ns);
    COLUMN(axis);
    COLUMN(point_a);
    COLUMN(point_b);
    put_poses_of(f, at, n, false);
    put_poses_of(f, at, n, true);
    COLUMN(a);
    COLUMN(b);
    COLUMN(shape_a);
    COLUMN(shape_b);
    COLUMN(kind);
    COLUMN(achieved);
    for (uint32_t i = 0; i < n; i++) {
        const uint8_t flags = (uint8_t)((at[i]->estimated ? 1 : 0) | (at[i]->has_poses ? 2 : 0));
        frame_put(f, &flags, 1);
    }
    frame_pad(f);
}

/* A page that asked for less than the server has is told that the rest is gone. */
static bool is_in_range(const mirror_contact *c, double range_m)
{
    return c->kind != 4 || c->lo <= range_m;
}

void frame_contacts(frame *f, const mirror *m, uint64_t since, double range_m)
{
    bool all =
        since < m->contacts_since || since == 0 || !ring_reaches(m->contacts_gone, m->contacts_gone_count, since);
    uint64_t from = all ? m->contacts_gone_count : ring_from(m->contacts_gone, m->contacts_gone_count, since);
    uint32_t n = 0, r = 0;
    const mirror_contact **some = web_allocate(m->contact_count, sizeof *some);
    frame_begin(f, FRAME_CONTACTS, m);
    const uint32_t head[6] = {0};
    size_t head_at = f->count;
    frame_put(f, head, sizeof head);
    for (uint64_t i = from; i < m->contacts_gone_count; i++, r++) put_i64(f, m->contacts_gone[i % MIRROR_GONE].id);
    uint32_t most = m->contact_count < FRAME_CONTACTS_MAX ? (uint32_t)m->contact_count : FRAME_CONTACTS_MAX;
    for (uint32_t i = 0; i < most; i++) {
        const mirror_contact *c = &m->contacts[i];
        if (!all && c->changed <= since) continue;
        if (is_in_range(c, range_m)) {
            some[n++] = c;
        } else if (!all) {
            put_i64(f, c->id);
            r++;
        }
    }
    put_columns(f, some, n);
    const uint32_t counts[6] = {n, r, all, 0, (uint32_t)m->contact_count, (uint32_t)m->contact_count - most};
    memcpy(frame_octets(f) + head_at, counts, sizeof counts);
    free(some);
    frame_end(f);
}

/* ---- events ---- */

static void put_event(frame *f, const mirror_event *e)
{
    put_i64(f, e->contact);
    put_i64(f, e->tick);
    put_i64(f, e->stamp_ns);
    const double numbers[7] = {e->lo, e->hi, e->closing, e->age_a, e->age_b, e->lo_s, e->hi_s};
    frame_put(f, numbers, sizeof numbers);
    put_i64(f, e->start_ns);
    const uint32_t who[4] = {e->a, e->b, e->shape_a, e->shape_b};
    frame_put(f, who, sizeof who);
    const uint8_t what[4] = {e->kind, e->cause, e->achieved, e->estimated};
    frame_put(f, what, sizeof what);
    put_u32(f, e->snapshot);
    put_f64(f, 0);
}

uint64_t frame_events(frame *f, const mirror *m, uint64_t from, uint64_t since, size_t most)
{
    uint64_t kept = m->event_count > MIRROR_EVENTS ? m->event_count - MIRROR_EVENTS : 0;
    uint64_t first = from - 1 < kept ? kept : from - 1, last = m->event_count;
    if (last - first > most) last = first + most;
    frame_begin(f, FRAME_EVENTS, m);
    put_i64(f, (int64_t)first + 1);
    put_u32(f, (uint32_t)(last - first));
    put_u32(f, (uint32_t)(first + 1 - (since < first + 1 ? since : first + 1)));
    for (uint64_t i = first; i < last; i++) put_event(f, &m->events[i % MIRROR_EVENTS]);
    frame_end(f);
    return last + 1;
}
