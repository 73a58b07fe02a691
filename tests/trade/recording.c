#include "recording.h"

#include "wire/one_shape.h"
#include "wire/wire_log.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

enum { CLIENT = 7, STANDING = 7, MOVING = 2, BODIES = STANDING + MOVING };

static const struct {
    uint8_t type;
    double size[3], radius;
} SHAPES[BODIES] = {{WIRE_SHAPE_SPHERE, {0, 0, 0}, 0.4}, {WIRE_SHAPE_BOX, {0.3, 0.4, 0.2}, 0},
    {WIRE_SHAPE_CYLINDER, {0.3, 0.3, 0.4}, 0}, {WIRE_SHAPE_CONE, {0.4, 0.4, 0.3}, 0},
    {WIRE_SHAPE_ELLIPSOID, {0.5, 0.3, 0.2}, 0}, {WIRE_SHAPE_CAPSULE, {0, 0, 0.3}, 0.2},
    {WIRE_SHAPE_HALFSPACE, {0, 0, 0}, 0}, {WIRE_SHAPE_CYLINDER, {0.2, 0.2, 0.3}, 0},
    {WIRE_SHAPE_CAPSULE, {0, 0, 0.4}, 0.1}};

static void put(wire_log_writer *w, wire_message m)
{
    if (wire_log_message(w, 0, &m) != 0) fail_msg("the recording cannot be written");
}

static void put_body(wire_log_writer *w, int64_t *sequence, int32_t i)
{
    char name[16];
    const bool ground = SHAPES[i].type == WIRE_SHAPE_HALFSPACE;
    one_shape s = one_shape_at(SHAPES[i].type, i < STANDING ? 1.5 * i : -3);
    s.pose[2] = ground ? -0.4 : i < STANDING ? 0 : 5;
    memcpy(s.size, SHAPES[i].size, sizeof s.size);
    s.radius[0] = SHAPES[i].radius;
    snprintf(name, sizeof name, "body%d", i);
    wire_message m = one_shape_body(&s, CLIENT, ++*sequence, i, name);
    m.body.motion = i < STANDING ? WIRE_MOTION_FIXED : WIRE_MOTION_MOVING;
    put(w, m);
}

static void put_poses(wire_log_writer *w, int64_t *sequence, int tick, const recording *r)
{
    const int32_t bodies[MOVING] = {STANDING, STANDING + 1};
    double positions[3 * MOVING], orientations[4 * MOVING];
    for (int i = 0; i < MOVING; i++) {
        double along = 10.0 * tick / r->ticks, angle = 0.5 * (0.3 + 0.11 * tick + i);
        positions[3 * i] = -1 + along;
        positions[3 * i + 1] = i ? -0.45 : 0.5;
        positions[3 * i + 2] = r->height + 0.2 * sin(1.7 * along + i);
        orientations[4 * i] = cos(angle);
        orientations[4 * i + 1] = 0.6 * sin(angle);
        orientations[4 * i + 2] = 0;
        orientations[4 * i + 3] = 0.8 * sin(angle);
    }
    put(w, (wire_message){.kind = WIRE_POSE_BATCH,
               .pose_batch = {.version = WIRE_VERSION,
                   .client = CLIENT,
                   .sequence = ++*sequence,
                   .bodies = {MOVING, bodies},
                   .positions = {3 * MOVING, positions},
                   .orientations = {4 * MOVING, orientations}}});
}

void record_session(const char *path, const recording *r)
{
    char why[256] = "";
    int64_t sequence = 0;
    wire_log_writer *w = wire_log_create(path, why, sizeof why);
    if (!w) fail_msg("%s", why);
    put(w, (wire_message){.kind = WIRE_CLIENT,
               .client = {.version = WIRE_VERSION,
                   .client = CLIENT,
                   .sequence = ++sequence,
                   .lease_ns = 60000000000,
                   .name = "recorded"}});
    for (int32_t i = 0; i < BODIES; i++) put_body(w, &sequence, i);
    if (r->subscription)
        put(w, (wire_message){.kind = WIRE_SUBSCRIPTION,
                   .subscription = {.version = WIRE_VERSION,
                       .client = CLIENT,
                       .sequence = ++sequence,
                       .subscription = 1,
                       .facts = WIRE_FACT_TOUCH | (r->range > 0 ? WIRE_FACT_DISTANCE : 0),
                       .stream = "",
                       .select_a = "*",
                       .select_b = "*",
                       .range_m = r->range,
                       .tolerance_m = 1e-6}});
    for (int tick = 0; tick < r->ticks; tick++) {
        bool again = r->again < 0 || (tick % 10 == 9 && tick / 10 < r->again);
        if (again) put_body(w, &sequence, 0);
        put_poses(w, &sequence, tick, r);
        const wire_log_tick end = {
            .tick = tick + 1, .now_ns = 1000000000 + 10000000ll * tick, .monotonic_ns = 1 + 10000000ll * tick};
        if (wire_log_tick_end(w, end.now_ns / 1000, &end) != 0) fail_msg("the recording cannot be written");
    }
    if (wire_log_close(w) != 0) fail_msg("the recording cannot be written");
}
