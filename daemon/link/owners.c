/* owners: three lists with a map each; the last entry takes the place of one that goes. */
#include "owners.h"

#include <stdlib.h>

void owners_init(owners *o, size_t most)
{
    *o = (owners){.most = most};
    pair_map_init(&o->writer_of);
    pair_map_init(&o->participant_of);
    pair_map_init(&o->claim_of);
}

void owners_free(owners *o)
{
    pair_map_free(&o->writer_of);
    pair_map_free(&o->participant_of);
    pair_map_free(&o->claim_of);
    array_free(&o->writers);
    array_free(&o->participants);
    array_free(&o->claims);
}

static owners_writer *writer_at(const owners *o, uint64_t handle)
{
    uint32_t i = handle ? pair_map_get(&o->writer_of, handle) : PAIR_MAP_NONE;
    return i == PAIR_MAP_NONE ? NULL : &o->writers.at[i];
}

static owners_participant *participant_at(const owners *o, uint64_t handle)
{
    uint32_t i = pair_map_get(&o->participant_of, handle);
    return i == PAIR_MAP_NONE ? NULL : &o->participants.at[i];
}

static owners_claim *claim_at(const owners *o, uint64_t client)
{
    uint32_t i = client ? pair_map_get(&o->claim_of, client) : PAIR_MAP_NONE;
    return i == PAIR_MAP_NONE ? NULL : &o->claims.at[i];
}

static bool participant_is_alive(const owners *o, uint64_t participant)
{
    const owners_participant *p = participant_at(o, participant);
    return p && p->writers && (!p->has_announced || p->announcing);
}

/* ---- writers ---- */

bool owners_knows(const owners *o, uint64_t writer)
{
    return writer_at(o, writer) != NULL;
}

uint64_t owners_participant_of(const owners *o, uint64_t writer)
{
    const owners_writer *w = writer_at(o, writer);
    return w ? w->participant : 0;
}

void owners_come(owners *o, uint64_t writer, uint64_t participant, bool announces)
{
    if (!writer || !participant || owners_knows(o, writer)) return;
    pair_map_put(&o->writer_of, writer, (uint32_t)o->writers.count);
    array_push(&o->writers, ((owners_writer){writer, participant, announces, true}));
    owners_participant *p = participant_at(o, participant);
    if (!p) {
        pair_map_put(&o->participant_of, participant, (uint32_t)o->participants.count);
        array_push(&o->participants, ((owners_participant){.handle = participant}));
        p = &o->participants.at[o->participants.count - 1];
    }
    p->writers++;
    p->announcing += announces;
    p->has_announced |= announces;
}

void owners_put_in_group(owners *o, uint64_t writer, int group)
{
    const owners_writer *w = writer_at(o, writer);
    if (w) participant_at(o, w->participant)->group = group;
}

int owners_group(const owners *o, int64_t client)
{
    const owners_claim *c = claim_at(o, (uint64_t)client);
    const owners_participant *p = c ? participant_at(o, c->participant) : NULL;
    return p ? p->group : 0;
}

uint64_t owners_participant_for(const owners *o, int64_t client)
{
    const owners_claim *c = claim_at(o, (uint64_t)client);
    return c ? c->participant : 0;
}

static void drop_participant(owners *o, const owners_participant *p)
{
    uint32_t place = pair_map_remove(&o->participant_of, p->handle);
    owners_participant last = o->participants.at[--o->participants.count];
    if (place == o->participants.count) return;
    o->participants.at[place] = last;
    pair_map_put(&o->participant_of, last.handle, place);
}

void owners_liveliness(owners *o, uint64_t writer, bool alive)
{
    owners_writer *w = writer_at(o, writer);
    if (!w || !w->announces || w->alive == alive) return;
    owners_participant *p = participant_at(o, w->participant);
    w->alive = alive;
    p->announcing += alive ? 1u : UINT32_MAX; /* one more, or one less */
    o->changed = true;
}

void owners_go(owners *o, uint64_t writer)
{
    const owners_writer *w = writer_at(o, writer);
    if (!w) return;
    owners_participant *p = participant_at(o, w->participant);
    p->announcing -= w->announces && w->alive;
    if (--p->writers == 0) drop_participant(o, p);
    uint32_t place = pair_map_remove(&o->writer_of, writer);
    owners_writer last = o->writers.at[--o->writers.count];
    o->changed = true;
    if (place == o->writers.count) return;
    o->writers.at[place] = last;
    pair_map_put(&o->writer_of, last.handle, place);
}

/* ---- clients ---- */

static void count_claim(owners *o, uint64_t participant, int more)
{
    owners_participant *p = participant_at(o, participant); /* NULL: gone */
    if (p) p->claims += (size_t)more;
}

owners_verdict owners_admit(owners *o, uint64_t writer, int64_t client, bool announces)
{
    uint64_t key = (uint64_t)client;
    const owners_writer *w = writer_at(o, writer);
    owners_claim *c = claim_at(o, key);
    if (!key) return OWNERS_YES; /* nobody's name: refused elsewhere */
    if (!w) return !c || !participant_is_alive(o, c->participant) ? OWNERS_YES : OWNERS_NOT_YOURS;
    if (!c && o->claims.count >= o->most) return OWNERS_FULL;
    if (!c && o->each && participant_at(o, w->participant)->claims >= o->each) return OWNERS_SHARE;
    if (!c) {
        participant_at(o, w->participant)->claims++;
        pair_map_put(&o->claim_of, key, (uint32_t)o->claims.count);
        array_push(&o->claims, ((owners_claim){key, w->participant, announces}));
        o->changed |= !participant_is_alive(o, w->participant);
        return OWNERS_YES;
    }
    if (c->participant != w->participant) {
        if (participant_is_alive(o, c->participant)) return OWNERS_NOT_YOURS;
        count_claim(o, c->participant, -1);
        count_claim(o, w->participant, 1);
        *c = (owners_claim){key, w->participant, false};
    }
    c->announced |= announces;
    return OWNERS_YES;
}

void owners_release(owners *o, int64_t client)
{
    if (!claim_at(o, (uint64_t)client)) return;
    count_claim(o, claim_at(o, (uint64_t)client)->participant, -1);
    uint32_t place = pair_map_remove(&o->claim_of, (uint64_t)client);
    owners_claim last = o->claims.at[--o->claims.count];
    if (o->left > o->claims.count) o->left = o->claims.count;
    if (place == o->claims.count) return;
    o->claims.at[place] = last;
    pair_map_put(&o->claim_of, last.client, place);
}

/* From the last to the first, and on from there at the next call: what takes the place of a claim that goes has been
 * looked at, unless something changed meanwhile, and then all are looked at again. */
bool owners_lost(owners *o, int64_t *client)
{
    if (o->changed) o->left = o->claims.count;
    o->changed = false;
    while (o->left > 0) {
        owners_claim c = o->claims.at[--o->left];
        if (participant_is_alive(o, c.participant)) continue;
        owners_release(o, (int64_t)c.client);
        *client = (int64_t)c.client;
        if (c.announced) return true;
    }
    return false;
}
