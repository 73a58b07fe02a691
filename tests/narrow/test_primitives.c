/* A sphere beside a sphere or a box, and two capsules, in the world (narrow/primitives/primitives.c): bounds, axis and
 * points hold by 113-bit arithmetic, from afar to a few roundings from the surface and beyond it to the centre, for
 * plates and needles, too. */
#include "oracle.h"
#include "polytope_oracle.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#include "primitive_cases.h"

static const double U = 0x1p-53;

/* Of norm 1, or off it by what quat_settled lets pass. */
static quat some_turn(random_state *r)
{
    static const double OFF[] = {1, 1, 1 + 0x1.fp-52, 1 - 0x1.fp-52};
    quat q = random_rotation(r);
    double k = pick(r, OFF, 4);
    quat off = {k * q.w, k * q.x, k * q.y, k * q.z};
    return quat_is_settled(off) ? off : q;
}

static shape some_box(random_state *r)
{
    static const double SIDES[] = {0, 1e-12, 1e-3, 1, 1, 1, 30};
    shape s = {.type = SHAPE_BOX, .radius = random_bits(r) % 4 ? 0 : random_in(r, 0, 0.5)};
    double *half = &s.half.x;
    for (int i = 0; i < 3; i++) half[i] = pick(r, SIDES, 7) * random_in(r, 0.3, 1);
    return s;
}

/* The ball's centre, in the box's frame: by each coordinate inside, on the face but for a few roundings, or outside. */
static vec3 some_place(random_state *r, vec3 half)
{
    static const double NEAR[] = {0, 1e-17, 1e-16, 1e-15, 1e-13, 1e-9, 1e-3}, AWAY[] = {1e-3, 1, 1, 100};
    const double *h = &half.x;
    double at[3];
    for (int i = 0; i < 3; i++) {
        double x = random_bits(r) % 16 ? random_in(r, -1, 1) : 0, side = x < 0 ? -1 : 1;
        at[i] = h[i] * x;
        if (random_bits(r) % 3 == 0) at[i] = side * h[i] * (1 + pick(r, NEAR, 7) * random_in(r, -1, 1));
        if (random_bits(r) % 3 == 0) at[i] = side * (h[i] + pick(r, AWAY, 4) * random_in(r, 0, 1));
    }
    return vec(at[0], at[1], at[2]);
}

static pair some_pair(random_state *r, bool box)
{
    static const double RADII[] = {0, 1e-9, 0.5, 0.5, 10};
    pair x = {.a = {.type = SHAPE_SPHERE, .radius = pick(r, RADII, 5) * random_in(r, 0.3, 1)}};
    x.b = box ? some_box(r) : (shape){.type = SHAPE_SPHERE, .radius = pick(r, RADII, 5) * random_in(r, 0.3, 1)};
    x.at_b = (pose){vec_scale(random_direction(r), random_in(r, 0, 3)), some_turn(r)};
    vec3 away = box ? quat_rotate(x.at_b.q, some_place(r, x.b.half)) : some_place(r, vec(1, 1, 1));
    x.at_a = (pose){vec_add(x.at_b.p, away), some_turn(r)};
    return x;
}

static real greater(real a, real b)
{
    return a > b ? a : b;
}

/* The signed distance, from the definition: of a point from a box (or from a point, which is one without sides), less
 * the radii. */
static real truth_of(const placed *a, const placed *b)
{
    const vec3 half = b->s->type == SHAPE_BOX ? b->s->half : VEC_ZERO;
    real3 t = real3_sub(a->p, b->p);
    real x[3] = {real3_dot(b->rx, t), real3_dot(b->ry, t), real3_dot(b->rz, t)}, most = -INFINITY, square = 0;
    const double *h = &half.x;
    for (int i = 0; i < 3; i++) {
        real beyond = (x[i] < 0 ? -x[i] : x[i]) - h[i];
        most = greater(most, beyond);
        square += beyond > 0 ? beyond * beyond : 0;
    }
    return (most > 0 ? real_sqrt(square) : most) - a->s->radius - b->s->radius;
}

static void check(const pair *x, const narrow_result *r, real truth, uint64_t seed)
{
    placed a = oracle_place(&x->a, x->at_a, x->at_a.p), b = oracle_place(&x->b, x->at_b, x->at_a.p);
    real along = oracle_separation(&a, &b, real3_of(r->axis));
    double size = size_of(x), length = vec_norm(r->axis);
    if (!(r->lo <= truth && truth <= r->hi))
        fail_msg("seed %llu: %.17g outside [%.17g, %.17g]", (unsigned long long)seed, (double)truth, r->lo, r->hi);
    if (!(r->lo <= along && r->lo <= along * length))
        fail_msg("seed %llu: the axis proves %.17g, not %.17g", (unsigned long long)seed, (double)along, r->lo);
    assert_true(fabs(length - 1) <= 16 * U);
    assert_true(r->hi - r->lo <= 60 * U * size && r->status == NARROW_CERTAIN && !r->refined);
    assert_true(r->manifold.count == 0 && r->iterations == 1 && r->peer_failures == 0);
    assert_true(oracle_outside(&a, r->point_a) <= 64 * U * size && oracle_outside(&b, r->point_b) <= 64 * U * size);
    vec3 line = vec_sub(r->point_b, r->point_a);
    if (r->lo > 0) assert_true(vec_norm(line) <= r->hi);
    assert_true(fabs(vec_dot(line, r->axis) - r->lo) <= 100 * U * size);
}

static bool ask(const pair *x, narrow_result *r)
{
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    return primitives_answer_in_world(&x->a, &x->at_a, &x->b, &x->at_b, &request, r);
}

static void what_is_told_holds(void **state)
{
    (void)state;
    int told = 0, n = count_of(60000);
    for (int i = 1; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = some_pair(&r, i % 4);
        narrow_result found;
        if (!ask(&x, &found)) continue;
        told++;
        placed a = oracle_place(&x.a, x.at_a, x.at_a.p), b = oracle_place(&x.b, x.at_b, x.at_a.p);
        check(&x, &found, truth_of(&a, &b), (uint64_t)i);
    }
    if (told < n * 0.9) fail_msg("%d of %d are told", told, n);
}

static shape some_capsule(random_state *r)
{
    static const double HALVES[] = {1e-9, 1e-3, 1, 1, 1, 30}, RADII[] = {0, 1e-3, 0.5, 3};
    return (shape){.type = SHAPE_CAPSULE,
        .radius = pick(r, RADII, 4) * random_in(r, 0.3, 1),
        .half = {0, 0, pick(r, HALVES, 6) * random_in(r, 0.3, 1)}};
}

/* Across each other, side by side, end to end; some nearly parallel, which the formula may leave to others. */
static void capsules_hold(void **state)
{
    (void)state;
    static const double AWAY[] = {1e-12, 1e-6, 0.01, 1, 1, 100}, ASKEW[] = {1e-12, 1e-6, 1e-3};
    int told = 0, n = count_of(8000);
    for (int i = 1; i <= n; i++) {
        random_state r = {(uint64_t)i};
        pair x = {.a = some_capsule(&r), .b = some_capsule(&r)};
        x.at_a = (pose){vec_scale(random_direction(&r), random_in(&r, 0, 3)), some_turn(&r)};
        quat askew = {1, pick(&r, ASKEW, 3) * random_in(&r, -1, 1), 0, 0};
        x.at_b.q = random_bits(&r) % 8 ? some_turn(&r) : quat_unit(quat_mul(x.at_a.q, askew));
        vec3 on_a = vec(0, 0, x.a.half.z * random_in(&r, -1.2, 1.2)),
             on_b = vec(0, 0, x.b.half.z * random_in(&r, -1.2, 1.2));
        vec3 away = vec_scale(random_direction(&r), pick(&r, AWAY, 6) * random_in(&r, 0, 1));
        x.at_b.p = vec_add(vec_sub(pose_point(x.at_a, on_a), quat_rotate(x.at_b.q, on_b)), away);
        narrow_result found;
        if (!ask(&x, &found)) continue;
        told++;
        placed a = oracle_place(&x.a, x.at_a, x.at_a.p), b = oracle_place(&x.b, x.at_b, x.at_a.p);
        check(&x, &found, polytope_signed_distance(&a, &b), (uint64_t)i);
    }
    if (told < n * 0.8) fail_msg("%d of %d are told", told, n);
}

/* Where there is no line, the general road answers. */
static void centres_that_coincide_are_answered(void **state)
{
    (void)state;
    pair x = {.a = {.type = SHAPE_SPHERE, .radius = 1}, .b = {.type = SHAPE_SPHERE, .radius = 2}};
    x.at_a = x.at_b = (pose){{1, 2, 3}, {1, 0, 0, 0}};
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result r;
    assert_false(ask(&x, &r));
    query_where_they_stand(&x.a, x.at_a, &x.b, x.at_b, &request, NULL, &r);
    assert_true(r.lo <= -3 && -3 <= r.hi && r.hi - r.lo <= 2e-14 && fabs(vec_norm(r.axis) - 1) <= 1e-15);
}

/* The one's core ends, but for rounding, on the middle of the other's: what is left between them points nowhere. */
static void a_core_that_ends_on_the_other_has_an_axis(void **state)
{
    (void)state;
    pair x = {.a = {.type = SHAPE_CAPSULE, .radius = 0.375, .half = {0, 0, 0.375}},
        .b = {.type = SHAPE_CAPSULE, .radius = 0.5, .half = {0, 0, 0.625}},
        .at_a = {{-0.875, -1, 0}, {0.5, 0.5, 0.5, 0.5}},
        .at_b = {{-0.875, -1.375, 0},
            {0.27059805007309851, 0.65328148243818829, -0.27059805007309851, 0.65328148243818829}}};
    const narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result r;
    for (int k = 0; k < 16; k++) {
        x.at_a.p.x = -0.875 + (k % 4) * 0.125, x.at_b.p.x = x.at_a.p.x;
        x.at_a.p.y = -1 + (k / 4) * 0.125, x.at_b.p.y = x.at_a.p.y - 0.375;
        query_where_they_stand(&x.a, x.at_a, &x.b, x.at_b, &request, NULL, &r);
        assert_true(r.lo <= -0.875 && -0.875 <= r.hi && fabs(vec_norm(r.axis) - 1) <= 1e-15);
    }
}

static int create(void **state)
{
    (void)state;
    cases_create();
    return 0;
}

static int destroy(void **state)
{
    (void)state;
    cases_destroy();
    return 0;
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(what_is_told_holds), cmocka_unit_test(capsules_hold),
        cmocka_unit_test(centres_that_coincide_are_answered),
        cmocka_unit_test(a_core_that_ends_on_the_other_has_an_axis)};
    return cmocka_run_group_tests(tests, create, destroy);
}
