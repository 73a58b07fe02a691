/* collided_later: the daemon as a later release may be, for who was built before. Linked with --wrap, so that all it
 * does otherwise is the daemon's own: each message that it sends has an extension, each batch of events one of a kind,
 * for a cause and with an `achieved` that nobody knows, each Status another counter; there is a message of a new kind;
 * and it reads two extensions of its own. */
#include "later.h"

#include "idl/later.h"
#include "wire/wire_extensions.h"
#include "wire/wire_lcm.h"
#include "wire_dds/wire_dds.h"

#include <dds/dds.h>
#include <stdlib.h>
#include <string.h>

/* What --wrap makes of the calls of these names, and of these functions. */
bool __wrap_wire_extension_is_known(wire_kind kind, uint32_t id);
void __wrap_wire_dds_encode(const wire_message *m, void *sample);
void __real_wire_dds_encode(const wire_message *m, void *sample);
size_t __wrap_wire_lcm_size(const wire_message *m);
size_t __real_wire_lcm_size(const wire_message *m);
size_t __wrap_wire_lcm_encode(const wire_message *m, void *out, size_t capacity);
size_t __real_wire_lcm_encode(const wire_message *m, void *out, size_t capacity);

bool __wrap_wire_extension_is_known(wire_kind kind, uint32_t id)
{
    return (kind == WIRE_BODY && id == (LATER_REQUIRED | WIRE_EXTENSION_REQUIRED)) ||
           (kind == WIRE_POSE_BATCH && id == LATER_POSE);
}

/* ---- what is said more ---- */

static const uint8_t extension[] = {LATER_OUT, 0, 0, 0, 5, 0, 0, 0, 'l', 'a', 't', 'e', 'r'};

/* An array with a copy of its last entries, `each` numbers of `bytes`, behind it. Kept until the next message. */
static void *longer(const void *at, uint32_t *count, uint32_t each, size_t bytes)
{
    enum { COLUMNS = 17 };
    static _Thread_local void *columns[COLUMNS];
    static _Thread_local unsigned next;
    void **column = &columns[next++ % COLUMNS];
    free(*column);
    *column = malloc((*count + each) * bytes);
    if (!*column) abort();
    memcpy(*column, at, *count * bytes);
    memcpy((char *)*column + *count * bytes, (const char *)at + (*count - each) * bytes, each * bytes);
    *count += each;
    return *column;
}

#define LONGER(array, each) (array).at = longer((array).at, &(array).count, each, sizeof *(array).at)

static uint8_t *last(wire_u8s *s)
{
    return (uint8_t *)(uintptr_t)s->at + s->count - 1;
}

static void add_event(wire_event_batch *m)
{
    LONGER(m->kinds, 1);
    LONGER(m->causes, 1);
    LONGER(m->contacts, 1);
    LONGER(m->names_a, 1);
    LONGER(m->names_b, 1);
    LONGER(m->shapes_a, 1);
    LONGER(m->shapes_b, 1);
    LONGER(m->lo, 1);
    LONGER(m->hi, 1);
    LONGER(m->axes, 3);
    LONGER(m->points_a, 3);
    LONGER(m->points_b, 3);
    LONGER(m->ages_a_ns, 1);
    LONGER(m->ages_b_ns, 1);
    LONGER(m->closings, 1);
    LONGER(m->achieved, 1);
    LONGER(m->manifold_counts, 1);
    *last(&m->kinds) = LATER_KIND;
    *last(&m->causes) = LATER_CAUSE;
    *last(&m->achieved) = LATER_ACHIEVED;
    *last(&m->manifold_counts) = 0;
}

static void add_counter(wire_status *m)
{
    static _Thread_local const char *names[WIRE_COUNTERS_MAX];
    static _Thread_local int64_t values[WIRE_COUNTERS_MAX];
    uint32_t n = m->counter_names.count;
    if (n == WIRE_COUNTERS_MAX) return;
    memcpy(names, m->counter_names.at, n * sizeof *names);
    memcpy(values, m->counter_values.at, n * sizeof *values);
    names[n] = "extension_" LATER_POSE_TEXT;
    values[n] = 1;
    m->counter_names = (wire_strings){n + 1, names};
    m->counter_values = (wire_i64s){n + 1, values};
}

/* What is on its way out for the first time; what has an extension has been here before. */
static wire_message later(const wire_message *m)
{
    wire_message more = *m;
    if (m->kind < WIRE_ANSWER || wire_extensions_of(m).count) return more;
    wire_extensions_set(&more, (wire_u8s){sizeof extension, extension});
    if (m->kind == WIRE_EVENT_BATCH && m->event_batch.kinds.count) add_event(&more.event_batch);
    if (m->kind == WIRE_STATUS) add_counter(&more.status);
    if (m->kind == WIRE_STATUS && m->status.health == WIRE_HEALTH_STOPPING) more.status.health = LATER_HEALTH;
    return more;
}

/* ---- a message of its own ---- */

static void say_later(void)
{
    static dds_entity_t writer;
    if (!writer) {
        const char *domain = getenv("LATER_DOMAIN");
        dds_entity_t p = dds_create_participant(domain ? (dds_domainid_t)atoi(domain) : 0, NULL, NULL);
        writer =
            dds_create_writer(p, dds_create_topic(p, &collided_Later_desc, "collided_Later", NULL, NULL), NULL, NULL);
    }
    dds_write(writer, &(collided_Later){.version = WIRE_VERSION, .word = (char *)(uintptr_t) "later"});
}

void __wrap_wire_dds_encode(const wire_message *m, void *sample)
{
    wire_message more = later(m);
    if (m->kind == WIRE_STATUS) say_later();
    __real_wire_dds_encode(&more, sample);
}

size_t __wrap_wire_lcm_size(const wire_message *m)
{
    wire_message more = later(m);
    return __real_wire_lcm_size(&more);
}

size_t __wrap_wire_lcm_encode(const wire_message *m, void *out, size_t capacity)
{
    wire_message more = later(m);
    return __real_wire_lcm_encode(&more, out, capacity);
}
