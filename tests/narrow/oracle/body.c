/* body: support points and separations of the oracle's bodies, in 113 bits. Pure. */
#include "body.h"

qmat oracle_rotation(quad w, quad x, quad y, quad z)
{
    quad s = 2 / (w * w + x * x + y * y + z * z);
    return (qmat){{1 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)},
        {s * (x * y + w * z), 1 - s * (x * x + z * z), s * (y * z - w * x)},
        {s * (x * z - w * y), s * (y * z + w * x), 1 - s * (x * x + y * y)}};
}

static qvec farthest_point(const qvec *points, size_t count, qvec d)
{
    size_t best = 0;
    for (size_t i = 1; i < count; i++)
        if (q_dot(d, points[i]) > q_dot(d, points[best])) best = i;
    return points[best];
}

/* The point of the circle of this radius around z at height z; its middle when d has no part across. */
static qvec farthest_on_circle(quad radius, quad z, qvec d)
{
    quad across = q_sqrt(d.x * d.x + d.y * d.y);
    if (!(across > 0)) return qv(0, 0, z);
    return qv(radius * d.x / across, radius * d.y / across, z);
}

static qvec farthest_local(const oracle_body *body, qvec d)
{
    qvec h = body->half;
    switch (body->core) {
    case ORACLE_CYLINDER:
        return farthest_on_circle(h.x, d.z < 0 ? -h.z : h.z, d);
    case ORACLE_CONE: {
        qvec apex = qv(0, 0, h.z), rim = farthest_on_circle(h.x, -h.z, d);
        return q_dot(d, apex) >= q_dot(d, rim) ? apex : rim;
    }
    case ORACLE_ELLIPSOID: {
        qvec scaled = qv(h.x * d.x, h.y * d.y, h.z * d.z);
        quad norm = q_norm(scaled);
        if (!(norm > 0)) return qv(0, 0, 0);
        return qv(h.x * scaled.x / norm, h.y * scaled.y / norm, h.z * scaled.z / norm);
    }
    case ORACLE_POINTS:
    case ORACLE_HALFSPACE:
        break;
    }
    return farthest_point(body->points, body->count, d);
}

qvec oracle_support(const oracle_body *body, qvec direction)
{
    qvec local = farthest_local(body, q_tmul(body->rotation, direction));
    return q_add(q_mul(body->rotation, local), body->position);
}

qvec body_plane_normal(const oracle_body *halfspace)
{
    return q_unit(q_mul(halfspace->rotation, qv(0, 0, 1)));
}

/* Greatest n.x relative to `origin`, for unit n. A half-space is bounded along its own normal alone; an axis that is
 * parallel up to the rounding of doubles counts as that normal, for no double vector may be parallel to it exactly. */
static quad height(const oracle_body *body, qvec n, qvec origin)
{
    if (body->core != ORACLE_HALFSPACE) return q_dot(n, q_sub(oracle_support(body, n), origin)) + body->radius;
    qvec normal = body_plane_normal(body);
    if (q_norm(q_sub(n, normal)) > 0x1p-48) return INFINITY;
    return q_dot(normal, q_sub(body->position, origin)) + body->radius;
}

quad oracle_separation(const oracle_body *a, const oracle_body *b, qvec n)
{
    qvec unit = q_unit(n);
    return -height(a, unit, a->position) - height(b, q_neg(unit), a->position);
}

static quad extent(const oracle_body *body)
{
    quad most = q_max_abs(body->half);
    if (body->core == ORACLE_HALFSPACE) most = 0;
    for (size_t i = 0; i < body->count; i++) most = q_max(most, q_max_abs(body->points[i]));
    return most + body->radius;
}

quad oracle_size(const oracle_body *a, const oracle_body *b)
{
    return q_max(q_max(extent(a), extent(b)), q_max_abs(q_sub(b->position, a->position)));
}
