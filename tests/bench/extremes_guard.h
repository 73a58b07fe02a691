/* extremes_guard: asks a contender about items that may crash it, hang it or exhaust it: in a process of its own. What
 * ends there costs that one item, which counts as failed, and the next process goes on behind it. One thread. */
#ifndef COLLIDED_TESTS_BENCH_EXTREMES_GUARD_H
#define COLLIDED_TESTS_BENCH_EXTREMES_GUARD_H

#include "narrow_race.h"

/* Who is asked: CMake's choice (extremes_all.c, extremes_alone.c). */
extern const narrow_entry extremes_entries[];
extern const size_t extremes_entry_count;

/* One item at a time, each at most 0.2 s of processor time. `answers` has `count`. */
void extremes_ask(
    const narrow_entry *entry, const narrow_item *items, size_t count, const narrow_row *row, narrow_answer *answers);

#endif
