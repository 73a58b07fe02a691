/* elementary_sets: queries for the tests and the benchmark: made from a seed by class, or read from the shared case
 * files. The classes are those in which floating point goes wrong. */
#ifndef COLLIDED_TESTS_ELEMENTARY_SETS_H
#define COLLIDED_TESTS_ELEMENTARY_SETS_H

#include "elementary_oracle.h"

#include <stddef.h>
#include <stdint.h>

typedef enum elementary_class {
    ELEMENTARY_RANDOM,      /* eight points in a cube, about every third a hit */
    ELEMENTARY_GRID,        /* whole numbers up to 1 or 3: contacts at corners, coplanar, coincident points */
    ELEMENTARY_BUILT,       /* a contact at a chosen place and time, then moved by a last bit or not at all */
    ELEMENTARY_COPLANAR,    /* all in one plane, at rest or moving in it: the cubic is zero */
    ELEMENTARY_TURNING,     /* all in one plane that turns: zero too, but no plane is fixed */
    ELEMENTARY_SLIVER,      /* nearly parallel edges, needles of triangles */
    ELEMENTARY_ZERO_LENGTH, /* edges and faces that are a point or a line, at one end or both */
    ELEMENTARY_COINCIDENT,  /* a shared point, at the start, at the end or between */
    ELEMENTARY_FAR,         /* a contact, shifted by 2^20 to 2^40 sizes */
    ELEMENTARY_CLOTH,       /* two sheets: size 1, motion 0.1 a step, mostly passing by */
    ELEMENTARY_NEAR_MISS,   /* past each other at 1e-3 to 1e-9 of the size */
    ELEMENTARY_LATTICE,     /* as machines go: axis-parallel edges and faces in eighths that rest, slide in contact,
                               graze, end exactly in contact or part from it; some off by 1e-15 to 1e-3 */
    ELEMENTARY_CLASSES,
} elementary_class;

const char *elementary_class_name(elementary_class c);

/* The n-th query of a class; the same for the same arguments. Odd n: edge against edge. */
elementary_query elementary_make(elementary_class c, uint64_t n);

uint64_t elementary_random(uint64_t *state);

typedef struct elementary_case { /* a line of a shared file */
    elementary_query query;
    elementary_truth truth;
} elementary_case;

/* All lines of cases/ccd/NAME in COLLIDED_SHARED, the environment's or the build's; owned by the caller. NULL: absent.
 * A line that is none aborts. */
elementary_case *elementary_read(const char *name, size_t *count);

#endif
