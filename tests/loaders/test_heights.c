/* Heights from text and from pictures: what is read, and what is refused with which words. */
#include "fixture.h"

#include "loaders/heights.h"
#include "loaders/text.h"

#include <stdlib.h>
#include <string.h>

static const double RANGE[2] = {-1, 3};

static void a_text_matrix_is_read_row_by_row(void **state)
{
    (void)state;
    static const double TRUTH[9] = {1, 0.5, 1, 1, 0, 1, 1, 0.25, -0.1};
    fixture f;
    heights_grid g;
    fixture_begin(&f);
    if (!heights_load(&f.pool, LOADERS_DATA "/ground.txt", NULL, &g, &f.report)) fail_msg("%s", f.report.error);
    assert_true(g.rows == 3 && g.columns == 3);
    assert_memory_equal(g.at, TRUTH, sizeof TRUTH);
    fixture_end(&f);
}

/* The picture's lowest line comes first; what it says of gamma does not count. */
static void a_picture_is_seen_from_above(void **state)
{
    (void)state;
    static const double SIXTEEN[6] = {65535, 1, 256, 0, 32768, 65535}, EIGHT[4] = {128, 1, 0, 255};
    fixture f;
    heights_grid g;
    fixture_begin(&f);
    if (!heights_load(&f.pool, LOADERS_DATA "/ground16.png", RANGE, &g, &f.report)) fail_msg("%s", f.report.error);
    assert_true(g.rows == 2 && g.columns == 3);
    for (int i = 0; i < 6; i++) assert_true(g.at[i] == -1 + 4 * (SIXTEEN[i] / 65535));
    if (!heights_load(&f.pool, LOADERS_DATA "/ground8.png", RANGE, &g, &f.report)) fail_msg("%s", f.report.error);
    assert_true(g.rows == 2 && g.columns == 2);
    for (int i = 0; i < 4; i++) assert_true(g.at[i] == -1 + 4 * (EIGHT[i] / 255));
    fixture_end(&f);
}

static void expect_refused(const char *text, size_t size, const double *range, const char *words)
{
    fixture f;
    heights_grid g;
    fixture_begin(&f);
    char *data = pool_alloc(&f.pool, size + 1, 1);
    memcpy(data, text, size);
    assert_false(heights_parse(&f.pool, data, size, "ground", range, &g, &f.report));
    if (!strstr(f.report.error, words)) fail_msg("\"%s\" does not say \"%s\"", f.report.error, words);
    assert_null(strchr(f.report.error, '\n'));
    fixture_end(&f);
}

static void what_is_no_grid_is_refused(void **state)
{
    (void)state;
#define REFUSED(text, words) expect_refused(text, sizeof text - 1, NULL, words)
    REFUSED("", "has 0 rows and 0 columns");
    REFUSED("# nothing\n", "has 0 rows and 0 columns");
    REFUSED("1 2 3\n", "has 1 rows and 3 columns: at least 2");
    REFUSED("1\n2\n3\n", "has 3 rows and 1 columns: at least 2");
    REFUSED("1 2\n3\n", "ground:2: has 1 numbers, the first row has 2");
    REFUSED("1 2\n\n3 4 5\n", "ground:3: has 3 numbers, the first row has 2");
    REFUSED("1 2\n3 nan\n", "ground:2: there is something that is not a finite number");
    REFUSED("1 2\n3 inf\n", "not a finite number");
    REFUSED("1 2\n3 1e999\n", "not a finite number");
    REFUSED("1 2\n3 4m\n", "not a finite number");
    REFUSED("1 2\n3 \0\n", "neither a PNG nor text");
    expect_refused("1 2\n3 4\n", 8, RANGE, "the key 'range' is for pictures");
}

static char *read(fixture *f, const char *path, size_t *size)
{
    char *data = text_read_file(&f->pool, path, HEIGHTS_FILE_MAX, size, &f->report);
    if (!data) fail_msg("%s", f->report.error);
    return data;
}

static void pictures_of_another_kind_are_refused(void **state)
{
    (void)state;
    fixture f;
    size_t size;
    fixture_begin(&f);
    char *colour = read(&f, LOADERS_DATA "/colour.png", &size);
    expect_refused(colour, size, RANGE, "cannot be read as a PNG: it must be grey, of 8 or 16 bits");
    char *good = read(&f, LOADERS_DATA "/ground16.png", &size);
    expect_refused(good, size, NULL, "a picture needs the key 'range'");
    expect_refused(good, size - 20, RANGE, "cannot be read as a PNG: it ends too early");
    good[16] = 0x7f; /* two thousand million columns */
    expect_refused(good, size, RANGE, "cannot be read as a PNG");
    assert_false(heights_load(&f.pool, LOADERS_DATA "/none.png", RANGE, &(heights_grid){0}, &f.report));
    fixture_end(&f);
}

/* Each prefix and each changed byte is read or refused. */
static void damaged_pictures_do_no_harm(void **state)
{
    (void)state;
    fixture f;
    size_t size;
    fixture_begin(&f);
    const char *good = read(&f, LOADERS_DATA "/ground16.png", &size);
    for (size_t i = 0; i < 2 * size; i++) {
        fixture one;
        heights_grid g;
        fixture_begin(&one);
        char *data = pool_alloc(&one.pool, size + 1, 1);
        memcpy(data, good, i < size ? i : size);
        if (i >= size) data[i - size] ^= (char)(1 + i % 255);
        bool ok = heights_parse(&one.pool, data, i < size ? i : size, "ground", RANGE, &g, &one.report);
        assert_int_equal(ok, one.report.error[0] == '\0');
        fixture_end(&one);
    }
    fixture_end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_text_matrix_is_read_row_by_row),
        cmocka_unit_test(a_picture_is_seen_from_above),
        cmocka_unit_test(what_is_no_grid_is_refused),
        cmocka_unit_test(pictures_of_another_kind_are_refused),
        cmocka_unit_test(damaged_pictures_do_no_harm),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
