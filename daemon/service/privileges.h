/* privileges: started as root, the daemon gives that up for the user of its configuration. Main thread; before links
 * and recording are opened, so that what they make, the LCM gateway among it, is that user's. */
#ifndef COLLIDED_SERVICE_PRIVILEGES_H
#define COLLIDED_SERVICE_PRIVILEGES_H

#include <stddef.h>

/* Could it become that user ("" = it stays who it is)? EX_OK, or another status with a line in `why`. */
int privileges_check(const char *user, char *why, size_t why_size);
void privileges_no_more(void); /* no program that is started from now on gets more, by setuid bits or otherwise */
/* Becomes that user for good: user, group and supplementary groups, no capabilities. 0, or -1 with a line in `why`. */
int privileges_drop(const char *user, char *why, size_t why_size);
void privileges_report(const char *user); /* in the log, if it is root without a need */

#endif
