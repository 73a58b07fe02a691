/* The page for Prometheus over one connection that is kept: each request is answered with the page of its moment, and
 * leaves no memory behind (seen in the heap's figures, and by the leak sanitizer). */
#include "service/exporter.h"

#include <arpa/inet.h>
#include <malloc.h>
#include <netinet/in.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cmocka.h>

enum { PAGE = 50000, REQUESTS = 100 };

static uint16_t free_port(void)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_addr = {htonl(INADDR_LOOPBACK)}};
    socklen_t size = sizeof at;
    int s = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(bind(s, (struct sockaddr *)&at, sizeof at), 0);
    assert_int_equal(getsockname(s, (struct sockaddr *)&at, &size), 0);
    close(s);
    return ntohs(at.sin_port);
}

static int connect_to(uint16_t port)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    const struct timeval patience = {.tv_sec = 30};
    int s = socket(AF_INET, SOCK_STREAM, 0);
    assert_int_equal(setsockopt(s, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience), 0);
    assert_int_equal(connect(s, (struct sockaddr *)&at, sizeof at), 0);
    return s;
}

/* The body of the answer is `page`; returns the HTTP status. */
static int get(int s, const char *path, const char *page, size_t size)
{
    static char answer[PAGE + 2000];
    char request[128];
    int length = snprintf(request, sizeof request, "GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n", path);
    assert_int_equal(write(s, request, (size_t)length), length);
    size_t got = 0;
    const char *body = NULL;
    while (!body || got - (size_t)(body - answer) < size) {
        ssize_t n = read(s, answer + got, sizeof answer - 1 - got);
        if (n <= 0) fail_msg("%s: the connection ends after %zu bytes", path, got);
        got += (size_t)n;
        answer[got] = '\0';
        const char *end = strstr(answer, "\r\n\r\n");
        body = end ? end + 4 : NULL;
    }
    assert_int_equal(got - (size_t)(body - answer), size);
    assert_memory_equal(body, page, size);
    return atoi(answer + sizeof "HTTP/1.1");
}

static void a_connection_that_is_kept_keeps_no_memory(void **state)
{
    (void)state;
    char why[256] = "", *page = malloc(PAGE);
    memset(page, 'x', PAGE);
    uint16_t port = 0;
    exporter *e = NULL;
    for (int tries = 0; tries < 10 && !e; tries++) /* somebody else may take it */
        e = exporter_start(port = free_port(), "127.0.0.1", "", why, sizeof why);
    if (!e) fail_msg("%s", why);
    exporter_show(e, page, PAGE, NULL);
    int s = connect_to(port);
    for (int i = 0; i < 3; i++) assert_int_equal(get(s, "/metrics", page, PAGE), 200);
    size_t before = mallinfo2().uordblks;
    for (int i = 0; i < REQUESTS; i++) {
        memset(page, 'a' + i % 26, PAGE);
        exporter_show(e, page, PAGE, NULL);
        assert_int_equal(get(s, "/metrics", page, PAGE), 200);
    }
    assert_int_equal(get(s, "/ready", "ready\n", 6), 200);
    size_t after = mallinfo2().uordblks;
    assert_true(after < before + 10 * PAGE); /* all of them would be 100 */
    close(s);
    exporter_stop(e);
    free(page);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_connection_that_is_kept_keeps_no_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
