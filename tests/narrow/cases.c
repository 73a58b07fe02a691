/* cases: random shapes and pairs. */
#include "cases.h"
#include "base/prng.h"

#include <stdlib.h>

enum { LATTICE_HULLS = 6 };

static hull *hulls[CASE_HULLS], *lattice_hulls[LATTICE_HULLS];

uint64_t random_bits(random_state *r)
{
    return prng_bits(&r->x);
}

double random_unit(random_state *r)
{
    return (double)(random_bits(r) >> 11) * 0x1p-53;
}
double random_in(random_state *r, double lo, double hi)
{
    return lo + (hi - lo) * random_unit(r);
}

/* Coordinates are drawn one after the other, here and below: the order in which C evaluates arguments is the
 * compiler's. */
static vec3 random_vec(random_state *r, vec3 lo, vec3 hi)
{
    double x = random_in(r, lo.x, hi.x), y = random_in(r, lo.y, hi.y), z = random_in(r, lo.z, hi.z);
    return vec(x, y, z);
}

static vec3 random_in_cube(random_state *r, double half)
{
    return random_vec(r, vec(-half, -half, -half), vec(half, half, half));
}

vec3 random_direction(random_state *r)
{
    for (;;) {
        vec3 v = random_in_cube(r, 1);
        double n = vec_norm2(v);
        if (n > 0.01 && n < 1) return vec_unit(v);
    }
}

quat random_rotation(random_state *r)
{
    for (;;) {
        double w = random_in(r, -1, 1);
        vec3 v = random_in_cube(r, 1);
        quat q = {w, v.x, v.y, v.z};
        double n = quat_norm2(q);
        if (n > 0.01 && n < 1) return quat_unit(q);
    }
}

/* A cube, a prism of six sides, an octahedron, a wedge, a bar and a cube without a corner. */
static void create_lattice_hulls(void)
{
    static const double POINTS[LATTICE_HULLS][12][3] = {
        {{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}, {1, 1, -1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, -1}},
        {{2, 0, 1}, {1, 1, 1}, {-1, 1, 1}, {-2, 0, 1}, {-1, -1, 1}, {1, -1, 1}, {2, 0, -1}, {1, 1, -1}, {-1, 1, -1},
            {-2, 0, -1}, {-1, -1, -1}, {1, -1, -1}},
        {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}},
        {{1, 1, -1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, -1}, {0, 1, 1}, {0, -1, 1}},
        {{3, 0.25, 0.25}, {-3, 0.25, 0.25}, {3, -0.25, 0.25}, {-3, -0.25, 0.25}, {3, 0.25, -0.25}, {-3, 0.25, -0.25},
            {3, -0.25, -0.25}, {-3, -0.25, -0.25}},
        {{1, 1, 0}, {1, 0, 1}, {0, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {-1, -1, 1}, {1, 1, -1}, {-1, 1, -1}, {1, -1, -1},
            {-1, -1, -1}}};
    static const size_t COUNTS[LATTICE_HULLS] = {8, 12, 6, 6, 8, 10};
    for (int i = 0; i < LATTICE_HULLS; i++) {
        double points[36];
        for (size_t k = 0; k < 3 * COUNTS[i]; k++) points[k] = 0.5 * POINTS[i][k / 3][k % 3];
        if (hull_build(points, COUNTS[i], 0, &lattice_hulls[i]) != HULL_OK) abort();
    }
}

void cases_create(void)
{
    create_lattice_hulls();
    random_state r = {7};
    for (int i = 0; i < CASE_HULLS; i++) {
        double points[3 * 40];
        size_t count = 4 + (size_t)(36 * i / (CASE_HULLS - 1));
        for (size_t k = 0; k < count; k++) {
            double size = i % 2 ? 1 : random_in(&r, 0.3, 1.2);
            vec3 v = vec_scale(random_direction(&r), size);
            points[3 * k] = v.x, points[3 * k + 1] = v.y, points[3 * k + 2] = i % 4 == 3 ? 0.05 * v.z : v.z;
        }
        if (hull_build(points, count, 0, &hulls[i]) != HULL_OK) abort();
    }
}

void cases_destroy(void)
{
    for (int i = 0; i < CASE_HULLS; i++) hull_destroy(hulls[i]);
    for (int i = 0; i < LATTICE_HULLS; i++) hull_destroy(lattice_hulls[i]);
}

const hull *case_hull(unsigned i)
{
    return hulls[i % CASE_HULLS];
}

shape random_shape(random_state *r, shape_type type)
{
    shape s = {.type = type};
    bool thin = random_unit(r) < 0.15, rounded = random_unit(r) < 0.3;
    if (type != SHAPE_SPHERE && type != SHAPE_HALFSPACE && type != SHAPE_HULL)
        s.half = random_vec(r, vec(0.1, 0.1, thin ? 0.001 : 0.1), vec(1.5, 1.5, thin ? 0.01 : 1.5));
    if (type == SHAPE_CYLINDER || type == SHAPE_CONE) s.half.y = s.half.x;
    if (type == SHAPE_CAPSULE) s.half.x = s.half.y = 0;
    if (type == SHAPE_SPHERE || type == SHAPE_CAPSULE || rounded) s.radius = random_in(r, 0.05, 0.6);
    if (type == SHAPE_HULL) s.hull = case_hull((unsigned)random_bits(r));
    return s;
}

void random_poses(random_state *r, const shape *a, const shape *b, enum regime where, pose *pose_a, pose *pose_b)
{
    static const double RANGE[REGIME_COUNT][2] = {{1.1, 2}, {0.6, 1.1}, {0.3, 0.7}, {0, 0.3}};
    double reach_a = shape_reach(a), reach_b = shape_reach(b);
    double reach = (isfinite(reach_a) ? reach_a : 0) + (isfinite(reach_b) ? reach_b : 0);
    double away = reach * random_in(r, RANGE[where][0], RANGE[where][1]);
    pose_a->q = random_rotation(r);
    pose_b->q = random_rotation(r);
    pose_a->p = random_in_cube(r, 5);
    pose_b->p = vec_madd(pose_a->p, away, random_direction(r));
}

static double eighths(random_state *r, int least, int most)
{
    return 0.125 * (double)(least + (int)(random_bits(r) % (uint64_t)(most - least + 1)));
}

shape lattice_shape(random_state *r, shape_type type)
{
    shape s = {.type = type};
    double x = eighths(r, 1, 8), y = eighths(r, 1, 8), z = eighths(r, 1, 8);
    bool cube = random_bits(r) % 4 == 0, rounded = random_bits(r) % 4 == 0;
    if (type != SHAPE_SPHERE && type != SHAPE_HALFSPACE && type != SHAPE_HULL)
        s.half = vec(x, cube ? x : y, cube ? x : z);
    if (type == SHAPE_CYLINDER || type == SHAPE_CONE) s.half.y = s.half.x;
    if (type == SHAPE_CAPSULE) s.half.x = s.half.y = 0;
    if (type == SHAPE_SPHERE || type == SHAPE_CAPSULE || rounded) s.radius = eighths(r, 1, 4);
    if (type == SHAPE_HULL) s.hull = lattice_hulls[random_bits(r) % LATTICE_HULLS];
    return s;
}

/* Of the 24 turns that map the axes onto themselves any one, and half of them once more by half a right angle. */
static quat lattice_rotation(random_state *r)
{
    static const double HALF_TURN = 0.70710678118654752440,
                        QUARTER[2] = {0.92387953251128675613, 0.38268343236508977173};
    quat q = {1, 0, 0, 0};
    for (int i = 0; i < 3; i++) {
        uint64_t axis = random_bits(r) % 4;
        quat by = {HALF_TURN, axis == 1 ? HALF_TURN : 0, axis == 2 ? HALF_TURN : 0, axis == 3 ? HALF_TURN : 0};
        if (axis) q = quat_mul(q, by);
    }
    quat by = {QUARTER[0], 0, 0, QUARTER[1]};
    if (random_bits(r) % 4 == 0) q = quat_mul(by, q);
    return quat_unit(q);
}

void lattice_poses(random_state *r, const shape *a, const shape *b, pose *pose_a, pose *pose_b)
{
    static const double NOISE[] = {1e-16, 1e-15, 1e-13, 1e-11, 1e-9, 1e-7, 1e-5, 1e-3};
    double reach = shape_reach(a) + shape_reach(b);
    int most = isfinite(reach) ? (int)(8 * reach) + 1 : 16;
    bool turned = random_bits(r) % 2, noisy = random_bits(r) % 3 == 0;
    double noise = noisy ? NOISE[random_bits(r) % 8] : 0;
    *pose_a = *pose_b = POSE_IDENTITY;
    if (turned) pose_a->q = lattice_rotation(r);
    pose_b->q = lattice_rotation(r);
    double *at = &pose_b->p.x;
    for (int k = 0; k < 3; k++) at[k] = random_bits(r) % 3 ? eighths(r, -most, most) : 0;
    if (turned) pose_a->p = vec(eighths(r, -8, 8), eighths(r, -8, 8), 0);
    pose_b->p = vec_add(pose_b->p, pose_a->p);
    if (noisy && random_bits(r) % 2) pose_b->p = vec_madd(pose_b->p, noise, random_direction(r));
    if (!noisy || random_bits(r) % 2) return;
    vec3 turn = vec_scale(random_direction(r), noise);
    pose_b->q = quat_unit(quat_mul((quat){1, turn.x, turn.y, turn.z}, pose_b->q));
}

narrow_scratch *case_scratch(void)
{
    static narrow_scratch *scratch;
    if (!scratch) scratch = aligned_alloc(64, narrow_scratch_size());
    if (!scratch) abort();
    return scratch;
}

narrow_request measure_exactly(void)
{
    return (narrow_request){.facts = NARROW_DISTANCE, .tolerance = 0, .range = INFINITY};
}
