/* check_lines: prints cases with what the kernel proves of them, for second_checker.py: `check_lines COUNT SEED` prints
 * so many of the engine's answers, and as many corrupted or hostile ones. */
#include "base/prng.h"
#include "cases.h"
#include "check_cases.h"

#include <math.h>
#include <stdlib.h>

static void print_proven(const check_case *c)
{
    collided_check_proven proven;
    collided_check_claim open = c->claim;
    open.lo = -1e300, open.hi = 1e300;
    collided_check_status status =
        collided_check_distance(&c->a.shape, c->a.pose, &c->b.shape, c->b.pose, &open, 0, &proven);
    if (status != COLLIDED_CHECK_PROVEN && status != COLLIDED_CHECK_LO_UNPROVEN) {
        fprintf(stderr, "%s\n", collided_check_status_text(status));
        check_print(stderr, c, &proven);
        exit(1);
    }
    check_print(stdout, c, &proven);
}

/* A number of the certificate, changed by a little or by much. */
static void corrupt(check_case *c, uint64_t *s)
{
    static const double BY[] = {0x1p-52, 1e-12, 1e-6, 1e-3, 1};
    double *numbers[] = {c->claim.point_a, c->claim.point_b, c->a.pose, c->b.pose, c->a.shape.half, c->b.shape.half};
    double *at = &numbers[prng_bits(s) % 6][prng_bits(s) % 3];
    *at = fabs(*at) > 0 ? *at * (1 + BY[prng_bits(s) % 5] * prng_in(s, 0, 1)) : BY[prng_bits(s) % 5];
}

int main(int argc, char **argv)
{
    if (argc != 3) return fprintf(stderr, "usage: check_lines COUNT SEED\n"), 2;
    long count = atol(argv[1]), seed = atol(argv[2]);
    static check_case c;
    cases_create();
    uint64_t s = (uint64_t)seed;
    for (long i = 0; i < count; i++) {
        int a = (int)(i % CASE_KINDS), b = (int)(i / CASE_KINDS % CASE_KINDS);
        unsigned index = (unsigned)(seed * 1000003 + i / (CASE_KINDS * CASE_KINDS));
        if (check_engine_case(a, b, index, &c)) {
            print_proven(&c);
            corrupt(&c, &s);
            print_proven(&c);
        }
        check_hostile_case(prng_bits(&s), &c);
        print_proven(&c);
    }
    cases_destroy();
    return ferror(stdout) != 0;
}
