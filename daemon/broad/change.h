/* change: what a batch changes about one proxy. */
#ifndef COLLIDED_BROAD_CHANGE_H
#define COLLIDED_BROAD_CHANGE_H

#include "fbox.h"

/* What was asked for one proxy since the last update: first removed, then put. */
typedef struct change {
    uint32_t proxy;
    bool removed, put, refilter;
    bool late;  /* removed: its pairs stay for a while */
    bool asks;  /* its meetings are searched around it; else the index finds them by itself */
    bool fixed; /* of what was put */
    bool was;   /* the proxy stood before, with... */
    bool was_fixed;
    fbox fat; /* of what was put */
    fbox old; /* ...this box */
} change;

#endif
