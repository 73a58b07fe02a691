/* subject: engine shapes and oracle bodies made of the same numbers. */
#include "subject.h"

#include <stdlib.h>

static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};

static qvec *points_new(size_t count)
{
    qvec *points = calloc(count, sizeof *points);
    if (!points) abort();
    return points;
}

/* The core of a sphere, capsule or box by its corners. */
static void core_points(subject *s)
{
    vec3 h = s->shape.half;
    size_t count = s->shape.type == SHAPE_SPHERE ? 1 : s->shape.type == SHAPE_CAPSULE ? 2 : 8;
    s->points = points_new(count);
    if (count == 2) s->points[0] = qv(0, 0, -h.z), s->points[1] = qv(0, 0, h.z);
    for (int i = 0; i < 8 && count == 8; i++)
        s->points[i] = qv(i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z);
    s->exact.count = count;
}

static oracle_core core_of(shape_type type)
{
    switch (type) {
    case SHAPE_CYLINDER:
        return ORACLE_CYLINDER;
    case SHAPE_CONE:
        return ORACLE_CONE;
    case SHAPE_ELLIPSOID:
        return ORACLE_ELLIPSOID;
    case SHAPE_HALFSPACE:
        return ORACLE_HALFSPACE;
    default:
        return ORACLE_POINTS;
    }
}

void subject_from_shape(subject *s, shape from)
{
    *s = (subject){.shape = from};
    s->exact.core = core_of(from.type);
    s->exact.radius = from.radius;
    if (s->exact.core == ORACLE_POINTS)
        core_points(s);
    else
        s->exact.half = qv(from.half.x, from.half.y, from.half.z);
    s->exact.points = s->points;
    subject_place(s, POSE_IDENTITY);
}

const char *subject_from_points(subject *s, const double *points, size_t count, double radius)
{
    *s = (subject){.shape = {.type = SHAPE_HULL, .radius = radius}};
    hull_status status = hull_build(points, count, HULL_ALLOW_FLAT, &s->hull);
    if (status != HULL_OK) return hull_status_text(status);
    s->shape.hull = s->hull;
    s->points = points_new(count);
    for (size_t i = 0; i < count; i++) s->points[i] = qv(points[3 * i], points[3 * i + 1], points[3 * i + 2]);
    s->exact.radius = radius;
    s->exact.points = s->points;
    s->exact.count = count;
    subject_place(s, POSE_IDENTITY);
    return NULL;
}

/* Shepperd's method: the largest of w, x, y, z is found first, so that nothing is divided by a small number. */
static quat quaternion_of(const double r[9])
{
    long double m[3][3], q[4];
    for (int i = 0; i < 9; i++) m[i / 3][i % 3] = r[i];
    long double trace = m[0][0] + m[1][1] + m[2][2];
    int largest = 3; /* w */
    for (int i = 0; i < 3; i++)
        if (m[i][i] > (largest == 3 ? trace : m[largest][largest])) largest = i;
    if (largest == 3) {
        q[0] = 1 + trace, q[1] = m[2][1] - m[1][2], q[2] = m[0][2] - m[2][0], q[3] = m[1][0] - m[0][1];
    } else {
        int i = largest, j = (i + 1) % 3, k = (i + 2) % 3;
        q[0] = m[k][j] - m[j][k];
        q[1 + i] = 1 + 2 * m[i][i] - trace;
        q[1 + j] = m[j][i] + m[i][j];
        q[1 + k] = m[k][i] + m[i][k];
    }
    long double norm = sqrtl(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    return (quat){(double)(q[0] / norm), (double)(q[1] / norm), (double)(q[2] / norm), (double)(q[3] / norm)};
}

void subject_place(subject *s, pose at)
{
    s->pose = at;
    s->exact.rotation = oracle_rotation(at.q.w, at.q.x, at.q.y, at.q.z);
    s->exact.position = qv(at.p.x, at.p.y, at.p.z);
    s->given = s->exact;
}

void subject_place_matrix(subject *s, const double r[9], vec3 p)
{
    bool same = numbers_equal(r, identity, 9);
    subject_place(s, (pose){p, same ? POSE_IDENTITY.q : quaternion_of(r)});
    s->given.rotation = (qmat){{r[0], r[1], r[2]}, {r[3], r[4], r[5]}, {r[6], r[7], r[8]}};
}

double subject_deviation(const subject *s)
{
    const qmat *g = &s->given.rotation, *e = &s->exact.rotation;
    quad reach = q_norm(s->exact.half);
    for (size_t i = 0; i < s->exact.count; i++) reach = q_max(reach, q_norm(s->exact.points[i]));
    qvec dx = q_sub(g->x, e->x), dy = q_sub(g->y, e->y), dz = q_sub(g->z, e->z);
    return (double)(reach * q_sqrt(q_dot(dx, dx) + q_dot(dy, dy) + q_dot(dz, dz)));
}

void subject_free(subject *s)
{
    hull_destroy(s->hull);
    free(s->points);
    *s = (subject){.hull = NULL};
}
