/* tree: the kinematic tree of a robot: links, and joints that move them.
 *
 * Link 0 is the first one that hangs at the base; each link but those at the base has a parent with a lesser index, and
 * one joint, under the link's own index, between the two. Joint frames are as in URDF: the joint's frame in the
 * parent's link frame is `origin`, and a value of q turns about (rad) or shifts along (m) `axis`, given in that frame.
 *
 * Coordinates are the values of those joints that move by themselves (revolute, continuous and prismatic joints that
 * mimic no other), in the order of the links. All frames are right-handed; poses map link frames to the base's frame.
 *
 * Threads: a tree is immutable; any number may read it. Ownership: what is given is copied. Errors: robot_status. */
#ifndef COLLIDED_ROBOT_TREE_H
#define COLLIDED_ROBOT_TREE_H

#include "geom/simd.h"
#include "geom/vec.h"

#include <stddef.h>
#include <stdint.h>

enum { ROBOT_LINKS_MAX = 128 };
#define ROBOT_SIZE_MAX 1e6 /* m: no offset, travel or shape of a robot is larger */

typedef enum robot_joint_type { ROBOT_FIXED, ROBOT_REVOLUTE, ROBOT_CONTINUOUS, ROBOT_PRISMATIC } robot_joint_type;

typedef struct robot_joint {
    int32_t parent; /* link; -1 = the base */
    robot_joint_type type;
    pose origin;         /* of the joint in the parent's frame; |q| = 1 but for 1e-6, and is divided by its norm */
    vec3 axis;           /* not zero; its length does not matter. Of a fixed joint it is not looked at */
    double lower, upper; /* rad or m; of a continuous or fixed joint not looked at */
    int32_t mimic;       /* the joint whose value times `factor` plus `offset` is this one's; -1 = none */
    double factor, offset;
} robot_joint;

typedef enum robot_status {
    ROBOT_OK,
    ROBOT_NO_LINKS,
    ROBOT_TOO_MANY_LINKS,
    ROBOT_BAD_PARENT, /* not -1, and not a link before this one: so there are no cycles */
    ROBOT_BAD_TYPE,
    ROBOT_BAD_ORIGIN, /* not finite, beyond ROBOT_SIZE_MAX, or no rotation */
    ROBOT_BAD_AXIS,
    ROBOT_BAD_LIMITS, /* not finite, lower above upper, or beyond what turn.h and ROBOT_SIZE_MAX allow */
    ROBOT_BAD_MIMIC   /* of a joint that is fixed, mimics, or is not there; factor or offset not finite */
} robot_status;

const char *robot_status_text(robot_status status);

typedef struct robot_tree robot_tree;

/* NULL, and why in *status and of which joint in *where, if it cannot be made. */
robot_tree *robot_tree_create(const robot_joint *joints, size_t count, robot_status *status, size_t *where);
void robot_tree_destroy(robot_tree *t);

size_t robot_tree_links(const robot_tree *t);
size_t robot_tree_coordinates(const robot_tree *t);
/* The joint (link) whose value the coordinate is. */
size_t robot_tree_joint_of(const robot_tree *t, size_t coordinate);
/* Of a continuous joint -TURN_ANGLE_MAX and TURN_ANGLE_MAX. */
void robot_tree_limits(const robot_tree *t, size_t coordinate, double *lower, double *upper);

/* The first coordinate that is not a number or beyond its limits (by more than 1e-9), or SIZE_MAX. */
size_t robot_tree_beyond(const robot_tree *t, const double *coordinates);

/* The pose of each link in the base's frame: out[link]. Within robot_tree_slack of the real numbers' pose, as far as
 * points within ROBOT_SIZE_MAX of the link's origin are concerned. Coordinates must be within TURN_ANGLE_MAX. */
void robot_tree_forward(const robot_tree *t, const double *coordinates, pose *out);

/* The first coordinate for which a joint that takes its value would be beyond what forward can tell (TURN_ANGLE_MAX,
 * ROBOT_SIZE_MAX), or SIZE_MAX. Limits of the joints do not matter. */
size_t robot_tree_unusable(const robot_tree *t, const double *coordinates);

/* The velocities of each link's origin, and its angular ones, in the base's frame, at the poses that forward gave:
 * linear[link] (m/s), angular[link] (rad/s). `rates`: of the coordinates. */
void robot_tree_velocities(const robot_tree *t, const double *rates, const pose *at, vec3 *linear, vec3 *angular);

/* m: no point of a link that is within `reach` of the link's origin is farther from where the real numbers would have
 * it. Each level of the tree multiplies matrices of entries up to 1 (3 products: 6 roundoffs), takes a sine and a
 * cosine within TURN_ERROR (4 roundoffs), a quaternion's matrix (16), and adds a rotated offset: less than 64 roundoffs
 * of all lengths from the base to the point a level. */
double robot_tree_slack(const robot_tree *t, size_t link, double reach);

/* m: no point of the link that is within `reach` of its origin is ever farther from the base's origin, whatever the
 * coordinates within their limits. */
double robot_tree_reach(const robot_tree *t, size_t link, double reach);

/* ---- motions along straight lines in joint space ---- */

/* A joint between two links, and the longest lever that it has about a point of the farther one. */
typedef struct robot_lever {
    uint32_t coordinate;
    double factor; /* of the coordinate's change */
    double arm;    /* m: of a joint that turns; of one that slides 1 */
    bool turns;
} robot_lever;

/* The joints that move points of `link` within `reach` of its origin against another link (`from`; -1 = the base), in
 * the order from that one to this one. `out` has room for 2 ROBOT_LINKS_MAX; how many there are. */
size_t robot_tree_levers(const robot_tree *t, int32_t from, uint32_t link, double reach, robot_lever *out);

/* An upper bound of |d^2 x / dt^2| for such a point x, in the frame of the first link, while the coordinates move by
 * `change` with t from 0 to 1 (m): the sum over pairs of joints of the products of their changes, times the lever of
 * the one nearer to the point. So x stays within this times h^2 / 8 of the chord of any stretch of length h. */
double robot_levers_bend(const robot_lever *levers, size_t count, const double *change);

/* An upper bound of how far it moves (m). */
double robot_levers_way(const robot_lever *levers, size_t count, const double *change);

/* ---- four configurations side by side ---- */

typedef struct robot_frames { /* of one link: columns of the rotation, and the origin */
    lanes x[3], y[3], z[3], p[3];
} robot_frames;

/* out[link], in frames that are turned against the links' own ones: robot_tree_inner says how. `coordinates` has one
 * vector a coordinate. Lane by lane the bits of four calls with one configuration in all lanes. */
void robot_tree_forward_lanes(const robot_tree *t, const lanes *coordinates, robot_frames *out);
/* From a link's frame to that turned one, whose z-axis is the joint's axis. */
quat robot_tree_inner(const robot_tree *t, size_t link);

#endif
