/* foxglove_put: the pieces of JSON that Foxglove's messages have in common. */
#ifndef COLLIDED_WINDOW_FOXGLOVE_PUT_H
#define COLLIDED_WINDOW_FOXGLOVE_PUT_H

#include "collided.h"
#include "json_buffer.h"

#include <inttypes.h>
#include <math.h>

typedef struct foxglove_color {
    double r, g, b, a;
} foxglove_color;

static inline void foxglove_put_stamp(json_buffer *j, const char *name, int64_t ns)
{
    uint64_t t = ns < 0 ? 0 : (uint64_t)ns;
    json_buffer_print(j, "\"%s\":{\"sec\":%" PRIu64 ",\"nsec\":%" PRIu64 "}", name, t / 1000000000u, t % 1000000000u);
}

/* What is not finite has no place in JSON: 0. */
static inline void foxglove_put_vector(json_buffer *j, const char *name, const double v[3])
{
    double f[3];
    for (int i = 0; i < 3; i++) f[i] = isfinite(v[i]) ? v[i] : 0;
    json_buffer_print(j, "\"%s\":{\"x\":%.17g,\"y\":%.17g,\"z\":%.17g}", name, f[0], f[1], f[2]);
}

/* Ours are w x y z. */
static inline void foxglove_put_rotation(json_buffer *j, const char *name, const double q[4])
{
    json_buffer_print(j, "\"%s\":{\"x\":%.17g,\"y\":%.17g,\"z\":%.17g,\"w\":%.17g}", name, q[1], q[2], q[3], q[0]);
}

static inline void foxglove_put_pose(json_buffer *j, const collided_pose *p)
{
    json_buffer_raw(j, "\"pose\":{");
    foxglove_put_vector(j, "position", p->position);
    json_buffer_raw(j, ",");
    foxglove_put_rotation(j, "orientation", p->orientation);
    json_buffer_raw(j, "}");
}

static inline void foxglove_put_color(json_buffer *j, const char *name, foxglove_color c)
{
    json_buffer_print(j, "\"%s\":{\"r\":%g,\"g\":%g,\"b\":%g,\"a\":%g}", name, c.r, c.g, c.b, c.a);
}

#endif
