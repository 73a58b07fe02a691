/* settle: which pairs end and begin when proxies have new boxes or filters. Tick thread, inside broad_update.
 *
 * Nobody asks a table whether two proxies are a pair. Two whose boxes met before (and not both were fixed), and whose
 * filters did not change, are what they were: a pair, or refused. Two that did not meet before are no pair. Only around
 * a proxy that was refiltered the existing pairs matter: they are marked before the search. */
#include "state.h"

static void end_pair(broad *b, uint32_t id, uint32_t link)
{
    uint32_t other = pairs_other(&b->pairs, link);
    array_push(&b->ended, pair_key(id, other));
    pairs_end(&b->pairs, link);
}

void broad_end_all_pairs(broad *b, uint32_t id)
{
    for (uint32_t link; (link = pairs_first(&b->pairs, id)) != PAIRS_NO_LINK;) end_pair(b, id, link);
}

bool broad_accepts(const broad *b, uint32_t x, uint32_t y)
{
    return x < y ? b->filter(b->filter_context, x, y) : b->filter(b->filter_context, y, x);
}

static void end_parted_pairs(broad *b, const change *c)
{
    const proxy *p = &b->proxies.at[c->proxy];
    for (uint32_t next, link = pairs_first(&b->pairs, c->proxy); link != PAIRS_NO_LINK; link = next) {
        next = pairs_next(&b->pairs, link);
        uint32_t other = pairs_other(&b->pairs, link);
        const proxy *q = &b->proxies.at[other];
        bool stays =
            may_pair(&p->fat, p->fixed, &q->fat, q->fixed) && (!c->refilter || broad_accepts(b, c->proxy, other));
        if (!stays) end_pair(b, c->proxy, link);
    }
}

/* ---- marks: the partners of a proxy that was refiltered ---- */

void broad_mark_partners(broad *b, uint32_t id)
{
    array_reserve(&b->marks, b->proxies.count);
    while (b->marks.count < b->proxies.count) b->marks.at[b->marks.count++] = 0;
    if (++b->mark == 0) { /* all numbers were used */
        for (size_t i = 0; i < b->marks.count; i++) b->marks.at[i] = 0;
        b->mark = 1;
    }
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        b->marks.at[pairs_other(&b->pairs, link)] = b->mark;
}

/* ---- meetings ---- */

static void begin_pair(broad *b, uint32_t x, uint32_t y)
{
    b->spent += UNITS_ASKED + broad_price_of(b, x, y);
    if (b->spent > b->limit || !broad_accepts(b, x, y)) return;
    b->spent += UNITS_BEGUN;
    pairs_begin(&b->pairs, x, y);
    array_push(&b->began, pair_key(x, y));
}

typedef struct meeting {
    broad *b;
    const change *c;
} meeting;

/* Of two proxies of which both could ask, one does: the refiltered one, else the one of lower id. */
static bool other_asks(const change *c, const change *d)
{
    if (!d->asks || !(d->put || d->refilter)) return false;
    if (c->refilter != d->refilter) return d->refilter;
    return !c->asks || d->proxy < c->proxy;
}

static bool met_before(const change *c, const proxy *q, const change *d)
{
    if (!c->was) return false;
    if (!d) return may_pair(&c->old, c->was_fixed, &q->fat, q->fixed);
    return d->was && may_pair(&c->old, c->was_fixed, &d->old, d->was_fixed);
}

static bool meet(void *context, uint32_t other)
{
    const meeting *m = context;
    broad *b = m->b;
    const change *c = m->c;
    const proxy *q = &b->proxies.at[other];
    const change *d = q->pending == NOTHING_PENDING ? NULL : &b->pending.at[q->pending];
    bool both_fixed = q->fixed && b->proxies.at[c->proxy].fixed;
    if (other == c->proxy || both_fixed) return true;
    if (b->all_ask) b->spent += UNITS_A_CANDIDATE;
    if (!q->passive && !(d && other_asks(c, d))) {
        bool known = c->refilter ? b->marks.at[other] == b->mark : met_before(c, q, d);
        if (!known) begin_pair(b, c->proxy, other);
    }
    return b->spent <= b->limit;
}

static void begin_new_pairs(broad *b, const change *c)
{
    const proxy *p = &b->proxies.at[c->proxy];
    meeting m = {b, c};
    if (p->passive) return;
    if (c->refilter) broad_mark_partners(b, c->proxy);
    if (c->asks) b->index->around(b, c->proxy, meet, &m);
    for (size_t i = 0; i < b->unbounded.count; i++) {
        const proxy *q = &b->proxies.at[b->unbounded.at[i]];
        if (may_pair(&p->fat, p->fixed, &q->fat, q->fixed) && !meet(&m, b->unbounded.at[i])) return;
    }
}

/* ---- what takes too long is put off ----
 *
 * Whether it does must be the same for each index and in each order, so it follows from sums over what changed: the
 * pairs that there are around it, those that part, those that meet, and if there may be too many of them, all
 * candidates (then each index is asked around each proxy). */

bool broad_must_ask(const broad *b)
{
    /* Not b->proxies.count: how many there have ever been is not known to a world that was restored. */
    size_t candidates = b->proxy_count + b->pending.count;
    return b->unsearched || b->pending.count * candidates > b->limit / UNITS_A_CANDIDATE;
}

static uint64_t count_parted(const broad *b, uint64_t most)
{
    uint64_t parted = 0;
    for (size_t i = 0; i < b->unsettled.count && parted <= most; i++) {
        uint32_t id = b->pending.at[b->unsettled.at[i]].proxy;
        const proxy *p = &b->proxies.at[id];
        for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link)) {
            const proxy *q = &b->proxies.at[pairs_other(&b->pairs, link)];
            parted += !may_pair(&p->fat, p->fixed, &q->fat, q->fixed);
        }
    }
    return parted;
}

static uint64_t price_of_pairs(const broad *b, uint32_t id)
{
    uint64_t sum = 0;
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        sum += broad_price_of(b, id, pairs_other(&b->pairs, link));
    return sum;
}

/* Those that a filter refuses now count as those that part; how many they are is not known before it is asked. */
static bool may_end_parted(broad *b)
{
    uint64_t pairs = 0, asked = 0, dear = 0;
    for (size_t i = 0; i < b->unsettled.count; i++) {
        const change *c = &b->pending.at[b->unsettled.at[i]];
        uint32_t of = pairs_of(&b->pairs, c->proxy);
        pairs += of;
        asked += c->refilter ? of : 0;
        dear += c->refilter && b->price ? price_of_pairs(b, c->proxy) : 0;
    }
    b->spent = UNITS_A_PAIR_KEPT * pairs + (UNITS_ASKED + UNITS_ENDED) * asked + dear;
    if (b->spent + UNITS_ENDED * pairs <= b->limit) return true;
    if (b->spent > b->limit) return false;
    b->spent += UNITS_ENDED * count_parted(b, b->limit / UNITS_ENDED);
    return b->spent <= b->limit;
}

/* The newest first, so that each stands first in the lists of both. */
static void take_back_begun(broad *b)
{
    while (b->began.count > 0) {
        uint64_t key = b->began.at[--b->began.count];
        pairs_end(&b->pairs, pairs_first(&b->pairs, (uint32_t)(key >> 32)));
    }
}

static void put_off(broad *b)
{
    take_back_begun(b);
    b->put_off = true;
    for (size_t i = 0; i < b->unsettled.count; i++) {
        const change *c = &b->pending.at[b->unsettled.at[i]];
        broad_take_searched(b, c->proxy, false, c->refilter);
    }
}

void broad_settle(broad *b)
{
    b->spent = 0;
    b->put_off = false;
    if (b->unsearched || b->limit == 0 || b->pairs.count >= b->most_pairs || !may_end_parted(b)) {
        if (b->unsettled.count) put_off(b);
        return;
    }
    for (size_t i = 0; i < b->unsettled.count; i++) end_parted_pairs(b, &b->pending.at[b->unsettled.at[i]]);
    for (size_t i = 0; i < b->unsettled.count && b->spent <= b->limit; i++)
        begin_new_pairs(b, &b->pending.at[b->unsettled.at[i]]);
    for (size_t i = 0; i < b->met.count && b->spent <= b->limit; i++) {
        uint32_t x = (uint32_t)(b->met.at[i] >> 32), y = (uint32_t)b->met.at[i];
        if (!b->proxies.at[x].passive && !b->proxies.at[y].passive) begin_pair(b, x, y);
    }
    bool many = b->began.count && b->pairs.count > b->most_pairs;
    if (b->spent > b->limit || many) put_off(b);
}
