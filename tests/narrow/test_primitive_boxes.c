/* A capsule and a box, and two boxes, by their formulas (narrow/primitives/primitives.c, box_box.c), against brute
 * force over all features in 113 bits (polytope_oracle.c): gaps, depths and verdicts of any kind, down to a few
 * roundings, thin and long ones, straight and turned by next to nothing; at every size the same, and the same with a
 * cache as without. And how far a matrix of a quaternion is off, which the bounds rest on. */
#include "polytope_oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

#include "primitive_cases.h"

static const shape_type TYPES[][2] = {{SHAPE_CAPSULE, SHAPE_BOX}, {SHAPE_BOX, SHAPE_BOX}};
enum { KINDS = sizeof TYPES / sizeof *TYPES };

static shape some_shape(random_state *r, shape_type type)
{
    static const double SIDES[] = {1e-9, 1e-3, 0.1, 0.5, 0.5, 1, 1, 2, 30};
    shape s = random_shape(r, type);
    if (random_bits(r) % 2) return s;
    s.half = vec(pick(r, SIDES, 9), pick(r, SIDES, 9), pick(r, SIDES, 9));
    if (type == SHAPE_CAPSULE) s.half = vec(0, 0, s.half.z);
    s.radius = random_bits(r) % 2 ? s.radius : 1e-3 * s.radius;
    return s;
}

/* As the other's, or turned from it by half a turn, or by next to nothing, or anyhow. */
static quat some_turn(random_state *r, quat other)
{
    static const quat STRAIGHT[] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0.5, 0.5, 0.5, 0.5}};
    quat q = quat_mul(other, STRAIGHT[random_bits(r) % 4]), little = {1, 0, 0, 0};
    double by = ldexp(random_unit(r), -(int)(random_bits(r) % 60));
    little.x = by * random_in(r, -1, 1), little.y = by * random_in(r, -1, 1);
    unsigned kind = (unsigned)(random_bits(r) % 4);
    return kind == 0 ? q : kind == 1 ? quat_unit(quat_mul(q, little)) : random_rotation(r);
}

static pair random_pair(random_state *r, const shape_type types[2], enum regime regime)
{
    pair x = {.a = some_shape(r, types[0]), .b = some_shape(r, types[1])};
    put_in_order(&x);
    random_poses(r, &x.a, &x.b, regime, &x.at_a, &x.at_b);
    x.at_b.q = some_turn(r, x.at_a.q);
    put_in_frame_of_a(&x);
    return x;
}

/* Of boxes gaps are not measured by a formula alone. */
static narrow_scratch *scratch_for(const pair *x)
{
    return x->a.type == SHAPE_BOX ? case_scratch() : NULL;
}

static bool ask(const pair *x, const narrow_request *request, narrow_result *r)
{
    return ask_with(x, request, NULL, scratch_for(x), r);
}

static narrow_request distance_of(const pair *x)
{
    return (narrow_request){.facts = NARROW_DISTANCE, .tolerance = 1e-12 * size_of(x), .range = INFINITY};
}

static void check(const pair *x, const narrow_result *r, uint64_t seed)
{
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    real truth = polytope_signed_distance(&a, &b), along = oracle_separation(&a, &b, real3_of(r->axis));
    double size = size_of(x), u = 0x1p-53;
    if (!(r->lo <= truth && truth <= r->hi && r->lo <= along))
        fail_msg("seed %llu: truth %.17g, axis %.17g, of [%.17g, %.17g]", (unsigned long long)seed, (double)truth,
            (double)along, r->lo, r->hi);
    bool overlap = r->hi + x->a.radius + x->b.radius < 0, formula = x->a.type == SHAPE_CAPSULE || overlap;
    double width = x->a.type == SHAPE_CAPSULE ? 42 * u : overlap ? 98 * u : 1e-12;
    bool slanted = r->lo <= 0 && r->hi > 0; /* of boxes that touch at edges nearly parallel the gap is told by points */
    if (slanted && x->a.type == SHAPE_BOX) width = 1e-10;
    if (!(r->hi - r->lo <= width * size && (r->status == NARROW_CERTAIN || slanted) && !r->refined))
        fail_msg("seed %llu: [%.17g, %.17g] of %g is wide", (unsigned long long)seed, r->lo, r->hi, size);
    assert_true(oracle_outside(&a, r->point_a) <= 64 * u * size && oracle_outside(&b, r->point_b) <= 64 * u * size);
    vec3 line = vec_sub(r->point_b, r->point_a);
    if (r->lo > 0) assert_true(vec_norm(line) <= r->hi);
    bool deep = r->hi < -1e-10 * size; /* what is less deep than edges nearly parallel are bent has no such points */
    if (deep && formula) assert_true(vec_norm(vec_madd(line, -r->lo, r->axis)) <= 100 * u * size);
}

static void what_is_told_holds(void **state)
{
    (void)state;
    int asked[KINDS] = {0}, answered[KINDS] = {0};
    for (int i = 1, n = count_of(1500) * KINDS; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, TYPES[i % KINDS], (enum regime)(i / KINDS % REGIME_COUNT));
        const narrow_request request = distance_of(&x);
        narrow_result told;
        asked[i % KINDS]++;
        if (!ask(&x, &request, &told)) continue;
        answered[i % KINDS] += told.lo > 0 || ask_with(&x, &request, NULL, NULL, &told);
        check(&x, &told, (uint64_t)i);
    }
    for (int k = 0; k < KINDS; k++)
        if (answered[k] < asked[k] * 0.85) fail_msg("kind %d: %d of %d are answered", k, answered[k], asked[k]);
}

/* B is moved along the axis of the distance to where the two, or their cores, touch, but for `gap` sizes. */
static bool bring(pair *x, double gap, bool cores)
{
    narrow_request request = measure_exactly();
    narrow_result r;
    narrow_query_world(&x->a, x->at_a, &x->b, x->at_b, &request, case_scratch(), &r);
    double by = gap * size_of(x) - r.lo - (cores ? x->a.radius + x->b.radius : 0);
    x->at_b.p = vec_madd(x->at_b.p, by, r.axis);
    return r.status == NARROW_CERTAIN;
}

static void it_holds_to_the_last_roundings(void **state)
{
    (void)state;
    static const double GAPS[] = {0, 1e-17, 1e-16, 1e-15, 1e-14, 1e-12, 1e-9, 1e-6, 1e-3};
    int answered = 0, n = count_of(1200) * KINDS;
    for (int i = 1; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, TYPES[i % KINDS], i % 4 ? REGIME_SHALLOW : REGIME_NEAR);
        if (!bring(&x, GAPS[i % 9] * (random_bits(&r) % 2 ? 1 : -1), random_bits(&r) % 2)) continue;
        const narrow_request request = distance_of(&x);
        narrow_result told;
        if (!ask(&x, &request, &told)) continue;
        answered++;
        check(&x, &told, (uint64_t)i);
    }
    if (answered < n / 2) fail_msg("%d of %d are answered", answered, n);
}

static void verdicts_hold(void **state)
{
    (void)state;
    static const double GAPS[] = {0, 1e-16, 1e-15, 1e-14, 1e-12, 1e-6};
    int decided = 0, n = count_of(1000) * KINDS;
    for (int i = 1; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, TYPES[i % KINDS], (enum regime)(i / KINDS % REGIME_COUNT));
        if (i % 5 == 0) (void)bring(&x, GAPS[i % 6] * (random_bits(&r) % 2 ? 1 : -1), false);
        double threshold = i % 3 ? 0 : random_in(&r, -0.2, 0.3);
        const narrow_request request = {
            .facts = NARROW_VERDICT, .tolerance = INFINITY, .range = INFINITY, .threshold = threshold};
        narrow_result told;
        if (!ask_with(&x, &request, NULL, NULL, &told)) continue;
        placed a = oracle_place(&x.a, x.at_a, x.at_a.p), b = oracle_place(&x.b, x.at_b, x.at_a.p);
        real truth = polytope_signed_distance(&a, &b);
        if (!(told.lo <= truth && truth <= told.hi && told.lo <= oracle_separation(&a, &b, real3_of(told.axis))))
            fail_msg("seed %d: %.17g outside [%.17g, %.17g]", i, (double)truth, told.lo, told.hi);
        assert_true(told.lo > threshold || told.hi <= threshold);
        double slack = 64 * 0x1p-53 * size_of(&x);
        assert_true(oracle_outside(&a, told.point_a) <= slack && oracle_outside(&b, told.point_b) <= slack);
        if (told.lo > 0) assert_true(vec_norm(vec_sub(told.point_b, told.point_a)) <= told.hi);
        decided++;
    }
    if (decided < n * 0.7) fail_msg("%d of %d are decided", decided, n);
}

static void a_cache_changes_no_bit(void **state)
{
    (void)state;
    static const double TOLERANCES[] = {1e-2, 1e-5, 1e-9, 1e-12};
    for (int i = 1, n = count_of(300); i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, TYPES[KINDS - 1], (enum regime)(i % REGIME_COUNT));
        double size = size_of(&x);
        narrow_request request = distance_of(&x);
        request.tolerance = TOLERANCES[i / 4 % 4] * size;
        if (i % 3 == 0) request.facts |= NARROW_VERDICT;
        vec3 step = vec_scale(random_direction(&r), 0.02 * size);
        quat turn = quat_unit((quat){1, random_in(&r, -0.02, 0.02), random_in(&r, -0.02, 0.02), 0});
        narrow_cache cache = {.lower = 0};
        for (int frame = 0; frame < 24; frame++) {
            narrow_result cold, kept;
            x.at_b.p = vec_madd(x.at_b.p, frame < 12 ? 1 : -1, step);
            x.at_b.q = quat_unit(quat_mul(x.at_b.q, turn));
            (void)ask_with(&x, &request, NULL, case_scratch(), &cold);
            (void)ask_with(&x, &request, &cache, case_scratch(), &kept);
            assert_memory_equal(&kept.lo, &cold.lo, offsetof(narrow_result, manifold));
            assert_true(kept.status == cold.status && kept.refined == cold.refined);
        }
    }
}

static void at_every_size_it_is_the_same(void **state)
{
    (void)state;
    for (int i = 1, n = count_of(1000) * KINDS; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = random_pair(&r, TYPES[i % KINDS], (enum regime)(i / KINDS % REGIME_COUNT));
        if (i % 50 == 0) x.at_b.p = x.at_a.p;
        narrow_request request = distance_of(&x);
        if (i / KINDS % 3 == 0) request.facts = NARROW_VERDICT;
        assert_same_at_every_size(&x, &request, scratch_for(&x));
    }
}

/* ---- the matrix ---- */

static real dot_of_columns(const real3 *e, const double *v, int row)
{
    real x[3] = {e[0].x * v[0] + e[1].x * v[1] + e[2].x * v[2], e[0].y * v[0] + e[1].y * v[1] + e[2].y * v[2],
        e[0].z * v[0] + e[1].z * v[1] + e[2].z * v[2]};
    return x[row];
}

/* The greatest |E v| of unit v, from below, by powers of E'E. */
static double norm_of(const real3 e[3])
{
    double v[3] = {0.6, 0.48, 0.64}, norm = 0;
    for (int i = 0; i < 20; i++) {
        double w[3], x[3], norm2 = 0;
        for (int k = 0; k < 3; k++) w[k] = (double)(dot_of_columns(e, v, k) * 0x1p53);
        for (int k = 0; k < 3; k++)
            x[k] = ((double)e[k].x * w[0] + (double)e[k].y * w[1] + (double)e[k].z * w[2]) * 0x1p53;
        for (int k = 0; k < 3; k++) norm2 += x[k] * x[k];
        norm = sqrt(sqrt(norm2));
        if (!(norm > 0)) return 0;
        for (int k = 0; k < 3; k++) v[k] = x[k] / (norm * norm);
    }
    return norm;
}

static quat some_quaternion(random_state *r)
{
    quat q = {random_in(r, -1, 1), random_in(r, -1, 1), random_in(r, -1, 1), random_in(r, -1, 1)};
    unsigned kind = (unsigned)(random_bits(r) % 5);
    if (kind == 1) q.w *= 1e-3;
    if (kind == 2) q.w = 0;
    if (kind == 3) q.x *= 0.01, q.w *= 0.01;
    q = quat_unit(q);
    double by = 1 + random_in(r, -0x1p-51, 0x1p-51); /* as far as it may be off unit */
    quat off = {q.w * by, q.x * by, q.y * by, q.z * by};
    return fabs(quat_norm2(off) - 1) <= 0x1p-50 && random_bits(r) % 2 ? off : q;
}

static void a_matrix_is_off_by_less_than_the_bounds_say(void **state)
{
    (void)state;
    static const shape POINT = {.type = SHAPE_SPHERE};
    double worst = 0;
    for (int i = 1, n = count_of(100000); i <= n; i++) {
        random_state r = {(uint64_t)i};
        quat q = some_quaternion(&r);
        mat3 m = quat_matrix(q);
        placed exact = oracle_place(&POINT, (pose){VEC_ZERO, q}, VEC_ZERO);
        const real3 e[3] = {
            real3_sub(real3_of(m.x), exact.rx), real3_sub(real3_of(m.y), exact.ry), real3_sub(real3_of(m.z), exact.rz)};
        worst = fmax(worst, norm_of(e));
    }
    if (!(worst > 3 && worst < 6.5)) fail_msg("%g u", worst);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_told_holds),
        cmocka_unit_test(it_holds_to_the_last_roundings),
        cmocka_unit_test(verdicts_hold),
        cmocka_unit_test(a_cache_changes_no_bit),
        cmocka_unit_test(at_every_size_it_is_the_same),
        cmocka_unit_test(a_matrix_is_off_by_less_than_the_bounds_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
