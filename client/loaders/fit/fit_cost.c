/* fit_cost: what tests/bench/results/pareto.md says of separated pairs at an error of at most 1e-6 (cold; tests/fit
 * holds this table against it): box-box 211 ns, cylinder-cylinder 835, cone-box 840, ellipsoid-ellipsoid 431,
 * hull16 501, hull64 771, hull256 2,500, mesh-mesh 39,200 at 5,000 triangles each; of sphere-sphere 26 and
 * capsule-capsule 64, as a tick asks for them (the page does in world axes, where it is quicker); and 40 to keep a pair
 * that is far apart (coherent). Rounding costs nothing. Between and beyond the sizes measured: hulls by a straight
 * line, meshes by the root of their triangles. */
#include "fit_cost.h"

#include <math.h>

enum { PAIR_NS = 40 };

static double cost_of_one(const load_shape *s)
{
    static const double ns[] = {[COLLIDED_SPHERE] = 26,
        [COLLIDED_CAPSULE] = 64,
        [COLLIDED_BOX] = 211,
        [COLLIDED_CYLINDER] = 835,
        [COLLIDED_CONE] = 840,
        [COLLIDED_ELLIPSOID] = 431,
        [COLLIDED_HALFSPACE] = 30};
    switch (s->shape.type) {
    case COLLIDED_HULL:
        return 340 + 8.2 * (double)s->points.count;
    case COLLIDED_MESH:
        return 554 * sqrt(fmax((double)s->triangles.count, 1));
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
