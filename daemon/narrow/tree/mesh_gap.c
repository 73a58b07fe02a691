/* The distance of surfaces by branch and bound, and containment by winding numbers. Pure; any thread. */
#include "mesh_pair.h"
#include "mesh_walk.h"
#include "narrow/convex/gjk.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/core.h"

/* ---- mesh part ---- */

/* The distance of the two parts that a walk visits. Two triangles by the nearest points of their edges or of a corner
 * and a face, where these answer; otherwise the search of gjk.c, for a triangle of which all corners are in A's frame,
 * and another or a convex core. */

enum { ITERATIONS_MAX = 128, STALLS_MAX = 16 };

/* Share of the size: while the bounds are farther apart than this, it goes on without coming nearer. Of triangles that
 * are parallel to the other but for 1e-9 the points are the nearest to the last bit long before the axis is: an axis
 * that is off by x costs lo x, and the points by which it is found x^2. */
static const double STALLED = 0x1p-38;

static vec3 mesh_gap_corner_along(const vec3 p[3], vec3 d)
{
    double h0 = vec_dot(d, p[0]), h1 = vec_dot(d, p[1]), h2 = vec_dot(d, p[2]);
    return h0 >= h1 ? (h0 >= h2 ? p[0] : p[2]) : (h1 >= h2 ? p[1] : p[2]);
}

static minkowski nearest_along(const mesh_walk *w, vec3 axis)
{
    minkowski m = {.b_local = VEC_ZERO};
    m.a = w->ma ? mesh_gap_corner_along(w->spot_a->corner, axis) : core_support(&w->whole_a, w->part.scale, axis, NULL);
    m.b = mesh_gap_corner_along(w->spot_b->corner, vec_neg(axis));
    m.w = vec_sub(m.b, m.a);
    return m;
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
static bool mesh_gap_advance(const mesh_walk *w, simplex *s, span *best, vec3 *axis, int *stalls)
{
    s->count++;
    nearest_feature n = simplex_reduce(s);
    if (n.inside) {
        simplex_lower_upper(s, 0, best);
        return false;
    }
    bool decreased = n.norm < best->hi || best->iterations == 1;
    if (n.norm < best->hi) simplex_lower_upper(s, n.norm, best);
    *axis = n.axis;
    bool goes_on = decreased || (best->hi - best->lo > STALLED * w->part.size && ++*stalls <= STALLS_MAX);
    if (best->hi > 8 * UNIT_ROUNDOFF * w->part.size && goes_on) return true;
    span_raise_lower(best, vec_dot(n.axis, nearest_along(w, n.axis).w), n.axis);
    return false;
}

/* As gjk_distance, from what belongs to the parts alone (w->lead, w->from, w->edges): so the answer about two parts
 * does not depend on which others were looked at before. */
static void mesh_part_distance(const mesh_walk *w, const narrow_goal *goal, span *best)
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
        span_raise_lower(best, vec_dot(axis, m->w), axis);
        if (best->iterations == 1) {
            best->hi = vec_norm(m->w);
            best->point_a = m->a;
            best->point_b = m->b;
        }
        if (narrow_goal_reached(goal, best->lo, best->hi) || simplex_has(&s, m->w) ||
            !mesh_gap_advance(w, &s, best, &axis, &stalls))
            break;
    }
}

/* ---- mesh held ---- */

/* Components that are inside of a solid, by one point of each.
 *
 * A mesh may be a hundred thousand loose triangles: where a box around many of them is nowhere near the solid's
 * surface, all of these are on one side of it, and one point decides for all. So only components near the surface,
 * compared with how far they are from each other, are asked one by one. */

#define MESH_NOT_HELD UINT32_MAX
#define MESH_HELD_UNKNOWN (UINT32_MAX - 1) /* the effort of the query ended */

enum { FEW = MESH_LEAF_MAX }; /* components that are rather asked each than by a box */

typedef struct held_search {
    const mesh_walk *w;
    const mesh *m, *solid;
    bool of_a;
} held_search;

/* A point of a component, in A's frame and units of the pair. */
static vec3 mesh_component_point(const mesh_walk *w, bool of_a, uint32_t component)
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

static bool mesh_gap_is_inside(const held_search *q, uint32_t component)
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
        if (mesh_gap_is_inside(q, i)) return i;
    }
    return MESH_NOT_HELD;
}

/* Of the components from `first` to `end`, which are all that begin below the node. As deep as the tree. */
static uint32_t search_held(const held_search *q, uint32_t node, uint32_t first, uint32_t end)
{
    const mesh_node *n = &q->m->nodes[node];
    if (end - first <= FEW) return ask_each(q, first, end);
    for (uint32_t i = 0, next; i < n->used; i++, first = next) {
        next = i + 1 < n->used ? component_from(q->m, first, end, first_triangle(q->m, node, i + 1)) : end;
        bool few = next - first <= FEW, clear = !few && mesh_walk_is_clear(q->w, q->of_a, node, i);
        uint32_t held = few || n->count[i] > 0 || clear ? ask_each(q, first, clear ? first + 1 : next)
                                                        : search_held(q, n->first[i], first, next);
        if (held != MESH_NOT_HELD) return held;
    }
    return MESH_NOT_HELD;
}

/* No surface is within rounding of the other. The first component of B (`of_a`: of A) in the order of its mesh that is
 * inside of the other, whatever the walk is aimed at and within; it is moved to where it is, and forgets its axis.
 * Or one of the two above. */
static uint32_t mesh_held_component(mesh_walk *w, bool of_a)
{
    const held_search q = {w, of_a ? w->ma : w->mb, of_a ? w->mb : w->ma, of_a};
    if (!q.solid->solid) return MESH_NOT_HELD;
    if (q.m->component_count > FEW) {
        mesh_walk_move(w, w->part.b_in_a.t);
        w->within = 0;
    }
    return search_held(&q, 0, 0, q.m->component_count);
}

/* ---- mesh gap ---- */

/* Shares of the size: by which even a search that stalls may be wrong; the widest bracket of two parts. */
static const double SURE = 0x1p-34, COARSEST = 0x1p-20;
/* Cosine: an axis that is so near to the one in use leaves out no more than it does. */
static const double SAME_AXIS = 1 - 0x1p-20;

typedef struct nearest_search {
    const narrow_goal *goal;
    narrow_goal part;
    double margin;
    mesh_gap *best;
    double least; /* lower bound of all parts that were looked at */
    bool ended;   /* before all were: it touches, or is as near as was asked */
} nearest_search;

/* The nearest; of two that are as near, the one that the meshes name first, so that the order does not matter. */
static bool is_nearer(const mesh_walk *w, const mesh_gap *best, double hi)
{
    if (hi != best->nearest.hi) return hi < best->nearest.hi;
    if (w->triangle_a != best->triangle_a) return w->triangle_a < best->triangle_a;
    return w->triangle_b < best->triangle_b;
}

static bool mesh_gap_nearer(mesh_walk *w, void *context)
{
    nearest_search *q = context;
    span s, *best = &q->best->nearest;
    q->part.far = w->within + 2 * w->part.error;
    mesh_part_distance(w, &q->part, &s);
    if (w->effort) effort_spend(w->effort, s.iterations * (int64_t)(w->ma ? EFFORT_PART_STEP : EFFORT_CORE_STEP));
    if (s.lo > q->part.far) return true;
    q->least = min_of(q->least, s.lo);
    if (!is_nearer(w, q->best, s.hi)) return true;
    *best = s;
    q->best->triangle_a = w->triangle_a;
    q->best->triangle_b = w->triangle_b;
    w->within = min_of(w->within, s.hi + q->margin);
    if (s.lo > 0 && !(vec_dot(s.axis, w->axis) > SAME_AXIS)) mesh_walk_aim(w, s.axis);
    q->ended = best->hi <= w->part.error || best->hi <= q->goal->near;
    return !q->ended;
}

/* What is left out is farther than the nearest by more than the bracket of any two parts is wide, so that it could not
 * have changed the answer. Then the answer depends on the poses alone: not on the order of the walk, nor on what was
 * left out by what was known before. (Of 2.4 million parts that tests measured none had a bracket wider than that,
 * except those that touch: there the walk ends early, and is begun again without what was known.) */
static void set_goal(const mesh_walk *w, const narrow_goal *goal, nearest_search *q)
{
    bool flat = w->ma || w->whole_a.type == SHAPE_BOX || w->whole_a.type == SHAPE_HULL ||
                w->whole_a.type == SHAPE_CAPSULE || w->whole_a.type == SHAPE_SPHERE;
    q->part = *goal;
    q->part.tolerance = flat ? goal->finest : min_of(goal->tolerance, COARSEST * w->part.size);
    q->margin = 2 * q->part.tolerance + SURE * w->part.size;
}

/* The parts that were the nearest before: within their distance are those that are now. False: they are not there, or
 * are so near that the walk may end anywhere. */
static bool begin_with(mesh_walk *w, const mesh_seed *seed, const nearest_search *q)
{
    span s;
    narrow_goal measure = q->part;
    uint32_t i = seed->triangle_a, k = seed->triangle_b;
    if (k >= w->mb->triangle_count || (w->ma && i >= w->ma->triangle_count)) return false;
    mesh_leaf_visit_alone(w, i, k);
    measure.far = INFINITY;
    mesh_part_distance(w, &measure, &s);
    if (!(s.lo > w->part.error)) return false;
    double within = s.hi + q->margin + 2 * w->part.error;
    if (within < w->within) mesh_walk_aim(w, s.axis);
    w->within = min_of(w->within, within);
    return true;
}

/* The effort of a walk must not depend on what the pair remembers. So a walk that begins with remembered triangles is
 * not counted, and is only made if it is certain that a walk without them would end, too: because there are few pairs
 * of leaves, or few below the boxes that are as near as the first parts. If that is not certain, nothing remembered is
 * used, and the walk is counted. (A search for a depth, or for a part of a compound, remembers nothing, and is always
 * counted.) */
static double leaves_uncounted(const mesh_walk *w)
{
    int parts = w->ma ? MESH_LEAF_MAX * MESH_LEAF_MAX * EFFORT_PART_STEP : MESH_LEAF_MAX * EFFORT_CORE;
    return (double)EFFORT_UNCOUNTED / (EFFORT_NODES + EFFORT_LEAVES + parts);
}

/* Returns true if the walk began with the seed. */
static bool mesh_gap_search(
    mesh_walk *w, const narrow_goal *goal, const mesh_seed *seed, nearest_search *q, mesh_gap *out)
{
    mesh_front front;
    effort *counted = w->part.effort;
    *q = (nearest_search){.goal = goal, .best = out, .least = INFINITY};
    *out = (mesh_gap){.nearest = {.lo = -INFINITY, .hi = INFINITY, .method = NARROW_BY_GJK},
        .triangle_a = MESH_NO_TRIANGLE,
        .triangle_b = MESH_NO_TRIANGLE};
    set_goal(w, goal, q);
    mesh_walk_move(w, w->part.b_in_a.t);
    w->effort = counted && counted->counts ? counted : NULL;
    w->unseen = INFINITY;
    double leaves = leaves_uncounted(w);
    bool few = mesh_walk_leaves(w) <= leaves, seeded = few && seed && begin_with(w, seed, q);
    if (!seeded && !mesh_walk_plunge(w, mesh_gap_nearer, q)) return false;
    bool is_short = !few && mesh_walk_is_short(w, leaves, &front);
    if (is_short) seeded = seed && begin_with(w, seed, q);
    if (!few && !is_short) w->effort = counted;
    mesh_walk_nearest(w, is_short ? &front : NULL, mesh_gap_nearer, q);
    return seeded;
}

/* ---- containment ---- */

/* A point of a convex core, in A's frame. */
static vec3 point_of_core(const mesh_walk *w)
{
    bool hull = w->whole_a.type == SHAPE_HULL;
    return hull ? vec_scale(hull_vertex(w->whole_a.hull, 0), w->part.scale) : VEC_ZERO;
}

/* No surface is within rounding of the other: so any one point decides for a core or a component of a mesh, and its own
 * rounding does not matter. What is inside of a convex core crosses it: its inside is a part like its surface. */
static void find_held(mesh_walk *w, mesh_gap *out)
{
    out->relation = MESH_APART;
    if (w->ma) {
        bool of_a = true;
        out->component = mesh_held_component(w, of_a);
        if (out->component == MESH_NOT_HELD) out->component = mesh_held_component(w, of_a = false);
        if (out->component == MESH_NOT_HELD) return;
        out->cut |= out->component == MESH_HELD_UNKNOWN;
        out->relation = out->cut ? MESH_CROSSING : of_a ? MESH_HOLDS_A : MESH_HOLDS_B;
    } else if (w->mb->solid) {
        vec3 in_b = transform_point(&w->a_in_b, point_of_core(w));
        if (mesh_inside(w->mb, vec_scale(in_b, w->part.unit))) out->relation = MESH_HOLDS_A;
    }
}

/* Of a mesh of several components the nearest may be another than the one that is held: a point of that one is at least
 * as deep, and gives the translation out. */
static void measure_held(const mesh_walk *w, const narrow_goal *goal, mesh_gap *out)
{
    bool of_a = out->relation == MESH_HOLDS_A;
    const mesh *held = of_a ? w->ma : w->mb;
    if (!held || held->component_count == 1) return;
    const shape spot = {.type = SHAPE_SPHERE};
    vec3 point = mesh_component_point(w, of_a, out->component);
    unit_pair p = w->part;
    narrow_goal measure = *goal;
    mesh_walk inner;
    nearest_search q;
    mesh_gap found;
    measure.far = INFINITY;
    measure.near = -INFINITY;
    p.a = spot;
    p.b = of_a ? w->whole_b : w->whole_a;
    if (!of_a) p.b_in_a = pose_transform(POSE_IDENTITY);
    p.b_in_a.t = vec_sub(p.b_in_a.t, point);
    mesh_walk_init(&inner, &p, &spot, &p.b);
    mesh_gap_search(&inner, &measure, NULL, &q, &found);
    span *s = &found.nearest;
    s->lo = q.ended ? -INFINITY : min_of(min_of(q.least, inner.unseen), s->hi);
    if (!(s->lo > w->part.error)) return;
    s->iterations = out->nearest.iterations;
    s->point_a = vec_add(s->point_a, point);
    s->point_b = vec_add(s->point_b, point);
    if (!of_a) {
        vec3 point_a = s->point_b;
        s->axis = vec_neg(s->axis);
        s->point_b = s->point_a;
        s->point_a = point_a;
    }
    out->nearest = *s;
}

void mesh_gap_find(mesh_walk *w, const narrow_goal *goal, const mesh_seed *seed, mesh_gap *out)
{
    nearest_search q;
    bool seeded = mesh_gap_search(w, goal, seed, &q, out);
    if (q.ended && seeded) mesh_gap_search(w, goal, NULL, &q, out); /* where it ended depends on the way */
    span *s = &out->nearest;
    s->lo = q.ended ? -INFINITY : min_of(min_of(q.least, w->unseen), s->hi);
    out->cut = w->unseen < INFINITY;
    w->effort = w->part.effort;
    out->relation = MESH_CROSSING;
    if (s->lo <= w->part.error) return;
    find_held(w, out);
    if (out->relation >= MESH_HOLDS_A) measure_held(w, goal, out);
}
