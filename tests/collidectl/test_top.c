/* What top shows: figures and rates of two Status, whole on a screen of any size, and nothing that a terminal would
 * obey. */
#include "run.h"

#include "top_page.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { COUNTERS_MAX = 512 };

typedef struct fake_status { /* a Status in the making */
    collided_counter counters[COUNTERS_MAX];
    char names[COUNTERS_MAX][64];
    size_t count;
} fake_status;

static void put(fake_status *f, int64_t value, const char *format, ...) __attribute__((format(printf, 3, 4)));
static void put(fake_status *f, int64_t value, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(f->names[f->count], sizeof f->names[0], format, arguments);
    va_end(arguments);
    f->counters[f->count] = (collided_counter){f->names[f->count], value};
    f->count++;
}

static void take(top_sample *s, const fake_status *f, int64_t epoch, int64_t second)
{
    const collided_daemon_status status = {.epoch = epoch,
        .tick = 1,
        .stamp_ns = second * 1000000000,
        .started_ns = 0,
        .health = "ready",
        .daemon = "host:1",
        .release = "0.1",
        .links = "dds://0 on lo",
        .limits = "",
        .counters = f->counters,
        .counter_count = f->count};
    top_sample_take(s, &status);
}

/* The state after so many seconds of a busy world. */
static void fill(fake_status *f, int64_t second, int clients, int streams)
{
    f->count = 0;
    put(f, clients, "clients");
    put(f, 100, "bodies");
    put(f, 7, "stale_bodies");
    put(f, 1000 * second, "ticks");
    put(f, 250000000 * second, "busy_ns");
    put(f, 345000, "latency_p50_ns");
    put(f, 1000000, "budget_ns");
    put(f, 17, "undone");
    put(f, 300 * second, "pairs_by_gjk");
    put(f, 100 * second, "pairs_by_sat");
    put(f, 5 * second, "reject_malformed");
    put(f, 0, "reject_limit");
    put(f, 3, "late_poses");
    put(f, streams, "streams");
    for (int i = 0; i < clients; i++) put(f, 1, "client_name_%016x_sim%d", i, i);
    for (int i = 0; i < clients; i++) put(f, i, "client_bodies_%016x", i);
    for (int i = 0; i < clients; i++) put(f, i * 10 * second, "client_poses_%016x", i);
    for (int i = 0; i < clients; i++) put(f, i, "client_work_%016x", i);
    for (int i = 0; i < streams; i++) put(f, 2 * i, "work_of_stream%d", i);
    for (int i = 0; i < streams; i++) put(f, i * second, "events_of_stream%d", i);
}

static void shows(const top_view *v, const char *words)
{
    char *page = top_page(v);
    if (!strstr(page, words)) fail_msg("no \"%s\" in:\n%s", words, page);
    free(page);
}

static void figures_are_rates_between_two_status(void **state)
{
    (void)state;
    static fake_status f;
    top_sample s = {.now = {.epoch = 0}};
    fill(&f, 10, 3, 2);
    take(&s, &f, 5, 10);
    assert_true(top_rate(&s, "ticks") > 999.9 && top_rate(&s, "ticks") < 1000.1); /* since the start */
    fill(&f, 12, 3, 2);
    take(&s, &f, 5, 12);
    const top_view v = {.sample = &s};
    shows(&v, "collided  ready, host:1, release 0.1, up 12 s\n");
    shows(&v, "ticks     1000/s, load 25.0 %,");
    shows(&v, "latency   p50 345 us ");
    shows(&v, "7 STALE");
    shows(&v, "budget    1 ms: 0 units done, 17 pairs undone");
    shows(&v, "pairs/s   gjk 300 (75 %)  sat 100 (25 %)\n");
    shows(&v, "drops     reject_malformed 60 (5.0/s)  late_poses 3\n");
    shows(&v, "sim2    0000000000000002      2    20.0        -        -     2.0\n"); /* the costliest first */
    shows(&v, "limits    none reached\n");
    top_sample_free(&s);
}

static void a_daemon_that_was_started_again_counts_anew(void **state)
{
    (void)state;
    static fake_status f;
    top_sample s = {.now = {.epoch = 0}};
    fill(&f, 100, 1, 1);
    take(&s, &f, 5, 100);
    fill(&f, 2, 1, 1);
    take(&s, &f, 6, 2);
    assert_int_equal(s.before.epoch, 0);
    assert_true(top_rate(&s, "ticks") > 999.9 && top_rate(&s, "ticks") < 1000.1);
    const top_view gone = {.sample = &s, .unheard_s = 4};
    shows(&gone, "collided  NOT HEARD for 4 s");
    top_sample_free(&s);
    const top_view nothing = {.sample = &s};
    shows(&nothing, "nothing is known yet");
}

/* Of any size: no line is wider and none more than there is room for; on large ones everybody is there, on smaller ones
 * those that are left out are counted. */
static void a_page_is_whole_on_any_screen(void **state)
{
    (void)state;
    static fake_status f;
    top_sample s = {.now = {.epoch = 0}};
    fill(&f, 1, 40, 30);
    take(&s, &f, 5, 1);
    fill(&f, 2, 40, 30);
    take(&s, &f, 5, 2);
    for (size_t columns = 1; columns < 160; columns += 11) {
        for (size_t rows = 1; rows < 100; rows += rows < 30 ? 1 : 23) {
            const top_view v = {.sample = &s, .columns = columns, .rows = rows};
            char *page = top_page(&v);
            size_t lines = 0;
            for (const char *t = page; *t; t += strcspn(t, "\n") + 1, lines++) assert_true(strcspn(t, "\n") <= columns);
            assert_true(lines <= rows);
            if (rows >= 24 && columns >= 80) {
                assert_non_null(strstr(page, "\nCLIENT"));
                assert_non_null(strstr(page, "\nSTREAM"));
                assert_non_null(strstr(page, "sim39")); /* the costliest is there ... */
                assert_non_null(strstr(page, "stream29"));
                assert_true(!!strstr(page, " more\n") == !(strstr(page, "sim0 ") && strstr(page, "stream0 ")));
            }
            free(page);
        }
    }
    top_sample_free(&s);
}

static void names_cannot_command_the_terminal(void **state)
{
    (void)state;
    static fake_status f;
    top_sample s = {.now = {.epoch = 0}};
    f.count = 0;
    put(&f, 1, "client_name_%016x_%s", 1,
        "\033[2J\a\xc2\x9b"
        "2J\x80z\xc3\xa4\xff");
    put(&f, 1, "events_of_%s", "a\nb\r");
    take(&s, &f, 5, 1);
    const top_view v = {.sample = &s, .columns = 80, .rows = 24};
    char *page = top_page(&v);
    for (const unsigned char *t = (const unsigned char *)page; *t; t++)
        assert_true((*t >= ' ' || *t == '\n') && *t != 127 && *t != 0x9b && *t != 0x80 && *t != 0xff);
    assert_non_null(strstr(page, "?[2J??2J?z\xc3\xa4?"));
    assert_non_null(strstr(page, "a?b?"));
    free(page);
    top_sample_free(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_are_rates_between_two_status),
        cmocka_unit_test(a_daemon_that_was_started_again_counts_anew),
        cmocka_unit_test(a_page_is_whole_on_any_screen),
        cmocka_unit_test(names_cannot_command_the_terminal),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
