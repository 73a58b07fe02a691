/* doctor: checks what goes wrong in practice between a daemon and its clients, and names the command that mends it. It
 * only reads this system and listens; besides that it asks the daemon a few queries as a guest. One thread of ours. */
#ifndef COLLIDED_DOCTOR_DOCTOR_H
#define COLLIDED_DOCTOR_DOCTOR_H

#include "options.h"

#include <stddef.h>

/* Runs all checks. The number of problems; -1 if the URI is neither dds:// nor lcm://, or not well-formed. */
int doctor_run(const doctor_options *options);

/* The table: name and summary of check `i`; NULL beyond the last. */
const char *doctor_check_name(size_t i, const char **summary);

#endif
