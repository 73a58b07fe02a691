/* geometry: hulls, meshes and height fields under the hash of their content, announced once, in pieces. The caller's
 * thread. */
#include "allocate.h"
#include "announce.h"
#include "message.h"
#include "session.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct content {
    uint8_t kind;
    wire_f64s points;
    wire_i32s indices;
    int64_t hash;
    int32_t pieces;
} content;

static geometry_record *known(const collided *c, int64_t hash)
{
    geometry_record *g = c->geometries;
    while (g && g->hash != hash) g = g->next;
    return g;
}

static content content_of(uint8_t kind, wire_f64s points, wire_i32s indices)
{
    uint64_t numbers = (uint64_t)points.count + indices.count;
    return (content){kind, points, indices, wire_geometry_hash(kind, points, indices),
        (int32_t)((numbers + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX)};
}

/* How many of `count` numbers, which begin at `begin` of the whole, are within [from, end). */
static uint32_t share(uint32_t begin, uint32_t count, uint32_t from, uint32_t end, uint32_t *first)
{
    uint32_t lo = from > begin ? from - begin : 0, hi = end > begin ? end - begin : 0;
    *first = lo < count ? lo : count;
    return (hi < count ? hi : count) - *first;
}

/* Vertices first, then indices. */
static wire_message piece_of(const collided *c, const content *g, int32_t piece)
{
    uint32_t from = (uint32_t)piece * WIRE_PIECE_MAX, end = from + WIRE_PIECE_MAX, vertex, index;
    uint32_t vertices = share(0, g->points.count, from, end, &vertex);
    uint32_t indices = share(g->points.count, g->indices.count, from, end, &index);
    return (wire_message){.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .kind = g->kind,
            .hash = g->hash,
            .vertex_numbers = (int32_t)g->points.count,
            .index_numbers = (int32_t)g->indices.count,
            .piece = piece,
            .pieces = g->pieces,
            .vertices = {vertices, vertices ? g->points.at + vertex : NULL},
            .indices = {indices, indices ? g->indices.at + index : NULL}}};
}

/* Content under a known hash is compared number by number: other content may have the same hash. */
static bool is_announced(const collided *c, const geometry_record *known, const content *g)
{
    bool same = known->piece_count == g->pieces;
    for (int32_t i = 0; same && i < g->pieces; i++) {
        const wire_geometry *had = &known->pieces[i].message->geometry;
        wire_message now = piece_of(c, g, i);
        const wire_geometry *m = &now.geometry;
        same = had->kind == m->kind && had->vertices.count == m->vertices.count &&
               had->indices.count == m->indices.count &&
               (!m->vertices.count ||
                   memcmp(had->vertices.at, m->vertices.at, m->vertices.count * sizeof *m->vertices.at) == 0) &&
               (!m->indices.count ||
                   memcmp(had->indices.at, m->indices.at, m->indices.count * sizeof *m->indices.at) == 0);
    }
    return same;
}

static void announce_geometry(collided *c, const content *from)
{
    geometry_record *g = allocate(1, sizeof *g);
    *g = (geometry_record){.pieces = allocate((size_t)from->pieces, sizeof *g->pieces),
        .piece_count = from->pieces,
        .hash = from->hash,
        .next = c->geometries};
    c->geometries = g;
    for (int32_t i = 0; i < from->pieces; i++) {
        wire_message m = piece_of(c, from, i);
        announce(c, &g->pieces[i], message_copy(&m));
    }
}

static collided_geometry create(collided *c, const content *g, const char *what)
{
    wire_refusal why = {.reason = WIRE_OK};
    pthread_mutex_lock(&c->lock);
    const geometry_record *before = known(c, g->hash);
    bool is_new = !before;
    if (before && !is_announced(c, before, g)) {
        why.reason = WIRE_BAD_HASH;
        snprintf(
            why.text, sizeof why.text, "other geometry of yours has the same hash: change a number in its last bits");
    }
    for (int32_t i = 0; is_new && i < g->pieces && why.reason == WIRE_OK; i++) {
        wire_message m = piece_of(c, g, i);
        why.reason = wire_check(&m, &why);
    }
    if (is_new && why.reason == WIRE_OK) announce_geometry(c, g);
    pthread_mutex_unlock(&c->lock);
    if (why.reason == WIRE_OK) return (collided_geometry){g->hash};
    (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "%s: %s", what, why.text);
    return (collided_geometry){0};
}

collided_geometry collided_create_hull(collided *c, const double *points, size_t count)
{
    if (!points || count < 4 || count > WIRE_GEOMETRY_MAX / 3) {
        (void)session_fail(
            c, COLLIDED_BAD_ARGUMENT, "a hull has 4 to %d points, not %zu", WIRE_GEOMETRY_MAX / 3, count);
        return (collided_geometry){0};
    }
    content g = content_of(WIRE_GEOMETRY_HULL, (wire_f64s){(uint32_t)(3 * count), points}, (wire_i32s){0});
    return create(c, &g, "hull");
}

collided_geometry collided_create_mesh(
    collided *c, const double *points, size_t count, const int32_t *triangles, size_t triangle_count)
{
    const size_t most = WIRE_GEOMETRY_MAX / 3; /* of points and triangles together */
    if (!points || !triangles || count < 3 || triangle_count < 1 || count > most || triangle_count > most - count) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT,
            "a mesh has at least 3 points and a triangle, and at most %zu of both together, not %zu and %zu", most,
            count, triangle_count);
        return (collided_geometry){0};
    }
    content g = content_of(WIRE_GEOMETRY_MESH, (wire_f64s){(uint32_t)(3 * count), points},
        (wire_i32s){(uint32_t)(3 * triangle_count), triangles});
    return create(c, &g, "mesh");
}

/* Spacing and base go in front of the heights. */
static content content_of_field(const double head[WIRE_FIELD_HEAD], const double *heights, const int32_t sizes[2])
{
    size_t count = (size_t)sizes[0] * (size_t)sizes[1];
    double *numbers = allocate(WIRE_FIELD_HEAD + count, sizeof *numbers);
    memcpy(numbers, head, WIRE_FIELD_HEAD * sizeof *numbers);
    memcpy(numbers + WIRE_FIELD_HEAD, heights, count * sizeof *numbers);
    return content_of(
        WIRE_GEOMETRY_HEIGHT_FIELD, (wire_f64s){(uint32_t)(WIRE_FIELD_HEAD + count), numbers}, (wire_i32s){2, sizes});
}

collided_geometry collided_create_height_field(
    collided *c, const double *heights, size_t rows, size_t columns, double spacing_x, double spacing_y, double base)
{
    const size_t most = WIRE_GEOMETRY_MAX - WIRE_FIELD_HEAD - 2; /* heights */
    if (!heights || rows < 2 || columns < 2 || rows > most / columns) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT,
            "a height field has at least 2 rows and 2 columns, and at most %zu heights, not %zu x %zu", most, rows,
            columns);
        return (collided_geometry){0};
    }
    const double head[WIRE_FIELD_HEAD] = {spacing_x, spacing_y, base};
    const int32_t sizes[2] = {(int32_t)columns, (int32_t)rows};
    content g = content_of_field(head, heights, sizes);
    collided_geometry made = create(c, &g, "height field");
    free((void *)g.points.at);
    return made;
}

/* Ring and exclusion go in front of the vertices. */
collided_geometry collided_create_soft(collided *c, const double *points, size_t count, const int32_t *triangles,
    size_t triangle_count, int ring, double rest_exclusion_m)
{
    const size_t most = WIRE_GEOMETRY_MAX / 3 - 1; /* of points and triangles together */
    if (!points || !triangles || count < 1 || triangle_count < 1 || count > most || triangle_count > most - count) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT,
            "a soft surface has at least a point and a triangle, and at most %zu of both together, not %zu and %zu",
            most, count, triangle_count);
        return (collided_geometry){0};
    }
    double *numbers = allocate(WIRE_SOFT_HEAD + 3 * count, sizeof *numbers);
    numbers[0] = ring, numbers[1] = rest_exclusion_m, numbers[2] = 0;
    memcpy(numbers + WIRE_SOFT_HEAD, points, 3 * count * sizeof *numbers);
    content g = content_of(WIRE_GEOMETRY_SOFT, (wire_f64s){(uint32_t)(WIRE_SOFT_HEAD + 3 * count), numbers},
        (wire_i32s){(uint32_t)(3 * triangle_count), triangles});
    collided_geometry made = create(c, &g, "soft surface");
    free(numbers);
    return made;
}
