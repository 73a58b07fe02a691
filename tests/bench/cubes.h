/* cubes: the scene of the benchmarks of the service: cubes of 1 m on a grid, far from each other, and one, the last,
 * beside the first: the two touch. bench_service has its own way of moving them on that grid. */
#ifndef COLLIDED_BENCH_CUBES_H
#define COLLIDED_BENCH_CUBES_H

#include "collided.h"

/* m: where cube number i of so many stands when it sways by that; 3 numbers. */
void cubes_place(size_t count, size_t i, double sway, double position[3]);

/* One of them. */
collided_body cubes_put(collided *client, const char *name, const collided_pose *at);

/* Writes count + 1 handles: "cube_0" and on, and "beside". False: the daemon does not say that it has them all. */
bool cubes_create(collided *client, size_t count, collided_body *bodies);

#endif
