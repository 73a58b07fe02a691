/* short_road: hulls, and boxes with hulls, whose nearest features are known, without the frames, goals and tables of
 * the general method; and two boxes that a formula left to a search. Pure; any thread. */
#ifndef COLLIDED_NARROW_SHORT_ROAD_H
#define COLLIDED_NARROW_SHORT_ROAD_H

#include "box_axes.h"
#include "epa.h"

/* The answer of narrow_query, to the bit, for two hulls or a box and a hull, when the distance alone is asked for and
 * is between the features that the cache names, or is proven by its shell (near_features.h, polytope_depth.h). Both are
 * kept up. False otherwise, and then nothing is written that counts. */
bool short_road_recall(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_result *out);

/* The distance of two boxes whose frames are known, and the face that separates most, of those that are not known to
 * overlap. Where the features that are nearest are found, they are told in place of the answer. */
bool short_road_boxes_apart(const box_pair *x, double most, int face, const narrow_request *r, epa_scratch *scratch,
    narrow_features *nearest, narrow_result *out);

#endif
