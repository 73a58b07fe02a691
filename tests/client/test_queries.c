/* Queries are answered once, asked again where a transport loses messages, and never waited for without end. */
#include "cmocka_c.h"
#include "fake.h"

#include <math.h>
#include <string.h>

static int64_t epoch = 1;

static void answer(const wire_message *query, uint8_t status, const char *text)
{
    const char *a[] = {"arm", "hand"}, *b[] = {"table", ""};
    const double lo[] = {1, 2}, hi[] = {1.5, 2.5}, six[] = {1, 0, 0, 0, 1, 0}, eight[] = {1, 0, 0, 0, 0, 1, 0, 0};
    const int64_t ages[] = {-1, 1000000000};
    const uint8_t stale[] = {0, 1};
    const wire_message m = {.kind = WIRE_ANSWER,
        .answer = {.version = WIRE_VERSION,
            .client = query->query.client,
            .sequence = query->query.sequence,
            .epoch = epoch,
            .tick = 9,
            .kind = query->query.kind,
            .status = status,
            .text = text,
            .names_a = {2, a},
            .names_b = {2, b},
            .lo = {2, lo},
            .hi = {2, hi},
            .axes = {6, six},
            .points_a = {6, six},
            .points_b = {6, six},
            .orientations = {8, eight},
            .ages_ns = {2, ages},
            .stale = {2, stale}}};
    fake_give(&m);
}

/* The daemon's side: answers the n-th query that is sent. */
typedef struct helper {
    size_t n;
    uint8_t status;
    const char *text;
    bool reject;
    const wire_message *query;
} helper;

static void *answer_nth(void *context)
{
    helper *h = context;
    h->query = fake_message(WIRE_QUERY, h->n);
    if (h->reject)
        fake_reject(h->query, WIRE_UNSUPPORTED, h->text);
    else
        answer(h->query, h->status, h->text);
    return NULL;
}

static collided_status ask(collided *c, helper *h, collided_result *out)
{
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, answer_nth, h), 0);
    collided_status status = collided_query_distance(c, "arm", "table", 1e-6, FAKE_PATIENCE_S, out);
    pthread_join(thread, NULL);
    return status;
}

static void answers_are_handed_over_whole(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    helper h = {.text = "why not"};
    assert_int_equal(ask(c, &h, &r), COLLIDED_OK);
    assert_string_equal(h.query->query.name_b, "table");
    assert_true(r.count == 2 && r.tick == 9 && !r.truncated);
    assert_string_equal(r.hits[0].name_b, "table");
    assert_string_equal(r.hits[1].name_a, "hand");
    assert_string_equal(r.text, "why not");
    assert_true(r.hits[1].lo == 2 && r.hits[1].hi == 2.5 && r.hits[1].axis[1] == 1 && r.hits[1].orientation[1] == 1);
    assert_true(r.hits[0].age_s == -1 && r.hits[1].age_s == 1 && r.hits[1].stale && !r.hits[0].stale);
    collided_result_free(&r);
    helper truncated = {.n = 1, .status = WIRE_ANSWER_TRUNCATED, .text = ""};
    assert_int_equal(ask(c, &truncated, &r), COLLIDED_OK);
    assert_true(r.truncated);
    collided_result_free(&r);
    collided_close(c);
}

static void who_wants_the_status_alone_gets_it(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    helper h = {.text = "recording ended"};
    assert_int_equal(ask(c, &h, NULL), COLLIDED_OK);
    assert_int_equal(collided_record(c, "", 0, NULL), COLLIDED_TIMEOUT);
    collided_close(c);
}

/* Legal on the wire: an answer that has names alone. */
static void *answer_with_names_alone(void *context)
{
    const char *a[] = {"one"};
    const wire_message *query = fake_message(WIRE_QUERY, 0);
    const wire_message m = {.kind = WIRE_ANSWER,
        .answer = {.version = WIRE_VERSION,
            .client = query->query.client,
            .sequence = query->query.sequence,
            .epoch = epoch,
            .kind = query->query.kind,
            .text = "",
            .names_a = {1, a}}};
    wire_refusal why;
    assert_int_equal(wire_check(&m, &why), WIRE_OK);
    fake_give(&m);
    return context;
}

static void what_an_answer_lacks_is_not_read(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    pthread_t thread;
    assert_int_equal(pthread_create(&thread, NULL, answer_with_names_alone, NULL), 0);
    assert_int_equal(collided_query_bodies(c, "*", FAKE_PATIENCE_S, &r), COLLIDED_OK);
    pthread_join(thread, NULL);
    assert_int_equal(r.count, 1);
    assert_string_equal(r.hits[0].name_a, "one");
    assert_string_equal(r.hits[0].name_b, "");
    collided_result_free(&r);
    collided_close(c);
}

static void failures_have_their_own_status(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    helper unknown = {.n = 0, .status = WIRE_ANSWER_UNKNOWN_NAME, .text = "no body 'arm'"};
    assert_int_equal(ask(c, &unknown, &r), COLLIDED_UNKNOWN_ID);
    assert_string_equal(collided_error(c), "no body 'arm'");
    helper unsupported = {.n = 1, .status = WIRE_ANSWER_UNSUPPORTED, .text = "x"};
    assert_int_equal(ask(c, &unsupported, &r), COLLIDED_UNSUPPORTED);
    helper rejected = {.n = 2, .reject = true, .text = "no"};
    assert_int_equal(ask(c, &rejected, &r), COLLIDED_REJECTED);
    assert_non_null(strstr(collided_error(c), "unsupported"));
    const double origin[3] = {0}, nowhere[3] = {NAN, 0, 0};
    assert_int_equal(collided_query_ray(c, origin, nowhere, INFINITY, 1.0, &r), COLLIDED_BAD_ARGUMENT);
    assert_int_equal(fake_sent(WIRE_QUERY), 3);
    assert_null(r.hits);
    collided_close(c);
}

static void unanswered_queries_are_repeated_under_their_sequence(void **state)
{
    (void)state;
    fake_begin((fake_options){.repeats = true, .epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    helper h = {.n = 1, .text = ""};
    assert_int_equal(ask(c, &h, &r), COLLIDED_OK);
    collided_result_free(&r);
    assert_true(h.query->query.sequence == fake_message(WIRE_QUERY, 0)->query.sequence);
    answer(h.query, WIRE_ANSWER_OK, "late duplicate");
    helper next = {.n = 2, .text = "next"};
    assert_int_equal(ask(c, &next, &r), COLLIDED_OK);
    assert_string_equal(r.text, "next");
    collided_result_free(&r);
    collided_close(c);
}

static void waiting_ends_in_time(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    int64_t begin = session_monotonic_ns();
    assert_int_equal(collided_query_bodies(c, "*", 0.3, &r), COLLIDED_TIMEOUT);
    assert_in_range(session_monotonic_ns() - begin, NS_PER_S / 4, (int64_t)FAKE_PATIENCE_S * NS_PER_S);
    assert_int_equal(fake_sent(WIRE_QUERY), 1);
    collided_close(c);
}

static void a_restarted_daemon_is_asked_again(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    collided_result r;
    epoch = A_LATER_EPOCH;
    fake_set((fake_options){.epoch = A_LATER_EPOCH});
    helper h = {.n = 0, .text = "of the new one"};
    assert_int_equal(ask(c, &h, &r), COLLIDED_OK);
    assert_string_equal(r.text, "of the new one");
    assert_int_equal(r.epoch, A_LATER_EPOCH);
    collided_result_free(&r);
    epoch = 1;
    collided_close(c);
}

static void silence_is_told_apart_from_slowness(void **state)
{
    (void)state;
    fake_begin((fake_options){.epoch = epoch});
    collided *c = fake_connect();
    assert_int_equal(collided_poll(c, 0.0), COLLIDED_OK);
    assert_int_equal(collided_poll(c, 3.2), COLLIDED_NO_DAEMON);
    collided_daemon_status s;
    assert_int_equal(collided_get_status(c, 0.0, &s), COLLIDED_NO_DAEMON);
    fake_status(1);
    assert_int_equal(collided_get_status(c, FAKE_PATIENCE_S, &s), COLLIDED_OK);
    assert_string_equal(s.counters[0].name, "ticks");
    assert_int_equal(s.counters[0].value, 7);
    assert_int_equal(collided_poll(c, 0.0), COLLIDED_OK);
    collided_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_are_handed_over_whole),
        cmocka_unit_test(who_wants_the_status_alone_gets_it),
        cmocka_unit_test(what_an_answer_lacks_is_not_read),
        cmocka_unit_test(failures_have_their_own_status),
        cmocka_unit_test(unanswered_queries_are_repeated_under_their_sequence),
        cmocka_unit_test(waiting_ends_in_time),
        cmocka_unit_test(a_restarted_daemon_is_asked_again),
        cmocka_unit_test(silence_is_told_apart_from_slowness),
    };
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    fake_begin((fake_options){0});
    return failed;
}
