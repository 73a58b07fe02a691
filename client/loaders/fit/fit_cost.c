/* fit_cost: what tests/bench/results/pareto.md says of separated pairs at an error of at most 1e-6 (cold; tests/loaders
 * holds this table against it): sphere-sphere 49 ns, capsule-capsule 86, box-box 366, cylinder-cylinder 1,060, cone-box
 * 1,100, ellipsoid-ellipsoid 457, hull16 585, hull64 847, hull256 2,140, mesh-mesh 36,800 at 5,000 triangles each; and
 * 40 to keep a pair that is far apart (coherent). Rounding costs nothing. Between and beyond the sizes measured: hulls
 * by a straight line, meshes by the root of their triangles. */
#include "fit_cost.h"

#include <math.h>

enum { PAIR_NS = 40 };

static double cost_of_one(const load_shape *s)
{
    static const double ns[] = {[COLLIDED_SPHERE] = 49,
        [COLLIDED_CAPSULE] = 86,
        [COLLIDED_BOX] = 366,
        [COLLIDED_CYLINDER] = 1060,
        [COLLIDED_CONE] = 1100,
        [COLLIDED_ELLIPSOID] = 457,
        [COLLIDED_HALFSPACE] = 30};
    switch (s->shape.type) {
    case COLLIDED_HULL:
        return 500 + 6.5 * (double)s->points.count;
    case COLLIDED_MESH:
        return 520 * sqrt(fmax((double)s->triangles.count, 1));
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
