/* fit_robot: a robot whose links are replaced by the cheapest shapes that hold them (fit_link.h), and the pairs of
 * links that can never meet (never_meet.h); written as a scene that the loaders take (scene.h: links and apart of a
 * robot).
 *
 * One thread a pool; everything lives in it. The same files and options give the same scene: nothing depends on a clock
 * or on chance. */
#ifndef COLLIDED_LOADERS_FIT_ROBOT_H
#define COLLIDED_LOADERS_FIT_ROBOT_H

#include "fit_link.h"
#include "loaders/robot.h"
#include "never_meet.h"

#include <stdio.h>

typedef struct fit_options {
    double excess_m;  /* > 0: no point of a fitted shape is farther than this from its link */
    size_t boxes_max; /* of joint values a pair; 0 = NEVER_BOXES_DEFAULT */
    void (*progress)(void *context, size_t done, size_t of, const char *what); /* NULL = untold */
    void *context;
} fit_options;

typedef struct fit_pair {
    int a, b; /* of fit_robot.links, a < b */
    never_answer answer;
    const char *disabled; /* the SRDF's reason for not checking it; NULL = it is checked */
} fit_pair;

typedef struct fit_robot {
    const robot *robot;
    fit_link *links; /* those with shapes, in the URDF's order */
    size_t link_count;
    fit_pair *pairs; /* all of them */
    size_t pair_count;
    double ns_before, ns_shapes, ns; /* by the table of costs: a query of each pair that the SRDF leaves, as the links
                                        were; with the fitted shapes; and without the pairs that never meet */
} fit_robot;

/* The robot was loaded with its meshes as solids. False, and the report, if a file cannot be read. */
bool fit_robot_make(pool *p, const robot *r, const fit_options *options, fit_robot *out, load_report *report);

/* The scene, a file of its own: it names the files of the robot by whole paths. */
void fit_robot_write(FILE *out, const fit_robot *f, double excess_m);

#endif
