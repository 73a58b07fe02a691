/* verify_scan: four points at a time: twelve numbers in three registers, sorted by coordinate without changing their
 * place more than once. Which point is in which lane does not matter for a greatest value. Pure; any thread. */
#include "verify_scan.h"

#include <float.h>
#include <math.h>

enum { LANES = 4, FEW = 4 /* fours in a chunk: the search for its greatest costs as much */ };

typedef double lanes __attribute__((vector_size(32)));
typedef double lanes_anywhere __attribute__((vector_size(32), aligned(8), may_alias));
typedef long long lane_mask __attribute__((vector_size(32)));

/* How such values are passed differs between processors: of no concern, all that takes them is inlined. */
#pragma GCC diagnostic ignored "-Wpsabi"

#define INLINE __attribute__((always_inline)) static inline

INLINE lanes lanes_of(real x)
{
    return (lanes){x, x, x, x};
}

INLINE lanes greater(lanes a, lanes b)
{
    lane_mask m = a > b;
    return (lanes)((m & (lane_mask)a) | (~m & (lane_mask)b));
}

INLINE real greatest_of(lanes m)
{
    real low = m[0] > m[1] ? m[0] : m[1], high = m[2] > m[3] ? m[2] : m[3];
    return low > high ? low : high;
}

typedef struct columns {
    lanes x, y, z;
} columns;

/* Points 0, 3, 2, 1 of the four at `p`. */
INLINE columns four_points(const double *p)
{
    lanes u = *(const lanes_anywhere *)p, v = *(const lanes_anywhere *)(p + 4), w = *(const lanes_anywhere *)(p + 8);
    lanes x = __builtin_shufflevector(__builtin_shufflevector(u, v, 0, 1, 6, 3), w, 0, 5, 2, 3);
    lanes y = __builtin_shufflevector(__builtin_shufflevector(u, v, 4, 1, 2, 7), w, 0, 1, 6, 3);
    lanes z = __builtin_shufflevector(__builtin_shufflevector(u, v, 0, 5, 2, 3), w, 4, 1, 2, 7);
    return (columns){x, __builtin_shufflevector(y, y, 1, 2, 3, 0), __builtin_shufflevector(z, z, 2, 3, 0, 1)};
}

/* Before and after the last whole four. */
typedef struct progress {
    lanes top, reach2;
    lane_mask good;
} progress;

INLINE void look_at_four(const double *p, lanes dx, lanes dy, lanes dz, progress *s)
{
    columns c = four_points(p);
    lanes norm2 = c.x * c.x + c.y * c.y + c.z * c.z;
    s->top = greater(c.x * dx + c.y * dy + c.z * dz, s->top);
    s->reach2 = greater(norm2, s->reach2);
    s->good &= norm2 <= lanes_of(DBL_MAX);
}

INLINE void look(const double *points, size_t count, vec d, points_scan *out)
{
    size_t fours = count / LANES, used = 0;
    size_t fours_a_chunk = fours <= FEW * SCAN_CHUNKS ? FEW : (fours + SCAN_CHUNKS - 1) / SCAN_CHUNKS;
    lanes dx = lanes_of(d.x), dy = lanes_of(d.y), dz = lanes_of(d.z);
    progress s = {.reach2 = lanes_of(0), .good = ~(lane_mask){0, 0, 0, 0}};
    real top = -INFINITY, reach2 = 0;
    out->chunk = LANES * fours_a_chunk;
    for (size_t first = 0; first < fours; first += fours_a_chunk) {
        size_t end = first + fours_a_chunk < fours ? first + fours_a_chunk : fours;
        s.top = lanes_of(-INFINITY);
        for (size_t i = first; i < end; i++) look_at_four(points + 3 * LANES * i, dx, dy, dz, &s);
        out->chunk_top[used] = greatest_of(s.top);
        top = out->chunk_top[used] > top ? out->chunk_top[used] : top;
        used++;
    }
    bool good = (s.good[0] & s.good[1] & s.good[2] & s.good[3]) != 0;
    for (size_t i = LANES * fours; i < count; i++) { /* in no chunk */
        const double *p = points + 3 * i;
        real norm2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], height = p[0] * d.x + p[1] * d.y + p[2] * d.z;
        good &= norm2 <= DBL_MAX;
        top = height > top ? height : top;
        reach2 = norm2 > reach2 ? norm2 : reach2;
    }
    real others = greatest_of(s.reach2);
    out->top = top;
    out->reach2 = good ? (others > reach2 ? others : reach2) : INFINITY;
}

#if defined(__x86_64__)
__attribute__((target("avx2"))) static void look_wide(const double *points, size_t count, vec d, points_scan *out)
{
    look(points, count, d, out);
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
static bool is_wide(void)
{
    return false;
}

static void look_wide(const double *points, size_t count, vec d, points_scan *out)
{
    look(points, count, d, out);
}
#endif

static void look_narrow(const double *points, size_t count, vec d, points_scan *out)
{
    look(points, count, d, out);
}

static bool all_finite(const double *x, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!isfinite(x[i])) return false;
    return true;
}

void points_look(const double *points, size_t count, vec along, points_scan *out)
{
    (is_wide() ? look_wide : look_narrow)(points, count, along, out);
    out->along = along;
    out->finite = out->reach2 < INFINITY || all_finite(points, 3 * count);
}

static int take_top(const double *points, size_t first, size_t end, vec d, real least, vec *out, int count, int most)
{
    for (size_t i = first; i < end && count < most; i++) {
        vec p = {points[3 * i], points[3 * i + 1], points[3 * i + 2]};
        if (p.x * d.x + p.y * d.y + p.z * d.z >= least) out[count++] = p;
    }
    return count;
}

int points_on_top(const double *points, size_t count, const points_scan *s, real depth, vec *out, int most)
{
    size_t in_chunks = count / LANES * LANES, chunk = 0;
    int found = 0;
    for (size_t first = 0; first < in_chunks; first += s->chunk, chunk++) {
        size_t end = first + s->chunk < in_chunks ? first + s->chunk : in_chunks;
        if (s->chunk_top[chunk] >= s->top - depth)
            found = take_top(points, first, end, s->along, s->top - depth, out, found, most);
    }
    return take_top(points, in_chunks, count, s->along, s->top - depth, out, found, most);
}
