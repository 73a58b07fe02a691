/* mesh_walk: all pairs of parts of two shapes that may be near each other, one of them or both a mesh.
 *
 * The parts of a mesh are its triangles; a convex core is its own only part. Both hierarchies are walked together. A
 * pair of boxes is skipped if it is proven to be farther apart than `within`, along the directions of mesh_bounds or
 * along the axis that the visitor found last. The stack of pairs is a local array whose depth follows from
 * MESH_DEPTH_MAX. The walk that goes nearest first has a queue of fixed size; pairs that do not fit are walked depth
 * first. Pure; any thread. */
#ifndef COLLIDED_NARROW_TREE_MESH_WALK_H
#define COLLIDED_NARROW_TREE_MESH_WALK_H

#include "geom/mesh_simd.h"
#include "mesh_row.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

/* ==== two shapes in their relative pose ==== */

/* What a walk over two hierarchies reads: both shapes in their relative pose, their frames and units as seen from each
 * other's boxes, the axis that skips pairs, and the parts that are visited. */

enum {
    MESH_NO_TRIANGLE = UINT32_MAX,
    MESH_WHOLE = UINT32_MAX, /* for a node: all of a convex A */
    TRIANGLE_PADDED = 8,
    MESH_STANDS = 64, /* nodes of each mesh whose heights along the current axis are kept; a power of two */
    MESH_FACES = 32,  /* nodes of A whose boxes in B's frame are kept; a power of two */
    MESH_LEAVES =
        32, /* leaves of each mesh whose triangles in the pair's frame are kept during a walk; a power of two */
    MESH_FRONT = 192 /* pairs of boxes of a mesh_front, at most */
};

/* A triangle represented as a flat hull, so that everything that takes support points takes it, too. */
typedef struct triangle_part {
    hull hull;
    double x[TRIANGLE_PADDED], y[TRIANGLE_PADDED], z[TRIANGLE_PADDED];
} triangle_part;

/* A box of a mesh, which is a child of a node. There is no box of the root, only its children. */
typedef struct mesh_box {
    uint32_t node; /* or MESH_WHOLE */
    uint16_t child;
    bool leaf; /* or all of a convex A */
} mesh_box;

/* Two boxes, and what they are apart at least, in units of the pair. */
typedef struct mesh_boxes {
    mesh_box a, b;
    double bound;
} mesh_boxes;

/* Pairs of boxes that have all parts below them which may be near: where a walk begins. */
typedef struct mesh_front {
    uint32_t count;
    mesh_boxes at[MESH_FRONT];
} mesh_front;

/* The triangles of a leaf in the pair's frame. They are computed when they are first needed, and again after another
 * leaf has taken their slot. */
typedef struct mesh_leaf {
    uint32_t first, count, aims;
    bool placed;
    double level;                 /* the greatest of A's, the least of B's */
    double levels[MESH_LEAF_MAX]; /* of each triangle; beside A a mesh 0 where there is none */
    mesh_four four;
} mesh_leaf;

/* From the frame and unit of one mesh's boxes to those of the other's. */
typedef struct mesh_turn {
    mat3 r; /* with the ratio of the units in it */
    vec3 t;
    float column[3][MESH_WIDTH], ratio; /* the rotation alone, and the ratio alone */
} mesh_turn;

/* How far the patches of a node reach along the axis, in B's unit, from B's origin. */
typedef struct mesh_stand {
    uint32_t node, aims;                  /* whose, and for which axis: mesh_walk.aims */
    _Alignas(16) float level[MESH_WIDTH]; /* of A the tops, of B the feet */
} mesh_stand;

/* The patches of a node of A as B's nodes see them. */
typedef struct mesh_faces {
    mesh_patch_box box[MESH_WIDTH];
} mesh_faces;

typedef struct mesh_walk {
    unit_pair part;                   /* the pair; after mesh_walk_dress with the visited parts for shapes */
    shape whole_a, whole_b;           /* what part.a and part.b were */
    const mesh *ma, *mb;              /* ma NULL: A is convex; B is a mesh always */
    double size_a, size_b;            /* the unit of either one's boxes, in units of the pair */
    double within;                    /* pairs of parts that are farther apart are left out; a visitor may lower it */
    vec3 axis;                        /* unit, from A to B: one that separates what is nearest; zero = none yet */
    uint32_t triangle_a, triangle_b;  /* the parts that are visited; triangle_a MESH_NO_TRIANGLE: all of A */
    const mesh_spot *spot_a, *spot_b; /* where they are */
    vec3 lead;                        /* of any length: the direction that separates them most, of those looked at */
    vec3 from, edges;                 /* of two triangles: as in mesh_row */
    uint32_t visits, aims;            /* aims: counts the axes */
    effort *effort;                   /* of the query; NULL: the walk is not counted */
    double unseen; /* after a walk: what is left out because the effort ended is no nearer; INFINITY: it did not end */
    triangle_part flat_a, flat_b;
    transform a_in_b; /* the inverse of part.b_in_a */
    vec3 b_axis;      /* the axis in B's frame */
    mesh_turn into_a, into_b;
    float axis_in_a[MESH_WIDTH], axis_in_b[MESH_WIDTH]; /* towards the boxes of either: the former points from B to A */
    float origin_level, open_slack; /* of A's frame along axis_in_b, in B's unit; of any box of A against one of B */
    bool aimed, opens_both;         /* opens_both: the meshes are of about one size, and not far apart */
    mesh_other whole_other;         /* of a convex A */
    mesh_spot whole;
    double whole_level; /* the greatest height of a convex A along the axis */
    mesh_stand stands_a[MESH_STANDS], stands_b[MESH_STANDS];
    uint32_t faced[MESH_FACES]; /* whose they are; MESH_WHOLE: none */
    mesh_faces faces_a[MESH_FACES];
    mesh_spot visited_a, visited;                        /* spot_a (of a mesh) and spot_b, while leaves are visited */
    mesh_box known_a[MESH_LEAVES], known_b[MESH_LEAVES]; /* the leaf in each slot; node MESH_WHOLE: none */
    mesh_leaf leaves_a[MESH_LEAVES], leaves_b[MESH_LEAVES];
} mesh_walk;

/* `p`: the whole pair; `a`, `b`: the shapes it was made of. Infinite `within`. */
void mesh_walk_init(mesh_walk *w, const unit_pair *p, const shape *a, const shape *b);

/* As if B were elsewhere: the translation is in units of the pair. */
void mesh_walk_move(mesh_walk *w, vec3 position);

/* A new axis to leave pairs out by. */
void mesh_walk_aim(mesh_walk *w, vec3 axis);

typedef bool mesh_visit(mesh_walk *w, void *context); /* false: enough */

/* For a visitor: makes `part` the pair of the visited parts. */
void mesh_walk_dress(mesh_walk *w);

/* The greatest and least heights of the visited parts along a direction, in A's frame. */
double mesh_walk_top_a(const mesh_walk *w, vec3 direction);
double mesh_walk_foot_b(const mesh_walk *w, vec3 direction);

/* u_float = 2^-24. A bound of mesh_bounds is made of less than 60 terms, none greater than the mesh's unit and the
 * other's reach together, and each is off by less than 4 u_float of that; that the sides of the other's box are turned
 * in floats makes 60 more of them: 480 u_float, 15/16 of this, so that the reach may be summed in floats. */
#define FLOAT_SLACK 0x1p-15f

/* Boxes of meshes lie within 1 of the origin; floats are of no use for what reaches beyond this. */
#define FLOAT_FAR 0x1p40

LANES_INLINE void put3(float to[MESH_WIDTH], vec3 v)
{
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
    to[3] = 0;
}

/* ==== leaves ==== */

/* The parts in two leaves, or in one and a convex core. For mesh_walk.c. */

/* Visits the pairs of parts that are not proven to be farther apart than w->within; `box_a` is of no meaning when all
 * of a convex A is the only part. False: the visitor has had enough. */
bool mesh_leaves_visit(mesh_walk *w, mesh_box box_a, mesh_box box_b, mesh_visit *visit, void *context);

/* As if these two parts were visited, however far they are; A's triangle only where A is a mesh. */
void mesh_leaf_visit_alone(mesh_walk *w, uint32_t triangle_a, uint32_t triangle_b);

/* ==== the walk ==== */

/* Visits all pairs of parts that may be within w->within. */
void mesh_walk_run(mesh_walk *w, mesh_visit *visit, void *context);

/* The nearest boxes first of all; `from`, or NULL: where to begin. */
void mesh_walk_nearest(mesh_walk *w, const mesh_front *from, mesh_visit *visit, void *context);

/* Visits the parts of two leaves that are likely to be near each other. What it finds, and where, is a matter of the
 * shapes and their poses. False: the visitor has had enough. */
bool mesh_walk_plunge(mesh_walk *w, mesh_visit *visit, void *context);

/* How many pairs of leaves there are. */
double mesh_walk_leaves(const mesh_walk *w);

/* Are there at most so many below those boxes that are near? They are opened level by level; a walk from *front visits
 * no others. */
bool mesh_walk_is_short(mesh_walk *w, double leaves, mesh_front *front);

/* Is no box of the other mesh's leaves near this box of A or of B? `child` of `node`, which is no leaf's. Both are
 * meshes; what counts as near is `within`. */
bool mesh_walk_is_clear(const mesh_walk *w, bool of_a, uint32_t node, uint32_t child);

#endif
