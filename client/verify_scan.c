/* verify_scan: four or eight points at a time: twelve or 24 numbers in three registers, sorted by coordinate without
 * changing their place more than once. Which point is in which lane does not matter for a greatest value. Pure; any
 * thread. */
#include "verify_scan.h"

#include "verify_lanes.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

enum { FEW = 4 /* fours in a chunk: the search for its greatest costs as much */ };

typedef struct columns {
    lanes x, y, z;
} columns;

/* Points 0, 3, 2, 1 of the four at `p`. */
INLINE columns four_points(const double *p)
{
    lanes u = lanes_at(p), v = lanes_at(p + 4), w = lanes_at(p + 8);
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

/* How many points make a chunk, when `whole` of them come in groups of `group`. */
INLINE size_t chunk_of(size_t whole, size_t group)
{
    size_t each = (whole + SCAN_CHUNKS - 1) / SCAN_CHUNKS, few = FEW * LANES;
    return each <= few ? few : (each + group - 1) / group * group;
}

/* The points after the last whole group, which are in no chunk. `reach2`: of the others; infinite when one of them is
 * not a number or its squares overflow. */
INLINE void look_at_rest(const double *points, size_t count, vec d, real reach2, points_scan *out)
{
    real top = -INFINITY;
    for (size_t i = 0; i * out->chunk < out->in_chunks; i++) top = out->chunk_top[i] > top ? out->chunk_top[i] : top;
    for (size_t i = out->in_chunks; i < count; i++) {
        const double *p = points + 3 * i;
        real norm2 = p[0] * p[0] + p[1] * p[1] + p[2] * p[2], height = p[0] * d.x + p[1] * d.y + p[2] * d.z;
        top = height > top ? height : top;
        reach2 = norm2 > reach2 ? norm2 : reach2;
        if (!(norm2 <= DBL_MAX)) reach2 = INFINITY;
    }
    out->top = top;
    out->reach2 = reach2;
}

INLINE void look_at_points(const double *points, size_t count, vec d, points_scan *out)
{
    lanes dx = lanes_of(d.x), dy = lanes_of(d.y), dz = lanes_of(d.z);
    progress s = {.reach2 = lanes_of(0), .good = ~(lane_mask){0, 0, 0, 0}};
    size_t used = 0;
    out->in_chunks = count / LANES * LANES;
    out->chunk = chunk_of(out->in_chunks, LANES);
    for (size_t first = 0; first < out->in_chunks; first += out->chunk) {
        size_t end = first + out->chunk < out->in_chunks ? first + out->chunk : out->in_chunks;
        s.top = lanes_of(-INFINITY);
        for (size_t i = first; i < end; i += LANES) look_at_four(points + 3 * i, dx, dy, dz, &s);
        out->chunk_top[used++] = greatest_of(s.top);
    }
    bool good = (s.good[0] & s.good[1] & s.good[2] & s.good[3]) != 0;
    look_at_rest(points, count, d, good ? greatest_of(s.reach2) : INFINITY, out);
}

typedef void points_kernel(const double *points, size_t count, vec d, points_scan *out);

static void look_at_points_narrow(const double *points, size_t count, vec d, points_scan *out)
{
    look_at_points(points, count, d, out);
}

#if defined(__x86_64__)

#include <immintrin.h>

__attribute__((target("avx2"))) static void look_at_points_wide(
    const double *points, size_t count, vec d, points_scan *out)
{
    look_at_points(points, count, d, out);
}

enum { EIGHT = 8 };

/* Every third number: those of u in the lanes of `of_u`, of v in those of `of_v`, and else of w. */
#define THIRDS(of_u, of_v) _mm512_mask_blend_pd(of_u, _mm512_mask_blend_pd(of_v, w, v), u)

__attribute__((target("avx512f"))) static inline __m512d turned_lanes(__m512d a, int by)
{
    __m512i i = _mm512_castpd_si512(a);
    return _mm512_castsi512_pd(by == 1 ? _mm512_alignr_epi64(i, i, 1) : _mm512_alignr_epi64(i, i, 2));
}

/* The words of squares are in the order of their values, with what is not a number above all. */
__attribute__((target("avx512f"))) static inline __m512d look_at_eight(
    const double *p, const __m512d d[3], __m512d top, __m512i *reach2)
{
    __m512d u = _mm512_loadu_pd(p), v = _mm512_loadu_pd(p + EIGHT), w = _mm512_loadu_pd(p + 2 * EIGHT);
    __m512d x = THIRDS(0x49, 0x92), y = turned_lanes(THIRDS(0x92, 0x24), 1), z = turned_lanes(THIRDS(0x24, 0x49), 2);
    __m512d norm2 = _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(x, x), _mm512_mul_pd(y, y)), _mm512_mul_pd(z, z));
    __m512d height =
        _mm512_add_pd(_mm512_add_pd(_mm512_mul_pd(x, d[0]), _mm512_mul_pd(y, d[1])), _mm512_mul_pd(z, d[2]));
    *reach2 = _mm512_max_epu64(*reach2, _mm512_castpd_si512(norm2));
    return _mm512_max_pd(height, top);
}

__attribute__((target("avx512f"))) static void look_at_points_widest(
    const double *points, size_t count, vec along, points_scan *out)
{
    const __m512d d[3] = {_mm512_set1_pd(along.x), _mm512_set1_pd(along.y), _mm512_set1_pd(along.z)};
    __m512i most = _mm512_setzero_si512();
    size_t used = 0;
    out->in_chunks = count / EIGHT * EIGHT;
    out->chunk = chunk_of(out->in_chunks, EIGHT);
    for (size_t first = 0; first < out->in_chunks; first += out->chunk) {
        size_t end = first + out->chunk < out->in_chunks ? first + out->chunk : out->in_chunks;
        __m512d top = _mm512_set1_pd(-INFINITY);
        for (size_t i = first; i < end; i += EIGHT) top = look_at_eight(points + 3 * i, d, top, &most);
        out->chunk_top[used++] = _mm512_reduce_max_pd(top);
    }
    uint64_t word = _mm512_reduce_max_epu64(most);
    real reach2;
    memcpy(&reach2, &word, sizeof reach2);
    look_at_rest(points, count, along, reach2 <= DBL_MAX ? reach2 : INFINITY, out);
}

bool points_look_has(points_width width)
{
    if (width == POINTS_AVX512) return __builtin_cpu_supports("avx512f");
    return width == POINTS_PLAIN || __builtin_cpu_supports("avx2");
}

static points_kernel *kernel_of(points_width width)
{
    return width == POINTS_AVX512 ? look_at_points_widest
           : width == POINTS_AVX2 ? look_at_points_wide
                                  : look_at_points_narrow;
}

#else

bool points_look_has(points_width width)
{
    return width == POINTS_PLAIN;
}

static points_kernel *kernel_of(points_width width)
{
    (void)width;
    return look_at_points_narrow;
}

#endif

void points_look_by(points_width width, const double *points, size_t count, vec along, points_scan *out)
{
    kernel_of(width)(points, count, along, out);
    out->along = along;
    out->finite = out->reach2 < INFINITY || all_finite(points, 3 * count);
}

void points_look(const double *points, size_t count, vec along, points_scan *out)
{
    points_width width = POINTS_AVX512;
    while (!points_look_has(width)) width--;
    points_look_by(width, points, count, along, out);
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
    size_t chunk = 0;
    int found = 0;
    for (size_t first = 0; first < s->in_chunks; first += s->chunk, chunk++) {
        size_t end = first + s->chunk < s->in_chunks ? first + s->chunk : s->in_chunks;
        if (s->chunk_top[chunk] >= s->top - depth)
            found = take_top(points, first, end, s->along, s->top - depth, out, found, most);
    }
    return take_top(points, s->in_chunks, count, s->along, s->top - depth, out, found, most);
}
