/* trade: the runs, in lock-step, and what is heard of them. Main thread; each world may have workers of its own. */
#include "trade.h"

#include "base/clock.h"
#include "link/link_replay.h"
#include "report.h"
#include "service/replay.h"
#include "service/server.h"
#include "wire/wire_lcm.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

typedef struct run { /* of one level */
    server *server;
    service *service;
    link_sink sink;
    episodes told;
    spread ticks;         /* ns */
    int64_t listening_ns; /* of this tick, in `hear`: not the daemon's */
} run;

typedef struct contents { /* what is in the recording */
    int64_t ticks, interests, first_ns, last_ns;
} contents;

static int fail(const config *c, const char *why)
{
    fprintf(stderr, "collided: %s: %s\n", c->replay, why);
    return EX_DATAERR;
}

/* ---- what is in it ---- */

static void count_entry(contents *s, const wire_log_entry *e)
{
    if (e->kind == WIRE_LOG_MESSAGE) s->interests += e->message.kind == WIRE_INTEREST && !e->message.interest.removed;
    if (e->kind != WIRE_LOG_TICK) return;
    if (!s->ticks++) s->first_ns = e->tick.monotonic_ns;
    s->last_ns = e->tick.monotonic_ns;
}

static int look_through(const config *c, contents *s)
{
    char why[256] = "", text[512];
    wire_log_entry e;
    int got = -1;
    wire_log_reader *r = wire_log_open(c->replay, why, sizeof why);
    while (r && (got = wire_log_next(r, &e, NULL, why, sizeof why)) == 1) count_entry(s, &e);
    if (r) wire_log_end(r);
    if (got < 0) {
        snprintf(text, sizeof text, "%s: %s", why,
            s->ticks ? "a trade needs a whole recording: end it by SIGINT, or --seconds"
                     : "name a recording of collided");
        return fail(c, text);
    }
    if (!s->ticks) return fail(c, "no tick is in it: record while bodies move");
    if (!s->interests)
        return fail(c, "no interest is in it, so that nothing is asked: record while somebody listens, for example "
                       "'collidectl watch'");
    return EX_OK;
}

/* ---- the runs ---- */

static void hear(void *context, const wire_message *m)
{
    run *r = context;
    int64_t began = clock_monotonic_ns();
    if (m->kind == WIRE_EVENT_BATCH) episodes_take(&r->told, r->service->world, &m->event_batch, wire_lcm_size(m));
    r->listening_ns += clock_monotonic_ns() - began;
}

static int open_run(run *r, size_t level, const config *c)
{
    char why[512] = "";
    episodes_init(&r->told);
    r->server = server_create(c, why, sizeof why);
    if (!r->server) return fail(c, why);
    r->service = server_service(r->server);
    r->sink = server_sink(r->server);
    r->service->amend_interest = level_amend;
    r->service->amend_context = &trade_levels[level];
    link_replay_listen(r->service->links[0], hear, r);
    return EX_OK;
}

static void close_run(run *r)
{
    server_destroy(r->server);
    episodes_free(&r->told);
}

/* All streams are read: what is told to nobody would cost nothing. */
static void read_streams(run *r)
{
    service *s = r->service;
    for (size_t i = 0; i < s->streams.count; i++) {
        stream *t = &s->streams.at[i];
        if (t->live && !t->read && !t->ending) r->sink.stream_reader(r->sink.context, t->link, t->name);
    }
}

static void run_tick(run *r)
{
    r->listening_ns = 0;
    int64_t began = clock_monotonic_ns();
    service_tick(r->service);
    spread_add(&r->ticks, clock_monotonic_ns() - began - r->listening_ns);
    read_streams(r);
}

/* The same tick at every level, none of them always the first. False: the recording has ended. */
static bool step(run *runs, int64_t tick, char *why, size_t why_size)
{
    for (size_t k = 0; k < TRADE_LEVELS; k++) {
        run *r = &runs[((size_t)tick + k) % TRADE_LEVELS];
        wire_log_tick t;
        if (!replay_take(r->service, &r->sink, &t, why, why_size)) return false;
        run_tick(r);
    }
    return true;
}

static void run_all(run *runs, meter *m, const contents *s, char *why, size_t why_size)
{
    int64_t told_ns = 0;
    for (int64_t tick = 0; step(runs, tick, why, why_size); tick++) {
        meter_tick(m, runs[TRADE_EXACT].service->world);
        if (clock_monotonic_ns() - told_ns < 100000000) continue;
        told_ns = clock_monotonic_ns();
        printf("progress\t%.3f\n", (double)(tick + 1) / (double)s->ticks);
        fflush(stdout);
    }
}

static void print_result(run *runs, const meter *m, const contents *s)
{
    trade_result result = {.meter = m, .seconds = 1e-9 * (double)(s->last_ns - s->first_ns)};
    for (size_t i = 0; i < TRADE_LEVELS; i++) {
        episodes_sort(&runs[i].told);
        result.told[i] = &runs[i].told;
        result.ticks[i] = &runs[i].ticks;
    }
    printf("answers\t%" PRIu64 "\t%" PRIu64 "\n", m->answers, m->measured);
    report_rows(stdout, &result);
    puts("end");
}

static int compare(const config *c, const contents *s, run *runs)
{
    char why[256] = "";
    meter *m = meter_create();
    run_all(runs, m, s, why, sizeof why);
    int status = *why ? fail(c, why) : EX_OK;
    if (!status && !m->measured)
        status = fail(c, "no pair came so near that it had to be measured: there is nothing to compare");
    if (!status) print_result(runs, m, s);
    meter_destroy(m);
    return status;
}

int trade_run(const config *c)
{
    contents s = {.ticks = 0};
    config each = *c;
    int status = look_through(c, &s);
    if (status) return status;
    printf("trade\t1\nsession\t%" PRId64 "\t%.3f\t%" PRId64 "\n", s.ticks, 1e-9 * (double)(s.last_ns - s.first_ns),
        s.interests);
    if (!each.workers) each.workers = 1; /* the worlds run one at a time, and are compared */
    run *runs = base_zalloc(TRADE_LEVELS, sizeof *runs);
    size_t open = 0;
    while (open < TRADE_LEVELS && !(status = open_run(&runs[open], open, &each))) open++;
    if (!status) status = compare(c, &s, runs);
    for (size_t i = 0; i <= open && i < TRADE_LEVELS; i++) close_run(&runs[i]);
    free(runs);
    if (fflush(stdout) == 0 || status) return status;
    fprintf(stderr, "collided: standard output cannot be written\n");
    return EX_IOERR;
}
