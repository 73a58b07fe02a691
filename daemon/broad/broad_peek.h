/* broad_peek: what a test of the broad phase needs to know beyond broad.h. */
#ifndef COLLIDED_BROAD_BROAD_PEEK_H
#define COLLIDED_BROAD_BROAD_PEEK_H

#include "broad.h"
#include "fbox.h"

typedef struct broad_stored {
    fbox fat;
    bool fixed;
    bool unbounded; /* in the list beside the index */
} broad_stored;

/* False if the proxy is not there. */
bool broad_peek(const broad *b, uint32_t proxy, broad_stored *stored);

#endif
