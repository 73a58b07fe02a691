/* tree_query: walks over a tree that nobody changes meanwhile; any number of threads. The walk keeps the nodes that it
 * has yet to enter on a stack of its own, which moves to the heap where a tree is deeper than any healthy one. */
#include "tree.h"

#include "simd.h"

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

typedef bool node_test(const void *query, const tree_node *n);

/* The fourth number read from either corner is another field of the node. */
static simd_box node_box(const tree_node *n)
{
    return simd_load_box(n->box.lo, n->box.hi);
}
static simd_box simd_box_of(const fbox *box)
{
    tree_node n = {.box = *box};
    return node_box(&n);
}

static bool box_meets(const void *query, const tree_node *n)
{
    return simd_overlap(*(const simd_box *)query, node_box(n));
}

/* Everything below a node that meets the query. Inlined into its callers, where `meets` is a constant. */
static inline __attribute__((always_inline)) bool walk(
    const tree *t, uint32_t from, const void *query, node_test *meets, tree_visit *visit, void *context)
{
    node_stack stack;
    stack_init(&stack);
    stack_push(&stack, from);
    bool goes_on = true;
    while (goes_on && stack.count > 0) { /* what is on the stack meets the query */
        uint32_t down = t->nodes[stack.at[--stack.count]].down;
        if (down & TREE_LEAF) {
            goes_on = visit(context, down & ~TREE_LEAF);
            continue;
        }
        if (stack.count + 2 > stack.capacity) stack_grow(&stack);
        stack.at[stack.count] = down + 1;
        stack.count += meets(query, &t->nodes[down + 1]);
        stack.at[stack.count] = down;
        stack.count += meets(query, &t->nodes[down]);
    }
    stack_free(&stack);
    return goes_on;
}

bool tree_query_box(const tree *t, const fbox *query, tree_visit *visit, void *context)
{
    if (t->leaf_count == 0 || !fbox_overlap(query, &t->nodes[TREE_ROOT].box)) return true;
    simd_box box = simd_box_of(query);
    return walk(t, TREE_ROOT, &box, box_meets, visit, context);
}

bool tree_query_around(const tree *t, uint32_t proxy, tree_visit *visit, void *context)
{
    const tree_node *n = t->nodes;
    uint32_t i = t->leaf_of.at[proxy];
    simd_box query = node_box(&n[i]);
    for (; n[i].parent != TREE_NONE; i = n[i].parent) {
        if (!box_meets(&query, &n[i ^ 1])) continue;
        if (!walk(t, i ^ 1, &query, box_meets, visit, context)) return false;
    }
    return true;
}
