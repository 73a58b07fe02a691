/* checker: a claim about a distance, as one array of doubles, and whether it is proven: checker.c says how it is laid
 * out. What verify.wasm exports. One thread. */
#ifndef COLLIDED_CLIENT_WEB_CHECKER_H
#define COLLIDED_CLIENT_WEB_CHECKER_H

#include "collided.h"

#ifdef __wasm__
#define CHECKER_EXPORT __attribute__((visibility("default"), used))
#else
#define CHECKER_EXPORT
#endif

/* Room for so many doubles, for the caller to write a claim into; at most 4,194,304. Valid until the next call, which
 * may move it. NULL if there is none. */
CHECKER_EXPORT double *checker_room(size_t words);

/* A collided_status: COLLIDED_OK = proven, COLLIDED_REJECTED = not, COLLIDED_UNSUPPORTED = of a compound, neither; or
 * COLLIDED_BAD_ARGUMENT, if the words are no claim. `count`: how many words there are, no more and no less. */
CHECKER_EXPORT int checker_check(const double *words, size_t count);

/* The same words, by the kernel that is proven by machine (collided_check.h): a collided_check_status, 0 = proven.
 * Words that are no claim: COLLIDED_CHECK_NO_POINTER, 13. Slower. */
CHECKER_EXPORT int checker_kernel(const double *claimed, size_t count, double allowed_m);

/* What the last call of checker_kernel proved: lo and hi, m; infinite where nothing. */
CHECKER_EXPORT const double *checker_kernel_proven(void);

/* collided_check_machine: 1 if the machine computes as the kernel's proofs assume; else believe nothing. */
CHECKER_EXPORT int checker_kernel_machine(void);

#endif
