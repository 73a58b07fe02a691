/* pool: a list of blocks, one an allocation: loaders allocate little and seldom. One thread a pool. */
#include "pool.h"

#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

struct pool_block {
    struct pool_block *next;
    _Alignas(max_align_t) unsigned char bytes[];
};

static _Noreturn void out_of_memory(void)
{
    fputs("collided: out of memory\n", stderr);
    exit(EX_OSERR);
}

void *pool_alloc(pool *p, size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || __builtin_add_overflow(bytes, sizeof(struct pool_block), &bytes))
        out_of_memory();
    struct pool_block *block = calloc(1, bytes);
    if (!block) out_of_memory();
    block->next = p->blocks;
    p->blocks = block;
    return block->bytes;
}

char *pool_copy(pool *p, const char *text)
{
    if (!text) return NULL;
    size_t bytes = strlen(text) + 1;
    return memcpy(pool_alloc(p, 1, bytes), text, bytes);
}

char *pool_format(pool *p, const char *format, ...)
{
    char *text;
    va_list arguments;
    va_start(arguments, format);
    int length = vasprintf(&text, format, arguments);
    va_end(arguments);
    if (length < 0) out_of_memory();
    char *copy = pool_copy(p, text);
    free(text);
    return copy;
}

void pool_free(pool *p)
{
    while (p->blocks) {
        struct pool_block *next = p->blocks->next;
        free(p->blocks);
        p->blocks = next;
    }
}
