/* A crowd that goes round and round: once every buffer has seen a round, an update allocates nothing. The linker puts
 * the __wrap functions below in front of the allocator. */
#include "base/whole.h"
#include "broad_world.h"

#include <stdlib.h>

static size_t allocations;

void *__real_malloc(size_t size);
void *__real_calloc(size_t count, size_t size);
void *__real_realloc(void *old, size_t size);
void *__real_aligned_alloc(size_t alignment, size_t size);
void *__wrap_malloc(size_t size);
void *__wrap_calloc(size_t count, size_t size);
void *__wrap_realloc(void *old, size_t size);
void *__wrap_aligned_alloc(size_t alignment, size_t size);

void *__wrap_malloc(size_t size)
{
    allocations++;
    return __real_malloc(size);
}
void *__wrap_calloc(size_t count, size_t size)
{
    allocations++;
    return __real_calloc(count, size);
}
void *__wrap_realloc(void *old, size_t size)
{
    allocations++;
    return __real_realloc(old, size);
}
void *__wrap_aligned_alloc(size_t alignment, size_t size)
{
    allocations++;
    return __real_aligned_alloc(alignment, size);
}

enum { BODIES = 800, ROUND = 60, WARM_UP = 12 };

/* Each body goes round a square of its own. */
static vec3 place_at(uint32_t body, int tick)
{
    static const vec3 sides[4] = {{1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}};
    uint32_t column = body % 10, row = body / 10 % 10, layer = body / 100;
    vec3 p = {1.5 * column, 1.5 * row, 1.5 * layer};
    int done = (tick + (int)(body * 7 % ROUND)) % ROUND, side = ROUND / 4;
    for (int k = 0; k < 4; k++) {
        int steps = done < side ? done : side;
        p = vec_madd(p, 0.1 * steps, sides[k]);
        done -= steps;
    }
    return p;
}

static size_t go_round(broad *b)
{
    size_t changes = 0;
    for (int tick = 0; tick < ROUND; tick++) {
        for (uint32_t i = 0; i < BODIES; i++) {
            aabb box = box_at(place_at(i, tick), vec(0.4, 0.4, 0.4));
            broad_put(b, &(broad_move){.proxy = i, .box = box, .margin = 0.05});
        }
        broad_changes c;
        broad_update(b, &c);
        changes += c.began_count + c.ended_count;
    }
    return changes;
}

static void a_steady_update_allocates_nothing(void **state)
{
    (void)state;
    whole_rest(true);
    allocations = 0;
    broad *b = make_broad(accept_all, NULL);
    for (int i = 0; i < WARM_UP; i++) go_round(b);
    assert_true(allocations > 0); /* the count works */
    allocations = 0;
    size_t changes = go_round(b);
    assert_int_equal(allocations, 0);
    assert_true(changes > BODIES);
    broad_destroy(b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_steady_update_allocates_nothing),
    };
    return run_with_each_index(tests);
}
