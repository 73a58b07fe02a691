/* tree_build: a whole tree from its leaves, top down: each set is cut where the surface area heuristic is least, among
 * a few planes across the longest side of the box around the centers (Wald 2007). One thread. Nodes are laid out depth
 * first, so that what is near in space is near in memory. The result depends on the leaves and their order alone. */
#include "tree.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { BINS = 16, FEW_BINS = 6 };

typedef struct bin {
    fbox box;
    uint32_t count;
} bin;

typedef struct cut {
    int axis;
    float from, scale; /* a center lies in the bin (center - from) * scale */
    int bins;
    int bin; /* the first one on the far side */
} cut;

static const fbox NO_BOX = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};

/* Twice the center; the sum of two numbers below the trees' reach does not overflow. */
static inline float center_of(const fbox *b, int axis)
{
    return b->lo[axis] + b->hi[axis];
}

static int bin_of(const cut *c, const fbox *box)
{
    int i = (int)((center_of(box, c->axis) - c->from) * c->scale);
    return i < c->bins ? i : c->bins - 1;
}

static void measure(const tree_leaf *leaves, uint32_t count, fbox *around, fbox *centers)
{
    *around = *centers = NO_BOX;
    for (uint32_t i = 0; i < count; i++) {
        const fbox *b = &leaves[i].box;
        fbox c;
        for (int k = 0; k < 3; k++) c.lo[k] = c.hi[k] = center_of(b, k);
        *around = fbox_union(around, b);
        *centers = fbox_union(centers, &c);
    }
}

static int longest_axis(const fbox *b)
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (b->hi[k] - b->lo[k] > b->hi[axis] - b->lo[axis]) axis = k;
    return axis;
}

static void best_bin(const bin *bins, cut *c)
{
    float near_cost[BINS];
    fbox box = NO_BOX;
    uint32_t count = 0;
    for (int i = 0; i < c->bins - 1; i++) {
        box = fbox_union(&box, &bins[i].box);
        count += bins[i].count;
        near_cost[i + 1] = count ? fbox_area(&box) * (float)count : INFINITY;
    }
    float best = INFINITY;
    box = NO_BOX;
    count = 0;
    c->bin = c->bins / 2;
    for (int i = c->bins - 1; i > 0; i--) {
        box = fbox_union(&box, &bins[i].box);
        count += bins[i].count;
        float cost = count ? near_cost[i] + fbox_area(&box) * (float)count : INFINITY;
        if (cost < best) best = cost, c->bin = i;
    }
}

/* Moves the leaves on the near side of the cut to the front; how many they are. */
static uint32_t part(tree_leaf *leaves, uint32_t count, const cut *c)
{
    uint32_t i = 0, end = count;
    while (i < end) {
        if (bin_of(c, &leaves[i].box) < c->bin) {
            i++;
            continue;
        }
        tree_leaf far = leaves[i];
        leaves[i] = leaves[--end];
        leaves[end] = far;
    }
    return i;
}

/* In two halves, where the centers coincide or the cut leaves a side empty. */
static uint32_t divide(tree_leaf *leaves, uint32_t count, fbox *around)
{
    fbox centers;
    measure(leaves, count, around, &centers);
    if (count < 3) return count / 2;
    cut c = {.axis = longest_axis(&centers), .bins = count < BINS ? FEW_BINS : BINS};
    float extent = centers.hi[c.axis] - centers.lo[c.axis];
    if (!(extent > 0) || !isfinite((float)c.bins / extent)) return count / 2;
    c.from = centers.lo[c.axis];
    c.scale = (float)c.bins / extent;
    bin bins[BINS];
    for (int i = 0; i < c.bins; i++) bins[i] = (bin){NO_BOX, 0};
    for (uint32_t i = 0; i < count; i++) {
        bin *at = &bins[bin_of(&c, &leaves[i].box)];
        at->box = fbox_union(&at->box, &leaves[i].box);
        at->count++;
    }
    best_bin(bins, &c);
    uint32_t near = part(leaves, count, &c);
    return near == 0 || near == count ? count / 2 : near;
}

void tree_build(tree *t, tree_leaf *leaves, size_t count)
{
    tree_reserve(t, 2 * count + 2);
    t->end = 2;
    t->free_pair = TREE_NONE;
    t->leaf_count = (uint32_t)count;
    if (count == 0) return;
    t->nodes[TREE_ROOT].parent = TREE_NONE;
    t->spans.count = 0;
    array_push(&t->spans, ((tree_span){0, (uint32_t)count, TREE_ROOT}));
    while (t->spans.count > 0) {
        tree_span s = t->spans.at[--t->spans.count];
        tree_node *n = &t->nodes[s.node];
        if (s.end - s.first == 1) {
            n->box = leaves[s.first].box;
            n->down = TREE_LEAF | leaves[s.first].proxy;
            t->leaf_of.at[leaves[s.first].proxy] = s.node;
            continue;
        }
        uint32_t middle = s.first + divide(leaves + s.first, s.end - s.first, &n->box);
        n->down = t->end;
        t->nodes[t->end].parent = t->nodes[t->end + 1].parent = s.node;
        array_push(&t->spans, ((tree_span){middle, s.end, t->end + 1}));
        array_push(&t->spans, ((tree_span){s.first, middle, t->end}));
        t->end += 2;
    }
}
