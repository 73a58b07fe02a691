/* extensions: see extensions.h. */
#include "extensions.h"

#include "base/array.h"
#include "base/log.h"
#include "wire/wire_extensions.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static uint32_t first_unknown(const wire_message *m)
{
    wire_u8s rest = wire_extensions_of(m);
    wire_extension e = {0};
    while (wire_extension_next(&rest, &e) && wire_extension_is_known(m->kind, e.id)) {
    }
    return e.id;
}

/* Of a batch that comes in parts each part has them: they count with the last one. */
static void report_unknown(service *s, const struct link *from, const wire_message *m, uint32_t unknown)
{
    int64_t client, sequence;
    int32_t object;
    if (from->in_parts) return;
    wire_origin(m, &client, &sequence, &object);
    metric_count(s->count.unknown_extensions, unknown);
    log_notice("%s %" PRId64 " of client %016" PRIx64 ": extension %" PRIu32
               " is not known to this release: passed over",
        wire_kind_name(m->kind), sequence, (uint64_t)client, first_unknown(m));
}

wire_message *extensions_leave_out(service *s, const struct link *from, const wire_message *m)
{
    uint32_t all = wire_extensions_of(m).count;
    if (!all) return NULL;
    wire_message *less = base_zalloc(1, sizeof *less + all);
    wire_u8s known;
    uint32_t unknown = wire_extensions_keep_known(m, (uint8_t *)(less + 1), &known);
    if (!unknown) {
        free(less);
        return NULL;
    }
    report_unknown(s, from, m, unknown);
    *less = *m;
    wire_extensions_set(less, known);
    return less;
}
