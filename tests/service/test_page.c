/* The page for Prometheus: each family has one head, before the first of its lines, whatever names hold. */
#include "service/page.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static size_t times(const page_text *page, const char *line)
{
    size_t found = 0, length = strlen(line);
    for (size_t i = 0; i + length <= page->count; i++)
        found += (i == 0 || page->at[i - 1] == '\n') && memcmp(page->at + i, line, length) == 0;
    return found;
}

static void a_family_has_one_head(void **state)
{
    (void)state;
    page_text page = {0};
    page_number(&page, "in_client", NULL, 1);
    page_number(&page, "in_body", NULL, 2);
    page_number(&page, "bodies", NULL, 3);
    page_number(&page, "reject_limit", NULL, 4);
    page_number(&page, "reject_not_yours", NULL, 5);
    assert_int_equal(times(&page, "# TYPE collided_messages_in_total counter\n"), 1);
    assert_int_equal(times(&page, "# TYPE collided_messages_rejected_total counter\n"), 1);
    assert_int_equal(times(&page, "collided_messages_in_total{kind=\"body\"} 2\n"), 1);
    assert_int_equal(times(&page, "collided_messages_rejected_total{reason=\"not_yours\"} 5\n"), 1);
    assert_int_equal(times(&page, "collided_bodies 3\n"), 1);
    array_free(&page);
}

/* Streams are named by clients. */
static void a_name_that_looks_like_a_head_is_none(void **state)
{
    (void)state;
    page_text page = {0};
    page_number(&page, "work_of_# HELP collided_lost_client_bodies x", NULL, 1);
    page_number(&page, "work_of_collided_stream_work_units{", NULL, 2);
    page_number(&page, "lost_client_000000000000000b", NULL, 3);
    assert_int_equal(times(&page, "# TYPE collided_stream_work_units gauge\n"), 1);
    assert_int_equal(times(&page, "# TYPE collided_lost_client_bodies gauge\n"), 1);
    array_free(&page);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_family_has_one_head),
        cmocka_unit_test(a_name_that_looks_like_a_head_is_none),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
