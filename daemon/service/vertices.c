/* vertices: see vertices.h. A frame is whole or nothing: what lacks parts when the next one comes is dropped, answered
 * and counted. */
#include "vertices.h"

#include "clients.h"
#include "commands.h"
#include "geometries.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

size_t vertices_weight(size_t vertices)
{
    enum { LEAST = WORLD_SOFT_LEAST };
    return vertices > LEAST ? vertices : LEAST;
}

size_t vertices_of_body(service *s, const wire_body *b)
{
    if (b->removed || b->shape_types.count != 1 || b->shape_types.at[0] != WIRE_SHAPE_SOFT) return 0;
    const geometry *g = geometry_at(s, geometry_claimed(s, b->client, b->shape_geometries.at[0]));
    return vertices_weight(g && g->vertex_numbers > WIRE_SOFT_HEAD ? (g->vertex_numbers - WIRE_SOFT_HEAD) / 3 : 0);
}

static void free_parts(frame_parts *f)
{
    array_free(&f->has), array_free(&f->pieces), array_free(&f->vertices);
}

static void drop_coming(service *s, size_t i)
{
    free_parts(&s->vertices.coming.at[i]);
    s->vertices.coming.at[i] = s->vertices.coming.at[--s->vertices.coming.count];
}

/* ---- a whole frame ---- */

static void answer_frame(service *s, session *c, const frame_parts *f, wire_reason reason, const char *text)
{
    wire_refusal why;
    apply_refuse(&why, reason, "frame %" PRId64 ": %s", f->frame, text);
    apply_reject(s, c->link, WIRE_VERTEX_BATCH, c->client, f->sequence, f->body, &why);
}

static world_frame_status put_whole(service *s, const session *c, const frame_parts *f)
{
    const owned_body *b = session_body((session *)c, f->body);
    ARRAY(world_range) ranges = {0};
    for (size_t i = 0; i < f->pieces.count; i++) {
        const frame_piece *p = &f->pieces.at[i];
        const vec3 *at = p->count ? f->vertices.at + p->at : NULL;
        array_push(&ranges, ((world_range){p->first, p->count, at}));
    }
    const world_frame frame = {.frame = f->frame,
        .stamp_ns = f->stamp_ns,
        .mode = (world_frame_mode)f->mode,
        .ranges = ranges.at,
        .range_count = ranges.count};
    world_frame_status status =
        b && b->world_id != WORLD_NONE ? world_put_frame(s->world, b->world_id, &frame) : WORLD_FRAME_NOT_SOFT;
    array_free(&ranges);
    return status;
}

static wire_reason reason_of_frame(world_frame_status status, const char **text)
{
    switch (status) {
    case WORLD_FRAME_NOT_SOFT:
        *text = "there is no such soft body";
        return WIRE_UNKNOWN_BODY;
    case WORLD_FRAME_NO_VERTEX:
        *text = "a part goes beyond the vertices of the body";
        return WIRE_MALFORMED;
    case WORLD_FRAME_OLD:
        *text = "the body is at a newer one already; a teleport may go back";
        return WIRE_OLD_POSE;
    case WORLD_FRAME_CROWDED:
        *text = "8 proposals of the body wait already";
        return WIRE_LIMIT;
    default:
        *text = "";
        return WIRE_OK;
    }
}

static void note_stamps(service *s, session *c, const frame_parts *f)
{
    if (f->stamp_ns > s->latest_pose_ns) s->latest_pose_ns = f->stamp_ns;
    if (f->stamp_ns > c->latest_pose_ns) c->latest_pose_ns = f->stamp_ns;
    if (f->step) poses_note_step(s, c, f->step);
}

/* Of frames that wait for a step a body has so many, and vertices for so many whole ones. */
static bool may_hold(const service *s, const session *c, const frame_parts *f)
{
    enum { FRAMES_MOST = 64, WHOLE_MOST = 2 };
    const owned_body *b = session_body((session *)c, f->body);
    size_t frames = 0, vertices = f->vertices.count, all = b ? world_soft_vertices(s->world, b->world_id) : 0;
    for (size_t i = 0; i < s->vertices.held.count; i++) {
        const frame_parts *h = &s->vertices.held.at[i];
        if (h->client != f->client || h->body != f->body) continue;
        frames++;
        vertices += h->vertices.count;
    }
    return frames < FRAMES_MOST && vertices <= WHOLE_MOST * all;
}

static wire_reason whole(service *s, session *c, frame_parts *f, wire_refusal *why)
{
    if (c->lock_step > 0 && f->step > s->lock_step.done && f->mode != WORLD_FRAME_PROPOSES) {
        if (!may_hold(s, c, f))
            return apply_refuse(why, WIRE_LIMIT,
                "frame %" PRId64 ": frames of the body with two times its vertices, or 64, wait for their step already",
                f->frame);
        array_push(&s->vertices.held, *f);
        *f = (frame_parts){.client = 0};
        return WIRE_OK;
    }
    const char *text;
    wire_reason reason = reason_of_frame(put_whole(s, c, f), &text);
    if (reason != WIRE_OK) return apply_refuse(why, reason, "frame %" PRId64 ": %s", f->frame, text);
    note_stamps(s, c, f);
    return WIRE_OK;
}

void vertices_step(service *s, const session *c, int64_t step)
{
    size_t kept = 0;
    for (size_t i = 0; i < s->vertices.held.count; i++) {
        frame_parts f = s->vertices.held.at[i];
        if (f.client != c->client || f.step > step) {
            s->vertices.held.at[kept++] = f;
            continue;
        }
        const char *text;
        wire_reason reason = reason_of_frame(put_whole(s, c, &f), &text);
        if (f.stamp_ns > s->latest_pose_ns) s->latest_pose_ns = f.stamp_ns;
        if (reason != WIRE_OK) answer_frame(s, (session *)c, &f, reason, text);
        free_parts(&f);
    }
    s->vertices.held.count = kept;
}

/* ---- parts ---- */

static size_t find_coming(const service *s, int64_t client, int32_t body)
{
    size_t i = 0;
    for (; i < s->vertices.coming.count; i++)
        if (s->vertices.coming.at[i].client == client && s->vertices.coming.at[i].body == body) break;
    return i;
}

static void report_incomplete(service *s, session *c, const frame_parts *f)
{
    char text[128];
    snprintf(text, sizeof text, "%d of %d parts have come, and a later frame: it is dropped", f->come, f->parts);
    metric_count(s->count.incomplete_frames, 1);
    answer_frame(s, c, f, WIRE_MALFORMED, text);
}

static wire_reason check_part(
    service *s, session *c, const wire_vertex_batch *m, const wire_soft_frame *f, size_t *vertices, wire_refusal *why)
{
    const owned_body *b = session_body(c, m->body);
    *vertices = b && b->world_id != WORLD_NONE ? world_soft_vertices(s->world, b->world_id) : 0;
    if (!*vertices) return apply_refuse(why, WIRE_UNKNOWN_BODY, "body_id: %d is no soft body of this client", m->body);
    if (m->shape != 0) return apply_refuse(why, WIRE_MALFORMED, "shape is %d: a soft body has the shape 0", m->shape);
    if ((size_t)m->first_vertex > *vertices || f->vertices > *vertices - (size_t)m->first_vertex)
        return apply_refuse(why, WIRE_MALFORMED, "vertices %d to %" PRId64 ": the body has %zu", m->first_vertex,
            (int64_t)m->first_vertex + f->vertices - 1, *vertices);
    return WIRE_OK;
}

static void add_part(frame_parts *to, const wire_vertex_batch *m, const wire_soft_frame *f)
{
    array_push(&to->pieces, ((frame_piece){(uint32_t)m->first_vertex, f->vertices, to->vertices.count}));
    array_reserve(&to->vertices, to->vertices.count + f->vertices);
    for (uint32_t i = 0; i < f->vertices; i++) {
        double v[3];
        wire_soft_vertex(m, f, i, v);
        to->vertices.at[to->vertices.count++] = vec(v[0], v[1], v[2]);
    }
    to->has.at[f->part] = 1;
    to->come++;
    if (m->sequence > to->sequence) to->sequence = m->sequence;
    if (m->stamp_ns > to->stamp_ns) to->stamp_ns = m->stamp_ns;
}

static frame_parts parts_of_frame(const session *c, const wire_vertex_batch *m, const wire_soft_frame *f)
{
    frame_parts made = {
        .client = c->client, .frame = f->frame, .step = m->step, .body = m->body, .parts = f->parts, .mode = f->mode};
    array_reserve(&made.has, (size_t)f->parts);
    memset(made.has.at, 0, (size_t)f->parts);
    made.has.count = (size_t)f->parts;
    return made;
}

wire_reason vertices_put(service *s, session *c, const wire_vertex_batch *m, wire_refusal *why)
{
    wire_soft_frame f;
    size_t vertices;
    wire_soft_read_frame(m, &f); /* it has been checked */
    if (check_part(s, c, m, &f, &vertices, why) != WIRE_OK) return why->reason;
    if (f.parts > 1 && !f.frame)
        return apply_refuse(
            why, WIRE_MALFORMED, "a frame in %d parts has the number 0: at least 1 is allowed", f.parts);
    size_t i = find_coming(s, c->client, m->body);
    frame_parts *at = i < s->vertices.coming.count ? &s->vertices.coming.at[i] : NULL;
    bool same = at && at->frame == f.frame && at->parts == f.parts && at->mode == f.mode && f.parts > 1;
    if (at && !same && f.parts > 1 && f.frame < at->frame)
        return apply_refuse(
            why, WIRE_OLD_POSE, "frame %" PRId64 ": parts of frame %" PRId64 " have come", f.frame, at->frame);
    if (at && !same) {
        report_incomplete(s, c, at);
        drop_coming(s, i);
    }
    if (!same) {
        array_push(&s->vertices.coming, parts_of_frame(c, m, &f));
        i = s->vertices.coming.count - 1;
    }
    at = &s->vertices.coming.at[i];
    if (at->has.at[f.part]) {
        metric_count(s->count.duplicates, 1);
        return WIRE_OK;
    }
    if (at->vertices.count + f.vertices > vertices) {
        drop_coming(s, i);
        return apply_refuse(why, WIRE_TOO_LARGE, "frame %" PRId64 ": its parts have more than the body's %zu vertices",
            f.frame, vertices);
    }
    add_part(at, m, &f);
    if (at->come < at->parts) return WIRE_OK;
    wire_reason reason = whole(s, c, at, why);
    drop_coming(s, i);
    return reason;
}

void vertices_forget(service *s, int64_t client)
{
    for (size_t i = s->vertices.coming.count; i-- > 0;)
        if (s->vertices.coming.at[i].client == client) drop_coming(s, i);
    size_t kept = 0;
    for (size_t i = 0; i < s->vertices.held.count; i++) {
        if (s->vertices.held.at[i].client == client)
            free_parts(&s->vertices.held.at[i]);
        else
            s->vertices.held.at[kept++] = s->vertices.held.at[i];
    }
    s->vertices.held.count = kept;
}

void vertices_free_all(service *s)
{
    vertex_state *v = &s->vertices;
    for (size_t i = 0; i < v->coming.count; i++) free_parts(&v->coming.at[i]);
    for (size_t i = 0; i < v->held.count; i++) free_parts(&v->held.at[i]);
    array_free(&v->coming), array_free(&v->held);
    wire_soft_free(&v->writer);
    *v = (vertex_state){.writer = {.at = NULL}};
}

/* ---- for another daemon ---- */

static void put_parts(bytes_out *to, const frame_parts *f)
{
    bytes_put(to, f, sizeof *f);
    bytes_put(to, f->has.at, f->has.count);
    bytes_put(to, f->pieces.at, f->pieces.count * sizeof *f->pieces.at);
    bytes_put(to, f->vertices.at, f->vertices.count * sizeof *f->vertices.at);
}

static bool get_parts(bytes_in *from, frame_parts *f)
{
    if (!bytes_get(from, f, sizeof *f)) return false;
    size_t has = f->has.count, pieces = f->pieces.count, vertices = f->vertices.count;
    memset(&f->has, 0, sizeof f->has), memset(&f->pieces, 0, sizeof f->pieces);
    memset(&f->vertices, 0, sizeof f->vertices);
    if (has > from->left || pieces > from->left / sizeof(frame_piece) || vertices > from->left / sizeof(vec3))
        return false;
    array_reserve(&f->has, has + 1), array_reserve(&f->pieces, pieces + 1), array_reserve(&f->vertices, vertices + 1);
    f->has.count = has, f->pieces.count = pieces, f->vertices.count = vertices;
    bytes_get(from, f->has.at, has);
    bytes_get(from, f->pieces.at, pieces * sizeof *f->pieces.at);
    return bytes_get(from, f->vertices.at, vertices * sizeof *f->vertices.at);
}

void vertices_save(const service *s, bytes_out *to)
{
    bytes_put_count(to, s->vertices.coming.count);
    for (size_t i = 0; i < s->vertices.coming.count; i++) put_parts(to, &s->vertices.coming.at[i]);
    bytes_put_count(to, s->vertices.held.count);
    for (size_t i = 0; i < s->vertices.held.count; i++) put_parts(to, &s->vertices.held.at[i]);
}

const char *vertices_restore(service *s, bytes_in *from)
{
    for (int list = 0; list < 2; list++) {
        size_t count = bytes_get_count(from, sizeof(frame_parts));
        for (size_t i = 0; i < count; i++) {
            frame_parts f;
            if (!get_parts(from, &f)) return "a frame of vertices is cut off";
            if (list)
                array_push(&s->vertices.held, f);
            else
                array_push(&s->vertices.coming, f);
        }
    }
    return NULL;
}

/* ---- what steps came to ---- */

/* A part stays below 64 kB, as all of a stream do. */
enum { FEATURES_A_PART = 2048, PAIRS_A_PART = 64 };

typedef struct cursor {
    size_t pair, feature;
} cursor;

/* Where the part behind the one that begins there does. */
static cursor behind(const world_batch *b, cursor at)
{
    size_t features = 0, pairs = 0;
    while (at.pair < b->soft_count && pairs < PAIRS_A_PART) {
        size_t left = b->soft[at.pair].count - at.feature, room = FEATURES_A_PART - features;
        if (left > room) {
            at.feature += room;
            return at;
        }
        features += left;
        pairs++;
        at.pair++;
        at.feature = 0;
    }
    return at;
}

int32_t vertices_parts(const world_batch *b)
{
    int32_t parts = 0;
    for (cursor at = {0, 0}; at.pair < b->soft_count; at = behind(b, at)) parts++;
    return parts;
}

static void put_features(wire_soft_writer *w, const world_soft *of, size_t from, size_t to)
{
    for (size_t i = from; i < to; i++) {
        world_feature f = world_soft_feature(of, i);
        wire_soft_feature out = {.kind = f.kind, .proof = f.proof, .a = f.a, .b = f.b, .t_lo = f.t_lo, .t_hi = f.t_hi};
        memcpy(out.normal, f.normal, sizeof out.normal);
        memcpy(out.bary, f.bary, sizeof out.bary);
        wire_soft_put_feature(w, &out);
    }
}

wire_u8s vertices_part(service *s, const world_batch *b, int32_t i)
{
    wire_soft_writer *w = &s->vertices.writer;
    cursor at = {0, 0};
    for (int32_t k = 0; k < i; k++) at = behind(b, at);
    cursor end = behind(b, at);
    wire_soft_begin(w);
    for (; at.pair < end.pair || (at.pair == end.pair && at.feature < end.feature); at.pair++, at.feature = 0) {
        const world_soft *of = &b->soft[at.pair];
        size_t to = at.pair == end.pair ? end.feature : of->count;
        const wire_soft_pair pair = {.contact = of->contact,
            .frame_a = of->frame_a,
            .frame_b = of->frame_b,
            .shape_a = of->shape_a,
            .shape_b = of->shape_b,
            .flags = (uint8_t)((of->proposed ? WIRE_SOFT_PROPOSED : 0) | (of->unfinished ? WIRE_SOFT_UNFINISHED : 0)),
            .vertex_face = of->vertex_face,
            .edge_edge = of->edge_edge,
            .face_shape = of->face_shape,
            .within = of->within,
            .undecided = of->undecided,
            .left_out = of->left_out,
            .safe_lo = of->safe_lo,
            .safe_hi = of->safe_hi,
            .name_a = of->name_a,
            .name_b = of->name_b,
            .features = (uint32_t)(to - at.feature)};
        wire_soft_put_pair(w, &pair);
        put_features(w, of, at.feature, to);
        if (at.pair == end.pair) break;
    }
    return wire_soft_end(w);
}
