/* placed_balls_wide: the roads of a ball and a ball or a box, with registers of 32 bytes: the same bits as
 * placed_balls.c, which has all other sizes. Pure; any thread. */
#include "triple_wide.h"

#include "placed_balls.h"

#define ROAD_WIDE(formula)                                                                                             \
    LANES_WIDE bool formula##_placed_wide(const narrow_placed *a, const narrow_placed *b,                              \
        const narrow_request *request, narrow_cache *cache, narrow_scratch *scratch, narrow_result *result)            \
    {                                                                                                                  \
        const placed q = {a->shape, b->shape, a, b, request, true};                                                    \
        return formula(&q, result) || formula##_placed(a, b, request, cache, scratch, result);                         \
    }

ROAD_WIDE(two_balls)
ROAD_WIDE(ball_and_box)
