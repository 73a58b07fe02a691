/* health: the counters of this process, the Status that carries them, and the page that Prometheus reads. Tick thread.
 */
#include "health.h"
#include "clients.h"
#include "memory.h"
#include "standby.h"
#include "streams.h"
#include "suspect.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#ifndef COLLIDED_RELEASE
#error "the build defines COLLIDED_RELEASE"
#endif

void health_register(service *s)
{
    char name[48];
    metrics *m = s->metrics;
    for (int k = WIRE_NOTHING + 1; k < WIRE_KIND_COUNT; k++) {
        snprintf(name, sizeof name, "in_%s", wire_kind_name((wire_kind)k));
        s->count.messages_in[k] = metrics_add(m, name, "messages of this kind that came and were well-formed");
    }
    for (int r = WIRE_OK; r < WIRE_REASON_COUNT; r++) {
        snprintf(name, sizeof name, "reject_%s", wire_reason_name((wire_reason)r));
        s->count.rejects[r] = metrics_add(m, name, "messages refused for this reason");
    }
    s->count.rejects_untold = metrics_add(m, "rejects_untold", "refusals not told to their client: too many a second");
    s->count.clients_lost = metrics_add(m, "clients_lost", "clients whose lease ran out");
    s->count.unheard =
        metrics_add(m, "unheard", "times that a client was found to be alive while what it publishes did not come");
    s->count.messages_lost =
        metrics_add(m, "messages_lost", "messages that a transport lost on their way to this daemon, at least");
    s->count.duplicates = metrics_add(m, "duplicates", "copies of messages that had been applied");
    s->count.joints_beyond = metrics_add(m, "joints_beyond", "configurations of robots beyond their joints' limits");
    s->count.late_poses = metrics_add(m, "late_poses", "poses older than one already applied");
    s->count.batches_out = metrics_add(m, "batches_out", "event batches published");
    s->count.batches_skipped =
        metrics_add(m, "batches_skipped", "event batches not sent to a subscriber that was behind: a snapshot follows");
    s->count.heartbeats = metrics_add(m, "heartbeats", "heartbeats of streams that had nothing to report");
    s->count.steps = metrics_add(m, "steps", "steps of lock-step that were done");
    s->count.steps_missed = metrics_add(m, "steps_missed", "steps that a lock-step client did not publish in time");
    s->count.events_out = metrics_add(m, "events_out", "events published");
    s->count.answers = metrics_add(m, "answers", "queries answered");
    s->count.queries_cut = metrics_add(m, "queries_cut", "queries given up, since they held the tick for too long");
    s->count.incomplete_frames =
        metrics_add(m, "incomplete_frames", "frames of vertices of which parts did not come: dropped");
    s->count.scene_batches = metrics_add(m, "scene_batches", "batches about scenes: bodies, and where they are");
    s->count.scene_poses = metrics_add(m, "scene_poses", "poses in them");
    s->count.unknown_extensions =
        metrics_add(m, "unknown_extensions", "extensions of messages that this release does not know: passed over");
    s->count.acks = metrics_add(m, "acks", "messages acknowledged");
    s->count.budget_over = metrics_add(m, "budget_over", "ticks that took more than 1.2 times budget_us");
    s->count.clock_steps = metrics_add(m, "clock_steps", "times that the wall clock was set back");
    s->count.record_failures = metrics_add(m, "record_failures", "recordings that the disk, or a limit, ended");
    s->count.records_refused = metrics_add(m, "records_refused", "wishes to end or begin a recording, refused");
    s->count.takeovers = metrics_add(m, "takeovers", "times that this standby went on for an active daemon");
    s->count.steps_down = metrics_add(m, "steps_down", "times that this daemon found that another one had taken over");
    s->count.out_of_step = metrics_add(m, "out_of_step", "times that this standby had to ask for the state anew");
    s->count.journalled = metrics_add(m, "journalled_ticks", "ticks handed to a standby");
    s->count.busy_ns = metrics_add(m, "busy_ns", "nanoseconds spent in ticks");
    s->count.tick_ns = metrics_add(m, "last_tick_ns", "nanoseconds of the last tick");
    s->count.round_longest_ns = metrics_add(m, "round_longest_ns",
        "nanoseconds of the longest round of the loop since the start: receiving, ticks, answers");
    s->count.round_most_cpu_ns = metrics_add(m, "round_most_cpu_ns",
        "nanoseconds of a processor that the most laborious round of the loop took on its own thread");
    s->count.ticks_on_arrival =
        metrics_add(m, "ticks_on_arrival", "ticks that ran on the thread that poses arrived on, without a hand-over");
    s->count.suspects_refused =
        metrics_add(m, "suspects_refused", "commands refused because a daemon was killed over them");
    s->count.memory_refused = metrics_add(m, "memory_refused", "messages refused because memory_limit was near");
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

static void add_world(const service *s, sheet *t)
{
    world_figures f = world_get_figures(s->world);
    sheet_add(t, "ready", s->whole && s->health != WIRE_HEALTH_STOPPING);
    sheet_add(t, "limits_reached", *s->limits != '\0');
    sheet_add(t, "clients", (int64_t)s->sessions.count);
    sheet_add(t, "clients_unheard", (int64_t)s->clients_unheard);
    sheet_add(t, "bodies", (int64_t)f.bodies);
    sheet_add(t, "shapes", (int64_t)f.shapes);
    sheet_add(t, "stale_bodies", (int64_t)f.stale_bodies);
    sheet_add(t, "subscriptions", (int64_t)f.subscriptions);
    sheet_add(t, "pairs", (int64_t)f.pairs);
    sheet_add(t, "pairs_left_out", (int64_t)f.pairs_left_out);
    sheet_add(t, "pending_pairs", (int64_t)f.pending_pairs);
    sheet_add(t, "bodies_with_pending_pairs", (int64_t)f.pending_bodies);
    sheet_add(t, "sliced_ticks", (int64_t)f.sliced_ticks);
    sheet_add(t, "contacts", (int64_t)f.contacts);
    sheet_add(t, "suspects", (int64_t)suspect_count(s));
    sheet_add(t, "memory_resident_bytes", s->memory->resident);
    sheet_add(t, "memory_limit_bytes", s->memory->statm < 0 ? 0 : s->memory->limit);
    sheet_add(t, "geometries", (int64_t)s->geometry_of.count);
    sheet_add(t, "lock_step_clients", (int64_t)s->lock_step.members);
    sheet_add(t, "waiting_commands", (int64_t)s->pending.count);
    sheet_add(t, "budget_ns", (int64_t)(1e3 * s->config.budget_us));
    sheet_add(t, "ticks", (int64_t)f.ticks);
    sheet_add(t, "moves", (int64_t)f.moves);
    sheet_add(t, "events", (int64_t)f.events);
    sheet_add(t, "narrow_queries", (int64_t)f.narrow_queries);
    sheet_add(t, "manifolds", (int64_t)f.manifolds);
    sheet_add(t, "wide_answers", (int64_t)f.wide);
    sheet_add(t, "refined_answers", (int64_t)f.refined);
    sheet_add(t, "ccd_failures", (int64_t)f.peer_failures);
    sheet_add(t, "sweeps", (int64_t)f.sweeps);
    sheet_add(t, "sweep_queries", (int64_t)f.sweep_queries);
    sheet_add(t, "sweeps_by_axis", (int64_t)f.sweeps_by_axis);
    sheet_add(t, "impacts", (int64_t)f.impacts);
    sheet_add(t, "predicted", (int64_t)f.predicted);
    sheet_add(t, "undecided_sweeps", (int64_t)f.undecided);
    sheet_add(t, "dropped_motions", (int64_t)f.dropped_motions);
    sheet_add(t, "coarse_motions", (int64_t)f.coarse_motions);
    sheet_add(t, "soft_bodies", (int64_t)f.soft_bodies);
    sheet_add(t, "soft_vertices", (int64_t)f.soft_vertices);
    sheet_add(t, "soft_waiting", (int64_t)f.soft_waiting);
    sheet_add(t, "soft_steps", (int64_t)f.soft_steps);
    sheet_add(t, "frames_skipped", (int64_t)f.frames_skipped);
    sheet_add(t, "soft_unfinished", (int64_t)f.soft_unfinished);
    sheet_add(t, "work", (int64_t)f.work);
    sheet_add(t, "undone", (int64_t)f.undone);
    sheet_add(t, "unbounded", (int64_t)f.unbounded);
    sheet_add(t, "undone_ticks", (int64_t)f.undone_ticks);
    for (int r = 0; r < STAGE_COUNT; r++)
        sheet_add_named(t, (int64_t)f.stages[r], "pairs_by_%s", world_stage_name((world_stage)r));
}

/* What an operator watches, of the first streams: what was reported there and stands. */
static void add_briefs(const service *s, sheet *t)
{
    enum { BRIEFS = 16, PAIRS_A_BRIEF = 20000 /* a millisecond or two */ };
    size_t told = 0, left = 2 * PAIRS_A_BRIEF; /* left: pairs of all of them together */
    for (uint32_t i = 0; i < s->streams.count && told < BRIEFS; i++) {
        const stream *to = &s->streams.at[i];
        world_brief b;
        if (!to->live || to->scene || !to->reported) continue;
        told++;
        bool all = world_brief_of(s->world, i, left < PAIRS_A_BRIEF ? left : PAIRS_A_BRIEF, &b);
        left -= b.pairs;
        sheet_add_named(t, (int64_t)b.contacts, "contacts_of_%s", to->name);
        sheet_add_named(t, (int64_t)b.unknown, "unknown_of_%s", to->name);
        if (isfinite(b.nearest)) sheet_add_named(t, (int64_t)floor(1e9 * b.nearest), "nearest_nm_of_%s", to->name);
        int64_t left_ns = b.soonest_ns > s->now_ns ? b.soonest_ns - s->now_ns : 0;
        if (b.soonest_ns != INT64_MAX) sheet_add_named(t, left_ns, "soonest_ns_of_%s", to->name);
        if (all && b.oldest_ns) sheet_add_named(t, s->now_ns - b.oldest_ns, "oldest_pose_ns_of_%s", to->name);
        if (!all) sheet_add_named(t, 1, "brief_cut_of_%s", to->name);
    }
}

/* What each stream tells, and costs: units of work a tick, since the last Status; those beyond the named together. */
static void add_streams(service *s, sheet *t)
{
    const char *names[SHEET_NAMED_MAX]; /* until they are told, nothing closes a stream */
    uint64_t works[SHEET_NAMED_MAX], rest = 0, events[SHEET_NAMED_MAX];
    int64_t behind[SHEET_NAMED_MAX];
    size_t named = 0, live = 0;
    int64_t ticks = s->tick > s->status_tick ? s->tick - s->status_tick : 1;
    for (uint32_t i = 0; i < s->streams.count; i++) {
        stream *to = &s->streams.at[i];
        uint64_t work = world_subscription_work(s->world, i),
                 since = (work > to->work ? work - to->work : 0) / (uint64_t)ticks;
        to->work = work;
        if (!to->live) continue;
        session *c = session_find(s, to->client);
        if (c) c->work += since;
        if (live++ >= SHEET_NAMED_MAX) {
            rest += since;
            continue;
        }
        names[named] = to->name;
        behind[named] = backlog_count(&to->backlog);
        events[named] = to->events;
        works[named++] = since;
    }
    sheet_add(t, "streams", (int64_t)live);
    sheet_add(t, "streams_behind", (int64_t)s->streams_behind);
    sheet_add(t, "streams_starving", (int64_t)s->streams_starving);
    for (size_t i = 0; i < named; i++) sheet_add_named(t, (int64_t)works[i], "work_of_%s", names[i]);
    if (live > named) sheet_add(t, "other_streams_work", (int64_t)rest);
    for (size_t i = 0; i < named; i++) sheet_add_named(t, (int64_t)events[i], "events_of_%s", names[i]);
    add_briefs(s, t);
    for (size_t i = 0; i < named; i++)
        if (behind[i]) sheet_add_named(t, behind[i], "behind_of_%s", names[i]);
    s->status_tick = s->tick;
}

/* Of what was since the last Status; where nothing was, 0. */
static void add_times(service *s, sheet *t)
{
    sheet_add(t, "latency_p50_ns", quantiles_at(&s->measures.latencies, 0.5));
    sheet_add(t, "latency_p90_ns", quantiles_at(&s->measures.latencies, 0.9));
    sheet_add(t, "latency_p99_ns", quantiles_at(&s->measures.latencies, 0.99));
    sheet_add(t, "latency_most_ns", s->measures.latencies.most_ns);
    sheet_add(t, "tick_p50_ns", quantiles_at(&s->measures.ticks, 0.5));
    sheet_add(t, "tick_p90_ns", quantiles_at(&s->measures.ticks, 0.9));
    sheet_add(t, "tick_p99_ns", quantiles_at(&s->measures.ticks, 0.99));
    sheet_add(t, "tick_most_ns", s->measures.ticks.most_ns);
    quantiles_clear(&s->measures.latencies);
    quantiles_clear(&s->measures.ticks);
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
    exporter_show(s->exporter, s->page.at, s->page.count,
        s->health == WIRE_HEALTH_STARTING   ? s->settling
        : s->health == WIRE_HEALTH_STOPPING ? "stopping"
                                            : NULL);
}

void health_limits(const service *s, char *text, size_t size)
{
    char suspect[480];
    suspect_describe(s, suspect, sizeof suspect);
    const char *const all[] = {
        s->limits, service_is_behind(s) ? "pending_pairs" : "", s->starving, s->unheard, s->samples_lost, suspect};
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < sizeof all / sizeof *all && used < size; i++)
        if (*all[i]) used += (size_t)snprintf(text + used, size - used, "%s%s", used ? "; " : "", all[i]);
}

void health_publish(service *s)
{
    sheet *t = s->sheet;
    char links[WIRE_TEXT_MAX], limits[HEALTH_LIMITS_MAX];
    describe_links(s, links, sizeof links);
    if (s->monotonic_ns - s->limit_ns > LIMITS_REPORTED_NS) s->limits[0] = '\0';
    health_limits(s, limits, sizeof limits);
    sheet_begin(t);
    add_world(s, t);
    health_add_lost(s, t);
    size_t registered = t->count; /* from here on */
    for (size_t i = 0; i < metrics_count(s->metrics); i++)
        sheet_add(t, metrics_at(s->metrics, i)->name, (int64_t)metric_get(metrics_at(s->metrics, i)));
    add_times(s, t);
    add_streams(s, t);
    health_add_clients(s, t);
    if (s->exporter) show(s, t, registered);
    wire_message m = {.kind = WIRE_STATUS,
        .status = {.version = WIRE_VERSION,
            .epoch = s->epoch,
            .health = s->health,
            .daemon = s->daemon_name,
            .release = COLLIDED_RELEASE,
            .links = links,
            .limits = limits,
            .stamp_ns = s->now_ns,
            .started_ns = s->started_ns,
            .tick = s->tick,
            .counter_names = {t->count, t->names},
            .counter_values = {t->count, t->values}}};
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->publish(s->links[i], &m);
}
