/* Arenas: aligned, disjoint, steady. */
#include "base/arena.h"
#include "cmocka_c.h"
#include "prng.h"

#include <string.h>

static void pieces_are_aligned_and_do_not_overlap(void **state)
{
    (void)state;
    enum { PIECES = 2000 };
    static unsigned char *at[PIECES];
    static size_t size[PIECES];
    prng random = {1};
    arena *a = arena_create(1000);
    for (int i = 0; i < PIECES; i++) {
        size[i] = prng_below(&random, i % 50 == 0 ? 5000 : 60);
        at[i] = arena_alloc(a, size[i]);
        assert_non_null(at[i]);
        assert_int_equal((uintptr_t)at[i] % 16, 0);
        memset(at[i], i & 0xff, size[i]);
    }
    for (int i = 0; i < PIECES; i++)
        for (size_t k = 0; k < size[i]; k++) assert_int_equal(at[i][k], i & 0xff);
    arena_destroy(a);
}

static void used_counts_since_the_last_reset(void **state)
{
    (void)state;
    arena *a = arena_create(64);
    assert_int_equal(arena_used(a), 0);
    arena_alloc(a, 16);
    arena_alloc(a, 17);
    assert_int_equal(arena_used(a), 48);
    arena_reset(a);
    assert_int_equal(arena_used(a), 0);
    arena_destroy(a);
}

/* The same requests after a reset come from the same block: the whole second round lies in one range. */
static void a_repeated_use_settles_on_one_block(void **state)
{
    (void)state;
    enum { PIECES = 500, BYTES = 100, ROOM = 112 };
    arena *a = arena_create(256);
    for (int i = 0; i < PIECES; i++) arena_alloc(a, BYTES);
    arena_reset(a);
    const char *first = NULL;
    for (int round = 0; round < 3; round++) {
        for (int i = 0; i < PIECES; i++) {
            const char *p = arena_alloc(a, BYTES);
            if (!first) first = p;
            assert_ptr_equal(p, first + (ptrdiff_t)i * ROOM);
        }
        arena_reset(a);
    }
    arena_destroy(a);
}

static void text_is_copied(void **state)
{
    (void)state;
    arena *a = arena_create(8);
    char text[] = "a name longer than the block";
    const char *copy = arena_strdup(a, text);
    text[0] = 'x';
    assert_string_equal(copy, "a name longer than the block");
    arena_destroy(a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pieces_are_aligned_and_do_not_overlap),
        cmocka_unit_test(used_counts_since_the_last_reset),
        cmocka_unit_test(a_repeated_use_settles_on_one_block),
        cmocka_unit_test(text_is_copied),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
