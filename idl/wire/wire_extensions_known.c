/* wire_extensions_known: which records this release reads, and in which messages. Any thread. */
#include "wire_extensions.h"

/* Each has a row in README.md. */
bool wire_extension_is_known(wire_kind kind, uint32_t id)
{
    if (kind == WIRE_QUERY) return id == WIRE_EXTENSION_CHECK;
    if (kind == WIRE_ANSWER) return id == WIRE_EXTENSION_GEOMETRY || id == WIRE_EXTENSION_CHECKED;
    return kind == WIRE_EVENT_BATCH && id >= WIRE_EXTENSION_POSES && id <= WIRE_EXTENSION_BODY_POSES;
}
