/* tree: insertion beside the sibling that costs the least surface, with rotations on the way up, and removal. One
 * thread. Between two calls the box of each inner node is the exact union of its children's boxes. */
#include "tree.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    WORTH_BUILDING = 64, /* leaves */
};

_Static_assert(sizeof(tree_node) == 32, "two siblings fill a cache line");

void tree_init(tree *t)
{
    *t = (tree){.end = 2, .free_pair = TREE_NONE};
}

void tree_give_buffers_back(tree *t)
{
    array_free(&t->search);
    array_free(&t->announced);
    array_free(&t->spans);
}

void tree_free(tree *t)
{
    array_release_in_place(t->nodes);
    array_free_in_place(&t->leaf_of);
    tree_give_buffers_back(t);
    tree_init(t);
}

void tree_reserve(tree *t, size_t need)
{
    assert(need <= TREE_NODES_MOST);
    if (need > t->capacity) t->nodes = array_grow_in_place(t->nodes, &t->capacity, need, sizeof *t->nodes);
}

static uint32_t take_pair(tree *t)
{
    if (t->free_pair != TREE_NONE) {
        uint32_t pair = t->free_pair;
        t->free_pair = t->nodes[pair].down;
        return pair;
    }
    tree_reserve(t, (size_t)t->end + 2);
    uint32_t pair = t->end;
    t->end += 2;
    return pair;
}

static void give_pair(tree *t, uint32_t pair)
{
    assert(pair >= 2 && pair % 2 == 0 && pair < t->end);
    t->nodes[pair].down = t->free_pair;
    t->free_pair = pair;
}

/* A node has moved to index i: tell those below it. */
static void relink_below(tree *t, uint32_t i)
{
    uint32_t down = t->nodes[i].down;
    if (down & TREE_LEAF)
        t->leaf_of.at[down & ~TREE_LEAF] = i;
    else
        t->nodes[down].parent = t->nodes[down + 1].parent = i;
}

static void set_content(tree *t, uint32_t i, const fbox *box, uint32_t down)
{
    assert(i < t->end && (down & TREE_LEAF || (down % 2 == 0 && down + 1 < t->end)));
    t->nodes[i].box = *box;
    t->nodes[i].down = down;
    relink_below(t, i);
}

/* ---- rotations: exchange a child with a child of its sibling where that makes the sibling smaller (Kensler 2008) ----
 */

typedef struct rotation {
    uint32_t up, down; /* the nodes to be exchanged: a child of the node, and a grandchild on the other side */
    uint32_t shrinks;  /* the grandchild's parent */
    fbox box;          /* which then has this box */
    float gain;        /* of area */
} rotation;

static void consider_rotation(const tree *t, uint32_t up, uint32_t down, rotation *best)
{
    const tree_node *n = t->nodes;
    uint32_t shrinks = n[down].parent;
    fbox box = fbox_union(&n[up].box, &n[down ^ 1].box);
    float gain = fbox_area(&n[shrinks].box) - fbox_area(&box);
    if (gain > best->gain) *best = (rotation){up, down, shrinks, box, gain};
}

static void rotate(tree *t, uint32_t i)
{
    rotation best = {.gain = 0};
    uint32_t first = t->nodes[i].down;
    for (uint32_t child = first; child < first + 2; child++) {
        const tree_node *n = &t->nodes[child];
        if (tree_is_leaf(n)) continue;
        consider_rotation(t, child ^ 1, n->down, &best);
        consider_rotation(t, child ^ 1, n->down + 1, &best);
    }
    if (!(best.gain > 0)) return;
    tree_node up = t->nodes[best.up], down = t->nodes[best.down];
    t->nodes[best.shrinks].box = best.box;
    set_content(t, best.up, &down.box, down.down);
    set_content(t, best.down, &up.box, up.down);
}

/* ---- the best sibling: branch and bound over the surface area heuristic (Bittner, Hapala and Havran 2013) ----
 *
 * A leaf put beside node n makes a new parent with the area of (n united with the leaf), and every node above grows.
 * Nothing below n costs less than the growth of n and all above it, plus the leaf's own area. The search first walks
 * straight down to the cheaper side, then looks into the sides that it left out while they can still win. */

typedef struct sibling_search {
    const fbox *leaf;
    float leaf_area;
    uint32_t best;
    float best_cost;
    uint32_t ties; /* random bits: equal sides (coincident boxes) are taken in turn, else the tree would be a list */
} sibling_search;

static tree_step step_to(const tree *t, const sibling_search *s, uint32_t i, float grown_above)
{
    const tree_node *n = &t->nodes[i];
    fbox united = fbox_union(&n->box, s->leaf);
    float area = fbox_area(&united);
    float grown = grown_above + (area - fbox_area(&n->box));
    return (tree_step){i, grown_above + area, grown, tree_is_leaf(n) ? INFINITY : grown + s->leaf_area};
}

static bool random_bit(sibling_search *s)
{
    s->ties = s->ties * 1664525 + 1013904223; /* Numerical Recipes; the upper bits are the random ones */
    return s->ties >> 31;
}

/* What a side promises: a leaf its own cost, an inner node its bound. */
static float promise(const tree_step *s)
{
    return s->bound < s->cost ? s->bound : s->cost;
}

static void walk_down(tree *t, sibling_search *s, tree_step at)
{
    while (at.bound <= s->best_cost) {
        uint32_t first = t->nodes[at.node].down;
        tree_step near = step_to(t, s, first, at.grown), far = step_to(t, s, first + 1, at.grown);
        bool exchange = promise(&near) == promise(&far) ? random_bit(s) : promise(&far) < promise(&near);
        if (exchange) {
            tree_step other = near;
            near = far;
            far = other;
        }
        /* On a tie the deeper place wins: that is what keeps the walk through equal boxes balanced. */
        if (near.cost <= s->best_cost) s->best = near.node, s->best_cost = near.cost;
        if (far.cost < s->best_cost) s->best = far.node, s->best_cost = far.cost;
        if (far.bound < s->best_cost) array_push(&t->search, far);
        at = near;
    }
}

static uint32_t best_sibling(tree *t, uint32_t proxy, const fbox *box)
{
    sibling_search s = {.leaf = box, .leaf_area = fbox_area(box), .ties = proxy};
    tree_step root = step_to(t, &s, TREE_ROOT, 0);
    s.best = TREE_ROOT;
    s.best_cost = root.cost;
    t->search.count = 0;
    walk_down(t, &s, root);
    while (t->search.count > 0) {
        tree_step next = t->search.at[--t->search.count];
        if (next.bound < s.best_cost) walk_down(t, &s, next);
    }
    return s.best;
}

/* ---- insertion and removal ---- */

static void note_proxy(tree *t, uint32_t proxy)
{
    assert(proxy < TREE_NODES_MOST);
    array_reserve_in_place(&t->leaf_of, (size_t)proxy + 1);
    while (t->leaf_of.count <= proxy) t->leaf_of.at[t->leaf_of.count++] = TREE_NONE;
}

/* Up to where nothing changes any more. */
static void fit_upward(tree *t, uint32_t i)
{
    if (t->loose) return;
    for (; i != TREE_NONE; i = t->nodes[i].parent) {
        uint32_t down = t->nodes[i].down;
        assert(!(down & TREE_LEAF) && t->nodes[down].parent == i && t->nodes[down + 1].parent == i);
        fbox box = fbox_union(&t->nodes[down].box, &t->nodes[down + 1].box);
        if (fbox_equal(&box, &t->nodes[i].box)) return;
        t->nodes[i].box = box;
        rotate(t, i);
    }
}

void tree_insert(tree *t, uint32_t proxy, const fbox *box)
{
    note_proxy(t, proxy);
    assert(t->leaf_of.at[proxy] == TREE_NONE && !t->loose);
    tree_reserve(t, 2);
    if (t->leaf_count++ == 0) {
        t->nodes[TREE_ROOT].parent = TREE_NONE;
        set_content(t, TREE_ROOT, box, TREE_LEAF | proxy);
        return;
    }
    /* The sibling steps down beside the leaf; its place becomes their parent. */
    uint32_t place = best_sibling(t, proxy, box);
    uint32_t pair = take_pair(t);
    tree_node sibling = t->nodes[place];
    set_content(t, pair, &sibling.box, sibling.down);
    set_content(t, pair + 1, box, TREE_LEAF | proxy);
    t->nodes[place].down = pair;
    relink_below(t, place);
    fit_upward(t, place);
}

void tree_remove(tree *t, uint32_t proxy)
{
    assert(proxy < t->leaf_of.count && t->leaf_of.at[proxy] != TREE_NONE);
    uint32_t leaf = t->leaf_of.at[proxy];
    assert(t->nodes[leaf].down == (TREE_LEAF | proxy));
    t->leaf_of.at[proxy] = TREE_NONE;
    t->leaf_count--;
    if (leaf == TREE_ROOT) return;
    /* The sibling steps up into the place of the parent. */
    tree_node sibling = t->nodes[leaf ^ 1];
    uint32_t parent = sibling.parent;
    set_content(t, parent, &sibling.box, sibling.down);
    give_pair(t, leaf & ~UINT32_C(1));
    fit_upward(t, t->nodes[parent].parent);
}

void tree_announce(tree *t, uint32_t proxy, const fbox *box)
{
    note_proxy(t, proxy);
    array_push(&t->announced, ((tree_leaf){*box, proxy}));
}

static void build_anew(tree *t)
{
    array_reserve(&t->announced, t->announced.count + t->leaf_count);
    for (uint32_t proxy = 0, left = t->leaf_count; left > 0; proxy++) {
        uint32_t leaf = t->leaf_of.at[proxy];
        if (leaf == TREE_NONE) continue;
        array_push(&t->announced, ((tree_leaf){t->nodes[leaf].box, proxy}));
        left--;
    }
    tree_build(t, t->announced.at, t->announced.count);
}

static bool is_most(const tree *t, size_t changes)
{
    return changes > WORTH_BUILDING && changes > t->leaf_count / 4;
}

void tree_loosen(tree *t, size_t changes)
{
    t->loose |= is_most(t, changes);
}

/* All inner nodes, each before those below it, and then backwards. */
static void fit_all(tree *t)
{
    t->spans.count = 0;
    if (t->leaf_count > 1) array_push(&t->spans, ((tree_span){.node = TREE_ROOT}));
    for (size_t i = 0; i < t->spans.count; i++) {
        uint32_t down = t->nodes[t->spans.at[i].node].down;
        for (uint32_t k = down; k < down + 2; k++)
            if (!tree_is_leaf(&t->nodes[k])) array_push(&t->spans, ((tree_span){.node = k}));
    }
    for (size_t i = t->spans.count; i-- > 0;) {
        tree_node *n = &t->nodes[t->spans.at[i].node];
        n->box = fbox_union(&t->nodes[n->down].box, &t->nodes[n->down + 1].box);
    }
}

void tree_settle(tree *t)
{
    bool anew = is_most(t, t->announced.count);
    if (t->loose && !anew) fit_all(t);
    t->loose = false;
    if (anew) {
        build_anew(t);
    } else {
        for (size_t i = 0; i < t->announced.count; i++)
            tree_insert(t, t->announced.at[i].proxy, &t->announced.at[i].box);
    }
    t->announced.count = 0;
}

void tree_move(tree *t, uint32_t proxy, const fbox *box)
{
    assert(proxy < t->leaf_of.count && t->leaf_of.at[proxy] != TREE_NONE);
    uint32_t leaf = t->leaf_of.at[proxy];
    assert(t->nodes[leaf].down == (TREE_LEAF | proxy));
    t->nodes[leaf].box = *box;
    fit_upward(t, t->nodes[leaf].parent);
}
