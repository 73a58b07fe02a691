/* rays_all: ours and every peer that finds the first body along a ray. */
#include "rays_peer.h"

const rays_peer *const rays_contenders[] = {&rays_ours, &rays_bullet, &rays_embree};
const size_t rays_contender_count = sizeof rays_contenders / sizeof *rays_contenders;
