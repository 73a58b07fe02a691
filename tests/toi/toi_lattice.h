/* toi_lattice: motions as machines make them, from a seed. Sizes, places, speeds and turns lie on a lattice: faces that
 * slide in contact or graze, bodies that come to rest exactly in contact, part from it, turn by quarter turns about
 * their own or a common axis, or do not move relative to each other; some of them disturbed by 1e-15 to 1e-3. */
#ifndef COLLIDED_TESTS_TOI_LATTICE_H
#define COLLIDED_TESTS_TOI_LATTICE_H

#include "toi_pairs.h"

/* The solids that lattice pairs have besides the convex types: built once, freed by toi_lattice_destroy. */
void toi_lattice_create(void);
void toi_lattice_destroy(void);

enum { TOI_LATTICE_MESH = SHAPE_CONVEX_COUNT, TOI_LATTICE_COMPOUND, TOI_LATTICE_TYPES }; /* after the convex types */

typedef enum toi_lattice_way {
    LATTICE_SLIDES,     /* across the axis along which they are placed */
    LATTICE_APPROACHES, /* along it, so that it ends in contact, or beyond it */
    LATTICE_PARTS,
    LATTICE_RESTS,   /* relative to each other; both may move */
    LATTICE_CROSSES, /* any direction in eighths */
    LATTICE_TURNS,   /* one or both, by quarter turns about an axis of the world; they may move, too */
    LATTICE_ORBITS,  /* both about one axis, as one body or one of them about the other */
    LATTICE_SPINS,   /* each about its own z */
    LATTICE_WAYS
} toi_lattice_way;
extern const char *const toi_lattice_way_names[LATTICE_WAYS];

/* The pair must not be copied: its movers point to its shapes. */
toi_lattice_way toi_lattice_make(uint64_t seed, int type_a, int type_b, toi_pair *out);

#endif
