/* pending: bodies that wait for their geometry, apart from the inbox, so that they cost nothing while they wait. A body
 * waits for HULL_WAIT_NS for a geometry that has not come, since topics have no order among each other, and without end
 * for one that is being built. Of those that wait for a build, only the newest announcement of each body is kept, with
 * the newest of its poses. The places of those that are
 * gone are closed up when they are many, and after the commands of each tick. Everything here is decided by counts,
 * commands and the recorded clock. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "service.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const size_t GAPS_FEW = 64; /* are left until the tick is over */
/* Of the messages that a tick takes up again: what takes as long as a price of 20 ms, at the least. */
static const size_t WOKEN_BYTES = 400000;

static void free_body(pending_body *p)
{
    free(p->name);
    array_free(&p->hashes);
    array_free(&p->bytes);
}

static pending_body *find_building(const service *s, const session *c, int32_t body)
{
    uint32_t place = c ? pair_map_get(&c->pending_of, (uint64_t)body + 1) : PAIR_MAP_NONE;
    return place == PAIR_MAP_NONE ? NULL : &s->pending.at[place];
}

static void count_needs(session *c, const pending_body *p, int sign)
{
    for (size_t i = 0; i < p->hashes.count; i++) {
        uint64_t hash = (uint64_t)p->hashes.at[i];
        uint32_t before = pair_map_get(&c->pending_needs, hash);
        uint32_t times = (before == PAIR_MAP_NONE ? 0 : before) + (uint32_t)sign;
        if (times)
            pair_map_put(&c->pending_needs, hash, times);
        else
            pair_map_remove(&c->pending_needs, hash);
    }
}

static void count_one(service *s, const pending_body *p, int sign)
{
    session *c = session_find(s, p->client);
    if (c) c->pending_count += (size_t)sign;
    if (!p->builds) s->pending_missing += (size_t)sign;
    if (!p->builds) return;
    s->pending_new += (size_t)(sign * p->is_new);
    s->pending_shapes += (size_t)(sign * (int)p->shapes);
    if (!c) return;
    c->pending_bytes += sign * (int64_t)p->bytes.count;
    count_needs(c, p, sign);
}

/* Of its client's map, by its place. */
static void enter_pending(service *s, uint32_t place)
{
    const pending_body *p = &s->pending.at[place];
    session *c = session_find(s, p->client);
    if (p->builds && c) pair_map_put(&c->pending_of, (uint64_t)p->body + 1, place);
}

static void note_wait(service *s, const pending_body *p)
{
    if (!p->builds && p->since_ns < s->pending_since_ns) s->pending_since_ns = p->since_ns;
}

/* Those whose name is NULL are gone. */
static void close_gaps(service *s)
{
    size_t kept = 0;
    if (!s->pending_gaps) return;
    s->pending_since_ns = INT64_MAX;
    for (uint32_t i = 0; i < s->pending.count; i++) {
        if (!s->pending.at[i].name) continue;
        note_wait(s, &s->pending.at[i]);
        if (kept != i) {
            s->pending.at[kept] = s->pending.at[i];
            enter_pending(s, (uint32_t)kept);
        }
        kept++;
    }
    s->pending.count = kept;
    s->pending_gaps = 0;
}

void pending_tidy(service *s)
{
    close_gaps(s);
}

/* It is closed up later. */
static void remove_one(service *s, pending_body *p)
{
    session *c = session_find(s, p->client);
    count_one(s, p, -1);
    if (p->builds && c) pair_map_remove(&c->pending_of, (uint64_t)p->body + 1);
    free_body(p);
    *p = (pending_body){.name = NULL};
    s->pending_gaps++;
}

/* ---- coming ---- */

/* Those that wait take a place, too, and their bytes; what is of the same body makes room. */
static bool has_room_for_body(service *s, const session *c, const pending_body *p, wire_refusal *why)
{
    const config *f = &s->config;
    world_figures now = world_get_figures(s->world);
    int64_t mib = INT64_C(1) << 20, bytes = c->geometry_bytes + c->pending_bytes + (int64_t)p->bytes.count;
    bool more = p->is_new && !find_building(s, c, p->body);
    size_t bodies = c->body_count + c->pending_of.count;
    return !(more && f->max_client_bodies && apply_limit(s, bodies, f->max_client_bodies, "max_client_bodies", why)) &&
           !(more && apply_limit(s, now.bodies + s->pending_new, f->max_bodies, "max_bodies", why)) &&
           !apply_limit(s, now.shapes + s->pending_shapes + p->shapes - 1, f->max_shapes, "max_shapes", why) &&
           !apply_limit(s, (size_t)((bytes - 1) / mib), f->max_client_geometry, "max_client_geometry", why);
}

static pending_body make(service *s, const command *l, const wire_body *m)
{
    pending_body p = {.client = l->client,
        .sequence = l->sequence,
        .since_ns = l->since_ns,
        .hash = s->carried.lacks,
        .link = l->link,
        .body = m->body,
        .shapes = m->shape_types.count,
        .pose = s->carried.pose,
        .name = base_strdup(m->name)};
    p.builds = geometry_state_of(s, p.client, p.hash) == GEOMETRY_BUILDING;
    for (uint32_t i = 0; i < m->shape_geometries.count; i++)
        if (m->shape_geometries.at[i]) array_push(&p.hashes, m->shape_geometries.at[i]);
    array_reserve(&p.bytes, l->size);
    memcpy(p.bytes.at, s->inbox.bytes.at + l->offset, l->size);
    p.bytes.count = l->size;
    return p;
}

static void add_pending_body(service *s, const pending_body *p)
{
    if (!s->pending_missing) s->pending_since_ns = INT64_MAX;
    array_push(&s->pending, *p);
    enter_pending(s, (uint32_t)(s->pending.count - 1));
    count_one(s, p, 1);
    note_wait(s, p);
}

void pending_put(service *s, const command *l, const wire_body *m)
{
    wire_refusal why;
    session *c = session_find(s, l->client); /* it is there: a Body has been tried */
    const owned_body *b = session_body(c, m->body);
    pending_body p = make(s, l, m);
    p.is_new = !b || b->world_id == WORLD_NONE;
    if (p.builds && !has_room_for_body(s, c, &p, &why)) {
        apply_reject(s, l->link, WIRE_BODY, l->client, l->sequence, m->body, &why);
        free_body(&p);
        return;
    }
    if (p.builds) pending_supersede(s, c, m, &p.pose);
    add_pending_body(s, &p);
}

pending_copy pending_is_copy(const service *s, const session *c, const wire_body *m)
{
    const pending_body *p = find_building(s, c, m->body);
    if (!p || m->sequence > p->sequence) return PENDING_NEWER;
    return m->sequence == p->sequence ? PENDING_SAME : PENDING_OLDER;
}

void pending_supersede(service *s, session *c, const wire_body *m, kept_pose *pose)
{
    pending_body *p = find_building(s, c, m->body);
    if (!p || p->sequence >= m->sequence) return;
    if (p->pose.sequence > pose->sequence) *pose = p->pose;
    session_ack(c, p->sequence);
    remove_one(s, p);
    if (s->pending_gaps > GAPS_FEW + s->pending.count / 2) close_gaps(s);
}

/* ---- waiting ---- */

bool pending_keeps_pose(service *s, session *c, const wire_pose_batch *m, uint32_t i)
{
    pending_body *p = c->pending_of.count ? find_building(s, c, m->bodies.at[i]) : NULL;
    if (!p) return false;
    if (m->sequence <= p->pose.sequence || m->sequence <= p->sequence || m->sequence == STEP_IN_ITS_NAME) return true;
    kept_pose *k = &p->pose;
    *k = (kept_pose){.sequence = m->sequence,
        .stamp_ns = m->stamp_ns,
        .has_linear = m->linear.count != 0,
        .has_angular = m->angular.count != 0};
    memcpy(k->position, m->positions.at + 3 * (size_t)i, sizeof k->position);
    memcpy(k->orientation, m->orientations.at + 4 * (size_t)i, sizeof k->orientation);
    if (k->has_linear) memcpy(k->linear, m->linear.at + 3 * (size_t)i, sizeof k->linear);
    if (k->has_angular) memcpy(k->angular, m->angular.at + 3 * (size_t)i, sizeof k->angular);
    return true;
}

bool pending_needs(const session *c, int64_t hash)
{
    return hash && pair_map_get(&c->pending_needs, (uint64_t)hash) != PAIR_MAP_NONE;
}

/* ---- ending ---- */

/* What it lacked is ready; or is refused or gone, and it is refused at once; or has not come for long. */
static bool may_be_tried(service *s, const pending_body *p)
{
    geometry_state state = s->hull_came ? geometry_state_of(s, p->client, p->hash) : GEOMETRY_MISSING;
    if (p->builds) return s->hull_came && state != GEOMETRY_BUILDING;
    return (s->hull_came && state != GEOMETRY_MISSING) || s->monotonic_ns - p->since_ns >= HULL_WAIT_NS;
}

static command command_of(service *s, const pending_body *p)
{
    inbox *in = &s->inbox;
    bool is_ready = geometry_state_of(s, p->client, p->hash) == GEOMETRY_READY;
    command l = {.client = p->client,
        .sequence = p->sequence,
        .since_ns = p->since_ns,
        .link = p->link,
        .kind = WIRE_BODY,
        .has_waited = p->builds,
        .offset = in->bytes.count,
        .size = p->bytes.count};
    if (p->pose.sequence) array_push(&in->poses, p->pose);
    if (p->pose.sequence) l.pose = (uint32_t)in->poses.count;
    if (p->builds) l.since_ns = is_ready ? s->monotonic_ns : s->monotonic_ns - HULL_WAIT_NS;
    array_reserve(&in->bytes, l.offset + l.size);
    memcpy(in->bytes.at + l.offset, p->bytes.at, l.size);
    in->bytes.count += l.size;
    return l;
}

/* Not more than a tick can take; the others come in the next ones. */
bool pending_wake(service *s)
{
    size_t woken = 0;
    s->pending_left = false;
    if (!pending_due(s)) return false;
    for (size_t i = 0; i < s->pending.count; i++) {
        pending_body *p = &s->pending.at[i];
        if (!p->name || !may_be_tried(s, p)) continue;
        if (woken >= WOKEN_BYTES) {
            s->pending_left = true;
            break;
        }
        woken += p->bytes.count;
        array_push(&s->inbox.commands, command_of(s, p));
        remove_one(s, p);
    }
    close_gaps(s);
    return woken > 0;
}

int64_t pending_next_ns(const service *s)
{
    return s->pending_missing ? s->pending_since_ns + HULL_WAIT_NS : INT64_MAX;
}

void pending_wait_anew(service *s)
{
    for (size_t i = 0; i < s->pending.count; i++) s->pending.at[i].since_ns = s->monotonic_ns;
    s->pending_since_ns = s->monotonic_ns;
}

/* One that waits for what has not come is refused in a tick of its own, if there is no other. */
bool pending_due(const service *s)
{
    return s->pending.count && (s->hull_came || s->monotonic_ns >= pending_next_ns(s));
}

void pending_forget(service *s, int64_t client, int64_t before)
{
    for (size_t i = 0; i < s->pending.count; i++) {
        pending_body *p = &s->pending.at[i];
        if (p->name && p->client == client && p->sequence < before) remove_one(s, p);
    }
    close_gaps(s);
}

void pending_restore(service *s, pending_body *p)
{
    add_pending_body(s, p);
}

void pending_free_all(service *s)
{
    for (size_t i = 0; i < s->pending.count; i++) free_body(&s->pending.at[i]);
    array_free(&s->pending);
    s->pending_new = s->pending_shapes = s->pending_missing = s->pending_gaps = 0;
}
