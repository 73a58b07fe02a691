/* watch_soft: steps of soft bodies as collidectl watch prints them, a line a pair. One thread. */
#ifndef COLLIDECTL_WATCH_SOFT_H
#define COLLIDECTL_WATCH_SOFT_H

#include "collided.h"

/* Callbacks of collided_subscribe_soft; the context is not used. */
void watch_soft_text(void *context, const collided_soft_steps *steps);
void watch_soft_json(void *context, const collided_soft_steps *steps);

#endif
