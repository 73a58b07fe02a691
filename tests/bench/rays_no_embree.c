/* rays_no_embree: the race where Embree is not installed, which is said. */
#include "rays_peer.h"

#include <stdio.h>

static void *create(const rays_scene *s)
{
    (void)s;
    fprintf(stderr, "embree: skipped, for CMake did not find it (apt install libembree-dev)\n");
    return NULL;
}

const rays_peer rays_embree = {.name = "embree", .create = create, .entry = "rtcIntersect1"};
