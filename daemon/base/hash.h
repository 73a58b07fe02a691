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

/* What hash_bytes makes of a number's own bytes (low ones first), and sooner: a step waits for the one before it, but
 * four bytes of zero are one step. */
static inline uint64_t hash_half(uint64_t h, uint32_t half)
{
    const uint64_t prime = UINT64_C(1099511628211);
    if (!half) return h * (prime * prime * prime * prime);
    for (int i = 0; i < 4; i++, half >>= 8) h = (h ^ (half & 255)) * prime;
    return h;
}

static inline uint64_t hash_word(uint64_t h, uint64_t word)
{
    return hash_half(hash_half(h, (uint32_t)word), (uint32_t)(word >> 32));
}

static inline uint64_t hash_double(uint64_t h, double number)
{
    uint64_t word;
    memcpy(&word, &number, sizeof word);
    return hash_word(h, word);
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
