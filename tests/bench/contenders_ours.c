/* contenders_ours: without the peers' packages (COLLIDED_PEERS=OFF). */
#include "broad_peer.h"

const peer *const broad_contenders[] = {&peer_ours};
const size_t broad_contender_count = 1, broad_ours_count = 1;
