/* Any bytes as what a gateway that was taken over sends to the daemon: frames within the bytes, or no frames. */
#include "fuzz.h"

#include "pipe/pipe.h"
#include "wire/wire_lcm.h"

#include <string.h>

static void use(const pipe_frame *f, wire_memory *memory)
{
    wire_message m;
    wire_refusal why;
    pipe_refusal refusal;
    PROMISE(f->channel_length <= PIPE_CHANNEL_MAX && f->size <= PIPE_DATA_MAX);
    if (pipe_get_refusal(f, &refusal)) PROMISE(memchr(refusal.text, '\0', sizeof refusal.text));
    wire_memory_reset(memory);
    if (f->kind == PIPE_MESSAGE) wire_lcm_decode(f->data, f->size, memory, &m, &why);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static wire_memory *memory;
    if (!memory) memory = wire_memory_create();
    pipe_buffer in = {.at = malloc(size + 1), .end = size, .capacity = size}, copy = {0};
    pipe_frame f, same;
    int got;
    memcpy(in.at, data, size);
    while ((got = pipe_take(&in, &f)) == 1) {
        use(&f, memory);
        pipe_put_frame(&copy, &f);
        PROMISE(pipe_take(&copy, &same) == 1 && same.kind == f.kind && same.size == f.size);
        PROMISE(f.size == 0 || memcmp(same.data, f.data, f.size) == 0);
    }
    PROMISE(got == 0 || got == -1);
    pipe_free(&in);
    pipe_free(&copy);
    return 0;
}
