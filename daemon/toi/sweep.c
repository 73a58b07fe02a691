/* The gaps of parts along directions, at the ends of the pieces of a motion. Pure; any thread. */
#include "sweep.h"

#include "geom/compound.h"
#include "geom/round.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/core.h"
#include "narrow/pair/unit_pair.h"

enum { ROUNDS_MAX = 8, ALTERNATIONS = 1 }; /* directions are looked for so often in a piece */
static const double FINE = 0.001;          /* of the pair's size: how far a gap may dip in a whole piece */
static const double STRETCH = 0.25;        /* the same in all of a stretch: about 1.5 rad of a turn */
static const double LEAST_GAIN = 0.02;     /* of a piece: below it no further direction is looked for */

static const uint32_t NOWHERE = UINT32_MAX;

bool sweep_init(sweep *s, const toi_mover *a, const toi_mover *b, const toi_request *request)
{
    if (!course_init(&s->course, a, b, request->span)) return false;
    s->request = request;
    s->size = s->course.reach_a + s->course.reach_b;
    s->work = 0;
    s->begun = false;
    return true;
}

/* Chooses the frame of fixed directions in which gaps dip the least. */
static void choose_frame(sweep *s)
{
    s->bend = INFINITY;
    const course *c = &s->course;
    double a = c->spin_a.speed * c->spin_a.speed * c->radius_a, b = c->spin_b.speed * c->spin_b.speed * c->radius_b;
    s->bend_a = a + b > 0 ? a / (a + b) * (1 + 0x1p-45) : 0;
    s->bend_b = a + b > 0 ? b / (a + b) * (1 + 0x1p-45) : 0;
    for (int frame = COURSE_STILL; frame < COURSE_FRAMES; frame++) {
        double bend = course_bend(&s->course, (course_frame)frame, s->start, s->end);
        if (bend >= s->bend) continue;
        s->frame = (course_frame)frame;
        s->bend = bend;
    }
}

void sweep_begin(sweep *s, double start, double end)
{
    if (s->begun && s->start == start && s->asked == end) return;
    s->begun = true;
    s->start = start;
    s->end = s->asked = end;
    choose_frame(s);
    double length = end - start, most = sqrt(8 * STRETCH * s->size / s->bend);
    if (length > most) s->end = min_of(start + most, end);
    length = s->end - start;
    double pieces = 1 + sqrt(s->bend * length * length / 8 / (FINE * s->size));
    bool cut = s->bend > 0;
    uint32_t whole = pieces < SWEEP_PIECES_MAX ? (uint32_t)pieces : SWEEP_PIECES_MAX; /* 16, but for rounding */
    whole = (whole + SWEEP_CUT - 1) / SWEEP_CUT * SWEEP_CUT;
    s->longest = cut ? SWEEP_LONGEST : 1;
    s->ends = cut ? whole * s->longest : 1;
    for (s->whole = 1; s->whole * SWEEP_CUT <= s->ends;) s->whole *= SWEEP_CUT;
    s->least = length / s->ends;
    for (int k = 0; k < SWEEP_PLACES; k++) s->at[k].index = NOWHERE;
}

/* Of both shapes, in the frame of the course, or of one of the two. */
static void set_frames(const sweep *s, const course_place *at, sweep_place *p)
{
    mat3 turned = quat_matrix(at->b_in_a.q), own = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    transform b_in_a = {turned, at->b_in_a.p}, still = {own, VEC_ZERO};
    mat3 w = at->world_of_a;
    switch (s->frame) {
    case COURSE_WITH_A:
        p->a = still, p->b = b_in_a;
        break;
    case COURSE_WITH_B:
        p->a.r = (mat3){mat_tmul(turned, own.x), mat_tmul(turned, own.y), mat_tmul(turned, own.z)};
        p->a.t = vec_neg(mat_tmul(turned, b_in_a.t)), p->b = still;
        break;
    default:
        p->a = (transform){w, at->arm};
        p->b.r = (mat3){mat_mul(w, turned.x), mat_mul(w, turned.y), mat_mul(w, turned.z)};
        p->b.t = vec_add(at->arm, mat_mul(w, b_in_a.t));
    }
}

static void make_place(const sweep *s, uint32_t index, sweep_place *p)
{
    double time = sweep_time(s, index);
    course_place at = course_at(&s->course, time);
    p->index = index;
    set_frames(s, &at, p);
    p->floor = s->request->threshold + s->course.slack +
               0.5 * s->request->wander * time * time * (1 + 4 * UNIT_ROUNDOFF) +
               UNIT_ROUNDOFF *
                   (128 * (vec_norm(p->a.t) + vec_norm(p->b.t) + s->size) + 32 * s->course.speed * s->request->span);
}

const sweep_place *sweep_place_at(sweep *s, uint32_t index)
{
    sweep_place *p = &s->at[(index ^ index / SWEEP_LONGEST) % SWEEP_PLACES]; /* most are multiples of it */
    if (p->index != index) {
        make_place(s, index, p);
        s->work += SWEEP_WORK_PLACE;
    }
    return p;
}

#define SWEEP_INLINE __attribute__((always_inline)) static inline

SWEEP_INLINE double top_of_shape(const toi_part *p, vec3 d)
{
    vec3 own = quat_rotate(quat_conj(p->local.q), d);
    return vec_dot(own, core_support(&p->shape, 1, own, NULL)) + vec_dot(d, p->local.p);
}

/* The greatest height of a part along a direction of its shape's frame. */
SWEEP_INLINE double sweep_top_of(const toi_part *p, vec3 d)
{
    if (p->form == TOI_PART_BOX)
        return vec_dot(d, p->centre) + fabs(vec_dot(d, p->side[0])) + fabs(vec_dot(d, p->side[1])) +
               fabs(vec_dot(d, p->side[2]));
    if (p->form == TOI_PART_SHAPE) return top_of_shape(p, d);
    double x = d.x * p->x[0] + d.y * p->y[0] + d.z * p->z[0], y = d.x * p->x[1] + d.y * p->y[1] + d.z * p->z[1],
           z = d.x * p->x[2] + d.y * p->y[2] + d.z * p->z[2];
    return max_of(max_of(x, y), z);
}

/* How far apart they are at a place along a unit direction of the course's frame, beyond the floor. */
SWEEP_INLINE double sweep_gap_at(const sweep_place *at, const toi_part *a, const toi_part *b, vec3 d)
{
    double top = sweep_top_of(a, mat_tmul(at->a.r, d)) + vec_dot(d, at->a.t);
    double foot = vec_dot(d, at->b.t) - sweep_top_of(b, vec_neg(mat_tmul(at->b.r, d)));
    return foot - top - a->margin - b->margin - at->floor;
}

typedef struct sweep_progress { /* through one piece */
    const sweep *s;
    const toi_part *a, *b;
    const sweep_place *from, *to;
    vec3 *hint; /* the direction that went farthest */
    double dip;
    double share; /* of the piece that is free */
    uint32_t tried;
} sweep_progress;

/* Goes on to the time until which the gap along a direction stays open. */
static void try_direction(sweep_progress *w, vec3 towards)
{
    if (!(vec_norm2(towards) > 0)) return;
    w->tried++;
    vec3 d = direction_of(towards);
    double dip = w->dip, first = sweep_gap_at(w->from, w->a, w->b, d);
    if (!(first > 0) && w->share == 0) return;
    double last = sweep_gap_at(w->to, w->a, w->b, d), share = 1;
    bool is_open = sweep_keeps_open(first, last, dip);
    if (!is_open) {
        dip *= sweep_share(w->s, d);
        is_open = sweep_keeps_open(first, last, dip);
    }
    if (!is_open) {
        first -= dip, last -= dip;
        if (!(first + (last - first) * w->share > 0)) return;
        share = last > 0 ? 1 : first / (first - last);
    }
    if (share > w->share) *w->hint = d;
    w->share = max_of(w->share, share);
}

SWEEP_INLINE vec3 sweep_between(const transform *from, const transform *to, double share, vec3 point)
{
    vec3 p = transform_point(from, point), q = transform_point(to, point);
    return vec_madd(p, share, vec_sub(q, p));
}

/* The extents of a part, turned as it is at the beginning of a piece. */
typedef struct extents {
    vec3 side[3];
    double per_norm2[3]; /* 0 where there is no side */
} extents;

static void turn_extents(const toi_part *p, const mat3 *r, extents *out)
{
    for (int k = 0; k < 3; k++) {
        double norm2 = vec_norm2(p->side[k]);
        out->side[k] = mat_mul(*r, p->side[k]);
        out->per_norm2[k] = norm2 > 0 ? 1 / norm2 : 0;
    }
}

/* The point of extents about a centre that is nearest to another point. */
SWEEP_INLINE vec3 sweep_nearest_in(const extents *e, vec3 centre, vec3 point)
{
    vec3 nearest = centre, away = vec_sub(point, centre);
    for (int k = 0; k < 3; k++)
        nearest = vec_madd(nearest, clamp_to(vec_dot(away, e->side[k]) * e->per_norm2[k], 1), e->side[k]);
    return nearest;
}

/* Directions that may have a gap at that share of the piece: between what is nearest of their extents (by going to and
 * fro between them), and across flat parts. */
static void try_directions(sweep_progress *w, const extents *ea, const extents *eb)
{
    const sweep_place *from = w->from, *to = w->to;
    vec3 a = sweep_between(&from->a, &to->a, w->share, w->a->centre),
         b = sweep_between(&from->b, &to->b, w->share, w->b->centre);
    vec3 line = vec_sub(b, a), on_b = b, on_a = sweep_nearest_in(ea, a, b), first = on_a;
    double before = w->share;
    for (int k = 0; k < ALTERNATIONS; k++) {
        on_b = sweep_nearest_in(eb, b, on_a);
        on_a = sweep_nearest_in(ea, a, on_b);
    }
    try_direction(w, vec_sub(on_b, on_a));
    if (w->share > before) return;
    try_direction(w, vec_sub(b, first));
    if (w->share > before) return;
    try_direction(w, vec_turned_to(mat_mul(from->b.r, w->b->normal), line));
    if (w->share > before) return;
    try_direction(w, vec_turned_to(mat_mul(from->a.r, w->a->normal), line));
}

/* The share of a piece that is free, given that so much is; not to be found out beyond `enough`. */
static double free_share(sweep *s, const toi_part *a, const toi_part *b, uint32_t first, uint32_t length, double share,
    double enough, vec3 *hint)
{
    sweep_place from = *sweep_place_at(s, first);
    sweep_progress w = {
        .s = s, .a = a, .b = b, .from = &from, .to = sweep_place_at(s, first + length), .share = share, .hint = hint};
    w.dip = sweep_dip(s, length);
    try_direction(&w, *hint);
    if (w.share < enough) {
        extents ea, eb;
        turn_extents(a, &from.a.r, &ea);
        turn_extents(b, &from.b.r, &eb);
        for (int round = 0; round < ROUNDS_MAX && w.share < enough; round++) {
            double before = w.share;
            try_directions(&w, &ea, &eb);
            if (w.share - before < LEAST_GAIN) break;
        }
    }
    s->work += SWEEP_WORK_TRY * w.tried;
    return w.share;
}

double sweep_entry(sweep *s, const toi_part *a, const toi_part *b, double from, double until, vec3 *hint)
{
    uint32_t shortest = a->is_leaf && b->is_leaf ? 1 : s->longest, length = s->longest;
    double time = sweep_index(s, from), last = sweep_index(s, until); /* in least pieces */
    while (time < s->ends && sweep_time(s, time) <= until) {
        uint32_t first = (uint32_t)time / length * length;
        double share = min_of(max_of((time - first) / length, 0), 1);
        double enough = min_of((last - first) / length * (1 + 0x1p-40), 1);
        share = free_share(s, a, b, first, length, share, enough, hint);
        if (share >= 1) {
            time = first + length;
            if (length < s->longest && (first + length) % (SWEEP_CUT * length) == 0) length *= SWEEP_CUT;
            continue;
        }
        time = max_of(time, first + share * length);
        double entry = sweep_time(s, time);
        if (length == shortest) return entry > until ? INFINITY : max_of(entry, from);
        length /= SWEEP_CUT;
    }
    return INFINITY;
}

/* ==== shapes of parts ==== */

/* Boxes of hierarchies and what lies in them, as shapes. */

bool toi_parts_apply(const shape *a, const shape *b)
{
    return a->type != SHAPE_HALFSPACE && (a->type >= SHAPE_CONVEX_COUNT || b->type >= SHAPE_CONVEX_COUNT);
}

/* A box from corner to corner, in m. */
static void be_box(toi_part *p, vec3 lo, vec3 hi)
{
    vec3 centre = vec_scale(vec_add(lo, hi), 0.5), half = vec_max(vec_sub(hi, centre), vec_sub(centre, lo));
    p->shape = (shape){.type = SHAPE_BOX,
        .radius = p->whole->radius + shape_excess(p->whole),
        .half = vec_scale(half, 1 + 4 * UNIT_ROUNDOFF)};
    p->local = (pose){centre, {1, 0, 0, 0}};
    p->size = shape_reach(&p->shape);
    p->is_leaf = false;
    p->form = TOI_PART_BOX;
    p->centre = centre;
    p->side[0] = vec(p->shape.half.x, 0, 0);
    p->side[1] = vec(0, p->shape.half.y, 0);
    p->side[2] = vec(0, 0, p->shape.half.z);
    p->margin = p->shape.radius;
}

/* The extents of a convex shape: those of its box, in its own frame. */
static void be_shape(toi_part *p)
{
    const vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vec3 middle = VEC_ZERO;
    mat3 r = quat_matrix(p->local.q);
    p->size = shape_reach(&p->shape);
    p->form = p->shape.type == SHAPE_BOX ? TOI_PART_BOX : TOI_PART_SHAPE;
    p->margin = p->shape.radius + shape_excess(&p->shape);
    for (int k = 0; k < 3; k++) {
        double hi = vec_dot(axes[k], core_support(&p->shape, 1, axes[k], NULL));
        double lo = vec_dot(axes[k], core_support(&p->shape, 1, vec_neg(axes[k]), NULL));
        middle = vec_madd(middle, 0.5 * (lo + hi), axes[k]);
        p->side[k] = mat_mul(r, vec_scale(axes[k], 0.5 * (hi - lo)));
    }
    p->centre = vec_add(mat_mul(r, middle), p->local.p);
}

/* Boxes of meshes are turned as their patches lie. */
static void be_turned(toi_part *p, const mesh_node *n, uint32_t c, double unit)
{
    p->centre = vec_scale(vec(n->centre[0][c], n->centre[1][c], n->centre[2][c]), unit);
    p->normal = vec_scale(vec(n->normal[0][c], n->normal[1][c], n->normal[2][c]), unit);
    for (int k = 0; k < 2; k++) p->side[k] = vec_scale(vec(n->side[k][0][c], n->side[k][1][c], n->side[k][2][c]), unit);
    p->side[2] = vec_scale(p->normal, (double)n->half[c]);
}

/* ---- meshes ---- */

static vec3 toi_part_corner_of(const float side[3][MESH_WIDTH], int child, double unit)
{
    return vec(side[0][child] * unit, side[1][child] * unit, side[2][child] * unit);
}

static void be_mesh_node(toi_part *p, const shape *whole, uint32_t node)
{
    const mesh_node *n = &whole->mesh->nodes[node];
    double unit = whole->mesh->unit;
    *p = (toi_part){.whole = whole, .node = node, .child = TOI_WHOLE_NODE};
    vec3 lo = toi_part_corner_of(n->lo, 0, unit), hi = toi_part_corner_of(n->hi, 0, unit);
    for (int k = 1; k < n->used; k++) {
        lo = vec_min(lo, toi_part_corner_of(n->lo, k, unit));
        hi = vec_max(hi, toi_part_corner_of(n->hi, k, unit));
    }
    be_box(p, lo, hi);
}

/* Makes the part a triangle, represented as a flat hull. */
static void be_triangle(toi_part *p, const shape *whole, uint32_t triangle)
{
    *p = (toi_part){.whole = whole, .local = POSE_IDENTITY, .is_leaf = true};
    double reach = 0, most = 0;
    for (int k = 0; k < 8; k++) {
        vec3 v = mesh_corner(whole->mesh, triangle, k < 3 ? k : 2);
        p->x[k] = v.x;
        p->y[k] = v.y;
        p->z[k] = v.z;
        reach = max_of(reach, length_up(v));
        most = max_of(most, vec_greatest(v));
    }
    p->flat = (hull){.vertex_count = 3,
        .padded_count = 8,
        .x = p->x,
        .y = p->y,
        .z = p->z,
        .reach = reach,
        .max_abs = most,
        .dimension = 2};
    p->shape = (shape){.type = SHAPE_HULL, .radius = whole->radius, .deviation = whole->deviation, .hull = &p->flat};
    p->size = reach;
    p->form = TOI_PART_TRIANGLE;
    p->margin = whole->radius;
    vec3 u = vec(p->x[0], p->y[0], p->z[0]), v = vec(p->x[1], p->y[1], p->z[1]), w = vec(p->x[2], p->y[2], p->z[2]);
    p->centre = vec_scale(vec_add(vec_add(u, v), w), 1.0 / 3);
    p->normal = vec_cross(vec_sub(v, u), vec_sub(w, u));
}

static int mesh_children(const toi_part *p, toi_part *out)
{
    const mesh_node *n = &p->whole->mesh->nodes[p->node];
    double unit = p->whole->mesh->unit;
    if (p->child != TOI_WHOLE_NODE) { /* the triangles of one child */
        for (int k = 0; k < n->count[p->child]; k++) be_triangle(&out[k], p->whole, n->first[p->child] + (uint32_t)k);
        return n->count[p->child];
    }
    for (uint32_t k = 0; k < n->used; k++) {
        bool inner = n->count[k] == 0;
        out[k] =
            (toi_part){.whole = p->whole, .node = inner ? n->first[k] : p->node, .child = inner ? TOI_WHOLE_NODE : k};
        be_box(&out[k], toi_part_corner_of(n->lo, (int)k, unit), toi_part_corner_of(n->hi, (int)k, unit));
        be_turned(&out[k], n, k, unit);
    }
    return n->used;
}

/* ---- compounds ---- */

static void be_child(toi_part *p, const shape *whole, uint32_t child)
{
    const compound_child *c = &whole->compound->children[child];
    *p = (toi_part){.whole = whole, .shape = c->shape, .local = c->local, .is_leaf = true};
    p->shape.radius += whole->radius;
    p->shape.deviation += whole->deviation;
    be_shape(p);
}

static void be_compound_node(toi_part *p, const shape *whole, uint32_t node)
{
    const compound_node *n = &whole->compound->nodes[node];
    if (n->right == 0) {
        be_child(p, whole, n->child);
        return;
    }
    *p = (toi_part){.whole = whole, .node = node};
    be_box(p, n->lo, n->hi);
}

static int compound_children(const toi_part *p, toi_part *out)
{
    be_compound_node(&out[0], p->whole, p->node + 1);
    be_compound_node(&out[1], p->whole, p->whole->compound->nodes[p->node].right);
    return 2;
}

/* ---- any shape ---- */

void toi_part_root(const shape *whole, toi_part *out)
{
    if (whole->type == SHAPE_MESH) {
        be_mesh_node(out, whole, 0);
        return;
    }
    if (whole->type == SHAPE_COMPOUND) {
        be_compound_node(out, whole, 0);
        return;
    }
    *out = (toi_part){.whole = whole, .shape = *whole, .local = POSE_IDENTITY, .is_leaf = true};
    be_shape(out);
}

int toi_part_children(const toi_part *p, toi_part *out)
{
    return p->whole->type == SHAPE_MESH ? mesh_children(p, out) : compound_children(p, out);
}
