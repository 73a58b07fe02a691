/* subscriptions: subscribing and unsubscribing. The stream's reader is there before the subscription is announced, so
 * that its first batch finds it. The caller's thread. */
#include "allocate.h"
#include "announce.h"
#include "message.h"
#include "session.h"
#include "wire/wire_soft.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FIRST_RESYNC_S = 2 };

static wire_message subscription_message(
    const collided *c, int32_t id, const char *stream, const collided_subscription_def *def, wire_u8s extensions)
{
    return (wire_message){.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = c->id,
            .sequence = c->sequence + 1,
            .subscription = id,
            .facts = (int32_t)def->facts,
            .stream = stream,
            .select_a = def->select_a ? def->select_a : "*",
            .select_b = def->select_b ? def->select_b : "*",
            .threshold_m = def->threshold_m,
            .range_m = def->range_m,
            .tolerance_m = def->tolerance_m,
            .relative_tolerance = def->relative_tolerance,
            .accuracy = (uint8_t)def->accuracy,
            .hysteresis_m = def->hysteresis_m,
            .horizon_s = def->horizon_s,
            .rate_hz = def->rate_hz,
            .extensions = extensions}};
}

static subscription_record *add_subscription_record(
    collided *c, const char *stream, const collided_subscription_def *def, const collided_soft_def *soft)
{
    subscription_record *i = allocate(1, sizeof *i);
    int64_t now = session_monotonic_ns();
    *i = (subscription_record){.id = c->next_subscription++,
        .stream = duplicate(stream),
        .callback = def->callback,
        .context = def->context,
        .soft_callback = soft ? soft->callback : NULL,
        .soft_context = soft ? soft->context : NULL,
        .waiting = true,
        .lacks_ns = now,
        .each_tick = def->rate_hz == 0,
        .resync_wait_ns = FIRST_RESYNC_S * NS_PER_S,
        .resync_ns = now + FIRST_RESYNC_S * NS_PER_S,
        .last_seen_ns = now,
        .patience_ns = c->lease_ns > SESSION_SILENCE_NS ? c->lease_ns : SESSION_SILENCE_NS,
        .next = c->subscriptions};
    c->subscriptions = i;
    return i;
}

static collided_subscription subscribe(
    collided *c, const collided_subscription_def *def, collided_observed *observed, const collided_soft_def *soft)
{
    uint8_t room[WIRE_SOFT_INTEREST_BYTES];
    const wire_soft_interest interest = {
        .grain = soft && soft->each_feature ? WIRE_SOFT_EACH : WIRE_SOFT_SUMMARY, .most = soft ? soft->most : 0};
    wire_u8s extensions = {soft ? wire_soft_put_interest(&interest, room) : 0, room};
    const collided_subscription none = {COLLIDED_NONE};
    if (c->on_arrival && c->in_callback) {
        (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "on_arrival: subscribe from outside of callbacks");
        return none;
    }
    char own[WIRE_NAME_MAX + 1];
    (void)snprintf(own, sizeof own, "%016llx.%d", (unsigned long long)c->id, c->next_subscription);
    const char *stream = def->stream ? def->stream : own;
    pthread_mutex_lock(&c->lock);
    wire_message m = subscription_message(c, c->next_subscription, stream, def, extensions);
    wire_refusal why;
    bool fits = wire_check(&m, &why) == WIRE_OK && (def->callback || observed);
    pthread_mutex_unlock(&c->lock);
    if (!fits) {
        (void)session_fail(
            c, COLLIDED_BAD_ARGUMENT, "subscription: %s", def->callback || observed ? why.text : "callback is needed");
        return none;
    }
    if (c->link->ops->stream_open(c->link, stream)) {
        (void)session_fail(c, COLLIDED_TRANSPORT, "cannot read the stream '%s'", stream);
        return none;
    }
    subscription_record *i = add_subscription_record(c, stream, def, soft);
    i->observed = observed;
    i->has_poses = def->facts & COLLIDED_POSES;
    pthread_mutex_lock(&c->lock);
    announce(c, &i->announced, message_copy(&m));
    pthread_mutex_unlock(&c->lock);
    return (collided_subscription){i->id};
}

collided_subscription collided_subscribe(collided *c, const collided_subscription_def *def)
{
    if (!(def->facts & WIRE_FACT_SCENE)) return subscribe(c, def, NULL, NULL);
    (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "subscription: scenes are for collided_observe");
    return (collided_subscription){COLLIDED_NONE};
}

collided_subscription collided_subscribe_soft(
    collided *c, const collided_subscription_def *def, const collided_soft_def *soft)
{
    if (!(def->facts & WIRE_FACT_SCENE)) return subscribe(c, def, NULL, soft);
    return collided_subscribe(c, def);
}

collided_subscription collided_observe(collided *c, const collided_observation_def *def)
{
    collided_subscription_def whole = collided_subscription_def_default();
    whole.facts = WIRE_FACT_SCENE;
    whole.select_a = def->select ? def->select : "*";
    whole.stream = def->stream;
    whole.rate_hz = def->rate_hz;
    whole.context = def->context;
    if (def->callback) return subscribe(c, &whole, def->callback, NULL);
    (void)session_fail(c, COLLIDED_BAD_ARGUMENT, "observation: callback is needed");
    return (collided_subscription){COLLIDED_NONE};
}

collided_status collided_unsubscribe(collided *c, collided_subscription subscription)
{
    subscription_record *i = c->subscriptions;
    while (i && (i->id != subscription.id || i->removed)) i = i->next;
    if (!i) return session_fail(c, COLLIDED_UNKNOWN_ID, "there is no subscription %d", subscription.id);
    const wire_message m = {.kind = WIRE_SUBSCRIPTION,
        .subscription = {.version = WIRE_VERSION,
            .client = c->id,
            .subscription = i->id,
            .removed = 1,
            .stream = "",
            .select_a = "",
            .select_b = ""}};
    i->removed = true;
    pthread_mutex_lock(&c->lock);
    announce_leaves_name(c, &i->announced);
    announce(c, &i->announced, message_copy(&m));
    pthread_mutex_unlock(&c->lock);
    return COLLIDED_OK;
}

static void free_record(subscription_record *i)
{
    stream_drop_parts(i);
    free(i->parts);
    free(i->stream);
    free(i);
}

/* Outside of callbacks, since one may unsubscribe the very stream that it is called for. */
void subscriptions_sweep(collided *c)
{
    for (subscription_record **at = &c->subscriptions; *at;) {
        subscription_record *i = *at;
        if (i->removed && i->stream) {
            c->link->ops->stream_close(c->link, i->stream);
            free(i->stream);
            i->stream = NULL;
        }
        pthread_mutex_lock(&c->lock);
        bool forgotten = i->forgotten;
        pthread_mutex_unlock(&c->lock);
        if (forgotten) {
            *at = i->next;
            free_record(i);
        } else {
            at = &i->next;
        }
    }
}

void subscriptions_free(collided *c)
{
    for (subscription_record *i = c->subscriptions, *next; i; i = next) {
        next = i->next;
        announce_drop(c, &i->announced);
        free_record(i);
    }
    c->subscriptions = NULL;
}
