/* commands: from what came to what is carried out: the inbox, bodies that wait, poses, steps, queries. Tick thread. */
#ifndef COLLIDED_SERVICE_COMMANDS_H
#define COLLIDED_SERVICE_COMMANDS_H

#include "service.h"

/* inbox.c */
void inbox_put(service *s, struct link *from, const wire_message *m);
void inbox_put_lost(service *s, struct link *from, int64_t client);
void inbox_apply(service *s);
void inbox_answer(service *s); /* the queries among them; after the tick */

/* pending.c */
/* That command, a Body, was tried in vain: s->carried.lacks says why. Answered, if a limit refuses it. */
void pending_put(service *s, const command *l, const wire_body *m);
/* Is it newer than what waits of the same body for a build, or the same, or older? */
typedef enum pending_copy { PENDING_NEWER, PENDING_SAME, PENDING_OLDER } pending_copy;
pending_copy pending_is_copy(const service *s, const session *c, const wire_body *m);
/* It has been carried out, or waits: what waited for a build before it is gone, but its pose, if that is newer. */
void pending_supersede(service *s, session *c, const wire_body *m, kept_pose *pose);
bool pending_wake(service *s); /* those that may be tried become commands again, behind the others: were there any? */
bool pending_due(const service *s);
void pending_tidy(service *s);             /* after the commands of a tick: until then some places are of nobody */
void pending_wait_anew(service *s);        /* they have waited for nothing yet */
int64_t pending_next_ns(const service *s); /* when one of them has waited too long, monotonic; INT64_MAX: never */
bool pending_needs(const session *c, int64_t hash); /* one of its bodies that wait for a build */
bool pending_keeps_pose(service *s, session *c, const wire_pose_batch *m, uint32_t i); /* of a body that waits */
void pending_forget(service *s, int64_t client, int64_t before); /* of that client, announced before */
void pending_restore(service *s, pending_body *p);               /* becomes the service's */
void pending_free_all(service *s);

/* poses.c */
void apply_note_simulation(simulation_mark *last, int64_t tick, int64_t simulation_ns);
void apply_poses(service *s, struct link *from, const wire_pose_batch *m, bool may_wait);
void apply_forget_refused(session *c, int64_t tick, int64_t step); /* before the poses of that step */
void apply_count_refused(session *c, uint32_t more, wire_reason reason);
void poses_note_step(service *s, session *c, int64_t step); /* of a frame of vertices */
bool poses_are_enough(const service *s);                    /* for a tick: what they move is worth one */
/* See link_sink.room. */
size_t poses_room(service *s, const wire_pose_batch *m, uint64_t *work);
void apply_poses_now(service *s, session *c, struct link *from, const wire_pose_batch *m); /* c: NULL if unknown */
void poses_give(service *s, session *c, const owned_body *b, const kept_pose *p);          /* if none is newer */
void poses_free(service *s);

/* apply.c */
/* False: it names a hull that has not come; nothing was done, and it may be tried again. */
bool apply_command(service *s, struct link *from, const wire_message *m, bool may_wait);
void apply_reject(service *s, struct link *to, wire_kind kind, int64_t client, int64_t sequence, int32_t object,
    const wire_refusal *why);
/* Fills in *why: the reason, which it returns, and a line that names what is wrong. */
wire_reason apply_refuse(wire_refusal *why, wire_reason reason, const char *format, ...)
    __attribute__((format(printf, 3, 4)));
void apply_name_limit(service *s, const char *option); /* it is reached */
bool apply_limit(service *s, size_t now, long most, const char *option, wire_refusal *why);

/* steps.c */
/* The sequence of what the daemon says in a client's name, and records. A batch without bodies ends a step for a client
 * that missed it: what it published of it is dropped. One with a body says that poses of that step were refused. */
#define STEP_IN_ITS_NAME INT64_MAX
bool steps_admit(const service *s, const wire_message *m, wire_refusal *why); /* that sequence is not for clients */
bool steps_take(service *s, session *c, struct link *from, const wire_pose_batch *m); /* true: it is of lock-step */
void steps_refused(service *s, struct link *from, const wire_message *m); /* for its rate: it has not been recorded */
void steps_join(service *s, session *c, int32_t lock_step);               /* 0: leaves */
bool steps_due(const service *s);           /* a step is complete, or asked for again: a tick is due */
uint64_t steps_effort(const service *s);    /* units of world_effort that steps_complete will bring */
void steps_complete(service *s);            /* applies a step that is */
void steps_watch(service *s);               /* who misses a step; before each round, not in a replay */
int64_t steps_next_ns(const service *s);    /* when somebody may miss one, monotonic; INT64_MAX: nobody */
void steps_settle(service *s);              /* after the world's tick: who may be answered */
void steps_began(service *s, int64_t done); /* a replay begins in the middle, before its first tick */
void steps_record(service *s, session *c);
void steps_free(session *c);

/* answer.c */
void answer_query(service *s, struct link *from, const wire_query *q);
void answer_owed(service *s); /* to who ended a recording */

#endif
