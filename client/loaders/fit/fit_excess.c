/* fit_excess: the faces, edges and corners of a solid, each with the directions in which points outside can have their
 * nearest point there; and how far it is from there to the hull's surface, at most. */
#include "fit_excess.h"

#include "loaders/decompose/deviate.h"
#include "loaders/decompose/vec3.h"

#include <stdlib.h>

enum { SPLITS_MAX = 14, AROUND_MAX = 64 /* different normals at a corner */, STEPS = 30000, GLANCE_STEPS = 300 };
static const double CLOSE = 1.05;       /* bound over a value that occurs: near enough */
static const double NORMAL_U = 0x1p-40; /* more than what a unit normal errs by */

typedef struct spot { /* all y in the hull of `at`, all u in the cone of `way` */
    double at[3][3], way[3][3];
    int at_count, way_count;
} spot;

typedef struct search {
    const solid *s;
    const fit_hull *h;
    double floor, occurs, bound;
    bool lost; /* a cone was too wide, or there is no hope */
} search;

static void middle(const double points[3][3], int count, double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = points[0][k];
    for (int i = 1; i < count; i++) along3(out, 1, points[i], out);
    for (int k = 0; k < 3; k++) out[k] /= count;
}

/* The bound of the spot; and what its middle comes to, which is how far splitting can get. */
static double look(search *q, const spot *x)
{
    double bound = INFINITY, value = INFINITY, y[3], u[3];
    middle(x->at, x->at_count, y);
    middle(x->way, x->way_count, u);
    double length = norm3(u);
    for (size_t f = 0; f < q->h->plane_count; f++) {
        const piece_plane *m = &q->h->planes[f];
        double least = INFINITY, far = -INFINITY, here = dot3(m->normal, u);
        if (!(here > 0)) continue;
        for (int i = 0; i < x->way_count; i++) {
            double along = dot3(m->normal, x->way[i]) - NORMAL_U;
            least = along < least ? along : least;
        }
        double room = m->offset - dot3(m->normal, y);
        room = room > 0 ? room : 0;
        if (room * length < value * here) value = room * length / here;
        if (!(least > 0)) continue;
        for (int i = 0; i < x->at_count; i++) {
            double below = m->offset - dot3(m->normal, x->at[i]);
            far = below > far ? below : far;
        }
        far = (far > 0 ? far : 0) + q->h->slack;
        if (far < bound * least) bound = far / least;
    }
    if (value < INFINITY) q->occurs = fmax(q->occurs, value);
    return bound;
}

static double longest(const double points[3][3], int count, int ends[2])
{
    double most = 0;
    for (int i = 0; i < count; i++)
        for (int k = 0; k < i; k++) {
            double d = distance3(points[i], points[k]);
            if (d <= most) continue;
            most = d;
            ends[0] = i;
            ends[1] = k;
        }
    return most;
}

/* Halves the longest side of the place or of the cone, whichever is longer against what it can be. */
static bool split(const search *q, const spot *x, spot parts[2])
{
    int ends[2] = {0, 0}, ways[2] = {0, 0};
    double size = longest(x->at, x->at_count, ends) / distance3(q->h->lo, q->h->hi);
    double angle = longest(x->way, x->way_count, ways) / 2;
    if (!(fmax(size, angle) > 0x1p-24)) return false;
    parts[0] = parts[1] = *x;
    double half[3];
    const double(*of)[3] = angle > size ? x->way : x->at;
    const int *pair = angle > size ? ways : ends;
    for (int k = 0; k < 3; k++) half[k] = (of[pair[0]][k] + of[pair[1]][k]) / 2;
    if (angle > size) {
        double length = norm3(half);
        for (int k = 0; k < 3; k++) half[k] /= length;
    }
    for (int i = 0; i < 2; i++) memcpy(angle > size ? parts[i].way[pair[i]] : parts[i].at[pair[i]], half, sizeof half);
    return true;
}

static void settle(search *q, const spot *x, int splits)
{
    double bound = look(q, x);
    if (bound <= q->bound || bound <= fmax(q->floor, CLOSE * q->occurs)) {
        q->bound = fmax(q->bound, bound);
        return;
    }
    spot parts[2];
    if (splits == 0 || !split(q, x, parts)) {
        q->bound = bound;
        return;
    }
    for (int i = 0; i < 2; i++) settle(q, &parts[i], splits - 1);
}

/* ---- where the nearest points can be ---- */

typedef void use_spot(search *q, const spot *x);

static void refine(search *q, const spot *x)
{
    settle(q, x, SPLITS_MAX);
}

static void glance(search *q, const spot *x)
{
    look(q, x);
}

static void faces(search *q, use_spot *use)
{
    for (size_t i = 0; i < q->s->count; i++) {
        spot x = {.at_count = 3, .way_count = 1};
        memcpy(x.at, q->s->triangles[i].at, sizeof x.at);
        memcpy(x.way[0], q->s->triangles[i].normal, sizeof x.way[0]);
        use(q, &x);
    }
}

typedef struct side { /* of a triangle; or one of its corners, twice */
    double low[3], high[3];
    const double *normal;
} side;

static int by_place(const void *left, const void *right)
{
    const double *a = ((const side *)left)->low, *b = ((const side *)right)->low; /* high follows low */
    for (int k = 0; k < 6; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

static void put_side(side *out, const solid_triangle *t, int i, int k)
{
    int order = 0;
    for (int c = 0; c < 3 && order == 0; c++) order = (t->at[i][c] > t->at[k][c]) - (t->at[i][c] < t->at[k][c]);
    memcpy(out->low, t->at[order > 0 ? k : i], sizeof out->low);
    memcpy(out->high, t->at[order > 0 ? i : k], sizeof out->high);
    out->normal = t->normal;
}

static void edges(search *q, const side *sides, size_t count, use_spot *use)
{
    for (size_t i = 0, end; i < count; i = end) {
        for (end = i + 1; end < count && by_place(&sides[i], &sides[end]) == 0;) end++;
        for (size_t a = i; a < end; a++)
            for (size_t b = i; b < a; b++) {
                spot x = {.at_count = 2, .way_count = 2};
                memcpy(x.at[0], sides[i].low, sizeof x.at[0]);
                memcpy(x.at[1], sides[i].high, sizeof x.at[1]);
                memcpy(x.way[0], sides[a].normal, sizeof x.way[0]);
                memcpy(x.way[1], sides[b].normal, sizeof x.way[1]);
                use(q, &x);
            }
    }
}

typedef struct flat { /* a direction where it meets the plane mean . u = 1 */
    double x, y;
    const double *normal;
} flat;

static int by_x(const void *left, const void *right)
{
    const flat *a = left, *b = right;
    return a->x != b->x ? (a->x < b->x ? -1 : 1) : (a->y > b->y) - (a->y < b->y);
}

static double turn(const flat *a, const flat *b, const flat *c)
{
    return (b->x - a->x) * (c->y - a->y) - (b->y - a->y) * (c->x - a->x);
}

/* Andrew's monotone chain. */
static int outline(flat *points, int count, flat *out)
{
    int n = 0;
    qsort(points, (size_t)count, sizeof *points, by_x);
    for (int i = 0; i < count; i++) {
        while (n >= 2 && turn(&out[n - 2], &out[n - 1], &points[i]) <= 0) n--;
        out[n++] = points[i];
    }
    for (int i = count - 2, lower = n + 1; i >= 0; i--) {
        while (n >= lower && turn(&out[n - 2], &out[n - 1], &points[i]) <= 0) n--;
        out[n++] = points[i];
    }
    return n > 1 ? n - 1 : n;
}

/* The cone of many normals is that of those that are outermost, seen against their mean. */
static void corner(search *q, const double at[3], const double *const *normals, int count, use_spot *use)
{
    double mean[3] = {0, 0, 0}, u[3], v[3];
    flat points[AROUND_MAX], around[2 * AROUND_MAX];
    for (int i = 0; i < count; i++) along3(mean, 1, normals[i], mean);
    double length = norm3(mean);
    for (int k = 0; k < 3; k++) mean[k] /= length;
    int least = 0;
    for (int k = 1; k < 3; k++) least = fabs(mean[k]) < fabs(mean[least]) ? k : least;
    const double axis[3] = {least == 0, least == 1, least == 2};
    cross3(mean, axis, u);
    cross3(mean, u, v);
    for (int i = 0; i < count; i++) {
        double up = dot3(mean, normals[i]);
        if (!(up > 0.02)) q->lost = true;
        points[i] = (flat){dot3(u, normals[i]) / up, dot3(v, normals[i]) / up, normals[i]};
    }
    if (q->lost) return;
    int n = outline(points, count, around);
    for (int i = 1; i + 1 < n || (n < 3 && i < 2); i++) {
        spot x = {.at_count = 1, .way_count = n < 3 ? n : 3};
        memcpy(x.at[0], at, sizeof x.at[0]);
        memcpy(x.way[0], around[0].normal, sizeof x.way[0]);
        for (int k = 1; k < x.way_count; k++) memcpy(x.way[k], around[i + k - 1].normal, sizeof x.way[k]);
        use(q, &x);
    }
}

static void corners(search *q, const side *sides, size_t count, use_spot *use)
{
    for (size_t i = 0, end; i < count; i = end) {
        const double *normals[AROUND_MAX];
        int different = 0;
        for (end = i; end < count && by_place(&sides[i], &sides[end]) == 0; end++) {
            bool known = false;
            for (int k = 0; k < different && !known; k++) known = distance3(normals[k], sides[end].normal) < 0x1p-45;
            if (known) continue;
            if (different == AROUND_MAX)
                q->lost = true;
            else
                normals[different++] = sides[end].normal;
        }
        if (!q->lost) corner(q, sides[i].low, normals, different, use);
    }
}

double fit_excess_by_normals(const solid *s, const fit_hull *h, double floor, double wanted)
{
    search q = {.s = s, .h = h, .floor = floor};
    for (size_t i = 0; i < s->count; i++)
        if (!s->triangles[i].backed) return INFINITY; /* none is, where it is open */
    pool work = {0};
    side *along = pool_alloc(&work, 3 * s->count, sizeof *along), *at = pool_alloc(&work, 3 * s->count, sizeof *at);
    for (size_t i = 0; i < 3 * s->count; i++) {
        put_side(&along[i], &s->triangles[i / 3], (int)(i % 3), (int)((i + 1) % 3));
        put_side(&at[i], &s->triangles[i / 3], (int)(i % 3), (int)(i % 3));
    }
    qsort(along, 3 * s->count, sizeof *along, by_place);
    qsort(at, 3 * s->count, sizeof *at, by_place);
    use_spot *const uses[] = {glance, refine}; /* what occurs anywhere is known before anything is split */
    for (int i = 0; i < 2 && !q.lost; i++) {
        faces(&q, uses[i]);
        edges(&q, along, 3 * s->count, uses[i]);
        corners(&q, at, 3 * s->count, uses[i]);
        q.lost |= q.occurs > wanted;
    }
    pool_free(&work);
    return q.lost ? INFINITY : q.bound + 4 * h->slack;
}

static piece piece_of(const fit_hull *h)
{
    piece p = {.points = h->points, .point_count = h->count, .planes = h->planes, .plane_count = h->plane_count};
    memcpy(p.lo, h->lo, sizeof p.lo);
    memcpy(p.hi, h->hi, sizeof p.hi);
    return p;
}

double fit_excess_of_hull(const solid *s, const fit_hull *h, double wanted)
{
    const deviate_effort glance = {.ratio = 1, .floor = wanted / 2, .steps = GLANCE_STEPS};
    const deviate_effort effort = {.ratio = 0.05, .floor = wanted / 2, .steps = STEPS};
    piece p = piece_of(h);
    if (deviate_find(s, &p, &glance) > wanted) return p.deviation;
    double bound = fit_excess_by_normals(s, h, wanted / 16, wanted);
    if (bound <= wanted) return bound;
    deviate_find(s, &p, &effort);
    return fmin(bound, p.deviation);
}
