/* status: what the daemon last said of itself, with this client's own counters beside its. The caller's thread. */
#include "allocate.h"
#include "message.h"
#include "session.h"
#include "session_run.h"

#include <stdlib.h>

static bool has_status(const collided *c)
{
    return c->status && c->status->status.epoch == c->epoch;
}

static const char *health_name(uint8_t health)
{
    static const char *const names[] = {[WIRE_HEALTH_STARTING] = "starting",
        [WIRE_HEALTH_READY] = "ready",
        [WIRE_HEALTH_DEGRADED] = "degraded",
        [WIRE_HEALTH_STOPPING] = "stopping"};
    return health < sizeof names / sizeof names[0] ? names[health] : "unknown";
}

/* The daemon's counters, then ours. */
static size_t fill_counters(collided *c, const wire_status *s)
{
    const session_counters *own = &c->counters;
    const collided_counter ours[] = {
        {"client_repeats", own->repeats},
        {"client_announced_again", own->announced_again},
        {"client_foreign_messages", own->foreign},
        {"client_malformed_messages", own->malformed},
        {"client_rejections_dropped", own->rejections_dropped},
        {"client_batches_lost", own->batches_lost},
        {"client_unknown_events", own->unknown_events},
        {"client_stalls", own->stalls},
        {"client_send_failures", own->send_failures},
        {"client_unheard", own->unheard},
        {"client_renewals", own->renewals},
        {"client_silent_streams", own->silent_streams},
    };
    size_t theirs = s->counter_names.count, count = sizeof ours / sizeof ours[0];
    c->status_counters = reallocate(c->status_counters, theirs + count, sizeof *c->status_counters);
    for (size_t i = 0; i < theirs; i++)
        c->status_counters[i] = (collided_counter){s->counter_names.at[i], s->counter_values.at[i]};
    for (size_t i = 0; i < count; i++) c->status_counters[theirs + i] = ours[i];
    return theirs + count;
}

collided_status collided_get_status(collided *c, double timeout_s, collided_daemon_status *out)
{
    *out = (collided_daemon_status){0};
    if (session_from_callback(c)) return COLLIDED_BAD_ARGUMENT;
    bool heard = session_wait(c, session_monotonic_ns() + session_seconds(timeout_s), has_status);
    if (session_unheard(c)) return session_fail(c, COLLIDED_NO_DAEMON, "no daemon has been heard for 3 s");
    if (!heard) return session_fail(c, COLLIDED_TIMEOUT, "no status came within %g s", timeout_s);
    pthread_mutex_lock(&c->lock);
    free(c->status_shown);
    c->status_shown = message_copy(c->status);
    const wire_status *s = &c->status_shown->status;
    size_t count = fill_counters(c, s);
    *out = (collided_daemon_status){.epoch = s->epoch,
        .tick = s->tick,
        .stamp_ns = s->stamp_ns,
        .started_ns = s->started_ns,
        .health = health_name(s->health),
        .daemon = s->daemon,
        .release = s->release,
        .links = s->links,
        .limits = s->limits,
        .counter_count = count,
        .counters = c->status_counters};
    pthread_mutex_unlock(&c->lock);
    return COLLIDED_OK;
}
