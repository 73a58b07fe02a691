/* session: what both threads of a client need: the clocks, its error, how it sends and wakes, the refusals that it
 * keeps. */
#include "session.h"

#include "message.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

static int64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * NS_PER_S + t.tv_nsec;
}

int64_t session_monotonic_ns(void)
{
    return clock_ns(CLOCK_MONOTONIC);
}
int64_t session_now_ns(void)
{
    return clock_ns(CLOCK_REALTIME);
}

int64_t session_seconds(double seconds)
{
    const double year_s = 365.0 * 86400.0;
    if (!(seconds > 0.0)) return 0;
    return (int64_t)((seconds < year_s ? seconds : year_s) * (double)NS_PER_S);
}

collided_status session_fail(collided *c, collided_status status, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(c->error, sizeof c->error, format, arguments);
    va_end(arguments);
    return status;
}

collided_status session_from_callback(collided *c)
{
    if (!c->in_callback) return COLLIDED_OK;
    return session_fail(c, COLLIDED_BAD_ARGUMENT, "a function that waits was called from a callback");
}

static void wake_reader_of(int fd)
{
    uint64_t one = 1;
    ssize_t written = write(fd, &one, sizeof one);
    (void)written; /* it fails only when the counter is full: then the reader is awake anyway */
}

void session_wake_keeper(collided *c)
{
    wake_reader_of(c->keeper_wake);
}
void session_wake_caller(collided *c)
{
    wake_reader_of(c->caller_wake);
}

int session_send(collided *c, const wire_message *m)
{
    int sent = c->link->ops->send(c->link, m);
    if (m->kind == WIRE_POSE_BATCH && m->pose_batch.sequence > c->newest_poses)
        c->newest_poses = m->pose_batch.sequence;
    if (sent) c->counters.send_failures++;
    return sent;
}

bool session_unheard(collided *c)
{
    pthread_mutex_lock(&c->lock);
    bool silent = session_monotonic_ns() - c->last_seen_ns >= SESSION_SILENCE_NS;
    pthread_mutex_unlock(&c->lock);
    return silent;
}

/* What is refused of a step before the one that is waited for may come late. Poses that were refused when the step was
 * done are counted in the answer to it; those that were refused before, the daemon wants before it takes the end. */
static void keep_refusal_of_step(collided *c, const wire_reject *why)
{
    bool is_of_step = why->sequence > c->step_begin && why->sequence <= c->step_end;
    bool is_end = why->sequence == c->step_end;
    if (why->kind != WIRE_POSE_BATCH || !is_of_step || !(is_end || why->reason == WIRE_BAD_STEP)) return;
    c->step_refused = true;
    (void)snprintf(c->step_refusal, sizeof c->step_refusal, "%s", why->text);
}

/* That another client missed a step is reported as a refusal, but is none of ours. */
void session_keep_rejection(collided *c, const wire_reject *why)
{
    keep_refusal_of_step(c, why);
    if (!c->refused && why->reason != WIRE_STEP_MISSED) {
        c->refused = true;
        (void)snprintf(c->first_refusal, sizeof c->first_refusal, "%s %d: %s: %s", wire_kind_name((wire_kind)why->kind),
            why->object, wire_reason_name((wire_reason)why->reason), why->text);
    }
    if (c->rejection_count < SESSION_REJECTIONS_MAX) {
        wire_message m = {.kind = WIRE_REJECT, .reject = *why};
        c->rejections[c->rejection_count++] = message_copy(&m);
    } else {
        c->rejections_overflowed++;
        c->counters.rejections_dropped++;
    }
    session_wake_caller(c);
}
