/* moving_alone: without peers the world is measured by itself. */
#include "moving_scene.h"

const moving_peer *const moving_peers[] = {0};
const size_t moving_peer_count = 0;
