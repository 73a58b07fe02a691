/* scene_schema: a YAML scene as libcyaml reads it: keys as they are written, pointers that are NULL where a key is
 * absent. scene.c checks it and makes bodies of it. */
#ifndef COLLIDED_LOADERS_SCENE_SCHEMA_H
#define COLLIDED_LOADERS_SCENE_SCHEMA_H

#include "report.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct yaml_pose {
    double *position;    /* 3 */
    double *rpy;         /* 3, rad */
    double *orientation; /* 4: w, x, y, z */
} yaml_pose;

typedef struct yaml_point {
    double at[3];
} yaml_point;

typedef struct yaml_shape {
    int type;          /* collided_shape_type */
    double *size;      /* 3 */
    double *semi_axes; /* 3 */
    double *radius, *length, *height, *rounding;
    double *scale; /* 3 */
    yaml_point *points;
    unsigned points_count;
    char *mesh;
    char *heights;   /* path */
    double *spacing; /* 2 */
    double *base;
    double *range; /* 2 */
    int *as;       /* load_mesh_as */
    uint64_t *pieces;
    double *deviation;
    yaml_pose *pose;
    struct yaml_shape *children;
    unsigned children_count;
} yaml_shape;

typedef struct yaml_rule {
    char *pattern, *reason;
    bool allow;
    double *padding, *margin;
} yaml_rule;

typedef struct yaml_body {
    char *name, *group;
    int motion; /* collided_motion */
    int ccd;    /* collided_ccd */
    double *acceleration, *angular_acceleration;
    uint64_t *category, *mask;
    bool one_way;
    yaml_pose *pose;
    yaml_shape *shapes;
    unsigned shapes_count;
    yaml_rule *rules;
    unsigned rules_count;
} yaml_body;

typedef struct yaml_package {
    char *name, *path;
} yaml_package;

typedef struct yaml_joint {
    char *name;
    double value;
} yaml_joint;

typedef struct yaml_link {
    char *name;
    yaml_shape *shapes;
    unsigned shapes_count;
} yaml_link;

typedef struct yaml_apart {
    char *link1, *link2, *reason;
} yaml_apart;

typedef struct yaml_robot {
    char *urdf, *srdf, *prefix, *state, *meshes;
    int motion, ccd;
    double *acceleration, *angular_acceleration;
    yaml_pose *pose;
    yaml_package *packages;
    unsigned packages_count;
    yaml_joint *joints;
    unsigned joints_count;
    yaml_link *links;
    unsigned links_count;
    yaml_apart *apart;
    unsigned apart_count;
} yaml_robot;

typedef struct yaml_scene {
    yaml_body *bodies;
    unsigned bodies_count;
    yaml_robot *robots;
    unsigned robots_count;
} yaml_scene;

/* NULL, and "file:line: ..." in the report, when it does not follow the schema. Freed by yaml_scene_free. */
yaml_scene *yaml_scene_read(const char *data, size_t size, const char *file, load_report *r);
void yaml_scene_free(yaml_scene *scene);

#endif
