/* mesh_row_lanes: what mesh_row.c and mesh_row_wide.c are made of: four triangles in the four lanes of simd.h. What is
 * not a number separates nothing.
 *
 * The file that includes this header includes simd.h and mesh_row.h before, and defines five macros for its registers:
 * row_greater_of and row_lesser_of (the second argument where one is not a number), row_choose, row_pick (lane k takes
 * the number of which[k]) and row_bits_of (bit k is lane k of a mask). All code that uses them is here, so that both
 * files give the same bits; KERNEL holds the functions that result. Pure; any thread. */
#ifndef COLLIDED_NARROW_TREE_MESH_ROW_LANES_H
#define COLLIDED_NARROW_TREE_MESH_ROW_LANES_H

/* What must be of one width is so here. */
_Static_assert((int)LANES == (int)MESH_LEAF_MAX, "a leaf fills the lanes");

LANES_INLINE lanes3 row_choose3(lane_mask m, lanes3 yes, lanes3 no)
{
    return (lanes3){row_choose(m, yes.x, no.x), row_choose(m, yes.y, no.y), row_choose(m, yes.z, no.z)};
}
LANES_INLINE lanes share_of(lanes x) /* 0 to 1 */
{
    return row_lesser_of(row_greater_of(x, lanes_of(0)), lanes_of(1));
}

LANES_INLINE lanes3 spread(vec3 v)
{
    return (lanes3){lanes_of(v.x), lanes_of(v.y), lanes_of(v.z)};
}
LANES_INLINE lanes3 row_load(const double v[3][LANES])
{
    return (lanes3){lanes_load(v[0]), lanes_load(v[1]), lanes_load(v[2])};
}
LANES_INLINE void store(double v[3][LANES], lanes3 x)
{
    lanes_store(v[0], x.x);
    lanes_store(v[1], x.y);
    lanes_store(v[2], x.z);
}
LANES_INLINE lanes3 scaled(lanes3 v, lanes s)
{
    return (lanes3){v.x * s, v.y * s, v.z * s};
}

/* ---- a leaf in its place ---- */

LANES_INLINE lanes3 corners_at(const vec3 *corners, const uint32_t at[LANES], uint32_t k)
{
    const vec3 *p = &corners[at[0] + k], *q = &corners[at[1] + k], *r = &corners[at[2] + k], *s = &corners[at[3] + k];
    return (lanes3){{p->x, q->x, r->x, s->x}, {p->y, q->y, r->y, s->y}, {p->z, q->z, r->z, s->z}};
}

/* transform_point, lane by lane. */
LANES_INLINE lanes3 moved(const transform *t, lanes3 v)
{
    const mat3 *m = &t->r;
    return (lanes3){lanes_of(m->x.x) * v.x + lanes_of(m->y.x) * v.y + lanes_of(m->z.x) * v.z + lanes_of(t->t.x),
        lanes_of(m->x.y) * v.x + lanes_of(m->y.y) * v.y + lanes_of(m->z.y) * v.z + lanes_of(t->t.y),
        lanes_of(m->x.z) * v.x + lanes_of(m->y.z) * v.y + lanes_of(m->z.z) * v.z + lanes_of(t->t.z)};
}

LANES_INLINE lanes3 least3(lanes3 a, lanes3 b)
{
    return (lanes3){row_lesser_of(a.x, b.x), row_lesser_of(a.y, b.y), row_lesser_of(a.z, b.z)};
}
LANES_INLINE lanes3 most3(lanes3 a, lanes3 b)
{
    return (lanes3){row_greater_of(a.x, b.x), row_greater_of(a.y, b.y), row_greater_of(a.z, b.z)};
}

static void four_set(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    uint32_t at[LANES];
    lanes3 p[3];
    for (uint32_t i = 0; i < LANES; i++) at[i] = 3 * (i < count ? i : count - 1);
    for (uint32_t k = 0; k < 3; k++) {
        p[k] = scaled(corners_at(corners, at, k), lanes_of(scale));
        if (b_in_a) p[k] = moved(b_in_a, p[k]);
        store(f->corner[k], p[k]);
    }
    store(f->lo, least3(least3(p[0], p[1]), p[2]));
    store(f->hi, most3(most3(p[0], p[1]), p[2]));
    store(f->normal, lanes3_cross(lanes3_sub(p[1], p[0]), lanes3_sub(p[2], p[0])));
}

/* ---- a row ---- */

LANES_INLINE lanes row_outside(double lo_a, double hi_a, lanes lo_b, lanes hi_b)
{
    return row_greater_of(row_greater_of(lo_b - lanes_of(hi_a), lanes_of(lo_a) - hi_b), lanes_of(0));
}

LANES_INLINE lanes boxes_away2(const mesh_four *b, const mesh_spot *a)
{
    lanes x = row_outside(a->lo.x, a->hi.x, lanes_load(b->lo[0]), lanes_load(b->hi[0]));
    lanes y = row_outside(a->lo.y, a->hi.y, lanes_load(b->lo[1]), lanes_load(b->hi[1]));
    lanes z = row_outside(a->lo.z, a->hi.z, lanes_load(b->lo[2]), lanes_load(b->hi[2]));
    return x * x + y * y + z * z;
}

LANES_INLINE lanes row_foot_of(const lanes3 p[3], lanes3 u)
{
    return row_lesser_of(row_lesser_of(lanes3_dot(u, p[0]), lanes3_dot(u, p[1])), lanes3_dot(u, p[2]));
}
LANES_INLINE lanes row_top_of(const lanes3 p[3], lanes3 u)
{
    return row_greater_of(row_greater_of(lanes3_dot(u, p[0]), lanes3_dot(u, p[1])), lanes3_dot(u, p[2]));
}

LANES_INLINE lanes3 row_towards(lanes3 u, lanes3 to)
{
    lanes3 back = {-u.x, -u.y, -u.z};
    return row_choose3(lanes3_dot(u, to) < 0, back, u);
}

/* Two triangles, in each lane from the corners that are nearest to each other (where several are, from some of these).
 */
typedef struct pairing {
    lanes3 from, lead;                   /* A's corner; from there to B's */
    lanes3 u[2], v[2];                   /* from those corners along the edges of A, of B */
    lanes norm2, along_u[2], along_v[2]; /* of the lead; products with it */
} pairing;

LANES_INLINE void swap_where(lane_mask m, lanes *x, lanes *y)
{
    lane_mask both = ((lane_mask)*x ^ (lane_mask)*y) & m;
    *x = (lanes)((lane_mask)*x ^ both);
    *y = (lanes)((lane_mask)*y ^ both);
}

LANES_INLINE void swap3_where(lane_mask m, lanes3 *x, lanes3 *y)
{
    swap_where(m, &x->x, &y->x);
    swap_where(m, &x->y, &y->y);
    swap_where(m, &x->z, &y->z);
}

/* `away2`: what each corner is from the other triangle's nearest. */
LANES_INLINE void nearest_first(lanes3 p[3], const lanes away2[3])
{
    swap3_where(away2[1] < away2[0], &p[0], &p[1]);
    swap3_where(away2[2] < row_lesser_of(away2[1], away2[0]), &p[0], &p[2]);
}

LANES_INLINE void set_pairing(pairing *p, lanes3 a[3], lanes3 b[3])
{
    lanes from_a[3], from_b[3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            lanes3 d = lanes3_sub(b[k], a[i]);
            lanes norm2 = lanes3_dot(d, d);
            from_a[i] = k == 0 ? norm2 : row_lesser_of(norm2, from_a[i]);
            from_b[k] = i == 0 ? norm2 : row_lesser_of(norm2, from_b[k]);
        }
    nearest_first(a, from_a);
    nearest_first(b, from_b);
    p->from = a[0];
    p->lead = lanes3_sub(b[0], a[0]);
    p->norm2 = lanes3_dot(p->lead, p->lead);
    for (int i = 0; i < 2; i++) {
        p->u[i] = lanes3_sub(a[i + 1], a[0]), p->v[i] = lanes3_sub(b[i + 1], b[0]);
        p->along_u[i] = lanes3_dot(p->u[i], p->lead), p->along_v[i] = lanes3_dot(p->v[i], p->lead);
    }
}

/* What parts them, not below 0: of products with the lead and with the edges. */
LANES_INLINE lanes row_gap_of(lanes lead, const lanes u[2], const lanes v[2])
{
    const lanes none = lanes_of(0);
    lanes top = row_greater_of(row_greater_of(u[0], u[1]), none), foot = row_lesser_of(row_lesser_of(v[0], v[1]), none);
    return row_greater_of(lead + foot - top, none);
}

/* Along a direction of any length. */
LANES_INLINE lanes row_gap_along(const pairing *p, lanes3 d)
{
    const lanes u[2] = {lanes3_dot(d, p->u[0]), lanes3_dot(d, p->u[1])};
    const lanes v[2] = {lanes3_dot(d, p->v[0]), lanes3_dot(d, p->v[1])};
    return row_gap_of(lanes3_dot(d, p->lead), u, v);
}

/* Of two by one division. */
LANES_INLINE void inverses(const lanes x[2], lanes per_x[2])
{
    lanes per_both = 1 / (x[0] * x[1]);
    per_x[0] = x[1] * per_both;
    per_x[1] = x[0] * per_both;
}

/* Between the nearest points of an edge of A and one of B (Ericson, Real-Time Collision Detection, 5.1.9), of the edges
 * at the nearest corners, of those that are nearest: `norm2` is the square of the line between these points, `along`
 * goes from A's nearest corner to the point on its edge. It need not be exact: whatever direction comes out is tried
 * for what it proves. */
LANES_INLINE lanes3 row_between_edges(const pairing *p, lanes *least, lanes3 *along)
{
    lanes uu[2], vv[2], uv[2][2], per_uu[2], per_vv[2], per_both[2][2];
    lanes3 best = p->lead;
    for (int i = 0; i < 2; i++) uu[i] = lanes3_dot(p->u[i], p->u[i]), vv[i] = lanes3_dot(p->v[i], p->v[i]);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            uv[i][k] = lanes3_dot(p->u[i], p->v[k]);
            per_both[i][k] = 1 / (uu[i] * vv[k] - uv[i][k] * uv[i][k]);
        }
    inverses(uu, per_uu);
    inverses(vv, per_vv);
    *least = p->norm2;
    *along = spread(VEC_ZERO);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            const lanes3 *u = &p->u[i], *v = &p->v[k];
            lanes s = share_of((vv[k] * p->along_u[i] - uv[i][k] * p->along_v[k]) * per_both[i][k]);
            lanes t = share_of((uv[i][k] * s - p->along_v[k]) * per_vv[k]);
            s = share_of((uv[i][k] * t + p->along_u[i]) * per_uu[i]);
            lanes3 us = scaled(*u, s);
            lanes3 d = {p->lead.x + v->x * t - us.x, p->lead.y + v->y * t - us.y, p->lead.z + v->z * t - us.z};
            lanes norm2 = lanes3_dot(d, d);
            lane_mask nearer = norm2 < *least;
            *least = row_lesser_of(norm2, *least);
            best = row_choose3(nearer, d, best);
            *along = row_choose3(nearer, us, *along);
        }
    return best;
}

LANES_INLINE lanes3 row_pick3(const double v[3][LANES], uint32_t which)
{
    return (lanes3){row_pick(v[0], which), row_pick(v[1], which), row_pick(v[2], which)};
}

/* The direction that parts them most, of those tried: squares, gap2 / norm2. */
typedef struct parting {
    lanes3 lead;
    lanes gap2, norm2;
} parting;

LANES_INLINE void part_along(parting *best, lanes3 u, lanes gap, lanes norm2)
{
    lanes gap2 = gap * gap;
    lane_mask more = gap2 * best->norm2 > best->gap2 * norm2;
    best->gap2 = row_choose(more, gap2, best->gap2);
    best->norm2 = row_choose(more, norm2, best->norm2);
    best->lead = row_choose3(more, u, best->lead);
}

LANES_INLINE void part_along_normal(parting *best, const pairing *p, lanes3 normal)
{
    lanes3 u = row_towards(normal, p->lead);
    part_along(best, u, row_gap_along(p, u), lanes3_dot(u, u));
}

#define LEAST_NORM2 0x1p-1000 /* of a lead, where two corners are one */

static unsigned row_near(const mesh_four *a, const mesh_four *b, const mesh_picks *p, double within2, mesh_row *out)
{
    lanes3 of_a[3], of_b[3], along;
    lanes most2 = lanes_of(within2), norm2;
    pairing q;
    for (int k = 0; k < 3; k++) of_a[k] = row_pick3(a->corner[k], p->a), of_b[k] = row_pick3(b->corner[k], p->b);
    set_pairing(&q, of_a, of_b);
    lanes by_corners = row_gap_of(q.norm2, q.along_u, q.along_v);
    unsigned near = ((1u << p->count) - 1) & ~row_bits_of(by_corners * by_corners > most2 * q.norm2);
    if (!near) return 0;
    lanes3 edges = row_between_edges(&q, &norm2, &along);
    lanes by_edges = row_gap_along(&q, edges);
    near &= ~row_bits_of(by_edges * by_edges > most2 * norm2);
    if (!near) return 0;
    parting best = {q.lead, by_corners * by_corners, row_greater_of(q.norm2, lanes_of(LEAST_NORM2))};
    part_along(&best, edges, by_edges, norm2);
    part_along_normal(&best, &q, row_pick3(b->normal, p->b));
    part_along_normal(&best, &q, row_pick3(a->normal, p->a));
    near &= ~row_bits_of(best.gap2 > most2 * best.norm2);
    lanes_store(out->away2, best.gap2 / best.norm2);
    store(out->lead, best.lead);
    store(out->edges, edges);
    store(out->from, (lanes3){q.from.x + along.x, q.from.y + along.y, q.from.z + along.z});
    return near;
}

static unsigned core_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes away2 = boxes_away2(b, a);
    lanes_store(out->away2, away2);
    return near & ~row_bits_of(away2 > lanes_of(within2));
}

/* ---- all of two leaves ---- */

LANES_INLINE double sum_of(lanes x)
{
    return x[0] + x[2] + (x[1] + x[3]);
}

/* Between the middles of the boxes around all triangles. */
LANES_INLINE vec3 between_fours(const mesh_four *a, const mesh_four *b)
{
    double d[3];
    for (int k = 0; k < 3; k++) {
        lanes lo = lanes_load(b->lo[k]) - lanes_load(a->lo[k]), hi = lanes_load(b->hi[k]) - lanes_load(a->hi[k]);
        d[k] = sum_of(lo + hi);
    }
    return vec(d[0], d[1], d[2]);
}

/* The pairs of which B's foot is not above A's top. */
LANES_INLINE unsigned not_above(lanes foot, lanes top)
{
    unsigned above = row_bits_of(foot > LANES_ALL(top, 0)) | row_bits_of(foot > LANES_ALL(top, 1)) << 4 |
                     row_bits_of(foot > LANES_ALL(top, 2)) << 8 | row_bits_of(foot > LANES_ALL(top, 3)) << 12;
    return ~above & 0xffff;
}

static unsigned fours_near(
    const mesh_four *a, const mesh_four *b, const double levels_a[LANES], const double levels_b[LANES], double within)
{
    const lanes3 of_a[3] = {row_load(a->corner[0]), row_load(a->corner[1]), row_load(a->corner[2])};
    const lanes3 of_b[3] = {row_load(b->corner[0]), row_load(b->corner[1]), row_load(b->corner[2])};
    vec3 between = between_fours(a, b);
    lanes3 u = spread(between);
    lanes limit = lanes_of(within * vec_norm(between));
    return not_above(lanes_load(levels_b), lanes_load(levels_a) + lanes_of(within)) &
           not_above(row_foot_of(of_b, u), row_top_of(of_a, u) + limit);
}

/* ---- a box ---- */

/* Squares of the least distance that was proven along a direction: gap2 / norm2, from A to B. */
typedef struct row {
    lanes3 b[3]; /* corners */
    lanes3 lead;
    lanes gap2, norm2, within2;
    unsigned near;
} row;

/* Along a direction of any length, along which A reaches no higher than `top`: what it separates more than those before
 * did. */
LANES_INLINE void try_above(row *r, lanes3 u, lanes top)
{
    lanes gap = row_foot_of(r->b, u) - top, norm2 = lanes3_dot(u, u), gap2 = gap * gap;
    lane_mask more = (gap > 0) & (gap2 * r->norm2 > r->gap2 * norm2);
    r->gap2 = row_choose(more, gap2, r->gap2);
    r->norm2 = row_choose(more, norm2, r->norm2);
    r->lead = row_choose3(more, u, r->lead);
    r->near &= ~row_bits_of(r->gap2 > r->within2 * r->norm2);
}

LANES_INLINE lanes beyond(double lo, double hi, lanes x)
{
    return x - row_lesser_of(row_greater_of(x, lanes_of(lo)), lanes_of(hi));
}

LANES_INLINE lanes3 from_box(const mesh_spot *a, lanes3 p)
{
    return (lanes3){beyond(a->lo.x, a->hi.x, p.x), beyond(a->lo.y, a->hi.y, p.y), beyond(a->lo.z, a->hi.z, p.z)};
}

/* From the box to the corner that is nearest to it. */
LANES_INLINE lanes3 from_box_to_corner(const mesh_spot *a, const lanes3 b[3])
{
    lanes3 lead = from_box(a, b[0]);
    lanes least = lanes3_dot(lead, lead);
    for (int k = 1; k < 3; k++) {
        lanes3 d = from_box(a, b[k]);
        lanes norm2 = lanes3_dot(d, d);
        lane_mask nearer = norm2 < least;
        least = row_choose(nearer, norm2, least);
        lead = row_choose3(nearer, d, lead);
    }
    return lead;
}

LANES_INLINE lanes row_reach_of(double lo, double hi, lanes u)
{
    return row_greater_of(u * lanes_of(lo), u * lanes_of(hi));
}

LANES_INLINE void try_from_box(row *r, const mesh_spot *a, lanes3 u)
{
    try_above(r, u,
        row_reach_of(a->lo.x, a->hi.x, u.x) + row_reach_of(a->lo.y, a->hi.y, u.y) +
            row_reach_of(a->lo.z, a->hi.z, u.z));
}

/* Across the box's edges and those of the triangles. */
LANES_INLINE void try_across(row *r, const mesh_spot *a, lanes3 lead)
{
    const lanes none = lanes_of(0);
    for (int k = 0; k < 3 && r->near; k++) {
        lanes3 e = lanes3_sub(r->b[(k + 1) % 3], r->b[k]);
        try_from_box(r, a, row_towards((lanes3){none, -e.z, e.y}, lead));
        try_from_box(r, a, row_towards((lanes3){e.z, none, -e.x}, lead));
        try_from_box(r, a, row_towards((lanes3){-e.y, e.x, none}, lead));
    }
}

static unsigned box_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes boxes2 = boxes_away2(b, a);
    row r;
    r.within2 = lanes_of(within2);
    r.near = near & ~row_bits_of(boxes2 > r.within2);
    if (!r.near) return 0;
    for (int k = 0; k < 3; k++) r.b[k] = row_load(b->corner[k]);
    lanes3 lead = r.lead = from_box_to_corner(a, r.b);
    r.gap2 = lanes_of(0), r.norm2 = lanes_of(1);
    try_from_box(&r, a, lead);
    try_from_box(&r, a, row_towards(row_load(b->normal), lead));
    if (!r.near) return 0;
    try_across(&r, a, lead);
    lanes_store(out->away2, row_greater_of(r.gap2 / r.norm2, boxes2));
    store(out->lead, r.lead);
    return r.near;
}

/* ---- levels ---- */

static void four_levels(const mesh_four *f, vec3 axis, double levels[LANES])
{
    const lanes3 p[3] = {row_load(f->corner[0]), row_load(f->corner[1]), row_load(f->corner[2])};
    lanes_store(levels, row_foot_of(p, spread(axis)));
}

static const mesh_row_kernel KERNEL = {four_set, fours_near, row_near, core_near, box_near, four_levels};

#endif
