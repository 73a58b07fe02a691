/* Id pools: the least free id first, whatever happened before. Oracle: an array of flags, scanned from 0. */
#include "base/id_pool.h"
#include "cmocka_c.h"
#include "prng.h"

enum { IDS = 700 };

static uint32_t least_free(const bool *taken)
{
    uint32_t id = 0;
    while (taken[id]) id++;
    return id;
}

static void the_least_free_id_comes_first(void **state)
{
    (void)state;
    static bool taken[IDS];
    id_pool p;
    id_pool_init(&p);
    prng random = {2};
    uint32_t count = 0, end = 0;
    for (int i = 0; i < 100000; i++) {
        /* Waves of mostly taking and mostly giving, so that both the full and the empty pool are met. */
        bool take = prng_below(&random, 100) < (i / 5000 % 2 ? 30u : 70u);
        uint32_t id = prng_below(&random, IDS);
        if (take && count < IDS - 1) {
            id = least_free(taken);
            assert_int_equal(id_pool_take(&p), id);
            taken[id] = true;
            count++;
            if (id >= end) end = id + 1;
        } else if (!take && taken[id]) {
            id_pool_give(&p, id);
            taken[id] = false;
            count--;
        }
        assert_int_equal(p.taken, count);
        assert_int_equal(p.end, end);
        id = prng_below(&random, IDS);
        assert_int_equal(id_pool_has(&p, id), taken[id]);
    }
    id_pool_free(&p);
}

static void ids_beyond_the_pool_are_not_taken(void **state)
{
    (void)state;
    id_pool p;
    id_pool_init(&p);
    assert_false(id_pool_has(&p, 0));
    assert_int_equal(id_pool_take(&p), 0);
    assert_true(id_pool_has(&p, 0));
    assert_false(id_pool_has(&p, 1));
    assert_false(id_pool_has(&p, UINT32_MAX));
    id_pool_free(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_least_free_id_comes_first),
        cmocka_unit_test(ids_beyond_the_pool_are_not_taken),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
