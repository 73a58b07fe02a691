/* feature_code: the stable id of a contact point: what it is made of on either shape. Plain values; any thread.
 *
 * 32 bits a shape, A's in the high half of the id, B's in the low. Bits 14 and 15 are the kind; the index (of a vertex,
 * edge or face of the shape, less than 2^30) has its low 14 bits below them and the rest above: so an index that fits
 * 14 bits makes a code of 16. No two features of a shape share a code. */
#ifndef COLLIDED_NARROW_CONTACT_FEATURE_CODE_H
#define COLLIDED_NARROW_CONTACT_FEATURE_CODE_H

#include <stdint.h>

enum { FEATURE_VERTEX = 0x0000, FEATURE_EDGE = 0x4000, FEATURE_FACE = 0x8000, FEATURE_WITNESS = 0xc000 };
enum { FEATURE_KIND = 0xc000, FEATURE_LOW = 0x3fff, FEATURE_LOW_BITS = 14, FEATURE_HIGH_AT = 16 };

static inline uint32_t feature_code(uint32_t kind, uint32_t index)
{
    return (index >> FEATURE_LOW_BITS) << FEATURE_HIGH_AT | kind | (index & FEATURE_LOW);
}

static inline uint32_t feature_kind(uint32_t code)
{
    return code & FEATURE_KIND;
}
static inline uint32_t feature_index(uint32_t code)
{
    return code >> FEATURE_HIGH_AT << FEATURE_LOW_BITS | (code & FEATURE_LOW);
}

static inline uint64_t feature_id(uint32_t code_a, uint32_t code_b)
{
    return (uint64_t)code_a << 32 | code_b;
}
static inline uint32_t feature_code_a(uint64_t id)
{
    return (uint32_t)(id >> 32);
}
static inline uint32_t feature_code_b(uint64_t id)
{
    return (uint32_t)id;
}

/* With A and B exchanged. */
static inline uint64_t feature_turned(uint64_t id)
{
    return id << 32 | id >> 32;
}

/* Of a point that is no corner of any feature: the witness of the distance. */
static inline uint64_t feature_witness(void)
{
    return feature_id(FEATURE_WITNESS, FEATURE_WITNESS);
}

#endif
