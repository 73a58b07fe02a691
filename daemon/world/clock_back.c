/* clock_back: the wall clock was set back. Everything that the world remembers of the clock before goes back with it:
 * deadlines, the next updates of rates, and the stamps of poses, so that ages stay what they were, and what is stamped
 * by the clock as it is now is newer than what it was before. Tick thread. */
#include "state.h"

/* Stamps of a simulator's own time are none of the wall clock's. */
static const int64_t NEAR_NS = INT64_C(86400000000000);

static void shift_stamp(int64_t *stamp_ns, int64_t old_ns, int64_t by_ns)
{
    if (*stamp_ns > by_ns && *stamp_ns > old_ns - NEAR_NS && *stamp_ns < old_ns + NEAR_NS) *stamp_ns -= by_ns;
}

static void shift_past(past_motion *p, int64_t old_ns, int64_t by_ns)
{
    shift_stamp(&p->from_ns, old_ns, by_ns);
    shift_stamp(&p->to_ns, old_ns, by_ns);
    p->now_ns -= by_ns;
    for (size_t i = 0; i < p->passed_count; i++) shift_stamp(&p->passed[i].stamp_ns, old_ns, by_ns);
}

static void shift_body(body *b, int64_t old_ns, int64_t by_ns)
{
    shift_stamp(&b->stamp_ns, old_ns, by_ns);
    shift_stamp(&b->before_ns, old_ns, by_ns);
    shift_stamp(&b->announced_ns, old_ns, by_ns);
    for (size_t i = 0; i < b->passed.count; i++) shift_stamp(&b->passed.at[i].stamp_ns, old_ns, by_ns);
    for (size_t i = 0; i < b->past.count; i++) shift_past(&b->past.at[i], old_ns, by_ns);
    if (b->expiry_ns != INT64_MAX) b->expiry_ns -= by_ns;
    if (b->expiry_queued) b->queued_ns -= by_ns;
}

void world_clock_back(world *w, int64_t by_ns)
{
    for (size_t i = 0; i < w->bodies.count; i++)
        if (w->bodies.at[i].used) shift_body(&w->bodies.at[i], w->now_ns, by_ns);
    for (size_t i = 0; i < w->expiries.count; i++) w->expiries.at[i].time_ns -= by_ns; /* all: it stays a heap */
    for (size_t i = 0; i < w->subscriptions.count; i++) w->subscriptions.at[i].next_update_ns -= by_ns;
    w->last_tick_ns -= by_ns;
    w->now_ns -= by_ns;
}
