/* Support vertices of hulls. Pure but for hull_tree_build; any thread.
 *
 * Small hulls are scanned. Large ones have a tree of boxes over their vertices, searched by branch and bound from the
 * hint. Hill climbing over the edges would be quicker still, but on faces that are flat only to rounding it may stop at
 * a neighbour of the true maximum, and the answer would then depend on the hint. */
#include "hull_support.h"

#include "base/array.h"
#include "hull_scan.h"

#include <stdlib.h>

enum {
    LEAF_MAX = 8,  /* vertices */
    TREE_MIN = 64, /* vertices; below, a scan is at least as quick */
};

static double height_of_vertex(const hull *h, uint32_t i, vec3 d)
{
    return h->x[i] * d.x + h->y[i] * d.y + h->z[i] * d.z;
}

/* Rounding is monotone: no vertex in the box has a computed height above the one computed for the box's corner. So the
 * bound needs no allowance, and what is skipped cannot hold the answer. */
static double height_bound(const hull_node *n, vec3 d)
{
    return (d.x >= 0 ? n->hi.x : n->lo.x) * d.x + (d.y >= 0 ? n->hi.y : n->lo.y) * d.y +
           (d.z >= 0 ? n->hi.z : n->lo.z) * d.z;
}

/* Without a hint: a vertex of the leaf that the higher box leads to each time. */
static uint32_t descend(const hull *h, vec3 d)
{
    uint32_t i = 0;
    while (h->nodes[i].count == 0) {
        uint32_t left = i + 1, right = h->nodes[left].skip;
        i = height_bound(&h->nodes[right], d) > height_bound(&h->nodes[left], d) ? right : left;
    }
    return h->node_vertices[h->nodes[i].first];
}

static uint32_t search(const hull *h, vec3 d, uint32_t start)
{
    uint32_t best = start;
    double most = height_of_vertex(h, start, d);
    for (uint32_t i = 0; i < h->node_count;) {
        const hull_node *n = &h->nodes[i];
        double bound = height_bound(n, d);
        if (bound < most || (bound == most && n->least >= best)) {
            i = n->skip;
            continue;
        }
        for (uint32_t k = n->first; k < n->first + n->count; k++) {
            uint32_t v = h->node_vertices[k];
            double height = height_of_vertex(h, v, d);
            if (height > most || (height == most && v < best)) {
                most = height;
                best = v;
            }
        }
        i++;
    }
    return best;
}

uint32_t hull_support(const hull *h, vec3 direction, uint32_t start)
{
    if (h->node_count == 0) return hull_scan(h, direction);
    return search(h, direction, start < h->vertex_count ? start : descend(h, direction));
}

static int compare_along(const void *left, const void *right, void *coordinates)
{
    uint32_t i = *(const uint32_t *)left, j = *(const uint32_t *)right;
    double a = ((const double *)coordinates)[i], b = ((const double *)coordinates)[j];
    if (a != b) return a < b ? -1 : 1;
    return (i > j) - (i < j);
}

static void split_at_median(hull *h, const hull_node *n, uint32_t first, uint32_t count)
{
    vec3 size = vec_sub(n->hi, n->lo);
    double *along = size.z > fmax(size.x, size.y) ? h->z : size.y > size.x ? h->y : h->x;
    qsort_r(h->node_vertices + first, count, sizeof *h->node_vertices, compare_along, along);
}

/* A node and all below it, in the order of a walk that takes parents first. */
static void add_node(hull *h, uint32_t first, uint32_t count)
{
    hull_node *n = &h->nodes[h->node_count++];
    *n = (hull_node){{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}, first, count, UINT32_MAX, 0};
    for (uint32_t k = first; k < first + count; k++) {
        uint32_t v = h->node_vertices[k];
        n->lo = vec_min(n->lo, hull_vertex(h, v));
        n->hi = vec_max(n->hi, hull_vertex(h, v));
        if (v < n->least) n->least = v;
    }
    if (count > LEAF_MAX) {
        n->count = 0;
        split_at_median(h, n, first, count);
        add_node(h, first, count / 2);
        add_node(h, first + count / 2, count - count / 2);
    }
    n->skip = h->node_count;
}

void hull_tree_build(hull *h)
{
    if (h->vertex_count < TREE_MIN) return;
    h->nodes = base_alloc(h->vertex_count, sizeof *h->nodes); /* a leaf holds four or more: nodes are fewer */
    h->node_vertices = base_alloc(h->vertex_count, sizeof *h->node_vertices);
    for (uint32_t i = 0; i < h->vertex_count; i++) h->node_vertices[i] = i;
    add_node(h, 0, h->vertex_count);
}
