/* cell: a daemon in this process and clients of it over the memory link, for the tests of this folder. */
#ifndef COLLIDED_TESTS_SERVICE_CELL_H
#define COLLIDED_TESTS_SERVICE_CELL_H

#include "link/link_memory.h"
#include "service/config.h"
#include "wire/wire_log.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

typedef struct cell cell;

cell *cell_start(const config *c);                            /* links = memory://cell are set here */
config cell_config(void);                                     /* one worker, quick status, no heartbeats */
int cell_stop(cell *c);                                       /* in order; the exit status */
int cell_replay(const char *path, long workers, bool caches); /* of a recording; the exit status */
int cell_replay_as(const char *path, config c);               /* under another configuration */
/* What its loop measured; to be looked at after the answer of a tick that came later. */
const struct measures *cell_measures(const cell *c);
double cell_processor_s(const cell *c);    /* that its loop has had, whatever else the machine does */
void cell_end_recording(cell *c);          /* as its operator: soon */
struct builds *cell_builds(const cell *c); /* to hold them back */
/* Looks at each entry of a recording; fails the test if it is damaged. How many ticks are in it. */
int cell_read(const char *path, void (*look)(void *context, const wire_log_entry *e), void *context);
memory_end *cell_client(const cell *c);

/* Waits, at most 30 s, for a message of that kind; what comes before it is dropped. Fails the test if none comes. A
 * Status is one that has not come yet: the next but one was made after all that was sent before. */
wire_message cell_await(memory_end *e, wire_memory *memory, wire_kind kind);
bool cell_hears(memory_end *e, wire_memory *memory, wire_kind kind, int ms); /* is one heard within that time? */
bool cell_next(memory_end *e, wire_memory *memory, wire_kind kind, int ms, wire_message *out); /* and which */

/* Waits until all that this client has sent is applied, by a query. */
void cell_settle(memory_end *e, wire_memory *memory, int64_t client, int64_t sequence);

void cell_hello(memory_end *e, int64_t client, int64_t sequence, double lease_s, uint8_t on_loss);
void cell_sphere(memory_end *e, int64_t client, int64_t sequence, int32_t body, const char *name, double x);
/* Of one shape that names a geometry: WIRE_SHAPE_HULL, ... */
void cell_body_of(memory_end *e, int64_t client, int64_t sequence, int32_t body, const char *name, uint8_t type,
    int64_t hash, double x);
void cell_pose(memory_end *e, int64_t client, int64_t sequence, int32_t body, double x);
void cell_touches(memory_end *e, int64_t client, int64_t sequence, int32_t subscription);
int64_t cell_counter(const wire_status *s, const char *name); /* fails the test if there is none */

#endif
