/* whole: a structure is walked as a whole where a phase ends, in builds with asserts (CMake presets debug and
 * asan-ubsan). With NDEBUG nothing of it is left, and the arguments are not evaluated. Any thread. */
#ifndef COLLIDED_BASE_WHOLE_H
#define COLLIDED_BASE_WHOLE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A walk takes as long as many phases: the first ones are all followed by one, later ones the less often the larger the
 * structure is, and the largest never, for who waits for their daemon is not patient. By counts alone, so that a run
 * can be repeated. `phase`: how many there were; `size`: of the structure, in elements. */
bool whole_is_due(uint64_t phase, size_t size);

/* `fault`: what a *_validate has found, or NULL. Ends the process as assert does, with that text. */
void whole_holds(const char *fault, const char *of, const char *file, int line);

/* For tests that count allocations, which walks make: none is due while they rest. Before threads begin. */
void whole_rest(bool rest);

#ifdef NDEBUG
#define ASSERT_WHOLE(due, fault) ((void)(false && (due) && (fault)))
#else
#define ASSERT_WHOLE(due, fault) ((due) ? whole_holds((fault), #fault, __FILE__, __LINE__) : (void)0)
#endif

#endif
