/* rough_depth: bounds from a tetrahedron that holds the origin. Pure; any thread. */
#include "rough_depth.h"

#include "scalar.h"

/* Twice a face's area, of the square of the size: with less its normal is not sure enough. A normal is off by at most a
 * few roundings of the square of the size, relative to that area; so its plane by far less than the slack. */
#define LEAST_AREA 0x1p-20
#define PLANE_SLACK 0x1p-24

enum { FACES = 4 };

typedef struct face {
    vec3 out; /* unit, away from the fourth corner */
    double offset;
} face;

static bool face_of(const simplex *s, int opposite, double size, face *out)
{
    vec3 a = s->v[(opposite + 1) % FACES].w, b = s->v[(opposite + 2) % FACES].w, c = s->v[(opposite + 3) % FACES].w;
    vec3 n = triangle_normal(a, b, c);
    double norm = vec_norm(n);
    if (!(norm >= LEAST_AREA * size * size)) return false;
    double side = vec_dot(n, vec_sub(s->v[opposite].w, a)) > 0 ? -1 : 1;
    out->out = vec_scale(n, side / norm);
    out->offset = vec_dot(out->out, a);
    return true;
}

/* The point along the known axis; or, for a measure, along the best of it and of those of the faces. */
static minkowski raise_lower(const unit_pair *p, bool measured, const face *faces, span *out)
{
    support_hints hints = NO_HINTS;
    minkowski top = unit_pair_nearest_from(p, out->axis, &hints), m;
    for (int i = 0; measured && i < FACES; i++) {
        vec3 axis = vec_neg(faces[i].out);
        unit_pair_nearest_to(p, axis, &hints, &m);
        double separation = vec_dot(axis, m.w);
        if (!(separation > out->lo)) continue;
        out->lo = separation;
        out->axis = axis;
        top = m;
    }
    return top;
}

bool rough_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    face faces[FACES];
    double least = INFINITY;
    if (start->state != GJK_INSIDE || start->simplex.count < FACES) return false;
    for (int i = 0; i < FACES; i++) {
        if (!face_of(&start->simplex, i, p->size, &faces[i])) return false;
        least = min_of(least, faces[i].offset);
    }
    double inside = least - PLANE_SLACK * p->size;
    if (!(inside > 0)) return false;
    span found = *out;
    minkowski top = raise_lower(p, goal->near == -INFINITY, faces, &found);
    found.hi = max_of(-inside, found.lo);
    found.iterations += FACES;
    found.point_a = top.a;
    found.point_b = top.b;
    if (!narrow_goal_reached(goal, found.lo, found.hi)) return false;
    *out = found;
    return true;
}
