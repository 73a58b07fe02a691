/* tree: a dynamic bounding-volume tree over finite boxes, one leaf a proxy.
 *
 * Nodes are 32 bytes, and siblings lie side by side in one cache line: a node at an even index 2k and its sibling at
 * 2k + 1, so the sibling of i is i ^ 1, and an inner node needs only one link down. The price is that leaves move in
 * memory; leaf_of follows them. The root is node 0, node 1 is not used. Not thread-safe; queries may run in several
 * threads while nobody changes the tree. No recursion: no bound on the height is assumed. */
#ifndef COLLIDED_BROAD_TREE_H
#define COLLIDED_BROAD_TREE_H

#include "base/array.h"
#include "fbox.h"

#include <stddef.h>
#include <stdint.h>

enum { TREE_ROOT = 0 };
#define TREE_NONE UINT32_MAX
#define TREE_LEAF (UINT32_C(1) << 31) /* in `down`: what follows is a proxy */

typedef struct tree_node {
    fbox box;
    uint32_t parent; /* TREE_NONE for the root */
    uint32_t down;   /* the first of the two children, or TREE_LEAF | proxy */
} tree_node;

typedef struct tree_step { /* a node to be looked into by the search for the best sibling */
    uint32_t node;
    float cost;  /* of putting the leaf beside this node */
    float grown; /* by how much the areas of this node and of all above it would grow */
    float bound; /* no place below this node costs less; infinite for a leaf */
} tree_step;

typedef struct tree {
    tree_node *nodes;   /* aligned to a cache line */
    size_t capacity;    /* nodes */
    uint32_t end;       /* nodes ever used */
    uint32_t free_pair; /* first of the freed pairs of siblings, linked by `down`; TREE_NONE at the end */
    uint32_t leaf_count;
    ARRAY(uint32_t) leaf_of; /* by proxy: its node */
    ARRAY(tree_step) search;
} tree;

void tree_init(tree *t);
void tree_free(tree *t);
void tree_insert(tree *t, uint32_t proxy, const fbox *box);
void tree_remove(tree *t, uint32_t proxy);

/* The box of a proxy that is in the tree. */
static inline const fbox *tree_box(const tree *t, uint32_t proxy)
{
    return &t->nodes[t->leaf_of.at[proxy]].box;
}
static inline bool tree_is_leaf(const tree_node *n)
{
    return (n->down & TREE_LEAF) != 0;
}

/* A segment from..from + length * direction. */
typedef struct tree_ray {
    double from[3], direction[3], length;
} tree_ray;

bool tree_ray_meets(const tree_ray *ray, const fbox *box);

/* Visit each proxy whose box meets the query, until a visit returns false; returns false then too. */
typedef bool tree_visit(void *context, uint32_t proxy);
bool tree_query_box(const tree *t, const fbox *query, tree_visit *visit, void *context);
bool tree_query_ray(const tree *t, const tree_ray *ray, tree_visit *visit, void *context);

/* For tests: the first broken invariant, or NULL. */
const char *tree_validate(const tree *t);

#endif
