/* replay: ticks of a recording. Main thread. */
#include "replay.h"

#include "link/link_replay.h"

#include <inttypes.h>
#include <stdio.h>
#include <sysexits.h>

typedef struct progress {
    int64_t ticks, first_different;
    uint64_t recorded_hash;
} progress;

bool replay_take(service *s, const link_sink *sink, wire_log_tick *t, char *why, size_t why_size)
{
    s->links[0]->ops->receive(s->links[0], sink);
    if (!link_replay_tick(s->links[0], t, why, why_size)) return false;
    s->tick = t->tick;
    s->now_ns = t->now_ns;
    s->monotonic_ns = t->monotonic_ns;
    return true;
}

static void count_tick(const service *s, const wire_log_tick *t, progress *p)
{
    p->ticks++;
    p->recorded_hash = (uint64_t)t->events_hash;
    if (p->recorded_hash != s->events_hash && !p->first_different) p->first_different = t->tick;
    if (!s->config.json && p->ticks % 10000 == 0) fprintf(stderr, "replay: %" PRId64 " ticks\n", p->ticks);
}

static void report(const service *s, const progress *p)
{
    world_figures f = world_get_figures(s->world);
    if (s->config.json) {
        printf("{\"event\":\"replay\",\"ticks\":%" PRId64 ",\"events\":%" PRIu64 ",\"hash\":\"%016" PRIx64
               "\",\"recorded\":\"%016" PRIx64 "\",\"first_different_tick\":%" PRId64 "}\n",
            p->ticks, f.events, s->events_hash, p->recorded_hash, p->first_different);
        return;
    }
    printf("replayed %" PRId64 " ticks, %" PRIu64 " events, hash %016" PRIx64 "\n", p->ticks, f.events, s->events_hash);
    if (p->first_different)
        printf("DIFFERS from the recording from tick %" PRId64 " on: recorded hash %016" PRIx64 "\n",
            p->first_different, p->recorded_hash);
    else
        printf("equal to the recording, tick by tick\n");
}

int replay_run(service *s, const link_sink *sink)
{
    progress p = {0};
    wire_log_tick t;
    char why[256] = "";
    while (replay_take(s, sink, &t, why, sizeof why)) {
        service_replay_budget(s, t.budgeted, (uint64_t)t.work);
        service_tick(s); /* what it publishes goes to nobody */
        count_tick(s, &t, &p);
    }
    if (p.ticks || !*why) report(s, &p);
    if (*why) {
        fprintf(stderr, "collided: %s: %s: %s\n", s->config.replay, why,
            p.ticks ? "what came before it was replayed" : "name a recording of collided");
        return EX_DATAERR;
    }
    return p.first_different ? EX_SOFTWARE : EX_OK;
}
