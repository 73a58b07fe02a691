/* elementary_cubic: the elementary tests as they are usually written (Provot 1997; Bridson, Fedkiw, Anderson 2002): the
 * roots in [0, 1] of the coplanarity cubic in doubles, and inside or outside at each, with a tolerance on the weights.
 * The contender that is fast and wrong: here to be measured, not to be used. */
#ifndef COLLIDED_TESTS_BENCH_ELEMENTARY_CUBIC_H
#define COLLIDED_TESTS_BENCH_ELEMENTARY_CUBIC_H

#include "elementary/elementary_oracle.h"

/* *t: the first contact that it sees; false: it sees none. */
bool elementary_cubic(const elementary_query *q, double tolerance, double *t);

#endif
