/* Relations between answers that hold whatever the truth is, over random pairs of all shape types, from a fixed seed.
 *
 * They are the metamorphic relations of the shared extremes.json: swap, scale by 2^k, shift by a representable vector,
 * permutation of a hull's points and of axes, reflection,
 * one last bit, moving apart by the depth; and: a cache may change the time, never the answer. The
 * oracle checks the proof of every answer. COLLIDED_NIGHTLY=1 runs a hundred times as many pairs. */
#include "judge.h"
#include "random_pair.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

typedef struct trial {
    subject a, b;
    narrow_result result; /* of ask(a, b) */
    double size;
    uint64_t seed; /* to make this one pair again */
} trial;

/* What is wrong with the pair, or NULL. */
typedef const char *relation(trial *t, uint64_t *random);

static size_t pairs_wanted(size_t count)
{
    const char *nightly = getenv("COLLIDED_NIGHTLY");
    return nightly && strcmp(nightly, "1") == 0 ? 100 * count : count;
}

static void print_pair(const trial *t, const char *fault)
{
    const subject *s[2] = {&t->a, &t->b};
    printf("seed 0x%llx: %s\n", (unsigned long long)t->seed, fault);
    for (int i = 0; i < 2; i++) {
        const pose *p = &s[i]->pose;
        printf("  %s half %a %a %a radius %a p %a %a %a q %a %a %a %a\n", shape_type_name(s[i]->shape.type),
            s[i]->shape.half.x, s[i]->shape.half.y, s[i]->shape.half.z, s[i]->shape.radius, p->p.x, p->p.y, p->p.z,
            p->q.w, p->q.x, p->q.y, p->q.z);
    }
    printf("  lo %.17g hi %.17g axis %.17g %.17g %.17g by %s\n", t->result.lo, t->result.hi, t->result.axis.x,
        t->result.axis.y, t->result.axis.z, narrow_method_name(t->result.method));
}

/* All pairs of types in turn, none of two half-spaces. */
static void types_of(size_t i, shape_type *a, shape_type *b)
{
    *a = (shape_type)(i % SHAPE_CONVEX_COUNT);
    *b = (shape_type)(i / SHAPE_CONVEX_COUNT % SHAPE_CONVEX_COUNT);
    if (*b == SHAPE_HALFSPACE) *b = SHAPE_BOX;
}

enum { FAULTS_PRINTED = 5 };

static void hold_for_all(relation *check, size_t count, uint64_t seed)
{
    size_t faults = 0;
    count = pairs_wanted(count);
    for (size_t i = 0; i < count; i++) {
        trial t = {.seed = seed + i * 0x632be59bd9b4e019};
        uint64_t random = t.seed;
        shape_type type_a, type_b;
        types_of(i, &type_a, &type_b);
        random_pair(&random, type_a, type_b, &t.a, &t.b);
        t.size = (double)oracle_size(&t.a.exact, &t.b.exact);
        ask(&t.a, &t.b, &t.result);
        const char *fault = check(&t, &random);
        if (fault && faults++ < FAULTS_PRINTED) print_pair(&t, fault);
        subject_free(&t.a);
        subject_free(&t.b);
    }
    if (faults) fail_msg("%zu of %zu pairs", faults, count);
}

static bool same(vec3 a, vec3 b)
{
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

/* ---- the proof itself ---- */

static const char *proof_holds(trial *t, uint64_t *random)
{
    (void)random;
    return check_certificate(&t->a, &t->b, &t->result, 1e-13 * t->size + 16 * (t->result.hi - t->result.lo));
}

static const char *width_is_small(trial *t, uint64_t *random)
{
    (void)random;
    double width = t->result.hi - t->result.lo;
    return width <= widest_allowed(&t->a, &t->b, &t->result) * t->size ? NULL : "the interval is too wide";
}

static const char *truth_is_within(trial *t, uint64_t *random)
{
    (void)random;
    oracle_truth truth = oracle_distance(&t->a.exact, &t->b.exact);
    return t->result.lo <= truth.hi && t->result.hi >= truth.lo ? NULL : "the truth is outside of the interval";
}

/* ---- relations ---- */

static const char *swap_negates(trial *t, uint64_t *random)
{
    (void)random;
    narrow_result r;
    ask(&t->b, &t->a, &r);
    if (r.lo != t->result.lo || r.hi != t->result.hi) return "swapped, the interval differs";
    if (!same(vec_neg(r.axis), t->result.axis)) return "swapped, the axis is not the opposite";
    return NULL;
}

static shape scaled_shape(const shape *s, int k)
{
    shape out = *s;
    out.radius = ldexp(s->radius, k);
    out.half = vec(ldexp(s->half.x, k), ldexp(s->half.y, k), ldexp(s->half.z, k));
    return out;
}

/* The same subject, 2^k as large. */
static void scaled(const subject *s, int k, subject *out)
{
    if (s->hull) {
        double points[3 * RANDOM_HULL_POINTS];
        for (size_t i = 0; i < s->exact.count; i++) {
            points[3 * i] = ldexp((double)s->points[i].x, k);
            points[3 * i + 1] = ldexp((double)s->points[i].y, k);
            points[3 * i + 2] = ldexp((double)s->points[i].z, k);
        }
        const char *why = subject_from_points(out, points, s->exact.count, ldexp(s->shape.radius, k));
        if (why) fail_msg("scaled by 2^%d, the hull is refused: %s", k, why);
    } else {
        subject_from_shape(out, scaled_shape(&s->shape, k));
    }
    vec3 p = s->pose.p;
    subject_place(out, (pose){vec(ldexp(p.x, k), ldexp(p.y, k), ldexp(p.z, k)), s->pose.q});
}

static bool same_scaled(vec3 small, int k, vec3 large)
{
    return ldexp(small.x, k) == large.x && ldexp(small.y, k) == large.y && ldexp(small.z, k) == large.z;
}

static const char *scale_changes_exponents_only(trial *t, uint64_t *random)
{
    static const int powers[] = {-300, -40, -1, 1, 40, 300};
    int k = powers[random_bits(random) % 6];
    subject a, b;
    narrow_result r;
    const narrow_result *before = &t->result;
    scaled(&t->a, k, &a);
    scaled(&t->b, k, &b);
    ask(&a, &b, &r);
    subject_free(&a);
    subject_free(&b);
    if (ldexp(before->lo, k) != r.lo || ldexp(before->hi, k) != r.hi) return "scaled, the interval differs";
    if (!same(before->axis, r.axis)) return "scaled, the axis differs";
    if (!same_scaled(before->point_a, k, r.point_a) || !same_scaled(before->point_b, k, r.point_b))
        return "scaled, the points differ";
    return NULL;
}

static const char *shift_changes_nothing(trial *t, uint64_t *random)
{
    vec3 by = vec((double)(random_bits(random) % 4096) - 2048, (double)(random_bits(random) % 4096) - 2048,
        (double)(random_bits(random) % 4096) - 2048);
    narrow_result r;
    subject_place(&t->a, (pose){vec_add(t->a.pose.p, by), t->a.pose.q});
    subject_place(&t->b, (pose){vec_add(t->b.pose.p, by), t->b.pose.q});
    ask(&t->a, &t->b, &r);
    if (r.lo != t->result.lo || r.hi != t->result.hi) return "shifted, the interval differs";
    if (!same(r.axis, t->result.axis)) return "shifted, the axis differs";
    if (!same(r.point_a, t->result.point_a) || !same(r.point_b, t->result.point_b)) return "shifted, the points differ";
    return NULL;
}

/* Both answers hold the same truth: they may differ by their widths and 4 ulp of the size. */
static bool agree_within(const trial *t, const narrow_result *r, double moved)
{
    double slack = moved + 8 * 0x1p-53 * t->size + (t->result.hi - t->result.lo) + (r->hi - r->lo);
    return fabs(r->lo - t->result.lo) <= slack && fabs(r->hi - t->result.hi) <= slack;
}

static bool agree(const trial *t, const narrow_result *r)
{
    return agree_within(t, r, 0);
}

/* The mirror image in x. All shapes but hulls are their own; every number keeps its bits but for signs. */
static void mirrored(const subject *s, subject *out)
{
    double points[3 * RANDOM_HULL_POINTS];
    for (size_t i = 0; s->hull && i < s->exact.count; i++) {
        points[3 * i] = -(double)s->points[i].x;
        points[3 * i + 1] = (double)s->points[i].y, points[3 * i + 2] = (double)s->points[i].z;
    }
    if (!s->hull)
        subject_from_shape(out, s->shape);
    else if (subject_from_points(out, points, s->exact.count, s->shape.radius))
        fail_msg("mirrored, a hull is refused");
    pose at = s->pose;
    subject_place(out, (pose){vec(-at.p.x, at.p.y, at.p.z), {at.q.w, at.q.x, -at.q.y, -at.q.z}});
}

static const char *reflection_changes_nothing(trial *t, uint64_t *random)
{
    (void)random;
    subject a, b;
    narrow_result r;
    mirrored(&t->a, &a);
    mirrored(&t->b, &b);
    ask(&a, &b, &r);
    subject_free(&a);
    subject_free(&b);
    return agree(t, &r) ? NULL : "mirrored, the interval differs";
}

/* x becomes y, y becomes z, z becomes x: a third of a turn about (1, 1, 1), exact but for the rounding of quaternions.
 */
static const char *axis_permutation_changes_nothing(trial *t, uint64_t *random)
{
    (void)random;
    static const quat third = {0.5, 0.5, 0.5, 0.5};
    subject *both[2] = {&t->a, &t->b};
    narrow_result r;
    for (int i = 0; i < 2; i++) {
        vec3 p = both[i]->pose.p;
        subject_place(both[i], (pose){vec(p.z, p.x, p.y), quat_mul(third, both[i]->pose.q)});
    }
    ask(&t->a, &t->b, &r);
    return agree(t, &r) ? NULL : "turned, the interval differs";
}

static const char *last_bit_changes_last_bits(trial *t, uint64_t *random)
{
    narrow_result r;
    pose at = t->b.pose;
    double *coordinates[3] = {&at.p.x, &at.p.y, &at.p.z};
    double *moved = coordinates[random_bits(random) % 3];
    double before = *moved;
    *moved = nextafter(before, random_bits(random) & 1 ? INFINITY : -INFINITY);
    subject_place(&t->b, at);
    ask(&t->a, &t->b, &r);
    return agree_within(t, &r, fabs(*moved - before)) ? NULL : "moved by the last bit, the interval jumps";
}

/* The order of a hull's points changes the distance by 4 ulp of the size at most, beyond what the interval admits. */
static const char *permutation_changes_nothing(trial *t, uint64_t *random)
{
    double points[3 * RANDOM_HULL_POINTS];
    size_t count = t->b.exact.count;
    size_t order[RANDOM_HULL_POINTS];
    if (t->b.shape.type != SHAPE_HULL) return NULL;
    for (size_t i = 0; i < count; i++) order[i] = i;
    for (size_t left = count; left > 1; left--) {
        size_t j = random_bits(random) % left, keep = order[left - 1];
        order[left - 1] = order[j], order[j] = keep;
    }
    for (size_t i = 0; i < count; i++) {
        qvec p = t->b.points[order[i]];
        points[3 * i] = (double)p.x, points[3 * i + 1] = (double)p.y, points[3 * i + 2] = (double)p.z;
    }
    subject shuffled;
    narrow_result r;
    if (subject_from_points(&shuffled, points, count, t->b.shape.radius)) return "permuted, the hull is refused";
    subject_place(&shuffled, t->b.pose);
    ask(&t->a, &shuffled, &r);
    subject_free(&shuffled);
    return agree(t, &r) ? NULL : "permuted, the interval differs";
}

/* B moved along the axis by a little more than the depth is apart; by a little less it is not. */
static const char *depth_separates(trial *t, uint64_t *random)
{
    (void)random;
    double depth = -t->result.lo;
    if (!(t->result.hi < -1e-9 * t->size)) return NULL;
    narrow_result more, less;
    pose at = t->b.pose;
    subject_place(&t->b, (pose){vec_madd(at.p, 1.001 * depth, t->result.axis), at.q});
    ask(&t->a, &t->b, &more);
    subject_place(&t->b, (pose){vec_madd(at.p, 0.999 * -t->result.hi, t->result.axis), at.q});
    ask(&t->a, &t->b, &less);
    subject_place(&t->b, at);
    if (!(more.lo > 0)) return "moved by 1.001 of the depth, it is not apart";
    if (!(less.hi < 0)) return "moved by 0.999 of the depth, it is apart";
    return NULL;
}

/* A pair followed through a motion in small steps, with its cache, answers each time what a cold one answers. */
static const char *cache_changes_nothing(trial *t, uint64_t *random)
{
    static _Alignas(64) unsigned char memory[1 << 21];
    narrow_scratch *scratch = (narrow_scratch *)(void *)memory;
    const narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    if (narrow_scratch_size() > sizeof memory) return "the scratch does not fit";
    bool in_order = narrow_ordered(&t->a.shape, 0, &t->b.shape, 1);
    const subject *first = in_order ? &t->a : &t->b, *second = in_order ? &t->b : &t->a;
    pose b_in_a = pose_relative(first->pose, second->pose);
    vec3 step = vec_scale(vec(random_uniform(random, -1, 1), random_uniform(random, -1, 1), 0.5), 0.02);
    quat turn = quat_unit((quat){1, random_uniform(random, -0.02, 0.02), random_uniform(random, -0.02, 0.02), 0});
    narrow_cache cache = {.hint_a = 0};
    for (int i = 0; i < 12; i++) {
        narrow_cache empty = {.hint_a = 0};
        narrow_result warm, cold;
        narrow_query(&first->shape, &second->shape, &b_in_a, &request, &cache, scratch, &warm);
        narrow_query(&first->shape, &second->shape, &b_in_a, &request, &empty, scratch, &cold);
        if (warm.lo != cold.lo || warm.hi != cold.hi) return "with its cache, the interval differs";
        if (!same(warm.axis, cold.axis)) return "with its cache, the axis differs";
        if (!same(warm.point_a, cold.point_a) || !same(warm.point_b, cold.point_b))
            return "with its cache, the points differ";
        b_in_a = (pose){vec_add(b_in_a.p, step), quat_unit(quat_mul(turn, b_in_a.q))};
    }
    return NULL;
}

#define HOLDS(name, check, count, seed)                                                                                \
    static void name(void **state)                                                                                     \
    {                                                                                                                  \
        (void)state;                                                                                                   \
        hold_for_all(check, count, seed);                                                                              \
    }

HOLDS(every_answer_proves_itself, proof_holds, 1024, 1)
HOLDS(every_interval_is_narrow, width_is_small, 2048, 2)
HOLDS(every_interval_holds_the_truth, truth_is_within, 256, 3)
HOLDS(swapping_negates_the_axis_and_nothing_else, swap_negates, 3072, 4)
HOLDS(scaling_by_a_power_of_two_changes_exponents_only, scale_changes_exponents_only, 1536, 5)
HOLDS(shifting_by_a_representable_vector_changes_nothing, shift_changes_nothing, 1536, 6)
HOLDS(permuting_hull_points_changes_nothing, permutation_changes_nothing, 1536, 7)
HOLDS(mirroring_changes_nothing, reflection_changes_nothing, 768, 10)
HOLDS(permuting_axes_changes_nothing, axis_permutation_changes_nothing, 768, 11)
HOLDS(moving_by_the_last_bit_moves_last_bits, last_bit_changes_last_bits, 768, 12)
HOLDS(moving_by_the_depth_separates, depth_separates, 1536, 8)
HOLDS(cached_equals_cold_over_coherent_motion, cache_changes_nothing, 384, 9)

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_answer_proves_itself),
        cmocka_unit_test(every_interval_is_narrow),
        cmocka_unit_test(every_interval_holds_the_truth),
        cmocka_unit_test(swapping_negates_the_axis_and_nothing_else),
        cmocka_unit_test(scaling_by_a_power_of_two_changes_exponents_only),
        cmocka_unit_test(shifting_by_a_representable_vector_changes_nothing),
        cmocka_unit_test(permuting_hull_points_changes_nothing),
        cmocka_unit_test(mirroring_changes_nothing),
        cmocka_unit_test(permuting_axes_changes_nothing),
        cmocka_unit_test(moving_by_the_last_bit_moves_last_bits),
        cmocka_unit_test(moving_by_the_depth_separates),
        cmocka_unit_test(cached_equals_cold_over_coherent_motion),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
