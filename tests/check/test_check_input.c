/* Bad input gets a status that says why, and nothing is read beyond what was passed: arrays end at a page that may not
 * be read; numbers are of any bit pattern; each number of a proper case is replaced by bad ones, one after the other.
 */
#include "base/prng.h"
#include "check_cases.h"
#include "client/cmocka_c.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

/* A copy that ends where reading on would end the process. */
static void *at_the_end(const void *from, size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (size + page - 1) / page * page;
    char *block = mmap(NULL, whole + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(block != MAP_FAILED);
    assert_int_equal(mprotect(block + whole, page, PROT_NONE), 0);
    return memcpy(block + whole - size, from, size);
}

static void give_back(void *at, size_t size)
{
    size_t page = (size_t)sysconf(_SC_PAGESIZE), whole = (size + page - 1) / page * page;
    assert_int_equal(munmap((char *)at + size - whole, whole + page), 0);
}

static collided_check_status ask(const check_case *c, collided_check_proven *p)
{
    return collided_check_distance(&c->a.shape, c->a.pose, &c->b.shape, c->b.pose, &c->claim, 0, p);
}

static void set_up(check_case *c)
{
    memset(c, 0, sizeof *c);
    c->a.shape =
        (collided_check_shape){.kind = COLLIDED_CHECK_BOX, .half = {1, 1, 1}, .pose = {0, 0, 0, 1}, .radius = 0.5};
    c->b.shape = (collided_check_shape){.kind = COLLIDED_CHECK_SPHERE, .radius = 1, .pose = {0, 0, 0, 1}};
    c->a.pose[3] = c->b.pose[3] = 1;
    c->b.pose[0] = 4;
    c->claim = (collided_check_claim){1.49, 1.51, {1, 0, 0}, {1.5, 0, 0}, {3, 0, 0}};
}

static void each_bad_number_is_named(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    set_up(&c);
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
    assert_true(p.lo > 1.5 - 1e-11 && p.lo <= 1.5 && p.hi >= 1.5 && p.hi < 1.5 + 1e-11);
    const double odd[] = {NAN, -NAN, INFINITY, -INFINITY, 1e300, -1e300};
    const struct {
        double *at;
        collided_check_status expected;
    } numbers[] = {{&c.a.shape.half[0], COLLIDED_CHECK_BAD_SIZE}, {&c.a.shape.half[2], COLLIDED_CHECK_BAD_SIZE},
        {&c.b.shape.radius, COLLIDED_CHECK_BAD_SIZE}, {&c.a.shape.deviation, COLLIDED_CHECK_BAD_SIZE},
        {&c.a.shape.pose[0], COLLIDED_CHECK_BAD_POSE}, {&c.a.shape.pose[3], COLLIDED_CHECK_BAD_POSE},
        {&c.b.shape.pose[6], COLLIDED_CHECK_BAD_POSE}, {&c.a.pose[2], COLLIDED_CHECK_BAD_POSE},
        {&c.b.pose[5], COLLIDED_CHECK_BAD_POSE}, {&c.claim.axis[1], COLLIDED_CHECK_BAD_AXIS},
        {&c.claim.point_a[1], COLLIDED_CHECK_BAD_CLAIM}, {&c.claim.point_b[2], COLLIDED_CHECK_BAD_CLAIM}};
    for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++)
        for (size_t k = 0; k < sizeof odd / sizeof *odd; k++) {
            double kept = *numbers[i].at;
            *numbers[i].at = odd[k];
            assert_int_equal(ask(&c, &p), numbers[i].expected);
            assert_true(p.lo == -INFINITY && p.hi == INFINITY);
            *numbers[i].at = kept;
        }
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
}

static void each_bad_word_is_named(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
#define EXPECT(change, status)                                                                                         \
    do {                                                                                                               \
        set_up(&c);                                                                                                    \
        change;                                                                                                        \
        assert_int_equal(ask(&c, &p), status);                                                                         \
    } while (0)
    EXPECT(c.a.shape.kind = 8, COLLIDED_CHECK_BAD_KIND);
    EXPECT(c.a.shape.kind = -1, COLLIDED_CHECK_BAD_KIND);
    EXPECT(c.b.shape.kind = 9, COLLIDED_CHECK_BAD_KIND);
    EXPECT(c.b.shape.kind = 11, COLLIDED_CHECK_BAD_KIND);
    EXPECT(c.a.shape.half[1] = -1e-300, COLLIDED_CHECK_BAD_SIZE);
    EXPECT(c.a.pose[3] = 0.99, COLLIDED_CHECK_BAD_POSE);
    EXPECT(c.a.pose[3] = 1.01, COLLIDED_CHECK_BAD_POSE);
    EXPECT(c.claim.axis[0] = 0.99, COLLIDED_CHECK_BAD_AXIS);
    EXPECT(c.a.shape.kind = COLLIDED_CHECK_HULL, COLLIDED_CHECK_NO_POINTER);
    EXPECT((c.a.shape.kind = COLLIDED_CHECK_HULL, c.a.shape.points = c.a.points[0]), COLLIDED_CHECK_BAD_POINTS);
    EXPECT((c.a.shape.kind = COLLIDED_CHECK_HULL, c.a.shape.points = c.a.points[0], c.a.shape.point_count = SIZE_MAX),
        COLLIDED_CHECK_BAD_POINTS);
    EXPECT(c.a.shape.kind = COLLIDED_CHECK_COMPOUND, COLLIDED_CHECK_NO_POINTER);
    EXPECT((c.a.shape.kind = COLLIDED_CHECK_COMPOUND, c.a.shape.children = c.a.children), COLLIDED_CHECK_BAD_CHILDREN);
    EXPECT((c.a.shape.kind = COLLIDED_CHECK_COMPOUND, c.a.shape.children = c.a.children, c.a.shape.child_count = 256),
        COLLIDED_CHECK_BAD_CHILDREN);
    EXPECT((c.a.shape.kind = COLLIDED_CHECK_COMPOUND, c.a.shape.children = c.a.children, c.a.shape.child_count = 1,
               c.a.children[0].kind = COLLIDED_CHECK_HALFSPACE),
        COLLIDED_CHECK_BAD_KIND);
    EXPECT(c.claim.lo = 2, COLLIDED_CHECK_BAD_CLAIM);
    EXPECT(c.claim.lo = NAN, COLLIDED_CHECK_BAD_CLAIM);
    EXPECT(c.claim.hi = NAN, COLLIDED_CHECK_BAD_CLAIM);
    EXPECT(c.claim.hi = -INFINITY, COLLIDED_CHECK_BAD_CLAIM);
    EXPECT((c.claim.lo = INFINITY, c.claim.hi = INFINITY), COLLIDED_CHECK_BAD_CLAIM);
    EXPECT((c.claim.lo = -INFINITY, c.claim.hi = -INFINITY), COLLIDED_CHECK_BAD_CLAIM);
    EXPECT(c.claim.lo = c.claim.hi, COLLIDED_CHECK_LO_UNPROVEN);
    EXPECT(c.claim.lo = 1.5000000001, COLLIDED_CHECK_LO_UNPROVEN);
    EXPECT(c.claim.hi = 1.4999999999, COLLIDED_CHECK_HI_UNPROVEN);
    EXPECT((c.claim.lo = -INFINITY, c.claim.hi = -1), COLLIDED_CHECK_DEPTH_UNPROVEN);
    EXPECT((c.claim.lo = -INFINITY, c.claim.axis[0] = NAN), COLLIDED_CHECK_PROVEN);
    EXPECT((c.claim.hi = INFINITY, c.claim.point_a[0] = NAN), COLLIDED_CHECK_PROVEN);
#undef EXPECT
    set_up(&c);
    const check_case *k = &c;
    assert_int_equal(
        collided_check_distance(NULL, k->a.pose, &k->b.shape, k->b.pose, &k->claim, 0, &p), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_distance(&k->a.shape, NULL, &k->b.shape, k->b.pose, &k->claim, 0, &p),
        COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(
        collided_check_distance(&k->a.shape, k->a.pose, NULL, k->b.pose, &k->claim, 0, &p), COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_distance(&k->a.shape, k->a.pose, &k->b.shape, NULL, &k->claim, 0, &p),
        COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_distance(&k->a.shape, k->a.pose, &k->b.shape, k->b.pose, NULL, 0, &p),
        COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_distance(&k->a.shape, k->a.pose, &k->b.shape, k->b.pose, &k->claim, 0, NULL),
        COLLIDED_CHECK_NO_POINTER);
    assert_int_equal(collided_check_distance(&k->a.shape, k->a.pose, &k->b.shape, k->b.pose, &k->claim, NAN, &p),
        COLLIDED_CHECK_BAD_CLAIM);
    for (int status = 0; status <= COLLIDED_CHECK_NO_POINTER; status++)
        assert_true(strcmp(collided_check_status_text((collided_check_status)status), "no status") != 0);
    assert_string_equal(
        collided_check_status_text((collided_check_status)(COLLIDED_CHECK_NO_POINTER + 1)), "no status");
}

/* The largest number that may be, and the shortest and longest quaternion and axis: (31, 6, 5) / 32 is of squared
 * length 1 - 2^-9, (32, 1, 1) / 32 of 1 + 2^-9. What is next is refused. */
static void limits_belong_to_the_input(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    const double most = 0x1p400, lengths[2][3] = {{31. / 32, 6. / 32, 5. / 32}, {1, 1. / 32, 1. / 32}};
    double *const sizes[] = {&c.a.shape.half[0], &c.a.shape.half[1], &c.a.shape.half[2], &c.a.shape.radius,
        &c.a.shape.deviation, &c.b.shape.radius};
    for (size_t i = 0; i < sizeof sizes / sizeof *sizes; i++) {
        set_up(&c), c.claim.lo = -INFINITY, c.claim.hi = 1e300, *sizes[i] = most;
        assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
        *sizes[i] = nextafter(most, INFINITY);
        assert_int_equal(ask(&c, &p), COLLIDED_CHECK_BAD_SIZE);
        *sizes[i] = -0x1p-1074;
        assert_int_equal(ask(&c, &p), COLLIDED_CHECK_BAD_SIZE);
    }
    for (int i = 0; i < 3; i++)
        for (int sign = -1; sign < 2; sign += 2) {
            const struct {
                double *at;
                collided_check_status bad;
            } numbers[] = {{&c.a.shape.pose[i], COLLIDED_CHECK_BAD_POSE}, {&c.b.pose[i], COLLIDED_CHECK_BAD_POSE},
                {&c.claim.point_a[i], COLLIDED_CHECK_BAD_CLAIM}, {&c.claim.point_b[i], COLLIDED_CHECK_BAD_CLAIM}};
            for (size_t k = 0; k < 4; k++) {
                set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300, *numbers[k].at = sign * most;
                assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
                *numbers[k].at = sign * nextafter(most, INFINITY);
                assert_int_equal(ask(&c, &p), numbers[k].bad);
            }
        }
    for (int i = 0; i < 2; i++) {
        double beyond = i ? INFINITY : 0, *poses[] = {c.a.shape.pose, c.b.shape.pose, c.a.pose, c.b.pose};
        set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300;
        for (int k = 0; k < 4; k++) memcpy(poses[k] + 3 + k % 2, lengths[i], sizeof lengths[i]);
        c.a.shape.pose[6] = c.a.pose[6] = 0, c.b.shape.pose[3] = c.b.pose[3] = 0;
        memcpy(c.claim.axis, lengths[i], sizeof lengths[i]);
        assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
        for (int k = 0; k < 4; k++) {
            double kept = poses[k][3 + k % 2];
            poses[k][3 + k % 2] = nextafter(kept, beyond);
            assert_int_equal(ask(&c, &p), COLLIDED_CHECK_BAD_POSE);
            poses[k][3 + k % 2] = kept;
        }
        c.claim.axis[0] = nextafter(c.claim.axis[0], beyond);
        assert_int_equal(ask(&c, &p), COLLIDED_CHECK_BAD_AXIS);
    }
}

/* lo is short of 1.5, or of what else is exact, by LO_SLACK times the power of two above the greatest number, wherever
 * that stands. */
static void the_slack_goes_with_the_greatest_number(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    const double big = 0x1p20;
    set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300; /* the greatest is 4 */
    ask(&c, &p);
    double slack = (1.5 - p.lo) / 8;
    assert_true(slack > 0x1p-43 && slack < 0x1p-42);
    c.a.shape.half[1] = 7.5;
    ask(&c, &p);
    assert_true(1.5 - p.lo == slack * 8);
    double *const core[] = {&c.a.shape.half[1], &c.a.shape.half[2], &c.a.shape.deviation, &c.a.shape.pose[1],
        &c.b.shape.pose[2], &c.b.pose[1]};
    for (size_t i = 0; i < sizeof core / sizeof *core; i++)
        for (int whole = 0; whole < 2; whole++) { /* 2^20 and less than 2^21 */
            set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300;
            *core[i] = whole ? big : 1.5 * big;
            ask(&c, &p);
            assert_true(1.5 - p.lo == slack * 2 * big);
        }
    for (int at = 0; at < 3; at++) {
        set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300;
        for (int i = 0; i < 9; i++) c.a.points[0][i] = i % 3 ? 0 : 1;
        c.a.points[0][3 * at + 1] = -big;
        c.a.shape = (collided_check_shape){.kind = COLLIDED_CHECK_HULL,
            .radius = 0.5,
            .pose = {0, 0, 0, 1},
            .points = c.a.points[0],
            .point_count = 3};
        ask(&c, &p);
        assert_true(1.5 - p.lo == slack * 2 * big);
    }
    double *const of[] = {&c.a.shape.pose[1], &c.a.shape.pose[2], &c.a.shape.deviation, &c.a.shape.radius,
        &c.a.children[1].half[1], &c.a.children[0].pose[2], &c.a.children[1].deviation};
    for (size_t i = 0; i < sizeof of / sizeof *of; i++) {
        set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300;
        c.a.children[0] = c.a.children[1] = c.a.shape;
        c.a.shape = (collided_check_shape){
            .kind = COLLIDED_CHECK_COMPOUND, .pose = {0, 0, 0, 1}, .children = c.a.children, .child_count = 2};
        *of[i] = big;
        ask(&c, &p);
        assert_true(1.5 - c.a.shape.radius - p.lo == slack * 2 * big);
    }
}

/* Likewise hi, by the points alone; and of children the one counts that is nearest with its deviation. */
static void the_slack_of_hi_goes_with_the_points(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    const double big = 0x1p20;
    set_up(&c), c.claim.lo = -INFINITY, c.claim.hi = 1e300;
    ask(&c, &p);
    double slack = (p.hi - 1.5) / 2; /* the greatest is 1.5 */
    assert_true(slack > 0x1p-43 && slack < 0x1p-42);
    c.b.pose[0] = c.claim.point_b[0] = 0.75 * big, c.claim.point_a[0] = 1.5 * big;
    ask(&c, &p); /* 1.5 x 2^20 from A's position, which is more than all else */
    assert_true(p.hi - (0.75 * big + 1.5 * big - 1.5) == slack * 2 * big);
    set_up(&c), c.claim.lo = -INFINITY, c.claim.hi = 1e300;
    c.a.children[0] = c.a.children[1] = c.a.shape;
    c.a.children[0].pose[0] = -0.5, c.a.children[1].deviation = 1;
    c.a.shape = (collided_check_shape){
        .kind = COLLIDED_CHECK_COMPOUND, .pose = {0, 0, 0, 1}, .children = c.a.children, .child_count = 2};
    ask(&c, &p);
    assert_true(p.hi - 2 >= 0 && p.hi - 2 < 1e-11);
    c.a.shape.kind = COLLIDED_CHECK_HALFSPACE, c.claim.lo = -1e300, c.claim.axis[0] = NAN; /* not looked at */
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
}

/* Along a computed normal, which is of length 1 but for rounding, nothing is divided by its length: the slack, of which
 * half-spaces need all, has no room for that. A point before a plane, bit by bit. */
static void beside_a_plane_nothing_is_divided(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    uint64_t s = 8;
    int odd = 0;
    for (int i = 0; i < 200; i++) {
        set_up(&c), c.claim.lo = -1e300, c.claim.hi = INFINITY;
        double *q = c.a.pose + 3, *at = c.b.pose, norm = 0;
        for (int k = 0; k < 4; k++) q[k] = prng_in(&s, -1, 1), norm += q[k] * q[k];
        for (int k = 0; k < 4; k++) q[k] /= sqrt(norm) * prng_in(&s, 0.9995, 1.0005);
        for (int k = 0; k < 3; k++) at[k] = prng_in(&s, 1, 2);
        c.a.shape.kind = COLLIDED_CHECK_HALFSPACE, c.a.shape.radius = c.b.shape.radius = 0;
        ask(&c, &p);
        double slack = 0x1.f7p-43, w = q[0], x = q[1], y = q[2], z = q[3], by = 2 / (w * w + x * x + y * y + z * z);
        double n[3] = {by * (w * y + z * x), by * (w * -x - z * -y), 1 + by * (x * -x - y * y)};
        double dn = n[0] * (at[0] / 2) + n[1] * (at[1] / 2) + n[2] * (at[2] / 2);
        odd += fabs(sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]) - 1) > 0;
        assert_true(p.lo == (dn - slack) * 2);
    }
    assert_true(odd > 20); /* so that a division would tell */
}

/* As many points and children as may be, and one more. */
static void the_largest_counts_are_taken(void **state)
{
    (void)state;
    static check_case c;
    static double points[3 * (COLLIDED_CHECK_POINTS_MOST + 1)];
    static collided_check_shape children[COLLIDED_CHECK_CHILDREN_MOST + 1];
    collided_check_proven p;
    set_up(&c), c.claim.lo = -1e300, c.claim.hi = 1e300;
    for (size_t i = 0; i <= COLLIDED_CHECK_CHILDREN_MOST; i++) children[i] = c.a.shape;
    c.a.shape.kind = COLLIDED_CHECK_HULL, c.a.shape.points = points;
    for (size_t more = 0; more < 2; more++) {
        c.a.shape.point_count = COLLIDED_CHECK_POINTS_MOST + more;
        assert_int_equal(ask(&c, &p), more ? COLLIDED_CHECK_BAD_POINTS : COLLIDED_CHECK_PROVEN);
    }
    c.a.shape.kind = COLLIDED_CHECK_COMPOUND, c.a.shape.children = children;
    for (size_t more = 0; more < 2; more++) {
        c.a.shape.child_count = COLLIDED_CHECK_CHILDREN_MOST + more;
        assert_int_equal(ask(&c, &p), more ? COLLIDED_CHECK_BAD_CHILDREN : COLLIDED_CHECK_PROVEN);
    }
}

static void a_claim_may_be_short_by_less_than_allowed(void **state)
{
    (void)state;
    static check_case c;
    collided_check_proven p;
    set_up(&c);
    ask(&c, &p);
    double lo = p.lo, hi = p.hi, more = 0x1p-20;
    c.claim.lo = lo + more, c.claim.hi = 2;
    for (int i = 0; i < 2; i++) { /* the bound that is reached is not allowed */
        collided_check_status expected = i ? COLLIDED_CHECK_PROVEN : COLLIDED_CHECK_LO_UNPROVEN;
        double exact = c.claim.lo - lo, allowed = i ? nextafter(exact, 1) : exact;
        assert_int_equal(
            collided_check_distance(&c.a.shape, c.a.pose, &c.b.shape, c.b.pose, &c.claim, allowed, &p), expected);
    }
    c.claim.lo = 1, c.claim.hi = hi - more;
    for (int i = 0; i < 2; i++) {
        collided_check_status expected = i ? COLLIDED_CHECK_PROVEN : COLLIDED_CHECK_HI_UNPROVEN;
        double exact = hi - c.claim.hi, allowed = i ? nextafter(exact, 1) : exact;
        assert_int_equal(
            collided_check_distance(&c.a.shape, c.a.pose, &c.b.shape, c.b.pose, &c.claim, allowed, &p), expected);
    }
    c.claim.lo = lo, c.claim.hi = hi; /* and what is proven exactly is accepted */
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_PROVEN);
    c.claim.lo = nextafter(lo, 9);
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_LO_UNPROVEN);
    c.claim.lo = lo, c.claim.hi = nextafter(hi, 0);
    assert_int_equal(ask(&c, &p), COLLIDED_CHECK_HI_UNPROVEN);
}

/* Everything of a hostile case at the end of its page. */
static void nothing_is_read_beyond(void **state)
{
    (void)state;
    static check_case c;
    for (uint64_t i = 0; i < (getenv("COLLIDED_NIGHTLY") ? 20000 : 600); i++) {
        check_hostile_case(i, &c);
        collided_check_shape shapes[2];
        void *blocks[16];
        size_t sizes[16], count = 0;
#define AT_THE_END(from, size)                                                                                         \
    (sizes[count] = (size), blocks[count] = at_the_end((from), sizes[count]), blocks[count++])
        const check_subject *both[2] = {&c.a, &c.b};
        for (int k = 0; k < 2; k++) {
            shapes[k] = both[k]->shape;
            if (shapes[k].point_count) shapes[k].points = AT_THE_END(shapes[k].points, 24 * shapes[k].point_count);
            if (!shapes[k].child_count) continue;
            collided_check_shape children[CASE_CHILDREN];
            memcpy(children, shapes[k].children, shapes[k].child_count * sizeof *children);
            for (size_t j = 0; j < shapes[k].child_count; j++)
                if (children[j].point_count)
                    children[j].points = AT_THE_END(children[j].points, 24 * children[j].point_count);
            shapes[k].children = AT_THE_END(children, shapes[k].child_count * sizeof *children);
        }
        const collided_check_shape *a = AT_THE_END(&shapes[0], sizeof *shapes);
        const collided_check_shape *b = AT_THE_END(&shapes[1], sizeof *shapes);
        const double *pose_a = AT_THE_END(c.a.pose, 56), *pose_b = AT_THE_END(c.b.pose, 56);
        const collided_check_claim *claim = AT_THE_END(&c.claim, sizeof c.claim);
#undef AT_THE_END
        collided_check_proven p, q;
        assert_int_equal(collided_check_distance(a, pose_a, b, pose_b, claim, 0, &p), ask(&c, &q));
        assert_memory_equal(&p, &q, sizeof p);
        while (count--) give_back(blocks[count], sizes[count]);
    }
}

/* Any bits in all numbers: a status, and never a NaN in what is proven. */
static void any_bits_are_answered(void **state)
{
    (void)state;
    static check_case c;
    long tally[COLLIDED_CHECK_NO_POINTER + 1] = {0};
    uint64_t s = 5;
    for (uint64_t i = 0; i < (getenv("COLLIDED_NIGHTLY") ? 5000000 : 100000); i++) {
        check_hostile_case(prng_bits(&s), &c);
        double *const blocks[] = {c.a.shape.half, c.b.shape.half, &c.a.shape.radius, c.a.shape.pose, c.b.shape.pose,
            c.a.pose, c.b.pose, c.claim.axis, c.claim.point_a, &c.claim.lo, c.a.points[CASE_CHILDREN],
            c.a.children[0].half};
        const size_t counts[] = {3, 3, 2, 7, 7, 7, 7, 3, 6, 2, 6, 3};
        unsigned at = (unsigned)(prng_bits(&s) % (sizeof counts / sizeof *counts));
        uint64_t bits = prng_bits(&s);
        if (prng_bits(&s) % 3 == 0) bits = (bits & 0x8000000000000fff) | 0x7ff0000000000000;
        memcpy(&blocks[at][prng_bits(&s) % counts[at]], &bits, sizeof bits);
        collided_check_proven p;
        tally[ask(&c, &p)]++;
        assert_true(p.lo >= -INFINITY && p.lo < INFINITY && p.hi > -INFINITY);
    }
    for (int k = 0; k <= COLLIDED_CHECK_NO_POINTER; k++)
        printf("%8ld %s\n", tally[k], collided_check_status_text((collided_check_status)k));
    assert_true(tally[COLLIDED_CHECK_BAD_SIZE] && tally[COLLIDED_CHECK_BAD_POSE] && tally[COLLIDED_CHECK_BAD_CLAIM]);
}

static void this_machine_computes_as_assumed(void **state)
{
    (void)state;
    assert_true(collided_check_machine());
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(each_bad_number_is_named),
        cmocka_unit_test(each_bad_word_is_named), cmocka_unit_test(limits_belong_to_the_input),
        cmocka_unit_test(the_slack_goes_with_the_greatest_number),
        cmocka_unit_test(the_slack_of_hi_goes_with_the_points), cmocka_unit_test(beside_a_plane_nothing_is_divided),
        cmocka_unit_test(the_largest_counts_are_taken), cmocka_unit_test(a_claim_may_be_short_by_less_than_allowed),
        cmocka_unit_test(nothing_is_read_beyond), cmocka_unit_test(any_bits_are_answered),
        cmocka_unit_test(this_machine_computes_as_assumed)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
