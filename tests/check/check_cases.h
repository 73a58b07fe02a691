/* check_cases: pairs of shapes with certificates, for the tests of the checker: the engine's answers, and hostile ones
 * that no engine made. */
#ifndef COLLIDED_TESTS_CHECK_CASES_H
#define COLLIDED_TESTS_CHECK_CASES_H

#include "narrow/narrow.h"

#include <collided_check.h>
#include <stdio.h>

enum { CASE_POINTS = 64, CASE_CHILDREN = 6, CASE_KINDS = 9 /* the last is a compound */ };

/* A shape as the kernel takes it; it points into itself, so it must not be copied. */
typedef struct check_subject {
    collided_check_shape shape, children[CASE_CHILDREN];
    double points[CASE_CHILDREN + 1][3 * CASE_POINTS], pose[7];
} check_subject;

typedef struct check_case {
    check_subject a, b;
    collided_check_claim claim;
} check_case;

/* What the engine says of pair `index` of two kinds (shape_type; CASE_KINDS - 1: a compound). cases_create() first.
 * False: it says nothing that can be claimed (two half-spaces). */
bool check_engine_case(int kind_a, int kind_b, unsigned index, check_case *out);

/* A pair with sizes of 0, needles, plates, huge and tiny ones, and points that lie on the shapes, just outside, or
 * anywhere; any axis. lo and hi are 0: what is proven is told by the kernel. */
void check_hostile_case(uint64_t seed, check_case *out);

/* The greatest number that enters. */
double check_size(const check_case *c);

/* How much a claim of this size may be allowed so that rounding does not matter. */
#define CHECK_ALLOWED 0x1p-38

/* A line for second_checker.py. */
void check_print(FILE *to, const check_case *c, const collided_check_proven *proven);

/* What the kernel's search proposes for a child of a shape: the core's point that is nearest to a world point, in the
 * core's frame; of a hull also the corners and their weights. */
typedef struct check_near {
    double at[3], weights[4];
    size_t corners[4];
} check_near;
void check_nearest(const check_subject *s, size_t child, const double point[3], check_near *out);

#endif
