/* exporter: a thread that waits for its connections with poll. What it shares with the tick thread is `shown`: the
 * page, under a lock that is held for a copy of a pointer only. A connection is in one of three states, each of which
 * has an end in time; where there are as many as there may be, the one that has been longest in its state goes. */
#include "exporter.h"

#include "base/array.h"
#include "base/clock.h"
#include "base/log.h"
#include "http.h"

#include <arpa/inet.h>
#include <errno.h>
#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <time.h>
#include <unistd.h>

enum {
    CONNECTIONS_MAX = 128, /* in all, ... */
    OF_ONE_MAX = 64,       /* ... and of one address */
    HANDLED_MAX = 16,      /* requests that are answered at once when they come together: then others have their turn */
    LEFT_MAX = 1 << 18,    /* bytes that are read of who was refused and goes on talking */
    BACKLOG = 512,
    HEADER_ROOM = 512
};

static const int64_t HEAD_NS = 2000000000, ANSWER_NS = 4000000000, LEAVE_NS = 1000000000;

typedef struct shown { /* a page, as long as somebody reads it */
    char *text;
    size_t size;
    unsigned readers; /* under the exporter's lock; whoever made it the page counts */
} shown;

typedef enum state { FREE, READING, ANSWERING, LEAVING } state;

typedef struct connection {
    state state;
    int fd;
    int64_t since_ns; /* in this state, monotonic */
    char from[INET6_ADDRSTRLEN];
    char head[HTTP_HEAD_MAX];
    size_t had; /* bytes in `head` */
    char header[HEADER_ROOM], own[384];
    size_t header_size, body_size, sent;
    const char *body; /* of `page`, or `own` */
    shown *page;      /* NULL: it reads none */
    bool keeps;       /* after this answer */
    size_t left;      /* bytes read while leaving */
} connection;

struct exporter {
    int listens, wakes;
    http_rules rules;
    char address[INET6_ADDRSTRLEN], hosts[1024];
    pthread_t thread;
    _Atomic bool stop;
    pthread_mutex_t lock;
    shown *page;       /* under the lock; NULL: none yet ... */
    char unready[256]; /* ... empty: it is ready */
    connection connections[CONNECTIONS_MAX];
};

/* ---- pages ---- */

static void let_go_of_page(exporter *e, shown *page)
{
    if (!page) return;
    pthread_mutex_lock(&e->lock);
    bool last = --page->readers == 0;
    pthread_mutex_unlock(&e->lock);
    if (!last) return;
    free(page->text);
    free(page);
}

static shown *take_page(exporter *e)
{
    pthread_mutex_lock(&e->lock);
    shown *page = e->page;
    if (page) page->readers++;
    pthread_mutex_unlock(&e->lock);
    return page;
}

/* ---- connections ---- */

static void turn_to(connection *c, state next)
{
    c->state = next;
    c->since_ns = clock_monotonic_ns();
}

static void hang_up(exporter *e, connection *c)
{
    let_go_of_page(e, c->page);
    c->page = NULL;
    close(c->fd);
    c->state = FREE;
}

/* So that the answer is read: who is sent data and has not read it is told of nothing but a reset. */
static void leave_connection(exporter *e, connection *c)
{
    let_go_of_page(e, c->page);
    c->page = NULL;
    shutdown(c->fd, SHUT_WR);
    c->left = 0;
    turn_to(c, LEAVING);
}

static const char *reason_of(unsigned status)
{
    switch (status) {
    case 200:
        return "OK";
    case 403:
        return "Forbidden";
    case 404:
        return "Not Found";
    case 405:
        return "Method Not Allowed";
    case 413:
        return "Content Too Large";
    case 417:
        return "Expectation Failed";
    case 421:
        return "Misdirected Request";
    case 431:
        return "Request Header Fields Too Large";
    case 503:
        return "Service Unavailable";
    case 505:
        return "HTTP Version Not Supported";
    default:
        return "Bad Request";
    }
}

static void own_body(connection *c, const char *text)
{
    int size = snprintf(c->own, sizeof c->own, "%s\n", text);
    c->body = c->own;
    c->body_size = size < (int)sizeof c->own ? (size_t)size : sizeof c->own - 1;
}

/* The HTTP status. */
static unsigned find_page(exporter *e, connection *c, const char *path)
{
    char unready[sizeof e->unready];
    if (strcmp(path, "/metrics") == 0) {
        c->page = take_page(e);
        c->body = c->page ? c->page->text : "";
        c->body_size = c->page ? c->page->size : 0;
        return 200;
    }
    if (strcmp(path, "/ready") == 0) {
        pthread_mutex_lock(&e->lock);
        memcpy(unready, e->unready, sizeof unready);
        pthread_mutex_unlock(&e->lock);
        own_body(c, *unready ? unready : "ready");
        return *unready ? 503 : 200;
    }
    own_body(c, "collided: /metrics for Prometheus, /ready for probes");
    return strcmp(path, "/") == 0 ? 200 : 404;
}

static void begin_answer(exporter *e, connection *c, const http_request *r)
{
    unsigned status = r->status;
    if (status == 200)
        status = find_page(e, c, r->path);
    else
        own_body(c, r->says);
    c->keeps = r->keeps;
    int size = snprintf(c->header, sizeof c->header,
        "HTTP/1.1 %u %s\r\nContent-Type: text/plain; version=0.0.4; charset=utf-8\r\nContent-Length: %zu\r\n"
        "Cache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n%sConnection: %s\r\n\r\n",
        status, reason_of(status), c->body_size, status == 405 ? "Allow: GET, HEAD\r\n" : "",
        c->keeps ? "keep-alive" : "close");
    c->header_size = (size_t)size;
    if (r->head) c->body_size = 0;
    c->sent = 0;
    turn_to(c, ANSWERING);
}

/* The first whole request of those that have come, or what is too long to be one. False: there is none. */
static bool take_request(exporter *e, connection *c)
{
    size_t size = http_head_size(c->head, c->had);
    http_request r = {.status = 431, .says = "a request has at most 8 KiB"};
    if (!size && c->had < sizeof c->head) return false;
    if (size) {
        r = http_read(c->head, size, &e->rules);
        c->had -= size;
        memmove(c->head, c->head + size, c->had);
    }
    begin_answer(e, c, &r);
    return true;
}

/* Each of these: true while there is more to do at once. */
static bool read_some(exporter *e, connection *c)
{
    ssize_t n = recv(c->fd, c->head + c->had, sizeof c->head - c->had, MSG_DONTWAIT);
    if (n > 0) c->had += (size_t)n;
    bool waits = n < 0 && (errno == EAGAIN || errno == EINTR);
    if (take_request(e, c)) return true;
    if (n <= 0 && !waits) hang_up(e, c);
    return n > 0;
}

static bool send_response(exporter *e, connection *c)
{
    size_t total = c->header_size + c->body_size;
    while (c->sent < total) {
        bool in_header = c->sent < c->header_size;
        const char *at = in_header ? c->header + c->sent : c->body + (c->sent - c->header_size);
        size_t size = in_header ? c->header_size - c->sent : total - c->sent;
        int more = in_header && c->body_size ? MSG_MORE : 0;
        ssize_t n = send(c->fd, at, size, MSG_DONTWAIT | MSG_NOSIGNAL | more);
        if (n < 0 && (errno == EAGAIN || errno == EINTR)) return false;
        if (n <= 0) {
            hang_up(e, c);
            return false;
        }
        c->sent += (size_t)n;
    }
    if (!c->keeps) {
        leave_connection(e, c);
        return true;
    }
    let_go_of_page(e, c->page);
    c->page = NULL;
    turn_to(c, READING);
    take_request(e, c);
    return true;
}

static bool leave_some(exporter *e, connection *c)
{
    char thrown[4096];
    ssize_t n = recv(c->fd, thrown, sizeof thrown, MSG_DONTWAIT);
    if (n < 0 && (errno == EAGAIN || errno == EINTR)) return false;
    if (n > 0) c->left += (size_t)n;
    if (n > 0 && c->left < LEFT_MAX) return true;
    hang_up(e, c);
    return false;
}

static void go_on(exporter *e, connection *c)
{
    bool more = true;
    for (int i = 0; i < HANDLED_MAX && more && c->state != FREE; i++)
        more = c->state == READING ? read_some(e, c) : c->state == ANSWERING ? send_response(e, c) : leave_some(e, c);
}

static int64_t end_of(const connection *c)
{
    return c->since_ns + (c->state == READING ? HEAD_NS : c->state == ANSWERING ? ANSWER_NS : LEAVE_NS);
}

/* ---- who comes ---- */

/* A free place, if need be that of whom it costs least: of the same address, where that has as many as it may have. */
static connection *make_place(exporter *e, const char *from)
{
    connection *place = NULL, *oldest = NULL, *oldest_own = NULL;
    size_t own = 0;
    for (size_t i = 0; i < CONNECTIONS_MAX; i++) {
        connection *c = &e->connections[i];
        if (c->state == FREE) {
            place = c;
            continue;
        }
        bool is_own = strcmp(c->from, from) == 0;
        own += is_own;
        if (!oldest || c->since_ns < oldest->since_ns) oldest = c;
        if (is_own && (!oldest_own || c->since_ns < oldest_own->since_ns)) oldest_own = c;
    }
    if (place && own < OF_ONE_MAX) return place;
    place = own >= OF_ONE_MAX ? oldest_own : oldest;
    hang_up(e, place);
    return place;
}

static void take_connections(exporter *e)
{
    for (int i = 0; i < BACKLOG; i++) {
        struct sockaddr_storage at;
        socklen_t size = sizeof at;
        char from[INET6_ADDRSTRLEN] = "";
        int fd = accept4(e->listens, (struct sockaddr *)&at, &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
        if (fd < 0 && (errno == ECONNABORTED || errno == EINTR)) continue;
        if (fd < 0 && errno != EAGAIN) nanosleep(&(struct timespec){0, 10000000}, NULL); /* no file left: not a loop */
        if (fd < 0) return;
        getnameinfo((struct sockaddr *)&at, size, from, sizeof from, NULL, 0, NI_NUMERICHOST);
        connection *c = make_place(e, from);
        c->fd = fd;
        c->had = 0;
        snprintf(c->from, sizeof c->from, "%s", from);
        turn_to(c, READING);
        go_on(e, c);
    }
}

/* ---- the thread ---- */

static int wait_ms(const exporter *e)
{
    int64_t next = INT64_MAX, now = clock_monotonic_ns();
    for (size_t i = 0; i < CONNECTIONS_MAX; i++)
        if (e->connections[i].state != FREE && end_of(&e->connections[i]) < next) next = end_of(&e->connections[i]);
    if (next == INT64_MAX) return -1;
    return next <= now ? 0 : (int)((next - now) / 1000000 + 1);
}

static void wait_and_go_on(exporter *e)
{
    struct pollfd waits[CONNECTIONS_MAX + 2] = {
        {.fd = e->wakes, .events = POLLIN}, {.fd = e->listens, .events = POLLIN}};
    for (size_t i = 0; i < CONNECTIONS_MAX; i++) {
        const connection *c = &e->connections[i];
        waits[i + 2] =
            (struct pollfd){.fd = c->state == FREE ? -1 : c->fd, .events = c->state == ANSWERING ? POLLOUT : POLLIN};
    }
    if (poll(waits, CONNECTIONS_MAX + 2, wait_ms(e)) < 0) return;
    int64_t now = clock_monotonic_ns();
    for (size_t i = 0; i < CONNECTIONS_MAX; i++) {
        connection *c = &e->connections[i];
        if (c->state == FREE) continue;
        if (waits[i + 2].revents) go_on(e, c);
        if (c->state != FREE && now >= end_of(c)) hang_up(e, c);
    }
    if (waits[1].revents) take_connections(e);
}

static void *serve(void *context)
{
    exporter *e = context;
    while (!e->stop) wait_and_go_on(e);
    return NULL;
}

/* ---- its life ---- */

static int listen_at(const char *address, uint16_t port)
{
    char service[8];
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE}, *at;
    const int yes = 1;
    snprintf(service, sizeof service, "%u", port);
    if (getaddrinfo(address, service, &hints, &at) != 0) {
        errno = EADDRNOTAVAIL;
        return -1;
    }
    int s = socket(at->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
    if (s >= 0) setsockopt(s, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
    bool good = s >= 0 && bind(s, at->ai_addr, at->ai_addrlen) == 0 && listen(s, BACKLOG) == 0;
    int error = errno;
    freeaddrinfo(at);
    if (good) return s;
    if (s >= 0) close(s);
    errno = error;
    return -1;
}

static void free_exporter(exporter *e)
{
    for (size_t i = 0; i < CONNECTIONS_MAX; i++)
        if (e->connections[i].state != FREE) hang_up(e, &e->connections[i]);
    if (e->listens >= 0) close(e->listens);
    if (e->wakes >= 0) close(e->wakes);
    let_go_of_page(e, e->page);
    pthread_mutex_destroy(&e->lock);
    free(e);
}

exporter *exporter_start(uint16_t port, const char *address, const char *hosts, char *why, size_t why_size)
{
    exporter *e = base_zalloc(1, sizeof *e);
    pthread_mutex_init(&e->lock, NULL);
    snprintf(e->unready, sizeof e->unready, "starting");
    snprintf(e->address, sizeof e->address, "%s", address);
    snprintf(e->hosts, sizeof e->hosts, "%s", hosts);
    e->rules = (http_rules){e->address, e->hosts};
    e->wakes = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    e->listens = listen_at(address, port);
    int error = e->listens < 0 || e->wakes < 0 ? errno : pthread_create(&e->thread, NULL, serve, e);
    if (!error) return e;
    if (error == EADDRNOTAVAIL)
        snprintf(why, why_size, "metrics_address = %s: %s: name an address of this machine as a number", address,
            strerror(error));
    else
        snprintf(why, why_size, "metrics_port = %u: %s: choose another port, or 0 for none", port, strerror(error));
    free_exporter(e);
    return NULL;
}

void exporter_show(exporter *e, const char *page, size_t size, const char *unready)
{
    shown *next = base_zalloc(1, sizeof *next);
    *next = (shown){.text = base_zalloc(size + 1, 1), .size = size, .readers = 1};
    memcpy(next->text, page, size);
    pthread_mutex_lock(&e->lock);
    shown *old = e->page;
    e->page = next;
    snprintf(e->unready, sizeof e->unready, "%s", unready ? unready : "");
    pthread_mutex_unlock(&e->lock);
    let_go_of_page(e, old);
}

void exporter_stop(exporter *e)
{
    if (!e) return;
    uint64_t one = 1;
    e->stop = true;
    if (write(e->wakes, &one, sizeof one) < 0) log_error("metrics: %s", strerror(errno));
    pthread_join(e->thread, NULL);
    free_exporter(e);
}
