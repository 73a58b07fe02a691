/* The walk over one or two hierarchies. Pure; any thread.
 *
 * What is left out is left out by proof: boxes are rounded outward, and FLOAT_SLACK takes back what the arithmetic of
 * floats may have added to a bound. */
#include "mesh_walk.h"

#include "geom/mesh_simd.h"

/* Both of two boxes are opened where neither is more than this times as large as the other. */
#define BOTH_RATIO 2
/* So that a bound in floats is compared with no less than `within`. */
#define FLOAT_MORE (1 + 0x1p-20)

enum {
    CHILDREN = MESH_WIDTH * MESH_WIDTH, /* of a pair of boxes that are opened together */
    STACK = MESH_DEPTH_MAX * (CHILDREN - 1 + MESH_WIDTH - 1) + CHILDREN,
    QUEUE = 512,
    BUCKETS = 64
};

typedef mesh_boxes entry;

/* ---- patches along the axis ---- */

/* How far the patches of nodes of two meshes reach along the axis of a walk, and where those of A are as
 * B's nodes see them; what floats hold of that. What is known of a node serves
 * each pair that it is in. */

LANES_INLINE void stand_keep(float to[MESH_WIDTH], mesh_lanes v)
{
    memcpy(to, &v, sizeof v);
}

LANES_INLINE const mesh_stand *stand_of_b(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_b[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level, mesh_lows(w->mb, &w->mb->nodes[node], w->axis_in_b));
    return s;
}

LANES_INLINE const mesh_stand *stand_of_a(mesh_walk *w, uint32_t node)
{
    mesh_stand *s = &w->stands_a[node % MESH_STANDS];
    if (s->node == node && s->aims == w->aims) return s;
    s->node = node;
    s->aims = w->aims;
    stand_keep(s->level,
        floats_of(w->origin_level) - floats_of(w->into_b.ratio) * mesh_lows(w->ma, &w->ma->nodes[node], w->axis_in_a));
    return s;
}

/* A coordinate of four centres, in doubles: there terms may cancel. */
LANES_INLINE mesh_lanes faces_centre(const mesh_node *n, double x, double y, double z, double t)
{
    lanes cx = __builtin_convertvector(floats_load(n->centre[0]), lanes);
    lanes cy = __builtin_convertvector(floats_load(n->centre[1]), lanes);
    lanes cz = __builtin_convertvector(floats_load(n->centre[2]), lanes);
    return __builtin_convertvector(cx * x + cy * y + cz * z + t, mesh_lanes);
}

/* Four vectors turned, to[k] the k-th, as a row. Returns the sums of their coordinates' absolute values. */
LANES_INLINE mesh_lanes faces_turned(const mesh_turn *t, float ratio, const float v[3][MESH_WIDTH], mesh_lanes to[4])
{
    const mesh_lanes in[3] = {floats_load(v[0]), floats_load(v[1]), floats_load(v[2])};
    for (int i = 0; i < 3; i++) {
        const float row[3] = {t->column[0][i], t->column[1][i], t->column[2][i]};
        to[i] = floats_dot(in, row) * floats_of(ratio);
    }
    to[3] = floats_of(0);
    mesh_lanes sum = floats_abs(to[0]) + floats_abs(to[1]) + floats_abs(to[2]);
    floats_turn(to);
    return sum;
}

/* As `face` of mesh_walk.c, four at once. */
LANES_INLINE void faces_set(const mesh_turn *t, const mesh_node *n, mesh_faces *f)
{
    mesh_lanes centre[4] = {faces_centre(n, t->r.x.x, t->r.y.x, t->r.z.x, t->t.x),
        faces_centre(n, t->r.x.y, t->r.y.y, t->r.z.y, t->t.y), faces_centre(n, t->r.x.z, t->r.y.z, t->r.z.z, t->t.z)};
    mesh_lanes side_0[4], side_1[4], normal[4], half = floats_of(t->ratio) * floats_load(n->half);
    mesh_lanes reach = floats_abs(centre[0]) + floats_abs(centre[1]) + floats_abs(centre[2]);
    centre[3] = floats_of(0);
    floats_turn(centre);
    reach += faces_turned(t, t->ratio, n->side[0], side_0);
    reach += faces_turned(t, t->ratio, n->side[1], side_1);
    reach += faces_turned(t, 1, n->normal, normal) * half;
    mesh_lanes slack = floats_of(FLOAT_SLACK) * (reach + floats_of(4));
    for (uint32_t k = 0; k < MESH_WIDTH; k++) {
        mesh_patch_box *o = &f->box[k];
        stand_keep(o->centre, centre[k]);
        stand_keep(o->side[0], side_0[k]);
        stand_keep(o->side[1], side_1[k]);
        stand_keep(o->normal, normal[k]);
        o->half = half[k];
        o->slack = slack[k];
    }
}

LANES_INLINE const mesh_patch_box *faces_of_a(mesh_walk *w, uint32_t node)
{
    uint32_t slot = node % MESH_FACES;
    if (w->faced[slot] != node) faces_set(&w->into_b, &w->ma->nodes[node], &w->faces_a[slot]);
    w->faced[slot] = node;
    return w->faces_a[slot].box;
}

/* ---- bounds ---- */

LANES_INLINE mesh_lanes mesh_walk_turned(const mesh_turn *t, float x, float y, float z)
{
    return floats_of(x) * floats_load(t->column[0]) + floats_of(y) * floats_load(t->column[1]) +
           floats_of(z) * floats_load(t->column[2]);
}

LANES_INLINE float floats_sum3(mesh_lanes v)
{
    return v[0] + v[1] + v[2];
}

LANES_INLINE float top_along(const mesh_other *o)
{
    mesh_lanes axis = floats_load(o->axis);
    return floats_sum3(axis * floats_load(o->centre)) + fabsf(floats_sum3(axis * floats_load(o->side[0]))) +
           fabsf(floats_sum3(axis * floats_load(o->side[1]))) + fabsf(floats_sum3(axis * floats_load(o->side[2])));
}

LANES_INLINE void keep_side(mesh_other *o, int k, mesh_lanes side)
{
    memcpy(o->side[k], &side, sizeof side);
}

/* A box as the other mesh's nodes see it. The centre in doubles: there terms may cancel. */
LANES_INLINE void face(
    const mesh_turn *t, const mesh_node *n, uint32_t c, const float axis[MESH_WIDTH], bool aimed, mesh_other *o)
{
    vec3 centre = vec_add(t->t, mat_mul(t->r, vec(n->centre[0][c], n->centre[1][c], n->centre[2][c])));
    mesh_lanes ratio = floats_of(t->ratio),
               normal = mesh_walk_turned(t, n->normal[0][c], n->normal[1][c], n->normal[2][c]);
    mesh_lanes side_0 = ratio * mesh_walk_turned(t, n->side[0][0][c], n->side[0][1][c], n->side[0][2][c]);
    mesh_lanes side_1 = ratio * mesh_walk_turned(t, n->side[1][0][c], n->side[1][1][c], n->side[1][2][c]);
    o->half = t->ratio * n->half[c];
    mesh_lanes side_2 = normal * floats_of(o->half);
    put3(o->centre, centre);
    keep_side(o, 0, side_0);
    keep_side(o, 1, side_1);
    keep_side(o, 2, side_2);
    memcpy(o->normal, &normal, sizeof normal);
    double reach =
        vec_sum_magnitudes(centre) + (double)floats_sum3(floats_abs(side_0) + floats_abs(side_1) + floats_abs(side_2));
    o->flat = true;
    o->far = !(reach < FLOAT_FAR);
    o->slack = (float)(FLOAT_SLACK * (4 + reach));
    o->aimed = aimed;
    if (!aimed) return;
    memcpy(o->axis, axis, sizeof o->axis);
    o->level = top_along(o);
}

/* A box that is turned, in units of the pair, in the frame of its mesh. */
typedef struct turned_box {
    vec3 centre, side[3];
} turned_box;

static turned_box mesh_walk_box_of(const mesh *m, mesh_box r, double size)
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
static double mesh_walk_top_of(const turned_box *b, vec3 d)
{
    return vec_dot(d, b->centre) + fabs(vec_dot(d, b->side[0])) + fabs(vec_dot(d, b->side[1])) +
           fabs(vec_dot(d, b->side[2]));
}

static double top_in_a(const mesh_walk *w, mesh_box a)
{
    if (a.node == MESH_WHOLE) return w->whole_level;
    turned_box box = mesh_walk_box_of(w->ma, a, w->size_a);
    return mesh_walk_top_of(&box, w->axis);
}

static double foot_in_a(const mesh_walk *w, mesh_box b)
{
    turned_box box = mesh_walk_box_of(w->mb, b, w->size_b);
    return vec_dot(w->axis, w->part.b_in_a.t) - mesh_walk_top_of(&box, vec_neg(mat_tmul(w->part.b_in_a.r, w->axis)));
}

/* The bound of boxes that reach beyond the range of floats: along the axis, in doubles. */
static double bound_in_doubles(const mesh_walk *w, mesh_box a, mesh_box b)
{
    return w->aimed ? foot_in_a(w, b) - top_in_a(w, a) - w->part.error : -INFINITY;
}

/* ---- the walk ---- */

static const mesh_box ALL_OF_A = {MESH_WHOLE, 0, true};

LANES_INLINE mesh_box child_of(const mesh *m, uint32_t node, uint32_t child)
{
    return (mesh_box){node, (uint16_t)child, m->nodes[node].count[child] > 0};
}

LANES_INLINE unsigned all_of(const mesh_node *n)
{
    return (1u << n->used) - 1;
}

/* Pairs of boxes, the nearest last. */
LANES_INLINE void put_sorted(entry *more, uint32_t *count, entry e)
{
    uint32_t k = (*count)++;
    for (; k > 0 && e.bound > more[k - 1].bound; k--) more[k] = more[k - 1];
    more[k] = e;
}

/* Bit k: box k of a node is near enough to the other. `size`, `bounds`: the node's unit, and in it. */
LANES_INLINE unsigned near_boxes(
    const mesh_walk *w, const mesh *m, const mesh_node *n, const mesh_other *o, double size, float bounds[])
{
    return mesh_bounds(m, n, o, (float)((w->within + w->part.error) / size * FLOAT_MORE), bounds);
}

LANES_INLINE uint32_t expand_b(const mesh_walk *w, mesh_box a, uint32_t node, entry more[MESH_WIDTH])
{
    const mesh_node *n = &w->mb->nodes[node];
    mesh_other other;
    const mesh_other *o = &w->whole_other;
    float bounds[MESH_WIDTH];
    uint32_t count = 0;
    if (a.node != MESH_WHOLE) {
        face(&w->into_b, &w->ma->nodes[a.node], a.child, w->axis_in_b, w->aimed, &other);
        o = &other;
    }
    unsigned near = o->far ? all_of(n) : near_boxes(w, w->mb, n, o, w->size_b, bounds);
    for (uint32_t i = 0; near; i++, near >>= 1) {
        if (!(near & 1)) continue;
        mesh_box b = child_of(w->mb, node, i);
        double bound = o->far ? bound_in_doubles(w, a, b) : (double)bounds[i] * w->size_b - w->part.error;
        if (!(bound > w->within)) put_sorted(more, &count, (entry){a, b, bound});
    }
    return count;
}

LANES_INLINE uint32_t expand_a(const mesh_walk *w, uint32_t node, mesh_box b, entry more[MESH_WIDTH])
{
    const mesh_node *n = &w->ma->nodes[node];
    mesh_other o;
    float bounds[MESH_WIDTH];
    uint32_t count = 0;
    face(&w->into_a, &w->mb->nodes[b.node], b.child, w->axis_in_a, w->aimed, &o);
    unsigned near = o.far ? all_of(n) : near_boxes(w, w->ma, n, &o, w->size_a, bounds);
    for (uint32_t i = 0; near; i++, near >>= 1) {
        if (!(near & 1)) continue;
        mesh_box a = child_of(w->ma, node, i);
        double bound = o.far ? bound_in_doubles(w, a, b) : (double)bounds[i] * w->size_a - w->part.error;
        if (!(bound > w->within)) put_sorted(more, &count, (entry){a, b, bound});
    }
    return count;
}

/* Both are opened, and there is no axis yet. */
LANES_INLINE uint32_t expand_both(const mesh_walk *w, uint32_t node_a, uint32_t node_b, entry more[CHILDREN])
{
    const mesh_node *na = &w->ma->nodes[node_a], *nb = &w->mb->nodes[node_b];
    float bounds[MESH_WIDTH], limit = (float)((w->within + w->part.error) / w->size_b * FLOAT_MORE);
    uint32_t count = 0;
    for (uint32_t k = 0; k < na->used; k++) {
        mesh_other o;
        face(&w->into_b, na, k, w->axis_in_b, false, &o);
        unsigned near = mesh_bounds_from(nb, &o, floats_of(-INFINITY), all_of(nb), limit, bounds);
        for (uint32_t i = 0; near; i++, near >>= 1) {
            double bound = (double)bounds[i] * w->size_b - w->part.error;
            if (near & 1 && !(bound > w->within))
                more[count++] = (entry){child_of(w->ma, node_a, k), child_of(w->mb, node_b, i), bound};
        }
    }
    return count;
}

/* Boxes `rows` of a node of A and `columns` of one of B. */
LANES_INLINE uint32_t expand_known(
    mesh_walk *w, uint32_t node_a, unsigned rows, uint32_t node_b, unsigned columns, entry more[CHILDREN])
{
    const mesh_stand *a = stand_of_a(w, node_a), *b = stand_of_b(w, node_b);
    const mesh_patch_box *faces = NULL;
    const mesh_node *nb = &w->mb->nodes[node_b];
    float bounds[MESH_WIDTH], limit = (float)((w->within + w->part.error) / w->size_b * FLOAT_MORE);
    mesh_lanes feet = floats_load(b->level) - floats_of(w->open_slack);
    uint32_t count = 0;
    for (; rows; rows &= rows - 1) {
        uint32_t k = (uint32_t)__builtin_ctz(rows);
        mesh_lanes along = feet - floats_of(a->level[k]);
        unsigned near = floats_not_above(along, floats_of(limit)) & columns;
        if (!near) continue;
        if (!faces) faces = faces_of_a(w, node_a);
        near = mesh_patch_bounds(nb, &faces[k], along, near, limit, bounds);
        mesh_box box_a = child_of(w->ma, node_a, k);
        for (; near; near &= near - 1) {
            uint32_t i = (uint32_t)__builtin_ctz(near);
            more[count++] = (entry){box_a, child_of(w->mb, node_b, i), (double)bounds[i] * w->size_b - w->part.error};
        }
    }
    return count;
}

LANES_INLINE double size_of(const mesh *m, mesh_box r, double size)
{
    return (double)m->nodes[r.node].size[r.child] * size;
}

LANES_INLINE uint32_t node_below(const mesh *m, mesh_box r)
{
    return m->nodes[r.node].first[r.child];
}

/* Either box, or both, are opened. */
LANES_INLINE uint32_t expand_aimed(mesh_walk *w, const entry *e, bool open_a, bool open_b, entry more[CHILDREN])
{
    uint32_t a = open_a ? node_below(w->ma, e->a) : e->a.node, b = open_b ? node_below(w->mb, e->b) : e->b.node;
    unsigned rows = open_a ? all_of(&w->ma->nodes[a]) : 1u << e->a.child;
    return expand_known(w, a, rows, b, open_b ? all_of(&w->mb->nodes[b]) : 1u << e->b.child, more);
}

/* Both boxes are opened where they are of about one size, otherwise the larger. */
LANES_INLINE uint32_t mesh_walk_expand(mesh_walk *w, const entry *e, entry more[CHILDREN])
{
    bool keep_a = e->a.leaf, keep_b = e->b.leaf, open_both = false;
    if (!keep_a && !keep_b) {
        double a = size_of(w->ma, e->a, w->size_a), b = size_of(w->mb, e->b, w->size_b);
        open_both = w->opens_both && !(a > BOTH_RATIO * b || b > BOTH_RATIO * a);
        keep_a = b >= a;
        keep_b = a > b;
    }
    return w->opens_both && w->aimed ? expand_aimed(w, e, !keep_a || open_both, !keep_b || open_both, more)
           : open_both               ? expand_both(w, node_below(w->ma, e->a), node_below(w->mb, e->b), more)
           : keep_a                  ? expand_b(w, e->a, node_below(w->mb, e->b), more)
                                     : expand_a(w, node_below(w->ma, e->a), e->b, more);
}

/* ---- the end of the effort ---- */

/* False: there is none left. */
LANES_INLINE bool mesh_walk_go_on(mesh_walk *w, bool leaves)
{
    return !w->effort || effort_spend(w->effort, leaves ? EFFORT_LEAVES : EFFORT_NODES);
}

static void leave(mesh_walk *w, const entry *e)
{
    if (e->bound < w->unseen) w->unseen = e->bound;
}

static void mesh_walk_leave_all(mesh_walk *w, const entry *e, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++) leave(w, &e[i]);
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
        if (!mesh_walk_go_on(w, e.a.leaf && e.b.leaf)) {
            mesh_walk_leave_all(w, stack, open + 1);
            return false;
        }
        if (!(e.a.leaf && e.b.leaf))
            open += mesh_walk_expand(w, &e, stack + open);
        else if (!mesh_leaves_visit(w, e.a, e.b, visit, context))
            return false;
    }
    return true;
}

/* The pairs of boxes to begin with. */
LANES_INLINE uint32_t mesh_walk_start(mesh_walk *w, entry first[CHILDREN])
{
    uint32_t count = 0;
    if (w->ma && w->opens_both && w->aimed)
        return expand_known(w, 0, all_of(&w->ma->nodes[0]), 0, all_of(&w->mb->nodes[0]), first);
    if (!w->ma) return expand_b(w, ALL_OF_A, 0, first);
    for (uint32_t i = 0; i < w->ma->nodes[0].used; i++) count += expand_b(w, child_of(w->ma, 0, i), 0, first + count);
    return count;
}

void mesh_walk_run(mesh_walk *w, mesh_visit *visit, void *context)
{
    entry first[CHILDREN];
    uint32_t count = mesh_walk_start(w, first);
    w->unseen = INFINITY;
    while (count)
        if (!run_below(w, &first[--count], visit, context)) break;
    if (w->unseen < INFINITY) mesh_walk_leave_all(w, first, count);
}

bool mesh_walk_is_clear(const mesh_walk *w, bool of_a, uint32_t node, uint32_t child)
{
    const mesh_box box = child_of(of_a ? w->ma : w->mb, node, child);
    uint32_t stack[MESH_DEPTH_MAX * MESH_WIDTH], open = 0;
    stack[open++] = 0;
    while (open) {
        entry more[MESH_WIDTH];
        uint32_t other = stack[--open], count = of_a ? expand_b(w, box, other, more) : expand_a(w, other, box, more);
        for (uint32_t i = 0; i < count; i++) {
            mesh_box near = of_a ? more[i].b : more[i].a;
            if (near.leaf) return false;
            stack[open++] = node_below(of_a ? w->mb : w->ma, near);
        }
    }
    return true;
}

/* ---- nearest first: pairs of boxes in buckets, by their bounds; of a bucket the last that came ---- */

typedef struct queue {
    entry entries[QUEUE];
    uint16_t next[QUEUE], unused; /* QUEUE: none */
    uint16_t head[BUCKETS];
    uint64_t filled; /* buckets */
    uint32_t count;
    double per_bucket;
} queue;

LANES_INLINE void queue_init(queue *q, double greatest_bound)
{
    for (uint32_t i = 0; i < QUEUE; i++) q->next[i] = (uint16_t)(i + 1);
    q->unused = 0;
    q->filled = 0;
    q->count = 0;
    q->per_bucket = greatest_bound > 0 ? (BUCKETS - 1) / greatest_bound : 0;
}

LANES_INLINE void queue_push(queue *q, const entry *e)
{
    double place = e->bound * q->per_bucket;
    int bucket = !(place > 0) ? 0 : place < BUCKETS - 1 ? (int)place : BUCKETS - 1;
    uint16_t at = q->unused;
    q->unused = q->next[at];
    q->entries[at] = *e;
    q->next[at] = q->filled >> bucket & 1 ? q->head[bucket] : QUEUE;
    q->head[bucket] = at;
    q->filled |= (uint64_t)1 << bucket;
    q->count++;
}

LANES_INLINE entry queue_pop(queue *q)
{
    int bucket = __builtin_ctzll(q->filled);
    uint16_t at = q->head[bucket];
    q->head[bucket] = q->next[at];
    if (q->head[bucket] == QUEUE) q->filled &= q->filled - 1;
    q->next[at] = q->unused;
    q->unused = at;
    q->count--;
    return q->entries[at];
}

static void leave_queue(mesh_walk *w, queue *q)
{
    while (q->count) {
        entry e = queue_pop(q);
        leave(w, &e);
    }
}

static vec3 mesh_walk_centre_of(const mesh_walk *w, mesh_box a)
{
    if (a.node == MESH_WHOLE) return vec_scale(vec_add(w->whole.lo, w->whole.hi), 0.5);
    const mesh_node *n = &w->ma->nodes[a.node];
    return vec_scale(vec(n->centre[0][a.child], n->centre[1][a.child], n->centre[2][a.child]), w->size_a);
}

static mesh_box nearest_child(const mesh *m, uint32_t node, vec3 point)
{
    const mesh_node *n = &m->nodes[node];
    uint32_t nearest = 0;
    double least = INFINITY;
    for (uint32_t i = 0; i < n->used; i++) {
        double away2 = vec_norm2(vec_sub(vec(n->centre[0][i], n->centre[1][i], n->centre[2][i]), point));
        if (away2 < least) least = away2, nearest = i;
    }
    return child_of(m, node, nearest);
}

static vec3 in_a(const mesh_walk *w, mesh_box b)
{
    const mesh_node *n = &w->mb->nodes[b.node];
    vec3 centre = vec_scale(vec(n->centre[0][b.child], n->centre[1][b.child], n->centre[2][b.child]), w->size_b);
    return transform_point(&w->part.b_in_a, centre);
}

/* Visits the pair of leaves whose boxes' centres are nearest to each other, as a way down by the nearest centres finds
 * it: its triangles are near enough to spare the walk most of the rest. */
bool mesh_walk_plunge(mesh_walk *w, mesh_visit *visit, void *context)
{
    mesh_box a = ALL_OF_A, b;
    vec3 from = VEC_ZERO;
    if (w->ma) {
        a = nearest_child(w->ma, 0, vec_scale(w->part.b_in_a.t, 1 / w->size_a));
        from = mesh_walk_centre_of(w, a);
    }
    b = nearest_child(w->mb, 0, vec_scale(transform_point(&w->a_in_b, from), 1 / w->size_b));
    while (!a.leaf || !b.leaf) {
        if (!a.leaf) a = nearest_child(w->ma, node_below(w->ma, a), vec_scale(in_a(w, b), 1 / w->size_a));
        if (b.leaf) continue;
        from = transform_point(&w->a_in_b, mesh_walk_centre_of(w, a));
        b = nearest_child(w->mb, node_below(w->mb, b), vec_scale(from, 1 / w->size_b));
    }
    entry e = {a, b, 0};
    return mesh_leaves_visit(w, e.a, e.b, visit, context);
}

LANES_INLINE void walk_nearest(mesh_walk *w, const mesh_front *from, mesh_visit *visit, void *context)
{
    queue q;
    entry more[CHILDREN];
    uint32_t count = from ? from->count : mesh_walk_start(w, more);
    queue_init(&q, w->within < w->part.size ? w->within : w->part.size);
    for (uint32_t i = 0; i < count; i++) queue_push(&q, from ? &from->at[i] : &more[i]);
    while (q.count) {
        entry e = queue_pop(&q);
        if (e.bound > w->within) continue;
        bool full = q.count + CHILDREN > QUEUE, leaves = e.a.leaf && e.b.leaf, ended = !mesh_walk_go_on(w, leaves);
        if (ended) leave(w, &e);
        if (ended ||
            (leaves ? !mesh_leaves_visit(w, e.a, e.b, visit, context) : full && !run_below(w, &e, visit, context))) {
            if (ended || w->unseen < INFINITY) leave_queue(w, &q);
            return;
        }
        if (leaves || full) continue;
        count = mesh_walk_expand(w, &e, more);
        for (uint32_t i = 0; i < count; i++) queue_push(&q, &more[i]);
    }
}

LANES_TWINS(LANES_WIDE, void, nearest_first, walk_nearest,
    (mesh_walk *const w, const mesh_front *from, mesh_visit *visit, void *context), (w, from, visit, context));

void mesh_walk_nearest(mesh_walk *w, const mesh_front *from, mesh_visit *visit, void *context)
{
    w->unseen = INFINITY;
    LANES_CHOSEN(nearest_first)(w, from, visit, context);
}

/* ---- how long a walk can be ---- */

/* Each node hands at most a quarter of its leaves, rounded up, to a child (mesh_tree.c). */
static uint32_t below(uint32_t leaves)
{
    return (leaves + MESH_WIDTH - 1) / MESH_WIDTH;
}

static uint32_t leaves_of(const mesh *m)
{
    return m ? (m->triangle_count + MESH_LEAF_MAX - 1) / MESH_LEAF_MAX : 1;
}

static bool is_same(mesh_box x, mesh_box y)
{
    return x.node == y.node && x.child == y.child;
}

/* A pair of boxes, and at most how many leaves are below either. */
typedef struct counted {
    entry e;
    uint32_t a, b;
} counted;

static double pairs_below(const counted *c, uint32_t count)
{
    double sum = 0;
    for (uint32_t i = 0; i < count; i++) sum += (double)c[i].a * c[i].b;
    return sum;
}

/* One level further; 0 where there is no place for all of them. */
static uint32_t open_level(mesh_walk *w, const counted *from, uint32_t count, counted *to)
{
    uint32_t n = 0;
    for (uint32_t i = 0; i < count; i++) {
        entry more[CHILDREN] = {from[i].e};
        bool leaves = from[i].e.a.leaf && from[i].e.b.leaf;
        uint32_t found = leaves ? 1 : mesh_walk_expand(w, &from[i].e, more);
        if (n + found > MESH_FRONT) return 0;
        for (uint32_t k = 0; k < found; k++) {
            bool same_a = is_same(more[k].a, from[i].e.a), same_b = is_same(more[k].b, from[i].e.b);
            uint32_t a = same_a ? from[i].a : below(from[i].a), b = same_b ? from[i].b : below(from[i].b);
            to[n++] = (counted){more[k], more[k].a.leaf ? 1 : a, more[k].b.leaf ? 1 : b};
        }
    }
    return n;
}

double mesh_walk_leaves(const mesh_walk *w)
{
    return (double)leaves_of(w->ma) * leaves_of(w->mb);
}

bool mesh_walk_is_short(mesh_walk *w, double leaves, mesh_front *front)
{
    counted now[MESH_FRONT], next[MESH_FRONT];
    entry first[CHILDREN];
    uint32_t a = leaves_of(w->ma), b = leaves_of(w->mb), count = mesh_walk_start(w, first);
    for (uint32_t i = 0; i < count; i++) now[i] = (counted){first[i], w->ma ? below(a) : 1, below(b)};
    while (pairs_below(now, count) > leaves) {
        count = open_level(w, now, count, next);
        if (count == 0) return false;
        memcpy(now, next, count * sizeof *now);
    }
    front->count = count;
    for (uint32_t i = 0; i < count; i++) front->at[i] = now[i].e;
    return true;
}
