/* impact_scene: what the scenes share: states into the hash, impacts with their balance, bounds. One thread. */
#include "impact_scene.h"

#include <math.h>
#include <string.h>

static uint64_t mix(uint64_t hash, const void *data, size_t size)
{
    const unsigned char *byte = data;
    for (size_t i = 0; i < size; i++) hash = (hash ^ byte[i]) * 1099511628211u;
    return hash;
}

void scene_note_state(scene_result *r, const lockstep *l)
{
    if (!r->hash) r->hash = 14695981039346656037u;
    r->hash = mix(r->hash, &r->time_s, sizeof r->time_s);
    for (size_t i = 0; i < l->moving; i++) {
        const rigid *b = &l->bodies[i];
        r->hash = mix(r->hash, &b->position, sizeof b->position);
        r->hash = mix(r->hash, &b->linear, sizeof b->linear);
        r->hash = mix(r->hash, &b->angular, sizeof b->angular);
        r->hash = mix(r->hash, b->orientation, sizeof b->orientation);
        if (r->tracks && r->track_count < TRACK_POINTS)
            r->tracks[r->track_count++] = (track_point){(int)i, b->position.x, b->position.y};
    }
}

static double size_of(vector v)
{
    return sqrt(vector_dot(v, v));
}

/* Of those that met, the sum of what each has. */
static double moved_mass(const lockstep *l, const touch *points, size_t count)
{
    double sum = 0;
    for (size_t i = 0; i < count; i++) {
        const rigid *a = &l->bodies[points[i].a], *b = &l->bodies[points[i].b];
        if (a->inverse_mass > 0) sum += size_of(a->linear) / a->inverse_mass;
        if (b->inverse_mass > 0) sum += size_of(b->linear) / b->inverse_mass;
    }
    return sum;
}

void scene_collide(scene_result *r, lockstep *l, touch *points, size_t count)
{
    bool closed = true; /* nothing fixed took some of the momentum */
    for (size_t i = 0; i < count; i++) closed &= (size_t)points[i].b < l->moving;
    double energy = dynamics_kinetic(l->bodies, l->moving), share = moved_mass(l, points, count);
    vector momentum = dynamics_momentum(l->bodies, l->moving);
    dynamics_collide(l->bodies, points, count);
    double change = (dynamics_kinetic(l->bodies, l->moving) - energy) / r->first_j;
    r->energy_gain = fmax(r->energy_gain, change);
    r->energy_change = fmax(r->energy_change, fabs(change));
    vector moved = vector_sub(dynamics_momentum(l->bodies, l->moving), momentum);
    if (closed && share > 0) r->momentum_change = fmax(r->momentum_change, size_of(moved) / share);
    r->impacts++;
}

bool scene_holds(const scene_result *r, const lockstep *l)
{
    double energy = r->elastic ? r->energy_change : r->energy_gain, gain = (r->last_j - r->first_j) / r->first_j;
    return r->good && energy <= r->energy_bound && r->momentum_change <= r->momentum_bound &&
           l->deepest_m <= r->depth_bound_m && (r->elastic ? fabs(gain) : gain) <= r->energy_bound * (double)r->impacts;
}
