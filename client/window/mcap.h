/* mcap: writes a file in the format MCAP (https://mcap.dev/spec), which Foxglove, PlotJuggler and their like open.
 * Messages stand in chunks of about 1 MiB, not compressed; each chunk has an index by channel and time; a summary at
 * the end has all schemas, channels, chunk indexes and counts. Chunks, the data section and the summary have a CRC
 * each. Until mcap_close has returned 0 the file lacks its end, which readers tell. One thread. */
#ifndef COLLIDED_WINDOW_MCAP_H
#define COLLIDED_WINDOW_MCAP_H

#include <stddef.h>
#include <stdint.h>

typedef struct mcap mcap;

mcap *mcap_create(const char *path, const char *library); /* NULL with errno; refuses a file that exists */

/* Its number, from 1. Of a channel: `schema` is 0 if the messages have none. Texts are copied. */
uint16_t mcap_add_schema(mcap *m, const char *name, const char *encoding, const char *data);
uint16_t mcap_add_channel(mcap *m, uint16_t schema, const char *topic, const char *encoding);

void mcap_message(mcap *m, uint16_t channel, int64_t log_ns, int64_t publish_ns, const void *data, size_t size);

/* A named record of `count` keys and values, key by value. */
void mcap_metadata(mcap *m, const char *name, const char *const *pairs, size_t count);

uint64_t mcap_message_count(const mcap *m);

/* Ends the file and frees `m`. 0, or -1 with errno if any of it could not be written; the file is then removed. */
int mcap_close(mcap *m);
void mcap_abandon(mcap *m); /* frees it, and removes the file */

#endif
