/* dynamics: rigid bodies and impulses between them, by the books: Newton and Euler for the motion, Poisson's hypothesis
 * for restitution, Coulomb's cone for friction. It knows of no collision daemon: where bodies touch, it is told.
 *
 * Units: m, kg, s, rad. The frame is the world's. One thread; nothing is allocated. */
#ifndef COLLIDED_EXAMPLES_DYNAMICS_H
#define COLLIDED_EXAMPLES_DYNAMICS_H

#include <stddef.h>

typedef struct vector {
    double x, y, z;
} vector;

static inline vector vector_add(vector a, vector b)
{
    return (vector){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline vector vector_scale(double k, vector a)
{
    return (vector){k * a.x, k * a.y, k * a.z};
}

static inline vector vector_sub(vector a, vector b)
{
    return (vector){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline double vector_dot(vector a, vector b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

typedef struct rigid {
    const char *name;
    double inverse_mass;    /* 1/kg; 0: it is fixed */
    double inverse_inertia; /* 1/(kg m^2), the same about all axes (balls, cubes): so it keeps its spin in free flight;
                               0: it does not turn */
    vector position, linear, angular;
    double orientation[4]; /* w, x, y, z */
} rigid;

typedef struct touch { /* a point at which two bodies touch */
    int a, b;          /* which ones */
    vector normal;     /* unit, from A to B */
    vector point;
    double gap; /* m */
    double restitution, friction;
    double target;         /* m/s: part at least so fast */
    double least;          /* N s: push at least so much */
    double normal_impulse; /* N s, what it came to: B is pushed along the normal, A against it, ... */
    vector friction_impulse;
} touch;

/* m/s: how fast the two part there. */
double dynamics_parting(const rigid *bodies, const touch *t);

/* The least impulses, within the cones of friction, after which all points part at their target speeds. (Projected
 * Gauss-Seidel: point by point until nothing changes any more.) */
void dynamics_relax(rigid *bodies, touch *touches, size_t count);

/* An impact at all these points at once. Poisson's hypothesis: it compresses until nothing approaches any more, and
 * then each point gives back its restitution's share of the normal impulse that this took. */
void dynamics_collide(rigid *bodies, touch *touches, size_t count);

/* On a straight line, turning at a constant rate, for so long: the motion that collided predicts. */
void dynamics_advance(rigid *body, vector linear, double seconds);

double dynamics_kinetic(const rigid *bodies, size_t count); /* J */
vector dynamics_momentum(const rigid *bodies, size_t count);

#endif
