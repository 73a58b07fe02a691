/* dds_client: a raw Cyclone client of collided, in a process of its own, to test the DDS link against. It does one of
 * the roles below, and writes a line a step to standard output. */
#ifndef COLLIDED_TESTS_LINK_DDS_CLIENT_H
#define COLLIDED_TESTS_LINK_DDS_CLIENT_H

enum {
    CLIENT_DOMAIN = 0,
    FLOOD_BATCHES = 300,
    ASIDE_SEQUENCE = 1000000,
    LARGE_POSES = 50001,
    LARGE_STEP = 2,
    MANY_BODIES = 500
};

/* "talk"    writes each kind of a client once ("sent"), then says of each kind that comes "KIND same" or "KIND
 * different" "live"    writes Client with its lease, and Body; "sent"; lives until killed "remove"  the same, then
 * takes the body back, in order "listen STREAM"  reads that stream: "matched", then "STREAM batch N" for each "flood"
 * writes FLOOD_BATCHES batches of 1,000 poses; "sent" "aside"   writes one of three, as another client; "sent" "large"
 * writes one of LARGE_POSES, which is no step, and one that is "many"
 * writes its Client, and MANY_BODIES bodies; "sent" "bad" writes a PoseBatch with an infinite position */
int dds_client(int argc, char **argv);

#endif
