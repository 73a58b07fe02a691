/* placed_balls: the roads of a ball and a ball or a box, with registers of 16 bytes, and for all sizes. Pure; any
 * thread. */
#include "triple_pairs.h"

#include "placed_balls.h"

ROAD(two_balls)
ROAD(ball_and_box)
