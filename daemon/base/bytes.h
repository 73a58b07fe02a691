/* bytes: numbers and texts one after the other as they lie in memory, for another process of the same program on the
 * same kind of machine. Reading never goes beyond the end: it then gives zeros, and the reader is broken for good. */
#ifndef COLLIDED_BASE_BYTES_H
#define COLLIDED_BASE_BYTES_H

#include "array.h"

#include <stdbool.h>
#include <stdint.h>
#include <string.h>

typedef ARRAY(uint8_t) bytes_out; /* zeros = empty; array_free */

typedef struct bytes_in {
    const uint8_t *at;
    size_t left;
    bool broken; /* it says more than there is */
} bytes_in;

static inline void bytes_put(bytes_out *to, const void *data, size_t size)
{
    array_reserve(to, to->count + size);
    if (size) memcpy(to->at + to->count, data, size);
    to->count += size;
}

static inline void bytes_put_count(bytes_out *to, size_t count)
{
    uint64_t n = count;
    bytes_put(to, &n, sizeof n);
}

static inline void bytes_put_text(bytes_out *to, const char *text)
{
    bytes_put(to, text, strlen(text) + 1);
}

static inline bool bytes_get(bytes_in *from, void *data, size_t size)
{
    if (size > from->left) {
        *from = (bytes_in){.at = from->at, .broken = true};
        memset(data, 0, size);
        return false;
    }
    if (size) memcpy(data, from->at, size);
    from->at += size;
    from->left -= size;
    return true;
}

/* Of things that have at least `each` bytes: no more than there may be. */
static inline size_t bytes_get_count(bytes_in *from, size_t each)
{
    uint64_t n;
    bytes_get(from, &n, sizeof n);
    if (n <= from->left / each) return (size_t)n;
    *from = (bytes_in){.at = from->at, .broken = true};
    return 0;
}

/* Borrowed; "" if it is broken. */
static inline const char *bytes_get_text(bytes_in *from)
{
    const char *text = (const char *)from->at;
    const void *end = from->left ? memchr(from->at, '\0', from->left) : NULL;
    if (!end) {
        *from = (bytes_in){.at = from->at, .broken = true};
        return "";
    }
    size_t size = strlen(text) + 1;
    from->at += size;
    from->left -= size;
    return text;
}

#endif
