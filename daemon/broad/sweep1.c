/* sweep1: sweep and prune on one axis, that of the largest variance: the lower ends of all boxes in one list. What
 * moved is brought to its new place, and meets those whose boxes it finds beside it. Tick thread. */
#include "sweep.h"

#include <stdlib.h>

/* The axis is chosen anew after so many moves a proxy, and only for one whose variance is so many times larger: a
 * choice costs a look at all and perhaps a sort. */
enum { MOVES_A_CHOICE = 16 };
static const double WORTH_CHANGING = 2;

static void sweep1_move(broad *b, change *c)
{
    array_push(&b->sweep.moved, c->proxy);
}

static void move_lower_end(broad *b, uint32_t id)
{
    sweep *s = &b->sweep;
    sweep_list *l = &s->lists[s->axis];
    sweep_end end = sweep_end_of(&b->proxies.at[id].fat, s->axis, id << 1);
    uint32_t i = l->place.at[end.what];
    sweep_note_width(l, &b->proxies.at[id].fat, s->axis);
    for (; i > 0 && sweep_before(end, l->ends.at[i - 1]); i--) {
        l->ends.at[i] = l->ends.at[i - 1];
        l->place.at[l->ends.at[i].what] = i;
    }
    for (; i + 1 < l->ends.count && sweep_before(l->ends.at[i + 1], end); i++) {
        l->ends.at[i] = l->ends.at[i + 1];
        l->place.at[l->ends.at[i].what] = i;
    }
    l->ends.at[i] = end;
    l->place.at[end.what] = i;
}

/* ---- the axis ---- */

/* Of the boxes' middles, by Welford's method. In the order of ids, so that the same boxes give the same axis. */
static void variances(const broad *b, double sums[3])
{
    double mean[3] = {0, 0, 0};
    size_t count = 0;
    sums[0] = sums[1] = sums[2] = 0;
    for (size_t i = 0; i < b->proxies.count; i++) {
        const proxy *p = &b->proxies.at[i];
        if (p->place != INDEXED) continue;
        count++;
        for (int k = 0; k < 3; k++) {
            double middle = 0.5 * ((double)p->fat.lo[k] + p->fat.hi[k]), off = middle - mean[k];
            mean[k] += off / (double)count;
            sums[k] += off * (middle - mean[k]);
        }
    }
}

static void use_axis(broad *b, int axis)
{
    sweep *s = &b->sweep;
    array_free(&s->lists[s->axis].ends);
    array_free(&s->lists[s->axis].place);
    s->axis = axis;
    s->fresh.count = s->moved.count = 0;
    for (uint32_t id = 0; id < b->proxies.count; id++)
        if (b->proxies.at[id].place == INDEXED) array_push(&s->fresh, id);
    s->count = s->gone = 0;
}

/* Also when all were put at once. */
static void choose_axis(broad *b)
{
    sweep *s = &b->sweep;
    s->changes += s->fresh.count + s->moved.count;
    if (s->changes < MOVES_A_CHOICE * (size_t)s->count) return;
    s->changes = 0;
    double sums[3];
    variances(b, sums);
    int best = s->axis;
    for (int k = 0; k < 3; k++)
        if (sums[k] > sums[best]) best = k;
    if (sums[best] > WORTH_CHANGING * sums[s->axis]) use_axis(b, best);
}

static void sweep1_settle(broad *b)
{
    choose_axis(b);
    sweep *s = &b->sweep;
    sweep_merge(b, s->axis, false);
    for (size_t i = 0; i < s->moved.count; i++) move_lower_end(b, s->moved.at[i]);
    sweep_end_batch(b);
}

/* ---- queries ---- */

static bool sweep1_query_box(const broad *b, const fbox *query, broad_visit *visit, void *context)
{
    return sweep_query_box(b, b->sweep.axis, query, visit, context);
}

static void sweep1_around(const broad *b, uint32_t id, broad_visit *visit, void *context)
{
    sweep_query_box(b, b->sweep.axis, &b->proxies.at[id].fat, visit, context);
}

static void sweep1_query_ray(const broad *b, tree_slabs *slabs, broad_ray_visit *visit, void *context)
{
    sweep_query_ray(b, b->sweep.axis, slabs, visit, context);
}

static void sweep1_query_nearest(const broad *b, near_search *search)
{
    sweep_query_nearest(b, b->sweep.axis, search);
}

static const char *sweep1_validate(const broad *b, size_t *count)
{
    return sweep_validate(b, b->sweep.axis, false, count);
}

const broad_index broad_sweep1 = {
    .kind = BROAD_SWEEP1,
    .put = sweep_put,
    .move = sweep1_move,
    .remove = sweep_remove,
    .settle = sweep1_settle,
    .around = sweep1_around,
    .position = sweep_position,
    .query_box = sweep1_query_box,
    .query_ray = sweep1_query_ray,
    .query_nearest = sweep1_query_nearest,
    .validate = sweep1_validate,
    .give_buffers_back = sweep_give_buffers_back,
    .free = sweep_free,
};
