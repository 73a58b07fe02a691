/* replay: ticks of a recording. Main thread. */
#include "replay.h"

#include "base/clock.h"
#include "compare.h"
#include "recordings.h"

#include <inttypes.h>
#include <stdio.h>
#include <sysexits.h>
#include <time.h>

typedef struct progress {
    service *service;
    wire_log_tick tick; /* that is replayed */
    int64_t ticks, first_different;
    uint64_t recorded_hash;
    bool has_events;      /* some were recorded ... */
    int64_t differs_tick; /* ... and the first tick in which what was reported differs; 0: none */
    difference what;
    int64_t began_ns, first_ns; /* now, and in the recording */
} progress;

bool replay_take(service *s, const link_sink *sink, wire_log_tick *t, char *why, size_t why_size)
{
    s->links[0]->ops->receive(s->links[0], sink);
    bool ended = !link_replay_tick(s->links[0], t, why, why_size);
    if (*s->taken.wrong) snprintf(why, why_size, "the state that it begins with cannot be taken: %s", s->taken.wrong);
    if (ended || *s->taken.wrong) return false;
    s->taken.stands = s->taken.is_there && s->tick == t->tick;
    s->taken.is_there = false;
    s->pairs_most = t->pairs_most;
    s->tick = t->tick;
    s->now_ns = t->now_ns;
    s->monotonic_ns = t->monotonic_ns;
    return true;
}

/* ---- a tick ---- */

static void compare_events(void *context, const world_batches *batches)
{
    progress *p = context;
    link_replay_reported reported = link_replay_events(p->service->links[0]);
    bool differs = batches->hash != (uint64_t)p->tick.events_hash;
    p->has_events |= reported.size != 0;
    /* Where nothing is recorded, nothing was reported, or no events were recorded then: a recording that has some
     * knows. */
    if (p->differs_tick || (!reported.size && !(p->has_events && differs))) return;
    if (!compare_batches(p->service, reported, batches, &p->what)) return;
    p->differs_tick = p->tick.tick;
    if (!p->first_different) p->first_different = p->tick.tick;
}

static void count_tick(progress *p)
{
    const service *s = p->service;
    p->ticks++;
    p->recorded_hash = (uint64_t)p->tick.events_hash;
    if (p->recorded_hash != s->events_hash && !p->first_different) p->first_different = p->tick.tick;
    if (!s->config.json && p->ticks % 10000 == 0) fprintf(stderr, "replay: %" PRId64 " ticks\n", p->ticks);
}

/* Until the tick is due, at the speed that was asked for. */
static void wait_for(progress *p, const _Atomic bool *stop)
{
    static const int64_t STEP_NS = 50000000; /* how soon a signal is seen */
    const service *s = p->service;
    int64_t now = clock_monotonic_ns();
    if (!p->ticks) {
        p->began_ns = now;
        p->first_ns = p->tick.monotonic_ns;
    }
    if (!(s->config.replay_speed > 0)) return;
    int64_t due = p->began_ns + (int64_t)((double)(p->tick.monotonic_ns - p->first_ns) / s->config.replay_speed);
    for (; now < due && !*stop; now = clock_monotonic_ns()) {
        int64_t left = due - now < STEP_NS ? due - now : STEP_NS;
        nanosleep(&(struct timespec){0, (long)left}, NULL);
    }
}

/* ---- what came of it ---- */

static void print_text(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        if ((unsigned char)*text < ' ')
            printf("\\u%04x", (unsigned char)*text);
        else
            printf(*text == '"' || *text == '\\' ? "\\%c" : "%c", *text);
    }
    putchar('"');
}

static void print_pair(const char *recorded, const char *replayed)
{
    printf(",\"recorded\":");
    print_text(recorded);
    printf(",\"replayed\":");
    print_text(replayed);
}

static void print_difference(int64_t tick, const difference *d)
{
    printf(",\"difference\":{\"tick\":%" PRId64 ",\"stream\":", tick);
    print_text(d->stream);
    printf(",\"event\":%" PRId64, d->event);
    print_pair(d->recorded, d->replayed);
    printf(",\"fields\":[");
    for (size_t i = 0; i < d->field_count; i++) {
        printf("%s{\"field\":", i ? "," : "");
        print_text(d->fields[i].name);
        print_pair(d->fields[i].recorded, d->fields[i].replayed);
        printf("}");
    }
    printf("],\"more\":%zu}", d->more);
}

static void report_difference(int64_t tick, const difference *d)
{
    printf("The first difference in what was reported, in tick %" PRId64 ":\n", tick);
    if (d->event >= 0)
        printf("  stream \"%s\", its event %" PRId64 " (from 0) in that tick:\n", d->stream, d->event);
    else
        printf("  stream \"%s\":\n", d->stream);
    printf("    recorded: %s\n    replayed: %s\n", d->recorded, d->replayed);
    for (size_t i = 0; i < d->field_count; i++)
        printf("    %s: recorded %s, replayed %s\n", d->fields[i].name, d->fields[i].recorded, d->fields[i].replayed);
    if (d->more) printf("    and %zu more numbers\n", d->more);
}

static void report(const progress *p)
{
    const service *s = p->service;
    uint64_t events = world_get_figures(s->world).events - s->taken.events;
    if (s->config.json) {
        printf("{\"event\":\"replay\",\"ticks\":%" PRId64 ",\"events\":%" PRIu64 ",\"hash\":\"%016" PRIx64
               "\",\"recorded\":\"%016" PRIx64 "\",\"first_different_tick\":%" PRId64,
            p->ticks, events, s->events_hash, p->recorded_hash, p->first_different);
        if (*s->taken.left) printf(",\"state_left_out\":");
        if (*s->taken.left) print_text(s->taken.left);
        if (p->differs_tick) print_difference(p->differs_tick, &p->what);
        printf("}\n");
        return;
    }
    printf("replayed %" PRId64 " ticks, %" PRIu64 " events, hash %016" PRIx64 "\n", p->ticks, events, s->events_hash);
    if (*s->taken.left)
        printf("The state that it begins with was left out: %s. It was begun with what is announced in it instead, so "
               "that velocities are missing at first, and contacts have other numbers\n",
            s->taken.left);
    if (!p->first_different) {
        printf("equal to the recording, tick by tick\n");
        return;
    }
    printf("DIFFERS from the recording from tick %" PRId64 " on: recorded hash %016" PRIx64 "\n", p->first_different,
        p->recorded_hash);
    if (p->differs_tick)
        report_difference(p->differs_tick, &p->what);
    else
        printf(p->has_events ? "All events are those that were recorded: only their hash is another one\n"
                             : "What differs cannot be told: the recording has no events (record_events)\n");
}

int replay_run(service *s, const link_sink *sink, const _Atomic bool *stop)
{
    progress p = {.service = s};
    char why[256] = "";
    s->on_batches = compare_events;
    s->on_batches_context = &p;
    while (!*stop && replay_take(s, sink, &p.tick, why, sizeof why)) {
        wait_for(&p, stop);
        service_replay_budget(s, p.tick.budgeted, (uint64_t)p.tick.work);
        s->slice = (uint64_t)p.tick.slice;
        if (s->taken.stands)
            record_tick(s);
        else
            service_tick(s); /* what it publishes goes to nobody */
        count_tick(&p);
    }
    s->on_batches = NULL;
    if (p.ticks || !*why) report(&p);
    if (*why) {
        fprintf(stderr, "collided: %s: %s: %s\n", s->config.replay, why,
            p.ticks ? "what came before it was replayed" : "name a recording of collided");
        return EX_DATAERR;
    }
    return p.first_different ? EX_SOFTWARE : EX_OK;
}
