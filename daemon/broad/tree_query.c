/* tree_query: walks over a tree that nobody changes meanwhile; any number of threads. The walk keeps the nodes that it
 * has yet to enter on a stack of its own, which moves to the heap where a tree is deeper than any healthy one. */
#include "tree.h"

#include <stdlib.h>
#include <string.h>

enum { SHALLOW = 120 }; /* nodes; a balanced tree of 2^100 leaves needs fewer */

typedef struct node_stack {
    uint32_t *at;
    size_t count, capacity;
    uint32_t shallow[SHALLOW];
} node_stack;

static void stack_init(node_stack *s)
{
    s->at = s->shallow;
    s->count = 0;
    s->capacity = SHALLOW;
}

static void stack_free(node_stack *s)
{
    if (s->at != s->shallow) free(s->at);
}

static void stack_grow(node_stack *s)
{
    uint32_t *deep = base_alloc(s->capacity * 2, sizeof *deep);
    memcpy(deep, s->at, s->count * sizeof *deep);
    stack_free(s);
    s->at = deep;
    s->capacity *= 2;
}

static inline void stack_push(node_stack *s, uint32_t node)
{
    if (s->count == s->capacity) stack_grow(s);
    s->at[s->count++] = node;
}

/* Relative slack for rounding: each of the two ends has a difference and a quotient, so 2^-52 each; this is four times
 * their sum. It is applied outward only, so a segment that meets a box is never said to miss it. */
static const double RAY_SLACK = 0x1p-49;

/* Slabs. For a larger box no computed near end is later and no far end earlier, since rounding is monotonic: a node
 * that misses has no leaf that meets. */
bool tree_ray_meets(const tree_ray *ray, const fbox *box)
{
    double near = 0, far = ray->length;
    for (int k = 0; k < 3; k++) {
        double lo = box->lo[k], hi = box->hi[k], d = ray->direction[k];
        if (d == 0) {
            if (ray->from[k] < lo || ray->from[k] > hi) return false;
            continue;
        }
        double enter = ((d > 0 ? lo : hi) - ray->from[k]) / d;
        double leave = ((d > 0 ? hi : lo) - ray->from[k]) / d;
        if (enter > near) near = enter;
        if (leave < far) far = leave;
    }
    return near <= far + far * RAY_SLACK;
}

typedef bool node_test(const void *query, const fbox *box);

static bool box_meets(const void *query, const fbox *box)
{
    return fbox_overlap(query, box);
}
static bool ray_meets(const void *query, const fbox *box)
{
    return tree_ray_meets(query, box);
}

/* Inlined into its two callers, where `meets` is a constant. */
static inline __attribute__((always_inline)) bool walk(
    const tree *t, const void *query, node_test *meets, tree_visit *visit, void *context)
{
    if (t->leaf_count == 0 || !meets(query, &t->nodes[TREE_ROOT].box)) return true;
    node_stack stack;
    stack_init(&stack);
    stack_push(&stack, TREE_ROOT);
    bool goes_on = true;
    while (goes_on && stack.count > 0) { /* what is on the stack meets the query */
        uint32_t down = t->nodes[stack.at[--stack.count]].down;
        if (down & TREE_LEAF) {
            goes_on = visit(context, down & ~TREE_LEAF);
            continue;
        }
        if (meets(query, &t->nodes[down + 1].box)) stack_push(&stack, down + 1);
        if (meets(query, &t->nodes[down].box)) stack_push(&stack, down);
    }
    stack_free(&stack);
    return goes_on;
}

bool tree_query_box(const tree *t, const fbox *query, tree_visit *visit, void *context)
{
    return walk(t, query, box_meets, visit, context);
}

bool tree_query_ray(const tree *t, const tree_ray *ray, tree_visit *visit, void *context)
{
    return walk(t, ray, ray_meets, visit, context);
}
