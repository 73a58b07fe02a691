/* options: the command line, from one table that gives parser, ranges and --help. */
#ifndef COLLIDED_COLLIDECTL_OPTIONS_H
#define COLLIDED_COLLIDECTL_OPTIONS_H

#include "ctl.h"

#include <stdio.h>

/* Takes the options out of argv. 0 and the verb (NULL if none was given), or EX_USAGE after saying what is wrong. */
int options_parse(ctl *c, int argc, char **argv, const ctl_verb **verb);

void options_help(FILE *out, const ctl_verb *verb); /* of a verb; NULL = of the program */

/* "x,y,z" or "x,y,z,qw,qx,qy,qz". False: neither, not finite, or not a rotation. */
bool options_pose(const char *text, collided_pose *out);
bool options_vector(const char *text, double out[3]);

#endif
