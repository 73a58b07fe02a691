/* connect: the URI's scheme chooses the transport. The caller's thread; the last failure is kept a thread. */
#include "session.h"
#include "session_run.h"

#include <stdio.h>
#include <string.h>

static const transport_ops *const transports[] = {&transport_dds_ops, &transport_lcm_ops, &transport_pipe_ops};
enum { TRANSPORTS = sizeof transports / sizeof transports[0] };

static _Thread_local char connect_error[SESSION_ERROR_MAX];

const char *collided_connect_error(void)
{
    return connect_error;
}

static const transport_ops *transport_of(const char *uri, const char **address)
{
    for (size_t i = 0; i < TRANSPORTS; i++) {
        size_t length = strlen(transports[i]->scheme);
        if (strncmp(uri, transports[i]->scheme, length) != 0 || strncmp(uri + length, "://", 3) != 0) continue;
        *address = uri + length + 3;
        return transports[i];
    }
    return NULL;
}

static void report_schemes(const char *uri)
{
    size_t at = (size_t)snprintf(connect_error, sizeof connect_error, "'%.200s' begins with none of", uri);
    for (size_t i = 0; i < TRANSPORTS; i++)
        at += (size_t)snprintf(connect_error + at, sizeof connect_error - at, " %s://", transports[i]->scheme);
}

static bool is_def(const collided_def *def)
{
    const double longest_s = 86400.0, longest_lease_s = 3600.0;
    bool lease = def->lease_s >= 0.01 && def->lease_s <= longest_lease_s;
    bool timeout = def->connect_timeout_s >= 0.0 && def->connect_timeout_s <= longest_s;
    bool loss = (unsigned)def->on_loss <= COLLIDED_KEEP;
    bool lock_step = def->lock_step >= 0 && def->lock_step <= WIRE_LOCK_STEP_MAX;
    if (lease && timeout && loss && lock_step) return true;
    (void)snprintf(connect_error, sizeof connect_error, "%s",
        !lease     ? "lease_s is not from 0.01 to 3600"
        : !timeout ? "connect_timeout_s is not from 0 to 86400"
        : !loss    ? "on_loss is not a collided_on_loss"
                   : "lock_step is not from 0 to 65536");
    return false;
}

collided *collided_connect(const char *uri, const collided_def *def)
{
    const collided_def defaults = collided_def_default();
    const char *address = NULL;
    connect_error[0] = '\0';
    if (!def) def = &defaults;
    if (!uri) uri = "";
    const transport_ops *ops = transport_of(uri, &address);
    if (!ops) report_schemes(uri);
    if (!ops || !is_def(def)) return NULL;
    char why[SESSION_ERROR_MAX] = "";
    collided *c = session_open(ops, address, def, why, sizeof why);
    if (!c) (void)snprintf(connect_error, sizeof connect_error, "%.150s: %.480s", uri, why);
    return c;
}

const char *collided_error(const collided *c)
{
    return c->error;
}
int64_t collided_client_id(const collided *c)
{
    return c->id;
}

void collided_on_rejected(collided *c, collided_rejected *callback, void *context)
{
    c->on_rejected = callback;
    c->on_rejected_context = context;
}

void collided_flush(collided *c)
{
    pthread_mutex_lock(&c->lock);
    c->link->ops->flush(c->link);
    pthread_mutex_unlock(&c->lock);
}

static bool has_delivered(const collided *c)
{
    return c->delivered > 0;
}

collided_status collided_poll(collided *c, double timeout_s)
{
    if (session_from_callback(c)) return COLLIDED_BAD_ARGUMENT;
    collided_flush(c);
    c->delivered = 0;
    int64_t deadline_ns = session_monotonic_ns() + session_seconds(timeout_s);
    session_sleep(
        c, deadline_ns); /* first: mostly there is nothing yet, and whoever publishes next needs a processor */
    (void)session_wait(c, deadline_ns, has_delivered);
    if (!session_unheard(c)) return COLLIDED_OK;
    return session_fail(c, COLLIDED_NO_DAEMON, "no daemon has been heard for 3 s");
}

/* Its first batch has come: the daemon knows that we listen, and whatever it tells from here on comes, or is told to be
 * lost. What is published before may be reported to nobody. */
static bool has_begun(const collided *c, const subscription_record *i)
{
    if (i->removed || i->announced.state == ANNOUNCE_REFUSED) return true;
    return i->reported_epoch && wire_same_line(i->reported_epoch, c->epoch);
}

static const char *silent_stream(const collided *c)
{
    for (const subscription_record *i = c->subscriptions; i; i = i->next)
        if (!has_begun(c, i)) return i->stream;
    return NULL;
}

static bool is_settled(const collided *c)
{
    return c->pending == 0 && !silent_stream(c);
}

collided_status collided_sync(collided *c, double timeout_s)
{
    if (session_from_callback(c)) return COLLIDED_BAD_ARGUMENT;
    collided_flush(c);
    bool settled = session_wait(c, session_monotonic_ns() + session_seconds(timeout_s), is_settled);
    if (!settled && session_unheard(c)) return session_fail(c, COLLIDED_NO_DAEMON, "no daemon has been heard for 3 s");
    pthread_mutex_lock(&c->lock);
    bool refused = c->refused;
    size_t pending = c->pending;
    const char *silent = silent_stream(c);
    if (refused) (void)session_fail(c, COLLIDED_REJECTED, "%s", c->first_refusal);
    c->refused = false;
    pthread_mutex_unlock(&c->lock);
    if (refused) return COLLIDED_REJECTED;
    if (settled) return COLLIDED_OK;
    if (!pending && silent)
        return session_fail(c, COLLIDED_TIMEOUT, "the stream '%s' has not begun after %g s", silent, timeout_s);
    return session_fail(c, COLLIDED_TIMEOUT, "%zu announcements are not acknowledged after %g s", pending, timeout_s);
}
