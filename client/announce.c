/* announce: sending, repeating and settling announcements. Runs on both threads, always under the client's mutex. An
 * announcement is in the record exactly as long as its message is not NULL. */
#include "announce.h"

#include "message.h"
#include "wire/wire_lcm.h"

#include <stdio.h>
#include <stdlib.h>

static bool is_removal(const wire_message *m)
{
    return (m->kind == WIRE_BODY && m->body.removed) || (m->kind == WIRE_SUBSCRIPTION && m->subscription.removed) ||
           (m->kind == WIRE_CLIENT && m->client.removed) || (m->kind == WIRE_GEOMETRY && m->geometry.removed);
}

static void link_last(collided *c, announcement *a)
{
    a->next = NULL;
    a->previous = c->last;
    if (c->last)
        c->last->next = a;
    else
        c->first = a;
    c->last = a;
}

static void unlink_one(collided *c, announcement *a)
{
    if (a->previous)
        a->previous->next = a->next;
    else
        c->first = a->next;
    if (a->next)
        a->next->previous = a->previous;
    else
        c->last = a->previous;
}

static void set_state(collided *c, announcement *a, announce_state state)
{
    if (a->state == ANNOUNCE_PENDING) c->pending--;
    if (state == ANNOUNCE_PENDING) c->pending++;
    a->state = state;
    if (!c->pending) session_wake_caller(c);
}

/* A transport that keeps what was sent brings it to whoever comes, but the answer may be lost: the daemon discovers our
 * writers and our readers independently, and answers nobody when it hears us before it knows who listens. */
static int64_t repeat_after_ns(const collided *c, unsigned tries)
{
    int64_t ms = c->link->ops->repeats ? ANNOUNCE_FIRST_REPEAT_MS : ANNOUNCE_FIRST_DOUBT_MS;
    while (tries-- > 1 && ms < ANNOUNCE_LAST_REPEAT_MS) ms *= 2;
    return (ms < ANNOUNCE_LAST_REPEAT_MS ? ms : ANNOUNCE_LAST_REPEAT_MS) * NS_PER_MS;
}

static void take_sequence(collided *c, announcement *a)
{
    table_drop(&c->by_sequence, message_sequence(a->message));
    message_set_sequence(a->message, ++c->sequence);
    table_put(&c->by_sequence, c->sequence, a);
    if (a->message->kind == WIRE_BODY && !a->message->body.removed) body_refresh((body_record *)a);
    a->renew = false;
}

static void send_now(collided *c, announcement *a, int64_t now_ns)
{
    if (a->renew) take_sequence(c, a);
    (void)session_send(c, a->message); /* counts its failures; the repetition mends them */
    a->tries++;
    a->due_ns = now_ns + repeat_after_ns(c, a->tries);
}

static bool may_write(const collided *c, wire_kind kind)
{
    return !c->link->ops->permits || c->link->ops->permits(c->link, kind);
}

/* What our certificate's permissions do not let us write, nobody would hear: refused here, in the daemon's place. */
static bool permitted(collided *c, announcement *a)
{
    const wire_message *m = a->message;
    if (may_write(c, m->kind)) return true;
    char text[128];
    wire_reject why = {.client = c->id, .kind = (uint8_t)m->kind, .reason = WIRE_NOT_YOURS, .text = text};
    wire_origin(m, &why.client, &why.sequence, &why.object);
    (void)snprintf(text, sizeof text, "the permissions of this client do not let it write %s", wire_kind_name(m->kind));
    set_state(c, a, ANNOUNCE_REFUSED);
    session_keep_rejection(c, &why);
    return false;
}

void announce(collided *c, announcement *a, wire_message *message)
{
    if (a->message) {
        table_drop(&c->by_sequence, message_sequence(a->message));
        free(a->message);
    } else {
        link_last(c, a);
        a->state = ANNOUNCE_ACKED;
    }
    a->message = message;
    message_set_sequence(message, ++c->sequence);
    table_put(&c->by_sequence, c->sequence, a);
    a->renew = false;
    a->tries = 0;
    set_state(c, a, ANNOUNCE_PENDING);
    if (!permitted(c, a)) return;
    send_now(c, a, session_monotonic_ns());
    /* The keeper sleeps until the first of those that wait is due; where repetition is rare, that will do for all. */
    if (c->link->ops->repeats || c->pending == 1) session_wake_keeper(c);
}

static void make_due(collided *c, announcement *a, bool renew, int64_t due_ns)
{
    if (!may_write(c, a->message->kind)) return; /* it has been refused for good */
    a->renew = a->renew || renew;
    a->due_ns = due_ns;
    if (a->state != ANNOUNCE_PENDING) a->tries = 0;
    set_state(c, a, ANNOUNCE_PENDING);
    session_wake_keeper(c);
}

void announce_again(collided *c, announcement *a)
{
    int64_t now = session_monotonic_ns();
    a->renewed_ns = now;
    c->counters.announced_again++;
    make_due(c, a, true, now);
}

void announce_all_again(collided *c)
{
    c->all_again_ns = session_monotonic_ns();
    c->all_again_wanted = false;
    for (announcement *a = c->first; a; a = a->next) announce_again(c, a);
}

void announce_drop(collided *c, announcement *a)
{
    if (!a->message) return;
    table_drop(&c->by_sequence, message_sequence(a->message));
    unlink_one(c, a);
    if (a->state == ANNOUNCE_PENDING) set_state(c, a, ANNOUNCE_ACKED);
    free(a->message);
    a->message = NULL;
}

void announce_leaves_name(collided *c, announcement *a)
{
    c->names_leaving += !a->leaves_name;
    a->leaves_name = true;
}

/* Its old name is free, or stays its own. */
static void has_left_name(collided *c, announcement *a)
{
    if (!a->leaves_name) return;
    a->leaves_name = false;
    c->names_leaving--;
    c->name_left_ns = session_monotonic_ns();
}

/* The object is gone on both sides: its record ends. */
static void settle_removal(collided *c, announcement *a)
{
    wire_kind kind = a->message->kind;
    has_left_name(c, a);
    if (c->link->ops->forget) c->link->ops->forget(c->link, a->message);
    if (kind == WIRE_CLIENT) {
        set_state(c, a, ANNOUNCE_ACKED);
        return;
    }
    announce_drop(c, a);
    if (kind == WIRE_BODY) {
        table_drop(&c->bodies, ((body_record *)a)->id);
        body_free(c, (body_record *)a);
    } else if (kind == WIRE_SUBSCRIPTION) {
        ((subscription_record *)a)->forgotten = true;
    }
}

void announce_to_new_daemon(collided *c)
{
    bool repeats = c->link->ops->repeats;
    int64_t now = session_monotonic_ns();
    for (announcement *a = c->first, *next; a; a = next) {
        next = a->next;
        if (is_removal(a->message) && a != &c->client)
            settle_removal(c, a);
        else if (repeats)
            make_due(c, a, true, now);
        else if (!a->renew) { /* the transport hands it to the new daemon, with the pose of old */
            if (a->message->kind == WIRE_BODY) ((body_record *)a)->teleported = true;
            make_due(c, a, false, now + repeat_after_ns(c, 0));
        }
    }
}

int64_t announce_tend(collided *c, int64_t now_ns)
{
    int64_t next = INT64_MAX, all_ns = c->all_again_ns + NS_PER_S;
    if (c->all_again_wanted && now_ns >= all_ns) announce_all_again(c);
    if (c->all_again_wanted) next = all_ns;
    size_t burst = 0;
    for (announcement *a = c->pending ? c->first : NULL; a; a = a->next) {
        if (a->state != ANNOUNCE_PENDING) continue;
        if (a->due_ns <= now_ns && burst < ANNOUNCE_BURST_BYTES) {
            burst += wire_lcm_size(a->message);
            if (!a->renew) c->counters.repeats++;
            send_now(c, a, now_ns);
        }
        if (a->due_ns < next) next = a->due_ns;
    }
    /* What the burst left over is due already: its turn comes in a moment. */
    return next <= now_ns ? now_ns + NS_PER_MS : next;
}

announcement *announce_find(const collided *c, int64_t sequence)
{
    return table_get(&c->by_sequence, sequence);
}

void announce_acked(collided *c, int64_t sequence)
{
    announcement *a = announce_find(c, sequence);
    if (!a || a->state != ANNOUNCE_PENDING || a->renew) return; /* of an older word on the same object, or known */
    if (is_removal(a->message)) {
        settle_removal(c, a);
        return;
    }
    set_state(c, a, ANNOUNCE_ACKED);
    has_left_name(c, a);
    if (a->message->kind == WIRE_BODY) body_acked(c, (body_record *)a);
}

static bool may_renew(const announcement *a)
{
    return session_monotonic_ns() - a->renewed_ns >= NS_PER_S;
}

/* A body of ours that is removed or renamed may still have the name when the next one that bears it is heard of, and a
 * subscription its stream, or both their place among as many as may be; and that it had may be told after it was told
 * to be gone. */
static bool may_be_left_name(const collided *c)
{
    return c->names_leaving || (c->name_left_ns && session_monotonic_ns() - c->name_left_ns < NS_PER_S);
}

/* A network has no order between topics, and one that repeats what it has lost none at all: what depends on something
 * that has not come yet is announced again, later. */
static bool comes_of_order(const collided *c, wire_reason reason)
{
    if (reason == WIRE_NAME_TAKEN || reason == WIRE_LIMIT) return may_be_left_name(c);
    return reason == WIRE_UNKNOWN_CLIENT || reason == WIRE_UNKNOWN_GEOMETRY;
}

static bool is_matter_of_order(const collided *c, const announcement *a, wire_reason reason)
{
    bool too_much = reason == WIRE_LIMIT && is_removal(a->message); /* in a second */
    return (too_much || comes_of_order(c, reason)) && a->tries < ANNOUNCE_ORDER_TRIES;
}

/* Of a word that is not the newest on its object any more, or of poses of a body that is gone: nobody waits for it. */
static bool is_of_before(const collided *c, const wire_reject *why)
{
    if (why->kind == WIRE_POSE_BATCH)
        return why->reason == WIRE_UNKNOWN_BODY && why->object >= 0 && !table_get(&c->bodies, why->object);
    bool announces = why->kind == WIRE_BODY || why->kind == WIRE_SUBSCRIPTION || why->kind == WIRE_GEOMETRY;
    return announces && comes_of_order(c, (wire_reason)why->reason);
}

/* A refused message that is no announcement. The daemon may have lost us while we stood still: it is told again who we
 * are and what we own, at most once a second: if it has lost us twice within one, when that is over. True if the caller
 * need not hear of it. */
static bool repair(collided *c, const wire_reject *why)
{
    if (why->reason == WIRE_UNKNOWN_CLIENT) {
        c->all_again_wanted = true;
        session_wake_keeper(c);
        return true;
    }
    if (why->reason != WIRE_UNKNOWN_BODY) return false;
    body_record *body = table_get(&c->bodies, why->object);
    if (!body || !body->announced.message) return false;
    if (body->announced.state != ANNOUNCE_ACKED || why->sequence < message_sequence(body->announced.message))
        return true;            /* it may know it by now */
    c->all_again_wanted = true; /* it had it, and has lost all; of those that do not move it would not ask */
    if (may_renew(&body->announced)) announce_again(c, &body->announced);
    return true;
}

/* Not ours: another participant speaks under our id, and the daemon listens to that one as long as it lives. If it is
 * what a crash left of ourselves, that is until its lease is over: the announcement stays, and is repeated. Or it was
 * the other one who was refused, and we hear of it: nothing of ours is settled by that. */
void announce_rejected(collided *c, const wire_reject *why)
{
    announcement *a = announce_find(c, why->sequence);
    if (why->reason == WIRE_NOT_YOURS) a = NULL;
    if (!a) {
        if (!repair(c, why) && !is_of_before(c, why)) session_keep_rejection(c, why);
        return;
    }
    if (a->state != ANNOUNCE_PENDING) return; /* of a copy, to which the next one was answered before or like this */
    if (is_matter_of_order(c, a, (wire_reason)why->reason)) {
        if (c->client.state == ANNOUNCE_ACKED && why->reason == WIRE_UNKNOWN_CLIENT && may_renew(&c->client))
            announce_again(c, &c->client);
        make_due(c, a, true, session_monotonic_ns() + repeat_after_ns(c, a->tries));
        return;
    }
    set_state(c, a, ANNOUNCE_REFUSED);
    session_keep_rejection(c, why);
    has_left_name(c, a);
    if (is_removal(a->message)) settle_removal(c, a); /* what the daemon does not know needs no removal */
}
