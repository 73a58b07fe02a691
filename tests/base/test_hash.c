/* FNV-1a: the known answers of its authors, and that pieces make the whole. */
#include "base/hash.h"
#include "cmocka_c.h"

static void known_answers(void **state)
{
    (void)state;
    assert_true(hash_bytes(HASH_START, "", 0) == UINT64_C(0xcbf29ce484222325));
    assert_true(hash_bytes(HASH_START, "a", 1) == UINT64_C(0xaf63dc4c8601ec8c));
    assert_true(hash_bytes(HASH_START, "foobar", 6) == UINT64_C(0x85944171f73967e8));
    assert_true(hash_bytes(hash_bytes(HASH_START, "foo", 3), "bar", 3) == UINT64_C(0x85944171f73967e8));
}

/* Words at once: whichever bit is another one, the hash is. */
static void words_differ_in_every_bit(void **state)
{
    (void)state;
    unsigned char key[37] = "eight bytes at once, and some behind";
    uint64_t whole = hash_words(HASH_START, key, sizeof key);
    for (size_t bit = 0; bit < 8 * sizeof key; bit++) {
        key[bit / 8] ^= (unsigned char)(1u << bit % 8);
        assert_true(hash_words(HASH_START, key, sizeof key) != whole);
        key[bit / 8] ^= (unsigned char)(1u << bit % 8);
    }
    assert_true(hash_words(hash_words(HASH_START, key, 16), key + 16, sizeof key - 16) == whole);
    assert_true(hash_words(HASH_START, "foo", 3) == hash_bytes(HASH_START, "foo", 3));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(known_answers),
        cmocka_unit_test(words_differ_in_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
