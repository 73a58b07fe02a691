/* standby: who of a pair is active, and what becomes of it. A daemon is joining until it has heard of an active one and
 * taken over its state (then it is the standby), or of nobody (then it is active). Two that join at once: the one that
 * began first is active; of two that are active, which happens when one of them only stood still or the network was
 * parted, the one of the lower epoch steps down, as clients follow the higher one (client/session_run.c). So a daemon
 * that goes on from nothing takes an epoch above all that it has heard of. Tick thread. */
#include "standby.h"

#include "base/clock.h"
#include "base/log.h"
#include "commands.h"
#include "recordings.h"
#include "standby_parts.h"
#include "streams.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const int64_t ALONE_NS = 1000000000;    /* who has not heard of another for so long is alone; at least ... */
static const int64_t ALONE_LEASES = 5;         /* ... so many leases */
static const int64_t ASK_AGAIN_NS = 500000000; /* for a state */
static const int64_t PORTION_NS = 1000000;     /* between two portions of one, at the latest */

uint8_t standby_place_of(const service *s, const struct link *l)
{
    uint8_t place = 0;
    while (place < s->link_count && s->links[place] != l) place++;
    return place;
}

bool standby_waits(const service *s)
{
    return s->standby && s->standby->announcement.role != PEER_ACTIVE;
}

/* ---- going over into another role ---- */

/* Nothing is left of what was: its state is the other one's, and comes from there. */
static void begin_anew(service *s)
{
    struct standby *p = s->standby;
    mute_links(s);
    record_stop(s);
    service_reset(s);
    kept_clear(&p->kept);
    for (int i = 0; i < 2; i++) p->batches[i].list.count = p->batches[i].bytes.count = 0;
    p->journal.count = 0;
    follower_end_state(s);
    standby_forget_state(p);
    p->active = p->asked_ns = p->waiting_ns = p->follower = p->lost_ns = p->dropped = p->doubted = p->missed = 0;
    p->in_step = p->out_of_step = p->state_wanted = p->left = p->followed = p->sure = p->heir = false;
    p->journalled_tick = p->had_tick = 0;
    p->began_ns = s->monotonic_ns;
    announcement_say(s, PEER_JOINING);
}

/* Those that our own links have not heard are given a lease's time. */
static void rebase_clocks(service *s)
{
    for (size_t i = 0; i < s->sessions.count; i++) {
        session *c = s->sessions.at[i];
        c->last_seen_ns = s->monotonic_ns;
        c->rejects = (flow){0};
        if (!standby_hears(s, c->client)) c->announced = false;
    }
    for (size_t i = 0; i < LOST_KEPT; i++) s->left_clients[i].since_ns = s->monotonic_ns;
    for (size_t i = 0; i < s->streams.count; i++) s->streams.at[i].reported_ns = 0;
    pending_wait_anew(s);
    s->next_heartbeat_ns = 0;
    s->lock_step.since_ns = 0;
    s->wall_ahead_ns = s->standby->in_step ? s->standby->ahead_ns : 0;
    service_follow_clock(s); /* it may have been set back meanwhile, or be behind the other one's */
    s->began_ns = s->announced_ns = s->monotonic_ns;
    s->rejects = (flow){0};
    s->limit_ns = s->monotonic_ns;
    s->limits[0] = '\0';
}

static void become_active(service *s, const link_sink *sink, const char *why)
{
    struct standby *p = s->standby;
    bool goes_on = p->in_step;
    s->epoch = goes_on ? s->epoch + 1 : announcement_new_line(s);
    service_replay_budget(s, false, 0);
    service_set_budget(s);
    if (!goes_on) ready_begin(s);
    announcement_say(s, PEER_ACTIVE);
    open_links_again(s);
    rebase_clocks(s);
    record_begin(s); /* of the world as it is; what was kept comes behind it */
    for (size_t i = 0; i < s->streams.count; i++) s->streams.at[i].inherited = s->streams.at[i].batch;
    p->heir = goes_on;
    if (goes_on) mute_publish_again(s);
    stream_heartbeats(s);
    s->status_due = true;
    p->in_step = p->left = p->followed = false;
    p->active = p->waiting_ns = p->alone = 0;
    p->journalled_tick = p->had_tick = s->tick;
    size_t kept = p->kept.messages.count;
    kept_apply(s, sink, s->monotonic_ns - 3 * p->lease_ns);
    if (goes_on)
        log_notice("%s: this standby is active now, and goes on from tick %" PRId64 ", epoch %" PRId64
                   "; %zu messages were not in the journal",
            why, s->tick, s->epoch, kept);
    else
        log_notice("%s: this daemon is active, epoch %" PRId64, why, s->epoch);
    metric_count(s->count.takeovers, goes_on);
}

/* Its epoch is told to be over. */
static void resign(service *s)
{
    metric_count(s->count.steps_down, 1);
    s->health = WIRE_HEALTH_STOPPING; /* of the old epoch */
    health_publish(s);
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
    begin_anew(s);
}

static void step_down(service *s, const peer_announcement *other)
{
    log_warning("%s has taken over (epoch %" PRId64 ", ours was %" PRId64
                "): this daemon steps down, and what it published since is not believed by anybody who has heard of it",
        other->name, other->epoch, s->epoch);
    if (other->epoch == s->epoch) s->standby->alone = s->epoch;
    resign(s);
}

/* Whoever has heard of a successor would believe nothing of this line any more. */
static void resolve_doubt(service *s)
{
    struct standby *p = s->standby;
    if (!p->doubted || s->monotonic_ns < p->quiet_ns) return;
    const peer_announcement *c = announcement_of(p, p->doubted);
    p->doubted = 0;
    if (c && c->alive && c->role == PEER_STANDBY && c->epoch == s->epoch) return;
    log_warning("the standby is gone, and may have taken over while this daemon stood still: it begins anew");
    resign(s);
}

/* ---- what the other one says ---- */

static bool has_taken_over(const service *s, const peer_announcement *c)
{
    return c->alive && c->role == PEER_ACTIVE &&
           announcement_stays(c->epoch, c->sender, s->epoch, s->standby->announcement.sender);
}

static void on_announcement(void *context, const peer_announcement *announcement)
{
    service *s = context;
    struct standby *p = s->standby;
    peer_announcement *known = announcement_of(p, announcement->sender);
    bool is_new = !known || known->role != announcement->role;
    if (announcement->epoch > p->seen_epoch) p->seen_epoch = announcement->epoch;
    if (is_new && announcement->alive && strcmp(announcement->release, p->announcement.release) != 0)
        log_warning("%s is of release %s, this one of %s: no pair", announcement->name, announcement->release,
            p->announcement.release);
    if (known)
        *known = *announcement;
    else
        array_push(&p->peers, *announcement);
    s->status_due |=
        is_new && p->announcement.role == PEER_ACTIVE; /* clients hear that it is there, and tell it of themselves */
    if (p->announcement.role == PEER_ACTIVE && has_taken_over(s, announcement))
        step_down(s, announcement);
    else if (p->announcement.role == PEER_ACTIVE)
        follower_find(s);
    announcements_forget_dead(p);
}

/* ---- records ---- */

static void on_record(void *context, int64_t sender, uint8_t kind, const uint8_t *bytes, size_t size)
{
    service *s = context;
    struct standby *p = s->standby;
    bytes_in r = {.at = bytes, .left = size};
    if (p->announcement.role == PEER_ACTIVE) {
        if (kind == JOURNAL_WANT_STATE) follower_wishes(s, sender, &r);
        if (kind == JOURNAL_HAVE) follower_has(s, sender, &r);
        return;
    }
    if (sender != p->active || p->out_of_step) return;
    if (kind == JOURNAL_STATE && !p->in_step) standby_take_state(s, &r);
    if (kind == JOURNAL_TICK) p->in_step ? standby_replay_tick(s, &r) : standby_keep_tick(s, &r);
    int64_t whom = 0;
    if (kind == JOURNAL_DROPPED && p->in_step && bytes_get(&r, &whom, sizeof whom) && whom == p->announcement.sender) {
        log_warning("the active daemon waits for this one no more: its state is asked for anew");
        p->out_of_step = true;
    }
    journal_followed word;
    if (kind == JOURNAL_FOLLOWED && p->in_step && bytes_get(&r, &word, sizeof word) &&
        word.whom == p->announcement.sender) {
        p->followed = true;
        if (word.asked == p->missed) p->missed = 0;
    }
    if (kind == JOURNAL_LEAVE) {
        p->left = true;
        p->missed = 0; /* all before it has come */
    }
}

static void on_gap(void *context, int64_t sender)
{
    service *s = context;
    struct standby *p = s->standby;
    if (p->announcement.role == PEER_ACTIVE || sender != p->active) return;
    standby_forget_state(p); /* it is asked for again */
    if (!p->in_step) return;
    log_warning("ticks of the active daemon were lost: its state is asked for anew");
    metric_count(s->count.out_of_step, 1);
    p->out_of_step = true;
}

/* ---- rounds ---- */

static void follow(service *s, const peer_announcement *active)
{
    struct standby *p = s->standby;
    if (p->active != active->sender) {
        p->asked_ns = 0;
        standby_forget_state(p);
    }
    p->active = active->sender;
    if (p->asked_ns && s->monotonic_ns - p->asked_ns < ASK_AGAIN_NS) return;
    p->asked_ns = s->monotonic_ns;
    p->link->ops->peers->send(
        p->link, p->announcement.sender, JOURNAL_WANT_STATE, (const uint8_t *)&p->alone, sizeof p->alone);
}

static void join(service *s, const link_sink *sink)
{
    struct standby *p = s->standby;
    int64_t patience_ns = ALONE_LEASES * p->lease_ns > ALONE_NS ? ALONE_LEASES * p->lease_ns : ALONE_NS;
    const peer_announcement *active = announcement_of_active(p);
    if (active) {
        follow(s, active);
        return;
    }
    if (p->active) { /* it was there, and its state never came: it may be back */
        p->active = 0;
        p->began_ns = s->monotonic_ns;
    }
    /* One of another release is left to its clients until it ends. */
    bool waits = announcement_is_before_us(p, PEER_JOINING) || announcement_is_there(p, PEER_STANDBY) ||
                 announcement_is_there(p, PEER_ACTIVE);
    kept_bound(s);
    if (!waits && s->monotonic_ns - p->began_ns >= patience_ns) become_active(s, sink, "no active daemon was heard");
}

static void stand_by(service *s, const link_sink *sink)
{
    struct standby *p = s->standby;
    const peer_announcement *active = announcement_of(p, p->active), *another = announcement_of_active(p);
    if (active && active->alive && active->role == PEER_ACTIVE && active->epoch == s->epoch && !p->left) {
        p->waiting_ns = 0;
        return;
    }
    if (another && (another->sender != p->active || another->epoch != s->epoch)) { /* it was before us, or began anew */
        begin_anew(s);
        return;
    }
    if (s->monotonic_ns < p->quiet_ns) return; /* it was we who stood still, perhaps: its signs may be unread */
    if (!p->waiting_ns) p->waiting_ns = s->monotonic_ns;
    if (announcement_is_before_us(p, PEER_STANDBY) && s->monotonic_ns - p->waiting_ns < 2 * p->lease_ns) return;
    if (!p->followed || p->missed) {
        log_warning("the active daemon is gone %s: what it told last is not known here",
            p->missed ? "while this one stood still" : "before it waited for this one");
        begin_anew(s);
        return;
    }
    become_active(s, sink, p->left ? "the active daemon has left" : "the active daemon is gone: its lease ran out");
}

/* An active daemon that stood still may have a successor, of which it has not read yet; a standby may not have read the
 * signs of life of its active one. */
static void notice_standstill(service *s)
{
    struct standby *p = s->standby;
    int64_t gap_ns = s->monotonic_ns - p->round_ns;
    if (!p->round_ns || gap_ns <= p->lease_ns / 2 || !p->peers.count) return;
    bool active = p->announcement.role == PEER_ACTIVE, is_long = gap_ns > p->lease_ns;
    if (active && !is_long && s->monotonic_ns < p->quiet_ns) return; /* it looks around already, and not for ever */
    p->quiet_ns = s->monotonic_ns + p->lease_ns;
    if (p->announcement.role == PEER_STANDBY && gap_ns > (SLOW_LEASES - 1) * p->lease_ns) {
        p->missed = s->monotonic_ns;
        p->said_ns = 0; /* it is asked at once */
    }
    if (!is_long || !active) return;
    log_warning(
        "this daemon stood still for %.3f s: it looks whether another one has taken over", 1e-9 * (double)gap_ns);
    if (p->sure) p->doubted = p->follower;
}

bool standby_round(service *s, const link_sink *sink)
{
    struct standby *p = s->standby;
    if (!p) return false;
    const peer_sink peers = {s, on_announcement, on_record, on_gap};
    notice_standstill(s);
    p->round_ns = s->monotonic_ns;
    p->link->ops->peers->receive(p->link, &peers);
    for (size_t i = 0; i < p->peers.count; i++)
        if (p->peers.at[i].alive) p->alive_ns = s->monotonic_ns;
    if (p->out_of_step) begin_anew(s);
    /* DDS takes a writer whose lease ran out for alive again only when it writes. */
    if (s->monotonic_ns - p->said_ns >= p->lease_ns / 2) {
        announcement_say(s, (peer_role)p->announcement.role);
        if (p->announcement.role == PEER_STANDBY) standby_say_have(s, s->tick); /* it may know us only now */
    }
    if (p->announcement.role == PEER_ACTIVE) resolve_doubt(s);
    if (p->announcement.role == PEER_ACTIVE) follower_drop_slow(s);
    if (p->announcement.role == PEER_ACTIVE) follower_find(s);
    if (p->announcement.role == PEER_ACTIVE) follower_state_more(s);
    if (p->announcement.role == PEER_JOINING)
        join(s, sink);
    else if (p->announcement.role == PEER_STANDBY)
        stand_by(s, sink);
    return standby_waits(s) || s->monotonic_ns < p->quiet_ns;
}

int64_t standby_next_ns(const service *s)
{
    const struct standby *p = s->standby;
    if (!p) return INT64_MAX;
    if (standby_wants_tick(s)) return p->round_ns;
    return p->round_ns + (p->state.size ? PORTION_NS : p->lease_ns / 4);
}

/* ---- what comes by the links ---- */

bool standby_takes(service *s, struct link *from, const wire_message *m)
{
    if (!s->standby) return false;
    kept_hear(s, m);
    if (!standby_waits(s)) return false;
    if (m->kind != WIRE_QUERY) kept_message_came(s, from, m); /* a query is the active one's, and is asked again */
    return true;
}

bool standby_takes_lost(service *s, struct link *from, int64_t client)
{
    if (s->standby) kept_hear_loss(s, client);
    if (standby_waits(s)) kept_lost_came(s, from, client);
    return standby_waits(s);
}

bool standby_hears(const service *s, int64_t client)
{
    return !s->standby || standby_waits(s) || kept_is_alive(&s->standby->kept, client);
}

bool standby_takes_reader(service *s, struct link *from, const char *stream)
{
    if (standby_waits(s)) kept_reader_came(s, from, stream);
    return standby_waits(s);
}

/* ---- beginning and end ---- */

int standby_start(service *s, char *why, size_t why_size)
{
    struct link *l = NULL;
    if (!s->config.standby || s->replaying) return 0;
    for (size_t i = 0; i < s->link_count && !l; i++)
        if (s->links[i]->ops->peers) l = s->links[i];
    if (!l) {
        snprintf(why, why_size, "standby = yes: the daemons of a pair speak over DDS: add dds://DOMAIN to links");
        return -1;
    }
    struct standby *p = s->standby = base_zalloc(1, sizeof *p);
    p->link = l;
    p->lease_ns = (int64_t)(1e9 * s->config.standby_lease);
    p->announcement = (peer_announcement){.sender = s->started_ns};
    snprintf(p->announcement.name, sizeof p->announcement.name, "%s", s->daemon_name);
    snprintf(p->announcement.release, sizeof p->announcement.release, "%s", health_release());
    p->memory = wire_memory_create();
    p->began_ns = s->monotonic_ns;
    kept_init(&p->kept);
    if (l->ops->peers->join(l, p->lease_ns) != 0) {
        snprintf(why, why_size, "standby = yes: DDS refuses the topics of a pair%s",
            *s->config.security ? ": with a site of an older release do: make_site --renew" : "");
        return -1;
    }
    mute_links(s);
    world_set_budget(s->world, NULL, NULL);
    announcement_say(s, PEER_JOINING);
    return 0;
}

void standby_free(service *s)
{
    struct standby *p = s->standby;
    if (!p) return;
    mute_links(s); /* what is held is the standby's to tell */
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops = p->muted[i].own;
    mute_free(p);
    kept_free(&p->kept);
    array_free(&p->peers);
    array_free(&p->journal);
    follower_end_state(s);
    standby_forget_state(p);
    wire_memory_destroy(p->memory);
    free(p);
    s->standby = NULL;
}

void standby_describe(const service *s, char *text, size_t size)
{
    const char *const ROLES[] = {"joining", "standby", "active", "leaving"};
    text[0] = '\0';
    if (!s->standby) return;
    const peer_announcement *other = standby_waits(s) || !s->standby->sure ? NULL : follower_announcement(s);
    bool joins = !other && announcement_is_there(s->standby, PEER_JOINING);
    snprintf(text, size, "; %s, %s%s", ROLES[s->standby->announcement.role],
        other   ? "hot standby: "
        : joins ? "without a standby: one joins"
                : "without a standby",
        other ? other->name : "");
}
