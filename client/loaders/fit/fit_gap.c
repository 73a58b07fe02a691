/* fit_gap: GJK, with the faces of the simplex tried one by one. Rounding: a product of an axis and a point errs by less
 * than 8 u |axis| most, the division by 3 u more; 2^-46 of both clouds' greatest coordinates is taken off lo, and put
 * on hi, whose points err by as little. */
#include "fit_gap.h"

#include "loaders/decompose/vec3.h"

#include <stdbool.h>

enum { ITERATIONS_MAX = 48 };

typedef struct simplex {
    double w[4][3]; /* differences of a point of a and one of b */
    int count;
} simplex;

static double lowest(fit_cloud c, const double axis[3], size_t *at)
{
    double best = INFINITY;
    for (size_t i = 0; i < c.count; i++) {
        double d = dot3(c.at + 3 * i, axis);
        if (d < best) best = d, *at = i;
    }
    return best;
}

static double highest(fit_cloud c, const double axis[3], size_t *at)
{
    double best = -INFINITY;
    for (size_t i = 0; i < c.count; i++) {
        double d = dot3(c.at + 3 * i, axis);
        if (d > best) best = d, *at = i;
    }
    return best;
}

static double slack_of(fit_cloud a, fit_cloud b)
{
    return 0x1p-46 * (a.most + b.most);
}

double fit_gap_along(fit_cloud a, fit_cloud b, const double axis[3])
{
    size_t i = 0, k = 0;
    double length = norm3(axis);
    if (!(length > 0x1p-500)) return -INFINITY;
    return (lowest(a, axis, &i) - highest(b, axis, &k)) / length - slack_of(a, b);
}

/* ---- the point of a simplex that is nearest to the origin ---- */

typedef struct nearest {
    double point[3], distance2;
    unsigned corners; /* bits */
} nearest;

static void offer(nearest *best, const double point[3], unsigned corners)
{
    double distance2 = dot3(point, point);
    if (!(distance2 < best->distance2)) return;
    best->distance2 = distance2;
    memcpy(best->point, point, sizeof best->point);
    best->corners = corners;
}

static void try_edge(const simplex *s, int i, int k, nearest *best)
{
    double way[3], point[3];
    sub3(s->w[k], s->w[i], way);
    double length2 = dot3(way, way), t = -dot3(s->w[i], way);
    if (!(t > 0 && t < length2)) return;
    along3(s->w[i], t / length2, way, point);
    offer(best, point, 1u << i | 1u << k);
}

static void try_face(const simplex *s, int i, int k, int l, nearest *best)
{
    double u[3], v[3], n[3], c[3], point[3];
    sub3(s->w[k], s->w[i], u);
    sub3(s->w[l], s->w[i], v);
    cross3(u, v, n);
    double n2 = dot3(n, n);
    if (!(n2 > 1e-24 * dot3(u, u) * dot3(v, v))) return;
    const double to[3] = {-s->w[i][0], -s->w[i][1], -s->w[i][2]};
    cross3(to, v, c);
    double r = dot3(c, n);
    cross3(u, to, c);
    double t = dot3(c, n);
    if (!(r > 0 && t > 0 && r + t < n2)) return;
    double height = dot3(s->w[i], n) / n2;
    for (int m = 0; m < 3; m++) point[m] = height * n[m];
    offer(best, point, 1u << i | 1u << k | 1u << l);
}

static bool holds_origin(const simplex *s)
{
    for (int i = 0; i < 4; i++) { /* each corner and the origin are on one side of the other three */
        double u[3], v[3], n[3], d[3];
        const double *base = s->w[(i + 1) % 4];
        sub3(s->w[(i + 2) % 4], base, u);
        sub3(s->w[(i + 3) % 4], base, v);
        cross3(u, v, n);
        sub3(s->w[i], base, d);
        double corner = dot3(n, d), origin = -dot3(n, base);
        if (!(corner * origin > 0)) return false;
    }
    return true;
}

/* Leaves only the corners whose hull has the point. False: the origin is inside. */
static bool reduce(simplex *s, double point[3])
{
    nearest best = {.distance2 = INFINITY};
    if (s->count == 4 && holds_origin(s)) return false;
    for (int i = 0; i < s->count; i++) {
        offer(&best, s->w[i], 1u << i);
        for (int k = 0; k < i; k++) {
            try_edge(s, i, k, &best);
            for (int l = 0; l < k; l++) try_face(s, i, k, l, &best);
        }
    }
    int kept = 0;
    for (int i = 0; i < s->count; i++)
        if (best.corners >> i & 1) memmove(s->w[kept++], s->w[i], sizeof s->w[i]);
    s->count = kept;
    memcpy(point, best.point, sizeof best.point);
    return true;
}

void fit_gap_find(fit_cloud a, fit_cloud b, const double start[3], double enough, double goal, fit_gap *out)
{
    double v[3] = {start[0], start[1], start[2]}, slack = slack_of(a, b);
    simplex s = {.count = 0};
    *out = (fit_gap){-INFINITY, INFINITY, {start[0], start[1], start[2]}};
    if (!(dot3(v, v) > 0x1p-900)) v[0] = 1, v[1] = v[2] = 0;
    for (int n = 0; n < ITERATIONS_MAX; n++) {
        size_t i = 0, k = 0;
        double length = norm3(v), lo = (lowest(a, v, &i) - highest(b, v, &k)) / length - slack;
        if (lo > out->lo) {
            out->lo = lo;
            memcpy(out->axis, v, sizeof v);
        }
        if (out->hi - out->lo <= enough || out->lo > goal) return;
        double w[3];
        sub3(a.at + 3 * i, b.at + 3 * k, w);
        for (int c = 0; c < s.count; c++) /* NOLINTNEXTLINE(*-suspicious-memory-comparison): the very same point */
            if (memcmp(s.w[c], w, sizeof w) == 0) return; /* as near as rounding lets it come */
        memcpy(s.w[s.count++], w, sizeof w);
        if (!reduce(&s, v)) {
            out->hi = slack;
            return;
        }
        double hi = norm3(v) + slack;
        if (hi >= out->hi && n > 0) return;
        out->hi = hi;
        if (!(hi > 2 * slack)) return;
    }
}
