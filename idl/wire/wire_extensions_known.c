/* wire_extensions_known: which records this release reads, and in which messages. Any thread. */
#include "wire_extensions.h"

/* There are none yet. The first one gets its kind and its id compared here, and a row in README.md. */
bool wire_extension_is_known(wire_kind kind, uint32_t id)
{
    (void)kind;
    (void)id;
    return false;
}
