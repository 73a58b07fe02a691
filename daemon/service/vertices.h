/* vertices: frames of soft bodies, from VertexBatches to the world; and what steps of soft bodies came to, as records
 * of EventBatches. Tick thread. */
#ifndef COLLIDED_SERVICE_VERTICES_H
#define COLLIDED_SERVICE_VERTICES_H

#include "service.h"

/* What a soft body counts for in limits: each costs something, however few vertices it has. */
size_t vertices_weight(size_t vertices);
/* Of one that is announced: as far as its geometry is known, which is looked at again when it is put. 0: it is rigid.
 */
size_t vertices_of_body(service *s, const wire_body *b);

/* Part of a frame has come: with its last one the whole goes to the world, or of a client in lock-step waits for the
 * step. */
wire_reason vertices_put(service *s, session *c, const wire_vertex_batch *m, wire_refusal *why);
void vertices_step(service *s, const session *c, int64_t step); /* it is done: those of it go to the world */
void vertices_forget(service *s, int64_t client);
void vertices_free_all(service *s);
void vertices_save(const service *s, bytes_out *to);
const char *vertices_restore(service *s, bytes_in *from);

/* Of a batch the parts that tell of soft bodies come behind those of its events. */
int32_t vertices_parts(const world_batch *b);
wire_u8s vertices_part(service *s, const world_batch *b, int32_t i); /* as extensions; valid until the next one */

#endif
