/* exporter: HTTP on loopback for Prometheus and for probes, in a thread of its own.
 *
 *   /metrics   the page of figures, in Prometheus' text format 0.0.4
 *   /ready     200 "ready" once the world is whole, else 503 with the reason
 *   /          where these are
 *
 * The tick thread leaves a page now and then (exporter_show); a request is answered from the newest one, so that no
 * request waits for a tick and no tick for a request. Connections, their time and their requests are bounded. */
#ifndef COLLIDED_SERVICE_EXPORTER_H
#define COLLIDED_SERVICE_EXPORTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct exporter exporter;

/* Listens on 127.0.0.1. NULL with one line in `why` that says what to do. */
exporter *exporter_start(uint16_t port, char *why, size_t why_size);
/* Copies both. `unready`: why it is not, or NULL. Any thread. */
void exporter_show(exporter *e, const char *page, size_t size, const char *unready);
void exporter_stop(exporter *e); /* NULL is fine */

#endif
