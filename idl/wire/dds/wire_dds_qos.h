/* wire_dds_qos: how each message travels over DDS: topic, quality of service, partition and configuration of the
 * domain, in one place, because the daemon and the client library must agree on it to the letter. Any thread. */
#ifndef COLLIDED_WIRE_DDS_QOS_H
#define COLLIDED_WIRE_DDS_QOS_H

#include "wire/wire.h"

#include <stdbool.h>
#include <stddef.h>

struct dds_qos; /* dds_qos_t */

/* All kinds are reliable, but for the library's readers of Status on loopback (transport_dds.c): a best-effort writer
 * would not match, and it has no need, since no writer here ever blocks (keep-last). What a full history overwrites is
 * seen by the receiver: batches of events and messages of a client are numbered, and the daemon counts each take that
 * found its history full. */
typedef struct wire_dds_profile {
    bool late_joiners;    /* transient-local and keyed: who comes late is told the present state; otherwise volatile */
    bool by_partition;    /* each stream is a partition of its own */
    int32_t writer_depth; /* samples kept, per instance where there is a key */
    int32_t reader_depth;
} wire_dds_profile;

typedef enum wire_dds_side { WIRE_DDS_WRITER, WIRE_DDS_READER } wire_dds_side;

const wire_dds_profile *wire_dds_profile_of(wire_kind kind); /* NULL for WIRE_NOTHING and unknown kinds */

enum { WIRE_DDS_TOPIC_MAX = 32 };
void wire_dds_topic(wire_kind kind, char name[WIRE_DDS_TOPIC_MAX]); /* "collided_Body" */

/* The quality of service of a topic's writer or reader, to be freed by dds_delete_qos. `stream` names the partition of
 * an EventBatch, otherwise NULL. `lease_ns` > 0: automatic liveliness with that lease, for the client's writer of
 * Client; readers ask for none, so that any lease matches.
 *
 * Writers do not dispose what they leave behind: an instance without writers (its client was lost) and a disposed one
 * (it was taken back, by dds_writedispose with removed = 1) are different news. */
struct dds_qos *wire_dds_qos(wire_kind kind, wire_dds_side side, const char *stream, int64_t lease_ns);

/* A stream's partition: its name, with the bytes that DDS takes as wildcards or separators written as %XX, so that no
 * stream can match another. */
enum { WIRE_DDS_PARTITION_MAX = 3 * WIRE_NAME_MAX + 16 };
void wire_dds_partition(const char *stream, char partition[WIRE_DDS_PARTITION_MAX]);

/* Ack, Reject and Answer are for one client each, and would go to all: with each client that comes, everybody would
 * hear more. So clients are spread over groups by their ids: a client of this library reads these topics in the
 * partition of its group, and says so in the user data of its writer of Client: the name of that partition. The daemon
 * answers it there and nowhere else, and all others in the partition without a name; those who do not speak for the
 * client that they name (for whom there is no place, or who have left), in both.
 * (A writer for each client would cost more: each writer of the daemon is announced to each client.) */
enum { WIRE_DDS_REPLIES = 16 };
void wire_dds_replies(unsigned group, char partition[WIRE_DDS_PARTITION_MAX]); /* "replies:7" */
unsigned wire_dds_replies_of(int64_t client);

/* A writer for each stream is announced to all clients, so that a crowd's announcements grow with its square. So beyond
 * the first streams, those that are not named by their client go out in partitions that are shared, and a client of
 * this library reads in one of them, by its id. All that it does is told in its user data: "replies:7 events:41". */
enum { WIRE_DDS_EVENTS = 64, WIRE_DDS_USER_DATA_MAX = 64 };
void wire_dds_events(unsigned group, char partition[WIRE_DDS_PARTITION_MAX]); /* "events:41" */
unsigned wire_dds_events_of(int64_t client);
/* In a room (below) there are few groups of either kind. */
enum { WIRE_DDS_ROOM_GROUPS = 4 };
void wire_dds_user_data(unsigned replies, unsigned events, char text[WIRE_DDS_USER_DATA_MAX]);
/* What it says: the groups, from 1; 0: none, of what is not said or not understood. */
void wire_dds_user_data_read(const void *data, size_t size, int *replies, int *events);

/* On loopback without multicast: who is to be found there has one of so many well-known ports of a domain. */
enum { WIRE_DDS_INDICES = 64 };

typedef enum wire_dds_role {
    WIRE_DDS_ANYBODY,        /* takes a well-known port, as tools and tests do */
    WIRE_DDS_DAEMON,         /* the same; is found by others at once; small samples wait for dds_write_flush */
    WIRE_DDS_CLIENT_LIBRARY, /* takes any port, finds daemons, and is found by nobody else */
    WIRE_DDS_CLIENT_OF_CROWD /* the same, among many on loopback: what is not acknowledged is said again later */
} wire_dds_role;

/* The configuration for dds_create_domain. `interface`: name or address of a network interface; NULL or "" = loopback
 * only, without multicast: unicast discovery on 127.0.0.1. What the user's CYCLONEDDS_URI says is appended, and wins.
 * False if it does not fit into `size`; 4096 bytes hold all but an outlandish CYCLONEDDS_URI.
 *
 * When the process has this domain already, dds_create_domain fails with DDS_RETCODE_PRECONDITION_NOT_MET: its
 * configuration then stands, and the participant can be created all the same. */
bool wire_dds_config(char *out, size_t size, const char *interface, wire_dds_role role);

/* Rooms: to Cyclone whoever comes costs all who are there (heartbeats of discovery, retransmissions to all, whom each
 * writer reaches, computed anew), so a crowd would cost its square. On loopback, where turns are given
 * (wire_dds_turn.h), the clients of the library that come after the first few are spread over rooms: each is a
 * participant of the daemon for so many clients, at a port of its own beyond the well-known ones, and in a domain of
 * its own to Cyclone (a domain tag: neither hears of the other's). What is said in a room is what is said outside of
 * it, but that streams go out by the shared partitions alone. */
enum { WIRE_DDS_ROOMS = 48, WIRE_DDS_ROOM_CLIENTS = 32 };
/* As Cyclone numbers the domain in this process: no other participant of the process is in it by chance. */
uint32_t wire_dds_room_domain(uint32_t domain, unsigned room);
/* As wire_dds_config, of a room from 1 to WIRE_DDS_ROOMS. Nothing of the user's is appended: who has set CYCLONEDDS_URI
 * has no rooms (wire_dds_has_rooms). */
bool wire_dds_config_room(char *out, size_t size, uint32_t domain, unsigned room, wire_dds_role role);
bool wire_dds_has_rooms(void);

#endif
