/* world_moving: the tick of a whole world in which all bodies move and turn, beside peers that do the same work. */
#ifndef COLLIDED_TESTS_BENCH_WORLD_MOVING_H
#define COLLIDED_TESTS_BENCH_WORLD_MOVING_H

#include <stdbool.h>
#include <stddef.h>

void world_moving_measure(size_t bodies, double seconds, bool json);

#endif
