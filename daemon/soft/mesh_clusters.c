/* mesh_clusters: cuts the triangles of a mesh into clusters of at most sixteen that lie together at rest, with a binary
 * tree over them, and gives each vertex and each edge to one triangle (representative triangles: Curtis, Tamstorf and
 * Manocha 2008). A leaf's features stand in blocks of eight. Any thread. */
#include "state.h"

#include "base/array.h"

#include <stdlib.h>
#include <string.h>

typedef struct cut {
    soft_mesh *mesh;
    vec3 *centre; /* by triangle: three times its centroid */
    uint32_t *order, nodes, clusters;
    size_t *begin; /* by cluster: its first triangle in `order` */
} cut;

static double along(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static bool comes_before(const cut *c, int axis, uint32_t a, uint32_t b)
{
    double x = along(c->centre[a], axis), y = along(c->centre[b], axis);
    return x < y || (x == y && a < b);
}

static int widest_axis(const cut *c, size_t begin, size_t end)
{
    vec3 low = c->centre[c->order[begin]], high = low;
    for (size_t i = begin + 1; i < end; i++) {
        low = vec_min(low, c->centre[c->order[i]]);
        high = vec_max(high, c->centre[c->order[i]]);
    }
    vec3 w = vec_sub(high, low);
    return w.x >= w.y && w.x >= w.z ? 0 : w.y >= w.z ? 1 : 2;
}

/* Hoare's selection: the first ones of [begin, end) along the axis come before `at`. All keys differ. */
static void select_first(cut *c, int axis, size_t begin, size_t end, size_t at)
{
    uint32_t *o = c->order;
    while (end - begin > 1) {
        uint32_t pivot = o[begin + (end - begin) / 2];
        size_t i = begin, k = end - 1;
        for (;;) {
            while (comes_before(c, axis, o[i], pivot)) i++;
            while (comes_before(c, axis, pivot, o[k])) k--;
            if (i >= k) break;
            uint32_t kept = o[i];
            o[i++] = o[k], o[k--] = kept;
        }
        size_t middle = i > begin ? i : begin + 1; /* [begin, i) <= pivot <= [i, end) */
        if (at < middle)
            end = middle;
        else
            begin = middle;
        if (at == begin) {
            size_t least = begin;
            for (size_t j = begin + 1; j < end; j++)
                if (comes_before(c, axis, o[j], o[least])) least = j;
            uint32_t kept = o[begin];
            o[begin] = o[least], o[least] = kept;
            return;
        }
    }
}

/* Halves by number of leaves, so that all but a few are full. Depth: the logarithm of their number. */
static uint32_t cut_node(cut *c, size_t begin, size_t end, uint32_t leaves)
{
    uint32_t self = c->nodes++;
    soft_node *n = &c->mesh->nodes[self];
    n->leaves = leaves;
    if (leaves == 1) {
        n->left = SOFT_NONE, n->right = c->clusters;
        c->begin[c->clusters++] = begin;
        return self;
    }
    uint32_t half = leaves / 2;
    size_t middle = begin + (end - begin) * half / leaves;
    select_first(c, widest_axis(c, begin, end), begin, end, middle);
    n->left = cut_node(c, begin, middle, half);
    n->right = cut_node(c, middle, end, leaves - half);
    return self;
}

/* ---- blocks ---- */

typedef struct owners {
    soft_mesh *mesh;
    uint8_t *vertex_owned, *edge_owned;
    ARRAY(soft_block) blocks;
} owners;

static void put(owners *o, soft_cluster *c, soft_feature kind, unsigned *count, uint32_t id, const uint32_t v[3])
{
    if (*count % SOFT_LANES == 0) {
        soft_block empty;
        memset(&empty, 0xff, sizeof empty); /* SOFT_NONE */
        if (*count == 0) c->first[kind] = (uint32_t)o->blocks.count;
        array_push(&o->blocks, empty);
        c->blocks[kind]++;
    }
    soft_block *b = &o->blocks.at[o->blocks.count - 1];
    unsigned lane = (*count)++ % SOFT_LANES;
    b->id[lane] = id;
    for (int k = 0; k < 3; k++) b->vertex[k][lane] = v[k];
}

static void put_faces(owners *o, soft_cluster *c, const uint32_t *triangles, size_t count)
{
    unsigned put_already = 0;
    for (size_t i = 0; i < count; i++) {
        const uint32_t *t = o->mesh->triangles[triangles[i]];
        if (t[0] != t[1] && t[1] != t[2] && t[2] != t[0]) put(o, c, SOFT_FACES, &put_already, triangles[i], t);
    }
}

static void put_edges(
    owners *o, soft_cluster *c, const uint32_t *triangles, size_t count, uint32_t (*triangle_edges)[3])
{
    unsigned put_already = 0;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t e = triangle_edges[triangles[i]][k];
            if (e == SOFT_NONE || o->edge_owned[e]) continue;
            o->edge_owned[e] = 1;
            const uint32_t *ends = o->mesh->edges[e];
            put(o, c, SOFT_EDGES, &put_already, e, (uint32_t[3]){ends[0], ends[1], ends[1]});
        }
}

static void put_vertices(owners *o, soft_cluster *c, const uint32_t *triangles, size_t count)
{
    unsigned put_already = 0;
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) {
            uint32_t v = o->mesh->triangles[triangles[i]][k];
            if (o->vertex_owned[v]) continue;
            o->vertex_owned[v] = 1;
            put(o, c, SOFT_VERTICES, &put_already, v, (uint32_t[3]){v, v, v});
        }
}

static void make_blocks(soft_mesh *m, const cut *c, uint32_t (*triangle_edges)[3])
{
    owners o = {.mesh = m};
    o.vertex_owned = base_zalloc(m->vertex_count, 1);
    o.edge_owned = base_zalloc(m->edge_count + 1, 1);
    for (size_t i = 0; i < m->cluster_count; i++) {
        size_t begin = c->begin[i], end = i + 1 < m->cluster_count ? c->begin[i + 1] : m->triangle_count;
        put_faces(&o, &m->clusters[i], c->order + begin, end - begin);
        put_edges(&o, &m->clusters[i], c->order + begin, end - begin, triangle_edges);
        put_vertices(&o, &m->clusters[i], c->order + begin, end - begin);
    }
    m->block_count = o.blocks.count;
    m->blocks = base_realloc(o.blocks.at, o.blocks.count, sizeof *m->blocks);
    m->bytes += m->block_count * sizeof *m->blocks;
    free(o.vertex_owned), free(o.edge_owned);
}

void soft_mesh_cluster(soft_mesh *m, const vec3 *rest, uint32_t (*triangle_edges)[3])
{
    size_t n = m->triangle_count;
    m->cluster_count = (n + SOFT_CLUSTER - 1) / SOFT_CLUSTER;
    m->node_count = 2 * m->cluster_count - 1;
    m->nodes = base_zalloc(m->node_count, sizeof *m->nodes);
    m->clusters = base_zalloc(m->cluster_count, sizeof *m->clusters);
    m->bytes += m->node_count * sizeof *m->nodes + m->cluster_count * sizeof *m->clusters;
    cut c = {.mesh = m, .centre = base_alloc(n, sizeof *c.centre), .order = base_alloc(n, sizeof *c.order)};
    c.begin = base_alloc(m->cluster_count, sizeof *c.begin);
    for (size_t i = 0; i < n; i++) {
        const uint32_t *t = m->triangles[i];
        c.centre[i] = vec_add(rest[t[0]], vec_add(rest[t[1]], rest[t[2]]));
        c.order[i] = (uint32_t)i;
    }
    cut_node(&c, 0, n, (uint32_t)m->cluster_count);
    make_blocks(m, &c, triangle_edges);
    free(c.centre), free(c.order), free(c.begin);
}
