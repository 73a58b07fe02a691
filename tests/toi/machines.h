/* machines: motions as machines make them, with small clearances: sliding in a guide, lifting off, turning about a
 * hinge, and coming to a stop. When they touch is known by construction. */
#ifndef COLLIDED_TESTS_MACHINES_H
#define COLLIDED_TESTS_MACHINES_H

#include "solids.h"
#include "toi/toi.h"

typedef struct compound compound;

typedef struct machine {
    const char *name;
    shape shapes[2];
    mesh *meshes[2];        /* owned, or NULL */
    compound *compounds[2]; /* the same */
    toi_mover movers[2];    /* of these shapes: a machine must not be copied */
    toi_request request;
    double shrink;
    double hit; /* s: when they touch; INFINITY: never */
} machine;

/* The scenes, and how many there are; `size` from 1 on multiplies what they are made of, `shrink` the clearances. */
enum { MACHINES = 31 };
void machine_make(int scene, int size, double shrink, machine *out);
void machine_free(machine *m);

/* toi_find, in canonical order whichever way round they are. */
toi_result machine_find(const machine *m, narrow_scratch *scratch);

#endif
