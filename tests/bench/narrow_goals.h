/* narrow_goals: what is asked of ours, row by row: right, and at most so many times as long as the best right peer of
 * the same run. The figures are nanoseconds on a 2.6 GHz EPYC, where that peer then was; their ratio is the goal. */
#ifndef COLLIDED_TESTS_BENCH_NARROW_GOALS_H
#define COLLIDED_TESTS_BENCH_NARROW_GOALS_H

#include "narrow_scene.h"

/* NAN = none is set for that row. */
double narrow_goal_ratio(const char *pair, narrow_regime regime, bool coherent);

#endif
