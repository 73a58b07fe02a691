/* hull_scan: the kernels, and the choice among them: one test of a word that the C library's start-up code has filled.
 *
 * Each kernel writes down the heights and the greatest of them by columns, then looks for the first vertex that has it,
 * 64 at a time without a branch in between. Padding repeats the last vertex, so it never comes first. */
#include "hull_scan.h"

enum { CHUNK = 64, LANES = 8 /* hull.h pads its arrays to this */ };

static inline double greater(double a, double b)
{
    return a > b ? a : b;
}

static uint32_t scan_plain(const hull *h, vec3 d)
{
    const double *restrict x = h->x, *restrict y = h->y, *restrict z = h->z;
    double height[HULL_SCAN_MAX], m0 = -INFINITY, m1 = -INFINITY, m2 = -INFINITY, m3 = -INFINITY;
    uint32_t count = h->padded_count;
    for (uint32_t i = 0; i < count; i++) height[i] = x[i] * d.x + y[i] * d.y + z[i] * d.z;
    /* padded_count is a multiple of 8, and not less than vertex_count: clang-tidy 14 cannot know.
     * NOLINTBEGIN(clang-analyzer-core.CallAndMessage, clang-analyzer-core.UndefinedBinaryOperatorResult) */
    for (uint32_t i = 0; i < count; i += 4) {
        m0 = greater(height[i], m0), m1 = greater(height[i + 1], m1);
        m2 = greater(height[i + 2], m2), m3 = greater(height[i + 3], m3);
    }
    double top = greater(greater(m0, m1), greater(m2, m3));
    for (uint32_t i = 0; i < h->vertex_count; i++)
        if (height[i] >= top) return i;
    /* NOLINTEND(clang-analyzer-core.CallAndMessage, clang-analyzer-core.UndefinedBinaryOperatorResult) */
    return 0; /* only for a direction that is not a number */
}

static uint32_t above_plain(const hull *h, vec3 d, double cut, uint16_t *found, uint32_t most)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        if (!(h->x[i] * d.x + h->y[i] * d.y + h->z[i] * d.z >= cut)) continue;
        if (count == most) return most + 1;
        found[count++] = (uint16_t)i;
    }
    return count;
}

static double top_plain(const hull *h, vec3 d)
{
    double top = -INFINITY;
    for (uint32_t i = 0; i < h->vertex_count; i++) {
        double height = h->x[i] * d.x + h->y[i] * d.y + h->z[i] * d.z;
        top = height > top ? height : top;
    }
    return top;
}

static void spans_plain(const hull *h, const vec3 d[3], double top[3], double bottom[3])
{
    for (int k = 0; k < 3; k++) {
        top[k] = -INFINITY, bottom[k] = INFINITY;
        for (uint32_t i = 0; i < h->vertex_count; i++) {
            double height = h->x[i] * d[k].x + h->y[i] * d[k].y + h->z[i] * d[k].z;
            top[k] = height > top[k] ? height : top[k];
            bottom[k] = height < bottom[k] ? height : bottom[k];
        }
    }
}

#if defined(__x86_64__)

#include <immintrin.h>

/* The vertices first + (bits of `above`), less the padding. False when there are too many. */
static inline bool note(const hull *h, uint32_t first, uint32_t above, uint16_t *found, uint32_t most, uint32_t *count)
{
    for (; above; above &= above - 1) {
        uint32_t i = first + (uint32_t)__builtin_ctz(above);
        if (i >= h->vertex_count) return true;
        if (*count == most) {
            *count = most + 1;
            return false;
        }
        found[(*count)++] = (uint16_t)i;
    }
    return true;
}

__attribute__((target("avx2"))) static inline __m256d heights4(
    const hull *h, uint32_t i, __m256d dx, __m256d dy, __m256d dz)
{
    __m256d x = _mm256_mul_pd(_mm256_loadu_pd(h->x + i), dx), y = _mm256_mul_pd(_mm256_loadu_pd(h->y + i), dy);
    return _mm256_add_pd(_mm256_add_pd(x, y), _mm256_mul_pd(_mm256_loadu_pd(h->z + i), dz));
}

__attribute__((target("avx2"))) static inline __m256d greatest4(__m256d m)
{
    m = _mm256_max_pd(m, _mm256_permute2f128_pd(m, m, 1));
    return _mm256_max_pd(m, _mm256_permute_pd(m, 5));
}

__attribute__((target("avx2"))) static inline uint32_t at_top(__m256d height, __m256d top)
{
    return (uint32_t)_mm256_movemask_pd(_mm256_cmp_pd(height, top, _CMP_GE_OQ));
}

/* Of 8 or 16 padded vertices: the heights stay in registers. Of 8 both halves are the same. */
__attribute__((target("avx2"))) static inline uint32_t scan_few(const hull *h, __m256d dx, __m256d dy, __m256d dz)
{
    uint32_t half = h->padded_count - LANES;
    __m256d h0 = heights4(h, 0, dx, dy, dz), h1 = heights4(h, 4, dx, dy, dz);
    __m256d h2 = heights4(h, half, dx, dy, dz), h3 = heights4(h, half + 4, dx, dy, dz);
    __m256d top = greatest4(_mm256_max_pd(_mm256_max_pd(h0, h1), _mm256_max_pd(h2, h3)));
    uint32_t low = at_top(h0, top) | at_top(h1, top) << 4, high = at_top(h2, top) | at_top(h3, top) << 4;
    uint32_t found = low | high << half;
    return found ? (uint32_t)__builtin_ctz(found) : 0;
}

__attribute__((target("avx2"), always_inline)) static inline void put_heights(
    const hull *h, double *height, uint32_t i, __m256d dx, __m256d dy, __m256d dz, __m256d *m0, __m256d *m1)
{
    __m256d h0 = heights4(h, i, dx, dy, dz), h1 = heights4(h, i + 4, dx, dy, dz);
    _mm256_storeu_pd(height + i, h0);
    _mm256_storeu_pd(height + i + 4, h1);
    *m0 = _mm256_max_pd(h0, *m0);
    *m1 = _mm256_max_pd(h1, *m1);
}

__attribute__((target("avx2"))) static uint32_t scan_avx2(const hull *h, vec3 d)
{
    double height[HULL_SCAN_MAX];
    __m256d dx = _mm256_set1_pd(d.x), dy = _mm256_set1_pd(d.y), dz = _mm256_set1_pd(d.z);
    __m256d m0 = _mm256_set1_pd(-INFINITY), m1 = m0, m2 = m0, m3 = m0;
    uint32_t count = h->padded_count;
    if (count <= 2 * LANES) return scan_few(h, dx, dy, dz);
    uint32_t pairs = count / (2 * LANES) * (2 * LANES);
    for (uint32_t i = 0; i < pairs; i += 2 * LANES) {
        put_heights(h, height, i, dx, dy, dz, &m0, &m1);
        put_heights(h, height, i + LANES, dx, dy, dz, &m2, &m3);
    }
    if (pairs < count) put_heights(h, height, pairs, dx, dy, dz, &m0, &m1);
    m0 = greatest4(_mm256_max_pd(_mm256_max_pd(m0, m1), _mm256_max_pd(m2, m3)));
    for (uint32_t first = 0; first < count; first += CHUNK) {
        uint64_t found = 0;
        uint32_t end = count - first < CHUNK ? count : first + CHUNK;
        for (uint32_t i = first; i < end; i += LANES) {
            uint32_t low = at_top(_mm256_loadu_pd(height + i), m0);
            found |= (uint64_t)(low | at_top(_mm256_loadu_pd(height + i + 4), m0) << 4) << (i - first);
        }
        if (found) return first + (uint32_t)__builtin_ctzll(found);
    }
    return 0;
}

__attribute__((target("avx2"))) static uint32_t above_avx2(
    const hull *h, vec3 d, double cut, uint16_t *found, uint32_t most)
{
    __m256d dx = _mm256_set1_pd(d.x), dy = _mm256_set1_pd(d.y), dz = _mm256_set1_pd(d.z), least = _mm256_set1_pd(cut);
    uint32_t count = 0;
    for (uint32_t i = 0; i < h->padded_count; i += LANES) {
        uint32_t low = at_top(heights4(h, i, dx, dy, dz), least), high = at_top(heights4(h, i + 4, dx, dy, dz), least);
        if ((low | high) && !note(h, i, low | high << 4, found, most, &count)) break;
    }
    return count;
}

__attribute__((target("avx2"), always_inline)) static inline void span4(
    __m256d x, __m256d y, __m256d z, const __m256d d[3], __m256d *top, __m256d *bottom)
{
    __m256d height =
        _mm256_add_pd(_mm256_add_pd(_mm256_mul_pd(x, d[0]), _mm256_mul_pd(y, d[1])), _mm256_mul_pd(z, d[2]));
    *top = _mm256_max_pd(height, *top);
    *bottom = _mm256_min_pd(height, *bottom);
}

__attribute__((target("avx2"))) static inline double least4(__m256d m)
{
    m = _mm256_min_pd(m, _mm256_permute2f128_pd(m, m, 1));
    return _mm256_cvtsd_f64(_mm256_min_pd(m, _mm256_permute_pd(m, 5)));
}

__attribute__((target("avx2"))) static void spans_avx2(const hull *h, const vec3 d[3], double top[3], double bottom[3])
{
    __m256d way[3][3], most[3], least[3];
    for (int k = 0; k < 3; k++) {
        way[k][0] = _mm256_set1_pd(d[k].x), way[k][1] = _mm256_set1_pd(d[k].y), way[k][2] = _mm256_set1_pd(d[k].z);
        most[k] = _mm256_set1_pd(-INFINITY), least[k] = _mm256_set1_pd(INFINITY);
    }
    for (uint32_t i = 0; i < h->padded_count; i += 4) {
        __m256d x = _mm256_loadu_pd(h->x + i), y = _mm256_loadu_pd(h->y + i), z = _mm256_loadu_pd(h->z + i);
        for (int k = 0; k < 3; k++) span4(x, y, z, way[k], &most[k], &least[k]);
    }
    for (int k = 0; k < 3; k++) {
        top[k] = _mm256_cvtsd_f64(greatest4(most[k]));
        bottom[k] = least4(least[k]);
    }
}

__attribute__((target("avx2"))) static double top_avx2(const hull *h, vec3 d)
{
    __m256d dx = _mm256_set1_pd(d.x), dy = _mm256_set1_pd(d.y), dz = _mm256_set1_pd(d.z);
    __m256d m0 = _mm256_set1_pd(-INFINITY), m1 = m0;
    for (uint32_t i = 0; i < h->padded_count; i += LANES) {
        m0 = _mm256_max_pd(heights4(h, i, dx, dy, dz), m0);
        m1 = _mm256_max_pd(heights4(h, i + 4, dx, dy, dz), m1);
    }
    return _mm256_cvtsd_f64(greatest4(_mm256_max_pd(m0, m1)));
}

bool hull_scan_has(hull_scan_width width)
{
    return width == HULL_SCAN_PLAIN || __builtin_cpu_supports("avx2");
}

uint32_t hull_scan_by(hull_scan_width width, const hull *h, vec3 direction)
{
    return (width == HULL_SCAN_AVX2 ? scan_avx2 : scan_plain)(h, direction);
}

uint32_t hull_scan_above_by(
    hull_scan_width width, const hull *h, vec3 direction, double cut, uint16_t *found, uint32_t most)
{
    return (width == HULL_SCAN_AVX2 ? above_avx2 : above_plain)(h, direction, cut, found, most);
}

double hull_scan_top_by(hull_scan_width width, const hull *h, vec3 direction)
{
    return (width == HULL_SCAN_AVX2 ? top_avx2 : top_plain)(h, direction);
}

void hull_scan_spans_by(hull_scan_width width, const hull *h, const vec3 d[3], double top[3], double bottom[3])
{
    (width == HULL_SCAN_AVX2 ? spans_avx2 : spans_plain)(h, d, top, bottom);
}

static hull_scan_width widest(void)
{
    return __builtin_cpu_supports("avx2") ? HULL_SCAN_AVX2 : HULL_SCAN_PLAIN;
}

#else

bool hull_scan_has(hull_scan_width width)
{
    return width == HULL_SCAN_PLAIN;
}

uint32_t hull_scan_by(hull_scan_width width, const hull *h, vec3 direction)
{
    (void)width;
    return scan_plain(h, direction);
}

uint32_t hull_scan_above_by(
    hull_scan_width width, const hull *h, vec3 direction, double cut, uint16_t *found, uint32_t most)
{
    (void)width;
    return above_plain(h, direction, cut, found, most);
}

double hull_scan_top_by(hull_scan_width width, const hull *h, vec3 direction)
{
    (void)width;
    return top_plain(h, direction);
}

void hull_scan_spans_by(hull_scan_width width, const hull *h, const vec3 d[3], double top[3], double bottom[3])
{
    (void)width;
    spans_plain(h, d, top, bottom);
}

static hull_scan_width widest(void)
{
    return HULL_SCAN_PLAIN;
}

#endif

uint32_t hull_scan(const hull *h, vec3 direction)
{
    return hull_scan_by(widest(), h, direction);
}

uint32_t hull_scan_above(const hull *h, vec3 direction, double cut, uint16_t *found, uint32_t most)
{
    return hull_scan_above_by(widest(), h, direction, cut, found, most);
}

double hull_scan_top(const hull *h, vec3 direction)
{
    return hull_scan_top_by(widest(), h, direction);
}

void hull_scan_spans(const hull *h, const vec3 d[3], double top[3], double bottom[3])
{
    hull_scan_spans_by(widest(), h, d, top, bottom);
}
