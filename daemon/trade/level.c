/* level: the one place that knows how an accuracy is asked for. Pure. */
#include "level.h"

const trade_level trade_levels[TRADE_LEVELS] = {
    {"1e-3", 1e-3}, {"1e-6", 1e-6}, {"1e-9", 1e-9}, {"1e-12", 1e-12}, {"exact", 0}};

void level_amend(const void *level, world_interest *def)
{
    def->tolerance = ((const trade_level *)level)->relative;
}

void level_ask(const trade_level *level, const world *w, size_t answer, double *lo, double *hi)
{
    world_ask_again(w, answer, level->relative, lo, hi);
}
