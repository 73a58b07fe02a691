/* robot_world: bodies as loaders make them, in a world of this process. One thread. */
#ifndef COLLIDED_TESTS_BENCH_ROBOT_WORLD_H
#define COLLIDED_TESTS_BENCH_ROBOT_WORLD_H

#include "base/array.h"
#include "geom/mesh.h"
#include "loaders/body.h"
#include "world/world.h"

typedef struct robot_world { /* geometry that its bodies borrow; zeros = none */
    ARRAY(hull *) hulls;
    ARRAY(mesh *) meshes;
} robot_world;

pose robot_world_pose(const collided_pose *p);
/* The body's id. Its rules become those that allow. */
uint32_t robot_world_put(robot_world *r, world *w, const load_body *from);
void robot_world_free(robot_world *r); /* after the world */

#endif
