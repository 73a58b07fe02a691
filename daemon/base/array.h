/* array: growing arrays of plain values, as a struct of the caller's own: struct { T *at; size_t count, capacity; }.
 *
 * Capacity doubles and shrinks only when it is asked to, so that a steady tick allocates nothing. Running out of memory
 * ends the process with a message: the limits at the boundary (config) keep outside input from getting there. */
#ifndef COLLIDED_BASE_ARRAY_H
#define COLLIDED_BASE_ARRAY_H

#include <stdbool.h>
#include <stddef.h>

/* malloc, calloc and realloc that never return NULL; overflow of count * size is checked. */
void *base_alloc(size_t count, size_t size);
void *base_zalloc(size_t count, size_t size);
void *base_realloc(void *old, size_t count, size_t size);
void *base_alloc_aligned(size_t alignment, size_t count, size_t size); /* alignment: a power of two; free() it */
void *base_alloc_lines(size_t count, size_t size);                     /* begins a cache line; free() it */
char *base_strdup(const char *text);
/* Bytes that the functions above have handed to this thread since it began. */
size_t base_handed_out(void);
/* The process ends for want of memory: for handlers of SIGABRT. Any thread. */
bool base_is_out_of_memory(void);

/* The grown buffer with room for at least `need` values; *capacity follows. */
void *array_grow(void *at, size_t *capacity, size_t need, size_t size);
/* The buffer without most of what is beyond `count` values, if that is ARRAY_SPARE_BYTES or more, and more than they
 * are: for who is short of memory. */
enum { ARRAY_SPARE_BYTES = 1 << 20 };
void *array_shrink(void *at, size_t *capacity, size_t count, size_t size);

/* Gives the whole pages in there back to the system; they read as zeros from then on, as those beside them may not. */
void base_give_pages_back(void *at, size_t bytes);

#define ARRAY(type)                                                                                                    \
    struct {                                                                                                           \
        type *at;                                                                                                      \
        size_t count, capacity;                                                                                        \
    }

#define array_reserve(a, need)                                                                                         \
    ((a)->at = (need) > (a)->capacity ? array_grow((a)->at, &(a)->capacity, (need), sizeof *(a)->at) : (a)->at)
/* The same for the largest arrays: they grow where they are, so that no tick copies gigabytes. Address space is set
 * aside for each one, of which only what is used is memory. Such an array is freed by array_free_in_place alone. */
void *array_grow_in_place(void *at, size_t *capacity, size_t need, size_t size);
void array_release_in_place(void *at);
#define array_reserve_in_place(a, need)                                                                                \
    ((a)->at = (need) > (a)->capacity ? array_grow_in_place((a)->at, &(a)->capacity, (need), sizeof *(a)->at) : (a)->at)
#define array_free_in_place(a) (array_release_in_place((a)->at), (a)->at = NULL, (a)->count = (a)->capacity = 0)

/* The same for arrays that may be large and of which there may be many: up to 256 KiB they are on the heap, beyond it
 * they grow where they are, with less address space, or move without being copied. No other macro may make such an
 * array grow, or free it. */
void *array_grow_long(void *at, size_t *capacity, size_t need, size_t size);
void array_release_long(void *at, size_t bytes);
#define array_reserve_long(a, need)                                                                                    \
    ((a)->at = (need) > (a)->capacity ? array_grow_long((a)->at, &(a)->capacity, (need), sizeof *(a)->at) : (a)->at)
#define array_push_long(a, value) (array_reserve_long((a), (a)->count + 1), (a)->at[(a)->count++] = (value))
#define array_free_long(a)                                                                                             \
    (array_release_long((a)->at, (a)->capacity * sizeof *(a)->at), (a)->at = NULL, (a)->count = (a)->capacity = 0)

#define array_push(a, value) (array_reserve((a), (a)->count + 1), (a)->at[(a)->count++] = (value))
#define array_trim(a) ((a)->at = array_shrink((a)->at, &(a)->capacity, (a)->count, sizeof *(a)->at))
#define array_free(a) (free((a)->at), (a)->at = NULL, (a)->count = (a)->capacity = 0)

#endif
