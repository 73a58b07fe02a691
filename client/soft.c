/* soft: soft bodies: their surfaces, frames of vertices out, and steps in. Frames go out in parts of one datagram over
 * LCM, of some hundred kB over DDS; the daemon takes a frame when all its parts have come. The caller's thread. */
#include "allocate.h"
#include "announce.h"
#include "session.h"
#include "session_run.h"
#include "wire/wire_soft.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

collided_shape collided_soft(collided_geometry surface, double thickness)
{
    return (collided_shape){
        .type = COLLIDED_SOFT, .radius = thickness / 2, .pose = collided_pose_identity(), .geometry = surface};
}

/* ---- frames ---- */

enum {
    SMALL_PART = 2500,
    SMALL_PART_SINGLE = 5000,
    LARGE_PART = 20000,
    LARGE_PART_SINGLE = 40000,
    DATAGRAM_POSES = 1000
};

static uint32_t part_size(const collided *c, bool single)
{
    bool small = c->link->ops->poses_max < DATAGRAM_POSES;
    if (single) return small ? SMALL_PART_SINGLE : LARGE_PART_SINGLE;
    return small ? SMALL_PART : LARGE_PART;
}

static int send_part(collided *c, const collided_vertices *v, collided_body body, wire_soft_frame *f, uint32_t first,
    uint8_t *room, int64_t stamp_ns, wire_refusal *why)
{
    const float *singles = v->singles ? v->singles + 3 * (size_t)first : NULL;
    wire_message m = {.kind = WIRE_VERTEX_BATCH,
        .vertex_batch = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .stamp_ns = stamp_ns,
            .step = v->step,
            .body = body.id,
            .first_vertex = v->first + (int32_t)first}};
    if (!singles) m.vertex_batch.vertices = (wire_f64s){3 * f->vertices, v->positions + 3 * (size_t)first};
    m.vertex_batch.extensions = (wire_u8s){wire_soft_put_frame(f, singles, room), room};
    if (wire_check(&m, why) != WIRE_OK) return 1;
    c->sequence++;
    return session_send(c, &m) ? 2 : 0;
}

static collided_status publish_frame(collided *c, collided_body body, const collided_vertices *v, int mode)
{
    if (!v || (!v->positions == !v->singles) || v->count == 0 || v->count > WIRE_GEOMETRY_MAX / 3 || v->first < 0)
        return session_fail(
            c, COLLIDED_BAD_ARGUMENT, "vertices: 1 to %d of them, in positions or in singles", WIRE_GEOMETRY_MAX / 3);
    uint32_t most = part_size(c, v->singles != NULL), count = (uint32_t)v->count;
    wire_soft_frame f = {.frame = v->frame,
        .parts = (int32_t)((count + most - 1) / most),
        .mode = mode,
        .single = v->singles != NULL,
        .origin = {v->origin[0], v->origin[1], v->origin[2]}};
    uint8_t *room = allocate(WIRE_SOFT_FRAME_BYTES + (v->singles ? 12 * (size_t)most : 0), 1);
    int64_t stamp_ns = v->stamp_ns ? v->stamp_ns : session_now_ns();
    wire_refusal why = {.reason = WIRE_OK};
    int failed = 0;
    bool known = false;
    pthread_mutex_lock(&c->lock);
    const body_record *record = table_get(&c->bodies, body.id);
    known = record && !record->removed && record->announced.state == ANNOUNCE_ACKED;
    for (uint32_t first = 0; known && first < count && !failed; first += most, f.part++) {
        f.vertices = count - first < most ? count - first : most;
        failed = send_part(c, v, body, &f, first, room, stamp_ns, &why);
    }
    pthread_mutex_unlock(&c->lock);
    free(room);
    if (!known)
        return session_fail(c, COLLIDED_UNKNOWN_ID, "body %d is not known to the daemon yet: collided_sync", body.id);
    if (failed == 1) return session_fail(c, COLLIDED_BAD_ARGUMENT, "vertices: %s", why.text);
    return failed ? session_fail(c, COLLIDED_TRANSPORT, "the transport did not take the vertices") : COLLIDED_OK;
}

collided_status collided_publish_vertices(collided *c, collided_body body, const collided_vertices *vertices)
{
    return publish_frame(c, body, vertices, WIRE_SOFT_MOVE);
}

collided_status collided_propose_vertices(collided *c, collided_body body, const collided_vertices *vertices)
{
    return publish_frame(c, body, vertices, WIRE_SOFT_PROPOSE);
}

collided_status collided_teleport_vertices(collided *c, collided_body body, const collided_vertices *vertices)
{
    return publish_frame(c, body, vertices, WIRE_SOFT_TELEPORT);
}

/* ---- steps ---- */

struct soft_gathered {
    collided_soft_pair *pairs;
    size_t pair_count, pair_capacity;
    collided_feature *features;
    size_t feature_count, feature_capacity;
    size_t *first; /* of each pair, of its features */
    size_t first_capacity;
    char *names; /* of the pairs, in order: offsets are in name_at */
    size_t name_bytes, name_capacity;
    size_t *name_at;
    size_t name_at_capacity;
};

void soft_gathered_free(struct soft_gathered *g)
{
    if (!g) return;
    free(g->pairs), free(g->features), free(g->first), free(g->names), free(g->name_at);
    free(g);
}

static size_t keep_soft_name(struct soft_gathered *g, const char *name)
{
    size_t length = strlen(name) + 1, at = g->name_bytes;
    g->names = reserve(g->names, &g->name_capacity, at + length, 1);
    memcpy(g->names + at, name, length);
    g->name_bytes += length;
    return at;
}

/* What does not fit into one part goes on in the next, under the same head. */
static bool goes_on(const struct soft_gathered *g, const wire_soft_pair *p)
{
    if (!g->pair_count) return false;
    const collided_soft_pair *last = &g->pairs[g->pair_count - 1];
    const size_t *at = g->name_at + 2 * (g->pair_count - 1);
    return last->contact == p->contact && last->frame_a == p->frame_a && last->frame_b == p->frame_b &&
           last->proposed == ((p->flags & WIRE_SOFT_PROPOSED) != 0) && last->vertex_face == p->vertex_face &&
           last->edge_edge == p->edge_edge && strcmp(g->names + at[0], p->name_a) == 0 &&
           strcmp(g->names + at[1], p->name_b) == 0;
}

static void add_pair(struct soft_gathered *g, const wire_soft_pair *p)
{
    size_t n = g->pair_count++;
    g->pairs = reserve(g->pairs, &g->pair_capacity, n + 1, sizeof *g->pairs);
    g->first = reserve(g->first, &g->first_capacity, n + 1, sizeof *g->first);
    g->name_at = reserve(g->name_at, &g->name_at_capacity, 2 * n + 2, sizeof *g->name_at);
    g->name_at[2 * n] = keep_soft_name(g, p->name_a);
    g->name_at[2 * n + 1] = keep_soft_name(g, p->name_b);
    g->first[n] = g->feature_count;
    g->pairs[n] = (collided_soft_pair){.contact = p->contact,
        .frame_a = p->frame_a,
        .frame_b = p->frame_b,
        .shape_a = p->shape_a,
        .shape_b = p->shape_b,
        .proposed = (p->flags & WIRE_SOFT_PROPOSED) != 0,
        .unfinished = (p->flags & WIRE_SOFT_UNFINISHED) != 0,
        .vertex_face = p->vertex_face,
        .edge_edge = p->edge_edge,
        .face_shape = p->face_shape,
        .within = p->within,
        .undecided = p->undecided,
        .left_out = p->left_out,
        .safe_lo = p->safe_lo,
        .safe_hi = p->safe_hi};
}

static void add_feature(struct soft_gathered *g, const wire_soft_feature *f)
{
    size_t n = g->feature_count++;
    g->features = reserve(g->features, &g->feature_capacity, n + 1, sizeof *g->features);
    g->features[n] = (collided_feature){.kind = (collided_feature_kind)f->kind,
        .proof = (collided_feature_proof)f->proof,
        .a = f->a,
        .b = f->b,
        .t_lo = f->t_lo,
        .t_hi = f->t_hi};
    memcpy(g->features[n].normal, f->normal, sizeof f->normal);
    memcpy(g->features[n].bary, f->bary, sizeof f->bary);
}

size_t soft_gather(struct soft_gathered **in, const wire_message *const *parts, size_t part_count)
{
    if (!*in) *in = allocate(1, sizeof **in);
    struct soft_gathered *g = *in;
    g->pair_count = g->feature_count = g->name_bytes = 0;
    for (size_t k = 0; k < part_count; k++) {
        wire_soft_reader r;
        wire_soft_pair p;
        wire_soft_feature f;
        if (!wire_soft_read(parts[k]->event_batch.extensions, &r)) continue;
        while (wire_soft_next_pair(&r, &p)) {
            if (!goes_on(g, &p)) add_pair(g, &p);
            while (wire_soft_next_feature(&r, &f)) add_feature(g, &f);
        }
    }
    for (size_t i = 0; i < g->pair_count; i++) {
        size_t end = i + 1 < g->pair_count ? g->first[i + 1] : g->feature_count;
        g->pairs[i].name_a = g->names + g->name_at[2 * i];
        g->pairs[i].name_b = g->names + g->name_at[2 * i + 1];
        g->pairs[i].features = g->features ? g->features + g->first[i] : NULL;
        g->pairs[i].feature_count = end - g->first[i];
    }
    return g->pair_count;
}

void soft_deliver(const subscription_record *i, struct soft_gathered *g, const wire_event_batch *b)
{
    const collided_soft_steps steps = {.subscription = {i->id},
        .tick = b->tick,
        .stamp_ns = b->stamp_ns,
        .step = b->step,
        .pairs = g->pairs,
        .pair_count = g->pair_count};
    i->soft_callback(i->soft_context, &steps);
}
