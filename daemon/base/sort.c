/* sort: least significant digit first, a byte a pass, leaving out the bytes that all keys share (ids are small: most of
 * their bytes are 0). Any thread. */
#include "sort.h"

#include <stdbool.h>
#include <string.h>

enum {
    INSERTION_MOST = 48, /* keys; below, shifting beats eight histograms */
    DIGITS = 256,
};

static bool in_order(const uint64_t *keys, size_t count)
{
    for (size_t i = 1; i < count; i++)
        if (keys[i - 1] > keys[i]) return false;
    return true;
}

static void insertion_sort(uint64_t *keys, size_t count)
{
    for (size_t i = 1; i < count; i++) {
        uint64_t key = keys[i];
        size_t k = i;
        for (; k > 0 && keys[k - 1] > key; k--) keys[k] = keys[k - 1];
        keys[k] = key;
    }
}

static void radix_pass(const uint64_t *from, uint64_t *to, size_t count, unsigned shift)
{
    size_t place[DIGITS] = {0};
    for (size_t i = 0; i < count; i++) place[from[i] >> shift & 0xff]++;
    size_t sum = 0;
    for (size_t d = 0; d < DIGITS; d++) {
        size_t n = place[d];
        place[d] = sum;
        sum += n;
    }
    for (size_t i = 0; i < count; i++) to[place[from[i] >> shift & 0xff]++] = from[i];
}

void sort_keys_above(uint64_t *keys, uint64_t *scratch, size_t count, unsigned bits)
{
    if (in_order(keys, count)) return;
    if (count <= INSERTION_MOST) {
        insertion_sort(keys, count);
        return;
    }
    uint64_t differing = 0;
    for (size_t i = 1; i < count; i++) differing |= keys[i] ^ keys[0];
    uint64_t *from = keys, *to = scratch;
    for (unsigned shift = bits; shift < 64; shift += 8) {
        if (!(differing >> shift & 0xff)) continue;
        radix_pass(from, to, count, shift);
        uint64_t *swapped = from;
        from = to;
        to = swapped;
    }
    if (from != keys) memcpy(keys, from, count * sizeof *keys);
}

void sort_keys(uint64_t *keys, uint64_t *scratch, size_t count)
{
    sort_keys_above(keys, scratch, count, 0);
}

int sort_compare_u32(const void *a, const void *b)
{
    uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
    return (x > y) - (x < y);
}
