/* vertex_state: frames of soft bodies of which not all parts have come, and those that wait for a step. */
#ifndef COLLIDED_SERVICE_VERTEX_STATE_H
#define COLLIDED_SERVICE_VERTEX_STATE_H

#include "base/array.h"
#include "wire/wire_soft.h"
#include "world/world.h"

typedef struct frame_piece { /* vertices that follow each other */
    uint32_t first, count;
    size_t at; /* in frame_parts.vertices */
} frame_piece;

typedef struct frame_parts {
    int64_t client, sequence; /* of the newest of them */
    int64_t frame, stamp_ns, step;
    int32_t body, parts, come, mode;
    ARRAY(uint8_t) has; /* by part */
    ARRAY(frame_piece) pieces;
    ARRAY(vec3) vertices;
} frame_parts;

typedef struct vertex_state {
    ARRAY(frame_parts) coming; /* at most one of a body */
    ARRAY(frame_parts) held;   /* whole ones of clients in lock-step, until their step is done */
    wire_soft_writer writer;
} vertex_state;

#endif
