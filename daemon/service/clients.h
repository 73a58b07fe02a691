/* clients: their sessions and what is theirs, what they may have, and who is not heard. Tick thread. */
#ifndef COLLIDED_SERVICE_CLIENTS_H
#define COLLIDED_SERVICE_CLIENTS_H

#include "service.h"

/* session.c */
session *session_find(service *s, int64_t client);
session *session_get(service *s, int64_t client, struct link *from); /* NULL: too many clients */
owned_body *session_body(session *c, int32_t number);
owned_body *session_add_body(session *c, int32_t number);
void session_add_row(session *c, int32_t number, uint32_t world_id, int64_t pose_sequence); /* of the body added last */
static inline int64_t *session_pose_sequence(session *c, const owned_body *b)
{
    return &c->rows.sequences.at[b - c->bodies.at];
}
void session_count_body(session *c, owned_body *b, uint32_t world_id, size_t shapes);
owned_subscription *session_subscription(session *c, int32_t number);
owned_subscription *session_add_subscription(session *c, int32_t number);
void session_find_subscriptions(session *c);           /* by their numbers, where all have come at once */
int64_t session_newest_sequence(const session *c);     /* of all that it said and was applied */
void session_heard(service *s, const wire_message *m); /* a sign of life, before it is applied */
void session_lost(service *s, session *c, const char *how);
/* A lost client that is heard again, with a message of that kind, is told that it was lost, until it has announced as
 * much as it had. */
void session_remind(service *s, session *c, wire_kind kind);
void session_leave(service *s, session *c);
/* Its goodbye came later than words of the next process under that id: what it had, and nothing else, ends. */
void session_leave_before(service *s, session *c, int64_t sequence);
void session_remember_left(service *s, int64_t client, int64_t sequence);
/* The sequence of its goodbye, if it left a short time ago, or another process under its id has come since; else 0. */
int64_t session_left_at(service *s, int64_t client);
void session_check_leases(service *s);
int64_t session_next_lease_ns(const service *s); /* monotonic; INT64_MAX: none */
void session_ack(session *c, int64_t sequence);
void session_send_acks(service *s);
size_t session_bodies(const session *c); /* in the world */
void session_free_all(service *s);

/* unheard.c: clients that publish, and of whom nothing comes */
void unheard_poses(service *s, const wire_pose_batch *m); /* one has come, whatever becomes of it */
void unheard_word(service *s, const wire_receipt *m);     /* a Receipt of no stream: epoch 0 */
/* Messages were lost on their way, of that client or (0) of whomever. */
void unheard_lost(service *s, const struct link *from, wire_kind kind, int64_t client, size_t count);
void unheard_watch(service *s); /* before each Status */

/* limits.c: what a client may have, and how fast it may talk */
bool limits_admit(service *s, struct link *from, const wire_message *m, wire_refusal *why);
bool limits_bodies(service *s, const session *c, bool is_new, wire_refusal *why);
bool limits_shapes(service *s, const session *c, size_t instead_of, size_t more, wire_refusal *why);
bool limits_subscriptions(service *s, const session *c, wire_refusal *why);
bool limits_geometry(service *s, const session *c, const wire_geometry *m, wire_refusal *why);
bool limits_report_reject(service *s, int64_t client);

#endif
