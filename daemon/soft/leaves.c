/* leaves: which features of two clusters may meet: their boxes do, and no filter keeps them apart (a common vertex, the
 * ring of edges, the distance at rest). Eight boxes are held against one at a time. Any thread.
 *
 * Each vertex and each edge stands in one cluster, so no pair comes twice. A pair whose owners are filtered is looked
 * at like any other: filters are asked of the features, never of their triangles. */
#include "elementary.h"
#include "simd.h"
#include "state.h"

#include "geom/simd.h"

#include <stdlib.h>

/* ---- boxes ---- */

LANES_INLINE singles side_of(const soft_lanes *b, int side, int axis)
{
    return *(const singles_anywhere *)b->at[side * 3 + axis];
}

LANES_INLINE singles same(float x)
{
    return (singles){x, x, x, x, x, x, x, x};
}

/* One box in memory: so many floats from one side to the next, and from one axis to the next. */
typedef struct one_box {
    const float *at;
    int side, axis;
} one_box;

/* Bit k: box k of the block is not apart from the one. */
LANES_INLINE unsigned meeting(const soft_lanes *b, one_box one)
{
    words apart = {0};
    singles zero = same(0);
    for (int axis = 0; axis < 3; axis++) {
        const float *at = one.at + axis * one.axis;
        singles low_start = same(at[SOFT_LOW_START * one.side]), low_end = same(at[SOFT_LOW_END * one.side]);
        singles high_start = same(at[SOFT_HIGH_START * one.side]), high_end = same(at[SOFT_HIGH_END * one.side]);
        apart |=
            (side_of(b, SOFT_LOW_START, axis) + high_start > zero) & (side_of(b, SOFT_LOW_END, axis) + high_end > zero);
        apart |=
            (low_start + side_of(b, SOFT_HIGH_START, axis) > zero) & (low_end + side_of(b, SOFT_HIGH_END, axis) > zero);
    }
    return ~words_bits(apart) & 0xff;
}

LANES_INLINE one_box box_of_lane(const soft_lanes *b, int lane)
{
    return (one_box){&b->at[0][lane], 3 * SOFT_LANES, SOFT_LANES};
}

LANES_INLINE one_box box_of_node(const soft_box *b)
{
    return (one_box){(const float *)&b->at[0], 4, 1};
}

LANES_INLINE words names_of(const soft_block *b, int corner)
{
    return *(const words_anywhere *)b->vertex[corner];
}

LANES_INLINE words all_words(uint32_t x)
{
    int32_t w = (int32_t)x;
    return (words){w, w, w, w, w, w, w, w};
}

/* Bit k: feature k of the block has a vertex in common with the lane of the other. */
LANES_INLINE unsigned sharing(const soft_block *b, int corners_b, const soft_block *a, int corners_a, int lane)
{
    words shared = {0};
    for (int i = 0; i < corners_a; i++)
        for (int k = 0; k < corners_b; k++) shared |= names_of(b, k) == all_words(a->vertex[i][lane]);
    return words_bits(shared);
}

static unsigned filled(const soft_block *b)
{
    unsigned bits = 0;
    for (int k = 0; k < SOFT_LANES; k++) bits |= (unsigned)(b->id[k] != SOFT_NONE) << k;
    return bits;
}

/* ---- filters of one body with itself ---- */

static bool within_ring(const soft_mesh *m, uint32_t a, uint32_t b)
{
    uint32_t first = m->near_first[a], last = m->near_first[a + 1];
    while (first < last) {
        uint32_t middle = first + (last - first) / 2;
        if (m->near[middle] == b) return true;
        if (m->near[middle] < b)
            first = middle + 1;
        else
            last = middle;
    }
    return false;
}

static bool near_at_rest(const soft_mesh *m, const soft_candidate *c, soft_kind kind)
{
    vec3 at[4];
    double lo, hi;
    for (int i = 0; i < 4; i++) at[i] = m->rest[c->vertex[i]];
    if (kind == SOFT_EDGE_EDGE)
        elementary_edge_edge_distance(at, &lo, &hi);
    else
        elementary_vertex_face_distance(at, &lo, &hi);
    return lo <= m->rest_exclusion;
}

/* Beyond a common vertex, which `sharing` has seen already. */
static bool filtered(const soft_mesh *m, const soft_candidate *c, soft_kind kind)
{
    int of_first = kind == SOFT_EDGE_EDGE ? 2 : 1;
    for (int i = 0; m->ring > 0 && i < of_first; i++)
        for (int k = of_first; k < 4; k++)
            if (within_ring(m, c->vertex[i], c->vertex[k])) return true;
    return m->rest_exclusion > 0 && near_at_rest(m, c, kind);
}

/* ---- pairs of blocks ---- */

typedef struct side { /* the blocks of one kind of feature in a cluster, and which of them meet the other cluster's box
                       */
    const soft_block *names;
    const soft_lanes *boxes;
    unsigned count, meets[3 * SOFT_CLUSTER / SOFT_LANES], any;
} side;

LANES_INLINE void look_at(
    const soft_terms *t, const soft_body *b, uint32_t cluster, soft_feature kind, const soft_box *other, side *out)
{
    const soft_cluster *c = &b->mesh->clusters[cluster];
    out->names = b->mesh->blocks + c->first[kind], out->boxes = b->boxes + c->first[kind];
    out->count = c->blocks[kind], out->any = 0;
    for (unsigned i = 0; i < out->count; i++) {
        out->meets[i] = t->without_boxes ? filled(&out->names[i]) : meeting(&out->boxes[i], box_of_node(other));
        out->any |= out->meets[i];
    }
}

static void offer(const soft_terms *t, soft_kind kind, const soft_candidate *c, soft_lists *out)
{
    if (t->self && filtered(t->a->mesh, c, kind)) return;
    out->at[kind][out->count[kind]++] = *c;
    if (out->count[kind] >= SOFT_LIST) out->full(out, kind, out->context);
}

/* Of body a with itself the lesser edge is told first. */
static void offer_edges(const soft_terms *t, const soft_block *a, int i, const soft_block *b, int k, soft_lists *out)
{
    soft_candidate c = {{a->vertex[0][i], a->vertex[1][i], b->vertex[0][k], b->vertex[1][k]}, a->id[i], b->id[k]};
    if (t->self && c.b < c.a) c = (soft_candidate){{c.vertex[2], c.vertex[3], c.vertex[0], c.vertex[1]}, c.b, c.a};
    offer(t, SOFT_EDGE_EDGE, &c, out);
}

static void offer_vertex(const soft_terms *t, soft_kind kind, const soft_block *vertices, int i,
    const soft_block *faces, int k, soft_lists *out)
{
    soft_candidate c = {{vertices->id[i], faces->vertex[0][k], faces->vertex[1][k], faces->vertex[2][k]},
        vertices->id[i], faces->id[k]};
    if (kind == SOFT_FACE_VERTEX) c.a = faces->id[k], c.b = vertices->id[i];
    offer(t, kind, &c, out);
}

/* `triangular`: both sides are one, and each pair is wanted once. */
LANES_INLINE void edges_with_edges(const soft_terms *t, const side *a, const side *b, bool triangular, soft_lists *out)
{
    for (unsigned i = 0; i < a->count; i++)
        for (unsigned left = a->meets[i]; left; left &= left - 1) {
            int lane = __builtin_ctz(left);
            one_box box = box_of_lane(&a->boxes[i], lane);
            for (unsigned k = triangular ? i : 0; k < b->count; k++) {
                unsigned hits = b->meets[k];
                if (triangular && k == i) hits &= ~((2u << lane) - 1);
                if (hits && !t->without_boxes) hits &= meeting(&b->boxes[k], box);
                if (hits && t->self) hits &= ~sharing(&b->names[k], 2, &a->names[i], 2, lane);
                for (; hits; hits &= hits - 1)
                    offer_edges(t, &a->names[i], lane, &b->names[k], __builtin_ctz(hits), out);
            }
        }
}

LANES_INLINE void vertices_with_faces(
    const soft_terms *t, soft_kind kind, const side *vertices, const side *faces, soft_lists *out)
{
    if (!faces->any) return;
    for (unsigned i = 0; i < vertices->count; i++)
        for (unsigned left = vertices->meets[i]; left; left &= left - 1) {
            int lane = __builtin_ctz(left);
            one_box box = box_of_lane(&vertices->boxes[i], lane);
            for (unsigned k = 0; k < faces->count; k++) {
                unsigned hits = faces->meets[k];
                if (hits && !t->without_boxes) hits &= meeting(&faces->boxes[k], box);
                if (hits && t->self) hits &= ~sharing(&faces->names[k], 3, &vertices->names[i], 1, lane);
                for (; hits; hits &= hits - 1)
                    offer_vertex(t, kind, &vertices->names[i], lane, &faces->names[k], __builtin_ctz(hits), out);
            }
        }
}

LANES_INLINE void find_candidates(const soft_terms *t, uint32_t cluster_a, uint32_t cluster_b, const soft_box *box_a,
    const soft_box *box_b, soft_lists *out)
{
    bool one = t->self && cluster_a == cluster_b;
    side edges_a, edges_b, vertices, faces;
    look_at(t, t->a, cluster_a, SOFT_EDGES, box_b, &edges_a);
    look_at(t, t->b, cluster_b, SOFT_EDGES, box_a, &edges_b);
    if (edges_a.any && edges_b.any) edges_with_edges(t, &edges_a, &edges_b, one, out);
    look_at(t, t->a, cluster_a, SOFT_VERTICES, box_b, &vertices);
    look_at(t, t->b, cluster_b, SOFT_FACES, box_a, &faces);
    vertices_with_faces(t, SOFT_VERTEX_FACE, &vertices, &faces, out);
    if (one) return;
    look_at(t, t->b, cluster_b, SOFT_VERTICES, box_a, &vertices);
    look_at(t, t->a, cluster_a, SOFT_FACES, box_b, &faces);
    vertices_with_faces(t, t->self ? SOFT_VERTEX_FACE : SOFT_FACE_VERTEX, &vertices, &faces, out);
}

LANES_TWINS(LANES_WIDE, void, candidates, find_candidates,
    (const soft_terms *t, uint32_t cluster_a, uint32_t cluster_b, const soft_box *box_a, const soft_box *box_b,
        soft_lists *out),
    (t, cluster_a, cluster_b, box_a, box_b, out));

void soft_find_candidates(const soft_terms *t, uint32_t node_a, uint32_t node_b, soft_lists *out)
{
    uint32_t cluster_a = t->a->mesh->nodes[node_a].right, cluster_b = t->b->mesh->nodes[node_b].right;
    LANES_CHOSEN(candidates)(t, cluster_a, cluster_b, &t->a->node_boxes[node_a], &t->b->node_boxes[node_b], out);
}
