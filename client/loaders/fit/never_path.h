/* never_path: the joints between two links of a robot, in order, and where they are for given values. */
#ifndef COLLIDED_LOADERS_FIT_NEVER_PATH_H
#define COLLIDED_LOADERS_FIT_NEVER_PATH_H

#include "loaders/robot.h"

enum { NEVER_JOINTS_MAX = 32 };

typedef struct never_joint { /* one that moves, between link a and link b */
    int joint;               /* of the URDF */
    int variable;            /* whose value it follows: value = factor * variable + offset */
    double factor, offset;
    bool upward; /* on the way from a up to the common link; its child is on a's side */
} never_joint;

typedef struct never_path {
    const urdf *u;
    int a, b, common;
    never_joint joints[NEVER_JOINTS_MAX]; /* from a to b */
    int joint_count;
    double lo[NEVER_JOINTS_MAX], hi[NEVER_JOINTS_MAX]; /* of the variables, rad or m */
    int variable_joint[NEVER_JOINTS_MAX];              /* whose value it is */
    int variable_count;
} never_path;

/* False: too many joints, or one whose range is not bounded (planar and floating ones, too). A continuous joint goes
 * once around. */
bool never_path_make(const urdf *u, int a, int b, never_path *out);

typedef struct never_place {
    collided_pose a, b;                                            /* of the links, in the common link's frame */
    double origin[NEVER_JOINTS_MAX][3], axis[NEVER_JOINTS_MAX][3]; /* of the joints, there; axes are unit */
} never_place;

void never_path_place(const never_path *p, const double *variables, never_place *out);

#endif
