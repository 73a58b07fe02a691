/* frame_names: the names that a hello has, by the numbers of PROTOCOL.md. */
#include "frames.h"

static void put_names(json_buffer *j, const char *name, const char *const *names, size_t count)
{
    json_buffer_name(j, name);
    json_buffer_raw(j, "[");
    for (size_t i = 0; i < count; i++) {
        if (i) json_buffer_raw(j, ",");
        if (names[i])
            json_buffer_text(j, names[i]);
        else
            json_buffer_raw(j, "null");
    }
    json_buffer_raw(j, "]");
}

#define NAMES(name, ...)                                                                                               \
    do {                                                                                                               \
        static const char *const all[] = {__VA_ARGS__};                                                                \
        put_names(j, name, all, sizeof all / sizeof all[0]);                                                           \
    } while (0)

void frame_names(json_buffer *j)
{
    NAMES("event_kinds", NULL, "begin", "update", "end", "near", "far", "unknown", "known", "impact", "predicted",
        "averted");
    NAMES("causes", "motion", "removed", "owner_lost", "filter", "shape", "subscription", "shutdown", "stale",
        "snapshot", "teleport");
    NAMES("achieved", "certain", "within", "wide", "stopped");
    NAMES("shape_types", "sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space", "hull", "mesh",
        "height field", "compound");
}
