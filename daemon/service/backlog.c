/* backlog: what waits on a stream until its subscriber has read what came before. A subscriber that sends receipts is
 * sent only so much beyond the last of them (the window, which grows while nothing is lost and is halved by a loss);
 * what it has not acknowledged is kept, and sent again from where it says that something is missing. To one that sends
 * none, what is large goes slowly. While nothing waits, batches pass by here (backlog_is_passed), and nothing is kept
 * of them. Of what is too much the reader is spared all but a snapshot, which comes when it has read the rest.
 *
 * None of this is a command: numbers of batches, events and their hash are the same, whoever reads how fast. Tick
 * thread. */
#include "base/log.h"
#include "clients.h"
#include "memory.h"
#include "service.h"
#include "standby.h"
#include "streams.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    WINDOW_FIRST = 16, /* messages of at most 64 kB ... */
    WINDOW_LEAST = 4,
    WINDOW_MOST = 128,   /* ... of which DDS keeps 256 on either side */
    BLIND_PASS = 64,     /* without receipts: a batch of more parts is sent slowly, ... */
    BLIND_BURST = 8,     /* ... so many at once, ... */
    BLIND_AGAIN_MOST = 3 /* ... halved each time that a snapshot is asked for again, up to so often */
};
static const size_t BACKLOG_BYTES = 64 << 20;       /* more than this, before a tick's, is not kept; ... */
static const size_t BACKLOG_IDLE_BYTES = 16 << 20;  /* ... nor more than this for who does not read, ... */
static const int64_t IDLE_NS = 500000000;           /* ... or has not for so long */
static const int64_t BLIND_PAUSE_NS = 20000000;     /* between two bursts */
static const int64_t BLIND_AGAIN_NS = 30000000000;  /* a snapshot asked for within this time is asked for again */
static const int64_t SNAPSHOT_PAUSE_NS = 100000000; /* between two that receipts ask for: each is work for a tick */
static const int64_t STARVED_NS = 2000000000;       /* something waits, and nothing was acknowledged for so long */
static const int64_t STARVED_SKIPPED = 256;         /* batches, since it was up to date */
static const int64_t WARN_AGAIN_NS = 60000000000;   /* of the same stream */
static const int64_t WATCH_NS = 250000000;

static size_t waiting(const backlog *b)
{
    return b->entries.count - b->first;
}

bool backlog_is_behind(const backlog *b)
{
    return waiting(b) || b->anew || b->building;
}

int64_t backlog_count(const backlog *b)
{
    return (int64_t)(waiting(b) + b->built.count) + b->anew;
}

static void drop_from(backlog *b, size_t from)
{
    while (b->entries.count > from) {
        backlog_entry *e = &b->entries.at[--b->entries.count];
        b->bytes -= e->size;
        free(e->data);
    }
}

static void drop_built(backlog *b)
{
    while (b->built.count) {
        backlog_entry *e = &b->built.at[--b->built.count];
        b->bytes -= e->size;
        free(e->data);
    }
    b->building = false;
}

void backlog_clear(backlog *b)
{
    drop_from(b, b->first);
    drop_built(b);
    b->entries.count = b->first = b->next = 0;
}

/* What was acknowledged leaves the array when it is most of it. */
static void compact(backlog *b)
{
    if (b->first < 1024 || b->first < b->entries.count / 2) return;
    memmove(b->entries.at, b->entries.at + b->first, waiting(b) * sizeof *b->entries.at);
    b->entries.count -= b->first;
    b->next -= b->first;
    b->first = 0;
}

void backlog_free(backlog *b)
{
    backlog_clear(b);
    array_free(&b->entries);
    array_free(&b->built);
}

bool backlog_is_passed(const service *s, const stream *to, const world_batch *batch, int32_t parts)
{
    const backlog *b = &to->backlog;
    if (batch->closing || stream_is_replayed(s, to) || standby_waits(s)) return true;
    if (backlog_is_behind(b)) return false;
    if (to->link->ops->loses_nothing) return true;
    if (batch->snapshot) return parts <= WINDOW_FIRST;
    return b->receipts ? to->batch - b->received + parts <= WINDOW_MOST : parts <= BLIND_PASS;
}

/* ---- what comes to wait ---- */

/* A snapshot makes what waits before it superfluous. */
static void replace_by_snapshot(service *s, backlog *b)
{
    bool again = b->snapshot_ns && s->monotonic_ns - b->snapshot_ns < BLIND_AGAIN_NS;
    b->again = again && !b->receipts ? b->again + 1 : 0;
    b->snapshot_ns = s->monotonic_ns;
    backlog_clear(b);
    b->anew = b->wants = false;
}

static bool keeps_too_much(const service *s, const backlog *b)
{
    bool idle = s->monotonic_ns - b->moved_ns > IDLE_NS;
    if (b->bytes && memory_is_short(s)) return true;
    return b->bytes > (idle ? BACKLOG_IDLE_BYTES : BACKLOG_BYTES);
}

/* The snapshot that will come has them in it. */
static void keep_no_more(service *s, stream *to)
{
    backlog *b = &to->backlog;
    size_t kept = b->entries.count;
    while (kept > b->next && !b->entries.at[kept - 1].snapshot) kept--;
    int64_t dropped = (int64_t)(b->entries.count - kept);
    b->skipped += dropped;
    metric_count(s->count.batches_skipped, (uint64_t)dropped);
    drop_from(b, kept);
    b->anew = true;
}

static void begin_to_wait(service *s, backlog *b)
{
    if (!backlog_is_behind(b)) {
        b->moved_ns = s->monotonic_ns;
        if (!b->window) b->window = b->threshold = WINDOW_FIRST;
    }
    s->next_watch_ns = s->next_watch_ns < s->monotonic_ns + WATCH_NS ? s->next_watch_ns : s->monotonic_ns + WATCH_NS;
}

bool backlog_begin(service *s, stream *to, const world_batch *batch)
{
    backlog *b = &to->backlog;
    begin_to_wait(s, b);
    if (batch->snapshot)
        replace_by_snapshot(s, b);
    else if (!b->anew && keeps_too_much(s, b))
        keep_no_more(s, to);
    return !b->anew;
}

void backlog_skip(service *s, stream *to, int32_t parts)
{
    to->backlog.skipped += parts;
    metric_count(s->count.batches_skipped, (uint64_t)parts);
}

static backlog_entry entry_of(backlog *b, const wire_message *m)
{
    const wire_event_batch *e = &m->event_batch;
    size_t size = wire_lcm_size(m);
    uint8_t *data = base_alloc(size, 1);
    wire_lcm_encode(m, data, size);
    b->bytes += size;
    return (backlog_entry){.data = data,
        .size = size,
        .batch = e->batch,
        .tick = e->tick,
        .part = e->part,
        .parts = e->parts,
        .snapshot = e->snapshot};
}

void backlog_put(stream *to, const wire_message *m)
{
    backlog *b = &to->backlog;
    backlog_entry e = entry_of(b, m);
    array_push(&b->entries, e);
}

/* ---- a snapshot in portions ---- */

void backlog_build(service *s, stream *to, const wire_event_batch *head)
{
    backlog *b = &to->backlog;
    begin_to_wait(s, b);
    replace_by_snapshot(s, b);
    b->building = true;
    b->head = *head;
}

/* How many there will be is filled in when they are sent. */
void backlog_add_built(service *s, stream *to, wire_message *m)
{
    backlog *b = &to->backlog;
    m->event_batch.part = (int32_t)b->built.count;
    m->event_batch.parts = INT32_MAX;
    backlog_entry e = entry_of(b, m);
    array_push(&b->built, e);
    b->moved_ns = s->monotonic_ns;
}

void backlog_built(service *s, stream *to)
{
    backlog *b = &to->backlog;
    size_t parts = b->built.count, later = waiting(b);
    array_reserve(&b->built, parts + later);
    for (size_t i = 0; i < parts; i++) b->built.at[i].parts = (int32_t)parts;
    if (later) memcpy(b->built.at + parts, b->entries.at + b->first, later * sizeof *b->entries.at);
    b->entries.count = b->first = b->next = 0;
    array_reserve(&b->entries, parts + later);
    memcpy(b->entries.at, b->built.at, (parts + later) * sizeof *b->entries.at);
    b->entries.count = parts + later;
    b->built.count = 0;
    b->building = false;
    backlog_send(s, to);
}

/* ---- what goes out ---- */

/* All streams together: to encode and send so much takes some 8 ms. The rest goes in the next rounds, which follow at
 * once, the streams by turns. */
static const size_t A_ROUND_BYTES = 4 << 20;

static bool round_is_full(service *s)
{
    if (s->backlog_round_ns != s->monotonic_ns) s->backlog_sent = 0;
    s->backlog_round_ns = s->monotonic_ns;
    if (s->backlog_sent < A_ROUND_BYTES) return false;
    s->next_watch_ns = s->monotonic_ns;
    s->backlog_crowded = true;
    return true;
}

static void send_next(service *s, stream *to)
{
    backlog *b = &to->backlog;
    int32_t behind = (int32_t)(b->entries.count - b->next) + b->anew;
    const backlog_entry *e = &b->entries.at[b->next++];
    wire_message m;
    wire_refusal why;
    if (!s->backlog_memory) s->backlog_memory = wire_memory_create();
    wire_memory_reset(s->backlog_memory);
    if (wire_lcm_decode(e->data, e->size, s->backlog_memory, &m, &why) != WIRE_OK) {
        log_error("stream %s: a batch that waits cannot be read: %s", to->name, why.text);
        return;
    }
    m.event_batch.epoch = s->epoch; /* a standby that has gone may have changed it */
    m.event_batch.behind = behind;
    m.event_batch.parts = e->parts;
    to->link->ops->publish(to->link, &m);
    to->reported_ns = s->monotonic_ns;
    s->backlog_sent += e->size;
    metric_count(s->count.batches_out, 1);
}

static void want_anew(service *s, stream *to)
{
    backlog *b = &to->backlog;
    int64_t due_ns = b->snapshot_ns ? b->snapshot_ns + SNAPSHOT_PAUSE_NS : 0;
    b->anew = true;
    b->wants = s->monotonic_ns < due_ns;
    if (!b->wants)
        world_want_snapshot(s->world, (uint32_t)(to - s->streams.at));
    else if (due_ns < s->next_watch_ns)
        s->next_watch_ns = due_ns;
}

static void emptied(service *s, stream *to)
{
    backlog *b = &to->backlog;
    backlog_clear(b);
    if (b->anew)
        want_anew(s, to);
    else
        b->skipped = 0;
}

static void send_blindly(service *s, stream *to)
{
    backlog *b = &to->backlog;
    if (s->monotonic_ns >= b->due_ns && round_is_full(s)) return;
    if (s->monotonic_ns >= b->due_ns) {
        unsigned again = b->again < BLIND_AGAIN_MOST ? b->again : BLIND_AGAIN_MOST;
        for (int i = 0; i < BLIND_BURST >> again && b->next < b->entries.count; i++) send_next(s, to);
        b->due_ns = s->monotonic_ns + BLIND_PAUSE_NS;
        b->moved_ns = s->monotonic_ns;
    }
    if (b->next == b->entries.count)
        emptied(s, to);
    else if (b->due_ns < s->next_watch_ns)
        s->next_watch_ns = b->due_ns;
}

static void send_all(service *s, stream *to)
{
    backlog *b = &to->backlog;
    while (b->next < b->entries.count) send_next(s, to);
    emptied(s, to);
}

static void send_some(service *s, stream *to)
{
    backlog *b = &to->backlog;
    if (standby_waits(s) || b->building || !waiting(b)) return;
    if (to->link->ops->loses_nothing)
        send_all(s, to);
    else if (!b->receipts)
        send_blindly(s, to);
    else
        while (b->next < b->entries.count && b->next - b->first < b->window && !round_is_full(s)) send_next(s, to);
}

/* While there is more than rounds take, whoever asks first or most often goes no sooner than others. */
void backlog_send(service *s, stream *to)
{
    if (s->backlog_crowded)
        s->next_watch_ns = s->monotonic_ns;
    else
        send_some(s, to);
}

/* ---- receipts ---- */

/* What came last of a snapshot does not tell of that snapshot's batch that it came. */
static bool has_come(const backlog_entry *e, const wire_receipt *m)
{
    if (!e->snapshot) return e->batch <= m->batch;
    return e->batch < m->batch || (e->batch == m->batch && e->tick == m->tick && e->part <= m->part);
}

static bool continues(const backlog_entry *e, const wire_receipt *m)
{
    if (e->snapshot) return e->part == 0 || (e->tick == m->tick && e->batch == m->batch && e->part == m->part + 1);
    return e->batch == m->batch + 1;
}

/* Twice as many a round trip up to the last number at which something was lost, then one more. */
static void widen(backlog *b, size_t come)
{
    b->window += b->window < b->threshold || !b->lossy ? (unsigned)come : 1;
    if (b->window > WINDOW_MOST) b->window = WINDOW_MOST;
}

static void narrow(backlog *b)
{
    b->lossy = true;
    b->window = b->threshold = b->window / 2 < WINDOW_LEAST ? WINDOW_LEAST : b->window / 2;
}

static void take_what_came(service *s, stream *to, const wire_receipt *m)
{
    backlog *b = &to->backlog;
    size_t come = 0;
    for (; b->first < b->entries.count && has_come(&b->entries.at[b->first], m); b->first++, come++) {
        backlog_entry *e = &b->entries.at[b->first];
        b->bytes -= e->size;
        free(e->data);
    }
    if (b->next < b->first) b->next = b->first;
    compact(b);
    if (come) b->moved_ns = s->monotonic_ns;
    if (come) widen(b, come);
}

static void send_again(service *s, stream *to, const wire_receipt *m)
{
    backlog *b = &to->backlog;
    if (!waiting(b) || !continues(&b->entries.at[b->first], m)) {
        backlog_clear(b);
        if (!b->anew) b->moved_ns = s->monotonic_ns;
        want_anew(s, to);
        return;
    }
    if (b->next > b->first) narrow(b);
    b->next = b->first;
}

void backlog_receipt(service *s, stream *to, const wire_receipt *m)
{
    backlog *b = &to->backlog;
    bool goes_on = m->epoch != s->epoch && m->epoch < s->epoch && wire_same_line(m->epoch, s->epoch);
    if ((m->epoch != s->epoch && !goes_on) || m->sequence <= b->receipt) return;
    if (goes_on && standby_was_outrun(s, to, m->epoch, m->batch)) return;
    b->receipt = m->sequence;
    if (!b->receipts) b->window = b->threshold = WINDOW_FIRST;
    b->receipts = true;
    if (m->batch > b->received) b->received = m->batch < to->batch ? m->batch : to->batch;
    bool was = backlog_is_behind(b);
    if (b->building) return; /* what is missing is in it, or comes behind it */
    take_what_came(s, to, m);
    if (m->missing)
        send_again(s, to, m);
    else if (was && !waiting(b))
        emptied(s, to);
    backlog_send(s, to);
}

/* ---- who starves ---- */

static bool starves(const service *s, const backlog *b)
{
    if (!backlog_is_behind(b)) return b->again >= BLIND_AGAIN_MOST && s->monotonic_ns - b->snapshot_ns < BLIND_AGAIN_NS;
    return s->monotonic_ns - b->moved_ns >= STARVED_NS || b->skipped >= STARVED_SKIPPED || b->again >= BLIND_AGAIN_MOST;
}

static void describe_starving(service *s, const stream *to, char *text, size_t size)
{
    const backlog *b = &to->backlog;
    const session *c = session_find(s, to->client);
    snprintf(text, size,
        "stream %s of client %s starves: %" PRId64 " messages wait, %" PRId64
        " were skipped, nothing was read for %.1f s",
        to->name, c ? c->name : "?", backlog_count(b), b->skipped, 1e-9 * (double)(s->monotonic_ns - b->moved_ns));
}

static void log_starving(service *s, stream *to)
{
    backlog *b = &to->backlog;
    char text[sizeof s->starving];
    describe_starving(s, to, text, sizeof text);
    if (b->starves && (!b->warned_ns || s->monotonic_ns - b->warned_ns >= WARN_AGAIN_NS)) {
        log_warning("%s", text);
        b->warned_ns = s->monotonic_ns;
        b->warned = true;
    } else if (!b->starves && b->warned) {
        log_notice("stream %s is up to date again", to->name);
        b->warned = false;
    }
}

void backlog_watch(service *s)
{
    if (s->monotonic_ns < s->next_watch_ns || standby_waits(s)) return;
    char before = *s->starving;
    bool any = false;
    size_t turn = s->backlog_turn + 1;
    s->next_watch_ns = INT64_MAX;
    s->backlog_crowded = false;
    s->starving[0] = '\0';
    s->streams_behind = s->streams_starving = 0;
    for (size_t k = 0; k < s->streams.count; k++) {
        size_t i = (s->backlog_turn + k) % s->streams.count;
        stream *to = &s->streams.at[i];
        backlog *b = &to->backlog;
        if (!to->live) continue;
        if (b->wants) want_anew(s, to);
        bool was_full = round_is_full(s);
        send_some(s, to);
        if (!was_full && round_is_full(s)) turn = i + 1;
        bool now = starves(s, b);
        bool changed = now != b->starves;
        b->starves = now;
        any |= now || backlog_is_behind(b);
        s->streams_behind += backlog_is_behind(b);
        s->streams_starving += now;
        if (changed || now) log_starving(s, to);
        if (now && !*s->starving) describe_starving(s, to, s->starving, sizeof s->starving);
    }
    s->backlog_turn = turn;
    if (any && s->monotonic_ns + WATCH_NS < s->next_watch_ns) s->next_watch_ns = s->monotonic_ns + WATCH_NS;
    if (!before != !*s->starving) s->status_due = true;
    for (size_t i = 0; i < s->link_count; i++) s->links[i]->ops->flush(s->links[i]);
}
