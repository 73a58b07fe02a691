/* finding: what a check has found, and how it words it. Pure. */
#ifndef COLLIDED_DOCTOR_FINDING_H
#define COLLIDED_DOCTOR_FINDING_H

typedef enum doctor_verdict { DOCTOR_OK, DOCTOR_PROBLEM, DOCTOR_UNKNOWN } doctor_verdict;

const char *doctor_verdict_name(doctor_verdict verdict); /* "ok", "problem", "cannot tell" */

enum { DOCTOR_TEXT_MAX = 640 };

typedef struct doctor_finding {
    doctor_verdict verdict;
    char seen[DOCTOR_TEXT_MAX]; /* one line: what was seen, with its numbers */
    char mend[DOCTOR_TEXT_MAX]; /* of a problem: one line for the shell. "ssh HOST ..." = to be run there */
} doctor_finding;

__attribute__((format(printf, 1, 2))) doctor_finding finding_ok(const char *format, ...);
__attribute__((format(printf, 1, 2))) doctor_finding finding_unknown(const char *format, ...);
__attribute__((format(printf, 1, 2))) doctor_finding finding_problem(const char *format, ...);

/* The same finding, with its command. */
__attribute__((format(printf, 2, 3))) doctor_finding finding_mend(doctor_finding f, const char *format, ...);

#endif
