/* One point a cell of a grid at most, and none that is too near to that of a neighbouring cell. */
#include "hull_thin.h"

#include "base/array.h"
#include "base/sort.h"

#include <stdlib.h>

enum { INDEX_BITS = 16, CELL_BITS = 16, CELL_BIAS = 1 << 15 };

/* The numbers of the cells' points are below: in order, those of a cell are side by side. */
static uint64_t cell_key(int64_t x, int64_t y, int64_t z)
{
    return (((uint64_t)x << CELL_BITS | (uint64_t)y) << CELL_BITS | (uint64_t)z) << INDEX_BITS;
}

static int64_t cell_of(double x, double apart)
{
    double cell = floor(x / apart) + CELL_BIAS;
    return (int64_t)(cell < 1 ? 1 : cell > 2 * CELL_BIAS - 2 ? 2 * CELL_BIAS - 2 : cell);
}

/* The first key that is not below. */
static uint32_t find_key(const uint64_t *keys, uint32_t count, uint64_t key)
{
    uint32_t lo = 0, hi = count;
    while (lo < hi) {
        uint32_t middle = lo + (hi - lo) / 2;
        if (keys[middle] < key)
            lo = middle + 1;
        else
            hi = middle;
    }
    return lo;
}

uint32_t hull_thin(const vec3 *at, uint32_t count, double apart, uint32_t *kept)
{
    uint64_t *keys = base_alloc(count, sizeof *keys), *scratch = base_alloc(count, sizeof *scratch);
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++)
        keys[i] = cell_key(cell_of(at[i].x, apart), cell_of(at[i].y, apart), cell_of(at[i].z, apart)) | i;
    sort_keys(keys, scratch, count);
    /* In the order of the keys; scratch has the keys of those that are kept, which come in ascending order. */
    for (uint32_t k = 0; k < count; k++) {
        uint32_t i = (uint32_t)(keys[k] & ((1u << INDEX_BITS) - 1));
        int64_t x = cell_of(at[i].x, apart), y = cell_of(at[i].y, apart), z = cell_of(at[i].z, apart);
        bool alone = true;
        for (int64_t dx = -1; dx <= 0 && alone; dx++)
            for (int64_t dy = -1; dy <= 1 && alone; dy++) { /* three cells along z are side by side */
                uint32_t j = find_key(scratch, n, cell_key(x + dx, y + dy, z - 1));
                uint64_t end = cell_key(x + dx, y + dy, z + 2);
                for (; j < n && scratch[j] < end && alone; j++)
                    alone = vec_norm(vec_sub(at[scratch[j] & ((1u << INDEX_BITS) - 1)], at[i])) >= apart;
            }
        if (!alone) continue;
        scratch[n] = keys[k];
        kept[n++] = i;
    }
    free(keys);
    free(scratch);
    return n;
}
