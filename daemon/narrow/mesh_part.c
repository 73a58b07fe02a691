/* Two triangles by the nearest points of their edges or of a corner and a face, where these answer; otherwise the
 * search of gjk.c, for a triangle of which all corners are in A's frame, and another or a convex core. Pure; any
 * thread. */
#include "mesh_part.h"

#include "core.h"
#include "scalar.h"
#include "simplex.h"

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
