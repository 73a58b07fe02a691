/* The hierarchy of a mesh: triangles are halved at the median of their centres, along the longest side of the box of
 * the centres, twice a node. Any thread; the same mesh gives the same tree.
 *
 * Depth: four triangles are a leaf, the last one may have fewer, and each node hands at most a quarter of its leaves,
 * rounded up, to a child. So 4^k triangles take at most k - 1 nodes below each other, and MESH_TRIANGLES_MAX = 4^11 at
 * most 10. */
#include "mesh_steps.h"

#include "base/array.h"
#include "round.h"
#include "split.h"

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

static int compare_by_centre(const void *left, const void *right, void *axis)
{
    const item *a = left, *b = right;
    return split_compare(a->centre, b->centre, *(int *)axis, a->triangle.source, b->triangle.source);
}

/* The first half gets the larger share, and only full leaves: so there are as few nodes as can be. */
static uint32_t split_in_half(builder *b, range r)
{
    int axis = split_axis(b->items + r.first, r.count, sizeof *b->items);
    uint32_t leaves = (r.count + MESH_LEAF_MAX - 1) / MESH_LEAF_MAX;
    qsort_r(b->items + r.first, r.count, sizeof *b->items, compare_by_centre, &axis);
    return (leaves + 1) / 2 * MESH_LEAF_MAX;
}

static float float_below(double x)
{
    return -float_above(-x);
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
        n->lo[k][child] = float_below(low[k] / b->m->unit);
        n->hi[k][child] = float_above(high[k] / b->m->unit);
        n->size[child] += n->hi[k][child] - n->lo[k][child];
    }
}

static vec3 unit_corner(const builder *b, uint32_t item, int k)
{
    return vec_scale(b->m->vertices[b->items[item].triangle.v[k]], 1 / b->m->unit);
}

static vec3 across(vec3 d)
{
    vec3 least = fabs(d.x) < 0.5 ? vec(1, 0, 0) : vec(0, 1, 0);
    return vec_unit(vec_cross(d, least));
}

/* Of the longest of the triangles' sides. */
static vec3 longest_of_sides(const builder *b, range r)
{
    vec3 longest = VEC_ZERO;
    for (uint32_t i = r.first; i < r.first + r.count; i++)
        for (int k = 0; k < 3; k++) {
            vec3 side = vec_sub(unit_corner(b, i, (k + 1) % 3), unit_corner(b, i, k));
            if (vec_norm(side) > vec_norm(longest)) longest = side;
        }
    return vec_unit(longest);
}

/* Of the triangles, weighted by area, or across the longest of needles; any direction would do. */
static vec3 mean_normal(const builder *b, range r)
{
    vec3 sum = VEC_ZERO;
    for (uint32_t i = r.first; i < r.first + r.count; i++) {
        vec3 p = unit_corner(b, i, 0);
        sum = vec_add(sum, vec_cross(vec_sub(unit_corner(b, i, 1), p), vec_sub(unit_corner(b, i, 2), p)));
    }
    sum = vec_unit(sum);
    if (!(vec_max_abs(sum) > 0)) sum = across(longest_of_sides(b, r));
    return vec_max_abs(sum) > 0 ? sum : vec(0, 0, 1);
}

/* The direction across `normal` in which the corners are spread most: of the 2 x 2 matrix of their second moments. */
static vec3 longest_across(const builder *b, range r, vec3 normal, vec3 middle)
{
    vec3 u = across(normal), v = vec_cross(normal, u);
    double uu = 0, uv = 0, vv = 0;
    for (uint32_t i = r.first; i < r.first + r.count; i++)
        for (int k = 0; k < 3; k++) {
            vec3 p = vec_sub(unit_corner(b, i, k), middle);
            double x = vec_dot(p, u), y = vec_dot(p, v);
            uu += x * x, uv += x * y, vv += y * y;
        }
    double half = 0.5 * (uu - vv), root = sqrt(half * half + uv * uv);
    double x = half >= 0 ? half + root : uv, y = half >= 0 ? uv : root - half;
    return x != 0 || y != 0 ? vec_unit(vec_madd(vec_scale(u, x), y, v)) : u;
}

/* A share of the size that makes up for axes that are unit and orthogonal only as far as floats are. */
#define TURNED_SLACK 0x1p-20
/* And of the unit, for what is so much smaller than the whole mesh that floats, or doubles, underflow. */
#define TURNED_LEAST 0x1p-120

static vec3 as_floats(vec3 v)
{
    return vec((float)v.x, (float)v.y, (float)v.z);
}

static void set_turned_box(const builder *b, mesh_node *n, int child, range r)
{
    vec3 corner = unit_corner(b, r.first, 0), axes[3];
    axes[2] = as_floats(mean_normal(b, r));
    axes[0] = as_floats(longest_across(b, r, axes[2], corner));
    axes[1] = as_floats(vec_cross(axes[2], axes[0]));
    double lo[3] = {0, 0, 0}, hi[3] = {0, 0, 0}, far = 0;
    for (uint32_t i = r.first; i < r.first + r.count; i++)
        for (int k = 0; k < 3; k++) {
            vec3 p = vec_sub(unit_corner(b, i, k), corner);
            far = fmax(far, vec_norm(p));
            for (int j = 0; j < 3; j++) {
                double x = vec_dot(p, axes[j]);
                lo[j] = fmin(lo[j], x);
                hi[j] = fmax(hi[j], x);
            }
        }
    vec3 centre = corner;
    double half[3];
    for (int j = 0; j < 3; j++) {
        centre = vec_madd(centre, 0.5 * (lo[j] + hi[j]), axes[j]);
        half[j] = 0.5 * (hi[j] - lo[j]) + TURNED_SLACK * (far + vec_norm(corner)) + TURNED_LEAST;
    }
    const double c[3] = {centre.x, centre.y, centre.z}, normal[3] = {axes[2].x, axes[2].y, axes[2].z};
    for (int k = 0; k < 3; k++) {
        n->centre[k][child] = (float)c[k];
        n->normal[k][child] = (float)normal[k];
    }
    n->half[child] = float_above(half[2]);
    for (int j = 0; j < 2; j++) {
        vec3 side = vec_scale(axes[j], half[j]);
        n->side[j][0][child] = (float)side.x;
        n->side[j][1][child] = (float)side.y;
        n->side[j][2][child] = (float)side.z;
    }
}

/* Up to four parts of a range; a part of MESH_LEAF_MAX is not cut. */
static uint8_t cut(builder *b, range r, range parts[MESH_WIDTH])
{
    uint8_t count = 0;
    range halves[2] = {r, {0, 0}};
    if (r.count > MESH_LEAF_MAX) {
        uint32_t half = split_in_half(b, r);
        halves[0] = (range){r.first, half};
        halves[1] = (range){r.first + half, r.count - half};
    }
    for (int i = 0; i < 2; i++) {
        if (halves[i].count <= MESH_LEAF_MAX) {
            if (halves[i].count) parts[count++] = halves[i];
            continue;
        }
        uint32_t half = split_in_half(b, halves[i]);
        parts[count++] = (range){halves[i].first, half};
        parts[count++] = (range){halves[i].first + half, halves[i].count - half};
    }
    return count;
}

static uint32_t build_mesh_node(builder *b, range r, uint32_t depth)
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
        set_turned_box(b, &m->nodes[index], i, parts[i]);
        m->nodes[index].count[i] = leaf ? (uint8_t)parts[i].count : 0;
        m->nodes[index].first[i] = leaf ? parts[i].first : build_mesh_node(b, parts[i], depth + 1);
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
    build_mesh_node(&b, (range){0, m->triangle_count}, 1);
    for (uint32_t t = 0; t < m->triangle_count; t++) m->triangles[t] = b.items[t].triangle;
    m->nodes = base_realloc(m->nodes, m->node_count, sizeof *m->nodes);
    m->corners = base_alloc(3 * (size_t)m->triangle_count, sizeof *m->corners);
    for (uint32_t t = 0; t < m->triangle_count; t++)
        for (int k = 0; k < 3; k++) m->corners[3 * (size_t)t + (size_t)k] = mesh_corner(m, t, k);
    free(b.items);
    mesh_patches_build(m);
}

/* ---- the check ---- */

static bool box_holds(const mesh *m, const mesh_node *n, int child, vec3 v)
{
    const double at[3] = {v.x / m->unit, v.y / m->unit, v.z / m->unit};
    for (int k = 0; k < 3; k++)
        if (!((double)n->lo[k][child] <= at[k] && at[k] <= (double)n->hi[k][child])) return false;
    vec3 p = vec_sub(vec(at[0], at[1], at[2]), vec(n->centre[0][child], n->centre[1][child], n->centre[2][child]));
    for (int j = 0; j < 2; j++) {
        vec3 side = vec(n->side[j][0][child], n->side[j][1][child], n->side[j][2][child]);
        if (!(fabs(vec_dot(p, side)) <= vec_norm2(side))) return false;
    }
    vec3 normal = vec(n->normal[0][child], n->normal[1][child], n->normal[2][child]);
    return fabs(vec_dot(p, normal)) <= (double)n->half[child];
}

/* No higher than the points that stand for the patch, in a few directions. */
static bool points_hold(const mesh *m, const mesh_node *n, int child, vec3 v)
{
    vec3 at = vec_scale(v, 1 / m->unit);
    for (int k = 0; k < 27; k += 5) {
        /* NOLINTNEXTLINE(bugprone-integer-division): the digits of k to the base of three */
        vec3 d = vec_unit(vec(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
        double top = -INFINITY;
        for (uint32_t i = n->first_point; i < n->first_point + n->points; i++) {
            const mesh_patch_point *p = &m->patch_points[i];
            top = fmax(top, vec_dot(d, vec(p->at[0][child], p->at[1][child], p->at[2][child])));
        }
        if (!(vec_dot(d, at) <= top + (double)n->excess[child])) return false;
    }
    return true;
}

/* Triangles below the node in *seen; each must be within the boxes above it. */
static const char *check_mesh_node(const mesh *m, uint32_t index, uint32_t depth, uint32_t *seen)
{
    const mesh_node *n = &m->nodes[index];
    if (index >= m->node_count || depth > m->depth) return "a node is out of place";
    if (n->used < 1 || n->used > MESH_WIDTH) return "a node has no children";
    for (int i = 0; i < n->used; i++) {
        uint32_t first = *seen;
        if (n->count[i] && n->first[i] != first) return "a leaf does not follow the one before";
        *seen += n->count[i];
        const char *fault = n->count[i] ? NULL : check_mesh_node(m, n->first[i], depth + 1, seen);
        if (fault) return fault;
        for (uint32_t t = first; t < *seen && t < m->triangle_count; t++)
            for (int k = 0; k < 3; k++)
                if (!box_holds(m, n, i, mesh_corner(m, t, k)) || !points_hold(m, n, i, mesh_corner(m, t, k)))
                    return "a triangle sticks out of a box, or of the points that stand for it";
    }
    return NULL;
}

/* In the order of their first triangles, which are in their boxes. */
static const char *check_components(const mesh *m)
{
    if (m->component_count == 0 || m->components[0].triangle != 0) return "no component begins with the first triangle";
    for (uint32_t i = 0; i < m->component_count; i++) {
        const mesh_component *c = &m->components[i];
        if (i && c->triangle <= c[-1].triangle) return "a component is out of order";
        if (c->triangle >= m->triangle_count) return "a component has no triangle";
        for (int k = 0; k < 3; k++) {
            vec3 v = vec_scale(mesh_corner(m, c->triangle, k), 1 / m->unit);
            bool in = (double)c->lo[0] <= v.x && v.x <= (double)c->hi[0] && (double)c->lo[1] <= v.y &&
                      v.y <= (double)c->hi[1] && (double)c->lo[2] <= v.z && v.z <= (double)c->hi[2];
            if (!in) return "a component sticks out of its box";
        }
    }
    return NULL;
}

const char *mesh_validate(const mesh *m)
{
    uint32_t seen = 0;
    const char *fault = check_mesh_node(m, 0, 1, &seen);
    if (!fault) fault = check_components(m);
    if (!fault && seen != m->triangle_count) fault = "triangles are missing in the leaves";
    return fault ? fault : m->depth > MESH_DEPTH_MAX ? "too deep" : NULL;
}
