/* wire_log: recordings, written and read front to back. One thread a writer or reader. What holds always: a length read
 * from a file is held against what is left of the file before memory is taken for it. */
#include "wire_log.h"

#include "wire_file.h"

#include <errno.h>
#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SYNC_WORD UINT32_C(0xEDA1DA01)
#define CHANNEL_PREFIX "collided."
#define TICK_CHANNEL CHANNEL_PREFIX "tick"
#define LOST_CHANNEL CHANNEL_PREFIX "lost"
#define STEPS_CHANNEL CHANNEL_PREFIX "steps"
#define LATER_CHANNEL CHANNEL_PREFIX "later"
#define BUILT_CHANNEL CHANNEL_PREFIX "built"
#define STATE_CHANNEL CHANNEL_PREFIX "state"
#define SETTINGS_CHANNEL CHANNEL_PREFIX "settings"

enum {
    HEADER_BYTES = 28,
    TICK_BYTES = 32,
    BUDGETED_TICK_BYTES = 40,
    CUT_TICK_BYTES = 64,
    NUMBER_BYTES = 8,
    BUILD_BYTES = 16,
    STATE_HEAD_BYTES = 24
};

static void store_be(uint8_t *at, uint64_t v, int bytes)
{
    for (int i = bytes - 1; i >= 0; i--, v >>= 8) at[i] = (uint8_t)v;
}

static uint64_t load_be(const uint8_t *at, int bytes)
{
    uint64_t v = 0;
    for (int i = 0; i < bytes; i++) v = v << 8 | at[i];
    return v;
}

__attribute__((format(printf, 3, 4))) static void say(char *why, size_t why_size, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(why, why_size, format, arguments);
    va_end(arguments);
}

/* Room for `size` bytes in a buffer that only grows; false when memory ends. */
static bool reserve(uint8_t **buffer, size_t *capacity, size_t size)
{
    if (size <= *capacity) return true;
    uint8_t *grown = realloc(*buffer, size);
    if (!grown) return false;
    *buffer = grown;
    *capacity = size;
    return true;
}

/* ---- writing ---- */

struct wire_log_writer {
    wire_log_put *put;
    void *context;
    FILE *file; /* its own, or NULL */
    int64_t events;
    int error; /* errno of the first failure; all that follows is refused */
    uint8_t *buffer;
    size_t capacity;
};

static int put_to_file(void *context, const uint8_t *bytes, size_t size)
{
    return size == 0 || fwrite(bytes, size, 1, context) == 1 ? 0 : -1;
}

wire_log_writer *wire_log_create(const char *path, char *why, size_t why_size)
{
    wire_log_writer *w = calloc(1, sizeof *w);
    if (w) w->context = w->file = fopen(path, "wbx");
    if (w) w->put = put_to_file;
    if (w && w->file) return w;
    say(why, why_size, "%s: %s", path, w ? strerror(errno) : "out of memory");
    free(w);
    return NULL;
}

wire_log_writer *wire_log_to(wire_log_put *put, void *context, int64_t first_record)
{
    wire_log_writer *w = calloc(1, sizeof *w);
    if (w) *w = (wire_log_writer){.put = put, .context = context, .events = first_record};
    return w;
}

static int note_error(wire_log_writer *w, int error)
{
    if (!w->error) w->error = error ? error : EIO;
    errno = w->error;
    return -1;
}

static int write_record(wire_log_writer *w, int64_t timestamp_us, const char *channel, const uint8_t *data, size_t size)
{
    if (w->error) return note_error(w, w->error);
    if (size > INT32_MAX) return note_error(w, EFBIG);
    uint8_t header[HEADER_BYTES];
    size_t channel_size = strlen(channel);
    store_be(header, SYNC_WORD, 4);
    store_be(header + 4, (uint64_t)w->events, 8);
    store_be(header + 12, (uint64_t)timestamp_us, 8);
    store_be(header + 20, channel_size, 4);
    store_be(header + 24, size, 4);
    bool written = w->put(w->context, header, sizeof header) == 0 &&
                   w->put(w->context, (const uint8_t *)channel, channel_size) == 0 &&
                   w->put(w->context, data, size) == 0;
    if (!written) return note_error(w, errno);
    w->events++;
    return 0;
}

int wire_log_message(wire_log_writer *w, int64_t timestamp_us, const wire_message *m)
{
    char channel[WIRE_CHANNEL_MAX];
    size_t size = wire_lcm_size(m);
    if (size == 0) return note_error(w, EINVAL);
    if (!reserve(&w->buffer, &w->capacity, size)) return note_error(w, ENOMEM);
    wire_lcm_encode(m, w->buffer, size);
    wire_lcm_channel(m, channel);
    return write_record(w, timestamp_us, channel, w->buffer, size);
}

int wire_log_tick_end(wire_log_writer *w, int64_t timestamp_us, const wire_log_tick *tick)
{
    uint8_t data[CUT_TICK_BYTES];
    bool cut = tick->slice > 0 || tick->pairs_most > 0;
    size_t size = cut ? CUT_TICK_BYTES : tick->budgeted ? BUDGETED_TICK_BYTES : TICK_BYTES;
    store_be(data, (uint64_t)tick->tick, 8);
    store_be(data + 8, (uint64_t)tick->now_ns, 8);
    store_be(data + 16, (uint64_t)tick->monotonic_ns, 8);
    store_be(data + 24, (uint64_t)tick->events_hash, 8);
    store_be(data + 32, (uint64_t)tick->work, 8);
    store_be(data + 40, (uint64_t)tick->slice, 8);
    store_be(data + 48, (uint64_t)(tick->budgeted != 0), 8);
    store_be(data + 56, (uint64_t)tick->pairs_most, 8);
    return write_record(w, timestamp_us, TICK_CHANNEL, data, size);
}

static int write_number(wire_log_writer *w, int64_t timestamp_us, const char *channel, int64_t number)
{
    uint8_t data[NUMBER_BYTES];
    store_be(data, (uint64_t)number, 8);
    return write_record(w, timestamp_us, channel, data, sizeof data);
}

int wire_log_lost(wire_log_writer *w, int64_t timestamp_us, int64_t client)
{
    return write_number(w, timestamp_us, LOST_CHANNEL, client);
}

int wire_log_steps(wire_log_writer *w, int64_t timestamp_us, int64_t done)
{
    return write_number(w, timestamp_us, STEPS_CHANNEL, done);
}

int wire_log_build(wire_log_writer *w, int64_t timestamp_us, int64_t client, int64_t hash, bool ready)
{
    uint8_t data[BUILD_BYTES];
    store_be(data, (uint64_t)client, 8);
    store_be(data + 8, (uint64_t)hash, 8);
    return write_record(w, timestamp_us, ready ? BUILT_CHANNEL : LATER_CHANNEL, data, sizeof data);
}

int wire_log_settings(wire_log_writer *w, int64_t timestamp_us, const char *text)
{
    return write_record(w, timestamp_us, SETTINGS_CHANNEL, (const uint8_t *)text, strlen(text));
}

int wire_log_state_piece(wire_log_writer *w, int64_t timestamp_us, size_t offset, size_t total, uint64_t hash,
    const uint8_t *bytes, size_t size)
{
    if (!reserve(&w->buffer, &w->capacity, STATE_HEAD_BYTES + size)) return note_error(w, ENOMEM);
    store_be(w->buffer, offset, 8);
    store_be(w->buffer + 8, total, 8);
    store_be(w->buffer + 16, hash, 8);
    memcpy(w->buffer + STATE_HEAD_BYTES, bytes, size);
    return write_record(w, timestamp_us, STATE_CHANNEL, w->buffer, STATE_HEAD_BYTES + size);
}

int wire_log_whole_state(wire_log_writer *w, int64_t timestamp_us, const uint8_t *bytes, size_t size, uint64_t hash)
{
    for (size_t at = 0, piece; at < size; at += piece) {
        piece = size - at < WIRE_LOG_PIECE_BYTES ? size - at : WIRE_LOG_PIECE_BYTES;
        if (wire_log_state_piece(w, timestamp_us, at, size, hash, bytes + at, piece) != 0) return -1;
    }
    return 0;
}

int64_t wire_log_leave_state(wire_log_writer *w, size_t size)
{
    int64_t first = w->events;
    w->events += (int64_t)((size + WIRE_LOG_PIECE_BYTES - 1) / WIRE_LOG_PIECE_BYTES);
    return first;
}

int wire_log_close(wire_log_writer *w)
{
    if (!w) return 0;
    if (w->file && fclose(w->file) != 0) note_error(w, errno);
    int error = w->error;
    free(w->buffer);
    free(w);
    errno = error;
    return error ? -1 : 0;
}

/* ---- reading ---- */

struct wire_log_reader {
    FILE *file;
    uint64_t offset, size; /* bytes */
    wire_memory *memory;
    uint8_t *buffer; /* channel and data of a record; never NULL once one was read */
    size_t capacity;
};

typedef struct record {
    uint64_t offset; /* of its header in the file */
    int64_t timestamp_us;
    uint32_t channel_size, data_size;
    const uint8_t *channel, *data;
} record;

static bool find_size(wire_log_reader *r)
{
    long end = fseek(r->file, 0, SEEK_END) == 0 ? ftell(r->file) : -1;
    if (end < 0 || fseek(r->file, 0, SEEK_SET) != 0) return false;
    r->size = (uint64_t)end;
    return true;
}

wire_log_reader *wire_log_open(const char *path, char *why, size_t why_size)
{
    wire_log_reader *r = calloc(1, sizeof *r);
    if (r) r->memory = wire_memory_create();
    if (!r || !r->memory) {
        say(why, why_size, "%s: out of memory", path);
        free(r);
        return NULL;
    }
    char fault[256];
    r->file = wire_file_open(path, UINT64_MAX, NULL, fault, sizeof fault);
    if (r->file && find_size(r)) return r;
    say(why, why_size, "%s: %s", path, r->file ? strerror(errno) : fault);
    wire_log_end(r);
    return NULL;
}

void wire_log_end(wire_log_reader *r)
{
    if (!r) return;
    if (r->file) fclose(r->file);
    wire_memory_destroy(r->memory);
    free(r->buffer);
    free(r);
}

/* NULL, or what is wrong with the record that begins here. */
static const char *read_header(wire_log_reader *r, record *out)
{
    uint8_t header[HEADER_BYTES];
    out->offset = r->offset;
    if (r->size - r->offset < sizeof header) return "the record's head is cut off";
    if (fread(header, sizeof header, 1, r->file) != 1) return "the file cannot be read";
    if (load_be(header, 4) != SYNC_WORD) return "no sync word";
    out->timestamp_us = (int64_t)load_be(header + 12, 8);
    out->channel_size = (uint32_t)load_be(header + 20, 4);
    out->data_size = (uint32_t)load_be(header + 24, 4);
    r->offset += sizeof header;
    if ((uint64_t)out->channel_size + out->data_size > r->size - r->offset) return "the record is longer than the file";
    return NULL;
}

static const char *read_body(wire_log_reader *r, record *out)
{
    size_t size = (size_t)out->channel_size + out->data_size;
    if (!reserve(&r->buffer, &r->capacity, size + 1)) return "no memory for the record";
    if (size && fread(r->buffer, size, 1, r->file) != 1) return "the file cannot be read";
    r->offset += size;
    out->channel = r->buffer;
    out->data = r->buffer + out->channel_size;
    return NULL;
}

static bool on_channel(const record *in, const char *channel)
{
    return in->channel_size == strlen(channel) && memcmp(in->channel, channel, in->channel_size) == 0;
}

static bool is_ours(const record *in)
{
    size_t length = strlen(CHANNEL_PREFIX);
    return in->channel_size > length && memcmp(in->channel, CHANNEL_PREFIX, length) == 0;
}

static const char *decode_tick(const record *in, wire_log_entry *out)
{
    bool cut = in->data_size == CUT_TICK_BYTES;
    bool budgeted = in->data_size == BUDGETED_TICK_BYTES || (cut && load_be(in->data + 48, 8));
    if (in->data_size != TICK_BYTES && in->data_size != BUDGETED_TICK_BYTES && !cut)
        return "a tick has 32 bytes, or 40 with a budget, or 64 where pairs were cut";
    out->kind = WIRE_LOG_TICK;
    out->tick.tick = (int64_t)load_be(in->data, 8);
    out->tick.now_ns = (int64_t)load_be(in->data + 8, 8);
    out->tick.monotonic_ns = (int64_t)load_be(in->data + 16, 8);
    out->tick.events_hash = (int64_t)load_be(in->data + 24, 8);
    out->tick.budgeted = budgeted;
    out->tick.work = budgeted ? (int64_t)load_be(in->data + 32, 8) : 0;
    out->tick.slice = cut ? (int64_t)load_be(in->data + 40, 8) : 0;
    out->tick.pairs_most = cut ? (int64_t)load_be(in->data + 56, 8) : 0;
    if (out->tick.slice < 0 || out->tick.pairs_most < 0) return "a tick's slice or limit of pairs is absurd";
    /* Clocks up to the year 2116, so that differences of their differences are numbers of 64 bits, too. */
    if ((uint64_t)out->tick.tick >> 62) return "a tick's number is absurd";
    if ((uint64_t)out->tick.now_ns >> 62 || (uint64_t)out->tick.monotonic_ns >> 62) return "a tick's clock is absurd";
    return NULL;
}

static const char *decode_lost(const record *in, wire_log_entry *out)
{
    if (in->data_size != NUMBER_BYTES) return "a lost client has 8 bytes";
    out->kind = WIRE_LOG_LOST;
    out->lost_client = (int64_t)load_be(in->data, 8);
    return NULL;
}

static const char *decode_steps(const record *in, wire_log_entry *out)
{
    if (in->data_size != NUMBER_BYTES) return "a number of steps has 8 bytes";
    out->kind = WIRE_LOG_STEPS;
    out->steps_done = (int64_t)load_be(in->data, 8);
    return out->steps_done < 1 ? "a step that is done is above 0" : NULL;
}

static const char *decode_build(const record *in, wire_log_entry *out, bool ready)
{
    if (in->data_size != BUILD_BYTES) return "a build has 16 bytes";
    out->kind = WIRE_LOG_BUILD;
    out->build = (wire_log_built){(int64_t)load_be(in->data, 8), (int64_t)load_be(in->data + 8, 8), ready};
    return NULL;
}

/* It is nowhere said to be longer than the file. */
static const char *decode_state(const wire_log_reader *r, const record *in, wire_log_entry *out)
{
    if (in->data_size <= STATE_HEAD_BYTES) return "a piece of a state has 25 bytes or more";
    out->kind = WIRE_LOG_STATE;
    out->data = in->data + STATE_HEAD_BYTES;
    out->data_size = in->data_size - STATE_HEAD_BYTES;
    out->state = (wire_log_state){load_be(in->data, 8), load_be(in->data + 8, 8), load_be(in->data + 16, 8)};
    if (out->state.total > r->size || out->state.offset > out->state.total) return "a state is longer than the file";
    return out->data_size > out->state.total - out->state.offset ? "a piece is longer than its state" : NULL;
}

static const char *decode_record(wire_log_reader *r, const record *in, wire_log_entry *out, wire_refusal *refusal)
{
    memset(out, 0, sizeof *out);
    out->timestamp_us = in->timestamp_us;
    if (on_channel(in, TICK_CHANNEL)) return decode_tick(in, out);
    if (on_channel(in, LOST_CHANNEL)) return decode_lost(in, out);
    if (on_channel(in, STEPS_CHANNEL)) return decode_steps(in, out);
    if (on_channel(in, LATER_CHANNEL)) return decode_build(in, out, false);
    if (on_channel(in, BUILT_CHANNEL)) return decode_build(in, out, true);
    if (on_channel(in, STATE_CHANNEL)) return decode_state(r, in, out);
    if (on_channel(in, SETTINGS_CHANNEL)) {
        out->kind = WIRE_LOG_SETTINGS;
        out->data = in->data;
        out->data_size = in->data_size;
        return NULL;
    }
    wire_memory_reset(r->memory);
    out->data = in->data;
    out->data_size = in->data_size;
    if (wire_lcm_decode_recorded(in->data, in->data_size, r->memory, &out->message, refusal) == WIRE_OK) return NULL;
    return refusal->text;
}

int wire_log_next(wire_log_reader *r, wire_log_entry *out, uint64_t *skipped, char *why, size_t why_size)
{
    while (r->offset < r->size) {
        record in = {0};
        wire_refusal refusal;
        const char *wrong = read_header(r, &in);
        if (!wrong) wrong = read_body(r, &in);
        bool ours = !wrong && is_ours(&in);
        if (ours) wrong = decode_record(r, &in, out, &refusal);
        if (wrong) {
            say(why, why_size, "damaged at byte %" PRIu64 ": %s", in.offset, wrong);
            return -1;
        }
        if (ours) return 1;
        if (skipped) (*skipped)++;
    }
    return 0;
}
