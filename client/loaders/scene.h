/* scene: a YAML file with bodies and robots.
 *
 *     bodies:
 *       - name: table
 *         group: furniture          # optional
 *         motion: fixed             # or moving, the default
 *         ccd: full                 # or linear, or off, the default: is its motion swept, see collided_ccd
 *         acceleration: 3           # m/s^2 and rad/s^2, default 0: what is predicted allows for so much
 *         angular_acceleration: 1
 *         category: 2               # bits, as in collided_body_def; with mask and one_way
 *         mask: 5
 *         one_way: true
 *         pose: {position: [0.5, 0, 0.2], rpy: [0, 0, 1.57]}   # or orientation: [w, x, y, z]; default: the origin
 *         shapes:
 *           - {type: box, size: [0.8, 1.2, 0.05]}              # full sides, m
 *         rules:                    # ordered; the first that matches the other body decides
 *           - {pattern: "part*", allow: true, reason: parts lie on the table}
 *           - {pattern: "group:human", allow: false, padding: 0.05, margin: 0.5}   # m, see collided_rule
 *     robots:
 *       - urdf: arm.urdf            # paths are relative to the scene
 *         srdf: arm.srdf
 *         prefix: left_
 *         state: ready
 *         joints: [{name: j1, value: 0.3}]
 *         pose: {position: [0, 0, 0]}
 *         motion: moving            # and ccd, acceleration, angular_acceleration, of all its links
 *         meshes: decompose:8       # hull (the default), solid, decompose or decompose:N: what mesh files become
 *         packages: [{name: arm_description, path: ../arm_description}]
 *         links: [{name: forearm, shapes: [{type: capsule, radius: 0.06, length: 0.3}]}] # in place of the URDF's
 *         apart: [{link1: base, link2: wrist, reason: never meet}] # not checked; `collidectl fit` writes both
 *
 * Shapes: sphere (radius), capsule (radius, length of its cylinder), box (size), cylinder (radius, height), cone
 * (radius, height), ellipsoid (semi_axes), halfspace (z <= 0), hull (points: [[x, y, z], ...] or mesh: FILE, with
 * scale), mesh (mesh: FILE, with scale; as: solid, the default, its triangles as they are, a solid when closed; as:
 * hull; as: decompose, several hulls, with pieces, at most so many, default 16, and deviation, m, which is enough),
 * height_field (heights: FILE, a text matrix in metres or a grey PNG with range: [black, white] in metres, see
 * heights.h; spacing: [x, y]; base: how far its flat base lies below the lowest height), compound (children: a list of
 * shapes, of any type but halfspace, mesh, height_field and compound, which are one shape together); each with `pose`
 * and `rounding` (m), and, but for mesh, `deviation` (m): what it stands for is in it, and none of it is farther away
 * (collided_shape.deviation). A child's pose is in its compound. Unknown keys, keys that do not belong to the type,
 * aliases and numbers that are not finite are refused. */
#ifndef COLLIDED_LOADERS_SCENE_H
#define COLLIDED_LOADERS_SCENE_H

#include "body.h"
#include "robot.h"

typedef struct scene_robot {
    robot_source source;
    const char *state;   /* NULL = none */
    const char **joints; /* names, and their values */
    double *values;
    size_t joint_count;
    collided_pose pose;
    collided_motion motion;
    collided_ccd ccd;                                      /* of all its links, ... */
    double acceleration_m_s2, angular_acceleration_rad_s2; /* ... with these */
} scene_robot;

typedef struct scene {
    load_bodies bodies;
    scene_robot *robots;
    size_t robot_count;
} scene;

enum { SCENE_SIZE_MAX = 16 << 20 /* bytes */ };

/* `file` is for messages, and the folder that paths are relative to. Files of meshes and heights are not read yet:
 * load_body_meshes. */
bool scene_parse(scene *out, pool *p, const char *data, size_t size, const char *file, load_report *r);

#endif
