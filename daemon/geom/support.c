/* Support points of the cores, and their heights rounded up. Pure; any thread; a hint changes the time of a query,
 * never its answer. */
#include "support.h"

#include "compound.h"
#include "hull_scan.h"
#include "hull_support.h"
#include "round.h"

/* |(x, y, z)| without overflow or underflow of the squares; errs by less than 5 u. */
static double length_of(double x, double y, double z)
{
    double most = fmax(fabs(x), fmax(fabs(y), fabs(z)));
    if (!(most > 0)) return 0;
    return most * vec_norm(vec(x / most, y / most, z / most));
}

/* The point of the disc of radius r about the z axis at height z; its centre when the direction has no radial part. */
static vec3 disc_support(double r, double z, vec3 d)
{
    vec3 radial = vec_unit(vec(d.x, d.y, 0));
    return vec(r * radial.x, r * radial.y, z);
}

/* The apex is the support point where the direction is steeper than the normal of the side, (2 h, r). */
static bool cone_apex_wins(const shape *s, vec3 d)
{
    return 2 * s->half.z * d.z >= s->half.x * length_of(d.x, d.y, 0);
}

static uint32_t hull_top(const hull *h, vec3 d, uint32_t *hint)
{
    uint32_t vertex = hull_support(h, d, hint ? *hint : HULL_NO_START);
    if (hint) *hint = vertex;
    return vertex;
}

static vec3 ellipsoid_support(vec3 half, vec3 d)
{
    vec3 w = vec_unit(vec(half.x * d.x, half.y * d.y, half.z * d.z));
    return vec(half.x * w.x, half.y * w.y, half.z * w.z);
}

vec3 support_core(const shape *s, vec3 d, uint32_t *hint)
{
    double z = d.z >= 0 ? s->half.z : -s->half.z;
    switch (s->type) {
    case SHAPE_CAPSULE:
        return vec(0, 0, z);
    case SHAPE_BOX:
        return vec(d.x >= 0 ? s->half.x : -s->half.x, d.y >= 0 ? s->half.y : -s->half.y, z);
    case SHAPE_CYLINDER:
        return disc_support(s->half.x, z, d);
    case SHAPE_CONE:
        return cone_apex_wins(s, d) ? vec(0, 0, s->half.z) : disc_support(s->half.x, -s->half.z, d);
    case SHAPE_ELLIPSOID:
        return ellipsoid_support(s->half, d);
    case SHAPE_HULL:
    case SHAPE_MESH:
        return hull_vertex(s->hull, hull_top(s->hull, d, hint));
    case SHAPE_COMPOUND:
        return compound_support(s->compound, d);
    default:
        return VEC_ZERO;
    }
}

/* `height` was computed from terms that add up to `terms` in absolute value, each by at most 8 rounded operations; so
 * it errs by less than 10 u terms, and the sum below by another u. */
static double height_up(double height, double terms)
{
    return terms > 0 ? height + (16 * ROUND_U * terms + DBL_TRUE_MIN) : height;
}

static double hull_height_up(const hull *h, vec3 d, uint32_t *hint)
{
    uint32_t vertex = hull_top(h, d, hint);
    /* The true highest vertex may be another one, but no higher than this one by more than both their errors. */
    return height_up(vec_dot(d, hull_vertex(h, vertex)), h->max_abs * (fabs(d.x) + fabs(d.y) + fabs(d.z)));
}

double support_height_up(const shape *s, vec3 d, uint32_t *hint)
{
    double along = s->half.z * fabs(d.z), radial, height;
    switch (s->type) {
    case SHAPE_CAPSULE:
        return height_up(along, along);
    case SHAPE_BOX:
        height = s->half.x * fabs(d.x) + s->half.y * fabs(d.y) + along;
        return height_up(height, height);
    case SHAPE_CYLINDER:
        height = s->half.x * length_of(d.x, d.y, 0) + along;
        return height_up(height, height);
    case SHAPE_CONE:
        radial = s->half.x * length_of(d.x, d.y, 0);
        return height_up(fmax(s->half.z * d.z, radial - s->half.z * d.z), radial + along);
    case SHAPE_ELLIPSOID:
        height = length_of(s->half.x * d.x, s->half.y * d.y, s->half.z * d.z);
        return height_up(height, height);
    case SHAPE_HALFSPACE:
        return d.x == 0 && d.y == 0 && d.z >= 0 ? 0 : INFINITY;
    case SHAPE_HULL:
    case SHAPE_MESH:
        return hull_height_up(s->hull, d, hint);
    case SHAPE_COMPOUND:
        return compound_height_up(s->compound, d);
    default:
        return 0;
    }
}

/* As high in each direction as in the opposite one, to the bit. */
static bool is_symmetric(shape_type type)
{
    return type == SHAPE_SPHERE || type == SHAPE_CAPSULE || type == SHAPE_BOX || type == SHAPE_CYLINDER ||
           type == SHAPE_ELLIPSOID;
}

/* A height in the opposite direction is the negative one, to the bit. */
static void hull_spans_up(const hull *h, const vec3 d[3], double up[3], double down[3])
{
    double top[3], bottom[3];
    hull_scan_spans(h, d, top, bottom);
    for (int k = 0; k < 3; k++) {
        double terms = h->max_abs * (fabs(d[k].x) + fabs(d[k].y) + fabs(d[k].z));
        up[k] = height_up(top[k], terms);
        down[k] = height_up(-bottom[k], terms);
    }
}

void support_spans_up(const shape *s, const vec3 directions[3], double up[3], double down[3])
{
    bool scanned = (s->type == SHAPE_HULL || s->type == SHAPE_MESH) && s->hull->node_count == 0;
    if (scanned) {
        hull_spans_up(s->hull, directions, up, down);
        return;
    }
    for (int k = 0; k < 3; k++) {
        up[k] = support_height_up(s, directions[k], NULL);
        down[k] = is_symmetric(s->type) ? up[k] : support_height_up(s, vec_neg(directions[k]), NULL);
    }
}

/* ---- compounds ---- */

static vec3 child_support(const compound_child *c, vec3 direction, vec3 unit)
{
    vec3 core = support_core(&c->shape, mat_tmul(c->place.r, direction), NULL);
    return vec_madd(transform_point(&c->place, core), c->shape.radius, unit);
}

vec3 compound_support(const compound *c, vec3 direction)
{
    vec3 unit = vec_unit(direction), best = child_support(&c->children[0], direction, unit);
    double top = vec_dot(direction, best);
    for (uint32_t i = 1; i < c->child_count; i++) {
        vec3 point = child_support(&c->children[i], direction, unit);
        double height = vec_dot(direction, point);
        if (height > top) top = height, best = point;
    }
    return best;
}

/* The rotation of a child errs by less than 16 u of what it turns (bounds.c), twice; products and sums by less than as
 * much again. */
#define TURN_ULPS 64

double compound_height_up(const compound *c, vec3 direction)
{
    double top = -INFINITY, length = length_up(direction);
    for (uint32_t i = 0; i < c->child_count; i++) {
        const compound_child *child = &c->children[i];
        double core = support_height_up(&child->shape, mat_tmul(child->place.r, direction), NULL);
        top = fmax(top, vec_dot(direction, child->place.t) + core + child->shape.radius * length);
    }
    return top + (TURN_ULPS * ROUND_U * c->reach * length + DBL_TRUE_MIN);
}
