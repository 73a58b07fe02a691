/* intake: see intake.h. The order of the tables is the order of what happens; each row is a filter (it may end the way
 * of a message), or a tap (it takes note). Nothing else stands between a link and the world. */
#include "intake.h"

#include "clients.h"
#include "commands.h"
#include "extensions.h"
#include "geometries.h"
#include "recordings.h"
#include "shares.h"
#include "standby.h"
#include "streams.h"

#include <stdlib.h>

typedef enum passing { PASSES, IS_DONE, IS_REFUSED } passing;

typedef passing row(service *s, struct link *from, const wire_message *m, wire_refusal *why);

static void refuse(service *s, struct link *from, const wire_message *m, const wire_refusal *why)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    apply_reject(s, from, m->kind, client, sequence, object, why);
}

/* ---- before it is admitted ---- */

static passing pass_count(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)why;
    metric_count(s->count.messages_in[m->kind], !from->in_parts);
    if (m->kind != WIRE_POSE_BATCH) s->received_us += price_of(m, 0).in_tick;
    return PASSES;
}

/* A receipt is no command: it is not recorded, the standby does not hear of it, and nobody waits for an answer. */
static passing pass_receipt(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    if (m->kind != WIRE_RECEIPT) return PASSES;
    if (standby_waits(s) || !session_find(s, m->receipt.client) || !limits_admit(s, from, m, why)) return IS_DONE;
    session_heard(s, m);
    if (m->receipt.epoch)
        stream_receipt(s, &m->receipt);
    else
        unheard_word(s, &m->receipt);
    return IS_DONE;
}

static passing pass_unheard(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)from, (void)why;
    if (m->kind == WIRE_POSE_BATCH) unheard_poses(s, &m->pose_batch);
    return PASSES;
}

static passing pass_standby(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)why;
    return standby_takes(s, from, m) ? IS_DONE : PASSES;
}

static passing pass_steps(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)from;
    return steps_admit(s, m, why) ? PASSES : IS_REFUSED;
}

static passing pass_limits(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    if (limits_admit(s, from, m, why)) return PASSES;
    refuse(s, from, m, why);
    if (why->reason == WIRE_LIMIT) steps_refused(s, from, m); /* it was the client's own */
    return IS_DONE;
}

static passing pass_shares(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    shares_verdict verdict = shares_admit(s, from, m, why);
    return verdict == SHARES_GO ? PASSES : verdict == SHARES_REFUSED ? IS_REFUSED : IS_DONE;
}

/* ---- when it is ---- */

static passing take_heard(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)from, (void)why;
    session_heard(s, m);
    return PASSES;
}

static passing take_record(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)from, (void)why;
    if (m->kind != WIRE_QUERY) record_message(s, m);
    return PASSES;
}

static passing take_journal(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)why;
    if (m->kind != WIRE_QUERY) standby_journal_message(s, from, m);
    return PASSES;
}

/* Poses at once, whatever their order; all else in the order that the tick makes. */
static passing take_in(service *s, struct link *from, const wire_message *m, wire_refusal *why)
{
    (void)why;
    if (m->kind == WIRE_POSE_BATCH)
        apply_poses(s, from, &m->pose_batch, true);
    else
        inbox_put(s, from, m);
    return IS_DONE;
}

/* ---- the order ---- */

/* Before these: what a later release has added to the message is left out (extensions.h). */
static row *const OFFERED[] = {
    pass_count,   /* by kind */
    pass_receipt, /* for the stream that it is of; done */
    pass_unheard, /* these poses have come */
    pass_standby, /* keeps it, or leaves it to the active one */
    pass_steps,   /* lock-step: is that step still to be done? */
    pass_limits,  /* of the client: messages and poses a second, its lease, memory, and which link speaks for it */
    pass_shares,  /* paid for, or it waits for its participant's turn, and comes to the table below then */
};

static row *const TAKEN[] = {
    take_heard,   /* a sign of life of its client */
    take_record,  /* before it is carried out */
    take_journal, /* to the standby */
    take_in,      /* poses to the world, commands and queries to the inbox of this tick */
};

static passing walk(row *const *rows, size_t count, service *s, struct link *from, const wire_message *m)
{
    wire_refusal why;
    passing p = PASSES;
    for (size_t i = 0; i < count && p == PASSES; i++) p = rows[i](s, from, m, &why);
    if (p == IS_REFUSED) refuse(s, from, m, &why);
    return p;
}

void service_take(service *s, struct link *from, const wire_message *m)
{
    (void)walk(TAKEN, sizeof TAKEN / sizeof *TAKEN, s, from, m);
}

void intake_offer(service *s, struct link *from, const wire_message *m)
{
    wire_message *less = extensions_leave_out(s, from, m);
    if (less) m = less;
    if (walk(OFFERED, sizeof OFFERED / sizeof *OFFERED, s, from, m) == PASSES) service_take(s, from, m);
    free(less);
}
