/* state: how meshes, bodies and their boxes lie in memory. Nothing outside of soft/ sees this.
 *
 * Features (vertices, edges, faces) stand in blocks of eight by cluster, so that one box is held against eight at once.
 * A mesh has the names, a body the boxes; both by the same numbers of blocks and nodes. */
#ifndef COLLIDED_SOFT_STATE_H
#define COLLIDED_SOFT_STATE_H

#include "soft.h"

#include "geom/simd.h"

enum { SOFT_LANES = 8, SOFT_CLUSTER = 16, SOFT_NONE = UINT32_MAX };

/* The box at both ends, in floats rounded outwards, relative to the step's origin: lowest coordinates at the start and
 * at the end, highest ones negated, so that a common box is the least of each. The fourth place is not looked at. */
enum { SOFT_LOW_START, SOFT_LOW_END, SOFT_HIGH_START, SOFT_HIGH_END, SOFT_SIDES };

typedef struct soft_box {
    four_singles at[SOFT_SIDES];
} soft_box;

typedef struct soft_lanes { /* eight boxes, [side * 3 + axis]; an empty place is apart from everything */
    float at[SOFT_SIDES * 3][SOFT_LANES];
} soft_lanes;

typedef struct soft_block {                         /* the features of these boxes; SOFT_NONE: an empty place */
    uint32_t id[SOFT_LANES], vertex[3][SOFT_LANES]; /* of an edge and a vertex the last ones repeat */
} soft_block;

typedef enum soft_feature { SOFT_FACES, SOFT_EDGES, SOFT_VERTICES, SOFT_FEATURES } soft_feature;

typedef struct soft_cluster {
    uint32_t first[SOFT_FEATURES]; /* block */
    uint8_t blocks[SOFT_FEATURES];
} soft_cluster;

typedef struct soft_node { /* children come after their parent */
    uint32_t left, right;  /* left == SOFT_NONE: a leaf, and right is its cluster */
    uint32_t leaves;
} soft_node;

struct soft_mesh {
    size_t vertex_count, triangle_count, edge_count, cluster_count, block_count, node_count, bytes;
    double half_thickness, rest_exclusion;
    unsigned ring;
    uint32_t (*triangles)[3], (*edges)[2];
    uint32_t (*beside)[2];  /* by edge: two triangles at it, or SOFT_NONE; the first is SOFT_NONE if there are more */
    uint32_t *around_first; /* by vertex, and one more: where its triangles begin in ... */
    uint32_t *around;
    uint32_t *near_first, *near; /* with a ring: the vertices within so many edges of a vertex, ascending, itself too */
    vec3 *rest;
    soft_cluster *clusters;
    soft_block *blocks;
    soft_node *nodes;
};

typedef struct soft_way {
    vec3 start, end;
} soft_way;

struct soft_body {
    const soft_mesh *mesh;
    double half_thickness; /* m */
    soft_way *ways;
    soft_box *vertex_boxes, *node_boxes;
    soft_lanes *boxes;    /* by block */
    vec3 lowest, highest; /* of all positions */
};

typedef struct soft_candidate { /* a pair of features, and its four points in the order of elementary.h */
    uint32_t vertex[4], a, b;
} soft_candidate;

/* ---- mesh_clusters.c ---- */

/* Cuts the triangles into clusters, makes the tree over them, and gives each vertex and edge to one triangle. The
 * centroids are those at rest. `triangle_edges`: by triangle, SOFT_NONE = it has fewer. */
void soft_mesh_cluster(soft_mesh *m, const vec3 *rest, uint32_t (*triangle_edges)[3]);

/* ---- refit.c ---- */

typedef enum soft_refit_stage {
    SOFT_REFIT_VERTICES,
    SOFT_REFIT_LEAVES,
    SOFT_REFIT_NODES,
    SOFT_REFIT_DONE
} soft_refit_stage;

typedef struct soft_refitting { /* the boxes relative to `origin`, each wider by `margin`, to `share` of the way */
    vec3 origin;
    double margin, share; /* m, and of 1 */
    soft_refit_stage stage;
    size_t from; /* of what the stage goes through */
} soft_refitting;

/* A portion of a body's boxes, of a millisecond or two; returns what it took, in units of soft_step_run. */
uint64_t soft_refit(soft_body *b, soft_refitting *r, workers *pool);

/* ---- leaves.c ---- */

/* Where candidates go, kind by kind; `full` empties a list before it overflows. */
enum { SOFT_KINDS = 3, SOFT_LIST = 512, SOFT_LIST_ROOM = SOFT_LIST + SOFT_LANES };
typedef struct soft_lists {
    soft_candidate at[SOFT_KINDS][SOFT_LIST_ROOM];
    size_t count[SOFT_KINDS];
    void (*full)(struct soft_lists *lists, soft_kind kind, void *context);
    void *context;
} soft_lists;

typedef struct soft_terms { /* what holds for all clusters of a pair of bodies */
    const soft_body *a, *b;
    bool self, without_boxes;
} soft_terms;

/* All pairs of features of two leaves whose boxes meet and which the filters let through. */
void soft_find_candidates(const soft_terms *t, uint32_t node_a, uint32_t node_b, soft_lists *out);

/* Are the boxes of two features apart? `first` has the candidate's first points. (refit.c) */
bool soft_features_apart(const soft_body *first, const soft_body *second, const soft_candidate *c, soft_kind kind);

/* ---- sift.c ---- */

/* Leaves out those that one of a few directions proves to be farther apart than the separation up to `share` of the
 * way; returns how many stay, in order. */
size_t soft_sift(soft_candidate *list, size_t count, soft_kind kind, const soft_way *a, const soft_way *b,
    double separation, double share);

/* ---- stars.c ---- */

/* Is the star of this vertex flat enough on the whole way, so that no two of its triangles meet but where they adjoin?
 */
bool soft_star_is_flat(const soft_mesh *m, const soft_way *ways, uint32_t vertex);

/* Do both features of the candidate lie in one flat star? `known`: by vertex, 0 = not looked at, 1 = flat, 2 = not. */
bool soft_in_flat_star(
    const soft_mesh *m, const soft_way *ways, const soft_candidate *c, soft_kind kind, _Atomic uint8_t *known);

/* ---- boxes ---- */

static inline soft_box soft_box_empty(void)
{
    four_singles most = {INFINITY, INFINITY, INFINITY, INFINITY};
    return (soft_box){{most, most, most, most}};
}

/* One axis and sign separates them at both ends. */
LANES_INLINE bool soft_boxes_apart(const soft_box *a, const soft_box *b)
{
    typedef int32_t four_words __attribute__((vector_size(16)));
    four_singles zero = {0, 0, 0, 0};
    four_words above =
        (a->at[SOFT_LOW_START] + b->at[SOFT_HIGH_START] > zero) & (a->at[SOFT_LOW_END] + b->at[SOFT_HIGH_END] > zero);
    four_words below =
        (b->at[SOFT_LOW_START] + a->at[SOFT_HIGH_START] > zero) & (b->at[SOFT_LOW_END] + a->at[SOFT_HIGH_END] > zero);
    four_words apart = above | below;
    return (apart[0] | apart[1] | apart[2]) != 0;
}

#endif
