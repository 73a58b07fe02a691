/* mesh_row_wide: mesh_row.h with registers of 32 bytes, where the processor has them (lanes_wide): a least or greatest
 * takes one instruction there, and gcc finds it only when told. The same bits. For mesh_row.c. */
#ifndef COLLIDED_NARROW_MESH_ROW_WIDE_H
#define COLLIDED_NARROW_MESH_ROW_WIDE_H

#include "mesh_row.h"

void mesh_four_set_wide(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a);
unsigned mesh_fours_near_wide(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
    const double levels_b[MESH_LEAF_MAX], double within);
unsigned mesh_row_near_wide(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out);
unsigned mesh_row_near_core_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out);
unsigned mesh_row_near_box_wide(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out);
void mesh_four_levels_wide(const mesh_four *f, vec3 axis, double levels[MESH_LEAF_MAX]);

#endif
