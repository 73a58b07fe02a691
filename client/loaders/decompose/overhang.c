/* overhang: the faces, edges and corners of a solid, each with the directions in which points outside can have their
 * nearest point there; and how far it is from there to the hull's surface, at most. */
#include "overhang.h"

#include "vec3.h"

#include <stdlib.h>

enum { SPLITS_MAX = 14, AROUND_MAX = 64 /* different normals at a corner */ };
static const double CLOSE = 1.05; /* bound over a value that occurs: near enough */
/* More than what a unit normal errs by: its triangle's area is above 1e-9 of the product of two sides (solid.c). */
static const double NORMAL_U = 0x1p-20;

typedef struct spot { /* all y in the hull of `at`, all u in the cone of `way` */
    double at[3][3], way[3][3];
    int at_count, way_count;
} spot;

typedef struct search {
    const solid *s;
    const piece_plane *planes;
    size_t plane_count;
    double slack;
    double floor, occurs, bound;
    size_t looks; /* left */
} search;

static void middle(const double points[3][3], int count, double out[3])
{
    for (int k = 0; k < 3; k++) out[k] = points[0][k];
    for (int i = 1; i < count; i++) along3(out, 1, points[i], out);
    for (int k = 0; k < 3; k++) out[k] /= count;
}

/* The bound of the spot; and what its middle comes to, which is how far splitting can get. */
static double bound_of_spot(search *q, const spot *x)
{
    double bound = INFINITY, value = INFINITY, y[3], u[3];
    middle(x->at, x->at_count, y);
    middle(x->way, x->way_count, u);
    double length = norm3(u);
    for (size_t f = 0; f < q->plane_count; f++) {
        const piece_plane *m = &q->planes[f];
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
        far = (far > 0 ? far : 0) + q->slack;
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
static bool split_spot(const search *q, const spot *x, spot parts[2])
{
    int ends[2] = {0, 0}, ways[2] = {0, 0};
    double size = longest(x->at, x->at_count, ends) / q->s->diagonal;
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
    double bound = bound_of_spot(q, x);
    if (bound <= q->bound || bound <= fmax(q->floor, CLOSE * q->occurs)) {
        q->bound = fmax(q->bound, bound);
        return;
    }
    spot parts[2];
    if (splits == 0 || q->looks < 2 || !split_spot(q, x, parts)) {
        q->bound = bound;
        return;
    }
    q->looks -= 2;
    for (int i = 0; i < 2; i++) settle(q, &parts[i], splits - 1);
}

/* ---- where the nearest points can be ---- */

struct overhang {
    spot *spots;
    size_t count, room;
    bool lost; /* a cone is too wide */
};

static spot *add_spot(struct overhang *o, pool *p, int at_count, int way_count)
{
    if (o->count == o->room) {
        o->room = o->room ? 2 * o->room : 1024;
        spot *more = pool_alloc(p, o->room, sizeof *more);
        if (o->count > 0) memcpy(more, o->spots, o->count * sizeof *more);
        o->spots = more;
    }
    spot *x = &o->spots[o->count++];
    *x = (spot){.at_count = at_count, .way_count = way_count};
    return x;
}

static void add_faces(struct overhang *o, pool *p, const solid *s)
{
    for (size_t i = 0; i < s->count; i++) {
        spot *x = add_spot(o, p, 3, 1);
        memcpy(x->at, s->triangles[i].at, sizeof x->at);
        memcpy(x->way[0], s->triangles[i].normal, sizeof x->way[0]);
    }
}

typedef struct side { /* of a triangle; or one of its corners, twice */
    double ends[6];
    const double *normal;
} side;

static int compare_side_ends(const void *left, const void *right)
{
    const double *a = ((const side *)left)->ends, *b = ((const side *)right)->ends;
    for (int k = 0; k < 6; k++)
        if (a[k] != b[k]) return a[k] < b[k] ? -1 : 1;
    return 0;
}

static void put_side(side *out, const solid_triangle *t, int i, int k)
{
    int order = 0;
    for (int c = 0; c < 3 && order == 0; c++) order = (t->at[i][c] > t->at[k][c]) - (t->at[i][c] < t->at[k][c]);
    memcpy(out->ends, t->at[order > 0 ? k : i], sizeof t->at[i]);
    memcpy(out->ends + 3, t->at[order > 0 ? i : k], sizeof t->at[i]);
    out->normal = t->normal;
}

static size_t same_place(const side *sides, size_t first, size_t count)
{
    size_t end = first + 1;
    while (end < count && compare_side_ends(&sides[first], &sides[end]) == 0) end++;
    return end;
}

static void add_edges(struct overhang *o, pool *p, const side *sides, size_t count)
{
    for (size_t i = 0, end; i < count; i = end) {
        end = same_place(sides, i, count);
        o->lost |= end - i > AROUND_MAX;
        for (size_t a = i; a < end && !o->lost; a++)
            for (size_t b = i; b < a; b++) {
                spot *x = add_spot(o, p, 2, 2);
                memcpy(x->at, sides[i].ends, sizeof sides[i].ends);
                memcpy(x->way[0], sides[a].normal, sizeof x->way[0]);
                memcpy(x->way[1], sides[b].normal, sizeof x->way[1]);
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

/* A frame whose third row is the mean of the normals. */
static void frame_about(const double *const *normals, int count, double axes[3][3])
{
    double mean[3] = {0, 0, 0};
    for (int i = 0; i < count; i++) along3(mean, 1, normals[i], mean);
    frame3(mean, axes);
}

/* The cone of many normals is that of those that are outermost, seen against their mean: a fan of triangles. */
static void add_corner_spots(struct overhang *o, pool *p, const double at[3], const double *const *normals, int count)
{
    double axes[3][3];
    flat points[AROUND_MAX], around[2 * AROUND_MAX];
    frame_about(normals, count, axes);
    for (int i = 0; i < count; i++) {
        double up = dot3(axes[2], normals[i]);
        if (!(up > 0.02)) o->lost = true;
        points[i] = (flat){dot3(axes[0], normals[i]) / up, dot3(axes[1], normals[i]) / up, normals[i]};
    }
    int n = o->lost ? 0 : outline(points, count, around);
    int fans = n < 3 ? n > 0 : n - 2;
    for (int i = 1; i <= fans; i++) {
        spot *x = add_spot(o, p, 1, n < 3 ? n : 3);
        memcpy(x->at[0], at, sizeof x->at[0]);
        memcpy(x->way[0], around[0].normal, sizeof x->way[0]);
        for (int k = 1; k < x->way_count; k++) memcpy(x->way[k], around[i + k - 1].normal, sizeof x->way[k]);
    }
}

static void add_corners(struct overhang *o, pool *p, const side *sides, size_t count)
{
    for (size_t i = 0, end; i < count && !o->lost; i = end) {
        const double *normals[AROUND_MAX];
        int different = 0;
        end = same_place(sides, i, count);
        for (size_t n = i; n < end && !o->lost; n++) {
            bool known = false;
            for (int k = 0; k < different && !known; k++) known = distance3(normals[k], sides[n].normal) < 0x1p-45;
            if (known) continue;
            if (different == AROUND_MAX)
                o->lost = true;
            else
                normals[different++] = sides[n].normal;
        }
        if (!o->lost) add_corner_spots(o, p, sides[i].ends, normals, different);
    }
}

struct overhang *overhang_make(pool *p, const solid *s)
{
    if (s->count == 0 || s->count > OVERHANG_TRIANGLES_MAX) return NULL;
    for (size_t i = 0; i < s->count; i++)
        if (!s->triangles[i].backed) return NULL; /* none is, where it is open */
    pool work = {0};
    struct overhang *o = pool_alloc(p, 1, sizeof *o);
    side *along = pool_alloc(&work, 3 * s->count, sizeof *along), *at = pool_alloc(&work, 3 * s->count, sizeof *at);
    for (size_t i = 0; i < 3 * s->count; i++) {
        put_side(&along[i], &s->triangles[i / 3], (int)(i % 3), (int)((i + 1) % 3));
        put_side(&at[i], &s->triangles[i / 3], (int)(i % 3), (int)(i % 3));
    }
    qsort(along, 3 * s->count, sizeof *along, compare_side_ends);
    qsort(at, 3 * s->count, sizeof *at, compare_side_ends);
    add_faces(o, p, s);
    add_edges(o, p, along, 3 * s->count);
    add_corners(o, p, at, 3 * s->count);
    pool_free(&work);
    return o->lost ? NULL : o;
}

size_t overhang_count(const struct overhang *o)
{
    return o ? o->count : 0;
}

/* What occurs anywhere is known before anything is split. */
double overhang_bound(const struct overhang *o, const solid *s, const piece_plane *planes, size_t plane_count,
    double floor, double wanted, size_t work)
{
    search q = {.s = s, .planes = planes, .plane_count = plane_count, .slack = 16 * piece_slack(s), .floor = floor};
    q.looks = work / (plane_count ? plane_count : 1);
    if (!o) return INFINITY;
    for (size_t i = 0; i < o->count; i++) {
        bound_of_spot(&q, &o->spots[i]);
        if (q.occurs > wanted) return INFINITY;
    }
    for (size_t i = 0; i < o->count; i++) {
        settle(&q, &o->spots[i], SPLITS_MAX);
        if (q.occurs > wanted || q.bound > wanted) return INFINITY;
    }
    return q.bound + 4 * q.slack;
}
