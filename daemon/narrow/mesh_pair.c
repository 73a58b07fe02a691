/* Pairs with a mesh: the surfaces' distance decides, unless they overlap. Pure; any thread. */
#include "mesh_pair.h"

#include "core.h"
#include "gjk.h"
#include "mesh_depth.h"
#include "scalar.h"
#include "simplex.h"

/* ---- mesh part ---- */

/* Two triangles by the nearest points of their edges or of a corner and a face, where these answer; otherwise the
 * search of gjk.c, for a triangle of which all corners are in A's frame, and another or a convex core. */

enum { ITERATIONS_MAX = 128, STALLS_MAX = 16 };

/* Share of the size: while the bounds are farther apart than this, it goes on without coming nearer. Of triangles that
 * are parallel to the other but for 1e-9 the points are the nearest to the last bit long before the axis is: an axis
 * that is off by x costs lo x, and the points by which it is found x^2. */
static const double STALLED = 0x1p-38;

static vec3 corner_along(const vec3 p[3], vec3 d)
{
    double h0 = vec_dot(d, p[0]), h1 = vec_dot(d, p[1]), h2 = vec_dot(d, p[2]);
    return h0 >= h1 ? (h0 >= h2 ? p[0] : p[2]) : (h1 >= h2 ? p[1] : p[2]);
}

static minkowski nearest_along(const mesh_walk *w, vec3 axis)
{
    minkowski m = {.b_local = VEC_ZERO};
    m.a = w->ma ? corner_along(w->spot_a->corner, axis) : core_support(&w->whole_a, w->part.scale, axis, NULL);
    m.b = corner_along(w->spot_b->corner, vec_neg(axis));
    m.w = vec_sub(m.b, m.a);
    return m;
}

static bool known(const simplex *s, vec3 w)
{
    for (int i = 0; i < s->count; i++)
        if (s->v[i].w.x == w.x && s->v[i].w.y == w.y && s->v[i].w.z == w.z) return true;
    return false;
}

static void raise_lower(span *best, double separation, vec3 axis)
{
    if (!(separation > best->lo)) return;
    best->lo = separation;
    best->axis = axis;
}

static void lower_upper(span *best, double norm, const simplex *s)
{
    best->hi = norm;
    simplex_witness(s, &best->point_a, &best->point_b);
}

/* ---- two triangles, where the nearest points are known ---- */

/* Do the nearest points of the two edges answer? Their own distance is the upper bound, how far the line between them
 * parts the triangles the lower. */
static bool edges_answer(const mesh_walk *w, const narrow_goal *goal, span *best)
{
    double norm2 = vec_norm2(w->edges);
    if (!(norm2 > 0x1p-900)) return false;
    best->hi = sqrt(norm2);
    best->axis = vec_scale(w->edges, 1 / best->hi);
    best->lo = mesh_walk_foot_b(w, best->axis) - mesh_walk_top_a(w, best->axis);
    best->point_a = w->from;
    best->point_b = vec_add(w->from, w->edges);
    return narrow_goal_reached(goal, best->lo, best->hi);
}

static bool is_normal(vec3 u, vec3 normal)
{
    vec3 back = vec_neg(normal);
    return (u.x == normal.x && u.y == normal.y && u.z == normal.z) || (u.x == back.x && u.y == back.y && u.z == back.z);
}

/* From a corner to the point of a face that is beside it; false: there is none. */
static bool to_face(vec3 corner, const mesh_spot *face, vec3 *to)
{
    vec3 p = vec_sub(face->corner[0], corner), q = vec_sub(face->corner[1], corner);
    vec3 r = vec_sub(face->corner[2], corner), n = face->normal;
    double of_p = vec_dot(n, vec_cross(q, r)), of_q = vec_dot(n, vec_cross(r, p)), of_r = vec_dot(n, vec_cross(p, q));
    double whole = 1 / (of_p + of_q + of_r);
    if (!(of_p > 0 && of_q > 0 && of_r > 0)) return false;
    *to = vec_madd(vec_madd(vec_scale(p, of_p * whole), of_q * whole, q), of_r * whole, r);
    return true;
}

/* Does a face answer? Where a normal is what parts them most, and the nearest corner along it is beside the face. */
static bool face_answers(const mesh_walk *w, const narrow_goal *goal, span *best)
{
    bool of_b = is_normal(w->lead, w->spot_b->normal);
    vec3 to;
    if (!of_b && !is_normal(w->lead, w->spot_a->normal)) return false;
    best->axis = direction_of(w->lead);
    minkowski m = nearest_along(w, best->axis);
    best->lo = vec_dot(best->axis, m.w);
    if (!to_face(of_b ? m.a : m.b, of_b ? w->spot_b : w->spot_a, &to)) return false;
    best->hi = vec_norm(to);
    best->point_a = of_b ? m.a : vec_add(m.b, to);
    best->point_b = of_b ? vec_add(m.a, to) : m.b;
    return narrow_goal_reached(goal, best->lo, best->hi);
}

/* ---- the search ---- */

/* As in gjk.c, but for stalls. */
static bool advance(const mesh_walk *w, simplex *s, span *best, vec3 *axis, int *stalls)
{
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        lower_upper(best, 0, s);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) lower_upper(best, n.norm, s);
    *axis = n.axis;
    bool goes_on = decreased || (best->hi - best->lo > STALLED * w->part.size && ++*stalls <= STALLS_MAX);
    if (best->hi > 8 * UNIT_ROUNDOFF * w->part.size && goes_on) return true;
    raise_lower(best, vec_dot(n.axis, nearest_along(w, n.axis).w), n.axis);
    return false;
}

void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *best)
{
    simplex s = {.count = 0};
    *best = (span){.lo = -INFINITY, .hi = INFINITY, .method = NARROW_BY_GJK, .iterations = 1};
    if (w->ma && (edges_answer(w, goal, best) || face_answers(w, goal, best))) return;
    int stalls = 0;
    vec3 axis = direction_of(w->lead);
    if (!(vec_norm2(axis) > 0)) axis = vec(1, 0, 0);
    best->lo = -INFINITY;
    best->hi = INFINITY;
    for (best->iterations = 1; best->iterations <= ITERATIONS_MAX; best->iterations++) {
        minkowski *m = &s.v[s.count];
        *m = nearest_along(w, axis);
        raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) {
            best->hi = vec_norm(m->w);
            best->point_a = m->a;
            best->point_b = m->b;
        }
        if (narrow_goal_reached(goal, best->lo, best->hi) || known(&s, m->w) || !advance(w, &s, best, &axis, &stalls))
            break;
    }
}

/* ---- mesh held ---- */

/* Components that are inside of a solid, by one point of each.
 *
 * A mesh may be a hundred thousand loose triangles: where a box around many of them is nowhere near the solid's
 * surface, all of these are on one side of it, and one point tells for all. So only components near the surface,
 * compared with how far they are from each other, are asked one by one. */

enum { FEW = MESH_LEAF_MAX }; /* components that are rather asked each than by a box */

typedef struct held_search {
    const mesh_walk *w;
    const mesh *m, *solid;
    bool of_a;
} held_search;

vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component)
{
    const mesh *m = of_a ? w->ma : w->mb;
    vec3 own = vec_scale(m->corners[3 * (size_t)m->components[component].triangle], w->part.scale);
    return of_a ? own : transform_point(&w->part.b_in_a, own);
}

double mesh_component_width(const mesh_walk *w, bool of_a, uint32_t component, vec3 direction)
{
    const mesh *m = of_a ? w->ma : w->mb;
    const mesh_component *c = &m->components[component];
    vec3 d = of_a ? direction : mat_tmul(w->part.b_in_a.r, direction);
    vec3 extent = vec(
        (double)c->hi[0] - (double)c->lo[0], (double)c->hi[1] - (double)c->lo[1], (double)c->hi[2] - (double)c->lo[2]);
    return (fabs(d.x) * extent.x + fabs(d.y) * extent.y + fabs(d.z) * extent.z) * m->unit * w->part.scale;
}

static bool is_inside(const held_search *q, uint32_t component)
{
    vec3 own = vec_scale(q->m->corners[3 * (size_t)q->m->components[component].triangle], q->w->part.scale);
    vec3 there = transform_point(q->of_a ? &q->w->a_in_b : &q->w->part.b_in_a, own);
    return mesh_inside(q->solid, vec_scale(there, q->w->part.unit));
}

/* The first of those from `first` to `end` that begins at a triangle or after it; `end`: none does. */
static uint32_t component_from(const mesh *m, uint32_t first, uint32_t end, uint32_t triangle)
{
    while (first < end) {
        uint32_t middle = first + (end - first) / 2;
        if (m->components[middle].triangle < triangle)
            first = middle + 1;
        else
            end = middle;
    }
    return first;
}

static uint32_t first_triangle(const mesh *m, uint32_t node, uint32_t child)
{
    while (m->nodes[node].count[child] == 0) node = m->nodes[node].first[child], child = 0;
    return m->nodes[node].first[child];
}

static uint32_t ask_each(const held_search *q, uint32_t first, uint32_t end)
{
    for (uint32_t i = first; i < end; i++) {
        if (q->w->effort && !effort_spend(q->w->effort, EFFORT_INSIDE)) return MESH_HELD_UNKNOWN;
        if (is_inside(q, i)) return i;
    }
    return MESH_NOT_HELD;
}

/* Of the components from `first` to `end`, which are all that begin below the node. As deep as the tree. */
static uint32_t search(const held_search *q, uint32_t node, uint32_t first, uint32_t end)
{
    const mesh_node *n = &q->m->nodes[node];
    if (end - first <= FEW) return ask_each(q, first, end);
    for (uint32_t i = 0, next; i < n->used; i++, first = next) {
        next = i + 1 < n->used ? component_from(q->m, first, end, first_triangle(q->m, node, i + 1)) : end;
        bool few = next - first <= FEW, clear = !few && mesh_walk_is_clear(q->w, q->of_a, node, i);
        uint32_t held = few || n->count[i] > 0 || clear ? ask_each(q, first, clear ? first + 1 : next)
                                                        : search(q, n->first[i], first, next);
        if (held != MESH_NOT_HELD) return held;
    }
    return MESH_NOT_HELD;
}

uint32_t mesh_held_component(mesh_walk *w, bool of_a)
{
    const held_search q = {w, of_a ? w->ma : w->mb, of_a ? w->mb : w->ma, of_a};
    if (!q.solid->solid) return MESH_NOT_HELD;
    if (q.m->component_count > FEW) {
        mesh_walk_move(w, w->part.b_in_a.t);
        w->within = 0;
    }
    return search(&q, 0, 0, q.m->component_count);
}

/* ---- mesh pair ---- */

/* Triangles and boxes are brought into the other frame and back: twice the error of one pose. The hull of a mesh is no
 * part of its surface. */
void mesh_pair_prepare(unit_pair *p, const shape *a)
{
    p->error *= 2;
    p->excess = a->type == SHAPE_MESH ? 0 : shape_excess(a) * p->scale;
}

static const mesh_seed *seed_of(const narrow_cache *cache, mesh_seed *seed)
{
    if (!cache || cache->triangle_b == 0) return NULL;
    *seed = (mesh_seed){cache->triangle_a - 1, cache->triangle_b - 1};
    return seed;
}

static void remember(narrow_cache *cache, const mesh_gap *gap)
{
    if (!cache || gap->triangle_b == MESH_NO_TRIANGLE) return;
    cache->triangle_a = gap->triangle_a + 1;
    cache->triangle_b = gap->triangle_b + 1;
}

/* The effort ended before it was known whether the surfaces meet: what the convex hulls prove, along the axis that
 * parts them, or that of the nearest parts that were found. */
static void bound_by_hulls(const unit_pair *p, span *out)
{
    const narrow_goal rough = {.tolerance = 1e-3 * p->size,
        .finest = 1e-3 * p->size,
        .far = INFINITY,
        .near = 0,
        .above = -INFINITY,
        .below = INFINITY};
    unit_pair hulls = mesh_depth_hulls(p);
    gjk_result r;
    gjk_distance(&hulls, &rough, VEC_ZERO, &r);
    if (r.span.lo > 0) out->axis = r.span.axis;
    mesh_depth_rough(p, out);
}

void mesh_pair_measure(const unit_pair *p, const shape *a, const shape *b, const narrow_goal *goal, narrow_cache *cache,
    epa_scratch *scratch, union_scratch *pieces, span *out)
{
    mesh_walk w;
    mesh_gap gap;
    mesh_seed seed;
    mesh_walk_init(&w, p, a, b);
    mesh_gap_find(&w, goal, seed_of(cache, &seed), &gap);
    remember(cache, &gap);
    bool apart = gap.relation == MESH_APART && gap.nearest.lo > p->radius + p->error + p->excess;
    *out = gap.nearest;
    if (apart) return;
    if (p->effort) p->effort->counts = true; /* from here on it is a matter of shapes and poses alone */
    if (gap.cut) {
        bound_by_hulls(p, out);
        return;
    }
    if (gap.relation < MESH_HOLDS_A && gap.nearest.hi <= goal->near)
        mesh_depth_rough(p, out);
    else
        mesh_depth_find(p, &w, goal, &gap, scratch, pieces, out);
}
