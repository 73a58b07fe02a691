/* link_replay: reads a recording tick by tick. One thread, the tick thread; whatever the daemon publishes meanwhile is
 * its own result, which link_replay_tick's hash is compared with, and goes to the listener alone. */
#include "link_replay.h"

#include "base/array.h"
#include "base/hash.h"
#include "wake.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

typedef enum replay_state { REPLAY_BETWEEN, REPLAY_TICK_READ, REPLAY_ENDED } replay_state;

typedef struct link_replay {
    struct link head;
    wire_log_reader *reader;
    replay_state state;
    wire_log_tick tick;
    char why[256];           /* what is wrong with the log; "" = nothing */
    ARRAY(uint8_t) reported; /* events of the tick, as link_replay_events tells them */
    ARRAY(uint8_t) whole;    /* what has come of a state */
    link_replay_listener listener;
    void *listener_context;
    metric *messages_in, *skipped, *unfinished;
} link_replay;

static link_replay *link_replay_of(struct link *l)
{
    return (link_replay *)l;
}

/* The address is the key. */
static int replay_check(const link_options *options, char key[LINK_KEY_MAX], char *why, size_t why_size)
{
    if (snprintf(key, LINK_KEY_MAX, "replay %s", options->address) < LINK_KEY_MAX) return EX_OK;
    snprintf(why, why_size, "replay://%.60s...: the name is too long", options->address);
    return EX_CONFIG;
}

static int replay_open(struct link *head, const link_options *options, char *why, size_t why_size)
{
    link_replay *l = link_replay_of(head);
    l->reader = wire_log_open(options->address, why, why_size);
    if (!l->reader) return -1;
    l->messages_in = metrics_add(options->counters, "replay_messages_in", "messages taken from the recording");
    l->skipped = metrics_add(options->counters, "replay_skipped", "records on channels that are not ours");
    l->unfinished =
        metrics_add(options->counters, "replay_unfinished", "messages after the recording's last whole tick");
    wake(options->wake_fd);
    return 0;
}

static void keep_reported(link_replay *l, const wire_log_entry *e)
{
    size_t at = l->reported.count;
    array_reserve(&l->reported, at + sizeof e->data_size + e->data_size);
    memcpy(l->reported.at + at, &e->data_size, sizeof e->data_size);
    memcpy(l->reported.at + at + sizeof e->data_size, e->data, e->data_size);
    l->reported.count += sizeof e->data_size + e->data_size;
}

link_replay_reported link_replay_events(struct link *head)
{
    return (link_replay_reported){link_replay_of(head)->reported.at, link_replay_of(head)->reported.count};
}

static void hand_over_entry(link_replay *l, const link_sink *sink, const wire_log_entry *e)
{
    if (e->kind == WIRE_LOG_MESSAGE)
        sink->message(sink->context, &l->head, &e->message);
    else if (e->kind == WIRE_LOG_STEPS && sink->steps_done)
        sink->steps_done(sink->context, e->steps_done);
    else if (e->kind == WIRE_LOG_BUILD && sink->build)
        sink->build(sink->context, e->build.client, e->build.hash, e->build.ready);
    else if (e->kind == WIRE_LOG_LOST)
        sink->client_lost(sink->context, &l->head, e->lost_client);
}

static const char MISSING[] = "a piece of the state that it begins with is missing";

static void fail(link_replay *l, const char *why)
{
    snprintf(l->why, sizeof l->why, "damaged: %s", why);
    l->state = REPLAY_ENDED;
}

/* One piece follows the other. */
static void take_state_piece(link_replay *l, const link_sink *sink, const wire_log_entry *e)
{
    size_t have = l->whole.count;
    if (e->state.offset != have) {
        fail(l, MISSING);
        return;
    }
    array_reserve(&l->whole, have + e->data_size);
    memcpy(l->whole.at + have, e->data, e->data_size);
    l->whole.count += e->data_size;
    if (l->whole.count < e->state.total) return;
    if (hash_words(HASH_START, l->whole.at, l->whole.count) != e->state.hash)
        fail(l, "the state that it begins with is not what was written");
    else if (sink->state)
        sink->state(sink->context, l->whole.at, l->whole.count);
    array_free(&l->whole);
}

/* Up to the end of the tick, or of the log. */
static size_t replay_receive(struct link *head, const link_sink *sink)
{
    link_replay *l = link_replay_of(head);
    size_t messages = 0;
    wire_log_entry e;
    if (l->state == REPLAY_BETWEEN) l->reported.count = 0;
    while (l->state == REPLAY_BETWEEN) {
        uint64_t skipped = 0;
        int got = wire_log_next(l->reader, &e, &skipped, l->why, sizeof l->why);
        metric_count(l->skipped, skipped);
        if (got != 1) {
            l->state = REPLAY_ENDED;
            metric_count(l->unfinished, messages);
        } else if (e.kind == WIRE_LOG_TICK && l->whole.count) {
            fail(l, MISSING);
        } else if (e.kind == WIRE_LOG_TICK) {
            l->tick = e.tick;
            l->state = REPLAY_TICK_READ;
        } else if (e.kind == WIRE_LOG_MESSAGE && e.message.kind == WIRE_EVENT_BATCH) {
            keep_reported(l, &e);
        } else if (e.kind == WIRE_LOG_STATE) {
            take_state_piece(l, sink, &e);
        } else {
            hand_over_entry(l, sink, &e);
            messages += e.kind == WIRE_LOG_MESSAGE;
        }
    }
    metric_count(l->messages_in, messages);
    return messages;
}

bool link_replay_tick(struct link *head, wire_log_tick *out, char *why, size_t why_size)
{
    link_replay *l = link_replay_of(head);
    snprintf(why, why_size, "%s", l->why);
    if (l->state != REPLAY_TICK_READ) return false;
    *out = l->tick;
    l->state = REPLAY_BETWEEN;
    wake(head->options.wake_fd); /* the next tick is there already */
    return true;
}

static void replay_publish(struct link *head, const wire_message *m)
{
    link_replay *l = link_replay_of(head);
    if (l->listener) l->listener(l->listener_context, m);
}

void link_replay_listen(struct link *head, link_replay_listener listener, void *context)
{
    link_replay_of(head)->listener = listener;
    link_replay_of(head)->listener_context = context;
}

static void replay_flush(struct link *head)
{
    (void)head;
}

static void replay_stream_open(struct link *head, const char *stream, int64_t client)
{
    (void)head, (void)stream, (void)client;
}

static void replay_stream_close(struct link *head, const char *stream)
{
    (void)head, (void)stream;
}

static void replay_describe(struct link *head, char *text, size_t size)
{
    snprintf(text, size, "replay of %s: nobody is listened to", head->options.address);
}

static void replay_close(struct link *head)
{
    wire_log_end(link_replay_of(head)->reader);
    array_free(&link_replay_of(head)->reported);
    array_free(&link_replay_of(head)->whole);
}

const link_ops link_replay_ops = {
    .scheme = "replay",
    .size = sizeof(link_replay),
    .has_liveliness = true, /* lost clients are in the recording */
    .acknowledges = false,
    .check = replay_check,
    .open = replay_open,
    .receive = replay_receive,
    .publish = replay_publish,
    .flush = replay_flush,
    .stream_open = replay_stream_open,
    .stream_close = replay_stream_close,
    .describe = replay_describe,
    .close = replay_close,
};
