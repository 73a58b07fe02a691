/* attacks_soft: what one client may do with soft bodies: crumpled noise in which all features meet, as many of them as
 * there may be at one place, and the largest of all through rigid shapes. */
#include "attacks_soft.h"

#include <collided.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

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

static double noise(void)
{
    static uint64_t x = 88172645463325252u;
    x ^= x << 13, x ^= x >> 7, x ^= x << 17;
    return (double)(x >> 11) * 0x1p-53 - 0.5;
}

static size_t steps_told;

typedef struct cloth {
    collided *c;
    size_t side, points, triangles;
    double *at; /* where its vertices are to be */
    int32_t *index;
    collided_geometry surface;
    int64_t frame;
} cloth;

static cloth make_cloth(collided *c, size_t side, double apart)
{
    cloth s = {.c = c, .side = side, .points = side * side, .triangles = 2 * (side - 1) * (side - 1)};
    s.at = room(3 * s.points, sizeof *s.at), s.index = room(3 * s.triangles, sizeof *s.index);
    for (size_t i = 0; i < s.points; i++)
        s.at[3 * i] = apart * (double)(i % side), s.at[3 * i + 1] = apart * (double)(i / side);
    int32_t *to = s.index, row = (int32_t)side;
    for (int32_t v = 0; v + row < (int32_t)s.points; v++) {
        if (v % row == row - 1) continue;
        const int32_t two[6] = {v, v + 1, v + row, v + 1, v + row + 1, v + row};
        memcpy(to, two, sizeof two);
        to += 6;
    }
    s.surface = collided_create_soft(c, s.at, s.points, s.index, s.triangles, 1, 0);
    return s;
}

static void drop_cloth(cloth *s)
{
    fprintf(stderr, "  %zu steps of pairs were told\n", steps_told);
    free(s->at), free(s->index);
}

static collided_body put_cloth(const cloth *s, const char *format, int i)
{
    char name[64];
    const collided_shape shape = collided_soft(s->surface, 0.001);
    collided_body_def def = collided_body_def_default();
    snprintf(name, sizeof name, format, i);
    def.name = name, def.shapes = &shape, def.shape_count = 1;
    return collided_create_body(s->c, &def);
}

static void send(cloth *s, collided_body body)
{
    const collided_vertices v = {.count = s->points, .positions = s->at, .frame = ++s->frame};
    (void)collided_publish_vertices(s->c, body, &v);
}

static void on_steps(void *context, const collided_soft_steps *steps)
{
    *(size_t *)context += steps->pair_count;
}

static void on_events(void *context, const collided_batch *b)
{
    (void)context, (void)b;
}

static void ask_for_steps(collided *c)
{
    collided_subscription_def def = collided_subscription_def_default();
    const collided_soft_def soft = {.each_feature = true, .callback = on_steps, .context = &steps_told};
    def.facts = COLLIDED_TOUCH | COLLIDED_FEATURES | COLLIDED_SAFE_STEP;
    def.callback = on_events;
    if (collided_subscribe_soft(c, &def, &soft).id == COLLIDED_NONE) fprintf(stderr, "  %s\n", collided_error(c));
}

/* All meets all, in each frame anew. */
void attack_soft_crumpled(const char *uri, bool full)
{
    collided *c = attack_enter(uri, "crumpled");
    cloth s = make_cloth(c, full ? 250 : 60, 0.01);
    collided_body body = put_cloth(&s, "crumpled %d", 0);
    ask_for_steps(c);
    attack_wait(c, full);
    double end = now_s() + (full ? 30 : 5);
    while (now_s() < end) {
        for (size_t i = 0; i < 3 * s.points; i++) s.at[i] = noise();
        send(&s, body);
        collided_poll(c, 0.02);
    }
    collided_close(c);
    drop_cloth(&s);
}

/* Many small ones at one place, many times asked for. */
void attack_soft_crowd(const char *uri, bool full)
{
    enum { MOST = 300 };
    collided *c = attack_enter(uri, "soft crowd");
    cloth s = make_cloth(c, 8, 0.02);
    collided_body bodies[MOST];
    int count = full ? MOST : 120;
    for (int i = 0; i < count; i++) bodies[i] = put_cloth(&s, "rag %d", i);
    for (int i = 0; i < (full ? 400 : 60); i++) ask_for_steps(c);
    attack_wait(c, full);
    double end = now_s() + (full ? 30 : 5);
    while (now_s() < end) {
        for (int i = 0; i < count; i++) {
            for (size_t k = 0; k < 3 * s.points; k++) s.at[k] = 0.2 * noise();
            send(&s, bodies[i]);
        }
        collided_poll(c, 0.05);
    }
    collided_close(c);
    drop_cloth(&s);
}

/* The largest surface there may be, to and fro through rigid shapes. */
void attack_soft_large(const char *uri, bool full)
{
    enum { BALLS = 60 };
    collided *c = attack_enter(uri, "soft large");
    cloth s = make_cloth(c, full ? 620 : 200, 0.01);
    collided_body body = put_cloth(&s, "sail %d", 0);
    const collided_shape ball = collided_ellipsoid(0.3, 0.2, 0.1);
    for (int i = 0; i < BALLS; i++) {
        char name[32];
        collided_body_def def = collided_body_def_default();
        snprintf(name, sizeof name, "ball %d", i);
        def.name = name, def.shapes = &ball, def.shape_count = 1;
        def.pose.position[0] = 0.01 * (double)s.side * i / BALLS, def.pose.position[1] = 0.005 * (double)s.side;
        collided_create_body(c, &def);
    }
    ask_for_steps(c);
    attack_wait(c, full);
    double end = now_s() + (full ? 30 : 5);
    for (int round = 0; now_s() < end; round++) {
        for (size_t i = 0; i < s.points; i++) s.at[3 * i + 2] = (round % 2 ? 0.3 : -0.3) + 0.01 * sin(0.1 * (double)i);
        send(&s, body);
        collided_poll(c, 0.05);
    }
    collided_close(c);
    drop_cloth(&s);
}
