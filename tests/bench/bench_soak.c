/* bench_soak: does the daemon's memory stay level? Events without end through one daemon: bodies that touch move in
 * every tick; now and then some part and meet again, some are removed and put back, the subscription is asked for anew,
 * and a client comes, subscribes and is killed (in long runs). Its resident memory is read a hundred times on the way.
 *
 * --full: 10^7 events. --plot FILE: FILE.svg and FILE.png. --events N: so many instead. The exit status is 1 if the
 * memory of the last half grew by more than GROWTH_KB (see there). */
#include "bench.h"

#include <collided.h>
#include <inttypes.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PAIRS = 500, SAMPLES = 100, DOMAIN_FIRST = 150, DOMAINS = 79, VISIT_TICKS = 500 };
enum {
    GROWTH_KB = 1024,
    GROWTH_SHORT_KB = 8192
}; /* what is allocated in a steady world is nothing; visitors leave holes */
static const int64_t EVENTS = 1000000, EVENTS_FULL = 10000000;
/* What DDS keeps for a client that was killed, until its lease is over, comes to tens of MiB here, and takes longer
 * than a short run to find its level: that has no visitors. */
static const int64_t VISITED_EVENTS = 5000000;

typedef struct soak {
    collided *client;
    collided_subscription watch;
    collided_body bodies[PAIRS];
    double positions[3 * PAIRS], orientations[4 * PAIRS];
    int64_t step, heard, events, lost, begins, ends;
    pid_t daemon, visitor;
    bool visited;
} soak;

typedef struct sample {
    int64_t events;
    long resident_kb;
} sample;

static long resident_kb(pid_t pid)
{
    char path[64];
    long pages = -1;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)pid);
    FILE *f = fopen(path, "r");
    if (!f) return -1;
    if (fscanf(f, "%*s %ld", &pages) != 1) pages = -1; /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

static void on_batch(void *context, const collided_batch *b)
{
    soak *s = context;
    if (b->step > s->heard) s->heard = b->step;
    s->lost += b->lost;
    s->events += (int64_t)b->event_count;
    for (size_t i = 0; i < b->event_count; i++) {
        s->begins += b->events[i].kind == COLLIDED_BEGIN;
        s->ends += b->events[i].kind == COLLIDED_END;
    }
}

static void subscribe(soak *s)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.callback = on_batch;
    def.context = s;
    s->watch = collided_subscribe(s->client, &def);
}

static void put(soak *s, int i, bool fixed)
{
    char name[32];
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    snprintf(name, sizeof name, fixed ? "table %d" : "part %d", i);
    def.name = name;
    def.shapes = &cube;
    def.shape_count = 1;
    def.motion = fixed ? COLLIDED_FIXED : COLLIDED_MOVING;
    def.pose.position[0] = 4 * i;
    def.pose.position[1] = fixed ? 0 : 0.9;
    collided_body body = collided_create_body(s->client, &def);
    if (!fixed) s->bodies[i] = body;
}

static bool open_soak(soak *s, const char *uri)
{
    s->client = collided_connect(uri, NULL);
    if (!s->client) return fprintf(stderr, "%s: %s\n", uri, collided_connect_error()), false;
    for (int i = 0; i < PAIRS; i++) {
        put(s, i, true);
        put(s, i, false);
    }
    subscribe(s);
    if (collided_sync(s->client, 30) == COLLIDED_OK) return true;
    return fprintf(stderr, "%s: %s\n", uri, collided_error(s->client)), false;
}

/* One in fifty is away for a tick, each in its turn. */
static bool tick(soak *s)
{
    s->step++;
    for (int i = 0; i < PAIRS; i++) {
        bool away = (i + s->step) % 50 == 0;
        s->positions[3 * i] = 4 * i;
        s->positions[3 * i + 1] = away ? 2 : 0.9 + 1e-4 * (double)((s->step + i) % 100);
        s->orientations[4 * i] = 1;
    }
    collided_publish(s->client, PAIRS, s->bodies, s->positions, s->orientations, NULL, NULL, 0, s->step);
    for (int64_t end = bench_now_ns() + INT64_C(5000000000); s->heard < s->step;) {
        if (bench_now_ns() > end) return fprintf(stderr, "step %" PRId64 " is not told of\n", s->step), false;
        collided_poll(s->client, 1);
    }
    return true;
}

/* The visitor of before is killed: its end is noticed by its liveliness. */
static void visit(soak *s, const char *uri)
{
    int i = (int)(s->step % PAIRS);
    collided_remove_body(s->client, s->bodies[i]);
    put(s, i, false);
    if (s->step % (4 * VISIT_TICKS) == 0) {
        collided_unsubscribe(s->client, s->watch);
        subscribe(s);
    }
    collided_sync(s->client, 10);
    if (!s->visited) return;
    if (s->visitor > 0) {
        kill(s->visitor, SIGKILL);
        waitpid(s->visitor, NULL, 0);
    }
    s->visitor = bench_start("/proc/self/exe", (const char *const[]){"soak", "--visitor", uri, NULL});
}

static int be_visitor(const char *uri)
{
    soak s = {.client = collided_connect(uri, NULL)};
    if (!s.client) return 1;
    subscribe(&s);
    for (;;) collided_poll(s.client, 1);
}

static bool run(soak *s, const char *uri, int64_t events, sample *out)
{
    for (int i = 0; i < SAMPLES; i++) {
        while (s->events < events * (i + 1) / SAMPLES) {
            if (!tick(s)) return false;
            if (s->step % VISIT_TICKS == 0) visit(s, uri);
        }
        out[i] = (sample){s->events, resident_kb(s->daemon)};
    }
    return true;
}

/* ---- telling ---- */

static bool plot(const char *path, const char *terminal, const sample *at)
{
    FILE *f = popen("gnuplot", "w"); /* NOLINT(cert-env33-c): a fixed line */
    if (!f) return false;
    fprintf(f,
        "set terminal %s\nset output '%s.%s'\nset xlabel 'events told, millions'\nset ylabel 'resident memory, MiB'\n"
        "set yrange [0:]\nset grid\nset key off\nset title 'The daemon: %d contacts, %.1f million events'\n"
        "plot '-' using 1:2 with lines linewidth 2\n",
        terminal, path, strncmp(terminal, "svg", 3) == 0 ? "svg" : "png", PAIRS, 1e-6 * (double)at[SAMPLES - 1].events);
    for (int i = 0; i < SAMPLES; i++)
        fprintf(f, "%g %g\n", 1e-6 * (double)at[i].events, (double)at[i].resident_kb / 1024);
    fprintf(f, "e\n");
    return pclose(f) == 0;
}

static long growth_kb(const sample *at)
{
    return at[SAMPLES - 1].resident_kb - at[SAMPLES / 2 - 1].resident_kb;
}

static void print(const soak *s, const sample *at, double seconds, bool json)
{
    if (!json) printf("%10s %12s\n", "events", "resident KiB");
    for (int i = SAMPLES / 10 - 1; i < SAMPLES; i += SAMPLES / 10)
        printf(json ? "{\"bench\":\"soak\",\"entry\":\"the daemon, by its client "
                      "library\",\"link\":\"dds\",\"events\":%" PRId64 ",\"resident_kib\":%ld}\n"
                    : "%10" PRId64 " %12ld\n",
            at[i].events, at[i].resident_kb);
    if (!json)
        printf("the last half grew by %ld KiB; %" PRId64 " begins, %" PRId64 " ends, %" PRId64
               " batches lost; %.0f s, %.0f events a second\n",
            growth_kb(at), s->begins, s->ends, s->lost, seconds, (double)s->events / seconds);
}

/* "--name VALUE" is taken out of the arguments. */
static const char *take(int *argc, char **argv, const char *name)
{
    for (int i = 1; i + 1 < *argc; i++) {
        if (strcmp(argv[i], name) != 0) continue;
        const char *value = argv[i + 1];
        for (int k = i; k + 2 <= *argc; k++) argv[k] = argv[k + 2];
        *argc -= 2;
        return value;
    }
    return NULL;
}

int main(int argc, char **argv)
{
    static soak s;
    sample at[SAMPLES];
    bench_options o;
    char uri[32];
    if (argc == 3 && strcmp(argv[1], "--visitor") == 0) return be_visitor(argv[2]);
    const char *picture = take(&argc, argv, "--plot"), *told = take(&argc, argv, "--events");
    if (!bench_parse(argc, argv, 1, 2, &o)) return EXIT_FAILURE;
    int64_t events = told ? strtoll(told, NULL, 10) : o.seconds > 1 ? EVENTS_FULL : EVENTS;
    bench_isolate();
    snprintf(uri, sizeof uri, "dds://%d", DOMAIN_FIRST + (int)getpid() % DOMAINS);
    s.daemon = bench_start(
        COLLIDED, (const char *const[]){"collided", "--links", uri, "--log", "warning", "--workers", "1", NULL});
    s.visited = events >= VISITED_EVENTS;
    int64_t began = bench_now_ns();
    bool done = open_soak(&s, uri) && run(&s, uri, events, at);
    double seconds = 1e-9 * (double)(bench_now_ns() - began);
    if (s.visitor > 0) kill(s.visitor, SIGKILL);
    if (s.client) collided_close(s.client);
    bench_end(s.daemon);
    if (!done) return EXIT_FAILURE;
    print(&s, at, seconds, o.json);
    if (picture && !(plot(picture, "svg size 800,500", at) && plot(picture, "pngcairo size 800,500", at)))
        return fprintf(stderr, "no picture %s: is gnuplot installed (package gnuplot-nox)?\n", picture), EXIT_FAILURE;
    if (growth_kb(at) <= (s.visited ? GROWTH_KB : GROWTH_SHORT_KB)) return EXIT_SUCCESS;
    fprintf(stderr, "memory is not level: the last half grew by %ld KiB\n", growth_kb(at));
    return EXIT_FAILURE;
}
