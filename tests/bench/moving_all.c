/* moving_all: the peers that Debian has, of whole steps: found pairs, and for each whether it touches. */
#include "moving_scene.h"

const moving_peer *const moving_peers[] = {&moving_bullet, &moving_fcl, &moving_ode};
const size_t moving_peer_count = sizeof moving_peers / sizeof *moving_peers;
