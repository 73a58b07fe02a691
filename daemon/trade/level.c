/* level: the one place that knows how an accuracy is asked for. Pure. */
#include "level.h"

const trade_level trade_levels[TRADE_LEVELS] = {
    {"boxes", WORLD_BY_BOXES, 1e-3}, /* bounds without a search; impacts, which have none, to 1e-3 */
    {"1e-3", WORLD_BY_TOLERANCE, 1e-3}, {"1e-6", WORLD_BY_TOLERANCE, 1e-6}, {"1e-9", WORLD_BY_TOLERANCE, 1e-9},
    {"1e-12", WORLD_BY_TOLERANCE, 1e-12}, {"exact", WORLD_BY_TOLERANCE, 0}, /* as narrow as arithmetic gives */
};

void level_amend(const void *context, world_subscription *def)
{
    const trade_level *level = context;
    def->accuracy = level->accuracy;
    def->tolerance = 0;
    def->relative_tolerance = level->relative;
}

void level_ask(const trade_level *level, const world *w, size_t answer, double *lo, double *hi)
{
    world_ask_again(w, answer, level->accuracy, level->relative, lo, hi);
}
