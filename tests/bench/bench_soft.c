/* bench_soft: a step of deformable meshes with themselves, by scene and by what is asked: verdicts, brackets of time,
 * or the safe step alone. Made cloths, calm and violent, frame by frame; whole published frames (COLLIDED_SHARED)
 * against their exact truth. Processor time of one thread, of soft_step_begin (which makes the boxes anew) and
 * soft_step_run. `missed` and `extra`: contacts that are not, and that are beyond those of the truth; of a made cloth
 * those of a run without boxes of features, directions and stars. `within`: not told from contact by rounding. --bodies
 * N: cells a side of the cloth alone. */
#include "bench.h"

#include "soft/soft.h"
#include "soft_scene.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { FRAMES_MAX = 400, CONTACTS_MOST = 4000000, CELLS_SMALL = 59, CELLS_LARGE = 215 };

static bench_options options;

static int64_t cpu_ns(void)
{
    struct timespec t;
    if (clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t) != 0) abort();
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

typedef struct stage {
    soft_mesh *mesh;
    soft_body *body;
    soft_step *step;
} stage;

static stage set_stage(const soft_scene *s)
{
    soft_status status;
    stage g;
    soft_mesh_def def = {.rest = s->start,
        .vertex_count = s->vertex_count,
        .triangles = s->triangles,
        .triangle_count = s->triangle_count};
    g.mesh = soft_mesh_create(&def, &status);
    if (!g.mesh) abort();
    g.body = soft_body_create(g.mesh);
    g.step = soft_step_create(NULL);
    return g;
}

static void strike(stage *g)
{
    soft_step_destroy(g->step), soft_body_destroy(g->body), soft_mesh_destroy(g->mesh);
}

static int64_t take(stage *g, const soft_scene *s, soft_want want, unsigned without)
{
    soft_step_def def = {.bodies = &g->body,
        .body_count = 1,
        .pairs = &(soft_pair){0, 0},
        .pair_count = 1,
        .want = want,
        .contacts_max = CONTACTS_MOST,
        .without = without};
    if (soft_body_set(g->body, s->start, s->end) != SOFT_OK) abort();
    int64_t start = cpu_ns();
    if (soft_step_begin(g->step, &def) != SOFT_OK || soft_step_run(g->step, 0) != SOFT_OK) abort();
    return cpu_ns() - start;
}

typedef struct score {
    size_t contacts, missed, extra, within;
} score;

/* Keys of contacts, with the kind on top. */
static uint64_t *keys_of(const soft_step *step, size_t *count)
{
    const soft_contact *c = soft_step_contacts(step, count);
    uint64_t *keys = malloc((*count + 1) * sizeof *keys);
    if (!keys) abort();
    for (size_t i = 0; i < *count; i++) keys[i] = (uint64_t)c[i].kind << 62 | (uint64_t)c[i].a << 32 | c[i].b;
    return keys;
}

static void compare(const uint64_t *truth, size_t true_count, const soft_step *step, score *out)
{
    size_t count, i = 0, k = 0;
    uint64_t *found = keys_of(step, &count);
    while (i < true_count || k < count) {
        bool lost = k == count || (i < true_count && truth[i] < found[k]);
        bool more = !lost && (i == true_count || found[k] < truth[i]);
        out->missed += lost, out->extra += more;
        i += !more, k += !lost;
    }
    const soft_tally *t = soft_step_tallies(step);
    out->contacts += count, out->within += t->within + t->undecided;
    free(found);
}

static void tell(
    const char *scene, const char *asked, const stage *g, bench_samples *times, const score *s, size_t frames)
{
    double median = 1e-3 * bench_percentile_us(times, 0.5), p99 = 1e-3 * bench_percentile_us(times, 0.99);
    size_t triangles = soft_mesh_triangle_count(g->mesh);
    double bytes = (double)(soft_mesh_bytes(g->mesh) + soft_body_bytes(g->body)) / (double)triangles;
    soft_work w = soft_step_work(g->step);
    if (options.json)
        printf("{\"bench\":\"soft\",\"scene\":\"%s\",\"asked\":\"%s\",\"contender\":\"collided\","
               "\"entry\":\"soft_step_begin, soft_step_run\",\"triangles\":%zu,\"ms_median\":%.3f,\"ms_p99\":%.3f,"
               "\"contacts\":%zu,\"missed\":%zu,\"extra\":%zu,\"within\":%zu,\"frames\":%zu,\"candidates\":%llu,"
               "\"tests\":%llu,\"bytes_per_triangle\":%.0f}\n",
            scene, asked, triangles, median, p99, s->contacts, s->missed, s->extra, s->within, frames,
            (unsigned long long)w.candidates, (unsigned long long)w.tests, bytes);
    else
        printf("%-22s %-10s %9zu %9.3f %9.3f %9zu %7zu %6zu %7zu %10llu %9llu %6.0f\n", scene, asked, triangles, median,
            p99, s->contacts, s->missed, s->extra, s->within, (unsigned long long)w.candidates,
            (unsigned long long)w.tests, bytes);
    (void)fflush(stdout);
}

static const char *const ASKED[] = {"verdicts", "brackets", "safe step"};

/* ---- cloth ---- */

static void cloth(const char *name, size_t cells, double violence, soft_want want)
{
    const double dt = 0.002;
    bench_samples times;
    score s = {0};
    soft_scene scene = soft_scene_cloth(cells, 0, dt, 0);
    stage g = set_stage(&scene), bare = set_stage(&scene);
    soft_scene_free(&scene);
    if (!bench_samples_init(&times, FRAMES_MAX)) abort();
    int64_t end = bench_now_ns() + (int64_t)(1e9 * options.seconds);
    size_t frames = 0;
    for (; frames < FRAMES_MAX && (frames < 3 || bench_now_ns() < end); frames++) {
        scene = soft_scene_cloth(cells, dt * (double)frames, dt, violence);
        bench_samples_add(&times, take(&g, &scene, want, 0));
        if (frames == 0 && want != SOFT_SAFE_STEP) {
            size_t count;
            take(&bare, &scene, want, SOFT_WITHOUT_DIRECTIONS | SOFT_WITHOUT_STARS | SOFT_WITHOUT_BOXES);
            uint64_t *truth = keys_of(bare.step, &count);
            compare(truth, count, g.step, &s);
            free(truth);
        }
        soft_scene_free(&scene);
    }
    tell(name, ASKED[want], &g, &times, &s, frames);
    bench_samples_free(&times), strike(&g), strike(&bare);
}

/* ---- published frames ---- */

static uint64_t *read_truth(const soft_truth *t, const soft_mesh *m, size_t *count)
{
    size_t faces, edges;
    uint64_t *vf = soft_truth_read(t, m, SOFT_VERTEX_FACE, &faces), *ee = soft_truth_read(t, m, SOFT_EDGE_EDGE, &edges);
    uint64_t *all = malloc((faces + edges + 1) * sizeof *all);
    if (!all) abort();
    memcpy(all, vf, faces * sizeof *all);
    for (size_t i = 0; i < edges; i++) all[faces + i] = ee[i] | (uint64_t)SOFT_EDGE_EDGE << 62;
    *count = faces + edges;
    free(vf), free(ee);
    return all;
}

static void published(const soft_truth *t)
{
    soft_scene scene;
    if (!soft_scene_read(t, &scene)) {
        (void)fprintf(stderr, "cases/soft/%s is not there (COLLIDED_SHARED)\n", t->name);
        return;
    }
    stage g = set_stage(&scene);
    size_t count;
    uint64_t *truth = read_truth(t, g.mesh, &count);
    for (int want = 0; want < 3; want++) {
        bench_samples times;
        score s = {0};
        if (!bench_samples_init(&times, FRAMES_MAX)) abort();
        int64_t end = bench_now_ns() + (int64_t)(1e9 * options.seconds);
        size_t frames = 0;
        for (; frames < FRAMES_MAX && (frames < 3 || bench_now_ns() < end); frames++)
            bench_samples_add(&times, take(&g, &scene, (soft_want)want, 0));
        if (want != SOFT_SAFE_STEP) compare(truth, count, g.step, &s);
        tell(t->name, ASKED[want], &g, &times, &s, frames);
        bench_samples_free(&times);
    }
    free(truth), strike(&g), soft_scene_free(&scene);
}

int main(int argc, char **argv)
{
    if (!bench_parse(argc, argv, 1, 10, &options)) return 64;
    if (!options.json)
        printf("%-22s %-10s %9s %9s %9s %9s %7s %6s %7s %10s %9s %6s\n", "scene", "asked", "triangles", "ms", "p99",
            "contacts", "missed", "extra", "within", "candidates", "tests", "B/tri");
    size_t small = options.bodies ? (size_t)options.bodies : CELLS_SMALL;
    for (int want = 0; want < 3; want++) {
        cloth("cloth, calm", small, 0, (soft_want)want);
        cloth("cloth, violent", small, 1, (soft_want)want);
    }
    if (options.bodies) return 0;
    cloth("large cloth, calm", CELLS_LARGE, 0, SOFT_BRACKETS);
    for (size_t i = 0; i < SOFT_TRUTHS; i++) published(&SOFT_TRUTH[i]);
    return 0;
}
