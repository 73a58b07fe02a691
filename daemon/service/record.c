/* record: every command, what each tick told, and the end of every tick, to a file in LCM's log format. A recording
 * that begins in the middle starts with what is announced now as if it came anew, for who reads it, and with the whole
 * state, from which a replay goes on. When the disk refuses, the recording ends, is counted, and the world goes on.
 * Tick thread. */
#include "service.h"

#include "base/hash.h"
#include "base/log.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { RECORDINGS_MAX = 1000 }; /* beside each other */

static void check(service *s, int result)
{
    if (result == 0) return;
    log_error("recording to %s ends: %s", s->recording_path, strerror(errno));
    metric_count(s->count.record_failures, 1);
    wire_log_close(s->recording);
    s->recording = NULL;
}

int record_start(service *s, const char *path, char *why, size_t why_size)
{
    if (s->recording) {
        snprintf(why, why_size, "already recording to %s", s->recording_path);
        return -1;
    }
    s->recording = wire_log_create(path, why, why_size);
    if (!s->recording) return -1;
    snprintf(s->recording_path, sizeof s->recording_path, "%s", path);
    log_notice("recording to %s", path);
    for (size_t i = 0; i < s->streams.count; i++) s->streams.at[i].recorded = 0;
    char settings[CONFIG_DECIDING_MAX];
    config_tell_deciding(&s->config, settings);
    if (*settings) check(s, wire_log_settings(s->recording, s->now_ns / 1000, settings));
    record_state(s);
    s->state_due = s->tick > 0;
    if (s->recording) return 0;
    snprintf(why, why_size, "%s: the disk refuses it", path);
    return -1;
}

/* What was recorded before is in it, what is recorded from here on comes after it. */
static void record_whole_state(service *s)
{
    bytes_out whole = {0};
    s->state_due = false;
    if (!s->recording) return;
    state_put(s, &whole);
    uint64_t hash = hash_words(HASH_START, whole.at, whole.count);
    check(s, wire_log_whole_state(s->recording, s->now_ns / 1000, whole.at, whole.count, hash));
    array_free(&whole);
}

void record_begin(service *s)
{
    char path[CONFIG_TEXT_MAX + 16], why[CONFIG_TEXT_MAX + 256];
    if (!*s->config.record || s->recording) return;
    snprintf(path, sizeof path, "%s", s->config.record);
    for (int n = 1; access(path, F_OK) == 0 && n < RECORDINGS_MAX; n++)
        snprintf(path, sizeof path, "%s.%d", s->config.record, n);
    if (record_start(s, path, why, sizeof why) != 0)
        log_error("record: %s", why);
    else if (s->state_due)
        record_whole_state(s);
}

void record_message(service *s, const wire_message *m)
{
    if (s->recording) check(s, wire_log_message(s->recording, s->now_ns / 1000, m));
}

static void record_one(void *context, const wire_message *m)
{
    record_message(context, m);
}

void record_events(service *s, const world_batches *batches)
{
    if (s->recording && s->config.record_events) stream_each(s, batches, record_one, s);
}

void record_tick(service *s)
{
    wire_log_tick t = {s->tick, s->now_ns, s->monotonic_ns, (int64_t)s->events_hash,
        .budgeted = s->replaying ? s->recorded_budget : s->config.budget_us > 0,
        .work = (int64_t)world_get_figures(s->world).work, .pairs_most = service_pairs_limited(s)};
    if (s->state_due) record_whole_state(s);
    if (s->recording) check(s, wire_log_tick_end(s->recording, s->now_ns / 1000, &t));
}

void record_lost(service *s, int64_t client)
{
    if (s->recording) check(s, wire_log_lost(s->recording, s->now_ns / 1000, client));
}

void record_steps(service *s)
{
    if (s->recording && s->lock_step.begun) check(s, wire_log_steps(s->recording, s->now_ns / 1000, s->lock_step.done));
}

void record_stop(service *s)
{
    if (!s->recording) return;
    wire_log_writer *w = s->recording;
    s->recording = NULL;
    s->state_due = false;
    if (wire_log_close(w) != 0) {
        log_error("recording to %s is not whole: %s", s->recording_path, strerror(errno));
        metric_count(s->count.record_failures, 1);
    } else {
        log_notice("recording to %s ended", s->recording_path);
    }
}
