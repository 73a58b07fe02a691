/* ctl: connecting, failing and waiting, the same way for all verbs. One thread; the signal handler only sets a flag. */
#include "ctl.h"

#include <limits.h>
#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <time.h>
#include <unistd.h>

static volatile sig_atomic_t interrupted;

int ctl_fail(int status, const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    for (char *t = text; *t; t++)
        if ((unsigned char)*t < ' ' || *t == 127) *t = '?';
    fprintf(stderr, "collidectl: %s\n", text);
    return status;
}

int ctl_fail_loading(ctl *c)
{
    return ctl_fail(EX_DATAERR, "%s", c->report.error);
}

static void on_rejected(void *context, const collided_rejection *why)
{
    ctl *c = context;
    if (!c->rejected[0])
        snprintf(
            c->rejected, sizeof c->rejected, "%s %d: %s: %s", why->message, (int)why->object, why->reason, why->text);
}

int ctl_connect_as(ctl *c, int64_t id, collided_on_loss on_loss)
{
    const char *uri = c->options.connect;
    if (strncmp(uri, "dds://", 6) != 0 && strncmp(uri, "lcm://", 6) != 0)
        return ctl_fail(EX_USAGE, "--connect '%s': must begin with dds:// or lcm://, for example dds://0", uri);
    collided_def def = collided_def_default();
    def.name = c->options.as;
    def.id = id;
    def.on_loss = on_loss;
    def.interface = c->options.interface;
    def.connect_timeout_s = c->options.timeout_s;
    c->client = collided_connect(uri, &def);
    if (!c->client)
        return ctl_fail(
            EX_UNAVAILABLE, "%s; start the daemon by 'collided', or give --connect URI", collided_connect_error());
    collided_on_rejected(c->client, on_rejected, c);
    return 0;
}

/* FNV-1a, made positive: the same name is the same client in every run. */
static int64_t id_of(const char *name)
{
    uint64_t hash = 14695981039346656037u;
    for (const char *parts[] = {"collidectl:", name}, **part = parts; part < parts + 2; part++)
        for (const char *t = *part; *t; t++) hash = (hash ^ (unsigned char)*t) * 1099511628211u;
    hash &= INT64_MAX;
    return hash ? (int64_t)hash : 1;
}

int ctl_connect_guest(ctl *c)
{
    return ctl_connect_as(c, 0, COLLIDED_REMOVE);
}
int ctl_connect_owner(ctl *c)
{
    return ctl_connect_as(c, id_of(c->options.as), COLLIDED_KEEP);
}

void ctl_disconnect(ctl *c)
{
    if (c->client) collided_close(c->client);
    c->client = NULL;
}

const char *ctl_find_daemon(ctl *c)
{
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    if (length <= 0) return "collided";
    self[length] = '\0';
    char *slash = strrchr(self, '/');
    if (!slash) return "collided";
    const char *beside = pool_format(&c->pool, "%.*s/collided", (int)(slash - self), self);
    return access(beside, X_OK) == 0 ? beside : "collided";
}

int ctl_check(ctl *c, collided_status status, const char *what)
{
    const char *why = c->client ? collided_error(c->client) : "";
    if (status == COLLIDED_REJECTED && c->rejected[0]) why = c->rejected;
    if (!*why) why = collided_status_text(status);
    switch (status) {
    case COLLIDED_OK:
        return 0;
    case COLLIDED_REJECTED:
        return ctl_fail(EX_DATAERR, "%s: the daemon refused: %s", what, why);
    case COLLIDED_TIMEOUT:
        return ctl_fail(EX_TEMPFAIL, "%s: no answer within %g s: give more by --timeout", what, c->options.timeout_s);
    case COLLIDED_NO_DAEMON:
        return ctl_fail(EX_UNAVAILABLE, "%s: the daemon is no longer heard: is it running?", what);
    case COLLIDED_TRANSPORT:
        return ctl_fail(EX_IOERR, "%s: %s", what, why);
    case COLLIDED_UNSUPPORTED:
        return ctl_fail(EX_UNAVAILABLE, "%s: this daemon cannot do that: %s", what, why);
    case COLLIDED_BAD_ARGUMENT:
    case COLLIDED_UNKNOWN_ID:
        break;
    }
    return ctl_fail(EX_DATAERR, "%s: %s", what, why);
}

static void on_signal(int number)
{
    (void)number;
    interrupted = 1;
}

void ctl_catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND}; /* a second one ends at once */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
}

bool ctl_interrupted(void)
{
    return interrupted != 0;
}

double ctl_now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

int ctl_poll(ctl *c, double seconds)
{
    enum { STEP_MS = 200 }; /* how soon a signal is seen */
    double end = seconds > 0 ? ctl_now_s() + seconds : INFINITY;
    bool heard = true;
    while (!ctl_interrupted() && ctl_now_s() < end) {
        collided_status status = collided_poll(c->client, fmin(STEP_MS / 1000.0, fmax(0, end - ctl_now_s())));
        if (status != COLLIDED_OK && status != COLLIDED_NO_DAEMON) return ctl_check(c, status, "watching");
        if (heard && status == COLLIDED_NO_DAEMON)
            fputs("collidectl: the daemon is not heard; waiting for it\n", stderr);
        heard = status == COLLIDED_OK;
    }
    return EX_OK;
}
