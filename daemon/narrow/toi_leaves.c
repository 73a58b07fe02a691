/* Heights of two leaves' triangles along directions, at both ends of pieces of the motion. Pure; any thread. */
#include "toi_leaves.h"

#include "lanes.h"
#include "scalar.h"

typedef struct leaf { /* a triangle a lane; the last one again where there are fewer */
    lanes3 corner[3];
    lanes3 normal; /* of any length */
    uint32_t count;
    double margin;
} leaf;

bool toi_leaves_apply(const toi_part *p)
{
    return !p->is_leaf && p->whole->type == SHAPE_MESH && p->form == TOI_PART_BOX && p->child != TOI_WHOLE_NODE;
}

static void load(const toi_part *p, leaf *out)
{
    const mesh *m = p->whole->mesh;
    const mesh_node *n = &m->nodes[p->node];
    out->count = n->count[p->child];
    out->margin = p->whole->radius;
    for (uint32_t k = 0; k < LANES; k++) {
        const vec3 *v = &m->corners[3 * (n->first[p->child] + (k < out->count ? k : out->count - 1))];
        for (int c = 0; c < 3; c++)
            out->corner[c].x[k] = v[c].x, out->corner[c].y[k] = v[c].y, out->corner[c].z[k] = v[c].z;
    }
    out->normal = lanes3_cross(
        lanes3_sub(out->corner[1], out->corner[0]), lanes3_sub(out->corner[2], out->corner[0]));
}

typedef struct heights {
    lanes least, most;
} heights;

LANES_INLINE lanes least_of(lanes a, lanes b)
{
    return lanes_choose(a < b, a, b);
}
LANES_INLINE lanes most_of(lanes a, lanes b)
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
    return (heights){least_of(u, least_of(v, w)) + origin, most_of(u, most_of(v, w)) + origin};
}

enum { DIRECTIONS_MAX = 2 * MESH_LEAF_MAX }; /* across each triangle of both */

typedef struct looked { /* along a direction, at the beginning of a piece */
    vec3 d;
    heights a, b;
} looked;

typedef struct leaves {
    leaf a, b;
    looked at[DIRECTIONS_MAX];
    uint32_t count;
    lanes best[MESH_LEAF_MAX]; /* m: the widest gap of triangle i of A and each of B, then */
} leaves;

LANES_INLINE void look_across(leaves *l, const leaf *of, const transform *turn, const sweep_place *p)
{
    lanes floor = lanes_of(l->a.margin + l->b.margin + p->floor);
    for (uint32_t k = 0; k < of->count; k++) {
        vec3 n = vec(of->normal.x[k], of->normal.y[k], of->normal.z[k]);
        if (!(vec_norm2(n) > 0)) continue;
        looked *x = &l->at[l->count++];
        x->d = direction_of(mat_mul(turn->r, n));
        x->a = heights_of(&l->a, &p->a, x->d);
        x->b = heights_of(&l->b, &p->b, x->d);
        for (int i = 0; i < MESH_LEAF_MAX; i++) {
            lanes above = x->b.least - lanes_of(x->a.most[i]), below = lanes_of(x->a.least[i]) - x->b.most;
            l->best[i] = most_of(l->best[i], most_of(above, below) - floor);
        }
    }
}

LANES_INLINE void look_at_beginning(leaves *l, const sweep_place *p)
{
    l->count = 0;
    for (int i = 0; i < MESH_LEAF_MAX; i++) l->best[i] = lanes_of(-INFINITY);
    look_across(l, &l->b, &p->b, p);
    look_across(l, &l->a, &p->a, p);
}

typedef struct piece {
    const sweep_place *from, *to;
    double dip;
    double share; /* of it that matters: gaps are above their chord less the dip */
} piece;

/* Bit MESH_LEAF_MAX i + k: triangle i of A and k of B are apart by more than the dip along one of the directions, the
 * same way at both ends of a piece. */
LANES_INLINE unsigned free_pairs(const leaves *l, const piece *p, unsigned open, uint32_t *tried)
{
    double apart = l->a.margin + l->b.margin + p->dip;
    lanes first = lanes_of(apart + p->from->floor), last = lanes_of(apart + p->to->floor), share = lanes_of(p->share);
    unsigned free = 0;
    for (uint32_t k = 0; k < l->count && (open & ~free); k++) {
        const looked *x = &l->at[k];
        heights a = heights_of(&l->a, &p->to->a, x->d), b = heights_of(&l->b, &p->to->b, x->d);
        lanes over_first = x->a.most + first, over_last = a.most + last;
        lanes under_first = x->a.least - first, under_last = a.least - last;
        for (int i = 0; i < MESH_LEAF_MAX; i++) {
            lanes above = x->b.least - lanes_of(over_first[i]), above_last = b.least - lanes_of(over_last[i]);
            lanes below = lanes_of(under_first[i]) - x->b.most, below_last = lanes_of(under_last[i]) - b.most;
            lane_mask is_above = (above > 0) & (above + share * (above_last - above) > 0);
            lane_mask is_below = (below > 0) & (below + share * (below_last - below) > 0);
            free |= lanes_bits(is_above | is_below) << (MESH_LEAF_MAX * i);
        }
        ++*tried;
    }
    return free;
}

/* The pairs that a direction keeps apart at the beginning, and how far the closest of them. */
LANES_INLINE unsigned apart_pairs(const leaves *l, unsigned open, double *least)
{
    unsigned apart = 0;
    *least = INFINITY;
    for (unsigned i = 0; i < LEAF_PAIRS; i++) {
        double gap = l->best[i / MESH_LEAF_MAX][i % MESH_LEAF_MAX];
        if (!(open >> i & 1) || !(gap > 0)) continue;
        apart |= 1u << i;
        *least = min_of(*least, gap);
    }
    return apart;
}

static void enter(double entry[LEAF_PAIRS], unsigned pairs, double time)
{
    for (int i = 0; i < LEAF_PAIRS; i++)
        if (pairs >> i & 1) entry[i] = time;
}

/* From one piece to the next, each as long as the least gap allows. */
LANES_INLINE void find_entries(sweep *s, leaves *l, double from, double until, double entry[LEAF_PAIRS])
{
    unsigned open = 0;
    for (uint32_t i = 0; i < LEAF_PAIRS; i++) {
        entry[i] = INFINITY;
        if (i / MESH_LEAF_MAX < l->a.count && i % MESH_LEAF_MAX < l->b.count) open |= 1u << i;
    }
    double time = sweep_index(s, from), end = sweep_index(s, until);
    while (open && time < s->ends && sweep_time(s, time) <= until) {
        uint32_t first = (uint32_t)time, length = s->longest, tried = 0;
        sweep_place at = *sweep_place_at(s, first);
        look_at_beginning(l, &at);
        double least, now = max_of(sweep_time(s, time), from);
        unsigned apart = apart_pairs(l, open, &least);
        enter(entry, open & ~apart, now);
        open = apart;
        tried += l->count;
        while (length > 1 && (first % length != 0 || sweep_dip(s, length) > 0.5 * least)) length /= SWEEP_CUT;
        while (open) {
            piece p = {&at, sweep_place_at(s, first + length), sweep_dip(s, length),
                min_of((end - first) / length * (1 + 0x1p-40), 1)};
            unsigned left = open & ~free_pairs(l, &p, open, &tried);
            if (left && length == 1) enter(entry, left, now);
            if (length == 1) open &= ~left;
            if (!left || length == 1) break;
            length /= SWEEP_CUT;
        }
        s->work += SWEEP_WORK_LEAVES_TRY * (uint64_t)tried;
        time = first + length;
    }
}

static void find_narrow(sweep *s, leaves *l, double from, double until, double entry[LEAF_PAIRS])
{
    find_entries(s, l, from, until, entry);
}

LANES_WIDE static void find_wide(sweep *s, leaves *l, double from, double until, double entry[LEAF_PAIRS])
{
    find_entries(s, l, from, until, entry);
}

void toi_leaves_entries(
    sweep *s, const toi_part *a, const toi_part *b, double from, double until, double entry[LEAF_PAIRS])
{
    leaves l;
    load(a, &l.a);
    load(b, &l.b);
    s->work += SWEEP_WORK_LEAVES;
    (lanes_wide() ? find_wide : find_narrow)(s, &l, from, until, entry);
}
