/* one_shape: the message that announces a body of one shape. */
#ifndef COLLIDED_TESTS_WIRE_ONE_SHAPE_H
#define COLLIDED_TESTS_WIRE_ONE_SHAPE_H

#include "wire/wire.h"

/* What the message borrows. Metres; poses are a position, and w x y z. */
typedef struct one_shape {
    double pose[7], size[3], radius[1], in_body[7];
    uint8_t type[1];
    int64_t geometry[1];
} one_shape;

/* Its sizes, radius and geometry are 0, for the caller to set. */
static inline one_shape one_shape_at(uint8_t type, double x)
{
    return (one_shape){.pose = {x, 0, 0, 1}, .in_body = {0, 0, 0, 1}, .type = {type}};
}

/* Borrows the shape and the name. What else there is to say of the body the caller adds. */
static inline wire_message one_shape_body(
    const one_shape *s, int64_t client, int64_t sequence, int32_t body, const char *name)
{
    return (wire_message){.kind = WIRE_BODY,
        .body = {.version = WIRE_VERSION,
            .client = client,
            .sequence = sequence,
            .body = body,
            .name = name,
            .group = "",
            .category = 1,
            .mask = -1,
            .pose = {7, s->pose},
            .shape_types = {1, s->type},
            .shape_sizes = {3, s->size},
            .shape_radii = {1, s->radius},
            .shape_poses = {7, s->in_body},
            .shape_geometries = {1, s->geometry}}};
}

#endif
