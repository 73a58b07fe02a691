/* standby_replay: the standby's end of the journal: the state that it begins from, and each tick, carried out as the
 * active daemon did. Tick thread. */
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "standby_parts.h"
#include "streams.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdlib.h>

static bool carry_out(service *s, const journal_entry *e)
{
    struct standby *p = s->standby;
    struct link *from = e->link < s->link_count ? s->links[e->link] : NULL;
    if (!from) return false;
    switch (e->kind) {
    case ENTRY_MESSAGE:
        kept_confirm(&p->kept, &e->message);
        service_take(s, from, &e->message);
        return true;
    case ENTRY_LOST:
        kept_confirm_lost(&p->kept, e->client);
        inbox_put_lost(s, from, e->client);
        return true;
    case ENTRY_READER:
        kept_confirm_reader(&p->kept, e->stream);
        stream_reader(s, from, e->stream);
        return true;
    case ENTRY_BUILD:
        geometry_report(s, e->client, e->hash, e->ready != 0);
        return true;
    case ENTRY_TICK:
        if (e->epoch != s->epoch || e->tick.tick != s->tick + 1) return false;
        service_replay_budget(s, e->tick.budgeted, (uint64_t)e->tick.work);
        s->slice = (uint64_t)e->tick.slice;
        s->pairs_most = e->tick.pairs_most;
        s->tick = e->tick.tick;
        s->now_ns = e->tick.now_ns;
        s->monotonic_ns = e->tick.monotonic_ns;
        service_tick(s);
        return (uint64_t)e->tick.events_hash == s->events_hash;
    }
    return false;
}

/* It has come: that is said before it is carried out, since the active one waits for it. */
void standby_say_have(service *s, int64_t tick)
{
    struct standby *p = s->standby;
    const journal_have have = {.to = p->active, .epoch = s->epoch, .tick = tick, .asks = p->missed};
    p->link->ops->peers->send(p->link, p->announcement.sender, JOURNAL_HAVE, (const uint8_t *)&have, sizeof have);
}

void standby_replay_tick(service *s, bytes_in *r)
{
    struct standby *p = s->standby;
    int64_t number;
    if (bytes_get(r, &number, sizeof number)) standby_say_have(s, number);
    int64_t now_ns = s->now_ns, monotonic_ns = s->monotonic_ns, tick = s->tick + 1;
    journal_entry e;
    bool good = true;
    while (good && journal_next(r, p->memory, &e)) good = carry_out(s, &e);
    p->ahead_ns = s->now_ns - monotonic_ns;
    s->now_ns = now_ns;
    s->monotonic_ns = monotonic_ns;
    kept_sweep(s);
    if (good && !r->broken) return;
    log_error("tick %" PRId64 " of the active daemon came out differently here: its state is asked for anew", tick);
    metric_count(s->count.out_of_step, 1);
    p->out_of_step = true;
}

/* ---- the state ---- */

/* What comes before it is whole: more than this, and it is asked for anew, when less may be going on. */
static const size_t LATER_BYTES = (size_t)512 << 20;

void standby_forget_state(struct standby *p)
{
    array_free(&p->coming);
    array_free(&p->later);
}

void standby_keep_tick(service *s, bytes_in *r)
{
    struct standby *p = s->standby;
    if (!p->coming.count) return; /* the state that will come has it in it */
    if (p->later.count > LATER_BYTES) {
        log_warning("more comes from the active daemon than its state: that is asked for anew");
        standby_forget_state(p);
        return;
    }
    bytes_put_count(&p->later, r->left);
    bytes_put(&p->later, r->at, r->left);
}

/* The ticks that came after it, while it was on its way. */
static void catch_up(service *s)
{
    struct standby *p = s->standby;
    bytes_out later = p->later;
    p->later = (bytes_out){0};
    bytes_in all = {.at = later.at, .left = later.count};
    while (all.left && !p->out_of_step) {
        size_t size = bytes_get_count(&all, 1);
        bytes_in tick = {.at = all.at, .left = size};
        all.at += size;
        all.left -= size;
        standby_replay_tick(s, &tick);
    }
    array_free(&later);
}

/* The next portion: true if all have come. */
static bool state_is_whole(struct standby *p, bytes_in *r)
{
    journal_portion head;
    if (!bytes_get(r, &head, sizeof head)) return false;
    if (head.offset == 0) standby_forget_state(p);
    if (head.offset != p->coming.count) { /* its beginning came before this daemon did */
        standby_forget_state(p);
        return false;
    }
    bytes_put(&p->coming, r->at, r->left);
    return p->coming.count == head.whole;
}

void standby_take_state(service *s, bytes_in *r)
{
    struct standby *p = s->standby;
    char why[128] = "";
    p->asked_ns = s->monotonic_ns; /* it is being answered */
    if (!state_is_whole(p, r)) return;
    bytes_in whole = {.at = p->coming.at, .left = p->coming.count};
    bool taken = state_take(s, &whole, why, sizeof why);
    array_free(&p->coming);
    if (!taken) {
        log_error("the state of the active daemon cannot be taken over: %s", why);
        p->out_of_step = true;
        return;
    }
    p->in_step = true;
    p->alone = 0;
    catch_up(s);
    if (p->out_of_step) return;
    announcement_say(s, PEER_STANDBY);
    standby_say_have(s, s->tick);
    log_notice("in step with the active daemon, from tick %" PRId64 " on, epoch %" PRId64, s->tick, s->epoch);
}
