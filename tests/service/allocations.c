#include "allocations.h"

#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

static atomic_size_t count;
static _Thread_local bool left_out;

size_t allocations(void)
{
    return atomic_load(&count);
}

void allocations_leave_out(bool leave)
{
    left_out = leave;
}

static void note(void)
{
    if (!left_out) atomic_fetch_add(&count, 1);
}

/* The linker's names. NOLINTBEGIN(bugprone-reserved-identifier) */
void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *p, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
char *__real_strdup(const char *text);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t n, size_t size);
void *__wrap_realloc(void *p, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);
char *__wrap_strdup(const char *text);

void *__wrap_malloc(size_t size)
{
    note();
    return __real_malloc(size);
}

void *__wrap_calloc(size_t n, size_t size)
{
    note();
    return __real_calloc(n, size);
}

void *__wrap_realloc(void *p, size_t size)
{
    note();
    return __real_realloc(p, size);
}

void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    note();
    return __real_aligned_alloc(alignment, size);
}

char *__wrap_strdup(const char *text)
{
    note();
    return __real_strdup(text);
}
/* NOLINTEND(bugprone-reserved-identifier) */
