/* pipe: the frames between daemon and gateway. Plain functions on the caller's buffers; one thread at a time a buffer.
 */
#include "pipe.h"

#include "base/array.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>

enum { SIZE_BYTES = 4, HEAD_BYTES = SIZE_BYTES + 2, READ_BYTES = 256 << 10 };

void pipe_free(pipe_buffer *b)
{
    free(b->at);
    *b = (pipe_buffer){0};
}

/* Room for `more` bytes at the end. What is used moves to the front once the free part before it is the larger one, so
 * that each byte is moved less than once on average. */
static uint8_t *room(pipe_buffer *b, size_t more)
{
    if (b->begin > pipe_used(b)) {
        memmove(b->at, b->at + b->begin, pipe_used(b));
        b->end -= b->begin;
        b->begin = 0;
    }
    if (b->end + more > b->capacity) b->at = array_grow(b->at, &b->capacity, b->end + more, 1);
    return b->at + b->end;
}

static void drop_front(pipe_buffer *b, size_t bytes)
{
    b->begin += bytes;
    if (b->begin == b->end) b->begin = b->end = 0;
}

size_t pipe_frame_size(size_t channel_length, size_t size)
{
    return HEAD_BYTES + channel_length + size;
}

static uint8_t *put(pipe_buffer *b, pipe_kind kind, const char *channel, size_t channel_length, size_t size)
{
    size_t whole = pipe_frame_size(channel_length, size);
    uint8_t *at = room(b, whole);
    uint32_t rest = (uint32_t)(whole - SIZE_BYTES);
    memcpy(at, &rest, SIZE_BYTES);
    at[4] = (uint8_t)kind;
    at[5] = (uint8_t)channel_length;
    memcpy(at + HEAD_BYTES, channel, channel_length);
    b->end += whole;
    return at + HEAD_BYTES + channel_length;
}

uint8_t *pipe_put(pipe_buffer *b, pipe_kind kind, const char *channel, size_t size)
{
    return put(b, kind, channel, strlen(channel), size);
}

void pipe_put_frame(pipe_buffer *b, const pipe_frame *f)
{
    uint8_t *data = put(b, f->kind, f->channel, f->channel_length, f->size);
    if (f->size) memcpy(data, f->data, f->size);
}

/* Bytes of the frame at the front, 0 if not even its size is there. */
static size_t front_size(const pipe_buffer *b)
{
    uint32_t rest;
    if (pipe_used(b) < SIZE_BYTES) return 0;
    memcpy(&rest, b->at + b->begin, SIZE_BYTES);
    return SIZE_BYTES + (size_t)rest;
}

int pipe_take(pipe_buffer *b, pipe_frame *out)
{
    size_t whole = front_size(b);
    if (whole == 0) return 0;
    if (whole < HEAD_BYTES || whole > pipe_frame_size(PIPE_CHANNEL_MAX, PIPE_DATA_MAX)) return -1;
    if (pipe_used(b) < whole) return 0;
    const uint8_t *at = b->at + b->begin;
    size_t channel_length = at[5];
    if (at[4] < PIPE_MESSAGE || at[4] > PIPE_DROPPED || channel_length > PIPE_CHANNEL_MAX ||
        HEAD_BYTES + channel_length > whole)
        return -1;
    *out = (pipe_frame){
        .kind = (pipe_kind)at[4],
        .channel = (const char *)at + HEAD_BYTES,
        .channel_length = channel_length,
        .data = at + HEAD_BYTES + channel_length,
        .size = whole - HEAD_BYTES - channel_length,
    };
    drop_front(b, whole);
    return 1;
}

int64_t pipe_read(pipe_buffer *b, int fd)
{
    uint8_t *at = room(b, READ_BYTES);
    ssize_t n = recv(fd, at, READ_BYTES, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    if (n <= 0) return -1;
    b->end += (size_t)n;
    return n;
}

/* Passes over the frames that are wholly sent. */
static void settle_sent(pipe_buffer *b)
{
    for (size_t whole = front_size(b); whole && b->sent >= whole; whole = front_size(b)) {
        b->sent -= whole;
        drop_front(b, whole);
    }
}

bool pipe_send(pipe_buffer *b, int fd)
{
    while (pipe_used(b) > b->sent) {
        ssize_t n = send(fd, b->at + b->begin + b->sent, pipe_used(b) - b->sent, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return errno == EAGAIN;
        b->sent += (size_t)n;
        settle_sent(b);
    }
    return true;
}

void pipe_resend(pipe_buffer *b)
{
    b->sent = 0;
}

void pipe_put_refusal(pipe_buffer *b, const pipe_refusal *r)
{
    memcpy(pipe_put(b, PIPE_REFUSAL, "", sizeof *r), r, sizeof *r);
}

bool pipe_get_refusal(const pipe_frame *f, pipe_refusal *out)
{
    if (f->kind != PIPE_REFUSAL || f->size != sizeof *out) return false;
    memcpy(out, f->data, sizeof *out);
    out->text[sizeof out->text - 1] = '\0';
    return out->kind >= WIRE_NOTHING && out->kind < WIRE_KIND_COUNT && out->reason > WIRE_OK &&
           out->reason < WIRE_REASON_COUNT;
}
