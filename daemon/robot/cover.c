/* cover: see cover.h. */
#include "cover.h"

#include "geom/bounds.h"
#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"

#include <stdlib.h>

/* Relative to a ball's distance from its frame's origin and its radius: some forty roundoffs each. */
#define GROWTH 0x1p-45

typedef struct points {
    ARRAY(vec3) array;
} points;

/* The centre of a ball around points: Badoiu and Clarkson's walk towards the farthest one, which is within 1 / sqrt(n)
 * of the best after n steps. */
static cover_ball ball_around(const vec3 *p, size_t count)
{
    enum { STEPS = 24 };
    vec3 lo = p[0], hi = p[0];
    for (size_t i = 1; i < count; i++) lo = vec_min(lo, p[i]), hi = vec_max(hi, p[i]);
    cover_ball best = {vec_scale(vec_add(lo, hi), 0.5), INFINITY};
    vec3 centre = best.centre;
    for (int step = 1; step <= STEPS; step++) {
        size_t far = 0;
        double far2 = -1;
        for (size_t i = 0; i < count; i++) {
            double d2 = vec_norm2(vec_sub(p[i], centre));
            if (d2 > far2) far2 = d2, far = i;
        }
        if (sqrt(far2) < best.radius) best = (cover_ball){centre, sqrt(far2)};
        centre = vec_madd(centre, 1.0 / (step + 1), vec_sub(p[far], centre));
    }
    return best;
}

static void put(const cover_ball *ball, double rounding, const transform *at, cover *out)
{
    double radius = ball->radius + rounding;
    vec3 centre = transform_point(at, ball->centre);
    radius += GROWTH * (radius + vec_norm(ball->centre) + vec_norm(centre));
    array_push(out, ((cover_ball){centre, radius}));
}

#define COVER_FINENESS 2.0

/* How many slabs make balls that are little wider than the shape. */
static int slabs_of(double length, double width)
{
    double n = width > 0 ? ceil(COVER_FINENESS * length / width) : COVER_SLABS_MAX;
    return n < 1 ? 1 : n > COVER_SLABS_MAX ? COVER_SLABS_MAX : (int)n;
}

static double component(vec3 v, int axis)
{
    return axis == 0 ? v.x : axis == 1 ? v.y : v.z;
}

static vec3 unit_vector(int axis, double length)
{
    return vec(axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0);
}

/* The part of an edge between two planes: its ends that are there, and where it meets them. */
static void clip_edge(vec3 a, vec3 b, int axis, double low, double high, points *p)
{
    double u = component(a, axis), v = component(b, axis);
    if (u >= low && u <= high) array_push(&p->array, a);
    if (v >= low && v <= high) array_push(&p->array, b);
    const double planes[] = {low, high};
    for (int k = 0; k < 2; k++)
        if ((u < planes[k]) != (v < planes[k]) && u != v)
            array_push(&p->array, vec_madd(a, (planes[k] - u) / (v - u), vec_sub(b, a)));
}

typedef struct edges { /* pairs of points */
    ARRAY(vec3) ends;
} edges;

static void cover_edges(const edges *e, double rounding, const transform *at, cover *out)
{
    vec3 lo = e->ends.at[0], hi = lo;
    for (size_t i = 1; i < e->ends.count; i++) lo = vec_min(lo, e->ends.at[i]), hi = vec_max(hi, e->ends.at[i]);
    vec3 size = vec_sub(hi, lo);
    int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    double length = component(size, axis);
    double width = sqrt(vec_norm2(size) - length * length);
    int slabs = slabs_of(length, width);
    double first = component(lo, axis);
    points p = {0};
    for (int k = 0; k < slabs; k++) {
        /* Neighbours share their plane's value, so nothing lies between; the last one ends where the shape does. */
        double low = first + length * k / slabs,
               high = k + 1 < slabs ? first + length * (k + 1) / slabs : component(hi, axis);
        p.array.count = 0;
        for (size_t i = 0; i + 1 < e->ends.count; i += 2)
            clip_edge(e->ends.at[i], e->ends.at[i + 1], axis, low, high, &p);
        if (p.array.count == 0) continue;
        cover_ball ball = ball_around(p.array.at, p.array.count);
        put(&ball, rounding, at, out);
    }
    array_free(&p.array);
}

static void cover_hull(const hull *h, double rounding, const transform *at, cover *out)
{
    edges e = {0};
    if (h->edge_count > 0) {
        for (uint32_t i = 0; i < h->edge_count; i++) {
            array_push(&e.ends, hull_vertex(h, h->edges[i].v0));
            array_push(&e.ends, hull_vertex(h, h->edges[i].v1));
        }
    } else { /* flat: all pairs would do, and so do those with one vertex and one ball */
        for (uint32_t i = 0; i < h->vertex_count; i++) array_push(&e.ends, hull_vertex(h, i));
        cover_ball ball = ball_around(e.ends.at, e.ends.count);
        put(&ball, rounding + h->excess, at, out);
        array_free(&e.ends);
        return;
    }
    cover_edges(&e, rounding + h->excess, at, out);
    array_free(&e.ends);
}

static void cover_mesh(const mesh *m, double rounding, const transform *at, cover *out)
{
    edges e = {0};
    for (uint32_t i = 0; i < m->triangle_count; i++)
        for (int k = 0; k < 3; k++) {
            array_push(&e.ends, mesh_corner(m, i, k));
            array_push(&e.ends, mesh_corner(m, i, (k + 1) % 3));
        }
    cover_edges(&e, rounding, at, out);
    array_free(&e.ends);
}

/* The greatest distance from the z-axis of a capsule's, cylinder's, cone's or ellipsoid's core between two heights. */
static double girth(const shape *s, double low, double high)
{
    double r = fmax(s->half.x, s->half.y);
    switch (s->type) {
    case SHAPE_CAPSULE:
        return 0;
    case SHAPE_CONE:
        return s->half.z > 0 ? r * (s->half.z - low) / (2 * s->half.z) : r;
    case SHAPE_ELLIPSOID: {
        double h = low <= 0 && high >= 0 ? 0 : fmin(fabs(low), fabs(high));
        double part = s->half.z > 0 ? fmin(1, h / s->half.z) : 0;
        return r * sqrt(1 - part * part) * (1 + 0x1p-40);
    }
    default:
        return r;
    }
}

static void cover_revolved(const shape *s, const transform *at, cover *out)
{
    double r = s->type == SHAPE_CAPSULE ? 0 : fmax(s->half.x, s->half.y), h = s->half.z;
    int slabs = slabs_of(2 * h + 2 * s->radius, 2 * (r + s->radius));
    for (int k = 0; k < slabs; k++) {
        double low = -h + 2 * h * k / slabs, high = k + 1 < slabs ? -h + 2 * h * (k + 1) / slabs : h;
        double middle = 0.5 * (low + high), half = fmax(high - middle, middle - low), wide = girth(s, low, high);
        cover_ball ball = {vec(0, 0, middle), sqrt(half * half + wide * wide)};
        put(&ball, s->radius, at, out);
    }
}

static void cover_box(const shape *s, const transform *at, cover *out)
{
    vec3 h = s->half;
    int axis = h.x >= h.y && h.x >= h.z ? 0 : h.y >= h.z ? 1 : 2;
    double length = component(h, axis), width = sqrt(fmax(0, vec_norm2(h) - length * length));
    int slabs = slabs_of(length + s->radius, width + s->radius);
    for (int k = 0; k < slabs; k++) {
        double low = -length + 2 * length * k / slabs;
        double high = k + 1 < slabs ? -length + 2 * length * (k + 1) / slabs : length;
        double middle = 0.5 * (low + high), half = fmax(high - middle, middle - low);
        cover_ball ball = {unit_vector(axis, middle), sqrt(half * half + width * width)};
        put(&ball, s->radius, at, out);
    }
}

/* Of what has very many edges, which the tick's thread has no time to go through: by the box around it. */
static void cover_bounds(const shape *s, pose at, cover *out)
{
    shape core = *s;
    core.radius = 0;
    aabb b = shape_bounds(&core, POSE_IDENTITY);
    vec3 middle = vec_scale(vec_add(b.lo, b.hi), 0.5), half = vec_scale(vec_sub(b.hi, b.lo), 0.5 * (1 + GROWTH));
    shape box = {.type = SHAPE_BOX, .half = half, .radius = s->radius + GROWTH * vec_max_abs(middle)};
    transform t = pose_transform(pose_mul(at, (pose){middle, {1, 0, 0, 0}}));
    cover_box(&box, &t, out);
}

static bool has_many_edges(const shape *s)
{
    return (s->type == SHAPE_HULL && s->hull->edge_count > COVER_EDGES_MAX) ||
           (s->type == SHAPE_MESH && s->mesh->triangle_count > COVER_EDGES_MAX);
}

bool cover_shape(const shape *s, pose at, cover *out)
{
    if (has_many_edges(s)) {
        cover_bounds(s, at, out);
        return true;
    }
    transform t = pose_transform(at);
    switch (s->type) {
    case SHAPE_HALFSPACE:
        return false;
    case SHAPE_SPHERE: {
        cover_ball ball = {VEC_ZERO, 0};
        put(&ball, s->radius, &t, out);
        return true;
    }
    case SHAPE_BOX:
        cover_box(s, &t, out);
        return true;
    case SHAPE_HULL:
        cover_hull(s->hull, s->radius, &t, out);
        return true;
    case SHAPE_MESH:
        cover_mesh(s->mesh, s->radius, &t, out);
        return true;
    case SHAPE_COMPOUND:
        for (uint32_t i = 0; i < s->compound->child_count; i++) {
            const compound_child *child = &s->compound->children[i];
            shape part = child->shape;
            part.radius += s->radius;
            if (!cover_shape(&part, pose_mul(at, child->local), out)) return false;
        }
        return true;
    default:
        cover_revolved(s, &t, out);
        return true;
    }
}

cover_ball cover_whole(const cover_ball *balls, size_t count)
{
    vec3 centre = balls[0].centre;
    double best = INFINITY;
    vec3 at = centre;
    for (int step = 1; step <= 128; step++) {
        size_t far = 0;
        double radius = -1;
        for (size_t i = 0; i < count; i++) {
            double d = vec_norm(vec_sub(balls[i].centre, at)) + balls[i].radius;
            if (d > radius) radius = d, far = i;
        }
        if (radius < best) best = radius, centre = at;
        at = vec_madd(at, 1.0 / (step + 1), vec_sub(balls[far].centre, at));
    }
    return (cover_ball){centre, best * (1 + GROWTH) + GROWTH * vec_norm(centre)};
}
