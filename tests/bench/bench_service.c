/* bench_service: the whole daemon under load. A client publishes all bodies' poses a hundred times a second in one
 * batch and subscribes to their contacts; measured are the daemon's use of a core and the time from a pose's stamp to
 * the callback with the contacts that follow from it. Between two steps the same payload goes to and fro over DDS
 * alone (raw_ping.h): the floor, under the same conditions.
 *
 * The scene: cubes of side 1 m on a grid of 4 m, each going round a circle of radius 0.5 m at 0.5 m/s while it turns
 * about z at 1 rad/s. 1 % of them, in pairs, are in contact all the time, so that each step has events. */
#include "bench.h"
#include "cubes.h"
#include "raw_ping.h"

#include <collided.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { HZ = 100, STEP_NS = 1000000000 / HZ, WARM_UP_STEPS = 50, DOMAIN_FIRST = 150, DOMAINS = 79 };
static const double CONTACT_SHARE = 0.01, RADIUS_M = 0.5, OVERLAP_AT_M = 0.8;

typedef struct scene {
    collided *client;
    size_t count, paired; /* the first `paired` bodies are in contact: 0 with 1, 2 with 3, ... */
    collided_body *bodies;
    double *positions, *orientations;
    int64_t step, measured_from; /* the first step that counts */
    int64_t heard_step, first_tick, last_tick, events, lost;
    bench_samples round;
} scene;

typedef struct row {
    const char *link;
    size_t bodies;
    double core_share, us_p50, us_p99, raw_us_p50, raw_us_p99;
    int64_t ticks, events;
    int64_t lost;               /* batches of events */
    int64_t missed, raw_missed; /* steps without an event of their own: late, or one tick for two; pings unanswered */
} row;

/* ---- the scene ---- */

/* A pair shares its first body's place, angle and phase. */
static void place(scene *s, size_t i, double t)
{
    bool second = i < s->paired && i % 2 == 1;
    size_t cell = second ? i - 1 : i;
    double phase = t + (double)cell;
    double *p = s->positions + 3 * i, *q = s->orientations + 4 * i;
    cubes_place(s->count, cell, RADIUS_M * cos(phase) + (second ? OVERLAP_AT_M : 0), p);
    p[1] += RADIUS_M * sin(phase);
    q[0] = cos(0.5 * phase);
    q[1] = q[2] = 0;
    q[3] = sin(0.5 * phase);
}

static bool create_bodies(scene *s)
{
    collided_pose at;
    char name[32];
    for (size_t i = 0; i < s->count; i++) {
        place(s, i, 0);
        snprintf(name, sizeof name, "cube_%zu", i);
        memcpy(at.position, s->positions + 3 * i, sizeof at.position);
        memcpy(at.orientation, s->orientations + 4 * i, sizeof at.orientation);
        s->bodies[i] = cubes_put(s->client, name, &at);
    }
    return collided_sync(s->client, 10) == COLLIDED_OK;
}

static void on_batch(void *context, const collided_batch *b)
{
    int64_t now_ns = bench_wall_ns();
    scene *s = context;
    s->lost += b->lost;
    if (b->step < s->measured_from || b->step <= s->heard_step) return;
    s->heard_step = b->step;
    bench_samples_add(&s->round, now_ns - b->latest_pose_ns);
    if (!s->first_tick) s->first_tick = b->tick;
    s->last_tick = b->tick;
    s->events += (int64_t)b->event_count;
}

static bool scene_open(scene *s, const char *uri, size_t bodies, size_t steps)
{
    *s = (scene){.count = bodies, .measured_from = INT64_MAX};
    s->paired = 2 * (size_t)fmax(1, round(0.5 * CONTACT_SHARE * (double)bodies));
    if (s->paired > bodies) s->paired = 0;
    s->bodies = calloc(bodies, sizeof *s->bodies);
    s->positions = calloc(3 * bodies, sizeof(double));
    s->orientations = calloc(4 * bodies, sizeof(double));
    if (!s->bodies || !s->positions || !s->orientations || !bench_samples_init(&s->round, steps)) return false;
    s->client = collided_connect(uri, NULL);
    if (!s->client) {
        fprintf(stderr, "%s: %s\n", uri, collided_connect_error());
        return false;
    }
    collided_subscription_def watch = collided_subscription_def_default();
    watch.callback = on_batch;
    watch.context = s;
    if (create_bodies(s) && collided_subscribe(s->client, &watch).id != COLLIDED_NONE &&
        collided_sync(s->client, 10) == COLLIDED_OK)
        return true;
    fprintf(stderr, "%s: %s\n", uri, collided_error(s->client));
    return false;
}

static void scene_close(scene *s)
{
    if (s->client) collided_close(s->client);
    bench_samples_free(&s->round);
    free(s->bodies);
    free(s->positions);
    free(s->orientations);
}

/* ---- a row ---- */

/* Half a period for the daemon, a quarter for raw DDS, the rest as a margin. An answer that comes later than its half
 * is taken with the next step, and its time counts until then. */
static void run_step(scene *s, raw_ping *raw, bench_samples *raw_round, int64_t at_ns)
{
    bool counts = ++s->step >= s->measured_from;
    for (size_t i = 0; i < s->count; i++) place(s, i, (double)s->step / HZ);
    bench_sleep_until(at_ns);
    collided_publish(
        s->client, s->count, s->bodies, s->positions, s->orientations, NULL, NULL, bench_wall_ns(), s->step);
    for (int64_t left; (left = at_ns + STEP_NS / 2 - bench_now_ns()) > 0;)
        collided_poll(s->client, 1e-9 * (double)left);
    int64_t took_ns = raw_round_ns(raw, STEP_NS / 4);
    if (counts && took_ns >= 0) bench_samples_add(raw_round, took_ns);
}

static bool measure(scene *s, raw_ping *raw, pid_t daemon, size_t steps, row *out)
{
    bench_samples raw_round;
    if (!bench_samples_init(&raw_round, steps)) return false;
    int64_t at_ns = bench_now_ns();
    for (int i = 0; i < WARM_UP_STEPS; i++) run_step(s, raw, &raw_round, at_ns += STEP_NS);
    s->measured_from = s->step + 1;
    double cpu_s = bench_cpu_s(daemon);
    int64_t began_ns = bench_now_ns();
    for (size_t i = 0; i < steps; i++) run_step(s, raw, &raw_round, at_ns += STEP_NS);
    double wall_s = 1e-9 * (double)(bench_now_ns() - began_ns);
    out->core_share = (bench_cpu_s(daemon) - cpu_s) / wall_s;
    out->us_p50 = bench_percentile_us(&s->round, 0.5);
    out->us_p99 = bench_percentile_us(&s->round, 0.99);
    out->raw_us_p50 = bench_percentile_us(&raw_round, 0.5);
    out->raw_us_p99 = bench_percentile_us(&raw_round, 0.99);
    out->ticks = s->first_tick ? s->last_tick - s->first_tick + 1 : 0;
    out->events = s->events;
    out->lost = s->lost;
    out->missed = (int64_t)(steps - s->round.count);
    out->raw_missed = (int64_t)(steps - raw_round.count);
    bench_samples_free(&raw_round);
    if (s->round.count && isfinite(out->core_share)) return true;
    fprintf(stderr, "%s, %zu bodies: no events came, or the daemon ended\n", out->link, out->bodies);
    return false;
}

static bool run_row(uint32_t domain, const bench_options *o, row *out)
{
    char links[64];
    bool dds = strcmp(out->link, "dds") == 0;
    if (dds)
        snprintf(links, sizeof links, "dds://%" PRIu32, domain);
    else
        snprintf(links, sizeof links, "lcm://");
    fprintf(stderr, "%s, %zu bodies, %g s ...\n", links, out->bodies, o->seconds);
    const char *const arguments[] = {"collided", "--links", links, "--log", "warning", NULL};
    size_t steps = (size_t)(o->seconds * HZ);
    scene s = {0};
    pid_t daemon = bench_start(COLLIDED, arguments);
    raw_ping *raw = raw_open(domain + 1, (uint32_t)out->bodies);
    bool done = raw && scene_open(&s, links, out->bodies, steps) && measure(&s, raw, daemon, steps, out);
    raw_close(raw);
    scene_close(&s);
    bench_end(daemon);
    return done;
}

/* ---- printing ---- */

static void print_head(void)
{
    printf("%-5s %7s %4s %11s | %9s %9s | %9s %9s | %7s %8s %5s %6s\n", "link", "bodies", "Hz", "core share", "p50 us",
        "p99 us", "raw p50", "raw p99", "ticks", "events", "lost", "missed");
}

static void print_row(const row *r, bool json)
{
    if (!json) {
        printf("%-5s %7zu %4d %9.1f %% | %9.1f %9.1f | %9.1f %9.1f | %7" PRId64 " %8" PRId64 " %5" PRId64 " %6" PRId64
               "\n",
            r->link, r->bodies, HZ, 100 * r->core_share, r->us_p50, r->us_p99, r->raw_us_p50, r->raw_us_p99, r->ticks,
            r->events, r->lost, r->missed);
    } else {
        printf("{\"bench\":\"service\",\"entry\":\"the daemon, by its client "
               "library\",\"link\":\"%s\",\"bodies\":%zu,\"hz\":%d,\"core_share\":%.4f,\"us_p50\":%.1f,"
               "\"us_p99\":%.1f,",
            r->link, r->bodies, HZ, r->core_share, r->us_p50, r->us_p99);
        /* JSON has no NaN: a ping-pong that never came back has no time. */
        if (isfinite(r->raw_us_p50)) printf("\"raw_us_p50\":%.1f,\"raw_us_p99\":%.1f,", r->raw_us_p50, r->raw_us_p99);
        printf("\"ticks\":%" PRId64 ",\"events\":%" PRId64 ",\"lost\":%" PRId64 ",\"missed\":%" PRId64
               ",\"raw_missed\":%" PRId64 ",\"contact_share\":%g}\n",
            r->ticks, r->events, r->lost, r->missed, r->raw_missed, CONTACT_SHARE);
    }
    fflush(stdout);
}

int main(int argc, char **argv)
{
    static const char *const links[] = {"dds", "lcm"};
    static const size_t sizes[] = {1000, 100};
    bench_options o;
    if (argc == 3 && strcmp(argv[1], "--echo") == 0) return raw_echo((uint32_t)strtoul(argv[2], NULL, 10));
    if (!bench_parse(argc, argv, 8, 60, &o)) return EXIT_FAILURE;
    bool isolated = bench_isolate(), done = true;
    uint32_t domain = DOMAIN_FIRST + (uint32_t)getpid() % DOMAINS; /* free in a namespace; elsewhere most likely */
    char echo_domain[16];
    snprintf(echo_domain, sizeof echo_domain, "%" PRIu32, domain + 1);
    pid_t echo = bench_start("/proc/self/exe", (const char *const[]){"echo", "--echo", echo_domain, NULL});
    if (!o.json) print_head();
    for (size_t i = 0; i < 4; i++) {
        row r = {.link = links[i / 2], .bodies = o.bodies ? (size_t)o.bodies : sizes[i % 2]};
        if (o.bodies && i % 2 == 1) continue;
        if (i >= 2 && !isolated) {
            fprintf(stderr, "lcm, %zu bodies: skipped: its multicast must not leave a namespace\n", r.bodies);
            continue;
        }
        if (run_row(domain, &o, &r))
            print_row(&r, o.json);
        else
            done = false;
    }
    bench_end(echo);
    return done ? EXIT_SUCCESS : EXIT_FAILURE;
}
