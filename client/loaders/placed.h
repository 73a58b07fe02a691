/* placed: robots that stand somewhere with their joints at some values, alone or in a scene, with everything read that
 * their bodies need. What `collidectl load` and collided_load.h have in common. Plain data in the pool. */
#ifndef COLLIDED_LOADERS_PLACED_H
#define COLLIDED_LOADERS_PLACED_H

#include "robot.h"
#include "scene.h"

typedef struct placed_robot {
    robot robot;
    collided_pose base; /* of the root link, world */
    double *values;     /* of each joint of the URDF */
    load_bodies links;
} placed_robot;

typedef struct placed_scene {
    load_bodies bodies;
    placed_robot *robots;
    size_t robot_count;
} placed_scene;

/* The files of a robot, its joints as `from` says, and then as `joints` does ("name=value,..."; NULL = no more), and
 * its bodies with their meshes. */
bool placed_robot_load(placed_robot *out, pool *p, const scene_robot *from, const char *joints, load_report *r);

/* The scene, its robots, and all meshes and heights. */
bool placed_scene_load(placed_scene *out, pool *p, const char *path, load_report *r);

#endif
