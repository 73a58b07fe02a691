#include "link_dds_reminder.h"

#include "base/clock.h"
#include "base/log.h"

#include <time.h>

#define MS_NS INT64_C(1000000)
enum { FIRST_MS = 20, SECOND_MS = 150, NS_PER_S = 1000000000 };

static void wait_until(reminder *r, int64_t ns)
{
    const struct timespec when = {.tv_sec = (time_t)(ns / NS_PER_S), .tv_nsec = (long)(ns % NS_PER_S)};
    if (ns == INT64_MAX)
        pthread_cond_wait(&r->wake, &r->lock);
    else
        pthread_cond_timedwait(&r->wake, &r->lock, &when);
}

/* Without the lock. Cyclone's only way to send a heartbeat now is dds_assert_liveliness, which, when its writer is
 * being deleted meanwhile, leaves it pinned, and then its deletion never ends: so reminder_forget waits for us. */
static void remind(reminder *r, dds_entity_t writer)
{
    r->reminds = writer;
    pthread_mutex_unlock(&r->lock);
    (void)dds_assert_liveliness(writer);
    pthread_mutex_lock(&r->lock);
    r->reminds = 0;
    pthread_cond_broadcast(&r->reminded);
}

/* One that is due, or when the next one is. */
static dds_entity_t take_due(reminder *r, int64_t now, int64_t *next_ns)
{
    *next_ns = INT64_MAX;
    for (unsigned i = 0; i < r->count; i++) {
        reminder_entry *e = &r->at[i];
        if (e->at_ns > now) {
            if (e->at_ns < *next_ns) *next_ns = e->at_ns;
            continue;
        }
        dds_entity_t writer = e->writer;
        if (e->again)
            *e = (reminder_entry){writer, now + SECOND_MS * MS_NS, false};
        else
            *e = r->at[--r->count];
        return writer;
    }
    return 0;
}

static void *reminder_run(void *context)
{
    reminder *r = context;
    pthread_mutex_lock(&r->lock);
    while (!r->ends) {
        int64_t next_ns;
        dds_entity_t writer = take_due(r, clock_monotonic_ns(), &next_ns);
        if (writer)
            remind(r, writer);
        else
            wait_until(r, next_ns);
    }
    pthread_mutex_unlock(&r->lock);
    return NULL;
}

void reminder_start(reminder *r)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&r->lock, NULL);
    pthread_cond_init(&r->wake, &monotonic);
    pthread_cond_init(&r->reminded, NULL);
    pthread_condattr_destroy(&monotonic);
    r->runs = pthread_create(&r->thread, NULL, reminder_run, r) == 0;
    if (!r->runs) log_warning("no thread that repeats heartbeats of DDS: a new stream may begin half a second late");
}

void reminder_put(reminder *r, dds_entity_t writer)
{
    if (!r->runs) return;
    pthread_mutex_lock(&r->lock);
    unsigned i = 0;
    while (i < r->count && r->at[i].writer != writer) i++;
    if (i == r->count && r->count < REMINDER_MOST) r->count++;
    if (i < REMINDER_MOST) r->at[i] = (reminder_entry){writer, clock_monotonic_ns() + FIRST_MS * MS_NS, true};
    pthread_cond_signal(&r->wake);
    pthread_mutex_unlock(&r->lock);
}

void reminder_forget(reminder *r, dds_entity_t writer)
{
    if (!r->runs) return;
    pthread_mutex_lock(&r->lock);
    for (unsigned i = 0; i < r->count; i++)
        if (r->at[i].writer == writer) r->at[i--] = r->at[--r->count];
    while (r->reminds == writer) pthread_cond_wait(&r->reminded, &r->lock);
    pthread_mutex_unlock(&r->lock);
}

void reminder_end(reminder *r)
{
    if (!r->runs) return;
    pthread_mutex_lock(&r->lock);
    r->ends = true;
    pthread_cond_signal(&r->wake);
    pthread_mutex_unlock(&r->lock);
    pthread_join(r->thread, NULL);
    pthread_cond_destroy(&r->wake);
    pthread_cond_destroy(&r->reminded);
    pthread_mutex_destroy(&r->lock);
    r->runs = false;
}
