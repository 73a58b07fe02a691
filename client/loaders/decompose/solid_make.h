/* solid_make: from a mesh as it was read to a solid. */
#ifndef COLLIDED_LOADERS_DECOMPOSE_SOLID_MAKE_H
#define COLLIDED_LOADERS_DECOMPOSE_SOLID_MAKE_H

#include "solid.h"

void solid_make(pool *p, const mesh_triangles *mesh, solid *out);

#endif
