/* Cases at the extremes, each with the answer that follows from its construction: touching, coincident, contained,
 * flat, size ratios to 1e9, sizes from 1e-160 to 1e160, far from the origin. The tolerance is relative to the smaller
 * shape or to the answer, whichever is larger, and holds for the middle of the interval; the interval must hold the
 * answer, to within what the rounding of a turned pose's numbers moves it. */
#include "cases.h"
#include "oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>

#define SPHERE(r)                                                                                                      \
    {                                                                                                                  \
        .type = SHAPE_SPHERE, .radius = (r)                                                                            \
    }
#define CAPSULE(h, r)                                                                                                  \
    {                                                                                                                  \
        .type = SHAPE_CAPSULE, .half = {0, 0, (h)}, .radius = (r)                                                      \
    }
#define BOX(x, y, z)                                                                                                   \
    {                                                                                                                  \
        .type = SHAPE_BOX, .half = {(x), (y), (z) }                                                                    \
    }
#define CYLINDER(r, h)                                                                                                 \
    {                                                                                                                  \
        .type = SHAPE_CYLINDER, .half = {(r), (r), (h) }                                                               \
    }
#define CONE(r, h)                                                                                                     \
    {                                                                                                                  \
        .type = SHAPE_CONE, .half = {(r), (r), (h) }                                                                   \
    }
#define ELLIPSOID(x, y, z)                                                                                             \
    {                                                                                                                  \
        .type = SHAPE_ELLIPSOID, .half = {(x), (y), (z) }                                                              \
    }
#define PLANE                                                                                                          \
    {                                                                                                                  \
        .type = SHAPE_HALFSPACE                                                                                        \
    }
#define AT(x, y, z)                                                                                                    \
    {                                                                                                                  \
        {(x), (y), (z)},                                                                                               \
        {                                                                                                              \
            1, 0, 0, 0                                                                                                 \
        }                                                                                                              \
    }
#define TURNED(x, y, z, w, i, j, k)                                                                                    \
    {                                                                                                                  \
        {(x), (y), (z)},                                                                                               \
        {                                                                                                              \
            (w), (i), (j), (k)                                                                                         \
        }                                                                                                              \
    }
#define R2 0.70710678118654752

typedef struct extreme {
    const char *name;
    shape a;
    pose pose_a;
    shape b;
    pose pose_b;
    double expected, tolerance;
    vec3 axis; /* zero: any */
} extreme;

static const extreme CASES[] = {
    {"edge on face, 45 degrees", BOX(1, 1, 1), AT(0, 0, 0), BOX(1, 1, 1),
        TURNED(0, 0, 2.414213562373095, 0.9238795325112867, 0.3826834323650898, 0, 0), 0, 1e-15, {0, 0, 1}},
    {"coincident boxes", BOX(1, 1, 1), AT(0, 0, 0), BOX(1, 1, 1), AT(0, 0, 0), -2, 4e-16, {0, 0, 0}},
    {"concentric boxes", BOX(1, 1, 1), AT(0, 0, 0), BOX(.125, .125, .125), AT(0, 0, 0), -1.125, 4e-16, {0, 0, 0}},
    {"contained box", BOX(1, 1, 1), AT(0, 0, 0), BOX(.125, .125, .125), AT(.5, 0, 0), -0.625, 4e-16, {1, 0, 0}},
    {"boxes, edge on edge", BOX(1, 1, 1), AT(0, 0, 0), BOX(1, 1, 1), AT(2, 2, 0), 0, 4e-16, {0, 0, 0}},
    {"boxes, gap 1e-12", BOX(1, 1, 1), AT(0, 0, 0), BOX(1, 1, 1), AT(2.000000000001, 0, 0), 1.000088900582341e-12, 1e-3,
        {1, 0, 0}},
    {"coplanar flat boxes", BOX(1, 1, 0), AT(0, 0, 0), BOX(1, 1, 0), AT(1, 1, 0), 0, 4e-16, {0, 0, 0}},
    {"boxes far from the origin", BOX(1, 1, 1), AT(1e7, -3e7, 1e7), BOX(1, 1, 1), AT(10000002.000000954, -3e7, 1e7),
        9.5367431640625e-07, 1e-9, {1, 0, 0}},
    {"plate in a box", BOX(1, 1, 1), AT(0, 0, 0), BOX(1, 1, 0x1p-31), AT(0, 0, 0), -1 - 0x1p-31, 4e-16, {0, 0, 0}},
    {"flat box in a box", BOX(1, 1, 1), AT(0, 0, 0), BOX(.5, .5, 0), AT(.75, 0, 0), -.75, 4e-16, {1, 0, 0}},
    {"point box", BOX(0, 0, 0), AT(2, 0, 0), BOX(1, 1, 1), AT(0, 0, 0), 1, 4e-16, {-1, 0, 0}},
    {"two point boxes", BOX(0, 0, 0), AT(2, 0, 0), BOX(0, 0, 0), AT(2, 0, 0), 0, 4e-16, {0, 0, 0}},
    {"ratio 1e9, depth 2^-20", BOX(1e9, 1e9, 1e9), AT(0, 0, -1e9), BOX(.5, .5, .5), AT(0, 0, 0.4999990463256836),
        -0x1p-20, 1e-9, {0, 0, 1}},
    {"ratio 1e9, corner", BOX(1e9, 1e9, 1e9), AT(-1e9, -1e9, -1e9), BOX(.5, .5, .5), AT(.5, .5, .5), 0, 4e-16,
        {0, 0, 0}},
    {"capsule as sphere", CAPSULE(0, .5), AT(0, 0, 0), SPHERE(.5), AT(0, 1, 0), 0, 4e-16, {0, 1, 0}},
    {"identical capsules", CAPSULE(1, .5), AT(0, 0, 0), CAPSULE(1, .5), AT(0, 0, 0), -1, 4e-16, {0, 0, 0}},
    {"capsules, tip on tip", CAPSULE(1, .5), AT(0, 0, 0), CAPSULE(1, .5), AT(0, 0, 3), 0, 4e-16, {0, 0, 1}},
    {"crossed capsules", CAPSULE(1, .5), AT(0, 0, 0), CAPSULE(1, .25), TURNED(0, 0, 0, R2, R2, 0, 0), -.75, 4e-16,
        {0, 0, 0}},
    {"spheres of 1e-160", SPHERE(1e-160), AT(0, 0, 0), SPHERE(1e-160), AT(3e-160, 0, 0), 1e-160, 4e-16, {1, 0, 0}},
    {"spheres of 1e160", SPHERE(1e160), AT(0, 0, 0), SPHERE(1e160), AT(3e160, 0, 0), 9.999999999999999e159, 4e-16,
        {1, 0, 0}},
    {"boxes of 1e150", BOX(1e150, 1e150, 1e150), AT(0, 0, 0), BOX(1e150, 1e150, 1e150), AT(3e150, 0, 0), 1e150, 4e-16,
        {1, 0, 0}},
    {"boxes of 1e-150", BOX(1e-150, 1e-150, 1e-150), AT(0, 0, 0), BOX(1e-150, 1e-150, 1e-150), AT(3e-150, 0, 0), 1e-150,
        4e-16, {1, 0, 0}},
    {"spheres, gap 1 ulp", SPHERE(1), AT(0, 0, 0), SPHERE(1), AT(2.0000000000000004, 0, 0), 0x1p-51, 2e-16, {1, 0, 0}},
    {"spheres at 1e15", SPHERE(1), AT(1e15, 0, 0), SPHERE(1), AT(1000000000000002.1, 0, 0), .125, 4e-16, {1, 0, 0}},
    {"spheres, ratio 1e9", SPHERE(1e9), AT(0, 0, 0), SPHERE(1), AT(1000000001.000001, 0, 0), 0x1p-20, 1e-10, {1, 0, 0}},
    {"two points", SPHERE(0), AT(0, 0, 0), SPHERE(0), AT(0, 0, 0), 0, 4e-16, {0, 0, 0}},
    {"sphere in the middle of a box", BOX(1, 1, 1), AT(0, 0, 0), SPHERE(.5), AT(0, 0, 0), -1.5, 4e-16, {0, 0, 0}},
    {"sphere inside a box", BOX(1, 1, 1), AT(0, 0, 0), SPHERE(.25), AT(0, 0, .5), -.75, 4e-16, {0, 0, 1}},
    {"huge sphere under a box", BOX(.5, .5, .5), AT(0, 0, .5), SPHERE(1e9), AT(0, 0, -1e9), 0, 4e-16, {0, 0, -1}},
    {"sphere in the middle of a cylinder", SPHERE(.25), AT(0, 0, 0), CYLINDER(1, 2), AT(0, 0, 0), -1.25, 4e-16,
        {0, 0, 0}},
    {"sphere on the axis of a cone", SPHERE(.25), AT(0, 0, -.5), CONE(1, .5), AT(0, 0, 0), -.25, 4e-16, {0, 0, 1}},
    {"sphere beyond the apex", SPHERE(.25), AT(0, 0, 1.5), CONE(1, .5), AT(0, 0, 0), .75, 4e-16, {0, 0, -1}},
    {"sphere above a rim", SPHERE(1), AT(4, 0, 6), CYLINDER(1, 2), AT(0, 0, 0), 4, 4e-16, {-.6, 0, -.8}},
    {"sphere above a disc", SPHERE(.125), AT(0, 0, 1), CYLINDER(1, 0), AT(.25, 0, 0), .875, 4e-16, {0, 0, -1}},
    {"sphere below a disc", SPHERE(.125), AT(0, 0, -1), CYLINDER(1, 0), AT(.25, 0, 0), .875, 4e-16, {0, 0, 1}},
    {"sphere below a thin disc", SPHERE(.125), AT(0, 0, -1), CYLINDER(1, 0x1p-60), AT(.25, 0, 0), .875, 4e-16,
        {0, 0, 1}},
    {"sphere above a flat cone", SPHERE(.125), AT(0, 0, 1), CONE(1, 0), AT(.25, 0, 0), .875, 4e-16, {0, 0, -1}},
    {"sphere below a flat cone", SPHERE(.125), AT(0, 0, -1), CONE(1, 0), AT(.25, 0, 0), .875, 4e-16, {0, 0, 1}},
    {"coaxial cylinders, end on end", CYLINDER(1, 1), AT(0, 0, 0), CYLINDER(.5, 1), AT(0, 0, 2), 0, 4e-15, {0, 0, 1}},
    {"coincident short cylinders", CYLINDER(2, .25), AT(0, 0, 0), CYLINDER(1, .5), AT(0, 0, 0), -.75, 4e-15, {0, 0, 0}},
    {"cylinder about a cylinder", CYLINDER(.75, 2), AT(0, 0, 0), CYLINDER(.25, 2), AT(0, 0, .5), -1, 4e-14, {0, 0, 0}},
    {"cone about a capsule", CONE(1, .5), AT(0, 0, 0), CAPSULE(1, .25), AT(0, 0, .25), -1.1338834764831845, 4e-14,
        {0, 0, 0}},
    {"coplanar discs", CYLINDER(1, 0), AT(0, 0, 0), CYLINDER(1, 0), AT(1, 0, 0), 0, 4e-15, {0, 0, 0}},
    {"cone on its base", CONE(1, 1), AT(0, 0, 1), PLANE, AT(0, 0, 0), 0, 4e-16, {0, 0, -1}},
    {"spheroid as sphere", ELLIPSOID(1, 1, 1), AT(0, 0, 0), ELLIPSOID(.5, .5, .5), AT(.25, 0, 0), -1.25, 4e-16,
        {1, 0, 0}},
    {"ellipsoids, tip on tip", ELLIPSOID(1, 2, 3), AT(0, 0, 0), ELLIPSOID(2, 1, 1), AT(0, 0, 4), 0, 4e-15, {0, 0, 1}},
    {"contained ellipsoid", ELLIPSOID(1, 2, 3), AT(0, 0, 0), ELLIPSOID(.25, .5, .5), AT(.5, 0, 0), -.75, 1e-12,
        {1, 0, 0}},
    {"rounded box over a rounded plane", {.type = SHAPE_BOX, .half = {1, 1, 1}, .radius = .25}, AT(0, 0, 3),
        {.type = SHAPE_HALFSPACE, .radius = .5}, AT(0, 0, 0), 1.25, 4e-16, {0, 0, -1}},
    {"planes back to back", PLANE, AT(0, 0, 0), PLANE, TURNED(0, 0, 2, 0, 1, 0, 0), 2, 4e-16, {0, 0, 1}},
    {"planes that meet", PLANE, AT(0, 0, 0), PLANE, TURNED(0, 0, 2, R2, R2, 0, 0), -INFINITY, 0, {0, 0, 0}},
    /* cylinder over a box's edge: FCL threw "the origin is outside of the polytope" (drake 21234). A 50-digit decimal
     * check of its axis gives 3.3108e-11 or more. */
    {"drake 21234", CYLINDER(.041, .085),
        TURNED(0.2023803334682546, 0.02784568359401101, 0.31142339392466933, 0.5886058345268528, 0.6818910619554416,
            0.1871485496210967, -0.3918458517847894),
        BOX(.15, .3, .008), AT(.4, 0, .26885000000000003), 3.3109e-11, 1e-12, {0, 0, 0}},
};

static double smaller(const shape *a, const shape *b)
{
    double ra = shape_reach(a), rb = shape_reach(b), least = fmin(ra, rb);
    return isfinite(least) ? least : 1;
}

/* A pose that has no turn says exactly what was meant; of others the last bits are an accident. */
static double rounded_away(const extreme *c)
{
    bool turned = vec_norm(vec(c->pose_b.q.x, c->pose_b.q.y, c->pose_b.q.z)) > 0;
    return turned ? 4 * 0x1p-53 * smaller(&c->a, &c->b) : 0;
}

static void check(const extreme *c, narrow_engine engine)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    request.engine = engine;
    narrow_query_world(&c->a, c->pose_a, &c->b, c->pose_b, &request, case_scratch(), &r);
    if (isinf(c->expected)) {
        assert_true(r.lo == c->expected);
        return;
    }
    double error = fabs(r.lo + (r.hi - r.lo) / 2 - c->expected);
    double allowed = c->tolerance * fmax(smaller(&c->a, &c->b), fabs(c->expected));
    double away = rounded_away(c);
    if (!(r.lo <= c->expected + away && c->expected - away <= r.hi) || !(error <= allowed))
        fail_msg("%s, engine %d: expected %.17g, got [%.17g, %.17g] by %s, %u iterations", c->name, engine, c->expected,
            r.lo, r.hi, narrow_method_name(r.method), r.iterations);
    double off = vec_norm(vec_sub(r.axis, c->axis));
    if (vec_norm(c->axis) > 0 && off > 1e-6) fail_msg("%s: axis %g %g %g", c->name, r.axis.x, r.axis.y, r.axis.z);
    assert_int_equal(r.status, NARROW_CERTAIN);
}

static void extreme_cases_are_right(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) check(&CASES[i], NARROW_ENGINE_AUTO);
}

static void hull_of(const double *points, size_t count, hull **out)
{
    assert_int_equal(hull_build(points, count, HULL_ALLOW_FLAT, out), HULL_OK);
}

static void check_hulls(const char *name, const double *p, size_t np, vec3 at_a, const double *q, size_t nq, vec3 at_b,
    double expected, double tolerance)
{
    extreme c = {.name = name, .expected = expected, .tolerance = tolerance};
    hull *a, *b;
    hull_of(p, np, &a);
    hull_of(q, nq, &b);
    c.a = (shape){.type = SHAPE_HULL, .hull = a};
    c.b = (shape){.type = SHAPE_HULL, .hull = b};
    c.pose_a = (pose){at_a, {1, 0, 0, 0}};
    c.pose_b = (pose){at_b, {1, 0, 0, 0}};
    check(&c, NARROW_ENGINE_AUTO);
    check(&c, NARROW_ENGINE_GJK);
    hull_destroy(a);
    hull_destroy(b);
}

static void flat_and_sharp_hulls_are_right(void **state)
{
    static const double A[] = {-1, 0, 0, 1, 0, 0, 0, 1, -1, 0, -1, -1}, B[] = {0, -1, 0, 0, 1, 0, 1, 0, 1, -1, 0, 1};
    static const double POINT[] = {1, 2, 3}, LINE[] = {0, 0, 0, 2, 0, 0}, NEXT[] = {1, 0, 0, 3, 0, 0};
    static const double QUAD[] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}, FAR[] = {2, 0, 0, 3, 0, 0, 3, 1, 0, 2, 1, 0};
    static const double CUBE[] = {-1, -1, -1, -1, -1, 1, -1, 1, -1, -1, 1, 1, 1, -1, -1, 1, -1, 1, 1, 1, -1, 1, 1, 1};
    vec3 o = VEC_ZERO;
    (void)state;
    check_hulls("edges cross, depth", A, 4, o, B, 4, vec(0, 0, -0x1p-20), -0x1p-20, 1e-9);
    check_hulls("edges cross, gap", A, 4, o, B, 4, vec(0, 0, 9.094947017729282e-13), 9.094947017729282e-13, 1e-15);
    check_hulls("edges cross, touching", A, 4, o, B, 4, o, 0, 4e-15);
    check_hulls("two points", POINT, 1, o, POINT, 1, o, 0, 4e-16);
    check_hulls("collinear segments", LINE, 2, o, NEXT, 2, o, 0, 4e-16);
    check_hulls("coplanar quads", QUAD, 4, o, FAR, 4, o, 1, 4e-16);
    check_hulls("coplanar quads, overlapping", QUAD, 4, o, QUAD, 4, vec(.25, .25, 0), 0, 4e-16);
    check_hulls("crossing segments", LINE, 2, o, QUAD, 4, vec(.5, -.5, 0), 0, 4e-16);
    check_hulls("quad inside a cube", CUBE, 8, o, QUAD, 4, vec(-.5, -.5, .25), -.75, 1e-14);
    check_hulls("segment inside a cube", CUBE, 8, o, LINE, 2, vec(-.5, 0, .25), -.75, 1e-14);
    check_hulls("point inside a cube", CUBE, 8, o, POINT, 1, vec(-1, -2, -3.5), -.5, 1e-14);
}

/* The libccd engines, and the general method, agree with the truth of the same cases. */
static void every_engine_is_right(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        extreme c = CASES[i];
        c.tolerance = fmax(c.tolerance, 1e-9);
        c.axis = VEC_ZERO;
        for (int engine = NARROW_ENGINE_CCD; engine <= NARROW_ENGINE_MPR; engine++) check(&c, (narrow_engine)engine);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extreme_cases_are_right),
        cmocka_unit_test(flat_and_sharp_hulls_are_right),
        cmocka_unit_test(every_engine_is_right),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
