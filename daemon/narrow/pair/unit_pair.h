/* unit_pair: two shapes brought to unit size by a power of two, and the three words in which every method answers.
 *
 * Inside narrow/ all methods work on cores (radii left out) in A's frame, in units in which the pair is about 1 large:
 * so no square overflows or underflows, and scaling the input by 2^k changes no bit but the exponent. Pure; any thread.
 */
#ifndef COLLIDED_NARROW_PAIR_UNIT_PAIR_H
#define COLLIDED_NARROW_PAIR_UNIT_PAIR_H

#include "effort.h"
#include "narrow/math/scalar.h"
#include "request.h"

#define UNIT_ROUNDOFF 0x1p-53

enum { UNIT_EXPONENT_MAX = 1000 };

typedef struct unit_pair {
    shape a, b;       /* scaled; the vertices of a hull are scaled when they are read */
    transform b_in_a; /* scaled */
    double unit;      /* power of two: real length = length here * unit */
    double scale;     /* 1 / unit */
    double radius;    /* of a plus of b */
    double shaved_a;  /* by which the core of an ellipsoid is smaller than its half axes say; in a.radius, too */
    double shaved_b;
    double size;         /* bounds every |coordinate| that enters: reach of A + reach of B + |position|; the reach of a
                            half-space is as far as the other shape is from its origin */
    double error;        /* of any separation along a unit axis: pose, support point, product and sum */
    double deviation;    /* of a plus of b: only upper bounds need it */
    narrow_shell *shell; /* where a search for the depth of hulls leaves its surface; may be NULL */
    vec3 apart_along;    /* the axis along which a remembered pair was apart; zero if it was not, or is new */
    bool remembers;      /* the pair was asked about before: a search need not propose features */
    effort *effort;      /* what is left of the query's effort; NULL if it is not counted */
    double excess;       /* how far points that hulls were made of may lie outside of them; for lower bounds only */
} unit_pair;

/* The stopping criteria of a search, as lengths between cores. */
typedef struct narrow_goal {
    double tolerance; /* width that is narrow enough, before `error` is added on both sides */
    double finest;    /* width below which rounding decides: always enough */
    double far;       /* a lower bound above it is enough */
    double near;      /* an upper bound at or below it is enough; -INFINITY when a measure is asked for */
    double above; /* the verdict: an interval that is narrow enough must also be above this, or at or below `below` */
    double below; /* INFINITY when no verdict is asked for */
    bool brief;   /* narrow_request.brief */
} narrow_goal;

static inline bool narrow_goal_reached(const narrow_goal *g, double lo, double hi)
{
    bool decided = lo > g->above || hi <= g->below;
    return hi - lo <= (decided ? g->tolerance : g->finest) || lo > g->far || hi <= g->near;
}

/* As a share of the pair's size. For a looser tolerance rough_depth is tried before a search for the depth begins. */
#define ROUGH_TOLERANCE 0x1p-2

/* The answer about two cores. `lo` and `hi` are as computed: `unit_pair.error` is not yet in them. */
typedef struct span {
    double lo, hi;
    vec3 axis, point_a, point_b;
    narrow_method method;
    uint32_t iterations;
    narrow_features nearest; /* counts of 0, unless GJK proposes or features.h answered */
} span;

/* Raises the lower bound to the separation along a unit axis, if that is greater. */
static inline void span_raise_lower(span *s, double separation, vec3 axis)
{
    if (!(separation > s->lo)) return;
    s->lo = separation;
    s->axis = axis;
}

/* The distance of the two points across the axis: 0 if they face each other along it. */
static inline double span_aside(const span *s)
{
    vec3 line = vec_sub(s->point_b, s->point_a);
    return vec_norm(vec_madd(line, -vec_dot(line, s->axis), s->axis));
}

static inline bool shape_is_plane(const shape *s)
{
    return s->type == SHAPE_HALFSPACE;
}

/* The half sides or half axes of a core: zero for a sphere, the segment's half length for a capsule. */
static inline vec3 shape_core_half(const shape *s)
{
    if (s->type == SHAPE_SPHERE) return VEC_ZERO;
    return s->type == SHAPE_CAPSULE ? vec(0, 0, s->half.z) : s->half;
}

static inline bool shape_has_rim(const shape *s)
{
    return s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE;
}

/* A point of the Minkowski difference B - A, and the two points it is made of. */
typedef struct minkowski {
    vec3 w, a, b;
    vec3 b_local;                /* b in B's frame: unlike b not rounded */
    uint32_t vertex_a, vertex_b; /* of two hulls, or a box and a hull: which they are */
} minkowski;

/* A box's corners by number: bit k is set at the high side of axis k. */
static inline vec3 box_corner(vec3 half, uint32_t i)
{
    return vec(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
}

/* The least power of two above the largest number of a pair (1 when all are zero), and its inverse: both finite and
 * normal. */
static inline void unit_of(double largest, double *unit, double *scale)
{
    int exponent = largest > 0 ? exponent_above(largest) : 0;
    exponent = exponent < -UNIT_EXPONENT_MAX ? -UNIT_EXPONENT_MAX : exponent;
    exponent = exponent > UNIT_EXPONENT_MAX ? UNIT_EXPONENT_MAX : exponent;
    *unit = power_of_two(exponent);
    *scale = power_of_two(-exponent);
}

#define LEAST_NUMBER 0x1p-1074
#define LEAST_EXACT_UNIT 0x1p-900 /* with a smaller one bounds may become subnormal */

/* With a smaller unit this is added to the error. A hull's vertex is chosen by its coordinates as they were given; if
 * these are subnormal, each of the three products is off by half of the least number. */
#define LEAST_ERROR (8 * LEAST_NUMBER)

/* unit_pair.error of a pair of that size. A separation is dot(n, b - a): the pose may be off by 9 u of position and
 * rotation (product of two rounded quaternions, whatever quat_settled lets pass, and the matrix made of it), a support
 * point by 4 u, difference, product and sum by 3 u. */
static inline double unit_error(double size)
{
    return 16 * UNIT_ROUNDOFF * size;
}

void unit_pair_init(unit_pair *p, const shape *a, const shape *b, const pose *b_in_a);

/* The cores' points with the greatest dot(direction, x); B's in A's frame. Never for half-spaces. */
vec3 unit_pair_support_a(const unit_pair *p, vec3 direction, uint32_t *hint);
vec3 unit_pair_support_b(const unit_pair *p, vec3 direction, uint32_t *hint);

/* The vertices of hulls that were the last support points; the next search starts there. Hints change the time of a
 * search, never its answer. */
typedef struct support_hints {
    uint32_t a, b;
} support_hints;
static const support_hints NO_HINTS = {UINT32_MAX, UINT32_MAX};

/* What both support points cost, in units of effort. */
int64_t unit_pair_support_price(const unit_pair *p);

/* The point of B - A with the least dot(axis, w): the separation along a unit axis is dot(axis, w). */
void unit_pair_nearest_to(const unit_pair *p, vec3 axis, support_hints *hints, minkowski *out); /* written in place */
minkowski unit_pair_nearest_from(const unit_pair *p, vec3 axis, support_hints *hints);
minkowski unit_pair_nearest_along(const unit_pair *p, vec3 axis); /* without hints */

/* narrow_separation for a pair that unit_pair_init has prepared. */
double unit_pair_separation(const unit_pair *p, vec3 axis, uint32_t *hint_a, uint32_t *hint_b);

/* Some unit vector orthogonal to `v`, chosen by its least component. */
vec3 vec_unit_orthogonal(vec3 v);

/* ==== order ==== */

/* Three-way comparisons behind the canonical order of a pair. */

/* By type, sizes, radius, and the vertices of hulls or the children of compounds; 0 when equal. */
int order_shapes(const shape *a, const shape *b);

/* By position, then orientation: unchanged when both are shifted by a representable vector. */
int order_poses(pose a, pose b);

#endif
