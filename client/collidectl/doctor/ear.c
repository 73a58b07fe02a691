/* ear: what both transports share: the daemons by epoch, waiting and asking. */
#include "ear.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>
#include <time.h>
#include <unistd.h>

enum { POLL_US = 2000 };

double ear_now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- daemons ---- */

static ear_daemon *daemon_of(ear *e, int64_t epoch)
{
    for (size_t i = 0; i < e->daemon_count; i++)
        if (e->daemons[i].epoch == epoch) return &e->daemons[i];
    if (e->daemon_count == EAR_DAEMONS_MAX) {
        e->daemons_passed_over++;
        return NULL;
    }
    e->daemons[e->daemon_count] = (ear_daemon){.epoch = epoch};
    return &e->daemons[e->daemon_count++];
}

static void put_counter(ear_daemon *d, const char *name, int64_t value)
{
    for (size_t i = 0; i < d->counter_count; i++) {
        if (strcmp(d->counters[i].name, name) != 0) continue;
        d->counters[i].last = value;
        return;
    }
    if (d->counter_count == EAR_COUNTERS_MAX) return; /* far more than a daemon of this release has */
    if (!d->counters) d->counters = calloc(EAR_COUNTERS_MAX, sizeof *d->counters);
    if (!d->counters) return;
    ear_counter *c = &d->counters[d->counter_count++];
    snprintf(c->name, sizeof c->name, "%s", name);
    c->last = value;
    c->first = d->statuses > 1 ? 0 : value; /* it is new, like a client that was lost just now */
}

static void take_status(ear *e, const wire_status *s)
{
    ear_daemon *d = daemon_of(e, s->epoch);
    if (!d) return;
    if (!d->statuses++) d->first_stamp_ns = s->stamp_ns;
    d->last_stamp_ns = s->stamp_ns;
    d->health = s->health;
    snprintf(d->name, sizeof d->name, "%s", s->daemon);
    snprintf(d->release, sizeof d->release, "%s", s->release);
    snprintf(d->links, sizeof d->links, "%s", s->links);
    snprintf(d->limits, sizeof d->limits, "%s", s->limits);
    for (size_t i = 0; i < d->counter_count; i++) d->counters[i].last = -1;
    for (uint32_t i = 0; i < s->counter_names.count && i < s->counter_values.count; i++)
        put_counter(d, s->counter_names.at[i], s->counter_values.at[i]);
}

static void take_answer(ear *e, const wire_answer *a)
{
    if (a->client != e->client || a->sequence != e->sequence || e->answered == a->sequence) return;
    e->answered = a->sequence;
    e->on_answer(e->context, a);
}

void ear_message(ear *e, const wire_message *m)
{
    if (m->kind == WIRE_STATUS) take_status(e, &m->status);
    if (m->kind == WIRE_ANSWER) take_answer(e, &m->answer);
    if (m->kind == WIRE_REJECT)
        snprintf(e->reject, sizeof e->reject, "%s of client %016" PRIx64 ": %.150s",
            wire_kind_name((wire_kind)m->reject.kind), (uint64_t)m->reject.client, m->reject.text);
}

void ear_strange(ear *e, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(e->strangers.what, sizeof e->strangers.what, format, arguments);
    va_end(arguments);
    e->strangers.count++;
}

const ear_daemon *ear_followed(const ear *e)
{
    const ear_daemon *latest = NULL;
    for (size_t i = 0; e && i < e->daemon_count; i++)
        if (e->daemons[i].health != WIRE_HEALTH_STOPPING && (!latest || e->daemons[i].epoch > latest->epoch))
            latest = &e->daemons[i];
    return latest;
}

const ear_counter *ear_counter_of(const ear_daemon *d, const char *name)
{
    for (size_t i = 0; i < d->counter_count; i++)
        if (strcmp(d->counters[i].name, name) == 0) return &d->counters[i];
    return NULL;
}

int64_t ear_value(const ear_daemon *d, const char *name)
{
    const ear_counter *c = ear_counter_of(d, name);
    return c && c->last > 0 ? c->last : 0;
}

/* ---- listening and asking ---- */

void ear_listen(ear *e, double seconds, double calm_s)
{
    double now = ear_now_s(), end = now + seconds, changed = now;
    size_t known = e->daemon_count;
    while (now < end && !(e->daemon_count && now - changed > calm_s)) {
        usleep(POLL_US);
        e->ops->poll(e);
        now = ear_now_s();
        if (e->daemon_count != known) changed = now;
        known = e->daemon_count;
    }
}

/* Over LCM a datagram may be lost: one repetition, under the same sequence, after a quarter of the time. */
bool ear_ask(ear *e, wire_query query, double seconds, void (*on_answer)(void *context, const wire_answer *answer),
    void *context)
{
    double begin = ear_now_s(), sent = 0;
    while (e->client == 0 && getrandom(&e->client, sizeof e->client, 0) > 0) e->client &= INT64_MAX;
    query.version = WIRE_VERSION;
    query.client = e->client;
    query.sequence = ++e->sequence;
    if (!query.name_b) query.name_b = "";
    const wire_message m = {.kind = WIRE_QUERY, .query = query};
    e->on_answer = on_answer;
    e->context = context;
    for (double now = begin; now < begin + seconds && e->answered != e->sequence; now = ear_now_s()) {
        if (e->ops->ready(e) && (sent == 0 || now - sent > seconds / 4) && e->ops->send(e, &m)) sent = now;
        usleep(sent == 0 ? POLL_US : 50); /* the round trip is measured: look often */
        e->ops->poll(e);
    }
    return e->answered == e->sequence;
}

bool ear_close(ear *e)
{
    if (!e) return true;
    for (size_t i = 0; i < e->daemon_count; i++) free(e->daemons[i].counters);
    return e->ops->close(e);
}
