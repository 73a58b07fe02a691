/* robot_draws: robots and scenes at random, and one arm of seven joints, for the tests of daemon/robot. */
#ifndef COLLIDED_TESTS_ROBOT_DRAWS_H
#define COLLIDED_TESTS_ROBOT_DRAWS_H

#include "base/prng.h"
#include "robot/check.h"

enum { DRAW_LINKS = 16, DRAW_SHAPES = 32, DRAW_PAIRS = 64, DRAW_OBSTACLES = 40 };

typedef struct robot_draw {
    robot_joint joints[DRAW_LINKS];
    size_t joint_count;
    shape shapes[DRAW_SHAPES];
    check_shape placed[DRAW_SHAPES];
    size_t shape_count;
    check_pair pairs[DRAW_PAIRS];
    size_t pair_count;
    hull *hulls[DRAW_SHAPES];
    size_t hull_count;
    robot_tree *tree;
    check_robot *robot;
} robot_draw;

typedef struct scene_draw {
    shape shapes[DRAW_OBSTACLES];
    scene_obstacle_def defs[DRAW_OBSTACLES];
    size_t count;
} scene_draw;

/* An arm as the Franka Panda's, with a gripper whose fingers mimic each other; capsules, cylinders, boxes, a hull. */
void draw_arm(robot_draw *out);
/* It holds a rod of 1 mm radius and that length (m) in its gripper, along the gripper. */
void draw_arm_with_pole(robot_draw *out, double length);
/* A tree of 2 to DRAW_LINKS links of all types of joints, sliders, branches, mimics, with shapes of all types, some of
 * them 1 mm rods, some at the end of long levers. */
void draw_robot(uint64_t *seed, robot_draw *out);
void draw_robot_free(robot_draw *d);

/* Bodies around: boxes, balls, rods, cylinders, hulls and now and then a half-space, out to `size`. */
void draw_scene(uint64_t *seed, double size, size_t count, scene_draw *out);

/* Uniform within the limits; of continuous joints within [-4, 4]. */
void draw_configuration(uint64_t *seed, const robot_tree *tree, double *out);

/* The least distance of all that is to be apart, by asking the narrow phase for all pairs: an interval, and by how much
 * poses may be off is not in it. */
void draw_distance(const robot_draw *d, const scene_draw *s, const double *coordinates, double *lo, double *hi);

#endif
