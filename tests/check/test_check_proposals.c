/* The searches of the kernel are believed nothing: here they are replaced by ones that propose anything, and what is
 * proven must still be true. A cube as a hull and a ball as an ellipsoid, of which the distances are known. */
#include "base/prng.h"
#include "client/cmocka_c.h"
#include "propose.h"

#include <collided_check.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

static double proposed[4];
static size_t proposed_corners[4];

void propose_ellipsoid(const double q[3], const double a[3], double u[3])
{
    (void)q, (void)a;
    memcpy(u, proposed, 3 * sizeof *u);
}

void propose_hull(
    const double *points, size_t count, const double q[3], double by, size_t corners[4], double weights[4])
{
    (void)points, (void)count, (void)q, (void)by;
    memcpy(corners, proposed_corners, sizeof proposed_corners);
    memcpy(weights, proposed, sizeof proposed);
}

/* What is proven of the distance of the ball of radius 0.25 around (4, 1, 0.5) from `a`, by the point (1, 1, 0.5). */
static double proven_hi(const collided_check_shape *a)
{
    static const double HERE[7] = {0, 0, 0, 1}, THERE[7] = {4, 1, 0.5, 1};
    const collided_check_shape ball = {.kind = COLLIDED_CHECK_SPHERE, .radius = 0.25, .pose = {0, 0, 0, 1}};
    const collided_check_claim claim = {
        .lo = -INFINITY, .hi = 1e300, .point_a = {1, 1, 0.5}, .point_b = {3.75, 1, 0.5}};
    collided_check_proven p;
    (void)collided_check_distance(a, HERE, &ball, THERE, &claim, 0, &p);
    return p.hi;
}

static void propose(double a, double b, double c, double d)
{
    const double numbers[4] = {a, b, c, d};
    memcpy(proposed, numbers, sizeof proposed);
}

static double any(uint64_t *s)
{
    static const double ODD[] = {NAN, INFINITY, -INFINITY, -1e300, 1e300, 0, -0.0, 1, -1, 0.5, 0x1p-1074, 1e-9};
    uint64_t way = prng_bits(s) % 24;
    return way < 12 ? ODD[way] : prng_in(s, -1, 2);
}

/* The eight corners end where reading on would end the process. */
static void hulls(void **state)
{
    (void)state;
    size_t page = (size_t)sysconf(_SC_PAGESIZE), size = 24 * sizeof(double);
    char *block = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    assert_true(block != MAP_FAILED && mprotect(block + page, page, PROT_NONE) == 0);
    double *points = (double *)(void *)(block + page - size);
    for (int i = 0; i < 24; i++) points[i] = i / 3 >> i % 3 & 1 ? 1 : -1;
    const collided_check_shape cube = {
        .kind = COLLIDED_CHECK_HULL, .points = points, .point_count = 8, .pose = {0, 0, 0, 1}};
    const double exact = 2.75; /* the point is on the cube */
    proposed_corners[0] = 3, proposed_corners[1] = 7;
    propose(0.25, 0.75, 0, 0);
    assert_true(proven_hi(&cube) >= exact && proven_hi(&cube) < exact + 1e-11);
    for (int k = 0; k < 4; k++) { /* each corner and each weight is looked at */
        proposed_corners[k] = 8, propose(0.25, 0.75, 0, 0);
        assert_true(proven_hi(&cube) == INFINITY);
        proposed_corners[k] = SIZE_MAX;
        assert_true(proven_hi(&cube) == INFINITY);
        proposed_corners[k] = k == 0 ? 3 : k == 1 ? 7 : 0;
        proposed[k] = -0x1p-30;
        assert_true(proven_hi(&cube) == INFINITY);
        proposed[k] = NAN;
        assert_true(proven_hi(&cube) == INFINITY);
    }
    /* weights of 1 +- 2^-9 are divided by; others are refused */
    propose(0.25, 0.75 + 0x1p-9, 0, 0);
    double more = 0x1p-10 / (1 + 0x1p-9), less = 0x1p-10 / (1 - 0x1p-9); /* beside the point */
    assert_true(proven_hi(&cube) >= exact + more && proven_hi(&cube) < exact + more + 1e-11);
    propose(0.25, 0.75 - 0x1p-9, 0, 0);
    assert_true(proven_hi(&cube) >= exact + less && proven_hi(&cube) < exact + less + 1e-11);
    propose(0.25, 0.75 + 0x1p-9 + 0x1p-52, 0, 0);
    assert_true(proven_hi(&cube) == INFINITY);
    propose(0.25, nextafter(0.75 - 0x1p-9, 0), 0, 0);
    assert_true(proven_hi(&cube) == INFINITY);
    propose(0, 0, 0, 0);
    assert_true(proven_hi(&cube) == INFINITY);
    uint64_t s = 3;
    long proven = 0;
    for (int i = 0; i < (getenv("COLLIDED_BRIEF") ? 20000 : 300000); i++) {
        bool proper = prng_bits(&s) % 2; /* else any weights */
        double left = 1;
        for (int k = 0; k < 4; k++) {
            proposed_corners[k] = prng_bits(&s) % 32 ? prng_bits(&s) % 8 : prng_bits(&s);
            proposed[k] = !proper ? any(&s) : k < 3 ? left * prng_in(&s, 0, 1) : left;
            left -= proposed[k];
        }
        double hi = proven_hi(&cube);
        assert_true(hi >= exact);
        proven += hi < INFINITY;
    }
    printf("%ld proposals made proofs\n", proven);
    assert_true(proven > 1000);
    assert_int_equal(munmap(block, 2 * page), 0);
}

/* A ball of radius 0.75, of which the nearest point to (1, 1, 0.5) is two thirds of the way: |(1, 1, 0.5)| = 1.5. */
static void ellipsoids(void **state)
{
    (void)state;
    const collided_check_shape ball = {
        .kind = COLLIDED_CHECK_ELLIPSOID, .half = {0.75, 0.75, 0.75}, .pose = {0, 0, 0, 1}};
    const double exact = 2.75 + 0.75;
    propose(2. / 3, 2. / 3, 1. / 3, 0);
    assert_true(proven_hi(&ball) >= exact && proven_hi(&ball) < exact + 1e-11);
    propose(4. / 3, 4. / 3, 2. / 3, 0); /* outside: drawn in */
    assert_true(proven_hi(&ball) >= exact && proven_hi(&ball) < exact + 1e-11);
    propose(0, 0, 0, 0);
    assert_true(fabs(proven_hi(&ball) - (2.75 + 1.5)) < 1e-11);
    uint64_t s = 4;
    long proven = 0;
    for (int i = 0; i < (getenv("COLLIDED_BRIEF") ? 20000 : 300000); i++) {
        propose(any(&s), any(&s), any(&s), 0);
        double hi = proven_hi(&ball);
        assert_true(hi >= exact);
        proven += hi < INFINITY;
    }
    assert_true(proven > 1000);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(hulls), cmocka_unit_test(ellipsoids)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
