/* judge: asks the engine about two subjects and holds the answer against the oracle, the expectation of a case, and
 * itself (swapped). Nothing here decides with a tolerance that it does not state. */
#ifndef COLLIDED_TESTS_CASES_JUDGE_H
#define COLLIDED_TESTS_CASES_JUDGE_H

#include "narrow/narrow.h"
#include "subject.h"

typedef enum expected_state { STATE_ANY, STATE_APART, STATE_TOUCHING, STATE_OVERLAPPING } expected_state;

enum { EXPECTED_NORMALS_MAX = 8 };

typedef struct expectation {
    bool measured;    /* `distance` is given */
    double distance;  /* m, signed */
    double tolerance; /* m, of the source: on top of what the conversion of matrices moves */
    expected_state state;
    double normals[EXPECTED_NORMALS_MAX][3]; /* unit, A to B: any of them */
    size_t normal_count;                     /* 0 = not said */
} expectation;

typedef struct judgement {
    narrow_result result;
    oracle_truth truth;
    double size;     /* of the pair, m: what widths are relative to */
    bool exact_kind; /* polytopes rounded or not: the truth is exact and the interval must be narrow to the last bits */
    bool undecided;  /* the interval holds 0 though the state is known; only where rounding may hide it */
    bool disproved;  /* the source's number lies below a separation that an axis proves: the number is wrong */
    const char *fault; /* NULL = holds */
} judgement;

/* Widest intervals that pass, relative to the size of the pair. Where many axes are equally deep (round bodies on one
 * axis of revolution) bounds from inside converge slowly: wider is right there if the status says so. */
#define WIDTH_EXACT 2e-14
#define WIDTH_CURVED 1e-12
#define WIDTH_SAID 1e-4
double widest_allowed(const subject *a, const subject *b, const narrow_result *result);

judgement judge(const subject *a, const subject *b, const expectation *expected);

/* The engine at tolerance 0, everything measured. The answer's points are relative to a's position. */
void ask(const subject *a, const subject *b, narrow_result *result);

/* The oracle's check of an answer; `slack_m` for the witness points. */
const char *check_certificate(const subject *a, const subject *b, const narrow_result *result, double slack_m);

#endif
