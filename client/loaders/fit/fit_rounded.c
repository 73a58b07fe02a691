/* fit_rounded: a hull of few of the corners, rounded. Corners are added until no other is farther than the radius: each
 * time that which is farthest. */
#include "fit_shape.h"
#include "loaders/decompose/vec3.h"
#include "loaders/rigid.h"

typedef struct core {
    const fit_hull *h;
    double *points;
    size_t count;
    double *away; /* of each corner of the hull: no farther than this from the core */
} core;

static void add(core *c, size_t corner)
{
    memcpy(c->points + 3 * c->count++, c->h->points + 3 * corner, 3 * sizeof *c->points);
    for (size_t i = 0; i < c->h->count; i++) {
        const double *x = c->h->points + 3 * i;
        double start[3];
        fit_gap gap;
        if (c->away[i] == 0) continue; /* its own corners */
        sub3(x, c->points, start);
        fit_gap_find((fit_cloud){x, 1, c->h->most}, (fit_cloud){c->points, c->count, c->h->most}, start, c->h->slack,
            INFINITY, &gap);
        c->away[i] = fmin(c->away[i], gap.hi);
    }
    c->away[corner] = 0;
}

static size_t farthest(const core *c)
{
    size_t best = 0;
    for (size_t i = 1; i < c->h->count; i++)
        if (c->away[i] > c->away[best]) best = i;
    return best;
}

static size_t lowest_along(const fit_hull *h, const double axis[3])
{
    size_t best = 0;
    for (size_t i = 1; i < h->count; i++)
        if (dot3(axis, h->points + 3 * i) < dot3(axis, h->points + 3 * best)) best = i;
    return best;
}

static double angle_between(const double a[3], const double b[3])
{
    double c[3];
    cross3(a, b, c);
    return atan2(norm3(c), dot3(a, b));
}

/* Of the facet on the other side of the edge from corner `from` to corner `to`. */
static const double *normal_beyond(const fit_hull *h, int32_t from, int32_t to)
{
    for (size_t i = 0; i < h->plane_count; i++)
        for (int k = 0; k < 3; k++)
            if (h->corners[i][k] == to && h->corners[i][(k + 1) % 3] == from) return h->planes[i].normal;
    return h->planes[0].normal; /* it is closed: there is one */
}

/* Steiner's formula: volume, surface r, half of each edge's length by its angle r^2, and the ball's own. */
static double rounded_volume(const fit_hull *h, double r)
{
    double area = 0, bend = 0;
    for (size_t i = 0; i < h->plane_count; i++) {
        const double *at[3];
        double u[3], v[3], n[3];
        for (int k = 0; k < 3; k++) at[k] = h->points + 3 * h->corners[i][k];
        sub3(at[1], at[0], u);
        sub3(at[2], at[0], v);
        cross3(u, v, n);
        area += norm3(n) / 2;
        for (int k = 0; k < 3; k++) /* each edge is met twice */
            bend += distance3(at[k], at[(k + 1) % 3]) / 4 *
                    angle_between(h->planes[i].normal, normal_beyond(h, h->corners[i][k], h->corners[i][(k + 1) % 3]));
    }
    return h->volume + area * r + bend * r * r + 4 * acos(-1) / 3 * r * r * r;
}

/* Flat cores are no hulls: at least four corners, which add() takes out of one plane one after the other. */
bool fit_rounded_hull(pool *p, const fit_hull *h, double radius_m, fit_shape *out)
{
    core c = {h, pool_alloc(p, h->count, 3 * sizeof *c.points), 0, pool_alloc(p, h->count, sizeof *c.away)};
    for (size_t i = 0; i < h->count; i++) c.away[i] = INFINITY;
    add(&c, lowest_along(h, h->axes[0]));
    size_t next = farthest(&c);
    while (c.count < h->count && (c.count < 4 || c.away[next] + 3 * h->slack > radius_m)) {
        add(&c, next);
        next = farthest(&c);
    }
    if (c.count + 1 >= h->count) return false;
    fit_hull made;
    pool work = {0};
    bool solid = fit_hull_make(&work, c.points, c.count, &made);
    double radius = c.away[next] + 2 * h->slack;
    *out = (fit_shape){.shape = {.scale = {1, 1, 1}}, .volume = solid ? rounded_volume(&made, radius) : 0};
    pool_free(&work);
    out->shape.shape = (collided_shape){.type = COLLIDED_HULL, .radius = radius};
    out->shape.shape.pose = rigid_identity();
    out->shape.points = (mesh_points){c.points, c.count};
    out->excess_m = out->shape.shape.radius + h->slack; /* its corners are the hull's: none is outside */
    return solid;
}

void fit_whole_hull(const fit_hull *h, fit_shape *out)
{
    *out = (fit_shape){.shape = {.scale = {1, 1, 1}}, .volume = h->volume, .excess_m = 3 * h->slack};
    out->shape.shape = (collided_shape){.type = COLLIDED_HULL, .radius = 2 * h->slack, .pose = rigid_identity()};
    out->shape.points = (mesh_points){h->points, h->count};
}

const char *fit_shape_word(const load_shape *s)
{
    static const char *const words[] = {"sphere", "capsule", "box", "cylinder", "cone", "ellipsoid", "half-space",
        "hull", "mesh", "height field", "compound"};
    if (s->shape.type == COLLIDED_BOX && s->shape.radius > 0) return "rounded box";
    if (s->shape.type == COLLIDED_HULL && s->shape.radius > 1e-6) return "rounded hull";
    return words[s->shape.type];
}
