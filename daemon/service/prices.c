/* prices: microseconds of expected work of a message, by counts that it tells itself and the number of bodies in the
 * world; measured on one core of 2026, rounded up. They need not be right: a query that takes longer than expected is
 * charged the difference, and what a price does not foresee is bounded where it is done. Pure. */
#include "shares.h"

#include "wire/wire_model.h"

static const double A_SUBSCRIPTION = 40; /* its stream is memory that the system has yet to find, and a writer */
static const double COMMAND = 2, A_BODY = 5, A_SHAPE = 2, A_CHILD = 10, A_RULE = 0.2; /* each */
static const double AN_OCTET_OF_ROBOT = 0.003;
static const double A_MATCH = 0.002;  /* a rule, or a pattern of a subscription, and a body */
static const double A_NUMBER = 0.012; /* of a geometry: copied into memory that the system has yet to find */
static const double A_POSE = 0.1, A_VERTEX = 0.005;              /* a number of a vertex: checked, and copied */
static const double A_POINT = 2, A_TRIANGLE = 1.5, A_HEIGHT = 4; /* of what is built: hull, mesh, height field */
static const double A_QUERY = 20, A_BODY_NAMED = 0.05, A_BODY_LOOKED_THROUGH = 0.02, A_HIT = 1;
static const double AN_OCTET_CHECKED = 0.05; /* of configurations */

static price of_geometry(const wire_geometry *m)
{
    double vertices = m->vertices.count, indices = m->indices.count;
    double building = m->kind == WIRE_GEOMETRY_MESH || m->kind == WIRE_GEOMETRY_SOFT ? A_TRIANGLE * indices / 3
                      : m->kind == WIRE_GEOMETRY_HEIGHT_FIELD                        ? A_HEIGHT * vertices
                                                                                     : A_POINT * vertices / 3;
    double copying = COMMAND + A_NUMBER * (vertices + indices);
    return (price){copying, copying + building};
}

static price of_body(const wire_body *m, double bodies)
{
    double shapes = m->shape_types.count, rules = m->rule_patterns.count, children = 0;
    for (uint32_t i = 0; i < m->shape_types.count; i++)
        if (m->shape_types.at[i] == WIRE_SHAPE_COMPOUND) children += m->shape_sizes.at[3 * (size_t)i];
    double putting =
        A_BODY + A_SHAPE * shapes + A_CHILD * children + A_RULE * rules + AN_OCTET_OF_ROBOT * m->extensions.count;
    return (price){putting, putting + A_MATCH * rules * bodies};
}

static price of_query(const wire_query *m, double bodies)
{
    double cost = A_QUERY;
    if (m->kind == WIRE_QUERY_BODIES) cost += A_BODY_NAMED * bodies;
    if (m->kind == WIRE_QUERY_BOX || m->kind == WIRE_QUERY_RAY || m->kind == WIRE_QUERY_CAST)
        cost += A_BODY_LOOKED_THROUGH * bodies;
    if (m->kind == WIRE_QUERY_NEAREST)
        cost += A_HIT * (m->most > 0 && m->most < WIRE_ANSWERS_MAX ? (double)m->most : (double)WIRE_ANSWERS_MAX);
    if (m->kind == WIRE_QUERY_CHECK) cost += A_BODY_LOOKED_THROUGH * bodies + AN_OCTET_CHECKED * m->extensions.count;
    return (price){cost, cost};
}

price price_of(const wire_message *m, size_t bodies)
{
    switch (m->kind) {
    case WIRE_GEOMETRY:
        return m->geometry.removed ? (price){COMMAND, COMMAND} : of_geometry(&m->geometry);
    case WIRE_BODY:
        return m->body.removed ? (price){A_BODY, A_BODY} : of_body(&m->body, (double)bodies);
    case WIRE_SUBSCRIPTION:
        return m->subscription.removed ? (price){A_BODY, A_BODY}
                                       : (price){A_SUBSCRIPTION, A_SUBSCRIPTION + 2 * A_MATCH * (double)bodies};
    case WIRE_QUERY:
        return of_query(&m->query, (double)bodies);
    case WIRE_POSE_BATCH: /* poses have rates of their own */
        return (price){
            COMMAND + A_POSE * (double)(m->pose_batch.bodies.count + wire_joints_poses_most(m->pose_batch.extensions)),
            0};
    case WIRE_VERTEX_BATCH: /* what its body has of vertices is added (shares.c) */
        return (price){COMMAND + A_VERTEX * (m->vertex_batch.vertices.count + m->vertex_batch.extensions.count / 4.0),
            COMMAND + A_VERTEX * (m->vertex_batch.vertices.count + m->vertex_batch.extensions.count / 4.0)};
    default:
        return (price){COMMAND, COMMAND};
    }
}
