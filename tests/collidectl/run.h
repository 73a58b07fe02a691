/* run: one run of a program, with what it printed. Its state folder and its home are a fresh folder of the test. */
#ifndef COLLIDED_TESTS_COLLIDECTL_RUN_H
#define COLLIDED_TESTS_COLLIDECTL_RUN_H

#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

typedef struct run {
    int status; /* exit status; -1 = ended by a signal */
    char out[32768], err[32768];
} run;

/* `arguments`: divided by spaces, "" for none. */
void run_program(const char *program, const char *arguments, run *result);

/* One line in `err`, with `words` in it, and that exit status. */
void expect_failure(const char *program, const char *arguments, int status, const char *words);

int run_make_state(void **state);   /* cmocka set-up: a fresh XDG_STATE_HOME */
int run_remove_state(void **state); /* and its end */

#endif
