/* Writes the binary seeds of the corpus: one message of each kind, a recording, a few frames of the gateway's pipe.
 * Run by hand when the wire changes: make_seeds tests/fuzz/corpus */
#include "sample.h"

#include "pipe/pipe.h"
#include "wire/wire_log.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { MOST = 2 };

static void write_file(const char *folder, const char *name, const void *bytes, size_t size)
{
    char path[512];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *f = fopen(path, "wb");
    if (!f || fwrite(bytes, 1, size, f) != size || fclose(f) != 0) {
        perror(path);
        exit(1);
    }
}

static void write_messages(const char *folder, sampler *s, pipe_buffer *frames)
{
    char name[64], channel[WIRE_CHANNEL_MAX];
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++) {
        wire_message m = sample_message(s, (wire_kind)kind, MOST);
        size_t size = wire_lcm_size(&m);
        wire_lcm_channel(&m, channel);
        uint8_t *at = pipe_put(frames, PIPE_MESSAGE, channel, size);
        wire_lcm_encode(&m, at, size);
        snprintf(name, sizeof name, "wire_lcm/%s", wire_kind_name((wire_kind)kind));
        write_file(folder, name, at, size);
    }
}

static void write_frames(const char *folder, pipe_buffer *frames)
{
    pipe_refusal refusal = {WIRE_BODY, WIRE_BAD_SIZE, 1, 2, "shape_sizes[0] is -1 m: 0 to 1e+09 is allowed"};
    pipe_put_refusal(frames, &refusal);
    pipe_put(frames, PIPE_READY, "", 0);
    write_file(folder, "pipe/frames", frames->at + frames->begin, pipe_used(frames));
}

static void write_log(const char *folder, sampler *s)
{
    char path[512], why[256];
    snprintf(path, sizeof path, "%s/wire_log/recording", folder);
    unlink(path);
    wire_log_writer *w = wire_log_create(path, why, sizeof why);
    for (int kind = WIRE_CLIENT; w && kind <= WIRE_QUERY; kind++) {
        wire_message m = sample_message(s, (wire_kind)kind, MOST);
        wire_log_message(w, 1000, &m);
    }
    wire_log_tick tick = {1, 2, 3, 4, 1, 5, 6, 0};
    if (!w || wire_log_tick_end(w, 2000, &tick) || wire_log_lost(w, 3000, 5) || wire_log_close(w)) {
        fprintf(stderr, "%s: not written\n", path);
        exit(1);
    }
}

int main(int argc, char **argv)
{
    if (argc != 2) return fprintf(stderr, "usage: make_seeds tests/fuzz/corpus\n"), 2;
    sampler s = {.random = 1, .memory = wire_memory_create()};
    pipe_buffer frames = {0};
    write_messages(argv[1], &s, &frames);
    write_frames(argv[1], &frames);
    write_log(argv[1], &s);
    pipe_free(&frames);
    wire_memory_destroy(s.memory);
    return 0;
}
