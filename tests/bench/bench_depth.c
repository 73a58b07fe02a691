/* bench_depth: how well the depth of overlapping meshes is bracketed, and what that takes.
 *
 * Pairs of machine parts (tests/narrow/cad.h), placed at random until they overlap, by kind and together: the median
 * and the 90th percentile of (hi - lo) / |lo|, of all queries the share that is certain, and the median and the
 * greatest time. Beside them the deep and the shallow contact of two bumpy meshes of 5,000 triangles, and of one and a
 * box: `brief` is what a subscription to touch asks, `measured` the depth within 1e-6 of the size. --bodies N: pairs a
 * kind. One thread; each time is the least of three. */
#include "bench.h"

#include "cad.h"
#include "narrow/narrow.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TRIES_MAX = 10000, ROUNDS = 3, RINGS = 49, SECTORS = 50 };

static narrow_scratch *scratch;
static bench_options options;

static narrow_result ask(const shape *a, const shape *b, pose b_in_a, bool brief)
{
    narrow_result r;
    const double size = shape_reach(a) + shape_reach(b);
    narrow_request q = {
        .facts = NARROW_VERDICT | NARROW_DISTANCE, .tolerance = 1e-6 * size, .range = INFINITY, .threshold = 0};
    q.brief = brief;
    narrow_query(a, b, &b_in_a, &q, NULL, scratch, &r);
    return r;
}

static int by_value(const void *x, const void *y)
{
    double a = *(const double *)x, b = *(const double *)y;
    return (a > b) - (a < b);
}

static double at_share(double *of, size_t count, double share)
{
    if (!count) return NAN;
    qsort(of, count, sizeof *of, by_value);
    size_t at = (size_t)(share * (double)count);
    return of[at < count ? at : count - 1];
}

typedef struct sample {
    double *widths, *us;
    size_t count, certain;
} sample;

static sample sample_of(size_t most)
{
    return (sample){calloc(most, sizeof(double)), calloc(most, sizeof(double)), 0, 0};
}

static void add(sample *s, const narrow_result *r, double us)
{
    s->widths[s->count] = r->lo < 0 ? (r->hi - r->lo) / -r->lo : 0;
    s->us[s->count++] = us;
    s->certain += r->status == NARROW_CERTAIN;
}

static double measure(const shape *a, const shape *b, pose at, bool brief, narrow_result *r)
{
    double least = INFINITY;
    for (int k = 0; k < ROUNDS; k++) {
        int64_t start = bench_now_ns();
        *r = ask(a, b, at, brief);
        least = fmin(least, 1e-3 * (double)(bench_now_ns() - start));
    }
    return least;
}

/* And frees it. */
static void tell(const char *scene, const char *asked, sample *s)
{
    double median = at_share(s->widths, s->count, 0.5), p90 = at_share(s->widths, s->count, 0.9);
    double us = at_share(s->us, s->count, 0.5), us_max = at_share(s->us, s->count, 1);
    double sure = s->count ? (double)s->certain / (double)s->count : 0;
    if (options.json)
        printf("{\"bench\":\"depth\",\"entry\":\"narrow_query\",\"scene\":\"%s\",\"asked\":\"%s\",\"pairs\":%zu,"
               "\"width_median\":%.3g,"
               "\"width_p90\":%.3g,\"certain\":%.3f,\"us_median\":%.1f,\"us_max\":%.1f}\n",
            scene, asked, s->count, median, p90, sure, us, us_max);
    else
        printf("%-18s %-9s %6zu %9.2g %9.2g %7.0f %% %9.1f %9.1f\n", scene, asked, s->count, median, p90, 100 * sure,
            us, us_max);
    fflush(stdout);
    free(s->widths);
    free(s->us);
}

/* ---- machine parts ---- */

static quat some_turn(dice *d)
{
    static const quat ABOUT_AXES[4] = {{1, 0, 0, 0}, {0.5, 0.5, 0.5, 0.5}, {0, 0, 1, 0}, {0.5, -0.5, 0.5, -0.5}};
    return dice_between(d, 0, 1) < 0.25 ? ABOUT_AXES[(int)dice_between(d, 0, 3.99)] : dice_quat(d);
}

static void one_pair(dice *d, cad_kind kind_a, cad_kind kind_b, bool brief, sample *of_kind, sample *of_all)
{
    soup x = cad_solid(kind_a, d), y = cad_solid(kind_b, d);
    mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
    shape a = mesh_shape(m, 0), b = mesh_shape(n, 0);
    for (int k = 0; k < TRIES_MAX; k++) {
        pose at = {dice_vec(d, -1.5, 1.5), some_turn(d)};
        narrow_result r = ask(&a, &b, at, true);
        if (!(r.hi < 0)) continue;
        double us = measure(&a, &b, at, brief, &r);
        add(of_kind, &r, us);
        add(of_all, &r, us);
        break;
    }
    mesh_destroy(m);
    mesh_destroy(n);
    soup_free(&x);
    soup_free(&y);
}

static void machine_parts(bool brief)
{
    const char *asked = brief ? "brief" : "measured";
    size_t each = options.bodies ? (size_t)options.bodies : 40;
    sample all = sample_of(each * CAD_KIND_COUNT);
    for (int kind = 0; kind < CAD_KIND_COUNT; kind++) {
        dice d = {(uint64_t)(1000 + kind)};
        sample s = sample_of(each);
        for (size_t k = 0; k < each; k++)
            one_pair(&d, (cad_kind)kind, (cad_kind)((kind + (int)k) % CAD_KIND_COUNT), brief, &s, &all);
        tell(cad_name((cad_kind)kind), asked, &s);
    }
    tell("all", asked, &all);
}

/* ---- 5,000 triangles ---- */

static soup bumpy(double x, double y, double z)
{
    soup s = soup_new();
    int32_t foot = soup_point(&s, vec(0, 0, z)), top = soup_point(&s, vec(0, 0, -z));
    for (int ring = 1; ring <= RINGS; ring++)
        for (int k = 0; k < SECTORS; k++) {
            double u = M_PI * ring / (RINGS + 1), v = 2 * M_PI * k / SECTORS, r = 1 + 0.2 * sin(4 * u) * sin(3 * v);
            soup_point(&s, vec(x * r * sin(u) * cos(v), y * r * sin(u) * sin(v), z * r * cos(u)));
        }
    for (int k = 0; k < SECTORS; k++) {
        int j = (k + 1) % SECTORS, last = 2 + (RINGS - 1) * SECTORS;
        soup_triangle(&s, foot, 2 + k, 2 + j);
        soup_triangle(&s, top, last + j, last + k);
        for (int i = 0; i + 1 < RINGS; i++)
            soup_quad(
                &s, 2 + i * SECTORS + k, 2 + (i + 1) * SECTORS + k, 2 + (i + 1) * SECTORS + j, 2 + i * SECTORS + j);
    }
    return s;
}

static void of_many_triangles(bool beside_box, bool deep, bool brief)
{
    dice d = {77};
    soup x = bumpy(1, 0.8, 0.6), y = bumpy(0.7, 0.9, 1);
    mesh *m = soup_mesh(&x), *n = soup_mesh(&y);
    shape a = beside_box ? (shape){.type = SHAPE_BOX, .half = {0.3, 0.4, 0.5}} : mesh_shape(m, 0);
    shape b = mesh_shape(n, 0);
    sample s = sample_of(20);
    while (s.count < 20) {
        vec3 way = vec_unit(dice_vec(&d, -1, 1));
        quat q = dice_quat(&d);
        double near = 0, far = 3; /* the last overlap on that way */
        for (int k = 0; k < 30; k++) {
            double middle = (near + far) / 2;
            narrow_result r = ask(&a, &b, (pose){vec_scale(way, middle), q}, true);
            if (r.hi < 0)
                near = middle;
            else
                far = middle;
        }
        narrow_result r;
        pose at = {vec_scale(way, near - (deep ? 0.35 : 0.002)), q};
        double us = measure(&a, &b, at, brief, &r);
        add(&s, &r, us);
    }
    char scene[40];
    snprintf(scene, sizeof scene, "5,000 %s %s", beside_box ? "and box" : "twice", deep ? "deep" : "shallow");
    tell(scene, brief ? "brief" : "measured", &s);
    mesh_destroy(m);
    mesh_destroy(n);
    soup_free(&x);
    soup_free(&y);
}

int main(int argc, char **argv)
{
    if (!bench_parse(argc, argv, 1, 1, &options)) return 2;
    scratch = aligned_alloc(64, narrow_scratch_size());
    if (!options.json) puts("scene              asked      pairs   width, median and p90   certain   us, median, max");
    for (int brief = 1; brief >= 0; brief--) {
        for (int k = 0; k < 4; k++) of_many_triangles(k & 1, k & 2, brief);
        machine_parts(brief);
    }
    free(scratch);
    return 0;
}
