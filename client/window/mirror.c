/* mirror: see mirror.h. */
#include "mirror.h"

#include "index.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TOUCHING = 1, NEAR = 4, UNKNOWN = 6, PREDICTED = 9, GAP = 255 };

mirror *mirror_create(void)
{
    mirror *m = web_allocate(1, sizeof *m);
    m->names = index_create();
    m->by_id = index_create();
    m->near = index_create();
    m->by_hash = index_create();
    m->changes = 1;
    return m;
}

static void free_body(mirror_body *b)
{
    free(b->name);
    free(b->group);
    free(b->owner);
    free(b->shapes);
    free(b->geometries);
}

void mirror_destroy(mirror *m)
{
    if (!m) return;
    for (size_t i = 0; i < m->body_count; i++) free_body(&m->bodies[i]);
    free(m->bodies);
    free(m->geometries);
    free(m->contacts);
    free(m->ids);
    index_destroy(m->names);
    index_destroy(m->by_id);
    index_destroy(m->near);
    index_destroy(m->by_hash);
    free(m);
}

static char *copy_text(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(web_allocate(size, 1), text, size);
}

/* ---- bodies ---- */

/* Names whose hashes are equal stand one behind the other, under the next keys. */
static int64_t place_of_name(const mirror *m, const char *name, uint64_t *key)
{
    *key = index_mix_text(UINT64_C(14695981039346656037), name);
    for (;; ++*key) {
        int64_t at = index_get(m->names, *key);
        if (at < 0 || strcmp(m->bodies[at].name, name) == 0) return at;
    }
}

int64_t mirror_find(const mirror *m, const char *name)
{
    uint64_t key;
    return place_of_name(m, name, &key);
}

/* Somebody may speak of it before it is known. */
static uint32_t body_named(mirror *m, const char *name)
{
    uint64_t key;
    int64_t at = place_of_name(m, name, &key);
    if (at >= 0) return (uint32_t)at;
    m->bodies = web_reserve(m->bodies, &m->body_capacity, m->body_count + 1, sizeof *m->bodies);
    m->bodies[m->body_count] = (mirror_body){
        .name = copy_text(name), .group = copy_text(""), .owner = copy_text(""), .pose = {.orientation = {1}}};
    index_put(m->names, key, (int64_t)m->body_count);
    return (uint32_t)m->body_count++;
}

static uint32_t geometry_of(mirror *m, int64_t client, const collided_shape *s, uint32_t body)
{
    if (!s->geometry.hash) return UINT32_MAX;
    uint64_t key = index_mix(index_mix(index_mix(1, (uint64_t)client), (uint64_t)s->geometry.hash), s->type);
    int64_t at = index_get(m->by_hash, key);
    if (at >= 0) {
        m->geometries[at].body = body;
        return (uint32_t)at;
    }
    m->geometries = web_reserve(m->geometries, &m->geometry_capacity, m->geometry_count + 1, sizeof *m->geometries);
    m->geometries[m->geometry_count] = (mirror_geometry){client, s->geometry.hash, (uint32_t)s->type, body, m->changes};
    index_put(m->by_hash, key, (int64_t)m->geometry_count);
    return (uint32_t)m->geometry_count++;
}

static size_t count_shapes(const collided_shape *shapes, size_t count)
{
    size_t all = count;
    for (size_t i = 0; i < count; i++) all += shapes[i].child_count;
    return all;
}

static void put_shapes(mirror *m, uint32_t body, const collided_seen_body *seen)
{
    mirror_body *b = &m->bodies[body];
    free(b->shapes);
    free(b->geometries);
    b->shape_count = count_shapes(seen->shapes, seen->shape_count);
    b->shapes = web_allocate(b->shape_count, sizeof *b->shapes);
    b->geometries = web_allocate(b->shape_count, sizeof *b->geometries);
    size_t at = 0;
    for (size_t i = 0; i < seen->shape_count; i++) {
        const collided_shape *s = &seen->shapes[i];
        b->shapes[at++] = *s;
        for (size_t k = 0; k < s->child_count; k++) b->shapes[at++] = s->children[k];
    }
    for (size_t i = 0; i < b->shape_count; i++) {
        b->shapes[i].children = NULL; /* they stand behind it */
        b->geometries[i] = geometry_of(m, seen->client, &b->shapes[i], body);
    }
}

static void remove_body(mirror *m, uint32_t place)
{
    mirror_body *b = &m->bodies[place];
    if (!b->live) return;
    b->live = false;
    m->live--;
    m->bodies_gone[m->bodies_gone_count++ % MIRROR_GONE] = (mirror_gone){m->changes, place};
}

static void put_body(mirror *m, const collided_seen_body *seen)
{
    uint32_t place = body_named(m, seen->name);
    mirror_body *b = &m->bodies[place];
    m->live += !b->live;
    b->live = true;
    free(b->group);
    free(b->owner);
    b->group = copy_text(seen->group);
    b->owner = copy_text(seen->owner);
    b->flags = seen->flags;
    b->client = seen->client;
    b->deadline_s = seen->deadline_s;
    b->pose = seen->pose;
    b->changed = b->posed = m->changes;
    put_shapes(m, place, seen);
    size_t id = (size_t)seen->id;
    size_t before = m->id_capacity;
    m->ids = web_reserve(m->ids, &m->id_capacity, id + 1, sizeof *m->ids);
    for (size_t i = before; i < m->id_capacity; i++) m->ids[i] = MIRROR_NOBODY;
    if (m->ids[id] != MIRROR_NOBODY && m->ids[id] != place) remove_body(m, (uint32_t)m->ids[id]);
    m->ids[id] = place;
}

static int64_t place_of_id(const mirror *m, int32_t id)
{
    return id >= 0 && (size_t)id < m->id_capacity ? m->ids[id] : MIRROR_NOBODY;
}

static void forget_bodies(mirror *m)
{
    for (size_t i = 0; i < m->body_count; i++) m->bodies[i].live = false;
    for (size_t i = 0; i < m->id_capacity; i++) m->ids[i] = MIRROR_NOBODY;
    m->live = 0;
    m->scene_since = m->changes;
}

void mirror_scene(void *context, const collided_scene *scene)
{
    mirror *m = context;
    m->changes++;
    m->epoch = scene->epoch;
    m->tick = scene->tick;
    m->stamp_ns = scene->stamp_ns;
    if (scene->whole || scene->closing) forget_bodies(m);
    for (size_t i = 0; i < scene->removed_count; i++) {
        int64_t place = place_of_id(m, scene->removed[i]);
        if (place == MIRROR_NOBODY) continue;
        remove_body(m, (uint32_t)place);
        m->ids[scene->removed[i]] = MIRROR_NOBODY;
    }
    for (size_t i = 0; i < scene->body_count; i++) put_body(m, &scene->bodies[i]);
    if (scene->whole || scene->closing || scene->removed_count || scene->body_count) m->scene = m->changes;
    for (size_t i = 0; i < scene->pose_count; i++) {
        int64_t place = place_of_id(m, scene->ids[i]);
        if (place == MIRROR_NOBODY) continue;
        mirror_body *b = &m->bodies[place];
        b->pose = scene->poses[i];
        b->flags = scene->flags[i];
        b->posed = m->changes;
    }
    m->poses = m->changes;
}

/* ---- contacts ---- */

static uint64_t pair_key(const mirror_contact *c)
{
    uint64_t h = index_mix(7, (uint64_t)c->a << 32 | c->b);
    return index_mix(h, (uint64_t)c->shape_a << 32 | c->shape_b);
}

static void drop_contact(mirror *m, int64_t id)
{
    int64_t at = index_get(m->by_id, (uint64_t)id);
    if (at < 0) return;
    index_drop(m->by_id, (uint64_t)id);
    if (m->contacts[at].base == NEAR) index_drop(m->near, pair_key(&m->contacts[at]));
    m->contacts_gone[m->contacts_gone_count++ % MIRROR_GONE] = (mirror_gone){m->changes, id};
    m->contacts[at] = m->contacts[--m->contact_count];
    if ((size_t)at < m->contact_count) index_put(m->by_id, (uint64_t)m->contacts[at].id, at);
}

static mirror_contact *contact_of(mirror *m, int64_t id)
{
    int64_t at = index_get(m->by_id, (uint64_t)id);
    if (at >= 0) return &m->contacts[at];
    m->contacts = web_reserve(m->contacts, &m->contact_capacity, m->contact_count + 1, sizeof *m->contacts);
    m->contacts[m->contact_count] = (mirror_contact){.id = id};
    index_put(m->by_id, (uint64_t)id, (int64_t)m->contact_count);
    return &m->contacts[m->contact_count++];
}

static bool is_pose(const collided_pose *p)
{
    return p->orientation[0] != 0 || p->orientation[1] != 0 || p->orientation[2] != 0 || p->orientation[3] != 0;
}

/* Poses that were not told with it may be those that the bodies have now: collided_verify says so. Only where the
 * shapes are no geometries: those are for the page. */
static bool proves_now(const mirror *m, mirror_contact *c)
{
    const mirror_body *a = &m->bodies[c->a], *b = &m->bodies[c->b];
    size_t i = 0, k = 0, n = 0;
    while (i < a->shape_count && n < c->shape_a) i += 1 + a->shapes[i].child_count, n++;
    for (n = 0; k < b->shape_count && n < c->shape_b;) k += 1 + b->shapes[k].child_count, n++;
    if (i >= a->shape_count || k >= b->shape_count || a->shapes[i].child_count || b->shapes[k].child_count)
        return false;
    if (a->shapes[i].geometry.hash || b->shapes[k].geometry.hash) return false;
    collided_certificate claim = {.lo = c->lo, .hi = c->hi};
    memcpy(claim.axis, c->axis, sizeof claim.axis);
    memcpy(claim.point_a, c->point_a, sizeof claim.point_a);
    memcpy(claim.point_b, c->point_b, sizeof claim.point_b);
    return collided_verify(&a->shapes[i], &a->pose, NULL, 0, &b->shapes[k], &b->pose, NULL, 0, &claim) == COLLIDED_OK;
}

static void fill_contact(mirror *m, mirror_contact *c, const collided_batch *b, const collided_event *e, size_t i)
{
    c->tick = b->tick;
    c->lo = e->lo;
    c->hi = e->hi;
    c->closing = e->closing_m_s;
    c->age_a = e->age_a_s;
    c->age_b = e->age_b_s;
    memcpy(c->axis, e->axis, sizeof c->axis);
    memcpy(c->point_a, e->point_a, sizeof c->point_a);
    memcpy(c->point_b, e->point_b, sizeof c->point_b);
    c->a = body_named(m, e->name_a);
    c->b = body_named(m, e->name_b);
    c->shape_a = e->shape_a < 0 ? UINT32_MAX : (uint32_t)e->shape_a;
    c->shape_b = e->shape_b < 0 ? UINT32_MAX : (uint32_t)e->shape_b;
    c->achieved = (uint8_t)e->achieved;
    c->lo_s = e->impact ? e->impact->lo_s : NAN;
    c->hi_s = e->impact ? e->impact->hi_s : NAN;
    c->start_ns = e->impact ? e->impact->start_ns : 0;
    c->estimated = e->impact && e->impact->estimated;
    c->has_poses = e->impact || (b->poses && is_pose(&b->poses[2 * i]));
    if (e->impact) {
        c->pose_a = e->impact->pose_a;
        c->pose_b = e->impact->pose_b;
    } else if (c->has_poses) {
        c->pose_a = b->poses[2 * i];
        c->pose_b = b->poses[2 * i + 1];
    } else if (isfinite(c->lo) && proves_now(m, c)) {
        c->has_poses = true;
        c->pose_a = m->bodies[c->a].pose;
        c->pose_b = m->bodies[c->b].pose;
    }
    c->changed = m->changes;
}

/* While two touch, what is told of their contact stands for their nearness, too. */
static void update_near(mirror *m, const mirror_contact *from)
{
    int64_t at = index_get(m->near, pair_key(from));
    at = at < 0 ? -1 : index_get(m->by_id, (uint64_t)at);
    if (at < 0 || &m->contacts[at] == from) return;
    mirror_contact *near = &m->contacts[at];
    int64_t id = near->id;
    uint8_t base = near->base;
    *near = *from;
    near->id = id;
    near->base = base;
    near->kind = from->kind == UNKNOWN ? UNKNOWN : base;
}

static void take_contact(mirror *m, const collided_batch *b, const collided_event *e, size_t i)
{
    if (e->contact == 0 || e->kind == COLLIDED_EVENT_IMPACT) return;
    if (e->kind == COLLIDED_END || e->kind == COLLIDED_FAR || e->kind == COLLIDED_EVENT_AVERTED) {
        drop_contact(m, e->contact);
        return;
    }
    mirror_contact *c = contact_of(m, e->contact);
    fill_contact(m, c, b, e, i);
    if (e->kind == COLLIDED_BEGIN) c->base = TOUCHING;
    if (e->kind == COLLIDED_NEAR) c->base = NEAR;
    if (e->kind == COLLIDED_EVENT_PREDICTED) c->base = PREDICTED;
    if (!c->base) c->base = TOUCHING;
    c->kind = e->kind == COLLIDED_UNKNOWN ? UNKNOWN : c->base;
    if (e->kind == COLLIDED_NEAR) index_put(m->near, pair_key(c), c->id);
    if (c->base == TOUCHING) update_near(m, c);
}

void mirror_forget_contacts(mirror *m)
{
    m->changes++;
    m->contact_count = 0;
    index_clear(m->by_id);
    index_clear(m->near);
    m->contacts_since = m->contacts_change = m->changes;
}

void mirror_forget(mirror *m)
{
    mirror_forget_contacts(m);
    forget_bodies(m);
    m->scene = m->poses = m->changes;
}

/* ---- events ---- */

static uint8_t cause_number(const char *cause)
{
    static const char *const NAMES[] = {"motion", "removed", "owner_lost", "filter", "shape", "subscription",
        "shutdown", "stale", "snapshot", "teleport"};
    for (size_t i = 0; i < sizeof NAMES / sizeof NAMES[0]; i++)
        if (strcmp(NAMES[i], cause) == 0) return (uint8_t)i;
    return UINT8_MAX;
}

static void add_event(mirror *m, const mirror_event *e)
{
    m->events[m->event_count++ % MIRROR_EVENTS] = *e;
}

static void take_event(mirror *m, const collided_batch *b, const collided_event *e)
{
    bool repeats = e->kind == COLLIDED_EVENT_PREDICTED || e->kind == COLLIDED_NEAR; /* with each new interval */
    bool is_new = !repeats || index_get(m->by_id, (uint64_t)e->contact) < 0;
    if (e->kind == COLLIDED_UPDATE || !is_new) return;
    bool anything = e->kind == COLLIDED_EVENT_IMPACT && strcmp(e->name_b, "*") == 0;
    add_event(m, &(mirror_event){.contact = e->contact,
                     .tick = b->tick,
                     .stamp_ns = b->stamp_ns,
                     .lo = e->lo,
                     .hi = e->hi,
                     .closing = e->closing_m_s,
                     .age_a = e->age_a_s,
                     .age_b = e->age_b_s,
                     .lo_s = e->impact ? e->impact->lo_s : NAN,
                     .hi_s = e->impact ? e->impact->hi_s : NAN,
                     .start_ns = e->impact ? e->impact->start_ns : 0,
                     .estimated = e->impact && e->impact->estimated,
                     .a = body_named(m, e->name_a),
                     .b = anything || strcmp(e->name_b, "*") == 0 ? UINT32_MAX : body_named(m, e->name_b),
                     .shape_a = e->shape_a < 0 ? UINT32_MAX : (uint32_t)e->shape_a,
                     .shape_b = e->shape_b < 0 ? UINT32_MAX : (uint32_t)e->shape_b,
                     .kind = (uint8_t)e->kind,
                     .cause = cause_number(e->cause),
                     .achieved = (uint8_t)e->achieved,
                     .snapshot = b->snapshot});
}

void mirror_batch(void *context, const collided_batch *b)
{
    mirror *m = context;
    if (b->starved) return;
    m->changes++;
    if (b->lost > 0) {
        m->lost += (uint64_t)b->lost;
        add_event(m, &(mirror_event){.contact = b->lost,
                         .tick = b->tick,
                         .stamp_ns = b->stamp_ns,
                         .kind = GAP,
                         .a = UINT32_MAX,
                         .b = UINT32_MAX});
    }
    if (b->heartbeat) return;
    if (b->snapshot) mirror_forget_contacts(m);
    for (size_t i = 0; i < b->event_count; i++) {
        take_event(m, b, &b->events[i]);
        take_contact(m, b, &b->events[i], i);
    }
    if (b->event_count) m->contacts_change = m->changes;
}
