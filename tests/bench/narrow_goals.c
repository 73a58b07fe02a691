/* narrow_goals: the table. */
#include "narrow_goals.h"

#include <math.h>
#include <string.h>

typedef struct goal_times {
    double cold, coherent; /* ns; 0 = not set */
} goal_times;

typedef struct goal_row {
    const char *pair;
    narrow_regime first, last;
    goal_times peer, ours;
} goal_row;

static const goal_row GOALS[] = {
    {"sphere-sphere", REGIME_SEPARATED, REGIME_DEEP, {40, 40}, {25, 20}},
    {"capsule-capsule", REGIME_SEPARATED, REGIME_DEEP, {80, 50}, {50, 30}},
    {"box-box", REGIME_SEPARATED, REGIME_SEPARATED, {421, 290}, {250, 60}},
    {"box-box", REGIME_SHALLOW, REGIME_SHALLOW, {791, 641}, {230, 130}},
    {"box-box", REGIME_DEEP, REGIME_DEEP, {2093, 1402}, {300, 150}},
    {"cylinder-cylinder", REGIME_SEPARATED, REGIME_SEPARATED, {1462, 861}, {700, 200}},
    {"cylinder-cylinder", REGIME_SHALLOW, REGIME_DEEP, {4767, 3746}, {1000, 500}},
    {"cone-box", REGIME_SHALLOW, REGIME_DEEP, {1642, 1252}, {700, 400}},
    {"ellipsoid-ellipsoid", REGIME_SHALLOW, REGIME_DEEP, {6810, 9574}, {1400, 700}},
    {"hull16-hull16", REGIME_SEPARATED, REGIME_SEPARATED, {531, 441}, {400, 80}},
    {"hull16-hull16", REGIME_SHALLOW, REGIME_DEEP, {1913, 1212}, {900, 260}},
    {"hull64-hull64", REGIME_SEPARATED, REGIME_SEPARATED, {1252, 1052}, {900, 120}},
    {"hull64-hull64", REGIME_SHALLOW, REGIME_DEEP, {3796, 2324}, {2000, 500}},
    {"hull256-hull256", REGIME_SEPARATED, REGIME_SEPARATED, {4507, 1142}, {2000, 200}},
    {"hull256-hull256", REGIME_SHALLOW, REGIME_DEEP, {9074, 3175}, {5000, 1000}},
    {"mesh-box", REGIME_SEPARATED, REGIME_SEPARATED, {301000, 165000}, {30000, 5000}},
    {"mesh-mesh", REGIME_SEPARATED, REGIME_SEPARATED, {338000, 234000}, {50000, 10000}},
};

double narrow_goal_ratio(const char *pair, narrow_regime regime, bool coherent)
{
    for (size_t i = 0; i < sizeof GOALS / sizeof *GOALS; i++) {
        const goal_row *g = &GOALS[i];
        if (strcmp(g->pair, pair) != 0 || regime < g->first || regime > g->last) continue;
        return coherent ? g->ours.coherent / g->peer.coherent : g->ours.cold / g->peer.cold;
    }
    return NAN;
}
