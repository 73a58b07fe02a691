/* Balls, capsules and boxes: what does not turn against 113 bits (the distance of a centre from a box, the fifteen axes
 * of two boxes), what turns, nearly or exactly parallel, against the march of toi_truth.h. */
#include "cases.h"
#include "oracle/quad.h"
#include "toi/toi.h"
#include "toi_truth.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>

#include <cmocka.h>
#include <stdio.h>

enum {
    BALLS = 2500,
    BOXES = 6000,
    PARALLEL = 1200,
    RODS = 1500,
    HALVINGS = 80
}; /* COLLIDED_NIGHTLY: 20 times as many */

static int times(int count)
{
    return getenv("COLLIDED_NIGHTLY") ? 20 * count : getenv("COLLIDED_BRIEF") ? count / 5 : count;
}

typedef struct tally {
    int hits, frees, searched, unclear;
} tally;

/* `truth`: of the first contact; infinite: never. */
static void check(const toi_result *t, quad truth, double scale, tally *all)
{
    all->searched += t->queries > 0 && truth > 0;
    if (t->status == TOI_FREE) {
        assert_true(isinf((double)truth));
        all->frees++;
        return;
    }
    assert_true(t->status != TOI_UNDECIDED && (quad)t->lo <= truth);
    assert_true(!isinf((double)truth) || t->status == TOI_NEAR);
    if (t->status != TOI_HIT) return;
    assert_true((quad)t->hi >= truth);
    all->hits++;
    if (t->hi == 0) return;
    double gap = vec_norm(vec_sub(t->point_b, t->point_a));
    assert_true(t->gap_lo <= t->gap_hi && fabs(gap) <= fmax(t->gap_hi, 0) + 1e-13 * scale);
    assert_true(t->gap_lo <= 2e-9 * scale && t->closing >= 0 && fabs(vec_norm(t->axis) - 1) < 1e-14);
}

/* B's rotation in A's frame does not matter: A does not turn, and has the identity. */
static toi_mover still(const shape *s, vec3 at, quat q, vec3 velocity)
{
    return (toi_mover){s, POSE_IDENTITY, {{at, q}, velocity, VEC_ZERO}};
}

static qmat quad_rotation(quat q)
{
    quad w = q.w, x = q.x, y = q.y, z = q.z, s = 2 / (w * w + x * x + y * y + z * z);
    return (qmat){{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
        {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
        {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
}

/* ---- a ball and a box ---- */

typedef struct quad_flight { /* of a centre, in the box's frame */
    quad from[3], velocity[3], half[3];
} quad_flight;

static quad distance2(const quad_flight *f, quad time)
{
    quad sum = 0;
    for (int i = 0; i < 3; i++) {
        quad out = q_abs(f->from[i] + time * f->velocity[i]) - f->half[i];
        if (out > 0) sum += out * out;
    }
    return sum;
}

/* Convex in time: its least value by thirds, the contact before that by halves. */
static quad ball_truth(const quad_flight *f, quad reach)
{
    quad lo = 0, hi = 1;
    if (distance2(f, 0) <= reach * reach) return 0;
    for (int k = 0; k < 2 * HALVINGS; k++) {
        quad one = lo + (hi - lo) / 3, two = hi - (hi - lo) / 3;
        if (distance2(f, one) <= distance2(f, two))
            hi = two;
        else
            lo = one;
    }
    if (distance2(f, hi) > reach * reach) return INFINITY;
    for (lo = 0; hi - lo > 0x1p-70;) {
        quad middle = (lo + hi) / 2;
        if (distance2(f, middle) <= reach * reach)
            hi = middle;
        else
            lo = middle;
    }
    return hi;
}

static void a_ball_meets_a_box_when_its_distance_says(void **state)
{
    (void)state;
    tally all = {0};
    for (int i = 0; i < times(BALLS); i++) {
        random_state r = {0xba11 + (uint64_t)i};
        double scale = i % 4 == 0 ? 0x1p-40 : i % 4 == 1 ? 0x1p40 : 1;
        shape ball = {.type = SHAPE_SPHERE, .radius = scale * random_in(&r, 0.001, 1)};
        shape box = {.type = SHAPE_BOX,
            .radius = i % 3 ? 0 : scale * random_in(&r, 0, 0.5),
            .half = vec_scale(vec(random_in(&r, 0, 1), random_in(&r, 0, 1), random_in(&r, 0, 1)), scale)};
        vec3 from = vec_scale(random_direction(&r), scale * random_in(&r, 2, 6));
        vec3 aim = vec_scale(random_direction(&r), scale * random_in(&r, 0, 2));
        vec3 velocity = vec_scale(vec_sub(aim, from), random_in(&r, 0.3, 3));
        if (i % 5 == 0) velocity.x = 0; /* along planes of faces */
        quat q = i % 7 == 0 ? POSE_IDENTITY.q : random_rotation(&r);
        toi_mover a = still(&ball, from, random_rotation(&r), velocity), b = still(&box, VEC_ZERO, q, VEC_ZERO);
        a.motion.angular = vec_scale(random_direction(&r), i % 2 ? 10 : 0); /* about its centre */
        toi_request request = {.span = 1, .tolerance = 1e-9 * scale, .threshold = i % 6 == 0 ? 0.1 * scale : 0};
        toi_result t;
        qmat rows = quad_rotation(q);
        const qvec columns[3] = {
            qv(rows.x.x, rows.y.x, rows.z.x), qv(rows.x.y, rows.y.y, rows.z.y), qv(rows.x.z, rows.y.z, rows.z.z)};
        quad_flight f = {.half = {box.half.x, box.half.y, box.half.z}};
        for (int k = 0; k < 3; k++) {
            f.from[k] = columns[k].x * from.x + columns[k].y * from.y + columns[k].z * from.z;
            f.velocity[k] = columns[k].x * velocity.x + columns[k].y * velocity.y + columns[k].z * velocity.z;
        }
        quad truth = ball_truth(&f, (quad)ball.radius + box.radius + request.threshold);
        toi_find(&a, &b, &request, VEC_ZERO, case_scratch(), &t);
        if (t.status == TOI_HIT) t.gap_lo -= request.threshold; /* what check looks at */
        check(&t, truth, scale, &all);
    }
    print_message("%d hits, %d free, %d searched\n", all.hits, all.frees, all.searched);
    assert_true(all.hits > times(BALLS) / 4 && all.frees > times(BALLS) / 8);
    assert_true(all.searched < times(BALLS) / 10);
}

/* ---- two boxes that do not turn ---- */

typedef struct overlap { /* of intervals of time in which axes do not separate */
    quad enter, leave;
} overlap;

static void meet(overlap *all, quad from, quad velocity, quad reach)
{
    overlap o = {-INFINITY, INFINITY};
    if (velocity != 0) {
        quad one = (-reach - from) / velocity, two = (reach - from) / velocity;
        o = (overlap){q_min(one, two), q_max(one, two)};
    } else if (q_abs(from) > reach) {
        o = (overlap){INFINITY, -INFINITY};
    }
    all->enter = q_max(all->enter, o.enter);
    all->leave = q_min(all->leave, o.leave);
}

static quad q_of(qvec axis, vec3 v)
{
    return axis.x * v.x + axis.y * v.y + axis.z * v.z;
}

static quad reach_of(const qvec columns[3], vec3 half, qvec axis)
{
    const quad h[3] = {half.x, half.y, half.z};
    quad sum = 0;
    for (int k = 0; k < 3; k++) sum += h[k] * q_abs(q_dot(columns[k], axis));
    return sum;
}

static void columns_of(quat q, qvec out[3])
{
    qmat m = quad_rotation(q);
    out[0] = qv(m.x.x, m.y.x, m.z.x);
    out[1] = qv(m.x.y, m.y.y, m.z.y);
    out[2] = qv(m.x.z, m.y.z, m.z.z);
}

/* When their interiors first share a point; edges that are parallel to 30 digits have no axis. */
static quad box_truth(const toi_mover *a, const toi_mover *b)
{
    qvec x[3], y[3];
    columns_of(a->motion.start.q, x);
    columns_of(b->motion.start.q, y);
    vec3 from = vec_sub(b->motion.start.p, a->motion.start.p), velocity = b->motion.linear; /* A stands still */
    overlap all = {0, 1};
    for (int k = 0; k < 15; k++) {
        qvec axis = k < 3 ? x[k] : k < 6 ? y[k - 3] : q_cross(x[(k - 6) / 3], y[(k - 6) % 3]);
        if (q_dot(axis, axis) < 1e-60) continue;
        meet(&all, q_of(axis, from), q_of(axis, velocity),
            reach_of(x, a->shape->half, axis) + reach_of(y, b->shape->half, axis));
    }
    return all.enter <= all.leave ? all.enter : INFINITY;
}

static shape random_box(random_state *r, double scale)
{
    return (shape){.type = SHAPE_BOX,
        .half = vec_scale(vec(random_in(r, 0.02, 1), random_in(r, 0.02, 1), random_in(r, 0.02, 1)), scale)};
}

/* Nearly or exactly parallel to the axes, or not at all. */
static quat some_rotation(random_state *r, int i)
{
    if (i % 3 == 0) return random_rotation(r);
    double off = i % 3 == 1 ? 0 : pow(10, -random_in(r, 1, 17));
    vec3 v = vec_scale(random_direction(r), off);
    quat quarter = i % 2 ? (quat){1, 0, 0, 1} : (quat){1, 0, 0, 0};
    return quat_unit(quat_mul(quarter, (quat){1, v.x, v.y, v.z}));
}

static void two_boxes_meet_when_the_axes_say(void **state)
{
    (void)state;
    tally all = {0};
    for (int i = 0; i < times(BOXES); i++) {
        random_state r = {0xb0c5 + (uint64_t)i};
        double scale = i % 4 == 0 ? 0x1p-40 : i % 4 == 1 ? 0x1p40 : 1;
        shape a = random_box(&r, scale), b = random_box(&r, scale);
        vec3 from = vec_scale(random_direction(&r), scale * random_in(&r, 1, 6));
        vec3 aim = vec_scale(random_direction(&r), scale * random_in(&r, 0, 2));
        vec3 velocity = vec_scale(vec_sub(aim, from), random_in(&r, 0.3, 3));
        if (i % 5 == 0) velocity.x = 0;
        bool ordered = narrow_ordered(&a, 0, &b, 1);
        toi_mover first = still(ordered ? &a : &b, VEC_ZERO, some_rotation(&r, i), VEC_ZERO);
        toi_mover second = still(ordered ? &b : &a, from, some_rotation(&r, i % 2 ? i : i + 1), velocity);
        toi_request request = {.span = 1, .tolerance = 1e-9 * scale};
        toi_result t;
        toi_find(&first, &second, &request, VEC_ZERO, case_scratch(), &t);
        check(&t, box_truth(&first, &second), scale, &all);
    }
    print_message("%d hits, %d free, %d searched\n", all.hits, all.frees, all.searched);
    assert_true(all.hits > times(BOXES) / 4 && all.frees > times(BOXES) / 8);
    assert_true(all.searched < times(BOXES) / 10);
}

/* ---- turning ---- */

static shape some_shape(random_state *r, int i)
{
    shape s = random_box(r, 1);
    if (i % 5 == 0) return (shape){.type = SHAPE_CAPSULE, .half = {0, 0, s.half.z}, .radius = s.half.x};
    if (i % 7 == 0) return (shape){.type = SHAPE_SPHERE, .radius = s.half.x};
    if (i % 3 == 0) s.radius = 0.2 * s.half.y;
    if (i % 4 == 0) s.half.z = 0; /* flat */
    return s;
}

/* About its own sides, or any axis. */
static vec3 some_spin(random_state *r, quat q, int i)
{
    double speed = random_in(r, 0, i % 11 == 0 ? 40 : 3);
    if (i % 3 == 0) return VEC_ZERO;
    vec3 axis = i % 3 == 1 ? quat_rotate(q, vec(i % 2 == 0, 0, i % 2)) : random_direction(r);
    return vec_scale(axis, speed);
}

static void compare(const toi_mover *x, const toi_mover *y, double tolerance, tally *all)
{
    bool ordered = narrow_ordered(x->shape, 0, y->shape, 1);
    const toi_mover *a = ordered ? x : y, *b = ordered ? y : x;
    toi_request request = {.span = 1, .tolerance = tolerance};
    toi_result t;
    toi_find(a, b, &request, VEC_ZERO, case_scratch(), &t);
    toi_truth truth = toi_truth_of(a, b, 1, case_scratch());
    all->searched += t.queries > 0;
    all->unclear += truth.verdict == TRUTH_UNCLEAR;
    all->hits += t.status == TOI_HIT, all->frees += t.status == TOI_FREE;
    if (truth.verdict == TRUTH_HIT) assert_true(t.status != TOI_FREE && t.lo <= truth.hi);
    if (truth.verdict == TRUTH_FREE)
        assert_true(t.status == TOI_FREE || (t.status == TOI_NEAR && truth.nearest <= tolerance));
    if (t.status != TOI_HIT) return;
    assert_true(t.hi >= truth.lo && toi_truth_at(a, b, t.hi, 0, case_scratch()).lo <= 1e-13);
    narrow_result at_lo = toi_truth_at(a, b, t.lo, 0, case_scratch());
    assert_true(at_lo.lo <= t.gap_hi + 1e-13 && at_lo.hi >= t.gap_lo - 1e-13);
}

static void turning_boxes_meet_when_a_plain_march_says(void **state)
{
    (void)state;
    tally all = {0};
    for (int i = 0; i < times(PARALLEL); i++) {
        random_state r = {0x7a12a11e1 + (uint64_t)i};
        shape a = some_shape(&r, i), b = some_shape(&r, i / 2);
        vec3 from = vec_scale(random_direction(&r), random_in(&r, 1, 5));
        vec3 aim = vec_scale(random_direction(&r), random_in(&r, 0, 1.5));
        quat qa = some_rotation(&r, i), qb = some_rotation(&r, i / 3);
        toi_mover x = still(&a, random_direction(&r), qa, random_direction(&r)), y = x;
        y.shape = &b;
        y.motion = (motion){{vec_add(x.motion.start.p, from), qb},
            vec_add(x.motion.linear, vec_scale(vec_sub(aim, from), random_in(&r, 0.3, 2))), some_spin(&r, qb, i)};
        x.motion.angular = some_spin(&r, qa, i / 4);
        if (i % 6 == 0) x.local.p = vec_scale(random_direction(&r), 0.5);
        if (i % 9 == 0) y.local = (pose){random_direction(&r), random_rotation(&r)};
        compare(&x, &y, i % 2 ? 1e-7 : 1e-2, &all);
    }
    print_message("%d hits, %d free, %d searched; %d unclear\n", all.hits, all.frees, all.searched, all.unclear);
    assert_true(all.hits > times(PARALLEL) / 4 && all.frees > times(PARALLEL) / 8);
    assert_true(all.unclear < times(PARALLEL) / 20);
}

/* Rods that spin several times round, near each other: what is apart at both ends of a step has often met within. */
static void spinning_rods_meet_when_a_plain_march_says(void **state)
{
    (void)state;
    tally all = {0};
    for (int i = 0; i < times(RODS); i++) {
        random_state r = {0x20d5 + (uint64_t)i};
        shape a = {.type = SHAPE_BOX, .half = {random_in(&r, 0, 0.05), 0.03, random_in(&r, 0.5, 1)}}, b = a;
        b.half.z = random_in(&r, 0.5, 1);
        quat qa = random_rotation(&r), qb = random_rotation(&r);
        vec3 from = vec_scale(random_direction(&r), random_in(&r, 0.6, 1.9));
        toi_mover x = still(&a, VEC_ZERO, qa, VEC_ZERO), y = still(&b, from, qb, random_direction(&r));
        x.motion.angular = vec_scale(quat_rotate(qa, vec(random_in(&r, -1, 1), 1, 0)), random_in(&r, 1, 20));
        if (i % 3) y.motion.angular = vec_scale(quat_rotate(qb, vec(1, random_in(&r, -1, 1), 0)), random_in(&r, 1, 20));
        compare(&x, &y, 1e-6, &all);
    }
    print_message("%d hits, %d free, %d searched; %d unclear\n", all.hits, all.frees, all.searched, all.unclear);
    assert_true(all.hits > times(RODS) / 8 && all.frees > times(RODS) / 8 && all.unclear < times(RODS) / 20);
}

/* From very far away, and past each other at a fraction of their size; at sizes whose squares vanish. */
static void far_and_small_bullets_hit(void **state)
{
    (void)state;
    static const double FAR[] = {10, 1e4, 1e8, 1e11}, SCALES[] = {1, 0x1p-250, 0x1p-520, 0x1p300};
    for (size_t i = 0; i < sizeof FAR / sizeof *FAR; i++)
        for (size_t k = 0; k < sizeof SCALES / sizeof *SCALES; k++)
            for (int n = 0; n < 40; n++) {
                random_state r = {0xb0117 + 100 * i + (uint64_t)n};
                double scale = SCALES[k], far = FAR[i] * scale, lateral = scale * (n % 2 ? 0.5 : 5);
                shape box = {.type = SHAPE_BOX, .half = {scale, scale, scale}};
                vec3 along = random_direction(&r), away = vec_unit(vec_cross(along, random_direction(&r)));
                toi_mover a = still(&box, VEC_ZERO, random_rotation(&r), VEC_ZERO), b = a;
                b.motion.start.p = vec_madd(vec_scale(along, -far), lateral, away);
                b.motion.linear = vec_scale(along, 2 * far);
                if (n % 4 >= 2) b.motion.angular = vec_scale(random_direction(&r), 1);
                toi_request request = {.span = 1, .tolerance = 1e-6 * scale + 1e-15 * far};
                toi_result t;
                toi_find(&a, &b, &request, VEC_ZERO, case_scratch(), &t);
                assert_int_equal(t.status == TOI_FREE, n % 2 == 0);
                if (n % 2) assert_true(t.lo <= 0.5 && t.lo > 0.5 - 2 / FAR[i]);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_ball_meets_a_box_when_its_distance_says),
        cmocka_unit_test(two_boxes_meet_when_the_axes_say),
        cmocka_unit_test(turning_boxes_meet_when_a_plain_march_says),
        cmocka_unit_test(far_and_small_bullets_hit),
        cmocka_unit_test(spinning_rods_meet_when_a_plain_march_says),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
