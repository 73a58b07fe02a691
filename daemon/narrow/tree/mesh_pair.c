/* Pairs with a mesh: the surfaces' distance decides, unless they overlap. Pure; any thread. */
#include "mesh_pair.h"

#include "mesh_walk.h"
#include "narrow/contact/manifold.h"
#include "narrow/convex/gjk.h"
#include "narrow/math/scalar.h"

#include <string.h>

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

static void mesh_pair_remember(narrow_cache *cache, const mesh_gap *gap)
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
    mesh_pair_remember(cache, &gap);
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

/* ==== contact points ==== */

/* Up to four contact points over all triangles.
 *
 * Each triangle that may touch is clipped against the other shape's feature along the one axis of the answer: so no
 * triangle brings a normal of its own, and inner edges leave no mark. Which points are kept is manifold.h's choice, by
 * one walk for each. */

/* A triangle of a solid whose outward normal points away from the other shape by more than this is its far side. */
static const double FAR_SIDE = 1e-6;

/* A triangle with two faces, three edges and their neighbours, as manifold_build looks for them. The back face has
 * corners of its own, 3 to 5, so that they tell which way it was walked round. One without area is the segment that is
 * its longest side. */
typedef struct thin_hull {
    hull hull;
    hull_face faces[2];
    uint32_t loops[6], first[4], neighbours[6];
    int side; /* of a segment: from which corner of the triangle on; NO_SIDE: of a triangle */
    double x[TRIANGLE_PADDED], y[TRIANGLE_PADDED], z[TRIANGLE_PADDED];
} thin_hull;

enum { NO_SIDE = -1 };

typedef struct point_search {
    const shape *a, *b; /* in metres */
    const transform *b_in_a;
    const narrow_result *answer;
    double threshold;
    manifold_choice choice;
} point_search;

static int longest_side(const vec3 p[3])
{
    int longest = 0;
    for (int k = 1; k < 3; k++)
        if (vec_norm(vec_sub(p[(k + 1) % 3], p[k])) > vec_norm(vec_sub(p[(longest + 1) % 3], p[longest]))) longest = k;
    return longest;
}

static void segment_init(thin_hull *t, const vec3 p[3])
{
    t->side = longest_side(p);
    for (int k = 0; k < TRIANGLE_PADDED; k++) {
        vec3 v = p[k == 0 ? t->side : (t->side + 1) % 3];
        t->x[k] = v.x;
        t->y[k] = v.y;
        t->z[k] = v.z;
    }
    t->first[0] = 0, t->first[1] = 1, t->first[2] = 2;
    t->neighbours[0] = 1, t->neighbours[1] = 0;
    t->hull = (hull){.vertex_count = 2,
        .padded_count = TRIANGLE_PADDED,
        .x = t->x,
        .y = t->y,
        .z = t->z,
        .neighbour_first = t->first,
        .neighbours = t->neighbours,
        .dimension = 1};
}

static void triangle_init(thin_hull *t, const triangle_part *from, const vec3 p[3])
{
    static const uint32_t LOOPS[6] = {0, 1, 2, 3, 5, 4}, FIRST[4] = {0, 2, 4, 6}, NEIGHBOURS[6] = {1, 2, 0, 2, 0, 1};
    vec3 n = vec_unit(vec_cross(vec_unit(vec_sub(p[1], p[0])), vec_unit(vec_sub(p[2], p[0]))));
    memcpy(t->loops, LOOPS, sizeof LOOPS);
    memcpy(t->first, FIRST, sizeof FIRST);
    memcpy(t->neighbours, NEIGHBOURS, sizeof NEIGHBOURS);
    t->faces[0] = (hull_face){n, vec_dot(n, p[0]), 0, 3};
    t->faces[1] = (hull_face){vec_neg(n), -vec_dot(n, p[0]), 3, 3};
    t->hull = from->hull;
    t->hull.face_count = 2;
    t->hull.faces = t->faces;
    t->hull.face_vertices = t->loops;
    t->hull.neighbour_first = t->first;
    t->hull.neighbours = t->neighbours;
    t->side = NO_SIDE;
}

static void thin_init(thin_hull *t, const triangle_part *from, bool has_area, shape *s)
{
    vec3 p[3];
    for (int k = 0; k < 3; k++) p[k] = vec(from->x[k], from->y[k], from->z[k]);
    if (has_area)
        triangle_init(t, from, p);
    else
        segment_init(t, p);
    *s = (shape){.type = SHAPE_HULL, .radius = s->radius, .hull = &t->hull};
}

/* From the triangle's own numbering to the mesh's: faces by the triangle of the input. A side is known by the corner at
 * which it begins: on the back face, corner 3 + k, it is the one that ends there on the front. */
static uint32_t code_in_mesh(const mesh *m, uint32_t triangle, const thin_hull *thin, uint32_t code)
{
    const mesh_triangle *t = &m->triangles[triangle];
    uint32_t kind = feature_kind(code), corner = feature_index(code);
    if (kind == FEATURE_WITNESS) return code;
    if (kind == FEATURE_FACE) return feature_code(kind, t->source);
    if (thin->side != NO_SIDE && kind == FEATURE_EDGE) return feature_code(kind, t->edge[thin->side]);
    if (thin->side != NO_SIDE) return feature_code(kind, t->v[((uint32_t)thin->side + corner) % 3]);
    if (kind == FEATURE_EDGE) return feature_code(kind, t->edge[corner < 3 ? corner : (corner + 2) % 3]);
    return feature_code(kind, t->v[corner % 3]);
}

/* Is it a side of a solid that faces away from the other shape? */
static bool is_far_side(const mesh *m, const thin_hull *t, vec3 towards_other)
{
    return m->solid && t->side == NO_SIDE && vec_dot(t->faces[0].normal, towards_other) < -FAR_SIDE;
}

static bool mesh_points_clip(mesh_walk *w, void *context)
{
    point_search *q = context;
    thin_hull thin_a, thin_b;
    effort_spend(w->effort, EFFORT_CLIP);
    shape a = *q->a, b = *q->b;
    vec3 axis = q->answer->axis;
    manifold points;
    mesh_walk_dress(w);
    thin_init(&thin_b, &w->flat_b, w->mb->triangles[w->triangle_b].form == MESH_AREA, &b);
    if (is_far_side(w->mb, &thin_b, mat_tmul(q->b_in_a->r, vec_neg(axis)))) return true;
    if (w->ma) {
        thin_init(&thin_a, &w->flat_a, w->ma->triangles[w->triangle_a].form == MESH_AREA, &a);
        if (is_far_side(w->ma, &thin_a, axis)) return true;
    }
    vec3 point = q->answer->point_a;
    manifold_build(&a, &b, q->b_in_a, axis, point, vec_madd(point, MANIFOLD_NO_WITNESS, axis), q->threshold, &points);
    for (uint32_t i = 0; i < points.count; i++) {
        manifold_point *p = &points.points[i];
        uint32_t code_a = feature_code_a(p->feature), code_b = feature_code_b(p->feature);
        if (p->feature == feature_witness()) continue;
        code_b = code_in_mesh(w->mb, w->triangle_b, &thin_b, code_b);
        if (w->ma) code_a = code_in_mesh(w->ma, w->triangle_a, &thin_a, code_a);
        p->feature = feature_id(code_a, code_b);
        manifold_choice_offer(&q->choice, p);
    }
    return true;
}

void mesh_pair_manifold(const unit_pair *p, const shape *a, const shape *b, const pose *b_in_a,
    const narrow_result *answer, double threshold, manifold *out)
{
    mesh_walk w;
    transform t = pose_transform(*b_in_a);
    point_search q = {.a = a, .b = b, .b_in_a = &t, .answer = answer, .threshold = threshold};
    manifold_choice_begin(&q.choice, answer->axis, MANIFOLD_SAME_POINT * (shape_reach(a) + shape_reach(b)), false);
    mesh_walk_init(&w, p, a, b);
    int64_t left = w.effort->left, share = left / MANIFOLD_POINTS_MAX; /* each walk sees as much as the others */
    bool cut = false;
    do {
        mesh_walk_move(&w, p->b_in_a.t);
        w.within = max_of(threshold * p->scale + p->radius, 0) + 2 * p->error;
        w.effort->left = share;
        mesh_walk_run(&w, mesh_points_clip, &q);
        left -= share - w.effort->left;
        cut |= w.unseen < INFINITY;
    } while (manifold_choice_next(&q.choice));
    w.effort->left = cut ? -1 : left;
    if (q.choice.chosen.count == 0) q.choice.chosen.points[q.choice.chosen.count++] = manifold_witness(answer);
    manifold_choice_write(&q.choice, out);
}
