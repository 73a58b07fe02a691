/* fit_box: the orientation is searched for, from the principal axes, from the frame itself, and from large facets; the
 * sides then touch the hull. A rounded box may be moved and made smaller in each direction, too. */
#include "fit_frame.h"
#include "fit_search.h"
#include "fit_shape.h"

typedef struct box { /* rows of axes: its sides' directions */
    double centre[3], half[3], axes[3][3], q[4];
} box;

typedef struct begin {
    const fit_hull *h;
    const double *q; /* of the frame that a small rotation is added to */
    const box *from;
} begin;

static void turned(const double q[4], const double by[3], double out[4])
{
    double angle = norm3(by), unit[3] = {1, 0, 0}, small[4];
    for (int k = 0; k < 3 && angle > 0; k++) unit[k] = by[k] / angle;
    rigid_about(unit, angle, small);
    rigid_quaternion_product(q, small, out);
}

static void tight_box(const fit_hull *h, const double q[4], box *out)
{
    memcpy(out->q, q, sizeof out->q);
    fit_frame_axes(q, out->axes);
    double mid[3];
    for (int k = 0; k < 3; k++) {
        double lo = INFINITY, hi = -INFINITY;
        for (size_t i = 0; i < h->count; i++) {
            double d = dot3(out->axes[k], h->points + 3 * i);
            lo = d < lo ? d : lo;
            hi = d > hi ? d : hi;
        }
        mid[k] = (lo + hi) / 2;
        out->half[k] = (hi - lo) / 2 + 4 * h->slack;
    }
    for (int k = 0; k < 3; k++)
        out->centre[k] = mid[0] * out->axes[0][k] + mid[1] * out->axes[1][k] + mid[2] * out->axes[2][k];
}

/* Greatest signed distance of its corners from the hull. */
static double corners_away(const fit_hull *h, const box *b)
{
    double most = -INFINITY;
    for (int i = 0; i < 8; i++) {
        double x[3];
        memcpy(x, b->centre, sizeof x);
        for (int k = 0; k < 3; k++) along3(x, i >> k & 1 ? b->half[k] : -b->half[k], b->axes[k], x);
        most = fmax(most, fit_hull_away(h, x));
    }
    return most + h->slack;
}

static double radius_about_box(const fit_hull *h, const box *b)
{
    double most2 = 0;
    for (size_t i = 0; i < h->count; i++) {
        double to[3], sum = 0;
        sub3(h->points + 3 * i, b->centre, to);
        for (int k = 0; k < 3; k++) {
            double out = fabs(dot3(b->axes[k], to)) - b->half[k];
            sum += out > 0 ? out * out : 0;
        }
        most2 = sum > most2 ? sum : most2;
    }
    return sqrt(most2) + 4 * h->slack;
}

static void set_box(const box *b, double radius, double excess, fit_shape *out)
{
    *out = (fit_shape){.shape = {.scale = {1, 1, 1}}, .excess_m = excess};
    collided_shape *s = &out->shape.shape;
    *s = (collided_shape){.type = COLLIDED_BOX, .radius = radius};
    memcpy(s->half, b->half, sizeof s->half);
    memcpy(s->pose.position, b->centre, sizeof s->pose.position);
    memcpy(s->pose.orientation, b->q, sizeof s->pose.orientation);
    double x = 2 * b->half[0], y = 2 * b->half[1], z = 2 * b->half[2], pi = acos(-1), r = radius;
    out->volume = x * y * z + 2 * r * (x * y + y * z + z * x) + pi * r * r * (x + y + z) + 4 * pi / 3 * r * r * r;
}

/* ---- boxes ---- */

static double box_excess(const void *context, const double *by)
{
    const begin *from = context;
    double q[4];
    box b;
    turned(from->q, by, q);
    tight_box(from->h, q, &b);
    return corners_away(from->h, &b);
}

static void try_frame(const fit_hull *h, const double q[4], fit_shape *out)
{
    const begin from = {h, q, NULL};
    double by[3] = {0, 0, 0}, steps[3] = {0.2, 0.2, 0.2}, best[4];
    double found = fit_search(box_excess, &from, by, steps, 3, 1e-3, 150);
    if (found >= out->excess_m) return;
    box b;
    turned(q, by, best);
    tight_box(h, best, &b);
    set_box(&b, 0, corners_away(h, &b), out);
}

static size_t largest_facet(const fit_hull *h, const bool *used)
{
    size_t best = h->plane_count;
    double most = 0;
    for (size_t i = 0; i < h->plane_count; i++) {
        double u[3], v[3], n[3];
        sub3(h->points + 3 * h->corners[i][1], h->points + 3 * h->corners[i][0], u);
        sub3(h->points + 3 * h->corners[i][2], h->points + 3 * h->corners[i][0], v);
        cross3(u, v, n);
        if (used[i] || dot3(n, n) <= most) continue;
        most = dot3(n, n);
        best = i;
    }
    return best;
}

enum { FACETS = 4 };

void fit_box(const fit_hull *h, fit_shape *out)
{
    pool work = {0};
    double q[4] = {1, 0, 0, 0}, axes[3][3];
    bool *used = pool_alloc(&work, h->plane_count, sizeof *used);
    out->excess_m = INFINITY;
    try_frame(h, q, out);
    fit_frame_from_axes(h->axes, q);
    try_frame(h, q, out);
    for (int n = 0; n < FACETS; n++) {
        size_t i = largest_facet(h, used);
        if (i == h->plane_count) break;
        for (size_t k = 0; k < h->plane_count; k++)
            used[k] |= fabs(dot3(h->planes[i].normal, h->planes[k].normal)) > 0.9;
        memcpy(axes[2], h->planes[i].normal, sizeof axes[2]);
        sub3(h->points + 3 * h->corners[i][1], h->points + 3 * h->corners[i][0], axes[0]);
        double length = norm3(axes[0]);
        for (int k = 0; k < 3; k++) axes[0][k] /= length;
        cross3(axes[2], axes[0], axes[1]);
        fit_frame_from_axes((const double(*)[3])axes, q);
        try_frame(h, q, out);
    }
    pool_free(&work);
}

/* ---- rounded boxes ---- */

static void moved_box(const begin *from, const double *x, box *out)
{
    *out = *from->from;
    turned(from->from->q, x, out->q);
    fit_frame_axes(out->q, out->axes);
    for (int k = 0; k < 3; k++) {
        out->centre[k] += x[3 + k];
        out->half[k] = fmax(out->half[k] - x[6 + k], 0);
    }
}

static double rounded_excess(const void *context, const double *x)
{
    const begin *from = context;
    box b;
    moved_box(from, x, &b);
    return radius_about_box(from->h, &b) + corners_away(from->h, &b);
}

void fit_rounded_box(const fit_hull *h, const fit_shape *around, fit_shape *out)
{
    box b;
    const collided_shape *s = &around->shape.shape;
    memcpy(b.half, s->half, sizeof b.half);
    memcpy(b.centre, s->pose.position, sizeof b.centre);
    memcpy(b.q, s->pose.orientation, sizeof b.q);
    fit_frame_axes(b.q, b.axes);
    double inset = fmin(around->excess_m, fmin(b.half[0], fmin(b.half[1], b.half[2])) / 2), step = inset / 2;
    const begin from = {h, b.q, &b};
    double x[9] = {0, 0, 0, 0, 0, 0, inset, inset, inset};
    double steps[9] = {0.05, 0.05, 0.05, step, step, step, step, step, step};
    double found = fit_search(rounded_excess, &from, x, steps, 9, 1e-3, 1500);
    box best;
    moved_box(&from, x, &best);
    set_box(&best, radius_about_box(h, &best), found, out);
}
