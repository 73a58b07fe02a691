/* storm_model: bookkeeping by linear search; a storm has some hundred contacts at once. */
#include "storm_model.h"
#include "base/prng.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { IDS_MAX = 1 << 24, PARTS_MAX = 4, LINE_BITS = 16 /* of an epoch: how often a standby took over */ };

uint64_t storm_random(uint64_t *state)
{
    return prng_bits(state);
}

/* ---- bodies and pairs as numbers ---- */

bool storm_known(int owner)
{
    return owner >= STORM_OWNERS / 2;
}

void storm_name(char name[32], int owner, int life, int body)
{
    snprintf(name, 32, "o%d.%d.%d", owner, life, body);
}

static uint32_t body_key(int owner, int life, int body)
{
    return (uint32_t)owner << 28 | (uint32_t)life << 8 | (uint32_t)body;
}

static uint32_t key_of(const char *name)
{
    int owner = -1, life = 0, body = 0;
    if (sscanf(name, "o%d.%d.%d", &owner, &life, &body) != 3) return UINT32_MAX; /* NOLINT(cert-err34-c): our own */
    return body_key(owner, life, body);
}

static uint64_t pair_of(uint32_t a, uint32_t b)
{
    return a < b ? (uint64_t)a << 32 | b : (uint64_t)b << 32 | a;
}

static uint64_t scatter(uint64_t pair)
{
    return storm_random(&pair);
}

/* Of a set: the order does not count. */
uint64_t storm_digest(const storm_model *m)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < m->open_count; i++) sum += scatter(m->open[i].pair);
    return sum;
}

/* ---- the model ---- */

static void fault(storm_model *m, const collided_batch *b, const char *format, ...)
{
    if (m->faulty) return;
    va_list arguments;
    va_start(arguments, format);
    int used = vsnprintf(m->fault, sizeof m->fault, format, arguments);
    va_end(arguments);
    snprintf(m->fault + used, sizeof m->fault - (size_t)used,
        " (epoch %" PRId64 ", tick %" PRId64 ", batch %" PRId64 " after %" PRId64 ", snapshot %d, lost %" PRId64 ")",
        b->epoch, b->tick, b->batch, m->batch, b->snapshot, b->lost);
    m->faulty = 1;
}

static bool is_over(const storm_model *m, int64_t id)
{
    return m->over[id >> 3] >> (id & 7) & 1;
}

static storm_contact *find(storm_model *m, int64_t id)
{
    for (size_t i = 0; i < m->open_count; i++)
        if (m->open[i].id == id) return &m->open[i];
    return NULL;
}

static void end(storm_model *m, storm_contact *at)
{
    m->over[at->id >> 3] |= (uint8_t)(1 << (at->id & 7));
    *at = m->open[--m->open_count];
    m->ended++;
}

static void begin(storm_model *m, const collided_batch *b, const collided_event *e)
{
    if (m->open_count == STORM_OPEN_MAX) {
        fault(m, b, "more contacts than bodies can have");
        return;
    }
    uint32_t a = key_of(e->name_a), c = key_of(e->name_b);
    m->open[m->open_count++] = (storm_contact){.id = e->contact, .pair = pair_of(a, c), .seen = true};
    m->begun++;
}

static void learn(storm_model *m, const collided_batch *b, const collided_event *e)
{
    if (!e->contact) return; /* a whole body is unknown, or known */
    if (e->contact < 0 || e->contact >= IDS_MAX) {
        fault(m, b, "contact id %" PRId64, e->contact);
        return;
    }
    storm_contact *at = find(m, e->contact);
    if (is_over(m, e->contact)) fault(m, b, "event %d of contact %" PRId64 " after its end", e->kind, e->contact);
    if (e->kind == COLLIDED_BEGIN && at && !b->snapshot) fault(m, b, "contact %" PRId64 " began twice", e->contact);
    if (e->kind != COLLIDED_BEGIN && !at)
        fault(m, b, "event %d of contact %" PRId64 " (%s, %s), which never began", e->kind, e->contact, e->name_a,
            e->name_b);
    if (e->lo > e->hi) fault(m, b, "contact %" PRId64 ": lo is above hi", e->contact);
    if (at) at->seen = true;
    if (e->kind == COLLIDED_BEGIN && !at) begin(m, b, e);
    if (e->kind == COLLIDED_END && at) end(m, at);
}

/* What a snapshot leaves out has ended unheard; on a stream that goes on and lost nothing, nothing has. */
static void settle_snapshot(storm_model *m, const collided_batch *b, size_t before)
{
    bool goes_on = before && b->lost == 0 && b->batch > m->batch && b->batch > PARTS_MAX;
    for (size_t i = m->open_count; i-- > 0;) {
        if (m->open[i].seen) continue;
        if (goes_on) fault(m, b, "a snapshot without contact %" PRId64 ", which had not ended", m->open[i].id);
        m->unheard++;
        end(m, &m->open[i]);
    }
    m->snapshots++;
}

static void follow_epoch(storm_model *m, const collided_batch *b)
{
    if (b->epoch == m->epoch) return;
    if (m->epoch && b->epoch >> LINE_BITS == m->epoch >> LINE_BITS) { /* it goes on with all that was told */
        if (b->epoch < m->epoch) fault(m, b, "epoch %" PRId64 " after %" PRId64, b->epoch, m->epoch);
        m->epoch = b->epoch;
        m->takeovers++;
        return;
    }
    if (!b->snapshot) fault(m, b, "an epoch that begins without a snapshot");
    m->epoch = b->epoch;
    m->batch = 0;
    m->epochs++;
    m->unheard += (int64_t)m->open_count;
    m->ended += (int64_t)m->open_count;
    m->open_count = 0;
    memset(m->over, 0, IDS_MAX / 8);
}

static void on_batch(void *context, const collided_batch *b)
{
    storm_model *m = context;
    if ((b->heartbeat || b->starved) && b->event_count) fault(m, b, "a heartbeat, or a notice, with events");
    if (b->starved) return; /* said by the client itself, and maybe before the first batch of an epoch */
    follow_epoch(m, b);
    m->lost += b->lost;
    if (b->heartbeat) return;
    if (!b->snapshot && b->batch <= m->batch) fault(m, b, "an old batch");
    if (!b->snapshot && b->lost) fault(m, b, "no snapshot after a loss");
    size_t before = m->open_count;
    for (size_t i = 0; b->snapshot && i < m->open_count; i++) m->open[i].seen = false;
    for (size_t i = 0; i < b->event_count; i++) learn(m, b, &b->events[i]);
    if (b->snapshot) settle_snapshot(m, b, before);
    if (b->closing && m->open_count) fault(m, b, "a stream that closes with %zu open contacts", m->open_count);
    m->batch = b->batch;
    m->digest = storm_digest(m);
}

collided_subscription storm_listen(collided *c, storm_model *m)
{
    uint8_t *over = calloc(IDS_MAX / 8, 1); /* an earlier process of this listener had its own */
    if (!over) abort();
    memset(m, 0, offsetof(storm_model, fault));
    m->over = over;
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = on_batch;
    def.context = m;
    return collided_subscribe(c, &def);
}

/* ---- the truth ---- */

typedef struct placed {
    uint32_t key;
    const double *at;
} placed;

static size_t all_bodies(const storm_shared *s, placed out[STORM_OWNERS * STORM_BODIES])
{
    size_t n = 0;
    for (int o = 0; o < STORM_OWNERS; o++)
        for (int i = 0; i < STORM_BODIES; i++)
            if (s->owners[o].there[i]) out[n++] = (placed){body_key(o, s->owners[o].life, i), s->owners[o].place[i]};
    return n;
}

static bool touch(const placed *a, const placed *b)
{
    double x = a->at[0] - b->at[0], y = a->at[1] - b->at[1];
    return x * x + y * y < 1;
}

uint64_t storm_truth(const storm_shared *s, size_t *count)
{
    placed all[STORM_OWNERS * STORM_BODIES];
    size_t n = all_bodies(s, all);
    uint64_t sum = 0;
    *count = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t k = i + 1; k < n; k++) {
            if (!touch(&all[i], &all[k])) continue;
            sum += scatter(pair_of(all[i].key, all[k].key));
            ++*count;
        }
    return sum;
}

static void print_pair(const char *what, uint64_t pair)
{
    uint32_t a = (uint32_t)(pair >> 32), b = (uint32_t)pair;
    printf("  %s: o%u.%u.%u and o%u.%u.%u\n", what, a >> 28, a >> 8 & 0xfffff, a & 0xff, b >> 28, b >> 8 & 0xfffff,
        b & 0xff);
}

void storm_print_difference(const storm_shared *s, const storm_model *m)
{
    placed all[STORM_OWNERS * STORM_BODIES];
    size_t n = all_bodies(s, all);
    for (size_t i = 0; i < n; i++)
        for (size_t k = i + 1; k < n; k++) {
            uint64_t pair = pair_of(all[i].key, all[k].key);
            bool told = false;
            for (size_t c = 0; c < m->open_count; c++) told |= m->open[c].pair == pair;
            if (touch(&all[i], &all[k]) && !told) print_pair("touch, and are not told", pair);
            if (!touch(&all[i], &all[k]) && told) print_pair("are told, and do not touch", pair);
        }
    for (size_t c = 0; c < m->open_count; c++) {
        bool known = false;
        for (size_t i = 0; i < n; i++)
            for (size_t k = i + 1; k < n; k++) known |= pair_of(all[i].key, all[k].key) == m->open[c].pair;
        if (!known) print_pair("are told, and not both there", m->open[c].pair);
    }
}
