/* slices: what an update has put off, proxy by proxy. Tick thread.
 *
 * A search knows nothing of what was before: it holds the pairs that a proxy has against those that it should have. So
 * it does not matter how often the boxes have moved since it was put off, nor which of two unsearched proxies comes
 * first. Candidates are taken by rising ids, so each index brings the same. */
#include "state.h"

#include "base/sort.h"

/* In spite of the units, or a large search would not end: pairs ended and begun, each, and a part of those to be. */
enum { SOME_AT_LEAST = 64, PART_AT_LEAST = 128 };
/* Around a proxy with so many candidates all proxies are gone through by their ids: a walk of the index has to be
 * sorted each time that the search goes on, and finds each of them far away in memory from the one before. */
enum { MANY_CANDIDATES = 32768 };

void broad_set_limit(broad *b, uint64_t units, size_t most_pairs)
{
    b->limit = units;
    b->most_pairs = most_pairs;
}

bool broad_is_unsearched(const broad *b, uint32_t id)
{
    return id < b->proxies.count && b->proxies.at[id].unsearched;
}

bool broad_was_refiltered(const broad *b, uint32_t id)
{
    return b->proxies.at[id].refiltered;
}

size_t broad_unsearched_count(const broad *b)
{
    return b->unsearched;
}

bool broad_was_put_off(const broad *b)
{
    return b->put_off;
}

uint32_t broad_pairs_of(const broad *b, uint32_t id)
{
    return pairs_of(&b->pairs, id);
}

void broad_each_number_of(
    broad *b, uint32_t id, void (*visit)(void *context, uint32_t other, uint32_t *number), void *context)
{
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        visit(context, pairs_other(&b->pairs, link), &b->pairs.records.at[link >> 1].number);
}

void broad_fetch_numbers_of(const broad *b, uint32_t id)
{
    uint32_t link = pairs_first(&b->pairs, id);
    if (link != PAIRS_NO_LINK) __builtin_prefetch(&b->pairs.records.at[link >> 1]);
}

/* ---- where asking has a price ----
 *
 * Then those that are refused take a share of the units, too, and a search goes on behind the last that it has asked:
 * first its partners by rising ids (1 and up), if it was refiltered, then its candidates (2^32 and up). What comes to
 * be one of them meanwhile is unsearched itself, and finds it. */

void broad_set_price(broad *b, broad_price *price)
{
    b->price = price;
}

uint64_t broad_asked_until(const broad *b, uint32_t id)
{
    return id < b->asked.count ? b->asked.at[id] : 0;
}

void broad_take_asked(broad *b, uint32_t id, uint64_t until)
{
    if (id >= b->asked.count && !until) return;
    array_reserve(&b->asked, (size_t)id + 1);
    while (b->asked.count <= id) b->asked.at[b->asked.count++] = 0;
    b->asked.at[id] = until;
}

static const uint64_t CANDIDATES = (uint64_t)1 << 32;

uint64_t broad_price_of(const broad *b, uint32_t x, uint32_t y)
{
    if (!b->price) return 0;
    return x < y ? b->price(b->filter_context, x, y) : b->price(b->filter_context, y, x);
}

static void sort_found(broad *b, key_array *keys)
{
    array_reserve(&b->scratch, keys->count);
    sort_keys(keys->at, b->scratch.at, keys->count);
}

/* False: the units do not reach for all. */
static bool ask_partners(broad *b, uint32_t id, uint64_t units)
{
    const proxy *p = &b->proxies.at[id];
    uint64_t until = broad_asked_until(b, id);
    b->met.count = 0;
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        array_push(&b->met, (uint64_t)pairs_other(&b->pairs, link) << 32 | link);
    sort_found(b, &b->met);
    for (size_t i = 0, asked = 0; i < b->met.count; i++) {
        uint32_t other = (uint32_t)(b->met.at[i] >> 32);
        const proxy *q = &b->proxies.at[other];
        if (other + (uint64_t)1 <= until) continue;
        if (asked++ && b->spent >= units) return false;
        b->spent += UNITS_A_PAIR_KEPT + UNITS_ASKED + broad_price_of(b, id, other);
        broad_take_asked(b, id, other + (uint64_t)1);
        if (may_pair(&p->fat, p->fixed, &q->fat, q->fixed) && broad_accepts(b, id, other)) continue;
        array_push(&b->ended, pair_key(id, other));
        pairs_end(&b->pairs, (uint32_t)b->met.at[i]);
        b->spent += UNITS_ENDED;
    }
    broad_take_asked(b, id, CANDIDATES);
    return true;
}

/* ---- what is unsearched ---- */

void broad_take_searched(broad *b, uint32_t id, bool searched, bool refiltered)
{
    proxy *p = &b->proxies.at[id];
    broad_take_asked(b, id, 0);
    b->unsearched = b->unsearched - p->unsearched + !searched;
    p->unsearched = !searched;
    p->refiltered = !searched && (p->refiltered || refiltered);
}

void broad_forget_put_off(broad *b, uint32_t id)
{
    broad_take_searched(b, id, true, false);
}

/* ---- a search ---- */

static bool goes_on(const broad *b, uint64_t units, size_t done, size_t of)
{
    return b->spent < units || done < SOME_AT_LEAST || done < of / PART_AT_LEAST;
}

/* The partners of those that part, in `met`, with their links; false: not all of them were ended. */
static bool end_parted(broad *b, uint32_t id, uint64_t units)
{
    const proxy *p = &b->proxies.at[id];
    if (b->price && p->refiltered && broad_asked_until(b, id) < CANDIDATES) return ask_partners(b, id, units);
    bool ask = p->refiltered && broad_asked_until(b, id) < CANDIDATES;
    b->met.count = 0;
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link)) {
        uint32_t other = pairs_other(&b->pairs, link);
        const proxy *q = &b->proxies.at[other];
        b->spent += (uint64_t)(UNITS_A_PAIR_KEPT + (ask ? UNITS_ASKED : 0));
        bool stays = may_pair(&p->fat, p->fixed, &q->fat, q->fixed) && (!ask || broad_accepts(b, id, other));
        if (!stays) array_push(&b->met, (uint64_t)other << 32 | link);
    }
    sort_found(b, &b->met);
    size_t done = 0;
    for (; done < b->met.count && goes_on(b, units, done, b->met.count); done++) {
        array_push(&b->ended, pair_key(id, (uint32_t)(b->met.at[done] >> 32)));
        pairs_end(&b->pairs, (uint32_t)b->met.at[done]);
        b->spent += UNITS_ENDED;
    }
    return done == b->met.count;
}

typedef struct hunt {
    broad *b;
    uint32_t id;
    broad_leave *is_left;
    void *context;
} hunt;

static bool is_candidate(const hunt *h, uint32_t other)
{
    broad *b = h->b;
    const proxy *q = &b->proxies.at[other];
    bool is_left = q->unsearched && h->is_left && h->is_left(h->context, other);
    return !q->passive && !is_left && b->marks.at[other] != b->mark;
}

/* False: there are too many. */
static bool gather(void *context, uint32_t other)
{
    const hunt *h = context;
    broad *b = h->b;
    if (other == h->id || (b->proxies.at[h->id].fixed && b->proxies.at[other].fixed)) return true;
    array_push(&b->met, other);
    return b->met.count < MANY_CANDIDATES;
}

static void gather_unbounded(const hunt *h)
{
    broad *b = h->b;
    const proxy *p = &b->proxies.at[h->id];
    for (size_t i = 0; i < b->unbounded.count; i++) {
        const proxy *q = &b->proxies.at[b->unbounded.at[i]];
        if (may_pair(&p->fat, p->fixed, &q->fat, q->fixed)) gather((void *)h, b->unbounded.at[i]);
    }
}

/* The same as those that an index finds, in the order of their ids. */
static void find_by_ids(const hunt *h)
{
    broad *b = h->b;
    const proxy *p = &b->proxies.at[h->id];
    b->met.count = 0;
    for (uint32_t other = 0; other < b->proxies.count; other++) {
        const proxy *q = &b->proxies.at[other];
        if (other == h->id || q->place == NOWHERE || !may_pair(&p->fat, p->fixed, &q->fat, q->fixed)) continue;
        if (is_candidate(h, other)) array_push(&b->met, other);
    }
    b->spent += UNITS_BY_ID * b->proxies.count;
}

static void find_candidates(broad *b, uint32_t id, const hunt *h)
{
    b->met.count = 0;
    broad_mark_partners(b, id);
    b->index->around(b, id, gather, (void *)h);
    gather_unbounded(h);
    size_t found = b->met.count, kept = 0;
    b->spent += UNITS_A_CANDIDATE * (found < MANY_CANDIDATES ? found : MANY_CANDIDATES);
    if (found >= MANY_CANDIDATES) {
        find_by_ids(h);
        return;
    }
    for (size_t i = 0; i < found; i++)
        if (is_candidate(h, (uint32_t)b->met.at[i])) b->met.at[kept++] = b->met.at[i];
    b->met.count = kept;
    sort_found(b, &b->met);
}

/* False: some are still to be begun. */
static bool begin_missing(broad *b, uint32_t id, uint64_t units, const hunt *h)
{
    size_t begun = 0, asked = 0;
    uint64_t before = broad_asked_until(b, id), until = before > CANDIDATES ? before - CANDIDATES : 0;
    find_candidates(b, id, h);
    for (size_t i = 0; i < b->met.count; i++) {
        uint32_t other = (uint32_t)b->met.at[i];
        uint64_t price = broad_price_of(b, id, other);
        if (other < until) continue;
        if (!goes_on(b, units, begun, b->met.count) || (price && asked && b->spent >= units)) return false;
        b->spent += UNITS_ASKED + price;
        asked += price > 0;
        if (price) broad_take_asked(b, id, CANDIDATES + other + 1);
        if (!broad_accepts(b, id, other)) continue;
        if (b->pairs.count >= b->most_pairs) return false;
        pairs_begin(&b->pairs, id, other);
        array_push(&b->began, pair_key(id, other));
        b->spent += UNITS_BEGUN;
        begun++;
    }
    return true;
}

bool broad_search(
    broad *b, uint32_t id, uint64_t units, broad_leave *is_left, void *context, broad_changes *changes, uint64_t *spent)
{
    const hunt h = {b, id, is_left, context};
    b->spent = 0;
    b->began.count = b->ended.count = 0;
    bool whole = end_parted(b, id, units);
    if (!b->proxies.at[id].passive) whole = whole && begin_missing(b, id, units, &h);
    if (whole) broad_take_searched(b, id, true, false);
    *spent = b->spent;
    *changes = (broad_changes){.began = broad_hand_out(b, &b->began),
        .ended = broad_hand_out(b, &b->ended),
        .began_count = b->began.count,
        .ended_count = b->ended.count};
    return whole;
}

/* ---- what leaves ---- */

void broad_set_leaving(broad *b, uint32_t id, bool leaving)
{
    b->leaving = b->leaving - b->proxies.at[id].leaving + leaving;
    b->proxies.at[id].leaving = leaving;
}

bool broad_is_leaving(const broad *b, uint32_t id)
{
    return id < b->proxies.count && b->proxies.at[id].leaving;
}

bool broad_end_leaving(broad *b, uint32_t id, uint64_t units, broad_changes *changes, uint64_t *spent)
{
    b->spent = b->began.count = b->ended.count = b->met.count = 0;
    for (uint32_t link = pairs_first(&b->pairs, id); link != PAIRS_NO_LINK; link = pairs_next(&b->pairs, link))
        array_push(&b->met, (uint64_t)pairs_other(&b->pairs, link) << 32 | link);
    b->spent = UNITS_A_PAIR_KEPT * b->met.count;
    sort_found(b, &b->met);
    size_t done = 0;
    for (; done < b->met.count && goes_on(b, units, done, b->met.count); done++) {
        array_push(&b->ended, pair_key(id, (uint32_t)(b->met.at[done] >> 32)));
        pairs_end(&b->pairs, (uint32_t)b->met.at[done]);
        b->spent += UNITS_ENDED;
    }
    bool whole = done == b->met.count;
    if (whole) broad_set_leaving(b, id, false);
    *spent = b->spent;
    *changes = (broad_changes){.ended = broad_hand_out(b, &b->ended), .ended_count = b->ended.count};
    return whole;
}

/* ---- a saved state ---- */

bool broad_take_pair(broad *b, uint32_t x, uint32_t y)
{
    if (x == y || x >= b->proxies.count || y >= b->proxies.count) return false;
    if (b->proxies.at[x].place == NOWHERE || b->proxies.at[y].place == NOWHERE) return false;
    pairs_begin(&b->pairs, x, y);
    return true;
}
