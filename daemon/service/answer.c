/* answer: queries of clients, answered from the world as the last tick left it. A query that comes twice is answered
 * twice. Tick thread. */
#include "answer_checks.h"
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "service.h"

#include "base/clock.h"
#include "base/log.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reply {
    service *s;
    struct link *to;
    wire_answer answer;
    char text[WIRE_TEXT_MAX + 1];
} reply;

static void send(reply *r)
{
    r->answer.text = r->text;
    metric_count(r->s->count.answers, 1);
    r->to->ops->publish(r->to, &(wire_message){.kind = WIRE_ANSWER, .answer = r->answer});
}

static void fail_query(reply *r, uint8_t status, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void fail_query(reply *r, uint8_t status, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    vsnprintf(r->text, sizeof r->text, format, args);
    va_end(args);
    r->answer.status = status;
    send(r);
}

/* ---- hits as arrays ---- */

static void copy_vec(double *at, vec3 v)
{
    at[0] = v.x;
    at[1] = v.y;
    at[2] = v.z;
}

static const char *name_of_body(const service *s, uint32_t body)
{
    const char *name = body == WORLD_NONE ? NULL : world_body_name(s->world, body);
    return name ? name : "";
}

/* What is said of a hit is that it is apart, or not. Hits without a measure have no width. */
static uint8_t achieved(const world_hit *h, double tolerance)
{
    if (tolerance > 0 && !(h->hi - h->lo <= tolerance)) return WIRE_WIDE;
    return h->lo > 0 || h->hi <= 0 ? WIRE_CERTAIN : WIRE_WITHIN;
}

static void send_hits(reply *r, const world_hits *hits, uint32_t n, const wire_query *asked)
{
    bool with_orientations = asked->kind == WIRE_QUERY_BODIES;
    wire_answer *a = &r->answer;
    const char **names = base_alloc(2 * (size_t)n + 1, sizeof *names);
    double *numbers = base_alloc(15 * (size_t)n + 1, sizeof *numbers);
    double *lo = numbers, *hi = lo + n, *axes = hi + n, *pa = axes + 3 * n, *pb = pa + 3 * n, *q = pb + 3 * n;
    int64_t *ages = base_alloc((size_t)n + 1, sizeof *ages);
    uint8_t *stale = base_alloc(2 * (size_t)n + 1, 1), *got = stale + n;
    for (uint32_t i = 0; i < n; i++) {
        const world_hit *h = &hits->at[i];
        names[i] = name_of_body(r->s, h->body_a);
        names[n + i] = name_of_body(r->s, h->body_b);
        lo[i] = h->stale ? -INFINITY : h->lo; /* a stale pose proves nothing */
        hi[i] = h->stale ? INFINITY : h->hi;
        copy_vec(axes + 3 * (size_t)i, h->axis);
        copy_vec(pa + 3 * (size_t)i, h->point_a);
        copy_vec(pb + 3 * (size_t)i, h->point_b);
        if (with_orientations) {
            quat o = world_body_pose(r->s->world, h->body_a).q;
            memcpy(q + 4 * (size_t)i, &o, sizeof o);
        }
        ages[i] = h->age_ns;
        stale[i] = h->stale;
        got[i] = h->stale ? WIRE_WIDE : achieved(h, asked->tolerance_m);
    }
    a->names_a = (wire_strings){n, names};
    a->names_b = (wire_strings){n, names + n};
    a->lo = (wire_f64s){n, lo};
    a->hi = (wire_f64s){n, hi};
    a->axes = (wire_f64s){3 * n, axes};
    a->points_a = (wire_f64s){3 * n, pa};
    a->points_b = (wire_f64s){3 * n, pb};
    a->orientations = (wire_f64s){with_orientations ? 4 * n : 0, q};
    a->ages_ns = (wire_i64s){n, ages};
    a->stale = (wire_u8s){n, stale};
    a->achieved = (wire_u8s){n, got};
    send(r);
    free(names);
    free(numbers);
    free(ages);
    free(stale);
}

/* ---- patience ---- */

/* How long a search may hold the tick, of this thread's own time; names are gone through without long steps. */
static const int64_t SEARCH_NS = 20000000, NAMES_NS = 40000000, CHECKS_NS = 5000000;

typedef struct patience {
    int64_t monotonic_ns; /* before then it cannot have had that much */
    int64_t thread_ns;
} patience;

static patience patience_for(const wire_query *q)
{
    int64_t ns = q->kind == WIRE_QUERY_BODIES ? NAMES_NS : q->kind == WIRE_QUERY_CHECK ? CHECKS_NS : SEARCH_NS;
    return (patience){clock_monotonic_ns() + ns, clock_thread_ns() + ns};
}

static bool has_patience(void *context)
{
    const patience *p = context;
    return clock_monotonic_ns() < p->monotonic_ns || clock_thread_ns() < p->thread_ns;
}

/* All in a box, or by name: what was found is true. Else it is no answer: nobody knows what else is nearer. */
static bool is_reported_in_part(const wire_query *q)
{
    return q->kind == WIRE_QUERY_BOX || q->kind == WIRE_QUERY_BODIES;
}

static void answer_hits(reply *r, world_hits *hits, const wire_query *q)
{
    uint32_t most = q->most > 0 && q->most < WIRE_ANSWERS_MAX ? (uint32_t)q->most : WIRE_ANSWERS_MAX;
    uint32_t n = hits->count < most ? (uint32_t)hits->count : most;
    size_t all = hits->count + hits->left_out;
    if (hits->gave_up) metric_count(r->s->count.queries_cut, 1);
    if (hits->gave_up && !is_reported_in_part(q)) {
        array_free(hits);
        fail_query(r, WIRE_ANSWER_UNSUPPORTED,
            "the search was given up after %.0f ms, so that nobody waits for it: ask for less (a shorter length, a "
            "smaller box, fewer bodies, a coarser tolerance)",
            1e-6 * (double)SEARCH_NS);
        return;
    }
    if (n < all || hits->gave_up) {
        r->answer.status = WIRE_ANSWER_TRUNCATED;
        snprintf(r->text, sizeof r->text, "%zu hits, %u of them told%s", all, n,
            hits->gave_up ? "; the search took too long, and there may be more" : "");
    }
    send_hits(r, hits, n, q);
    array_free(hits);
}

/* ---- kinds ---- */

static vec3 vec_of(wire_f64s numbers)
{
    return numbers.count == 3 ? vec(numbers.at[0], numbers.at[1], numbers.at[2]) : VEC_ZERO;
}

static pose pose_of(const wire_query *q)
{
    pose at = {vec_of(q->origin), {1, 0, 0, 0}};
    if (q->orientation.count == 4) memcpy(&at.q, q->orientation.at, sizeof at.q);
    return at;
}

static bool two_bodies(reply *r, const wire_query *q, uint32_t *a, uint32_t *b)
{
    *a = world_find_body(r->s->world, q->name_a);
    *b = world_find_body(r->s->world, q->name_b);
    if (*a != WORLD_NONE && *b != WORLD_NONE) return true;
    fail_query(r, WIRE_ANSWER_UNKNOWN_NAME, "no body is named \"%.200s\"", *a == WORLD_NONE ? q->name_a : q->name_b);
    return false;
}

/* Near the body that name_a names, or near a box. With no number asked for, one too many tells that there are more. */
static bool nearest(reply *r, const wire_query *q, world_hits *hits)
{
    service *s = r->s;
    size_t most = q->most > 0 ? (size_t)q->most : WIRE_ANSWERS_MAX + 1;
    if (!*q->name_a) {
        world_query_nearest(s->world, pose_of(q), vec_of(q->half), q->length_m, most, q->tolerance_m, s->now_ns, hits);
        return true;
    }
    uint32_t body = world_find_body(s->world, q->name_a);
    if (body != WORLD_NONE)
        world_query_nearest_to(s->world, body, q->length_m, most, q->tolerance_m, s->now_ns, hits);
    else
        fail_query(r, WIRE_ANSWER_UNKNOWN_NAME, "no body is named \"%.200s\"", q->name_a);
    return body != WORLD_NONE;
}

static bool sweep_body(reply *r, const wire_query *q, world_hits *hits)
{
    service *s = r->s;
    uint32_t body = world_find_body(s->world, q->name_a);
    bool sane = vec_norm(vec_of(q->angular)) * q->span_s <= MOTION_ANGLE_MAX;
    if (body == WORLD_NONE)
        fail_query(r, WIRE_ANSWER_UNKNOWN_NAME, "no body is named \"%.200s\"", q->name_a);
    else if (!sane)
        fail_query(r, WIRE_ANSWER_UNSUPPORTED, "angular, span_s: it would turn by more than %g rad", MOTION_ANGLE_MAX);
    else
        world_query_sweep(
            s->world, body, vec_of(q->linear), vec_of(q->angular), q->span_s, q->tolerance_m, s->now_ns, hits);
    return body != WORLD_NONE && sane;
}

/* Other queries change nothing; this one may do so once only: a copy of it is answered like the first. */
static bool was_carried_out(reply *r, const wire_query *q)
{
    const record_wish *last = &r->s->record_wish;
    if (last->client != q->client || q->sequence > last->sequence) return false;
    if (q->sequence == last->sequence && r->s->record_reply.to) return true; /* it comes */
    if (q->sequence == last->sequence)
        fail_query(r, last->status, "%s", last->text);
    else
        fail_query(r, WIRE_ANSWER_UNSUPPORTED, "of what this client has said of recordings since, it is an older word");
    return true;
}

static void record(reply *r, const wire_query *q)
{
    service *s = r->s;
    char path[2 * CONFIG_TEXT_MAX], why[CONFIG_TEXT_MAX + 256];
    if (!*q->name_a && !s->recording_to) {
        fail_query(r, WIRE_ANSWER_UNSUPPORTED, "nothing is being recorded: it was not begun, or the disk refused it");
    } else if (!*q->name_a && !record_may_end(s, q->client, why, sizeof why)) {
        log_notice("client %016" PRIx64 " may not end the recording: %s", (uint64_t)q->client, why);
        metric_count(s->count.records_refused, 1);
        fail_query(r, WIRE_ANSWER_UNSUPPORTED, "%s", why);
    } else if (!*q->name_a) {
        record_stop(s);
        answer_owed(s); /* an earlier one */
        snprintf(r->text, sizeof r->text, "recording ended");
        s->record_reply = (record_reply){.to = r->to, .answer = r->answer};
    } else if (!*s->config.record_dir) {
        fail_query(
            r, WIRE_ANSWER_UNSUPPORTED, "the daemon was started without record_dir: it does not let clients record");
    } else if (strchr(q->name_a, '/') || q->name_a[0] == '.') {
        fail_query(r, WIRE_ANSWER_UNSUPPORTED, "a recording needs a plain name, without '/' and not starting with '.'");
    } else {
        snprintf(path, sizeof path, "%s/%s.lcmlog", s->config.record_dir, q->name_a);
        if (record_start(s, path, &q->client, why, sizeof why) != 0) {
            log_notice("client %016" PRIx64 " may not record: %s", (uint64_t)q->client, why);
            metric_count(s->count.records_refused, 1);
            fail_query(r, WIRE_ANSWER_UNSUPPORTED, "%s", why);
        } else {
            answer_owed(s); /* an earlier one */
            snprintf(r->text, sizeof r->text, "%s", path);
            s->record_reply = (record_reply){.to = r->to, .answer = r->answer};
        }
    }
}

static const owned_body *body_named(const service *s, const char *name)
{
    uint32_t id = world_find_body(s->world, name);
    for (size_t i = 0; id != WORLD_NONE && i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        for (size_t k = 0; k < c->bodies.count; k++)
            if (c->bodies.at[k].world_id == id) return &c->bodies.at[k];
    }
    return NULL;
}

/* A piece of a geometry, by the body that has it and by the hash under which its client sent it: as a record. */
static void send_geometry(reply *r, const wire_query *q)
{
    service *s = r->s;
    char *end;
    int64_t hash = (int64_t)strtoull(q->name_b, &end, 16);
    const owned_body *b = body_named(s, q->name_a);
    const geometry *g = NULL;
    for (size_t i = 0; b && i < b->geometries.count && !g; i++) {
        const geometry *at = geometry_at(s, b->geometries.at[i]);
        if (at && at->hash == hash) g = at;
    }
    if (!b || !g || *end || !*q->name_b || !g->vertices) {
        fail_query(r, WIRE_ANSWER_UNKNOWN_NAME, "\"%.127s\" has no geometry \"%.64s\"", q->name_a, q->name_b);
        return;
    }
    if (q->most >= g->pieces) {
        fail_query(r, WIRE_ANSWER_UNKNOWN_NAME, "most: it has %d pieces, from 0 on", g->pieces);
        return;
    }
    geometry_share share = geometry_share_of(g, q->most);
    const uint32_t octets = (uint32_t)(1 + 8 + 4 * 4 + 8 * share.vertices + 4 * share.indices);
    const int32_t counts[4] = {(int32_t)g->vertex_numbers, (int32_t)g->index_numbers, q->most, g->pieces};
    const uint32_t head[2] = {WIRE_EXTENSION_GEOMETRY, octets};
    bytes_out out = {0};
    bytes_put(&out, head, sizeof head);
    bytes_put(&out, &g->kind, 1);
    bytes_put(&out, &g->hash, sizeof g->hash);
    bytes_put(&out, counts, sizeof counts);
    bytes_put(&out, g->vertices + share.first_vertex, share.vertices * sizeof *g->vertices);
    bytes_put(&out, g->indices + share.first_index, share.indices * sizeof *g->indices);
    r->answer.extensions = (wire_u8s){(uint32_t)out.count, out.at};
    send(r);
    array_free(&out);
}

static void send_checks(reply *r, const wire_query *q, patience *p)
{
    check_answer_record done;
    world_check_patience patient = {has_patience, p};
    if (!answer_checks(r->s, q, &patient, &done, r->text, sizeof r->text)) {
        r->answer.status = WIRE_ANSWER_UNSUPPORTED;
        send(r);
        return;
    }
    r->answer.extensions = (wire_u8s){(uint32_t)done.record.count, done.record.at};
    r->answer.names_a = (wire_strings){done.name_count, done.names};
    if (done.cut) metric_count(r->s->count.queries_cut, 1);
    send(r);
    array_free(&done.record);
    free(done.names);
}

void answer_owed(service *s)
{
    record_reply *owed = &s->record_reply;
    if (!owed->to) return;
    owed->answer.text = s->record_wish.text;
    metric_count(s->count.answers, 1);
    owed->to->ops->publish(owed->to, &(wire_message){.kind = WIRE_ANSWER, .answer = owed->answer});
    owed->to->ops->flush(owed->to);
    owed->to = NULL;
}

void answer_query(service *s, struct link *from, const wire_query *q)
{
    reply r;
    patience p = patience_for(q);
    world_hits hits = {.go_on = has_patience, .go_on_context = &p, .most = WIRE_ANSWERS_MAX};
    uint32_t a, b;
    r = (reply){.s = s,
        .to = from,
        .answer = {.version = WIRE_VERSION,
            .client = q->client,
            .sequence = q->sequence,
            .epoch = s->epoch,
            .tick = s->tick,
            .stamp_ns = s->now_ns,
            .kind = q->kind}};
    switch (q->kind) {
    case WIRE_QUERY_DISTANCE:
        if (!two_bodies(&r, q, &a, &b)) return;
        world_query_distance(s->world, a, b, q->tolerance_m, s->now_ns, &hits);
        if (hits.count == 0 && !hits.gave_up) {
            fail_query(&r, WIRE_ANSWER_UNSUPPORTED, "distances of soft bodies are not told by this release");
            return;
        }
        break;
    case WIRE_QUERY_RAY:
        world_query_ray(
            s->world, vec_of(q->origin), vec_of(q->direction), q->length_m, q->tolerance_m, s->now_ns, &hits);
        break;
    case WIRE_QUERY_CAST:
        world_query_cast(
            s->world, pose_of(q), vec_of(q->half), vec_of(q->direction), q->length_m, q->tolerance_m, s->now_ns, &hits);
        break;
    case WIRE_QUERY_NEAREST:
        if (!nearest(&r, q, &hits)) return;
        break;
    case WIRE_QUERY_SWEEP:
        if (!sweep_body(&r, q, &hits)) return;
        break;
    case WIRE_QUERY_BOX:
        world_query_box(s->world, pose_of(q), vec_of(q->half), s->now_ns, &hits);
        break;
    case WIRE_QUERY_BODIES:
        world_query_bodies(s->world, q->name_a, s->now_ns, &hits);
        break;
    case WIRE_QUERY_EXPLAIN:
        if (!two_bodies(&r, q, &a, &b)) return;
        world_explain_within(s->world, a, b, s->now_ns, &hits, r.text, sizeof r.text);
        send(&r);
        return;
    case WIRE_QUERY_GEOMETRY:
        send_geometry(&r, q);
        return;
    case WIRE_QUERY_CHECK:
        send_checks(&r, q, &p);
        return;
    case WIRE_QUERY_RECORD:
        if (was_carried_out(&r, q)) return;
        record(&r, q);
        s->record_wish = (record_wish){.client = q->client, .sequence = q->sequence, .status = r.answer.status};
        memcpy(s->record_wish.text, r.text, sizeof r.text);
        if (!s->record_ends.count && !s->record_next) answer_owed(s);
        return;
    default:
        fail_query(&r, WIRE_ANSWER_UNSUPPORTED, "this kind of query is not supported by this release");
        return;
    }
    answer_hits(&r, &hits, q);
}
