/* math.h, as Frama-C is to see it: sqrt and fabs write nothing, as with -fno-math-errno, which the library is built
 * with. (Frama-C's own has them write errno.) */
#ifndef COLLIDED_CHECK_PROOFS_MATH_H
#define COLLIDED_CHECK_PROOFS_MATH_H

#define INFINITY (1e300 * 1e300)
#define NAN (INFINITY - INFINITY)

/*@ assigns \nothing; */
double sqrt(double x);
/*@ assigns \nothing; */
double fabs(double x);

#endif
