/* collided_load: robots and scenes from files, for clients of the collision daemon collided(8).
 *
 * Reads URDF and SRDF, and scenes in YAML, and makes bodies of them by way of collided.h. It is a library of its own,
 * libcollided-load, so that programs which do not read such files need neither libxml2 nor libyaml nor assimp.
 *
 *     collided_loaded_robot *arm = collided_load_urdf("arm.urdf", NULL);
 *     if (!arm || collided_load_srdf(arm, "arm.srdf") != COLLIDED_OK)
 *         fprintf(stderr, "%s\n", collided_load_error());
 *     double values[32];
 *     collided_loaded_default_values(arm, values);
 *     collided_loaded_state_values(arm, "ready", values);
 *     collided_body links[32];
 *     collided_create_loaded(c, arm, &(collided_placement){.base = collided_pose_identity(), .values = values}, links);
 *     ...
 *     collided_pose poses[32];
 *     collided_loaded_body_poses(arm, collided_pose_identity(), values, poses);
 *
 * Units: metres and radians. Frames are right-handed; quaternions are (w, x, y, z). Joint values are arrays with one
 * number for each joint of the URDF, fixed ones too, in the file's order (rad or m): those of fixed joints are not
 * looked at, those of mimic joints follow from the joint that they mimic. Bodies are the links that have collision
 * geometry, in the file's order. Ownership: what is loaded belongs to the caller, who frees it; names and arrays that
 * it hands out are its own and live as long; paths and definitions are copied. Threads: what is loaded is only changed
 * by collided_load_srdf and by the first call that creates its bodies; apart from these any threads may read it at
 * once. Errors: functions return NULL or a collided_status; collided_load_error tells the rest, with file and line.
 * Nothing is half loaded. Limits: files of 16 MB, 4,096 links. Running out of memory ends the program with a message.
 * Files are data: no DOCTYPE, no external entity, no address on a network is followed. */
#ifndef COLLIDED_LOAD_H
#define COLLIDED_LOAD_H

#include <collided.h>

#ifdef __cplusplus
extern "C" {
#endif

/* A robot that was read: its links, joints and states. Freed by collided_loaded_robot_free. */
typedef struct collided_loaded_robot collided_loaded_robot;
/* A scene that was read, with its robots. Freed by collided_loaded_scene_free. */
typedef struct collided_loaded_scene collided_loaded_scene;

/* ---- reading ---- */

/* Where a package is that a model names: package://name/... is path/... */
typedef struct collided_load_package {
    const char *name, *path;
} collided_load_package;

/* Called with one line for people, inside the function that reads. */
typedef void collided_load_told(void *context, const char *text);

/* How to read; begin with collided_load_def_default. */
typedef struct collided_load_def {
    const char *prefix; /* put before the links' names to make those of bodies; NULL = none */
    const char *meshes; /* what mesh files become: "hull" (the default), "solid", "decompose" or "decompose:N", several
                           hulls, at most N of 1 to 128, each with its deviation */
    const collided_load_package *packages; /* looked in first. Then: a folder of that name beside or above the model,
                                              ROS_PACKAGE_PATH, AMENT_PREFIX_PATH, the model's own folder */
    size_t package_count;
    collided_load_told *warn; /* what is passed over: a pair of the SRDF whose link does not exist, a joint that is
                                 taken as fixed, a value beyond its joint's limits; NULL = nobody is told */
    collided_load_told *note; /* what was made of a mesh; NULL = nobody is told */
    void *context;            /* handed to both; they live as long as what is loaded */
} collided_load_def;
/* No prefix, no packages, hulls, and nobody is told. Any thread. */
collided_load_def collided_load_def_default(void);

/* Why the last function of this library failed on this thread, in one line. Valid until the thread's next one. */
const char *collided_load_error(void);

/* Reads a URDF file. NULL def = the defaults. Its meshes are read when the bodies are created. What is not a tree, has
 * two links of a name, a number that is none, or elements of xacro is refused. NULL on failure. */
collided_loaded_robot *collided_load_urdf(const char *path, const collided_load_def *def);

/* Reads an SRDF into a robot. It adds named states, and pairs of links that are not checked; without one the links that
 * a joint connects are not. Before the bodies are created: COLLIDED_BAD_ARGUMENT afterwards, or if the file is wrong.
 */
collided_status collided_load_srdf(collided_loaded_robot *robot, const char *path);

/* Frees a robot. Its bodies stay with the client. NULL is no error; of a scene's robot nothing is done. */
void collided_loaded_robot_free(collided_loaded_robot *robot);

/* ---- what a robot has ---- */

/* The name of the robot in its URDF, which is its bodies' group, too. */
const char *collided_loaded_name(const collided_loaded_robot *robot);

/* A joint of the URDF. */
typedef struct collided_loaded_joint {
    const char *name;
    collided_joint_type type;
    int32_t parent, child; /* links */
    bool limited;
    double lower, upper; /* rad or m, if it is limited */
    int32_t mimics;      /* its value is factor times that of this joint, plus offset; -1 = it moves by itself */
    double factor, offset;
} collided_loaded_joint;

/* A link of the URDF. */
typedef struct collided_loaded_link {
    const char *name;
    const char *body; /* name of its body, with the prefix; NULL = it has no collision geometry */
    int32_t joint;    /* whose child it is; -1 = it is the root */
} collided_loaded_link;

/* A named state of the SRDF. */
typedef struct collided_loaded_state {
    const char *name, *group;
} collided_loaded_state;

/* The joints, in the file's order. `count` is set to how many there are. */
const collided_loaded_joint *collided_loaded_joints(const collided_loaded_robot *robot, size_t *count);
/* The links, in the file's order. `count` is set to how many there are. */
const collided_loaded_link *collided_loaded_links(const collided_loaded_robot *robot, size_t *count);
/* The named states, in the file's order. `count` is set to how many there are; 0 without an SRDF. */
const collided_loaded_state *collided_loaded_states(const collided_loaded_robot *robot, size_t *count);
/* How many bodies it makes: links with collision geometry. */
size_t collided_loaded_body_count(const collided_loaded_robot *robot);

/* ---- joint values ---- */

/* Sets all values to 0, or to the limit next to it. */
void collided_loaded_default_values(const collided_loaded_robot *robot, double *values);
/* Sets the joints that a state names. The others stay. COLLIDED_UNKNOWN_ID if there is no such state; the error lists
 * those there are. */
collided_status collided_loaded_state_values(const collided_loaded_robot *robot, const char *state, double *values);
/* Sets one joint by its name. COLLIDED_UNKNOWN_ID if there is none; COLLIDED_BAD_ARGUMENT if it is fixed, mimics
 * another one, or the value is not finite. A value beyond the joint's limits is taken, with a warning. */
collided_status collided_loaded_set_value(
    const collided_loaded_robot *robot, const char *joint, double value, double *values);

/* Tells where the links are. `poses`: one a link, world; `base` is the pose of the root link. */
void collided_loaded_link_poses(
    const collided_loaded_robot *robot, collided_pose base, const double *values, collided_pose *poses);
/* Tells where the bodies are. `poses`: one a body, world, in the order in which they are created. */
void collided_loaded_body_poses(
    const collided_loaded_robot *robot, collided_pose base, const double *values, collided_pose *poses);

/* ---- checks ---- */

/* The robot as collided_check_states takes it. Its joints belong to the loaded robot. COLLIDED_UNSUPPORTED: it has more
 * than 128 links. */
collided_status collided_loaded_tree(const collided_loaded_robot *robot, collided_pose base, collided_robot *out);
/* Makes a configuration of joint values. It has collided_robot_coordinates numbers. */
void collided_loaded_configuration(const collided_loaded_robot *robot, const double *values, double *configuration);
/* Makes joint values of a configuration. Those of fixed and mimic joints stay. */
void collided_loaded_values(const collided_loaded_robot *robot, const double *configuration, double *values);

/* ---- bodies ---- */

/* Where a robot stands, and what its bodies are like. Zeros are good but for base, which has a quaternion. */
typedef struct collided_placement {
    collided_pose base;     /* of the root link, world */
    const double *values;   /* of its joints; NULL = collided_loaded_default_values */
    collided_motion motion; /* COLLIDED_MOVING is 0 */
    double deadline_s;      /* a pose older than this is unknown; 0 = never */
    collided_ccd ccd;       /* as in collided_body_def, of all links, with these: */
    double acceleration_m_s2, angular_acceleration_rad_s2;
} collided_placement;

/* Creates a robot's bodies. The first time it reads the meshes, and finds all of them good before the daemon hears of
 * the first body. Names are prefix and link, the group is the robot's name, rules come from the SRDF. `bodies`: room
 * for collided_loaded_body_count, filled in the links' order. COLLIDED_BAD_ARGUMENT: a file is missing or wrong
 * (collided_load_error); what the client refuses is told by collided_error, too. Call collided_sync to hear what the
 * daemon refuses. */
collided_status collided_create_loaded(
    collided *c, collided_loaded_robot *robot, const collided_placement *placement, collided_body *bodies);

/* ---- scenes ---- */

/* Reads a scene. It has bodies, and robots with their files, states and places; client/load/SCENES.md (installed as
 * /usr/share/doc/libcollided-load-dev/SCENES.md) has its keys. All meshes are read at once. Of def the packages, the
 * meshes and the prefix must be none: the scene says these itself. NULL on failure. */
collided_loaded_scene *collided_load_scene(const char *path, const collided_load_def *def);

/* Frees a scene, and its robots with it. Its bodies stay with the client. NULL is no error. */
void collided_loaded_scene_free(collided_loaded_scene *scene);

/* A robot of a scene, as it stands there. */
typedef struct collided_loaded_placed {
    const collided_loaded_robot *robot;
    collided_pose base;   /* of its root link, world */
    const double *values; /* of its joints */
    size_t first_body;    /* of its bodies among the scene's */
} collided_loaded_placed;

/* How many bodies a scene has: those that it lists, and those of its robots. */
size_t collided_loaded_scene_body_count(const collided_loaded_scene *scene);
/* The name of a scene's body. `index` is below collided_loaded_scene_body_count. */
const char *collided_loaded_scene_body_name(const collided_loaded_scene *scene, size_t index);
/* The robots of a scene, in the file's order. `count` is set to how many there are. */
const collided_loaded_placed *collided_loaded_scene_robots(const collided_loaded_scene *scene, size_t *count);
/* Creates all bodies of a scene: first those that it lists, then those of each robot. `bodies` has room for
 * collided_loaded_scene_body_count. Errors are those of collided_create_loaded. */
collided_status collided_create_loaded_scene(collided *c, const collided_loaded_scene *scene, collided_body *bodies);

#ifdef __cplusplus
}
#endif

#endif
