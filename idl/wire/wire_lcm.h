/* wire_lcm: messages to and from LCM's encoding, by our own bounds-checked code (lcm-gen's decoders trust the counts).
 * Recordings and the pipe from the gateway use the same encoding. */
#ifndef COLLIDED_WIRE_LCM_H
#define COLLIDED_WIRE_LCM_H

#include "wire.h"

/* A growing stock of memory for decoded arrays; wire_memory_reset keeps it for the next message. One thread. */
typedef struct wire_memory wire_memory;
wire_memory *wire_memory_create(void);
void wire_memory_destroy(wire_memory *m);
void wire_memory_reset(wire_memory *m);
void *wire_memory_take(wire_memory *m, size_t bytes);

/* LCM's fingerprint of a kind: the first 8 bytes of its encoding, big-endian. */
int64_t wire_lcm_fingerprint(wire_kind kind);
wire_kind wire_lcm_kind(const void *data, size_t size); /* by fingerprint; WIRE_NOTHING if none fits */

/* Bytes that wire_lcm_encode writes. */
size_t wire_lcm_size(const wire_message *m);
/* The number of bytes written, or 0 if `capacity` is too small. */
size_t wire_lcm_encode(const wire_message *m, void *out, size_t capacity);

/* Decodes and checks (wire_check). Any bytes are safe: every count is held against what is left of the buffer and the
 * field's limit before anything is taken. Arrays live in `memory`. What is refused leaves in `out` its kind and the
 * fields before the fault, so that wire_origin can tell whose it was. */
wire_reason wire_lcm_decode(
    const void *data, size_t size, wire_memory *memory, wire_message *out, wire_refusal *refusal);
/* The same of a message in a recording, which may have been made before messages had extensions. */
wire_reason wire_lcm_decode_recorded(
    const void *data, size_t size, wire_memory *memory, wire_message *out, wire_refusal *refusal);

/* The channel a message travels on: "collided.in.PoseBatch", "collided.out.Status",
 * "collided.out.EventBatch.<stream>", "collided.out.Answer.<client as 16 hex digits>". At most WIRE_CHANNEL_MAX - 1
 * bytes (LCM's limit is 63 characters): a longer stream name is replaced by its hash. */
enum { WIRE_CHANNEL_MAX = 64 };
void wire_lcm_channel(const wire_message *m, char channel[WIRE_CHANNEL_MAX]);
void wire_lcm_stream_channel(const char *stream, char channel[WIRE_CHANNEL_MAX]);

#endif
