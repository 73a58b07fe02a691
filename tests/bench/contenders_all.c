/* contenders_all: ours and every peer of the Debian packages. */
#include "broad_peer.h"

const peer *const broad_contenders[] = {&peer_ours, &peer_ours_tree, &peer_ours_sweep3, &peer_ours_sweep1,
    &peer_bullet_dbvt, &peer_bullet_sweep16, &peer_bullet_sweep32, &peer_fcl_update, &peer_fcl_refit, &peer_ode_hash,
    &peer_ode_sweep};
const size_t broad_contender_count = sizeof broad_contenders / sizeof *broad_contenders, broad_ours_count = 4;
