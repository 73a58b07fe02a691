/* toi_leaves: the triangles of two leaves of meshes, all pairs of them side by side: which may meet, and from when on.
 * One direction, at both ends of a piece of the motion, tells of up to 16 pairs at once. Pure; any thread. */
#ifndef COLLIDED_NARROW_TOI_LEAVES_H
#define COLLIDED_NARROW_TOI_LEAVES_H

#include "toi_sweep.h"

enum { LEAF_PAIRS = MESH_LEAF_MAX * MESH_LEAF_MAX };

/* Is it a leaf of a mesh, whose children are its triangles? */
bool toi_leaves_apply(const toi_part *p);

/* Given that they do not meet before `from`: entry[MESH_LEAF_MAX * i + k] is a time before which triangle i of A and k
 * of B do not, either. INFINITY: not before `until`, or there is no such triangle. */
void toi_leaves_entries(
    sweep *s, const toi_part *a, const toi_part *b, double from, double until, double entry[LEAF_PAIRS]);

#endif
