/* The hierarchy of a compound (halved at the median of the boxes' centres along the longest side of their box). Any
 * thread. */
#include "compound.h"

#include "base/array.h"
#include "bounds.h"
#include "hull.h"
#include "round.h"
#include "split.h"
#include "support.h"

#include <stdlib.h>
#include <string.h>

typedef struct item {
    double centre[3]; /* twice */
    aabb box;
    uint32_t child;
} item;

typedef struct item_range {
    uint32_t first, count;
} item_range;

const char *compound_status_text(compound_status status)
{
    static const char *const TEXTS[] = {
        [COMPOUND_OK] = "it is well",
        [COMPOUND_EMPTY] = "it has no children",
        [COMPOUND_TOO_MANY] = "it has too many children",
        [COMPOUND_BAD_CHILD] = "a child is a half-space, a mesh or a compound",
        [COMPOUND_BAD_SIZE] = "a child's size or pose is beyond the limits",
    };
    return TEXTS[status];
}

/* ---- the hierarchy ---- */

static int compare_children(const void *left, const void *right, void *axis)
{
    const item *a = left, *b = right;
    return split_compare(a->centre, b->centre, *(int *)axis, a->child, b->child);
}

static uint32_t build_compound_node(compound *c, item *items, item_range r)
{
    uint32_t index = c->node_count++;
    aabb box = items[r.first].box;
    for (uint32_t i = 1; i < r.count; i++) box = aabb_union(box, items[r.first + i].box);
    c->nodes[index] = (compound_node){box.lo, box.hi, 0, items[r.first].child};
    if (r.count == 1) return index;
    int axis = split_axis(items + r.first, r.count, sizeof *items);
    qsort_r(items + r.first, r.count, sizeof *items, compare_children, &axis);
    uint32_t half = (r.count + 1) / 2;
    build_compound_node(c, items, (item_range){r.first, half});
    c->nodes[index].right = build_compound_node(c, items, (item_range){r.first + half, r.count - half});
    return index;
}

static void build_tree(compound *c)
{
    item *items = base_alloc(c->child_count, sizeof *items);
    c->nodes = base_alloc(2 * (size_t)c->child_count - 1, sizeof *c->nodes);
    for (uint32_t i = 0; i < c->child_count; i++) {
        aabb b = shape_bounds(&c->children[i].shape, c->children[i].local);
        items[i] = (item){{b.lo.x + b.hi.x, b.lo.y + b.hi.y, b.lo.z + b.hi.z}, b, i};
    }
    build_compound_node(c, items, (item_range){0, c->child_count});
    free(items);
}

/* ---- building ---- */

static compound_status check_child(const shape *s, pose at)
{
    if ((unsigned)s->type >= SHAPE_CONVEX_COUNT || s->type == SHAPE_HALFSPACE) return COMPOUND_BAD_CHILD;
    bool placed = vec_finite(at.p) && vec_max_abs(at.p) <= SHAPE_SIZE_MAX;
    double norm2 = quat_norm2(at.q);
    return !shape_check(s) && placed && norm2 > 0 && isfinite(norm2) ? COMPOUND_OK : COMPOUND_BAD_SIZE;
}

static bool is_identity(pose p)
{
    return p.p.x == 0 && p.p.y == 0 && p.p.z == 0 && p.q.w == 1 && p.q.x == 0 && p.q.y == 0 && p.q.z == 0;
}

static void add_child(compound *c, const shape *s, pose at)
{
    pose local = {at.p, quat_unit(at.q)};
    c->children[c->child_count++] = (compound_child){*s, local, pose_transform(local), is_identity(local)};
    c->reach = fmax(c->reach, add_up(length_up(at.p), shape_reach(s)));
    c->excess = fmax(c->excess, shape_excess(s));
}

compound_status compound_build(const shape *shapes, const pose *locals, size_t count, compound **out)
{
    *out = NULL;
    if (count == 0) return COMPOUND_EMPTY;
    if (count > COMPOUND_CHILDREN_MAX) return COMPOUND_TOO_MANY;
    for (size_t i = 0; i < count; i++) {
        compound_status status = check_child(&shapes[i], locals[i]);
        if (status != COMPOUND_OK) return status;
    }
    compound *c = base_zalloc(1, sizeof *c);
    c->children = base_alloc(count, sizeof *c->children);
    for (size_t i = 0; i < count; i++) add_child(c, &shapes[i], locals[i]);
    build_tree(c);
    *out = c;
    return COMPOUND_OK;
}

compound *compound_copy(const compound *c)
{
    compound *out = base_alloc(1, sizeof *out);
    *out = *c;
    out->children = base_alloc(c->child_count, sizeof *out->children);
    out->nodes = base_alloc(c->node_count, sizeof *out->nodes);
    memcpy(out->children, c->children, c->child_count * sizeof *out->children);
    memcpy(out->nodes, c->nodes, c->node_count * sizeof *out->nodes);
    return out;
}

void compound_destroy(compound *c)
{
    if (!c) return;
    free(c->children);
    free(c->nodes);
    free(c);
}

static bool same_child(const compound_child *a, const compound_child *b)
{
    quat p = a->local.q, q = b->local.q;
    return a->shape.type == b->shape.type && a->shape.radius == b->shape.radius &&
           a->shape.deviation == b->shape.deviation && vec_equal(a->shape.half, b->shape.half) &&
           a->shape.hull == b->shape.hull && vec_equal(a->local.p, b->local.p) && p.w == q.w && p.x == q.x &&
           p.y == q.y && p.z == q.z;
}

bool compound_equal(const compound *a, const compound *b)
{
    if (a->child_count != b->child_count) return false;
    for (uint32_t i = 0; i < a->child_count; i++)
        if (!same_child(&a->children[i], &b->children[i])) return false;
    return true;
}

/* ---- the check ---- */

static const char *check_compound_node(const compound *c, uint32_t index, uint32_t depth, bool *seen)
{
    const compound_node *n = &c->nodes[index];
    aabb box = {n->lo, n->hi};
    if (depth > COMPOUND_DEPTH_MAX) return "too deep";
    if (!n->right) {
        if (n->child >= c->child_count || seen[n->child]) return "a leaf has no child of its own";
        const compound_child *child = &c->children[n->child];
        seen[n->child] = true;
        return aabb_contains(box, shape_bounds(&child->shape, child->local)) ? NULL : "a child sticks out of its box";
    }
    if (n->right <= index + 1 || n->right >= c->node_count) return "a node is out of place";
    const uint32_t parts[2] = {index + 1, n->right};
    for (int i = 0; i < 2; i++) {
        const char *fault = check_compound_node(c, parts[i], depth + 1, seen);
        if (fault) return fault;
        if (!aabb_contains(box, (aabb){c->nodes[parts[i]].lo, c->nodes[parts[i]].hi})) return "a box sticks out";
    }
    return NULL;
}

const char *compound_validate(const compound *c)
{
    bool seen[COMPOUND_CHILDREN_MAX] = {false};
    const char *fault = check_compound_node(c, 0, 1, seen);
    for (uint32_t i = 0; i < c->child_count && !fault; i++)
        if (!seen[i]) fault = "a child is in no leaf";
    return fault;
}
