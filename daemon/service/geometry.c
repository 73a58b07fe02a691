/* geometry: hulls, meshes and height fields. Content is known by the numbers themselves: a hash is what a client calls
 * it by, and what one client sends under a hash neither changes nor hinders what another sends under the same. While it
 * comes it belongs to its client; when its last piece has come it is compared with what is there, and shared if it is
 * the same number by number, or else built: at once what is small, the rest by the threads of builds.c, compared and
 * hashed there. When a build is put off, and when it is over, is a command that is recorded. It goes when no body holds
 * it and nobody claims it. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "service.h"
#include "standby.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TAKEN_BACK_KEPT = 4096 }; /* hashes that a client's session remembers, against late copies */

static geometry *find(const service *s, int64_t id)
{
    uint32_t place = id ? pair_map_get(&s->geometry_of, (uint64_t)id) : PAIR_MAP_NONE;
    return place == PAIR_MAP_NONE ? NULL : &s->geometries.at[place];
}

const geometry *geometry_at(const service *s, int64_t id)
{
    return find(s, id);
}

static bool is_ready(const geometry *g)
{
    return g->hull || g->mesh || g->soft;
}

static wire_reason refuse_piece(wire_refusal *why, wire_reason reason, const char *text)
{
    why->reason = reason;
    snprintf(why->text, sizeof why->text, "%s", text);
    return reason;
}

int64_t geometry_bytes(int64_t vertex_numbers, int64_t index_numbers)
{
    return vertex_numbers * (int64_t)sizeof(double) + index_numbers * (int64_t)sizeof(int32_t);
}

/* ---- who means what by a hash ---- */

static geometry_claim *own_claim(const session *c, int64_t hash)
{
    uint32_t place = hash ? pair_map_get(&c->claim_of, (uint64_t)hash) : PAIR_MAP_NONE;
    return place == PAIR_MAP_NONE ? NULL : &c->claims.at[place];
}

static geometry_claim *find_claim(service *s, int64_t client, int64_t hash)
{
    const session *c = session_find(s, client);
    return c ? own_claim(c, hash) : NULL;
}

int64_t geometry_claimed(service *s, int64_t client, int64_t hash)
{
    const geometry_claim *c = find_claim(s, client, hash);
    return c ? c->geometry : 0;
}

static int64_t bytes_of_geometry(const geometry *g)
{
    return geometry_bytes((int64_t)g->vertex_numbers, (int64_t)g->index_numbers);
}

/* Its entries go that claim nothing. */
static void forget_taken_back(session *c)
{
    size_t kept = 0;
    for (size_t i = 0; i < c->claims.count; i++) {
        const geometry_claim at = c->claims.at[i];
        if (at.geometry) {
            pair_map_put(&c->claim_of, (uint64_t)at.hash, (uint32_t)kept);
            c->claims.at[kept++] = at;
        } else {
            pair_map_remove(&c->claim_of, (uint64_t)at.hash);
        }
    }
    c->claims.count = kept;
    c->geometries_taken_back = 0;
}

/* The client's entry under that hash; a new one claims nothing. */
static geometry_claim *claim_of(session *c, int64_t hash)
{
    geometry_claim *there = own_claim(c, hash);
    if (there) return there;
    if (c->geometries_taken_back >= TAKEN_BACK_KEPT) forget_taken_back(c);
    pair_map_put(&c->claim_of, (uint64_t)hash, (uint32_t)c->claims.count);
    array_push(&c->claims, ((geometry_claim){.client = c->client, .hash = hash}));
    c->geometries_taken_back++;
    return &c->claims.at[c->claims.count - 1];
}

static void claim(session *c, geometry *g)
{
    claim_of(c, g->hash)->geometry = g->id;
    c->geometries_taken_back--;
    g->claims++;
    c->geometry_count++;
    c->geometry_bytes += bytes_of_geometry(g);
}

/* What it was for goes at the next sweep, if nobody else wants it. */
static void disclaim(service *s, session *c, geometry_claim *at)
{
    geometry *g = find(s, at->geometry);
    if (!g) return;
    c->geometry_count--;
    c->geometry_bytes -= bytes_of_geometry(g);
    c->geometries_taken_back++;
    g->claims--;
    s->geometries_loose = true;
    at->geometry = 0;
}

/* ---- the store ---- */

static void own_numbers(geometry *g, geometry_numbers *n)
{
    g->numbers = n;
    g->vertices = n->vertices;
    g->indices = n->indices;
}

static geometry *add_geometry(service *s, session *c, const wire_geometry *m)
{
    size_t place = s->geometry_hint;
    while (place < s->geometries.count && s->geometries.at[place].id) place++;
    if (place == s->geometries.count) array_push(&s->geometries, (geometry){.id = 0});
    s->geometry_hint = place + 1;
    geometry *g = &s->geometries.at[place];
    *g = (geometry){.id = ++s->geometry_last,
        .hash = m->hash,
        .same = PAIR_MAP_NONE,
        .kind = m->kind,
        .pieces = m->pieces,
        .client = c->client,
        .vertex_numbers = (size_t)m->vertex_numbers,
        .index_numbers = (size_t)m->index_numbers};
    own_numbers(g, geometry_numbers_create(m->kind, m->hash, g->vertex_numbers, g->index_numbers));
    g->has = base_zalloc((size_t)m->pieces, 1);
    pair_map_put(&s->geometry_of, (uint64_t)g->id, (uint32_t)place);
    claim(c, g);
    return g;
}

/* All of it has come. */
static void enter_whole(service *s, geometry *g)
{
    if (!g->completed) g->completed = ++s->geometries_completed;
    g->same = pair_map_get(&s->geometry_whole, (uint64_t)g->hash);
    pair_map_put(&s->geometry_whole, (uint64_t)g->hash, (uint32_t)(g - s->geometries.at));
}

static void leave_whole(service *s, const geometry *g)
{
    uint32_t place = (uint32_t)(g - s->geometries.at), at = pair_map_get(&s->geometry_whole, (uint64_t)g->hash);
    if (at == place && g->same == PAIR_MAP_NONE)
        pair_map_remove(&s->geometry_whole, (uint64_t)g->hash);
    else if (at == place)
        pair_map_put(&s->geometry_whole, (uint64_t)g->hash, g->same);
    else
        for (; at != PAIR_MAP_NONE; at = s->geometries.at[at].same)
            if (s->geometries.at[at].same == place) s->geometries.at[at].same = g->same;
}

static void end_building(service *s, geometry *g)
{
    s->geometries_building -= g->is_building;
    g->is_building = false;
    g->build = NULL;
}

static void drop_geometry(service *s, geometry *g)
{
    size_t place = (size_t)(g - s->geometries.at);
    if (g->completed) leave_whole(s, g);
    builds_abandon(s->builds, g->build);
    end_building(s, g);
    pair_map_remove(&s->geometry_of, (uint64_t)g->id);
    free(g->has);
    builds_free(s->builds, g->numbers, g->hull, g->mesh, g->soft);
    *g = (geometry){.id = 0};
    if (place < s->geometry_hint) s->geometry_hint = place;
}

/* What was mended is worth a warning, and so is a surface where a solid may have been meant. */
static void report_findings(const geometry *g)
{
    char text[512];
    const mesh_findings *f = &g->mesh->found;
    mesh_describe(g->mesh, text, sizeof text);
    bool mended = f->zero_area || f->needles || f->repeated || f->turned || f->inside_out;
    if (!g->mesh->solid || mended || f->shared_edges)
        log_warning("mesh %016" PRIx64 " is %s", (uint64_t)g->hash, text);
    else
        log_info("mesh %016" PRIx64 " is %s", (uint64_t)g->hash, text);
}

static void report_ready(const geometry *g)
{
    if (g->kind == WIRE_GEOMETRY_MESH) report_findings(g);
    if (g->kind == WIRE_GEOMETRY_SOFT)
        log_info("soft surface %016" PRIx64 " has %zu vertices, %zu edges and %zu triangles, %zu kB", (uint64_t)g->hash,
            soft_mesh_vertex_count(g->soft), soft_mesh_edge_count(g->soft), soft_mesh_triangle_count(g->soft),
            soft_mesh_bytes(g->soft) / 1000);
    if (g->kind == WIRE_GEOMETRY_HEIGHT_FIELD)
        log_info("height field %016" PRIx64 " has %u rows and %u columns", (uint64_t)g->hash, g->mesh->rows,
            g->mesh->columns);
}

/* The one that was completed first, whose numbers are the same. */
static geometry *find_equal(const service *s, const geometry *like)
{
    geometry *first = NULL;
    uint32_t at = pair_map_get(&s->geometry_whole, (uint64_t)like->hash);
    for (; at != PAIR_MAP_NONE; at = s->geometries.at[at].same) {
        geometry *g = &s->geometries.at[at];
        if ((!first || g->completed < first->completed) && geometry_numbers_equal(g->numbers, like->numbers)) first = g;
    }
    return first;
}

/* ---- building beside the tick ---- */

/* What takes a millisecond or so is built at once, and so much of it in a tick. */
static const uint64_t AT_ONCE_UNITS = 96, AT_ONCE_IN_A_TICK = 768;

/* Those of the same hash make it longer: it is compared with each. */
static uint64_t units_of(const service *s, const geometry *g)
{
    uint64_t units = build_cost_of(g->kind, g->vertex_numbers, g->index_numbers).units;
    uint32_t at = pair_map_get(&s->geometry_whole, (uint64_t)g->hash);
    for (; at != PAIR_MAP_NONE && units <= AT_ONCE_UNITS; at = s->geometries.at[at].same) units++;
    return units;
}

/* Another daemon has decided: the one that is followed, or the one that made the recording. */
static bool is_reported(const service *s)
{
    return s->replaying || standby_waits(s);
}

static bool is_reported_later(const service *s, int64_t client, int64_t hash)
{
    for (size_t i = 0; i < s->reported_builds.count; i++) {
        const reported_build *t = &s->reported_builds.at[i];
        if (!t->ready && t->client == client && t->hash == hash) return true;
    }
    return false;
}

static void report_build(service *s, int64_t client, int64_t hash, bool ready)
{
    record_build(s, client, hash, ready);
    standby_journal_build(s, client, hash, ready);
}

static bool comes_later(service *s, const session *c, const geometry *g)
{
    if (is_reported(s)) {
        bool later = is_reported_later(s, c->client, g->hash);
        if (later) report_build(s, c->client, g->hash, false);
        return later;
    }
    uint64_t units = units_of(s, g);
    bool now = units <= AT_ONCE_UNITS && s->built_units + units <= AT_ONCE_IN_A_TICK;
    if (now)
        s->built_units += units;
    else
        report_build(s, c->client, g->hash, false);
    return !now;
}

static int compare_older(const void *a, const void *b)
{
    const geometry *const *x = a, *const *y = b;
    return ((*x)->completed > (*y)->completed) - ((*x)->completed < (*y)->completed);
}

static const char *name_of_sender(service *s, const geometry *g)
{
    const session *c = session_find(s, g->client);
    return c ? c->name : "";
}

/* With those of the same hash that were completed before it, in that order. */
static build *begin_build(service *s, geometry *g)
{
    ARRAY(const geometry *) found = {0};
    uint32_t at = pair_map_get(&s->geometry_whole, (uint64_t)g->hash);
    for (; at != PAIR_MAP_NONE; at = s->geometries.at[at].same) {
        const geometry *other = &s->geometries.at[at];
        if (other->completed < g->completed) array_push(&found, other);
    }
    if (found.count) qsort(found.at, found.count, sizeof *found.at, compare_older);
    older_geometry *older = base_alloc(found.count + 1, sizeof *older);
    for (size_t i = 0; i < found.count; i++) older[i] = (older_geometry){found.at[i]->id, found.at[i]->numbers};
    size_t count = found.count;
    array_free(&found);
    return g->build = builds_add(s->builds, g->client, name_of_sender(s, g), g->id, g->numbers, older, count);
}

static void build_later(service *s, geometry *g)
{
    enter_whole(s, g);
    g->is_building = true;
    s->geometries_building++;
    begin_build(s, g);
}

geometry_state geometry_state_of(service *s, int64_t client, int64_t hash)
{
    const geometry *g = find(s, geometry_claimed(s, client, hash));
    if (!g) return GEOMETRY_MISSING;
    return is_ready(g) ? GEOMETRY_READY : g->is_building ? GEOMETRY_BUILDING : GEOMETRY_MISSING;
}

/* What one of its claimants sent last has its answer. */
static void answer_claim(service *s, geometry_claim *at, const wire_refusal *why)
{
    session *c = session_find(s, at->client);
    int64_t sequence = at->unanswered;
    at->unanswered = 0;
    if (!c || !sequence) return;
    if (why->reason == WIRE_OK)
        session_ack(c, sequence);
    else
        apply_reject(s, c->link, WIRE_GEOMETRY, c->client, sequence, -1, why);
}

static void refuse_claim(service *s, geometry_claim *at, const wire_refusal *why)
{
    session *c = session_find(s, at->client);
    answer_claim(s, at, why);
    if (c) disclaim(s, c, at);
    at->sequence = 0; /* a copy is refused, too */
    at->leaves = false;
}

/* What that client means by its hash, if it is this one. */
static geometry_claim *claim_on(const session *c, const geometry *g)
{
    geometry_claim *at = own_claim(c, g->hash);
    return at && at->geometry == g->id ? at : NULL;
}

/* Those who mean it mean the other one from now on, or nothing. */
static void move_claims(service *s, geometry *from, geometry *to)
{
    static const wire_refusal fine = {WIRE_OK, ""};
    for (size_t i = 0; i < s->sessions.count; i++) {
        geometry_claim *at = claim_on(s->sessions.at[i], from);
        if (!at) continue;
        at->geometry = to->id;
        to->claims++;
        from->claims--;
        if (is_ready(to)) answer_claim(s, at, &fine);
    }
}

static void answer_claims(service *s, geometry *g, const wire_refusal *why)
{
    for (size_t i = 0; i < s->sessions.count; i++) {
        geometry_claim *at = claim_on(s->sessions.at[i], g);
        if (!at) continue;
        if (why->reason == WIRE_OK)
            answer_claim(s, at, why);
        else
            refuse_claim(s, at, why);
    }
}

/* Its build is over. */
static void take_build(service *s, geometry *g)
{
    built b;
    builds_end(s->builds, g->build, &b);
    g->build = NULL;
    geometry *same = b.same ? find(s, b.same) : NULL;
    if (b.same && !same) { /* nobody wants that one any more: this one has to be built all the same */
        begin_build(s, g);
        return;
    }
    end_building(s, g);
    s->hull_came = true;
    if (same) {
        move_claims(s, g, same);
        drop_geometry(s, g);
        return;
    }
    g->hull = b.hull;
    g->mesh = b.mesh;
    g->soft = b.soft;
    answer_claims(s, g, &b.why);
    if (is_ready(g))
        report_ready(g);
    else
        drop_geometry(s, g);
}

/* Who means it, of several the first: so it is called in recordings. NULL: nobody. */
static const geometry_claim *claimant_of(service *s, const geometry *g)
{
    const geometry_claim *own = find_claim(s, g->client, g->hash);
    if (own && own->geometry == g->id) return own;
    for (size_t i = 0; i < s->sessions.count; i++)
        if ((own = claim_on(s->sessions.at[i], g)) != NULL) return own;
    return NULL;
}

static void take_ready(service *s)
{
    build *ready;
    while (builds_ready(s->builds) && (ready = builds_take(s->builds)) != NULL) {
        geometry *g = find(s, build_of(ready));
        const geometry_claim *by = claimant_of(s, g); /* it has some: who wants nothing has no build */
        report_build(s, by->client, by->hash, true);
        take_build(s, g);
    }
}

static void take_reported(service *s)
{
    for (size_t i = 0; i < s->reported_builds.count; i++) {
        const reported_build t = s->reported_builds.at[i];
        geometry *g = t.ready ? find(s, geometry_claimed(s, t.client, t.hash)) : NULL;
        if (!g || !g->build) continue; /* of a recording that was begun without its state */
        report_build(s, t.client, t.hash, true);
        builds_wait(s->builds, g->build, s->on_waiting, s->on_waiting_context);
        take_build(s, g);
    }
}

void geometry_builds_end(service *s)
{
    s->built_units = 0;
    if (is_reported(s))
        take_reported(s);
    else if (!s->poses_only)
        take_ready(s);
}

void geometry_report(service *s, int64_t client, int64_t hash, bool ready)
{
    array_push(&s->reported_builds, ((reported_build){client, hash, ready}));
}

/* ---- pieces ---- */

/* All pieces have come: it is shared with who sent the same before, or built, now or later. Refused, it is gone with
 * its claim. */
static wire_reason complete(service *s, geometry *g, session *c, wire_refusal *why)
{
    free(g->has);
    g->has = NULL;
    if (comes_later(s, c, g)) {
        build_later(s, g);
        return WIRE_OK;
    }
    geometry *there = find_equal(s, g);
    s->hull_came = true;
    if (there) {
        find_claim(s, c->client, g->hash)->geometry = there->id;
        there->claims++;
        g->claims--;
        drop_geometry(s, g);
        return WIRE_OK;
    }
    built b;
    build_now(g->numbers, &b);
    if (b.why.reason != WIRE_OK) {
        *why = b.why;
        geometry_claim *refused = find_claim(s, c->client, g->hash);
        disclaim(s, c, refused);
        refused->sequence = 0; /* a copy is refused, too */
        drop_geometry(s, g);
        return why->reason;
    }
    g->hull = b.hull;
    g->mesh = b.mesh;
    g->soft = b.soft;
    enter_whole(s, g);
    report_ready(g);
    return WIRE_OK;
}

geometry_share geometry_share_of(const geometry *g, int32_t piece)
{
    size_t first = (size_t)piece * WIRE_PIECE_MAX, whole = g->vertex_numbers + g->index_numbers;
    size_t end = whole - first < WIRE_PIECE_MAX ? whole : first + WIRE_PIECE_MAX, v = g->vertex_numbers;
    geometry_share share = {.first_vertex = first < v ? first : v, .first_index = first < v ? 0 : first - v};
    share.vertices = (end < v ? end : v) - share.first_vertex;
    share.indices = end - first - share.vertices;
    return share;
}

/* Pieces may come in any order and more than once; what comes again must be the same. */
static wire_reason put_piece(service *s, session *c, geometry *g, const wire_geometry *m, wire_refusal *why)
{
    if (m->kind != g->kind || m->pieces != g->pieces || (size_t)m->vertex_numbers != g->vertex_numbers ||
        (size_t)m->index_numbers != g->index_numbers)
        return refuse_piece(why, WIRE_MALFORMED, "pieces: they do not belong to one geometry");
    geometry_share share = geometry_share_of(g, m->piece);
    if (m->vertices.count != share.vertices || m->indices.count != share.indices)
        return refuse_piece(why, WIRE_MALFORMED, "pieces: one does not hold its share of the whole");
    size_t v = share.vertices * sizeof *g->vertices, i = share.indices * sizeof *g->indices;
    bool has = !g->has || g->has[m->piece];
    bool other = has && ((v && memcmp(g->vertices + share.first_vertex, m->vertices.at, v) != 0) ||
                            (i && memcmp(g->indices + share.first_index, m->indices.at, i) != 0));
    if (other) return refuse_piece(why, WIRE_BAD_HASH, "hash: you have sent other content under it");
    if (has) return WIRE_OK;
    if (v) memcpy(g->vertices + share.first_vertex, m->vertices.at, v);
    if (i) memcpy(g->indices + share.first_index, m->indices.at, i);
    g->come++;
    g->has[m->piece] = 1;
    return g->come == g->pieces ? complete(s, g, c, why) : WIRE_OK;
}

/* So large a hull, mesh or height field is refused at its first piece, before memory is set aside for it. Each height
 * brings about two triangles. */
static wire_reason check_size(const wire_geometry *m, wire_refusal *why)
{
    bool mesh = m->kind == WIRE_GEOMETRY_MESH, field = m->kind == WIRE_GEOMETRY_HEIGHT_FIELD;
    int32_t numbers = mesh ? m->index_numbers : m->vertex_numbers;
    int32_t most = mesh    ? 3 * MESH_TRIANGLES_MAX
                   : field ? WIRE_FIELD_HEAD + MESH_TRIANGLES_MAX / 2
                           : 3 * HULL_VERTICES_MAX;
    if (numbers <= most) return WIRE_OK;
    if (mesh)
        snprintf(why->text, sizeof why->text, "index_numbers: a mesh has at most %d triangles", MESH_TRIANGLES_MAX);
    else if (field)
        snprintf(why->text, sizeof why->text, "vertex_numbers: a height field has at most %d triangles, two a cell",
            MESH_TRIANGLES_MAX);
    else
        snprintf(why->text, sizeof why->text, "vertex_numbers: a hull has at most %d points", HULL_VERTICES_MAX);
    return why->reason = WIRE_TOO_LARGE;
}

/* Those that go at the next sweep are not counted. */
static size_t count_wanted(const service *s)
{
    size_t count = s->geometry_of.count;
    for (size_t i = 0; s->geometries_loose && i < s->geometries.count; i++) {
        const geometry *g = &s->geometries.at[i];
        count -= g->id && !g->users && !g->claims;
    }
    return count;
}

/* A number far beyond what came before is the time of a disposal (link_dds_take.c), and says nothing of what may come
 * late: what was announced until then does. */
static void take_back(service *s, session *c, const wire_geometry *m)
{
    static const int64_t FAR = 1 << 20;
    int64_t newest = c->sequence > c->geometry_sequence ? c->sequence : c->geometry_sequence;
    geometry_claim *at = claim_of(c, m->hash);
    at->leaves = at->geometry && pending_needs(c, m->hash);
    c->claims_leave |= at->leaves;
    s->claims_leave |= at->leaves;
    if (!at->leaves) disclaim(s, c, at);
    if (m->sequence - newest >= FAR) return;
    at->sequence = m->sequence;
    if (m->sequence > c->geometry_sequence) c->geometry_sequence = m->sequence;
}

static void let_go_of_claims(service *s, session *c)
{
    c->claims_leave = false;
    for (size_t k = 0; k < c->claims.count; k++) {
        geometry_claim *at = &c->claims.at[k];
        bool needed = at->leaves && pending_needs(c, at->hash);
        c->claims_leave |= needed;
        if (!at->leaves || needed) continue;
        at->leaves = false;
        disclaim(s, c, at);
    }
}

void geometry_let_go(service *s)
{
    bool some = false;
    for (size_t i = 0; s->claims_leave && i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        if (c->claims_leave) let_go_of_claims(s, c);
        some |= c->claims_leave;
    }
    s->claims_leave = some;
}

/* The piece by which it became whole is acknowledged when it is built, and not its copies before. */
static bool is_answered_later(const service *s, geometry_claim *at, const wire_geometry *m, bool was_whole)
{
    const geometry *g = find(s, at->geometry);
    if (!g || !g->is_building || (was_whole && m->piece != at->last_piece)) return false;
    at->last_piece = m->piece;
    at->unanswered = m->sequence > at->unanswered ? m->sequence : at->unanswered;
    return true;
}

/* Of two words on one hash the higher sequence stands. */
wire_reason geometry_put(service *s, session *c, const wire_geometry *m, wire_refusal *why, bool *later)
{
    geometry_claim *at = find_claim(s, m->client, m->hash);
    geometry *g = at ? find(s, at->geometry) : NULL;
    if (at && m->sequence <= at->sequence && (m->removed || !g)) {
        metric_count(s->count.duplicates, 1);
        return WIRE_OK;
    }
    if (m->removed) {
        take_back(s, c, m);
        return WIRE_OK;
    }
    if (check_size(m, why) != WIRE_OK) return why->reason;
    if (!g && apply_limit(s, count_wanted(s), s->config.max_geometries, "max_geometries", why)) return why->reason;
    if (!g && !limits_geometry(s, c, m, why)) return why->reason;
    if (!g) g = add_geometry(s, c, m);
    bool was_whole = !g->has;
    if (put_piece(s, c, g, m, why) != WIRE_OK) return why->reason;
    at = find_claim(s, m->client, m->hash);
    if (m->sequence > at->sequence) at->sequence = m->sequence, at->leaves = false;
    *later = is_answered_later(s, at, m, was_whole);
    if (m->sequence > c->geometry_sequence) c->geometry_sequence = m->sequence;
    return WIRE_OK;
}

/* What a shape of this type on the wire is made of. */
static uint8_t kind_for(uint8_t wire_type)
{
    if (wire_type == WIRE_SHAPE_HEIGHT_FIELD) return WIRE_GEOMETRY_HEIGHT_FIELD;
    if (wire_type == WIRE_SHAPE_SOFT) return WIRE_GEOMETRY_SOFT;
    return wire_type == WIRE_SHAPE_MESH ? WIRE_GEOMETRY_MESH : WIRE_GEOMETRY_HULL;
}

bool geometry_lend(const service *s, int64_t id, uint8_t wire_type, shape *to)
{
    const geometry *g = find(s, id);
    if (!g || !is_ready(g) || g->kind != kind_for(wire_type)) return false;
    to->mesh = g->mesh;
    to->hull = g->mesh ? g->mesh->hull : g->hull;
    to->soft = g->soft;
    return true;
}

void geometry_hold(service *s, int64_t id)
{
    geometry *g = find(s, id);
    if (g) g->users++;
}

void geometry_release(service *s, int64_t id)
{
    geometry *g = find(s, id);
    if (g && g->users) g->users--;
    s->geometries_loose = true;
}

void geometry_forget(service *s, session *c)
{
    for (size_t i = 0; i < c->claims.count; i++) disclaim(s, c, &c->claims.at[i]);
    forget_taken_back(c);
}

wire_reason geometry_restore(service *s, const geometry *bare, wire_refusal *why)
{
    geometry g = *bare;
    if (!g.has && !g.is_building) {
        built b;
        g.build = builds_add(s->builds, g.client, name_of_sender(s, &g), g.id, g.numbers, NULL, 0);
        builds_wait(s->builds, g.build, s->on_waiting, s->on_waiting_context);
        builds_end(s->builds, g.build, &b);
        g.build = NULL;
        g.hull = b.hull;
        g.mesh = b.mesh;
        g.soft = b.soft;
        *why = b.why;
        if (b.why.reason != WIRE_OK) return why->reason;
    }
    pair_map_put(&s->geometry_of, (uint64_t)g.id, (uint32_t)s->geometries.count);
    array_push(&s->geometries, g);
    s->geometries_building += g.is_building;
    if (g.completed) enter_whole(s, &s->geometries.at[s->geometries.count - 1]);
    return WIRE_OK;
}

void geometry_restore_builds(service *s)
{
    s->claims_leave = true; /* perhaps */
    for (size_t i = 0; i < s->sessions.count; i++) s->sessions.at[i]->claims_leave = true;
    for (size_t i = 0; i < s->geometries.count; i++)
        if (s->geometries.at[i].is_building) begin_build(s, &s->geometries.at[i]);
}

/* The world may look at a removed body's hull until the tick after its removal is over: so this runs after a tick, in
 * which ends have been reported. Of what is built bodies may be that nobody owns any more, and that are yet to go. */
void geometry_sweep(service *s)
{
    bool some_go = world_some_go(s->world);
    if (!s->geometries_loose) return;
    s->geometries_loose = some_go;
    for (size_t i = 0; i < s->geometries.count; i++) {
        geometry *g = &s->geometries.at[i];
        bool stays = some_go && is_ready(g);
        if (g->id && !g->users && !g->claims && !stays) drop_geometry(s, g);
    }
}

void geometry_free_all(service *s)
{
    for (size_t i = 0; i < s->geometries.count; i++)
        if (s->geometries.at[i].id) drop_geometry(s, &s->geometries.at[i]);
    array_free(&s->geometries);
    array_free(&s->reported_builds);
    s->geometry_hint = 0;
    s->geometries_completed = 0;
    pair_map_free(&s->geometry_of);
    pair_map_free(&s->geometry_whole);
}
