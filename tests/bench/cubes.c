#include "cubes.h"

#include <math.h>
#include <stdio.h>

static const double SPACING_M = 4, BESIDE_M = 0.9;

void cubes_place(size_t count, size_t i, double sway, double position[3])
{
    size_t columns = (size_t)ceil(sqrt((double)count));
    position[0] = SPACING_M * (double)(i % columns) + sway;
    position[1] = SPACING_M * (double)(i / columns);
    position[2] = 0;
}

collided_body cubes_put(collided *client, const char *name, const collided_pose *at)
{
    collided_shape cube = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.shapes = &cube;
    def.shape_count = 1;
    def.pose = *at;
    return collided_create_body(client, &def);
}

bool cubes_create(collided *client, size_t count, collided_body *bodies)
{
    collided_pose at = collided_pose_identity();
    char name[32];
    for (size_t i = 0; i <= count; i++) {
        cubes_place(count, i < count ? i : 0, i < count ? 0 : -BESIDE_M, at.position);
        snprintf(name, sizeof name, i < count ? "cube_%zu" : "beside", i);
        bodies[i] = cubes_put(client, name, &at);
        if (i % 1000 == 999 && collided_sync(client, 30) != COLLIDED_OK) return false;
    }
    return collided_sync(client, 30) == COLLIDED_OK;
}
