/* hash: FNV-1a with 64 bits (http://www.isthe.com/chongo/tech/comp/fnv/): the same on every machine of one byte order,
 * quick for short keys, and no protection against who wants keys to clash. Pure. */
#ifndef COLLIDED_BASE_HASH_H
#define COLLIDED_BASE_HASH_H

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define HASH_START UINT64_C(14695981039346656037)

static inline uint64_t hash_bytes(uint64_t h, const void *data, size_t size)
{
    const unsigned char *byte = data;
    for (size_t i = 0; i < size; i++) h = (h ^ byte[i]) * UINT64_C(1099511628211);
    return h;
}

/* Eight bytes at once: another hash, and quicker for long keys. Two keys of which one word differs differ. */
static inline uint64_t hash_words(uint64_t h, const void *data, size_t size)
{
    const unsigned char *at = data;
    for (uint64_t word; size >= sizeof word; at += sizeof word, size -= sizeof word) {
        memcpy(&word, at, sizeof word);
        h = (h ^ word) * UINT64_C(1099511628211);
    }
    return hash_bytes(h, at, size);
}

#endif
