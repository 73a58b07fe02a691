/* check_cases: see the header. */
#include "check_cases.h"

#include "base/prng.h"
#include "cases.h"
#include "geom/compound.h"
#include "geom/hull.h"
#include "propose.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void put(vec3 from, double to[3])
{
    to[0] = from.x, to[1] = from.y, to[2] = from.z;
}

static void put_pose(pose from, double to[7])
{
    put(from.p, to);
    to[3] = from.q.w, to[4] = from.q.x, to[5] = from.q.y, to[6] = from.q.z;
}

static void put_shape(const shape *from, collided_check_shape *to, double *points)
{
    *to = (collided_check_shape){.kind = (int32_t)from->type,
        .radius = from->radius,
        .deviation = from->deviation,
        .pose = {0, 0, 0, 1, 0, 0, 0}};
    put(from->half, to->half);
    if (from->type != SHAPE_HULL) return;
    to->points = points;
    to->point_count = from->hull->vertex_count;
    if (to->point_count > CASE_POINTS) abort();
    for (size_t i = 0; i < to->point_count; i++)
        put(vec(from->hull->x[i], from->hull->y[i], from->hull->z[i]), points + 3 * i);
}

static void put_subject(const shape *from, pose at, check_subject *to)
{
    put_shape(from, &to->shape, to->points[CASE_CHILDREN]);
    put_pose(at, to->pose);
    if (from->type != SHAPE_COMPOUND) return;
    to->shape.children = to->children;
    to->shape.child_count = from->compound->child_count;
    for (size_t i = 0; i < to->shape.child_count; i++) {
        put_shape(&from->compound->children[i].shape, &to->children[i], to->points[i]);
        put_pose(from->compound->children[i].local, to->children[i].pose);
    }
}

static shape any_shape(random_state *r, int kind, bool lattice, compound **made)
{
    *made = NULL;
    if (kind != CASE_KINDS - 1) return (lattice ? lattice_shape : random_shape)(r, (shape_type)kind);
    shape parts[CASE_CHILDREN];
    pose locals[CASE_CHILDREN];
    size_t count = 1 + random_bits(r) % CASE_CHILDREN;
    for (size_t i = 0; i < count; i++) {
        unsigned type = (unsigned)(random_bits(r) % 7);
        parts[i] = random_shape(r, type == 6 ? SHAPE_HULL : (shape_type)type);
        locals[i] = (pose){vec_scale(random_direction(r), random_unit(r)), random_rotation(r)};
    }
    if (compound_build(parts, locals, count, made) != COMPOUND_OK) abort();
    return (shape){.type = SHAPE_COMPOUND, .compound = *made, .radius = random_bits(r) % 3 ? 0 : 0.05};
}

bool check_engine_case(int kind_a, int kind_b, unsigned index, check_case *out)
{
    static const double TOLERANCES[] = {0, 1e-12, 1e-6, 1e-3}, AWAY[] = {0, 0, 100, 1e6};
    random_state r = {((uint64_t)kind_a << 40) + ((uint64_t)kind_b << 32) + index};
    compound *made[2];
    bool lattice = index % 2 && kind_a < SHAPE_CONVEX_COUNT && kind_b < SHAPE_CONVEX_COUNT;
    shape a = any_shape(&r, kind_a, lattice, &made[0]), b = any_shape(&r, kind_b, lattice, &made[1]);
    pose at_a, at_b;
    if (lattice)
        lattice_poses(&r, &a, &b, &at_a, &at_b);
    else
        random_poses(&r, &a, &b, (enum regime)(index / 2 % REGIME_COUNT), &at_a, &at_b);
    at_a.p.x += AWAY[index / 8 % 4], at_b.p.x += AWAY[index / 8 % 4];
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = TOLERANCES[index / 2 % 4], .range = INFINITY};
    narrow_result result;
    narrow_query_world(&a, at_a, &b, at_b, &request, case_scratch(), &result);
    memset(out, 0, sizeof *out);
    put_subject(&a, at_a, &out->a);
    put_subject(&b, at_b, &out->b);
    for (int i = 0; i < 2; i++) compound_destroy(made[i]);
    if (isinf(result.lo)) return false;
    out->claim.lo = result.lo, out->claim.hi = result.hi;
    put(result.axis, out->claim.axis);
    put(vec_add(result.point_a, at_a.p), out->claim.point_a);
    put(vec_add(result.point_b, at_a.p), out->claim.point_b);
    return true;
}

/* ---- hostile ---- */

static double odd_size(uint64_t *s, double scale)
{
    static const double SHARES[] = {0, 0, 1e-300, 1e-16, 1e-9, 1e-3, 1, 1, 1e3, 1e9};
    return scale * SHARES[prng_bits(s) % 10] * prng_in(s, 0.5, 1);
}

static void odd_pose(uint64_t *s, double scale, double out[7])
{
    double q[4], sum = 0;
    for (int i = 0; i < 3; i++) out[i] = odd_size(s, scale) * (prng_bits(s) % 2 ? 1 : -1);
    for (int i = 0; i < 4; i++) q[i] = prng_bits(s) % 4 ? prng_in(s, -1, 1) : 0, sum += q[i] * q[i];
    double norm = sum > 0 ? sqrt(sum) * prng_in(s, 0.9995, 1.0005) : 1;
    for (int i = 0; i < 4; i++) out[3 + i] = sum > 0 ? q[i] / norm : i == 0;
}

static void odd_core(uint64_t *s, double scale, int kind, collided_check_shape *out, double *points)
{
    out->kind = kind;
    for (int i = 0; i < 3; i++) out->half[i] = odd_size(s, scale);
    out->radius = prng_bits(s) % 2 ? odd_size(s, scale) : 0;
    out->deviation = prng_bits(s) % 4 ? 0 : odd_size(s, scale);
    odd_pose(s, scale, out->pose);
    if (kind != COLLIDED_CHECK_HULL) return;
    out->points = points;
    out->point_count = 1 + prng_bits(s) % 12;
    double spread[3] = {odd_size(s, scale), odd_size(s, scale), odd_size(s, scale)};
    for (size_t i = 0; i < 3 * out->point_count; i++) points[i] = spread[i % 3] * prng_in(s, -1, 1);
}

static void odd_subject(uint64_t *s, double scale, check_subject *out)
{
    int kind = (int)(prng_bits(s) % CASE_KINDS);
    if (kind < CASE_KINDS - 1) {
        odd_core(s, scale, kind, &out->shape, out->points[CASE_CHILDREN]);
    } else {
        odd_core(s, scale, COLLIDED_CHECK_COMPOUND, &out->shape, NULL);
        out->shape.children = out->children;
        out->shape.child_count = 1 + prng_bits(s) % 3;
        for (size_t i = 0; i < out->shape.child_count; i++) {
            int child = (int)(prng_bits(s) % 7);
            odd_core(s, scale, child == 6 ? COLLIDED_CHECK_HULL : child, &out->children[i], out->points[i]);
        }
    }
    odd_pose(s, scale, out->pose);
}

static void turn(const double q[4], const double v[3], double out[3])
{
    double w = q[0], x = q[1], y = q[2], z = q[3], by = 2 / (w * w + x * x + y * y + z * z);
    double c[3] = {y * v[2] - z * v[1], z * v[0] - x * v[2], x * v[1] - y * v[0]};
    out[0] = v[0] + by * (w * c[0] + y * c[2] - z * c[1]);
    out[1] = v[1] + by * (w * c[1] + z * c[0] - x * c[2]);
    out[2] = v[2] + by * (w * c[2] + x * c[1] - y * c[0]);
}

/* A world point on the surface of a shape, up to rounding, or just off it. */
static void odd_point(uint64_t *s, const check_subject *of, double scale, double out[3])
{
    static const double OFF[] = {0, 0, 1e-16, 1e-14, 1e-12, 1e-9, 1e-3, 1};
    const collided_check_shape *core = &of->shape;
    if (core->child_count) core = &core->children[prng_bits(s) % core->child_count];
    double v[3], off = 1 + OFF[prng_bits(s) % 8] * prng_in(s, -1, 1);
    for (int i = 0; i < 3; i++)
        v[i] = core->half[i] * (prng_bits(s) % 3 ? prng_in(s, -1, 1) : prng_bits(s) % 2 ? 1 : -1);
    if (core->kind == COLLIDED_CHECK_HULL)
        for (int i = 0; i < 3; i++) v[i] = core->points[3 * (prng_bits(s) % core->point_count) + (size_t)i];
    for (int i = 0; i < 3; i++) v[i] *= off;
    if (core != &of->shape) {
        turn(core->pose + 3, v, v);
        for (int i = 0; i < 3; i++) v[i] += core->pose[i];
    }
    double w[3];
    turn(of->shape.pose + 3, v, w);
    for (int i = 0; i < 3; i++) w[i] += of->shape.pose[i];
    turn(of->pose + 3, w, out);
    for (int i = 0; i < 3; i++) out[i] += of->pose[i] + (prng_bits(s) % 8 ? 0 : odd_size(s, scale));
}

void check_hostile_case(uint64_t seed, check_case *out)
{
    static const double SCALES[] = {1, 1, 1, 1e-6, 1e6, 1e-90, 1e90};
    uint64_t s = seed;
    double scale = SCALES[prng_bits(&s) % 7], sum = 0;
    memset(out, 0, sizeof *out);
    odd_subject(&s, scale, &out->a);
    odd_subject(&s, scale, &out->b);
    for (int i = 0; i < 3; i++) out->claim.axis[i] = prng_bits(&s) % 4 ? prng_in(&s, -1, 1) : 0;
    for (int i = 0; i < 3; i++) sum += out->claim.axis[i] * out->claim.axis[i];
    double norm = sum > 0 ? sqrt(sum) * prng_in(&s, 0.9995, 1.0005) : 1;
    for (int i = 0; i < 3; i++) out->claim.axis[i] = sum > 0 ? out->claim.axis[i] / norm : i == 2;
    odd_point(&s, &out->a, scale, out->claim.point_a);
    odd_point(&s, &out->b, scale, out->claim.point_b);
}

/* ---- what belongs to a case ---- */

static double most_of(const double *v, size_t count)
{
    double most = 0;
    for (size_t i = 0; i < count; i++) most = fmax(most, fabs(v[i]));
    return most;
}

static double size_of(const collided_check_shape *s)
{
    double size = fmax(fmax(most_of(s->half, 3), most_of(s->pose, 3)), fmax(s->radius, s->deviation));
    if (s->points) size = fmax(size, most_of(s->points, 3 * s->point_count));
    for (size_t i = 0; i < s->child_count; i++) size = fmax(size, size_of(&s->children[i]));
    return size;
}

double check_size(const check_case *c)
{
    double size = fmax(size_of(&c->a.shape), size_of(&c->b.shape));
    const collided_check_claim *claim = &c->claim;
    for (int i = 0; i < 3; i++) {
        size = fmax(size, fabs(c->b.pose[i] - c->a.pose[i]));
        size = fmax(size, fabs(claim->point_a[i] - c->a.pose[i]));
        size = fmax(size, fabs(claim->point_b[i] - c->b.pose[i]));
        size = fmax(size, fabs(claim->point_b[i] - claim->point_a[i]));
    }
    return size;
}

static void turn_back(const double q[4], const double v[3], double out[3])
{
    double back[4] = {-q[0], q[1], q[2], q[3]};
    turn(back, v, out);
}

void check_nearest(const check_subject *s, size_t child, const double point[3], check_near *out)
{
    const collided_check_shape *core = s->shape.child_count ? &s->shape.children[child] : &s->shape;
    const double *frames[3] = {s->pose, s->shape.pose, core->pose};
    double q[3] = {point[0], point[1], point[2]}, u[3], most = size_of(core);
    for (int k = 0; k < (s->shape.child_count ? 3 : 2); k++) {
        double moved[3] = {q[0] - frames[k][0], q[1] - frames[k][1], q[2] - frames[k][2]};
        turn_back(frames[k] + 3, moved, q);
    }
    *out = (check_near){.at = {q[0], q[1], q[2]}};
    int exponent;
    frexp(fmax(fmax(most, most_of(q, 3)), 0x1p-400), &exponent);
    double by = ldexp(1, -exponent), half[3] = {core->half[0] * by, core->half[1] * by, core->half[2] * by};
    for (int i = 0; i < 3; i++) q[i] *= by;
    if (core->kind == COLLIDED_CHECK_ELLIPSOID) {
        propose_ellipsoid(q, half, u);
        for (int i = 0; i < 3; i++) out->at[i] = half[i] * u[i] / by;
    } else if (core->kind == COLLIDED_CHECK_HULL) {
        propose_hull(core->points, core->point_count, q, by, out->corners, out->weights);
        for (int i = 0; i < 3; i++) {
            out->at[i] = 0;
            for (int k = 0; k < 4; k++) out->at[i] += out->weights[k] * core->points[3 * out->corners[k] + (size_t)i];
        }
    }
}

static void print_numbers(FILE *to, const double *v, size_t count)
{
    for (size_t i = 0; i < count; i++) fprintf(to, "%a ", v[i]);
}

static void print_shape(FILE *to, const collided_check_shape *s)
{
    fprintf(to, "%d ", (int)s->kind);
    print_numbers(to, s->half, 3);
    print_numbers(to, &s->radius, 1);
    print_numbers(to, &s->deviation, 1);
    print_numbers(to, s->pose, 7);
    fprintf(to, "%zu ", s->point_count);
    print_numbers(to, s->points, 3 * s->point_count);
    fprintf(to, "%zu ", s->child_count);
    for (size_t i = 0; i < s->child_count; i++) print_shape(to, &s->children[i]);
}

void check_print(FILE *to, const check_case *c, const collided_check_proven *proven)
{
    const check_subject *both[2] = {&c->a, &c->b};
    const double *points[2] = {c->claim.point_a, c->claim.point_b};
    for (int i = 0; i < 2; i++) {
        print_shape(to, &both[i]->shape);
        print_numbers(to, both[i]->pose, 7);
    }
    print_numbers(to, c->claim.axis, 3);
    for (int i = 0; i < 2; i++) print_numbers(to, points[i], 3);
    for (int i = 0; i < 2; i++)
        for (size_t k = 0; k < (both[i]->shape.child_count ? both[i]->shape.child_count : 1); k++) {
            check_near near;
            check_nearest(both[i], k, points[i], &near);
            print_numbers(to, near.at, 3);
        }
    fprintf(to, "%a %a\n", proven->lo, proven->hi);
}
