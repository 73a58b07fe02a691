/* near: the search for the nearest proxies (broad_nearest.c), as the indices see it: they push where it begins. */
#ifndef COLLIDED_BROAD_NEAR_H
#define COLLIDED_BROAD_NEAR_H

#include "base/array.h"
#include "tree.h"

typedef struct near_candidate {
    double distance;  /* m; what lies below is no nearer */
    const tree *tree; /* of the node; NULL for a proxy */
    uint32_t at;      /* node or proxy */
} near_candidate;

typedef struct near_search {
    ARRAY(near_candidate) heap; /* children of i: 2i + 1, 2i + 2 */
    aabb from;
    double reach; /* m */
} near_search;

void near_push_tree(near_search *s, const tree *t);
void near_push_proxy(near_search *s, uint32_t proxy, const fbox *box);

#endif
