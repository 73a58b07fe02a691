/* trade: the runs, in lock-step, and what is heard of them. Main thread; each world may have workers of its own. */
#include "trade.h"

#include "base/array.h"
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
    episodes reported;
    int64_t listening_ns; /* of this tick, in `hear`: not the daemon's */
} run;

typedef struct contents { /* what is in the recording */
    int64_t ticks, subscriptions, first_ns, last_ns;
    ARRAY(bool) builds; /* of each tick: something is announced in it, or taken back */
    int64_t left_out;   /* such ticks: what they cost is no question of accuracy */
    bool building;      /* such a command has come since the last tick */
} contents;

enum { PASSES = 3 }; /* of a tick's times, the least counts, so that the scheduler has no say */

typedef struct comparison {
    const config *config;
    const contents *in;
    run runs[TRADE_LEVELS];
    int64_t *ticks_ns[TRADE_LEVELS]; /* one a tick */
    meter *meter;
    int64_t pass, reported_ns; /* told: the progress, last */
} comparison;

static int fail_with(int status, const config *c, const char *why)
{
    fprintf(stderr, "collided: %s: %s\n", c->replay, why);
    return status;
}

/* The recording is to blame. */
static int fail(const config *c, const char *why)
{
    return fail_with(EX_DATAERR, c, why);
}

/* ---- what is in it ---- */

/* Geometries are built, bodies put, pairs found and subscriptions matched in the tick of these. */
static bool is_built(const wire_message *m)
{
    return m->kind == WIRE_GEOMETRY || m->kind == WIRE_BODY || m->kind == WIRE_SUBSCRIPTION;
}

static void count_entry(contents *s, const wire_log_entry *e)
{
    if (e->kind == WIRE_LOG_MESSAGE)
        s->subscriptions += e->message.kind == WIRE_SUBSCRIPTION && !e->message.subscription.removed;
    s->building |= e->kind == WIRE_LOG_MESSAGE && is_built(&e->message);
    if (e->kind != WIRE_LOG_TICK) return;
    if (!s->ticks++) s->first_ns = e->tick.monotonic_ns;
    s->last_ns = e->tick.monotonic_ns;
    array_push(&s->builds, s->building);
    s->left_out += s->building;
    s->building = false;
}

/* Where there is no other tick, all are measured. */
static void leave_none_out(contents *s)
{
    if (s->left_out < s->ticks) return;
    for (size_t i = 0; i < s->builds.count; i++) s->builds.at[i] = false;
    s->left_out = 0;
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
    leave_none_out(s);
    if (!s->subscriptions)
        return fail(c, "no subscription is in it, so that nothing is asked: record while somebody listens, for example "
                       "'collidectl watch'");
    return EX_OK;
}

/* ---- the runs ---- */

static void hear(void *context, const wire_message *m)
{
    run *r = context;
    int64_t began = clock_monotonic_ns();
    if (m->kind == WIRE_EVENT_BATCH) episodes_take(&r->reported, r->service->world, &m->event_batch, wire_lcm_size(m));
    r->listening_ns += clock_monotonic_ns() - began;
}

static int open_run(run *r, size_t level, const config *c)
{
    char why[512] = "";
    episodes_init(&r->reported);
    r->server = server_create(c, why, sizeof why);
    if (!r->server) return fail_with(EX_UNAVAILABLE, c, why); /* as without a trade; the recording has been read */
    r->service = server_service(r->server);
    r->sink = server_sink(r->server);
    r->sink.state = NULL; /* its subscriptions ask for what they asked, and not for what is compared */
    r->service->amend_subscription = level_amend;
    r->service->amend_context = &trade_levels[level];
    link_replay_listen(r->service->links[0], hear, r);
    return EX_OK;
}

/* All streams are read: what is reported to nobody would cost nothing. */
static void read_streams(run *r)
{
    service *s = r->service;
    for (size_t i = 0; i < s->streams.count; i++) {
        stream *t = &s->streams.at[i];
        if (t->live && !t->read && !t->ending) r->sink.stream_reader(r->sink.context, t->link, t->name);
    }
}

static void run_tick(run *r, int64_t *least_ns)
{
    r->listening_ns = 0;
    int64_t began = clock_monotonic_ns();
    service_tick(r->service);
    int64_t took = clock_monotonic_ns() - began - r->listening_ns;
    if (took < *least_ns) *least_ns = took;
    read_streams(r);
}

/* The same tick at every level, none of them always the first. False: the recording has ended. */
static bool step(comparison *v, int64_t tick, char *why, size_t why_size)
{
    for (int64_t k = 0; k < TRADE_LEVELS; k++) {
        int64_t level = (tick + v->pass + k) % TRADE_LEVELS;
        run *r = &v->runs[level];
        wire_log_tick t;
        if (!replay_take(r->service, &r->sink, &t, why, why_size)) return false;
        run_tick(r, &v->ticks_ns[level][tick]);
    }
    return true;
}

static void report_progress(comparison *v, int64_t tick)
{
    if (clock_monotonic_ns() - v->reported_ns < 100000000) return;
    v->reported_ns = clock_monotonic_ns();
    printf("progress\t%.3f\n", (double)(v->pass * v->in->ticks + tick + 1) / (double)(PASSES * v->in->ticks));
    fflush(stdout);
}

static void close_runs(comparison *v)
{
    for (size_t i = 0; i < TRADE_LEVELS; i++) {
        server_destroy(v->runs[i].server);
        episodes_free(&v->runs[i].reported);
        v->runs[i] = (run){.server = NULL};
    }
}

/* All of it once. The runs stay open. */
static int run_pass(comparison *v)
{
    char why[256] = "";
    int status = EX_OK;
    for (size_t i = 0; i < TRADE_LEVELS && !status; i++) status = open_run(&v->runs[i], i, v->config);
    for (int64_t tick = 0; !status && tick < v->in->ticks && step(v, tick, why, sizeof why); tick++) {
        if (v->pass == 0) meter_tick(v->meter, v->runs[TRADE_EXACT].service->world);
        report_progress(v, tick);
    }
    return *why ? fail(v->config, why) : status;
}

/* ---- the result ---- */

static void print_result(comparison *v)
{
    trade_result result = {.meter = v->meter, .seconds = 1e-9 * (double)(v->in->last_ns - v->in->first_ns)};
    spread *ticks = base_zalloc(TRADE_LEVELS, sizeof *ticks);
    for (size_t i = 0; i < TRADE_LEVELS; i++) {
        for (int64_t tick = 0; tick < v->in->ticks; tick++)
            if (!v->in->builds.at[tick]) spread_add(&ticks[i], v->ticks_ns[i][tick]);
        episodes_sort(&v->runs[i].reported);
        result.reported[i] = &v->runs[i].reported;
        result.ticks[i] = &ticks[i];
    }
    printf("answers\t%" PRIu64 "\t%" PRIu64 "\n", v->meter->answers, v->meter->measured);
    report_rows(stdout, &result);
    puts("end");
    free(ticks);
}

static int compare(comparison *v)
{
    int status = EX_OK;
    for (v->pass = 0; v->pass < PASSES && !status; v->pass++) {
        close_runs(v);
        status = run_pass(v);
        if (!status && !v->meter->measured)
            status = fail(v->config, "no pair came so near that it had to be measured: there is nothing to compare");
    }
    if (!status) print_result(v);
    close_runs(v);
    return status;
}

static comparison *comparison_create(const config *c, const contents *in)
{
    comparison *v = base_zalloc(1, sizeof *v);
    v->config = c;
    v->in = in;
    v->meter = meter_create();
    for (size_t i = 0; i < TRADE_LEVELS; i++) {
        v->ticks_ns[i] = base_alloc((size_t)in->ticks, sizeof **v->ticks_ns);
        for (int64_t tick = 0; tick < in->ticks; tick++) v->ticks_ns[i][tick] = INT64_MAX;
    }
    return v;
}

static void comparison_destroy(comparison *v)
{
    for (size_t i = 0; i < TRADE_LEVELS; i++) free(v->ticks_ns[i]);
    meter_destroy(v->meter);
    free(v);
}

int trade_run(const config *c)
{
    contents in = {.ticks = 0};
    config each = *c;
    int status = look_through(c, &in);
    if (status) {
        array_free(&in.builds);
        return status;
    }
    printf("trade\t2\nsession\t%" PRId64 "\t%.3f\t%" PRId64 "\t%" PRId64 "\n", in.ticks,
        1e-9 * (double)(in.last_ns - in.first_ns), in.subscriptions, in.left_out);
    each.record[0] = '\0';               /* six daemons would write it */
    if (!each.workers) each.workers = 1; /* the worlds run one at a time, and are compared */
    comparison *v = comparison_create(&each, &in);
    status = compare(v);
    comparison_destroy(v);
    array_free(&in.builds);
    if (fflush(stdout) == 0 || status) return status;
    fprintf(stderr, "collided: standard output cannot be written\n");
    return EX_IOERR;
}
