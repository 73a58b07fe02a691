/* models: robots. A Body may carry a kinematic tree (wire_model.h) whose links are bodies of the same client; the
 * values of its joints in a PoseBatch become poses of these bodies before anything else looks at the batch, so that all
 * that holds for poses holds for them: order, steps, recordings, rates. Tick thread. */
#ifndef COLLIDED_SERVICE_MODELS_H
#define COLLIDED_SERVICE_MODELS_H

#include "service.h"

/* *out: NULL where it carries none; owned by the caller. A reason: its joints make no tree. */
wire_reason model_of(wire_u8s extensions, struct model **out, wire_refusal *why);
void model_destroy(struct model *m);
wire_u8s model_extensions(const struct model *m); /* of the Body that it came with; none for NULL */

/* What the batch says of joints is said in *out by poses, behind its own ones; *out borrows from it, and from the
 * service until the next call. A robot that is refused is left out, and its client is told. */
void models_expand(service *s, session *c, struct link *from, const wire_pose_batch *m, wire_pose_batch *out);
void models_free(service *s);

bool models_are_known(session *c, const wire_pose_batch *m); /* those whose joints are in it */

#endif
