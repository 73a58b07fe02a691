/* fit_cost: medians of `script/bench narrow --regime separated` (cold, a loaded two-core machine): sphere-sphere 26 ns,
 * capsule-capsule 65, box-box 225, cylinder-cylinder 1,050, cone-box 1,310, ellipsoid-ellipsoid 440, hull16 590, hull64
 * 970, hull256 2,740, and 40 to keep a pair that is far apart (coherent); `--mesh`: mesh-mesh 180,000 at 5,000
 * triangles each; and of `script/bench fit` 60,000 at 300. Rounding costs nothing. Between and beyond the sizes
 * measured: hulls by a straight line, meshes by the root of their triangles. */
#include "fit_cost.h"

#include <math.h>

enum { PAIR_NS = 40 };

static double cost_of_one(const load_shape *s)
{
    static const double ns[] = {[COLLIDED_SPHERE] = 26,
        [COLLIDED_CAPSULE] = 65,
        [COLLIDED_BOX] = 225,
        [COLLIDED_CYLINDER] = 1050,
        [COLLIDED_CONE] = 1310,
        [COLLIDED_ELLIPSOID] = 440,
        [COLLIDED_HALFSPACE] = 30};
    switch (s->shape.type) {
    case COLLIDED_HULL:
        return 450 + 8.9 * (double)s->points.count;
    case COLLIDED_MESH:
        return 3000 * sqrt(fmax((double)s->triangles.count, 1));
    case COLLIDED_HEIGHT_FIELD:
    case COLLIDED_COMPOUND:
        return 100000;
    default:
        return ns[s->shape.type];
    }
}

double fit_cost_ns(const load_shape *s)
{
    return PAIR_NS + cost_of_one(s);
}

double fit_cost_of_pair(const load_shape *a, size_t a_count, const load_shape *b, size_t b_count)
{
    double sum = 0;
    for (size_t i = 0; i < a_count; i++)
        for (size_t k = 0; k < b_count; k++) sum += PAIR_NS + fmax(cost_of_one(&a[i]), cost_of_one(&b[k]));
    return sum;
}
