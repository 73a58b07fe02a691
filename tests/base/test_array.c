/* Growing arrays: what was pushed stays, and a steady use does not grow. */
#include "base/array.h"
#include "cmocka_c.h"

#include <stdlib.h>

static void pushed_values_stay_in_order(void **state)
{
    (void)state;
    ARRAY(uint32_t) a = {0};
    for (uint32_t i = 0; i < 10000; i++) array_push(&a, i * 7);
    assert_int_equal(a.count, 10000);
    assert_true(a.capacity >= a.count);
    for (uint32_t i = 0; i < 10000; i++) assert_int_equal(a.at[i], i * 7);
    array_free(&a);
    assert_null(a.at);
    assert_int_equal(a.capacity, 0);
}

static void a_refilled_array_keeps_its_buffer(void **state)
{
    (void)state;
    ARRAY(double) a = {0};
    for (int i = 0; i < 1000; i++) array_push(&a, i);
    const double *buffer = a.at;
    size_t capacity = a.capacity;
    for (int round = 0; round < 10; round++) {
        a.count = 0;
        for (int i = 0; i < 1000; i++) array_push(&a, i);
    }
    assert_ptr_equal(a.at, buffer);
    assert_int_equal(a.capacity, capacity);
    array_free(&a);
}

static void growth_meets_the_need_and_at_least_doubles(void **state)
{
    (void)state;
    size_t capacity = 0;
    char *at = array_grow(NULL, &capacity, 100, 1);
    assert_int_equal(capacity, 100);
    at = array_grow(at, &capacity, 101, 1);
    assert_int_equal(capacity, 200);
    at = array_grow(at, &capacity, 150, 1);
    assert_int_equal(capacity, 200);
    free(at);
}

static void zero_bytes_are_a_valid_request(void **state)
{
    (void)state;
    void *none = base_alloc(0, 8), *cleared = base_zalloc(0, 0);
    assert_non_null(none);
    assert_non_null(cleared);
    free(none);
    free(cleared);
}

static void text_is_copied(void **state)
{
    (void)state;
    char text[] = "panda_link7";
    char *copy = base_strdup(text);
    text[0] = 'x';
    assert_string_equal(copy, "panda_link7");
    free(copy);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pushed_values_stay_in_order),
        cmocka_unit_test(a_refilled_array_keeps_its_buffer),
        cmocka_unit_test(growth_meets_the_need_and_at_least_doubles),
        cmocka_unit_test(zero_bytes_are_a_valid_request),
        cmocka_unit_test(text_is_copied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
