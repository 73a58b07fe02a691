/* stream: the world's batches as numbered EventBatch messages, each on the stream of its subscription. Tick thread. */
#include "clients.h"
#include "service.h"
#include "standby.h"
#include "streams.h"
#include "vertices.h"
#include "wire/wire_extensions.h"

#include <assert.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EVENTS_A_PART = 128 }; /* a part stays below 64 kB, but for the longest names */

static void open_at(service *s, session *c, const wire_subscription *m, uint32_t world_id, const char *name)
{
    const stream *old = stream_ending(s, name); /* its readers are this one's: a link tells of a reader once */
    bool read = old && old->read && old->link == c->link;
    array_reserve(&s->streams, (size_t)world_id + 1);
    while (s->streams.count <= world_id) s->streams.at[s->streams.count++] = (stream){.live = false};
    s->streams.at[world_id] = (stream){.live = true,
        .read = read,
        .name = base_strdup(name),
        .client = c->client,
        .subscription = m->subscription,
        .link = c->link,
        .each_tick = m->rate_hz == 0};
    scene_subscribed(s, &s->streams.at[world_id], m);
    stream_names_add(s, world_id);
    c->link->ops->stream_open(c->link, name, c->client);
}

static void name_of_stream(const session *c, const wire_subscription *m, char name[WIRE_NAME_MAX + 1])
{
    if (*m->stream)
        snprintf(name, WIRE_NAME_MAX + 1, "%s", m->stream);
    else
        snprintf(name, WIRE_NAME_MAX + 1, "%016" PRIx64 ".%d", (uint64_t)c->client, m->subscription);
}

bool stream_taken(service *s, const session *c, const wire_subscription *m, uint32_t world_id, wire_refusal *why)
{
    char name[WIRE_NAME_MAX + 1];
    name_of_stream(c, m, name);
    const stream *taken = stream_named(s, name);
    if (!taken || (size_t)(taken - s->streams.at) == world_id) return false;
    why->reason = WIRE_NAME_TAKEN;
    snprintf(why->text, sizeof why->text, "stream: \"%.100s\" is the stream of another subscription", name);
    return true;
}

void stream_open(service *s, session *c, const wire_subscription *m, uint32_t world_id)
{
    char name[WIRE_NAME_MAX + 1];
    name_of_stream(c, m, name);
    stream *old = world_id < s->streams.count && s->streams.at[world_id].live ? &s->streams.at[world_id] : NULL;
    if (old) old->each_tick = m->rate_hz == 0;
    if (old) scene_subscribed(s, old, m);
    if (old && old->link == c->link && strcmp(old->name, name) == 0) {
        if (!old->read)
            old->link->ops->stream_open(old->link, name, c->client); /* asked again: is somebody there after all? */
        return;
    }
    if (old) stream_close(s, world_id);
    open_at(s, c, m, world_id, name);
}

void stream_end(service *s, uint32_t world_id, uint8_t cause)
{
    assert(world_id < s->streams.count && s->streams.at[world_id].live);
    world_remove_subscription(s->world, world_id, cause);
    stream_names_drop(s, world_id);
    s->streams.at[world_id].ending = true;
    stream_names_add(s, world_id);
}

/* The link's stream ends with the last that has its name. */
void stream_close(service *s, uint32_t world_id)
{
    assert(world_id < s->streams.count);
    stream at = s->streams.at[world_id];
    if (!at.live) return;
    stream_names_drop(s, world_id);
    s->streams.at[world_id] = (stream){.live = false};
    backlog_free(&at.backlog);
    scene_free(at.view);
    s->scenes -= at.scene;
    if (at.batch > s->last_batch) s->last_batch = at.batch;
    const stream *heir = stream_named(s, at.name);
    if (!heir || heir->link != at.link) at.link->ops->stream_close(at.link, at.name);
    free(at.name);
}

void stream_reader(service *s, struct link *from, const char *name)
{
    stream *at = stream_named(s, name);
    if (!at || at->link != from) return;
    at->read = true;
    world_want_snapshot(s->world, (uint32_t)(at - s->streams.at));
}

bool stream_lacks_reader(service *s, const char *name)
{
    const stream *at = stream_named(s, name);
    return at && !at->read;
}

void stream_receipt(service *s, const wire_receipt *m)
{
    session *c = session_find(s, m->client);
    const owned_subscription *i = c ? session_subscription(c, m->subscription) : NULL;
    bool live = i && i->live && i->world_id < s->streams.count && s->streams.at[i->world_id].live;
    stream *to = live ? &s->streams.at[i->world_id] : NULL;
    if (to && to->reported && !to->ending) backlog_receipt(s, to, m);
}

/* ---- one part of one batch ---- */

typedef struct part {
    uint8_t kinds[EVENTS_A_PART], causes[EVENTS_A_PART], manifold_counts[EVENTS_A_PART];
    int64_t contacts[EVENTS_A_PART], ages_a[EVENTS_A_PART], ages_b[EVENTS_A_PART];
    const char *names_a[EVENTS_A_PART], *names_b[EVENTS_A_PART];
    int32_t shapes_a[EVENTS_A_PART], shapes_b[EVENTS_A_PART];
    double lo[EVENTS_A_PART], hi[EVENTS_A_PART];
    double axes[3 * EVENTS_A_PART], points_a[3 * EVENTS_A_PART], points_b[3 * EVENTS_A_PART];
    double manifold_points[3 * MANIFOLD_POINTS_MAX * EVENTS_A_PART];
    double manifold_distances[MANIFOLD_POINTS_MAX * EVENTS_A_PART];
    int64_t manifold_features[MANIFOLD_POINTS_MAX * EVENTS_A_PART];
    double closings[EVENTS_A_PART], impact_times[2 * EVENTS_A_PART], impact_poses[14 * EVENTS_A_PART];
    int64_t impact_starts[EVENTS_A_PART];
    uint8_t impact_estimated[EVENTS_A_PART], achieved[EVENTS_A_PART];
    uint8_t poses[WIRE_EXTENSION_HEAD + 14 * sizeof(double) * EVENTS_A_PART];
} part;

static void put_vec(double *at, vec3 v)
{
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

static uint32_t put_manifold(part *p, uint32_t points, const manifold *m)
{
    assert(m->count <= MANIFOLD_POINTS_MAX);
    for (uint32_t i = 0; i < m->count; i++, points++) {
        put_vec(p->manifold_points + 3 * (size_t)points, m->points[i].point);
        p->manifold_distances[points] = m->points[i].distance;
        p->manifold_features[points] = (int64_t)m->points[i].feature;
    }
    return points;
}

static void copy_pose(double *at, pose p)
{
    const double numbers[7] = {p.p.x, p.p.y, p.p.z, p.q.w, p.q.x, p.q.y, p.q.z};
    memcpy(at, numbers, sizeof numbers);
}

static uint32_t put_impact(part *p, uint32_t impacts, const world_event *e)
{
    if (e->kind != EVENT_IMPACT && e->kind != EVENT_PREDICTED) return impacts;
    p->impact_times[2 * (size_t)impacts] = e->impact.lo;
    p->impact_times[2 * (size_t)impacts + 1] = e->impact.hi;
    p->impact_starts[impacts] = e->impact.start_ns;
    copy_pose(p->impact_poses + 14 * (size_t)impacts, e->impact.pose_a);
    copy_pose(p->impact_poses + 14 * (size_t)impacts + 7, e->impact.pose_b);
    p->impact_estimated[impacts] = e->impact.estimated;
    return impacts + 1;
}

static void fill_part(part *p, const world_event *events, uint32_t n, wire_event_batch *m)
{
    uint32_t points = 0, impacts = 0;
    assert(n <= EVENTS_A_PART);
    for (uint32_t i = 0; i < n; i++) {
        const world_event *e = &events[i];
        p->kinds[i] = e->kind;
        p->causes[i] = e->cause;
        p->contacts[i] = e->contact;
        p->names_a[i] = e->name_a;
        p->names_b[i] = e->name_b;
        p->shapes_a[i] = e->shape_a;
        p->shapes_b[i] = e->shape_b;
        p->lo[i] = e->lo;
        p->hi[i] = e->hi;
        p->ages_a[i] = e->age_a_ns;
        p->ages_b[i] = e->age_b_ns;
        put_vec(p->axes + 3 * (size_t)i, e->axis);
        put_vec(p->points_a + 3 * (size_t)i, e->point_a);
        put_vec(p->points_b + 3 * (size_t)i, e->point_b);
        p->manifold_counts[i] = (uint8_t)e->manifold.count;
        points = put_manifold(p, points, &e->manifold);
        p->closings[i] = e->closing;
        p->achieved[i] = e->achieved;
        impacts = put_impact(p, impacts, e);
    }
    m->kinds = (wire_u8s){n, p->kinds};
    m->causes = (wire_u8s){n, p->causes};
    m->contacts = (wire_i64s){n, p->contacts};
    m->names_a = (wire_strings){n, p->names_a};
    m->names_b = (wire_strings){n, p->names_b};
    m->shapes_a = (wire_i32s){n, p->shapes_a};
    m->shapes_b = (wire_i32s){n, p->shapes_b};
    m->lo = (wire_f64s){n, p->lo};
    m->hi = (wire_f64s){n, p->hi};
    m->axes = (wire_f64s){3 * n, p->axes};
    m->points_a = (wire_f64s){3 * n, p->points_a};
    m->points_b = (wire_f64s){3 * n, p->points_b};
    m->ages_a_ns = (wire_i64s){n, p->ages_a};
    m->ages_b_ns = (wire_i64s){n, p->ages_b};
    m->manifold_counts = (wire_u8s){n, p->manifold_counts};
    m->manifold_points = (wire_f64s){3 * points, p->manifold_points};
    m->manifold_distances = (wire_f64s){points, p->manifold_distances};
    m->manifold_features = (wire_i64s){points, p->manifold_features};
    m->closings = (wire_f64s){n, p->closings};
    m->achieved = (wire_u8s){n, p->achieved};
    m->impact_times = (wire_f64s){2 * impacts, p->impact_times};
    m->impact_starts_ns = (wire_i64s){impacts, p->impact_starts};
    m->impact_poses = (wire_f64s){14 * impacts, p->impact_poses};
    m->impact_estimated = (wire_u8s){impacts, p->impact_estimated};
}

static bool is_pose(pose p)
{
    return p.q.w != 0 || p.q.x != 0 || p.q.y != 0 || p.q.z != 0;
}

/* The poses that each event is proven for, as a record: 14 numbers an event, little-endian as this machine is. */
static void put_poses(part *p, const world_event *events, uint32_t n, wire_event_batch *m)
{
    const uint32_t head[2] = {WIRE_EXTENSION_POSES, (uint32_t)(14 * sizeof(double) * n)};
    memcpy(p->poses, head, sizeof head);
    for (uint32_t i = 0; i < n; i++) {
        const world_event *e = &events[i];
        bool met = e->kind == EVENT_IMPACT || e->kind == EVENT_PREDICTED, known = met || is_pose(e->pose_a);
        double poses[14] = {0};
        if (known) copy_pose(poses, met ? e->impact.pose_a : e->pose_a);
        if (known) copy_pose(poses + 7, met ? e->impact.pose_b : e->pose_b);
        memcpy(p->poses + sizeof head + i * sizeof poses, poses, sizeof poses);
    }
    m->extensions = (wire_u8s){WIRE_EXTENSION_HEAD + head[1], p->poses};
}

static double age_of(const world_event *e)
{
    int64_t age = e->age_a_ns > e->age_b_ns ? e->age_a_ns : e->age_b_ns;
    return age < 0 ? NAN : 1e-9 * (double)age;
}

static void measure(service *s, const world_batch *b)
{
    for (size_t i = 0; i < b->count; i++) {
        histogram_add(&s->measures.age, age_of(&b->events[i]));
        histogram_add(&s->measures.width, b->events[i].hi - b->events[i].lo);
    }
}

/* Who counts steps is told his own; of several simulators one would take another's answer for his. */
static int64_t step_for(service *s, const stream *to)
{
    const session *c = session_find(s, to->client);
    return c && c->step.step ? c->answered_step : s->latest_step.step;
}

/* Likewise. */
static int64_t simulation_for(service *s, const stream *to)
{
    const session *c = session_find(s, to->client);
    return c && c->simulation.now_ns ? c->simulation.now_ns : s->simulation.now_ns;
}

/* Who missed it himself must not take the batch for the answer to what he sends of it too late. */
static int32_t missing_for(service *s, const stream *to)
{
    const session *c = session_find(s, to->client);
    return c && c->missed ? -s->lock_step.missing : s->lock_step.missing;
}

/* Of the step that it is told. */
static refused_poses refused_for(service *s, const stream *to)
{
    const session *c = session_find(s, to->client);
    return c && c->step.step && c->answered_step == c->step.step ? c->refused : (refused_poses){0};
}

static wire_message message_for(service *s, const stream *to)
{
    refused_poses refused = refused_for(s, to);
    return (wire_message){.kind = WIRE_EVENT_BATCH,
        .event_batch = {.version = WIRE_VERSION,
            .client = to->client,
            .subscription = to->subscription,
            .epoch = s->epoch,
            .batch = to->batch,
            .tick = s->tick,
            .stamp_ns = s->now_ns,
            .latest_pose_ns = s->latest_pose_ns,
            .step = step_for(s, to),
            .simulation_ns = simulation_for(s, to),
            .missing = missing_for(s, to),
            .refused = refused.count,
            .refusal = refused.reason,
            .parts = 1,
            .stream = to->name}};
}

static int64_t heartbeat_ns(const service *s)
{
    return (int64_t)(1e9 * s->config.heartbeat);
}

static void expect_heartbeat(service *s, const stream *to)
{
    int64_t due_ns = to->reported_ns + heartbeat_ns(s);
    if (due_ns < s->next_heartbeat_ns) s->next_heartbeat_ns = due_ns;
}

static int32_t event_parts_of(const world_batch *b)
{
    return (int32_t)((b->count + EVENTS_A_PART - 1) / EVENTS_A_PART);
}

/* Events first, then soft bodies; at least one. */
static int32_t parts_of(const world_batch *b)
{
    int32_t parts = event_parts_of(b) + vertices_parts(b);
    return parts ? parts : 1;
}

/* One part of a batch; valid until the next one. */
static wire_message part_of(service *s, const stream *to, const world_batch *b, int32_t i)
{
    if (!s->part) s->part = base_alloc(1, sizeof *s->part);
    int32_t events = event_parts_of(b);
    size_t first = i < events ? (size_t)i * EVENTS_A_PART : b->count;
    assert(i >= 0);
    size_t n = b->count - first < EVENTS_A_PART ? b->count - first : EVENTS_A_PART;
    wire_message m = message_for(s, to);
    m.event_batch.undone = (int64_t)b->undone;
    m.event_batch.snapshot = b->snapshot;
    m.event_batch.closing = b->closing;
    m.event_batch.part = i;
    m.event_batch.parts = parts_of(b);
    fill_part(s->part, n ? b->events + first : NULL, (uint32_t)n, &m.event_batch);
    if (i >= events && b->soft_count) m.event_batch.extensions = vertices_part(s, b, i - events);
    if (to->tells_poses && n && !b->snapshot) put_poses(s->part, b->events + first, (uint32_t)n, &m.event_batch);
    return m;
}

/* A number that no reader has seen: there may be none. */
static void each_part(service *s, stream *to, const world_batch *b, stream_visit *visit, void *context)
{
    for (int32_t i = 0; i < parts_of(b); i++) {
        wire_message m = part_of(s, to, b, i);
        m.event_batch.batch = ++to->recorded;
        visit(context, &m);
    }
}

void stream_each(service *s, const world_batches *batches, stream_visit *visit, void *context)
{
    for (size_t i = 0; i < batches->count; i++) {
        const world_batch *b = &batches->at[i];
        bool live = b->subscription < s->streams.count && s->streams.at[b->subscription].live;
        if (live && !b->snapshot) each_part(s, &s->streams.at[b->subscription], b, visit, context);
    }
}

/* A portion of a snapshot: all its parts have the head of the first, since it is the state of that tick. Nobody hears
 * of it here while it is another daemon that tells it, nor in a replay. */
static void build_snapshot(service *s, stream *to, const world_batch *b)
{
    static part scratch; /* the tick thread's */
    if (stream_is_replayed(s, to) || standby_waits(s) || (b->goes_on && !to->backlog.building)) return;
    if (!b->goes_on) {
        wire_message head = part_of(s, to, b, 0);
        backlog_build(s, to, &head.event_batch);
    }
    for (size_t first = 0; first < b->count; first += EVENTS_A_PART) {
        size_t n = b->count - first < EVENTS_A_PART ? b->count - first : EVENTS_A_PART;
        wire_message m = {.kind = WIRE_EVENT_BATCH, .event_batch = to->backlog.head};
        fill_part(&scratch, b->events + first, (uint32_t)n, &m.event_batch);
        backlog_add_built(s, to, &m);
    }
    if (!b->more) backlog_built(s, to);
}

/* At once, or when its subscriber has read what waits. */
static void send_or_keep(service *s, stream *to, const world_batch *b)
{
    int32_t parts = parts_of(b);
    bool passes = backlog_is_passed(s, to, b, parts), kept = passes || backlog_begin(s, to, b);
    for (int32_t i = 0; i < parts; i++) {
        to->batch += !b->snapshot;
        if (!kept) continue;
        wire_message m = part_of(s, to, b, i);
        if (passes)
            to->link->ops->publish(to->link, &m);
        else
            backlog_put(to, &m);
    }
    if (passes) {
        to->reported_ns = s->monotonic_ns;
        metric_count(s->count.batches_out, (uint64_t)parts);
        return;
    }
    if (!kept) backlog_skip(s, to, parts);
    backlog_send(s, to);
}

bool stream_tell(service *s, stream *to, wire_u8s extensions)
{
    const world_batch b = {.subscription = (uint32_t)(to - s->streams.at)};
    bool passes = backlog_is_passed(s, to, &b, 1), kept = passes || backlog_begin(s, to, &b);
    to->batch++;
    to->batch_tick = s->tick;
    wire_message m = message_for(s, to);
    m.event_batch.extensions = extensions;
    if (passes)
        to->link->ops->publish(to->link, &m);
    else if (kept)
        backlog_put(to, &m);
    else
        backlog_skip(s, to, 1);
    if (!passes) backlog_send(s, to);
    to->reported_ns = s->monotonic_ns;
    expect_heartbeat(s, to);
    metric_count(s->count.batches_out, 1);
    return kept;
}

/* Numbers go on above those of all streams that have ended: one of the same name, of a client that was lost and is
 * back, may be told of to somebody who knows the old one and has heard neither its end nor the new one's beginning. A
 * snapshot is no batch, and has the number of the one that it follows: numbers do not depend on who asks for one. */
static void publish(service *s, stream *to, const world_batch *b)
{
    assert(to->live && to->read);
    if (!to->reported) to->batch = to->inherited = s->last_batch + 1; /* what ends in this tick has been published */
    if (b->more || b->goes_on)
        build_snapshot(s, to, b);
    else
        send_or_keep(s, to, b);
    measure(s, b);
    to->reported = true;
    if (b->snapshot && !b->more) scene_read_anew(to);
    if (!b->snapshot) to->batch_tick = s->tick;
    expect_heartbeat(s, to);
    metric_count(s->count.events_out, b->count);
    to->events += b->count;
}

/* What a simulator is answered is whole: it need not keep what it was told before. */
void stream_ask_all(service *s)
{
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        for (size_t k = 0; c->stepped && k < c->subscriptions.count; k++) {
            const owned_subscription *own = &c->subscriptions.at[k];
            if (own->live && s->streams.at[own->world_id].each_tick) world_want_all(s->world, own->world_id);
        }
    }
}

static void answer_step(service *s, uint32_t id)
{
    stream *to = &s->streams.at[id];
    if (!to->live || !to->read || !to->reported || !to->each_tick || to->batch_tick == s->tick) return;
    publish(s, to, &(world_batch){.subscription = id});
}

/* Lock-step: a client whose poses carry a step hears of each tick that had one, on each of its streams, also when there
 * is nothing to tell: by then all that the step brings about has been told. */
static void answer_steps(service *s)
{
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (!c->stepped || c->withheld) continue;
        for (size_t k = 0; k < c->subscriptions.count; k++)
            if (c->subscriptions.at[k].live) answer_step(s, c->subscriptions.at[k].world_id);
        c->stepped = false;
    }
}

/* Its first batch waits for the last one of the stream that had its name, and has not ended in this tick. */
static bool waits_for_name(service *s, const stream *to, const world_batch *b)
{
    if (to->reported || to->ending || !b->snapshot || b->goes_on || !stream_ending(s, to->name)) return false;
    world_want_snapshot(s->world, b->subscription);
    return true;
}

/* Before its first reader has come, a stream says nothing: its first batch is the whole state, for that reader. */
static void publish_one(service *s, const world_batch *b)
{
    if (b->subscription >= s->streams.count || !s->streams.at[b->subscription].live) return;
    stream *to = &s->streams.at[b->subscription];
    if (waits_for_name(s, to, b)) return;
    if (to->read && (to->reported || (b->snapshot && !b->goes_on))) publish(s, to, b);
    if (b->closing) stream_close(s, b->subscription);
}

/* What closes goes first: another stream of this tick may have its name. */
void stream_publish(service *s, const world_batches *batches)
{
    for (size_t i = 0; i < batches->count; i++)
        if (batches->at[i].closing) publish_one(s, &batches->at[i]);
    for (size_t i = 0; i < batches->count; i++)
        if (!batches->at[i].closing) publish_one(s, &batches->at[i]);
    answer_steps(s);
}

/* It is no batch: it has the number of the last one, so that a lost heartbeat is no loss, and a lost batch is found
 * out.
 */
static void beat(service *s, uint32_t id, int64_t oldest_ns)
{
    stream *to = &s->streams.at[id];
    wire_message m = message_for(s, to);
    m.event_batch.heartbeat = 1;
    m.event_batch.behind = (int32_t)backlog_count(&to->backlog);
    m.event_batch.oldest_pose_ns = oldest_ns;
    to->link->ops->publish(to->link, &m);
    metric_count(s->count.heartbeats, 1);
    to->reported_ns = s->monotonic_ns;
}

/* One of very many pairs comes a few rounds later: all that it rests on is looked through, some of it in each round. */
void stream_heartbeats(service *s)
{
    if (s->monotonic_ns < s->next_heartbeat_ns) return;
    s->next_heartbeat_ns = INT64_MAX;
    size_t looked = 0, count = s->streams.count, first = s->heartbeat_turn;
    for (size_t n = 0; n < count; n++) {
        size_t i = (first + n) % count;
        stream *to = &s->streams.at[i];
        int64_t oldest_ns;
        if (!to->live || !to->read || !to->reported) continue;
        bool is_due = s->monotonic_ns - to->reported_ns >= heartbeat_ns(s), has_room = looked < OLDEST_STAMP_PART;
        if (is_due && has_room && world_oldest_stamp(s->world, (uint32_t)i, &looked, &oldest_ns))
            beat(s, (uint32_t)i, oldest_ns);
        if (is_due && has_room && looked >= OLDEST_STAMP_PART) s->heartbeat_turn = i + 1; /* who comes next */
        expect_heartbeat(s, to);
    }
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
}

void stream_beat_all(service *s)
{
    for (size_t i = 0; i < s->streams.count; i++) {
        const stream *to = &s->streams.at[i];
        size_t looked = 0;
        int64_t oldest_ns;
        bool tells = to->live && to->read && to->reported && !stream_is_replayed(s, to);
        if (tells && world_oldest_stamp(s->world, (uint32_t)i, &looked, &oldest_ns)) beat(s, (uint32_t)i, oldest_ns);
    }
}

void stream_free_all(service *s)
{
    for (uint32_t i = 0; i < s->streams.count; i++) stream_close(s, i);
    array_free(&s->streams);
    pair_map_free(&s->open_streams);
    pair_map_free(&s->ending_streams);
}
