/* moving_scene: see the header. */
#include "moving_scene.h"

#include "base/prng.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double SIDE_EACH = 1.05; /* m, of a cube for each body: by it 0.47 contacts a body */

static double *drawn(uint64_t *state, size_t count, double lo, double hi)
{
    double *out = malloc(count * sizeof *out);
    if (!out) abort();
    for (size_t i = 0; i < count; i++) out[i] = prng_in(state, lo, hi);
    return out;
}

static void make_unit(double q[4])
{
    double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4; k++) q[k] /= length;
}

moving_scene *moving_scene_create(size_t count)
{
    uint64_t state = 18;
    moving_scene *s = malloc(sizeof *s);
    if (!s) abort();
    s->count = count;
    s->side = SIDE_EACH * cbrt((double)count);
    s->bodies = malloc(count * sizeof *s->bodies);
    if (!s->bodies) abort();
    for (size_t i = 0; i < count; i++) {
        moving_body *b = &s->bodies[i];
        b->kind = (moving_kind)(i % MOVING_KINDS);
        for (int k = 0; k < 3; k++) b->half[k] = prng_in(&state, 0.2, 0.4);
        if (b->kind == MOVING_CAPSULE) b->half[0] *= 0.5;
    }
    s->positions = drawn(&state, 3 * count, 0, s->side);
    s->orientations = drawn(&state, 4 * count, -1, 1);
    for (size_t i = 0; i < count; i++) make_unit(&s->orientations[4 * i]);
    s->velocities = drawn(&state, 3 * count, -1, 1);
    s->spins = drawn(&state, 3 * count, -2, 2);
    return s;
}

void moving_scene_destroy(moving_scene *s)
{
    free(s->bodies);
    free(s->positions);
    free(s->orientations);
    free(s->velocities);
    free(s->spins);
    free(s);
}

void moving_scene_copy(moving_scene *to, const moving_scene *from)
{
    memcpy(to->positions, from->positions, 3 * from->count * sizeof *to->positions);
    memcpy(to->orientations, from->orientations, 4 * from->count * sizeof *to->orientations);
    memcpy(to->velocities, from->velocities, 3 * from->count * sizeof *to->velocities);
}

static void turn(double q[4], const double spin[3], double h)
{
    double w = q[0], x = q[1], y = q[2], z = q[3], a = 0.5 * h * spin[0], b = 0.5 * h * spin[1], c = 0.5 * h * spin[2];
    q[0] = w - a * x - b * y - c * z;
    q[1] = x + a * w + b * z - c * y;
    q[2] = y + b * w + c * x - a * z;
    q[3] = z + c * w + a * y - b * x;
    make_unit(q);
}

void moving_scene_step(moving_scene *s)
{
    const double h = 1.0 / MOVING_HZ;
    for (size_t i = 0; i < 3 * s->count; i++) {
        double to = s->positions[i] + h * s->velocities[i];
        if (to < 0 || to > s->side)
            s->velocities[i] = -s->velocities[i];
        else
            s->positions[i] = to;
    }
    for (size_t i = 0; i < s->count; i++) turn(&s->orientations[4 * i], &s->spins[3 * i], h);
}
