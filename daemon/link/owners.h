/* owners: which participant speaks for which client, where a transport can tell who wrote a message (DDS). The first
 * participant that names a client speaks for it as long as it is alive; what another one says under that name is to be
 * refused. Participants and writers are known by handles, never 0 and never used again. No transport is seen here. One
 * thread. */
#ifndef COLLIDED_LINK_OWNERS_H
#define COLLIDED_LINK_OWNERS_H

#include "base/array.h"
#include "base/pair_map.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct owners_writer {
    uint64_t handle, participant;
    bool announces; /* of Client: its liveliness is that of the client */
    bool alive;
} owners_writer;

typedef struct owners_participant {
    uint64_t handle;
    uint32_t writers, announcing; /* announcing: its writers of Client that are alive */
    bool has_announced;           /* it has, or had, such a writer: without a living one it is lost */
    size_t claims;
    int group; /* see owners_put_in_group; 0 = none */
} owners_participant;

typedef struct owners_claim {
    uint64_t client, participant;
    bool announced; /* by a Client message */
} owners_claim;

typedef struct owners {                           /* zeros = empty, but for owners_init */
    pair_map writer_of, participant_of, claim_of; /* to the places in the lists */
    ARRAY(owners_writer) writers;
    ARRAY(owners_participant) participants;
    ARRAY(owners_claim) claims;
    size_t most;  /* claims, ... */
    size_t each;  /* ... and of one participant; 0: all of them */
    bool changed; /* since owners_lost began to look through the claims: somebody may be gone */
    size_t left;  /* claims that it has not looked at yet: the first ones */
} owners;

typedef enum owners_verdict { OWNERS_YES, OWNERS_NOT_YOURS, OWNERS_FULL, OWNERS_SHARE } owners_verdict;

void owners_init(owners *o, size_t most);
void owners_free(owners *o);

void owners_come(owners *o, uint64_t writer, uint64_t participant, bool announces); /* a writer has been discovered */
void owners_go(owners *o, uint64_t writer);                                         /* it exists no more */
void owners_liveliness(owners *o, uint64_t writer, bool alive);                     /* its lease ran out; it is back */
bool owners_knows(const owners *o, uint64_t writer);
uint64_t owners_participant_of(const owners *o, uint64_t writer); /* 0: it is not known */
/* Where this writer's participant wants answers to its clients to go, a number above 0; and that of the client's. */
void owners_put_in_group(owners *o, uint64_t writer, int group);
int owners_group(const owners *o, int64_t client);                /* 0: none, or nobody speaks for the client */
uint64_t owners_participant_for(const owners *o, int64_t client); /* that speaks for it; 0: nobody */

/* May what this writer says under that client's name be taken? The first one claims the name, if there are not as many
 * claims as there may be (OWNERS_FULL), or of one participant (OWNERS_SHARE). A writer that is not known, since it is
 * gone already, may speak for whom nobody else speaks, and claims nothing. */
owners_verdict owners_admit(owners *o, uint64_t writer, int64_t client, bool announces);
void owners_release(owners *o, int64_t client); /* it has left in order */

/* The next client whose participant is gone, or has lost its liveliness, after having announced it; its claim is over.
 * False: no more. */
bool owners_lost(owners *o, int64_t *client);

#endif
