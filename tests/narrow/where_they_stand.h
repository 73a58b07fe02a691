/* where_they_stand: a query of two shapes by their poses in the world, with a cache. After cases.h. */
#ifndef COLLIDED_TESTS_NARROW_WHERE_THEY_STAND_H
#define COLLIDED_TESTS_NARROW_WHERE_THEY_STAND_H

#include "narrow/primitives/primitives.h"

/* As narrow_query, of shapes in canonical order where they stand: by a formula in world axes if one knows them. The
 * answer is in world axes, with the origin at A's. */
static inline void query_where_they_stand(const shape *a, pose at_a, const shape *b, pose at_b,
    const narrow_request *request, narrow_cache *cache, narrow_result *r)
{
    if (primitives_answer_in_world(a, &at_a, b, &at_b, request, r)) return;
    pose b_in_a = pose_relative(at_a, at_b);
    mat3 turn = quat_matrix(at_a.q);
    narrow_query(a, b, &b_in_a, request, cache, case_scratch(), r);
    r->axis = mat_mul(turn, r->axis), r->point_a = mat_mul(turn, r->point_a), r->point_b = mat_mul(turn, r->point_b);
}

#endif
