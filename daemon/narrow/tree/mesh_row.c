/* Four triangles side by side, with the registers that every processor has: mesh_row_wide.c has the wide ones. Pure;
 * any thread. */
#include "mesh_row.h"

#include "geom/simd.h"

LANES_INLINE lanes greater_by_mask(lanes x, lanes y)
{
    return lanes_choose(x > y, x, y);
}
LANES_INLINE lanes lesser_by_mask(lanes x, lanes y)
{
    return lanes_choose(x < y, x, y);
}
LANES_INLINE lanes pick_one_by_one(const double v[LANES], uint32_t which)
{
    return (lanes){v[mesh_pick(which, 0)], v[mesh_pick(which, 1)], v[mesh_pick(which, 2)], v[mesh_pick(which, 3)]};
}

#define row_greater_of greater_by_mask
#define row_lesser_of lesser_by_mask
#define row_choose lanes_choose
#define row_pick pick_one_by_one
#define row_bits_of lanes_bits
#include "mesh_row_lanes.h"

static const mesh_row_kernel *kernel(void)
{
    return lanes_wide() ? mesh_row_wide : &KERNEL;
}

void mesh_four_set(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    kernel()->four_set(f, corners, count, scale, b_in_a);
}

unsigned mesh_row_near(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out)
{
    return kernel()->row_near(a, b, p, within2, out);
}

unsigned mesh_fours_near(const mesh_four *a, const mesh_four *b, const double levels_a[MESH_LEAF_MAX],
    const double levels_b[MESH_LEAF_MAX], double within)
{
    return kernel()->fours_near(a, b, levels_a, levels_b, within);
}

unsigned mesh_row_near_core(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return kernel()->core_near(b, a, near, within2, out);
}

unsigned mesh_row_near_box(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return kernel()->box_near(b, a, near, within2, out);
}

void mesh_four_levels(const mesh_four *f, vec3 axis, double levels[LANES])
{
    kernel()->four_levels(f, axis, levels);
}

void mesh_four_spot(const mesh_four *f, uint32_t i, mesh_spot *s)
{
    for (int k = 0; k < 3; k++) s->corner[k] = vec(f->corner[k][0][i], f->corner[k][1][i], f->corner[k][2][i]);
    s->lo = vec(f->lo[0][i], f->lo[1][i], f->lo[2][i]);
    s->hi = vec(f->hi[0][i], f->hi[1][i], f->hi[2][i]);
    s->normal = vec(f->normal[0][i], f->normal[1][i], f->normal[2][i]);
}
