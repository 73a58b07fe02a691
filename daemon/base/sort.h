/* sort: 64-bit keys into ascending order, in memory of the caller's (qsort of glibc allocates); and the order of
 * numbers for qsort, where few are sorted. Any thread. */
#ifndef COLLIDED_BASE_SORT_H
#define COLLIDED_BASE_SORT_H

#include <stddef.h>
#include <stdint.h>

/* `scratch` has room for `count` keys. Linear in `count`; keys already in order cost one look at each. */
void sort_keys(uint64_t *keys, uint64_t *scratch, size_t count);

/* Where the lowest `bits` of two keys differ, the others do, too: their order is that of the others. */
void sort_keys_above(uint64_t *keys, uint64_t *scratch, size_t count, unsigned bits);

/* For qsort, of uint32_t: ascending. */
int sort_compare_u32(const void *a, const void *b);

#endif
