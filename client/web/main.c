/* main: collided-web, the window of the collision daemon for browsers: a process of its own that serves a page and what
 * it shows, as an ordinary subscriber. Parses the command line, runs libwebsockets' loop. One thread beside that of the
 * client library. */
#include "foxview.h"
#include "web.h"
#include "window/index.h"

#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

static web *the_web; /* for the signals */

/* ---- HTTP ---- */

static const char SECURITY[] =
    "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; style-src 'self'; img-src 'self' data: blob:; "
    "connect-src 'self' ws://%s; worker-src 'self'; font-src 'self'; base-uri 'none'; form-action 'none'; "
    "frame-ancestors 'none'";

static bool header(struct lws *wsi, enum lws_token_indexes which, char *to, int size)
{
    return lws_hdr_total_length(wsi, which) > 0 && lws_hdr_copy(wsi, to, size, which) > 0;
}

static bool host_fits(struct lws *wsi, const web *w, char host[256])
{
    return header(wsi, WSI_TOKEN_HOST, host, 256) && gate_host(host, &w->options);
}

static int send_plain(struct lws *wsi, unsigned status, const char *text)
{
    return lws_return_http_status(wsi, status, text) ? -1 : (lws_http_transaction_completed(wsi) ? -1 : 0);
}

static int add(struct lws *wsi, const char *name, const char *value, unsigned char **at, unsigned char *end)
{
    return lws_add_http_header_by_name(
        wsi, (const unsigned char *)name, (const unsigned char *)value, (int)strlen(value), at, end);
}

typedef struct getting { /* of an HTTP request */
    const unsigned char *at;
    size_t left;
} getting;

static int answer_get(struct lws *wsi, const web *w, getting *g)
{
    char path[512];
    unsigned char room[LWS_PRE + 2048], *at = room + LWS_PRE, *begin = at, *end = room + sizeof room - 1;
    char host[256], policy[1024];
    site_file file;
    if (!host_fits(wsi, w, host)) return send_plain(wsi, 403, "this is nobody's page under that Host: --allow-host");
    if (lws_hdr_total_length(wsi, WSI_TOKEN_GET_URI) <= 0) return send_plain(wsi, 405, "GET is allowed");
    if (!header(wsi, WSI_TOKEN_GET_URI, path, sizeof path)) return send_plain(wsi, 404, "there is no such page");
    if (!site_find(w->site, path, &file)) return send_plain(wsi, 404, "there is no such page");
    snprintf(policy, sizeof policy, SECURITY, host);
    if (lws_add_http_common_headers(wsi, 200, file.type, file.size, &at, end) ||
        add(wsi, "content-security-policy:", policy, &at, end) ||
        add(wsi, "x-content-type-options:", "nosniff", &at, end) ||
        add(wsi, "referrer-policy:", "no-referrer", &at, end) ||
        add(wsi, "cross-origin-opener-policy:", "same-origin", &at, end) ||
        add(wsi, "cross-origin-resource-policy:", "same-origin", &at, end) ||
        add(wsi, "cache-control:", "no-cache", &at, end) || lws_finalize_write_http_header(wsi, begin, &at, end))
        return -1;
    *g = (getting){file.at, file.size};
    lws_callback_on_writable(wsi);
    return 0;
}

static int go_on_get(struct lws *wsi, getting *g)
{
    enum { PIECE = 16384 };
    unsigned char room[LWS_PRE + PIECE];
    size_t n = g->left < PIECE ? g->left : PIECE;
    bool last = n == g->left;
    if (!g->at) return 0;
    memcpy(room + LWS_PRE, g->at, n);
    g->at += n;
    g->left -= n;
    if (lws_write(wsi, room + LWS_PRE, n, last ? LWS_WRITE_HTTP_FINAL : LWS_WRITE_HTTP) < 0) return -1;
    if (!last) {
        lws_callback_on_writable(wsi);
        return 0;
    }
    g->at = NULL;
    return lws_http_transaction_completed(wsi) ? -1 : 0;
}

static web *web_of(struct lws *wsi)
{
    return lws_context_user(lws_get_context(wsi));
}

static int on_http(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    (void)size;
    if (reason == LWS_CALLBACK_HTTP) return answer_get(wsi, web_of(wsi), user);
    if (reason == LWS_CALLBACK_HTTP_WRITEABLE) return go_on_get(wsi, user);
    return lws_callback_http_dummy(wsi, reason, user, in, size);
}

/* ---- WebSockets ---- */

static int admit(struct lws *wsi, const web *w)
{
    char host[256], origin[512];
    bool has_origin = lws_hdr_total_length(wsi, WSI_TOKEN_ORIGIN) > 0;
    bool fits = host_fits(wsi, w, host) && (!has_origin || (header(wsi, WSI_TOKEN_ORIGIN, origin, sizeof origin) &&
                                                               gate_origin(origin, host, &w->options)));
    if (fits && w->viewer_count < WEB_CONNECTIONS) return 0;
    (void)lws_return_http_status(
        wsi, fits ? 503 : 403, fits ? "too many pages" : "Host and Origin are not of this page");
    return -1;
}

static int on_page(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    viewer *v = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        return admit(wsi, web_of(wsi));
    case LWS_CALLBACK_ESTABLISHED:
        viewer_open(web_of(wsi), v, wsi);
        return 0;
    case LWS_CALLBACK_RECEIVE:
        return viewer_receive(v, in, size, lws_is_final_fragment(wsi) && !lws_remaining_packet_payload(wsi));
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return viewer_write(v);
    case LWS_CALLBACK_CLOSED:
        viewer_close(v);
        return 0;
    default:
        return 0;
    }
}

static int on_foxglove(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    foxview *v = user;
    switch (reason) {
    case LWS_CALLBACK_FILTER_PROTOCOL_CONNECTION:
        if (foxview_may(wsi, web_of(wsi))) return admit(wsi, web_of(wsi));
        (void)lws_return_http_status(wsi, 403, "the token is the last part of the path: /foxglove/TOKEN");
        return -1;
    case LWS_CALLBACK_ESTABLISHED:
        foxview_open(web_of(wsi), v, wsi);
        return 0;
    case LWS_CALLBACK_RECEIVE:
        return foxview_receive(
            v, in, size, lws_is_final_fragment(wsi) && !lws_remaining_packet_payload(wsi), lws_frame_is_binary(wsi));
    case LWS_CALLBACK_SERVER_WRITEABLE:
        return foxview_write(v);
    case LWS_CALLBACK_CLOSED:
        foxview_close(v);
        return 0;
    default:
        return 0;
    }
}

/* The client library's descriptor, in the same loop. */
static int on_daemon(struct lws *wsi, enum lws_callback_reasons reason, void *user, void *in, size_t size)
{
    (void)user;
    (void)in;
    (void)size;
    if (reason == LWS_CALLBACK_RAW_RX_FILE && web_of(wsi)->client) feed_poll(web_of(wsi));
    return 0;
}

static const struct lws_protocols PROTOCOLS[] = {
    {"http", on_http, sizeof(getting), 0, 0, NULL, 0},
    {"collided.web.v1", on_page, sizeof(viewer), REQUEST_MAX, 0, NULL, 0},
    {"foxglove.sdk.v1", on_foxglove, sizeof(foxview), REQUEST_MAX, 0, NULL, 0},
    {"foxglove.websocket.v1", on_foxglove, sizeof(foxview), REQUEST_MAX, 0, NULL, 0},
    {"daemon", on_daemon, 0, 0, 0, NULL, 0},
    {NULL, NULL, 0, 0, 0, NULL, 0},
};

static const struct lws_http_mount MOUNT = {
    .mountpoint = "/", .mountpoint_len = 1, .origin_protocol = LWSMPRO_CALLBACK, .protocol = "http"};

/* ---- time ---- */

static void on_second(lws_sorted_usec_list_t *timer)
{
    web *w = lws_container_of(timer, web, second);
    feed_poll(w);
    viewer_second(w);
    lws_sul_schedule(w->context, 0, &w->second, on_second, LWS_US_PER_SEC);
}

static void on_signal(int number)
{
    (void)number;
    the_web->stop = true;
    lws_cancel_service(the_web->context);
}

/* ---- its life ---- */

/* What it needs when it runs: no new rights, no core files, no other programs. */
static void confine(void)
{
    const struct rlimit none = {0, 0};
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    prctl(PR_SET_DUMPABLE, 0, 0, 0, 0);
    (void)setrlimit(RLIMIT_CORE, &none);
    if (!the_web->options.file) (void)setrlimit(RLIMIT_NPROC, &none); /* a replay is begun anew to go back */
}

static int fail(int status, const char *format, const char *what)
{
    fprintf(stderr, "collided-web: ");
    fprintf(stderr, format, what); /* NOLINT(clang-diagnostic-format-nonliteral): ours */
    fprintf(stderr, "\n");
    return status;
}

static int open_client(web *w)
{
    collided_def def = collided_def_default();
    def.name = w->options.name;
    def.connect_timeout_s = 0;
    def.interface = w->options.interface;
    def.security = w->options.security;
    w->client = collided_connect(w->options.connect, &def);
    if (!w->client) return fail(EX_UNAVAILABLE, "%s", collided_connect_error());
    w->client_fd = dup(collided_fd(w->client));
    return w->client_fd >= 0 ? EX_OK : fail(EX_OSERR, "%s", strerror(errno));
}

static int open_server(web *w)
{
    struct lws_context_creation_info info = {.port = w->options.port,
        .iface = w->options.host,
        .protocols = PROTOCOLS,
        .mounts = &MOUNT,
        .user = w,
        .options = LWS_SERVER_OPTION_FAIL_UPON_UNABLE_TO_BIND | LWS_SERVER_OPTION_VALIDATE_UTF8,
        .server_string = "collided-web",
        .max_http_header_pool = 64,
        .keepalive_timeout = 30,
        .timeout_secs = 10,
        .uid = -1,
        .gid = -1};
    lws_set_log_level(LLL_ERR, NULL);
    w->context = lws_create_context(&info);
    if (!w->context)
        return fail(EX_UNAVAILABLE, "cannot listen at %s: is the port taken? --port chooses another", w->options.host);
    return web_watch(w) ? EX_OK : EX_SOFTWARE;
}

bool web_watch(web *w)
{
    const int fds[] = {w->client_fd, w->options.file ? w->replay_fd : -1};
    for (int i = 0; i < 2; i++) {
        lws_sock_file_fd_type fd = {.filefd = fds[i]};
        w->watched[i] = fds[i] < 0 ? NULL
                                   : lws_adopt_descriptor_vhost(lws_get_vhost_by_name(w->context, "default"),
                                         LWS_ADOPT_RAW_FILE_DESC, fd, "daemon", NULL);
        if (fds[i] >= 0 && !w->watched[i]) {
            fail(EX_SOFTWARE, "%s", "libwebsockets does not watch the daemon's descriptor");
            return false;
        }
    }
    return true;
}

/* Which closes them. */
void web_unwatch(web *w)
{
    for (int i = 0; i < 2; i++)
        if (w->watched[i]) lws_set_timeout(w->watched[i], PENDING_TIMEOUT_USER_OK, LWS_TO_KILL_ASYNC);
}

static void say_where(const web *w)
{
    bool six = strchr(w->options.host, ':') != NULL;
    printf("http://%s%s%s:%d/%s%s\n", six ? "[" : "", w->options.host, six ? "]" : "", w->options.port,
        *w->options.token ? "#t=" : "", w->options.token);
    fflush(stdout);
}

static int run(web *w)
{
    struct sigaction stop = {.sa_handler = on_signal};
    sigaction(SIGINT, &stop, NULL);
    sigaction(SIGTERM, &stop, NULL);
    signal(SIGPIPE, SIG_IGN); /* NOLINT(cert-err33-c) */
    lws_sul_schedule(w->context, 0, &w->second, on_second, LWS_US_PER_SEC);
    confine();
    say_where(w);
    while (!w->stop && lws_service(w->context, 0) >= 0) {
        recorded_tend(w);
        if (!w->stop) feed_poll(w);
    }
    return w->client ? EX_OK : EX_UNAVAILABLE;
}

static int serve(web *w)
{
    const char *root = *w->options.root ? w->options.root : getenv("COLLIDED_WEB_ROOT");
    w->site = site_read(root ? root : COLLIDED_WEB_INSTALLED);
    w->mirror = mirror_create();
    the_web = w;
    int status = w->options.file ? recorded_open(w) : open_client(w);
    if (status == EX_OK) status = open_server(w);
    if (status == EX_OK) status = run(w);
    if (w->context) lws_context_destroy(w->context);
    if (w->client) collided_close(w->client);
    recorded_close(w);
    mirror_destroy(w->mirror);
    triangles_free_all(&w->kept);
    site_free(w->site);
    frame_free(&w->scratch);
    frame_free(&w->shared);
    return status;
}

/* ---- the command line ---- */

static const char HELP[] =
    "usage: collided-web [OPTION]...\n"
    "Serves a page on which a browser sees the daemon's world live: bodies, contacts with their intervals and\n"
    "proofs, distances, predicted impacts. Prints the page's address, which holds the token, as its first line.\n\n"
    "  --connect URI        the daemon (dds://0)\n"
    "  --file FILE          a recording in place of a daemon: pages play, pause and seek it\n"
    "  --interface NAME     network interface towards the daemon (loopback)\n"
    "  --security FOLDER    DDS: certificate and permissions of this subscriber (COLLIDED_SECURITY)\n"
    "  --name NAME          its name for the daemon (collided-web)\n"
    "  --port N             where to serve (9465)\n"
    "  --host ADDRESS       at this address of the machine (127.0.0.1)\n"
    "  --token-file FILE    32 hexadecimal digits, kept there; made if there is no such file (a new one each time)\n"
    "  --no-token           whoever is on this machine may look; on loopback only\n"
    "  --allow-host NAME    a further name under which the page is asked for; may be given 16 times\n"
    "  --allow-origin URL   a further page that may connect, as http://NAME:PORT; may be given 16 times\n"
    "  --rate HZ            states a second, at most (30)\n"
    "  --range M            pairs nearer than this are shown (0.5)\n"
    "  --horizon S          contacts are predicted so far ahead; 0 = not (1)\n"
    "  --tolerance M        asked width of the intervals (0.0001)\n"
    "  --root FOLDER        the built page (COLLIDED_WEB_ROOT, else the installed one, else one that needs no build)\n"
    "  --help, --version\n\n"
    "Nothing is asked of the daemon while no page is open. Read-only. See collided-web(1).\n";

static bool to_number(const char *text, double least, double most, double *to)
{
    char *end;
    double value = strtod(text, &end);
    bool fits = *text && !*end && isfinite(value) && value >= least && value <= most;
    if (fits) *to = value;
    return fits;
}

static bool is_token(const char *text)
{
    return strlen(text) == 32 && strspn(text, "0123456789abcdef") == 32;
}

static bool make_token(char token[33])
{
    unsigned char random[16];
    if (getrandom(random, sizeof random, 0) != sizeof random) return false;
    for (int i = 0; i < 16; i++) snprintf(token + 2 * i, 3, "%02x", random[i]);
    return true;
}

static int keep_token(const char *path, char token[33])
{
    char text[64] = "";
    int fd = open(path, O_RDONLY | O_CLOEXEC);
    if (fd >= 0) {
        ssize_t n = read(fd, text, sizeof text - 1);
        close(fd);
        text[n > 0 ? n : 0] = '\0';
        text[strcspn(text, "\n")] = '\0';
        if (!is_token(text)) return fail(EX_DATAERR, "%s: 32 hexadecimal digits (0-9, a-f) are a token", path);
        snprintf(token, 33, "%s", text);
        return EX_OK;
    }
    if (errno != ENOENT) return fail(EX_NOINPUT, "%s: cannot be read", path);
    fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    bool kept = fd >= 0 && dprintf(fd, "%s\n", token) == 33;
    if (fd >= 0) close(fd);
    return kept ? EX_OK : fail(EX_CANTCREAT, "%s: cannot be written", path);
}

static bool is_loopback(const char *host)
{
    return strncmp(host, "127.", 4) == 0 || strcmp(host, "::1") == 0 || strcmp(host, "localhost") == 0;
}

typedef struct parsed {
    const char *token_file;
    bool no_token;
} parsed;

static bool add_name(const char **list, size_t *count, const char *name)
{
    if (*count == WEB_HOSTS) return false;
    list[(*count)++] = name;
    return true;
}

/* False: its value is not possible. */
static bool take_option(web_options *o, parsed *p, int which, const char *value)
{
    double port;
    switch (which) {
    case 'c':
        o->connect = value;
        return true;
    case 'f':
        o->file = value;
        return true;
    case 'i':
        o->interface = value;
        return true;
    case 's':
        o->security = value;
        return true;
    case 'n':
        o->name = value;
        return true;
    case 'H':
        o->host = value;
        return true;
    case 'r':
        o->root = value;
        return true;
    case 't':
        p->token_file = value;
        return true;
    case 'T':
        p->no_token = true;
        return true;
    case 'a':
        return add_name(o->hosts, &o->host_count, value);
    case 'o':
        return add_name(o->origins, &o->origin_count, value);
    case 'R':
        return to_number(value, 0.1, 240, &o->rate_hz);
    case 'g':
        return to_number(value, 0, 1e9, &o->range_m);
    case 'z':
        return to_number(value, 0, 86400, &o->horizon_s);
    case 'w':
        return to_number(value, 0, 1e9, &o->tolerance_m);
    case 'p':
        if (!to_number(value, 1, 65535, &port) || port != floor(port)) return false;
        o->port = (int)port;
        return true;
    default:
        return false;
    }
}

int main(int argc, char **argv)
{
    static const struct option OPTIONS[] = {{"connect", 1, NULL, 'c'}, {"file", 1, NULL, 'f'},
        {"interface", 1, NULL, 'i'}, {"security", 1, NULL, 's'}, {"name", 1, NULL, 'n'}, {"port", 1, NULL, 'p'},
        {"host", 1, NULL, 'H'}, {"token-file", 1, NULL, 't'}, {"no-token", 0, NULL, 'T'}, {"allow-host", 1, NULL, 'a'},
        {"allow-origin", 1, NULL, 'o'}, {"rate", 1, NULL, 'R'}, {"range", 1, NULL, 'g'}, {"horizon", 1, NULL, 'z'},
        {"tolerance", 1, NULL, 'w'}, {"root", 1, NULL, 'r'}, {"help", 0, NULL, 'h'}, {"version", 0, NULL, 'v'},
        {NULL, 0, NULL, 0}};
    web *w = web_allocate(1, sizeof *w);
    parsed p = {NULL, false};
    web_options *o = &w->options;
    *o = (web_options){.connect = "dds://0",
        .host = "127.0.0.1",
        .root = "",
        .name = "collided-web",
        .port = 9465,
        .rate_hz = 30,
        .range_m = 0.5,
        .horizon_s = 1,
        .tolerance_m = 1e-4};
    int status = EX_OK, which, index = 0;
    while (status == EX_OK && (which = getopt_long(argc, argv, "", OPTIONS, &index)) != -1) {
        if (which == 'h' || which == 'v') {
            printf("%s%s", which == 'h' ? HELP : collided_version(), which == 'h' ? "" : "\n");
            free(w);
            return EX_OK;
        }
        if (which == '?')
            status = fail(EX_USAGE, "%s", "see collided-web --help");
        else if (!take_option(o, &p, which, optarg))
            status = fail(EX_USAGE, "--%s: this is not possible", OPTIONS[index].name);
    }
    if (status == EX_OK && optind < argc) status = fail(EX_USAGE, "%s: there are options only", argv[optind]);
    if (status == EX_OK && p.no_token && !is_loopback(o->host))
        status = fail(EX_USAGE, "--no-token: at %s, everybody on the network would see all", o->host);
    if (status == EX_OK && !p.no_token && !make_token(o->token)) status = fail(EX_OSERR, "%s", strerror(errno));
    if (status == EX_OK && p.token_file && !p.no_token) status = keep_token(p.token_file, o->token);
    if (status == EX_OK && !is_loopback(o->host)) (void)add_name(o->hosts, &o->host_count, o->host);
    if (status == EX_OK) status = serve(w);
    free(w);
    return status;
}
