/* commands: command lines for the shell that start, end or restart a daemon. Reads proc/ only. */
#ifndef COLLIDED_DOCTOR_COMMANDS_H
#define COLLIDED_DOCTOR_COMMANDS_H

#include "checks.h"

enum { COMMAND_MAX = 512 };

/* A word as the shell takes it: as it is, or in single quotes. Returns `out`. */
char *command_word(const char *text, char *out, size_t size);

void command_start(const doctor *d, char out[COMMAND_MAX]);        /* a daemon on the URI */
void command_end(const ear_daemon *daemon, char out[COMMAND_MAX]); /* that daemon */
/* That daemon again, with its own options, and `key` (NULL: none) set to `value`. */
void command_restart(const doctor *d, const ear_daemon *daemon, const char *key, long value, char out[COMMAND_MAX]);
/* A daemon on this machine of which only is known that it is none of ours gives way to one of ours. */
void command_replace(const doctor *d, char out[COMMAND_MAX]);
/* "collidectl WORDS", with --connect and --interface where this run has them and $COLLIDED_URI does not say it. */
void command_ctl(const doctor *d, const char *words, char out[COMMAND_MAX]);

#endif
