/* fit_sphere: the centre is searched for from the middle of the box. */
#include "fit_search.h"
#include "fit_shape.h"
#include "loaders/decompose/vec3.h"
#include "loaders/rigid.h"

static double radius_about_point(const fit_hull *h, const double centre[3])
{
    double most = 0;
    for (size_t i = 0; i < h->count; i++) most = fmax(most, distance3(h->points + 3 * i, centre));
    return most + h->slack;
}

static double sphere_excess(const void *context, const double *centre)
{
    const fit_hull *h = context;
    return radius_about_point(h, centre) + fit_hull_away(h, centre);
}

void fit_sphere(const fit_hull *h, fit_shape *out)
{
    double size = distance3(h->lo, h->hi), centre[3], steps[3] = {size / 16, size / 16, size / 16};
    memcpy(centre, h->centre, sizeof centre);
    *out = (fit_shape){.shape = {.scale = {1, 1, 1}}};
    out->excess_m = fit_search(sphere_excess, h, centre, steps, 3, 1e-4, 400) + h->slack;
    double r = radius_about_point(h, centre);
    out->shape.shape = (collided_shape){.type = COLLIDED_SPHERE, .radius = r, .pose = rigid_identity()};
    memcpy(out->shape.shape.pose.position, centre, sizeof centre);
    out->volume = 4 * acos(-1) / 3 * r * r * r;
}
