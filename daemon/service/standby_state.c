/* The state of an active daemon between two ticks, for a standby that begins. Tick thread. */
#include "standby_parts.h"

#include <stdio.h>

bool state_is_fit(const service *s)
{
    return !s->inbox.letters.count && !s->sessions.count && !s->geometries.count;
}

typedef struct state_head {
    int64_t epoch, tick;
    uint64_t events_hash;
} state_head;

void state_put(service *s, journal_bytes *to)
{
    state_head h = {s->epoch, s->tick, s->events_hash};
    journal_put(to, &h, sizeof h);
}

bool state_take(service *s, journal_reader *from, char *why, size_t why_size)
{
    state_head h;
    if (!journal_get(from, &h, sizeof h)) {
        snprintf(why, why_size, "it is cut off");
        return false;
    }
    s->epoch = h.epoch;
    s->tick = h.tick;
    s->events_hash = h.events_hash;
    return true;
}
