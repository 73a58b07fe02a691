/* raw_dds: a client of Cyclone's own calls beside the client library, which refuses what these tests want to send. In a
 * process that has connected to RIG_DDS before: the domain is then set up. One thread. */
#ifndef COLLIDED_TESTS_FAULTS_RAW_DDS_H
#define COLLIDED_TESTS_FAULTS_RAW_DDS_H

#include "wire/wire.h"

#include <stdbool.h>

typedef struct raw_dds {
    int participant, reader; /* of Reject */
    int writers[WIRE_KIND_COUNT];
    int64_t sequence;
} raw_dds;

enum { RAW_CLIENT = 7 };

void raw_open(raw_dds *r); /* all has matched */
void raw_close(raw_dds *r);
int64_t raw_send(raw_dds *r, wire_message *m);                    /* under a new sequence, which it returns */
int64_t raw_send_as(raw_dds *r, int64_t client, wire_message *m); /* the same, under another name than RAW_CLIENT */
/* Waits for the Reject of that message; fails the test if none comes within 3 s. */
wire_reason raw_rejected(raw_dds *r, int64_t sequence);

#endif
