/* fit_capsule: both ends of the segment are searched for, from each of the principal axes. */
#include "fit_frame.h"
#include "fit_search.h"
#include "fit_shape.h"

static double from_segment(const double a[3], const double b[3], const double x[3])
{
    double way[3], to[3], near[3];
    sub3(b, a, way);
    sub3(x, a, to);
    double length2 = dot3(way, way), t = length2 > 0 ? dot3(to, way) / length2 : 0;
    along3(a, t < 0 ? 0 : t > 1 ? 1 : t, way, near);
    return distance3(near, x);
}

static double radius_about_segment(const fit_hull *h, const double ends[6])
{
    double most = 0;
    for (size_t i = 0; i < h->count; i++) most = fmax(most, from_segment(ends, ends + 3, h->points + 3 * i));
    return most + 2 * h->slack;
}

static double capsule_excess(const void *context, const double *ends)
{
    const fit_hull *h = context;
    return radius_about_segment(h, ends) + fmax(fit_hull_away(h, ends), fit_hull_away(h, ends + 3));
}

/* The segment along an axis through the middle that leaves its ends to the round caps. */
static void begin_along(const fit_hull *h, const double axis[3], double ends[6])
{
    double lo = INFINITY, hi = -INFINITY, thick = 0;
    for (size_t i = 0; i < h->count; i++) {
        double to[3], foot[3];
        sub3(h->points + 3 * i, h->centre, to);
        double t = dot3(to, axis);
        along3(to, -t, axis, foot);
        lo = fmin(lo, t);
        hi = fmax(hi, t);
        thick = fmax(thick, norm3(foot));
    }
    double inset = fmin(thick, 0.49 * (hi - lo));
    along3(h->centre, lo + inset, axis, ends);
    along3(h->centre, hi - inset, axis, ends + 3);
}

static void set_capsule(const fit_hull *h, const double ends[6], fit_shape *out)
{
    double way[3], axes[3][3], r = radius_about_segment(h, ends);
    sub3(ends + 3, ends, way);
    double half = norm3(way) / 2;
    out->shape.shape = (collided_shape){.type = COLLIDED_CAPSULE, .radius = r, .pose = rigid_identity()};
    out->shape.shape.half[2] = half;
    along3(ends, 0.5, way, out->shape.shape.pose.position);
    if (half > 0) {
        frame3(way, axes);
        fit_frame_from_axes(axes, out->shape.shape.pose.orientation);
    }
    out->volume = acos(-1) * r * r * (4 * r / 3 + 2 * half);
}

void fit_capsule(const fit_hull *h, fit_shape *out)
{
    double size = distance3(h->lo, h->hi) / 32, steps[6] = {size, size, size, size, size, size};
    *out = (fit_shape){.shape = {.scale = {1, 1, 1}}, .excess_m = INFINITY};
    for (int i = 0; i < 3; i++) {
        double ends[6];
        begin_along(h, h->axes[i], ends);
        double found = fit_search(capsule_excess, h, ends, steps, 6, 1e-3, 900) + h->slack;
        if (found >= out->excess_m) continue;
        out->excess_m = found;
        set_capsule(h, ends, out);
    }
}
