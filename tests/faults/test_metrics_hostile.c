/* The page of figures among connections that mean harm, 200 of each kind: who asks at once is answered within a second,
 * and the world's ticks do not notice. What is no GET or HEAD of a known Host is refused. */
#include "rig.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

enum { PORT = 9464, HOSTILE = 200, SCRAPES = 5 };
#define PATIENT_S 1.0
#define GET_METRICS "GET /metrics HTTP/1.1\r\nHost: localhost:9464\r\n"

static int open_connection(void)
{
    struct sockaddr_in at = {.sin_family = AF_INET, .sin_port = htons(PORT), .sin_addr = {htonl(INADDR_LOOPBACK)}};
    int s = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    assert_true(s >= 0);
    if (connect(s, (struct sockaddr *)&at, sizeof at) == 0 || errno == EINPROGRESS) return s;
    close(s);
    return -1;
}

static void say(int s, const char *text, size_t size)
{
    while (size) { /* as much as is taken: it may have hung up */
        ssize_t n = send(s, text, size, MSG_DONTWAIT | MSG_NOSIGNAL);
        if (n <= 0) return;
        text += n;
        size -= (size_t)n;
    }
}

/* The whole answer to one request, or what of it came within that time. */
static char *ask(const char *request, double seconds)
{
    static char answer[1 << 20];
    size_t got = 0;
    double end_s = rig_now_s() + seconds;
    int s = open_connection();
    struct pollfd p = {.fd = s, .events = POLLOUT};
    answer[0] = '\0';
    if (s < 0 || poll(&p, 1, (int)(1000 * seconds)) <= 0) return answer;
    say(s, request, strlen(request));
    p.events = POLLIN;
    while (rig_now_s() < end_s && poll(&p, 1, 10) >= 0) {
        ssize_t n = recv(s, answer + got, sizeof answer - 1 - got, MSG_DONTWAIT);
        if (n == 0 || (n < 0 && errno != EAGAIN)) break;
        if (n > 0) got += (size_t)n;
        answer[got] = '\0';
    }
    close(s);
    return answer;
}

static bool scrape(void)
{
    const char *page = ask(GET_METRICS "Connection: close\r\n\r\n", PATIENT_S);
    return strstr(page, " 200 ") && strstr(page, "\ncollided_ticks_total ") && strstr(page, "collided_build_info{");
}

/* ---- hostile connections: what they do when they are there, and every 100 ms from then on ---- */

typedef struct hostile {
    const char *name;
    void (*begin)(int s, int i);
    void (*go_on)(int s, int i);
} hostile;

static void nothing(int s, int i)
{
    (void)s, (void)i;
}

static void one_byte(int s, int i)
{
    static int turn;
    if (turn++ % (10 * HOSTILE) < HOSTILE || i % 2) say(s, "G", 1);
}

static void many_requests(int s, int i)
{
    (void)i;
    for (int k = 0; k < 1000; k++) say(s, GET_METRICS "\r\n", sizeof GET_METRICS "\r\n" - 1);
}

static void half_close(int s, int i)
{
    if (i % 2) say(s, GET_METRICS, sizeof GET_METRICS - 1);
    shutdown(s, SHUT_WR);
}

static void huge_header(int s, int i)
{
    static char much[1 << 16];
    memset(much, 'x', sizeof much);
    say(s, i % 2 ? GET_METRICS "X: " : "", i % 2 ? sizeof GET_METRICS "X: " - 1 : 0);
    say(s, much, sizeof much);
}

static void upgrade(int s, int i)
{
    static const char *const TO[] = {
        "websocket\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13",
        "h2c\r\nHTTP2-Settings: AAMAAABkAAQAoAAAAAIAAAAA"};
    char text[512];
    snprintf(text, sizeof text, GET_METRICS "Connection: Upgrade\r\nUpgrade: %s\r\n\r\n", TO[i % 2]);
    say(s, text, strlen(text));
}

static void tunnel(int s, int i)
{
    (void)i;
    static const char TEXT[] = "CONNECT localhost:9464 HTTP/1.1\r\nHost: localhost:9464\r\n\r\n";
    say(s, TEXT, sizeof TEXT - 1);
}

static void tls(int s, int i)
{
    (void)i;
    static const char HELLO[] = "\x16\x03\x01\x00\xf8\x01\x00\x00\xf4\x03\x03";
    say(s, HELLO, sizeof HELLO - 1);
}

static void garbage(int s, int i)
{
    char noise[3000];
    uint64_t seed = (uint64_t)i + 1;
    for (size_t k = 0; k < sizeof noise; k++) {
        seed = seed * UINT64_C(6364136223846793005) + 1442695040888963407u;
        noise[k] = (char)(seed >> 56);
    }
    say(s, noise, sizeof noise);
}

static void reset(int s, int i)
{
    const struct linger at_once = {.l_onoff = 1, .l_linger = 0};
    if (i % 2) say(s, GET_METRICS "\r\n", sizeof GET_METRICS "\r\n" - 1);
    setsockopt(s, SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once);
}

static const hostile KINDS[] = {{"never sends", nothing, nothing}, {"a byte now and then", one_byte, one_byte},
    {"never reads", many_requests, nothing}, {"half closed", half_close, nothing},
    {"huge headers", huge_header, huge_header}, {"upgrades", upgrade, nothing}, {"tunnels", tunnel, nothing},
    {"TLS", tls, nothing}, {"garbage", garbage, garbage}, {"resets", reset, nothing}};

static void come(const hostile *kind, int s[HOSTILE])
{
    for (int i = 0; i < HOSTILE; i++) {
        struct pollfd p = {.fd = s[i] = open_connection(), .events = POLLOUT};
        if (s[i] >= 0 && poll(&p, 1, 100) > 0) kind->begin(s[i], i);
        if (kind->begin == reset && s[i] >= 0) {
            close(s[i]);
            s[i] = -1;
        }
    }
}

static void beside(const hostile *kind, collided *c)
{
    int s[HOSTILE];
    come(kind, s);
    for (int k = 0; k < SCRAPES; k++) {
        for (int i = 0; i < HOSTILE; i++)
            if (s[i] >= 0) kind->go_on(s[i], i);
        if (!scrape()) fail_msg("%s: scrape %d had no answer within %g s", kind->name, k, PATIENT_S);
        collided_poll(c, 0.1);
    }
    for (int i = 0; i < HOSTILE; i++)
        if (s[i] >= 0) close(s[i]);
}

static pid_t daemon_with_figures(void)
{
    rig_need_network();
    static const char *const ARGUMENTS[] = {"collided", "--links", RIG_DDS, "--status-period", "0.1", "--workers", "1",
        "--log", "warning", "--metrics-port", "9464", NULL};
    return rig_start(COLLIDED, ARGUMENTS);
}

static void a_scrape_is_answered_beside_200_of_each_kind(void **state)
{
    pid_t daemon = daemon_with_figures();
    collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
    UNTIL(c, RIG_PATIENCE_S, scrape());
    for (size_t i = 0; i < sizeof KINDS / sizeof *KINDS; i++) beside(&KINDS[i], c);
    assert_true(rig_alive(daemon));
    rig_close(c);
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
}

static void refused(const char *request, const char *status)
{
    const char *answer = ask(request, 3);
    if (strncmp(answer, "HTTP/1.1 ", 9) != 0 || strncmp(answer + 9, status, 3) != 0)
        fail_msg("%s: expected %s, got: %.60s", request, status, answer);
}

static void what_is_no_plain_request_is_refused(void **state)
{
    pid_t daemon = daemon_with_figures();
    collided *c = rig_connect(*state, 10, COLLIDED_REMOVE);
    UNTIL(c, RIG_PATIENCE_S, scrape());
    refused("POST /metrics HTTP/1.1\r\nHost: localhost\r\n\r\n", "405");
    refused("CONNECT localhost:1 HTTP/1.1\r\nHost: localhost\r\n\r\n", "405");
    refused("GET /metrics HTTP/1.1\r\nHost: localhost\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n\r\n", "400");
    refused("GET /metrics HTTP/1.1\r\nHost: localhost\r\nUpgrade: h2c\r\nHTTP2-Settings: AA\r\n\r\n", "400");
    refused("GET /metrics HTTP/1.1\r\nHost: evil.example.org:9464\r\n\r\n", "421");
    refused("GET /metrics HTTP/1.1\r\nHost: localhost\r\nOrigin: http://evil.example.org\r\n\r\n", "403");
    refused("PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", "505");
    rig_close(c);
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(a_scrape_is_answered_beside_200_of_each_kind, RIG_DDS),
        OVER(what_is_no_plain_request_is_refused, RIG_DDS)};
    rig_isolate();
    return cmocka_run_group_tests(tests, NULL, NULL);
}
