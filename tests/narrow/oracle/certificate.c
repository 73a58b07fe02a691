/* certificate: is a claimed interval proved by its axis and points? And the choice of the method for a truth. */
#include "body.h"

/* A half-space against anything bounded: the one plane decides. */
static oracle_truth halfspace_distance(const oracle_body *a, const oracle_body *b)
{
    bool a_is_plane = a->core == ORACLE_HALFSPACE;
    const oracle_body *plane = a_is_plane ? a : b, *other = a_is_plane ? b : a;
    qvec normal = body_plane_normal(plane), axis = a_is_plane ? normal : q_neg(normal);
    if (other->core == ORACLE_HALFSPACE) return (oracle_truth){.lo = -INFINITY, .hi = -INFINITY, .axis = axis};
    quad f = oracle_separation(a, b, axis), error = (quad)1e-30 * oracle_size(a, b);
    return (oracle_truth){.lo = f - error, .hi = f + error, .axis = axis};
}

static bool has_features(const oracle_body *body)
{
    return body->core == ORACLE_POINTS && body->count <= ORACLE_FEATURES_MAX;
}

oracle_truth oracle_distance(const oracle_body *a, const oracle_body *b)
{
    if (a->core == ORACLE_HALFSPACE || b->core == ORACLE_HALFSPACE) return halfspace_distance(a, b);
    return has_features(a) && has_features(b) ? oracle_distance_features(a, b) : oracle_distance_bounds(a, b);
}

quad oracle_outside(const oracle_body *body, qvec point)
{
    const qvec origin = {0, 0, 0};
    oracle_body at = {.core = ORACLE_POINTS, .points = &origin, .count = 1, .rotation = oracle_rotation(1, 0, 0, 0)};
    at.position = point;
    oracle_truth truth =
        body->core == ORACLE_HALFSPACE ? halfspace_distance(body, &at) : oracle_distance_bounds(body, &at);
    return q_max(0, truth.lo);
}

static qvec from_doubles(const double v[3])
{
    return qv(v[0], v[1], v[2]);
}

/* Deepest along the axis: on the plane that supports the body there. A half-space has that plane and no other. */
static bool on_support_plane(const oracle_body *body, qvec n, qvec point, quad slack)
{
    if (body->core == ORACLE_HALFSPACE) {
        qvec normal = body_plane_normal(body);
        return q_abs(q_dot(normal, q_sub(point, body->position)) - body->radius) <= slack;
    }
    return q_dot(n, q_sub(oracle_support(body, n), point)) + body->radius <= slack;
}

const char *oracle_check(const oracle_body *a, const oracle_body *b, const oracle_claim *claim, quad slack)
{
    qvec axis = from_doubles(claim->axis);
    qvec point_a = q_add(from_doubles(claim->point_a), claim->origin);
    qvec point_b = q_add(from_doubles(claim->point_b), claim->origin);
    if (!(claim->lo <= claim->hi)) return "lo > hi, or not a number";
    if (!(q_abs(q_norm(axis) - 1) <= 0x1p-49)) return "the axis is not a unit vector";
    if (!(claim->lo <= oracle_separation(a, b, axis))) return "lo is above the separation along the axis";
    if (!(oracle_outside(a, point_a) <= slack)) return "point_a is outside of A";
    if (!(oracle_outside(b, point_b) <= slack)) return "point_b is outside of B";
    if (claim->hi > 0 && claim->lo > 0) {
        /* of turned points the coordinates are rounded once more */
        if (!(q_norm(q_sub(point_b, point_a)) <= claim->hi * (1 + (quad)0x1p-50)))
            return "the points are farther apart than hi";
        return NULL;
    }
    if (claim->hi < 0 && !on_support_plane(a, axis, point_a, slack)) return "point_a is not deepest along the axis";
    if (claim->hi < 0 && !on_support_plane(b, q_neg(axis), point_b, slack))
        return "point_b is not deepest along the axis";
    return NULL;
}
