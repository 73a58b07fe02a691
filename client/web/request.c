/* request: see request.h. libwebsockets' LEJP takes the JSON apart; what stands where is decided here. */
#include "request.h"

#include <errno.h>
#include <libwebsockets.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct reading {
    request *out;
    char *why;
    char text[REQUEST_NAME_MAX + 1]; /* a string that comes in pieces */
    size_t text_size;
    bool failed;
} reading;

static const char *const PATHS[] = {"op", "token", "what", "a", "b", "do", "id", "number", "rate_hz", "range_m",
    "tolerance_m", "speed", "at_ns", "at[]", "poses", "contacts", "events"};
enum {
    OP = 1,
    TOKEN,
    WHAT,
    NAME_A,
    NAME_B,
    DO,
    ID,
    NUMBER,
    RATE,
    RANGE,
    TOLERANCE,
    SPEED,
    AT_NS,
    AT,
    POSES,
    CONTACTS,
    EVENTS
};

static signed char fail(reading *r, const char *what)
{
    if (!r->failed) snprintf(r->why, 104, "%s", what);
    r->failed = true;
    return -1;
}

static signed char copy(reading *r, char *to, size_t room, const char *name)
{
    if (strlen(r->text) != r->text_size || r->text_size >= room) return fail(r, name);
    memcpy(to, r->text, r->text_size + 1);
    return 0;
}

static signed char take_op(reading *r)
{
    static const char *const OPS[] = {"", "hello", "subscribe", "view", "seen", "ask", "control"};
    for (unsigned i = 1; i < sizeof OPS / sizeof OPS[0]; i++)
        if (strcmp(OPS[i], r->text) == 0) r->out->op = (request_op)i;
    return r->out->op ? 0 : fail(r, "op: unknown");
}

static signed char take_whole(
    reading *r, const char *digits, uint64_t most, uint64_t *to, unsigned has, const char *name)
{
    char *end;
    errno = 0;
    if (*digits < '0' || *digits > '9') return fail(r, name);
    unsigned long long n = strtoull(digits, &end, 10);
    if (*end || errno || n > most) return fail(r, name);
    *to = n;
    r->out->has |= has;
    return 0;
}

static signed char take_text(reading *r, uint8_t path)
{
    request *q = r->out;
    uint64_t n = 0;
    switch (path) {
    case OP:
        return take_op(r);
    case TOKEN:
        return copy(r, q->token, sizeof q->token, "token: too long");
    case WHAT:
    case DO:
        return copy(r, q->what, sizeof q->what, "what, do: unknown");
    case NAME_A:
        q->has |= REQUEST_HAS_A;
        return copy(r, q->a, sizeof q->a, "a: too long");
    case NAME_B:
        q->has |= REQUEST_HAS_B;
        return copy(r, q->b, sizeof q->b, "b: too long");
    case NUMBER:
        return take_whole(r, r->text, UINT64_MAX, &q->number, REQUEST_HAS_NUMBER, "number: no whole number");
    case AT_NS:
        if (take_whole(r, r->text, INT64_MAX, &n, REQUEST_HAS_AT_NS, "at_ns: no whole number")) return -1;
        q->at_ns = (int64_t)n;
        return 0;
    default:
        return path ? fail(r, "a text stands where none may") : 0;
    }
}

static signed char take_number(reading *r, uint8_t path, const char *digits)
{
    request *q = r->out;
    char *end;
    uint64_t n = 0;
    double value = strtod(digits, &end);
    if (*end || !isfinite(value)) return fail(r, "a number is not finite");
    switch (path) {
    case ID:
        if (take_whole(r, digits, UINT32_MAX, &n, REQUEST_HAS_ID, "id: 0 to 4294967295")) return -1;
        q->id = (uint32_t)n;
        return 0;
    case NUMBER:
        return take_whole(r, digits, UINT32_MAX, &q->number, REQUEST_HAS_NUMBER, "number: no whole number");
    case RATE:
        q->rate_hz = value;
        return value > 0 ? 0 : fail(r, "rate_hz: above 0");
    case RANGE:
        q->range_m = value;
        return value >= 0 ? 0 : fail(r, "range_m: at least 0");
    case TOLERANCE:
        q->tolerance_m = value;
        return value >= 0 ? 0 : fail(r, "tolerance_m: at least 0");
    case SPEED:
        q->speed = value;
        return value > 0 ? 0 : fail(r, "speed: above 0");
    case AT:
        if (q->at_count == 3 || fabs(value) > 1e12) return fail(r, "at: three numbers within 1e12");
        q->at[q->at_count++] = value;
        return 0;
    default:
        return path ? fail(r, "a number stands where none may") : 0;
    }
}

static signed char take_flag(reading *r, uint8_t path, bool value)
{
    switch (path) {
    case POSES:
        r->out->poses = value;
        return 0;
    case CONTACTS:
        r->out->contacts = value;
        return 0;
    case EVENTS:
        r->out->events = value;
        return 0;
    default:
        return path ? fail(r, "true or false stands where none may") : 0;
    }
}

/* LEJP matches paths when a name comes, and not when an array begins. */
static bool in_array(const struct lejp_ctx *ctx)
{
    return strcmp(ctx->path, "at[]") == 0;
}

static signed char take(struct lejp_ctx *ctx, char reason)
{
    reading *r = ctx->user;
    switch (reason) {
    case LEJPCB_VAL_STR_START:
        r->text_size = 0;
        r->text[0] = '\0';
        return 0;
    case LEJPCB_VAL_STR_CHUNK:
    case LEJPCB_VAL_STR_END:
        if (r->text_size + ctx->npos >= sizeof r->text) return ctx->path_match ? fail(r, "a text is too long") : 0;
        memcpy(r->text + r->text_size, ctx->buf, ctx->npos);
        r->text_size += ctx->npos;
        r->text[r->text_size] = '\0';
        return reason == LEJPCB_VAL_STR_END ? take_text(r, ctx->path_match) : 0;
    case LEJPCB_VAL_NUM_INT:
    case LEJPCB_VAL_NUM_FLOAT:
        return take_number(r, in_array(ctx) ? AT : ctx->path_match, ctx->buf);
    case LEJPCB_VAL_TRUE:
    case LEJPCB_VAL_FALSE:
        return take_flag(r, ctx->path_match, reason == LEJPCB_VAL_TRUE);
    case LEJPCB_VAL_NULL:
        return ctx->path_match ? fail(r, "null stands where none may") : 0;
    default:
        return 0;
    }
}

bool request_read(const char *text, size_t size, request *out, char why[104])
{
    *out = (request){.poses = true,
        .contacts = true,
        .events = true,
        .rate_hz = NAN,
        .range_m = NAN,
        .tolerance_m = NAN,
        .speed = NAN};
    reading r = {.out = out, .why = why};
    struct lejp_ctx ctx;
    snprintf(why, 104, "no JSON object");
    if (size > REQUEST_MAX || size == 0) return false;
    lejp_construct(&ctx, take, &r, PATHS, sizeof PATHS / sizeof PATHS[0]);
    int left = lejp_parse(&ctx, (const unsigned char *)text, (int)size);
    lejp_destruct(&ctx);
    if (left != 0 || r.failed) return false; /* less, or more than an object */
    if (!out->op) snprintf(why, 104, "op: missing");
    if (out->op == REQUEST_VIEW && out->at_count != 3) snprintf(why, 104, "at: three numbers");
    return out->op && (out->op != REQUEST_VIEW || out->at_count == 3);
}
