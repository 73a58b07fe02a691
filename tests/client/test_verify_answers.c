/* What the engine tells, a client can check: the answers of random pairs, and of pairs on a lattice (cases.h), of all
 * convex types, far from the origin too, are accepted by collided_verify, also with prepared hulls; and a claim that is
 * a little stronger than that is refused. */
#include "cases.h"
#include "cmocka_c.h"

#include <collided.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "geom/hull.h"

enum { POINTS_MAX = 64 };

typedef struct subject {
    collided_shape shape;
    collided_pose pose;
    double points[3 * POINTS_MAX];
    size_t count;
    collided_prepared_hull *prepared;
} subject;

static int pairs_each(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 4000 : getenv("COLLIDED_BRIEF") ? 20 : 200;
}

static void put(vec3 from, double to[3])
{
    to[0] = from.x, to[1] = from.y, to[2] = from.z;
}

static subject subject_of(const shape *s, pose at)
{
    subject out = {.shape = {.type = (collided_shape_type)s->type, .radius = s->radius},
        .pose = {.orientation = {at.q.w, at.q.x, at.q.y, at.q.z}}};
    out.shape.pose = collided_pose_identity();
    put(s->half, out.shape.half);
    put(at.p, out.pose.position);
    if (s->type != SHAPE_HULL) return out;
    out.count = s->hull->vertex_count;
    for (size_t i = 0; i < out.count; i++) put(vec(s->hull->x[i], s->hull->y[i], s->hull->z[i]), out.points + 3 * i);
    out.prepared = collided_prepare_hull(out.points, out.count);
    assert_non_null(out.prepared);
    return out;
}

static collided_status verify(const subject *a, const subject *b, const collided_certificate *claim)
{
    collided_status status = collided_verify(&a->shape, &a->pose, a->count ? a->points : NULL, a->count, &b->shape,
        &b->pose, b->count ? b->points : NULL, b->count, claim);
    assert_int_equal(
        collided_verify_prepared(&a->shape, &a->pose, a->prepared, &b->shape, &b->pose, b->prepared, claim), status);
    return status;
}

/* The engine's points are about A's origin, as its axes are the world's. */
static collided_certificate claim_of(const narrow_result *r, pose at_a)
{
    collided_certificate claim = {.lo = r->lo, .hi = r->hi};
    vec3 a = vec_add(r->point_a, at_a.p), b = vec_add(r->point_b, at_a.p);
    put(r->axis, claim.axis);
    put(a, claim.point_a);
    put(b, claim.point_b);
    return claim;
}

static void check(const shape *a, pose at_a, const shape *b, pose at_b, double tolerance, uint64_t seed)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = tolerance, .range = INFINITY};
    narrow_result r;
    narrow_query_world(a, at_a, b, at_b, &request, case_scratch(), &r);
    if (isinf(r.lo)) return; /* planes that meet */
    subject x = subject_of(a, at_a), y = subject_of(b, at_b);
    collided_certificate claim = claim_of(&r, at_a);
    if (verify(&x, &y, &claim) != COLLIDED_OK)
        fail_msg("%s-%s, seed %llu: [%.17g, %.17g] is refused", shape_type_name(a->type), shape_type_name(b->type),
            (unsigned long long)seed, r.lo, r.hi);
    bool planes = a->type == SHAPE_HALFSPACE || b->type == SHAPE_HALFSPACE;
    double size = 1 + vec_norm(at_a.p) + (planes ? 0 : shape_reach(a) + shape_reach(b)) + fabs(r.lo);
    claim.lo += 1e-6 * size + (r.hi - r.lo);
    claim.hi = fmax(claim.hi, claim.lo);
    if (verify(&x, &y, &claim) != COLLIDED_REJECTED)
        fail_msg("%s-%s, seed %llu: [%.17g, %.17g] is accepted", shape_type_name(a->type), shape_type_name(b->type),
            (unsigned long long)seed, claim.lo, claim.hi);
    collided_free_prepared_hull(x.prepared);
    collided_free_prepared_hull(y.prepared);
}

static void each_answer_is_accepted(bool lattice)
{
    static const double TOLERANCES[] = {0, 1e-12, 1e-6, 1e-3}, AWAY[] = {0, 0, 100, 1e6};
    cases_create();
    for (int ta = 0; ta < SHAPE_CONVEX_COUNT; ta++)
        for (int tb = 0; tb < SHAPE_CONVEX_COUNT; tb++)
            for (int i = 0; i < pairs_each(); i++) {
                uint64_t seed = ((uint64_t)ta << 40) + ((uint64_t)tb << 32) + (uint64_t)i;
                random_state r = {seed};
                pose pa, pb;
                shape a = (lattice ? lattice_shape : random_shape)(&r, (shape_type)ta);
                shape b = (lattice ? lattice_shape : random_shape)(&r, (shape_type)tb);
                if (lattice)
                    lattice_poses(&r, &a, &b, &pa, &pb);
                else
                    random_poses(&r, &a, &b, (enum regime)(i % REGIME_COUNT), &pa, &pb);
                pa.p.x += AWAY[i / 4 % 4];
                pb.p.x += AWAY[i / 4 % 4];
                check(&a, pa, &b, pb, TOLERANCES[i % 4], seed);
            }
    cases_destroy();
}

static void answers_of_random_pairs_are_accepted(void **state)
{
    (void)state;
    each_answer_is_accepted(false);
}

static void answers_of_pairs_on_a_lattice_are_accepted(void **state)
{
    (void)state;
    each_answer_is_accepted(true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(answers_of_random_pairs_are_accepted),
        cmocka_unit_test(answers_of_pairs_on_a_lattice_are_accepted),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
