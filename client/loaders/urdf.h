/* urdf: a robot's links, their collision geometry, and the joints between them, from the Unified Robot Description
 * Format. Visual geometry, inertia and transmissions are passed over.
 *
 * What urdf_parse returns is a tree: one root, each other link the child of exactly one joint, names unique, mimic
 * chains without rings. Units: m, rad; frames right-handed. It lives in the caller's pool and is not changed again. */
#ifndef COLLIDED_LOADERS_URDF_H
#define COLLIDED_LOADERS_URDF_H

#include "body.h"
#include "pool.h"
#include "report.h"

#include <stdbool.h>
#include <stddef.h>

enum { URDF_LINKS_MAX = 4096 };

typedef enum urdf_joint_type { URDF_FIXED, URDF_REVOLUTE, URDF_CONTINUOUS, URDF_PRISMATIC } urdf_joint_type;

typedef struct urdf_link {
    const char *name;
    load_shape *shapes; /* mesh = the URI as written; its path is found by the robot */
    size_t shape_count;
    int joint; /* whose child it is; -1 = the root */
    int line;
} urdf_link;

typedef struct urdf_joint {
    const char *name;
    urdf_joint_type type;
    bool stands_still;    /* it is planar or floating, and taken as fixed */
    int parent, child;    /* links */
    collided_pose origin; /* of the joint in the parent link's frame */
    double axis[3];       /* unit, in the joint's frame */
    bool limited;
    double lower, upper; /* rad or m */
    int mimic;           /* value = mimic_factor * value of that joint + mimic_offset; -1 = free */
    double mimic_factor, mimic_offset;
    int line;
} urdf_joint;

typedef struct urdf {
    const char *name;
    const char *file;
    urdf_link *links;
    int link_count;
    urdf_joint *joints;
    int joint_count;
    int root;   /* link */
    int *order; /* all joints, each after the joint that leads to its parent */
} urdf;

/* `file` is for messages. */
bool urdf_parse(urdf *out, pool *p, const char *data, size_t size, const char *file, load_report *r);

int urdf_find_link(const urdf *u, const char *name); /* -1 = none */
int urdf_find_joint(const urdf *u, const char *name);

/* Second half of urdf_parse (urdf_tree.c): is it a tree? Fills root, order and the links' joints. */
bool urdf_make_tree(urdf *u, pool *p, load_report *r);

#endif
