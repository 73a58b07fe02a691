/* mcap: records, chunk by chunk. Each record is an opcode, the size of the rest (u64) and the rest; numbers are
 * little-endian; texts and arrays are preceded by their size in octets (u32). */
#include "mcap.h"

#include "index.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include <zlib.h>

enum {
    OP_HEADER = 1,
    OP_FOOTER,
    OP_SCHEMA,
    OP_CHANNEL,
    OP_MESSAGE,
    OP_CHUNK,
    OP_MESSAGE_INDEX,
    OP_CHUNK_INDEX,
    OP_STATISTICS = 11,
    OP_METADATA,
    OP_METADATA_INDEX,
    OP_SUMMARY_OFFSET,
    OP_DATA_END
};
enum { CHUNK_BYTES = 1 << 20, RECORD_HEAD = 9 };
static const unsigned char MAGIC[8] = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};

typedef struct octets {
    unsigned char *at;
    size_t count, capacity;
} octets;

typedef struct index_entry { /* of a message in the chunk that is being filled */
    uint64_t time, offset;
    uint16_t channel;
} index_entry;

typedef struct channel_count {
    uint64_t messages;
    uint64_t index_at; /* of the last chunk: where its message index stands; 0: none */
} channel_count;

struct mcap {
    FILE *out;
    char *path;
    int failed; /* errno of the first failure */
    uint64_t at;
    uint32_t crc;             /* of what was written since the file's, or the summary's, begin */
    octets schemas, channels; /* their records, for the summary */
    octets chunk, chunk_indexes, metadata_indexes, scratch;
    index_entry *entries;
    size_t entry_count, entry_capacity;
    channel_count *counts; /* by channel - 1 */
    size_t count_capacity;
    uint16_t schema_count, channel_count;
    uint64_t begin, end, chunk_begin, chunk_end; /* least and greatest times */
    uint64_t messages;
    uint32_t chunks, metadata;
};

/* ---- octets ---- */

static void put_bytes(octets *o, const void *at, size_t size)
{
    o->at = web_reserve(o->at, &o->capacity, o->count + size, 1);
    if (size) memcpy(o->at + o->count, at, size);
    o->count += size;
}

static void put_uint(octets *o, uint64_t value, size_t size)
{
    unsigned char bytes[8];
    for (size_t i = 0; i < size; i++) bytes[i] = (unsigned char)(value >> 8 * i);
    put_bytes(o, bytes, size);
}

static void put_string(octets *o, const char *text)
{
    size_t size = strlen(text);
    put_uint(o, size, 4);
    put_bytes(o, text, size);
}

/* Begins a record; its size is filled in by end_record. */
static size_t begin_record(octets *o, uint8_t opcode)
{
    put_uint(o, opcode, 1);
    put_uint(o, 0, 8);
    return o->count;
}

static void set_uint(octets *o, size_t where, uint64_t value, size_t size)
{
    for (size_t i = 0; i < size; i++) o->at[where + i] = (unsigned char)(value >> 8 * i);
}

static void end_record(octets *o, size_t began)
{
    set_uint(o, began - 8, o->count - began, 8);
}

/* ---- the file ---- */

static void write_out(mcap *m, const void *at, size_t size)
{
    if (size && !m->failed && fwrite(at, 1, size, m->out) != size) m->failed = errno ? errno : EIO;
    m->crc = (uint32_t)crc32_z(m->crc, at, size);
    m->at += size;
}

static void write_scratch(mcap *m)
{
    write_out(m, m->scratch.at, m->scratch.count);
    m->scratch.count = 0;
}

mcap *mcap_create(const char *path, const char *library)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd < 0) return NULL;
    mcap *m = web_allocate(1, sizeof *m);
    m->out = fdopen(fd, "wb");
    m->path = memcpy(web_allocate(strlen(path) + 1, 1), path, strlen(path) + 1);
    m->begin = m->chunk_begin = UINT64_MAX;
    write_out(m, MAGIC, sizeof MAGIC);
    size_t began = begin_record(&m->scratch, OP_HEADER);
    put_string(&m->scratch, ""); /* profile */
    put_string(&m->scratch, library);
    end_record(&m->scratch, began);
    write_scratch(m);
    return m;
}

uint16_t mcap_add_schema(mcap *m, const char *name, const char *encoding, const char *data)
{
    size_t from = m->schemas.count, began = begin_record(&m->schemas, OP_SCHEMA);
    put_uint(&m->schemas, ++m->schema_count, 2);
    put_string(&m->schemas, name);
    put_string(&m->schemas, encoding);
    put_string(&m->schemas, data);
    end_record(&m->schemas, began);
    put_bytes(&m->chunk, m->schemas.at + from, m->schemas.count - from);
    return m->schema_count;
}

uint16_t mcap_add_channel(mcap *m, uint16_t schema, const char *topic, const char *encoding)
{
    size_t from = m->channels.count, began = begin_record(&m->channels, OP_CHANNEL);
    put_uint(&m->channels, ++m->channel_count, 2);
    put_uint(&m->channels, schema, 2);
    put_string(&m->channels, topic);
    put_string(&m->channels, encoding);
    put_uint(&m->channels, 0, 4); /* no metadata */
    end_record(&m->channels, began);
    put_bytes(&m->chunk, m->channels.at + from, m->channels.count - from);
    m->counts = web_reserve(m->counts, &m->count_capacity, m->channel_count, sizeof *m->counts);
    m->counts[m->channel_count - 1] = (channel_count){0};
    return m->channel_count;
}

/* ---- chunks ---- */

static int by_channel_and_time(const void *left, const void *right)
{
    const index_entry *a = left, *b = right;
    if (a->channel != b->channel) return a->channel < b->channel ? -1 : 1;
    if (a->time != b->time) return a->time < b->time ? -1 : 1;
    return (a->offset > b->offset) - (a->offset < b->offset);
}

/* One record for each channel; where it stands is noted for the chunk's index. */
static void write_message_indexes(mcap *m)
{
    qsort(m->entries, m->entry_count, sizeof *m->entries, by_channel_and_time);
    for (size_t i = 0, next; i < m->entry_count; i = next) {
        uint16_t channel = m->entries[i].channel;
        for (next = i; next < m->entry_count && m->entries[next].channel == channel;) next++;
        m->counts[channel - 1].index_at = m->at;
        size_t began = begin_record(&m->scratch, OP_MESSAGE_INDEX);
        put_uint(&m->scratch, channel, 2);
        put_uint(&m->scratch, 16 * (next - i), 4);
        for (size_t k = i; k < next; k++) {
            put_uint(&m->scratch, m->entries[k].time, 8);
            put_uint(&m->scratch, m->entries[k].offset, 8);
        }
        end_record(&m->scratch, began);
        write_scratch(m);
    }
}

static void put_chunk_index(mcap *m, uint64_t chunk_at, uint64_t chunk_size, uint64_t index_at)
{
    octets *o = &m->chunk_indexes;
    size_t began = begin_record(o, OP_CHUNK_INDEX), channels = 0;
    put_uint(o, m->chunk_begin, 8);
    put_uint(o, m->chunk_end, 8);
    put_uint(o, chunk_at, 8);
    put_uint(o, chunk_size, 8);
    for (uint16_t c = 0; c < m->channel_count; c++) channels += m->counts[c].index_at != 0;
    put_uint(o, 10 * channels, 4);
    for (uint16_t c = 0; c < m->channel_count; c++) {
        if (!m->counts[c].index_at) continue;
        put_uint(o, c + 1u, 2);
        put_uint(o, m->counts[c].index_at, 8);
        m->counts[c].index_at = 0;
    }
    put_uint(o, m->at - index_at, 8);
    put_string(o, ""); /* compression */
    put_uint(o, m->chunk.count, 8);
    put_uint(o, m->chunk.count, 8);
    end_record(o, began);
}

static void end_chunk(mcap *m)
{
    if (!m->chunk.count) return;
    if (!m->entry_count) m->chunk_begin = m->chunk_end = 0;
    uint64_t chunk_at = m->at;
    octets *o = &m->scratch;
    size_t began = begin_record(o, OP_CHUNK);
    put_uint(o, m->chunk_begin, 8);
    put_uint(o, m->chunk_end, 8);
    put_uint(o, m->chunk.count, 8);
    put_uint(o, crc32_z(0, m->chunk.at, m->chunk.count), 4);
    put_string(o, ""); /* compression */
    put_uint(o, m->chunk.count, 8);
    put_bytes(o, m->chunk.at, m->chunk.count);
    end_record(o, began);
    write_scratch(m);
    uint64_t chunk_size = m->at - chunk_at, index_at = m->at;
    write_message_indexes(m);
    put_chunk_index(m, chunk_at, chunk_size, index_at);
    m->chunks++;
    m->chunk.count = m->entry_count = 0;
    m->chunk_begin = UINT64_MAX;
    m->chunk_end = 0;
}

void mcap_message(mcap *m, uint16_t channel, int64_t log_ns, int64_t publish_ns, const void *data, size_t size)
{
    uint64_t time = log_ns < 0 ? 0 : (uint64_t)log_ns;
    channel_count *c = &m->counts[channel - 1];
    m->entries = web_reserve(m->entries, &m->entry_capacity, m->entry_count + 1, sizeof *m->entries);
    m->entries[m->entry_count++] = (index_entry){time, m->chunk.count, channel};
    size_t began = begin_record(&m->chunk, OP_MESSAGE);
    put_uint(&m->chunk, channel, 2);
    put_uint(&m->chunk, c->messages++, 4);
    put_uint(&m->chunk, time, 8);
    put_uint(&m->chunk, publish_ns < 0 ? 0 : (uint64_t)publish_ns, 8);
    put_bytes(&m->chunk, data, size);
    end_record(&m->chunk, began);
    m->messages++;
    if (time < m->chunk_begin) m->chunk_begin = time;
    if (time > m->chunk_end) m->chunk_end = time;
    if (time < m->begin) m->begin = time;
    if (time > m->end) m->end = time;
    if (m->chunk.count >= CHUNK_BYTES) end_chunk(m);
}

uint64_t mcap_message_count(const mcap *m)
{
    return m->messages;
}

void mcap_metadata(mcap *m, const char *name, const char *const *pairs, size_t count)
{
    octets *o = &m->scratch;
    end_chunk(m);
    uint64_t at = m->at;
    size_t began = begin_record(o, OP_METADATA), bytes = 0;
    put_string(o, name);
    for (size_t i = 0; i < 2 * count; i++) bytes += 4 + strlen(pairs[i]);
    put_uint(o, bytes, 4);
    for (size_t i = 0; i < 2 * count; i++) put_string(o, pairs[i]);
    end_record(o, began);
    write_scratch(m);
    o = &m->metadata_indexes;
    began = begin_record(o, OP_METADATA_INDEX);
    put_uint(o, at, 8);
    put_uint(o, m->at - at, 8);
    put_string(o, name);
    end_record(o, began);
    m->metadata++;
}

/* ---- the end ---- */

static void put_statistics(mcap *m)
{
    octets *o = &m->scratch;
    size_t began = begin_record(o, OP_STATISTICS), channels = 0;
    put_uint(o, m->messages, 8);
    put_uint(o, m->schema_count, 2);
    put_uint(o, m->channel_count, 4);
    put_uint(o, 0, 4); /* attachments */
    put_uint(o, m->metadata, 4);
    put_uint(o, m->chunks, 4);
    put_uint(o, m->messages ? m->begin : 0, 8);
    put_uint(o, m->end, 8);
    for (uint16_t c = 0; c < m->channel_count; c++) channels += m->counts[c].messages != 0;
    put_uint(o, 10 * channels, 4);
    for (uint16_t c = 0; c < m->channel_count; c++) {
        if (!m->counts[c].messages) continue;
        put_uint(o, c + 1u, 2);
        put_uint(o, m->counts[c].messages, 8);
    }
    end_record(o, began);
}

static void write_group(mcap *m, octets *offsets, uint8_t opcode, const octets *records)
{
    uint64_t at = m->at;
    if (!records->count) return;
    write_out(m, records->at, records->count);
    size_t began = begin_record(offsets, OP_SUMMARY_OFFSET);
    put_uint(offsets, opcode, 1);
    put_uint(offsets, at, 8);
    put_uint(offsets, m->at - at, 8);
    end_record(offsets, began);
}

/* The summary's CRC covers it and the footer up to the CRC. */
static void write_summary(mcap *m)
{
    octets offsets = {0}, statistics = {0};
    uint64_t summary_at = m->at;
    m->crc = 0;
    write_group(m, &offsets, OP_SCHEMA, &m->schemas);
    write_group(m, &offsets, OP_CHANNEL, &m->channels);
    put_statistics(m);
    statistics = m->scratch;
    m->scratch = (octets){0};
    write_group(m, &offsets, OP_STATISTICS, &statistics);
    write_group(m, &offsets, OP_CHUNK_INDEX, &m->chunk_indexes);
    write_group(m, &offsets, OP_METADATA_INDEX, &m->metadata_indexes);
    uint64_t offsets_at = m->at;
    write_out(m, offsets.at, offsets.count);
    size_t began = begin_record(&m->scratch, OP_FOOTER);
    put_uint(&m->scratch, summary_at, 8);
    put_uint(&m->scratch, offsets_at, 8);
    set_uint(&m->scratch, began - 8, 20, 8);
    write_scratch(m);
    put_uint(&m->scratch, m->crc, 4);
    write_scratch(m);
    free(offsets.at);
    free(statistics.at);
}

static void mcap_free(mcap *m)
{
    octets *all[] = {&m->schemas, &m->channels, &m->chunk, &m->chunk_indexes, &m->metadata_indexes, &m->scratch};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) free(all[i]->at);
    free(m->entries);
    free(m->counts);
    free(m->path);
    free(m);
}

int mcap_close(mcap *m)
{
    end_chunk(m);
    uint32_t data_crc = m->crc;
    size_t began = begin_record(&m->scratch, OP_DATA_END);
    put_uint(&m->scratch, data_crc, 4);
    end_record(&m->scratch, began);
    write_scratch(m);
    write_summary(m);
    write_out(m, MAGIC, sizeof MAGIC);
    if (fclose(m->out) != 0 && !m->failed) m->failed = errno;
    int failed = m->failed;
    if (failed) (void)unlink(m->path);
    mcap_free(m);
    errno = failed;
    return failed ? -1 : 0;
}

void mcap_abandon(mcap *m)
{
    (void)fclose(m->out);
    (void)unlink(m->path);
    mcap_free(m);
}
