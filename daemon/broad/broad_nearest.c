/* broad_nearest: proxies in the order of their distance, best first (Hjaltason and Samet 1999): a heap holds the nodes
 * and proxies that lie at the edge of what was seen, nearest on top; what comes up as a proxy is nearer than all else.
 * Any number of threads, between updates. */
#include "broad.h"

#include "near.h"
#include "state.h"

#include <math.h>
#include <stdlib.h>

static double gap(double lo, double hi, double from_lo, double from_hi)
{
    return fmax(0, fmax(lo - from_hi, from_lo - hi));
}

/* Six roundings, of at most 2^-53 each: the slack makes the computed distance a lower bound. */
static double distance_to(const near_search *s, const fbox *b)
{
    double x = gap(b->lo[0], b->hi[0], s->from.lo.x, s->from.hi.x);
    double y = gap(b->lo[1], b->hi[1], s->from.lo.y, s->from.hi.y);
    double z = gap(b->lo[2], b->hi[2], s->from.lo.z, s->from.hi.z);
    return sqrt(x * x + y * y + z * z) * (1 - 0x1p-49);
}

/* Proxies before nodes at the same distance: fewer nodes are opened. */
static bool before(const near_candidate *a, const near_candidate *b)
{
    if (a->distance != b->distance) return a->distance < b->distance;
    return !a->tree && b->tree;
}

static void push(near_search *s, const tree *t, uint32_t at, const fbox *box)
{
    near_candidate c = {distance_to(s, box), t, at};
    if (!(c.distance <= s->reach)) return;
    array_push(&s->heap, c);
    size_t i = s->heap.count - 1;
    for (; i > 0 && before(&c, &s->heap.at[(i - 1) / 2]); i = (i - 1) / 2) s->heap.at[i] = s->heap.at[(i - 1) / 2];
    s->heap.at[i] = c;
}

static near_candidate pop(near_search *s)
{
    near_candidate top = s->heap.at[0], c = s->heap.at[--s->heap.count];
    size_t i = 0, count = s->heap.count;
    for (size_t child; (child = 2 * i + 1) < count; i = child) {
        if (child + 1 < count && before(&s->heap.at[child + 1], &s->heap.at[child])) child++;
        if (!before(&s->heap.at[child], &c)) break;
        s->heap.at[i] = s->heap.at[child];
    }
    s->heap.at[i] = c;
    return top;
}

static void open_node(near_search *s, const tree *t, uint32_t node)
{
    uint32_t down = t->nodes[node].down;
    for (uint32_t i = down; i < down + 2; i++) {
        const tree_node *n = &t->nodes[i];
        push(s, tree_is_leaf(n) ? NULL : t, tree_is_leaf(n) ? n->down & ~TREE_LEAF : i, &n->box);
    }
}

void near_push_tree(near_search *s, const tree *t)
{
    if (t->leaf_count == 0) return;
    const tree_node *root = &t->nodes[TREE_ROOT];
    push(s, tree_is_leaf(root) ? NULL : t, tree_is_leaf(root) ? root->down & ~TREE_LEAF : TREE_ROOT, &root->box);
}

void near_push_proxy(near_search *s, uint32_t proxy, const fbox *box)
{
    push(s, NULL, proxy, box);
}

void broad_query_nearest(const broad *b, aabb box, double reach, broad_near_visit *visit, void *context)
{
    near_search s = {.from = box, .reach = reach};
    b->index->query_nearest(b, &s);
    for (size_t i = 0; i < b->unbounded.count; i++) {
        uint32_t id = b->unbounded.at[i];
        near_push_proxy(&s, id, &b->proxies.at[id].fat);
    }
    while (s.heap.count > 0) {
        near_candidate c = pop(&s);
        if (!(c.distance <= s.reach)) break;
        if (c.tree)
            open_node(&s, c.tree, c.at);
        else
            s.reach = visit(context, c.at, c.distance);
    }
    array_free(&s.heap);
}
