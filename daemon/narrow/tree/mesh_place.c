/* Where the two shapes of a walk are, as each other's boxes see them; the axis, and the parts that are visited. Pure;
 * any thread. */
#include "mesh_walk.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/core.h"

/* Two boxes are opened together where neither mesh is more than this times as large as the other, nor farther away than
 * ALONE_FAR times its size: elsewhere floats are better of one box at a time. */
#define ALONE_RATIO 16
#define ALONE_FAR 64

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

void mesh_walk_dress(mesh_walk *w)
{
    put_on(&w->flat_b, w->mb, w->triangle_b);
    if (w->ma) put_on(&w->flat_a, w->ma, w->triangle_a);
}

static void set_turn(mesh_turn *turn, const transform *t, double size_from, double size_to)
{
    double ratio = size_from / size_to;
    turn->r = (mat3){vec_scale(t->r.x, ratio), vec_scale(t->r.y, ratio), vec_scale(t->r.z, ratio)};
    turn->t = vec_scale(t->t, 1 / size_to);
    turn->ratio = (float)ratio;
    put3(turn->column[0], t->r.x);
    put3(turn->column[1], t->r.y);
    put3(turn->column[2], t->r.z);
}

static double extent_of(const mesh_walk *w, vec3 d)
{
    return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
}

/* The box of a convex A as B's nodes see it. */
static void box_whole(mesh_walk *w)
{
    mesh_other *o = &w->whole_other;
    vec3 half = vec_scale(vec_sub(w->whole.hi, w->whole.lo), 0.5), middle = vec_add(w->whole.lo, half);
    vec3 centre = vec_scale(transform_point(&w->a_in_b, middle), 1 / w->size_b);
    const double halves[3] = {half.x / w->size_b, half.y / w->size_b, half.z / w->size_b};
    const vec3 axes[3] = {w->a_in_b.r.x, w->a_in_b.r.y, w->a_in_b.r.z};
    double reach = vec_sum_magnitudes(centre);
    for (int k = 0; k < 3; k++) {
        vec3 side = vec_scale(axes[k], halves[k]);
        put3(o->side[k], side);
        put3(o->square[k], axes[k]);
        o->halves[k] = (float)halves[k];
        reach += vec_sum_magnitudes(side);
    }
    put3(o->centre, centre);
    o->far = !(reach < FLOAT_FAR);
    o->slack = (float)(FLOAT_SLACK * (4 + reach));
    o->flat = false;
}

static void spot_whole(mesh_walk *w)
{
    const vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    w->whole.hi = vec(extent_of(w, x), extent_of(w, y), extent_of(w, z));
    w->whole.lo = vec(-extent_of(w, vec_neg(x)), -extent_of(w, vec_neg(y)), -extent_of(w, vec_neg(z)));
}

static void forget_stands(mesh_stand *stands)
{
    for (int i = 0; i < MESH_STANDS; i++) stands[i].node = MESH_WHOLE;
}

static void forget_faces(mesh_walk *w)
{
    for (int i = 0; i < MESH_FACES; i++) w->faced[i] = MESH_WHOLE;
}

static void forget_leaves(mesh_box *known)
{
    for (int i = 0; i < MESH_LEAVES; i++) known[i].node = MESH_WHOLE;
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
    w->effort = p->effort;
    w->unseen = INFINITY;
    if (w->ma) {
        wear(&w->flat_a, &w->part.a);
        forget_leaves(w->known_a);
        forget_stands(w->stands_a);
        forget_stands(w->stands_b);
    } else {
        spot_whole(w);
    }
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
    w->axis = w->b_axis = VEC_ZERO;
    w->whole_level = 0;
    w->aimed = w->whole_other.aimed = false;
    w->aims++;
    w->triangle_a = w->triangle_b = MESH_NO_TRIANGLE;
    forget_leaves(w->known_b);
    if (w->ma) {
        set_turn(&w->into_a, &w->part.b_in_a, w->size_b, w->size_a);
        set_turn(&w->into_b, &w->a_in_b, w->size_a, w->size_b);
        double ratio = w->size_a / w->size_b, reach = vec_sum_magnitudes(w->into_b.t) + 8 * ratio;
        w->opens_both = ratio <= ALONE_RATIO && ratio * ALONE_RATIO >= 1 && reach < ALONE_FAR;
        forget_faces(w);
        w->open_slack = (float)(FLOAT_SLACK * (4 + reach));
    } else {
        w->opens_both = false;
        box_whole(w);
    }
}

static void aim_whole(mesh_walk *w)
{
    mesh_other *o = &w->whole_other;
    w->whole_level = extent_of(w, w->axis);
    o->aimed = true;
    memcpy(o->axis, w->axis_in_b, sizeof o->axis);
    o->level = (float)((w->whole_level - vec_dot(w->axis, w->part.b_in_a.t)) / w->size_b);
}

void mesh_walk_aim(mesh_walk *w, vec3 axis)
{
    w->axis = axis;
    w->aimed = true;
    w->aims++;
    put3(w->axis_in_a, vec_neg(axis));
    w->b_axis = mat_tmul(w->part.b_in_a.r, axis);
    put3(w->axis_in_b, w->b_axis);
    if (w->ma)
        w->origin_level = (float)(-vec_dot(axis, w->part.b_in_a.t) / w->size_b);
    else
        aim_whole(w);
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

/* ==== leaves ==== */

/* The triangles of two leaves, pair by pair, as far as they are near enough, in doubles. */

/* Between the middles of the boxes, twice. */
static vec3 between_boxes(const mesh_spot *a, const mesh_spot *b)
{
    return vec_sub(vec_add(b->lo, b->hi), vec_add(a->lo, a->hi));
}

static double farthest(const mesh_walk *w)
{
    return w->within + 2 * w->part.error;
}

static double farthest2(const mesh_walk *w)
{
    return farthest(w) * farthest(w);
}

/* Along a direction of any length. The best so far is in w->lead, *best is the square of the gap along it. */
static bool is_far_along(mesh_walk *w, vec3 u, double *best)
{
    double gap = mesh_walk_foot_b(w, u) - mesh_walk_top_a(w, u), norm2 = vec_norm2(u);
    if (!(gap > 0) || !(gap * gap > *best * norm2)) return false;
    double within = farthest(w);
    *best = gap * gap / norm2;
    w->lead = u;
    return *best > within * within;
}

/* A convex A, along the line between the boxes and the normal. */
static bool is_core_far(mesh_walk *w)
{
    const mesh_spot *a = w->spot_a, *b = w->spot_b;
    double best = 0;
    w->lead = between_boxes(a, b);
    return is_far_along(w, w->lead, &best) || is_far_along(w, vec_turned_to(b->normal, w->lead), &best);
}

static const mesh_four *mesh_leaf_place_a(const mesh_walk *w, mesh_leaf *l)
{
    if (!l->placed) mesh_four_set(&l->four, w->ma->corners + 3 * (size_t)l->first, l->count, w->part.scale, NULL);
    l->placed = true;
    return &l->four;
}

static const mesh_four *mesh_leaf_place_b(const mesh_walk *w, mesh_leaf *l)
{
    const vec3 *corners = w->mb->corners + 3 * (size_t)l->first;
    if (!l->placed) mesh_four_set(&l->four, corners, l->count, w->part.scale, &w->part.b_in_a);
    l->placed = true;
    return &l->four;
}

/* Beside a convex A all of a leaf is put in place at once. */
static void set_levels_in_place(const mesh_walk *w, mesh_leaf *l)
{
    mesh_four_levels(mesh_leaf_place_b(w, l), w->axis, l->levels);
    l->level = min_of(min_of(l->levels[0], l->levels[1]), min_of(l->levels[2], l->levels[3]));
}

/* The greatest height of the triangles of A along the axis, or the least of B's, and that of each: from where they are
 * in their own frame, so that what is far by it need not be put in place. Without an axis all levels are 0. */
static void set_levels(const mesh_walk *w, mesh_leaf *l, bool of_a)
{
    l->aims = w->aims;
    if (!w->ma) {
        set_levels_in_place(w, l);
        return;
    }
    vec3 up = of_a ? w->axis : vec_neg(w->b_axis);
    double most = -INFINITY, lift = of_a ? 0 : vec_dot(w->axis, w->part.b_in_a.t);
    const vec3 *p = (of_a ? w->ma : w->mb)->corners + 3 * (size_t)l->first;
    for (uint32_t i = 0; i < l->count; i++, p += 3) {
        double level = max_of(max_of(vec_dot(up, p[0]), vec_dot(up, p[1])), vec_dot(up, p[2])) * w->part.scale;
        l->levels[i] = of_a ? level : lift - level;
        most = max_of(most, level);
    }
    l->level = of_a ? most : lift - most;
    for (uint32_t i = l->count; i < MESH_LEAF_MAX; i++) l->levels[i] = 0;
}

static mesh_leaf *leaf_of(mesh_walk *w, bool of_a, mesh_box box)
{
    uint32_t slot = (box.node * MESH_WIDTH + box.child) % MESH_LEAVES;
    mesh_leaf *l = (of_a ? w->leaves_a : w->leaves_b) + slot;
    mesh_box *known = (of_a ? w->known_a : w->known_b) + slot;
    if (known->node != box.node || known->child != box.child) {
        const mesh_node *n = &(of_a ? w->ma : w->mb)->nodes[box.node];
        *known = box;
        l->first = n->first[box.child];
        l->count = n->count[box.child];
        l->placed = false;
        l->aims = w->aims - 1;
    }
    if (l->aims != w->aims) set_levels(w, l, of_a);
    return l;
}

/* ---- a convex A and a leaf ---- */

/* Bit i: triangle i is not too far by its level. */
static unsigned near_levels(const mesh_walk *w, const mesh_leaf *b)
{
    double most = w->whole_level + farthest(w);
    unsigned near = 0;
    for (uint32_t i = 0; i < b->count; i++) near |= (unsigned)!(b->levels[i] > most) << i;
    return near;
}

/* The visitor may find a new axis. */
static bool visit_beside_core(mesh_walk *w, mesh_leaf *b, mesh_visit *visit, void *context)
{
    mesh_row row;
    unsigned near = near_levels(w, b);
    w->spot_a = &w->whole;
    if (!near) return true;
    const mesh_four *four = mesh_leaf_place_b(w, b);
    bool box = w->whole_a.type == SHAPE_BOX;
    near = (box ? mesh_row_near_box : mesh_row_near_core)(four, w->spot_a, near, farthest2(w), &row);
    for (uint32_t i = 0; near >> i; i++) {
        if (!(near >> i & 1) || row.away2[i] > farthest2(w) || !(near_levels(w, b) >> i & 1)) continue;
        mesh_four_spot(four, i, &w->visited);
        w->spot_b = &w->visited;
        w->triangle_b = b->first + i;
        if (box)
            w->lead = vec(row.lead[0][i], row.lead[1][i], row.lead[2][i]);
        else if (is_core_far(w))
            continue;
        w->visits++;
        uint32_t aims = w->aims;
        if (!visit(w, context)) return false;
        if (aims != w->aims) set_levels(w, b, false);
    }
    return true;
}

/* ---- two leaves ---- */

static void report_row(mesh_walk *w, const mesh_row *row, uint32_t i)
{
    w->lead = vec(row->lead[0][i], row->lead[1][i], row->lead[2][i]);
    w->from = vec(row->from[0][i], row->from[1][i], row->from[2][i]);
    w->edges = vec(row->edges[0][i], row->edges[1][i], row->edges[2][i]);
}

void mesh_leaf_visit_alone(mesh_walk *w, uint32_t triangle_a, uint32_t triangle_b)
{
    mesh_four a, b;
    mesh_row row;
    const mesh_picks only = {.count = 1};
    mesh_four_set(&b, w->mb->corners + 3 * (size_t)triangle_b, 1, w->part.scale, &w->part.b_in_a);
    mesh_four_spot(&b, 0, &w->visited);
    w->spot_b = &w->visited;
    w->triangle_b = triangle_b;
    w->spot_a = &w->whole;
    w->lead = between_boxes(w->spot_a, w->spot_b);
    if (!w->ma) return;
    mesh_four_set(&a, w->ma->corners + 3 * (size_t)triangle_a, 1, w->part.scale, NULL);
    mesh_four_spot(&a, 0, &w->visited_a);
    w->spot_a = &w->visited_a;
    w->triangle_a = triangle_a;
    w->edges = VEC_ZERO;
    if (mesh_row_near(&a, &b, &only, INFINITY, &row)) report_row(w, &row, 0);
}

static unsigned all_pairs(const mesh_leaf *a, const mesh_leaf *b)
{
    return ((1u << MESH_LEAF_MAX * a->count) - 1) & ((1u << b->count) - 1) * 0x1111;
}

/* The next pairs of `*pairs`, which are taken out. */
static void next_picks(unsigned *pairs, mesh_picks *p)
{
    *p = (mesh_picks){0};
    for (; *pairs && p->count < MESH_LEAF_MAX; p->count++, *pairs &= *pairs - 1) {
        unsigned pair = (unsigned)__builtin_ctz(*pairs);
        p->a |= pair / MESH_LEAF_MAX << 8 * p->count;
        p->b |= pair % MESH_LEAF_MAX << 8 * p->count;
    }
}

static bool is_far_by_now(
    const mesh_walk *w, const mesh_leaf *a, const mesh_leaf *b, const mesh_picks *p, const mesh_row *row, uint32_t i)
{
    return row->away2[i] > farthest2(w) || b->levels[mesh_pick(p->b, i)] - a->levels[mesh_pick(p->a, i)] > farthest(w);
}

/* The visitor may find a new axis. */
static bool visit_picks(mesh_walk *w, mesh_leaf *a, mesh_leaf *b, const mesh_picks *p, mesh_visit *visit, void *context)
{
    mesh_row row;
    if (w->effort) effort_spend(w->effort, EFFORT_ROW);
    unsigned near = mesh_row_near(&a->four, &b->four, p, farthest2(w), &row);
    for (uint32_t i = 0; near >> i; i++) {
        if (!(near >> i & 1) || is_far_by_now(w, a, b, p, &row, i)) continue;
        uint32_t of_a = mesh_pick(p->a, i), of_b = mesh_pick(p->b, i);
        mesh_four_spot(&a->four, of_a, &w->visited_a);
        mesh_four_spot(&b->four, of_b, &w->visited);
        w->spot_a = &w->visited_a;
        w->spot_b = &w->visited;
        w->triangle_a = a->first + of_a;
        w->triangle_b = b->first + of_b;
        report_row(w, &row, i);
        w->visits++;
        uint32_t aims = w->aims;
        if (!visit(w, context)) return false;
        if (aims == w->aims) continue;
        set_levels(w, a, true);
        set_levels(w, b, false);
    }
    return true;
}

bool mesh_leaves_visit(mesh_walk *w, mesh_box box_a, mesh_box box_b, mesh_visit *visit, void *context)
{
    mesh_leaf *b = leaf_of(w, false, box_b);
    if (!w->ma) return b->level - w->whole_level > farthest(w) || visit_beside_core(w, b, visit, context);
    mesh_leaf *a = leaf_of(w, true, box_a);
    if (b->level - a->level > farthest(w)) return true;
    unsigned pairs =
        mesh_fours_near(mesh_leaf_place_a(w, a), mesh_leaf_place_b(w, b), a->levels, b->levels, farthest(w)) &
        all_pairs(a, b);
    while (pairs) {
        mesh_picks picks;
        next_picks(&pairs, &picks);
        if (!visit_picks(w, a, b, &picks, visit, context)) return false;
    }
    return true;
}
