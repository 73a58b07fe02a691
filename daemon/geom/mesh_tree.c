/* The hierarchy of a mesh: triangles are halved at the median of their centres, along the longest side of the box of
 * the centres, twice a node. Any thread; the same mesh gives the same tree.
 *
 * Depth: each node hands at most a quarter of its triangles, rounded up, to a child, and four triangles are a leaf. So
 * 4^k triangles take at most k - 1 nodes below each other, and MESH_TRIANGLES_MAX = 4^11 at most 10. */
#include "mesh_steps.h"

#include "base/array.h"
#include "round.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

typedef struct item {
    double centre[3]; /* sum of the corners */
    mesh_triangle triangle;
} item;

typedef struct builder {
    mesh *m;
    item *items;
} builder;

typedef struct range {
    uint32_t first, count;
} range;

static int compare_items(const void *left, const void *right, void *axis)
{
    const item *a = left, *b = right;
    int k = *(int *)axis;
    if (a->centre[k] != b->centre[k]) return a->centre[k] < b->centre[k] ? -1 : 1;
    return (a->triangle.source > b->triangle.source) - (a->triangle.source < b->triangle.source);
}

static int longest_side(const item *items, uint32_t count)
{
    int longest = 0;
    double length = -1;
    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;
        for (uint32_t i = 0; i < count; i++) {
            lo = fmin(lo, items[i].centre[k]);
            hi = fmax(hi, items[i].centre[k]);
        }
        if (hi - lo > length) length = hi - lo, longest = k;
    }
    return longest;
}

/* The first half gets the larger share. */
static uint32_t halve(builder *b, range r)
{
    int axis = longest_side(b->items + r.first, r.count);
    qsort_r(b->items + r.first, r.count, sizeof *b->items, compare_items, &axis);
    return (r.count + 1) / 2;
}

static float down(double x)
{
    float f = (float)x;
    return (double)f > x ? nextafterf(f, -INFINITY) : f;
}

static float up(double x)
{
    return -down(-x);
}

static void set_box(const builder *b, mesh_node *n, int child, range r)
{
    vec3 lo = vec(INFINITY, INFINITY, INFINITY), hi = vec_neg(lo);
    for (uint32_t i = r.first; i < r.first + r.count; i++) {
        for (int k = 0; k < 3; k++) {
            vec3 v = b->m->vertices[b->items[i].triangle.v[k]];
            lo = vec_min(lo, v);
            hi = vec_max(hi, v);
        }
    }
    const double low[3] = {lo.x, lo.y, lo.z}, high[3] = {hi.x, hi.y, hi.z};
    for (int k = 0; k < 3; k++) {
        n->lo[k][child] = down(low[k] / b->m->unit);
        n->hi[k][child] = up(high[k] / b->m->unit);
    }
}

static vec3 unit_corner(const builder *b, uint32_t item, int k)
{
    return vec_scale(b->m->vertices[b->items[item].triangle.v[k]], 1 / b->m->unit);
}

/* Any direction makes a true plane; the mean normal, weighted by area, makes a low one. */
static void set_plane(const builder *b, mesh_node *n, int child, range r)
{
    vec3 sum = VEC_ZERO;
    for (uint32_t i = r.first; i < r.first + r.count; i++) {
        vec3 p = unit_corner(b, i, 0);
        sum = vec_add(sum, vec_cross(vec_sub(unit_corner(b, i, 1), p), vec_sub(unit_corner(b, i, 2), p)));
    }
    sum = vec_unit(sum);
    const float normal[3] = {(float)sum.x, (float)sum.y, (float)sum.z};
    const vec3 exact = {normal[0], normal[1], normal[2]}; /* the plane is that of what is stored */
    double top = -INFINITY;
    for (uint32_t i = r.first; i < r.first + r.count; i++)
        for (int k = 0; k < 3; k++) top = fmax(top, vec_dot(exact, unit_corner(b, i, k)));
    for (int k = 0; k < 3; k++) n->normal[k][child] = normal[k];
    n->top[child] = up(top + 8 * ROUND_U);
}

/* Up to four parts of a range; a part of MESH_LEAF_MAX is not cut. */
static uint8_t cut(builder *b, range r, range parts[MESH_WIDTH])
{
    uint8_t count = 0;
    range halves[2] = {r, {0, 0}};
    if (r.count > MESH_LEAF_MAX) {
        uint32_t half = halve(b, r);
        halves[0] = (range){r.first, half};
        halves[1] = (range){r.first + half, r.count - half};
    }
    for (int i = 0; i < 2; i++) {
        if (halves[i].count <= MESH_LEAF_MAX) {
            if (halves[i].count) parts[count++] = halves[i];
            continue;
        }
        uint32_t half = halve(b, halves[i]);
        parts[count++] = (range){halves[i].first, half};
        parts[count++] = (range){halves[i].first + half, halves[i].count - half};
    }
    return count;
}

static uint32_t build_node(builder *b, range r, uint32_t depth)
{
    mesh *m = b->m;
    range parts[MESH_WIDTH];
    uint32_t index = m->node_count++;
    uint8_t used = cut(b, r, parts);
    assert(depth <= MESH_DEPTH_MAX);
    if (depth > m->depth) m->depth = depth;
    memset(&m->nodes[index], 0, sizeof *m->nodes);
    m->nodes[index].used = used;
    for (int i = 0; i < used; i++) {
        bool leaf = parts[i].count <= MESH_LEAF_MAX;
        set_box(b, &m->nodes[index], i, parts[i]);
        set_plane(b, &m->nodes[index], i, parts[i]);
        m->nodes[index].count[i] = leaf ? (uint8_t)parts[i].count : 0;
        m->nodes[index].first[i] = leaf ? parts[i].first : build_node(b, parts[i], depth + 1);
    }
    return index;
}

static void sum_corners(const mesh *m, uint32_t t, double out[3])
{
    vec3 sum = VEC_ZERO;
    for (int k = 0; k < 3; k++) sum = vec_add(sum, vec_scale(mesh_corner(m, t, k), 1 / m->unit));
    out[0] = sum.x;
    out[1] = sum.y;
    out[2] = sum.z;
}

void mesh_tree_build(mesh *m)
{
    builder b = {m, base_alloc(m->triangle_count, sizeof *b.items)};
    for (uint32_t t = 0; t < m->triangle_count; t++) {
        b.items[t].triangle = m->triangles[t];
        sum_corners(m, t, b.items[t].centre);
    }
    /* an inner node has at least two children, so there are fewer of them than triangles */
    m->nodes = base_alloc(m->triangle_count, sizeof *m->nodes);
    build_node(&b, (range){0, m->triangle_count}, 1);
    for (uint32_t t = 0; t < m->triangle_count; t++) m->triangles[t] = b.items[t].triangle;
    m->nodes = base_realloc(m->nodes, m->node_count, sizeof *m->nodes);
    free(b.items);
}

/* ---- the check ---- */

static bool box_holds(const mesh *m, const mesh_node *n, int child, vec3 v)
{
    const double at[3] = {v.x / m->unit, v.y / m->unit, v.z / m->unit};
    for (int k = 0; k < 3; k++)
        if (!((double)n->lo[k][child] <= at[k] && at[k] <= (double)n->hi[k][child])) return false;
    double height = 0;
    for (int k = 0; k < 3; k++) height += (double)n->normal[k][child] * at[k];
    return height <= (double)n->top[child];
}

/* Triangles below the node in *seen; each must be within the boxes above it. */
static const char *check_node(const mesh *m, uint32_t index, uint32_t depth, uint32_t *seen)
{
    const mesh_node *n = &m->nodes[index];
    if (index >= m->node_count || depth > m->depth) return "a node is out of place";
    if (n->used < 1 || n->used > MESH_WIDTH) return "a node has no children";
    for (int i = 0; i < n->used; i++) {
        uint32_t first = *seen;
        if (n->count[i] && n->first[i] != first) return "a leaf does not follow the one before";
        *seen += n->count[i];
        const char *fault = n->count[i] ? NULL : check_node(m, n->first[i], depth + 1, seen);
        if (fault) return fault;
        for (uint32_t t = first; t < *seen && t < m->triangle_count; t++)
            for (int k = 0; k < 3; k++)
                if (!box_holds(m, n, i, mesh_corner(m, t, k))) return "a triangle sticks out of a box";
    }
    return NULL;
}

const char *mesh_validate(const mesh *m)
{
    uint32_t seen = 0;
    const char *fault = check_node(m, 0, 1, &seen);
    if (!fault && seen != m->triangle_count) fault = "triangles are missing in the leaves";
    return fault ? fault : m->depth > MESH_DEPTH_MAX ? "too deep" : NULL;
}
