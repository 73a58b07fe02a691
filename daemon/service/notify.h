/* notify: what a service manager is told (sd_notify(3)): ready, one line of state, alive, ending. Tick thread only, so
 * that a tick that hangs is noticed. Without a service manager (no NOTIFY_SOCKET), nothing happens. */
#ifndef COLLIDED_SERVICE_NOTIFY_H
#define COLLIDED_SERVICE_NOTIFY_H

#include <stdint.h>

typedef struct notify {
    int64_t period_ns; /* between signs of life: half of what the watchdog waits for; 0: no watchdog */
    int64_t next_ns;   /* when the next one is due, monotonic; INT64_MAX: never */
} notify;

notify notify_start(void); /* reads what the service manager asked for; nothing is reported yet */
void notify_ready(const char *state);
void notify_state(const char *state);
void notify_alive(notify *n, int64_t now_ns); /* once a round; tells it when it is due */
void notify_stopping(void);

#endif
