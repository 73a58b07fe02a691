/* What clients send comes to both daemons of a pair. The standby keeps it until the journal has told that the active
 * one has applied it: by client, kind and sequence, since a client's messages of one kind come in order. What is left
 * when it takes over is applied then; copies of what was applied change nothing. Tick thread. */
#include "commands.h"
#include "standby_parts.h"
#include "streams.h"

#include "base/log.h"

#include <stdlib.h>
#include <string.h>

/* What the active one has not told of for so long, it has refused; or it was a pose that stands no more. */
#define KEPT_NS ((int64_t)5000000000)
enum { KEPT_BYTES = 64 << 20, KEPT_CLIENTS = 1 << 16 };

void kept_init(kept *k)
{
    *k = (kept){.place_of = {.count = 0}};
    pair_map_init(&k->place_of);
}

static void free_readers(kept *k)
{
    for (size_t i = 0; i < k->readers.count; i++) free(k->readers.at[i].stream);
    k->readers.count = 0;
}

void kept_free(kept *k)
{
    free_readers(k);
    array_free(&k->readers);
    array_free(&k->messages);
    array_free(&k->bytes);
    array_free(&k->clients);
    pair_map_free(&k->place_of);
}

/* Nobody has so many at a time. Those that live are heard again, or are given a lease's time when we take over. */
static void forget_clients(kept *k)
{
    log_warning("%d clients have come and gone: which of them live is forgotten", KEPT_CLIENTS);
    pair_map_free(&k->place_of);
    pair_map_init(&k->place_of);
    k->clients.count = 0;
}

static known_client *client_of(kept *k, int64_t client)
{
    uint32_t place = pair_map_get(&k->place_of, (uint64_t)client);
    if (place != PAIR_MAP_NONE) return &k->clients.at[place];
    if (k->clients.count == KEPT_CLIENTS) forget_clients(k);
    pair_map_put(&k->place_of, (uint64_t)client, (uint32_t)k->clients.count);
    array_push(&k->clients, ((known_client){.client = client}));
    return &k->clients.at[k->clients.count - 1];
}

bool kept_is_alive(const kept *k, int64_t client)
{
    uint32_t place = pair_map_get(&k->place_of, (uint64_t)client);
    return place != PAIR_MAP_NONE && k->clients.at[place].alive;
}

void kept_clear(kept *k)
{
    for (size_t i = 0; i < k->clients.count; i++)
        memset(k->clients.at[i].confirmed, 0, sizeof k->clients.at[i].confirmed);
}

/* ---- what comes ---- */

static void forget_loss(kept *k, int64_t client)
{
    for (size_t i = 0; i < k->messages.count; i++)
        if (k->messages.at[i].kind == WIRE_NOTHING && k->messages.at[i].client == client) k->messages.at[i].client = 0;
}

/* A state that is taken over later may have clients that are gone, and our links do not tell again of those, nor of
 * those that live and have nothing to say. After a loss only a Client message is a sign of life: others may come late,
 * and a link that has told of the loss tells of the next one only if the client has announced itself again. */
void kept_hear(service *s, const wire_message *m)
{
    kept *k = &s->standby->kept;
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    if (!client || k->applied) return;
    known_client *c = client_of(k, client);
    if (!c->alive) forget_loss(k, client); /* if it is dead after all, its lease runs out: standby_hears */
    if (m->kind == WIRE_CLIENT) c->alive = !m->client.removed;
}

void kept_hear_loss(service *s, int64_t client)
{
    client_of(&s->standby->kept, client)->alive = false;
}

void kept_message_came(service *s, struct link *from, const wire_message *m)
{
    kept *k = &s->standby->kept;
    kept_message e = {.link = from, .kind = m->kind, .came_ns = s->monotonic_ns, .offset = k->bytes.count};
    int32_t object;
    e.origin = from->origin;
    wire_origin(m, &e.client, &e.sequence, &object);
    if (!e.client) return; /* nobody's: refused by the active one */
    if (e.sequence <= client_of(k, e.client)->confirmed[m->kind]) return;
    e.size = wire_lcm_size(m);
    array_reserve(&k->bytes, e.offset + e.size);
    k->bytes.count += wire_lcm_encode(m, k->bytes.at + e.offset, e.size);
    array_push(&k->messages, e);
}

void kept_lost_came(service *s, struct link *from, int64_t client)
{
    kept *k = &s->standby->kept;
    array_push(&k->messages, ((kept_message){.link = from, .client = client, .came_ns = s->monotonic_ns}));
}

void kept_reader_came(service *s, struct link *from, const char *stream)
{
    array_push(&s->standby->kept.readers, ((kept_reader){base_strdup(stream), from, s->monotonic_ns}));
}

/* ---- what the journal tells ---- */

void kept_confirm(kept *k, const wire_message *m)
{
    int64_t client, sequence;
    int32_t object;
    wire_origin(m, &client, &sequence, &object);
    if (!client || sequence == STEP_IN_ITS_NAME) return;
    known_client *c = client_of(k, client);
    bool ends = m->kind == WIRE_CLIENT && m->client.removed;
    for (int kind = 0; kind < WIRE_KIND_COUNT; kind++)
        if ((ends || kind == (int)m->kind) && sequence > c->confirmed[kind]) c->confirmed[kind] = sequence;
}

void kept_confirm_lost(kept *k, int64_t client)
{
    forget_loss(k, client);
}

void kept_confirm_reader(kept *k, const char *stream)
{
    for (size_t i = k->readers.count; i-- > 0;) {
        if (strcmp(k->readers.at[i].stream, stream) != 0) continue;
        free(k->readers.at[i].stream);
        k->readers.at[i] = k->readers.at[--k->readers.count];
        return;
    }
}

static bool is_settled(const service *s, kept *k, const kept_message *e)
{
    if (!e->client || s->monotonic_ns - e->came_ns > KEPT_NS) return true;
    return e->kind != WIRE_NOTHING && e->sequence <= client_of(k, e->client)->confirmed[e->kind];
}

void kept_sweep(service *s)
{
    kept *k = &s->standby->kept;
    size_t left = 0, bytes = 0;
    for (size_t i = 0; i < k->messages.count; i++) {
        kept_message e = k->messages.at[i];
        if (is_settled(s, k, &e)) continue;
        if (e.size) memmove(k->bytes.at + bytes, k->bytes.at + e.offset, e.size);
        e.offset = bytes;
        bytes += e.size;
        k->messages.at[left++] = e;
    }
    k->messages.count = left;
    k->bytes.count = bytes;
    for (size_t i = k->readers.count; i-- > 0;) {
        const kept_reader *r = &k->readers.at[i];
        if (s->monotonic_ns - r->came_ns <= KEPT_NS || stream_lacks_reader(s, r->stream)) continue;
        free(k->readers.at[i].stream);
        k->readers.at[i] = k->readers.at[--k->readers.count];
    }
}

/* While nobody's state has come, nothing is confirmed, and what comes is kept as long as it is not too much. */
void kept_bound(service *s)
{
    if (s->standby->kept.bytes.count <= KEPT_BYTES) return;
    log_warning("more than %d MB came before the state of the active daemon: what is older than %.0f s is not kept",
        KEPT_BYTES >> 20, 1e-9 * KEPT_NS);
    kept_sweep(s);
}

/* ---- taking over ---- */

void kept_apply(service *s, const link_sink *sink, int64_t recent_ns)
{
    kept *k = &s->standby->kept;
    k->applied = true;
    for (size_t i = 0; i < k->messages.count; i++) {
        const kept_message *e = &k->messages.at[i];
        wire_message m;
        wire_refusal why;
        if (!e->client) continue;
        if (e->kind == WIRE_NOTHING) {
            sink->client_lost(sink->context, e->link, e->client);
            continue;
        }
        wire_memory_reset(s->standby->memory);
        e->link->origin = e->origin;
        e->link->unclaimed = false;
        if (wire_lcm_decode(k->bytes.at + e->offset, e->size, s->standby->memory, &m, &why) == WIRE_OK)
            sink->message(sink->context, e->link, &m);
    }
    for (size_t i = 0; i < k->readers.count; i++)
        if (k->readers.at[i].came_ns >= recent_ns || stream_lacks_reader(s, k->readers.at[i].stream))
            sink->stream_reader(sink->context, k->readers.at[i].link, k->readers.at[i].stream);
    k->messages.count = k->bytes.count = 0;
    free_readers(k);
    k->applied = false;
}
