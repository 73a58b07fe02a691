/* random_pair: reproducible pairs for relations that hold for every pair. */
#include "random_pair.h"
#include "base/prng.h"

#include <stdlib.h>

uint64_t random_bits(uint64_t *state)
{
    return prng_bits(state);
}

double random_uniform(uint64_t *state, double lo, double hi)
{
    return lo + (hi - lo) * ((double)(random_bits(state) >> 11) * 0x1p-53);
}

/* A point of the four-dimensional ball, normalised. A tenth are turns by quarters, where features are parallel. */
quat random_rotation(uint64_t *state)
{
    static const quat quarters[4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}, {0, 0, 0, 1}};
    if (random_bits(state) % 10 == 0) return quarters[random_bits(state) % 4];
    for (;;) {
        quat q = {random_uniform(state, -1, 1), random_uniform(state, -1, 1), random_uniform(state, -1, 1),
            random_uniform(state, -1, 1)};
        double norm2 = quat_norm2(q);
        if (norm2 > 0.01 && norm2 <= 1) return quat_unit(q);
    }
}

shape random_shape(uint64_t *state, shape_type type)
{
    shape s = {.type = type};
    double x = random_uniform(state, 0.05, 1), y = random_uniform(state, 0.05, 1), z = random_uniform(state, 0.05, 1);
    switch (type) {
    case SHAPE_SPHERE:
        s.radius = x;
        break;
    case SHAPE_CAPSULE:
        s.radius = x / 2;
        s.half.z = z;
        break;
    case SHAPE_CYLINDER:
    case SHAPE_CONE:
        s.half = vec(x, x, z);
        break;
    case SHAPE_HALFSPACE:
        break;
    default:
        s.half = vec(x, y, z);
    }
    bool round = type == SHAPE_SPHERE || type == SHAPE_CAPSULE;
    if (!round && random_bits(state) % 3 == 0) s.radius = random_uniform(state, 0.01, 0.2);
    return s;
}

void random_hull_points(uint64_t *state, double points[3 * RANDOM_HULL_POINTS])
{
    for (int i = 0; i < 3 * RANDOM_HULL_POINTS; i++) points[i] = random_uniform(state, -1, 1);
}

void random_subject(uint64_t *state, shape_type type, subject *s)
{
    double points[3 * RANDOM_HULL_POINTS];
    if (type != SHAPE_HULL) {
        subject_from_shape(s, random_shape(state, type));
        return;
    }
    random_hull_points(state, points);
    if (subject_from_points(s, points, RANDOM_HULL_POINTS, random_bits(state) % 3 == 0 ? 0.1 : 0)) abort();
}

static double on_grid(double x)
{
    return nearbyint(x * 0x1p30) * 0x1p-30;
}

static vec3 random_direction(uint64_t *state)
{
    quat q = random_rotation(state);
    return quat_rotate(q, vec(0, 0, 1));
}

void random_pair(uint64_t *state, shape_type type_a, shape_type type_b, subject *a, subject *b)
{
    random_subject(state, type_a, a);
    random_subject(state, type_b, b);
    vec3 at = vec(on_grid(random_uniform(state, -1, 1)), on_grid(random_uniform(state, -1, 1)),
        on_grid(random_uniform(state, -1, 1)));
    subject_place(a, (pose){at, random_rotation(state)});
    double reach = shape_reach(&b->shape) + (type_a == SHAPE_HALFSPACE ? 0 : shape_reach(&a->shape));
    vec3 towards = vec_scale(random_direction(state), reach * random_uniform(state, 0.05, 1.3));
    vec3 to = vec_add(at, vec(on_grid(towards.x), on_grid(towards.y), on_grid(towards.z)));
    subject_place(b, (pose){to, random_rotation(state)});
}
