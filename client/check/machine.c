/* machine: does this machine compute as the proofs assume? And the statuses in words. */
#include "collided_check.h"

#include <float.h>
#include <math.h>

const char *collided_check_status_text(collided_check_status status)
{
    static const char *const TEXTS[] = {"proven", "the axis does not prove lo", "the points do not prove hi",
        "lo is proven, a depth is not", "not all of the time is proven to be free", "no such kind of shape here",
        "a size is negative, too large or no number", "a pose is no pose", "points are missing, too many or no numbers",
        "children are missing or too many", "an axis is not a unit vector", "the claim is none",
        "the times do not rise, or are too few or too many", "a pointer is NULL"};
    unsigned at = (unsigned)status;
    return at < sizeof TEXTS / sizeof *TEXTS ? TEXTS[at] : "no status";
}

/* Square roots that lie so near to the middle between two doubles that a sloppy one rounds them the wrong way: x (1 + k
 * 2^-52) and its neighbours. Right is s where s and x are as they are told, found with integers. */
static const double ROOTS[][2] = {{2, 0x1.6a09e667f3bcdp+0}, {3, 0x1.bb67ae8584caap+0}, {0x1.0000000000001p+0, 0x1p+0},
    {0x1.fffffffffffffp+0, 0x1.6a09e667f3bccp+0}, {0x1.fffffffffffffp-1, 0x1.fffffffffffffp-1},
    {0x1.0000000000003p+0, 0x1.0000000000001p+0}, {0x1p-1074, 0x1p-537},
    {0x1.fffffffffffffp+1023, 0x1.fffffffffffffp+511}, {0, 0}};

/* Operands are volatile, so that the machine computes, and not the compiler. */
bool collided_check_machine(void)
{
    volatile double one = 1, ulp = DBL_EPSILON, half = DBL_EPSILON / 2, least = 0x1p-1074, a = 1 + 0x1p-30, x;
    bool right = FLT_RADIX == 2 && DBL_MANT_DIG == 53;
    x = one + half;
    right = right && x == 1; /* a tie goes to the even one */
    x = one + ulp + half;
    right = right && x == 1 + 2 * ulp;
    x = -one - half * 1.5;
    right = right && x == -1 - ulp; /* towards the nearest, of either sign: no directed rounding */
    x = one - half * 0.75;
    right = right && x == 1 - half;
    x = least * 0.75;
    right = right && x == least; /* numbers below the normal ones are kept, and rounded */
    x = 0x1p-1022 - least;
    right = right && x < 0x1p-1022 && x > 0;
    x = a * a - (1 + 0x1p-29); /* fused it is 2^-60; rounded in between, 0: no wider registers, no contraction */
    right = right && x == 0;
    x = one / 3;
    right = right && x == 0x1.5555555555555p-2;
    for (unsigned i = 0; i < sizeof ROOTS / sizeof *ROOTS; i++) {
        volatile double of = ROOTS[i][0];
        x = sqrt(of);
        right = right && x == ROOTS[i][1];
    }
    return right;
}
