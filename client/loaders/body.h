/* body: what loaders make of files: bodies with shapes, not yet known to any daemon. Plain data in the pool that it was
 * loaded into. */
#ifndef COLLIDED_LOADERS_BODY_H
#define COLLIDED_LOADERS_BODY_H

#include "collided.h"
#include "heights.h"
#include "mesh.h"

/* A compound and each of its children count. */
enum { LOAD_SHAPES_MAX = 256 /* WIRE_SHAPES_MAX */, LOAD_RULES_MAX = 1024 /* WIRE_RULES_MAX */ };

/* What a mesh file becomes. */
typedef enum load_mesh_as {
    LOAD_MESH_HULL,     /* the convex hull of its points, which then is what is meant: its deviation is 0 */
    LOAD_MESH_SOLID,    /* its triangles as they are, a solid when closed */
    LOAD_MESH_DECOMPOSE /* several hulls, each with its deviation; see decompose/decompose.h */
} load_mesh_as;

typedef struct load_meshes {
    load_mesh_as as;
    size_t pieces;      /* LOAD_MESH_DECOMPOSE: at most so many; 0 = the default */
    double deviation_m; /* and no more than this asks for; 0 = the default */
} load_meshes;

#define LOAD_MESHES_WORDS "hull, solid, decompose or decompose:N with N from 1 to %d"
/* "hull", "solid", "decompose" or "decompose:N". False: none of these. */
bool load_meshes_parse(const char *text, load_meshes *out);

/* Of a height field. */
typedef struct load_heights {
    const char *path;
    double spacing[2], base; /* m: between columns and between rows; see collided_create_height_field */
    const double *range;     /* m, of a picture: black and white; NULL of text */
    heights_grid grid;
} load_heights;

/* One shape. A hull's points come with it, or from a mesh file; a mesh's triangles and heights from a file. */
typedef struct load_shape {
    collided_shape shape; /* its geometry is set when it is announced */
    const char *mesh;     /* path of the file; NULL = none */
    double scale[3];
    load_meshes meshes; /* of a shape with a mesh file; set by load_shape_becomes */
    mesh_points points;
    mesh_triangles triangles;    /* of a mesh */
    load_heights heights;        /* of a height field */
    struct load_shape *children; /* of a compound; shape.children is set when it is announced */
    size_t child_count;
} load_shape;

typedef struct load_body {
    const char *name;
    const char *group; /* "" = none */
    collided_motion motion;
    uint64_t category, mask; /* as in collided_body_def, with one_way */
    bool one_way;
    collided_ccd ccd;
    double acceleration_m_s2, angular_acceleration_rad_s2; /* as in collided_body_def */
    collided_pose pose;                                    /* world */
    double deadline_s; /* a pose older than this is stale; 0 = never, which is what files say */
    load_shape *shapes;
    size_t shape_count;
    collided_rule *rules;
    size_t rule_count;
} load_body;

typedef struct load_bodies {
    load_body *at;
    size_t count;
} load_bodies;

/* What the mesh file of the shape becomes. */
void load_shape_becomes(load_shape *s, const load_meshes *meshes);

/* Reads the files of a body's shapes; a decomposed mesh becomes several shapes, and a note says how many. A file that
 * was given before is read again: files are small. */
bool load_body_meshes(pool *p, load_body *body, load_report *r);

/* How far the body's shapes reach beyond what they stand for, at most (m): their deviations, and what the hulls of mesh
 * files add to the solids in these files, which is measured here, with proof. NAN: a mesh is flat or too large for that
 * (decompose/decompose.h). Reads the files again. */
double load_body_excess(const load_body *body);

/* Tells the daemon: the hulls and meshes, then the body, under the number `id` (-1 = the next free one). The body's id
 * is COLLIDED_NONE on failure; collided_error tells why. */
collided_body load_body_announce(collided *c, const load_body *body, int32_t id);

#endif
