/* bench_clients: a crowd that comes at once. Each client is a process of its own that starts, connects over DDS,
 * creates a body, subscribes to its contacts, and is in when both are acknowledged and its stream has begun. What is
 * measured: the time from the start of the first process until the last is in (or until patience ends: "joined" says
 * how many are), the memory of a client's process when all are in (proportional set size, shared pages shared: the mean
 * over all), and the processor time and memory of the daemon until then.
 *
 * The processes run in a network namespace of their own, with the daemon that ships. `--bodies` chooses one number of
 * clients; `--full` adds 1,000. `--seconds` is the patience.
 */
#include "bench.h"

#include <collided.h>
#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

enum { CLIENTS_MAX = 4000, DOMAIN_FIRST = 0, DOMAINS = 79, SHARED_FD = 40, PATIENCE_S = 60, FULL_PATIENCE_S = 120 };

typedef struct shared {
    double patience_s;
    _Atomic int joined, failed, over;
    char complaint[256]; /* of the first that failed */
} shared;

static shared *map(void)
{
    shared *s = mmap(NULL, sizeof *s, PROT_READ | PROT_WRITE, MAP_SHARED, SHARED_FD, 0);
    return s == MAP_FAILED ? NULL : s;
}

/* ---- a client ---- */

static void on_batch(void *context, const collided_batch *b)
{
    (void)context;
    (void)b;
}

static int fail(shared *s, const char *what)
{
    if (s->failed++ == 0) snprintf(s->complaint, sizeof s->complaint, "%s", what);
    while (!s->over) usleep(100000); /* as one that keeps trying: it takes the place that it has */
    return 1;
}

static int be_client(const char *uri, int number)
{
    shared *s = map();
    if (!s) return 2;
    char name[32];
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    collided_subscription_def watch = collided_subscription_def_default();
    collided_def who = collided_def_default();
    snprintf(name, sizeof name, "client %d", number);
    who.connect_timeout_s = s->patience_s;
    collided *c = collided_connect(uri, &who);
    if (!c) return fail(s, collided_connect_error());
    def.shapes = &cube;
    def.shape_count = 1;
    def.name = watch.select_a = name;
    def.pose.position[0] = 4 * number;
    watch.callback = on_batch;
    bool in = collided_create_body(c, &def).id != COLLIDED_NONE && collided_subscribe(c, &watch).id != COLLIDED_NONE &&
              collided_sync(c, s->patience_s) == COLLIDED_OK;
    if (!in) return fail(s, collided_error(c));
    s->joined++;
    while (!s->over) collided_poll(c, 0.5);
    return 0; /* without a farewell: the daemon ends first */
}

/* ---- all ---- */

static double field_mb(pid_t pid, const char *file, const char *field)
{
    char path[64], line[128];
    double kib = 0;
    snprintf(path, sizeof path, "/proc/%d/%s", (int)pid, file);
    FILE *f = fopen(path, "r");
    while (f && fgets(line, sizeof line, f))
        if (strncmp(line, field, strlen(field)) == 0) kib = strtod(line + strlen(field), NULL);
    if (f) fclose(f);
    return kib * 1024 / 1e6;
}

static pid_t start_client(const char *uri, int number)
{
    char text[16];
    snprintf(text, sizeof text, "%d", number);
    return bench_start("/proc/self/exe", (const char *const[]){"clients", "--client", uri, text, NULL});
}

static pid_t start_daemon(const char *uri)
{
    return bench_start(COLLIDED, (const char *const[]){"collided", "--links", uri, "--log", "warning", NULL});
}

static bool daemon_speaks(const char *uri)
{
    collided_def who = collided_def_default();
    who.connect_timeout_s = 10;
    collided *c = collided_connect(uri, &who);
    if (!c) return fprintf(stderr, "%s: %s\n", uri, collided_connect_error()), false;
    collided_close(c);
    return true;
}

typedef struct figures {
    double seconds, client_mb, client_core_s; /* the latter two: of one, the mean */
    double daemon_core_s, daemon_mb;
} figures;

static void print(const shared *s, int clients, const figures *f, bool json)
{
    if (!json && s->complaint[0]) printf("the first of %d that failed: %s\n", s->failed, s->complaint);
    printf(
        json ? "{\"bench\":\"clients\",\"entry\":\"the daemon, by its client library\",\"link\":\"dds\",\"clients\":%d,"
               "\"joined\":%d,\"seconds\":%.3f,\"client_mb\":%.3f,\"client_core_s\":%.4f,"
               "\"daemon_core_s\":%.3f,\"daemon_mb\":%.3f}\n"
             : "%7d | %6d %8.2f s | %8.2f MB %7.4f s | %8.2f s %7.1f MB\n",
        clients, s->joined, f->seconds, f->client_mb, f->client_core_s, f->daemon_core_s, f->daemon_mb);
    fflush(stdout);
}

static bool run(shared *s, int clients, const bench_options *o)
{
    static int domain = -1;
    static pid_t pids[CLIENTS_MAX];
    char uri[32];
    if (domain < 0) domain = (int)getpid();
    snprintf(uri, sizeof uri, "dds://%d", DOMAIN_FIRST + domain++ % DOMAINS);
    memset(s, 0, sizeof *s);
    s->patience_s = o->seconds;
    pid_t daemon = start_daemon(uri);
    if (!daemon_speaks(uri)) return bench_end(daemon), false;
    double before_s = bench_cpu_s(daemon);
    int64_t began = bench_now_ns(), end = began + (int64_t)(1e9 * o->seconds);
    for (int i = 0; i < clients; i++) pids[i] = start_client(uri, i);
    while (s->joined + s->failed < clients && bench_now_ns() < end) bench_sleep_until(bench_now_ns() + 5000000);
    figures f = {.seconds = 1e-9 * (double)(bench_now_ns() - began), .daemon_core_s = bench_cpu_s(daemon) - before_s};
    f.daemon_mb = field_mb(daemon, "status", "VmRSS:");
    for (int i = 0; i < clients; i++) kill(pids[i], SIGSTOP); /* a thousand that run leave no time to look at them */
    for (int i = 0; i < clients; i++) {
        f.client_mb += field_mb(pids[i], "smaps_rollup", "Pss:") / clients;
        f.client_core_s += bench_cpu_s(pids[i]) / clients;
    }
    print(s, clients, &f, o->json);
    bool all = s->joined == clients;
    for (int i = 0; i < clients; i++) kill(pids[i], SIGKILL);
    kill(daemon, SIGKILL); /* it would wait for them */
    for (int i = 0; i < clients; i++) bench_end(pids[i]);
    bench_end(daemon);
    return all;
}

int main(int argc, char **argv)
{
    bench_options o;
    if (argc == 4 && strcmp(argv[1], "--client") == 0) return be_client(argv[2], (int)strtol(argv[3], NULL, 10));
    if (!bench_parse(argc, argv, PATIENCE_S, FULL_PATIENCE_S, &o)) return EXIT_FAILURE;
    if (!bench_isolate()) return EXIT_FAILURE;
    int fd = memfd_create("clients", 0);
    if (fd < 0 || ftruncate(fd, sizeof(shared)) != 0 || dup2(fd, SHARED_FD) < 0) return EXIT_FAILURE;
    close(fd);
    shared *s = map();
    if (!s || o.bodies > CLIENTS_MAX) return EXIT_FAILURE;
    const int rows[] = {50, 200, 1000};
    size_t count = o.seconds >= FULL_PATIENCE_S ? 3 : 2;
    bool all = true;
    if (!o.json) printf("clients | joined   all in after | a client: memory, cores | daemon: cores, memory\n");
    if (o.bodies) return run(s, (int)o.bodies, &o) ? EXIT_SUCCESS : EXIT_FAILURE;
    for (size_t i = 0; i < count; i++) all &= run(s, rows[i], &o);
    return all ? EXIT_SUCCESS : EXIT_FAILURE;
}
