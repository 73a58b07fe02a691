/* Turns: the order within a source stands, whoever floods waits for himself, and every byte is counted. Against a plain
 * model of lists. */
#include "link/turns.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

#include <cmocka.h>

typedef struct message {
    uint64_t source;
    size_t number, bytes;
} message;

static message *put(turns *t, uint64_t source, size_t number, size_t bytes)
{
    message *m = calloc(1, sizeof *m);
    assert_non_null(m);
    *m = (message){source, number, bytes};
    turns_put(t, source, m, bytes);
    return m;
}

static void who_says_little_does_not_wait_for_who_floods(void **state)
{
    enum { FLOOD = 5000, BYTES = 60000, FLOODERS = 3 };
    (void)state;
    turns t;
    turns_init(&t);
    for (uint64_t s = 1; s <= FLOODERS; s++)
        for (size_t i = 0; i < FLOOD; i++) put(&t, s, i, BYTES);
    message *last = put(&t, 99, 0, 100), *m;
    size_t before = 0;
    while ((m = turns_next(&t)) != last) {
        before += m->bytes;
        free(m);
    }
    free(m);
    assert_true(before <= FLOODERS * (size_t)400000); /* a turn and a message each */
    size_t taken[FLOODERS + 1] = {0};
    for (int i = 0; i < 3000; i++) { /* and those who flood have equal shares */
        m = turns_next(&t);
        taken[m->source]++;
        free(m);
    }
    for (int s = 1; s <= FLOODERS; s++) assert_in_range(taken[s], 990, 1010);
    while ((m = turns_next(&t)) != NULL) free(m);
    assert_int_equal(t.bytes, 0);
    turns_free(&t);
}

static uint64_t seed = 1;

static size_t draw(size_t below)
{
    seed = seed * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (size_t)(seed >> 33) % below;
}

typedef struct seen {
    size_t count, bytes;
} seen;

static void see(void *context, void *at)
{
    seen *s = context;
    s->count++;
    s->bytes += ((const message *)at)->bytes;
}

static void any_sequence_keeps_the_order_of_each_source(void **state)
{
    enum { SOURCES = 20, STEPS = 200000 };
    (void)state;
    turns t;
    size_t put_in[SOURCES] = {0}, taken[SOURCES] = {0}, bytes[SOURCES] = {0}, count = 0, all = 0;
    turns_init(&t);
    for (size_t i = 0; i < STEPS; i++) {
        size_t s = draw(SOURCES), what = draw(10);
        message *m = NULL;
        if (what < 5) {
            size_t size = draw(10) ? draw(1000) : draw(2000000);
            put(&t, s + 1, put_in[s]++, size);
            bytes[s] += size;
            count++;
            all += size;
        } else {
            m = what < 9 ? turns_next(&t) : turns_oldest_of(&t, s + 1);
            assert_int_equal(m != NULL, what < 9 ? count > 0 : put_in[s] > taken[s]);
        }
        if (m) {
            size_t of = (size_t)m->source - 1;
            assert_int_equal(m->number, taken[of]);
            taken[of]++;
            bytes[of] -= m->bytes;
            all -= m->bytes;
            count--;
            free(m);
        }
        assert_int_equal(t.count, count);
        assert_int_equal(t.bytes, all);
        assert_int_equal(turns_bytes_of(&t, s + 1), bytes[s]);
        assert_int_equal(turns_count_of(&t, s + 1), put_in[s] - taken[s]);
        uint64_t longest = turns_longest(&t);
        assert_int_equal(longest != 0, count > 0);
        for (size_t k = 0; longest && k < SOURCES; k++) assert_true(bytes[k] <= bytes[longest - 1]);
    }
    seen s = {0};
    turns_each(&t, see, &s);
    assert_int_equal(s.count, count);
    assert_int_equal(s.bytes, all);
    for (message *m; (m = turns_next(&t)) != NULL;) free(m);
    turns_free(&t);
}

/* Who is charged more than his bytes has fewer of them, and a message of which a part is taken stays the first. */
static void work_is_charged_and_parts_stay_first(void **state)
{
    enum { DEAR = 50, EACH = 1000, BYTES = 10000, MORE = 90000 };
    (void)state;
    turns t;
    size_t taken[3] = {0}, parts = 0;
    turns_init(&t);
    assert_null(turns_first(&t));
    for (uint64_t s = 1; s <= 2; s++)
        for (size_t i = 0; i < EACH; i++) put(&t, s, i, BYTES);
    for (int i = 0; i < 500; i++) {
        message *m = turns_first(&t);
        assert_non_null(m);
        assert_int_equal(m->number, taken[m->source]);
        if (m->source == 1 && m->bytes == BYTES) { /* first a half of it, at as much */
            size_t before = t.bytes, of = turns_bytes_of(&t, 1);
            turns_part(&t, BYTES / 2, MORE / 2);
            m->bytes -= BYTES / 2;
            assert_int_equal(before - t.bytes, BYTES / 2);
            assert_int_equal(of - turns_bytes_of(&t, 1), BYTES / 2);
            parts++;
            continue;
        }
        size_t before = t.bytes;
        turns_take(&t, m->source == 1 ? MORE / 2 : 0);
        assert_int_equal(before - t.bytes, m->bytes);
        taken[m->source]++;
        free(m);
    }
    assert_true(parts >= taken[1] && taken[1] > 20);
    assert_in_range(taken[2], 8 * taken[1], 12 * taken[1] + DEAR);
    for (message *m; (m = turns_next(&t)) != NULL;) free(m);
    assert_int_equal(t.bytes, 0);
    turns_free(&t);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(who_says_little_does_not_wait_for_who_floods),
        cmocka_unit_test(work_is_charged_and_parts_stay_first),
        cmocka_unit_test(any_sequence_keeps_the_order_of_each_source),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
