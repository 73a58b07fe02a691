/* wire_lcm: LCM's encoding, driven by the table of fields: 8 bytes of fingerprint, then the fields in order,
 * big-endian; before each array its count as int32; strings with their length, which counts the NUL. Any thread, with
 * memory of its own. */
#include "wire_lcm.h"

#include "wire_schema.h"
#include "wire_text.h"

#include <assert.h>
#include <inttypes.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

static const char *const LCM_TYPES[] = {
    [WIRE_U8] = "byte",
    [WIRE_I32] = "int32_t",
    [WIRE_I64] = "int64_t",
    [WIRE_F64] = "double",
    [WIRE_STRING] = "string",
    [WIRE_U8S] = "byte",
    [WIRE_I32S] = "int32_t",
    [WIRE_I64S] = "int64_t",
    [WIRE_F64S] = "double",
    [WIRE_STRINGS] = "string",
};

static const uint8_t WIDTH[] = {
    [WIRE_U8] = 1,
    [WIRE_I32] = 4,
    [WIRE_I64] = 8,
    [WIRE_F64] = 8,
    [WIRE_STRING] = 0,
    [WIRE_U8S] = 1,
    [WIRE_I32S] = 4,
    [WIRE_I64S] = 8,
    [WIRE_F64S] = 8,
    [WIRE_STRINGS] = 0,
};

/* All arrays of plain messages have this shape. */
typedef struct span {
    uint32_t count;
    const void *at;
} span;

_Static_assert(sizeof(span) == sizeof(wire_f64s) && sizeof(span) == sizeof(wire_strings), "arrays have one shape");

/* ---- fingerprint (lcm-gen: hash_update, lcm_struct_hash) ---- */

static uint64_t hash_byte(uint64_t v, uint64_t c)
{
    return ((v << 8) ^ (uint64_t)((int64_t)v >> 55)) + c;
}

static uint64_t hash_text(uint64_t v, const char *text, const char *suffix)
{
    v = hash_byte(v, strlen(text) + strlen(suffix));
    for (; *text; text++) v = hash_byte(v, (uint64_t)*text);
    for (; *suffix; suffix++) v = hash_byte(v, (uint64_t)*suffix);
    return v;
}

static uint64_t hash_member(uint64_t v, const char *name, const char *suffix, const char *type, bool is_array)
{
    enum { LCM_VARIABLE_SIZE = 1 };
    v = hash_text(v, name, suffix);
    v = hash_text(v, type, "");
    v = hash_byte(v, is_array);
    return is_array ? hash_text(hash_byte(v, LCM_VARIABLE_SIZE), name, "_n") : v;
}

static int64_t compute_fingerprint(const wire_schema *s)
{
    uint64_t v = 0x12345678;
    for (uint32_t i = 0; i < s->field_count; i++) {
        const wire_field *f = &s->fields[i];
        bool is_array = f->type >= WIRE_U8S;
        if (is_array) v = hash_member(v, f->name, "_n", "int32_t", false);
        v = hash_member(v, f->name, "", LCM_TYPES[f->type], is_array);
    }
    return (int64_t)(v << 1 | v >> 63);
}

/* Computed when first asked for: each message that comes is compared with all of them. Whoever is first, it is the same
 * number. */
int64_t wire_lcm_fingerprint(wire_kind kind)
{
    static atomic_int_least64_t known[WIRE_KIND_COUNT]; /* 0: not yet */
    const wire_schema *s = wire_schema_of(kind);
    if (!s) return 0;
    int64_t fingerprint = atomic_load_explicit(&known[kind], memory_order_relaxed);
    if (fingerprint) return fingerprint;
    fingerprint = compute_fingerprint(s);
    atomic_store_explicit(&known[kind], fingerprint, memory_order_relaxed);
    return fingerprint;
}

/* ---- writing ---- */

static uint8_t *put_u32(uint8_t *at, uint32_t v)
{
    v = __builtin_bswap32(v);
    memcpy(at, &v, 4);
    return at + 4;
}

static uint8_t *put_u64(uint8_t *at, uint64_t v)
{
    v = __builtin_bswap64(v);
    memcpy(at, &v, 8);
    return at + 8;
}

/* A text that is missing is written as an empty one, as over DDS. */
static const char *present(const char *text)
{
    return text ? text : "";
}

static uint8_t *put_string(uint8_t *at, const char *text)
{
    size_t length = strlen(present(text)) + 1;
    at = put_u32(at, (uint32_t)length);
    memcpy(at, present(text), length);
    return at + length;
}

static uint8_t *put_array(uint8_t *at, wire_type type, span s)
{
    at = put_u32(at, s.count);
    switch (type) {
    case WIRE_U8S:
        if (s.count) memcpy(at, s.at, s.count);
        return at + s.count;
    case WIRE_I32S:
        for (uint32_t i = 0; i < s.count; i++) at = put_u32(at, ((const uint32_t *)s.at)[i]);
        return at;
    case WIRE_STRINGS:
        for (uint32_t i = 0; i < s.count; i++) at = put_string(at, ((const char *const *)s.at)[i]);
        return at;
    default:
        for (uint32_t i = 0; i < s.count; i++) {
            uint64_t bits;
            memcpy(&bits, (const uint64_t *)s.at + i, 8);
            at = put_u64(at, bits);
        }
        return at;
    }
}

static uint8_t *put_field(uint8_t *at, wire_type type, const void *value)
{
    uint32_t word;
    uint64_t bits;
    span s;
    switch (type) {
    case WIRE_U8:
        *at = *(const uint8_t *)value;
        return at + 1;
    case WIRE_I32:
        memcpy(&word, value, 4);
        return put_u32(at, word);
    case WIRE_I64:
    case WIRE_F64:
        memcpy(&bits, value, 8);
        return put_u64(at, bits);
    case WIRE_STRING:
        return put_string(at, *(const char *const *)value);
    default:
        memcpy(&s, value, sizeof s);
        return put_array(at, type, s);
    }
}

static size_t size_of_field(wire_type type, const void *value)
{
    span s;
    if (type == WIRE_STRING) return 4 + strlen(present(*(const char *const *)value)) + 1;
    if (type < WIRE_U8S) return WIDTH[type];
    memcpy(&s, value, sizeof s);
    size_t size = 4 + (size_t)s.count * WIDTH[type];
    for (uint32_t i = 0; type == WIRE_STRINGS && i < s.count; i++)
        size += 4 + strlen(present(((const char *const *)s.at)[i])) + 1;
    return size;
}

size_t wire_lcm_size(const wire_message *m)
{
    const wire_schema *s = wire_schema_of(m->kind);
    size_t size = 8;
    for (uint32_t i = 0; s && i < s->field_count; i++)
        size += size_of_field(s->fields[i].type, (const char *)&m->version + s->fields[i].offset);
    return s ? size : 0;
}

size_t wire_lcm_encode(const wire_message *m, void *out, size_t capacity)
{
    const wire_schema *s = wire_schema_of(m->kind);
    if (!s || wire_lcm_size(m) > capacity) return 0;
    uint8_t *at = put_u64(out, (uint64_t)wire_lcm_fingerprint(m->kind));
    for (uint32_t i = 0; i < s->field_count; i++)
        at = put_field(at, s->fields[i].type, (const char *)&m->version + s->fields[i].offset);
    assert((size_t)(at - (uint8_t *)out) == wire_lcm_size(m));
    return (size_t)(at - (uint8_t *)out);
}

/* ---- reading ---- */

typedef struct reader {
    const uint8_t *at, *end;
    wire_memory *memory;
    const wire_field *field;
    wire_refusal *refusal;
} reader;

static bool fail(reader *r, wire_reason reason, const char *what)
{
    wire_refuse(r->refusal, reason, "%s: %s", r->field->name, what);
    return false;
}

static size_t left(const reader *r)
{
    return (size_t)(r->end - r->at);
}

static uint32_t get_u32(reader *r)
{
    uint32_t v;
    assert(left(r) >= 4); /* whoever calls has looked */
    memcpy(&v, r->at, 4);
    r->at += 4;
    return __builtin_bswap32(v);
}

static uint64_t get_u64(reader *r)
{
    uint64_t v;
    assert(left(r) >= 8);
    memcpy(&v, r->at, 8);
    r->at += 8;
    return __builtin_bswap64(v);
}

/* Text stays where it is: it ends with a NUL in the buffer itself. */
static bool get_string(reader *r, const char **out)
{
    if (left(r) < 4) return fail(r, WIRE_MALFORMED, "the message ends within it");
    uint32_t length = get_u32(r);
    if (length < 1 || length > left(r)) return fail(r, WIRE_MALFORMED, "its length is beyond the message");
    if (length - 1 > WIRE_TEXT_MAX) return fail(r, WIRE_TOO_LARGE, "text is too long");
    if (r->at[length - 1] || memchr(r->at, 0, length - 1)) return fail(r, WIRE_MALFORMED, "text has no end, or two");
    *out = (const char *)r->at;
    r->at += length;
    return true;
}

static bool get_strings(reader *r, uint32_t count, span *out)
{
    if ((size_t)count * 5 > left(r)) return fail(r, WIRE_MALFORMED, "its count is beyond the message");
    const char **texts = wire_memory_take(r->memory, (size_t)count * sizeof *texts);
    *out = (span){count, texts};
    for (uint32_t i = 0; i < count; i++)
        if (!get_string(r, &texts[i])) return false;
    return true;
}

static bool get_numbers(reader *r, uint32_t count, span *out)
{
    size_t width = WIDTH[r->field->type];
    if ((size_t)count * width > left(r)) return fail(r, WIRE_MALFORMED, "its count is beyond the message");
    void *numbers = wire_memory_take(r->memory, (size_t)count * width);
    *out = (span){count, numbers};
    if (width == 1 && count) {
        memcpy(numbers, r->at, count);
        r->at += count;
    }
    for (uint32_t i = 0; width == 4 && i < count; i++) ((uint32_t *)numbers)[i] = get_u32(r);
    for (uint32_t i = 0; width == 8 && i < count; i++) ((uint64_t *)numbers)[i] = get_u64(r);
    return true;
}

static bool get_array(reader *r, void *value)
{
    span s;
    if (left(r) < 4) return fail(r, WIRE_MALFORMED, "the message ends within it");
    uint32_t count = get_u32(r);
    if (count > INT32_MAX) return fail(r, WIRE_MALFORMED, "its count is negative");
    if (count > r->field->limit) return fail(r, WIRE_TOO_LARGE, "more entries than the limit");
    if (!(r->field->type == WIRE_STRINGS ? get_strings(r, count, &s) : get_numbers(r, count, &s))) return false;
    memcpy(value, &s, sizeof s);
    return true;
}

static bool get_field(reader *r, void *value)
{
    wire_type type = r->field->type;
    if (type >= WIRE_U8S) return get_array(r, value);
    if (type == WIRE_STRING) return get_string(r, value);
    if (left(r) < WIDTH[type]) return fail(r, WIRE_MALFORMED, "the message ends within it");
    uint32_t word;
    uint64_t bits;
    switch (WIDTH[type]) {
    case 1:
        *(uint8_t *)value = *r->at++;
        break;
    case 4:
        word = get_u32(r);
        memcpy(value, &word, 4);
        break;
    default:
        bits = get_u64(r);
        memcpy(value, &bits, 8);
        break;
    }
    return true;
}

/* The fingerprints of the same messages before they had extensions: all other fields are the same, if not by name. */
static const uint64_t BEFORE_EXTENSIONS[WIRE_KIND_COUNT] = {
    [WIRE_CLIENT] = UINT64_C(0xbb4f1662aaad6974),
    [WIRE_GEOMETRY] = UINT64_C(0x93629c55b6494f0f),
    [WIRE_BODY] = UINT64_C(0x1b64de851dbc799a),
    [WIRE_POSE_BATCH] = UINT64_C(0xa987d30858af2aaa),
    [WIRE_VERTEX_BATCH] = UINT64_C(0x8027f806b140fbde),
    [WIRE_SUBSCRIPTION] = UINT64_C(0xa7556880d883d9fe),
    [WIRE_QUERY] = UINT64_C(0xb1e2762bdc56927d),
    [WIRE_RECEIPT] = UINT64_C(0x6eb50376c4fdfcbc),
    [WIRE_ANSWER] = UINT64_C(0xaea363ded731a27d),
    [WIRE_EVENT_BATCH] = UINT64_C(0x7184e560f7783f75),
    [WIRE_STATUS] = UINT64_C(0x8e305345269074fc),
    [WIRE_REJECT] = UINT64_C(0xe0d20536e8e0ef98),
    [WIRE_ACK] = UINT64_C(0xffb5fc0b5c7fd1e6),
};

static wire_kind kind_before_extensions(const void *data, size_t size)
{
    uint64_t fingerprint;
    if (size < 8) return WIRE_NOTHING;
    memcpy(&fingerprint, data, 8);
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++)
        if (BEFORE_EXTENSIONS[kind] == __builtin_bswap64(fingerprint)) return (wire_kind)kind;
    return WIRE_NOTHING;
}

wire_kind wire_lcm_kind(const void *data, size_t size)
{
    uint64_t fingerprint;
    if (size < 8) return WIRE_NOTHING;
    memcpy(&fingerprint, data, 8);
    for (int kind = WIRE_NOTHING + 1; kind < WIRE_KIND_COUNT; kind++)
        if ((uint64_t)wire_lcm_fingerprint((wire_kind)kind) == __builtin_bswap64(fingerprint)) return (wire_kind)kind;
    return WIRE_NOTHING;
}

/* A message of that kind whose last `absent` fields are not there. */
static wire_reason decode(wire_kind kind, uint32_t absent, const void *data, size_t size, wire_memory *memory,
    wire_message *out, wire_refusal *refusal)
{
    *refusal = (wire_refusal){.reason = WIRE_OK};
    *out = (wire_message){.kind = kind};
    const wire_schema *s = wire_schema_of(out->kind);
    if (size < 8) return wire_refuse(refusal, WIRE_MALFORMED, "%zu bytes: a message has at least 8", size);
    if (!s) return wire_refuse(refusal, WIRE_WRONG_VERSION, "no type of this version has its fingerprint");
    reader r = {(const uint8_t *)data + 8, (const uint8_t *)data + size, memory, NULL, refusal};
    for (uint32_t i = 0; i < s->field_count - absent; i++) {
        r.field = &s->fields[i];
        if (!get_field(&r, (char *)&out->version + r.field->offset)) return refusal->reason;
    }
    if (left(&r)) return wire_refuse(refusal, WIRE_MALFORMED, "%zu bytes too many", left(&r));
    return wire_check(out, refusal);
}

wire_reason wire_lcm_decode(
    const void *data, size_t size, wire_memory *memory, wire_message *out, wire_refusal *refusal)
{
    return decode(wire_lcm_kind(data, size), 0, data, size, memory, out, refusal);
}

wire_reason wire_lcm_decode_recorded(
    const void *data, size_t size, wire_memory *memory, wire_message *out, wire_refusal *refusal)
{
    wire_kind before = kind_before_extensions(data, size);
    return before ? decode(before, 1, data, size, memory, out, refusal)
                  : wire_lcm_decode(data, size, memory, out, refusal);
}

/* ---- channels ---- */

void wire_lcm_stream_channel(const char *stream, char channel[WIRE_CHANNEL_MAX])
{
    int length = snprintf(channel, WIRE_CHANNEL_MAX, "collided.out.EventBatch.%s", stream);
    if (length >= WIRE_CHANNEL_MAX)
        snprintf(channel, WIRE_CHANNEL_MAX, "collided.out.EventBatch.#%016" PRIx64,
            wire_fnv1a(WIRE_FNV1A_START, stream, strlen(stream)));
}

void wire_lcm_channel(const wire_message *m, char channel[WIRE_CHANNEL_MAX])
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    switch (m->kind) {
    case WIRE_EVENT_BATCH:
        wire_lcm_stream_channel(m->event_batch.stream, channel);
        break;
    case WIRE_STATUS:
        snprintf(channel, WIRE_CHANNEL_MAX, "collided.out.Status");
        break;
    case WIRE_ANSWER:
    case WIRE_REJECT:
    case WIRE_ACK:
        snprintf(channel, WIRE_CHANNEL_MAX, "collided.out.%s.%016" PRIx64, wire_kind_name(m->kind), (uint64_t)client);
        break;
    default:
        snprintf(channel, WIRE_CHANNEL_MAX, "collided.in.%s", wire_kind_name(m->kind));
        break;
    }
}
