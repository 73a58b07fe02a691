/* impact_all: ours and every peer of the Debian packages that finds times of impact. */
#include "impact_peer.h"

const impact_peer *const impact_contenders[] = {&impact_ours, &impact_fcl, &impact_bullet};
const size_t impact_contender_count = sizeof impact_contenders / sizeof *impact_contenders;
