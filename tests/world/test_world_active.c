/* The active list is in the order of its keys, whatever ids are in it: small ones, those that just fit into one number
 * with their pair's, and those that do not, up to the largest that there are. A world of that many shapes would fill
 * the machine: here there is none but the pairs and their map. */
#include "world/state.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct entry {
    uint64_t key;
    uint32_t id;
} entry;

static uint64_t next(uint64_t *state)
{
    *state += 0x9e3779b97f4a7c15u;
    uint64_t x = (*state ^ *state >> 30) * 0xbf58476d1ce4e5b9u;
    return x ^ x >> 29;
}

static int by_key(const void *a, const void *b)
{
    uint64_t x = ((const entry *)a)->key, y = ((const entry *)b)->key;
    return (x > y) - (x < y);
}

/* Of so many bits; half of them among the largest, so that keys differ in their lowest bits alone. */
static uint32_t some_id(uint64_t *random, unsigned bits)
{
    uint32_t most = (uint32_t)(UINT64_MAX >> (64 - bits));
    return next(random) % 2 ? (uint32_t)next(random) & most : most - (uint32_t)next(random) % 64;
}

/* Each of them has a key of its own: a pair is not there twice. */
static void add_pairs(world *w, size_t count, unsigned of_colliders, unsigned of_pairs, entry *list)
{
    uint64_t random = count + of_colliders;
    while (w->active_pairs.count < count) {
        uint32_t id = some_id(&random, of_pairs), a = some_id(&random, of_colliders),
                 b = some_id(&random, of_colliders);
        if (a == b || w->pairs.at[id].used || pair_map_get(&w->pair_of, pair_key(a, b)) != PAIR_MAP_NONE) continue;
        w->pairs.at[id] = (pair){.a = a, .b = b, .used = true};
        pair_map_put(&w->pair_of, pair_key(a, b), id);
        list[w->active_pairs.count] = (entry){pair_key(a, b), id};
        array_push(&w->active_pairs, id);
        array_push(&w->active, pair_key(a, b));
    }
}

static void sorts(size_t count, unsigned of_colliders, unsigned of_pairs)
{
    world w = {.now_ns = 0};
    entry *list = base_alloc(count, sizeof *list);
    w.pairs.at = base_zalloc((size_t)1 << of_pairs, sizeof *w.pairs.at);
    pair_map_init(&w.pair_of);
    add_pairs(&w, count, of_colliders, of_pairs, list);
    qsort(list, count, sizeof *list, by_key);
    pair_sort_active(&w, of_colliders, of_pairs);
    assert_true(w.active.count == count && w.active_pairs.count == count);
    for (size_t i = 0; i < count; i++) {
        assert_int_equal(w.active.at[i], list[i].key);
        assert_int_equal(w.active_pairs.at[i], list[i].id);
    }
    pair_map_free(&w.pair_of);
    free(w.pairs.at);
    array_free(&w.active);
    array_free(&w.active_pairs);
    array_free(&w.sort_scratch);
    free(list);
}

static void it_is_in_the_order_of_keys_whatever_the_ids(void **state)
{
    (void)state;
    static const unsigned BITS[][2] = {{10, 12}, {24, 15}, {24, 16}, {24, 17}, {25, 16}, {32, 12}};
    for (size_t i = 0; i < sizeof BITS / sizeof *BITS; i++) {
        sorts(20, BITS[i][0], BITS[i][1]); /* few are sorted in another way */
        sorts(1000, BITS[i][0], BITS[i][1]);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_is_in_the_order_of_keys_whatever_the_ids),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
