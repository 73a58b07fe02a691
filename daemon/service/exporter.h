/* exporter: HTTP/1.1 for Prometheus and for probes, in a thread of its own.
 *
 *   /metrics   the page of figures, in Prometheus' text format 0.0.4
 *   /ready     200 "ready" once the world is whole, else 503 with the reason
 *   /          where these are
 *
 * The tick thread leaves a page now and then (exporter_show); a request is answered from the newest one, so that no
 * request waits for a tick and no tick for a request. GET and HEAD are answered, and nothing else; whom a request may
 * name as its Host and its Origin: http.h. Each state of a connection has an end in time, a request has 8 KiB, and
 * there are at most 128 connections, 64 of one address: one more takes the place of the one that has been longest at
 * its request or its answer, so that somebody who asks at once is answered whoever else is there. */
#ifndef COLLIDED_SERVICE_EXPORTER_H
#define COLLIDED_SERVICE_EXPORTER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct exporter exporter;

/* Listens on that address, a number; `hosts`: names more that requests may have as their Host. NULL with one line in
 * `why` that says what to do. */
exporter *exporter_start(uint16_t port, const char *address, const char *hosts, char *why, size_t why_size);
/* Copies both. `unready`: why it is not, or NULL. Any thread. */
void exporter_show(exporter *e, const char *page, size_t size, const char *unready);
void exporter_stop(exporter *e); /* NULL is fine */

#endif
