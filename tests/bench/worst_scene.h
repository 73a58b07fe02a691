/* worst_scene: constructions that are made to take long, each of a few numbers between 0 and 1, so that a search may
 * turn them. For bench_worst. */
#ifndef COLLIDED_TESTS_BENCH_WORST_SCENE_H
#define COLLIDED_TESTS_BENCH_WORST_SCENE_H

#include "geom/compound.h"
#include "geom/mesh.h"
#include "toi/toi.h"

#include <stddef.h>

enum { WORST_KNOBS = 8, WORST_TRIANGLES = 100000, WORST_POINTS = 40000 };

typedef enum worst_entry {
    WORST_QUERY, /* narrow_query, as world/ asks it */
    WORST_BUILD, /* hull_build */
    WORST_IMPACT /* toi_find */
} worst_entry;

typedef struct worst_scene {
    shape a, b;
    pose b_in_a;    /* WORST_QUERY */
    double *points; /* WORST_BUILD: triples */
    size_t point_count;
    toi_mover move_a, move_b; /* WORST_IMPACT; their shapes are a and b */
    toi_request request;
    mesh *meshes[2];
    hull *hulls[2];
    compound *compounds[2];
} worst_scene;

typedef struct worst_case {
    const char *name;
    worst_entry entry;
    void (*build)(const double knob[WORST_KNOBS], double size, worst_scene *out); /* of knobs 0 and 1, and the size */
    void (*place)(const double knob[WORST_KNOBS], worst_scene *s);                /* of the others; may be NULL */
    double start[WORST_KNOBS];
} worst_case;

extern const worst_case WORST_CASES[];
extern const size_t WORST_CASE_COUNT;

/* `size`: 1 for as many triangles, points and parts as there are of each case; less for fewer. */
void worst_build(const worst_case *c, const double knob[WORST_KNOBS], double size, worst_scene *out);
void worst_place(const worst_case *c, const double knob[WORST_KNOBS], worst_scene *s);
void worst_free(worst_scene *s);
size_t worst_elements(const worst_scene *s); /* triangles, points and children in all */

#endif
