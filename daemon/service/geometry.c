/* geometry: hulls, meshes and height fields by the hash of their content. One is built when its last piece has come; it
 * goes when no body holds it and its sender is gone or took it back. Tick thread. */
#include "service.h"

#include "base/log.h"
#include "geom/height_field.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static geometry *find(const service *s, int64_t hash)
{
    uint32_t index = pair_map_get(&s->geometry_of, (uint64_t)hash);
    return index == PAIR_MAP_NONE ? NULL : &s->geometries.at[index];
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

static geometry *add(service *s, const wire_geometry *m)
{
    size_t index = 0;
    while (index < s->geometries.count && s->geometries.at[index].used) index++;
    if (index == s->geometries.count) array_push(&s->geometries, (geometry){.used = false});
    geometry *g = &s->geometries.at[index];
    *g = (geometry){.used = true,
        .hash = m->hash,
        .payer = m->client,
        .kind = m->kind,
        .pieces = m->pieces,
        .vertex_numbers = (size_t)m->vertex_numbers,
        .index_numbers = (size_t)m->index_numbers};
    g->vertices = base_zalloc(g->vertex_numbers ? g->vertex_numbers : 1, sizeof *g->vertices);
    g->indices = base_zalloc(g->index_numbers ? g->index_numbers : 1, sizeof *g->indices);
    g->has = base_zalloc((size_t)m->pieces, 1);
    pair_map_put(&s->geometry_of, (uint64_t)m->hash, (uint32_t)index);
    session *payer = session_find(s, m->client);
    if (payer) payer->geometry_bytes += geometry_bytes(m->vertex_numbers, m->index_numbers);
    return g;
}

static void pay_back(service *s, const geometry *g)
{
    session *payer = session_find(s, g->payer);
    int64_t bytes = geometry_bytes((int64_t)g->vertex_numbers, (int64_t)g->index_numbers);
    if (payer) payer->geometry_bytes = payer->geometry_bytes > bytes ? payer->geometry_bytes - bytes : 0;
}

static void drop(service *s, geometry *g)
{
    pay_back(s, g);
    pair_map_remove(&s->geometry_of, (uint64_t)g->hash);
    free(g->vertices);
    free(g->indices);
    free(g->has);
    hull_destroy(g->hull);
    mesh_destroy(g->mesh);
    array_free(&g->announcers);
    *g = (geometry){.used = false};
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

static wire_reason build(service *s, geometry *g, wire_refusal *why)
{
    wire_f64s vertices = {(uint32_t)g->vertex_numbers, g->vertices};
    if (wire_geometry_hash(g->kind, vertices, (wire_i32s){(uint32_t)g->index_numbers, g->indices}) != g->hash) {
        drop(s, g);
        return refuse(why, WIRE_BAD_HASH, "hash: the content has another one");
    }
    if (build_kind(g, why) != WIRE_OK) {
        drop(s, g);
        return why->reason;
    }
    free(g->has);
    g->has = NULL;
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

/* Pieces may come in any order and more than once. */
static wire_reason put_piece(service *s, geometry *g, const wire_geometry *m, wire_refusal *why)
{
    if (m->kind != g->kind || m->pieces != g->pieces || (size_t)m->vertex_numbers != g->vertex_numbers ||
        (size_t)m->index_numbers != g->index_numbers)
        return refuse(why, WIRE_MALFORMED, "pieces: they do not belong to one geometry");
    geometry_share share = geometry_share_of(g, m->piece);
    if (m->vertices.count != share.vertices || m->indices.count != share.indices)
        return refuse(why, WIRE_MALFORMED, "pieces: one does not hold its share of the whole");
    if (share.vertices) memcpy(g->vertices + share.first_vertex, m->vertices.at, share.vertices * sizeof *g->vertices);
    if (share.indices) memcpy(g->indices + share.first_index, m->indices.at, share.indices * sizeof *g->indices);
    g->come += !g->has[m->piece];
    g->has[m->piece] = 1;
    return g->come == g->pieces ? build(s, g, why) : WIRE_OK;
}

/* ---- who announces it: several clients may send the same hull ---- */

static void announce(geometry *g, int64_t client)
{
    for (size_t i = 0; i < g->announcers.count; i++)
        if (g->announcers.at[i] == client) return;
    array_push(&g->announcers, client);
}

static void retract(service *s, geometry *g, int64_t client)
{
    for (size_t i = 0; i < g->announcers.count; i++) {
        if (g->announcers.at[i] != client) continue;
        g->announcers.at[i] = g->announcers.at[--g->announcers.count];
        s->geometries_loose = true;
        return;
    }
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

wire_reason geometry_put(service *s, const wire_geometry *m, wire_refusal *why)
{
    geometry *g = find(s, m->hash);
    if (m->removed) {
        if (g) retract(s, g, m->client);
        return WIRE_OK;
    }
    if (check_size(m, why) != WIRE_OK) return why->reason;
    if (!g && apply_limit(s, s->geometry_of.count, s->config.max_geometries, "max_geometries", why)) return why->reason;
    if (!g && !limits_geometry(s, session_find(s, m->client), m, why)) return why->reason;
    if (!g) g = add(s, m);
    announce(g, m->client);
    return is_whole(g) ? WIRE_OK : put_piece(s, g, m, why);
}

/* What a shape of this type on the wire is made of. */
static uint8_t kind_for(uint8_t wire_type)
{
    if (wire_type == WIRE_SHAPE_HEIGHT_FIELD) return WIRE_GEOMETRY_HEIGHT_FIELD;
    return wire_type == WIRE_SHAPE_MESH ? WIRE_GEOMETRY_MESH : WIRE_GEOMETRY_HULL;
}

bool geometry_lend(const service *s, int64_t hash, uint8_t wire_type, shape *to)
{
    const geometry *g = find(s, hash);
    if (!g || !is_whole(g) || g->kind != kind_for(wire_type)) return false;
    to->mesh = g->mesh;
    to->hull = g->mesh ? g->mesh->hull : g->hull;
    return true;
}

void geometry_hold(service *s, int64_t hash)
{
    geometry *g = find(s, hash);
    if (g) g->users++;
}

void geometry_release(service *s, int64_t hash)
{
    geometry *g = find(s, hash);
    if (g && g->users) g->users--;
    s->geometries_loose = true;
}

void geometry_forget(service *s, int64_t client)
{
    for (size_t i = 0; i < s->geometries.count; i++) {
        geometry *g = &s->geometries.at[i];
        if (!g->used) continue;
        retract(s, g, client);
        if (g->payer == client) g->payer = 0; /* one who comes back under that number has not paid for it */
    }
}

wire_reason geometry_restore(service *s, const geometry *bare, wire_refusal *why)
{
    geometry g = *bare;
    bool whole = !g.has;
    if (whole && build_kind(&g, why) != WIRE_OK) return why->reason;
    pair_map_put(&s->geometry_of, (uint64_t)g.hash, (uint32_t)s->geometries.count);
    array_push(&s->geometries, g);
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
        if (g->used && !g->users && !g->announcers.count) drop(s, g);
    }
}

void geometry_free_all(service *s)
{
    for (size_t i = 0; i < s->geometries.count; i++)
        if (s->geometries.at[i].used) drop(s, &s->geometries.at[i]);
    array_free(&s->geometries);
    pair_map_free(&s->geometry_of);
}
