/* link: a transport. Checked messages in, messages out; it never sees the world.
 *
 * All functions of a link are called by the tick thread alone. A link may have threads of its own (a DDS listener, a
 * reader of the gateway's pipe): they only queue, and wake the tick thread through the eventfd `wake_fd`, with one
 * write when something arrives at a link that had nothing. A link's own thread stands in for the tick thread, and has
 * its lock, while the service runs a round with poses that have just come (link_options.poses): then it calls
 * receive_poses, publish and flush, and nothing else. Incoming messages are decoded and checked (wire_check) before the
 * sink sees them; what is refused goes to sink->refused, and is counted. Nothing here blocks. */
#ifndef COLLIDED_LINK_LINK_H
#define COLLIDED_LINK_LINK_H

#include "base/metrics.h"
#include "peer.h"
#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>

struct link; /* no typedef: unistd.h has a function of that name */

/* What a link calls while it is in link_receive (on the tick thread). */
typedef struct link_sink {
    void *context;
    /* A checked message. It, and what it borrows, is valid during the call only. */
    void (*message)(void *context, struct link *from, const wire_message *m);
    /* A message that was refused. `partial` holds what could be told of it: kind, client and sequence (0 = unknown). */
    void (*refused)(
        void *context, struct link *from, wire_kind kind, int64_t client, int64_t sequence, const wire_refusal *why);
    /* The transport itself noticed that a client has gone (DDS liveliness). A lease by heartbeat (LCM) is the service's
     * business: see link_ops.has_liveliness. */
    void (*client_lost)(void *context, struct link *from, int64_t client);
    /* A reader has come to that stream: it wants the whole current state first. A link that cannot see readers (LCM,
     * memory) takes a stream's opening for the coming of its first. */
    void (*stream_reader)(void *context, struct link *from, const char *stream);
    /* A recording began in the middle, when the clients in lock-step had done that step. Replay alone calls it; NULL:
     * nobody wants to know. */
    void (*steps_done)(void *context, int64_t step);
    /* A recording began in the middle with this state, which holds all that came before it. Replay alone calls it;
     * NULL: what was announced until then is enough. */
    void (*state)(void *context, const uint8_t *bytes, size_t size);
    /* In this tick the build of a geometry was put off, or was over. Replay alone calls it; NULL: all is built when it
     * has come. */
    void (*build)(void *context, int64_t client, int64_t hash, bool ready);
    /* So much has changed by poses that a tick is due before there are more: what waits in the link, but for a first
     * batch, waits for the next round. NULL: never. */
    bool (*enough)(void *context);
    /* How many poses of a batch, from its first, may be handed over before a tick is due, at least one: of bodies of
     * many shapes a batch may be more than a tick takes. *work: what these take then, in nanoseconds, if that is more
     * than is usual; otherwise 0. What is left of a batch is handed over in parts, of which only the last has the step.
     * NULL: all. */
    size_t (*room)(void *context, const wire_pose_batch *m, uint64_t *work);
    /* So much has come in this receive, of all kinds, that to take more would keep everybody waiting: what waits in the
     * link, but for a first take of each kind, waits for the next round. NULL: never. */
    bool (*much)(void *context);
    /* Somebody has come who reads Status, and may not get the one that was sent last. NULL: nobody wants to know. */
    void (*status_reader)(void *context, struct link *from);
    /* So many messages of that kind, at least, were lost on their way, or had to be dropped. `client`: whose they were;
     * 0: nobody knows. NULL: nobody wants to know. */
    void (*lost)(void *context, struct link *from, wire_kind kind, int64_t client, size_t count);
} link_sink;

static inline bool link_has_much(const link_sink *sink)
{
    return sink->much && sink->much(sink->context);
}

/* Of a batch: its first poses go into *part, the rest stays; the step is that of the rest. */
void link_cut_poses(wire_pose_batch *rest, uint32_t count, wire_pose_batch *part);
/* How many poses of it may be handed over now, and the work that they are. */
size_t link_room_for(const link_sink *sink, const wire_message *m, uint64_t *work); /* SIZE_MAX: all */
/* As many bytes as are charged for it in turns: as of poses of which each takes a microsecond. */
static inline size_t link_bytes_of_work(uint64_t ns)
{
    return (size_t)(ns * 64 / 1000);
}

typedef struct link_options {
    int wake_fd;           /* eventfd of the tick thread */
    metrics *counters;     /* where it registers "dds_messages_in", "lcm_gateway_restarts", ... */
    const char *address;   /* what follows the scheme; link_open sets it */
    const char *interface; /* network interface or address; "" = loopback only */
    const char *security;  /* DDS: folder of certificates and permissions; "" = no security */
    const char *program;   /* LCM: path of collided-lcm; "" = beside this executable */
    size_t max_clients;    /* DDS: clients whose speakers it remembers; 0: any number ... */
    size_t client_share;   /* ... and of these one participant's; 0: all */
    bool rooms;            /* DDS on loopback: a crowd may be spread over rooms (wire_dds_qos.h) */
    bool must_start;       /* LCM: a gateway that does not start at all is an error; otherwise it is tried again */
    /* Poses have come and nothing else waits: the link offers the service to run a round on the thread that they came
     * on, which saves handing them to the tick thread. The service never waits for a lock there. False: not now, the
     * tick thread is to be woken. NULL: never. The link holds no lock of its own meanwhile. */
    bool (*poses)(void *context, struct link *from);
    void *poses_context;
} link_options;

/* Two links with the same key would be one: they would hear everything twice. */
enum { LINK_KEY_MAX = 128 };

typedef struct link_ops {
    const char *scheme;  /* "dds", "lcm", "memory", "replay", "pipe" */
    size_t size;         /* bytes of the link's own struct, which begins with a link; it starts out as zeros */
    bool has_liveliness; /* it reports lost clients itself */
    bool acknowledges;   /* its clients repeat messages until acknowledged */
    bool loses_nothing;  /* whatever is published waits until it is read: a stream need keep nothing back */
    bool announces;      /* others notice when it is opened: of several links, it is opened last */
    /* What can be told of an address without opening it: see link_check. */
    int (*check)(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size);
    /* 0, or -1 with a line in `why` that says what failed and what to do; nothing is then left to close. */
    int (*open)(struct link *l, const link_options *options, char *why, size_t why_size);
    /* Takes everything that has come. The number of messages handed over. */
    size_t (*receive)(struct link *l, const link_sink *sink);
    /* Takes poses that have come, and nothing else, during link_options.poses; if more are left, the tick thread has
     * been woken. */
    size_t (*receive_poses)(struct link *l, const link_sink *sink);
    /* Sends, or queues until flush. A message that cannot be sent is counted, by cause, and never blocks. */
    void (*publish)(struct link *l, const wire_message *m);
    void (*flush)(struct link *l); /* once a tick */
    /* A stream of that client begins or ends to exist; publish of an EventBatch goes to the stream of that name. Opened
     * again, it tells of the readers that are there. */
    void (*stream_open)(struct link *l, const char *stream, int64_t client);
    void (*stream_close)(struct link *l, const char *stream);
    /* One line for people: what it listens on, and who can reach it. */
    void (*describe)(struct link *l, char *text, size_t size);
    const peer_ops *peers; /* NULL: it carries no pairs of daemons */
    void (*close)(struct link *l);
} link_ops;

struct link { /* the head of each link's own struct */
    const link_ops *ops;
    link_options options;
    /* Of the message that is being handed over: who sent it, as far as the link can tell, whatever client it names (a
     * participant of DDS, an end of memory): the same number for the same one as long as it lives; 0 = it cannot. */
    int64_t origin;
    bool in_parts;  /* what is handed over now is a part of a batch of poses, and not the last one */
    bool unclaimed; /* the link could not note who speaks for its client: it must not begin a session */
};

#endif
