/* robot_tree: a robot's joints as the client library takes them for checks (collided_robot). */
#ifndef COLLIDED_LOADERS_ROBOT_TREE_H
#define COLLIDED_LOADERS_ROBOT_TREE_H

#include "robot.h"

typedef struct robot_checked {
    collided_robot robot; /* its base is the root link's pose */
    int *joints;          /* of each coordinate the joint of the URDF */
    size_t coordinates;
} robot_checked;

/* Its links are the bodies that robot_bodies makes. False, with the report's error: more links than the library takes.
 */
bool robot_make_tree(const robot *r, collided_pose base, pool *p, robot_checked *out, load_report *report);

/* From values as robot.h has them to a configuration: `out` has room for `coordinates`. */
void robot_configuration(const robot_checked *t, const double *values, double *out);

#endif
