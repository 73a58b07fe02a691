/* soft_scene: meshes in motion for the tests and the benchmark of soft bodies: made from a seed, or read from the
 * shared frames with their exact truth (COLLIDED_SHARED, the environment's or the build's, cases/soft). */
#ifndef COLLIDED_TESTS_SOFT_SCENE_H
#define COLLIDED_TESTS_SOFT_SCENE_H

#include "soft/soft.h"

typedef struct soft_scene { /* owned: soft_scene_free */
    vec3 *start, *end;
    uint32_t (*triangles)[3];
    size_t vertex_count, triangle_count;
} soft_scene;

void soft_scene_free(soft_scene *s);

/* ---- made ---- */

typedef enum soft_class {
    SOFT_CRUMPLED, /* a sheet, each vertex moved at random by about an edge's length, at the start and again by the end
                    */
    SOFT_FOLDED,   /* a sheet that folds over onto itself */
    SOFT_KNOTTED,  /* a ribbon along a closed knot that pulls tight through itself */
    SOFT_SLIDING,  /* two layers of one mesh within a plane, sliding: coplanar */
    SOFT_LATTICE,  /* corners in whole numbers: vertices upon vertices, edges along edges */
    SOFT_SOUP,     /* triangles, hair (a, b, b) and points without neighbours, at random */
    SOFT_CLASSES,
} soft_class;

const char *soft_class_name(soft_class c);
soft_scene soft_scene_make(soft_class c, uint64_t seed, size_t about_triangles);

/* A sheet of cells x cells squares, about 1 m wide, that waves. time in s, step of dt; violence 0 = calm: it never
 * comes near itself; 1: it crumples. */
soft_scene soft_scene_cloth(size_t cells, double time, double dt, double violence);

/* ---- shared ---- */

typedef struct soft_truth {
    const char *name, *start, *end, *number; /* folder, meshes, and the number in the names of the lists */
    size_t vertex_face, edge_edge;           /* contacts by exact arithmetic */
} soft_truth;

enum { SOFT_TRUTHS = 3 };
extern const soft_truth SOFT_TRUTH[SOFT_TRUTHS];

/* False: it is not there. A file that is damaged aborts. */
bool soft_scene_read(const soft_truth *t, soft_scene *out);

/* The contacts of the lists that are true: keys of our numbers (a << 32 | b), ascending; owned by the caller. */
uint64_t *soft_truth_read(const soft_truth *t, const soft_mesh *m, soft_kind kind, size_t *count);

#endif
