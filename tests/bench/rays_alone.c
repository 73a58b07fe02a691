/* rays_alone: the race without peers (COLLIDED_PEERS is off). */
#include "rays_peer.h"

const rays_peer *const rays_contenders[] = {&rays_ours};
const size_t rays_contender_count = sizeof rays_contenders / sizeof *rays_contenders;
