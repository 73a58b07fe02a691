/* geometry: hulls, meshes and height fields. Content is known by the numbers themselves: a hash is what a client calls
 * it by, and what one client sends under a hash neither changes nor hinders what another sends under the same. While it
 * comes it belongs to its client; when its last piece has come it is compared with what is there, and shared if it is
 * the same number by number, or else built. It goes when no body holds it and nobody claims it. Tick thread. */
#include "service.h"

#include "base/log.h"
#include "geom/height_field.h"

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

static bool is_whole(const geometry *g)
{
    return g->hull || g->mesh;
}

static wire_reason refuse(wire_refusal *why, wire_reason reason, const char *text)
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

static int compare_claims(const geometry_claim *x, int64_t client, int64_t hash)
{
    if (x->client != client) return x->client < client ? -1 : 1;
    return (x->hash > hash) - (x->hash < hash);
}

/* The first that is not less. */
static size_t place_of_claim(const service *s, int64_t client, int64_t hash)
{
    size_t low = 0, high = s->claims.count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (compare_claims(&s->claims.at[middle], client, hash) < 0)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static geometry_claim *find_claim(const service *s, int64_t client, int64_t hash)
{
    size_t at = place_of_claim(s, client, hash);
    bool found = at < s->claims.count && compare_claims(&s->claims.at[at], client, hash) == 0;
    return found ? &s->claims.at[at] : NULL;
}

int64_t geometry_claimed(const service *s, int64_t client, int64_t hash)
{
    const geometry_claim *c = find_claim(s, client, hash);
    return c ? c->geometry : 0;
}

static int64_t bytes_of(const geometry *g)
{
    return geometry_bytes((int64_t)g->vertex_numbers, (int64_t)g->index_numbers);
}

/* Its entries go that claim nothing. */
static void forget_taken_back(service *s, session *c)
{
    size_t at = place_of_claim(s, c->client, INT64_MIN), kept = at;
    for (; at < s->claims.count; at++)
        if (s->claims.at[at].client != c->client || s->claims.at[at].geometry) s->claims.at[kept++] = s->claims.at[at];
    s->claims.count = kept;
    c->geometries_taken_back = 0;
}

/* The client's entry under that hash; a new one claims nothing. */
static geometry_claim *claim_of(service *s, session *c, int64_t hash)
{
    geometry_claim *there = find_claim(s, c->client, hash);
    if (there) return there;
    if (c->geometries_taken_back >= TAKEN_BACK_KEPT) forget_taken_back(s, c);
    size_t at = place_of_claim(s, c->client, hash);
    array_push(&s->claims, (geometry_claim){.client = 0});
    memmove(&s->claims.at[at + 1], &s->claims.at[at], (s->claims.count - 1 - at) * sizeof *s->claims.at);
    s->claims.at[at] = (geometry_claim){.client = c->client, .hash = hash};
    c->geometries_taken_back++;
    return &s->claims.at[at];
}

static void claim(service *s, session *c, geometry *g)
{
    claim_of(s, c, g->hash)->geometry = g->id;
    c->geometries_taken_back--;
    g->claims++;
    c->geometry_count++;
    c->geometry_bytes += bytes_of(g);
}

/* What it was for goes at the next sweep, if nobody else wants it. */
static void disclaim(service *s, session *c, geometry_claim *at)
{
    geometry *g = find(s, at->geometry);
    if (!g) return;
    c->geometry_count--;
    c->geometry_bytes -= bytes_of(g);
    c->geometries_taken_back++;
    g->claims--;
    s->geometries_loose = true;
    at->geometry = 0;
}

/* ---- the store ---- */

static geometry *add(service *s, session *c, const wire_geometry *m)
{
    size_t place = 0;
    while (place < s->geometries.count && s->geometries.at[place].id) place++;
    if (place == s->geometries.count) array_push(&s->geometries, (geometry){.id = 0});
    geometry *g = &s->geometries.at[place];
    *g = (geometry){.id = ++s->geometry_last,
        .hash = m->hash,
        .same = PAIR_MAP_NONE,
        .kind = m->kind,
        .pieces = m->pieces,
        .vertex_numbers = (size_t)m->vertex_numbers,
        .index_numbers = (size_t)m->index_numbers};
    g->vertices = base_zalloc(g->vertex_numbers ? g->vertex_numbers : 1, sizeof *g->vertices);
    g->indices = base_zalloc(g->index_numbers ? g->index_numbers : 1, sizeof *g->indices);
    g->has = base_zalloc((size_t)m->pieces, 1);
    pair_map_put(&s->geometry_of, (uint64_t)g->id, (uint32_t)place);
    claim(s, c, g);
    return g;
}

static void enter_whole(service *s, geometry *g)
{
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

static void drop(service *s, geometry *g)
{
    if (is_whole(g)) leave_whole(s, g);
    pair_map_remove(&s->geometry_of, (uint64_t)g->id);
    free(g->vertices);
    free(g->indices);
    free(g->has);
    hull_destroy(g->hull);
    mesh_destroy(g->mesh);
    *g = (geometry){.id = 0};
}

static wire_reason build_hull(geometry *g, wire_refusal *why)
{
    hull_status status = hull_build(g->vertices, g->vertex_numbers / 3, 0, &g->hull);
    if (status == HULL_OK) return WIRE_OK;
    snprintf(why->text, sizeof why->text, "vertices: %s", hull_status_text(status));
    return why->reason = status == HULL_FLAT       ? WIRE_FLAT_HULL
                         : status == HULL_TOO_MANY ? WIRE_TOO_LARGE
                                                   : WIRE_BAD_SIZE;
}

/* What was mended is worth a warning, and so is a surface where a solid may have been meant. */
static void tell_findings(const geometry *g)
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

static wire_reason build_mesh(geometry *g, wire_refusal *why)
{
    mesh_status status = mesh_build(g->vertices, g->vertex_numbers / 3, g->indices, g->index_numbers / 3, &g->mesh);
    if (status == MESH_OK) {
        tell_findings(g);
        return WIRE_OK;
    }
    bool large = status == MESH_TOO_MANY || status == MESH_WIDE_HULL;
    snprintf(why->text, sizeof why->text, "vertices, indices: %s", mesh_status_text(status));
    return why->reason = large ? WIRE_TOO_LARGE : WIRE_BAD_SIZE;
}

static wire_reason build_height_field(geometry *g, wire_refusal *why)
{
    const double *head = g->vertices;
    int32_t columns = g->indices[0], rows = g->indices[1];
    int64_t heights = (int64_t)g->vertex_numbers - WIRE_FIELD_HEAD;
    if (columns < 2 || rows < 2 || (int64_t)columns * rows != heights) { /* they came in pieces of their own */
        snprintf(why->text, sizeof why->text, "indices: %d columns and %d rows are not %" PRId64 " heights", columns,
            rows, heights);
        return why->reason = WIRE_MALFORMED;
    }
    const height_field field = {.rows = (uint32_t)rows,
        .columns = (uint32_t)columns,
        .dx = head[0],
        .dy = head[1],
        .base = head[2],
        .heights = head + WIRE_FIELD_HEAD};
    height_field_status status = height_field_build(&field, &g->mesh);
    if (status == HEIGHT_FIELD_OK) {
        log_info("height field %016" PRIx64 " has %d rows and %d columns", (uint64_t)g->hash, rows, columns);
        return WIRE_OK;
    }
    bool large = status == HEIGHT_FIELD_TOO_MANY || status == HEIGHT_FIELD_NO_MESH;
    snprintf(why->text, sizeof why->text, "vertices, indices: %s", height_field_status_text(status));
    return why->reason = large ? WIRE_TOO_LARGE : WIRE_BAD_SIZE;
}

static wire_reason build_kind(geometry *g, wire_refusal *why)
{
    switch (g->kind) {
    case WIRE_GEOMETRY_MESH:
        return build_mesh(g, why);
    case WIRE_GEOMETRY_HEIGHT_FIELD:
        return build_height_field(g, why);
    default:
        return build_hull(g, why);
    }
}

static bool has_content(const geometry *g, const geometry *of)
{
    return g->hash == of->hash && g->kind == of->kind && g->vertex_numbers == of->vertex_numbers &&
           g->index_numbers == of->index_numbers &&
           memcmp(g->vertices, of->vertices, of->vertex_numbers * sizeof *of->vertices) == 0 &&
           memcmp(g->indices, of->indices, of->index_numbers * sizeof *of->indices) == 0;
}

static geometry *find_whole(const service *s, const geometry *like)
{
    uint32_t at = pair_map_get(&s->geometry_whole, (uint64_t)like->hash);
    while (at != PAIR_MAP_NONE && !has_content(&s->geometries.at[at], like)) at = s->geometries.at[at].same;
    return at == PAIR_MAP_NONE ? NULL : &s->geometries.at[at];
}

/* All pieces have come: it is shared with who sent the same before, or built. Refused, it is gone with its claim. */
static wire_reason complete(service *s, geometry *g, session *c, wire_refusal *why)
{
    wire_f64s vertices = {(uint32_t)g->vertex_numbers, g->vertices};
    bool right = wire_geometry_hash(g->kind, vertices, (wire_i32s){(uint32_t)g->index_numbers, g->indices}) == g->hash;
    geometry *there = right ? find_whole(s, g) : NULL;
    if (there) {
        find_claim(s, c->client, g->hash)->geometry = there->id;
        there->claims++;
        drop(s, g);
    } else if (!right || build_kind(g, why) != WIRE_OK) {
        geometry_claim *refused = find_claim(s, c->client, g->hash);
        disclaim(s, c, refused);
        refused->sequence = 0; /* a copy is refused, too */
        drop(s, g);
        return right ? why->reason : refuse(why, WIRE_BAD_HASH, "hash: the content has another one");
    } else {
        free(g->has);
        g->has = NULL;
        enter_whole(s, g);
    }
    s->hull_came = true;
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
        return refuse(why, WIRE_MALFORMED, "pieces: they do not belong to one geometry");
    geometry_share share = geometry_share_of(g, m->piece);
    if (m->vertices.count != share.vertices || m->indices.count != share.indices)
        return refuse(why, WIRE_MALFORMED, "pieces: one does not hold its share of the whole");
    size_t v = share.vertices * sizeof *g->vertices, i = share.indices * sizeof *g->indices;
    bool has = is_whole(g) || g->has[m->piece];
    bool other = has && ((v && memcmp(g->vertices + share.first_vertex, m->vertices.at, v) != 0) ||
                            (i && memcmp(g->indices + share.first_index, m->indices.at, i) != 0));
    if (other) return refuse(why, WIRE_BAD_HASH, "hash: you have sent other content under it");
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
    geometry_claim *at = claim_of(s, c, m->hash);
    disclaim(s, c, at);
    if (m->sequence - newest >= FAR) return;
    at->sequence = m->sequence;
    if (m->sequence > c->geometry_sequence) c->geometry_sequence = m->sequence;
}

/* Of two words on one hash the higher sequence stands. */
wire_reason geometry_put(service *s, session *c, const wire_geometry *m, wire_refusal *why)
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
    if (!g) g = add(s, c, m);
    if (put_piece(s, c, g, m, why) != WIRE_OK) return why->reason;
    at = find_claim(s, m->client, m->hash);
    if (m->sequence > at->sequence) at->sequence = m->sequence;
    if (m->sequence > c->geometry_sequence) c->geometry_sequence = m->sequence;
    return WIRE_OK;
}

/* What a shape of this type on the wire is made of. */
static uint8_t kind_for(uint8_t wire_type)
{
    if (wire_type == WIRE_SHAPE_HEIGHT_FIELD) return WIRE_GEOMETRY_HEIGHT_FIELD;
    return wire_type == WIRE_SHAPE_MESH ? WIRE_GEOMETRY_MESH : WIRE_GEOMETRY_HULL;
}

bool geometry_lend(const service *s, int64_t id, uint8_t wire_type, shape *to)
{
    const geometry *g = find(s, id);
    if (!g || !is_whole(g) || g->kind != kind_for(wire_type)) return false;
    to->mesh = g->mesh;
    to->hull = g->mesh ? g->mesh->hull : g->hull;
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
    size_t at = place_of_claim(s, c->client, INT64_MIN);
    for (; at < s->claims.count && s->claims.at[at].client == c->client; at++) disclaim(s, c, &s->claims.at[at]);
    forget_taken_back(s, c);
}

wire_reason geometry_restore(service *s, const geometry *bare, wire_refusal *why)
{
    geometry g = *bare;
    bool whole = !g.has;
    if (whole && build_kind(&g, why) != WIRE_OK) return why->reason;
    pair_map_put(&s->geometry_of, (uint64_t)g.id, (uint32_t)s->geometries.count);
    array_push(&s->geometries, g);
    if (whole) enter_whole(s, &s->geometries.at[s->geometries.count - 1]);
    return WIRE_OK;
}

/* The world may look at a removed body's hull until the tick after its removal is over: so this runs after a tick, in
 * which ends have been told. */
void geometry_sweep(service *s)
{
    if (!s->geometries_loose) return;
    s->geometries_loose = false;
    for (size_t i = 0; i < s->geometries.count; i++) {
        geometry *g = &s->geometries.at[i];
        if (g->id && !g->users && !g->claims) drop(s, g);
    }
}

void geometry_free_all(service *s)
{
    for (size_t i = 0; i < s->geometries.count; i++)
        if (s->geometries.at[i].id) drop(s, &s->geometries.at[i]);
    array_free(&s->geometries);
    array_free(&s->claims);
    pair_map_free(&s->geometry_of);
    pair_map_free(&s->geometry_whole);
}
