/* options: the command line, from one table that gives parser, ranges and --help. */
#ifndef COLLIDED_COLLIDECTL_OPTIONS_H
#define COLLIDED_COLLIDECTL_OPTIONS_H

#include "ctl.h"

#include <stdio.h>

typedef enum option_kind { FLAG, TEXT, NUMBER, COUNT, POSE, LINEAR, ANGULAR, FACTS, PACKAGE } option_kind;

typedef struct option {
    const char *name, *value;
    option_kind kind;
    size_t offset; /* in ctl_options */
    double least, most;
    const char *verbs; /* divided by spaces */
    const char *help;
} option;

/* The table, for help, manual and completion. */
const option *options_table(int *count);
bool options_takes(const option *o, const ctl_verb *verb); /* verb NULL: no verb was given */
extern const char *const options_facts[];                  /* the words of --facts; NULL ends them */

typedef struct option_exit {
    int status; /* of sysexits.h */
    const char *meaning;
} option_exit;

const option_exit *options_exits(int *count);

/* Takes the options out of argv. 0 and the verb (NULL if none was given), or EX_USAGE after saying what is wrong. */
int options_parse(ctl *c, int argc, char **argv, const ctl_verb **verb);

void options_help(FILE *out, const ctl_verb *verb); /* of a verb; NULL = of the program */

/* "x,y,z" or "x,y,z,qw,qx,qy,qz". False: neither, not finite, or not a rotation. */
bool options_pose(const char *text, collided_pose *out);
bool options_vector(const char *text, double out[3]);

#endif
