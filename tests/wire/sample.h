/* sample: random legal messages of every kind, and whether two messages say the same. One thread a sampler. */
#ifndef COLLIDED_TESTS_WIRE_SAMPLE_H
#define COLLIDED_TESTS_WIRE_SAMPLE_H

#include "wire/wire_lcm.h"
#include "wire/wire_schema.h"

typedef struct sampler {
    uint64_t random; /* splitmix64's state */
    wire_memory *memory;
} sampler;

uint64_t sample_next(sampler *s);
uint32_t sample_below(sampler *s, uint32_t bound);

/* A message that wire_check accepts, of up to `most` bodies, shapes, events or hits. It borrows from the sampler. */
wire_message sample_message(sampler *s, wire_kind kind, uint32_t most);

/* The first field in which two messages differ in any bit, NULL if there is none. */
const char *sample_difference(const wire_message *a, const wire_message *b);

#endif
