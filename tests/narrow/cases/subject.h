/* subject: one body under test, as the engine takes it and as the oracle takes it. Owns its hull and points. */
#ifndef COLLIDED_TESTS_CASES_SUBJECT_H
#define COLLIDED_TESTS_CASES_SUBJECT_H

#include "geom/hull.h"
#include "geom/shape.h"
#include "geom/vec.h"
#include "oracle/oracle.h"

typedef struct subject {
    shape shape;
    pose pose;
    hull *hull;        /* owned; NULL if none */
    qvec *points;      /* owned: the oracle's */
    oracle_body exact; /* at `pose`, its quaternion normalised in 113 bits: what the engine is asked about */
    oracle_body given; /* at the pose of the source, before it became a quaternion */
} subject;

/* The shape's own frame: at the identity until it is placed. */
void subject_from_shape(subject *s, shape from); /* no hulls */

/* A hull of `count` points; flat ones too. NULL, or why the engine's builder refused. */
const char *subject_from_points(subject *s, const double *points, size_t count, double radius);

/* Row-major matrix, perhaps not orthonormal: made a quaternion in extended precision for the engine. */
void subject_place_matrix(subject *s, const double r[9], vec3 p);
void subject_place(subject *s, pose at);

/* How far any point of the body may be from where `given` has it, because a quaternion cannot say what the matrix said.
 */
double subject_deviation(const subject *s);

void subject_free(subject *s);

static inline bool numbers_equal(const double *a, const double *b, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (a[i] != b[i]) return false;
    return true;
}

#endif
