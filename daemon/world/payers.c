/* payers: of max_pairs nobody takes what others need. Each pair is charged to the owner of its two bodies who has more
 * pairs charged to him already (of two with as many: the smaller id), so that who surrounds others with his bodies pays
 * for it. While there is a quarter left, a new pair may begin whosever it is; from then on only if its owner has fewer
 * than an equal share of that quarter. Pairs that linger are about to end, and are charged to nobody. By counts, so
 * that it follows from the commands. Tick thread. */
#include "state.h"

#include <stdlib.h>

enum { KEPT = 4, SHARES_LEAST = 16 }; /* one part in so many; it is for so many owners, at the least */

/* 0 is no key. Whose owners have the same one share a place. */
static uint64_t purse_key(uint64_t owner)
{
    return owner ? owner : UINT64_MAX;
}

static uint32_t place_of_payer(const world *w, uint64_t owner)
{
    if (w->last_payer < w->payers.count && w->payers.at[w->last_payer].pairs &&
        purse_key(w->payers.at[w->last_payer].owner) == purse_key(owner))
        return w->last_payer;
    return pair_map_get(&w->payer_of, purse_key(owner));
}

static uint32_t charged_to(const world *w, uint64_t owner)
{
    uint32_t place = place_of_payer(w, owner);
    return place == PAIR_MAP_NONE ? 0 : w->payers.at[place].pairs;
}

static uint64_t owner_of(const world *w, uint32_t collider)
{
    return w->bodies.at[w->colliders.at[collider].body].owner;
}

/* Who is to pay for the two. */
static uint64_t payer_of(const world *w, uint32_t a, uint32_t b, uint32_t *has)
{
    uint64_t x = owner_of(w, a), y = owner_of(w, b);
    uint32_t x_has = charged_to(w, x), y_has = x == y ? x_has : charged_to(w, y);
    bool first = x_has > y_has || (x_has == y_has && x <= y);
    *has = first ? x_has : y_has;
    return first ? x : y;
}

static size_t share(const world *w, size_t most)
{
    size_t of = w->payer_ids.taken + (size_t)1;
    return most / KEPT / (of > SHARES_LEAST ? of : SHARES_LEAST);
}

size_t payers_open(size_t most)
{
    return most - most / KEPT;
}

bool payers_allow(const world *w, uint32_t a, uint32_t b)
{
    size_t most = pair_most(w), pairs = w->figures.pairs - w->lingers;
    uint32_t has;
    if (pairs < payers_open(most)) return true;
    if (pairs >= most) return false;
    payer_of(w, a, b, &has);
    return has < share(w, most);
}

size_t payers_kept_for(const world *w, const body *b)
{
    size_t most = pair_most(w);
    return charged_to(w, b->owner) < share(w, most) ? most / KEPT : 0;
}

void payers_charge(world *w, pair *p)
{
    uint32_t has;
    uint64_t owner = payer_of(w, p->a, p->b, &has);
    uint32_t place = place_of_payer(w, owner);
    if (place == PAIR_MAP_NONE) {
        place = id_pool_take(&w->payer_ids);
        array_reserve(&w->payers, (size_t)place + 1);
        if (place >= w->payers.count) w->payers.count = place + 1;
        w->payers.at[place] = (payer){.owner = owner};
        pair_map_put(&w->payer_of, purse_key(owner), place);
    }
    w->payers.at[place].pairs++;
    w->last_payer = place;
    p->payer = place;
}

void payers_release(world *w, const pair *p)
{
    payer *of = &w->payers.at[p->payer];
    if (--of->pairs) return;
    pair_map_remove(&w->payer_of, purse_key(of->owner));
    id_pool_give(&w->payer_ids, p->payer);
}

void payers_restored(world *w)
{
    for (uint32_t i = 0; i < w->payers.count; i++) id_pool_take(&w->payer_ids);
    for (uint32_t i = 0; i < w->payers.count; i++)
        if (w->payers.at[i].pairs)
            pair_map_put(&w->payer_of, purse_key(w->payers.at[i].owner), i);
        else
            id_pool_give(&w->payer_ids, i);
}

const char *payers_validate(const world *w)
{
    uint32_t *pairs = base_zalloc(w->payers.count + 1, sizeof *pairs);
    const char *fault = NULL;
    for (uint32_t i = 0; i < w->pairs.count; i++) {
        const pair *p = &w->pairs.at[i];
        if (!p->used || p->lingers) continue;
        if (p->payer >= w->payers.count)
            fault = "nobody is charged for a pair";
        else
            pairs[p->payer]++;
    }
    for (uint32_t i = 0; i < w->payers.count && !fault; i++)
        if (pairs[i] != w->payers.at[i].pairs) fault = "an owner's pairs are miscounted";
    free(pairs);
    return fault;
}
