/* standby_active: the active daemon of a pair: whom it waits for, which is one standby that is in step, what that one
 * has of its journal, and the writing of it. Tick thread. */
#include "recordings.h"
#include "standby.h"
#include "standby_parts.h"

#include "base/log.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>

static const int64_t FOLLOWED_NS = 10000000000; /* a peer that was alive may be back: it is still written for */

/* ---- who follows ---- */

const peer_announcement *follower_announcement(const service *s)
{
    struct standby *p = s->standby;
    return p->follower && p->announcement.role == PEER_ACTIVE ? announcement_of(p, p->follower) : NULL;
}

static bool may_follow(const service *s, const peer_announcement *c)
{
    return c->alive && c->role == PEER_STANDBY && c->epoch == s->epoch && c->sender != s->standby->dropped;
}

/* It is told so by the journal, in which it finds that before it can miss anything. */
static void follower_lose(service *s, const char *why)
{
    struct standby *p = s->standby;
    const peer_announcement *f = follower_announcement(s);
    log_notice("%s %s", f ? f->name : "the standby", why);
    if (p->sure) p->alone = s->epoch;
    p->dropped = p->follower;
    p->link->ops->peers->send(
        p->link, p->announcement.sender, JOURNAL_DROPPED, (const uint8_t *)&p->dropped, sizeof p->dropped);
    p->follower = p->lost_ns = 0;
    p->sure = false;
    open_links_again(s);
    s->status_due = true;
}

/* It may be we who do not hear it, and it may be about to take over: what it does not have is told when it would have
 * done so long ago. */
static bool is_given_up(service *s)
{
    struct standby *p = s->standby;
    const peer_announcement *f = follower_announcement(s);
    bool alive = f && f->alive;
    if (alive) p->lost_ns = 0;
    if (alive) return !may_follow(s, f);
    if (!p->lost_ns) p->lost_ns = s->monotonic_ns;
    if (p->lost_ns < p->quiet_ns) p->lost_ns = p->quiet_ns; /* we stood still ourselves */
    return s->monotonic_ns - p->lost_ns >= (SLOW_LEASES - 1) * p->lease_ns;
}

/* Of several the one that began first: it has precedence among themselves, too. */
void follower_find(service *s)
{
    struct standby *p = s->standby;
    const peer_announcement *first = NULL;
    if (s->monotonic_ns < p->quiet_ns) return; /* what was held would go out, and it may have taken over */
    if (p->follower && is_given_up(s)) follower_lose(s, "is no standby any more: lost, or out of step");
    if (p->follower) return;
    for (size_t i = 0; i < p->peers.count; i++) {
        const peer_announcement *c = &p->peers.at[i];
        if (may_follow(s, c) && (!first || c->sender < first->sender)) first = c;
    }
    if (!first) return;
    p->follower = first->sender;
    p->lost_ns = 0;
    p->sure_tick = p->journalled_tick;
    p->had_tick = 0; /* it will say */
    p->sure = false;
    hold_links(s);
}

static void say_followed(struct standby *p, int64_t asked)
{
    const journal_followed word = {.whom = p->follower, .asked = asked};
    p->link->ops->peers->send(p->link, p->announcement.sender, JOURNAL_FOLLOWED, (const uint8_t *)&word, sizeof word);
}

void follower_has(service *s, int64_t sender, bytes_in *r)
{
    struct standby *p = s->standby;
    journal_have have;
    if (!bytes_get(r, &have, sizeof have) || have.to != p->announcement.sender || have.epoch != s->epoch) return;
    if (sender != p->follower) return;
    if (have.asks && p->sure) say_followed(p, have.asks);
    if (have.tick <= p->had_tick) return;
    p->had_tick = have.tick;
    if (!p->sure && p->had_tick >= p->sure_tick) {
        p->sure = s->status_due = true;
        p->alone = 0; /* it knows that, too */
        say_followed(p, have.asks);
        const peer_announcement *f = follower_announcement(s); /* NULL: it is dead already */
        log_notice("%s is in step: it takes over when this one is gone", f ? f->name : "the standby");
    }
    hold_release(s);
}

/* One that lives and does not keep up is waited for no more. */
void follower_drop_slow(service *s)
{
    struct standby *p = s->standby;
    bool holds = p->mouth == MOUTH_HELD && p->held.first < p->held.list.count;
    bool stood_still = s->monotonic_ns < p->quiet_ns; /* nobody was slow but we */
    if (!holds || stood_still || p->held_tick != p->had_tick) p->had_ns = s->monotonic_ns;
    p->held_tick = p->had_tick;
    if (s->monotonic_ns - p->had_ns < SLOW_LEASES * p->lease_ns) return;
    follower_lose(s, "does not keep up: it is waited for no more, and has to join anew");
}

/* What is on its way is of the line that ends. */
static void begin_state_anew(service *s)
{
    struct standby *p = s->standby;
    p->state_wanted |= p->state.size > 0;
    follower_end_state(s);
}

/* Another one has told in this line what is not known here: whoever heard it would take our batches for those that come
 * next. Under a line of their own they begin with a snapshot. */
static void begin_line(service *s, const peer_announcement *other)
{
    if (s->standby->follower) follower_lose(s, "is of the line that ends: it has to join anew");
    int64_t before = s->epoch;
    s->epoch = announcement_new_line(s);
    s->standby->heir = false;
    begin_state_anew(s);
    announcement_say(s, PEER_ACTIVE);
    for (uint32_t i = 0; i < s->streams.count; i++)
        if (s->streams.at[i].live) world_want_snapshot(s->world, i);
    s->status_due = true;
    log_warning("%s was active, too, while the network was parted: epoch %" PRId64 " becomes %" PRId64
                ", and every stream begins anew",
        other ? other->name : "another daemon", before, s->epoch);
}

void follower_wishes(service *s, int64_t sender, bytes_in *r)
{
    struct standby *p = s->standby;
    int64_t alone = 0;
    p->alive_ns = s->monotonic_ns; /* its announcement may come later: topics have no order */
    if (bytes_get(r, &alone, sizeof alone) && wire_same_line(alone, s->epoch))
        begin_line(s, announcement_of(p, sender));
    p->state_wanted = true;
    if (p->dropped == sender) p->dropped = 0;
}

/* Once for each time that we took over, whoever says so. */
bool standby_was_outrun(service *s, const stream *to, int64_t epoch, int64_t batch)
{
    struct standby *p = s->standby;
    if (!p || !p->heir || standby_waits(s) || epoch >= s->epoch || batch <= to->inherited) return false;
    begin_line(s, NULL);
    return true;
}

bool standby_hands_over(service *s)
{
    struct standby *p = s->standby;
    if (!p) return false;
    if (standby_waits(s)) { /* nobody knows of it but the active one, which need not wait for it */
        announcement_say(s, PEER_LEAVING);
        return true;
    }
    const peer_announcement *to = follower_announcement(s);
    if (!to || !to->alive || !p->sure) {
        if (p->follower) follower_lose(s, "is not there to take over");
        return false;
    }
    log_notice("%s takes over", to->name);
    p->link->ops->peers->send(p->link, p->announcement.sender, JOURNAL_LEAVE, NULL, 0);
    return true;
}

/* ---- its journal ---- */

static bool is_followed(const service *s)
{
    const struct standby *p = s->standby;
    return p && p->announcement.role == PEER_ACTIVE && p->alive_ns && s->monotonic_ns - p->alive_ns < FOLLOWED_NS;
}

/* A record begins with the number of its tick. */
static bytes_out *journal_of(service *s)
{
    bytes_out *to = &s->standby->journal;
    int64_t tick = s->tick + 1;
    if (!to->count) bytes_put(to, &tick, sizeof tick);
    return to;
}

void standby_journal_message(service *s, const struct link *from, const wire_message *m)
{
    if (is_followed(s)) journal_put_message(journal_of(s), standby_place_of(s, from), m);
}

void standby_journal_lost(service *s, const struct link *from, int64_t client)
{
    if (is_followed(s)) journal_put_lost(journal_of(s), standby_place_of(s, from), client);
}

void standby_journal_build(service *s, int64_t client, int64_t hash, bool ready)
{
    if (is_followed(s)) journal_put_build(journal_of(s), client, hash, ready);
}

void standby_journal_reader(service *s, const struct link *from, const char *stream)
{
    if (is_followed(s)) journal_put_reader(journal_of(s), standby_place_of(s, from), stream);
}

void standby_journal_tick(service *s)
{
    struct standby *p = s->standby;
    if (!is_followed(s)) return;
    wire_log_tick t = {s->tick, s->now_ns, s->monotonic_ns, (int64_t)s->events_hash,
        .budgeted = s->config.budget_us > 0, .work = (int64_t)world_get_figures(s->world).work,
        .slice = (int64_t)service_slice_reported(s), .pairs_most = service_pairs_limited(s)};
    if (!p->journal.count) bytes_put(&p->journal, &s->tick, sizeof s->tick); /* nothing came */
    journal_put_tick(&p->journal, s->epoch, &t);
    p->link->ops->peers->send(p->link, p->announcement.sender, JOURNAL_TICK, p->journal.at, p->journal.count);
    metric_count(s->count.journalled, 1);
    p->journal.count = 0;
    p->journalled_tick = s->tick;
}

/* ---- the state ---- */

bool standby_wants_tick(const service *s)
{
    const struct standby *p = s->standby;
    return p && p->state_wanted && !p->state.size && p->announcement.role == PEER_ACTIVE;
}

void follower_end_state(service *s)
{
    struct standby *p = s->standby;
    state_parts_free(&p->state, s->builds);
    p->touched = 0;
}

/* Pages that are written for the first time take longer than what is written there: of a large state, ten times as
 * long. They are touched before, some in each tick. True: there is room for all of it. */
static bool make_room(const service *s, struct standby *p)
{
    enum { A_TICK = 16 << 20, PAGE = 4096 };
    bytes_out *own = &p->state.own;
    size_t size = state_size(s), need = size + size / 16;
    if (own->capacity < need) p->touched = 0;
    array_reserve(own, need);
    size_t until = p->touched + A_TICK < need ? p->touched + A_TICK : need;
    for (size_t at = p->touched; at < until; at += PAGE) own->at[at] = 0;
    p->touched = until;
    return until == need;
}

/* To send all of it takes far longer than to put it together, so it goes round by round, and ticks go on between. */
void follower_state_more(service *s)
{
    enum { A_ROUND = 2 << 20 };
    struct standby *p = s->standby;
    if (!p->state.size) return;
    const journal_portion head = {.whole = p->state.size, .offset = p->state.read};
    uint8_t *portion = base_alloc(sizeof head + A_ROUND, 1);
    memcpy(portion, &head, sizeof head);
    size_t size = state_parts_read(&p->state, portion + sizeof head, A_ROUND);
    p->link->ops->peers->send(p->link, p->announcement.sender, JOURNAL_STATE, portion, sizeof head + size);
    free(portion);
    if (p->state.read == p->state.size) follower_end_state(s);
}

/* The journal is empty here: what comes from now on is of the next tick. */
void standby_after_tick(service *s)
{
    struct standby *p = s->standby;
    if (!standby_wants_tick(s) || !make_room(s, p)) return;
    p->state_wanted = false;
    state_put(s, &p->state);
    log_info("the state of tick %" PRId64 " goes to a standby: %zu bytes", s->tick, p->state.size);
    follower_state_more(s);
}
