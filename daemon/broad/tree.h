/* tree: a dynamic bounding-volume tree over finite boxes, one leaf a proxy. A leaf whose box changes stays where it is,
 * the boxes above follow, and rotations mend what grows; now and then it is taken out and put where it is best. A tree
 * that is filled at once, or of which much has to find new places, is built anew.
 *
 * Nodes are 32 bytes, and siblings lie side by side in one cache line: a node at an even index 2k and its sibling at
 * 2k + 1, so the sibling of i is i ^ 1, and an inner node needs only one link down. The price is that leaves move in
 * memory; leaf_of follows them. The root is node 0, node 1 is not used. Not thread-safe; queries may run in several
 * threads while nobody changes the tree. No recursion: no bound on the height is assumed.
 *
 * Why two children and not four or eight. Measured (Xeon, Sapphire Rapids, one core; a world of N boxes, a fourteenth
 * of them queried and moved a round; the wide trees collapsed from the same binary one, so with the least loss of
 * quality, 4-wide with SSE, 8-wide with AVX; ns each):
 *
 *   N           query around a leaf     box of a leaf changed, boxes above follow     bytes a leaf
 *               2-wide  4-wide  8-wide  2-wide, rotating    4-wide    8-wide          2     4     8
 *   10,000      230     169     126     120                 43        83              64    62    97
 *   100,000     530     458     377     310                 274       363             64    63    88
 *   1,000,000   800     624     481     490                 355       429             64    60    75
 *
 * A body leaves its fat box about every fourteenth tick, so the whole gain would be 4 to 20 ns of the 50 to 100 ns a
 * moved body. For it a wide tree gives up rotations and the exact search for the best place, which are what keeps a
 * tree good for a long life, and the 8-wide one needs AVX. */
#ifndef COLLIDED_BROAD_TREE_H
#define COLLIDED_BROAD_TREE_H

#include "base/array.h"
#include "fbox.h"
#include "simd.h"

#include <stddef.h>
#include <stdint.h>

enum { TREE_ROOT = 0 };
#define TREE_NONE UINT32_MAX
#define TREE_NODES_MOST (UINT32_C(1) << 30) /* so that places in two trees sort in 32 bits (broad_update.c) */
#define TREE_LEAF (UINT32_C(1) << 31)       /* in `down`: what follows is a proxy */

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

typedef struct tree_span { /* of leaves, which become the tree below a node */
    uint32_t first, end, node;
} tree_span;

typedef struct tree_leaf { /* yet without a node */
    fbox box;
    uint32_t proxy;
} tree_leaf;

typedef struct tree {
    tree_node *nodes;   /* from a cache line on; they grow in place */
    size_t capacity;    /* nodes */
    uint32_t end;       /* nodes ever used */
    uint32_t free_pair; /* first of the freed pairs of siblings, linked by `down`; TREE_NONE at the end */
    uint32_t leaf_count;
    bool loose;              /* until tree_settle: see tree_loosen */
    ARRAY(uint32_t) leaf_of; /* by proxy: its node */
    ARRAY(tree_step) search;
    ARRAY(tree_leaf) announced;
    ARRAY(tree_span) spans;
} tree;

void tree_init(tree *t);
void tree_free(tree *t);
void tree_give_buffers_back(tree *t); /* what insertion and building work in; they come again as needed */
void tree_insert(tree *t, uint32_t proxy, const fbox *box);
void tree_remove(tree *t, uint32_t proxy);

/* The proxy has another box; its leaf stays where it is. */
void tree_move(tree *t, uint32_t proxy, const fbox *box);

/* Very many changes are about to come, if they are: then boxes above leaves that move or go follow in tree_settle, all
 * of them, without rotations. One by one, rotated against neighbours that have not moved yet, they would leave a tree
 * in which a query goes through ten times as many nodes. No query, nor insertion, before tree_settle. */
void tree_loosen(tree *t, size_t changes);

/* Several at once: announced, and inserted by tree_settle, which builds the whole tree anew where that costs less. */
void tree_announce(tree *t, uint32_t proxy, const fbox *box);
void tree_settle(tree *t);

/* Of these leaves alone, whose proxies the tree knows (announced or inserted once); reorders them. */
void tree_build(tree *t, tree_leaf *leaves, size_t count);
void tree_reserve(tree *t, size_t nodes);

/* The box of a proxy that is in the tree. */
static inline const fbox *tree_box(const tree *t, uint32_t proxy)
{
    return &t->nodes[t->leaf_of.at[proxy]].box;
}
static inline bool tree_is_leaf(const tree_node *n)
{
    return (n->down & TREE_LEAF) != 0;
}

/* A box lo..hi that moves by length * direction; a ray is one with lo = hi. */
typedef struct tree_ray {
    double lo[3], hi[3], direction[3], length;
} tree_ray;

/* Ready for many boxes, for a direction of a length of about 1; see tree_ray.c. */
typedef struct tree_slabs {
    simd_ray ray;
    float far;
} tree_slabs;
tree_slabs tree_slabs_of(const tree_ray *ray);
/* False: it does not meet the box. True: it does, or by a rounding of a float it does not. */
bool tree_slabs_meet(const tree_slabs *slabs, const fbox *box);
/* The way ends at this length from now on; < 0: at once. */
void tree_slabs_end(tree_slabs *slabs, double length);

/* Visit each proxy whose box meets the query, until a visit returns false; returns false then too. */
typedef bool tree_visit(void *context, uint32_t proxy);
bool tree_query_box(const tree *t, const fbox *query, tree_visit *visit, void *context);
/* The same for the box of a proxy of the tree, upward from its leaf; without the proxy itself. */
bool tree_query_around(const tree *t, uint32_t proxy, tree_visit *visit, void *context);

/* Each proxy whose box a ray meets (or nearly), roughly in the order of its way, over several trees at once. The visit
 * returns at which length the way ends from now on: as before, shorter, or < 0 to stop. */
typedef double tree_ray_visit(void *context, uint32_t proxy);
void tree_query_ray(const tree *const trees[], size_t count, tree_slabs *slabs, tree_ray_visit *visit, void *context);

/* For tests: the first broken invariant, or NULL. */
const char *tree_validate(const tree *t);

#endif
