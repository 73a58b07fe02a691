/* inbox: the commands of one tick. A network has no call order, so one is made: by (client, sequence). Poses of known
 * bodies do not wait here: the newest sequence wins, whatever order they come in. Tick thread. */
#include "service.h"
#include "standby.h"

#include <stdlib.h>
#include <string.h>

void inbox_put(service *s, struct link *from, const wire_message *m)
{
    int32_t object;
    letter l = {.link = from, .kind = m->kind, .offset = s->inbox.bytes.count, .size = wire_lcm_size(m), .since_ns = 0};
    wire_origin(m, &l.client, &l.sequence, &object);
    l.takes_back = m->kind == WIRE_GEOMETRY && m->geometry.removed;
    array_reserve(&s->inbox.bytes, l.offset + l.size);
    s->inbox.bytes.count += wire_lcm_encode(m, s->inbox.bytes.at + l.offset, l.size);
    array_push(&s->inbox.letters, l);
    session *c = session_find(s, l.client);
    if (c && m->kind != WIRE_QUERY && m->kind != WIRE_POSE_BATCH) c->letters_tick = s->tick;
}

/* The loss of a client comes behind what it said before, live as in a replay. */
void inbox_put_lost(service *s, struct link *from, int64_t client)
{
    record_lost(s, client);
    standby_journal_lost(s, from, client);
    letter l = {.link = from, .kind = WIRE_CLIENT, .client = client, .offset = s->inbox.bytes.count};
    for (size_t i = 0; i < s->inbox.letters.count; i++) {
        const letter *other = &s->inbox.letters.at[i];
        if (other->client == client && other->sequence > l.sequence) l.sequence = other->sequence;
    }
    array_reserve(&s->inbox.bytes, l.offset + 1);
    s->inbox.bytes.at[s->inbox.bytes.count++] = 0; /* so that its offset is its own */
    array_push(&s->inbox.letters, l);
}

static int compare(const void *a, const void *b)
{
    const letter *x = a, *y = b;
    if (x->client != y->client) return x->client < y->client ? -1 : 1;
    if (x->sequence != y->sequence) return x->sequence < y->sequence ? -1 : 1;
    return (x->offset > y->offset) - (x->offset < y->offset);
}

static bool open_letter(service *s, const letter *l, wire_message *m)
{
    wire_refusal why;
    wire_memory_reset(s->inbox.memory);
    if (wire_lcm_decode(s->inbox.bytes.at + l->offset, l->size, s->inbox.memory, m, &why) == WIRE_OK) return true;
    apply_reject(s, l->link, l->kind, l->client, l->sequence, -1, &why);
    return false;
}

/* One command: true if it is done with. A letter without a time came in this tick. */
static bool apply_letter(service *s, letter *l)
{
    wire_message m;
    if (!l->size) {
        session *c = session_find(s, l->client);
        if (c && c->link == l->link)
            session_lost(s, c, c->link->ops->has_liveliness ? "its liveliness ended" : "its lease ran out");
        return true;
    }
    bool time_is_up = l->since_ns && s->monotonic_ns - l->since_ns >= HULL_WAIT_NS;
    if (l->since_ns && !s->hull_came && !time_is_up) return false; /* nothing has changed for it */
    if (!open_letter(s, l, &m)) return true;
    if (!l->since_ns) l->since_ns = s->monotonic_ns;
    suspect_begin(s, &m);
    bool done = apply_command(s, l->link, &m, !time_is_up);
    suspect_end(s);
    return done;
}

/* What a client takes back stays for those of its bodies that it has announced before. */
static void apply_geometries(service *s)
{
    inbox *in = &s->inbox;
    int64_t has_bodies = 0; /* a client, before the letter that is looked at */
    for (size_t i = 0; i < in->letters.count; i++) {
        letter *l = &in->letters.at[i];
        if (l->kind == WIRE_BODY) has_bodies = l->client;
        if (l->kind != WIRE_GEOMETRY || (l->takes_back && l->client == has_bodies)) continue;
        if (apply_letter(s, l)) l->kind = WIRE_NOTHING;
    }
}

/* Hulls first, then the other commands, then poses that came with them or before their bodies. Queries stay until the
 * tick is over, commands that wait for a hull until it comes or their time is up. */
void inbox_apply(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    if (in->letters.count) qsort(in->letters.at, in->letters.count, sizeof *in->letters.at, compare);
    apply_geometries(s);
    for (size_t i = 0; i < in->letters.count; i++) {
        letter *l = &in->letters.at[i];
        if (l->kind != WIRE_NOTHING && l->kind != WIRE_POSE_BATCH && l->kind != WIRE_QUERY && apply_letter(s, l))
            l->kind = WIRE_NOTHING;
    }
    for (size_t i = 0; i < in->letters.count; i++) {
        letter *l = &in->letters.at[i];
        if (l->kind != WIRE_POSE_BATCH) continue;
        if (open_letter(s, l, &m)) apply_poses(s, l->link, &m.pose_batch, false);
        l->kind = WIRE_NOTHING;
    }
    s->hull_came = false;
    steps_complete(s);
}

static void keep_waiting(inbox *in)
{
    ARRAY(uint8_t) bytes = {0};
    size_t kept = 0;
    for (size_t i = 0; i < in->letters.count; i++) {
        letter l = in->letters.at[i];
        if (l.kind == WIRE_NOTHING) continue;
        array_reserve(&bytes, bytes.count + l.size);
        memcpy(bytes.at + bytes.count, in->bytes.at + l.offset, l.size);
        l.offset = bytes.count;
        bytes.count += l.size;
        in->letters.at[kept++] = l;
    }
    in->letters.count = in->waiting = kept;
    if (bytes.count) memcpy(in->bytes.at, bytes.at, bytes.count);
    in->bytes.count = bytes.count;
    array_free(&bytes);
}

void inbox_answer(service *s)
{
    inbox *in = &s->inbox;
    wire_message m;
    bool some_wait = false;
    for (size_t i = 0; i < in->letters.count; i++) {
        letter *l = &in->letters.at[i];
        if (l->kind == WIRE_QUERY) {
            if (open_letter(s, l, &m)) {
                suspect_begin(s, &m);
                answer_query(s, l->link, &m.query);
                suspect_end(s);
            }
            l->kind = WIRE_NOTHING;
        }
        some_wait |= l->kind != WIRE_NOTHING;
    }
    if (some_wait)
        keep_waiting(in);
    else
        in->letters.count = in->bytes.count = in->waiting = 0;
}
