/* where_they_stand: a query of two shapes by their poses in the world, by the formulas of narrow/placed_road.h. After
 * cases.h. */
#ifndef COLLIDED_TESTS_NARROW_WHERE_THEY_STAND_H
#define COLLIDED_TESTS_NARROW_WHERE_THEY_STAND_H

#include "narrow/placed_road.h"

/* As narrow_query, of shapes in canonical order where they stand: by a formula in world axes if one knows them. The
 * answer is in world axes, with the origin at A's. */
static inline void query_where_they_stand(const shape *a, pose at_a, const shape *b, pose at_b,
    const narrow_request *request, narrow_cache *cache, narrow_result *r)
{
    narrow_placed x = narrow_placed_at(a, at_a), y = narrow_placed_at(b, at_b);
    if (placed_road_applies(request) && x.row->with[y.kind](&x, &y, request, cache, case_scratch(), r)) return;
    pose b_in_a = pose_relative(at_a, at_b);
    narrow_query(a, b, &b_in_a, request, cache, case_scratch(), r);
    r->axis = mat_mul(x.turn, r->axis), r->point_a = mat_mul(x.turn, r->point_a),
    r->point_b = mat_mul(x.turn, r->point_b);
}

#endif
