/* verify_hull: balls around points that are next to each other: halves of halves, across where they reach farthest. A
 * point is no higher along d than its ball, m . d + r |d|; and the highest point is no lower than the highest middle, a
 * mean of points. So the balls that reach as high as that hold the highest point: three or four of 32, most often. */
#include "verify_hull.h"

#include "verify_lanes.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { EIGHT = 8, TRIPLES = 3 * EIGHT, BALL_NUMBERS = 4 * LANES, ALIGNMENT = 64, AT_ONCE = 64 /* balls */ };
/* Relative to the reach: for the rounding of heights, middles and radii, each some units of 2^-53. */
static const real HEIGHT_ERROR = 0x1p-46;

/* ---- making ---- */

typedef struct sorted {
    real key;
    const double *point;
} sorted;

static int compare(const void *a, const void *b)
{
    real x = ((const sorted *)a)->key, y = ((const sorted *)b)->key;
    return (x > y) - (x < y);
}

static int widest(const sorted *items, size_t count)
{
    real most = -1;
    int axis = 0;
    for (int k = 0; k < 3; k++) {
        real low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < count; i++) {
            low = fmin(low, items[i].point[k]);
            high = fmax(high, items[i].point[k]);
        }
        if (high - low > most) most = high - low, axis = k;
    }
    return axis;
}

/* Into runs of eight, of which only the last is shorter. */
static void sort_into_runs(sorted *items, size_t count)
{
    if (count <= EIGHT) return;
    int axis = widest(items, count);
    size_t half = (count / 2 + EIGHT - 1) / EIGHT * EIGHT;
    for (size_t i = 0; i < count; i++) items[i].key = items[i].point[axis];
    qsort(items, count, sizeof *items, compare);
    sort_into_runs(items, half);
    sort_into_runs(items + half, count - half);
}

/* The eight points of a ball, of which there may be fewer. */
static void put_ball(const double *points, size_t count, real reach, double *eight, double *ball)
{
    real middle[3] = {0, 0, 0}, radius2 = 0;
    for (size_t i = 0; i < EIGHT; i++)
        for (int k = 0; k < 3; k++) eight[EIGHT * k + (int)i] = points[3 * (i < count ? i : count - 1) + (size_t)k];
    for (size_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) middle[k] += points[3 * i + (size_t)k] / (real)count;
    for (size_t i = 0; i < count; i++) {
        real away2 = 0;
        for (int k = 0; k < 3; k++)
            away2 += (points[3 * i + (size_t)k] - middle[k]) * (points[3 * i + (size_t)k] - middle[k]);
        radius2 = fmax(radius2, away2);
    }
    for (int k = 0; k < 3; k++) ball[LANES * k] = middle[k];
    ball[LANES * 3] = sqrt(radius2) + HEIGHT_ERROR * reach;
}

static size_t rounded_up(size_t count, size_t to)
{
    return (count + to - 1) / to * to;
}

collided_prepared_hull *collided_prepare_hull(const double *points, size_t count)
{
    points_scan scan;
    if (!points || !count || count > SIZE_MAX / 1024) return NULL;
    points_look(points, count, (vec){0, 0, 0}, &scan);
    if (!scan.finite) return NULL;
    size_t used = (count + EIGHT - 1) / EIGHT, balls = rounded_up(used, LANES);
    size_t room = rounded_up(sizeof(collided_prepared_hull), ALIGNMENT);
    size_t numbers = balls * (BALL_NUMBERS / LANES + TRIPLES) + rounded_up(3 * count, EIGHT);
    collided_prepared_hull *h = aligned_alloc(ALIGNMENT, room + numbers * sizeof(double));
    sorted *items = malloc(count * sizeof *items);
    if (h && items) {
        double *ball = (double *)((char *)h + room), *eight = ball + balls * (BALL_NUMBERS / LANES);
        double *own = eight + balls * TRIPLES;
        for (size_t i = 0; i < count; i++) items[i].point = points + 3 * i;
        sort_into_runs(items, count);
        for (size_t i = 0; i < count; i++) memcpy(own + 3 * i, items[i].point, 3 * sizeof *own);
        *h = (collided_prepared_hull){count, own, scan.reach2, balls, ball, eight};
        for (size_t i = 0; i < balls; i++) {
            size_t first = (i < used ? i : used - 1) * EIGHT;
            put_ball(own + 3 * first, count - first < EIGHT ? count - first : EIGHT, sqrt(scan.reach2),
                eight + i * TRIPLES, ball + i / LANES * BALL_NUMBERS + i % LANES);
        }
    }
    free(items);
    if (!items) free(h);
    return items ? h : NULL;
}

void collided_free_prepared_hull(collided_prepared_hull *h)
{
    free(h);
}

/* ---- looking ---- */

INLINE lanes heights(const double *p, size_t stride, const lanes d[3])
{
    return lanes_at(p) * d[0] + lanes_at(p + stride) * d[1] + lanes_at(p + 2 * stride) * d[2];
}

INLINE real top_of_eight(const double *eight, const lanes d[3])
{
    return greatest_of(greater(heights(eight, EIGHT, d), heights(eight + LANES, EIGHT, d)));
}

/* 64 balls from the first: those that reach up to `cut`, and the tops of their points. No branch depends on which these
 * are but a loop's end: it would be guessed wrong once a ball. Where a height or radius is not a number, for they
 * overflow, nothing is ruled out. */
INLINE void look_at_balls(
    const collided_prepared_hull *h, size_t first, const lanes d[3], real norm, real error, real *cut, prepared_scan *s)
{
    lanes middle[AT_ONCE / LANES], most = lanes_of(-INFINITY);
    size_t fours = (h->balls - first < AT_ONCE ? h->balls - first : AT_ONCE) / LANES;
    const double *ball = h->ball + first * LANES;
    for (size_t i = 0; i < fours; i++) {
        middle[i] = heights(ball + i * BALL_NUMBERS, LANES, d);
        most = greater(middle[i], most);
    }
    real lowest = greatest_of(most) - error;
    *cut = lowest > *cut ? lowest : *cut;
    int from = s->count, count = from;
    for (size_t i = 0; i < fours; i++) {
        lane_mask below = middle[i] + lanes_at(ball + i * BALL_NUMBERS + 3 * LANES) * lanes_of(norm) < lanes_of(*cut);
        for (int k = 0; k < LANES; k++) {
            s->ball[count] = (uint32_t)(first + i * LANES) + (uint32_t)k;
            count += 1 + (int)below[k];
        }
    }
    for (int i = from; i < count; i++) {
        s->ball_top[i] = top_of_eight(h->eight + s->ball[i] * (size_t)TRIPLES, d);
        s->top = s->ball_top[i] > s->top ? s->ball_top[i] : s->top;
    }
    s->count = count;
}

INLINE void look_at_hull(const collided_prepared_hull *h, vec along, real depth, prepared_scan *s)
{
    const lanes d[3] = {lanes_of(along.x), lanes_of(along.y), lanes_of(along.z)};
    real norm = sqrt(along.x * along.x + along.y * along.y + along.z * along.z);
    real cut = -INFINITY, error = HEIGHT_ERROR * sqrt(h->reach2) * norm + depth;
    s->along = along;
    s->top = -INFINITY;
    s->count = 0;
    s->forgot = false;
    for (size_t i = 0; i < h->balls; i += AT_ONCE) {
        if (s->count > PREPARED_BALLS - AT_ONCE) s->count = 0, s->forgot = true;
        look_at_balls(h, i, d, norm, error, &cut, s);
        cut = s->top - depth > cut ? s->top - depth : cut;
    }
}

typedef void look_kernel(const collided_prepared_hull *h, vec along, real depth, prepared_scan *s);

static void look_at_hull_narrow(const collided_prepared_hull *h, vec along, real depth, prepared_scan *s)
{
    look_at_hull(h, along, depth, s);
}

#if defined(__x86_64__)

__attribute__((target("avx2"))) static void look_at_hull_wide(
    const collided_prepared_hull *h, vec along, real depth, prepared_scan *s)
{
    look_at_hull(h, along, depth, s);
}

static look_kernel *kernel(void)
{
    return __builtin_cpu_supports("avx2") ? look_at_hull_wide : look_at_hull_narrow;
}

#else

static look_kernel *kernel(void)
{
    return look_at_hull_narrow;
}

#endif

void prepared_look(const collided_prepared_hull *h, vec along, real depth, prepared_scan *out)
{
    kernel()(h, along, depth, out);
}

static int take(const double *p, size_t count, vec d, real least, vec *out, int found, int most)
{
    for (size_t i = 0; i < count && found < most; i++, p += 3)
        if (p[0] * d.x + p[1] * d.y + p[2] * d.z >= least) out[found++] = (vec){p[0], p[1], p[2]};
    return found;
}

/* Of a ball, from the columns that were looked at just now. */
static int take_of_ball(
    const collided_prepared_hull *h, uint32_t ball, vec d, real least, vec *out, int found, int most)
{
    const double *x = h->eight + ball * (size_t)TRIPLES, *y = x + EIGHT, *z = y + EIGHT;
    size_t first = ball * (size_t)EIGHT, left = first < h->count ? h->count - first : 0;
    for (size_t i = 0; i < EIGHT && i < left && found < most; i++)
        if (x[i] * d.x + y[i] * d.y + z[i] * d.z >= least) out[found++] = (vec){x[i], y[i], z[i]};
    return found;
}

int prepared_on_top(const collided_prepared_hull *h, const prepared_scan *s, real depth, vec *out, int most)
{
    real least = s->top - depth;
    int found = 0;
    if (s->forgot) return take(h->points, h->count, s->along, least, out, 0, most);
    for (int i = 0; i < s->count; i++)
        if (s->ball_top[i] >= least) found = take_of_ball(h, s->ball[i], s->along, least, out, found, most);
    return found;
}
