/* Motions and features: what is accepted is looked at everywhere in between, by the engine and by exact corners; what
 * is a little too strong is refused. Lists of times are made as a planner or a march makes them. */
#include "base/prng.h"
#include "cases.h"
#include "check_cases.h"
#include "client/cmocka_c.h"
#include "soft/elementary.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TIMES_MOST = 400 };

static int rounds(int day)
{
    return getenv("COLLIDED_NIGHTLY") ? 50 * day : getenv("COLLIDED_BRIEF") ? day / 10 : day;
}

/* ---- bodies that move and turn steadily ---- */

typedef struct mover {
    double linear[3], angular[3];
    pose start;
} mover;

static pose pose_then(const mover *m, double t)
{
    double w = sqrt(m->angular[0] * m->angular[0] + m->angular[1] * m->angular[1] + m->angular[2] * m->angular[2]);
    double s = w > 0 ? sin(w * t / 2) / w : 0, c = cos(w * t / 2);
    quat turn = {c, s * m->angular[0], s * m->angular[1], s * m->angular[2]};
    pose out = {
        vec_add(m->start.p, vec_scale(vec(m->linear[0], m->linear[1], m->linear[2]), t)), quat_mul(turn, m->start.q)};
    double norm = sqrt(out.q.w * out.q.w + out.q.x * out.q.x + out.q.y * out.q.y + out.q.z * out.q.z);
    out.q = (quat){out.q.w / norm, out.q.x / norm, out.q.y / norm, out.q.z / norm};
    return out;
}

static void put(pose p, double to[7])
{
    const double from[7] = {p.p.x, p.p.y, p.p.z, p.q.w, p.q.x, p.q.y, p.q.z};
    memcpy(to, from, sizeof from);
}

static mover random_mover(random_state *r, pose at, bool turns)
{
    mover m = {.start = at};
    for (int i = 0; i < 3; i++) {
        m.linear[i] = random_in(r, -1, 1);
        m.angular[i] = turns ? random_in(r, -2, 2) : 0;
    }
    return m;
}

static double size_in_kernel(const shape *s, collided_check_shape *out)
{
    *out = (collided_check_shape){
        .kind = (int32_t)s->type, .radius = s->radius, .half = {s->half.x, s->half.y, s->half.z}, .pose = {0, 0, 0, 1}};
    return s->radius + s->half.x + s->half.y + s->half.z;
}

static narrow_result distance_then(const shape *a, const mover *ma, const shape *b, const mover *mb, double t)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .range = INFINITY};
    narrow_result r;
    narrow_query_world(a, pose_then(ma, t), b, pose_then(mb, t), &request, case_scratch(), &r);
    return r;
}

typedef struct list {
    double times[TIMES_MOST], poses_a[7 * TIMES_MOST], poses_b[7 * TIMES_MOST], axes[3 * TIMES_MOST];
    size_t count;
} list;

/* Marches by what the speed or the bend leaves. False: they come too near. */
static bool march(
    const shape *a, const mover *ma, const shape *b, const mover *mb, double speed, double bend, list *out)
{
    double t = 0;
    for (out->count = 0; out->count < TIMES_MOST;) {
        narrow_result r = distance_then(a, ma, b, mb, t);
        if (!(r.lo > 1e-3)) return false;
        size_t k = out->count++;
        out->times[k] = t;
        put(pose_then(ma, t), out->poses_a + 7 * k);
        put(pose_then(mb, t), out->poses_b + 7 * k);
        memcpy(out->axes + 3 * k, (double[]){r.axis.x, r.axis.y, r.axis.z}, 3 * sizeof(double));
        if (t == 1) return out->count > 1;
        double step = 0.9 * r.lo / speed, along = isfinite(bend) && bend > 0 ? 0.5 * sqrt(8 * r.lo / bend) : 0;
        t = fmin(1, t + fmax(step, speed > 0 ? fmin(along, step * 1.5) : 1));
    }
    return false;
}

static void motions_that_are_accepted_are_free(void **state)
{
    (void)state;
    static list l;
    long accepted = 0, given_up = 0, stretched = 0;
    cases_create();
    for (int i = 0; i < rounds(300); i++) {
        random_state r = {(uint64_t)i + 77};
        int kinds[2] = {(int)(random_bits(&r) % 7), (int)(random_bits(&r) % 6)};
        shape a = random_shape(&r, (shape_type)kinds[0]), b = random_shape(&r, (shape_type)kinds[1]);
        pose pa, pb;
        random_poses(&r, &a, &b, REGIME_APART, &pa, &pb);
        mover ma = random_mover(&r, pa, a.type != SHAPE_HALFSPACE), mb = random_mover(&r, pb, true);
        collided_check_shape ka, kb;
        double size = size_in_kernel(&a, &ka) + size_in_kernel(&b, &kb), speed, bend, until;
        assert_int_equal(collided_check_twist(&ka, ma.linear, ma.angular, &kb, mb.linear, mb.angular, &speed, &bend),
            COLLIDED_CHECK_PROVEN);
        if (!march(&a, &ma, &b, &mb, speed, bend, &l)) {
            given_up++;
            continue;
        }
        collided_check_motion m = {.count = l.count,
            .times = l.times,
            .poses_a = l.poses_a,
            .poses_b = l.poses_b,
            .axes = l.axes,
            .speed = speed,
            .bend = bend};
        collided_check_status status = collided_check_motion_free(&ka, &kb, &m, &until);
        if (status != COLLIDED_CHECK_PROVEN) { /* a step that was too long: what is proven ends before it */
            assert_int_equal(status, COLLIDED_CHECK_TIME_UNPROVEN);
            assert_true(until >= 0 && until < 1);
            stretched++;
        }
        accepted += until > 0;
        for (int k = 0; k <= 40; k++) assert_true(distance_then(&a, &ma, &b, &mb, until * k / 40).hi > -1e-9 * size);
        /* the margin up to which it is proven is not beyond the least distance */
        for (m.margin = 1e-3; m.margin < 10; m.margin *= 1.5) {
            if (collided_check_motion_free(&ka, &kb, &m, &until) != COLLIDED_CHECK_PROVEN) break;
            for (int k = 0; k <= 10; k++)
                assert_true(distance_then(&a, &ma, &b, &mb, k / 10.0).hi > m.margin * (1 - 1e-9));
        }
        assert_true(m.margin < 10);
    }
    cases_destroy();
    printf("%ld accepted, %ld of them not to their end, %ld come too near\n", accepted, stretched, given_up);
    assert_true(accepted > rounds(300) / 4);
}

/* One number at its limit: two balls that approach. The bound that is reached is refused. */
static void limits_of_the_rules(void **state)
{
    (void)state;
    collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.5, .pose = {0, 0, 0, 1}};
    double times[2] = {0, 1}, poses_a[14] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1},
           poses_b[14] = {3, 0, 0, 1, 0, 0, 0, 3, 0, 0, 1};
    double axes[6] = {1, 0, 0, 1, 0, 0}, until;
    collided_check_motion m = {.count = 2, .times = times, .poses_a = poses_a, .poses_b = poses_b, .axes = axes};
    const struct {
        double speed, bend, margin;
        collided_check_status expected;
    } cases[] = {{4 - 1e-9, INFINITY, 0, COLLIDED_CHECK_PROVEN}, {4 + 1e-15, INFINITY, 0, COLLIDED_CHECK_TIME_UNPROVEN},
        {4, INFINITY, 0, COLLIDED_CHECK_TIME_UNPROVEN}, {INFINITY, 16 - 1e-9, 0, COLLIDED_CHECK_PROVEN},
        {INFINITY, 16, 0, COLLIDED_CHECK_TIME_UNPROVEN}, {INFINITY, INFINITY, 0, COLLIDED_CHECK_TIME_UNPROVEN},
        {0, INFINITY, 2 - 1e-9, COLLIDED_CHECK_PROVEN}, {0, INFINITY, 2, COLLIDED_CHECK_TIME_UNPROVEN},
        {2 - 1e-9, INFINITY, 1, COLLIDED_CHECK_PROVEN}, {2 + 1e-9, INFINITY, 1, COLLIDED_CHECK_TIME_UNPROVEN},
        {INFINITY, 8 - 1e-9, 1, COLLIDED_CHECK_PROVEN}, {INFINITY, 8 + 1e-9, 1, COLLIDED_CHECK_TIME_UNPROVEN},
        {6 - 1e-9, INFINITY, -1, COLLIDED_CHECK_PROVEN}, {6 + 1e-9, INFINITY, -1, COLLIDED_CHECK_TIME_UNPROVEN},
        {-1, INFINITY, 0, COLLIDED_CHECK_BAD_CLAIM}, {NAN, INFINITY, 0, COLLIDED_CHECK_BAD_CLAIM},
        {1, NAN, 0, COLLIDED_CHECK_BAD_CLAIM}, {1, 1, NAN, COLLIDED_CHECK_BAD_CLAIM}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        m.speed = cases[i].speed, m.bend = cases[i].bend, m.margin = cases[i].margin;
        collided_check_status status = collided_check_motion_free(&ball, &ball, &m, &until);
        if (status != cases[i].expected) fail_msg("%zu: %s", i, collided_check_status_text(status));
        assert_true(status != COLLIDED_CHECK_PROVEN || until == 1);
        assert_true(status != COLLIDED_CHECK_TIME_UNPROVEN || until == 0);
    }
    /* along the first axis at both ends; along their own, at each; over half the time */
    m.speed = INFINITY, m.bend = 4, m.margin = 0;
    axes[0] = -1;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_TIME_UNPROVEN);
    axes[0] = 1, axes[3] = -1;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
    m.speed = 1, m.bend = INFINITY;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_TIME_UNPROVEN);
    axes[3] = 1, times[1] = 0.5;
    m.speed = 8 - 1e-9;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
    m.speed = INFINITY, m.bend = 64 - 1e-9;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
    m.bend = 64;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_TIME_UNPROVEN);
    const double odd[][2] = {{0, 0}, {1, 0}, {NAN, 1}, {0, INFINITY}, {-INFINITY, 0}};
    for (size_t i = 0; i < sizeof odd / sizeof *odd; i++) {
        times[0] = odd[i][0], times[1] = odd[i][1];
        assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_BAD_TIMES);
        assert_true(isnan(until));
    }
    m.count = 1;
    assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_BAD_TIMES);
}

static void bounds_of_motion(void **state)
{
    (void)state;
    const double travel[] = {0.5, -0.25, 0.125}, arm[] = {1, 0.5, 2}, none[3] = {0, 0, 0};
    double speed = collided_check_joint_speed(3, travel, arm), bend;
    assert_true(speed >= 0.875 && speed < 0.875 * (1 + 1e-12));
    assert_true(collided_check_joint_speed(3, travel, (double[]){1, NAN, 2}) == INFINITY);
    assert_true(collided_check_joint_speed(3, travel, (double[]){1, -1, 2}) == INFINITY);
    assert_true(collided_check_joint_speed(3, (double[]){1, INFINITY, 2}, arm) == INFINITY);
    assert_true(collided_check_joint_speed(257, travel, arm) == INFINITY);
    assert_true(collided_check_joint_speed(3, NULL, arm) == INFINITY);
    /* A turns at 2 rad/s, its farthest point 1 + 3 + 0.5 m off; B at 3, 2 m; they part at (3, 4) m/s */
    double points[] = {0, 0, 1, 1, 2, 2};
    collided_check_shape a = {
        .kind = COLLIDED_CHECK_HULL, .points = points, .point_count = 2, .radius = 0.5, .pose = {1, 0, 0, 1}};
    collided_check_shape b = {.kind = COLLIDED_CHECK_CAPSULE, .half = {0, 0, 1.5}, .radius = 0.5, .pose = {0, 0, 0, 1}};
    assert_int_equal(collided_check_twist(&a, (double[]){-1, 0, 0}, (double[]){0, 2, 0}, &b, (double[]){2, 4, 0},
                         (double[]){0, 0, 3}, &speed, &bend),
        COLLIDED_CHECK_PROVEN);
    assert_true(speed >= 5 + 9 + 6 && speed < 20 * (1 + 1e-12));
    assert_true(bend >= 4 * 4.5 + 9 * 2 && bend < 36 * (1 + 1e-12));
    collided_check_shape child = a, compound = {.kind = COLLIDED_CHECK_COMPOUND,
                                        .children = &child,
                                        .child_count = 1,
                                        .radius = 0.25,
                                        .pose = {0, 2, 0, 1}};
    assert_int_equal(collided_check_twist(&compound, none, (double[]){1, 0, 0}, &b, none, none, &speed, &bend),
        COLLIDED_CHECK_PROVEN);
    assert_true(speed >= 6.75 && speed < 6.75 * (1 + 1e-12) && bend >= 6.75);
    collided_check_shape plane = {.kind = COLLIDED_CHECK_HALFSPACE, .pose = {0, 0, 0, 1}};
    assert_int_equal(collided_check_twist(&plane, none, (double[]){1, 0, 0}, &b, none, none, &speed, &bend),
        COLLIDED_CHECK_BAD_KIND);
    assert_true(speed == INFINITY && bend == INFINITY);
    assert_int_equal(
        collided_check_twist(&plane, none, none, &b, none, (double[]){0, 0, 1}, &speed, &bend), COLLIDED_CHECK_PROVEN);
    assert_int_equal(
        collided_check_twist(&a, none, (double[]){NAN, 0, 0}, &b, none, none, &speed, &bend), COLLIDED_CHECK_BAD_CLAIM);
}

/* Four looks, each along another axis, with A somewhere else; times of both signs. Each look counts. */
static void each_look_counts(void **state)
{
    (void)state;
    enum { LOOKS = 4 };
    collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.5, .pose = {0, 0, 0, 1}};
    double times[LOOKS] = {-1, -0.5, 0, 0.5}, poses[2][7 * LOOKS] = {{0}}, axes[3 * LOOKS] = {0}, until;
    for (int straight = 0; straight < 2; straight++) {
        for (int k = 0; k < LOOKS; k++) {
            for (int i = 0; i < 3; i++) {
                axes[3 * k + i] = i == (straight ? 0 : k % 3);
                poses[0][7 * k + i] = 20 * k * (i + 1);
                poses[1][7 * k + i] = poses[0][7 * k + i] + 3 * axes[3 * k + i];
            }
            poses[0][7 * k + 3] = poses[1][7 * k + 3] = 1;
        }
        collided_check_motion m = {
            .count = LOOKS, .times = times, .poses_a = poses[0], .poses_b = poses[1], .axes = axes};
        double limit = straight ? 64 : 8; /* 2 + 2 m within 0.5 */
        m.speed = straight ? INFINITY : limit - 1e-7, m.bend = straight ? limit - 1e-7 : INFINITY;
        assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
        assert_true(until == 0.5);
        for (int k = 0; k < LOOKS; k++) {
            double first = k > 1 ? times[k - 1] : times[0];
            axes[3 * k + (straight ? 0 : k % 3)] = -1;
            assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until),
                straight && k == LOOKS - 1 ? COLLIDED_CHECK_PROVEN : COLLIDED_CHECK_TIME_UNPROVEN);
            assert_true(until == (straight ? times[k] : first)); /* the axis of a stretch is that of its start */
            axes[3 * k + (straight ? 0 : k % 3)] = 1;
            for (int side = 0; side < 2; side++) {
                poses[side][7 * k] += side ? -2 : 2; /* too near there */
                assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until),
                    k % 3 == 0 || straight ? COLLIDED_CHECK_TIME_UNPROVEN : COLLIDED_CHECK_PROVEN);
                assert_true(until == (k % 3 == 0 || straight ? first : 0.5));
                poses[side][7 * k] -= side ? -2 : 2;
                poses[side][7 * k + 3] = 0.9;
                assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_BAD_POSE);
                poses[side][7 * k + 3] = 1;
            }
        }
        m.count = 1;
        assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until), COLLIDED_CHECK_BAD_TIMES);
    }
    /* beside a half-space no axis is looked at */
    const collided_check_shape plane = {.kind = COLLIDED_CHECK_HALFSPACE, .pose = {-100, 0, -2, 1}};
    axes[0] = axes[1] = axes[2] = axes[4] = NAN;
    collided_check_motion m = {.count = 2,
        .times = times,
        .poses_a = poses[0],
        .poses_b = poses[0],
        .axes = axes,
        .speed = 1,
        .bend = INFINITY};
    assert_int_equal(collided_check_motion_free(&plane, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
}

/* The rule's slack, held against the same in long doubles, at and beside its limit. */
static void slack_of_the_rule(void **state)
{
    (void)state;
    const collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.5, .pose = {0, 0, 0, 1}};
    double times[2] = {0, 1}, poses_a[14] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}, until;
    double poses_b[14] = {3, 0, 0, 1, 0, 0, 0, 3, 0, 0, 1}, axes[6] = {1, 0, 0, 1, 0, 0};
    const collided_check_claim claim = {.lo = -9, .hi = INFINITY, .axis = {1}};
    collided_check_proven p;
    assert_int_equal(collided_check_distance(&ball, poses_a, &ball, poses_b, &claim, 0, &p), COLLIDED_CHECK_PROVEN);
    collided_check_motion m = {
        .count = 2, .times = times, .poses_a = poses_a, .poses_b = poses_b, .axes = axes, .bend = INFINITY};
    long verdicts[2] = {0, 0};
    for (m.margin = -1; m.margin < 2; m.margin += 0.5)
        for (int off = -100; off < 100; off++) {
            double need = 2 * p.lo - 0x1p-47 + off * 0x1p-51;
            m.speed = need - 2 * m.margin;
            long double taken = m.speed, sum = 2 * (long double)p.lo;
            long double size = sum + 2 * fabsl((long double)m.margin) + taken;
            bool apart = sum - (2 * (long double)m.margin + taken) > 0x1p-50L * size;
            assert_int_equal(collided_check_motion_free(&ball, &ball, &m, &until) == COLLIDED_CHECK_PROVEN, apart);
            verdicts[apart]++;
        }
    assert_true(verdicts[0] > 100 && verdicts[1] > 100);
}

static void missing_pointers(void **state)
{
    (void)state;
    const collided_check_shape s = {.kind = COLLIDED_CHECK_SPHERE, .pose = {0, 0, 0, 1}};
    const double v[3] = {0, 0, 0}, t[3] = {0, 1, 2};
    double poses[14] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}, axes[6] = {1, 0, 0, 1}, out, more;
    const collided_check_motion whole = {.count = 2, .times = t, .poses_a = poses, .poses_b = poses, .axes = axes};
    for (int i = 0; i < 4; i++) {
        collided_check_motion m = whole;
        *(const double **[]){&m.times, &m.poses_a, &m.poses_b, &m.axes}[i] = NULL;
        assert_int_equal(collided_check_motion_free(&s, &s, &m, &out), COLLIDED_CHECK_NO_POINTER);
    }
    assert_int_equal(collided_check_motion_free(NULL, &s, &whole, &out), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_motion_free(&s, NULL, &whole, &out), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_motion_free(&s, &s, NULL, &out), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_motion_free(&s, &s, &whole, NULL), COLLIDED_CHECK_NO_POINTER);
    for (int i = 0; i < 8; i++)
        assert_int_equal(
            collided_check_twist(i == 0 ? NULL : &s, i == 1 ? NULL : v, i == 2 ? NULL : v, i == 3 ? NULL : &s,
                i == 4 ? NULL : v, i == 5 ? NULL : v, i == 6 ? NULL : &out, i == 7 ? NULL : &more),
            COLLIDED_CHECK_NO_POINTER);
    assert_true(collided_check_joint_speed(1, t, NULL) == INFINITY);
    for (int i = 0; i < 2; i++) {
        collided_check_features f = {.count = 1, .times = i ? t : NULL, .directions = i ? NULL : axes};
        assert_int_equal(collided_check_features_free(&f, &out), COLLIDED_CHECK_NO_POINTER);
    }
}

/* What stands behind an array does not count; its last does. And what is nothing has a bound above 0. */
static void reach_of_arrays(void **state)
{
    (void)state;
    const double none[3] = {0, 0, 0}, turn[3] = {0, 0, 1}, bad[3] = {NAN, 0, 0};
    double points[12] = {1, 0, 0, 0, 2, 0, 0, 0, 3, 9, 9, 9}, speed, bend, many[257] = {0};
    collided_check_shape hull = {.kind = COLLIDED_CHECK_HULL, .points = points, .point_count = 3, .pose = {0, 0, 0, 1}};
    collided_check_shape children[3] = {hull, hull, hull};
    children[2].pose[0] = 99;
    collided_check_shape compound = {
        .kind = COLLIDED_CHECK_COMPOUND, .children = children, .child_count = 2, .pose = {0, 0, 0, 1}};
    const collided_check_shape *of[] = {&hull, &compound};
    for (int i = 0; i < 2; i++) {
        assert_int_equal(
            collided_check_twist(of[i], none, turn, &hull, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
        assert_true(speed >= 3 && speed < 3 + 1e-11 && bend >= 3 && bend < 3 + 1e-11);
    }
    const collided_check_shape plane = {.kind = COLLIDED_CHECK_HALFSPACE, .pose = {0, 0, 0, 1}};
    assert_int_equal(collided_check_twist(&hull, none, turn, &plane, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
    assert_int_equal(
        collided_check_twist(&hull, none, none, &hull, bad, none, &speed, &bend), COLLIDED_CHECK_BAD_CLAIM);
    assert_int_equal(
        collided_check_twist(&hull, none, none, &hull, none, bad, &speed, &bend), COLLIDED_CHECK_BAD_CLAIM);
    assert_int_equal(collided_check_twist(&hull, none, none, &hull, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
    assert_true(speed >= 0x1p-499 && bend > 0 && collided_check_joint_speed(1, many, many) > 0);
    assert_true(
        collided_check_joint_speed(256, many, many) < 1 && collided_check_joint_speed(257, many, many) == INFINITY);
}

/* Numbers of which the squares underflow: neither a velocity nor a size may be lost. */
static void bounds_of_tiny_motion(void **state)
{
    (void)state;
    const double none[3] = {0, 0, 0};
    double speed, bend;
    for (double tiny = 0x1p-500; tiny > 0; tiny *= 0x1p-37)
        for (int way = 0; way < 3; way++) {
            double v[3] = {0, 0, 0}, size = way == 2 ? tiny : 0x1p390;
            v[way] = tiny;
            collided_check_shape a = {.kind = COLLIDED_CHECK_BOX, .half = {0, size, 0}, .pose = {0, 0, 0, 1}}, b = a;
            assert_int_equal(collided_check_twist(&a, none, none, &b, v, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
            assert_true(speed >= tiny && speed < fmax(2 * tiny, 0x1p-490) && bend >= 0 && bend < 0x1p-490);
            assert_int_equal(collided_check_twist(&a, v, none, &b, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
            assert_true(speed >= tiny);
            double w[3] = {0, 0, way == 2 ? 0x1p390 : tiny}; /* the product is what counts */
            for (int second = 0; second < 2; second++) {
                assert_int_equal(
                    collided_check_twist(&a, none, second ? none : w, &b, none, second ? w : none, &speed, &bend),
                    COLLIDED_CHECK_PROVEN);
                assert_true(speed >= tiny * 0x1p390 && bend >= w[2] * w[2] * size);
            }
            double points[3] = {size, 0, 0};
            a = (collided_check_shape){
                .kind = COLLIDED_CHECK_HULL, .points = points, .point_count = 1, .pose = {0, 0, 0, 1}};
            assert_int_equal(collided_check_twist(&a, none, w, &b, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
            assert_true(speed >= tiny * 0x1p390);
            a = (collided_check_shape){.kind = COLLIDED_CHECK_SPHERE, .pose = {0, size, 0, 1}};
            assert_int_equal(collided_check_twist(&a, none, w, &b, none, none, &speed, &bend), COLLIDED_CHECK_PROVEN);
            assert_true(speed >= tiny * 0x1p390);
        }
}

/* ---- features ---- */

static void differences(int kind, const double points[12], vec3 w[4])
{
    const vec3 p[4] = {{points[0], points[1], points[2]}, {points[3], points[4], points[5]},
        {points[6], points[7], points[8]}, {points[9], points[10], points[11]}};
    for (int i = 0; i < 4; i++)
        w[i] = kind == COLLIDED_CHECK_VERTEX_FACE ? vec_sub(p[1 + i % 3], p[0]) : vec_sub(p[2 + i % 2], p[i / 2]);
}

static void between(const double start[12], const double end[12], double t, double out[12])
{
    for (int i = 0; i < 12; i++) out[i] = (1 - t) * start[i] + t * end[i];
}

static void distance_of(int kind, const double at[12], double *lo, double *hi)
{
    vec3 p[4];
    for (int i = 0; i < 4; i++) p[i] = vec(at[3 * i], at[3 * i + 1], at[3 * i + 2]);
    if (kind == COLLIDED_CHECK_VERTEX_FACE)
        elementary_vertex_face_distance(p, lo, hi);
    else
        elementary_edge_edge_distance(p, lo, hi);
}

/* A direction from the first feature to the second: towards the nearest point of the polygon, by looking at many
 * weights. */
static vec3 towards(int kind, const double at[12])
{
    vec3 w[4], best = {0, 0, 0};
    double least = INFINITY;
    differences(kind, at, w);
    for (int i = 0; i <= 24; i++)
        for (int k = 0; k <= 24; k++) {
            double a = i / 24.0, b = k / 24.0;
            if (kind == COLLIDED_CHECK_VERTEX_FACE && a + b > 1) continue;
            vec3 p = kind == COLLIDED_CHECK_VERTEX_FACE
                         ? vec_add(vec_scale(w[0], 1 - a - b), vec_add(vec_scale(w[1], a), vec_scale(w[2], b)))
                         : vec_add(vec_scale(vec_add(vec_scale(w[0], 1 - b), vec_scale(w[1], b)), 1 - a),
                               vec_scale(vec_add(vec_scale(w[2], 1 - b), vec_scale(w[3], b)), a));
            if (vec_norm2(p) < least) least = vec_norm2(p), best = p;
        }
    return least > 0 ? vec_scale(best, 1 / sqrt(least)) : vec(1, 0, 0);
}

static void features_that_are_accepted_are_apart(void **state)
{
    (void)state;
    long accepted = 0, proposals = 0;
    for (int i = 0; i < rounds(1500); i++) {
        uint64_t s = (uint64_t)i;
        enum { PIECES = 8 };
        double times[PIECES + 1], directions[3 * PIECES], until;
        collided_check_features f = {.kind = i % 2, .count = PIECES, .times = times, .directions = directions};
        double away = prng_in(&s, 0, 2), scale = i % 7 ? 1 : 1e-7;
        for (int k = 0; k < 12; k++) {
            double shift = k % 3 == 2 && k >= (f.kind ? 6 : 3) ? away : 0;
            f.start[k] = scale * (prng_in(&s, -1, 1) + shift);
            f.end[k] = scale * (prng_in(&s, -1, 1) + shift);
        }
        f.separation = i % 3 ? 0 : 0.05 * scale;
        for (int k = 0; k < PIECES; k++) {
            double at[12];
            times[k] = (double)k / PIECES;
            between(f.start, f.end, (k + 0.5) / PIECES, at);
            vec3 d = towards(f.kind, at);
            memcpy(directions + 3 * k, (double[]){d.x, d.y, d.z}, 3 * sizeof(double));
        }
        times[PIECES] = 1;
        collided_check_status status = collided_check_features_free(&f, &until);
        assert_true(status == COLLIDED_CHECK_PROVEN || status == COLLIDED_CHECK_TIME_UNPROVEN);
        assert_true((status == COLLIDED_CHECK_PROVEN) == (until == 1));
        proposals++;
        accepted += status == COLLIDED_CHECK_PROVEN;
        for (int k = 0; k <= 32 && until > 0; k++) {
            double at[12], lo, hi;
            between(f.start, f.end, until * k / 32, at);
            distance_of(f.kind, at, &lo, &hi);
            assert_true(hi > f.separation * (1 - 1e-12));
        }
    }
    printf("%ld of %ld proven to the end\n", accepted, proposals);
    assert_true(accepted > proposals / 5 && accepted < proposals);
}

static void limits_of_features(void **state)
{
    (void)state;
    double times[3] = {0, 0.5, 1}, directions[6] = {0, 0, 1, 0, 0, 1}, until;
    collided_check_features f = {.kind = COLLIDED_CHECK_VERTEX_FACE,
        .count = 2,
        .times = times,
        .directions = directions,
        .start = {0, 0, 0, 1, 0, 1, 0, 1, 1, -1, -1, 1},
        .end = {0, 0, 0, 1, 0, 1, 0, 1, 1, -1, -1, 1}};
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
    f.separation = 1 - 1e-14;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
    f.separation = 1;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_TIME_UNPROVEN);
    assert_true(until == 0);
    f.separation = 0;
    for (int i = 1; i < 4; i++) { /* each corner counts, at each end; it dips below at three quarters */
        f.end[3 * i + 2] = -1.0 / 3;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_TIME_UNPROVEN);
        assert_true(until == 0.5);
        times[2] = 0.7;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
        times[2] = 1, f.end[3 * i + 2] = 1;
    }
    f.kind = COLLIDED_CHECK_EDGE_EDGE; /* the second point is no corner of the face now, but an end of the first edge */
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_TIME_UNPROVEN);
    f.start[5] = f.end[5] = 0.5;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
    for (int i = 0; i < 4; i++) {
        double kept = f.end[3 * i + 2];
        f.end[3 * i + 2] = i < 2 ? 2 : -1;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_TIME_UNPROVEN);
        f.end[3 * i + 2] = kept;
    }
    f.kind = 2;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_KIND);
    f.kind = 0, f.start[4] = NAN;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_POINTS);
    f.start[4] = 0, f.separation = -1;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_SIZE);
    f.separation = 0, times[2] = 1.5;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
    times[2] = 1, times[0] = -0.1;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
    times[0] = 0, f.count = 0;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
    f.count = 2, directions[5] = 1.1;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_AXIS);
    assert_int_equal(collided_check_features_free(NULL, &until), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_features_free(&f, NULL), COLLIDED_CHECK_NO_POINTER);
}

/* Along each axis in turn, the features being 1 apart at the start and 3 at the end, or the other way round: from 0.25
 * to 0.75 they are 1.5 apart, and no more. All other coordinates are odd ones. */
static void features_along_each_axis(void **state)
{
    (void)state;
    for (int way = 0; way < 12; way++) {
        int axis = way % 3, kind = way / 3 % 2;
        bool nears = way >= 6;
        double times[2] = {0.25, 0.75}, direction[3] = {axis == 0, axis == 1, axis == 2}, until;
        collided_check_features f = {.kind = kind, .count = 1, .times = times, .directions = direction};
        for (int i = 0; i < 12; i++) {
            bool second = i / 3 >= (kind ? 2 : 1);
            f.start[i] = i % 3 == axis ? 2 * axis + (second ? nears ? 3 : 1 : 0) : 0.5 * i - 2;
            f.end[i] = i % 3 == axis ? 5 + (second ? nears ? 1 : 3 : 0) : 3 - 0.25 * i;
        }
        f.separation = 1.5 - 1e-13;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
        f.separation = 1.5;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_TIME_UNPROVEN);
        times[1] = 0.25;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
        times[1] = 0.2;
        assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
    }
}

/* Gaps of 2^-489, of which RULE_SLACK is less than TINY: what is needed and reached, and no more, is refused. */
static void tiny_gaps(void **state)
{
    (void)state;
    const collided_check_shape point = {.kind = COLLIDED_CHECK_SPHERE, .pose = {0, 0, 0, 1}};
    const double far = (0x1.f7p-43 + 0x1p-90) * 0x1p-399, times[2] = {0, 1}, axes[6] = {1, 0, 0, 1};
    const double poses_a[14] = {0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 1}, poses_b[14] = {far, 0, 0, 1, 0, 0, 0, far, 0, 0, 1};
    double until;
    collided_check_motion m = {
        .count = 2, .times = times, .poses_a = poses_a, .poses_b = poses_b, .axes = axes, .bend = INFINITY};
    const struct {
        double speed;
        collided_check_status expected;
    } cases[] = {{0x1p-489, COLLIDED_CHECK_PROVEN}, {0x1p-488 - 0x1p-498, COLLIDED_CHECK_PROVEN},
        {0x1p-488 - 0x1p-500, COLLIDED_CHECK_TIME_UNPROVEN}, {0x1p-488, COLLIDED_CHECK_TIME_UNPROVEN}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        m.speed = cases[i].speed;
        assert_int_equal(collided_check_motion_free(&point, &point, &m, &until), cases[i].expected);
    }
}

static void as_many_looks_as_may_be(void **state)
{
    (void)state;
    enum { MOST = COLLIDED_CHECK_TIMES_MOST };
    double *times = malloc((MOST + 1) * sizeof *times), *poses = calloc(7 * (MOST + 1), sizeof *poses), until;
    assert_true(times && poses);
    for (size_t i = 0; i <= MOST; i++) times[i] = (double)i, poses[7 * i + 2] = poses[7 * i + 3] = 1;
    const collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.5, .pose = {0, 0, 0, 1}};
    const collided_check_shape plane = {.kind = COLLIDED_CHECK_HALFSPACE, .pose = {0, 0, -1, 1}};
    collided_check_motion m = {
        .count = MOST, .times = times, .poses_a = poses, .poses_b = poses, .axes = times, .bend = INFINITY};
    assert_int_equal(collided_check_motion_free(&plane, &ball, &m, &until), COLLIDED_CHECK_PROVEN);
    assert_true(until == MOST - 1);
    m.count = MOST + 1;
    assert_int_equal(collided_check_motion_free(&plane, &ball, &m, &until), COLLIDED_CHECK_BAD_TIMES);
    free(times);
    free(poses);
}

/* Corners at FEATURE_SLACK of the scale and no more, at one end of the time: refused; and accepted just above it. The
 * scale is that of the greatest number, at the start or at the end. */
static void features_at_the_slack(void **state)
{
    (void)state;
    const double times[2] = {0, 1}, direction[3] = {0, 0, 1};
    double until;
    for (int way = 0; way < 24; way++) {
        collided_check_features f = {.kind = way % 2, .count = 1, .times = times, .directions = direction};
        int wide = way / 8; /* 0: nowhere; 1: at the start; 2: at the end */
        double slack = 0x1p-49 * (wide ? 0x1p21 : 2);
        for (int i = way % 2 ? 2 : 1; i < 4; i++) {
            f.start[3 * i + 2] = f.end[3 * i + 2] = 1;
            if (wide) (wide == 1 ? f.start : f.end)[3 * i] = 0x1p20;
            (way & 2 ? f.start : f.end)[3 * i + 2] = way & 4 ? slack * (1 + 0x1p-52) : slack;
        }
        assert_int_equal(
            collided_check_features_free(&f, &until), way & 4 ? COLLIDED_CHECK_PROVEN : COLLIDED_CHECK_TIME_UNPROVEN);
    }
}

static void as_many_features_as_may_be(void **state)
{
    (void)state;
    enum { MOST = COLLIDED_CHECK_TIMES_MOST };
    double *times = malloc((MOST + 1) * sizeof *times), *directions = calloc(3 * MOST, sizeof *directions), until;
    assert_true(times && directions);
    for (size_t i = 0; i <= MOST; i++) times[i] = (double)i / MOST;
    for (size_t i = 0; i < MOST; i++) directions[3 * i + 2] = 1;
    collided_check_features f = {.times = times,
        .directions = directions,
        .start = {0, 0, 0, 1, 0, 1, 0, 1, 1, -1, -1, 1},
        .end = {0, 0, 0, 1, 0, 1, 0, 1, 1, -1, -1, 1}};
    f.count = MOST - 1;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_PROVEN);
    f.count = MOST;
    assert_int_equal(collided_check_features_free(&f, &until), COLLIDED_CHECK_BAD_TIMES);
    free(times);
    free(directions);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(motions_that_are_accepted_are_free),
        cmocka_unit_test(limits_of_the_rules), cmocka_unit_test(bounds_of_motion), cmocka_unit_test(each_look_counts),
        cmocka_unit_test(slack_of_the_rule), cmocka_unit_test(missing_pointers), cmocka_unit_test(reach_of_arrays),
        cmocka_unit_test(features_along_each_axis), cmocka_unit_test(tiny_gaps),
        cmocka_unit_test(features_at_the_slack), cmocka_unit_test(as_many_looks_as_may_be),
        cmocka_unit_test(as_many_features_as_may_be), cmocka_unit_test(bounds_of_tiny_motion),
        cmocka_unit_test(features_that_are_accepted_are_apart), cmocka_unit_test(limits_of_features)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
