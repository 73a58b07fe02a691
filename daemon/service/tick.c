/* tick: one tick of the service: the same for live links and for a replay. Tick thread. */
#include "base/clock.h"
#include "base/log.h"
#include "base/whole.h"
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "memory.h"
#include "recordings.h"
#include "service.h"
#include "shares.h"
#include "standby.h"
#include "streams.h"
#include "suspect.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

/* Rare: where auto changes its mind, it does so with hysteresis. */
void service_report_broad(service *s)
{
    char text[96];
    if (world_broad_kind(s->world) == s->reported_broad) return;
    s->reported_broad = world_broad_kind(s->world);
    world_report_broad(s->world, text);
    log_notice("broad phase: %s", text);
}

/* ---- the budget ---- */

static uint64_t grant_by_clock(void *context, uint64_t done)
{
    service *s = context;
    return pace_grant(&s->pace, clock_monotonic_ns(), done);
}

static uint64_t grant_as_recorded(void *context, uint64_t done)
{
    const service *s = context;
    (void)done;
    return s->recorded_work;
}

void service_set_budget(service *s)
{
    if (!(s->config.budget_us > 0) || s->replaying) return;
    pace_init(&s->pace, (int64_t)(1e3 * s->config.budget_us));
    world_set_budget(s->world, grant_by_clock, s);
}

void service_replay_budget(service *s, bool budgeted, uint64_t work)
{
    if (budgeted != s->recorded_budget) world_set_budget(s->world, budgeted ? grant_as_recorded : NULL, s);
    s->recorded_budget = budgeted;
    s->recorded_work = work;
}

/* ---- slices ---- */

/* Units: with fewer even a small world would be cut. */
static const double SLICE_LEAST = 2e6;
/* Nanoseconds: what ticks show of a unit may be far less, where they looked up what had been found out. The next tick,
 * which has to find out, is not to take all that this seems to leave. */
static const double UNIT_LEAST_NS = 3, UNIT_FIRST_NS = 4;   /* as long as no tick has shown anything */
static const double SLICE_LEFT = 0.5;                       /* of it, whatever else a round does */
static const double LEARN_SLOWER = 0.5, LEARN_FASTER = 0.1; /* of what the last tick has shown */
static const uint64_t SLICE_TO_LEARN_FROM = 1000000;        /* units */

static double unit_ns(const service *s)
{
    return s->slice_unit_ns > 0 ? s->slice_unit_ns : UNIT_FIRST_NS;
}

/* What has been received in this round, and is to be carried out, is a part of what the slice is to bound. */
void service_choose_slice(service *s, int64_t spent_ns)
{
    double before_us =
        1e-3 * (double)spent_ns + shares_expected_us(s) + 1e-3 * (double)(world_effort(s->world) + steps_effort(s));
    double us = fmax(s->config.slice_us - before_us, SLICE_LEFT * s->config.slice_us);
    double units = 1e3 * us / unit_ns(s);
    units = fmax(units, SLICE_LEAST);
    s->slice = s->config.slice_us > 0 ? (uint64_t)units : 0;
}

/* All that the tick took counts, with what it told. A tick that was held up by others on its core counts for twice as
 * much at most. */
void service_learn_slice(service *s, int64_t took_ns)
{
    uint64_t units = world_get_figures(s->world).slice_units;
    if (!world_was_sliced(s->world) || units < SLICE_TO_LEARN_FROM) return;
    double was = unit_ns(s), is = (double)took_ns / (double)units;
    if (is > 2 * was) is = 2 * was;
    s->slice_unit_ns = fmax(was + (is > was ? LEARN_SLOWER : LEARN_FASTER) * (is - was), UNIT_LEAST_NS);
}

/* The rest of what the tick took, if that was worth learning from: nothing but how much is received hangs on it. */
void service_learn_effort(service *s, uint64_t effort, int64_t took_ns)
{
    static const double MOST = 8; /* a mistake is not to last */
    double slice_ns = (double)world_get_figures(s->world).slice_units * unit_ns(s);
    if (effort < SLICE_TO_LEARN_FROM) return;
    double was = fmax(s->effort_unit_ns, 1), is = fmax((double)took_ns - slice_ns, 0) / (double)effort;
    is = fmin(is, fmin(2 * was, MOST));
    s->effort_unit_ns = was + (is > was ? LEARN_SLOWER : LEARN_FASTER) * (is - was);
}

uint64_t service_slice_reported(const service *s)
{
    return world_was_sliced(s->world) ? s->slice : 0;
}

/* ---- the wall clock ---- */

/* What is slewed, or read a little late, is no step; a step is what NTP or somebody has set. */
static const int64_t STEP_NS = 20000000;

bool service_clock_back(const service *s)
{
    return s->wall_ahead_ns && s->now_ns - s->monotonic_ns < s->wall_ahead_ns - STEP_NS;
}

/* By the two clocks of ticks, which are recorded: a replay does it in the same tick. Set forward, it makes poses old
 * that are, perhaps, not, which the next ones mend; set back, it would make all that comes older than what came, and
 * let no deadline pass. */
void service_follow_clock(service *s)
{
    int64_t ahead_ns = s->now_ns - s->monotonic_ns, by_ns = s->wall_ahead_ns - ahead_ns;
    bool back = service_clock_back(s);
    s->wall_ahead_ns = ahead_ns;
    if (!back) return;
    log_warning("the wall clock was set back by %.3f s: what the world knows goes back with it", 1e-9 * (double)by_ns);
    metric_count(s->count.clock_steps, 1);
    if (s->latest_pose_ns > s->now_ns) s->latest_pose_ns -= by_ns;
    for (size_t i = 0; i < s->sessions.count; i++) /* their ages in Status */
        if (s->sessions.at[i]->latest_pose_ns > s->now_ns) s->sessions.at[i]->latest_pose_ns -= by_ns;
    world_clock_back(s->world, by_ns);
}

/* ---- the tick ---- */

int64_t service_pairs_limited(const service *s)
{
    world_figures f = world_get_figures(s->world);
    return f.pairs_left_out || f.parked_bodies || world_was_sliced(s->world) ? s->pairs_most : 0;
}

/* Of a limit that no command is refused for. */
static void report_pairs_left_out(service *s)
{
    world_figures f = world_get_figures(s->world);
    if (!f.pairs_left_out && !f.parked_bodies) return;
    const char *option = s->pairs_most ? "memory_limit" : "max_pairs";
    if (!strstr(s->limits, option))
        log_warning("%s = %" PRId64 " is reached: %zu pairs are not looked at%s", option,
            s->pairs_most ? s->memory->limit >> 20 : (int64_t)s->config.max_pairs, f.pairs_left_out,
            f.parked_bodies ? ", nor those that have not been counted" : "");
    apply_name_limit(s, option);
}

/* What a large step or many new bodies leave for a few ticks is no reason to be degraded; nor is it, once it is, over
 * between two surges. */
static const int64_t PENDING_LONG_NS = 100000000, PENDING_OVER_NS = 1000000000;

static void note_pending(service *s)
{
    bool was = service_is_behind(s);
    world_figures f = world_get_figures(s->world);
    if (f.pending_bodies) {
        if (!s->pending_ns || s->monotonic_ns - s->pending_last_ns > PENDING_OVER_NS) s->pending_ns = s->monotonic_ns;
        s->pending_last_ns = s->monotonic_ns;
    }
    if (!was && service_is_behind(s))
        log_warning("more has changed than can be decided at once: %zu pairs or more of %zu bodies are pending, and "
                    "unknown until then",
            f.pending_pairs, f.pending_bodies);
}

bool service_is_behind(const service *s)
{
    return s->pending_last_ns - s->pending_ns > PENDING_LONG_NS &&
           s->monotonic_ns - s->pending_last_ns < PENDING_OVER_NS;
}

static void carry_out_commands(service *s)
{
    bool learn = shares_learn(s);
    int64_t began_ns = learn ? clock_thread_ns() : 0;
    inbox_apply(s);
    if (learn) shares_carried_out(s, clock_thread_ns() - began_ns);
}

/* Queries wait in the inbox like commands, and are answered from the world as the tick leaves it. */
void service_tick(service *s)
{
    world_batches batches;
    service_follow_clock(s);
    carry_out_commands(s);
    s->stepped = false;
    stream_ask_all(s);
    world_set_slice(s->world, s->slice ? s->slice : UINT64_MAX);
    world_set_pairs_most(s->world, (size_t)s->pairs_most);
    suspect_begin_tick(s);
    world_tick(s->world, s->now_ns, &batches);
    suspect_end(s);
    steps_settle(s);
    service_report_broad(s);
    report_pairs_left_out(s);
    note_pending(s);
    s->events_hash = batches.hash;
    record_events(s, &batches);
    standby_journal_tick(s); /* before anybody is told: what readers have been told, the standby knows */
    if (s->on_batches) s->on_batches(s->on_batches_context, &batches);
    stream_publish(s, &batches);
    session_send_acks(s);
    inbox_answer(s);
    geometry_sweep(s);
    shares_ticked(s);
    record_tick(s); /* perhaps with the state as the next tick finds it */
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
    ASSERT_WHOLE(
        whole_is_due((uint64_t)s->tick, world_get_figures(s->world).bodies + s->streams.count), service_validate(s));
}
