/* geometry: hulls under the hash of their points, announced once, in pieces. The caller's thread. */
#include "allocate.h"
#include "message.h"
#include "session.h"

static geometry_record *known(const collided *c, int64_t hash)
{
    geometry_record *g = c->geometries;
    while (g && g->hash != hash) g = g->next;
    return g;
}

static wire_message piece_of(const collided *c, wire_f64s points, int64_t hash, int32_t piece, int32_t pieces)
{
    uint32_t from = (uint32_t)piece * WIRE_PIECE_MAX, left = points.count - from;
    return (wire_message){.kind = WIRE_GEOMETRY,
        .geometry = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .kind = WIRE_GEOMETRY_HULL,
            .hash = hash,
            .vertex_numbers = (int32_t)points.count,
            .piece = piece,
            .pieces = pieces,
            .vertices = {left < WIRE_PIECE_MAX ? left : WIRE_PIECE_MAX, points.at + from}}};
}

static void announce_geometry(collided *c, wire_f64s points, int64_t hash, int32_t pieces)
{
    geometry_record *g = allocate(1, sizeof *g);
    *g = (geometry_record){.pieces = allocate((size_t)pieces, sizeof *g->pieces),
        .piece_count = pieces,
        .hash = hash,
        .next = c->geometries};
    c->geometries = g;
    for (int32_t i = 0; i < pieces; i++) {
        wire_message m = piece_of(c, points, hash, i, pieces);
        announce(c, &g->pieces[i], message_copy(&m));
    }
}

collided_geometry collided_create_hull(collided *c, const double *points, size_t count)
{
    const collided_geometry none = {0};
    if (!points || count < 4 || count > WIRE_GEOMETRY_MAX / 3) {
        (void)session_fail(
            c, COLLIDED_BAD_ARGUMENT, "a hull has 4 to %d points, not %zu", WIRE_GEOMETRY_MAX / 3, count);
        return none;
    }
    wire_f64s numbers = {(uint32_t)(3 * count), points};
    int64_t hash = wire_geometry_hash(WIRE_GEOMETRY_HULL, numbers, (wire_i32s){0});
    int32_t pieces = (int32_t)((numbers.count + WIRE_PIECE_MAX - 1) / WIRE_PIECE_MAX);
    wire_refusal why = {.reason = WIRE_OK};
    pthread_mutex_lock(&c->lock);
    bool is_new = !known(c, hash);
    for (int32_t i = 0; is_new && i < pieces && why.reason == WIRE_OK; i++) {
        wire_message m = piece_of(c, numbers, hash, i, pieces);
        why.reason = wire_check(&m, &why);
    }
    if (is_new && why.reason == WIRE_OK) announce_geometry(c, numbers, hash, pieces);
    pthread_mutex_unlock(&c->lock);
    if (why.reason == WIRE_OK) return (collided_geometry){hash};
    (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "hull: %s", why.text);
    return none;
}
