/* pool: memory that is freed all at once. What a loader returns lives in the caller's pool. One thread a pool. Inputs
 * are limited in size, so running out of memory here is the machine's trouble: it ends the program with a message. */
#ifndef COLLIDED_LOADERS_POOL_H
#define COLLIDED_LOADERS_POOL_H

#include <stddef.h>

typedef struct pool {
    struct pool_block *blocks;
} pool;

void *pool_alloc(pool *p, size_t count, size_t size); /* zeroed; never NULL; aligned for anything */
char *pool_copy(pool *p, const char *text);           /* NULL stays NULL */
__attribute__((format(printf, 2, 3))) char *pool_format(pool *p, const char *format, ...);
void pool_free(pool *p); /* the pool is empty again and can be used on */

#endif
