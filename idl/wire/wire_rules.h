/* wire_rules: rules that the checks of several messages share, and the checks that have files of their own. Each
 * returns WIRE_OK, or a reason with a line in `why` that names the field, the index and what is allowed. Pure; any
 * thread. */
#ifndef COLLIDED_WIRE_RULES_H
#define COLLIDED_WIRE_RULES_H

#include "wire_schema.h"
#include "wire_text.h"

#define FAIL(reason, ...) return wire_refuse(why, reason, __VA_ARGS__)
#define TRY(check)                                                                                                     \
    do {                                                                                                               \
        wire_reason tried = (check);                                                                                   \
        if (tried != WIRE_OK) return tried;                                                                            \
    } while (0)

wire_reason check_count(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why);
wire_reason check_optional(const char *name, uint32_t count, uint32_t each, uint32_t things, wire_refusal *why);
wire_reason check_between(const char *name, int64_t value, int64_t least, int64_t most, wire_refusal *why);
wire_reason check_all_between(const char *name, wire_u8s s, uint8_t least, uint8_t most, wire_refusal *why);
wire_reason check_at_least(const char *name, double value, double least, wire_refusal *why);
wire_reason check_magnitudes(const char *name, wire_f64s v, double most, wire_refusal *why);
wire_reason check_rotation(const char *name, uint32_t i, const double q[4], wire_refusal *why);
wire_reason check_poses(const char *name, wire_f64s poses, wire_refusal *why);
wire_reason check_label(const char *name, const char *text, wire_refusal *why);
wire_reason check_name(const char *name, const char *text, wire_refusal *why);
wire_reason check_pattern(const char *name, const char *text, wire_refusal *why);
wire_reason check_stream(const char *text, wire_refusal *why);
wire_reason check_sender(int64_t client, int64_t sequence, wire_refusal *why);
wire_reason check_rate(const char *name, double rate, wire_refusal *why);

/* ---- whole messages ---- */

bool poses_are_plain(const wire_pose_batch *m); /* true: nothing is wrong with it; wire_check_poses.c */
wire_reason check_extensions(const wire_message *m, wire_refusal *why);      /* wire_extensions.c */
wire_reason check_geometry(const wire_geometry *m, wire_refusal *why);       /* wire_check_body.c */
wire_reason check_body(const wire_body *m, wire_refusal *why);               /* wire_check_body.c */
wire_reason check_answer(const wire_answer *m, wire_refusal *why);           /* wire_check_events.c */
wire_reason check_event_batch(const wire_event_batch *m, wire_refusal *why); /* wire_check_events.c */

wire_reason check_soft_vertices(const wire_vertex_batch *m, wire_refusal *why); /* wire_soft.c */
wire_reason check_soft_interest(wire_u8s extensions, wire_refusal *why);

wire_reason check_model(const wire_body *m, wire_refusal *why); /* wire_model.c */
wire_reason check_joints(const wire_pose_batch *m, wire_refusal *why);

#endif
