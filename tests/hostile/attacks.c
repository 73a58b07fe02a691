#include "attacks.h"
#include "attacks_soft.h"

#include <collided.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static const double PATIENCE_S = 300, PATIENCE_SHORT_S = 20;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void *room(size_t count, size_t size)
{
    void *p = calloc(count, size);
    if (!p) abort();
    return p;
}

/* What is refused is what some attacks are for: it is no failure of theirs. */
static void say_refusals(void *context, const collided_rejection *why)
{
    int *told = context;
    if ((*told)++ < 3) fprintf(stderr, "  refused: %s: %s\n", why->reason, why->text);
}

static int refusals_told;

static collided *enter(const char *uri, const char *name)
{
    collided_def def = collided_def_default();
    def.name = name;
    def.lease_s = 60;
    def.connect_timeout_s = PATIENCE_SHORT_S;
    collided *c = collided_connect(uri, &def);
    if (!c) {
        fprintf(stderr, "  %s: %s\n", name, collided_connect_error());
        exit(1);
    }
    collided_on_rejected(c, say_refusals, &refusals_told);
    return c;
}

/* Until all is applied or refused, or a time is over. */
static void wait_for_all(collided *c, bool full)
{
    (void)collided_sync(c, full ? PATIENCE_S : PATIENCE_SHORT_S);
}

collided *attack_enter(const char *uri, const char *name)
{
    return enter(uri, name);
}

void attack_wait(collided *c, bool full)
{
    wait_for_all(c, full);
}

static void stay(collided *c, double seconds)
{
    double end = now_s() + seconds;
    while (now_s() < end) collided_poll(c, 0.05);
}

static void on_nothing(void *context, const collided_batch *b)
{
    (void)b;
    ++*(long *)context;
}

static long batches;

static void watch(collided *c, const char *select_a, const char *select_b)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.select_a = select_a;
    def.select_b = select_b;
    def.callback = on_nothing;
    def.context = &batches;
    (void)collided_subscribe(c, &def);
}

static collided_body put(collided *c, const char *format, size_t i, const collided_shape *shape, double x)
{
    char name[64];
    collided_body_def def = collided_body_def_default();
    snprintf(name, sizeof name, format, i);
    def.name = name;
    def.shapes = shape;
    def.shape_count = 1;
    def.pose.position[0] = x;
    return collided_create_body(c, &def);
}

/* ---- geometry ---- */

static void height_field(const char *uri, bool full)
{
    size_t side = full ? 1446 : 400;
    double *heights = room(side * side, sizeof *heights);
    for (size_t i = 0; i < side * side; i++) heights[i] = sin((double)(i % side)) * cos((double)(i / side));
    collided *c = enter(uri, "ground");
    collided_shape ground = collided_height_field(collided_create_height_field(c, heights, side, side, 0.1, 0.1, 1));
    put(c, "ground %zu", 0, &ground, 0);
    wait_for_all(c, full);
    stay(c, 2);
    collided_close(c);
    free(heights);
}

/* A wavy surface of 2 (side - 1)^2 triangles. */
static collided_geometry make_sheet(collided *c, size_t side, double phase)
{
    size_t points = side * side, triangles = 2 * (side - 1) * (side - 1), t = 0;
    double *at = room(3 * points, sizeof *at);
    int32_t *index = room(3 * triangles, sizeof *index);
    for (size_t i = 0; i < points; i++) {
        at[3 * i] = 0.01 * (double)(i % side);
        at[3 * i + 1] = 0.01 * (double)(i / side);
        at[3 * i + 2] = 0.1 * sin(0.05 * (double)(i % side) + phase) * cos(0.05 * (double)(i / side));
    }
    for (size_t r = 0; r + 1 < side; r++)
        for (size_t k = 0; k + 1 < side; k++) {
            int32_t a = (int32_t)(r * side + k), b = a + (int32_t)side;
            const int32_t two[6] = {a, a + 1, b + 1, a, b + 1, b};
            memcpy(index + t, two, sizeof two);
            t += 6;
        }
    collided_geometry g = collided_create_mesh(c, at, points, index, triangles);
    free(at);
    free(index);
    return g;
}

static void meshes(const char *uri, bool full)
{
    size_t side = full ? 701 : 160; /* 980,000 triangles */
    collided *c = enter(uri, "meshes");
    watch(c, "mesh *", "mesh *");
    for (size_t i = 0; i < 2; i++) {
        collided_shape mesh = collided_mesh(make_sheet(c, side, (double)i));
        put(c, "mesh %zu", i, &mesh, 0.001 * (double)i);
    }
    wait_for_all(c, full);
    for (int i = 0; i < (full ? 40 : 5); i++) {
        collided_pose pose = collided_pose_identity();
        pose.position[2] = 1e-3 * i;
        collided_move(c, (collided_body){0}, pose);
        stay(c, 0.1);
    }
    collided_close(c);
}

static void crowded_hulls(const char *uri, bool full)
{
    size_t count = full ? 65535 : 8000, hulls = full ? 8 : 2;
    double *at = room(3 * count, sizeof *at);
    collided *c = enter(uri, "hulls");
    for (size_t h = 0; h < hulls; h++) {
        for (size_t i = 0; i < count; i++) { /* a cone's rim, shifted far: many facets that are nearly coplanar */
            double angle = 2 * M_PI * (double)i / (double)count;
            at[3 * i] = cos(angle) + (double)h;
            at[3 * i + 1] = sin(angle);
            at[3 * i + 2] = i % 7 ? 0 : 1e-9 * (double)(i % 1000);
        }
        collided_shape hull = collided_hull(collided_create_hull(c, at, count));
        put(c, "hull %zu", h, &hull, 0);
    }
    wait_for_all(c, full);
    collided_close(c);
    free(at);
}

static void compounds(const char *uri, bool full)
{
    enum { CHILDREN = 255 };
    collided_shape children[CHILDREN];
    size_t count = full ? 4000 : 200;
    for (int i = 0; i < CHILDREN; i++) {
        children[i] = collided_box(0.1, 0.2, 0.3);
        children[i].pose.position[0] = 0.05 * i;
    }
    collided_shape whole = collided_compound(children, CHILDREN);
    collided *c = enter(uri, "compounds");
    watch(c, "compound *", "compound *");
    for (size_t i = 0; i < count; i++) put(c, "compound %zu", i, &whole, (double)(i % 40));
    wait_for_all(c, full);
    stay(c, 1);
    collided_close(c);
}

/* Pieces of geometry that belong to no body, as much as one may send, and more. */
static void hoard(const char *uri, bool full)
{
    size_t meshes_sent = full ? 200 : 20, side = full ? 501 : 120;
    collided *c = enter(uri, "hoard");
    for (size_t i = 0; i < meshes_sent; i++) {
        make_sheet(c, side, 0.01 * (double)i);
        collided_poll(c, 0);
    }
    wait_for_all(c, full);
    stay(c, 1);
    collided_close(c);
}

/* ---- crowds ---- */

static void heap_up(collided *c, size_t count, bool full)
{
    collided_shape ball = collided_sphere(0.5);
    for (size_t i = 0; i < count; i++) put(c, "ball %zu", i, &ball, 0);
    wait_for_all(c, full);
}

static void crowd_unasked(const char *uri, bool full)
{
    collided *c = enter(uri, "crowd");
    heap_up(c, full ? 20000 : 3000, full);
    stay(c, 1);
    collided_close(c);
}

/* All at one place, and then all move. */
static void crowd_asked(const char *uri, bool full)
{
    size_t count = full ? 3000 : 400;
    collided *c = enter(uri, "crowd");
    watch(c, "ball *", "*");
    heap_up(c, count, full);
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    for (int round = 1; round <= (full ? 100 : 20); round++) {
        for (size_t i = 0; i < count; i++) {
            bodies[i].id = (int32_t)i;
            at[3 * i] = 1e-4 * round * (double)(i % 17);
            turn[4 * i] = 1;
        }
        collided_publish(c, count, bodies, at, turn, NULL, NULL, 0, 0);
        stay(c, 0.05);
    }
    collided_close(c); /* and all leave at once */
    free(bodies);
    free(at);
    free(turn);
}

/* Somebody begins to ask about everything when all lie in one place. */
static void crowd_asked_later(const char *uri, bool full)
{
    collided *c = enter(uri, "crowd");
    heap_up(c, full ? 5000 : 600, full);
    for (int i = 0; i < (full ? 20 : 4); i++) {
        collided_subscription_def def = collided_subscription_def_default();
        def.callback = on_nothing;
        def.context = &batches;
        collided_subscription all = collided_subscribe(c, &def);
        stay(c, 0.5);
        collided_unsubscribe(c, all);
    }
    collided_close(c);
}

static void rules(const char *uri, bool full)
{
    enum { RULES = 1024 };
    collided_rule list[RULES];
    static char patterns[RULES][32];
    size_t count = full ? 2000 : 100;
    collided_shape ball = collided_sphere(0.5);
    collided *c = enter(uri, "rules");
    watch(c, "ruled *", "*");
    for (size_t i = 0; i < count; i++) {
        collided_body_def def = collided_body_def_default();
        char name[64];
        for (int k = 0; k < RULES; k++) {
            snprintf(patterns[k], sizeof patterns[k], "*%zu*r*u*l*e*%d*x", i, k);
            list[k] = (collided_rule){.pattern = patterns[k], .allow = k % 2 == 0, .reason = ""};
        }
        snprintf(name, sizeof name, "ruled %zu rrruuullleee", i);
        def.name = name;
        def.shapes = &ball;
        def.shape_count = 1;
        def.rules = list;
        def.rule_count = RULES;
        def.pose.position[0] = 1e-3 * (double)i;
        (void)collided_create_body(c, &def);
    }
    wait_for_all(c, full);
    stay(c, 1);
    collided_close(c);
}

static void subscriptions(const char *uri, bool full)
{
    size_t bodies = full ? 5000 : 1000, asked = full ? 4096 : 200;
    char a[64], b[64];
    collided_shape ball = collided_sphere(0.01);
    collided *c = enter(uri, "subscriptions");
    for (size_t i = 0; i < bodies; i++) put(c, "grain %zu of aaaaaaaaaaaaaaaaaaaa", i, &ball, (double)i);
    wait_for_all(c, full);
    for (size_t i = 0; i < asked; i++) {
        snprintf(a, sizeof a, "*a*a*a*a*a*%zu", i);
        snprintf(b, sizeof b, "g*r*a*i*n*%zu*", i);
        watch(c, a, b);
    }
    wait_for_all(c, full);
    stay(c, 1);
    collided_close(c);
}

/* ---- floods ---- */

static void poses(const char *uri, bool full)
{
    size_t count = full ? 100000 : 5000;
    collided_shape ball = collided_sphere(0.01);
    collided *c = enter(uri, "poses");
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    watch(c, "grain *", "grain *");
    for (size_t i = 0; i < count; i++) bodies[i] = put(c, "grain %zu", i, &ball, 0.1 * (double)i);
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 4);
    for (int round = 1; now_s() < end; round++) {
        for (size_t i = 0; i < count; i++) {
            at[3 * i] = 0.1 * (double)i + 0.01 * (round % 9);
            turn[4 * i] = 1;
        }
        collided_publish(c, count, bodies, at, turn, NULL, NULL, 0, 0);
        collided_poll(c, 0);
    }
    collided_close(c);
    free(bodies);
    free(at);
    free(turn);
}

/* Each answer names all bodies, and is asked for again and again, by many processes at once. */
static void queries(const char *uri, bool full)
{
    size_t count = full ? 20000 : 2000;
    collided_shape ball = collided_sphere(0.01);
    collided *c = enter(uri, "queries");
    for (size_t i = 0; i < count; i++) put(c, "grain %zu", i, &ball, 0.1 * (double)i);
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 4);
    const double half[3] = {1e6, 1e6, 1e6};
    collided_pose origin = collided_pose_identity();
    while (now_s() < end) { /* time-outs of a millisecond: the next one is asked before the last one is answered */
        collided_result result = {0};
        (void)collided_query_box(c, &origin, half, 1e-3, &result);
        collided_result_free(&result);
        (void)collided_query_nearest(c, NULL, &origin, half, INFINITY, 0, 1e-3, &result);
        collided_result_free(&result);
        (void)collided_query_bodies(c, "*", 1e-3, &result);
        collided_result_free(&result);
    }
    collided_close(c);
}

/* One process, as many clients as it can be, each with a body and a subscription of its own. */
static void names(const char *uri, bool full)
{
    enum { MOST = 400 };
    collided *clients[MOST];
    int count = 0, most = full ? MOST : 40;
    collided_shape ball = collided_sphere(0.01);
    for (; count < most; count++) {
        collided_def def = collided_def_default();
        def.name = "many";
        def.connect_timeout_s = PATIENCE_SHORT_S;
        if (!(clients[count] = collided_connect(uri, &def))) break;
        put(clients[count], "many %zu", (size_t)count, &ball, count);
        watch(clients[count], "many *", "many *");
        collided_poll(clients[count], 0);
    }
    for (int round = 0; round < 100; round++)
        for (int i = 0; i < count; i++) collided_poll(clients[i], 0);
    for (int i = 0; i < count; i++) collided_close(clients[i]);
}

/* Recordings begun and ended without a pause, each of which holds the state of the whole world. */
static void recordings(const char *uri, bool full)
{
    collided_shape ball = collided_sphere(0.01);
    collided *c = enter(uri, "records");
    size_t count = full ? 100000 : 5000;
    for (size_t i = 0; i < count; i++) put(c, "grain %zu", i, &ball, (double)i);
    wait_for_all(c, full);
    for (int i = 0; i < 20; i++) {
        collided_result result = {0};
        char name[32];
        snprintf(name, sizeof name, "hostile %d", i);
        (void)collided_record(c, i % 2 ? NULL : name, 2, &result);
        collided_result_free(&result);
        stay(c, 0.1);
    }
    collided_close(c);
}

/* ---- far and fast ---- */

static void ask_for(collided *c, unsigned facts, double range_m, double horizon_s)
{
    collided_subscription_def def = collided_subscription_def_default();
    def.facts = facts;
    def.range_m = range_m;
    def.horizon_s = horizon_s;
    def.callback = on_nothing;
    def.context = &batches;
    (void)collided_subscribe(c, &def);
}

/* Everything is near everything, for who asks so. */
static void wide_range(const char *uri, bool full)
{
    collided_shape ball = collided_sphere(0.5);
    collided *c = enter(uri, "wide");
    size_t count = full ? 3000 : 400;
    ask_for(c, COLLIDED_DISTANCE, 1e9, 0);
    for (size_t i = 0; i < count; i++) put(c, "far %zu", i, &ball, 3.0 * (double)i);
    wait_for_all(c, full);
    stay(c, 2);
    collided_close(c);
}

/* Bodies that fly through each other's ways for a day to come, told over and over that they do. */
static void fast_and_predicted(const char *uri, bool full)
{
    size_t count = full ? 2000 : 300;
    collided_shape box = collided_box(0.3, 0.2, 0.1);
    collided *c = enter(uri, "fast");
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    double *speed = room(3 * count, sizeof *speed), *spin = room(3 * count, sizeof *spin);
    ask_for(c, COLLIDED_IMPACT | COLLIDED_PREDICT, 0, 86400);
    for (size_t i = 0; i < count; i++) {
        char name[32];
        collided_body_def def = collided_body_def_default();
        snprintf(name, sizeof name, "fast %zu", i);
        def.name = name;
        def.ccd = COLLIDED_CCD_FULL;
        def.shapes = &box;
        def.shape_count = 1;
        def.pose.position[0] = (double)i;
        bodies[i] = collided_create_body(c, &def);
    }
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 3);
    for (int round = 1; now_s() < end; round++) {
        for (size_t i = 0; i < count; i++) {
            at[3 * i] = (double)i + 0.1 * (round % 5);
            turn[4 * i] = 1;
            speed[3 * i] = i % 2 ? 1e3 : -1e3;
            speed[3 * i + 1] = 1e-3 * (double)i;
            spin[3 * i + 2] = 1e4;
        }
        collided_publish(c, count, bodies, at, turn, speed, spin, 0, 0);
        collided_poll(c, 0.02);
    }
    collided_close(c);
    free(bodies);
    free(at);
    free(turn);
    free(speed);
    free(spin);
}

/* Bodies put and taken away without a pause, with all that asks for them. */
static void churn(const char *uri, bool full)
{
    collided_shape ball = collided_sphere(0.5);
    collided *c = enter(uri, "churn");
    watch(c, "churn *", "*");
    double end = now_s() + (full ? 20 : 3);
    while (now_s() < end) {
        collided_body bodies[200];
        for (size_t i = 0; i < 200; i++) bodies[i] = put(c, "churn %zu", i, &ball, 1e-3 * (double)i);
        collided_poll(c, 0.01);
        for (size_t i = 0; i < 200; i++) (void)collided_remove_body(c, bodies[i]);
        collided_poll(c, 0);
    }
    collided_close(c);
}

/* What a body would meet on its way, with hundreds in its way, asked again and again. */
static void sweeps(const char *uri, bool full)
{
    size_t count = full ? 20000 : 1500;
    collided_shape box = collided_box(0.1, 0.2, 0.3);
    const double linear[3] = {10, 1, 0.5}, angular[3] = {1, 20, 3};
    collided *c = enter(uri, "sweeps");
    for (size_t i = 0; i < count; i++) put(c, "swept %zu", i, &box, 0.2 * (double)(i % 50));
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 4);
    while (now_s() < end) {
        collided_result result = {0};
        (void)collided_query_sweep(c, "swept 0", linear, angular, 3600, 1e-9, 1e-3, &result);
        collided_result_free(&result);
    }
    collided_close(c);
}

/* As many bodies as there is room for, whose client then falls silent for good. */
static void lost_with_all(const char *uri, bool full)
{
    size_t count = full ? 200000 : 10000;
    collided_shape ball = collided_sphere(0.5);
    collided_def def = collided_def_default();
    def.name = "lost";
    def.lease_s = 0.5;
    def.connect_timeout_s = PATIENCE_SHORT_S;
    collided *c = collided_connect(uri, &def);
    if (!c) exit(1);
    watch(c, "lost *", "lost *");
    for (size_t i = 0; i < count; i++) put(c, "lost %zu", i, &ball, 0.9 * (double)i);
    wait_for_all(c, full);
    _exit(0); /* as if killed */
}

/* In lock-step with many who never come, and with steps that are begun and not ended. */
static void lock_step_alone(const char *uri, bool full)
{
    collided_shape ball = collided_sphere(0.5);
    collided_def def = collided_def_default();
    def.name = "step";
    def.lease_s = 60;
    def.connect_timeout_s = PATIENCE_SHORT_S;
    def.lock_step = 2;
    collided *c = collided_connect(uri, &def);
    if (!c) exit(1);
    size_t count = full ? 50000 : 2000;
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    for (size_t i = 0; i < count; i++) bodies[i] = put(c, "step %zu", i, &ball, 2.0 * (double)i);
    wait_for_all(c, full);
    for (size_t i = 0; i < count; i++) turn[4 * i] = 1;
    double end = now_s() + (full ? 10 : 3);
    for (int64_t step = 1; now_s() < end; step++) {
        collided_publish(c, count, bodies, at, turn, NULL, NULL, 0, step);
        collided_poll(c, 0.001);
    }
    collided_close(c);
    free(bodies);
    free(at);
    free(turn);
}

/* Alone in lock-step, with steps that move `count` bodies; `impacts`: somebody asks what they meet on their way. */
static void move_in_steps(const char *uri, bool full, size_t count, bool impacts)
{
    collided_shape ball = collided_sphere(0.01);
    collided_def def = collided_def_default();
    def.name = "step";
    def.lease_s = 60;
    def.connect_timeout_s = PATIENCE_SHORT_S;
    def.lock_step = 1;
    collided *c = collided_connect(uri, &def);
    if (!c) exit(1);
    collided_on_rejected(c, say_refusals, &refusals_told);
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    collided_subscription_def asked = collided_subscription_def_default();
    asked.select_a = asked.select_b = "step *";
    asked.facts = impacts ? COLLIDED_IMPACT : COLLIDED_TOUCH;
    asked.callback = on_nothing;
    asked.context = &batches;
    (void)collided_subscribe(c, &asked);
    for (size_t i = 0; i < count; i++) {
        char name[64];
        collided_body_def b = collided_body_def_default();
        snprintf(name, sizeof name, "step %zu", i);
        b.name = name;
        b.shapes = &ball;
        b.shape_count = 1;
        b.ccd = impacts ? COLLIDED_CCD_LINEAR : COLLIDED_CCD_OFF;
        b.pose.position[0] = 0.1 * (double)i;
        bodies[i] = collided_create_body(c, &b);
    }
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 4);
    for (int64_t step = 1; now_s() < end; step++) {
        for (size_t i = 0; i < count; i++) {
            at[3 * i] = 0.1 * (double)i + 0.05 * (double)(step % 2);
            at[3 * i + 1] = 0.1 * (double)(step % 9);
            turn[4 * i] = 1;
        }
        collided_publish(c, count, bodies, at, turn, NULL, NULL, 0, step);
        if (collided_step(c, step, full ? PATIENCE_S : PATIENCE_SHORT_S) != COLLIDED_OK) exit(1);
    }
    collided_close(c);
    free(bodies);
    free(at);
    free(turn);
}

static void lock_step_moving(const char *uri, bool full)
{
    move_in_steps(uri, full, full ? 40000 : 5000, false);
}

static void lock_step_impacts(const char *uri, bool full)
{
    move_in_steps(uri, full, full ? 40000 : 5000, true);
}

/* ---- many shapes ---- */

enum { SHAPES_MOST = 256 };

/* Bodies of as many shapes as there may be, moved and turned all at once, again and again. */
static void move_wide(collided *c, const collided_shape *shapes, size_t count, double seconds)
{
    collided_body *bodies = room(count, sizeof *bodies);
    double *at = room(3 * count, sizeof *at), *turn = room(4 * count, sizeof *turn);
    for (size_t i = 0; i < count; i++) {
        char name[32];
        collided_body_def def = collided_body_def_default();
        snprintf(name, sizeof name, "wide %zu", i);
        def.name = name;
        def.shapes = shapes;
        def.shape_count = SHAPES_MOST;
        def.pose.position[0] = 20.0 * (double)i;
        bodies[i] = collided_create_body(c, &def);
    }
    wait_for_all(c, true);
    double end = now_s() + seconds;
    for (int round = 1; now_s() < end; round++) {
        for (size_t i = 0; i < count; i++) {
            at[3 * i] = 20.0 * (double)i;
            at[3 * i + 1] = 0.7 * round;
            turn[4 * i] = 1;
            turn[4 * i + 1] = 0.1 * (round % 9);
        }
        collided_publish(c, count, bodies, at, turn, NULL, NULL, 0, 0);
        stay(c, 0.1);
    }
    collided_close(c);
    free(bodies);
    free(at);
    free(turn);
}

static void wide_bodies(const char *uri, bool full)
{
    collided_shape shapes[SHAPES_MOST];
    for (int i = 0; i < SHAPES_MOST; i++) {
        shapes[i] = collided_box(0.01, 0.02, 0.03);
        shapes[i].pose.position[0] = 0.05 * i;
    }
    move_wide(enter(uri, "wide"), shapes, full ? 5000 : 400, full ? 20 : 3);
}

/* The same of one hull of as many corners as there may be. */
static void wide_hulls(const char *uri, bool full)
{
    size_t corners = full ? 65535 : 20000;
    double *at = room(3 * corners, sizeof *at);
    collided_shape shapes[SHAPES_MOST];
    collided *c = enter(uri, "wide");
    for (size_t i = 0; i < corners; i++) { /* a spiral on a ball */
        double z = 2 * ((double)i + 0.5) / (double)corners - 1, r = sqrt(1 - z * z), angle = 2.399963 * (double)i;
        at[3 * i] = r * cos(angle);
        at[3 * i + 1] = r * sin(angle);
        at[3 * i + 2] = z;
    }
    collided_geometry hull = collided_create_hull(c, at, corners);
    for (int i = 0; i < SHAPES_MOST; i++) {
        shapes[i] = collided_hull(hull);
        shapes[i].pose.position[0] = 0.05 * i;
    }
    move_wide(c, shapes, full ? 2000 : 60, full ? 20 : 3);
    free(at);
}

/* Bodies of parts that fly and spin through each other, predicted for a day: each search may take long. */
static void predicted_parts(const char *uri, bool full)
{
    enum { PARTS = 10, MOST = 64 };
    size_t count = full ? MOST : 10;
    collided_shape parts[PARTS];
    for (int i = 0; i < PARTS; i++) {
        parts[i] = collided_cylinder(0.05, 0.6);
        parts[i].pose.position[0] = 0.1 * i;
        parts[i].pose.position[1] = 0.05 * (i % 3);
    }
    collided_shape whole = collided_compound(parts, PARTS);
    collided *c = enter(uri, "parts");
    collided_body bodies[MOST];
    double at[3 * MOST] = {0}, turn[4 * MOST] = {0}, speed[3 * MOST] = {0}, spin[3 * MOST] = {0};
    ask_for(c, COLLIDED_IMPACT | COLLIDED_PREDICT, 0, 86400);
    for (size_t i = 0; i < count; i++) {
        char name[32];
        collided_body_def def = collided_body_def_default();
        snprintf(name, sizeof name, "part %zu", i);
        def.name = name;
        def.ccd = COLLIDED_CCD_FULL;
        def.shapes = &whole;
        def.shape_count = 1;
        def.pose.position[0] = 2.0 * (double)i;
        bodies[i] = collided_create_body(c, &def);
    }
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 3);
    for (int round = 1; now_s() < end; round++) {
        for (size_t i = 0; i < count; i++) {
            at[3 * i] = 2.0 * (double)i + 0.1 * (round % 5);
            at[3 * i + 1] = 0.3 * (round % 20);
            turn[4 * i] = 1;
            speed[3 * i] = i % 2 ? 1e3 : -1e3;
            spin[3 * i] = 3e4;
            spin[3 * i + 1] = 1e4;
        }
        collided_publish(c, count, bodies, at, turn, speed, spin, 0, 0);
        collided_poll(c, 0.02);
    }
    collided_close(c);
}

/* One body that holds all others, which goes away and comes back. */
static void hub(const char *uri, bool full)
{
    size_t grains = full ? 400000 : 20000;
    const double apart = 0.01, length = apart * (double)grains;
    const collided_shape grain = collided_sphere(1e-3), ball = collided_sphere(length);
    collided *c = enter(uri, "hub");
    watch(c, "hub *", "*");
    for (size_t i = 0; i < grains; i++) put(c, "grain %zu", i, &grain, apart * (double)i);
    collided_body all = put(c, "hub %zu", 0, &ball, 0.5 * length);
    wait_for_all(c, full);
    double end = now_s() + (full ? 20 : 3);
    for (bool away = true; now_s() < end; away = !away) {
        const double at[3] = {0.5 * length + (away ? 4 * length : 0), 0, 0}, turn[4] = {1, 0, 0, 0};
        (void)collided_teleport(c, 1, &all, at, turn, NULL, NULL, 0, 0);
        stay(c, 0.5);
    }
    collided_close(c);
}

const attack attacks[] = {
    {"height_field", "the largest height field", height_field, 50},
    {"meshes", "two large meshes, one through the other, moving", meshes, 50},
    {"crowded_hulls", "hulls of points that are nearly on one circle", crowded_hulls, 50},
    {"compounds", "bodies of as many children as there may be", compounds, 50},
    {"hoard", "geometry that no body uses, as much as may be sent and more", hoard, 50},
    {"crowd_unasked", "all bodies at one place, and nobody asks", crowd_unasked, 50},
    {"crowd_asked", "all bodies at one place, which then move, asked for; and all leave", crowd_asked, 50},
    {"crowd_asked_later", "all bodies at one place, and who asks for everything again and again", crowd_asked_later,
        50},
    {"rules", "as many rules as a body may have, with many stars", rules, 50},
    {"subscriptions", "as many subscriptions as there may be, with many stars", subscriptions, 50},
    {"poses", "poses as fast as one process can send them", poses, 50},
    {"queries", "queries whose answers name every body, without waiting for them", queries, 50},
    {"names", "one process that is many clients", names, 50},
    {"recordings", "recordings begun and ended without a pause", recordings, 50},
    {"wide_range", "everybody is asked to be told of from everywhere", wide_range, 50},
    {"fast_and_predicted", "bodies that fly and spin, and are predicted for a day", fast_and_predicted, 50},
    {"churn", "bodies put and removed without a pause", churn, 50},
    {"sweeps", "what a body would meet within an hour, asked without a pause", sweeps, 50},
    {"wide_bodies", "bodies of 256 shapes, all moved at once", wide_bodies, 50},
    {"wide_hulls", "bodies of 256 hulls of very many corners, all moved at once", wide_hulls, 50},
    {"hub", "a body that holds very many others, teleported away and back", hub, 50},
    {"predicted_parts", "bodies of many parts that fly and spin, predicted for a day", predicted_parts, 50},
    {"lost_with_all", "a client with many bodies that is killed", lost_with_all, 50},
    {"lock_step_moving", "steps of lock-step that move very many bodies", lock_step_moving, 50},
    {"lock_step_impacts", "the same, of bodies that are asked what they meet on their way", lock_step_impacts, 50},
    {"soft_crumpled", "a cloth of crumpled noise, in which all features meet", attack_soft_crumpled, 50},
    {"soft_crowd", "many soft bodies at one place, asked for by many", attack_soft_crowd, 50},
    {"soft_large", "the largest soft body, through rigid shapes", attack_soft_large, 50},
    {"lock_step_alone", "steps that are never ended, in step with one who never comes", lock_step_alone, 50},
};
const size_t attack_count = sizeof attacks / sizeof *attacks;
