/* The depth of an overlap with a mesh, from both sides. Pure; any thread. */
#include "mesh_pair.h"
#include "narrow/convex/gjk.h"
#include "narrow/dispatch.h"
#include "narrow/math/scalar.h"

/* Work for one pair: counted, so that an answer depends on the poses alone. */
enum {
    PARTS_CROSSING_MAX = 2000, /* pairs of triangles that are measured where there is nothing else to go by */
    PARTS_SHALLOW_MAX = 200, /* pairs that are measured where there are pieces: more cross where the overlap is deep */
    PARTS_COUNTED_MAX = 150, /* that say how much farther to go */
    SHALLOW_ROUNDS = 3,      /* of going on, where there are pieces */
    PARTS_IN_BRIEF = 64,     /* pairs that are measured for a brief request */
    BRIEF_ROUNDS = 2,        /* further rounds for a brief request, where these are all pairs */
    BRIEF_WORK = 6000,       /* of union_depth.h, for them */
    PIECES_WORK = 200000,    /* units of union_depth.h, where the pieces fill the meshes */
    SOME_PIECES_WORK = 60000 /* the same where the pieces fill part of them */
};
enum { ROUNDS_MAX = 12, BACK_ROUNDS = 3, EXTRA_GROWTH = 4 };

/* The bound by the hulls is worth knowing to this part of the bracket that there is without it. */
static const double HULL_SHARE = 0.01;

/* Of the size: how far to go on at least where not all parts that overlap are asked; and how much farther each time
 * than the last, because there are others behind them. */
static const double LEAST_STRIDE = 0x1p-7, LONGER = 1.5;

/* A bracket in which the lower bound is no more than twice the upper needs no triangles. */
static const double HALF_KNOWN = 0.5;

/* Axes that are nearly across the direction of travel say little about how far it must go. */
static const double LEAST_SLOPE = 0.05;

typedef struct deepest_search {
    const narrow_goal *goal;
    epa_scratch *scratch;
    double depth; /* of the deepest pair of parts so far */
    span part;
    uint32_t left;   /* pairs that may still be looked at */
    vec3 normals[2]; /* of B's triangle and of A's, the same way as part.axis; 0 of a convex A */
    bool found;
} deepest_search;

/* Of a triangle; of one without area some direction across its longest side. */
static vec3 mesh_depth_normal_of(const mesh_spot *s)
{
    vec3 normal = direction_of(s->normal), longest = VEC_ZERO;
    if (vec_norm2(normal) > 0) return normal;
    for (int k = 0; k < 3; k++) {
        vec3 side = vec_sub(s->corner[(k + 1) % 3], s->corner[k]);
        if (vec_norm2(side) > vec_norm2(longest)) longest = side;
    }
    return vec_norm2(longest) > 0 ? vec_unit_orthogonal(direction_of(longest)) : vec(1, 0, 0);
}

static vec3 normal_b(const mesh_walk *w)
{
    return mesh_depth_normal_of(w->spot_b);
}

/* How far the part of B must go along `axis` to leave that of A. */
static double mesh_depth_overlap_along(const mesh_walk *w, vec3 axis)
{
    return mesh_walk_top_a(w, axis) - mesh_walk_foot_b(w, axis);
}

/* No pair of parts is deeper than it overlaps along the axes of A's frame and across the triangle. */
static double deepest_possible(const mesh_walk *w, vec3 n)
{
    vec3 up = vec_sub(w->spot_a->hi, w->spot_b->lo), down = vec_sub(w->spot_b->hi, w->spot_a->lo);
    double along = min_of(min_of(min_of(up.x, up.y), up.z), min_of(min_of(down.x, down.y), down.z));
    return min_of(along, min_of(mesh_depth_overlap_along(w, n), mesh_depth_overlap_along(w, vec_neg(n))));
}

/* Only parts that may be deeper than the deepest so far are measured. */
static bool deeper(mesh_walk *w, void *context)
{
    deepest_search *q = context;
    gjk_result start;
    span s;
    vec3 n = normal_b(w);
    if (q->left-- == 0) return false;
    if (w->effort) effort_spend(w->effort, EFFORT_NEED);
    if (deepest_possible(w, n) <= q->depth) return true;
    if (w->effort) effort_spend(w->effort, EFFORT_DEEP_PARTS);
    narrow_goal goal = *q->goal;
    goal.far = 0;
    goal.near = -INFINITY;
    mesh_walk_dress(w);
    gjk_distance(&w->part, &goal, VEC_ZERO, &start);
    if (start.state == GJK_APART) return true;
    s = start.span;
    epa_depth(&w->part, &goal, &start, q->scratch, &s);
    if (-s.hi > q->depth || !q->found) {
        q->depth = max_of(q->depth, -s.hi);
        q->part = s;
        if (!(vec_norm2(s.axis) > 0)) q->part.axis = n;
        q->normals[0] = vec_turned_to(n, q->part.axis);
        q->normals[1] = w->ma ? vec_turned_to(mesh_depth_normal_of(w->spot_a), q->part.axis) : VEC_ZERO;
        q->found = true;
    }
    return -q->depth > q->goal->near;
}

unit_pair mesh_depth_hulls(const unit_pair *whole)
{
    unit_pair hulls = *whole;
    if (hulls.a.type == SHAPE_MESH) hulls.a.type = SHAPE_HULL;
    if (hulls.b.type == SHAPE_MESH) hulls.b.type = SHAPE_HULL;
    return hulls;
}

/* Of the ball about the centre of a convex core that fits into it. */
static double inner_radius(const shape *s)
{
    switch (s->type) {
    case SHAPE_BOX:
    case SHAPE_CYLINDER:
    case SHAPE_ELLIPSOID:
        return min_of(s->half.x, min_of(s->half.y, s->half.z));
    default:
        return 0;
    }
}

/* How far a point (in A's frame) is below the surface of B: while it meets A, and a ball about it is in B, so do the
 * shapes. 0 if it is not inside, or B is a surface. */
static double depth_of_point(const unit_pair *whole, const narrow_goal *goal, vec3 point)
{
    const shape spot = {.type = SHAPE_SPHERE};
    unit_pair p = *whole;
    narrow_goal measure = *goal;
    mesh_walk w;
    mesh_gap gap;
    if (!whole->b.mesh->solid) return 0;
    p.a = spot;
    p.b_in_a.t = vec_sub(p.b_in_a.t, point);
    measure.far = INFINITY;
    measure.near = -INFINITY;
    mesh_walk_init(&w, &p, &spot, &whole->b);
    mesh_gap_find(&w, &measure, NULL, &gap);
    return gap.relation == MESH_HOLDS_A ? gap.nearest.lo : 0;
}

/* The ball about the centre of A and that of B meet for so long. 0 if the centre is not inside. */
static double depth_of_centre(const unit_pair *whole, const narrow_goal *goal)
{
    if (whole->a.type == SHAPE_MESH || whole->a.type == SHAPE_HULL) return 0;
    double depth = depth_of_point(whole, goal, VEC_ZERO);
    return depth > 0 ? depth + inner_radius(&whole->a) : 0;
}

/* The point of A that is farthest along the axis is, in contact with one side, the deepest: the triangles that it
 * passed through may each be less deep, because past an edge there is no more of them. */
static void try_deepest_point(const unit_pair *whole, const narrow_goal *goal, span *out)
{
    vec3 far_a = unit_pair_support_a(whole, out->axis, NULL);
    double depth = depth_of_point(whole, goal, far_a);
    if (!(depth > 0 && -depth < out->hi)) return; /* a rounded shape may touch with its core outside */
    out->hi = -depth;
    out->point_a = far_a;
    out->point_b = vec_madd(far_a, -depth, out->axis);
}

/* ---- a translation that separates ---- */

/* The distance of the cores at which the shapes are proven to be apart. */
static double clear_of(const unit_pair *whole)
{
    return whole->radius + 2 * whole->error + whole->excess;
}

/* How far points may lie outside of the hulls that represent meshes. */
static double hull_excess_of(const unit_pair *whole)
{
    double of_a = whole->a.type == SHAPE_MESH ? shape_excess(&whole->a) : 0;
    return (of_a + shape_excess(&whole->b)) * whole->scale;
}

typedef struct travel {
    const unit_pair *whole;
    mesh_walk *w;
    vec3 direction; /* unit, of B */
    double gone;
    double most;   /* farther is of no use */
    mesh_gap gap;  /* where it ended */
    double clear;  /* distance of the cores at which the shapes are apart */
    double need;   /* of the parts that still overlap: how much farther the farthest must go */
    uint32_t left; /* parts that may still be counted */
    int rounds;    /* at most */
} travel;

static vec3 position_at(const travel *t, double gone)
{
    return vec_madd(t->whole->b_in_a.t, gone, t->direction);
}

static bool count_need(mesh_walk *w, void *context)
{
    travel *t = context;
    if (w->effort) effort_spend(w->effort, EFFORT_NEED);
    double straight = mesh_depth_overlap_along(w, t->direction) + t->clear;
    vec3 n = normal_b(w);
    double slope = vec_dot(n, t->direction);
    if (slope < 0) n = vec_neg(n), slope = -slope;
    if (slope > LEAST_SLOPE) straight = min_of(straight, (mesh_depth_overlap_along(w, n) + t->clear) / slope);
    t->need = max_of(t->need, straight);
    return --t->left > 0;
}

static double width_along(const unit_pair *p, const shape *s, const mat3 *r, vec3 direction)
{
    unit_pair alone = {.a = *s, .scale = p->scale};
    vec3 d = r ? mat_tmul(*r, direction) : direction;
    return vec_dot(d, vec_sub(unit_pair_support_a(&alone, d, NULL), unit_pair_support_a(&alone, vec_neg(d), NULL)));
}

/* Of what is held, along the direction of travel. */
static double width_of_held(const travel *t, const mesh_gap *gap)
{
    unit_pair hulls = mesh_depth_hulls(t->whole);
    bool a_is_held = gap->relation == MESH_HOLDS_A;
    const mesh *held = a_is_held ? t->w->ma : t->w->mb;
    if (held && held->component_count > 1) return mesh_component_width(t->w, a_is_held, gap->component, t->direction);
    return a_is_held ? width_along(&hulls, &hulls.a, NULL, t->direction)
                     : width_along(&hulls, &hulls.b, &hulls.b_in_a.r, t->direction);
}

/* What is held must go to the surface, and then its own width. */
static double way_out(const travel *t, const mesh_gap *gap)
{
    return gap->nearest.hi + t->clear + width_of_held(t, gap);
}

/* Is it proven that the shapes are apart there? *spare: by how much more than needed. */
static bool is_clear(travel *t, double gone, mesh_gap *gap, double *spare)
{
    const narrow_goal measure = {.tolerance = 1e-9 * t->whole->size,
        .finest = 1e-12 * t->whole->size,
        .far = INFINITY,
        .near = -INFINITY,
        .above = -INFINITY,
        .below = INFINITY};
    mesh_walk_move(t->w, position_at(t, gone));
    mesh_gap_find(t->w, &measure, NULL, gap);
    *spare = gap->nearest.lo - t->clear;
    return gap->relation == MESH_APART && *spare >= 0;
}

/* The distance that B must go along the direction, INFINITY if none was found. Going back by what is to spare cannot
 * make them meet again. */
static double go(travel *t, double start)
{
    mesh_gap gap;
    double stride = LEAST_STRIDE * t->whole->size;
    double spare = 0, extra = 2 * t->whole->error; /* curved parts that all but touch are hard to prove apart */
    t->gone = start;
    for (int round = 0; round < t->rounds && t->gone < t->most; round++) {
        if (is_clear(t, t->gone, &gap, &spare)) {
            t->gap = gap;
            for (int back = 0; back < BACK_ROUNDS; back++) {
                t->gone -= spare;
                if (spare <= t->whole->error || !is_clear(t, t->gone, &gap, &spare)) break;
                t->gap = gap;
            }
            return max_of(t->gone, 0);
        }
        t->need = 0;
        t->left = PARTS_COUNTED_MAX;
        mesh_walk_move(t->w, position_at(t, t->gone));
        t->w->within = t->clear;
        mesh_walk_run(t->w, count_need, t);
        if (gap.relation == MESH_HOLDS_A || gap.relation == MESH_HOLDS_B) t->need = max_of(t->need, way_out(t, &gap));
        stride = max_of(t->need, (round || t->left == 0) * LONGER * stride); /* other parts come in its way */
        t->gone += stride + extra;
        extra *= EXTRA_GROWTH;
    }
    return INFINITY;
}

/* ---- both sides ---- */

void mesh_depth_rough(const unit_pair *whole, span *out)
{
    unit_pair hulls = mesh_depth_hulls(whole);
    double lo = vec_dot(out->axis, unit_pair_nearest_along(&hulls, out->axis).w);
    out->lo = min_of(lo - hull_excess_of(whole), out->hi);
}

/* Farther than that is no better than what is known. */
static double mesh_depth_most_of(const unit_pair *whole, const span *out)
{
    return whole->radius + whole->excess - out->lo;
}

/* Out along a direction, if that is shorter than what is known. */
static void try_way(
    const unit_pair *whole, mesh_walk *w, vec3 direction, int most_rounds, const mesh_gap *held, span *out)
{
    travel t = {.whole = whole,
        .w = w,
        .direction = direction,
        .most = mesh_depth_most_of(whole, out),
        .rounds = most_rounds,
        .clear = clear_of(whole)};
    double lo = whole->radius + whole->excess - go(&t, held ? way_out(&t, held) : 0);
    if (!(lo > out->lo)) return;
    out->lo = lo;
    out->axis = direction;
}

/* Apart as the convex hulls are. */
static void try_hulls(const unit_pair *whole, const narrow_goal *goal, epa_scratch *scratch, span *out)
{
    unit_pair hulls = mesh_depth_hulls(whole);
    narrow_goal measure = *goal;
    measure.far = INFINITY;
    measure.near = measure.above = -INFINITY; /* the measure is all that counts */
    measure.tolerance = max_of(goal->tolerance, HULL_SHARE * min_of(out->hi - out->lo, whole->size));
    span s;
    dispatch_general(&hulls, &measure, false, VEC_ZERO, scratch, &s);
    s.lo -= hull_excess_of(whole);
    if (s.lo <= out->lo) return;
    out->lo = s.lo;
    out->axis = s.axis;
}

/* Out through the nearest point of the surface, or apart along the axis of the deepest parts; the axis of a curved part
 * is known less well than its depth, so along the normals of the deepest triangles, too. */
static void mesh_depth_lower_bound(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    const vec3 normals[2], int rounds, epa_scratch *scratch, span *out)
{
    bool held = gap->relation == MESH_HOLDS_A || gap->relation == MESH_HOLDS_B;
    vec3 first = held ? vec_neg(gap->nearest.axis) : out->axis;
    int64_t kept = effort_keep_back(w->effort, EFFORT_OF_HULLS);
    out->lo = -INFINITY;
    out->axis = first;
    try_way(whole, w, first, rounds, held ? gap : NULL, out);
    for (int i = 0; i < 2; i++)
        if (!narrow_goal_reached(goal, out->lo, out->hi) && vec_norm2(normals[i]) > 0)
            try_way(whole, w, normals[i], rounds, NULL, out);
    effort_give_back(w->effort, kept);
    if (!narrow_goal_reached(goal, out->lo, out->hi)) try_hulls(whole, goal, scratch, out);
}

static void both_bounds(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    const vec3 normals[2], int rounds, epa_scratch *scratch, span *out)
{
    mesh_depth_lower_bound(whole, w, goal, gap, normals, rounds, scratch, out);
    if (!narrow_goal_reached(goal, out->lo, out->hi)) try_deepest_point(whole, goal, out);
}

/* ---- convex pieces ---- */

static bool is_convex(const shape *s)
{
    return s->type != SHAPE_MESH || s->mesh->convex;
}

static double mesh_depth_slack_of(const shape *s)
{
    return s->type == SHAPE_MESH ? s->mesh->pieces[0].slack : 0;
}

/* A convex mesh is its hull. True: the goal is reached. */
static bool depth_of_hulls(const unit_pair *whole, const narrow_goal *goal, epa_scratch *scratch, span *out)
{
    if (!is_convex(&whole->a) || !is_convex(&whole->b)) return false;
    unit_pair hulls = mesh_depth_hulls(whole);
    span s = *out;
    double slack = (mesh_depth_slack_of(&whole->a) + mesh_depth_slack_of(&whole->b)) * whole->scale + whole->error;
    dispatch_general(&hulls, goal, false, VEC_ZERO, scratch, &s);
    if (!(s.hi + slack < 0)) return false;
    s.lo -= hull_excess_of(whole);
    s.hi = min_of(s.hi + slack, out->hi);
    s.nearest.count_a = 0;
    s.nearest.deep = false;
    *out = s;
    return narrow_goal_reached(goal, s.lo, s.hi);
}

typedef struct piece_search {
    travel t;
    span *out;
} piece_search;

/* Where the search has come to: on from there, until all triangles are proven to be apart. */
static double mesh_depth_go_on(void *context, vec3 way)
{
    piece_search *q = context;
    const unit_pair *whole = q->t.whole;
    double length = vec_norm(way), reserve = q->t.clear + 2 * whole->error;
    if (!(length > 0)) return INFINITY;
    q->t.direction = vec_scale(way, 1 / length);
    q->t.most = mesh_depth_most_of(whole, q->out);
    double gone = go(&q->t, length + reserve), lo = whole->radius + whole->excess - gone;
    if (!(lo > q->out->lo)) return INFINITY;
    q->out->lo = lo;
    q->out->axis = q->t.direction;
    q->out->point_a = q->t.gap.nearest.point_a;
    q->out->point_b = vec_madd(q->t.gap.nearest.point_b, -gone, q->t.direction);
    return -lo;
}

/* Both bounds by the convex pieces that fill the meshes, or most of them, if what is known leaves something open. */
static void depth_of_pieces(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, uint32_t work,
    epa_scratch *scratch, union_scratch *u, span *out)
{
    work = effort_grant(w->part.effort, work, EFFORT_UNION);
    if (work == 0 || narrow_goal_reached(goal, out->lo, out->hi)) return;
    if (!union_side_init(&u->a, &whole->a, whole->scale, NULL)) return;
    if (!union_side_init(&u->b, &whole->b, whole->scale, &whole->b_in_a)) return;
    if (out->lo == -INFINITY) try_hulls(whole, goal, scratch, out);
    piece_search q = {.t = {.whole = whole, .w = w, .rounds = ROUNDS_MAX, .clear = clear_of(whole)}, .out = out};
    union_bounds bounds = union_depth(u, -out->lo, goal, 2 * whole->error, work, mesh_depth_go_on, &q);
    out->iterations += bounds.work / 64;
    if (w->part.effort) effort_spend(w->part.effort, bounds.work * (int64_t)EFFORT_UNION);
    out->hi = min_of(out->hi, -bounds.least);
}

static bool is_filled(const shape *s)
{
    return s->type != SHAPE_MESH || s->mesh->filled;
}

static bool mesh_depth_has_pieces(const shape *s)
{
    return s->type == SHAPE_MESH ? s->mesh->piece_count > 0 : union_side_takes(s->type);
}

/* Both bounds by the triangles that cross, the way out of what is held, and the hulls. `deep`: there are pieces to
 * ask where many cross. */
static void depth_of_surfaces(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    bool deep, epa_scratch *scratch, span *out)
{
    const span known = *out;
    deepest_search q = {
        .goal = goal, .scratch = scratch, .depth = 0, .left = deep ? PARTS_SHALLOW_MAX : PARTS_CROSSING_MAX};
    *out = gap->nearest;
    out->method = NARROW_BY_EPA;
    if (gap->relation == MESH_CROSSING) {
        mesh_walk_move(w, whole->b_in_a.t);
        w->within = whole->error;
        int64_t kept = effort_keep_back(w->effort, EFFORT_OF_WAYS_OUT);
        mesh_walk_run(w, deeper, &q);
        effort_give_back(w->effort, kept);
        if (q.found) {
            out->hi = min_of(out->hi, -q.depth);
            out->axis = q.part.axis;
            out->point_a = q.part.point_a;
            out->point_b = q.part.point_b;
        }
    } else if (gap->relation != MESH_APART) {
        out->hi = -gap->nearest.lo;
        out->axis = vec_neg(out->axis);
    }
    double centre = out->hi > goal->near ? depth_of_centre(whole, goal) : 0;
    if (centre > 0) out->hi = min_of(out->hi, -centre);
    out->lo = -INFINITY;
    if (out->hi <= goal->near)
        mesh_depth_rough(whole, out);
    else if (!(deep && q.left == UINT32_MAX))
        both_bounds(whole, w, goal, gap, q.normals, deep ? SHALLOW_ROUNDS : ROUNDS_MAX, scratch, out);
    else if (known.lo == -INFINITY)
        try_hulls(whole, goal, scratch, out);
    double hi = min_of(out->hi, known.hi);
    if (known.lo >= out->lo) *out = known;
    out->hi = hi;
}

/* The first bracket: by the pieces, where they fill the meshes and decide quickly; by the first triangles that cross,
 * and the hulls. */
static void depth_in_brief(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    bool filled, epa_scratch *scratch, union_scratch *pieces, span *out)
{
    deepest_search q = {.goal = goal, .scratch = scratch, .depth = 0, .left = PARTS_IN_BRIEF};
    if (filled) depth_of_pieces(whole, w, goal, BRIEF_WORK, scratch, pieces, out);
    if (gap->relation == MESH_CROSSING && !(out->hi < HALF_KNOWN * out->lo)) {
        mesh_walk_move(w, whole->b_in_a.t);
        w->within = whole->error;
        mesh_walk_run(w, deeper, &q);
        out->hi = min_of(out->hi, -q.depth);
        if (q.found && q.left != UINT32_MAX) try_way(whole, w, q.part.axis, BRIEF_ROUNDS, NULL, out);
    } else if (gap->relation != MESH_CROSSING && gap->relation != MESH_APART) {
        out->hi = min_of(out->hi, -gap->nearest.lo);
    }
    if (out->lo == -INFINITY) try_hulls(whole, goal, scratch, out);
    if (!q.found || narrow_goal_reached(goal, out->lo, out->hi)) return;
    out->point_a = q.part.point_a;
    out->point_b = q.part.point_b;
}

/* Pieces that fill the meshes are searched first; other pieces, if the surfaces do not decide. */
void mesh_depth_find(const unit_pair *whole, mesh_walk *w, const narrow_goal *goal, const mesh_gap *gap,
    epa_scratch *scratch, union_scratch *pieces, span *out)
{
    uint32_t visits = w->visits; /* how many that were depends on where the search for the gap began */
    bool measured = goal->near == -INFINITY, filled = is_filled(&whole->a) && is_filled(&whole->b);
    bool in_pieces =
        gap->relation != MESH_APART && mesh_depth_has_pieces(&whole->a) && mesh_depth_has_pieces(&whole->b);
    uint32_t work = filled ? PIECES_WORK : SOME_PIECES_WORK;
    *out = gap->nearest;
    out->method = NARROW_BY_EPA;
    out->lo = -INFINITY;
    if (gap->relation != MESH_APART && depth_of_hulls(whole, goal, scratch, out)) return;
    if (goal->brief && measured) {
        depth_in_brief(whole, w, goal, gap, in_pieces && filled, scratch, pieces, out);
        out->lo = min_of(out->lo, out->hi);
        return;
    }
    if (in_pieces && filled && measured) depth_of_pieces(whole, w, goal, work, scratch, pieces, out);
    if (!narrow_goal_reached(goal, out->lo, out->hi)) depth_of_surfaces(whole, w, goal, gap, in_pieces, scratch, out);
    if (in_pieces && !(filled && measured)) depth_of_pieces(whole, w, goal, work, scratch, pieces, out);
    out->iterations = gap->nearest.iterations + w->visits - visits;
    out->lo = min_of(out->lo, out->hi);
}
