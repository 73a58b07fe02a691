/* compound: the union of convex shapes, each at a pose in the compound's frame, with a hierarchy of boxes over them.
 *
 * Built once, immutable afterwards, shared by any number of shapes and threads. It borrows its children's hulls, which
 * outlive it. Children are numbered as they were given. Lengths in metres. */
#ifndef COLLIDED_GEOM_COMPOUND_H
#define COLLIDED_GEOM_COMPOUND_H

#include "shape.h"

enum {
    COMPOUND_CHILDREN_MAX = 4096, /* 2^12, so that the hierarchy is at most COMPOUND_DEPTH_MAX nodes deep: each node
                                     hands half of its children, rounded up, to either side */
    COMPOUND_DEPTH_MAX = 13
};

typedef struct compound_child {
    shape shape;
    pose local;      /* its orientation divided by its norm */
    transform place; /* the same, ready for many points */
    bool at_origin;  /* its frame is the compound's */
} compound_child;

/* A box, rounded outward, around some children. The left part follows its parent; `right` is where the other begins. */
typedef struct compound_node {
    vec3 lo, hi;
    uint32_t right; /* 0: a leaf */
    uint32_t child; /* of a leaf */
} compound_node;

typedef struct compound {
    uint32_t child_count, node_count;
    compound_child *children;
    compound_node *nodes; /* the root first */
    double reach;         /* of all children about the compound's origin, rounded up */
    double excess;        /* the greatest of its hulls' */
} compound;

typedef enum compound_status {
    COMPOUND_OK,
    COMPOUND_EMPTY,
    COMPOUND_TOO_MANY,  /* more than COMPOUND_CHILDREN_MAX children */
    COMPOUND_BAD_CHILD, /* a child is no convex shape with an end: a half-space, a mesh, a compound */
    COMPOUND_BAD_SIZE   /* what shape_check finds, or a position that is not finite or beyond SHAPE_SIZE_MAX, or an
                           orientation of length zero */
} compound_status;

/* `shapes` and `locals`: count of them, copied. On COMPOUND_OK *out is owned by the caller, who frees it by
 * compound_destroy. The same input gives the same compound. */
compound_status compound_build(const shape *shapes, const pose *locals, size_t count, compound **out);
/* The same again, owned by the caller. */
compound *compound_copy(const compound *c);
void compound_destroy(compound *c);
const char *compound_status_text(compound_status status);

/* Are they made of the same shapes, hulls and poses, in the same order? */
bool compound_equal(const compound *a, const compound *b);

/* In support.c. The farthest point of all children, their radii included, in a direction of any length but zero; ties
 * go to the least child. */
vec3 compound_support(const compound *c, vec3 direction);

/* Its greatest dot(direction, x), never less than the true one. */
double compound_height_up(const compound *c, vec3 direction);

/* Whole-structure check for tests: each child in one leaf, boxes around all below them, depth. The first fault found,
 * or NULL. */
const char *compound_validate(const compound *c);

#endif
