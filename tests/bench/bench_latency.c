/* bench_latency: from a pose to the event that follows from it, through the daemon, beside the same payload going to
 * and fro over the same transport alone (raw_ping.h for DDS, raw_lcm.h for LCM), a round of each in turn.
 *
 * The world: cubes of side 1 m on a grid of 4 m, all at rest, of which one stands close to cube_0, and a subscription
 * in cube_0's contacts. A round publishes a batch of the first `poses` bodies, each a little away from where it was,
 * and ends when the batch of events with its step is there: in the callback, as at the listener of the transport alone
 * (with LCM both are polled); "polled" is the same round until collided_poll has returned. Where there are two
 * processors, this process has one and all others have the other one: where threads are woken costs more than most of
 * what is measured, and must be the same for all. --security: over DDS alone, open, and in closed sites that sign and
 * that encrypt, made by script/make_site; DDS alone stays open. --standby: over DDS, one daemon, and a pair of them in
 * turn; the standby shares the processor of the active one. */
#include "bench.h"
#include "cubes.h"
#include "raw_lcm.h"
#include "raw_ping.h"

#include <collided.h>
#include <inttypes.h>
#include <math.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { DOMAIN_FIRST = 150, DOMAINS = 77 /* and three more after each */, WARM_UP = 200, ROUNDS_MAX = 200000 };
static const double SWAY_M = 0.02;
static const int64_t PATIENCE_NS = 2000000000;

typedef struct scene {
    collided *client;
    size_t world, poses;
    collided_body *bodies; /* the world's, and one beside cube_0 */
    double *positions, *orientations;
    int64_t step, heard_step, last_seen_ns, lost;
} scene;

typedef struct way { /* to the daemon */
    const char *name;
    const char *protect; /* as make_site takes it; NULL = no security */
    bool lcm, paired;
} way;

typedef struct row {
    const char *link;
    size_t world, poses, rounds, missed;
    int64_t on_arrival; /* ticks of the daemon without a hand-over */
    double us_p50, us_p99, polled_us_p50, polled_us_p99, raw_us_p50, raw_us_p99;
} row;

/* ---- processors ---- */

static void stay_on(int nth)
{
    static cpu_set_t allowed;
    cpu_set_t one;
    if (!CPU_COUNT(&allowed) && sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
    if (CPU_COUNT(&allowed) < 2) return;
    CPU_ZERO(&one);
    for (size_t i = 0; i < CPU_SETSIZE && !CPU_COUNT(&one); i++)
        if (CPU_ISSET(i, &allowed) && nth-- == 0) CPU_SET(i, &one);
    (void)sched_setaffinity(0, sizeof one, &one); /* as before, then */
}

static pid_t start_elsewhere(const char *path, const char *const *arguments)
{
    stay_on(1);
    pid_t pid = bench_start(path, arguments);
    stay_on(0);
    return pid;
}

/* ---- the scene ---- */

static void on_batch(void *context, const collided_batch *b)
{
    scene *s = context;
    s->lost += b->lost;
    if (b->step <= s->heard_step || !b->event_count) return;
    s->heard_step = b->step;
    s->last_seen_ns = bench_now_ns();
}

static bool scene_open(scene *s, const char *uri, const char *security, size_t world, size_t poses)
{
    collided_def def = collided_def_default();
    def.security = security;
    def.on_arrival = true;
    *s = (scene){.world = world, .poses = poses};
    s->bodies = calloc(world + 1, sizeof *s->bodies);
    s->positions = calloc(3 * poses, sizeof(double));
    s->orientations = calloc(4 * poses, sizeof(double));
    if (!s->bodies || !s->positions || !s->orientations) return false;
    for (size_t i = 0; i < poses; i++) s->orientations[4 * i] = 1;
    s->client = collided_connect(uri, &def);
    if (!s->client) {
        fprintf(stderr, "%s: %s\n", uri, collided_connect_error());
        return false;
    }
    collided_subscription_def watch = collided_subscription_def_default();
    watch.select_a = "cube_0";
    watch.callback = on_batch;
    watch.context = s;
    if (cubes_create(s->client, s->world, s->bodies) && collided_subscribe(s->client, &watch).id != COLLIDED_NONE &&
        collided_sync(s->client, 30) == COLLIDED_OK)
        return true;
    fprintf(stderr, "%s: %s\n", uri, collided_error(s->client));
    return false;
}

static void scene_close(scene *s)
{
    if (s->client) collided_close(s->client);
    free(s->bodies);
    free(s->positions);
    free(s->orientations);
}

/* ---- a row ---- */

typedef struct floor_of { /* the link's transport alone: one of the two */
    raw_ping *dds;
    raw_lcm *lcm;
} floor_of;

static int64_t floor_round_ns(const floor_of *f)
{
    return f->dds ? raw_round_ns(f->dds, PATIENCE_NS) : raw_lcm_round_ns(f->lcm, PATIENCE_NS);
}

/* ns until the callback and until collided_poll has returned; false: nothing came. */
static bool run_round(scene *s, int64_t *until_heard, int64_t *until_polled)
{
    s->step++;
    for (size_t i = 0; i < s->poses; i++)
        cubes_place(s->world, i, s->step % 2 ? SWAY_M : -SWAY_M, s->positions + 3 * i);
    int64_t began = bench_now_ns(), end = began + PATIENCE_NS;
    collided_publish(
        s->client, s->poses, s->bodies, s->positions, s->orientations, NULL, NULL, bench_wall_ns(), s->step);
    while (s->heard_step < s->step) {
        int64_t left = end - bench_now_ns();
        if (left <= 0) return false;
        collided_poll(s->client, 1e-9 * (double)left);
    }
    *until_heard = s->last_seen_ns - began;
    *until_polled = bench_now_ns() - began;
    return true;
}

static void summarise(bench_samples *s, double *us_p50, double *us_p99)
{
    *us_p50 = bench_percentile_us(s, 0.5);
    *us_p99 = bench_percentile_us(s, 0.99);
    bench_samples_free(s);
}

static bool measure(scene *s, const floor_of *raw, double seconds, row *out)
{
    bench_samples heard, polled, alone;
    if (!bench_samples_init(&heard, ROUNDS_MAX) || !bench_samples_init(&polled, ROUNDS_MAX) ||
        !bench_samples_init(&alone, ROUNDS_MAX))
        return false;
    int64_t end = INT64_MAX;
    for (size_t i = 0; i < ROUNDS_MAX && bench_now_ns() < end && out->missed <= 10; i++) {
        int64_t until_heard, until_polled;
        bool came = run_round(s, &until_heard, &until_polled);
        int64_t took_alone = floor_round_ns(raw);
        if (i == WARM_UP) end = bench_now_ns() + (int64_t)(1e9 * seconds);
        if (!came) out->missed++;
        if (i < WARM_UP) continue;
        if (came) bench_samples_add(&heard, until_heard);
        if (came) bench_samples_add(&polled, until_polled);
        if (took_alone >= 0) bench_samples_add(&alone, took_alone);
    }
    out->rounds = heard.count;
    summarise(&heard, &out->us_p50, &out->us_p99);
    summarise(&polled, &out->polled_us_p50, &out->polled_us_p99);
    summarise(&alone, &out->raw_us_p50, &out->raw_us_p99);
    if (out->rounds && isfinite(out->raw_us_p50)) return true;
    fprintf(stderr, "%s, %zu bodies, %zu poses: no events came, or no echo\n", out->link, out->world, out->poses);
    return false;
}

/* From the next Status; -1: none came. */
static int64_t ticks_on_arrival(scene *s, double period_s)
{
    collided_daemon_status status;
    int64_t end = bench_now_ns() + (int64_t)(2e9 * period_s);
    for (int64_t left; (left = end - bench_now_ns()) > 0;) collided_poll(s->client, 1e-9 * (double)left);
    if (collided_get_status(s->client, 5, &status) != COLLIDED_OK) return -1;
    for (size_t i = 0; i < status.counter_count; i++)
        if (strcmp(status.counters[i].name, "ticks_on_arrival") == 0) return status.counters[i].value;
    return -1;
}

static bool await_standby(scene *s, double seconds)
{
    collided_daemon_status status;
    for (int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds); bench_now_ns() < end;) {
        if (collided_get_status(s->client, 2, &status) == COLLIDED_OK && strstr(status.links, "hot standby: "))
            return true;
        collided_poll(s->client, 0.05);
    }
    fprintf(stderr, "no standby is in step within %g s\n", seconds);
    return false;
}

/* A site for the daemon and "robot", which is this program. */
static bool make_site(const char *sites, const char *protect)
{
    char line[512];
    snprintf(line, sizeof line, MAKE_SITE " --protect %s %s/%s robot >&2", protect, sites, protect);
    return system(line) == 0; /* NOLINT(cert-env33-c): a line of this program's own */
}

/* Each of its own domain: a process has one identity in it. `sites`: the folder of the sites. */
static bool run_row(uint32_t domain, const way *w, const char *sites, const bench_options *o, row *out)
{
    char links[64], server[256] = "", robot[256] = "";
    uint32_t domain_of_raw = domain + 1;
    if (w->protect) {
        domain += w->protect[0] == 's' ? 3 : 2;
        snprintf(server, sizeof server, "%s/%s/daemon", sites, w->protect);
        snprintf(robot, sizeof robot, "%s/%s/robot", sites, w->protect);
    }
    snprintf(links, sizeof links, w->lcm ? "lcm://" : "dds://%" PRIu32, domain);
    fprintf(stderr, "%s (%s), %zu bodies, %zu poses ...\n", links, w->name, out->world, out->poses);
    double status_s = o->seconds < 1 ? 0.05 : 1;
    const char *const arguments[] = {"collided", "--links", links, "--log", "warning", "--status_period",
        o->seconds < 1 ? "0.05" : "1",
        w->protect  ? "--security"
        : w->paired ? "--standby=yes"
                    : NULL,
        w->protect ? server : NULL, NULL};
    scene s = {0};
    pid_t daemon = start_elsewhere(COLLIDED, arguments), standby = w->paired ? start_elsewhere(COLLIDED, arguments) : 0;
    floor_of raw = {0};
    if (w->lcm)
        raw.lcm = raw_lcm_open((uint32_t)out->poses);
    else
        raw.dds = raw_open(domain_of_raw, (uint32_t)out->poses);
    bool done = (raw.dds || raw.lcm) && scene_open(&s, links, robot, out->world, out->poses) &&
                (!w->paired || await_standby(&s, 30)) && measure(&s, &raw, o->seconds, out);
    if (done) out->on_arrival = ticks_on_arrival(&s, status_s);
    raw_close(raw.dds);
    raw_lcm_close(raw.lcm);
    scene_close(&s);
    if (standby) bench_end(standby);
    bench_end(daemon);
    return done;
}

/* ---- printing ---- */

static void print_contender(const row *r, const char *contender, double p50, double p99)
{
    printf("{\"bench\":\"latency\",\"entry\":\"the daemon, by its client "
           "library\",\"link\":\"%s\",\"world\":%zu,\"poses\":%zu,\"contender\":\"%s\",\"us_p50\":%.1f,"
           "\"us_p99\":%.1f,\"ratio_p50\":%.3f,\"ratio_p99\":%.3f,\"missed\":%zu,"
           "\"on_arrival\":%" PRId64 "}\n",
        r->link, r->world, r->poses, contender, p50, p99, p50 / r->raw_us_p50, p99 / r->raw_us_p99, r->missed,
        r->on_arrival);
}

static void print_row(const row *r, bool json)
{
    if (json) {
        print_contender(r, "collided", r->us_p50, r->us_p99);
        print_contender(r, "collided, polled", r->polled_us_p50, r->polled_us_p99);
        print_contender(r, strcmp(r->link, "lcm") ? "raw dds" : "raw lcm", r->raw_us_p50, r->raw_us_p99);
    } else {
        printf("%-9s %7zu %6zu | %8.1f %8.1f | %8.1f %8.1f | %8.1f %8.1f | %6.2f %6.2f | %7zu %6zu\n", r->link,
            r->world, r->poses, r->us_p50, r->us_p99, r->polled_us_p50, r->polled_us_p99, r->raw_us_p50, r->raw_us_p99,
            r->us_p50 / r->raw_us_p50, r->us_p99 / r->raw_us_p99, r->rounds, r->missed);
    }
    fflush(stdout);
}

/* Takes that option out of the arguments. */
static bool take_option(int *argc, char **argv, const char *option)
{
    for (int i = 1; i < *argc; i++) {
        if (strcmp(argv[i], option) != 0) continue;
        memmove(argv + i, argv + i + 1, (size_t)(*argc - i) * sizeof *argv);
        --*argc;
        return true;
    }
    return false;
}

static bool run_all(const way *ways, size_t way_count, const char *sites, uint32_t domain, const bench_options *o)
{
    static const size_t worlds[] = {100, 10000, 100000}, poses[] = {1, 100, 1000};
    bool done = true;
    if (!o->json)
        printf("%-9s %7s %6s | %8s %8s | %8s %8s | %8s %8s | %6s %6s | %7s %6s\n", "link", "world", "poses", "p50 us",
            "p99 us", "polled50", "polled99", "raw p50", "raw p99", "p50 x", "p99 x", "rounds", "missed");
    for (size_t i = 0; i < 9 * way_count; i++) {
        size_t scene_of = ways[way_count - 1].paired ? i / way_count : i % 9; /* those two take turns */
        const way *to = &ways[ways[way_count - 1].paired ? i % way_count : i / 9];
        row r = {.link = to->name, .world = worlds[scene_of / 3], .poses = poses[scene_of % 3]};
        if (r.poses > r.world || (o->bodies && (size_t)o->bodies != r.world)) continue;
        if (run_row(domain, to, sites, o, &r))
            print_row(&r, o->json);
        else
            done = false;
    }
    return done;
}

static bool run_secured(uint32_t domain, const bench_options *o)
{
    static const way ways[] = {
        {"dds", NULL, false, false}, {"signed", "sign", false, false}, {"encrypted", "encrypt", false, false}};
    char sites[] = "/tmp/collided-bench-XXXXXX", line[64];
    bool done =
        mkdtemp(sites) && make_site(sites, "sign") && make_site(sites, "encrypt") && run_all(ways, 3, sites, domain, o);
    snprintf(line, sizeof line, "rm -rf -- %s", sites);
    if (system(line) != 0) fprintf(stderr, "%s is left behind\n", sites); /* NOLINT(cert-env33-c) */
    return done;
}

int main(int argc, char **argv)
{
    static const way ways[] = {{"dds", NULL, false, false}, {"lcm", NULL, true, false}},
                     pair[] = {{"dds", NULL, false, false}, {"pair", NULL, false, true}};
    bench_options o;
    if (argc == 3 && strcmp(argv[1], "--echo") == 0) return raw_echo((uint32_t)strtoul(argv[2], NULL, 10));
    if (argc == 2 && strcmp(argv[1], "--echo-lcm") == 0) return raw_lcm_echo();
    bool secured = take_option(&argc, argv, "--security"), paired = take_option(&argc, argv, "--standby");
    if (!bench_parse(argc, argv, 4, 30, &o)) return EXIT_FAILURE;
    bool isolated = bench_isolate();
    uint32_t domain = DOMAIN_FIRST + (uint32_t)getpid() % DOMAINS;
    char echo_domain[16];
    snprintf(echo_domain, sizeof echo_domain, "%" PRIu32, domain + 1);
    pid_t echo = start_elsewhere("/proc/self/exe", (const char *const[]){"echo", "--echo", echo_domain, NULL}),
          echo_lcm = -1;
    if (isolated && !secured && !paired)
        echo_lcm = start_elsewhere("/proc/self/exe", (const char *const[]){"echo", "--echo-lcm", NULL});
    bool done = secured  ? run_secured(domain, &o)
                : paired ? run_all(pair, 2, "", domain, &o)
                         : run_all(ways, isolated ? 2 : 1, "", domain, &o);
    if (!isolated && !secured && !paired) fprintf(stderr, "lcm: skipped: its multicast must not leave a namespace\n");
    bench_end(echo);
    if (echo_lcm > 0) bench_end(echo_lcm);
    return done ? EXIT_SUCCESS : EXIT_FAILURE;
}
