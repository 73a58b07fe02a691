/* contenders_ours: without the peers' packages (COLLIDED_PEERS=OFF). */
#include "broad_peer.h"

const peer *const broad_contenders[] = {&peer_ours, &peer_ours_tree, &peer_ours_sweep3, &peer_ours_sweep1};
const size_t broad_contender_count = 4, broad_ours_count = 4;
