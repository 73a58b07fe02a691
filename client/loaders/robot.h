/* robot: a URDF with its SRDF, ready to be posed: joint values in, link poses and bodies out.
 *
 * Joint values are arrays with one number a joint of the URDF, in its order (rad or m); values of fixed joints are not
 * looked at, those of mimic joints follow from the joint they mimic. Poses are of the link frames in the frame of the
 * root link. A robot is not changed after it was loaded: any thread may read it. */
#ifndef COLLIDED_LOADERS_ROBOT_H
#define COLLIDED_LOADERS_ROBOT_H

#include "package.h"
#include "srdf.h"
#include "urdf.h"

typedef struct robot_link_shapes { /* in place of those of the URDF, for example as collidectl fit found them */
    const char *link;
    load_shape *shapes; /* in the link's frame; their meshes' paths are whole */
    size_t shape_count;
} robot_link_shapes;

typedef struct robot_apart { /* two links that are not checked against each other */
    const char *link1, *link2, *reason;
} robot_apart;

typedef struct robot_source {
    const char *urdf;   /* path */
    const char *srdf;   /* path; NULL = none: then only links that a joint connects may touch */
    const char *prefix; /* put before the links' names; NULL = none */
    const load_package *packages;
    size_t package_count;
    load_meshes meshes; /* what mesh files become; zero = hulls */
    const robot_link_shapes *links;
    size_t link_count;
    const robot_apart *apart;
    size_t apart_count;
} robot_source;

typedef struct robot {
    pool *pool;
    robot_source source;
    urdf model;
    srdf semantics; /* empty without an SRDF */
} robot;

/* Parses both files; meshes are read by robot_bodies. What `source` points to must live as long as the robot. */
bool robot_load(robot *out, pool *p, const robot_source *source, load_report *r);
/* An SRDF afterwards, in place of the one before; before robot_bodies, which makes rules of it. */
bool robot_load_srdf(robot *b, const char *path, load_report *r);

/* Zero, or the limit next to it. `values` has robot.model.joint_count entries here and below. */
void robot_default_values(const robot *b, double *values);
/* The joints that the SRDF's state names; the others keep what they had. Unknown: false, and the report lists them. */
bool robot_state(const robot *b, const char *state, double *values, load_report *r);
/* One joint. Refused: unknown, fixed and mimic joints. A value beyond its limits is taken, with a warning. */
bool robot_set(const robot *b, const char *joint, double value, double *values, load_report *r);
/* "joint=value,joint=value". */
bool robot_set_list(const robot *b, const char *list, double *values, load_report *r);

/* What a joint stands at: of one that mimics another what follows from that one. */
double robot_joint_value(const robot *b, int joint, const double *values);

/* Pose of each link (robot.model.link_count) in the root link's frame. */
void robot_forward(const robot *b, const double *values, collided_pose *links);

/* One body for each link that has collision geometry, in the URDF's order: name = prefix + link, group = the robot's
 * name, rules first from source.apart, then from the SRDF, with their reasons. `base` is the pose of the root link in
 * the world. Reads the meshes. */
bool robot_bodies(const robot *b, collided_pose base, const double *values, collided_motion motion, pool *p,
    load_bodies *out, load_report *r);

/* The poses of the same bodies, in the same order; `out` has room for robot_body_count. */
size_t robot_body_count(const robot *b);
void robot_body_poses(const robot *b, collided_pose base, const double *values, collided_pose *out);
const char *robot_body_name(const robot *b, int link, pool *p);

#endif
