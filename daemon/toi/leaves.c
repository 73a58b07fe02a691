/* Heights of two leaves' triangles along directions, at both ends of pieces of the motion. Pure; any thread. */
#include "geom/simd.h"
#include "narrow/math/scalar.h"
#include "sweep.h"

typedef struct leaf { /* a triangle a lane; the last one again where there are fewer */
    lanes3 corner[3];
    vec3 normal[MESH_LEAF_MAX]; /* unit, or zero */
    uint32_t count;
    double margin;
} leaf;

bool toi_leaves_apply(const toi_part *p)
{
    return !p->is_leaf && p->whole->type == SHAPE_MESH && p->form == TOI_PART_BOX && p->child != TOI_WHOLE_NODE;
}

static void leaves_load(const toi_part *p, leaf *out)
{
    const mesh *m = p->whole->mesh;
    const mesh_node *n = &m->nodes[p->node];
    out->count = n->count[p->child];
    out->margin = p->whole->radius;
    for (uint32_t k = 0; k < LANES; k++) {
        const vec3 *v = &m->corners[3 * (n->first[p->child] + (k < out->count ? k : out->count - 1))];
        for (int c = 0; c < 3; c++)
            out->corner[c].x[k] = v[c].x, out->corner[c].y[k] = v[c].y, out->corner[c].z[k] = v[c].z;
        if (k < out->count) out->normal[k] = direction_of(vec_cross(vec_sub(v[1], v[0]), vec_sub(v[2], v[0])));
    }
}

typedef struct heights {
    lanes least, most;
} heights;

LANES_INLINE lanes leaves_least_of(lanes a, lanes b)
{
    return lanes_choose(a < b, a, b);
}
LANES_INLINE lanes leaves_most_of(lanes a, lanes b)
{
    return lanes_choose(a > b, a, b);
}

/* Along a unit direction of the course's frame. */
LANES_INLINE heights heights_of(const leaf *l, const transform *at, vec3 d)
{
    vec3 own = mat_tmul(at->r, d);
    lanes3 to = {lanes_of(own.x), lanes_of(own.y), lanes_of(own.z)};
    lanes u = lanes3_dot(to, l->corner[0]), v = lanes3_dot(to, l->corner[1]), w = lanes3_dot(to, l->corner[2]);
    lanes origin = lanes_of(vec_dot(d, at->t));
    return (heights){
        leaves_least_of(u, leaves_least_of(v, w)) + origin, leaves_most_of(u, leaves_most_of(v, w)) + origin};
}

enum {
    DIRECTIONS_MAX = 2 * MESH_LEAF_MAX, /* across each triangle of both */
    TRIED_SIDES = 8                     /* what those of one pair take, in directions of all */
};

static const double MUCH_CLOSER = 0.1;

typedef struct looked { /* along a direction, at the beginning of a piece */
    vec3 d;
    double share; /* of the dip that it has */
    heights a, b;
} looked;

typedef struct leaves {
    leaf a, b;
    looked at[DIRECTIONS_MAX];
    uint32_t count;
    lanes best[MESH_LEAF_MAX]; /* m: the widest gap of triangle i of A and each of B, then, for all of the dip */
    unsigned sided;            /* of pairs: none of the directions is of use, but its own */
    vec3 own[LEAF_PAIRS];
} leaves;

LANES_INLINE void look_across(const sweep *s, leaves *l, const leaf *of, const transform *turn, const sweep_place *p)
{
    lanes floor = lanes_of(l->a.margin + l->b.margin + p->floor);
    for (uint32_t k = 0; k < of->count; k++) {
        looked *x = &l->at[l->count++];
        x->d = mat_mul(turn->r, of->normal[k]);
        x->share = sweep_share(s, x->d);
        lanes weight = lanes_of(1 / x->share);
        x->a = heights_of(&l->a, &p->a, x->d);
        x->b = heights_of(&l->b, &p->b, x->d);
        for (int i = 0; i < MESH_LEAF_MAX; i++) {
            lanes above = x->b.least - lanes_of(x->a.most[i]), below = lanes_of(x->a.least[i]) - x->b.most;
            l->best[i] = leaves_most_of(l->best[i], (leaves_most_of(above, below) - floor) * weight);
        }
    }
}

LANES_INLINE void look_at_beginning(const sweep *s, leaves *l, const sweep_place *p)
{
    l->count = 0;
    for (int i = 0; i < MESH_LEAF_MAX; i++) l->best[i] = lanes_of(-INFINITY);
    look_across(s, l, &l->b, &p->b, p);
    look_across(s, l, &l->a, &p->a, p);
}

typedef struct piece {
    const sweep *s;
    const sweep_place *from, *to;
    double dip;
    double share; /* of it that matters: gaps are above their chord less the dip */
} piece;

/* sweep_keeps_open, lane by lane; or, up to the share that matters, above the chord less the dip. */
LANES_INLINE lane_mask stay_open(lanes first, lanes last, lanes dip, lanes share)
{
    lanes bow = 4 * dip, change = last - first, slow = bow - leaves_most_of(change, -change);
    lanes sag = lanes_choose(slow > 0, slow * slow / (4 * bow) * (1 + 0x1p-40), lanes_of(0));
    lanes less = leaves_least_of(first, first + share * change);
    return ((first > sag) & (last > sag)) | (less > dip);
}

/* Bit MESH_LEAF_MAX i + k: triangle i of A and k of B are apart by more than the dip along one of the directions, the
 * same way at both ends of a piece. */
LANES_INLINE unsigned free_pairs(const leaves *l, const piece *p, unsigned open, uint32_t *tried)
{
    lanes share = lanes_of(p->share);
    unsigned free = 0;
    for (uint32_t k = 0; k < l->count && (open & ~free); k++) {
        const looked *x = &l->at[k];
        double apart = l->a.margin + l->b.margin;
        lanes first = lanes_of(apart + p->from->floor), last = lanes_of(apart + p->to->floor);
        lanes dip = lanes_of(p->dip * x->share);
        heights a = heights_of(&l->a, &p->to->a, x->d), b = heights_of(&l->b, &p->to->b, x->d);
        lanes over_first = x->a.most + first, over_last = a.most + last;
        lanes under_first = x->a.least - first, under_last = a.least - last;
        for (int i = 0; i < MESH_LEAF_MAX; i++) {
            lanes above = x->b.least - lanes_of(over_first[i]), below = lanes_of(under_first[i]) - x->b.most;
            lanes above_last = b.least - lanes_of(over_last[i]), below_last = lanes_of(under_last[i]) - b.most;
            lane_mask open_above = stay_open(above, above_last, dip, share);
            lane_mask open_below = stay_open(below, below_last, dip, share);
            free |= lanes_bits(open_above | open_below) << (MESH_LEAF_MAX * i);
        }
        ++*tried;
    }
    return free;
}

LANES_TWINS(LANES_WHOLE, void, begin, look_at_beginning, (const sweep *s, leaves *l, const sweep_place *p), (s, l, p));

LANES_TWINS(LANES_WHOLE, unsigned, free, free_pairs, (const leaves *l, const piece *p, unsigned open, uint32_t *tried),
    (l, p, open, tried));

/* ---- one pair ---- */

static vec3 corner_at(const leaf *l, int triangle, int corner, const transform *at)
{
    const lanes3 *c = &l->corner[corner];
    return transform_point(at, vec(c->x[triangle], c->y[triangle], c->z[triangle]));
}

typedef struct two_triangles { /* at a place */
    vec3 a[3], b[3];
    double apart; /* m: a lesser gap counts as none */
} two_triangles;

static two_triangles pair_at(const leaves *l, int pair, const sweep_place *p)
{
    two_triangles t = {.apart = l->a.margin + l->b.margin + p->floor};
    for (int c = 0; c < 3; c++) {
        t.a[c] = corner_at(&l->a, pair / MESH_LEAF_MAX, c, &p->a);
        t.b[c] = corner_at(&l->b, pair % MESH_LEAF_MAX, c, &p->b);
    }
    return t;
}

static double leaves_gap_along(const two_triangles *t, vec3 d)
{
    double top = max_of(vec_dot(d, t->a[0]), max_of(vec_dot(d, t->a[1]), vec_dot(d, t->a[2])));
    return min_of(vec_dot(d, t->b[0]), min_of(vec_dot(d, t->b[1]), vec_dot(d, t->b[2]))) - top - t->apart;
}

/* The gap of one pair of triangles along a direction, with both shapes at a given place. */
static double leaves_gap_of(const leaves *l, int pair, const sweep_place *at, vec3 d)
{
    vec3 in_a = mat_tmul(at->a.r, d), in_b = mat_tmul(at->b.r, d);
    int i = pair / MESH_LEAF_MAX, k = pair % MESH_LEAF_MAX;
    double top = -INFINITY, foot = INFINITY;
    for (int c = 0; c < 3; c++) {
        const lanes3 *a = &l->a.corner[c], *b = &l->b.corner[c];
        top = max_of(top, in_a.x * a->x[i] + in_a.y * a->y[i] + in_a.z * a->z[i]);
        foot = min_of(foot, in_b.x * b->x[k] + in_b.y * b->y[k] + in_b.z * b->z[k]);
    }
    return foot - top + vec_dot(d, vec_sub(at->b.t, at->a.t)) - l->a.margin - l->b.margin - at->floor;
}

typedef struct chosen { /* the direction of a pair that keeps the widest gap at both ends of a piece */
    two_triangles first, last;
    vec3 d;
    double kept; /* m */
} chosen;

static void leaves_offer(chosen *c, vec3 towards, vec3 against)
{
    double norm2 = vec_norm2(towards);
    if (!(norm2 > 0)) return;
    vec3 d = direction_of(vec_dot(towards, against) > 0 ? vec_neg(towards) : towards);
    double gap = leaves_gap_along(&c->first, d);
    if (gap > c->kept) gap = min_of(gap, leaves_gap_along(&c->last, d));
    if (gap > c->kept) c->kept = gap, c->d = d;
}

/* Across a side of each, with A behind its own; and in the plane of one, across a side of it. Where two triangles are
 * apart, one of these or of their normals says so. */
static chosen best_of_sides(const leaves *l, int pair, const piece *p)
{
    chosen c = {pair_at(l, pair, p->from), pair_at(l, pair, p->to), VEC_ZERO, 0};
    const two_triangles *t = &c.first;
    vec3 side_a[3], side_b[3];
    for (int k = 0; k < 3; k++) {
        side_a[k] = vec_sub(t->a[(k + 1) % 3], t->a[k]);
        side_b[k] = vec_sub(t->b[(k + 1) % 3], t->b[k]);
    }
    vec3 normal_a = vec_cross(side_a[0], side_a[1]), normal_b = vec_cross(side_b[0], side_b[1]);
    for (int i = 0; i < 3; i++) {
        vec3 in_a = vec_neg(side_a[(i + 2) % 3]), out_b = side_b[(i + 2) % 3];
        for (int k = 0; k < 3; k++) leaves_offer(&c, vec_cross(side_a[i], side_b[k]), in_a);
        leaves_offer(&c, vec_cross(side_a[i], normal_a), in_a);
        leaves_offer(&c, vec_cross(side_b[i], normal_b), out_b);
    }
    return c;
}

/* Does a direction keep a pair apart all along a piece? */
static bool keeps(const leaves *l, int pair, const piece *p, vec3 d)
{
    double dip = p->dip * sweep_share(p->s, d), first = leaves_gap_of(l, pair, p->from, d);
    if (!(first > 0)) return false;
    double last = leaves_gap_of(l, pair, p->to, d), less = min_of(first, first + p->share * (last - first));
    return sweep_keeps_open(first, last, dip) || less > dip;
}

static unsigned free_by_sides(const leaves *l, const piece *p, unsigned open)
{
    unsigned free = 0;
    for (int i = 0; i < LEAF_PAIRS; i++)
        if (open >> i & 1 && keeps(l, i, p, l->own[i])) free |= 1u << i;
    return free;
}

/* What directions across triangles do not keep apart is given one of its own, if there is one: that of the pair before,
 * or the best. Those that it keeps apart. */
static unsigned turn_to_sides(leaves *l, const piece *p, unsigned pairs, uint32_t *tried)
{
    unsigned free = 0;
    vec3 before = VEC_ZERO;
    for (int i = 0; i < LEAF_PAIRS; i++) {
        if (!(pairs >> i & 1)) continue;
        l->sided |= 1u << i;
        if (vec_greatest(before) > 0 && keeps(l, i, p, before)) {
            l->own[i] = before;
            free |= 1u << i;
            continue;
        }
        chosen c = best_of_sides(l, i, p);
        *tried += TRIED_SIDES;
        l->own[i] = c.d;
        if (!(c.kept > 0)) l->sided &= ~(1u << i);
        if (!(c.kept > 0) || !keeps(l, i, p, c.d)) continue;
        before = c.d;
        free |= 1u << i;
    }
    return free;
}

/* How far apart pairs are at the beginning: the closest of those that are not much closer than the farthest are. The
 * others are in *close. A direction of its own that is of no use any more is forgotten. */
static double typical_gap(const sweep *s, leaves *l, const sweep_place *at, unsigned open, unsigned *close)
{
    double gaps[LEAF_PAIRS], most = 0, least = INFINITY;
    for (int i = 0; i < LEAF_PAIRS; i++) {
        if (!(open >> i & 1)) continue;
        gaps[i] = l->best[i / MESH_LEAF_MAX][i % MESH_LEAF_MAX];
        if (l->sided >> i & 1) {
            double own = leaves_gap_of(l, i, at, l->own[i]) / sweep_share(s, l->own[i]);
            if (!(own > gaps[i])) l->sided &= ~(1u << i);
            gaps[i] = max_of(own, gaps[i]);
        }
        most = max_of(most, gaps[i]);
    }
    *close = 0;
    for (int i = 0; i < LEAF_PAIRS; i++) {
        if (!(open >> i & 1)) continue;
        if (gaps[i] > MUCH_CLOSER * most)
            least = min_of(least, gaps[i]);
        else
            *close |= 1u << i;
    }
    return least;
}

static unsigned free_in(leaves *l, const piece *p, unsigned open, uint32_t *tried)
{
    unsigned sided = open & l->sided, free = free_by_sides(l, p, sided);
    return free | LANES_CHOSEN(free)(l, p, open & ~sided, tried);
}

/* ---- a stretch ---- */

static void enter(double entry[LEAF_PAIRS], unsigned pairs, double time)
{
    for (int i = 0; i < LEAF_PAIRS; i++)
        if (pairs >> i & 1) entry[i] = time;
}

/* From one piece to the next, each as long as gaps allow. */
static void find_entries(sweep *s, leaves *l, double from, double until, double entry[LEAF_PAIRS])
{
    unsigned open = 0;
    for (uint32_t i = 0; i < LEAF_PAIRS; i++) {
        entry[i] = INFINITY;
        if (i / MESH_LEAF_MAX < l->a.count && i % MESH_LEAF_MAX < l->b.count) open |= 1u << i;
    }
    double time = sweep_index(s, from), end = sweep_index(s, until);
    while (open && time < s->ends && sweep_time(s, time) <= until) {
        uint32_t first = (uint32_t)time, length = s->whole, tried = 0;
        sweep_place at = *sweep_place_at(s, first);
        LANES_CHOSEN(begin)(s, l, &at);
        tried += l->count;
        unsigned close;
        double typical = typical_gap(s, l, &at, open, &close), now = max_of(sweep_time(s, time), from);
        while (length > 1 && (first % length != 0 || first + length > s->ends || sweep_dip(s, length) > 0.5 * typical))
            length /= SWEEP_CUT;
        for (bool is_first = true; open; is_first = false) {
            piece p = {s, &at, sweep_place_at(s, first + length), sweep_dip(s, length),
                min_of((end - first) / length * (1 + 0x1p-40), 1)};
            unsigned left = open & ~free_in(l, &p, open, &tried);
            unsigned turned = length == 1 ? left : is_first ? left & close : 0;
            if (turned) left &= ~turn_to_sides(l, &p, turned, &tried);
            if (left && length == 1) enter(entry, left, now);
            if (length == 1) open &= ~left;
            if (!left || length == 1) break;
            length /= SWEEP_CUT;
        }
        s->work += SWEEP_WORK_LEAVES_TRY * (uint64_t)tried;
        time = first + length;
    }
}

void toi_leaves_entries(
    sweep *s, const toi_part *a, const toi_part *b, double from, double until, double entry[LEAF_PAIRS])
{
    leaves l;
    l.sided = 0;
    leaves_load(a, &l.a);
    leaves_load(b, &l.b);
    s->work += SWEEP_WORK_LEAVES;
    find_entries(s, &l, from, until, entry);
}
