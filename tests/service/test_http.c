/* Which requests for the page of figures are answered: GET and HEAD, of who names the daemon as its host. */
#include "service/http.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

static const http_rules LOOPBACK = {"127.0.0.1", "figures.example.org, two"}, BOUND = {"172.18.0.2", ""};

static http_request request_of(const char *head, const http_rules *rules)
{
    assert_int_equal(http_head_size(head, strlen(head)), strlen(head));
    return http_read(head, strlen(head), rules);
}

static unsigned status_of(const char *head)
{
    return request_of(head, &LOOPBACK).status;
}

#define H "Host: localhost:9464\r\n"

static void what_is_no_plain_request_is_refused(void **state)
{
    (void)state;
    assert_int_equal(status_of("GET /metrics HTTP/1.1\r\n" H "\r\n"), 200);
    assert_int_equal(status_of("HEAD / HTTP/1.1\r\n" H "\r\n"), 200);
    assert_int_equal(status_of("GET / HTTP/1.0\r\n\r\n"), 200);
    assert_int_equal(status_of("POST / HTTP/1.1\r\n" H "\r\n"), 405);
    assert_int_equal(status_of("CONNECT localhost:80 HTTP/1.1\r\n" H "\r\n"), 405);
    assert_int_equal(status_of("get / HTTP/1.1\r\n" H "\r\n"), 405);
    assert_int_equal(status_of("PRI * HTTP/2.0\r\n\r\n"), 505);
    assert_int_equal(status_of("GET http://localhost/ HTTP/1.1\r\n" H "\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Upgrade: websocket\r\nConnection: Upgrade\r\n\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Upgrade: h2c\r\nHTTP2-Settings: x\r\n\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Content-Length: 5\r\n\r\n"), 413);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Transfer-Encoding: chunked\r\n\r\n"), 413);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H H "\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H " folded: x\r\n\r\n"), 400);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "no colon\r\n\r\n"), 400);
    assert_int_equal(status_of("GET\r\n\r\n"), 400);
    assert_int_equal(status_of("\r\n\r\n"), 400);
    assert_int_equal(http_head_size("GET / HTTP/1.1\r\nHost: x\r\n", 25), 0);
}

static void a_connection_is_kept_or_not_as_was_said(void **state)
{
    (void)state;
    assert_true(request_of("GET /metrics?x=1 HTTP/1.1\r\n" H "\r\n", &LOOPBACK).keeps);
    assert_string_equal(request_of("GET /metrics?x=1 HTTP/1.1\r\n" H "\r\n", &LOOPBACK).path, "/metrics");
    assert_false(request_of("GET / HTTP/1.1\r\n" H "Connection: x, close\r\n\r\n", &LOOPBACK).keeps);
    assert_false(request_of("GET / HTTP/1.0\r\n\r\n", &LOOPBACK).keeps);
    assert_false(request_of("POST / HTTP/1.1\r\n" H "\r\n", &LOOPBACK).keeps);
}

static bool fits(const char *host, const http_rules *rules)
{
    return http_host_fits(host, strlen(host), rules);
}

static void a_host_is_one_that_is_known(void **state)
{
    (void)state;
    static const char *const ALWAYS[] = {"localhost", "LOCALHOST:1", "127.0.0.1:9464", "127.1.2.3", "[::1]:9464"};
    static const char *const NEVER[] = {"evil.example.org", "", ":", "localhost:x", "localhost:1:2", "[::1", "[::1]x",
        "localhost.evil.org", "127.0.0.1.evil.org", "evil.org:9464"};
    for (size_t i = 0; i < sizeof ALWAYS / sizeof *ALWAYS; i++)
        assert_true(fits(ALWAYS[i], &LOOPBACK) && fits(ALWAYS[i], &BOUND));
    for (size_t i = 0; i < sizeof NEVER / sizeof *NEVER; i++)
        assert_false(fits(NEVER[i], &LOOPBACK) || fits(NEVER[i], &BOUND));
    assert_true(fits("172.18.0.2:9464", &BOUND) && fits("collided:9464", &BOUND) && fits("10.0.0.7", &BOUND));
    assert_false(fits("172.18.0.2", &LOOPBACK) || fits("collided", &LOOPBACK));
    assert_true(fits("figures.example.org:80", &LOOPBACK) && fits("two", &LOOPBACK));
    assert_true(fits("evil.example.org", &(http_rules){"127.0.0.1", "*"}));
    assert_int_equal(status_of("GET / HTTP/1.1\r\nHost: evil.example.org\r\n\r\n"), 421);
}

static void a_foreign_origin_is_refused(void **state)
{
    (void)state;
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Origin: http://localhost:9464\r\n\r\n"), 200);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Origin: http://evil.example.org\r\n\r\n"), 403);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Origin: null\r\n\r\n"), 403);
    assert_int_equal(status_of("GET / HTTP/1.1\r\n" H "Origin:\r\n\r\n"), 403);
}

/* Whatever comes, nothing beyond it is read (the sanitizers look on), and only what is plain is answered. */
static void noise_is_no_request(void **state)
{
    (void)state;
    uint64_t seed = 1;
    static const char BASE[] =
        "GET /metrics HTTP/1.1\r\n" H "Origin: http://localhost:9464\r\nConnection: close\r\n\r\n";
    for (int i = 0; i < 100000; i++) {
        size_t size = sizeof BASE - 1;
        char *head = malloc(size);
        memcpy(head, BASE, size);
        for (int k = 0; k < 3; k++) {
            seed = seed * UINT64_C(6364136223846793005) + 1442695040888963407u;
            head[(seed >> 33) % (size - 4)] = (char)(seed >> 56);
        }
        http_request r = http_read(head, size, &LOOPBACK);
        assert_true(r.status != 200 || (memcmp(head, "GET /", 5) == 0 && strlen(r.path) < sizeof r.path));
        free(head);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_no_plain_request_is_refused),
        cmocka_unit_test(a_connection_is_kept_or_not_as_was_said),
        cmocka_unit_test(a_host_is_one_that_is_known),
        cmocka_unit_test(a_foreign_origin_is_refused),
        cmocka_unit_test(noise_is_no_request),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
