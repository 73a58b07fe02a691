/* impact_alone: the race without peers (COLLIDED_PEERS is off). */
#include "impact_peer.h"

const impact_peer *const impact_contenders[] = {&impact_ours};
const size_t impact_contender_count = sizeof impact_contenders / sizeof *impact_contenders;
