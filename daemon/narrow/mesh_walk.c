/* The walk over one or two hierarchies, nearest first. Pure; any thread.
 *
 * What is left out is left out by proof: boxes are rounded outward, and FLOAT_SLACK takes back what the arithmetic of
 * floats may have added to a bound. */
#include "mesh_walk.h"

#include "core.h"
#include "geom/mesh_simd.h"

#include <float.h>

/* A squared distance is off by less than 8 u_float of itself; a height by less than 100 u_float of the boxes' unit: its
 * terms are at most 2 and there are less than 20. */
#define FLOAT_SLACK 0x1p-17
/* Boxes of meshes lie within 1 of the origin; what is farther away than this counts as being just so far. */
#define FLOAT_FAR 0x1p40

enum { WHOLE = UINT32_MAX, STACK = 2 * MESH_DEPTH_MAX * (MESH_WIDTH - 1) + MESH_WIDTH * MESH_WIDTH };

/* A box of a mesh: a child of a node. The root's own children stand for the root. */
typedef struct box_ref {
    uint32_t node, child; /* node WHOLE: all of a convex A */
} box_ref;

typedef struct entry {
    box_ref a, b;
    double bound;
} entry;

static void wear(triangle_part *t, shape *s)
{
    t->hull =
        (hull){.vertex_count = 3, .padded_count = TRIANGLE_PADDED, .x = t->x, .y = t->y, .z = t->z, .dimension = 2};
    *s = (shape){.type = SHAPE_HULL, .radius = s->radius, .hull = &t->hull};
}

static void put_on(triangle_part *t, const mesh *m, uint32_t triangle)
{
    for (int k = 0; k < TRIANGLE_PADDED; k++) {
        vec3 v = mesh_corner(m, triangle, k < 3 ? k : 2);
        t->x[k] = v.x;
        t->y[k] = v.y;
        t->z[k] = v.z;
    }
}

static float float_down(double x)
{
    float f = (float)clamp_to(x, FLOAT_FAR);
    return f - fabsf(f) * 0x1p-22f - FLT_MIN;
}

static float float_up(double x)
{
    return -float_down(-x);
}

/* The box of a convex A in B's frame. */
static void box_whole(mesh_walk *w)
{
    const transform *t = &w->part.b_in_a;
    const vec3 rows[3] = {t->r.x, t->r.y, t->r.z};
    for (int k = 0; k < 3; k++) {
        vec3 d = rows[k];
        double at = vec_dot(d, t->t), error = w->part.error;
        double top = vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
        double foot = vec_dot(d, core_support(&w->whole_a, w->part.scale, vec_neg(d), NULL));
        w->box_lo[k] = float_down((foot - at - error) / w->size_b);
        w->box_hi[k] = float_up((top - at + error) / w->size_b);
    }
}

static double extent_of(const mesh_walk *w, vec3 d)
{
    return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
}

/* The box of a convex A in its own frame. */
static void spot_whole(mesh_walk *w)
{
    const vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    w->whole.hi = vec(extent_of(w, x), extent_of(w, y), extent_of(w, z));
    w->whole.lo = vec(-extent_of(w, vec_neg(x)), -extent_of(w, vec_neg(y)), -extent_of(w, vec_neg(z)));
}

void mesh_walk_init(mesh_walk *w, const unit_pair *p, const shape *a, const shape *b)
{
    w->part = *p;
    w->whole_a = p->a;
    w->whole_b = p->b;
    w->ma = a->type == SHAPE_MESH ? a->mesh : NULL;
    w->mb = b->mesh;
    w->size_a = w->ma ? w->ma->unit * p->scale : 0;
    w->size_b = w->mb->unit * p->scale;
    w->visits = w->aims = 0;
    if (w->ma)
        wear(&w->flat_a, &w->part.a);
    else
        spot_whole(w);
    wear(&w->flat_b, &w->part.b);
    mesh_walk_move(w, p->b_in_a.t);
}

void mesh_walk_move(mesh_walk *w, vec3 position)
{
    w->part.b_in_a.t = position;
    w->within = INFINITY;
    w->axis = VEC_ZERO;
    w->whole.level = 0;
    w->aims++;
    w->triangle_a = w->triangle_b = MESH_NO_TRIANGLE;
    if (!w->ma) box_whole(w);
}

void mesh_walk_aim(mesh_walk *w, vec3 axis)
{
    w->axis = axis;
    w->aims++;
    if (!w->ma) w->whole.level = extent_of(w, axis);
}

double mesh_walk_top_a(const mesh_walk *w, vec3 d)
{
    if (!w->ma) return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
    double top = -INFINITY;
    for (int k = 0; k < 3; k++) top = max_of(top, vec_dot(d, w->spot_a->corner[k]));
    return top;
}

double mesh_walk_foot_b(const mesh_walk *w, vec3 d)
{
    double foot = INFINITY;
    for (int k = 0; k < 3; k++) foot = min_of(foot, vec_dot(d, w->spot_b->corner[k]));
    return foot;
}

/* ---- bounds ---- */

typedef struct middle_box { /* in units of the pair */
    vec3 centre, half;
} middle_box;

static middle_box box_of(const mesh *m, box_ref r, double size)
{
    const mesh_node *n = &m->nodes[r.node];
    double lo[3], hi[3];
    for (int k = 0; k < 3; k++) {
        lo[k] = 0.5 * size * (double)n->lo[k][r.child];
        hi[k] = 0.5 * size * (double)n->hi[k][r.child];
    }
    return (middle_box){{hi[0] + lo[0], hi[1] + lo[1], hi[2] + lo[2]}, {hi[0] - lo[0], hi[1] - lo[1], hi[2] - lo[2]}};
}

static vec3 abs_mul(vec3 x, vec3 y, vec3 z, vec3 h) /* |x| h.x + |y| h.y + |z| h.z, coordinate by coordinate */
{
    return vec(fabs(x.x) * h.x + fabs(y.x) * h.y + fabs(z.x) * h.z, fabs(x.y) * h.x + fabs(y.y) * h.y + fabs(z.y) * h.z,
        fabs(x.z) * h.x + fabs(y.z) * h.y + fabs(z.z) * h.z);
}

static double reach_along(middle_box b, vec3 d) /* of the box beyond its centre */
{
    return fabs(d.x) * b.half.x + fabs(d.y) * b.half.y + fabs(d.z) * b.half.z;
}

/* The greatest height of what is in a box of a mesh along `d`, in the mesh's frame: see mesh_heights. */
static double top_of(const mesh *m, box_ref r, middle_box b, double size, vec3 d)
{
    const mesh_node *n = &m->nodes[r.node];
    vec3 normal = {n->normal[0][r.child], n->normal[1][r.child], n->normal[2][r.child]};
    double share = vec_dot(d, normal), by_box = vec_dot(d, b.centre) + reach_along(b, d);
    if (!(share > 0)) return by_box;
    vec3 rest = vec_madd(d, -share, normal);
    return min_of(by_box, share * size * (double)n->top[r.child] + vec_dot(rest, b.centre) + reach_along(b, rest));
}

static void to_floats(middle_box b, double error, double unit, float lo[3], float hi[3])
{
    const double c[3] = {b.centre.x, b.centre.y, b.centre.z}, h[3] = {b.half.x, b.half.y, b.half.z};
    for (int k = 0; k < 3; k++) {
        lo[k] = float_down((c[k] - h[k] - error) / unit);
        hi[k] = float_up((c[k] + h[k] + error) / unit);
    }
}

/* Lower bounds of the distances between the children of a node and the box [lo, hi], which is in the node's frame and
 * unit; and along `direction` (in the node's frame), seen from a plane at `level`. */
static void bounds_of(const mesh_node *n, const float lo[3], const float hi[3], vec3 direction, double level,
    double size, double error, double out[MESH_WIDTH])
{
    float distances2[MESH_WIDTH], heights[MESH_WIDTH];
    const float d[3] = {(float)direction.x, (float)direction.y, (float)direction.z};
    mesh_distances2(n, lo, hi, distances2);
    mesh_heights(n, d, heights);
    for (int i = 0; i < n->used; i++) {
        double apart = sqrt((double)distances2[i]) * (1 - FLOAT_SLACK) * size;
        double along = ((double)heights[i] - FLOAT_SLACK) * size - level - error;
        out[i] = max_of(apart, along);
    }
}

static bool has_axis(const mesh_walk *w)
{
    return w->axis.x != 0 || w->axis.y != 0 || w->axis.z != 0;
}

/* Without an axis the level is one that nothing is above. */
static void bounds_below_b(const mesh_walk *w, box_ref a, const mesh_node *n, double out[MESH_WIDTH])
{
    const transform *t = &w->part.b_in_a;
    vec3 d = mat_tmul(t->r, w->axis);
    double level = INFINITY, error = w->part.error;
    if (a.node == WHOLE) {
        if (has_axis(w)) level = w->whole.level - vec_dot(w->axis, t->t);
        bounds_of(n, w->box_lo, w->box_hi, d, level, w->size_b, error, out);
        return;
    }
    float lo[3], hi[3];
    middle_box box = box_of(w->ma, a, w->size_a);
    if (has_axis(w)) level = top_of(w->ma, a, box, w->size_a, w->axis) - vec_dot(w->axis, t->t);
    vec3 rx = {t->r.x.x, t->r.y.x, t->r.z.x}, ry = {t->r.x.y, t->r.y.y, t->r.z.y}, rz = {t->r.x.z, t->r.y.z, t->r.z.z};
    middle_box there = {mat_tmul(t->r, vec_sub(box.centre, t->t)), abs_mul(rx, ry, rz, box.half)};
    to_floats(there, error, w->size_b, lo, hi);
    bounds_of(n, lo, hi, d, level, w->size_b, error, out);
}

static void bounds_below_a(const mesh_walk *w, const mesh_node *n, box_ref b, double out[MESH_WIDTH])
{
    const transform *t = &w->part.b_in_a;
    double level = INFINITY, error = w->part.error;
    float lo[3], hi[3];
    middle_box box = box_of(w->mb, b, w->size_b);
    middle_box here = {transform_point(t, box.centre), abs_mul(t->r.x, t->r.y, t->r.z, box.half)};
    if (has_axis(w))
        level = top_of(w->mb, b, box, w->size_b, mat_tmul(t->r, vec_neg(w->axis))) - vec_dot(w->axis, t->t);
    to_floats(here, error, w->size_a, lo, hi);
    bounds_of(n, lo, hi, vec_neg(w->axis), level, w->size_a, error, out);
}

/* ---- the walk ---- */

/* Of the boxes of one node the nearest comes on top. */
static uint32_t push_sorted(entry *stack, uint32_t open, entry *more, int count)
{
    for (int i = 1; i < count; i++)
        for (int k = i; k > 0 && more[k].bound > more[k - 1].bound; k--) {
            entry e = more[k];
            more[k] = more[k - 1];
            more[k - 1] = e;
        }
    for (int i = 0; i < count; i++) stack[open++] = more[i];
    return open;
}

static uint32_t expand_b(const mesh_walk *w, entry *stack, uint32_t open, box_ref a, uint32_t node)
{
    const mesh_node *n = &w->mb->nodes[node];
    double bounds[MESH_WIDTH];
    entry more[MESH_WIDTH];
    int count = 0;
    bounds_below_b(w, a, n, bounds);
    for (uint32_t i = 0; i < n->used; i++)
        if (!(bounds[i] > w->within)) more[count++] = (entry){a, {node, i}, bounds[i]};
    return push_sorted(stack, open, more, count);
}

static uint32_t expand_a(const mesh_walk *w, entry *stack, uint32_t open, uint32_t node, box_ref b)
{
    const mesh_node *n = &w->ma->nodes[node];
    double bounds[MESH_WIDTH];
    entry more[MESH_WIDTH];
    int count = 0;
    bounds_below_a(w, n, b, bounds);
    for (uint32_t i = 0; i < n->used; i++)
        if (!(bounds[i] > w->within)) more[count++] = (entry){{node, i}, b, bounds[i]};
    return push_sorted(stack, open, more, count);
}

/* ---- leaves ---- */

static vec3 least_of(vec3 a, vec3 b)
{
    return vec(min_of(a.x, b.x), min_of(a.y, b.y), min_of(a.z, b.z));
}
static vec3 most_of(vec3 a, vec3 b)
{
    return vec(max_of(a.x, b.x), max_of(a.y, b.y), max_of(a.z, b.z));
}

static void set_box(mesh_spot *s)
{
    s->lo = least_of(least_of(s->corner[0], s->corner[1]), s->corner[2]);
    s->hi = most_of(most_of(s->corner[0], s->corner[1]), s->corner[2]);
}

static double outside(double lo_a, double hi_a, double lo_b, double hi_b)
{
    return max_of(max_of(lo_b - hi_a, lo_a - hi_b), 0);
}

/* By their boxes, or along the axis, in doubles. */
static bool is_far(const mesh_walk *w)
{
    const mesh_spot *a = w->spot_a, *b = w->spot_b;
    double x = outside(a->lo.x, a->hi.x, b->lo.x, b->hi.x), y = outside(a->lo.y, a->hi.y, b->lo.y, b->hi.y),
           z = outside(a->lo.z, a->hi.z, b->lo.z, b->hi.z), within = w->within + 2 * w->part.error;
    return x * x + y * y + z * z > within * within || b->level - a->level > within;
}

static uint32_t spots_of(const mesh *m, box_ref r, double scale, const transform *to_a, mesh_spot *out)
{
    const mesh_node *n = &m->nodes[r.node];
    for (uint32_t i = 0; i < n->count[r.child]; i++) {
        for (int k = 0; k < 3; k++) {
            vec3 v = vec_scale(mesh_corner(m, n->first[r.child] + i, k), scale);
            out[i].corner[k] = to_a ? transform_point(to_a, v) : v;
        }
        set_box(&out[i]);
    }
    return n->count[r.child];
}

typedef struct leaf_pair {
    mesh_spot a[MESH_LEAF_MAX], b[MESH_LEAF_MAX];
    uint32_t count_a, count_b, aims; /* aims: of the axis that the levels are for */
} leaf_pair;

static double level_of(const mesh_spot *s, vec3 axis, double sign)
{
    double level = -INFINITY;
    for (int k = 0; k < 3; k++) level = max_of(level, sign * vec_dot(axis, s->corner[k]));
    return sign * level;
}

/* Is there a triangle of B that is not beyond all of A along the axis? Without an axis all levels are 0. */
static bool set_levels(const mesh_walk *w, leaf_pair *l)
{
    double top = w->ma ? -INFINITY : w->whole.level, foot = INFINITY;
    for (uint32_t k = 0; w->ma && k < l->count_a; k++) {
        l->a[k].level = level_of(&l->a[k], w->axis, 1);
        top = max_of(top, l->a[k].level);
    }
    for (uint32_t i = 0; i < l->count_b; i++) {
        l->b[i].level = level_of(&l->b[i], w->axis, -1);
        foot = min_of(foot, l->b[i].level);
    }
    l->aims = w->aims;
    return !(foot - top > w->within + 2 * w->part.error);
}

static bool visit_pair(mesh_walk *w, mesh_visit *visit, void *context)
{
    if (is_far(w)) return true;
    put_on(&w->flat_b, w->mb, w->triangle_b);
    if (w->ma) put_on(&w->flat_a, w->ma, w->triangle_a);
    w->visits++;
    return visit(w, context);
}

static bool visit_leaves(mesh_walk *w, const entry *e, mesh_visit *visit, void *context)
{
    leaf_pair l;
    l.count_b = spots_of(w->mb, e->b, w->part.scale, &w->part.b_in_a, l.b);
    l.count_a = w->ma ? spots_of(w->ma, e->a, w->part.scale, NULL, l.a) : 1;
    if (!set_levels(w, &l)) return true;
    for (uint32_t i = 0; i < l.count_b; i++) {
        w->spot_b = &l.b[i];
        w->triangle_b = w->mb->nodes[e->b.node].first[e->b.child] + i;
        for (uint32_t k = 0; k < l.count_a; k++) {
            w->spot_a = w->ma ? &l.a[k] : &w->whole;
            if (w->ma) w->triangle_a = w->ma->nodes[e->a.node].first[e->a.child] + k;
            if (!visit_pair(w, visit, context)) return false;
            if (l.aims != w->aims) (void)set_levels(w, &l);
        }
    }
    return true;
}

static bool is_leaf(const mesh *m, box_ref r)
{
    return r.node == WHOLE || m->nodes[r.node].count[r.child] > 0;
}

static double volume_like(middle_box b)
{
    return b.half.x + b.half.y + b.half.z;
}

/* A or B: the larger of two boxes is opened. */
static bool opens_a(const mesh_walk *w, const entry *e)
{
    if (is_leaf(w->ma, e->a)) return false;
    if (is_leaf(w->mb, e->b)) return true;
    return volume_like(box_of(w->ma, e->a, w->size_a)) > volume_like(box_of(w->mb, e->b, w->size_b));
}

void mesh_walk_run(mesh_walk *w, mesh_visit *visit, void *context)
{
    entry stack[STACK];
    uint32_t open = 0;
    if (w->ma)
        for (uint32_t i = 0; i < w->ma->nodes[0].used; i++) open = expand_b(w, stack, open, (box_ref){0, i}, 0);
    else
        open = expand_b(w, stack, open, (box_ref){WHOLE, 0}, 0);
    while (open) {
        entry e = stack[--open];
        if (e.bound > w->within) continue;
        if (is_leaf(w->ma, e.a) && is_leaf(w->mb, e.b)) {
            if (!visit_leaves(w, &e, visit, context)) return;
        } else if (opens_a(w, &e)) {
            open = expand_a(w, stack, open, w->ma->nodes[e.a.node].first[e.a.child], e.b);
        } else {
            open = expand_b(w, stack, open, e.a, w->mb->nodes[e.b.node].first[e.b.child]);
        }
    }
}
