/* wire_extensions_known: which records this release reads, and in which messages. Constant data; any thread. */
#include "wire_extensions.h"

/* There are none yet: a new one gets a row here, and one in README.md. */
static const struct {
    wire_kind kind;
    uint32_t id;
} KNOWN[] = {
    {WIRE_NOTHING, 0},
};

bool wire_extension_is_known(wire_kind kind, uint32_t id)
{
    for (size_t i = 0; i < sizeof KNOWN / sizeof *KNOWN; i++)
        if (KNOWN[i].kind == kind && KNOWN[i].id == id) return true;
    return false;
}
