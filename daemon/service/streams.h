/* streams: the world's events to the links, and what waits for slow readers. Tick thread. */
#ifndef COLLIDED_SERVICE_STREAMS_H
#define COLLIDED_SERVICE_STREAMS_H

#include "service.h"

/* stream.c */
bool stream_taken(service *s, const session *c, const wire_subscription *m, uint32_t world_id, wire_refusal *why);
void stream_open(service *s, session *c, const wire_subscription *m, uint32_t world_id);
void stream_end(service *s, uint32_t world_id, uint8_t cause); /* and the subscription with it, in the next tick */
void stream_close(service *s, uint32_t world_id);
/* stream_names.c: to be found by its name, which has to be there, and by whether it ends. */
void stream_names_add(service *s, uint32_t world_id);
void stream_names_drop(service *s, uint32_t world_id);
stream *stream_named(service *s, const char *name);        /* the open one, or NULL */
const stream *stream_ending(service *s, const char *name); /* the one of them that ended last, or NULL */
void stream_reader(service *s, struct link *from, const char *name);
bool stream_lacks_reader(service *s, const char *name); /* it is open, and none has come */
/* What the tick tells, snapshots apart, on every stream, whether it has a reader or not: as it is recorded. The message
 * is valid during the visit. Before stream_publish, which closes streams. */
typedef void stream_visit(void *context, const wire_message *m);
void stream_each(service *s, const world_batches *batches, stream_visit *visit, void *context);
void stream_ask_all(service *s); /* before the tick: lock-step clients are told also what is as it was */
void stream_publish(service *s, const world_batches *batches);
void stream_heartbeats(service *s); /* on those that have been silent for a period */
void stream_beat_all(service *s);   /* on all, now: a replay that stands still */
void stream_free_all(service *s);
/* Of a client of the recording that is replayed: nobody hears it. */
static inline bool stream_is_replayed(const service *s, const stream *to)
{
    return s->replaying && to->link == s->links[0];
}

/* A batch of the stream in which nothing but these records is. False: its reader is to have a snapshot instead. */
bool stream_tell(service *s, stream *to, wire_u8s extensions);

/* scene.c */
void scene_subscribed(service *s, stream *to, const wire_subscription *m); /* anew, or again: then all is told again */
void scene_read_anew(stream *to);                                          /* its reader has lost what it knew */
void scene_watch(service *s);                                              /* tells what is due; each round */
int64_t scene_next_ns(const service *s); /* when that is, monotonic; INT64_MAX: nobody looks, or nothing was done */
void scene_free(struct scene_view *view);
/* What matches no body: the world has nothing to do for a scene. */
extern const char SCENE_NO_BODY[];

void stream_receipt(service *s, const wire_receipt *m);

/* backlog.c */
bool backlog_is_behind(const backlog *b); /* something waits */
int64_t backlog_count(const backlog *b);  /* so many messages */
bool backlog_is_passed(const service *s, const stream *to, const world_batch *batch, int32_t parts);
bool backlog_begin(service *s, stream *to, const world_batch *batch); /* false: it is not kept, but skipped */
void backlog_skip(service *s, stream *to, int32_t parts);
void backlog_put(stream *to, const wire_message *m);
/* A snapshot that comes in portions: with the head of its parts; a part, whose number it fills in; and all of them, in
 * front of what has come to wait since. */
void backlog_build(service *s, stream *to, const wire_event_batch *head);
void backlog_add_built(service *s, stream *to, wire_message *m);
void backlog_built(service *s, stream *to);
void backlog_send(service *s, stream *to); /* as much as may be under way */
void backlog_receipt(service *s, stream *to, const wire_receipt *m);
void backlog_watch(service *s); /* sends what is due, and finds out who starves; each round */
void backlog_clear(backlog *b);
void backlog_free(backlog *b);

#endif
