/* finding: how a check words what it found. Pure. */
#ifndef COLLIDED_DOCTOR_FINDING_H
#define COLLIDED_DOCTOR_FINDING_H

#include "doctor.h"

__attribute__((format(printf, 1, 2))) doctor_finding finding_ok(const char *format, ...);
__attribute__((format(printf, 1, 2))) doctor_finding finding_unknown(const char *format, ...);
__attribute__((format(printf, 1, 2))) doctor_finding finding_problem(const char *format, ...);

/* The same finding, with its command. */
__attribute__((format(printf, 2, 3))) doctor_finding finding_mend(doctor_finding f, const char *format, ...);

#endif
