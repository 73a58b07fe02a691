/* wire_extensions_known: which records this release reads, and in which messages. Any thread. */
#include "wire_extensions.h"
#include "wire_soft.h"

bool wire_extension_is_known(wire_kind kind, uint32_t id)
{
    static const struct known {
        wire_kind kind;
        uint32_t id;
    } KNOWN[] = {
        /* as the table in README.md has them */
        {WIRE_VERTEX_BATCH, WIRE_SOFT_FRAME},
        {WIRE_VERTEX_BATCH, WIRE_SOFT_SINGLES},
        {WIRE_SUBSCRIPTION, WIRE_SOFT_INTEREST},
        {WIRE_EVENT_BATCH, WIRE_SOFT_STEP},
    };
    for (size_t i = 0; i < sizeof KNOWN / sizeof *KNOWN; i++)
        if (KNOWN[i].kind == kind && KNOWN[i].id == id) return true;
    return false;
}
