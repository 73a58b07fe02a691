/* pareto_sweep: who is raced at which tolerances. */
#ifndef COLLIDED_TESTS_BENCH_PARETO_SWEEP_H
#define COLLIDED_TESTS_BENCH_PARETO_SWEEP_H

#include "narrow_race.h"

/* Ours come first; which others are there is CMake's choice (pareto_all.c, pareto_alone.c). */
extern const narrow_entry pareto_sweep[];
extern const size_t pareto_sweep_count;

/* Ours, from the loosest to the exact; relative to the pair's size, and an exact verdict with each but the first two.
 */
#define PARETO_OURS                                                                                                    \
    {&narrow_dial_boxes, 0, "boxes", true, true}, {&narrow_dial_bounds, 0, "bounds", true, true},                      \
        {&narrow_dial_cascade, 0, "cascade", true, true}, {&narrow_dial_verdict, 0, "verdict", true, true},            \
        {&narrow_dial, 1, "1", true, true}, {&narrow_dial, 0.1, "0.1", true, true},                                    \
        {&narrow_dial, 1e-2, "1e-2", true, true}, {&narrow_dial, 1e-3, "1e-3", true, true},                            \
        {&narrow_dial, 1e-6, "1e-6", true, true}, {&narrow_dial, 1e-9, "1e-9", true, true},                            \
        {&narrow_dial, 1e-12, "1e-12", true, true},                                                                    \
    {                                                                                                                  \
        &narrow_dial_world, 0, "exact", true, true                                                                     \
    }

/* libccd: gaps it does not measure, so that no tolerance enters. */
#define PARETO_CCD                                                                                                     \
    {&narrow_ccd_gjk, 0, "none", true, false}, {&narrow_ccd_gjk, 1e-2, "1e-2", false, true},                           \
        {&narrow_ccd_gjk, 1e-4, "1e-4", false, true}, {&narrow_ccd_gjk, 1e-6, "1e-6", false, true},                    \
        {&narrow_ccd_gjk, 1e-10, "1e-10", false, true}, {&narrow_ccd_mpr, 0, "none", true, false},                     \
        {&narrow_ccd_mpr, 1e-2, "1e-2", false, true}, {&narrow_ccd_mpr, 1e-4, "1e-4", false, true},                    \
        {&narrow_ccd_mpr, 1e-6, "1e-6", false, true},                                                                  \
    {                                                                                                                  \
        &narrow_ccd_mpr, 1e-10, "1e-10", false, true                                                                   \
    }

#endif
