/* The log, read back through a file in place of standard error. */
#include "base/clock.h"
#include "base/log.h"
#include "cmocka_c.h"

#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { TEXT_BYTES = 16384 };

typedef struct capture {
    FILE *file;
    int stderr_before;
    char text[TEXT_BYTES];
} capture;

static void capture_begin(capture *c)
{
    c->file = tmpfile();
    assert_non_null(c->file);
    c->stderr_before = dup(STDERR_FILENO);
    dup2(fileno(c->file), STDERR_FILENO);
}

static void capture_end(capture *c)
{
    dup2(c->stderr_before, STDERR_FILENO);
    close(c->stderr_before);
    rewind(c->file);
    size_t n = fread(c->text, 1, TEXT_BYTES - 1, c->file);
    c->text[n] = '\0';
    fclose(c->file);
}

static int lines_of(const char *text)
{
    int n = 0;
    for (; *text; text++) n += *text == '\n';
    return n;
}

/* Logs `lines` lines within one second of the clock; tries again when the second turned meanwhile. */
static void flood(log_site *site, int lines, capture *c)
{
    int64_t before;
    do {
        atomic_store(&site->second, 0);
        atomic_store(&site->muted, 0);
        before = clock_monotonic_ns() / 1000000000;
        capture_begin(c);
        for (int i = 0; i < lines; i++) log_write(site, LOG_WARNING, "bad number in message %d", i);
        capture_end(c);
    } while (clock_monotonic_ns() / 1000000000 != before);
}

static void a_line_has_its_level_and_its_text(void **state)
{
    (void)state;
    static capture c;
    capture_begin(&c);
    log_error("body %d of '%s' is flat", 7, "arm");
    log_info("second");
    capture_end(&c);
    assert_string_equal(c.text, "error: body 7 of 'arm' is flat\ninfo: second\n");
}

static void the_journal_gets_its_prefix(void **state)
{
    (void)state;
    static capture c;
    log_setup(LOG_INFO, 1);
    capture_begin(&c);
    log_warning("hot");
    log_notice("mild");
    capture_end(&c);
    log_setup(LOG_INFO, 0);
    assert_string_equal(c.text, "<4>warning: hot\n<5>notice: mild\n");
}

static void lines_above_the_level_are_not_printed(void **state)
{
    (void)state;
    static capture c;
    log_setup(LOG_WARNING, 0);
    capture_begin(&c);
    log_notice("no");
    log_warning("yes");
    capture_end(&c);
    log_setup(LOG_INFO, 0);
    assert_string_equal(c.text, "warning: yes\n");
}

static void a_burst_is_printed_whole(void **state)
{
    (void)state;
    static capture c;
    static log_site site;
    flood(&site, LOG_BURST, &c);
    assert_int_equal(lines_of(c.text), LOG_BURST);
    assert_int_equal(atomic_load(&site.muted), 0);
}

static void a_flood_is_muted_and_says_so_at_once(void **state)
{
    (void)state;
    static capture c;
    static log_site site;
    flood(&site, LOG_BURST + 15, &c);
    assert_int_equal(lines_of(c.text), LOG_BURST);
    assert_non_null(strstr(c.text, "(more like this are left out until the second is over) bad number in message 9\n"));
    assert_int_equal(atomic_load(&site.muted), 15);
}

static void the_next_line_says_how_many_were_muted(void **state)
{
    (void)state;
    static capture c;
    static log_site site;
    flood(&site, LOG_BURST + 15, &c);
    atomic_fetch_sub(&site.second, 1); /* as if the second had passed */
    capture_begin(&c);
    log_write(&site, LOG_WARNING, "again");
    capture_end(&c);
    assert_string_equal(c.text, "warning: (15 like this were left out) again\n");
    assert_int_equal(atomic_load(&site.muted), 0);
}

static void text_from_outside_cannot_break_the_line(void **state)
{
    (void)state;
    static capture c;
    capture_begin(&c);
    log_error("name '%s'", "a\nerror: forged\x1b[2J\x7f");
    capture_end(&c);
    assert_string_equal(c.text, "error: name 'a?error: forged?[2J?'\n");
}

static void a_long_line_is_cut_visibly(void **state)
{
    (void)state;
    static capture c;
    static char name[5000];
    memset(name, 'n', sizeof name - 1);
    capture_begin(&c);
    log_error("%s", name);
    log_info("after");
    capture_end(&c);
    assert_int_equal(lines_of(c.text), 2);
    assert_true(strchr(c.text, '\n') - c.text < 1024);
    assert_non_null(strstr(c.text, "nnn...\ninfo: after\n"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_line_has_its_level_and_its_text),
        cmocka_unit_test(the_journal_gets_its_prefix),
        cmocka_unit_test(lines_above_the_level_are_not_printed),
        cmocka_unit_test(a_burst_is_printed_whole),
        cmocka_unit_test(a_flood_is_muted_and_says_so_at_once),
        cmocka_unit_test(the_next_line_says_how_many_were_muted),
        cmocka_unit_test(text_from_outside_cannot_break_the_line),
        cmocka_unit_test(a_long_line_is_cut_visibly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
