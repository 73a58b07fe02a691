/* sweep: what both sweeps share: the lists, what comes and goes, queries along one list. Tick thread; the queries in
 * any number of threads, between updates. */
#include "sweep.h"

#include "base/sort.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

/* ---- what comes and goes ---- */

void sweep_put(broad *b, const change *c)
{
    assert(c->proxy < TREE_NODES_MOST);
    array_push(&b->sweep.fresh, c->proxy);
}

static void strike_out(sweep_list *l, uint32_t what)
{
    if (what >= l->place.count || l->place.at[what] == SWEEP_NOWHERE) return;
    l->ends.at[l->place.at[what]].what = SWEEP_NOWHERE;
    l->place.at[what] = SWEEP_NOWHERE;
}

void sweep_remove(broad *b, uint32_t id)
{
    for (int k = 0; k < 3; k++) {
        strike_out(&b->sweep.lists[k], id << 1);
        strike_out(&b->sweep.lists[k], id << 1 | 1);
    }
    b->sweep.gone++;
}

static void close_gaps(sweep_list *l)
{
    size_t count = 0;
    for (size_t i = 0; i < l->ends.count; i++)
        if (l->ends.at[i].what != SWEEP_NOWHERE) l->ends.at[count++] = l->ends.at[i];
    l->ends.count = count;
}

/* Floats as whole numbers of the same order. */
static uint32_t ordinal(float at)
{
    uint32_t bits;
    memcpy(&bits, &at, sizeof bits);
    return bits & UINT32_C(1) << 31 ? ~bits : bits | UINT32_C(1) << 31;
}

/* The fresh ends in their order: value, then lower before upper. */
static void sort_fresh(broad *b, int axis, bool both_ends)
{
    sweep *s = &b->sweep;
    s->keys.count = 0;
    for (size_t i = 0; i < s->fresh.count; i++) {
        uint32_t id = s->fresh.at[i];
        for (uint32_t upper = 0; upper <= both_ends; upper++) {
            sweep_end end = sweep_end_of(&b->proxies.at[id].fat, axis, id << 1 | upper);
            array_push(&s->keys, (uint64_t)ordinal(end.at) << 32 | upper << 31 | id);
        }
    }
    array_reserve(&s->scratch, s->keys.count);
    sort_keys(s->keys.at, s->scratch.at, s->keys.count);
}

static sweep_end fresh_end(const broad *b, int axis, uint64_t key)
{
    uint32_t id = (uint32_t)key & (UINT32_MAX >> 1), upper = (uint32_t)key >> 31;
    return sweep_end_of(&b->proxies.at[id].fat, axis, id << 1 | upper);
}

static void merge_fresh(broad *b, int axis)
{
    sweep *s = &b->sweep;
    sweep_list *l = &s->lists[axis];
    size_t old = l->ends.count, left = s->keys.count;
    array_reserve(&l->ends, old + left);
    l->ends.count = old + left;
    for (size_t to = l->ends.count; left > 0;) { /* from the back, so that nothing is overwritten */
        sweep_end end = fresh_end(b, axis, s->keys.at[left - 1]);
        bool old_is_last = old > 0 && sweep_before(end, l->ends.at[old - 1]);
        l->ends.at[--to] = old_is_last ? l->ends.at[--old] : end;
        left -= !old_is_last;
    }
}

void sweep_note_width(sweep_list *l, const fbox *box, int axis)
{
    double width = ((double)box->hi[axis] - box->lo[axis]) * (1 + 0x1p-50); /* one rounding: 2^-53 */
    if (width > l->widest) l->widest = width;
}

/* After a merge the places are found anew, and how wide the widest still is. */
static void find_places(broad *b, int axis)
{
    sweep_list *l = &b->sweep.lists[axis];
    array_reserve(&l->place, 2 * b->proxies.count);
    while (l->place.count < 2 * b->proxies.count) l->place.at[l->place.count++] = SWEEP_NOWHERE;
    l->widest = 0;
    for (uint32_t i = 0; i < l->ends.count; i++) {
        uint32_t what = l->ends.at[i].what;
        l->place.at[what] = i;
        if (!(what & 1)) sweep_note_width(l, &b->proxies.at[what >> 1].fat, axis);
    }
}

void sweep_merge(broad *b, int axis, bool both_ends)
{
    if (b->sweep.gone) close_gaps(&b->sweep.lists[axis]);
    if (b->sweep.fresh.count) {
        sort_fresh(b, axis, both_ends);
        merge_fresh(b, axis);
    }
    if (b->sweep.gone || b->sweep.fresh.count) find_places(b, axis);
}

void sweep_end_batch(broad *b)
{
    sweep *s = &b->sweep;
    s->count = s->count - s->gone + (uint32_t)s->fresh.count;
    s->fresh.count = s->moved.count = 0;
    s->gone = 0;
}

/* ---- queries ---- */

/* The first place whose value is not below `at`. */
static size_t first_from(const sweep_list *l, double at)
{
    size_t from = 0, to = l->ends.count;
    while (from < to) {
        size_t middle = from + (to - from) / 2;
        if ((double)l->ends.at[middle].at < at)
            from = middle + 1;
        else
            to = middle;
    }
    return from;
}

/* No box that reaches `lo` begins before this; slack for the rounding of one difference. */
static double first_beginning(const sweep_list *l, double lo)
{
    double at = lo - l->widest;
    return at - fabs(at) * 0x1p-50;
}

bool sweep_query_box(const broad *b, int axis, const fbox *query, broad_visit *visit, void *context)
{
    const sweep_list *l = &b->sweep.lists[axis];
    for (size_t i = first_from(l, first_beginning(l, query->lo[axis])); i < l->ends.count; i++) {
        sweep_end end = l->ends.at[i];
        if (end.at > query->hi[axis]) break;
        if (end.what & 1 || !fbox_overlap(&b->proxies.at[end.what >> 1].fat, query)) continue;
        if (!visit(context, end.what >> 1)) return false;
    }
    return true;
}

/* Along its axis a ray is in no hurry: all are asked. */
void sweep_query_ray(const broad *b, int axis, tree_slabs *slabs, broad_ray_visit *visit, void *context)
{
    const sweep_list *l = &b->sweep.lists[axis];
    for (size_t i = 0; i < l->ends.count; i++) {
        uint32_t what = l->ends.at[i].what;
        if (what & 1 || !tree_slabs_meet(slabs, &b->proxies.at[what >> 1].fat)) continue;
        tree_slabs_end(slabs, visit(context, what >> 1));
    }
}

void sweep_query_nearest(const broad *b, int axis, near_search *search)
{
    const sweep_list *l = &b->sweep.lists[axis];
    for (size_t i = 0; i < l->ends.count; i++) {
        uint32_t what = l->ends.at[i].what;
        if (!(what & 1)) near_push_proxy(search, what >> 1, &b->proxies.at[what >> 1].fat);
    }
}

/* ---- the rest of an index ---- */

uint32_t sweep_position(const broad *b, uint32_t id)
{
    (void)b;
    return id;
}

static const char *validate_end(const broad *b, int axis, uint32_t place)
{
    const sweep_list *l = &b->sweep.lists[axis];
    sweep_end end = l->ends.at[place];
    if (end.what >> 1 >= b->proxies.count) return "an end has a proxy that was never put in";
    const proxy *p = &b->proxies.at[end.what >> 1];
    if (p->place != INDEXED) return "an end has a proxy that is gone";
    if (l->place.at[end.what] != place) return "the place of an end is wrong";
    if (end.at != sweep_end_of(&p->fat, axis, end.what).at) return "an end differs from the proxy's box";
    if ((double)p->fat.hi[axis] - p->fat.lo[axis] > l->widest) return "a box is wider than the widest";
    if (place > 0 && sweep_before(end, l->ends.at[place - 1])) return "a list is not sorted";
    return NULL;
}

const char *sweep_validate(const broad *b, int axis, bool both_ends, size_t *count)
{
    const sweep_list *l = &b->sweep.lists[axis];
    const char *broken = NULL;
    *count = b->sweep.count;
    if (l->ends.count != (both_ends ? 2 : 1) * (size_t)b->sweep.count) return "the count of ends is wrong";
    for (uint32_t i = 0; !broken && i < l->ends.count; i++) broken = validate_end(b, axis, i);
    return broken;
}

void sweep_give_buffers_back(broad *b)
{
    sweep *s = &b->sweep;
    array_free(&s->fresh);
    array_free(&s->moved);
    array_free(&s->keys);
    array_free(&s->scratch);
}

void sweep_free(broad *b)
{
    sweep_give_buffers_back(b);
    for (int k = 0; k < 3; k++) {
        array_free(&b->sweep.lists[k].ends);
        array_free(&b->sweep.lists[k].place);
    }
    b->sweep = (sweep){0};
}
