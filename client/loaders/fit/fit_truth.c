/* fit_truth: spheres by rings of points; cylinders and capsules by moving circles and spheres along their axis. */
#include "fit_truth.h"

#include "loaders/decompose/decompose.h"
#include "loaders/decompose/vec3.h"
#include "loaders/rigid.h"

enum { SECTORS = 32, RINGS = 15, BALL_POINTS = SECTORS * RINGS + 2 };

typedef struct gathering {
    pool *pool;
    fit_truth *out;
} gathering;

static void into_link(const collided_pose *pose, double *points, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        double turned[3];
        rigid_rotate(pose->orientation, points + 3 * i, turned);
        for (size_t k = 0; k < 3; k++) points[3 * i + k] = turned[k] + pose->position[k];
    }
}

static void take_outer(gathering *g, const double *points, size_t count)
{
    double *all = pool_alloc(g->pool, g->out->outer_count + count, 3 * sizeof *all);
    if (g->out->outer_count > 0) memcpy(all, g->out->outer, 3 * g->out->outer_count * sizeof *all);
    memcpy(all + 3 * g->out->outer_count, points, 3 * count * sizeof *all);
    g->out->outer = all;
    g->out->outer_count += count;
}

static void take_inner(gathering *g, const double *points, size_t count, const int32_t *corners, size_t triangles)
{
    mesh_triangles *old = &g->out->inner;
    double *all = pool_alloc(g->pool, old->point_count + count, 3 * sizeof *all);
    int32_t *ends = pool_alloc(g->pool, old->count + triangles, 3 * sizeof *ends);
    if (old->count > 0) {
        memcpy(all, old->points, 3 * old->point_count * sizeof *all);
        memcpy(ends, old->corners, 3 * old->count * sizeof *ends);
    }
    memcpy(all + 3 * old->point_count, points, 3 * count * sizeof *all);
    for (size_t i = 0; i < 3 * triangles; i++) ends[3 * old->count + i] = corners[i] + (int32_t)old->point_count;
    *old = (mesh_triangles){all, old->point_count + count, ends, old->count + triangles};
}

static void take_mesh(gathering *g, const load_shape *s)
{
    const mesh_triangles *m = &s->triangles;
    double *points = pool_alloc(g->pool, m->point_count, 3 * sizeof *points);
    memcpy(points, m->points, 3 * m->point_count * sizeof *points);
    into_link(&s->shape.pose, points, m->point_count);
    take_outer(g, points, m->point_count);
    take_inner(g, points, m->point_count, m->corners, m->count);
}

/* Unit vectors all around. */
static size_t ball(double *out)
{
    double pi = acos(-1);
    size_t n = 0;
    for (int ring = 0; ring <= RINGS + 1; ring++) {
        double height = cos(pi * ring / (RINGS + 1)), r = sin(pi * ring / (RINGS + 1));
        bool pole = ring == 0 || ring == RINGS + 1;
        for (int i = 0; i < (pole ? 1 : SECTORS); i++, n++) {
            out[3 * n] = pole ? 0 : r * cos(2 * pi * i / SECTORS);
            out[3 * n + 1] = pole ? 0 : r * sin(2 * pi * i / SECTORS);
            out[3 * n + 2] = height;
        }
    }
    return n;
}

/* By how much the ball's points have to be moved outward to hold the ball. */
static double ball_outward(void)
{
    pool work = {0};
    double points[3 * BALL_POINTS], least = 1;
    fit_hull h;
    if (fit_hull_make(&work, points, ball(points), &h))
        for (size_t i = 0; i < h.plane_count; i++) least = fmin(least, h.planes[i].offset - h.slack);
    pool_free(&work);
    return 1 / least;
}

/* Points of a sphere, capsule or cylinder: outer ones are moved outward from the axis by `outward`. */
static size_t round_points(const collided_shape *s, double outward, double *out)
{
    double pi = acos(-1), half = s->type == COLLIDED_SPHERE ? 0 : s->half[2], unit[3 * BALL_POINTS];
    size_t n = 0, count = 0;
    if (s->type == COLLIDED_CYLINDER) {
        for (int i = 0; i < SECTORS; i++, count++) {
            double way[3] = {cos(2 * pi * i / SECTORS), sin(2 * pi * i / SECTORS), 0};
            memcpy(unit + 3 * count, way, sizeof way);
        }
    } else {
        count = ball(unit);
    }
    double r = outward * (s->type == COLLIDED_CYLINDER ? s->half[0] : s->radius);
    for (int side = -1; side <= 1; side += 2)
        for (size_t i = 0; i < count; i++, n++) {
            for (size_t k = 0; k < 3; k++) out[3 * n + k] = r * unit[3 * i + k];
            out[3 * n + 2] += side * half;
        }
    return n;
}

static size_t box_points(const collided_shape *s, double *out)
{
    for (int i = 0; i < 8; i++)
        for (int k = 0; k < 3; k++) out[3 * i + k] = i >> k & 1 ? s->half[k] : -s->half[k];
    return 8;
}

static bool take_round(gathering *g, const load_shape *from)
{
    const collided_shape *s = &from->shape;
    bool box = s->type == COLLIDED_BOX;
    if (!box && s->type != COLLIDED_SPHERE && s->type != COLLIDED_CAPSULE && s->type != COLLIDED_CYLINDER) return false;
    double points[6 * BALL_POINTS], pi = acos(-1);
    double outward = s->type == COLLIDED_CYLINDER ? 1 / cos(pi / SECTORS) : ball_outward();
    size_t count = box ? box_points(s, points) : round_points(s, outward * (1 + 0x1p-40), points);
    into_link(&s->pose, points, count);
    take_outer(g, points, count);
    count = box ? box_points(s, points) : round_points(s, 1 - 0x1p-40, points);
    into_link(&s->pose, points, count);
    pool work = {0};
    fit_hull h;
    bool solid = fit_hull_make(&work, points, count, &h);
    if (solid) take_inner(g, h.points, h.count, h.corners[0], h.plane_count);
    pool_free(&work);
    return solid;
}

bool fit_truth_of(pool *p, const load_shape *shapes, size_t count, fit_truth *out)
{
    *out = (fit_truth){0};
    gathering g = {.pool = p, .out = out};
    for (size_t i = 0; i < count; i++) {
        if (shapes[i].shape.type == COLLIDED_MESH)
            take_mesh(&g, &shapes[i]);
        else if (!take_round(&g, &shapes[i]))
            return false;
    }
    return out->inner.count > 0 && out->inner.count <= DECOMPOSE_TRIANGLES_MAX;
}
