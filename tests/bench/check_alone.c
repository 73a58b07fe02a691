/* check_alone: the race without peers (COLLIDED_PEERS is off). */
#include "check_peer.h"

const check_peer *const check_contenders[] = {NULL};
const size_t check_contender_count = 0;
