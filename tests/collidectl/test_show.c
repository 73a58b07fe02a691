/* What is printed: JSON that any parser takes, and intervals with as many digits as they deserve. */
#include "run.h"

#include "json.h"
#include "show.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void text_is(const char *value, const char *expected)
{
    char *text = NULL;
    size_t size;
    json j = {.out = open_memstream(&text, &size)};
    json_text(&j, NULL, value);
    fclose(j.out);
    assert_string_equal(text, expected);
    free(text);
}

static void strings_are_escaped(void **state)
{
    (void)state;
    text_is("plain", "\"plain\"");
    text_is("\"\\/", "\"\\\"\\\\/\"");
    text_is("\n\t\x01\x7f", "\"\\u000a\\u0009\\u0001\\u007f\"");
    text_is("\xc3\xa4\xe2\x82\xac\xf0\x9f\xa4\x96", "\"\xc3\xa4\xe2\x82\xac\xf0\x9f\xa4\x96\"");
    text_is("\xff", "\"\\ufffd\"");
    text_is("a\xc3", "\"a\\ufffd\"");                     /* cut */
    text_is("\xc0\xaf", "\"\\ufffd\\ufffd\"");            /* overlong */
    text_is("\xed\xa0\x80", "\"\\ufffd\\ufffd\\ufffd\""); /* surrogate */
}

static void numbers_read_back_as_the_same_bits(void **state)
{
    (void)state;
    uint64_t seed = 11;
    for (int i = 0; i < 2000; i++) {
        double value, back;
        seed = seed * 6364136223846793005u + 1442695040888963407u;
        memcpy(&value, &seed, sizeof value);
        char *text = NULL;
        size_t size;
        json j = {.out = open_memstream(&text, &size)};
        json_number(&j, NULL, value);
        fclose(j.out);
        back = strtod(text, NULL);
        if (isfinite(value))
            assert_memory_equal(&back, &value, sizeof value);
        else
            assert_string_equal(text, "null");
        free(text);
    }
}

static void commas_stand_between_and_only_between(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size;
    json j = {.out = open_memstream(&text, &size)};
    json_open(&j, NULL, '{');
    json_integer(&j, "i", INT64_MIN);
    json_numbers(&j, "n", (double[]){1, NAN}, 2);
    json_open(&j, "e", '[');
    json_close(&j, ']');
    json_bool(&j, "b", false);
    json_close(&j, '}');
    json_end_line(&j);
    json_open(&j, NULL, '{');
    json_close(&j, '}');
    fclose(j.out);
    assert_string_equal(text, "{\"i\":-9223372036854775808,\"n\":[1,null],\"e\":[],\"b\":false}\n{}");
    free(text);
}

static void interval_is(double lo, double hi, const char *expected)
{
    char text[96];
    show_interval(lo, hi, text, sizeof text);
    assert_string_equal(text, expected);
}

static void intervals_show_their_width(void **state)
{
    (void)state;
    interval_is(0.0221348905, 0.0221348925, "[22.1348905, 22.1348925] mm");
    interval_is(0.1, 0.2, "[100.000, 200.000] mm");
    interval_is(-0.001, -0.001, "[-1.000000, -1.000000] mm");
    interval_is(2, 3, "[2.000, 3.000] m");
    interval_is(-INFINITY, INFINITY, "[-inf, inf] m");
}

static void brackets_show_their_width(void **state)
{
    (void)state;
    char text[96];
    show_bracket(0.73, 0.73000002, text, sizeof text);
    assert_string_equal(text, "[0.730000000, 0.730000020] s");
    show_bracket(0.5, INFINITY, text, sizeof text);
    assert_string_equal(text, "[0.500000, inf] s");
}

static void lengths_and_spans_have_three_digits_of_their_unit(void **state)
{
    (void)state;
    static const struct {
        double value;
        const char *length, *span;
    } cases[] = {{0, "0", "0 ns"}, {6e-15, "6e-15 m", "0 ns"}, {2.84e-9, "2.84 nm", "3 ns"}, {9.999e-7, "1 um", "1 us"},
        {1.23456e-5, "12.3 um", "12.3 us"}, {9.9996e-4, "1 mm", "1 ms"}, {0.0929, "92.9 mm", "92.9 ms"},
        {2.26, "2.26 m", ""}};
    char text[32];
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        show_length(cases[i].value, text, sizeof text);
        assert_string_equal(text, cases[i].length);
        if (!*cases[i].span) continue;
        show_span(cases[i].value, text, sizeof text);
        assert_string_equal(text, cases[i].span);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(strings_are_escaped),
        cmocka_unit_test(numbers_read_back_as_the_same_bits),
        cmocka_unit_test(commas_stand_between_and_only_between),
        cmocka_unit_test(intervals_show_their_width),
        cmocka_unit_test(brackets_show_their_width),
        cmocka_unit_test(lengths_and_spans_have_three_digits_of_their_unit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
