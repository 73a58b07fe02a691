/* sweep3: sweep and prune on three axes (Baraff 1992; Cohen, Lin, Manocha and Ponamgi 1995): lower and upper ends of
 * all boxes, one list an axis. Where a lower end passes an upper one, two boxes begin to meet on that axis; if at the
 * end of the batch they meet on all, and did not before, they have met. Tick thread.
 *
 * Ends move one proxy after the other, so two may pass each other forth and back in one batch. It does not matter: for
 * each order of two ends that was wrong at first and is right at the end, exactly one passing is in the right
 * direction; and a pair is told by that of the first order that was wrong. */
#include "sweep.h"

static void sweep3_move(broad *b, change *c)
{
    c->asks = c->refilter || b->proxies.at[c->proxy].fixed != c->fixed;
    array_push(&b->sweep.moved, c->proxy);
}

/* On this axis the boxes were apart in this way: `low` began behind the end of `high`. On the axes before they met. */
static bool parted_first(const fbox *low, const fbox *high, int axis)
{
    for (int k = 0; k < axis; k++)
        if (low->lo[k] > high->hi[k] || high->lo[k] > low->hi[k]) return false;
    return low->lo[axis] > high->hi[axis];
}

static const fbox *box_before(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    return p->pending == NOTHING_PENDING ? &p->fat : &b->pending.at[p->pending].old;
}

static bool asks(const broad *b, uint32_t id)
{
    const proxy *p = &b->proxies.at[id];
    const change *c = p->pending == NOTHING_PENDING ? NULL : &b->pending.at[p->pending];
    return c && c->asks && (c->put || c->refilter);
}

/* The lower end of `low` came before the upper end of `high`. */
static void passed(broad *b, uint32_t low, uint32_t high, int axis)
{
    const proxy *p = &b->proxies.at[low], *q = &b->proxies.at[high];
    if (low == high || !may_pair(&p->fat, p->fixed, &q->fat, q->fixed) || asks(b, low) || asks(b, high)) return;
    if (!parted_first(box_before(b, low), box_before(b, high), axis)) return;
    array_push(&b->met, pair_key(low, high));
}

static void move_down(broad *b, int axis, sweep_end end)
{
    sweep_list *l = &b->sweep.lists[axis];
    uint32_t i = l->place.at[end.what];
    for (; i > 0 && sweep_before(end, l->ends.at[i - 1]); i--) {
        sweep_end other = l->ends.at[i] = l->ends.at[i - 1];
        l->place.at[other.what] = i;
        if (!(end.what & 1) && other.what & 1) passed(b, end.what >> 1, other.what >> 1, axis);
    }
    l->ends.at[i] = end;
    l->place.at[end.what] = i;
}

static void move_up(broad *b, int axis, sweep_end end)
{
    sweep_list *l = &b->sweep.lists[axis];
    uint32_t i = l->place.at[end.what];
    for (; i + 1 < l->ends.count && sweep_before(l->ends.at[i + 1], end); i++) {
        sweep_end other = l->ends.at[i] = l->ends.at[i + 1];
        l->place.at[other.what] = i;
        if (end.what & 1 && !(other.what & 1)) passed(b, other.what >> 1, end.what >> 1, axis);
    }
    l->ends.at[i] = end;
    l->place.at[end.what] = i;
}

static void move_either_end(broad *b, int axis, sweep_end end)
{
    const sweep_list *l = &b->sweep.lists[axis];
    if (end.at < l->ends.at[l->place.at[end.what]].at)
        move_down(b, axis, end);
    else
        move_up(b, axis, end);
}

/* First the end that gives room to the other, so that a proxy's own ends stay in order. */
static void move_ends(broad *b, uint32_t id, int axis)
{
    const fbox *box = &b->proxies.at[id].fat;
    sweep_end lower = sweep_end_of(box, axis, id << 1), upper = sweep_end_of(box, axis, id << 1 | 1);
    sweep_list *l = &b->sweep.lists[axis];
    sweep_note_width(l, box, axis);
    bool upper_first = upper.at > l->ends.at[l->place.at[upper.what]].at;
    if (upper_first) move_either_end(b, axis, upper);
    move_either_end(b, axis, lower);
    if (!upper_first) move_either_end(b, axis, upper);
}

static void sweep3_settle(broad *b)
{
    sweep *s = &b->sweep;
    for (int k = 0; k < 3; k++) {
        sweep_merge(b, k, true);
        for (size_t i = 0; i < s->moved.count; i++) move_ends(b, s->moved.at[i], k);
    }
    sweep_end_batch(b);
}

/* ---- queries: along the axis on which the fewest boxes stand side by side ---- */

static double stretch(const sweep_list *l)
{
    if (l->ends.count == 0 || l->widest == 0) return 0;
    return ((double)l->ends.at[l->ends.count - 1].at - l->ends.at[0].at) / l->widest;
}

static int best_axis(const broad *b)
{
    int best = 0;
    for (int k = 1; k < 3; k++)
        if (stretch(&b->sweep.lists[k]) > stretch(&b->sweep.lists[best])) best = k;
    return best;
}

static bool sweep3_query_box(const broad *b, const fbox *query, broad_visit *visit, void *context)
{
    return sweep_query_box(b, best_axis(b), query, visit, context);
}

static void sweep3_around(const broad *b, uint32_t id, broad_visit *visit, void *context)
{
    sweep_query_box(b, best_axis(b), &b->proxies.at[id].fat, visit, context);
}

static void sweep3_query_ray(const broad *b, tree_slabs *slabs, broad_ray_visit *visit, void *context)
{
    sweep_query_ray(b, best_axis(b), slabs, visit, context);
}

static void sweep3_query_nearest(const broad *b, near_search *search)
{
    sweep_query_nearest(b, best_axis(b), search);
}

static const char *sweep3_validate(const broad *b, size_t *count)
{
    const char *broken = NULL;
    for (int k = 0; !broken && k < 3; k++) broken = sweep_validate(b, k, true, count);
    return broken;
}

const broad_index broad_sweep3 = {
    .kind = BROAD_SWEEP3,
    .put = sweep_put,
    .move = sweep3_move,
    .remove = sweep_remove,
    .settle = sweep3_settle,
    .around = sweep3_around,
    .position = sweep_position,
    .query_box = sweep3_query_box,
    .query_ray = sweep3_query_ray,
    .query_nearest = sweep3_query_nearest,
    .validate = sweep3_validate,
    .give_buffers_back = sweep_give_buffers_back,
    .free = sweep_free,
};
