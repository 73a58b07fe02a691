/* elementary_judge: one answer of soft/elementary.h held against exact arithmetic. */
#ifndef COLLIDED_TESTS_ELEMENTARY_JUDGE_H
#define COLLIDED_TESTS_ELEMENTARY_JUDGE_H

#include "elementary_oracle.h"
#include "soft/elementary.h"

#include <stddef.h>

typedef struct elementary_tally {
    size_t queries, contacts, hits, certain, within, undecided, false_hits, steps;
    double widest; /* t_hi - t_lo of certain hits */
} elementary_tally;

elementary_result elementary_ask(const elementary_query *q, double separation);

/* What is wrong with the answer to q; NULL = nothing. `truth` is that without separation. */
const char *elementary_fault(
    const elementary_query *q, double separation, const elementary_result *r, const elementary_truth *truth);

void elementary_count(elementary_tally *t, const elementary_result *r, const elementary_truth *truth);
void elementary_print_tally(const char *name, const elementary_tally *t);

/* The query as the test's message shows it, to be asked again. */
void elementary_print(const elementary_query *q, const elementary_result *r, const elementary_truth *truth);

#endif
