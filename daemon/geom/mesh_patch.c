/* The points that stand for each patch of a mesh: of all its vertices those few that reach outward most, and how far
 * the others may be outside of their convex hull. A box around a bent patch reaches far beyond it where a direction is
 * neither along nor across it; the points do not. Any thread; the same mesh gives the same points.
 *
 * From the leaves upward, which keep all of theirs: a patch chooses among the points of its parts, so that what these
 * leave out adds up. The choice is greedy: next comes the point that is farthest from the hull of those before it. How
 * far points are from a hull is known from above, and no hull shrinks: so only the farthest has to be measured again.
 */
#include "mesh_steps.h"

#include "base/array.h"
#include "round.h"

#include <string.h>

enum { CANDIDATES = MESH_WIDTH * MESH_PATCH_POINTS, STEPS = 8 };

/* Of the greatest distance between two points of a patch: nearer than this to the hull, a point is not worth a place.
 */
static const double NEAR_ENOUGH = 0x1p-9;
/* Points are kept as floats, in units of the mesh. */
#define POINT_ERROR 0x1p-22
/* For the rounding of the lengths here. */
#define LENGTH_MORE (1 + 0x1p-20)

typedef struct candidates {
    vec3 at[CANDIDATES];      /* in units of the mesh; those that are chosen come first */
    double away2[CANDIDATES]; /* squares of distances from the hull of the chosen, or more */
    uint32_t count, chosen;
} candidates;

static void add(candidates *c, vec3 p)
{
    p = vec((float)p.x, (float)p.y, (float)p.z);
    for (uint32_t i = 0; i < c->count; i++)
        if (vec_norm2(vec_sub(c->at[i], p)) == 0) return;
    c->away2[c->count] = INFINITY;
    c->at[c->count++] = p;
}

/* ---- how far a point is from a hull: from above ---- */

typedef struct simplex {
    vec3 corner[3]; /* of a triangle, perhaps of no area, from the point */
    vec3 nearest;   /* of it to the point */
    double norm2;
} simplex;

static vec3 nearest_of_segment(vec3 a, vec3 b)
{
    vec3 ab = vec_sub(b, a);
    double length2 = vec_norm2(ab), t = length2 > 0 ? -vec_dot(a, ab) / length2 : 0;
    return vec_madd(a, t < 0 ? 0 : t > 1 ? 1 : t, ab);
}

static void take_nearer(simplex *s, vec3 p)
{
    double norm2 = vec_norm2(p);
    if (norm2 < s->norm2) s->nearest = p, s->norm2 = norm2;
}

static simplex simplex_of(vec3 a, vec3 b, vec3 c)
{
    simplex s = {.corner = {a, b, c}, .norm2 = INFINITY};
    vec3 ab = vec_sub(b, a), ac = vec_sub(c, a);
    double bb = vec_dot(ab, ab), bc = vec_dot(ab, ac), cc = vec_dot(ac, ac), pb = -vec_dot(a, ab), pc = -vec_dot(a, ac);
    double det = bb * cc - bc * bc, v = cc * pb - bc * pc, w = bb * pc - bc * pb;
    if (det > 0x1p-40 * bb * cc && v >= 0 && w >= 0 && v + w <= det)
        take_nearer(&s, vec_madd(vec_madd(a, v / det, ab), w / det, ac));
    take_nearer(&s, nearest_of_segment(a, b));
    take_nearer(&s, nearest_of_segment(b, c));
    take_nearer(&s, nearest_of_segment(c, a));
    return s;
}

/* Any point of the hull gives a bound; the search for the nearest goes on by triangles, as far as it comes. */
static double away2_of(const candidates *c, vec3 point)
{
    vec3 first = vec_sub(c->at[0], point);
    simplex best = simplex_of(first, first, first);
    for (int step = 0; step < STEPS; step++) {
        vec3 far = first;
        double least = INFINITY;
        for (uint32_t i = 0; i < c->chosen; i++) {
            vec3 p = vec_sub(c->at[i], point);
            double height = vec_dot(best.nearest, p);
            if (height < least) least = height, far = p;
        }
        simplex found = best;
        for (int k = 0; k < 3; k++) {
            simplex s = simplex_of(best.corner[k], best.corner[(k + 1) % 3], far);
            if (s.norm2 < found.norm2) found = s;
        }
        if (!(found.norm2 < best.norm2)) break;
        best = found;
    }
    return best.norm2;
}

/* ---- the choice ---- */

static uint32_t farthest_candidate(const candidates *c)
{
    uint32_t far = c->chosen;
    for (uint32_t i = far + 1; i < c->count; i++)
        if (c->away2[i] > c->away2[far]) far = i;
    return far;
}

/* The square of the distance that is left. */
static double choose(candidates *c)
{
    double enough2 = 0;
    for (uint32_t i = 1; i < c->count; i++) enough2 = fmax(enough2, vec_norm2(vec_sub(c->at[i], c->at[0])));
    enough2 *= NEAR_ENOUGH * NEAR_ENOUGH;
    c->chosen = 1;
    while (c->chosen < c->count) {
        uint32_t far = farthest_candidate(c);
        double away2 = fmin(c->away2[far], away2_of(c, c->at[far]));
        bool still = away2 == c->away2[far];
        c->away2[far] = away2;
        if (!still && farthest_candidate(c) != far) continue;
        if (away2 <= enough2 || c->chosen == MESH_PATCH_POINTS) return away2;
        vec3 p = c->at[far];
        c->at[far] = c->at[c->chosen];
        c->away2[far] = c->away2[c->chosen];
        c->at[c->chosen++] = p;
    }
    return 0;
}

typedef struct points {
    mesh *m;
    ARRAY(mesh_patch_point) all;
} points;

static vec3 point_of(const mesh_patch_point *p, uint32_t child)
{
    return vec(p->at[0][child], p->at[1][child], p->at[2][child]);
}

static void gather_triangles(const mesh *m, const mesh_node *n, uint32_t child, candidates *c)
{
    uint32_t last = n->first[child] + n->count[child];
    for (uint32_t t = n->first[child]; t < last; t++)
        for (int k = 0; k < 3; k++) add(c, vec_scale(mesh_corner(m, t, k), 1 / m->unit));
}

static void gather_below(const points *p, const mesh_node *below, candidates *c)
{
    for (uint32_t i = 0; i < below->used; i++)
        for (uint32_t k = 0; k < below->points; k++) add(c, point_of(&p->all.at[below->first_point + k], i));
}

static double excess_below(const mesh_node *below)
{
    double most = 0;
    for (uint32_t i = 0; i < below->used; i++) most = fmax(most, (double)below->excess[i]);
    return most;
}

/* Side by side; where one child has fewer points than another, its first one stands in. */
static void keep(points *p, mesh_node *n, const candidates *c)
{
    uint32_t most = 1;
    for (uint32_t i = 0; i < n->used; i++) most = c[i].chosen > most ? c[i].chosen : most;
    n->first_point = (uint32_t)p->all.count;
    n->points = (uint8_t)most;
    for (uint32_t k = 0; k < most; k++) {
        mesh_patch_point side_by_side = {0};
        for (uint32_t i = 0; i < n->used; i++) {
            vec3 v = c[i].at[k < c[i].chosen ? k : 0];
            side_by_side.at[0][i] = (float)v.x;
            side_by_side.at[1][i] = (float)v.y;
            side_by_side.at[2][i] = (float)v.z;
        }
        array_push(&p->all, side_by_side);
    }
}

/* As deep as the tree: MESH_DEPTH_MAX. */
static void stand_for(points *p, uint32_t node)
{
    mesh_node *n = &p->m->nodes[node];
    candidates c[MESH_WIDTH];
    for (uint32_t i = 0; i < n->used; i++) {
        double excess = POINT_ERROR;
        c[i].count = 0;
        if (n->count[i]) {
            gather_triangles(p->m, n, i, &c[i]);
            c[i].chosen = c[i].count;
        } else {
            const mesh_node *below = &p->m->nodes[n->first[i]];
            stand_for(p, n->first[i]);
            gather_below(p, below, &c[i]);
            excess = excess_below(below) + sqrt(choose(&c[i])) * LENGTH_MORE;
        }
        n->excess[i] = float_above(excess);
    }
    keep(p, n, c);
}

void mesh_patches_build(mesh *m)
{
    points p = {.m = m};
    stand_for(&p, 0);
    m->patch_points = base_realloc(p.all.at, p.all.count, sizeof *p.all.at);
    m->patch_point_count = (uint32_t)p.all.count;
}
