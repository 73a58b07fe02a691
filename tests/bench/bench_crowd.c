/* bench_crowd: a crowd of clients at one daemon, and one more that subscribes to everything they do. In one half of the
 * time it reads, in the other it does not, in turns; what is measured is the others' time from a pose to the event that
 * follows from it.
 *
 * Each client has a cube that touches one beside it, and publishes a pose of it at 2 Hz, and awaits the batch with its
 * step. They live in a few processes, each of which lets its clients take turns. */
#include "bench.h"

#include <collided.h>
#include <inttypes.h>
#include <math.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { CLIENTS = 200, PROCESSES = 10, EACH_MAX = CLIENTS / PROCESSES, TURNS_MAX = 64, ROUNDS_MAX = 400000 };
enum { DOMAIN_FIRST = 150, DOMAINS = 79, SHARED_FD = 40 };
static const int64_t PATIENCE_NS = 2000000000, PERIOD_NS = 500000000;

typedef enum phase { GATHERING, PAUSE, ALL_READ, ONE_DEAF, OVER, PHASES } phase;

typedef struct shared {
    _Atomic int phase, deaf, gathered, failed;
    _Atomic int64_t missed[PHASES], lost;
    _Atomic int64_t next[PHASES]; /* of the samples */
    int64_t ns[PHASES][ROUNDS_MAX];
} shared;

typedef struct one {
    collided *client;
    collided_body body;
    double x;
    int64_t step, heard;
} one;

static shared *map(void)
{
    shared *s = mmap(NULL, sizeof *s, PROT_READ | PROT_WRITE, MAP_SHARED, SHARED_FD, 0);
    return s == MAP_FAILED ? NULL : s;
}

/* ---- a client ---- */

static void on_batch(void *context, const collided_batch *b)
{
    one *o = context;
    if (b->step > o->heard) o->heard = b->step;
}

static bool connect_one(one *o, const char *uri, int number)
{
    char name[32];
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    collided_subscription_def watch = collided_subscription_def_default();
    collided_def who = collided_def_default();
    who.lease_s = 20; /* whoever waits for his turn polls rarely */
    who.connect_timeout_s = 60;
    o->client = collided_connect(uri, &who);
    if (!o->client) return fprintf(stderr, "%s: %s\n", uri, collided_connect_error()), false;
    o->x = 4 * number;
    def.shapes = &cube;
    def.shape_count = 1;
    def.name = name;
    for (int i = 0; i < 2; i++) {
        snprintf(name, sizeof name, i ? "mover %d" : "beside %d", number);
        def.pose.position[0] = o->x;
        def.pose.position[1] = i ? 0.9 : 0;
        o->body = collided_create_body(o->client, &def);
    }
    watch.select_a = name;
    watch.callback = on_batch;
    watch.context = o;
    if (collided_subscribe(o->client, &watch).id != COLLIDED_NONE && collided_sync(o->client, 30) == COLLIDED_OK)
        return true;
    return fprintf(stderr, "%s: %s\n", uri, collided_error(o->client)), false;
}

/* ns, or -1: no event came. */
static int64_t round_ns(one *o)
{
    o->step++;
    const double position[3] = {o->x, 0.9 + (o->step % 2 ? 0.02 : -0.02), 0}, orientation[4] = {1, 0, 0, 0};
    int64_t began = bench_now_ns(), end = began + PATIENCE_NS;
    collided_publish(o->client, 1, &o->body, position, orientation, NULL, NULL, 0, o->step);
    while (o->heard < o->step) {
        int64_t left = end - bench_now_ns();
        if (left <= 0) return -1;
        collided_poll(o->client, 1e-9 * (double)left);
    }
    return bench_now_ns() - began;
}

static void measure(shared *s, one *o)
{
    int before = s->phase;
    int64_t took = round_ns(o);
    if (took < 0) s->missed[before]++;
    if (took < 0 || s->phase != before || before >= OVER) return;
    int64_t index = s->next[before]++;
    if (index < ROUNDS_MAX) s->ns[before][index] = took;
}

static int be_some(const char *uri, int process, int each)
{
    static one clients[EACH_MAX];
    shared *s = map();
    if (!s) return 2;
    for (int i = 0; i < each; i++) {
        if (!connect_one(&clients[i], uri, process * each + i)) return s->failed = 1;
        s->gathered++;
    }
    for (int i = 0; s->phase != OVER; i = (i + 1) % each) {
        int64_t next = bench_now_ns() + PERIOD_NS / each;
        if (s->phase != GATHERING) measure(s, &clients[i]);
        bench_sleep_until(next);
    }
    for (int i = 0; i < each; i++) collided_close(clients[i].client);
    return 0;
}

/* ---- the one ---- */

static void on_any(void *context, const collided_batch *b)
{
    shared *s = context;
    s->lost += b->lost;
}

static int be_deaf(const char *uri)
{
    shared *s = map();
    collided_def who = collided_def_default();
    collided_subscription_def all = collided_subscription_def_default();
    who.connect_timeout_s = 60;
    who.lease_s = 20;
    collided *c = s ? collided_connect(uri, &who) : NULL;
    if (!c) return fprintf(stderr, "%s: %s\n", uri, collided_connect_error()), 1;
    all.callback = on_any;
    all.context = s;
    collided_subscribe(c, &all);
    collided_sync(c, 30);
    s->gathered++;
    while (s->phase != OVER) {
        if (s->deaf)
            usleep(10000);
        else
            collided_poll(c, 0.05);
    }
    collided_close(c);
    return 0;
}

/* ---- all ---- */

static pid_t start(const char *role, const char *uri, int number, int each)
{
    char a[16], b[16];
    snprintf(a, sizeof a, "%d", number);
    snprintf(b, sizeof b, "%d", each);
    return bench_start("/proc/self/exe", (const char *const[]){"crowd", role, uri, a, b, NULL});
}

static void pause_s(double seconds)
{
    bench_sleep_until(bench_now_ns() + (int64_t)(1e9 * seconds));
}

static bool gather(shared *s, int expected)
{
    int64_t began = bench_now_ns(), end = began + INT64_C(120000000000);
    while (s->gathered < expected && !s->failed && bench_now_ns() < end) pause_s(0.05);
    if (s->gathered == expected)
        fprintf(stderr, "all are there after %.1f s\n", 1e-9 * (double)(bench_now_ns() - began));
    return s->gathered == expected;
}

/* The first second of a turn belongs to what the one before has left. */
static void take_turns(shared *s, double seconds)
{
    int turns = seconds < 4 ? 2 : 8;
    for (int i = 0; i < turns; i++) {
        s->deaf = (i + 1) / 2 % 2; /* each as often after the other as after itself */
        s->phase = PAUSE;
        pause_s(seconds < 4 ? 0.2 : 1);
        s->phase = s->deaf ? ONE_DEAF : ALL_READ;
        pause_s(2 * seconds / turns);
    }
    s->phase = PAUSE;
}

static void print(shared *s, const char *link, int clients, const bench_options *o)
{
    double p50[PHASES], p99[PHASES];
    for (int k = ALL_READ; k <= ONE_DEAF; k++) {
        size_t count = (size_t)(s->next[k] < ROUNDS_MAX ? s->next[k] : ROUNDS_MAX);
        bench_samples samples = {.at_ns = s->ns[k], .count = count, .capacity = ROUNDS_MAX};
        p50[k] = bench_percentile_us(&samples, 0.5);
        p99[k] = bench_percentile_us(&samples, 0.99);
    }
    if (!o->json)
        printf("%-4s %7s | %-16s | %8s %8s | %6s | %7s %6s\n", "link", "clients", "", "p50 us", "p99 us", "p99 x",
            "rounds", "missed");
    for (int k = ALL_READ; k <= ONE_DEAF; k++) {
        const char *who = k == ALL_READ ? "all read" : "one never reads";
        double ratio = p99[k] / p99[ALL_READ];
        printf(o->json ? "{\"bench\":\"crowd\",\"entry\":\"the daemon, by its client "
                         "library\",\"link\":\"%s\",\"clients\":%d,\"contender\":\"%s\",\"us_p50\":%.1f,"
                         "\"us_p99\":%.1f,\"ratio_p99\":%.3f,\"rounds\":%" PRId64 ",\"missed\":%" PRId64 "}\n"
                       : "%-4s %7d | %-16s | %8.1f %8.1f | %6.2f | %7" PRId64 " %6" PRId64 "\n",
            link, clients, who, p50[k], p99[k], ratio, (int64_t)s->next[k], (int64_t)s->missed[k]);
    }
    fflush(stdout);
}

static bool run(shared *s, const char *link, const char *uri, int clients, const bench_options *o)
{
    pid_t pids[PROCESSES + 1] = {0};
    int processes = clients < PROCESSES ? clients : PROCESSES, each = clients / processes;
    memset(s, 0, sizeof *s);
    const char *const arguments[] = {"collided", "--links", uri, "--log", "warning", "--workers", "1", NULL};
    pid_t daemon = bench_start(COLLIDED, arguments);
    for (int i = 0; i < processes; i++) pids[i] = start("--some", uri, i, each);
    pids[PROCESSES] = start("--deaf", uri, 0, 0);
    bool done = gather(s, processes * each + 1);
    if (done) {
        take_turns(s, o->seconds);
        print(s, link, processes * each, o);
    } else {
        fprintf(stderr, "%s: %d of %d clients came\n", link, (int)s->gathered, processes * each + 1);
    }
    s->phase = OVER;
    s->deaf = 0;
    for (int i = 0; i <= PROCESSES; i++) bench_end(pids[i]);
    bench_end(daemon);
    return done && s->next[ALL_READ] && s->next[ONE_DEAF];
}

int main(int argc, char **argv)
{
    bench_options o;
    if (argc == 5 && strcmp(argv[1], "--some") == 0)
        return be_some(argv[2], (int)strtol(argv[3], NULL, 10), (int)strtol(argv[4], NULL, 10));
    if (argc == 5 && strcmp(argv[1], "--deaf") == 0) return be_deaf(argv[2]);
    if (!bench_parse(argc, argv, 20, 120, &o)) return EXIT_FAILURE;
    char uri[32];
    bench_isolate();
    snprintf(uri, sizeof uri, "dds://%d", DOMAIN_FIRST + (int)getpid() % DOMAINS);
    int fd = memfd_create("crowd", 0);
    if (fd < 0 || ftruncate(fd, sizeof(shared)) != 0 || dup2(fd, SHARED_FD) < 0) return EXIT_FAILURE;
    close(fd);
    shared *s = map();
    if (!s) return EXIT_FAILURE;
    int clients = o.bodies ? (int)o.bodies : CLIENTS;
    return run(s, "dds", uri, clients < CLIENTS ? clients : CLIENTS, &o) ? EXIT_SUCCESS : EXIT_FAILURE;
}
