/* record: every command, what each tick reported, and the end of every tick, to a file in LCM's log format. A recording
 * that begins in the middle starts with what is announced now as if it came anew, for who reads it, and with the whole
 * state, from which a replay goes on. A thread of its own writes it (record_file.h). When the disk refuses, or a limit
 * is reached, the recording ends, is counted, and the world goes on. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "record_file.h"
#include "recordings.h"
#include "service.h"
#include "streams.h"

#include "base/log.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    HERE_MS = 10,        /* a tick waits for a disk so long: most are quicker */
    AT_ONCE = 4 << 20,   /* bytes that a recording begins with within the tick it was asked for in */
    ENDS_MAX = 4,        /* recordings that a slow disk has yet to finish */
    REPORT_NS = 8000000, /* of a tick goes to what a large world's recording begins with */
    AGAIN_NS = 5000000,  /* they are looked after so often */
    LAST_WAIT_MS = 60000 /* for those, when the daemon ends */
};

/* No more is put into it. */
static void let_go_of_recording(service *s)
{
    wire_log_close(s->recording ? s->recording : s->record_next);
    s->recording = s->record_next = NULL;
    array_free(&s->record_room);
    record_state_end(s);
    s->state_due = false;
    array_push(&s->record_ends, s->recording_to);
    s->recording_to = NULL;
}

/* It has ended of itself. */
static void report_end_of_recording(service *s, const record_file *f, const char *path)
{
    const char *option, *why = record_file_why(f, &option);
    log_error("recording to %s ends: %s", path, why);
    metric_count(s->count.record_failures, 1);
    apply_name_limit(s, *option ? option : "recording");
}

static void check_file(service *s)
{
    const char *option;
    if (!s->recording_to || record_file_look(s->recording_to, 0) != RECORD_FILE_ENDED) return;
    report_end_of_recording(s, s->recording_to, record_file_path(s->recording_to));
    if (s->record_next && s->record_reply.to) { /* whoever asked for it is told that it did not come to that */
        s->record_reply.answer.status = s->record_wish.status = WIRE_ANSWER_UNSUPPORTED;
        snprintf(s->record_wish.text, sizeof s->record_wish.text, "%.400s", record_file_why(s->recording_to, &option));
    }
    let_go_of_recording(s);
}

static void check(service *s, int result)
{
    if (result == 0) return;
    log_error("recording to %s ends: %s", record_file_path(s->recording_to), strerror(errno));
    metric_count(s->count.record_failures, 1);
    let_go_of_recording(s);
}

static void close_ended(service *s, int wait_ms)
{
    size_t left = 0;
    for (size_t i = 0; i < s->record_ends.count; i++)
        if (!record_file_close(s->record_ends.at[i], wait_ms)) s->record_ends.at[left++] = s->record_ends.at[i];
    s->record_ends.count = left;
}

/* 0, or -1: it cannot be made. What a slow disk says later is told by check_file. */
static int open_recording(service *s, const record_terms *terms, int wait_ms, char *why, size_t why_size)
{
    const char *option;
    close_ended(s, 0);
    bool many = s->record_ends.count >= ENDS_MAX;
    record_file *f = many ? NULL : record_file_begin(terms);
    if (!f) {
        snprintf(why, why_size, "%s: %s", terms->path, many ? "the disk is behind with earlier ones" : strerror(errno));
        return -1;
    }
    if (record_file_look(f, wait_ms) == RECORD_FILE_ENDED) {
        snprintf(why, why_size, "%s", record_file_why(f, &option));
        if (*option) apply_name_limit(s, option);
        if (!record_file_close(f, HERE_MS)) array_push(&s->record_ends, f);
        return -1;
    }
    s->recording_to = f;
    s->record_next = wire_log_to(record_file_put, f, 0);
    return 0;
}

static void announce(service *s)
{
    s->recording = s->record_next;
    s->record_next = NULL;
    for (size_t i = 0; i < s->streams.count; i++) s->streams.at[i].recorded = 0;
    char settings[CONFIG_DECIDING_MAX];
    config_report_deciding(&s->config, settings);
    if (*settings) check(s, wire_log_settings(s->recording, s->now_ns / 1000, settings));
    s->state_due = s->tick > 0;
    if (s->recording) record_state_begin(s);
}

static int start(service *s, const record_terms *terms, const int64_t *client, int wait_ms, char *why, size_t why_size)
{
    if (s->recording_to) {
        snprintf(why, why_size, "already recording to %s", record_file_path(s->recording_to));
        return -1;
    }
    if (open_recording(s, terms, wait_ms, why, why_size) != 0) return -1;
    s->recording_of =
        (record_beginner){.by_query = client != NULL, .client = client ? *client : 0, .since_ns = s->monotonic_ns};
    log_notice("recording to %s", record_file_path(s->recording_to));
    size_t bytes = record_state_size(s), state_bytes = state_size(s);
    if (s->tick > 0 && !s->replaying && bytes + state_bytes > AT_ONCE) {
        record_file_ask_room(s->recording_to, state_bytes + state_bytes / 16);
        return 0;
    }
    announce(s);
    (void)record_state_more(s, INT64_MAX);
    if (s->recording) return 0;
    snprintf(why, why_size, "%s: it cannot be written", terms->path);
    return -1;
}

static record_terms terms_of(const service *s, const char *path)
{
    return (record_terms){.path = path,
        .most_bytes = (int64_t)s->config.record_max_size << 20,
        .keep_free = s->config.record_keep_free / 100};
}

int record_start(service *s, const char *path, const int64_t *client, char *why, size_t why_size)
{
    record_terms terms = terms_of(s, path);
    if (client) terms.most_files = s->config.record_max_files;
    return start(s, &terms, client, client ? HERE_MS : -1, why, why_size);
}

/* What was recorded before is in it, what is recorded from here on comes after it. */
static void record_whole_state(service *s)
{
    state_parts whole = {.own = s->record_room};
    s->record_room = (bytes_out){0};
    s->state_due = false;
    if (!s->recording) {
        state_parts_free(&whole, s->builds);
        return;
    }
    state_put(s, &whole);
    int64_t first = wire_log_leave_state(s->recording, whole.size);
    record_file_put_state(s->recording_to, &whole, first, s->now_ns / 1000);
}

void record_begin(service *s)
{
    char why[CONFIG_TEXT_MAX + 256];
    if (!*s->config.record || s->recording) return;
    record_terms terms = terms_of(s, s->config.record);
    terms.beside = true;
    if (start(s, &terms, NULL, HERE_MS, why, sizeof why) != 0)
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
    if (s->recording && !s->state_due && s->config.record_events) stream_each(s, batches, record_one, s);
}

void record_tick(service *s)
{
    wire_log_tick t = {s->tick, s->now_ns, s->monotonic_ns, (int64_t)s->events_hash,
        .budgeted = s->replaying ? s->recorded_budget : s->config.budget_us > 0,
        .work = (int64_t)world_get_figures(s->world).work, .slice = (int64_t)service_slice_reported(s),
        .pairs_most = service_pairs_limited(s)};
    if (s->record_next && record_file_take_room(s->recording_to, &s->record_room)) {
        announce(s);
        return;
    }
    if (s->record_telling.runs) { /* over some ticks, whose ends are not reported; the state is one tick's work */
        if (record_file_part(s->recording_to)) (void)record_state_more(s, REPORT_NS);
        return;
    }
    if (s->state_due) record_whole_state(s);
    if (s->recording) check(s, wire_log_tick_end(s->recording, s->now_ns / 1000, &t));
    if (s->recording) record_file_tick(s->recording_to, s->replaying);
}

void record_lost(service *s, int64_t client)
{
    if (s->recording) check(s, wire_log_lost(s->recording, s->now_ns / 1000, client));
}

void record_build(service *s, int64_t client, int64_t hash, bool ready)
{
    if (s->recording) check(s, wire_log_build(s->recording, s->now_ns / 1000, client, hash, ready));
}

void record_steps(service *s)
{
    if (s->recording && s->lock_step.begun) check(s, wire_log_steps(s->recording, s->now_ns / 1000, s->lock_step.done));
}

bool record_may_end(const service *s, int64_t client, char *why, size_t why_size)
{
    const record_beginner *b = &s->recording_of;
    static const char ELSE[] = "it ends by its limits, and by SIGUSR1 to the daemon";
    if (b->by_query && !b->gone && b->client == client) return true;
    if (!b->by_query)
        snprintf(why, why_size, "the daemon's configuration began this recording: %s, not by a query", ELSE);
    else if (b->gone)
        snprintf(
            why, why_size, "client %016" PRIx64 " began this recording and is gone: %s", (uint64_t)b->client, ELSE);
    else
        snprintf(why, why_size, "client %016" PRIx64 " began this recording: it alone may end it, or %s",
            (uint64_t)b->client, ELSE);
    return false;
}

void record_stop(service *s)
{
    if (!s->recording_to) return;
    check_file(s);
    if (!s->recording_to) return;
    char path[2 * CONFIG_TEXT_MAX];
    snprintf(path, sizeof path, "%s", record_file_path(s->recording_to));
    let_go_of_recording(s);
    log_notice("recording to %s ended", path);
    close_ended(s, HERE_MS);
}

/* Where a link notices who goes, the number of a client that is gone may be anybody's next. */
static void watch_beginner(service *s)
{
    record_beginner *b = &s->recording_of;
    const session *c = session_find(s, b->client);
    if (c) b->watched |= c->link->ops->has_liveliness;
    b->gone |= b->watched && (!c || c->lost || c->left);
}

static void watch_time(service *s)
{
    const record_beginner *b = &s->recording_of;
    if (!b->by_query || (double)(s->monotonic_ns - b->since_ns) < 1e9 * s->config.record_max_time) return;
    log_warning("recording to %s ends: record_max_time = %g s is reached", record_file_path(s->recording_to),
        s->config.record_max_time);
    apply_name_limit(s, "record_max_time");
    record_stop(s);
}

void record_watch(service *s)
{
    check_file(s);
    if (s->recording_to && s->recording_of.by_query) watch_beginner(s);
    if (s->recording_to) watch_time(s);
    if (s->record_ends.count) close_ended(s, 0);
    bool begins = s->record_next || (s->recording && s->state_due);
    if (!s->record_ends.count && !begins) answer_owed(s);
}

bool record_wants_tick(const service *s)
{
    return s->record_next || (s->recording && s->state_due);
}

int64_t record_next_ns(const service *s)
{
    return s->record_ends.count || record_wants_tick(s) ? s->monotonic_ns + AGAIN_NS : INT64_MAX;
}

void record_stop_now(service *s)
{
    record_stop(s);
    close_ended(s, LAST_WAIT_MS);
    if (s->record_ends.count) log_error("%zu recording(s) are not whole: the disk stands still", s->record_ends.count);
    array_free(&s->record_ends);
}
