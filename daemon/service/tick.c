/* tick: one tick of the service: the same for live links and for a replay. Tick thread. */
#include "base/clock.h"
#include "base/log.h"
#include "service.h"
#include "standby.h"

/* Rare: where auto changes its mind, it does so with hysteresis. */
void service_tell_broad(service *s)
{
    char text[96];
    if (world_broad_kind(s->world) == s->told_broad) return;
    s->told_broad = world_broad_kind(s->world);
    world_tell_broad(s->world, text);
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

/* ---- the tick ---- */

void service_take(service *s, struct link *from, const wire_message *m)
{
    session_heard(s, m);
    if (m->kind != WIRE_QUERY) {
        record_message(s, m);
        standby_journal_message(s, from, m);
    }
    if (m->kind == WIRE_POSE_BATCH)
        apply_poses(s, from, &m->pose_batch, true);
    else
        inbox_put(s, from, m);
}

/* Queries wait in the inbox like commands, and are answered from the world as the tick leaves it. */
void service_tick(service *s)
{
    world_batches batches;
    inbox_apply(s);
    stream_ask_all(s);
    world_tick(s->world, s->now_ns, &batches);
    service_tell_broad(s);
    s->events_hash = batches.hash;
    standby_journal_tick(s); /* before anybody is told: what readers have been told, the standby knows */
    stream_publish(s, &batches);
    session_send_acks(s);
    inbox_answer(s);
    record_tick(s);
    geometry_sweep(s);
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
}
