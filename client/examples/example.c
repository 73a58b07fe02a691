/* example: options, clock, signals and lines. One thread. */
#include "example.h"

#include <math.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>
#include <time.h>

static const int64_t NS_PER_S = 1000000000;
static volatile sig_atomic_t signalled;

static void on_signal(int number)
{
    (void)number;
    signalled = 1;
}

static int64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return t.tv_sec * NS_PER_S + t.tv_nsec;
}

int64_t example_now_ns(void)
{
    return clock_ns(CLOCK_MONOTONIC);
}

static void usage(const char *program)
{
    fprintf(stderr,
        "usage: %s [--connect dds://DOMAIN|lcm://...] [--interface NAME] [--seconds N] [--json]\n"
        "Without --connect: dds://0. Without --interface: this machine only. Without --seconds: until Ctrl-C.\n",
        program);
    exit(EX_USAGE);
}

example example_start(int argc, char **argv)
{
    example e = {.program = argv[0], .connect = "dds://0", .end_ns = INT64_MAX};
    for (int i = 1; i < argc; i++) {
        const char *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(argv[i], "--json") == 0) {
            e.json = true;
            continue;
        }
        char *rest = NULL;
        double seconds = value ? strtod(value, &rest) : 0;
        if (value && strcmp(argv[i], "--connect") == 0)
            e.connect = value;
        else if (value && strcmp(argv[i], "--interface") == 0)
            e.interface = value;
        else if (value && strcmp(argv[i], "--seconds") == 0 && !*rest && seconds > 0 && seconds < 1e6)
            e.end_ns = example_now_ns() + (int64_t)(seconds * 1e9);
        else
            usage(argv[0]);
        i++;
    }
    e.link = strncmp(e.connect, "lcm", 3) == 0 ? "lcm" : "dds";
    struct sigaction action = {.sa_handler = on_signal, .sa_flags = (int)SA_RESETHAND}; /* a second one ends at once */
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    setvbuf(stdout, NULL, _IOFBF, 4096); /* PIPE_BUF: a line that is flushed as a whole is written as a whole */
    return e;
}

static void on_rejected(void *context, const collided_rejection *why)
{
    const example *e = context;
    fprintf(stderr, "%s: the daemon refused %s %d: %s: %s\n", e->program, why->message, (int)why->object, why->reason,
        why->text);
}

collided *example_connect(const example *e, const collided_def *def)
{
    collided_def own = def ? *def : collided_def_default();
    if (e->interface) own.interface = e->interface;
    collided *c = collided_connect(e->connect, &own);
    if (c)
        collided_on_rejected(c, on_rejected, (void *)e);
    else
        fprintf(stderr, "%s: %s\nIs the daemon running there? Start it by: collided --links %s\n", e->program,
            collided_connect_error(), e->connect);
    return c;
}

bool example_ok(const collided *c, collided_status status, const char *what)
{
    if (status == COLLIDED_OK) return true;
    fprintf(stderr, "%s: %s: %s\n", what, collided_status_text(status), collided_error(c));
    return false;
}

bool example_running(const example *e)
{
    return !signalled && example_now_ns() < e->end_ns;
}

collided_status example_poll_until(collided *c, int64_t when_ns)
{
    collided_status status;
    int64_t left_ns;
    do {
        left_ns = when_ns - example_now_ns();
        status = collided_poll(c, left_ns > 0 ? (double)left_ns * 1e-9 : 0);
    } while (left_ns > 0 && !signalled);
    return status;
}

/* ---- lines ---- */

void example_json_text(const char *text)
{
    putchar('"');
    for (; *text; text++) {
        unsigned char c = (unsigned char)*text;
        if (c == '"' || c == '\\')
            printf("\\%c", c);
        else if (c < ' ' || c == 127)
            printf("\\u%04x", c);
        else
            putchar(c);
    }
    putchar('"');
}

void example_json_number(double value)
{
    if (isfinite(value))
        printf("%.9g", value);
    else
        fputs("null", stdout);
}

static void json_line(const example *e, double stamp_s, const char *event, const char *a, const char *b, double lo,
    double hi, double age_s)
{
    const struct {
        const char *key;
        double value;
    } numbers[] = {{"lo", lo}, {"hi", hi}, {"age_s", age_s}};
    printf("{\"event\":\"%s\",\"link\":\"%s\",\"time\":%.3f,\"a\":", event, e->link, stamp_s);
    example_json_text(a);
    fputs(",\"b\":", stdout);
    example_json_text(b);
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
        printf(",\"%s\":", numbers[i].key);
        example_json_number(numbers[i].value);
    }
    puts("}");
}

static void print_clock(int64_t stamp_ns)
{
    time_t seconds = (time_t)(stamp_ns / NS_PER_S);
    struct tm t;
    localtime_r(&seconds, &t);
    printf("%02d:%02d:%02d.%03d  ", t.tm_hour, t.tm_min, t.tm_sec, (int)(stamp_ns / 1000000 % 1000));
}

void example_line(const example *e, const char *event, const char *a, const char *b, double lo, double hi, double age_s)
{
    int64_t stamp_ns = clock_ns(CLOCK_REALTIME);
    if (e->json) {
        json_line(e, (double)stamp_ns * 1e-9, event, a, b, lo, hi, age_s);
    } else {
        print_clock(stamp_ns);
        printf("%-7s %-15s %-15s ", event, a, b);
        if (isfinite(lo) && isfinite(hi))
            printf("%9.3f .. %9.3f mm", 1e3 * lo, 1e3 * hi);
        else
            printf("%25s", "unknown");
        if (age_s >= 0) printf("   age %5.1f ms", 1e3 * age_s);
        putchar('\n');
    }
    fflush(stdout);
}

void example_note(const example *e, const char *format, ...)
{
    if (e->json) return;
    va_list arguments;
    va_start(arguments, format);
    print_clock(clock_ns(CLOCK_REALTIME));
    vprintf(format, arguments);
    va_end(arguments);
    putchar('\n');
    fflush(stdout);
}
