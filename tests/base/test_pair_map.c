/* Pair maps against a plain table indexed by both ids, and over a long life. */
#include "base/clock.h"
#include "base/pair_map.h"
#include "cmocka_c.h"
#include "prng.h"

enum { IDS = 60 };

typedef struct table { /* the oracle: value by (a, b), a < b */
    uint32_t value[IDS][IDS];
    size_t count;
} table;

static void table_clear(table *t)
{
    t->count = 0;
    for (int a = 0; a < IDS; a++)
        for (int b = 0; b < IDS; b++) t->value[a][b] = PAIR_MAP_NONE;
}

static void random_ids(prng *random, uint32_t *a, uint32_t *b)
{
    *a = prng_below(random, IDS);
    do *b = prng_below(random, IDS);
    while (*b == *a);
}

static uint32_t *cell_of(table *t, uint32_t a, uint32_t b)
{
    return a < b ? &t->value[a][b] : &t->value[b][a];
}

static void check_one_operation(pair_map *m, table *t, prng *random, bool growing)
{
    uint32_t a, b;
    random_ids(random, &a, &b);
    uint32_t *cell = cell_of(t, a, b);
    assert_int_equal(pair_map_get(m, pair_key(a, b)), *cell);
    if (prng_below(random, 100) < (growing ? 70u : 30u)) {
        uint32_t value = prng_below(random, 1000000);
        assert_int_equal(pair_map_put(m, pair_key(b, a), value), *cell == PAIR_MAP_NONE);
        t->count += *cell == PAIR_MAP_NONE;
        *cell = value;
    } else {
        assert_int_equal(pair_map_remove(m, pair_key(a, b)), *cell);
        t->count -= *cell != PAIR_MAP_NONE;
        *cell = PAIR_MAP_NONE;
    }
    assert_int_equal(m->count, t->count);
}

static void every_answer_equals_a_plain_table(void **state)
{
    (void)state;
    static table t;
    table_clear(&t);
    pair_map m;
    pair_map_init(&m);
    prng random = {3};
    for (int i = 0; i < 200000; i++) check_one_operation(&m, &t, &random, i / 10000 % 2 == 0);
    for (uint32_t a = 0; a < IDS; a++)
        for (uint32_t b = a + 1; b < IDS; b++) assert_int_equal(pair_map_get(&m, pair_key(a, b)), t.value[a][b]);
    pair_map_free(&m);
}

static size_t occupied_slots(const pair_map *m)
{
    size_t n = 0;
    for (size_t i = 0; i < m->table.capacity; i++) n += m->table.keys[i] != 0;
    return n;
}

/* The sum over all runs of occupied slots of length squared: proportional to the cost of a missing look-up. */
static double cost_of_a_miss(const pair_map *m)
{
    double sum = 0;
    size_t run = 0;
    for (size_t i = 0; i < m->table.capacity; i++) {
        run = m->table.keys[i] ? run + 1 : 0;
        sum += (double)run;
    }
    return sum / (double)m->table.capacity;
}

/* With tombstones, occupied slots would grow beyond the count, and the runs with them. */
static void a_long_life_leaves_nothing_behind(void **state)
{
    (void)state;
    enum { LIVE = 3000, CHURN = 300000 };
    static uint64_t live[LIVE];
    pair_map m;
    pair_map_init(&m);
    prng random = {4};
    for (uint32_t i = 0; i < LIVE; i++) pair_map_put(&m, live[i] = pair_key(i, i + 1), i);
    size_t capacity = m.table.capacity;
    for (uint32_t i = 0; i < CHURN; i++) {
        uint32_t which = prng_below(&random, LIVE);
        assert_int_equal(pair_map_remove(&m, live[which]), which);
        live[which] = pair_key(LIVE + i, LIVE + i + 1 + prng_below(&random, 10)); /* new ids: never seen before */
        assert_true(pair_map_put(&m, live[which], which));
    }
    assert_int_equal(m.table.capacity, capacity);
    assert_int_equal(m.count, LIVE);
    assert_int_equal(occupied_slots(&m), LIVE);
    /* Linear probing at load 3/4 expects (1 + 1 / (1 - 3/4)^2) / 2 = 8.5 probes a miss (Knuth, vol. 3, 6.4). */
    assert_true(cost_of_a_miss(&m) < 10);
    pair_map_free(&m);
}

/* Lattices of ids (a grid of bodies, each with its right and its lower neighbour) must not pile up either. */
static void neighbours_on_a_grid_spread_evenly(void **state)
{
    (void)state;
    enum { SIDE = 128 };
    pair_map m;
    pair_map_init(&m);
    for (uint32_t i = 0; i + SIDE < SIDE * SIDE; i++) {
        pair_map_put(&m, pair_key(i, i + 1), i);
        if (i % 2 == 0) pair_map_put(&m, pair_key(i, i + SIDE), i);
    }
    assert_true(4 * m.count <= 3 * m.table.capacity);
    assert_true(cost_of_a_miss(&m) < 10);
    pair_map_free(&m);
}

/* Turns the finaliser of MurmurHash3 round: the key that it makes this of. */
static uint64_t key_that_becomes(uint64_t mixed)
{
    mixed ^= mixed >> 33;
    mixed *= UINT64_C(0x9cb4b2f8129337db);
    mixed ^= mixed >> 33;
    mixed *= UINT64_C(0x4f74430c22a54005);
    return mixed ^ mixed >> 33;
}

static int64_t time_of(const uint64_t *keys, uint32_t count)
{
    pair_map m;
    pair_map_init(&m);
    int64_t began_ns = clock_thread_ns();
    for (uint32_t i = 0; i < count; i++) pair_map_put(&m, keys[i], i);
    for (uint32_t i = 0; i < count; i++) assert_int_equal(pair_map_get(&m, keys[i]), i);
    int64_t took_ns = clock_thread_ns() - began_ns;
    pair_map_free(&m);
    return took_ns;
}

/* Clients choose numbers of bodies, hashes, their own ids: all of them for one slot, if that could be known. */
static void chosen_keys_do_not_clash(void **state)
{
    (void)state;
    enum { KEYS = 40000 };
    static uint64_t ordinary[KEYS], chosen[KEYS];
    for (uint64_t i = 0; i < KEYS; i++) {
        ordinary[i] = i + 1;
        chosen[i] = key_that_becomes(((i + 1) << 32) | 7);
    }
    int64_t least_ns = time_of(ordinary, KEYS);
    assert_true(time_of(chosen, KEYS) < 50 * least_ns);
}

/* A map that grows has its keys in two tables for a while: all are found, put anew and removed, and each once. */
static void a_large_map_grows_little_by_little(void **state)
{
    (void)state;
    enum { KEYS = 200000, CHANGES = 1000000 };
    static uint32_t value[KEYS];
    pair_map m;
    prng random = {5};
    size_t count = 0, growths = 0;
    bool was_growing = false;
    pair_map_init(&m);
    for (uint32_t i = 0; i < KEYS; i++) value[i] = PAIR_MAP_NONE;
    for (uint32_t i = 0; i < CHANGES; i++) {
        uint32_t key = prng_below(&random, KEYS), to = prng_below(&random, 1000), had = value[key];
        bool removes = prng_below(&random, 4) == 0;
        assert_int_equal(pair_map_get(&m, key + 1), had);
        if (removes)
            assert_int_equal(pair_map_remove(&m, key + 1), had);
        else
            assert_int_equal(pair_map_put(&m, key + 1, to), had == PAIR_MAP_NONE);
        value[key] = removes ? (uint32_t)PAIR_MAP_NONE : to;
        count += (value[key] != PAIR_MAP_NONE) - (size_t)(had != PAIR_MAP_NONE);
        assert_int_equal(m.count, count);
        bool grows = m.before.keys != NULL;
        if (grows && !was_growing) { /* nothing has been moved yet, or as good as nothing */
            size_t moved = occupied_slots(&m);
            assert_true(moved <= 16);
            growths++;
        }
        was_growing = grows;
    }
    assert_true(growths >= 3);
    for (uint32_t key = 0; key < KEYS; key++) assert_int_equal(pair_map_get(&m, key + 1), value[key]);
    pair_map_trim(&m);
    for (uint32_t key = 0; key < KEYS; key++) assert_int_equal(pair_map_get(&m, key + 1), value[key]);
    pair_map_free(&m);
}

static void a_key_does_not_depend_on_the_order(void **state)
{
    (void)state;
    assert_true(pair_key(1, 2) == pair_key(2, 1));
    assert_true(pair_key(0, 1) != 0);
    assert_true(pair_key(0, 2) != pair_key(1, 2));
    assert_true(pair_key(UINT32_MAX, 0) == UINT32_MAX);
}

static void an_empty_map_has_nothing(void **state)
{
    (void)state;
    pair_map m;
    pair_map_init(&m);
    assert_int_equal(pair_map_get(&m, 5), PAIR_MAP_NONE);
    assert_int_equal(pair_map_remove(&m, 5), PAIR_MAP_NONE);
    pair_map_free(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_answer_equals_a_plain_table),
        cmocka_unit_test(a_long_life_leaves_nothing_behind),
        cmocka_unit_test(neighbours_on_a_grid_spread_evenly),
        cmocka_unit_test(chosen_keys_do_not_clash),
        cmocka_unit_test(a_large_map_grows_little_by_little),
        cmocka_unit_test(a_key_does_not_depend_on_the_order),
        cmocka_unit_test(an_empty_map_has_nothing),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
