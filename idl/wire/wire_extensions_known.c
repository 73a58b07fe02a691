/* wire_extensions_known: which records this release reads, and in which messages. Any thread. */
#include "wire_extensions.h"
#include "wire_model.h"
#include "wire_soft.h"

/* Each has a row in README.md. */
bool wire_extension_is_known(wire_kind kind, uint32_t id)
{
    if (kind == WIRE_BODY) return id == WIRE_EXTENSION_MODEL;
    if (kind == WIRE_POSE_BATCH) return id == WIRE_EXTENSION_JOINTS;
    if (kind == WIRE_QUERY) return id == WIRE_EXTENSION_CHECK;
    if (kind == WIRE_ANSWER) return id == WIRE_EXTENSION_GEOMETRY || id == WIRE_EXTENSION_CHECKED;
    if (kind == WIRE_VERTEX_BATCH) return id == WIRE_SOFT_FRAME || id == WIRE_SOFT_SINGLES;
    if (kind == WIRE_SUBSCRIPTION) return id == WIRE_SOFT_INTEREST;
    if (kind != WIRE_EVENT_BATCH) return false;
    return (id >= WIRE_EXTENSION_POSES && id <= WIRE_EXTENSION_BODY_POSES) || id == WIRE_SOFT_STEP;
}
