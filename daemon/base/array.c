/* array: the memory behind every growing array. Any thread. None of these functions returns NULL or a buffer too small:
 * where memory ends, the process ends with a message. */
#include "array.h"

#include "ahead.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { FIRST_CAPACITY = 8 }; /* values; the first growth, so that small arrays do not grow eight times */

static _Atomic bool memory_has_ended;

bool base_is_out_of_memory(void)
{
    return memory_has_ended;
}

/* Not through the log, which could itself be out of memory and may be muted. */
static _Noreturn void out_of_memory(size_t count, size_t size)
{
    memory_has_ended = true;
    fprintf(stderr, "out of memory: no room for %zu values of %zu bytes\n", count, size);
    abort();
}

static _Thread_local size_t handed_out;

size_t base_handed_out(void)
{
    return handed_out;
}

/* malloc(0) may return NULL, which callers would have to tell from failure. */
static size_t checked_bytes(size_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes)) out_of_memory(count, size);
    handed_out += bytes;
    return bytes ? bytes : 1;
}

void *base_alloc(size_t count, size_t size)
{
    void *p = malloc(checked_bytes(count, size));
    if (!p) out_of_memory(count, size);
    return p;
}

void *base_zalloc(size_t count, size_t size)
{
    void *p = calloc(1, checked_bytes(count, size));
    if (!p) out_of_memory(count, size);
    return p;
}

void *base_realloc(void *old, size_t count, size_t size)
{
    void *p = realloc(old, checked_bytes(count, size));
    if (!p) out_of_memory(count, size);
    return p;
}

void *base_alloc_aligned(size_t alignment, size_t count, size_t size)
{
    size_t bytes = checked_bytes(count, size);
    if (bytes > SIZE_MAX - alignment) out_of_memory(count, size);
    void *p = aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (!p) out_of_memory(count, size);
    return p;
}

/* Pages of 4 KiB are looked up one by one: where things lie far apart, that costs as much as what is in them. What is
 * so large asks for larger ones, in as far as it covers them; where the system has none, these do. */
enum { WIDE = 2 << 20 };

static void ask_for_wide_pages(void *at, size_t bytes)
{
    if (bytes < 2 * (size_t)WIDE) return;
    uintptr_t first = ((uintptr_t)at + WIDE - 1) & ~(uintptr_t)(WIDE - 1);
    uintptr_t end = ((uintptr_t)at + bytes) & ~(uintptr_t)(WIDE - 1);
    if (end > first) (void)madvise((void *)first, end - first, MADV_HUGEPAGE);
}

void *base_alloc_lines(size_t count, size_t size)
{
    enum { LINE = 64 };
    size_t bytes = checked_bytes(count, size);
    void *p = base_alloc_aligned(bytes < 2 * (size_t)WIDE ? LINE : WIDE, count, size);
    ask_for_wide_pages(p, bytes);
    return p;
}

char *base_strdup(const char *text)
{
    size_t size = strlen(text) + 1;
    return memcpy(base_alloc(size, 1), text, size);
}

void *array_grow(void *at, size_t *capacity, size_t need, size_t size)
{
    if (need <= *capacity) return at;
    size_t grown = *capacity > SIZE_MAX / 2 ? need : *capacity * 2;
    if (grown < FIRST_CAPACITY) grown = FIRST_CAPACITY;
    if (grown < need) grown = need;
    *capacity = grown;
    at = base_realloc(at, grown, size);
    ask_for_wide_pages(at, grown * size);
    return at;
}

/* ---- in place ---- */

/* Bytes of address space: machines have 2^47 or more, of which ThreadSanitizer leaves 3 TB. */
#if defined(__SANITIZE_THREAD__)
static const size_t SET_ASIDE = (size_t)1 << 34;
#else
static const size_t SET_ASIDE = (size_t)1 << 37;
#endif

/* Memory that may not be touched is none: neither counted nor locked. */
static void *set_aside(size_t bytes)
{
    void *at = mmap(NULL, bytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (at == MAP_FAILED) out_of_memory(bytes, 1);
    return at;
}

/* By an eighth, and a next such step is touched ahead: a tick finds it touched, and an array has at most a quarter more
 * memory than it uses. */
static size_t step_after(size_t bytes)
{
    enum { LEAST = 256 << 10, MOST = 4 << 20 };
    size_t step = bytes / 8, unit = bytes < WIDE ? LEAST : WIDE;
    if (step > MOST) step = MOST;
    return step < unit ? unit : step / unit * unit;
}

/* Of memory at `at`, of which *bytes may be touched, so much that there are `least`; and what comes next. */
static void open_up(void *at, size_t *bytes, size_t least)
{
    while (*bytes < least) *bytes += step_after(*bytes);
    size_t next = step_after(*bytes);
    if (mprotect(at, *bytes + next, PROT_READ | PROT_WRITE) != 0) out_of_memory(*bytes, 1);
    ask_for_wide_pages(at, *bytes + next);
    ahead_touch((char *)at + *bytes, next);
}

void *array_grow_in_place(void *at, size_t *capacity, size_t need, size_t size)
{
    if (need <= *capacity) return at;
    if (need > SET_ASIDE / 2 / size) out_of_memory(need, size);
    size_t bytes = *capacity * size;
    if (!at) at = set_aside(SET_ASIDE);
    open_up(at, &bytes, need * size);
    *capacity = bytes / size;
    return at;
}

void array_release_in_place(void *at)
{
    if (at) munmap(at, SET_ASIDE);
}

/* ---- on the heap, and then in place ---- */

enum { ON_HEAP = 256 << 10 }; /* bytes */
static const size_t SET_ASIDE_LONG = (size_t)1 << 32;

void *array_grow_long(void *at, size_t *capacity, size_t need, size_t size)
{
    if (need <= *capacity) return at;
    size_t bytes = *capacity * size;
    if (need <= ON_HEAP / 2 / size) return array_grow(at, capacity, need, size);
    if (need > SET_ASIDE_LONG / 2 / size) out_of_memory(need, size);
    if (bytes <= ON_HEAP) {
        void *in_place = set_aside(SET_ASIDE_LONG), *on_heap = at;
        size_t had = bytes;
        bytes = ON_HEAP;
        open_up(in_place, &bytes, need * size + ON_HEAP);
        if (had) memcpy(in_place, on_heap, had);
        free(on_heap);
        at = in_place;
    } else {
        open_up(at, &bytes, need * size);
    }
    *capacity = bytes / size;
    return at;
}

void array_release_long(void *at, size_t bytes)
{
    if (bytes <= ON_HEAP)
        free(at);
    else
        munmap(at, SET_ASIDE_LONG);
}

void *array_shrink(void *at, size_t *capacity, size_t count, size_t size)
{
    size_t spare = (*capacity - count) * size;
    if (spare < ARRAY_SPARE_BYTES || spare < count * size) return at;
    *capacity = count < FIRST_CAPACITY ? FIRST_CAPACITY : count;
    return base_realloc(at, *capacity, size);
}

void base_give_pages_back(void *at, size_t bytes)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), first = ((uintptr_t)at + page - 1) / page * page;
    uintptr_t end = ((uintptr_t)at + bytes) / page * page;
    if (end > first) (void)madvise((void *)first, end - first, MADV_DONTNEED);
}
