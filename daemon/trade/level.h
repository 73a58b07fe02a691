/* level: the accuracies that a trade compares, from the loosest to exact, and what each makes of a subscription. */
#ifndef COLLIDED_TRADE_LEVEL_H
#define COLLIDED_TRADE_LEVEL_H

#include "world/world.h"

typedef struct trade_level {
    const char *name;
    world_accuracy accuracy;
    double relative; /* width of an interval, as a share of the pair's size */
} trade_level;

enum { TRADE_LEVELS = 6, TRADE_EXACT = TRADE_LEVELS - 1 }; /* the last one is what all are held against */
extern const trade_level trade_levels[TRADE_LEVELS];

/* service.amend_subscription; `context` is a trade_level. */
void level_amend(const void *context, world_subscription *def);
/* world_ask_again at this level. */
void level_ask(const trade_level *level, const world *w, size_t answer, double *lo, double *hi);

#endif
