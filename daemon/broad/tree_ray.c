/* tree_ray: the walk along a ray, through trees that nobody changes meanwhile; any number of threads. Nodes are entered
 * in the order in which the ray meets them, as far as a stack allows: the nearer of two siblings first. So a hit
 * shortens the way before what lies behind it is looked at. (Kay and Kajiya 1986.)
 *
 * Boxes are floats, and so is the walk: four numbers at a time, products in place of quotients. It is conservative: the
 * ray's origin is rounded away from what is ahead, lengths at which a box is entered are made shorter, and those at
 * which it is left longer, by more than the roundings of a difference, a product and the factor, 2^-24 each, so that no
 * box is missed. What is visited besides is farther from the way than nothing by some 2^-20 of its length, or by what
 * rounding has added to the box itself. */
#include "tree.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- in floats ---- */

static const double SHORTER = 1 - 0x1p-21, LONGER = 1 + 0x1p-21;

/* Up to infinity, which stands for a direction that is 0, or nearly. */
static float scale_up(double scale)
{
    return scale < FLT_MAX ? fmaxf((float)scale, FLT_MIN) : INFINITY;
}

/* A length of 1 along an axis takes 1 / |d| of the way, rounded down and up. Where d is 0 what is ahead is never met,
 * and what is behind is never left. */
static void scales(double d, float *near, float *far)
{
    double scale = 1 / fabs(d);
    *near = (float)fmin(scale * SHORTER, d == 0 ? INFINITY : FLT_MAX);
    *far = scale_up(scale * LONGER);
}

tree_slabs tree_slabs_of(const tree_ray *ray)
{
    float near_from[3], near_scale[3], far_from[3], far_scale[3];
    bool forward[3];
    for (int k = 0; k < 3; k++) {
        float lo = float_down(ray->lo[k]), hi = float_up(ray->hi[k]);
        forward[k] = ray->direction[k] >= 0;
        near_from[k] = forward[k] ? hi : lo;
        far_from[k] = forward[k] ? lo : hi;
        scales(ray->direction[k], &near_scale[k], &far_scale[k]);
        if (!forward[k]) near_scale[k] = -near_scale[k], far_scale[k] = -far_scale[k];
    }
    tree_slabs s = {simd_make_ray(near_from, near_scale, far_from, far_scale, forward), INFINITY};
    tree_slabs_end(&s, ray->length);
    return s;
}

void tree_slabs_end(tree_slabs *s, double length)
{
    s->far = length < 0 ? -1 : float_up(length);
}

bool tree_slabs_meet(const tree_slabs *s, const fbox *box)
{
    tree_node n = {.box = *box}; /* the fourth number of either corner is another field of the node */
    return simd_enters(&s->ray, simd_load_box(n.box.lo, n.box.hi), s->far) < INFINITY;
}

/* ---- the walk ---- */

enum { SHALLOW = 120 }; /* steps; a balanced tree of 2^100 leaves needs fewer */

typedef struct ray_step { /* a node to be entered */
    const tree_node *nodes;
    uint32_t down; /* the node's */
    float from;    /* the length at which the ray meets its box */
} ray_step;

typedef struct ray_stack {
    ray_step *at;
    size_t count, capacity;
    ray_step shallow[SHALLOW];
} ray_stack;

static void grow(ray_stack *s)
{
    ray_step *deep = base_alloc(s->capacity * 2, sizeof *deep);
    memcpy(deep, s->at, s->count * sizeof *deep);
    if (s->at != s->shallow) free(s->at);
    s->at = deep;
    s->capacity *= 2;
}

/* Most of the time goes into waiting for nodes: what lies below is asked for before it is known whether the ray meets
 * it. (Below a leaf it is some other node, which does no harm.) */
static inline ray_step ray_step_to(const tree_slabs *s, const tree_node *nodes, uint32_t node)
{
    const tree_node *n = &nodes[node];
    __builtin_prefetch(&nodes[n->down & ~TREE_LEAF]);
    return (ray_step){nodes, n->down, simd_enters(&s->ray, simd_load_box(n->box.lo, n->box.hi), s->far)};
}

static inline void put_by(ray_stack *stack, ray_step step)
{
    if (stack->count == stack->capacity) grow(stack);
    stack->at[stack->count++] = step;
}

/* The node to be entered next. False: there is none. */
static inline bool take_up(ray_stack *stack, const tree_slabs *s, ray_step *step)
{
    while (stack->count > 0) {
        *step = stack->at[--stack->count];
        if (step->from <= s->far) return true;
    }
    return false;
}

/* From an inner node to the nearer of its children, or to what was put by. */
static inline bool go_down(ray_stack *stack, const tree_slabs *s, ray_step *step)
{
    ray_step one = ray_step_to(s, step->nodes, step->down), other = ray_step_to(s, step->nodes, step->down + 1);
    bool meets_one = one.from < INFINITY, meets_other = other.from < INFINITY;
    if (!meets_one && !meets_other) return take_up(stack, s, step);
    bool exchanged = other.from < one.from;
    if (meets_one && meets_other) put_by(stack, exchanged ? one : other);
    *step = exchanged ? other : one;
    return true;
}

void tree_query_ray(const tree *const trees[], size_t count, tree_slabs *slabs, tree_ray_visit *visit, void *context)
{
    ray_stack stack;
    ray_step step;
    stack.count = 0;
    stack.capacity = SHALLOW;
    stack.at = stack.shallow;
    for (size_t i = 0; i < count; i++) {
        if (!trees[i]->leaf_count) continue;
        step = ray_step_to(slabs, trees[i]->nodes, TREE_ROOT);
        if (step.from < INFINITY) put_by(&stack, step);
    }
    bool more = take_up(&stack, slabs, &step);
    while (more) {
        if (step.down & TREE_LEAF) {
            tree_slabs_end(slabs, visit(context, step.down & ~TREE_LEAF));
            more = take_up(&stack, slabs, &step);
        } else {
            more = go_down(&stack, slabs, &step);
        }
    }
    if (stack.at != stack.shallow) free(stack.at);
}
