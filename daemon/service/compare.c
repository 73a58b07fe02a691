/* compare: see compare.h. Both sides are EventBatch messages, made by the same code from the world's batches; they are
 * walked in step, field by field, by the table of fields. */
#include "compare.h"

#include "streams.h"
#include "wire/wire_schema.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

/* What differs between two runs and says nothing about the world. */
static bool is_of_the_run(const char *field)
{
    return !strcmp(field, "epoch") || !strcmp(field, "batch") || !strcmp(field, "latest_pose_ns") ||
           !strcmp(field, "refused") || !strcmp(field, "refusal");
}

/* ---- one number of one field ---- */

/* What a later release has told beside. */
static bool is_compared(const wire_field *f)
{
    return strcmp(f->name, "extensions") != 0;
}

static bool is_array(const wire_field *f)
{
    return f->type >= WIRE_U8S;
}

/* All arrays begin alike. */
static uint32_t count_of(const wire_message *m, const wire_field *f)
{
    return is_array(f) ? ((const wire_u8s *)wire_field_at(m, f))->count : 1;
}

static const char *string_at(const wire_message *m, const wire_field *f, uint32_t i)
{
    const void *at = wire_field_at(m, f);
    return f->type == WIRE_STRING ? *(const char *const *)at : ((const wire_strings *)at)->at[i];
}

static size_t size_of(const wire_field *f)
{
    static const size_t SIZES[] = {[WIRE_U8] = 1,
        [WIRE_I32] = 4,
        [WIRE_I64] = 8,
        [WIRE_F64] = 8,
        [WIRE_U8S] = 1,
        [WIRE_I32S] = 4,
        [WIRE_I64S] = 8,
        [WIRE_F64S] = 8,
        [WIRE_STRINGS] = 0};
    return SIZES[f->type];
}

static const void *number_at(const wire_message *m, const wire_field *f, uint32_t i)
{
    const void *at = wire_field_at(m, f);
    return is_array(f) ? (const char *)((const wire_u8s *)at)->at + i * size_of(f) : at;
}

static bool is_text(const wire_field *f)
{
    return f->type == WIRE_STRING || f->type == WIRE_STRINGS;
}

/* Bit for bit: -0 is not 0. */
static bool same(const wire_message *a, const wire_message *b, const wire_field *f, uint32_t i, uint32_t k)
{
    if (is_text(f)) return strcmp(string_at(a, f, i), string_at(b, f, k)) == 0;
    return memcmp(number_at(a, f, i), number_at(b, f, k), size_of(f)) == 0;
}

static void show_value(const wire_message *m, const wire_field *f, uint32_t i, char out[COMPARE_VALUE_MAX])
{
    const void *at = is_text(f) ? NULL : number_at(m, f, i);
    int32_t i32;
    int64_t i64;
    double f64;
    switch (f->type) {
    case WIRE_STRING:
    case WIRE_STRINGS:
        snprintf(out, COMPARE_VALUE_MAX, "%s", string_at(m, f, i));
        break;
    case WIRE_U8:
    case WIRE_U8S:
        snprintf(out, COMPARE_VALUE_MAX, "%u", *(const uint8_t *)at);
        break;
    case WIRE_I32:
    case WIRE_I32S:
        memcpy(&i32, at, sizeof i32);
        snprintf(out, COMPARE_VALUE_MAX, "%" PRId32, i32);
        break;
    case WIRE_I64:
    case WIRE_I64S:
        memcpy(&i64, at, sizeof i64);
        snprintf(out, COMPARE_VALUE_MAX, "%" PRId64, i64);
        break;
    case WIRE_F64:
    case WIRE_F64S:
        memcpy(&f64, at, sizeof f64);
        snprintf(out, COMPARE_VALUE_MAX, "%.17g", f64);
        break;
    }
}

static compared_field *next_field(difference *d)
{
    if (d->field_count < COMPARE_FIELDS_MAX) return &d->fields[d->field_count++];
    d->more++;
    return NULL;
}

/* ---- what belongs to one event ---- */

typedef struct reach {
    uint32_t first, count;
} reach;

static bool has_impact(const wire_event_batch *b, uint32_t event)
{
    return b->kinds.at[event] == WIRE_EVENT_IMPACT || b->kinds.at[event] == WIRE_EVENT_PREDICTED;
}

static reach reach_of(const wire_message *m, const wire_field *f, uint32_t event)
{
    const wire_event_batch *b = &m->event_batch;
    uint32_t before = 0, mine = 1, all = b->kinds.count;
    if (strncmp(f->name, "impact_", 7) == 0) {
        all = b->impact_starts_ns.count;
        mine = has_impact(b, event);
        for (uint32_t i = 0; i < event; i++) before += has_impact(b, i);
    } else if (strncmp(f->name, "manifold_", 9) == 0 && strcmp(f->name, "manifold_counts") != 0) {
        all = b->manifold_distances.count;
        mine = b->manifold_counts.at[event];
        for (uint32_t i = 0; i < event; i++) before += b->manifold_counts.at[i];
    } else {
        before = event;
    }
    uint32_t each = all ? count_of(m, f) / all : 0;
    return (reach){each * before, each * mine};
}

static bool same_event(const wire_message *a, const wire_message *b, const wire_field *f, uint32_t event)
{
    reach x = reach_of(a, f, event), y = reach_of(b, f, event);
    if (x.count != y.count) return false;
    for (uint32_t i = 0; i < x.count; i++)
        if (!same(a, b, f, x.first + i, y.first + i)) return false;
    return true;
}

static void report_field(
    difference *d, const wire_message *a, const wire_message *b, const wire_field *f, uint32_t event)
{
    reach x = reach_of(a, f, event), y = reach_of(b, f, event);
    uint32_t most = x.count > y.count ? x.count : y.count;
    for (uint32_t i = 0; i < most; i++) {
        if (i < x.count && i < y.count && same(a, b, f, x.first + i, y.first + i)) continue;
        compared_field *to = next_field(d);
        if (!to) continue;
        snprintf(to->name, sizeof to->name, most > 1 ? "%.40s[%u]" : "%.40s", f->name, i);
        snprintf(to->recorded, sizeof to->recorded, "none");
        snprintf(to->replayed, sizeof to->replayed, "none");
        if (i < x.count) show_value(a, f, x.first + i, to->recorded);
        if (i < y.count) show_value(b, f, y.first + i, to->replayed);
    }
}

static void name_event(const wire_message *m, uint32_t event, char *out, size_t size)
{
    static const char *const KINDS[] = {[WIRE_EVENT_BEGIN] = "begin",
        [WIRE_EVENT_UPDATE] = "update",
        [WIRE_EVENT_END] = "end",
        [WIRE_EVENT_NEAR] = "near",
        [WIRE_EVENT_FAR] = "far",
        [WIRE_EVENT_UNKNOWN] = "unknown",
        [WIRE_EVENT_KNOWN] = "known",
        [WIRE_EVENT_IMPACT] = "impact",
        [WIRE_EVENT_PREDICTED] = "predicted",
        [WIRE_EVENT_AVERTED] = "averted"};
    const wire_event_batch *b = &m->event_batch;
    if (event >= b->kinds.count) {
        snprintf(out, size, "nothing");
        return;
    }
    uint8_t kind = b->kinds.at[event];
    char words[24];
    snprintf(words, sizeof words, "unknown kind %u", kind);
    bool is_known = kind < sizeof KINDS / sizeof *KINDS && KINDS[kind];
    snprintf(out, size, "%s of contact %" PRId64 ", \"%s\" and \"%s\"", is_known ? KINDS[kind] : words,
        b->contacts.at[event], b->names_a.at[event], b->names_b.at[event]);
}

/* ---- two batches ---- */

static bool differ_in_head(const wire_message *a, const wire_message *b, difference *d)
{
    const wire_schema *s = wire_schema_of(WIRE_EVENT_BATCH);
    for (uint32_t i = 0; i < s->field_count; i++) {
        const wire_field *f = &s->fields[i];
        if (is_array(f) || is_of_the_run(f->name) || same(a, b, f, 0, 0)) continue;
        compared_field *to = next_field(d);
        if (!to) continue;
        snprintf(to->name, sizeof to->name, "%s", f->name);
        show_value(a, f, 0, to->recorded);
        show_value(b, f, 0, to->replayed);
    }
    if (!d->field_count) return false;
    d->event = -1;
    snprintf(d->recorded, sizeof d->recorded, "the batch with %u events", a->event_batch.kinds.count);
    snprintf(d->replayed, sizeof d->replayed, "the batch with %u events", b->event_batch.kinds.count);
    return true;
}

static bool differ_in_event(const wire_message *a, const wire_message *b, uint32_t event, difference *d)
{
    const wire_schema *s = wire_schema_of(WIRE_EVENT_BATCH);
    bool both = event < a->event_batch.kinds.count && event < b->event_batch.kinds.count;
    for (uint32_t i = 0; both && i < s->field_count; i++)
        if (is_array(&s->fields[i]) && is_compared(&s->fields[i]) && !same_event(a, b, &s->fields[i], event))
            report_field(d, a, b, &s->fields[i], event);
    if (both && !d->field_count) return false;
    d->event = event;
    name_event(a, event, d->recorded, sizeof d->recorded);
    name_event(b, event, d->replayed, sizeof d->replayed);
    return true;
}

/* An event that is missing, or one too many, shows first where it stands. */
static bool differ(const wire_message *a, const wire_message *b, difference *d)
{
    const wire_event_batch *x = &a->event_batch, *y = &b->event_batch;
    snprintf(d->stream, sizeof d->stream, "%s", x->stream);
    if (x->client == y->client && strcmp(x->stream, y->stream) == 0) {
        uint32_t most = x->kinds.count > y->kinds.count ? x->kinds.count : y->kinds.count;
        for (uint32_t i = 0; i < most; i++)
            if (differ_in_event(a, b, i, d)) return true;
    }
    return differ_in_head(a, b, d);
}

/* ---- all batches of a tick ---- */

typedef struct walk {
    link_replay_reported reported; /* what is left of it */
    wire_memory *memory;
    bool found;
    difference *out;
} walk;

static bool next_recorded(walk *w, wire_message *out)
{
    size_t size;
    wire_refusal why;
    if (w->reported.size < sizeof size) return false;
    memcpy(&size, w->reported.bytes, sizeof size);
    wire_memory_reset(w->memory);
    bool good = wire_lcm_decode_recorded(w->reported.bytes + sizeof size, size, w->memory, out, &why) == WIRE_OK;
    w->reported.bytes += sizeof size + size;
    w->reported.size -= sizeof size + size;
    return good;
}

static void report_one_side(difference *d, const wire_message *m, bool recorded)
{
    char *words = recorded ? d->recorded : d->replayed, *other = recorded ? d->replayed : d->recorded;
    d->event = m->event_batch.kinds.count ? 0 : -1;
    snprintf(d->stream, sizeof d->stream, "%s", m->event_batch.stream);
    if (d->event == 0)
        name_event(m, 0, words, sizeof d->recorded);
    else
        snprintf(words, sizeof d->recorded, "a batch without events");
    snprintf(other, sizeof d->recorded, "nothing");
}

static void compare_one(void *context, const wire_message *replayed)
{
    walk *w = context;
    wire_message recorded;
    if (w->found) return;
    if (next_recorded(w, &recorded)) {
        w->found = differ(&recorded, replayed, w->out);
    } else {
        report_one_side(w->out, replayed, false);
        w->found = true;
    }
}

bool compare_batches(service *s, link_replay_reported reported, const world_batches *batches, difference *out)
{
    walk w = {.reported = reported, .memory = wire_memory_create(), .out = out};
    wire_message recorded;
    *out = (difference){.event = -1};
    stream_each(s, batches, compare_one, &w);
    if (!w.found && next_recorded(&w, &recorded)) {
        report_one_side(out, &recorded, true);
        w.found = true;
    }
    wire_memory_destroy(w.memory);
    return w.found;
}
