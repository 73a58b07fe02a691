/* extremes_limits: bodies and poses as messages, held to wire_check, as the daemon holds whatever comes. */
#include "extremes_limits.h"

#include "wire/wire.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

typedef struct probe {
    const char *name;
    const char *limit; /* the words that the refusal must have */
    double value;
    bool beyond;
    enum { OF_SIZE, OF_RADIUS, OF_POSITION, OF_ROTATION } of;
} probe;

#define STEP (1 + DBL_EPSILON)
static const probe PROBES[] = {
    {"half extent, m", "at most", DBL_MIN, false, OF_SIZE},
    {"half extent, m", "0 to 1e+09 is allowed", WIRE_SIZE_MAX, false, OF_SIZE},
    {"half extent, m", "0 to 1e+09 is allowed", WIRE_SIZE_MAX *STEP, true, OF_SIZE},
    {"half extent, m", "0 to 1e+09 is allowed", -1, true, OF_SIZE},
    {"half extent, m", "must be solid", 0, true, OF_SIZE},
    {"half extent, m", "must be finite", INFINITY, true, OF_SIZE},
    {"half extent, m", "not a number", NAN, true, OF_SIZE},
    {"radius, m", "at most 1e+09 is allowed", WIRE_SIZE_MAX, false, OF_RADIUS},
    {"radius, m", "at most 1e+09 is allowed", WIRE_SIZE_MAX *STEP, true, OF_RADIUS},
    {"radius, m", "at most 1e+09 is allowed", 0, true, OF_RADIUS},
    {"position, m", "at most 1e+12 is allowed", WIRE_POSITION_MAX, false, OF_POSITION},
    {"position, m", "at most 1e+12 is allowed", WIRE_POSITION_MAX *STEP, true, OF_POSITION},
    {"position, m", "must be finite", INFINITY, true, OF_POSITION},
    {"position, m", "not a number", NAN, true, OF_POSITION},
    {"norm of an orientation", "0.5 to 2 is allowed", 0.5, false, OF_ROTATION},
    {"norm of an orientation", "0.5 to 2 is allowed", 0.499, true, OF_ROTATION},
    {"norm of an orientation", "0.5 to 2 is allowed", 2, false, OF_ROTATION},
    {"norm of an orientation", "0.5 to 2 is allowed", 2.001, true, OF_ROTATION},
};

static wire_reason check(const probe *p, wire_refusal *why)
{
    double sizes[3] = {1, 1, 1}, radius = 0, poses[7] = {0, 0, 0, 1, 0, 0, 0}, at[7] = {0, 0, 0, 1, 0, 0, 0};
    uint8_t type = p->of == OF_RADIUS ? WIRE_SHAPE_SPHERE : WIRE_SHAPE_BOX;
    int64_t geometry = 0;
    if (p->of == OF_SIZE) sizes[0] = p->value;
    if (p->of == OF_RADIUS) radius = p->value, sizes[0] = sizes[1] = sizes[2] = 0;
    if (p->of == OF_POSITION) at[1] = p->value;
    if (p->of == OF_ROTATION) at[3] = p->value;
    wire_message m = {.kind = WIRE_BODY};
    m.body = (wire_body){.version = WIRE_VERSION,
        .client = 1,
        .sequence = 1,
        .name = "probe",
        .group = "",
        .category = 1,
        .mask = -1,
        .pose = {7, at},
        .shape_types = {1, &type},
        .shape_sizes = {3, sizes},
        .shape_radii = {1, &radius},
        .shape_poses = {7, poses},
        .shape_geometries = {1, &geometry}};
    return wire_check(&m, why);
}

size_t extremes_limits(extremes_limit *out, size_t room)
{
    size_t count = 0;
    for (; count < sizeof PROBES / sizeof *PROBES && count < room; count++) {
        const probe *p = &PROBES[count];
        extremes_limit *l = &out[count];
        wire_refusal why;
        *l = (extremes_limit){.name = p->name, .value = p->value, .beyond = p->beyond};
        l->refused = check(p, &why) != WIRE_OK;
        l->named = l->refused && strstr(why.text, p->limit);
        snprintf(l->text, sizeof l->text, "%s", why.text);
    }
    return count;
}
