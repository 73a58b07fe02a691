/* exporter: a thread that runs libwebsockets' loop. What it shares with the tick thread is `shown`, under a lock that
 * is held for a copy only. */
#include "exporter.h"

#include "base/array.h"
#include "base/log.h"

#include <errno.h>
#include <libwebsockets.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { CONNECTIONS_MAX = 64, TIMEOUT_S = 2, A_WRITE = 4096 };

struct exporter {
    struct lws_context *context;
    pthread_t thread;
    _Atomic bool stop;
    pthread_mutex_t lock;
    char *page; /* under the lock ... */
    size_t size;
    char unready[256]; /* ... empty: it is ready */
};

/* An answer on its way, one a connection; the text stays as it was when it began. */
typedef struct reply {
    char *text;
    size_t size, sent;
} reply;

static void set_text(reply *r, const char *text, size_t size)
{
    free(r->text);
    *r = (reply){.text = base_zalloc(size + 1, 1), .size = size};
    memcpy(r->text, text, size);
}

/* The HTTP status. */
static unsigned answer(exporter *e, const char *path, reply *r)
{
    static const char ELSEWHERE[] = "collided: /metrics for Prometheus, /ready for probes\n";
    unsigned status = HTTP_STATUS_OK;
    pthread_mutex_lock(&e->lock);
    if (!strcmp(path, "/metrics")) {
        set_text(r, e->page ? e->page : "", e->size);
    } else if (!strcmp(path, "/ready")) {
        char text[sizeof e->unready + 2];
        int size = snprintf(text, sizeof text, "%s\n", *e->unready ? e->unready : "ready");
        set_text(r, text, (size_t)size);
        if (*e->unready) status = HTTP_STATUS_SERVICE_UNAVAILABLE;
    } else {
        set_text(r, ELSEWHERE, sizeof ELSEWHERE - 1);
        if (strcmp(path, "/") != 0) status = HTTP_STATUS_NOT_FOUND;
    }
    pthread_mutex_unlock(&e->lock);
    return status;
}

static int send_head(struct lws *wsi, unsigned status, size_t size)
{
    unsigned char head[LWS_PRE + 1024], *start = head + LWS_PRE, *at = start, *end = head + sizeof head - 1;
    if (lws_add_http_common_headers(wsi, status, "text/plain; version=0.0.4; charset=utf-8", size, &at, end) ||
        lws_finalize_write_http_header(wsi, start, &at, end))
        return 1;
    lws_callback_on_writable(wsi);
    return 0;
}

static void end_reply(reply *r)
{
    free(r->text);
    *r = (reply){.text = NULL};
}

/* libwebsockets may give a kept connection other memory for its next reply: so this one ends before. */
static int send_some(struct lws *wsi, reply *r)
{
    unsigned char piece[LWS_PRE + A_WRITE];
    if (!r->text) return 1;
    size_t left = r->size - r->sent, n = left < A_WRITE ? left : A_WRITE;
    memcpy(piece + LWS_PRE, r->text + r->sent, n);
    r->sent += n;
    bool last = r->sent == r->size;
    if (lws_write(wsi, piece + LWS_PRE, n, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < (int)n) return 1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    end_reply(r);
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

static int on_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    exporter *e = lws_context_user(lws_get_context(wsi));
    reply *r = user;
    switch (reason) {
    case LWS_CALLBACK_HTTP: {
        unsigned status = answer(e, size ? in : "/", r);
        return send_head(wsi, status, r->size);
    }
    case LWS_CALLBACK_HTTP_WRITEABLE:
        return send_some(wsi, r);
    case LWS_CALLBACK_CLOSED_HTTP:
        if (r) end_reply(r);
        return 0;
    case LWS_CALLBACK_FILTER_NETWORK_CONNECTION:
        return 0;
    default:
        return lws_callback_http_dummy(wsi, reason, user, in, size);
    }
}

static void *serve(void *context)
{
    exporter *e = context;
    while (!e->stop && lws_service(e->context, 0) >= 0) {
    }
    return NULL;
}

static void log_line(int level, const char *line)
{
    (void)level;
    log_warning("metrics: %.*s", (int)strcspn(line, "\n"), line);
}

static struct lws_context *create_context(exporter *e, uint16_t port)
{
    static const struct lws_protocols PROTOCOLS[] = {
        {.name = "http", .callback = on_http, .per_session_data_size = sizeof(reply)}, {.name = NULL}};
    struct lws_context_creation_info info = {.port = port,
        .iface = "127.0.0.1",
        .protocols = PROTOCOLS,
        .user = e,
        .gid = (gid_t)-1,
        .uid = (uid_t)-1,
        .options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_DISABLE_IPV6,
        .fd_limit_per_thread = CONNECTIONS_MAX,
        .timeout_secs = TIMEOUT_S,
        .keepalive_timeout = TIMEOUT_S,
        .max_http_header_pool = CONNECTIONS_MAX,
        .server_string = "collided"};
    lws_set_log_level(0, NULL); /* what goes wrong here is told by one line of our own */
    struct lws_context *context = lws_create_context(&info);
    lws_set_log_level(LLL_ERR, log_line);
    return context;
}

exporter *exporter_start(uint16_t port, char *why, size_t why_size)
{
    exporter *e = base_zalloc(1, sizeof *e);
    pthread_mutex_init(&e->lock, NULL);
    snprintf(e->unready, sizeof e->unready, "starting");
    errno = 0;
    e->context = create_context(e, port);
    int error = e->context ? pthread_create(&e->thread, NULL, serve, e) : errno ? errno : EADDRINUSE;
    if (!error) return e;
    snprintf(why, why_size, "metrics_port = %u: %s: choose another port, or 0 for none", port, strerror(error));
    if (e->context) lws_context_destroy(e->context);
    pthread_mutex_destroy(&e->lock);
    free(e);
    return NULL;
}

void exporter_show(exporter *e, const char *page, size_t size, const char *unready)
{
    char *copy = base_zalloc(size + 1, 1);
    memcpy(copy, page, size);
    pthread_mutex_lock(&e->lock);
    char *old = e->page;
    e->page = copy;
    e->size = size;
    snprintf(e->unready, sizeof e->unready, "%s", unready ? unready : "");
    pthread_mutex_unlock(&e->lock);
    free(old);
}

void exporter_stop(exporter *e)
{
    if (!e) return;
    e->stop = true;
    lws_cancel_service(e->context);
    pthread_join(e->thread, NULL);
    lws_context_destroy(e->context);
    pthread_mutex_destroy(&e->lock);
    free(e->page);
    free(e);
}
