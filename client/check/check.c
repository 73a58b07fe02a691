/* check: the whole of collided_check.h. What is computed is short; that it is enough is proven elsewhere: see
 * script/prove. Pure; any thread.
 *
 * Every length is divided by a power of two, `scale`, such that none that enters exceeds 1. So what rounding does is
 * bounded by constants: LO_SLACK, HI_SLACK, ... below, in units of the scale. proofs/ derives each of them, formula by
 * formula, from the code as it stands: script/prove reads them here. Where a search is needed (which point of a hull or
 * an ellipsoid is nearest?) its result is a proposal: the formula after it makes a point of the shape of whatever
 * numbers it gets, and that alone is proven. Comparisons are written so that NaN fails them. */
#include "collided_check.h"
#include "propose.h"

#include <math.h>

#define MOST 0x1p400          /* m: the largest coordinate */
#define LEAST 0x1p-400        /* m: the least scale */
#define UNIT 0x1p-9           /* how far from 1 a quaternion's and an axis' squared length may be */
#define LO_SLACK 0x1.f7p-43   /* of the gap along an axis */
#define HI_SLACK 0x1.f7p-43   /* of the distance that two points prove */
#define FEATURE_SLACK 0x1p-49 /* of the product of a direction and a corner, for a direction of length <= 2 */
#define RULE_SLACK 0x1p-50    /* of the sum of what is added and compared */
#define SPEED_SLACK 0x1p-44   /* of a sum of at most 256 products, none negative */
#define TINY 0x1p-499 /* as long as a vector of which the square may underflow; and more than a product then lacks */

typedef struct vec {
    double x, y, z;
} vec;

/* What is read and written is stated in ACSL, which Frama-C holds against the code, for the inputs of proofs/inputs.c.
 * (Of functions of numbers alone nothing needs to be stated.) An array is there if its count is one that is taken. */
/*@ predicate vector_is_there(double *v) = \valid_read(v + (0 .. 2));
    predicate pose_is_there(double *p) = \valid_read(p + (0 .. 6));
    predicate points_are_there(collided_check_shape *s) = \valid_read(s->points + (0 .. 3 * s->point_count - 1));
    predicate core_is_there(collided_check_shape *s) = \valid_read(s) &&
      (s->kind == COLLIDED_CHECK_HULL && s->points != \null && 1 <= s->point_count <= COLLIDED_CHECK_POINTS_MOST
        ==> points_are_there(s));
    predicate shape_is_there(collided_check_shape *s) = core_is_there(s) &&
      (s->kind == COLLIDED_CHECK_COMPOUND && s->children != \null && 1 <= s->child_count <= COLLIDED_CHECK_CHILDREN_MOST
        ==> \valid_read(s->children + (0 .. s->child_count - 1))); */

static double magnitude(double x)
{
    return x < 0 ? -x : x;
}
static double larger(double a, double b)
{
    return a > b ? a : b;
}
/*@ requires vector_is_there(v); assigns \nothing; */
static vec vec_of(const double v[3], double by)
{
    return (vec){v[0] * by, v[1] * by, v[2] * by};
}
/* From one point to another. */
/*@ requires vector_is_there(a) && vector_is_there(b); assigns \nothing; */
static vec between(const double a[3], const double b[3], double by)
{
    return (vec){(b[0] - a[0]) * by, (b[1] - a[1]) * by, (b[2] - a[2]) * by};
}
static vec plus(vec a, vec b)
{
    return (vec){a.x + b.x, a.y + b.y, a.z + b.z};
}
static vec minus(vec a, vec b)
{
    return (vec){a.x - b.x, a.y - b.y, a.z - b.z};
}
static vec times(double s, vec a)
{
    return (vec){s * a.x, s * a.y, s * a.z};
}
static double dot(vec a, vec b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}
static vec cross(vec a, vec b)
{
    return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
static double length(vec a)
{
    return sqrt(dot(a, a));
}
/* Not less than |a|, but for relative rounding: squares underflow, which matters where there is no scale. */
static double length_at_most(vec a)
{
    return length(a) + TINY;
}

/* v + 2 (w (u x v) + u x (u x v)) / |q|^2: turned by the quaternion q = (w, u), which need not be unit; `way` -1: back.
 */
/*@ requires \valid_read(q + (0 .. 3)); assigns \nothing; */
static vec turned(const double q[4], double way, vec v)
{
    vec u = {q[1], q[2], q[3]}, c = cross(u, v);
    double by = 2 / (q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return plus(v, times(by, plus(times(way * q[0], c), cross(u, c))));
}

/* ---- what came from outside ---- */

static bool fits(double x)
{
    return x >= -MOST && x <= MOST;
}
/*@ requires vector_is_there(v); assigns \nothing; */
static bool fits3(const double v[3])
{
    return fits(v[0]) && fits(v[1]) && fits(v[2]);
}
static bool is_size(double x)
{
    return x >= 0 && x <= MOST;
}
static bool is_unit(double square)
{
    return square >= 1 - UNIT && square <= 1 + UNIT;
}
/*@ requires vector_is_there(v); assigns \nothing; */
static bool is_axis(const double v[3])
{
    return is_unit(dot(vec_of(v, 1), vec_of(v, 1)));
}
/*@ requires pose_is_there(p); assigns \nothing; */
static bool is_pose(const double p[7])
{
    return fits3(p) && is_unit(p[3] * p[3] + p[4] * p[4] + p[5] * p[5] + p[6] * p[6]);
}

static double greatest(vec v)
{
    return larger(larger(magnitude(v.x), magnitude(v.y)), magnitude(v.z));
}
/*@ requires vector_is_there(v); assigns \nothing; */
static double most3(const double v[3])
{
    return greatest(vec_of(v, 1));
}

/* A shape that is no compound. *most grows to the greatest number of its sizes, points and position. */
/*@ requires core_is_there(s) && \valid(most); assigns *most; ensures 0 <= \result <= 13; */
static collided_check_status look_at_core(const collided_check_shape *s, double *most)
{
    if (s->kind < COLLIDED_CHECK_SPHERE || s->kind > COLLIDED_CHECK_HULL) return COLLIDED_CHECK_BAD_KIND;
    if (!is_size(s->half[0]) || !is_size(s->half[1]) || !is_size(s->half[2]) || !is_size(s->radius) ||
        !is_size(s->deviation))
        return COLLIDED_CHECK_BAD_SIZE;
    if (!is_pose(s->pose)) return COLLIDED_CHECK_BAD_POSE;
    *most = larger(*most, larger(larger(most3(s->half), most3(s->pose)), larger(s->radius, s->deviation)));
    if (s->kind != COLLIDED_CHECK_HULL) return COLLIDED_CHECK_PROVEN;
    if (!s->points) return COLLIDED_CHECK_NO_POINTER;
    if (s->point_count < 1 || s->point_count > COLLIDED_CHECK_POINTS_MOST) return COLLIDED_CHECK_BAD_POINTS;
    for (size_t i = 0; i < s->point_count; i++) {
        if (!fits3(s->points + 3 * i)) return COLLIDED_CHECK_BAD_POINTS;
        *most = larger(*most, most3(s->points + 3 * i));
    }
    return COLLIDED_CHECK_PROVEN;
}

/*@ requires shape_is_there(s) && \valid(most); assigns *most; ensures 0 <= \result <= 13; */
static collided_check_status look_at(const collided_check_shape *s, double *most)
{
    if (s->kind != COLLIDED_CHECK_COMPOUND) return look_at_core(s, most);
    if (!is_size(s->radius) || !is_size(s->deviation)) return COLLIDED_CHECK_BAD_SIZE;
    if (!is_pose(s->pose)) return COLLIDED_CHECK_BAD_POSE;
    *most = larger(*most, larger(most3(s->pose), larger(s->radius, s->deviation)));
    if (!s->children) return COLLIDED_CHECK_NO_POINTER;
    if (s->child_count < 1 || s->child_count > COLLIDED_CHECK_CHILDREN_MOST) return COLLIDED_CHECK_BAD_CHILDREN;
    for (size_t i = 0; i < s->child_count; i++) {
        if (s->children[i].kind == COLLIDED_CHECK_HALFSPACE) return COLLIDED_CHECK_BAD_KIND;
        collided_check_status status = look_at_core(&s->children[i], most);
        if (status != COLLIDED_CHECK_PROVEN) return status;
    }
    return COLLIDED_CHECK_PROVEN;
}

/* The power of two that all numbers are divided by: `most` of it is at most 1. */
static double scale_above(double most)
{
    static const double POWERS[10] = {0x1p512, 0x1p256, 0x1p128, 0x1p64, 0x1p32, 0x1p16, 0x1p8, 0x1p4, 0x1p2, 0x1p1};
    double scale = LEAST;
    for (int i = 0; i < 10; i++)
        if (scale * POWERS[i] <= most) scale *= POWERS[i];
    return 2 * scale;
}

/* ---- how far shapes reach along a direction ---- */

/* A convex core where it stands: the frames that lead to it, outermost first, and what rounds it. */
typedef struct placed {
    const collided_check_shape *core;
    const double *poses[3];
    int frames;
    double radius, deviation; /* in units of the scale */
} placed;

/*@ requires \valid_read(s); assigns \nothing; */
static size_t part_count(const collided_check_shape *s)
{
    return s->kind == COLLIDED_CHECK_COMPOUND ? s->child_count : 1;
}

/*@ requires shape_is_there(s) && pose_is_there(pose); assigns \nothing; ensures 2 <= \result.frames <= 3; */
static placed part_of(const collided_check_shape *s, const double *pose, size_t index, double by)
{
    placed p = {s, {pose, s->pose, s->pose}, 2, s->radius * by, s->deviation * by};
    if (s->kind != COLLIDED_CHECK_COMPOUND) return p;
    p.core = &s->children[index];
    p.poses[2] = p.core->pose;
    p.frames = 3;
    p.radius += p.core->radius * by;
    p.deviation += p.core->deviation * by;
    return p;
}

/*@ requires core_is_there(s); assigns \nothing; */
static double core_support(const collided_check_shape *s, vec d, double by)
{
    double x = s->half[0] * by, y = s->half[1] * by, z = s->half[2] * by;
    double round = x * sqrt(d.x * d.x + d.y * d.y), top = -INFINITY;
    switch (s->kind) {
    case COLLIDED_CHECK_CAPSULE:
        return z * magnitude(d.z);
    case COLLIDED_CHECK_BOX:
        return x * magnitude(d.x) + y * magnitude(d.y) + z * magnitude(d.z);
    case COLLIDED_CHECK_CYLINDER:
        return round + z * magnitude(d.z);
    case COLLIDED_CHECK_CONE:
        return larger(z * d.z, round - z * d.z);
    case COLLIDED_CHECK_ELLIPSOID:
        return length((vec){x * d.x, y * d.y, z * d.z});
    case COLLIDED_CHECK_HULL:
        for (size_t i = 0; i < s->point_count; i++) top = larger(top, dot(d, vec_of(s->points + 3 * i, by)));
        return top;
    default: /* a point; of a half-space along its normal the origin is */
        return 0;
    }
}

/* Greatest n . x of a shape's points, from the position of its body; `size` is |n|. */
/*@ requires shape_is_there(s) && pose_is_there(pose); assigns \nothing; */
static double support(const collided_check_shape *s, const double *pose, vec n, double size, double by)
{
    double most = -INFINITY;
    for (size_t i = 0; i < part_count(s); i++) {
        placed p = part_of(s, pose, i, by);
        vec d = turned(pose + 3, -1, n);
        double sum = p.radius * size;
        for (int k = 1; k < p.frames; k++) {
            sum += dot(d, vec_of(p.poses[k], by));
            d = turned(p.poses[k] + 3, -1, d);
        }
        most = larger(most, sum + core_support(p.core, d, by));
    }
    return most;
}

/* Least n . (b - a) of their points, for the unit vector along the axis; beside a half-space for its normal. */
/*@ requires shape_is_there(a) && pose_is_there(pose_a) && shape_is_there(b) && pose_is_there(pose_b);
    assigns \nothing; */
static double gap(const collided_check_shape *a, const double *pose_a, const collided_check_shape *b,
    const double *pose_b, const double axis[3], double by)
{
    const vec up = {0, 0, 1}, down = {0, 0, -1};
    bool plane_a = a->kind == COLLIDED_CHECK_HALFSPACE, plane_b = b->kind == COLLIDED_CHECK_HALFSPACE;
    if (plane_a && plane_b) return -INFINITY; /* what rounding leaves of their angle is too much */
    vec n = plane_a   ? turned(pose_a + 3, 1, turned(a->pose + 3, 1, up))
            : plane_b ? turned(pose_b + 3, 1, turned(b->pose + 3, 1, down))
                      : vec_of(axis, 1);
    double size = plane_a || plane_b ? 1 : length(n); /* a normal is unit, but for rounding */
    double reach = support(a, pose_a, n, size, by) + support(b, pose_b, times(-1, n), size, by);
    return (dot(n, between(pose_a, pose_b, by)) - reach) / size;
}

/*@ requires shape_is_there(a) && pose_is_there(pose_a) && shape_is_there(b) && pose_is_there(pose_b);
    assigns \nothing; */
static double proven_gap(const collided_check_shape *a, const double *pose_a, const collided_check_shape *b,
    const double *pose_b, const double axis[3], double most)
{
    double scale = scale_above(larger(most, greatest(between(pose_a, pose_b, 1))));
    return (gap(a, pose_a, b, pose_b, axis, 1 / scale) - LO_SLACK) * scale;
}

/* ---- how far points are from shapes ---- */

/* From q to the cone's disc that is `share` of the way from the apex to the base. */
static double disc_distance(double rho, double height, double r, double h, double share)
{
    double kept = share > 0 ? share < 1 ? share : 1 : 0;
    double out = larger(rho - kept * r, 0), up = height - h * (1 - 2 * kept);
    return sqrt(out * out + up * up);
}

static double cone_distance(vec q, double r, double h)
{
    double rho = sqrt(q.x * q.x + q.y * q.y), level = (h - q.z) / (2 * h);
    double slant = (r * rho + 2 * h * (h - q.z)) / (r * r + 4 * h * h);
    double least = disc_distance(rho, q.z, r, h, 1);
    double at_level = disc_distance(rho, q.z, r, h, level), at_slant = disc_distance(rho, q.z, r, h, slant);
    if (at_level < least) least = at_level;
    return at_slant < least ? at_slant : least;
}

/* Whatever u is proposed, it is put into the ball that the ellipsoid stretches. */
/*@ requires vector_is_there(a); assigns \nothing; */
static double ellipsoid_distance(vec q, const double a[3])
{
    double at[3] = {q.x, q.y, q.z}, u[3];
    propose_ellipsoid(at, a, u);
    double out = larger(length(vec_of(u, 1)), 1);
    return length(minus(q, (vec){a[0] * (u[0] / out), a[1] * (u[1] / out), a[2] * (u[2] / out)}));
}

/* Weights that are not negative make a point of the hull of its points, whatever they are. */
/*@ requires \valid_read(s) && points_are_there(s); assigns \nothing; */
static double hull_distance(const collided_check_shape *s, vec q, double by)
{
    double at[3] = {q.x, q.y, q.z}, weights[4], all = 0;
    size_t corners[4];
    vec sum = {0, 0, 0};
    propose_hull(s->points, s->point_count, at, by, corners, weights);
    for (int i = 0; i < 4; i++) {
        if (!(corners[i] < s->point_count) || !(weights[i] >= 0)) return INFINITY;
        sum = plus(sum, times(weights[i], minus(vec_of(s->points + 3 * corners[i], by), q)));
        all += weights[i];
    }
    return is_unit(all) ? length(sum) / all : INFINITY;
}

/*@ requires core_is_there(s); assigns \nothing; */
static double core_distance(const collided_check_shape *s, vec q, double by)
{
    double half[3] = {s->half[0] * by, s->half[1] * by, s->half[2] * by};
    double x = larger(magnitude(q.x) - half[0], 0), y = larger(magnitude(q.y) - half[1], 0);
    double z = larger(magnitude(q.z) - half[2], 0), round = larger(sqrt(q.x * q.x + q.y * q.y) - half[0], 0);
    switch (s->kind) {
    case COLLIDED_CHECK_CAPSULE:
        return length((vec){q.x, q.y, z});
    case COLLIDED_CHECK_BOX:
        return length((vec){x, y, z});
    case COLLIDED_CHECK_CYLINDER:
        return length((vec){round, 0, z});
    case COLLIDED_CHECK_CONE:
        return cone_distance(q, half[0], half[2]);
    case COLLIDED_CHECK_ELLIPSOID:
        return ellipsoid_distance(q, half);
    case COLLIDED_CHECK_HALFSPACE:
        return larger(q.z, 0);
    case COLLIDED_CHECK_HULL:
        return hull_distance(s, q, by);
    default:
        return length(q);
    }
}

/* How far a world point is from a shape, at most, and that from what the shape stands for. */
/*@ requires shape_is_there(s) && pose_is_there(pose) && vector_is_there(point); assigns \nothing; */
static double outside(const collided_check_shape *s, const double *pose, const double point[3], double by)
{
    double least = INFINITY;
    for (size_t i = 0; i < part_count(s); i++) {
        placed p = part_of(s, pose, i, by);
        vec q = turned(pose + 3, -1, between(pose, point, by));
        for (int k = 1; k < p.frames; k++) q = turned(p.poses[k] + 3, -1, minus(q, vec_of(p.poses[k], by)));
        double core = core_distance(p.core, q, by), out = core <= p.radius ? 0 : core - p.radius;
        if (out + p.deviation < least) least = out + p.deviation;
    }
    return least;
}

/*@ requires shape_is_there(a) && pose_is_there(pose_a) && shape_is_there(b) && pose_is_there(pose_b) &&
      \valid_read(claim);
    assigns \nothing; */
static double proven_hi(const collided_check_shape *a, const double *pose_a, const collided_check_shape *b,
    const double *pose_b, const collided_check_claim *claim, double most)
{
    const double *at = claim->point_a, *to = claim->point_b;
    most = larger(most, larger(greatest(between(pose_a, at, 1)), greatest(between(pose_b, to, 1))));
    double scale = scale_above(larger(most, greatest(between(at, to, 1)))), by = 1 / scale;
    double sum = length(between(at, to, by)) + (outside(a, pose_a, at, by) + outside(b, pose_b, to, by));
    return (sum + HI_SLACK) * scale;
}

/* ---- the functions of the header ---- */

/*@ requires (a == \null || shape_is_there(a)) && (b == \null || shape_is_there(b));
    requires (pose_a == \null || pose_is_there(pose_a)) && (pose_b == \null || pose_is_there(pose_b));
    requires (claim == \null || \valid_read(claim)) && (proven == \null || \valid(proven));
    ensures \result \in {0, 1, 2, 3, 5, 6, 7, 8, 9, 10, 11, 13};
    behavior refused: assumes proven == \null; assigns \nothing;
    behavior told: assumes proven != \null; assigns *proven; */
collided_check_status collided_check_distance(const collided_check_shape *a, const double pose_a[7],
    const collided_check_shape *b, const double pose_b[7], const collided_check_claim *claim, double allowed_m,
    collided_check_proven *proven)
{
    if (!proven) return COLLIDED_CHECK_NO_POINTER;
    *proven = (collided_check_proven){-INFINITY, INFINITY};
    if (!a || !pose_a || !b || !pose_b || !claim) return COLLIDED_CHECK_NO_POINTER;
    double most = 0;
    collided_check_status status = look_at(a, &most);
    if (status == COLLIDED_CHECK_PROVEN) status = look_at(b, &most);
    if (status != COLLIDED_CHECK_PROVEN) return status;
    if (!is_pose(pose_a) || !is_pose(pose_b)) return COLLIDED_CHECK_BAD_POSE;
    bool below = claim->lo > -INFINITY, above = claim->hi < INFINITY;
    if (!(claim->lo <= claim->hi) || !(claim->lo < INFINITY) || !(claim->hi > -INFINITY) || !is_size(allowed_m))
        return COLLIDED_CHECK_BAD_CLAIM;
    bool plane = a->kind == COLLIDED_CHECK_HALFSPACE || b->kind == COLLIDED_CHECK_HALFSPACE;
    if (below && !plane && !is_axis(claim->axis)) return COLLIDED_CHECK_BAD_AXIS;
    if (above && (!fits3(claim->point_a) || !fits3(claim->point_b))) return COLLIDED_CHECK_BAD_CLAIM;
    if (below) proven->lo = proven_gap(a, pose_a, b, pose_b, claim->axis, most);
    if (above) proven->hi = proven_hi(a, pose_a, b, pose_b, claim, most);
    if (below && !(claim->lo <= proven->lo) && !(claim->lo - proven->lo < allowed_m)) return COLLIDED_CHECK_LO_UNPROVEN;
    if (!above || proven->hi <= claim->hi || proven->hi - claim->hi < allowed_m) return COLLIDED_CHECK_PROVEN;
    return claim->hi < 0 ? COLLIDED_CHECK_DEPTH_UNPROVEN : COLLIDED_CHECK_HI_UNPROVEN;
}

/*@ requires 1 <= count <= COLLIDED_CHECK_TIMES_MOST && \valid_read(times + (0 .. count - 1)); assigns \nothing; */
static bool rise(const double *times, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (!fits(times[i]) || (i && !(times[i - 1] < times[i]))) return false;
    return true;
}

static bool is_rate(double x)
{
    return is_size(x) || x == INFINITY;
}

/* Are both gaps, and what the speed or the bend takes of them, enough for a piece of the time? */
static bool keeps_apart(double first, double last, double margin, double taken)
{
    double sum = first + last, need = 2 * margin + taken;
    double size = magnitude(first) + magnitude(last) + (2 * magnitude(margin) + taken);
    return sum - need > RULE_SLACK * size + TINY;
}

/*@ requires (a == \null || shape_is_there(a)) && (b == \null || shape_is_there(b)) && (m == \null || \valid_read(m));
    requires m != \null && 2 <= m->count <= COLLIDED_CHECK_TIMES_MOST ==>
      (m->times == \null || \valid_read(m->times + (0 .. m->count - 1))) &&
      (m->poses_a == \null || \valid_read(m->poses_a + (0 .. 7 * m->count - 1))) &&
      (m->poses_b == \null || \valid_read(m->poses_b + (0 .. 7 * m->count - 1))) &&
      (m->axes == \null || \valid_read(m->axes + (0 .. 3 * m->count - 1)));
    requires until == \null || \valid(until);
    ensures \result \in {0, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13};
    behavior refused: assumes until == \null; assigns \nothing;
    behavior told: assumes until != \null; assigns *until; */
collided_check_status collided_check_motion_free(
    const collided_check_shape *a, const collided_check_shape *b, const collided_check_motion *m, double *until)
{
    if (!until) return COLLIDED_CHECK_NO_POINTER;
    *until = NAN;
    if (!a || !b || !m || !m->times || !m->poses_a || !m->poses_b || !m->axes) return COLLIDED_CHECK_NO_POINTER;
    double most = 0;
    collided_check_status status = look_at(a, &most);
    if (status == COLLIDED_CHECK_PROVEN) status = look_at(b, &most);
    if (status != COLLIDED_CHECK_PROVEN) return status;
    if (!is_rate(m->speed) || !is_rate(m->bend) || !fits(m->margin)) return COLLIDED_CHECK_BAD_CLAIM;
    if (m->count < 2 || m->count > COLLIDED_CHECK_TIMES_MOST || !rise(m->times, m->count))
        return COLLIDED_CHECK_BAD_TIMES;
    bool plane = a->kind == COLLIDED_CHECK_HALFSPACE || b->kind == COLLIDED_CHECK_HALFSPACE;
    for (size_t k = 0; k < m->count; k++) {
        if (!is_pose(m->poses_a + 7 * k) || !is_pose(m->poses_b + 7 * k)) return COLLIDED_CHECK_BAD_POSE;
        if (!plane && !is_axis(m->axes + 3 * k)) return COLLIDED_CHECK_BAD_AXIS;
    }
    *until = m->times[0];
    for (size_t k = 0; k + 1 < m->count; k++) {
        const double *from_a = m->poses_a + 7 * k, *from_b = m->poses_b + 7 * k, *axis = m->axes + 3 * k;
        double step = m->times[k + 1] - m->times[k];
        double first = proven_gap(a, from_a, b, from_b, axis, most);
        double last = proven_gap(a, from_a + 7, b, from_b + 7, axis + 3, most);
        double along = proven_gap(a, from_a + 7, b, from_b + 7, axis, most);
        double least = along < first ? along : first;
        if (!keeps_apart(first, last, m->margin, m->speed * step) &&
            !keeps_apart(least, least, m->margin, m->bend * step * step * 0.25))
            return COLLIDED_CHECK_TIME_UNPROVEN;
        *until = m->times[k + 1];
    }
    return COLLIDED_CHECK_PROVEN;
}

/*@ requires travel == \null || count > COLLIDED_CHECK_JOINTS_MOST || \valid_read(travel + (0 .. count - 1));
    requires arm == \null || count > COLLIDED_CHECK_JOINTS_MOST || \valid_read(arm + (0 .. count - 1));
    assigns \nothing; */
double collided_check_joint_speed(size_t count, const double *travel, const double *arm)
{
    double sum = 0;
    if (!travel || !arm || count > COLLIDED_CHECK_JOINTS_MOST) return INFINITY;
    for (size_t i = 0; i < count; i++) {
        if (!fits(travel[i]) || !is_size(arm[i])) return INFINITY;
        sum += magnitude(travel[i]) * arm[i];
    }
    return sum * (1 + SPEED_SLACK) + TINY;
}

/* How far from its body's position a shape reaches at most. */
/*@ requires shape_is_there(s); assigns \nothing; */
static double reach_of(const collided_check_shape *s)
{
    double most = 0;
    for (size_t i = 0; i < part_count(s); i++) {
        placed p = part_of(s, s->pose, i, 1);
        double core = s->kind == COLLIDED_CHECK_HALFSPACE ? 0 : length_at_most(vec_of(p.core->half, 1)), sum = p.radius;
        for (size_t k = 0; p.core->kind == COLLIDED_CHECK_HULL && k < p.core->point_count; k++)
            core = larger(core, length_at_most(vec_of(p.core->points + 3 * k, 1)));
        for (int k = 1; k < p.frames; k++) sum += length_at_most(vec_of(p.poses[k], 1));
        most = larger(most, sum + core);
    }
    return most;
}

/*@ requires (a == \null || shape_is_there(a)) && (b == \null || shape_is_there(b));
    requires (linear_a == \null || vector_is_there(linear_a)) && (angular_a == \null || vector_is_there(angular_a));
    requires (linear_b == \null || vector_is_there(linear_b)) && (angular_b == \null || vector_is_there(angular_b));
    requires (speed == \null || \valid(speed)) && (bend == \null || \valid(bend));
    ensures \result \in {0, 5, 6, 7, 8, 9, 11, 13};
    behavior refused: assumes speed == \null || bend == \null; assigns \nothing;
    behavior told: assumes speed != \null && bend != \null; assigns *speed, *bend; */
collided_check_status collided_check_twist(const collided_check_shape *a, const double linear_a[3],
    const double angular_a[3], const collided_check_shape *b, const double linear_b[3], const double angular_b[3],
    double *speed, double *bend)
{
    if (!speed || !bend) return COLLIDED_CHECK_NO_POINTER;
    *speed = INFINITY, *bend = INFINITY;
    if (!a || !linear_a || !angular_a || !b || !linear_b || !angular_b) return COLLIDED_CHECK_NO_POINTER;
    double most = 0;
    collided_check_status status = look_at(a, &most);
    if (status == COLLIDED_CHECK_PROVEN) status = look_at(b, &most);
    if (status != COLLIDED_CHECK_PROVEN) return status;
    if (!fits3(linear_a) || !fits3(angular_a) || !fits3(linear_b) || !fits3(angular_b)) return COLLIDED_CHECK_BAD_CLAIM;
    bool turns_a = most3(angular_a) > 0, turns_b = most3(angular_b) > 0;
    if ((turns_a && a->kind == COLLIDED_CHECK_HALFSPACE) || (turns_b && b->kind == COLLIDED_CHECK_HALFSPACE))
        return COLLIDED_CHECK_BAD_KIND;
    double w_a = length_at_most(vec_of(angular_a, 1)), w_b = length_at_most(vec_of(angular_b, 1));
    double r_a = turns_a ? reach_of(a) : 0, r_b = turns_b ? reach_of(b) : 0;
    vec v = minus(vec_of(linear_b, 1), vec_of(linear_a, 1));
    *speed = (length_at_most(v) + (w_a * r_a + w_b * r_b)) * (1 + SPEED_SLACK) + TINY;
    *bend = (w_a * w_a * r_a + w_b * w_b * r_b) * (1 + SPEED_SLACK) + TINY;
    return COLLIDED_CHECK_PROVEN;
}

/* Corner i of the polygon of differences: it holds the origin when the features meet. */
/*@ requires \valid_read(points + (0 .. 11)) && 0 <= i < 4 && (kind == COLLIDED_CHECK_VERTEX_FACE ==> i < 3);
    assigns \nothing; */
static vec corner(int32_t kind, const double points[12], int i, double by)
{
    int from = kind == COLLIDED_CHECK_VERTEX_FACE ? 0 : i / 2,
        to = kind == COLLIDED_CHECK_VERTEX_FACE ? i + 1 : 2 + i % 2;
    return between(points + 3 * from, points + 3 * to, by);
}

/* Is the direction's product with each corner, which is linear in time, above the separation at both times? */
/*@ requires \valid_read(f); assigns \nothing; */
static bool parts(const collided_check_features *f, vec d, double from, double to, double scale)
{
    double by = 1 / scale, least = f->separation * by * length(d) + FEATURE_SLACK;
    bool apart = true;
    for (int i = 0; i < (f->kind == COLLIDED_CHECK_VERTEX_FACE ? 3 : 4); i++) {
        double start = dot(d, corner(f->kind, f->start, i, by)), end = dot(d, corner(f->kind, f->end, i, by));
        apart = apart && (1 - from) * start + from * end > least && (1 - to) * start + to * end > least;
    }
    return apart;
}

/*@ requires (f == \null || \valid_read(f)) && (until == \null || \valid(until));
    requires f != \null &&
      1 <= f->count < COLLIDED_CHECK_TIMES_MOST ==> (f->times == \null || \valid_read(f->times + (0 .. f->count))) &&
      (f->directions == \null || \valid_read(f->directions + (0 .. 3 * f->count - 1)));
    ensures \result \in {0, 4, 5, 6, 8, 10, 12, 13};
    behavior refused: assumes until == \null; assigns \nothing;
    behavior told: assumes until != \null; assigns *until; */
collided_check_status collided_check_features_free(const collided_check_features *f, double *until)
{
    if (!until) return COLLIDED_CHECK_NO_POINTER;
    *until = NAN;
    if (!f || !f->times || !f->directions) return COLLIDED_CHECK_NO_POINTER;
    if (f->kind != COLLIDED_CHECK_VERTEX_FACE && f->kind != COLLIDED_CHECK_EDGE_EDGE) return COLLIDED_CHECK_BAD_KIND;
    for (int i = 0; i < 12; i++)
        if (!fits(f->start[i]) || !fits(f->end[i])) return COLLIDED_CHECK_BAD_POINTS;
    if (!is_size(f->separation)) return COLLIDED_CHECK_BAD_SIZE;
    if (f->count < 1 || f->count >= COLLIDED_CHECK_TIMES_MOST || !rise(f->times, f->count + 1) || !(f->times[0] >= 0) ||
        !(f->times[f->count] <= 1))
        return COLLIDED_CHECK_BAD_TIMES;
    double most = f->separation;
    for (int i = 0; i < (f->kind == COLLIDED_CHECK_VERTEX_FACE ? 3 : 4); i++) {
        most = larger(most, greatest(corner(f->kind, f->start, i, 1)));
        most = larger(most, greatest(corner(f->kind, f->end, i, 1)));
    }
    double scale = scale_above(most);
    *until = f->times[0];
    for (size_t k = 0; k < f->count; k++) {
        if (!is_axis(f->directions + 3 * k)) return COLLIDED_CHECK_BAD_AXIS;
        if (!parts(f, vec_of(f->directions + 3 * k, 1), f->times[k], f->times[k + 1], scale))
            return COLLIDED_CHECK_TIME_UNPROVEN;
        *until = f->times[k + 1];
    }
    return COLLIDED_CHECK_PROVEN;
}
