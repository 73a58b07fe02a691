/* raw_rtps: packets of RTPS that are forged in the name of somebody else's writer. In a process that has connected to
 * RIG_DDS before. One thread. */
#ifndef COLLIDED_TESTS_FAULTS_RAW_RTPS_H
#define COLLIDED_TESTS_FAULTS_RAW_RTPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { RAW_GUIDS_MAX = 1024 };

typedef struct raw_guid {
    uint8_t bytes[16]; /* as it travels: name of the participant, and of the entity */
} raw_guid;

/* The writers of a topic that discovery has told of until now, of all participants or of all but this process's own.
 * Waits for the first one. */
size_t raw_writers(const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX]);
size_t raw_readers(const char *topic, bool own, raw_guid out[RAW_GUIDS_MAX]);

/* "All before number 2^30 is no longer to be had"; "... is of no subscription": to the reader, which for a heartbeat
 * may be NULL: all of that writer's. */
void raw_forge_heartbeat(const raw_guid *writer, const raw_guid *reader);
void raw_forge_gap(const raw_guid *writer, const raw_guid *reader);

#endif
