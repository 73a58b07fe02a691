/* validate: what the service keeps twice, walked in full: counts of clients, their rows of poses, streams by name.
 * Where a tick ends, in builds with asserts. Tick thread. */
#include "service.h"
#include "streams.h"

#include <string.h>

static const char *check_bodies(const session *c)
{
    size_t bodies = 0, shapes = 0;
    if (c->rows.numbers.count != c->bodies.count || c->rows.world_ids.count != c->bodies.count ||
        c->rows.sequences.count != c->bodies.count)
        return "a client has more or fewer rows of poses than bodies";
    for (uint32_t i = 0; i < c->bodies.count; i++) {
        const owned_body *b = &c->bodies.at[i];
        if (pair_map_get(&c->body_of, (uint64_t)b->number + 1) != i) return "a body is not in its client's map";
        if (c->rows.numbers.at[i] != b->number || c->rows.world_ids.at[i] != b->world_id)
            return "a row of poses is of another body";
        bodies += b->world_id != WORLD_NONE;
        shapes += b->shapes;
    }
    if (bodies != c->body_count) return "bodies of a client miscounted";
    return shapes == c->shape_count ? NULL : "shapes of a client miscounted";
}

static const char *check_subscriptions(const service *s, const session *c)
{
    size_t live = 0;
    for (uint32_t i = 0; i < c->subscriptions.count; i++) {
        const owned_subscription *own = &c->subscriptions.at[i];
        if (pair_map_get(&c->subscription_of, (uint64_t)(uint32_t)own->number + 1) != i)
            return "a subscription is not in its client's map";
        if (!own->live) continue;
        live++;
        if (own->world_id >= s->streams.count) return "a subscription has no stream";
        const stream *to = &s->streams.at[own->world_id];
        if (s->health == WIRE_HEALTH_STOPPING) continue; /* all streams end before their subscriptions */
        if (!to->live || to->client != c->client || to->subscription != own->number)
            return "the stream of a subscription is another's";
    }
    return live == c->subscription_count ? NULL : "subscriptions of a client miscounted";
}

static const char *check_backlog(const backlog *b)
{
    size_t bytes = 0;
    if (b->first > b->next || b->next > b->entries.count) return "what waits on a stream is out of order";
    for (size_t i = b->first; i < b->entries.count; i++) bytes += b->entries.at[i].size;
    for (size_t i = 0; i < b->built.count; i++) bytes += b->built.at[i].size;
    return bytes == b->bytes ? NULL : "bytes that wait on a stream miscounted";
}

/* Of several that end in one tick under one name the map has one. */
static const char *check_stream(service *s, uint32_t id)
{
    const stream *at = &s->streams.at[id];
    if (!at->live) return NULL;
    if (!at->name || !at->link) return "a stream without a name or a link";
    if (at->ending && !stream_ending(s, at->name)) return "a stream that ends is not found by its name";
    if (!at->ending && stream_named(s, at->name) != at) return "a stream is not found by its name";
    return check_backlog(&at->backlog);
}

const char *service_validate(service *s)
{
    const char *fault = NULL;
    for (uint32_t i = 0; !fault && i < s->sessions.count; i++) {
        const session *c = s->sessions.at[i];
        if (pair_map_get(&s->session_of, (uint64_t)c->client) != i) fault = "a client is not in the map";
        if (!fault) fault = check_bodies(c);
        if (!fault) fault = check_subscriptions(s, c);
    }
    for (uint32_t i = 0; !fault && i < s->streams.count; i++) fault = check_stream(s, i);
    return fault;
}
