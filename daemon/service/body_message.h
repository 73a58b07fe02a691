/* body_message: a body of the world as the message that announces it. Tick thread. */
#ifndef COLLIDED_SERVICE_BODY_MESSAGE_H
#define COLLIDED_SERVICE_BODY_MESSAGE_H

#include "service.h"

typedef struct body_columns { /* of the shapes and rules of one body */
    uint8_t types[WIRE_SHAPES_MAX], actions[WIRE_RULES_MAX];
    double sizes[3 * WIRE_SHAPES_MAX], radii[WIRE_SHAPES_MAX], deviations[WIRE_SHAPES_MAX], poses[7 * WIRE_SHAPES_MAX],
        pose[7];
    double paddings[WIRE_RULES_MAX], margins[WIRE_RULES_MAX];
    int64_t geometries[WIRE_SHAPES_MAX];
    const char *patterns[WIRE_RULES_MAX], *reasons[WIRE_RULES_MAX];
    world_shape shapes[WIRE_SHAPES_MAX];
} body_columns;

/* `def` is what world_get_body said of `b`, a body of that client, with its shapes in scratch->shapes. The message
 * borrows from these and from the world, until either changes. */
wire_message body_message_of(
    const service *s, int64_t client, const owned_body *b, const world_body *def, body_columns *scratch);

#endif
