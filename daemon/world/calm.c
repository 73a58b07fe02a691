/* calm: bodies whose poses change nothing. A body that is in no pair, and of which nobody asks more than who meets it,
 * has a free-motion region: as long as its position is in there, the boxes of its shapes are inside the fat ones, and a
 * tick has nothing to do but to see that it is so. Its shapes stay behind: whoever asks for their poses gets them by
 * collider_pose.
 *
 * The region is what the fat boxes leave around the tight ones, each taken where it was looked at last. Where the body
 * has turned since, by the quaternions q and q0, no point at a distance r of its origin has moved by more than
 * 2 |q - q0| r: with the angle a between the two, |q - q0| = 2 sin(a / 4), and the point moves by at most
 * 2 r sin(a / 2) = 4 r sin(a / 4) cos(a / 4).
 *
 * A body that turns is soon out of such a region, and most of them still in their fat boxes. One of a single shape has
 * a box in its own frame that holds the shape: turned, it is looked at along each axis, in some 10 ns and without the
 * shape, and the region is found anew. Tick thread. */
#include "calm.h"
#include "state.h"

#include "broad/fbox.h"

/* Rounding of boxes at the one pose and at the other, as a share of all that they are made of: much more than it is. */
static const double ROUNDING = 0x1p-44;

/* Quaternions are compared in floats; each component of the two errs by at most 2^-25, and all four together by twice
 * that. */
static const double AS_FLOATS = 5 * 0x1p-24;

/* So is how far the body is from the middle of its region: ten roundings, as a share of the region and of the reach. */
static const double OF_FLOATS = 0x1p-20;

static inline double more_of(double a, double b)
{
    return a > b ? a : b;
}
static inline double less_of(double a, double b)
{
    return a < b ? a : b;
}

static bool may_be_calm(const body *b)
{
    return !b->pair_count && !b->soft && !b->impacts && !(b->horizon > 0) && !b->deadline_ns && !b->stale && !b->held;
}

/* Looked at along each axis: how far a box turned so reaches is a sum of three products. The box is the core's; the
 * radius about it turns with nothing. */
static void find_fit(const world *w, body *b, const broad_region *region, double reach)
{
    const collider *s = &w->colliders.at[b->shapes[0]];
    shape core = s->shape;
    core.radius = 0;
    aabb own = shape_bounds(&core, s->local);
    vec3 middle = vec_scale(vec_add(own.lo, own.hi), 0.5);
    const double *lo = &own.lo.x, *hi = &own.hi.x, *c = &middle.x, *fat_lo = &region->fat.lo.x,
                 *fat_hi = &region->fat.hi.x;
    double far = 0;
    for (int k = 0; k < 3; k++) {
        b->fit_centre[k] = (float)c[k];
        b->fit_half[k] = float_up(more_of(hi[k] - b->fit_centre[k], b->fit_centre[k] - lo[k]) * (1 + 0x1p-50));
        b->fit_lo[k] = (float)fat_lo[k]; /* a float's */
        b->fit_hi[k] = (float)fat_hi[k];
        b->fit_least[k] = float_up(0.5 * region->least[k] - s->shape.radius);
        far = more_of(far, more_of(fabs(fat_lo[k]), fabs(fat_hi[k])));
    }
    double rounding = ROUNDING * (far + 4 * (reach + b->widen)) + AS_FLOATS * reach;
    b->fit_slack = float_up(s->shape.radius + b->widen + rounding);
}

static void set_region(body *b, aabb region, quat q)
{
    const double *lo = &region.lo.x, *hi = &region.hi.x;
    b->region.q = (calm_four){(float)q.w, (float)q.x, (float)q.y, (float)q.z};
    for (int k = 0; k < 3; k++) {
        float middle = (float)(0.5 * (lo[k] + hi[k]));
        b->region.middle[k] = middle;
        b->region.half[k] = float_down(less_of(hi[k] - middle, middle - lo[k]) * (1 - OF_FLOATS));
    }
    b->region.middle[3] = 0;
}

static void narrow_region(const body *b, const broad_region *region, double reach, aabb *all)
{
    const double p[3] = {b->pose.p.x, b->pose.p.y, b->pose.p.z};
    double *lo = &all->lo.x, *hi = &all->hi.x;
    for (int k = 0; k < 3; k++) {
        double slack = ROUNDING * (fabs(p[k]) + reach + b->widen) + AS_FLOATS * reach;
        lo[k] = more_of(lo[k], p[k] - region->down[k] + slack);
        hi[k] = less_of(hi[k], p[k] + region->up[k] - slack);
    }
}

void calm_find(const world *w, body *b)
{
    aabb all = {{-INFINITY, -INFINITY, -INFINITY}, {INFINITY, INFINITY, INFINITY}};
    double reach = 0, turning = 0; /* of the shapes; of their cores, which alone turn with the body */
    b->is_calm = false;
    b->fit_slack = INFINITY;
    if (!may_be_calm(b)) return;
    for (size_t i = 0; i < b->shape_count; i++) {
        const collider *s = &w->colliders.at[b->shapes[i]];
        double arm = vec_norm(s->local.p), core = s->reach - s->shape.radius + ROUNDING * s->reach;
        reach = more_of(reach, s->reach + arm);
        turning = more_of(turning, core + arm);
    }
    for (size_t i = 0; i < b->shape_count; i++) {
        broad_region region;
        aabb box = aabb_grow(w->colliders.at[b->shapes[i]].box, b->widen);
        double margin = body_margin(w, &w->colliders.at[b->shapes[i]]);
        if (!broad_region_of(w->broad, b->shapes[i], box, margin, &region) || !region.slim) return;
        narrow_region(b, &region, reach, &all);
        if (b->shape_count == 1) find_fit(w, b, &region, reach);
    }
    set_region(b, all, b->pose.q);
    b->region.half[3] = float_up(2 * (1 + OF_FLOATS) * turning);
    b->is_calm = calm_holds(b, &b->pose);
}

bool calm_find_again(body *b, const pose *at)
{
    const mat3 r = quat_matrix(at->q);
    const double *p = &at->p.x, *x = &r.x.x, *y = &r.y.x, *z = &r.z.x;
    const float *c = b->fit_centre, *h = b->fit_half;
    bool fits = true;
    aabb region;
    double *lo = &region.lo.x, *hi = &region.hi.x;
    for (int k = 0; k < 3; k++) {
        double middle = x[k] * c[0] + y[k] * c[1] + z[k] * c[2];
        double half = fabs(x[k]) * h[0] + fabs(y[k]) * h[1] + fabs(z[k]) * h[2], wide = half + b->fit_slack;
        lo[k] = b->fit_lo[k] + (wide - middle);
        hi[k] = b->fit_hi[k] - (wide + middle);
        fits &= (p[k] >= lo[k]) & (p[k] <= hi[k]) & (half >= b->fit_least[k]);
    }
    if (!fits) return false;
    set_region(b, region, at->q);
    return true;
}
