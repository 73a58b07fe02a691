/* union_depth: the depth of two overlapping unions of convex polytopes, bracketed by branch and bound. Pure; any
 * thread.
 *
 * B moved by t meets A if and only if t lies inside one of the differences C = P - Q of a part P of A and a part Q of
 * B. So the depth is the distance from the origin to the nearest translation outside of all differences. The search is
 * branch and bound (Land and Doig, 1960); each node is a region of translations, and the first is all of them. The
 * point t of a region that is nearest to the origin, found by quadratic programming, is a lower bound for the region.
 * If t lies inside some C, every translation of the region outside of C lies beyond one of C's facets: the region is
 * split into one smaller region for each facet. If t lies in no C, it separates the shapes. The region with the least
 * bound is searched first, so that its bound is a lower bound of the depth at any time. */
#ifndef COLLIDED_NARROW_TREE_UNION_DEPTH_H
#define COLLIDED_NARROW_TREE_UNION_DEPTH_H

#include "narrow/pair/unit_pair.h"

enum {
    UNION_SIDE_PARTS = 64, /* of a side */
    UNION_POINTS_MAX = 2048,
    UNION_FACES_MAX = 2048,
    UNION_EDGES_MAX = 3072,
    UNION_PAIRS_MAX = 2304,
    UNION_PLANES_MAX = 8192,
    UNION_NODES_MAX = 2048,
    UNION_PLANES_A_NODE = 10
};

typedef struct union_edge {
    vec3 along;    /* of any length */
    vec3 between;  /* the normals' cross product */
    uint16_t from; /* point */
    uint16_t face[2];
} union_edge;

typedef struct union_part { /* of the side's arrays */
    vec3 lo, hi;
    uint32_t first_point, point_count, first_face, face_count, first_edge, edge_count;
    bool flat; /* a point or a segment: no faces; its one edge has no normals */
} union_part;

/* In A's frame and units of the pair. */
typedef struct union_side {
    uint32_t part_count, point_count, face_count, edge_count;
    double slack; /* the greatest slack of a part: how much smaller than the part the solid may be */
    union_part parts[UNION_SIDE_PARTS];
    vec3 points[UNION_POINTS_MAX];
    vec3 normals[UNION_FACES_MAX]; /* unit */
    double tops[UNION_FACES_MAX];  /* of the part along its face's normal */
    union_edge edges[UNION_EDGES_MAX];
} union_side;

typedef struct union_plane { /* dot(normal, t) < offset inside */
    vec3 normal;
    double offset;
} union_plane;

typedef struct union_pair {
    uint16_t part_a, part_b;
    uint32_t first, count; /* planes, once they are made */
    uint32_t last;         /* the plane that separated them the last time; before planes are made, the face */
    double depth;          /* overlap of their boxes, for one translation */
    bool made, dead;       /* dead: it lies beyond the bound, or there is no memory for its planes */
} union_pair;

typedef struct union_node {
    vec3 way;
    double length; /* a lower bound of the lengths of all translations of the region */
    uint16_t planes[UNION_PLANES_A_NODE];
    uint16_t active; /* bits: the planes that `way` lies in */
    uint8_t plane_count;
} union_node;

typedef struct union_scratch {
    union_side a, b;
    uint32_t pair_count, plane_count, node_count;
    union_pair pairs[UNION_PAIRS_MAX];
    union_plane planes[UNION_PLANES_MAX];
    union_node nodes[UNION_NODES_MAX]; /* a heap, the least length first */
} union_scratch;

/* Of meshes those that have pieces. */
static inline bool union_side_takes(shape_type type)
{
    return type == SHAPE_SPHERE || type == SHAPE_CAPSULE || type == SHAPE_BOX || type == SHAPE_HULL ||
           type == SHAPE_MESH;
}

/* The children of a compound; false: there are too many, or not all are polytopes but for their rounding. Of those only
 * the least is given. */
bool union_side_of_children(
    union_side *side, const struct compound *c, double scale, const transform *place, double *rounding);

/* The parts of a shape as a side; false: they are none, or too many, or not all polytopes. `place`: its pose, scaled,
 * or NULL: A. */
bool union_side_init(union_side *side, const shape *s, double scale, const transform *place);

/* Is it proven that B, moved by `way`, is apart? Returns the length along that direction after which it is proven, at
 * least the length of `way`, or INFINITY. */
typedef double union_try(void *context, vec3 way);

typedef struct union_bounds {
    double least;  /* no shorter translation separates */
    double length; /* of the shortest that is known to; the one given at first where none was found */
    uint32_t work;
} union_bounds;

/* `within`: a translation of that length is known. Ends when minus the bounds reach the goal, or after `work` units of
 * 10 to 30 ns; `error`: of the points of both. */
union_bounds union_depth(union_scratch *u, double within, const narrow_goal *goal, double error, uint32_t work,
    union_try *try_way, void *context);

#endif
