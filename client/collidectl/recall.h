/* recall: a robot that an earlier run loaded, with the joint values that it was given last. */
#ifndef COLLIDED_COLLIDECTL_RECALL_H
#define COLLIDED_COLLIDECTL_RECALL_H

#include "loaders/robot.h"
#include "store.h"

/* The robot of that name, for the verb; its files are read again, into the pool of `c`. 0, or an exit status after
 * saying why not. */
int recall_robot(
    ctl *c, const store *s, const char *verb, const char *name, store_robot **of, robot *out, double **values);

#endif
