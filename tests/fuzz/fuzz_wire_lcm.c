/* Any bytes as a message of LCM: refused with a reason and a text, or a legal message whose encoding is those bytes. */
#include "fuzz.h"

#include "wire/wire_lcm.h"

#include <string.h>

static void expect_same_again(wire_memory *memory, const wire_message *m, const uint8_t *data, size_t size)
{
    wire_message again;
    wire_refusal why;
    char channel[WIRE_CHANNEL_MAX];
    uint8_t *bytes = malloc(size);
    PROMISE(wire_lcm_size(m) == size);
    PROMISE(wire_lcm_encode(m, bytes, size) == size);
    PROMISE(memcmp(bytes, data, size) == 0);
    PROMISE(wire_lcm_decode(bytes, size, memory, &again, &why) == WIRE_OK && again.kind == m->kind);
    wire_lcm_channel(m, channel);
    PROMISE(strlen(channel) < WIRE_CHANNEL_MAX);
    free(bytes);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static wire_memory *memory;
    wire_message m;
    wire_refusal why;
    int64_t client, sequence;
    int32_t object;
    if (!memory) memory = wire_memory_create();
    wire_memory_reset(memory);
    wire_reason reason = wire_lcm_decode(data, size, memory, &m, &why);
    PROMISE(reason == why.reason && (reason == WIRE_OK) == !why.text[0]);
    wire_origin(&m, &client, &sequence, &object);
    if (reason == WIRE_OK) expect_same_again(memory, &m, data, size);
    reason = wire_lcm_decode_recorded(data, size, memory, &m, &why);
    PROMISE(reason == why.reason && (reason == WIRE_OK) == !why.text[0]);
    if (reason == WIRE_OK) PROMISE(wire_lcm_size(&m) - size <= 4); /* in which there may be no extensions */
    return 0;
}
