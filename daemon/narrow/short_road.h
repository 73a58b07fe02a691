/* short_road: balls against balls, capsules and boxes, capsules against capsules, and two boxes: the most frequent
 * pairs of all; and boxes and hulls whose nearest features are known: without the frames, goals and tables of the
 * general road. Pure; any thread. */
#ifndef COLLIDED_NARROW_SHORT_ROAD_H
#define COLLIDED_NARROW_SHORT_ROAD_H

#include "box_axes.h"
#include "epa.h"

/* The answer of narrow_query, to the bit, when the pair is one of these (`cache`, or NULL, is that of boxes: kept up)
 * and doubles suffice for what is asked (no manifold); false otherwise, and then nothing is written that counts. */
bool short_road_answer(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, epa_scratch *scratch, narrow_result *out);

/* The same for two boxes or two hulls, when the distance alone is asked for and is between the features that the cache
 * names, or is proven by its shell (near_features.h, polytope_depth.h). Both are kept up. */
bool short_road_recall(const shape *a, const shape *b, const pose *b_in_a, const narrow_request *request,
    narrow_cache *cache, narrow_result *out);

/* The same for two boxes whose frames are known, and the face that separates most, of those that are not known to
 * overlap. Where the features that are nearest are found, they are told in place of the answer. */
bool short_road_boxes_apart(const box_pair *x, double most, int face, const narrow_request *r, epa_scratch *scratch,
    narrow_features *nearest, narrow_result *out);

#endif
