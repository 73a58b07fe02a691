/* The walk over one or two hierarchies, nearest first. Pure; any thread.
 *
 * What is left out is left out by proof: boxes are rounded outward, and FLOAT_SLACK takes back what the arithmetic of
 * floats may have added to a bound. */
#include "mesh_walk.h"

#include "core.h"
#include "geom/mesh_simd.h"

/* u_float = 2^-24. A bound of mesh_bounds is made of less than 60 terms, none greater than the mesh's unit and the
 * other's reach together, and each is off by less than 4 u_float of that. */
#define FLOAT_SLACK 0x1p-16
/* Boxes of meshes lie within 1 of the origin; floats are of no use for what reaches beyond this. */
#define FLOAT_FAR 0x1p40

enum { WHOLE = UINT32_MAX, STACK = 2 * MESH_DEPTH_MAX * (MESH_WIDTH - 1) + MESH_WIDTH * MESH_WIDTH, HEAP = 512 };

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
        vec3 v = mesh_corner(m, triangle, k % 3);
        t->x[k] = v.x;
        t->y[k] = v.y;
        t->z[k] = v.z;
    }
}

/* A box that is turned, in units of the pair. */
typedef struct turned_box {
    vec3 centre, side[3];
} turned_box;

static double sum_abs(vec3 v)
{
    return fabs(v.x) + fabs(v.y) + fabs(v.z);
}

static void put(float to[3], vec3 v)
{
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
}

static turned_box turned_by(const transform *t, const turned_box *b)
{
    return (turned_box){transform_point(t, b->centre),
        {mat_mul(t->r, b->side[0]), mat_mul(t->r, b->side[1]), mat_mul(t->r, b->side[2])}};
}

/* The box, in the frame of a node, in the node's unit. */
static void face(const turned_box *b, double size, mesh_other *o)
{
    vec3 centre = vec_scale(b->centre, 1 / size);
    double reach = sum_abs(centre);
    for (int k = 0; k < 3; k++) {
        vec3 side = vec_scale(b->side[k], 1 / size);
        reach += sum_abs(side);
        put(o->side[k], side);
    }
    put(o->centre, centre);
    o->far = !(reach < FLOAT_FAR);
    o->slack = (float)(FLOAT_SLACK * (4 + reach));
}

static double extent_of(const mesh_walk *w, vec3 d)
{
    return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
}

/* The box of a convex A as B's nodes see it. */
static void box_whole(mesh_walk *w)
{
    vec3 half = vec_scale(vec_sub(w->whole.hi, w->whole.lo), 0.5);
    turned_box box = {vec_add(w->whole.lo, half), {vec(half.x, 0, 0), vec(0, half.y, 0), vec(0, 0, half.z)}};
    turned_box there = turned_by(&w->a_in_b, &box);
    face(&there, w->size_b, &w->whole_other);
    w->whole_other.flat = false;
}

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
    vec3 x = p->b_in_a.r.x, y = p->b_in_a.r.y, z = p->b_in_a.r.z;
    w->a_in_b.r = (mat3){{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
    mesh_walk_move(w, p->b_in_a.t);
}

void mesh_walk_move(mesh_walk *w, vec3 position)
{
    w->part.b_in_a.t = position;
    w->a_in_b.t = vec_neg(mat_mul(w->a_in_b.r, position));
    w->within = INFINITY;
    w->axis = w->axis_in_b = VEC_ZERO;
    w->whole.level = 0;
    w->aims++;
    w->triangle_a = w->triangle_b = MESH_NO_TRIANGLE;
    if (!w->ma) box_whole(w);
}

void mesh_walk_aim(mesh_walk *w, vec3 axis)
{
    w->axis = axis;
    w->axis_in_b = mat_tmul(w->part.b_in_a.r, axis);
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

static vec3 normal_of(const mesh *m, box_ref r)
{
    const mesh_node *n = &m->nodes[r.node];
    return vec(n->normal[0][r.child], n->normal[1][r.child], n->normal[2][r.child]);
}

static turned_box box_of(const mesh *m, box_ref r, double size)
{
    const mesh_node *n = &m->nodes[r.node];
    turned_box b;
    uint32_t c = r.child;
    b.centre = vec_scale(vec(n->centre[0][c], n->centre[1][c], n->centre[2][c]), size);
    for (int k = 0; k < 2; k++) b.side[k] = vec_scale(vec(n->side[k][0][c], n->side[k][1][c], n->side[k][2][c]), size);
    b.side[2] = vec_scale(vec(n->normal[0][c], n->normal[1][c], n->normal[2][c]), size * (double)n->half[c]);
    return b;
}

/* The greatest height of a box along `d`, in its frame. */
static double top_of(const turned_box *b, vec3 d)
{
    return vec_dot(d, b->centre) + fabs(vec_dot(d, b->side[0])) + fabs(vec_dot(d, b->side[1])) +
           fabs(vec_dot(d, b->side[2]));
}

static bool has_axis(const mesh_walk *w)
{
    return w->axis.x != 0 || w->axis.y != 0 || w->axis.z != 0;
}

/* How far the boxes of a node are beyond `level` along the axis, both in the node's frame: in doubles. */
static void bounds_along(const mesh *m, uint32_t node, vec3 axis, double level, double size, double out[MESH_WIDTH])
{
    for (uint32_t i = 0; i < m->nodes[node].used; i++) {
        turned_box box = box_of(m, (box_ref){node, i}, size);
        out[i] = -top_of(&box, vec_neg(axis)) - level;
    }
}

/* `axis` and `level` in the node's frame, which `other` is in. Without an axis there is nothing above any level. */
static void bounds_of(const mesh_walk *w, const mesh *m, uint32_t node, mesh_other *o, vec3 axis, double level,
    double size, double out[MESH_WIDTH])
{
    float bounds[MESH_WIDTH];
    if (!has_axis(w)) level = INFINITY;
    if (o->far) {
        bounds_along(m, node, axis, level, size, out);
    } else {
        put(o->axis, axis);
        o->level = (float)(level / size);
        mesh_bounds(&m->nodes[node], o, bounds);
        for (int i = 0; i < m->nodes[node].used; i++) out[i] = (double)bounds[i] * size;
    }
    for (int i = 0; i < m->nodes[node].used; i++) out[i] -= w->part.error;
}

static void bounds_below_b(const mesh_walk *w, box_ref a, uint32_t node, double out[MESH_WIDTH])
{
    mesh_other o = w->whole_other;
    double level = w->whole.level;
    if (a.node != WHOLE) {
        turned_box box = box_of(w->ma, a, w->size_a), there = turned_by(&w->a_in_b, &box);
        face(&there, w->size_b, &o);
        o.flat = true;
        put(o.normal, mat_mul(w->a_in_b.r, normal_of(w->ma, a)));
        level = top_of(&box, w->axis);
    }
    bounds_of(w, w->mb, node, &o, w->axis_in_b, level - vec_dot(w->axis, w->part.b_in_a.t), w->size_b, out);
}

static void bounds_below_a(const mesh_walk *w, uint32_t node, box_ref b, double out[MESH_WIDTH])
{
    mesh_other o;
    turned_box box = box_of(w->mb, b, w->size_b), here = turned_by(&w->part.b_in_a, &box);
    face(&here, w->size_a, &o);
    o.flat = true;
    put(o.normal, mat_mul(w->part.b_in_a.r, normal_of(w->mb, b)));
    bounds_of(w, w->ma, node, &o, vec_neg(w->axis), top_of(&here, vec_neg(w->axis)), w->size_a, out);
}

/* ---- the walk ---- */

/* The boxes of a node that are near enough, beside a box of the other shape; the nearest comes last. */
static uint32_t sorted_last(entry *more, uint32_t count)
{
    for (uint32_t i = 1; i < count; i++)
        for (uint32_t k = i; k > 0 && more[k].bound > more[k - 1].bound; k--) {
            entry e = more[k];
            more[k] = more[k - 1];
            more[k - 1] = e;
        }
    return count;
}

static uint32_t expand_b(const mesh_walk *w, box_ref a, uint32_t node, entry more[MESH_WIDTH])
{
    double bounds[MESH_WIDTH];
    uint32_t count = 0;
    bounds_below_b(w, a, node, bounds);
    for (uint32_t i = 0; i < w->mb->nodes[node].used; i++)
        if (!(bounds[i] > w->within)) more[count++] = (entry){a, {node, i}, bounds[i]};
    return sorted_last(more, count);
}

static uint32_t expand_a(const mesh_walk *w, uint32_t node, box_ref b, entry more[MESH_WIDTH])
{
    double bounds[MESH_WIDTH];
    uint32_t count = 0;
    bounds_below_a(w, node, b, bounds);
    for (uint32_t i = 0; i < w->ma->nodes[node].used; i++)
        if (!(bounds[i] > w->within)) more[count++] = (entry){{node, i}, b, bounds[i]};
    return sorted_last(more, count);
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
    const vec3 *p = s->corner;
    s->lo = least_of(least_of(p[0], p[1]), p[2]);
    s->hi = most_of(most_of(p[0], p[1]), p[2]);
    s->normal = vec_cross(vec_sub(p[1], p[0]), vec_sub(p[2], p[0]));
}

static double outside(double lo_a, double hi_a, double lo_b, double hi_b)
{
    return max_of(max_of(lo_b - hi_a, lo_a - hi_b), 0);
}

/* Along a direction of any length, one way or the other. */
static bool is_far_along(const mesh_walk *w, vec3 u)
{
    vec3 between = vec_sub(vec_add(w->spot_b->lo, w->spot_b->hi), vec_add(w->spot_a->lo, w->spot_a->hi));
    if (vec_dot(u, between) < 0) u = vec_neg(u);
    double gap = mesh_walk_foot_b(w, u) - mesh_walk_top_a(w, u), within = w->within + 2 * w->part.error;
    return gap > 0 && gap * gap > within * within * vec_norm2(u);
}

/* Along the axis, by their boxes, or along the directions of mesh_bounds, in doubles. */
static bool is_far(const mesh_walk *w)
{
    const mesh_spot *a = w->spot_a, *b = w->spot_b;
    double within = w->within + 2 * w->part.error;
    if (b->level - a->level > within) return true;
    double x = outside(a->lo.x, a->hi.x, b->lo.x, b->hi.x), y = outside(a->lo.y, a->hi.y, b->lo.y, b->hi.y),
           z = outside(a->lo.z, a->hi.z, b->lo.z, b->hi.z);
    if (x * x + y * y + z * z > within * within) return true;
    if (!(w->within < INFINITY)) return false;
    return is_far_along(w, vec_sub(vec_add(b->lo, b->hi), vec_add(a->lo, a->hi))) || is_far_along(w, b->normal) ||
           (w->ma && is_far_along(w, a->normal));
}

static uint32_t spots_of(const mesh *m, box_ref r, double scale, const transform *to_a, mesh_spot *out)
{
    const mesh_node *n = &m->nodes[r.node];
    for (uint32_t i = 0; i < n->count[r.child]; i++) {
        for (int k = 0; k < 3; k++) {
            vec3 v = vec_scale(mesh_corner(m, n->first[r.child] + i, k), scale);
            out[i].corner[k] = to_a ? transform_point(to_a, v) : v;
        }
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
    for (uint32_t k = 0; w->ma && k < l.count_a; k++) set_box(&l.a[k]);
    for (uint32_t i = 0; i < l.count_b; i++) {
        set_box(&l.b[i]);
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

static double size_of(const mesh *m, box_ref r, double size)
{
    const mesh_node *n = &m->nodes[r.node];
    float sum = 0;
    for (int k = 0; k < 3; k++) sum += n->hi[k][r.child] - n->lo[k][r.child];
    return (double)sum * size;
}

/* A or B: the larger of two boxes is opened. */
static bool opens_a(const mesh_walk *w, const entry *e)
{
    if (is_leaf(w->ma, e->a)) return false;
    if (is_leaf(w->mb, e->b)) return true;
    return size_of(w->ma, e->a, w->size_a) > size_of(w->mb, e->b, w->size_b);
}

static uint32_t expand(const mesh_walk *w, const entry *e, entry more[MESH_WIDTH])
{
    return opens_a(w, e) ? expand_a(w, w->ma->nodes[e->a.node].first[e->a.child], e->b, more)
                         : expand_b(w, e->a, w->mb->nodes[e->b.node].first[e->b.child], more);
}

static bool is_leaves(const mesh_walk *w, const entry *e)
{
    return is_leaf(w->ma, e->a) && is_leaf(w->mb, e->b);
}

/* All below one pair of boxes, depth first. False: enough. */
static bool run_below(mesh_walk *w, const entry *top, mesh_visit *visit, void *context)
{
    entry stack[STACK];
    uint32_t open = 0;
    stack[open++] = *top;
    while (open) {
        entry e = stack[--open];
        if (e.bound > w->within) continue;
        if (!is_leaves(w, &e))
            open += expand(w, &e, stack + open);
        else if (!visit_leaves(w, &e, visit, context))
            return false;
    }
    return true;
}

/* The pairs of boxes to begin with. */
static uint32_t start(const mesh_walk *w, entry first[MESH_WIDTH * MESH_WIDTH])
{
    uint32_t count = 0;
    if (!w->ma) return expand_b(w, (box_ref){WHOLE, 0}, 0, first);
    for (uint32_t i = 0; i < w->ma->nodes[0].used; i++) count += expand_b(w, (box_ref){0, i}, 0, first + count);
    return count;
}

void mesh_walk_run(mesh_walk *w, mesh_visit *visit, void *context)
{
    entry first[MESH_WIDTH * MESH_WIDTH];
    uint32_t count = start(w, first);
    while (count)
        if (!run_below(w, &first[--count], visit, context)) return;
}

/* ---- nearest first: a heap, the nearest on top ---- */

static void heap_push(entry *heap, uint32_t *count, entry e)
{
    uint32_t at = (*count)++;
    for (; at && heap[(at - 1) / 2].bound > e.bound; at = (at - 1) / 2) heap[at] = heap[(at - 1) / 2];
    heap[at] = e;
}

static entry heap_pop(entry *heap, uint32_t *count)
{
    entry top = heap[0], last = heap[--*count];
    uint32_t at = 0;
    for (uint32_t k; (k = 2 * at + 1) < *count; at = k) {
        if (k + 1 < *count && heap[k + 1].bound < heap[k].bound) k++;
        if (!(heap[k].bound < last.bound)) break;
        heap[at] = heap[k];
    }
    heap[at] = last;
    return top;
}

void mesh_walk_nearest(mesh_walk *w, mesh_visit *visit, void *context)
{
    entry heap[HEAP], more[MESH_WIDTH * MESH_WIDTH];
    uint32_t open = 0, count = start(w, more);
    while (count) heap_push(heap, &open, more[--count]);
    while (open) {
        entry e = heap_pop(heap, &open);
        if (e.bound > w->within) return;
        bool full = open + MESH_WIDTH > HEAP, leaves = is_leaves(w, &e);
        if (leaves ? !visit_leaves(w, &e, visit, context) : full && !run_below(w, &e, visit, context)) return;
        if (leaves || full) continue;
        count = expand(w, &e, more);
        while (count) heap_push(heap, &open, more[--count]);
    }
}
