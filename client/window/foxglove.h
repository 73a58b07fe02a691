/* foxglove: the mirror's world as JSON messages of Foxglove's schemas (SceneUpdate, FrameTransforms, Log) and two of
 * our own, flat ones to plot. One set of channels for files (MCAP) and for Foxglove's WebSocket protocol.
 *
 * Frames: "world", and "body:NAME" for each body, whose shapes are an entity in its frame. What stands still is drawn
 * grey, what moves in a colour of its client's; of what is stale or unknown a text says so. Rounding of boxes is drawn;
 * that of cones, cylinders, hulls and meshes is not, and the entity's metadata has it. A half-space is drawn as a
 * square of 20 m. Numbers that are not finite are left out. One thread. */
#ifndef COLLIDED_WINDOW_FOXGLOVE_H
#define COLLIDED_WINDOW_FOXGLOVE_H

#include "json_buffer.h"
#include "mirror.h"
#include "triangles.h"

typedef enum foxglove_topic {
    FOXGLOVE_SCENE,
    FOXGLOVE_TRANSFORMS,
    FOXGLOVE_CONTACTS,
    FOXGLOVE_EVENTS,
    FOXGLOVE_DISTANCES,
    FOXGLOVE_LOG,
    FOXGLOVE_TOPICS
} foxglove_topic;

typedef struct foxglove_channel {
    const char *topic, *schema_name, *schema; /* a JSON schema of what is sent */
} foxglove_channel;

extern const foxglove_channel foxglove_channels[FOXGLOVE_TOPICS];

/* Each adds one message to `j`, with that stamp. */
void foxglove_scene(json_buffer *j, const mirror *m, const triangles_kept *k, int64_t stamp_ns); /* all of it */
/* Those that were put or moved after that change; 0: all. How many. */
size_t foxglove_transforms(json_buffer *j, const mirror *m, uint64_t since, int64_t stamp_ns);
void foxglove_contacts(json_buffer *j, const mirror *m, int64_t stamp_ns);  /* what holds: axes and witness points */
void foxglove_distances(json_buffer *j, const mirror *m, int64_t stamp_ns); /* counts, the nearest, the soonest */
void foxglove_event(json_buffer *j, const mirror *m, const mirror_event *e);
void foxglove_event_log(json_buffer *j, const mirror *m, const mirror_event *e); /* the same in words */

/* A number that changes with what foxglove_scene draws of bodies beside their shapes: flags. */
uint64_t foxglove_looks(const mirror *m);

#endif
