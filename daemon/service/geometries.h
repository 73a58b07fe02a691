/* geometries: hulls, meshes and height fields, by their content. Tick thread. */
#ifndef COLLIDED_SERVICE_GEOMETRIES_H
#define COLLIDED_SERVICE_GEOMETRIES_H

#include "service.h"

/* geometry.c */
typedef struct geometry_share { /* what one piece holds of the whole: vertices first, then indices */
    size_t first_vertex, vertices, first_index, indices;
} geometry_share;
int64_t geometry_bytes(int64_t vertex_numbers, int64_t index_numbers); /* of its numbers in memory */
geometry_share geometry_share_of(const geometry *g, int32_t piece);
/* *later: it is not acknowledged now, but when it has been built. */
wire_reason geometry_put(service *s, session *c, const wire_geometry *m, wire_refusal *why, bool *later);
int64_t geometry_claimed(service *s, int64_t client, int64_t hash); /* its id; 0: the client has sent none */
const geometry *geometry_at(const service *s, int64_t id);          /* NULL: there is none */
/* The hull or mesh of a shape of that type, WIRE_SHAPE_*; false: it is not whole, or of another kind. */
bool geometry_lend(const service *s, int64_t id, uint8_t wire_type, shape *to);
void geometry_hold(service *s, int64_t id);
void geometry_release(service *s, int64_t id);
void geometry_forget(service *s, session *c); /* what it alone announced and no body holds may go */
void geometry_sweep(service *s);              /* frees what nobody wants; after a tick */
void geometry_free_all(service *s);
/* Behind the others, as it was elsewhere: numbers and `has` become its own. It is built, if it was. */
wire_reason geometry_restore(service *s, const geometry *bare, wire_refusal *why);
void geometry_restore_builds(service *s); /* when all are there: what was being built is being built again */
typedef enum geometry_state { GEOMETRY_MISSING, GEOMETRY_BUILDING, GEOMETRY_READY } geometry_state;
/* Of what the client means by that hash. */
geometry_state geometry_state_of(service *s, int64_t client, int64_t hash);
void geometry_builds_end(service *s); /* the first thing in a tick: what is ready from then on */
void geometry_report(service *s, int64_t client, int64_t hash, bool ready); /* what another daemon did in this tick */
void geometry_let_go(service *s); /* what was taken back, and no body waits for any more */

#endif
