/* dynamics: impulses at points, and motion between impacts. One thread. */
#include "dynamics.h"

#include <math.h>

enum { SWEEPS_MAX = 400 };
static const double SETTLED_M_S = 1e-12; /* a sweep that changes no point's speed by more is the last */

static vector cross(vector a, vector b)
{
    return (vector){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static vector velocity_at(const rigid *body, vector point)
{
    return vector_add(body->linear, cross(body->angular, vector_sub(point, body->position)));
}

static vector slip(const rigid *bodies, const touch *t)
{
    return vector_sub(velocity_at(&bodies[t->b], t->point), velocity_at(&bodies[t->a], t->point));
}

double dynamics_parting(const rigid *bodies, const touch *t)
{
    return vector_dot(t->normal, slip(bodies, t));
}

/* 1/kg: what a unit impulse along a direction there changes of that speed. */
static double yielding(const rigid *body, const touch *t, vector direction)
{
    vector lever = cross(vector_sub(t->point, body->position), direction);
    return body->inverse_mass + body->inverse_inertia * vector_dot(lever, lever);
}

static double yielding_of_both(const rigid *bodies, const touch *t, vector direction)
{
    return yielding(&bodies[t->a], t, direction) + yielding(&bodies[t->b], t, direction);
}

static void push(rigid *body, vector point, vector impulse)
{
    vector twist = cross(vector_sub(point, body->position), impulse);
    body->linear = vector_add(body->linear, vector_scale(body->inverse_mass, impulse));
    body->angular = vector_add(body->angular, vector_scale(body->inverse_inertia, twist));
}

static void push_both(rigid *bodies, const touch *t, vector impulse)
{
    push(&bodies[t->b], t->point, impulse);
    push(&bodies[t->a], t->point, vector_scale(-1, impulse));
}

/* m/s: by how much it changed the speed of parting. */
static double relax_normal(rigid *bodies, touch *t)
{
    double k = yielding_of_both(bodies, t, t->normal);
    double whole = fmax(t->normal_impulse + (t->target - dynamics_parting(bodies, t)) / k, t->least);
    double more = whole - t->normal_impulse;
    t->normal_impulse = whole;
    push_both(bodies, t, vector_scale(more, t->normal));
    return fabs(more) * k;
}

/* Against the slipping, as far as the cone allows. */
static double relax_friction(rigid *bodies, touch *t)
{
    vector v = slip(bodies, t);
    v = vector_sub(v, vector_scale(vector_dot(v, t->normal), t->normal));
    double speed = sqrt(vector_dot(v, v));
    if (t->friction == 0 || speed == 0) return 0;
    double k = yielding_of_both(bodies, t, vector_scale(1 / speed, v));
    vector whole = vector_sub(t->friction_impulse, vector_scale(1 / k, v));
    double size = sqrt(vector_dot(whole, whole)), most = t->friction * t->normal_impulse;
    if (size > most) whole = vector_scale(most / size, whole);
    vector more = vector_sub(whole, t->friction_impulse);
    t->friction_impulse = whole;
    push_both(bodies, t, more);
    return sqrt(vector_dot(more, more)) * k;
}

void dynamics_relax(rigid *bodies, touch *touches, size_t count)
{
    double most = INFINITY;
    for (int k = 0; k < SWEEPS_MAX && most > SETTLED_M_S; k++) {
        most = 0;
        for (size_t i = 0; i < count; i++) {
            most = fmax(most, relax_friction(bodies, &touches[i]));
            most = fmax(most, relax_normal(bodies, &touches[i]));
        }
    }
}

static void begin(touch *t, double least)
{
    t->target = 0;
    t->least = t->normal_impulse = least;
    t->friction_impulse = (vector){0};
}

void dynamics_collide(rigid *bodies, touch *touches, size_t count)
{
    for (size_t i = 0; i < count; i++) begin(&touches[i], 0);
    dynamics_relax(bodies, touches, count);
    for (size_t i = 0; i < count; i++) {
        touch *t = &touches[i];
        begin(t, t->restitution * t->normal_impulse);
        push_both(bodies, t, vector_scale(t->least, t->normal));
    }
    dynamics_relax(bodies, touches, count);
}

static void turn(double q[4], vector angular, double seconds)
{
    double rate = sqrt(vector_dot(angular, angular));
    if (rate == 0) return;
    double s = sin(0.5 * rate * seconds) / rate, w = cos(0.5 * rate * seconds);
    vector v = vector_scale(s, angular), u = {q[1], q[2], q[3]};
    vector to = vector_add(vector_add(vector_scale(w, u), vector_scale(q[0], v)), cross(v, u));
    const double turned[4] = {w * q[0] - vector_dot(v, u), to.x, to.y, to.z};
    double size = 0;
    for (int i = 0; i < 4; i++) size += turned[i] * turned[i];
    for (int i = 0; i < 4; i++) q[i] = turned[i] / sqrt(size);
}

void dynamics_advance(rigid *body, vector linear, double seconds)
{
    body->position = vector_add(body->position, vector_scale(seconds, linear));
    turn(body->orientation, body->angular, seconds);
}

double dynamics_kinetic(const rigid *bodies, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        const rigid *b = &bodies[i];
        if (b->inverse_mass > 0) sum += vector_dot(b->linear, b->linear) / b->inverse_mass;
        if (b->inverse_inertia > 0) sum += vector_dot(b->angular, b->angular) / b->inverse_inertia;
    }
    return 0.5 * sum;
}

vector dynamics_momentum(const rigid *bodies, size_t count)
{
    vector sum = {0};
    for (size_t i = 0; i < count; i++)
        if (bodies[i].inverse_mass > 0)
            sum = vector_add(sum, vector_scale(1 / bodies[i].inverse_mass, bodies[i].linear));
    return sum;
}
