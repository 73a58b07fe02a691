/* wire_soft: see wire_soft.h. */
#include "wire_soft.h"
#include "wire_extensions.h"
#include "wire_rules.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- numbers ---- */

static uint64_t get(const uint8_t *at, int bytes)
{
    uint64_t v = 0;
    for (int i = bytes; i-- > 0;) v = v << 8 | at[i];
    return v;
}

static void put(uint8_t *at, uint64_t v, int bytes)
{
    for (int i = 0; i < bytes; i++, v >>= 8) at[i] = (uint8_t)v;
}

static double get_double(const uint8_t *at)
{
    uint64_t bits = get(at, 8);
    double v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void put_double(uint8_t *at, double v)
{
    uint64_t bits;
    memcpy(&bits, &v, sizeof bits);
    put(at, bits, 8);
}

static float get_single(const uint8_t *at)
{
    uint32_t bits = (uint32_t)get(at, 4);
    float v;
    memcpy(&v, &bits, sizeof v);
    return v;
}

static void put_single(uint8_t *at, float v)
{
    uint32_t bits;
    memcpy(&bits, &v, sizeof bits);
    put(at, bits, 4);
}

static bool find_record(wire_u8s extensions, uint32_t id, wire_u8s *out)
{
    wire_extension e;
    while (wire_extension_next(&extensions, &e))
        if (e.id == id) return *out = e.bytes, true;
    return false;
}

static uint32_t put_head(uint8_t *to, uint32_t id, uint32_t length)
{
    put(to, id, 4);
    put(to + 4, length, 4);
    return WIRE_EXTENSION_HEAD;
}

/* ---- frames ---- */

enum { FRAME_BYTES = 20, ORIGIN_BYTES = 24, SINGLES_BYTES = 12 };

bool wire_soft_read_frame(const wire_vertex_batch *m, wire_soft_frame *out)
{
    wire_u8s at;
    *out = (wire_soft_frame){.parts = 1, .vertices = m->vertices.count / 3};
    if (find_record(m->extensions, WIRE_SOFT_FRAME, &at)) {
        if (at.count != FRAME_BYTES) return false;
        out->frame = (int64_t)get(at.at, 8);
        out->part = (int32_t)get(at.at + 8, 4);
        out->parts = (int32_t)get(at.at + 12, 4);
        out->mode = (int32_t)get(at.at + 16, 4);
    }
    if (find_record(m->extensions, WIRE_SOFT_SINGLES, &at)) {
        if (at.count < ORIGIN_BYTES || (at.count - ORIGIN_BYTES) % SINGLES_BYTES || m->vertices.count) return false;
        out->single = true;
        for (int k = 0; k < 3; k++) out->origin[k] = get_double(at.at + 8 * k);
        out->singles = at.at + ORIGIN_BYTES;
        out->vertices = (at.count - ORIGIN_BYTES) / SINGLES_BYTES;
    }
    return true;
}

void wire_soft_vertex(const wire_vertex_batch *m, const wire_soft_frame *f, uint32_t i, double out[3])
{
    for (int k = 0; k < 3; k++)
        out[k] = f->single ? f->origin[k] + (double)get_single(f->singles + SINGLES_BYTES * (size_t)i + 4 * k)
                           : m->vertices.at[3 * (size_t)i + (size_t)k];
}

uint32_t wire_soft_put_frame(const wire_soft_frame *f, const float *singles, uint8_t *to)
{
    uint32_t at = put_head(to, WIRE_SOFT_FRAME, FRAME_BYTES);
    put(to + at, (uint64_t)f->frame, 8);
    put(to + at + 8, (uint32_t)f->part, 4);
    put(to + at + 12, (uint32_t)f->parts, 4);
    put(to + at + 16, (uint32_t)f->mode, 4);
    at += FRAME_BYTES;
    if (!f->single) return at;
    at += put_head(to + at, WIRE_SOFT_SINGLES, ORIGIN_BYTES + SINGLES_BYTES * f->vertices);
    for (int k = 0; k < 3; k++, at += 8) put_double(to + at, f->origin[k]);
    for (size_t i = 0; i < 3 * (size_t)f->vertices; i++, at += 4) put_single(to + at, singles[i]);
    return at;
}

static wire_reason check_singles(const wire_soft_frame *f, wire_refusal *why)
{
    TRY(check_magnitudes("the origin of singles", (wire_f64s){3, f->origin}, WIRE_SIZE_MAX, why));
    for (size_t i = 0; i < 3 * (size_t)f->vertices; i++) {
        float v = get_single(f->singles + 4 * i);
        if (!isfinite(v)) FAIL(WIRE_BAD_NUMBER, "singles[%zu] is not a number", i);
        if (fabsf(v) > (float)WIRE_SIZE_MAX)
            FAIL(WIRE_TOO_LARGE, "singles[%zu] is %g: at most %g is allowed", i, (double)v, WIRE_SIZE_MAX);
    }
    return WIRE_OK;
}

wire_reason check_soft_vertices(const wire_vertex_batch *m, wire_refusal *why)
{
    wire_soft_frame f;
    if (!wire_soft_read_frame(m, &f))
        FAIL(WIRE_MALFORMED,
            "extensions: the frame has %d octets, singles an origin and three floats each, "
            "instead of `vertices`",
            FRAME_BYTES);
    TRY(check_between("the frame", f.frame, 0, INT64_MAX, why));
    TRY(check_between("the mode of the frame", f.mode, WIRE_SOFT_MOVE, WIRE_SOFT_MODES - 1, why));
    TRY(check_between("the parts of the frame", f.parts, 1, WIRE_SOFT_PARTS_MAX, why));
    TRY(check_between("the part of the frame", f.part, 0, f.parts - 1, why));
    for (int k = 0; f.single && k < 3; k++)
        if (!isfinite(f.origin[k])) FAIL(WIRE_BAD_NUMBER, "the origin of singles is not a number");
    return f.single ? check_singles(&f, why) : WIRE_OK;
}

/* ---- interests ---- */

void wire_soft_read_interest(wire_u8s extensions, wire_soft_interest *out)
{
    wire_u8s at;
    *out = (wire_soft_interest){.grain = WIRE_SOFT_SUMMARY};
    if (!find_record(extensions, WIRE_SOFT_INTEREST, &at) || at.count != 8) return;
    out->grain = (int32_t)get(at.at, 4);
    out->most = (int32_t)get(at.at + 4, 4);
}

uint32_t wire_soft_put_interest(const wire_soft_interest *of, uint8_t to[WIRE_SOFT_INTEREST_BYTES])
{
    uint32_t at = put_head(to, WIRE_SOFT_INTEREST, 8);
    put(to + at, (uint32_t)of->grain, 4);
    put(to + at + 4, (uint32_t)of->most, 4);
    return at + 8;
}

wire_reason check_soft_interest(wire_u8s extensions, wire_refusal *why)
{
    wire_u8s at;
    wire_soft_interest i;
    if (!find_record(extensions, WIRE_SOFT_INTEREST, &at)) return WIRE_OK;
    if (at.count != 8)
        FAIL(WIRE_MALFORMED, "extensions: what is wanted of soft bodies has %u octets: it must have 8", at.count);
    wire_soft_read_interest(extensions, &i);
    TRY(check_between("the grain of soft bodies", i.grain, WIRE_SOFT_SUMMARY, WIRE_SOFT_GRAINS - 1, why));
    return check_between("the most features of a pair", i.most, 0, INT32_MAX, why);
}

/* ---- steps ---- */

/* Of a record: u32 pairs; then each pair, its names and its features. */
enum { PAIR_BYTES = 8 * 3 + 4 * 2 + 4 + 8 * 6 + 8 * 2 + 4 + 2, COUNT_BYTES = 4 };

static uint8_t *grow(wire_soft_writer *w, size_t by)
{
    if (w->count + by > w->capacity) {
        size_t need = 2 * (w->count + by);
        uint8_t *at = realloc(w->at, need);
        if (!at) abort();
        w->at = at;
        w->capacity = need;
    }
    w->count += by;
    return w->at + w->count - by;
}

void wire_soft_begin(wire_soft_writer *w)
{
    w->count = w->pairs = 0;
    grow(w, WIRE_EXTENSION_HEAD + COUNT_BYTES);
}

void wire_soft_put_pair(wire_soft_writer *w, const wire_soft_pair *p)
{
    size_t a = strlen(p->name_a), b = strlen(p->name_b);
    uint8_t *at = grow(w, PAIR_BYTES + a + b);
    const uint64_t counts[] = {p->vertex_face, p->edge_edge, p->face_shape, p->within, p->undecided, p->left_out};
    put(at, (uint64_t)p->contact, 8), put(at + 8, (uint64_t)p->frame_a, 8), put(at + 16, (uint64_t)p->frame_b, 8);
    put(at + 24, (uint32_t)p->shape_a, 4), put(at + 28, (uint32_t)p->shape_b, 4);
    put(at + 32, p->flags, 4);
    for (int i = 0; i < 6; i++) put(at + 36 + 8 * i, counts[i], 8);
    put_double(at + 84, p->safe_lo), put_double(at + 92, p->safe_hi);
    put(at + 100, p->features, 4);
    at[104] = (uint8_t)a, at[105] = (uint8_t)b;
    memcpy(at + PAIR_BYTES, p->name_a, a);
    memcpy(at + PAIR_BYTES + a, p->name_b, b);
    w->pairs++;
}

/* A unit vector on an octahedron, unfolded to a square (Meyer et al. 2010): to some 1e-4. */
static void fold(const float n[3], int16_t out[2])
{
    float sum = fabsf(n[0]) + fabsf(n[1]) + fabsf(n[2]);
    float x = sum > 0 ? n[0] / sum : 0, y = sum > 0 ? n[1] / sum : 0;
    if (n[2] < 0) {
        float was = x;
        x = copysignf(1 - fabsf(y), x);
        y = copysignf(1 - fabsf(was), y);
    }
    out[0] = (int16_t)lrintf(32767 * x), out[1] = (int16_t)lrintf(32767 * y);
}

static void unfold(const int16_t in[2], float n[3])
{
    float x = (float)in[0] / 32767, y = (float)in[1] / 32767, z = 1 - fabsf(x) - fabsf(y);
    if (z < 0) {
        float was = x;
        x = copysignf(1 - fabsf(y), x);
        y = copysignf(1 - fabsf(was), y);
    }
    float norm = sqrtf(x * x + y * y + z * z);
    n[0] = x / norm, n[1] = y / norm, n[2] = z / norm;
}

static uint16_t share(float v)
{
    return (uint16_t)lrintf(65535 * (v > 0 ? (v < 1 ? v : 1) : 0));
}

void wire_soft_put_feature(wire_soft_writer *w, const wire_soft_feature *f)
{
    uint8_t *at = grow(w, WIRE_SOFT_FEATURE_BYTES);
    int16_t n[2];
    fold(f->normal, n);
    put(at, (uint32_t)f->kind | (uint32_t)f->proof << 2 | f->a << 4, 4), put(at + 4, f->b, 4);
    put_single(at + 8, f->t_lo), put_single(at + 12, f->t_hi);
    put(at + 16, (uint16_t)n[0], 2), put(at + 18, (uint16_t)n[1], 2);
    put(at + 20, share(f->bary[0]), 2), put(at + 22, share(f->bary[1]), 2);
}

wire_u8s wire_soft_end(wire_soft_writer *w)
{
    put_head(w->at, WIRE_SOFT_STEP, (uint32_t)(w->count - WIRE_EXTENSION_HEAD));
    put(w->at + WIRE_EXTENSION_HEAD, w->pairs, 4);
    return (wire_u8s){(uint32_t)w->count, w->at};
}

void wire_soft_free(wire_soft_writer *w)
{
    free(w->at);
    *w = (wire_soft_writer){.at = NULL};
}

bool wire_soft_read(wire_u8s extensions, wire_soft_reader *out)
{
    *out = (wire_soft_reader){.pairs = 0};
    if (!find_record(extensions, WIRE_SOFT_STEP, &out->rest) || out->rest.count < COUNT_BYTES) return false;
    out->pairs = (uint32_t)get(out->rest.at, 4);
    out->rest = (wire_u8s){out->rest.count - COUNT_BYTES, out->rest.at + COUNT_BYTES};
    return true;
}

static const uint8_t *take_bytes(wire_soft_reader *r, size_t bytes)
{
    if (bytes > r->rest.count) return NULL;
    const uint8_t *at = r->rest.at;
    r->rest = (wire_u8s){r->rest.count - (uint32_t)bytes, at + bytes};
    return at;
}

static const char *take_name(wire_soft_reader *r, int which, size_t length)
{
    const uint8_t *at = length <= WIRE_NAME_MAX ? take_bytes(r, length) : NULL;
    if (!at) return NULL;
    memcpy(r->names[which], at, length);
    r->names[which][length] = '\0';
    return r->names[which];
}

bool wire_soft_next_pair(wire_soft_reader *r, wire_soft_pair *p)
{
    wire_soft_feature passed;
    while (wire_soft_next_feature(r, &passed)) {
    }
    const uint8_t *at = r->pairs ? take_bytes(r, PAIR_BYTES) : NULL;
    if (!at) return false;
    uint64_t counts[6];
    for (int i = 0; i < 6; i++) counts[i] = get(at + 36 + 8 * i, 8);
    *p = (wire_soft_pair){.contact = (int64_t)get(at, 8),
        .frame_a = (int64_t)get(at + 8, 8),
        .frame_b = (int64_t)get(at + 16, 8),
        .shape_a = (int32_t)get(at + 24, 4),
        .shape_b = (int32_t)get(at + 28, 4),
        .flags = (uint8_t)get(at + 32, 4),
        .vertex_face = counts[0],
        .edge_edge = counts[1],
        .face_shape = counts[2],
        .within = counts[3],
        .undecided = counts[4],
        .left_out = counts[5],
        .safe_lo = get_double(at + 84),
        .safe_hi = get_double(at + 92),
        .features = (uint32_t)get(at + 100, 4)};
    p->name_a = take_name(r, 0, at[104]);
    p->name_b = take_name(r, 1, at[105]);
    if (!p->name_a || !p->name_b) return false;
    r->pairs--;
    r->features = p->features;
    return true;
}

bool wire_soft_next_feature(wire_soft_reader *r, wire_soft_feature *f)
{
    const uint8_t *at = r->features ? take_bytes(r, WIRE_SOFT_FEATURE_BYTES) : NULL;
    if (!at) return false;
    uint32_t word = (uint32_t)get(at, 4);
    const int16_t n[2] = {(int16_t)get(at + 16, 2), (int16_t)get(at + 18, 2)};
    *f = (wire_soft_feature){.kind = word & 3, .proof = word >> 2 & 3, .a = word >> 4, .b = (uint32_t)get(at + 4, 4)};
    f->t_lo = get_single(at + 8), f->t_hi = get_single(at + 12);
    unfold(n, f->normal);
    f->bary[0] = (float)get(at + 20, 2) / 65535, f->bary[1] = (float)get(at + 22, 2) / 65535;
    r->features--;
    return true;
}
