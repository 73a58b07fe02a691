/* pipe: what the daemon and collided-lcm say to each other over a pair of stream sockets: frames of a message's channel
 * and bytes, in both directions; refusals, the word that it is ready, and what was dropped, towards the daemon.
 *
 * A frame: size of the rest (u32, host order: both ends are on this machine), kind (u8), length of the channel (u8),
 * channel, data. The peer may be compromised (that is why it is a process of its own): every length is checked. No
 * threads of its own. */
#ifndef COLLIDED_PIPE_PIPE_H
#define COLLIDED_PIPE_PIPE_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    PIPE_FD = 3,              /* the gateway's end, when it starts */
    PIPE_DATA_MAX = 16 << 20, /* bytes of a frame's data; the largest legal message, a full PoseBatch, has 7 MB */
    PIPE_CHANNEL_MAX = 63,    /* bytes, LCM's limit */
    PIPE_EXIT_USAGE = 2,      /* how the gateway ends: wrong arguments, ... */
    PIPE_EXIT_NETWORK = 3     /* ... or the network refuses LCM, and standard error says what to do */
};

typedef enum pipe_kind {
    PIPE_MESSAGE = 1,
    PIPE_REFUSAL = 2,
    /* LCM runs. The daemon sends nothing before: what a gateway that cannot start would swallow is lost */
    PIPE_READY = 3,
    PIPE_DROPPED = 4 /* u32, host order: so many datagrams more were dropped by the kernel */
} pipe_kind;

typedef struct pipe_frame { /* borrows from the buffer */
    pipe_kind kind;
    const char *channel; /* not terminated */
    size_t channel_length;
    const uint8_t *data;
    size_t size;
} pipe_frame;

/* A queue of frames as plain bytes. It always begins at a frame's begin, so that whatever was sent of its first frame
 * to a peer that has died can be sent again to the next one. */
typedef struct pipe_buffer {
    uint8_t *at;
    size_t begin, end, capacity;
    size_t sent; /* of the first frame, by pipe_send */
} pipe_buffer;

void pipe_free(pipe_buffer *b);
static inline size_t pipe_used(const pipe_buffer *b)
{
    return b->end - b->begin;
}

/* Bytes that a frame takes. */
size_t pipe_frame_size(size_t channel_length, size_t size);

/* Appends a frame and returns where its `size` bytes of data are to be written. */
uint8_t *pipe_put(pipe_buffer *b, pipe_kind kind, const char *channel, size_t size);
void pipe_put_frame(pipe_buffer *b, const pipe_frame *f); /* a copy */

/* Takes the next frame, if it is whole: 1. 0: not yet. -1: this is no frame, and nothing after it can be trusted. */
int pipe_take(pipe_buffer *b, pipe_frame *out);

/* Reads what is there. Bytes, 0 = nothing now, -1 = the peer is gone. */
int64_t pipe_read(pipe_buffer *b, int fd);
/* Sends what the socket takes now; the rest stays. False: the peer is gone. Never raises SIGPIPE. */
bool pipe_send(pipe_buffer *b, int fd);
void pipe_resend(pipe_buffer *b); /* the peer is a new one: the first frame starts over */

/* A refusal as data of a frame: written and read here, because both ends must agree. */
typedef struct pipe_refusal {
    int32_t kind;   /* wire_kind, WIRE_NOTHING = cannot be told */
    int32_t reason; /* wire_reason */
    int64_t client;
    int64_t sequence;
    char text[256]; /* as in wire_refusal */
} pipe_refusal;
void pipe_put_refusal(pipe_buffer *b, const pipe_refusal *r);
bool pipe_get_refusal(const pipe_frame *f, pipe_refusal *out); /* false: not a refusal, or out of range */

#endif
