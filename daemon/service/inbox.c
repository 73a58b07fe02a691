/* inbox: the commands of one tick. A network has no call order, so one is made: by (client, sequence). Poses of known
 * bodies do not wait here: the newest sequence wins, whatever order they come in. Tick thread. */
#include "clients.h"
#include "commands.h"
#include "geometries.h"
#include "recordings.h"
#include "service.h"
#include "shares.h"
#include "standby.h"
#include "suspect.h"

#include "base/clock.h"

#include <stdlib.h>
#include <string.h>

void inbox_put(service *s, struct link *from, const wire_message *m)
{
    int32_t object;
    command l = {
        .link = from, .kind = m->kind, .offset = s->inbox.bytes.count, .size = wire_lcm_size(m), .since_ns = 0};
    wire_origin(m, &l.client, &l.sequence, &object);
    l.origin = from->origin;
    l.takes_back = m->kind == WIRE_GEOMETRY && m->geometry.removed;
    array_reserve(&s->inbox.bytes, l.offset + l.size);
    s->inbox.bytes.count += wire_lcm_encode(m, s->inbox.bytes.at + l.offset, l.size);
    array_push(&s->inbox.commands, l);
    session *c = session_find(s, l.client);
    if (c && m->kind != WIRE_QUERY && m->kind != WIRE_POSE_BATCH) c->commands_tick = s->tick;
}

/* The loss of a client comes behind what it said before, live as in a replay. */
void inbox_put_lost(service *s, struct link *from, int64_t client)
{
    shares_forget(s, client);
    record_lost(s, client);
    standby_journal_lost(s, from, client);
    command l = {.link = from, .kind = WIRE_CLIENT, .client = client, .offset = s->inbox.bytes.count};
    for (size_t i = 0; i < s->inbox.commands.count; i++) {
        const command *other = &s->inbox.commands.at[i];
        if (other->client == client && other->sequence > l.sequence) l.sequence = other->sequence;
    }
    array_reserve(&s->inbox.bytes, l.offset + 1);
    s->inbox.bytes.at[s->inbox.bytes.count++] = 0; /* so that its offset is its own */
    array_push(&s->inbox.commands, l);
}

static int compare_commands(const void *a, const void *b)
{
    const command *x = a, *y = b;
    if (x->client != y->client) return x->client < y->client ? -1 : 1;
    if (x->sequence != y->sequence) return x->sequence < y->sequence ? -1 : 1;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

static bool open_command(service *s, const command *l, wire_message *m)
{
    wire_refusal why;
    wire_memory_reset(s->inbox.memory);
    if (wire_lcm_decode(s->inbox.bytes.at + l->offset, l->size, s->inbox.memory, m, &why) == WIRE_OK) return true;
    apply_reject(s, l->link, l->kind, l->client, l->sequence, -1, &why);
    return false;
}

/* One command. A command without a time came in this tick. */
static void apply_queued(service *s, command *l)
{
    wire_message m;
    if (!l->size) {
        session *c = session_find(s, l->client);
        if (c && c->link == l->link)
            session_lost(s, c, c->link->ops->has_liveliness ? "its liveliness ended" : "its lease ran out");
        return;
    }
    bool time_is_up = l->since_ns && s->monotonic_ns - l->since_ns >= HULL_WAIT_NS;
    if (!open_command(s, l, &m)) return;
    if (!l->since_ns) l->since_ns = s->monotonic_ns;
    s->carried.has_waited = l->has_waited;
    s->carried.pose = l->pose ? s->inbox.poses.at[l->pose - 1] : (kept_pose){.sequence = 0};
    suspect_begin(s, &m);
    bool done = apply_command(s, l->link, &m, !time_is_up);
    suspect_end(s);
    if (!done) pending_put(s, l, &m.body);
}

/* What a client takes back stays for those of its bodies that it has announced before. */
static void apply_geometries(service *s)
{
    inbox *in = &s->inbox;
    int64_t has_bodies = 0; /* a client, before the command that is looked at */
    const session *c;
    for (size_t i = 0; i < in->commands.count; i++) {
        command *l = &in->commands.at[i];
        if (l->kind == WIRE_BODY) has_bodies = l->client;
        if (l->kind != WIRE_GEOMETRY || (l->takes_back && l->client == has_bodies)) continue;
        if (l->takes_back && (c = session_find(s, l->client)) != NULL && c->pending_count) continue;
        apply_queued(s, l);
        l->kind = WIRE_NOTHING;
    }
}

static void sort_commands(inbox *in)
{
    if (in->commands.count) qsort(in->commands.at, in->commands.count, sizeof *in->commands.at, compare_commands);
}

/* Hulls first, then the other commands, with those that have waited for a hull (pending.c) in their order, then poses
 * that came with them or before their bodies. Queries stay until the tick is over. */
void inbox_apply(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    in->effort = 0;
    geometry_builds_end(s);
    sort_commands(in);
    apply_geometries(s);
    if (pending_wake(s)) sort_commands(in);
    for (size_t i = 0; i < in->commands.count; i++) {
        command *l = &in->commands.at[i];
        if (l->kind == WIRE_NOTHING || l->kind == WIRE_POSE_BATCH || l->kind == WIRE_QUERY) continue;
        apply_queued(s, l);
        l->kind = WIRE_NOTHING;
    }
    for (size_t i = 0; i < in->commands.count; i++) {
        command *l = &in->commands.at[i];
        if (l->kind != WIRE_POSE_BATCH) continue;
        if (open_command(s, l, &m)) apply_poses(s, l->link, &m.pose_batch, false);
        l->kind = WIRE_NOTHING;
    }
    s->hull_came = s->pending_left;
    pending_tidy(s);
    s->reported_builds.count = 0;
    geometry_let_go(s);
    steps_complete(s);
}

static const int64_t ANSWERS_NS = 10000000; /* of a tick; what is not answered then comes first in the next */

/* In the order in which they came, so that it is their turn who were late in the last tick. The first that is not
 * answered. A purse pays for what its query took of a processor: that others had the processor meanwhile is not its. */
static size_t answer_queries(service *s, const command *queries, size_t count)
{
    int64_t began_ns = clock_monotonic_ns(), now_ns = began_ns;
    size_t i = 0;
    for (; i < count && (now_ns - began_ns < ANSWERS_NS || s->replaying); i++) {
        wire_message m;
        const command *l = &queries[i];
        int64_t before_ns = clock_thread_ns();
        if (!open_command(s, l, &m)) continue;
        suspect_begin(s, &m);
        answer_query(s, l->link, &m.query);
        suspect_end(s);
        now_ns = clock_monotonic_ns();
        shares_answered(s, l, &m, clock_thread_ns() - before_ns);
    }
    return i;
}

static int compare_offsets(const void *a, const void *b)
{
    const command *x = a, *y = b;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

void inbox_answer(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    ARRAY(command) queries = {0};
    for (size_t i = 0; i < in->commands.count; i++)
        if (in->commands.at[i].kind == WIRE_QUERY) array_push(&queries, in->commands.at[i]);
    if (queries.count > 1) qsort(queries.at, queries.count, sizeof *queries.at, compare_offsets);
    size_t answered = answer_queries(s, queries.at, queries.count);
    for (size_t i = queries.count; i-- > answered;)
        if (open_command(s, &queries.at[i], &m)) shares_defer(s, &queries.at[i], &m);
    array_free(&queries);
    in->commands.count = in->bytes.count = in->poses.count = 0;
}
