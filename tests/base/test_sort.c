/* Sorting keys. Oracle: qsort. */
#include "base/sort.h"
#include "cmocka_c.h"
#include "prng.h"

#include <stdlib.h>

enum { MOST = 5000 };

static int compare(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

static void check(prng *random, size_t count, uint64_t mask)
{
    static uint64_t keys[MOST], expected[MOST], scratch[MOST];
    for (size_t i = 0; i < count; i++) expected[i] = keys[i] = prng_next(random) & mask;
    qsort(expected, count, sizeof *expected, compare);
    sort_keys(keys, scratch, count);
    assert_memory_equal(keys, expected, count * sizeof *keys);
    sort_keys(keys, scratch, count); /* in order already */
    assert_memory_equal(keys, expected, count * sizeof *keys);
}

static void keys_come_out_as_qsort_has_them(void **state)
{
    (void)state;
    static const uint64_t masks[] = {UINT64_MAX, 0xff, 0x0000ffff0000ffff, 0x00000fff00000fff, UINT64_C(0xff) << 56, 3};
    prng random = {6};
    for (size_t m = 0; m < sizeof masks / sizeof *masks; m++) {
        for (size_t count = 1; count < 100; count++) check(&random, count, masks[m]);
        check(&random, MOST, masks[m]);
    }
}

/* Keys that differ in their upper bits, each with a payload below. */
static void payloads_go_with_their_keys(void **state)
{
    (void)state;
    static uint64_t keys[MOST], expected[MOST], scratch[MOST];
    prng random = {7};
    for (unsigned bits = 0; bits < 32; bits += 3) {
        for (size_t count = 40; count < MOST; count *= 5) {
            for (size_t i = 0; i < count; i++)
                expected[i] = (i * 7919 % count) << bits | (prng_next(&random) & ((UINT64_C(1) << bits) - 1));
            for (size_t i = 0; i < count; i++) keys[i] = expected[i];
            qsort(expected, count, sizeof *expected, compare);
            sort_keys_above(keys, scratch, count, bits);
            assert_memory_equal(keys, expected, count * sizeof *keys);
        }
    }
}

static void nothing_is_sorted_too(void **state)
{
    (void)state;
    sort_keys(NULL, NULL, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_come_out_as_qsort_has_them),
        cmocka_unit_test(payloads_go_with_their_keys),
        cmocka_unit_test(nothing_is_sorted_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
