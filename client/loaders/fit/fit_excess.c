/* fit_excess: a glance at where the hull's points are; then the solid's normals; then a long look. */
#include "fit_excess.h"

#include "loaders/decompose/deviate.h"
#include "loaders/decompose/overhang.h"

#include <math.h>
#include <string.h>

enum { STEPS = 30000, GLANCE_STEPS = 300 };

static piece piece_of(const fit_hull *h)
{
    piece p = {.points = h->points, .point_count = h->count, .planes = h->planes, .plane_count = h->plane_count};
    memcpy(p.lo, h->lo, sizeof p.lo);
    memcpy(p.hi, h->hi, sizeof p.hi);
    return p;
}

double fit_excess_of_hull(const solid *s, const fit_hull *h, double wanted)
{
    const deviate_effort glance = {.ratio = 1, .floor = wanted / 2, .steps = GLANCE_STEPS, .places_only = true};
    const deviate_effort effort = {.ratio = 0.05, .floor = wanted / 2, .steps = STEPS, .places_only = true};
    piece p = piece_of(h);
    if (deviate_find(s, &p, &glance) > wanted) return p.deviation;
    double bound = overhang_bound(s->overhang, s, h->planes, h->plane_count, wanted / 16, wanted, OVERHANG_WORK);
    if (bound <= wanted) return bound;
    deviate_find(s, &p, &effort);
    return fmin(bound, p.deviation);
}
