/* The table holds what was put last under each key; the oracle is a plain array. */
#include "base/prng.h"
#include "cmocka_c.h"
#include "table.h"

enum { KEYS = 300, STEPS = 100000 };

static void finds_what_an_array_finds(void **state)
{
    (void)state;
    static char values[2];
    void *oracle[KEYS] = {NULL};
    table t = {0};
    uint64_t seed = 1;
    for (int step = 0; step < STEPS; step++) {
        uint64_t r = prng_bits(&seed);
        size_t key = r % KEYS;
        int64_t wide = (int64_t)(key << 33 | key); /* keys that differ in high and low bits */
        if (r >> 32 & 1) {
            oracle[key] = &values[r >> 33 & 1];
            table_put(&t, wide, oracle[key]);
        } else {
            oracle[key] = NULL;
            table_drop(&t, wide);
        }
        size_t probe = (r >> 40) % KEYS;
        assert_ptr_equal(table_get(&t, (int64_t)(probe << 33 | probe)), oracle[probe]);
    }
    size_t count = 0;
    for (size_t i = 0; i < KEYS; i++) count += oracle[i] != NULL;
    assert_int_equal(t.count, count);
    table_free(&t);
    assert_null(table_get(&t, 0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(finds_what_an_array_finds)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
