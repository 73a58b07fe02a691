/* frames: what a page is sent, as octets of the protocol collided.web.v1 (PROTOCOL.md). Each function begins a frame
 * anew in `out`; frame_number gives it its number when it is sent. One thread. */
#ifndef COLLIDED_WINDOW_FRAMES_H
#define COLLIDED_WINDOW_FRAMES_H

#include "json_buffer.h"
#include "mirror.h"

enum {
    FRAME_HELLO = 1,
    FRAME_SCENE,
    FRAME_GEOMETRY,
    FRAME_POSES,
    FRAME_CONTACTS,
    FRAME_EVENTS,
    FRAME_STATUS,
    FRAME_ANSWER,
    FRAME_HEADER = 32,
    FRAME_ROOM = 32, /* octets before a frame, which libwebsockets wants */
    FRAME_CONTACTS_MAX = 10000
};

typedef struct frame {      /* zeros = empty; frame_free */
    unsigned char *at;      /* room for libwebsockets' head, then the frame */
    size_t count, capacity; /* of the frame */
} frame;

unsigned char *frame_octets(const frame *f);
void frame_free(frame *f);
void frame_number(frame *f, uint64_t number, uint32_t skipped); /* skipped: of poses and contacts */

void frame_text(frame *f, uint8_t kind, const mirror *m, const char *json); /* hello, status, answer */
/* What has changed since `since`; all, if that is 0 or too long ago. */
void frame_scene(frame *f, const mirror *m, uint64_t since, uint32_t revision);
void frame_poses(frame *f, const mirror *m, uint64_t since, bool all, const double origin[3], uint32_t revision);
void frame_contacts(frame *f, const mirror *m, uint64_t since, double range_m);
/* From the event of that number (from 1) on, at most `most`; returns the number of the next one. */
uint64_t frame_events(frame *f, const mirror *m, uint64_t from, uint64_t since, size_t most);
void frame_geometry(frame *f, const mirror *m, uint32_t number, uint32_t question, const collided_geometry_numbers *g);

/* Members of a hello: names by number. */
void frame_names(json_buffer *j);

#endif
