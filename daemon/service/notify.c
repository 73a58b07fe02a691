/* notify: sd_notify of libsystemd. Tick thread. A datagram that the service manager does not take is told in the log.
 */
#include "notify.h"

#include "base/log.h"

#include <stdio.h>
#include <string.h>
#include <systemd/sd-daemon.h>

static void report_manager(const char *text)
{
    int result = sd_notify(0, text);
    if (result < 0) log_warning("the service manager was not told \"%.60s\": %s", text, strerror(-result));
}

notify notify_start(void)
{
    uint64_t watchdog_us = 0;
    int asked = sd_watchdog_enabled(0, &watchdog_us);
    if (asked < 0) log_warning("WATCHDOG_USEC cannot be read: %s; no sign of life is sent", strerror(-asked));
    if (asked <= 0) return (notify){0, INT64_MAX};
    return (notify){(int64_t)watchdog_us * 1000 / 2, 0};
}

void notify_ready(const char *state)
{
    char text[512];
    snprintf(text, sizeof text, "READY=1\nSTATUS=%s", state);
    report_manager(text);
}

void notify_state(const char *state)
{
    char text[512];
    snprintf(text, sizeof text, "STATUS=%s", state);
    report_manager(text);
}

/* Told early by a fifth, so that a round that takes a little does not make it late. */
void notify_alive(notify *n, int64_t now_ns)
{
    if (now_ns < n->next_ns) return;
    report_manager("WATCHDOG=1");
    n->next_ns = now_ns + n->period_ns - n->period_ns / 5;
}

void notify_stopping(void)
{
    report_manager("STOPPING=1\nSTATUS=ending in order");
}
