/* health: the counters of this process, the Status that carries them, and the page that Prometheus reads. Tick thread.
 */
#include "service.h"
#include "standby.h"

#include <inttypes.h>
#include <stdio.h>
#include <string.h>

#ifndef COLLIDED_RELEASE
#error "the build defines COLLIDED_RELEASE"
#endif

void health_register(service *s)
{
    static char in[WIRE_KIND_COUNT][48], refused[WIRE_REASON_COUNT][48];
    metrics *m = s->metrics;
    for (int k = WIRE_NOTHING + 1; k < WIRE_KIND_COUNT; k++) {
        snprintf(in[k], sizeof in[k], "in_%s", wire_kind_name((wire_kind)k));
        s->count.messages_in[k] = metrics_add(m, in[k], "messages of this kind that came and were well-formed");
    }
    for (int r = WIRE_OK; r < WIRE_REASON_COUNT; r++) {
        snprintf(refused[r], sizeof refused[r], "reject_%s", wire_reason_name((wire_reason)r));
        s->count.rejects[r] = metrics_add(m, refused[r], "messages refused for this reason");
    }
    s->count.rejects_untold = metrics_add(m, "rejects_untold", "refusals not told to their client: too many a second");
    s->count.clients_lost = metrics_add(m, "clients_lost", "clients whose lease ran out");
    s->count.duplicates = metrics_add(m, "duplicates", "copies of messages that had been applied");
    s->count.late_poses = metrics_add(m, "late_poses", "poses older than one already applied");
    s->count.batches_out = metrics_add(m, "batches_out", "event batches published");
    s->count.heartbeats = metrics_add(m, "heartbeats", "heartbeats of streams that had nothing to tell");
    s->count.steps = metrics_add(m, "steps", "steps of lock-step that were done");
    s->count.steps_missed = metrics_add(m, "steps_missed", "steps that a lock-step client did not publish in time");
    s->count.events_out = metrics_add(m, "events_out", "events published");
    s->count.answers = metrics_add(m, "answers", "queries answered");
    s->count.acks = metrics_add(m, "acks", "messages acknowledged");
    s->count.budget_over = metrics_add(m, "budget_over", "ticks that took more than 1.2 times budget_us");
    s->count.record_failures = metrics_add(m, "record_failures", "records that the disk refused");
    s->count.takeovers = metrics_add(m, "takeovers", "times that this standby went on for an active daemon");
    s->count.steps_down = metrics_add(m, "steps_down", "times that this daemon found that another one had taken over");
    s->count.out_of_step = metrics_add(m, "out_of_step", "times that this standby had to ask for the state anew");
    s->count.journalled = metrics_add(m, "journalled_ticks", "ticks handed to a standby");
    s->count.busy_ns = metrics_add(m, "busy_ns", "nanoseconds spent in ticks");
    s->count.tick_ns = metrics_add(m, "last_tick_ns", "nanoseconds of the last tick");
}

const char *health_release(void)
{
    return COLLIDED_RELEASE;
}

static void define(histogram *h, const char *name, const char *help, const double *bounds, size_t count)
{
    *h = (histogram){.name = name, .help = help, .bounds = bounds, .count = count};
}

void health_define(measures *m)
{
    static const double TIMES[] = {
        20e-6, 50e-6, 100e-6, 200e-6, 500e-6, 1e-3, 2e-3, 5e-3, 10e-3, 20e-3, 50e-3, 0.1, 0.2, 0.5, 1, 2, 5, 10};
    static const double WIDTHS[] = {
        0, 1e-15, 1e-14, 1e-13, 1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1};
    enum { TIME_COUNT = sizeof TIMES / sizeof *TIMES, WIDTH_COUNT = sizeof WIDTHS / sizeof *WIDTHS };
    define(&m->latency, "latency_seconds", "from the stamp of the newest pose to the events that follow from it", TIMES,
        TIME_COUNT);
    define(&m->tick, "tick_seconds", "duration of ticks", TIMES, TIME_COUNT);
    define(&m->age, "pose_age_seconds", "age of the older pose that a published event rests on", TIMES, TIME_COUNT);
    define(&m->width, "interval_width_metres", "width of the intervals in published events", WIDTHS, WIDTH_COUNT);
}

typedef struct sheet {
    const char *names[WIRE_COUNTERS_MAX];
    int64_t values[WIRE_COUNTERS_MAX];
    uint32_t count;
} sheet;

static void add(sheet *t, const char *name, uint64_t value)
{
    if (t->count == WIRE_COUNTERS_MAX) return; /* far more than there are: the registry is made at start */
    t->names[t->count] = name;
    t->values[t->count++] = (int64_t)value;
}

static void add_world(const service *s, sheet *t)
{
    static char rungs[RUNG_COUNT][48];
    world_figures f = world_get_figures(s->world);
    add(t, "clients", s->sessions.count);
    add(t, "bodies", f.bodies);
    add(t, "shapes", f.shapes);
    add(t, "stale_bodies", f.stale_bodies);
    add(t, "interests", f.interests);
    add(t, "pairs", f.pairs);
    add(t, "contacts", f.contacts);
    add(t, "geometries", s->geometry_of.count);
    add(t, "lock_step_clients", s->lock_step.members);
    add(t, "ticks", f.ticks);
    add(t, "moves", f.moves);
    add(t, "events", f.events);
    add(t, "narrow_queries", f.narrow_queries);
    add(t, "manifolds", f.manifolds);
    add(t, "wide_answers", f.wide);
    add(t, "refined_answers", f.refined);
    add(t, "ccd_failures", f.peer_failures);
    add(t, "sweeps", f.sweeps);
    add(t, "sweep_queries", f.sweep_queries);
    add(t, "sweeps_by_axis", f.sweeps_by_axis);
    add(t, "impacts", f.impacts);
    add(t, "foretold", f.foretold);
    add(t, "undecided_sweeps", f.undecided);
    add(t, "coarse_ways", f.coarse_ways);
    add(t, "work", f.work);
    add(t, "undone", f.undone);
    add(t, "unbounded", f.unbounded);
    add(t, "undone_ticks", f.undone_ticks);
    for (int r = 0; r < RUNG_COUNT; r++) {
        snprintf(rungs[r], sizeof rungs[r], "pairs_by_%s", world_rung_name((world_rung)r));
        add(t, rungs[r], f.rungs[r]);
    }
}

/* What each subscriber costs: units of work a tick, since the last Status; those beyond NAMED_MAX together. */
static void add_work(service *s, sheet *t)
{
    enum { NAMED_MAX = 64 };
    static char names[NAMED_MAX][WIRE_NAME_MAX + 16];
    size_t named = 0;
    uint64_t rest = 0;
    int64_t ticks = s->tick > s->status_tick ? s->tick - s->status_tick : 1;
    for (uint32_t i = 0; i < s->streams.count; i++) {
        stream *to = &s->streams.at[i];
        uint64_t work = world_interest_work(s->world, i), since = work > to->work ? work - to->work : 0;
        to->work = work;
        if (!to->live) continue;
        if (named == NAMED_MAX) {
            rest += since;
            continue;
        }
        snprintf(names[named], sizeof names[0], "work_of_%s", to->name);
        add(t, names[named++], since / (uint64_t)ticks);
    }
    if (named == NAMED_MAX) add(t, "work_of_other_streams", rest / (uint64_t)ticks);
    s->status_tick = s->tick;
}

/* Whose lease ran out and whose bodies stay. Those who left in order are not missed. */
static void add_lost(const service *s, sheet *t)
{
    enum { NAMED_MAX = 64 };
    static char names[NAMED_MAX][32];
    size_t clients = 0, bodies = 0;
    for (size_t i = 0; i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        size_t left = c->lost && !c->left ? session_bodies(c) : 0;
        if (!left) continue;
        bodies += left;
        if (clients++ >= NAMED_MAX) continue; /* counted, and told in the log */
        snprintf(names[clients - 1], sizeof names[0], "lost_client_%016" PRIx64, (uint64_t)c->client);
        add(t, names[clients - 1], left);
    }
    add(t, "lost_clients", clients);
    add(t, "lost_bodies", bodies);
}

static void describe_links(const service *s, char *text, size_t size)
{
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < s->link_count && used < size; i++) {
        char one[512] = "";
        s->links[i]->ops->describe(s->links[i], one, sizeof one);
        used += (size_t)snprintf(text + used, size - used, "%s%s", i ? "; " : "", one);
    }
    if (used < size) standby_describe(s, text + used, size - used);
}

static void show(service *s, const sheet *t, size_t registered)
{
    s->page.count = 0;
    page_build_info(&s->page, COLLIDED_RELEASE, s->daemon_name);
    for (size_t i = 0; i < t->count; i++) {
        bool known = i >= registered && i - registered < metrics_count(s->metrics);
        page_number(&s->page, t->names[i], known ? metrics_at(s->metrics, i - registered)->help : NULL, t->values[i]);
    }
    const histogram *all[] = {&s->measures.latency, &s->measures.tick, &s->measures.age, &s->measures.width};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) page_histogram(&s->page, all[i]);
    exporter_show(s->exporter, s->page.at, s->page.count, s->health == WIRE_HEALTH_STOPPING ? "stopping" : NULL);
}

void health_publish(service *s)
{
    static sheet t; /* the tick thread's */
    char links[WIRE_TEXT_MAX];
    describe_links(s, links, sizeof links);
    if (s->monotonic_ns - s->limit_ns > LIMITS_TOLD_NS) s->limits[0] = '\0';
    t.count = 0;
    add_world(s, &t);
    add_lost(s, &t);
    size_t registered = t.count; /* from here on */
    for (size_t i = 0; i < metrics_count(s->metrics); i++)
        add(&t, metrics_at(s->metrics, i)->name, metric_get(metrics_at(s->metrics, i)));
    add_work(s, &t);
    if (s->exporter) show(s, &t, registered);
    wire_message m = {.kind = WIRE_STATUS,
        .status = {.version = WIRE_VERSION,
            .epoch = s->epoch,
            .health = s->health,
            .daemon = s->daemon_name,
            .release = COLLIDED_RELEASE,
            .links = links,
            .limits = s->limits,
            .stamp_ns = s->now_ns,
            .started_ns = s->started_ns,
            .tick = s->tick,
            .counter_names = {t.count, t.names},
            .counter_values = {t.count, t.values}}};
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->publish(s->links[i], &m);
}
