/* Parts of a state, read in portions of any size, are the bytes that a copy of all of it would be; what had not come
 * when it was made is zeros. */
#include "service/state_parts.h"

#include "base/hash.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

enum { VERTICES = WIRE_PIECE_MAX + 3000, INDICES = WIRE_PIECE_MAX + 9, PIECES = 3 };

static geometry_numbers *make_numbers(size_t vertices, size_t indices)
{
    geometry_numbers *n = geometry_numbers_create(WIRE_GEOMETRY_MESH, 1, vertices, indices);
    for (size_t i = 0; i < vertices; i++) n->vertices[i] = 1.0 + (double)i;
    for (size_t i = 0; i < indices; i++) n->indices[i] = (int32_t)(7 * i + 1);
    return n;
}

static void put_copy(bytes_out *to, const geometry_numbers *n, const uint8_t *has)
{
    const double none = 0;
    for (size_t i = 0; i < n->vertex_numbers; i++)
        bytes_put(to, !has || has[i / WIRE_PIECE_MAX] ? &n->vertices[i] : &none, sizeof *n->vertices);
    for (size_t i = 0; i < n->index_numbers; i++) {
        size_t number = n->vertex_numbers + i;
        bytes_put(to, !has || has[number / WIRE_PIECE_MAX] ? (const void *)&n->indices[i] : &none, sizeof *n->indices);
    }
}

static void expect_bytes(state_parts *p, const bytes_out *whole, size_t portion)
{
    uint8_t *some = malloc(portion);
    size_t at = 0, n;
    state_parts_rewind(p);
    while ((n = state_parts_read(p, some, portion)) > 0) {
        assert_true(at + n <= whole->count);
        assert_memory_equal(some, whole->at + at, n);
        at += n;
        assert_int_equal(p->read, at);
        assert_true(n == portion || at == whole->count);
    }
    assert_int_equal(at, whole->count);
    free(some);
}

static void portions_are_what_a_copy_would_be(void **state)
{
    (void)state;
    static const uint8_t HAS[][PIECES] = {{1, 1, 1}, {1, 0, 1}, {0, 1, 0}, {0, 0, 0}};
    static const size_t PORTIONS[] = {7, 4096, 65536, 1000003, 1 << 23};
    state_parts p = {.size = 0};
    bytes_out whole = {0};
    geometry_numbers *large = make_numbers(VERTICES, INDICES), *small = make_numbers(12, 0), *none = make_numbers(0, 0);
    for (size_t i = 0; i < sizeof HAS / sizeof *HAS; i++) {
        bytes_put(&p.own, "between", i); /* of no length at first */
        bytes_put(&whole, "between", i);
        state_parts_borrow(&p, large, i ? HAS[i] : NULL, PIECES);
        put_copy(&whole, large, i ? HAS[i] : NULL);
        state_parts_borrow(&p, i % 2 ? none : small, NULL, 1);
        put_copy(&whole, i % 2 ? none : small, NULL);
    }
    state_parts_borrow(&p, small, NULL, 1);
    put_copy(&whole, small, NULL);
    bytes_put(&p.own, "end", 3);
    bytes_put(&whole, "end", 3);
    state_parts_end(&p);
    assert_int_equal(p.size, whole.count);
    for (size_t i = 0; i < sizeof PORTIONS / sizeof *PORTIONS; i++) expect_bytes(&p, &whole, PORTIONS[i]);
    assert_true(state_parts_hash(&p) == hash_words(HASH_START, whole.at, whole.count));
    assert_int_equal(p.read, 0);
    geometry_numbers_release(large);
    geometry_numbers_release(small); /* what is borrowed stays until it is given back */
    geometry_numbers_release(none);
    expect_bytes(&p, &whole, 4096);
    state_parts_free(&p, NULL);
    assert_int_equal(p.size, 0);
    array_free(&whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(portions_are_what_a_copy_would_be)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
