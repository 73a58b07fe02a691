/* bench_throughput: how many poses a second the daemon takes, in a world of 10,000 bodies with one subscriber to
 * contacts, beside a subscriber over the same transport that does nothing with them (raw_ping.h), in turns.
 *
 * The world: cubes of side 1 m on a grid of 4 m, and one beside cube_0, which never moves. Poses sway by 2 cm, so the
 * fat boxes hold and no pair comes or goes. Over DDS batches go out in groups, and the next one when the last of a
 * group has been answered in lock-step. Over LCM they go out at a fixed rate, and what the daemon has not counted is
 * lost. */
#include "bench.h"
#include "cubes.h"
#include "raw_ping.h"

#include <collided.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum {
    DOMAIN_FIRST = 150,
    DOMAINS = 79,
    BATCH = 1000,
    BATCH_LCM = 600 /* what the client library puts into a message */,
    GROUP = 32,
    TURNS = 4,
    WORLD = 10000
};
static const double SWAY_M = 0.02, LCM_POSES_S = 1e6;
static const int64_t PATIENCE_NS = 5000000000;

typedef struct scene {
    collided *client;
    size_t world, batch;   /* bodies: all, of a batch */
    collided_body *bodies; /* the world's, and one beside cube_0 */
    double *positions, *orientations;
    int64_t step, heard_step;
} scene;

typedef struct figures {
    double poses_s, poses_core_s; /* a second; a second of the daemon's processor time */
    double raw_poses_s, raw_poses_core_s;
    int64_t sent, lost; /* batches */
} figures;

/* ---- the scene ---- */

static void on_batch(void *context, const collided_batch *b)
{
    scene *s = context;
    if (b->step > s->heard_step) s->heard_step = b->step;
}

static bool scene_open(scene *s, const char *uri, size_t world, size_t batch)
{
    *s = (scene){.world = world, .batch = batch};
    s->bodies = calloc(world + 1, sizeof *s->bodies);
    s->positions = calloc(3 * (world + BATCH), sizeof(double));
    s->orientations = calloc(4 * (world + BATCH), sizeof(double));
    if (!s->bodies || !s->positions || !s->orientations) return false;
    for (size_t i = 0; i < world + BATCH; i++) s->orientations[4 * i] = 1;
    s->client = collided_connect(uri, NULL);
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

/* ---- sending ---- */

/* The batch of that number: the bodies in turn. True if it went out. */
static bool send(scene *s, int64_t number, int64_t step)
{
    size_t share = s->batch, first = (size_t)number * share % s->world;
    if (first + share > s->world) first = s->world - share;
    for (size_t i = first; i < first + share; i++)
        cubes_place(s->world, i, number % 2 ? SWAY_M : -SWAY_M, s->positions + 3 * i);
    return collided_publish(s->client, share, s->bodies + first, s->positions + 3 * first, s->orientations + 4 * first,
               NULL, NULL, bench_wall_ns(), step) == COLLIDED_OK;
}

static bool await_step(scene *s)
{
    int64_t end = bench_now_ns() + PATIENCE_NS;
    while (s->heard_step < s->step) {
        int64_t left = end - bench_now_ns();
        if (left <= 0) return false;
        collided_poll(s->client, 1e-9 * (double)left);
    }
    return true;
}

/* Batches that were taken in that time; -1: no answer. */
static int64_t flood(scene *s, double seconds)
{
    int64_t batches = 0, end = bench_now_ns() + (int64_t)(1e9 * seconds);
    while (bench_now_ns() < end) {
        for (int i = 1; i <= GROUP; i++, batches++)
            if (!send(s, batches, i == GROUP ? ++s->step : 0)) return -1;
        if (!await_step(s)) return -1;
    }
    return batches;
}

/* Turns of ours and of the raw one. */
static bool measure_dds(scene *s, raw_ping *raw, pid_t daemon, pid_t echo, double seconds, figures *f)
{
    double share = seconds / TURNS, ours_s = 0, raw_s = 0, poses = 0, raw_poses = 0;
    size_t batch = s->batch;
    if (flood(s, share / 4) < 0) return false; /* warm up */
    double cpu = bench_cpu_s(daemon), raw_cpu = bench_cpu_s(echo);
    for (int i = 0; i < TURNS; i++) {
        int64_t began = bench_now_ns(), ours = flood(s, share / 2), between = bench_now_ns();
        int64_t alone = raw_flood(raw, share / 2, GROUP);
        if (ours < 0 || alone < 0) return false;
        ours_s += 1e-9 * (double)(between - began);
        raw_s += 1e-9 * (double)(bench_now_ns() - between);
        poses += (double)ours * (double)batch;
        raw_poses += (double)alone * (double)batch;
        f->sent += ours;
    }
    cpu = bench_cpu_s(daemon) - cpu;
    raw_cpu = bench_cpu_s(echo) - raw_cpu;
    f->poses_s = poses / ours_s;
    f->poses_core_s = cpu > 0 ? poses / cpu : 0;
    f->raw_poses_core_s = raw_cpu > 0 ? raw_poses / raw_cpu : 0;
    f->raw_poses_s = raw_poses / raw_s;
    return true;
}

static int64_t counter(scene *s, const char *name)
{
    collided_daemon_status status;
    if (collided_get_status(s->client, 5, &status) != COLLIDED_OK) return -1;
    for (size_t i = 0; i < status.counter_count; i++)
        if (strcmp(status.counters[i].name, name) == 0) return status.counters[i].value;
    return -1;
}

static void poll_for(scene *s, double seconds)
{
    int64_t end = bench_now_ns() + (int64_t)(1e9 * seconds);
    for (int64_t left; (left = end - bench_now_ns()) > 0;) collided_poll(s->client, 1e-9 * (double)left);
}

/* At a fixed rate; then, when all that is to come has been counted, how much of it came. */
static bool measure_lcm(scene *s, pid_t daemon, double seconds, figures *f)
{
    static const char IN[] = "in_PoseBatch";
    size_t batch = s->batch;
    int64_t pause = (int64_t)(1e9 * (double)batch / LCM_POSES_S), before = counter(s, IN), began = bench_now_ns();
    double cpu = bench_cpu_s(daemon);
    if (before < 0) return false;
    while (bench_now_ns() < began + (int64_t)(1e9 * seconds)) {
        bench_sleep_until(began + f->sent * pause);
        if (!send(s, f->sent++, 0)) return false;
        collided_poll(s->client, 0);
    }
    double took = 1e-9 * (double)(bench_now_ns() - began);
    cpu = bench_cpu_s(daemon) - cpu;
    poll_for(s, 1.6); /* Status comes once a second */
    f->lost = f->sent - (counter(s, IN) - before);
    f->poses_s = (double)f->sent * (double)batch / took;
    f->poses_core_s = cpu > 0 ? (double)f->sent * (double)batch / cpu : 0;
    return true;
}

/* ---- printing ---- */

static void print_row(const char *link, size_t world, const figures *f, bool json)
{
    double core_ratio = f->raw_poses_core_s > 0 ? f->poses_core_s / f->raw_poses_core_s : 0;
    double ratio = f->raw_poses_s > 0 ? f->poses_s / f->raw_poses_s : 0;
    if (json)
        printf("{\"bench\":\"throughput\",\"entry\":\"the daemon, by its client "
               "library\",\"link\":\"%s\",\"world\":%zu,\"poses_s\":%.0f,\"poses_core_s\":%.0f,"
               "\"raw_poses_s\":%.0f,\"raw_poses_core_s\":%.0f,\"ratio\":%.3f,\"core_ratio\":%.3f,\"sent\":%" PRId64
               ",\"lost\":%" PRId64 "}\n",
            link, world, f->poses_s, f->poses_core_s, f->raw_poses_s, f->raw_poses_core_s, ratio, core_ratio, f->sent,
            f->lost);
    else
        printf("%-4s %7zu | %12.0f %12.0f | %12.0f %12.0f | %6.2f %6.2f | %8" PRId64 " %6" PRId64 "\n", link, world,
            f->poses_s, f->poses_core_s, f->raw_poses_s, f->raw_poses_core_s, ratio, core_ratio, f->sent, f->lost);
    fflush(stdout);
}

static bool run_row(bool lcm, uint32_t domain, pid_t echo, const bench_options *o)
{
    char links[64];
    size_t world = o->bodies ? (size_t)o->bodies : WORLD, most = lcm ? BATCH_LCM : BATCH;
    size_t batch = world < most ? world : most;
    snprintf(links, sizeof links, lcm ? "lcm://" : "dds://%" PRIu32, domain);
    fprintf(stderr, "%s, %zu bodies ...\n", links, world);
    const char *const arguments[] = {"collided", "--links", links, "--log", "warning", NULL};
    scene s = {0};
    figures f = {0};
    pid_t daemon = bench_start(COLLIDED, arguments);
    raw_ping *raw = lcm ? NULL : raw_open(domain + 1, (uint32_t)batch);
    bool done = (lcm || raw) && scene_open(&s, links, world, batch) &&
                (lcm ? measure_lcm(&s, daemon, o->seconds, &f) : measure_dds(&s, raw, daemon, echo, o->seconds, &f));
    if (done)
        print_row(lcm ? "lcm" : "dds", world, &f, o->json);
    else
        fprintf(stderr, "%s: no figures\n", links);
    raw_close(raw);
    scene_close(&s);
    bench_end(daemon);
    return done;
}

int main(int argc, char **argv)
{
    bench_options o;
    if (argc == 3 && strcmp(argv[1], "--echo") == 0) return raw_echo((uint32_t)strtoul(argv[2], NULL, 10));
    if (!bench_parse(argc, argv, 4, 30, &o)) return EXIT_FAILURE;
    bool isolated = bench_isolate();
    uint32_t domain = DOMAIN_FIRST + (uint32_t)getpid() % DOMAINS;
    char echo_domain[16];
    snprintf(echo_domain, sizeof echo_domain, "%" PRIu32, domain + 1);
    pid_t echo = bench_start("/proc/self/exe", (const char *const[]){"echo", "--echo", echo_domain, NULL});
    if (!o.json)
        printf("%-4s %7s | %12s %12s | %12s %12s | %6s %6s | %8s %6s\n", "link", "world", "poses/s", "/s of core",
            "raw poses/s", "/s of core", "ratio", "core", "batches", "lost");
    bool done = run_row(false, domain, echo, &o);
    if (isolated)
        done &= run_row(true, domain, echo, &o);
    else
        fprintf(stderr, "lcm: skipped: its multicast must not leave a namespace\n");
    bench_end(echo);
    return done ? EXIT_SUCCESS : EXIT_FAILURE;
}
