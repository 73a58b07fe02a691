/* cloth: a simulator of cloth that never passes through itself, nor through the ball that it falls on. Each step is
 * first proposed: the daemon answers which features would meet, and which share of the way is free for certain. What
 * would meet is stopped, and asked about again; if that does not help, all go a share of the way. What is free is gone,
 * and published; the daemon's answer to that, about the very numbers, says whether it was free. One thread.
 *
 * The cloth is a grid of particles under gravity, with springs between neighbours (position based dynamics, Müller et
 * al. 2007), pinned at two corners until it swings down. Contacts push back: what the proposal says meets is stopped.
 */
#include "example.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    SIDE = 45,
    COUNT = SIDE * SIDE,
    TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1),
    RELAXED = 12,
    STOPS = 24,
    HALVINGS = 12,
    EDGES = 2 * SIDE * (SIDE - 1) + (SIDE - 1) * (SIDE - 1)
};
static const double SPACING = 0.02, STEP_S = 0.005, GRAVITY = 9.81, DAMPING = 0.02;
static const double THICKNESS = 0.002, BALL_RADIUS = 0.25, BALL_HEIGHT = 0.3;

typedef struct cloth {
    collided *c;
    collided_body body;
    double at[3 * COUNT], before[3 * COUNT], next[3 * COUNT]; /* m */
    int32_t triangles[3 * TRIANGLES];
    int edges[EDGES][2]; /* as the daemon counts them: by the lesser end, then by the greater */
    bool stopped[COUNT];
    int64_t frame;
    /* the answer that is waited for */
    int64_t awaited;
    bool proposed, answered, free;
    double safe;
    uint64_t contacts;
    /* so far */
    uint64_t steps, shortened, refused;
    bool pinned;
} cloth;

static void stop(cloth *x, bool is_edge, bool is_face, uint32_t n)
{
    if (is_edge)
        for (int k = 0; k < 2; k++) x->stopped[x->edges[n][k]] = true;
    else if (is_face)
        for (int k = 0; k < 3; k++) x->stopped[x->triangles[3 * n + (uint32_t)k]] = true;
    else
        x->stopped[n] = true;
}

/* What meets is not to move; of the ball there is nothing to stop. */
static void stop_features(cloth *x, const collided_soft_pair *p)
{
    bool cloth_is_b = strcmp(p->name_a, "cloth") != 0;
    for (size_t i = 0; i < p->feature_count; i++) {
        const collided_feature *f = &p->features[i];
        bool edges = f->kind == COLLIDED_EDGE_EDGE;
        if (f->kind == COLLIDED_FACE_SHAPE) {
            stop(x, false, true, f->a);
            continue;
        }
        if (!cloth_is_b) stop(x, edges, f->kind == COLLIDED_FACE_VERTEX, f->a);
        stop(x, edges, f->kind == COLLIDED_VERTEX_FACE, f->b);
    }
}

/* Of all pairs of the step the least. */
static void on_steps(void *context, const collided_soft_steps *steps)
{
    cloth *x = context;
    for (size_t i = 0; i < steps->pair_count; i++) {
        const collided_soft_pair *p = &steps->pairs[i];
        int64_t frame = p->frame_a > p->frame_b ? p->frame_a : p->frame_b;
        if (frame != x->awaited || p->proposed != x->proposed) continue;
        if (p->safe_lo < x->safe) x->safe = p->safe_lo;
        x->contacts += p->vertex_face + p->edge_edge + p->face_shape;
        stop_features(x, p);
        x->answered = true;
    }
}

static void on_events(void *context, const collided_batch *batch)
{
    (void)context, (void)batch;
}

static void make_cloth(cloth *x)
{
    const double HALF = 0.5 * (SIDE - 1);
    for (int r = 0, t = 0; r < SIDE; r++)
        for (int k = 0; k < SIDE; k++) {
            int v = r * SIDE + k;
            double *p = x->at + 3 * v;
            p[0] = (k - HALF) * SPACING, p[1] = (r - HALF) * SPACING;
            p[2] = BALL_HEIGHT + BALL_RADIUS + 0.1 + 1e-4 * ((v * 7919) % 13); /* not quite flat */
            if (r == SIDE - 1 || k == SIDE - 1) continue;
            /* cells are cut from (k + 1, r) to (k, r + 1) */
            const int32_t two[6] = {v, v + 1, v + SIDE, v + 1, v + SIDE + 1, v + SIDE};
            memcpy(x->triangles + t, two, sizeof two);
            t += 6;
        }
    memcpy(x->before, x->at, sizeof x->at);
    for (int v = 0, n = 0; v < COUNT; v++) {
        int r = v / SIDE, k = v % SIDE;
        const int other[3] = {k + 1 < SIDE ? v + 1 : -1, k > 0 && r + 1 < SIDE ? v + SIDE - 1 : -1,
            r + 1 < SIDE ? v + SIDE : -1}; /* rising */
        for (int i = 0; i < 3; i++)
            if (other[i] >= 0) x->edges[n][0] = v, x->edges[n++][1] = other[i];
    }
}

/* ---- the physics, which knows of no contact but what it is told ---- */

static bool is_pinned(const cloth *x, int v)
{
    return x->pinned && (v == 0 || v == SIDE - 1);
}

static void pull(cloth *x, int a, int b, double length)
{
    double *p = x->next + 3 * a, *q = x->next + 3 * b, d[3], norm = 0;
    for (int k = 0; k < 3; k++) d[k] = q[k] - p[k], norm += d[k] * d[k];
    norm = sqrt(norm);
    if (norm < 1e-12) return;
    double wa = !is_pinned(x, a), wb = !is_pinned(x, b), sum = wa + wb;
    if (sum == 0) return;
    double by = (norm - length) / norm / sum;
    for (int k = 0; k < 3; k++) p[k] += wa * by * d[k], q[k] -= wb * by * d[k];
}

static void relax(cloth *x)
{
    for (int r = 0; r < SIDE; r++)
        for (int k = 0; k < SIDE; k++) {
            int v = r * SIDE + k;
            if (k + 1 < SIDE) pull(x, v, v + 1, SPACING);
            if (r + 1 < SIDE) pull(x, v, v + SIDE, SPACING);
            if (k + 1 < SIDE && r + 1 < SIDE) pull(x, v, v + SIDE + 1, SPACING * sqrt(2.0));
            if (k && r + 1 < SIDE) pull(x, v, v + SIDE - 1, SPACING * sqrt(2.0));
        }
}

/* The ball pushes out what would be in it: a contact model, as good as it is; that nothing passes is the daemon's word.
 */
static void push_out(cloth *x)
{
    double least = BALL_RADIUS + 2 * THICKNESS;
    for (int v = 0; v < COUNT; v++) {
        double *p = x->next + 3 * v, d[3] = {p[0], p[1], p[2] - BALL_HEIGHT};
        double norm = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        if (norm >= least || norm == 0) continue;
        for (int k = 0; k < 3; k++) p[k] += d[k] * (least / norm - 1);
    }
}

static void integrate(cloth *x)
{
    for (int i = 0; i < 3 * COUNT; i++) {
        double velocity = (1 - DAMPING) * (x->at[i] - x->before[i]);
        x->next[i] =
            is_pinned(x, i / 3) ? x->at[i] : x->at[i] + velocity - (i % 3 == 2 ? GRAVITY * STEP_S * STEP_S : 0);
    }
    for (int i = 0; i < RELAXED; i++) relax(x), push_out(x);
}

/* ---- lock-step with the daemon ---- */

static bool await(cloth *x, bool proposed)
{
    for (int i = 0; i < 500 && !x->answered; i++)
        if (collided_poll(x->c, 0.01) == COLLIDED_NO_DAEMON) return false;
    (void)proposed;
    return x->answered;
}

/* Asks, or goes; the share of the way that is free for certain is in x->safe. */
static bool send(cloth *x, bool proposed, const double *to)
{
    const collided_vertices v = {.positions = to, .count = COUNT, .frame = ++x->frame};
    x->awaited = x->frame, x->proposed = proposed, x->answered = false, x->safe = 1, x->contacts = 0;
    collided_status s =
        proposed ? collided_propose_vertices(x->c, x->body, &v) : collided_publish_vertices(x->c, x->body, &v);
    if (!example_ok(x->c, s, "vertices")) return false;
    collided_flush(x->c);
    return await(x, proposed);
}

/* What is scaled is another way: it is asked about, too, before it is gone. */
static bool step(cloth *x)
{
    double share = 1, target[3 * COUNT];
    memset(x->stopped, 0, sizeof x->stopped);
    for (int tries = 0;; tries++) {
        for (int i = 0; i < 3 * COUNT; i++)
            target[i] = x->stopped[i / 3] ? x->at[i]
                        : share == 1      ? x->next[i]
                                          : x->at[i] + share * (x->next[i] - x->at[i]);
        if (share == 0) break;
        if (!send(x, true, target)) return false;
        if (x->safe == 1) break;
        x->shortened++;
        if (tries >= STOPS) share *= tries < STOPS + HALVINGS ? 0.9 * x->safe : 0;
    }
    if (!send(x, false, target)) return false;
    if (x->safe < 1) x->refused++; /* it stood within rounding of a contact already */
    memcpy(x->before, x->at, sizeof x->at);
    memcpy(x->at, target, sizeof x->at);
    for (int i = 0; i < 3 * COUNT; i++)
        if (share < 1 || x->stopped[i / 3]) x->before[i] = x->at[i]; /* what was stopped has lost its speed */
    x->steps++;
    return true;
}

static bool connect(cloth *x, const example *e)
{
    collided_def def = collided_def_default();
    def.name = "cloth", def.interface = e->interface;
    x->c = example_connect(e, &def);
    if (!x->c) return false;
    collided_geometry surface = collided_create_soft(x->c, x->at, COUNT, x->triangles, TRIANGLES, 1, 0);
    collided_shape soft = collided_soft(surface, THICKNESS), ball = collided_sphere(BALL_RADIUS);
    collided_body_def body = collided_body_def_default();
    body.name = "cloth", body.shapes = &soft, body.shape_count = 1;
    x->body = collided_create_body(x->c, &body);
    body = collided_body_def_default();
    body.name = "ball", body.shapes = &ball, body.shape_count = 1, body.motion = COLLIDED_FIXED;
    body.pose.position[2] = BALL_HEIGHT;
    collided_create_body(x->c, &body);
    collided_subscription_def all = collided_subscription_def_default();
    all.facts = COLLIDED_TOUCH | COLLIDED_FEATURES | COLLIDED_SAFE_STEP;
    all.callback = on_events;
    const collided_soft_def steps = {.each_feature = true, .callback = on_steps, .context = x};
    if (collided_subscribe_soft(x->c, &all, &steps).id == COLLIDED_NONE) return false;
    return example_ok(x->c, collided_sync(x->c, 10), "the cloth");
}

static void write_picture(const cloth *x, const char *path);

int main(int argc, char **argv)
{
    static cloth x = {.pinned = true};
    const char *picture = getenv("CLOTH_PICTURE"), *most = getenv("CLOTH_STEPS"), *dump = getenv("CLOTH_FRAMES");
    long steps = most ? strtol(most, NULL, 10) : 2000;
    example e = example_start(argc, argv);
    make_cloth(&x);
    if (!connect(&x, &e)) return EXIT_FAILURE;
    FILE *frames = dump ? fopen(dump, "wb") : NULL;
    while (example_running(&e) && (long)x.steps < steps) {
        x.pinned = x.steps < 400;
        integrate(&x);
        if (!step(&x)) {
            fprintf(stderr, "cloth: no answer to frame %lld\n", (long long)x.frame);
            return EXIT_FAILURE;
        }
        if (frames) fwrite(x.at, sizeof x.at, 1, frames);
        if (x.steps % 100 == 0)
            example_note(&e, "step %llu: %llu shortened, %llu within rounding", (unsigned long long)x.steps,
                (unsigned long long)x.shortened, (unsigned long long)x.refused);
    }
    if (frames) fclose(frames);
    if (picture) write_picture(&x, picture);
    collided_close(x.c);
    return EXIT_SUCCESS;
}

/* ---- the picture: from the side, the far triangles first ---- */

static const cloth *pictured;

static double depth_of(const int32_t *t)
{
    double sum = 0;
    for (int k = 0; k < 3; k++) sum += pictured->at[3 * t[k] + 1] - 0.6 * pictured->at[3 * t[k] + 2];
    return sum;
}

static int compare_depths(const void *a, const void *b)
{
    double x = depth_of(a), y = depth_of(b);
    return (x < y) - (x > y);
}

static void write_picture(const cloth *x, const char *path)
{
    static int32_t order[3 * TRIANGLES];
    FILE *f = fopen(path, "w");
    if (!f) return;
    memcpy(order, x->triangles, sizeof order);
    pictured = x;
    qsort(order, TRIANGLES, 3 * sizeof *order, compare_depths);
    fprintf(f,
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='-0.7 -1 1.4 1.2' width='700' height='600'>\n"
        "<rect x='-0.7' y='-1' width='1.4' height='1.2' fill='#fff'/>\n"
        "<circle cx='0' cy='%.3f' r='%.3f' fill='#b9c4cf'/>\n",
        -0.8 * BALL_HEIGHT, BALL_RADIUS);
    for (int i = 0; i < TRIANGLES; i++) {
        const int32_t *t = order + 3 * i;
        double u[3], v[3], n[3];
        for (int k = 0; k < 3; k++) {
            u[k] = x->at[3 * t[1] + k] - x->at[3 * t[0] + k];
            v[k] = x->at[3 * t[2] + k] - x->at[3 * t[0] + k];
        }
        n[0] = u[1] * v[2] - u[2] * v[1], n[1] = u[2] * v[0] - u[0] * v[2], n[2] = u[0] * v[1] - u[1] * v[0];
        double norm = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        int light = (int)(110 + 120 * fabs(0.3 * n[0] - 0.5 * n[1] + 0.8 * n[2]) / fmax(norm, 1e-12));
        light = light > 250 ? 250 : light;
        fprintf(f, "<path d='M");
        for (int k = 0; k < 3; k++)
            fprintf(f, "%.4f %.4f ", x->at[3 * t[k]], -0.8 * x->at[3 * t[k] + 2] - 0.6 * x->at[3 * t[k] + 1] * 0.5);
        fprintf(f, "z' fill='rgb(%d,%d,%d)'/>\n", light, light * 2 / 3, light / 3);
    }
    fprintf(f, "</svg>\n");
    fclose(f);
}
