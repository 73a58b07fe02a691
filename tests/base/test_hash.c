/* FNV-1a: the known answers of its authors, and that pieces make the whole. */
#include "base/hash.h"
#include "cmocka_c.h"

#include <math.h>

static void known_answers(void **state)
{
    (void)state;
    assert_true(hash_bytes(HASH_START, "", 0) == UINT64_C(0xcbf29ce484222325));
    assert_true(hash_bytes(HASH_START, "a", 1) == UINT64_C(0xaf63dc4c8601ec8c));
    assert_true(hash_bytes(HASH_START, "foobar", 6) == UINT64_C(0x85944171f73967e8));
    assert_true(hash_bytes(hash_bytes(HASH_START, "foo", 3), "bar", 3) == UINT64_C(0x85944171f73967e8));
}

static uint64_t hash_of_bytes(uint64_t h, uint64_t word)
{
    unsigned char bytes[8]; /* low ones first */
    for (int i = 0; i < 8; i++) bytes[i] = (unsigned char)(word >> 8 * i);
    return hash_bytes(h, bytes, sizeof bytes);
}

/* Zeros in all places, where hash_half takes a shorter way, and around each single bit. */
static void numbers_are_their_bytes(void **state)
{
    (void)state;
    for (int bit = 0; bit < 64; bit++)
        for (int bytes = 0; bytes < 256; bytes++) {
            uint64_t word = UINT64_C(1) << bit;
            for (int i = 0; i < 8; i++) word |= (bytes >> i & 1 ? UINT64_C(0xb7) : 0) << 8 * i;
            assert_true(hash_word(HASH_START, word) == hash_of_bytes(HASH_START, word));
            assert_true(hash_half((uint64_t)bytes, (uint32_t)word) == hash_bytes((uint64_t)bytes, &word, 4));
        }
    assert_true(hash_word(HASH_START, 0) == hash_of_bytes(HASH_START, 0));
    const double numbers[] = {0, -0.0, -1, 1e7, 0.1, INFINITY};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        assert_true(hash_double(HASH_START, numbers[i]) == hash_bytes(HASH_START, &numbers[i], sizeof numbers[i]));
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
        cmocka_unit_test(numbers_are_their_bytes),
        cmocka_unit_test(words_differ_in_every_bit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
