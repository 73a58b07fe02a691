/* tree_validate: the invariants of a tree, checked as a whole; for tests. Any thread while nobody changes the tree. */
#include "tree.h"

#include <stdlib.h>

typedef struct tally {
    ARRAY(uint32_t) ahead; /* nodes yet to be checked */
    size_t nodes, leaves;
} tally;

static const char *check_leaf(const tree *t, uint32_t i)
{
    uint32_t proxy = t->nodes[i].down & ~TREE_LEAF;
    if (proxy >= t->leaf_of.count) return "a leaf has a proxy that was never put in";
    if (t->leaf_of.at[proxy] != i) return "leaf_of does not lead to the leaf";
    return NULL;
}

static const char *check_inner(const tree *t, uint32_t i)
{
    const tree_node *n = &t->nodes[i];
    if (n->down % 2 != 0 || n->down < 2 || n->down + 1 >= t->end) return "a link down leads outside";
    const tree_node *first = &t->nodes[n->down], *second = first + 1;
    if (first->parent != i || second->parent != i) return "a child does not know its parent";
    fbox united = fbox_union(&first->box, &second->box);
    if (!fbox_equal(&united, &n->box)) return "a box is not the union of its children's";
    return NULL;
}

static const char *check_reachable(const tree *t, tally *y)
{
    array_push(&y->ahead, (uint32_t)TREE_ROOT);
    if (t->nodes[TREE_ROOT].parent != TREE_NONE) return "the root has a parent";
    while (y->ahead.count > 0) {
        uint32_t i = y->ahead.at[--y->ahead.count];
        if (++y->nodes > t->end) return "the tree has a ring";
        bool leaf = tree_is_leaf(&t->nodes[i]);
        const char *broken = leaf ? check_leaf(t, i) : check_inner(t, i);
        if (broken) return broken;
        y->leaves += leaf;
        if (leaf) continue;
        array_push(&y->ahead, t->nodes[i].down);
        array_push(&y->ahead, t->nodes[i].down + 1);
    }
    return NULL;
}

static const char *check_counts(const tree *t, const tally *y)
{
    if (y->leaves != t->leaf_count) return "leaf_count differs from the leaves";
    size_t known = 0;
    for (size_t i = 0; i < t->leaf_of.count; i++) known += t->leaf_of.at[i] != TREE_NONE;
    if (known != y->leaves) return "leaf_of has a proxy that is not in the tree";
    size_t freed = 0;
    for (uint32_t i = t->free_pair; i != TREE_NONE && freed <= t->end; i = t->nodes[i].down) freed += 2;
    size_t below_root = y->nodes > 0 ? y->nodes - 1 : 0;
    if (below_root + freed + 2 != t->end) return "nodes were lost";
    return NULL;
}

const char *tree_validate(const tree *t)
{
    tally y = {0};
    const char *broken = t->leaf_count > 0 ? check_reachable(t, &y) : NULL;
    if (!broken) broken = check_counts(t, &y);
    array_free(&y.ahead);
    return broken;
}
