/* unions: compounds for tests, and the truth about them: all pairs of children by the oracle in 113 bits. */
#ifndef COMPOUND_UNIONS_H
#define COMPOUND_UNIONS_H

#include "geom/compound.h"
#include "narrow/narrow.h"
#include "solids.h"
#include "subject.h"

enum { UNION_PARTS_MAX = 64 };

/* A compound, or any one convex shape, as the engine and as the oracle take it. */
typedef struct union_body {
    shape shape;
    compound *compound; /* owned; NULL: one shape */
    size_t count;
    subject parts[UNION_PARTS_MAX];
    pose locals[UNION_PARTS_MAX];
} union_body;

/* `parts`: no hulls. Fails the test if it cannot be built. The rounding is of the whole. */
void union_make(union_body *u, const shape *parts, const pose *locals, size_t count, double rounding);
void union_single(union_body *u, shape s);
void union_random(union_body *u, dice *d, size_t count, double rounding); /* any bounded type but hulls */
void union_boxes(union_body *u, dice *d, size_t count);
void union_free(union_body *u);

/* The exact poses: the whole's, times each child's. `shift` is added in 113 bits. */
void union_place(union_body *u, pose at, qvec shift);

/* Bounds of the least signed distance of all pairs of parts. Apart: those of the unions. */
oracle_truth union_nearest(const union_body *a, const union_body *b);

/* The least of oracle_separation over all pairs, each along the axis that the oracle finds for it: > 0 is a proof that
 * the unions are apart. */
quad union_apart_by(const union_body *a, const union_body *b);

shape random_part(dice *d, double least, double most);

int union_make_scratch(void **state); /* for cmocka_run_group_tests */
int union_free_scratch(void **state);
narrow_scratch *union_scratch(void);

/* Everything measured. */
narrow_result union_ask(const shape *a, const shape *b, pose b_in_a, double tolerance);

#endif
