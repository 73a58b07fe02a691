/* check_all: the race with FCL. */
#include "check_peer.h"

const check_peer *const check_contenders[] = {&check_fcl};
const size_t check_contender_count = sizeof check_contenders / sizeof *check_contenders;
