#include "neighbour.h"

#include <collided.h>

#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { BINS_A_DOUBLING = 16, SIDES = 5 /* distances between the cubes, in turn */ };
static const double PERIOD_S = 0.01, PATIENCE_S = 60, STEP_M = 0.125, FAR_M = 1e5, TOLERANCE_M = 1e-6;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- histograms ---- */

static void count_at(neighbour_waits *w, double seconds)
{
    double us = fmax(1, 1e6 * seconds);
    int bin = (int)(BINS_A_DOUBLING * log2(us));
    atomic_fetch_add(&w->bins[bin < NEIGHBOUR_BINS ? bin : NEIGHBOUR_BINS - 1], 1);
}

/* Who waits cannot ask meanwhile: those that he would have asked in his rhythm would have waited, too. */
static void add_wait(neighbour_waits *w, double seconds)
{
    for (double wait = seconds; wait > 0; wait -= PERIOD_S) count_at(w, wait);
}

uint64_t neighbour_count(const neighbour_waits *w)
{
    uint64_t count = 0;
    for (int i = 0; i < NEIGHBOUR_BINS; i++) count += atomic_load(&w->bins[i]);
    return count;
}

double neighbour_percentile_ms(const neighbour_waits *w, double share)
{
    uint64_t count = neighbour_count(w), rank = (uint64_t)ceil(share * (double)count), seen = 0;
    for (int i = 0; count && i < NEIGHBOUR_BINS; i++)
        if ((seen += atomic_load(&w->bins[i])) >= rank) return 1e-3 * exp2((i + 1.0) / BINS_A_DOUBLING);
    return 0;
}

static void clear_waits(neighbour_waits *w)
{
    for (int i = 0; i < NEIGHBOUR_BINS; i++) atomic_store(&w->bins[i], 0);
}

void neighbour_clear(neighbour_report *r)
{
    clear_waits(&r->answers);
    clear_waits(&r->events);
    clear_waits(&r->machine);
    atomic_store(&r->rounds, 0);
    atomic_store(&r->longest_tick_ns, 0);
    atomic_store(&r->most_cpu_ns, 0);
}

/* ---- what he has in the world ---- */

typedef struct neighbour {
    neighbour_report *report;
    collided *client;
    collided_shape cube;
    collided_body standing, going;
    double distance; /* of the newest pose */
    int64_t step, heard_step;
} neighbour;

static int give_up(neighbour *n, const char *what, const char *why)
{
    snprintf(n->report->error, sizeof n->report->error, "%s: %s", what, why);
    if (n->client) collided_close(n->client);
    return 1;
}

/* Is the distance of the two cubes, when it was d, within the interval, and do axis and points prove that? */
static bool is_true(const neighbour *n, double d, const collided_certificate *claim)
{
    collided_pose a = collided_pose_identity(), b = collided_pose_identity();
    a.position[0] = FAR_M;
    b.position[0] = FAR_M + 1 + d;
    return claim->lo <= d && d <= claim->hi &&
           collided_verify(&n->cube, &a, NULL, 0, &n->cube, &b, NULL, 0, claim) == COLLIDED_OK;
}

static void turn(collided_certificate *claim)
{
    collided_certificate was = *claim;
    for (int k = 0; k < 3; k++) {
        claim->axis[k] = -was.axis[k];
        claim->point_a[k] = was.point_b[k];
        claim->point_b[k] = was.point_a[k];
    }
}

static void hold_true(neighbour *n, const char *name_a, collided_certificate claim)
{
    if (strcmp(name_a, "neighbour/stands") != 0) turn(&claim);
    if (!is_true(n, n->distance, &claim)) atomic_fetch_add(&n->report->wrong, 1);
}

static collided_certificate claim_of(
    double lo, double hi, const double axis[3], const double point_a[3], const double point_b[3])
{
    collided_certificate c = {.lo = lo, .hi = hi};
    for (int k = 0; k < 3; k++) {
        c.axis[k] = axis[k];
        c.point_a[k] = point_a[k];
        c.point_b[k] = point_b[k];
    }
    return c;
}

static void on_batch(void *context, const collided_batch *b)
{
    neighbour *n = context;
    if (b->starved || b->step < n->step) return; /* of an earlier pose */
    n->heard_step = b->step;
    for (size_t i = 0; i < b->event_count; i++) {
        const collided_event *e = &b->events[i];
        if (e->kind != COLLIDED_FAR && e->kind != COLLIDED_UNKNOWN)
            hold_true(n, e->name_a, claim_of(e->lo, e->hi, e->axis, e->point_a, e->point_b));
    }
}

static collided_body put_cube(neighbour *n, const char *name, double x)
{
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &n->cube;
    def.shape_count = 1;
    def.pose.position[0] = x;
    return collided_create_body(n->client, &def);
}

static bool settle_in(neighbour *n)
{
    n->cube = collided_box(1, 1, 1);
    n->distance = STEP_M;
    n->standing = put_cube(n, "neighbour/stands", FAR_M);
    n->going = put_cube(n, "neighbour/goes", FAR_M + 1 + n->distance);
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = COLLIDED_DISTANCE;
    def.select_a = def.select_b = "neighbour/*";
    def.range_m = 10;
    def.tolerance_m = TOLERANCE_M;
    def.callback = on_batch;
    def.context = n;
    return collided_subscribe(n->client, &def).id != COLLIDED_NONE &&
           collided_sync(n->client, PATIENCE_S) == COLLIDED_OK;
}

/* ---- his rhythm ---- */

static void move_and_hear(neighbour *n)
{
    double position[3] = {0}, orientation[4] = {1, 0, 0, 0}, began = now_s();
    n->step++;
    n->distance = STEP_M * (double)(1 + n->step % SIDES);
    position[0] = FAR_M + 1 + n->distance;
    collided_publish(n->client, 1, &n->going, position, orientation, NULL, NULL, 0, n->step);
    while (n->heard_step < n->step && now_s() < began + PATIENCE_S && !atomic_load(&n->report->end))
        collided_poll(n->client, 0.1);
    add_wait(&n->report->events, now_s() - began);
    if (n->heard_step < n->step) atomic_fetch_add(&n->report->unanswered, 1);
}

static void ask(neighbour *n)
{
    collided_result result = {0};
    double began = now_s();
    collided_status status =
        collided_query_distance(n->client, "neighbour/stands", "neighbour/goes", TOLERANCE_M, PATIENCE_S, &result);
    add_wait(&n->report->answers, now_s() - began);
    if (status != COLLIDED_OK || result.count != 1) {
        atomic_fetch_add(&n->report->unanswered, 1);
    } else {
        const collided_hit *h = &result.hits[0];
        hold_true(n, h->name_a, claim_of(h->lo, h->hi, h->axis, h->point_a, h->point_b));
    }
    collided_result_free(&result);
}

static void read_status(neighbour *n)
{
    collided_daemon_status s;
    if (collided_get_status(n->client, 0, &s) != COLLIDED_OK) return;
    uint64_t epoch = (uint64_t)s.epoch;
    if (atomic_load(&n->report->epoch) && epoch != atomic_load(&n->report->epoch))
        atomic_fetch_add(&n->report->restarts, 1);
    atomic_store(&n->report->epoch, epoch);
    for (size_t i = 0; i < s.counter_count; i++) {
        uint64_t value = (uint64_t)s.counters[i].value;
        if (strcmp(s.counters[i].name, "round_longest_ns") == 0) atomic_store(&n->report->longest_tick_ns, value);
        if (strcmp(s.counters[i].name, "round_most_cpu_ns") == 0) atomic_store(&n->report->most_cpu_ns, value);
    }
}

static void rest_a_while(neighbour *n)
{
    struct timespec t = {.tv_nsec = (long)(1e9 * PERIOD_S / 2)};
    double began = now_s();
    nanosleep(&t, NULL);
    count_at(&n->report->machine, now_s() - began - PERIOD_S / 2);
}

int neighbour_live(const char *uri, neighbour_report *r)
{
    neighbour n = {.report = r};
    collided_def def = collided_def_default();
    def.name = "neighbour";
    def.lease_s = PATIENCE_S;
    def.connect_timeout_s = PATIENCE_S;
    n.client = collided_connect(uri, &def);
    if (!n.client) return give_up(&n, "connect", collided_connect_error());
    if (!settle_in(&n)) return give_up(&n, "announcing", collided_error(n.client));
    while (!atomic_load(&r->end)) {
        move_and_hear(&n);
        ask(&n);
        read_status(&n);
        rest_a_while(&n);
        atomic_fetch_add(&r->rounds, 1);
        if (atomic_load(&r->rounds) >= 20) atomic_store(&r->ready, true);
    }
    collided_close(n.client);
    return 0;
}
