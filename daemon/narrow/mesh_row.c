/* Four triangles in the four lanes of lanes.h. What is not a number separates nothing. Pure; any thread. */
#include "mesh_row.h"

#include "lanes.h"

/* What must be of one width is so here. */
_Static_assert((int)LANES == (int)MESH_LEAF_MAX, "a leaf fills the lanes");

LANES_INLINE lanes greater_of(lanes x, lanes y) /* y, when one is not a number */
{
    return lanes_choose(x > y, x, y);
}
LANES_INLINE lanes lesser_of(lanes x, lanes y)
{
    return lanes_choose(x < y, x, y);
}
LANES_INLINE lanes share_of(lanes x) /* 0 to 1 */
{
    return lesser_of(greater_of(x, lanes_of(0)), lanes_of(1));
}

LANES_INLINE lanes3 spread(vec3 v)
{
    return (lanes3){lanes_of(v.x), lanes_of(v.y), lanes_of(v.z)};
}
LANES_INLINE lanes3 load(const double v[3][LANES])
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
    return (lanes3){lesser_of(a.x, b.x), lesser_of(a.y, b.y), lesser_of(a.z, b.z)};
}
LANES_INLINE lanes3 most3(lanes3 a, lanes3 b)
{
    return (lanes3){greater_of(a.x, b.x), greater_of(a.y, b.y), greater_of(a.z, b.z)};
}

LANES_INLINE void four_set(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    uint32_t at[LANES];
    lanes3 p[3];
    for (uint32_t i = 0; i < LANES; i++) at[i] = 3 * (i < count ? i : count - 1);
    for (uint32_t k = 0; k < 3; k++) {
        p[k] = moved(b_in_a, scaled(corners_at(corners, at, k), lanes_of(scale)));
        store(f->corner[k], p[k]);
    }
    store(f->lo, least3(least3(p[0], p[1]), p[2]));
    store(f->hi, most3(most3(p[0], p[1]), p[2]));
    store(f->normal, lanes3_cross(lanes3_sub(p[1], p[0]), lanes3_sub(p[2], p[0])));
}

LANES_WIDE static void four_set_wide(
    mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    four_set(f, corners, count, scale, b_in_a);
}

void mesh_four_set(mesh_four *f, const vec3 *corners, uint32_t count, double scale, const transform *b_in_a)
{
    if (lanes_wide())
        four_set_wide(f, corners, count, scale, b_in_a);
    else
        four_set(f, corners, count, scale, b_in_a);
}

void mesh_four_spot(const mesh_four *f, uint32_t i, mesh_spot *s)
{
    for (int k = 0; k < 3; k++) s->corner[k] = vec(f->corner[k][0][i], f->corner[k][1][i], f->corner[k][2][i]);
    s->lo = vec(f->lo[0][i], f->lo[1][i], f->lo[2][i]);
    s->hi = vec(f->hi[0][i], f->hi[1][i], f->hi[2][i]);
    s->normal = vec(f->normal[0][i], f->normal[1][i], f->normal[2][i]);
}

/* ---- a row ---- */

/* Three corners, in each lane in the order that begins with the one nearest to the other triangle. */
typedef struct corners {
    lanes3 at[3];
} corners;

/* Squares of the least distance that was proven along a direction: gap2 / norm2, from A to B. */
typedef struct row {
    lanes3 a[3], b[3]; /* corners */
    lanes3 lead;
    lanes gap2, norm2, within2;
    unsigned near;
} row;

LANES_INLINE lanes outside(double lo_a, double hi_a, lanes lo_b, lanes hi_b)
{
    return greater_of(greater_of(lo_b - lanes_of(hi_a), lanes_of(lo_a) - hi_b), lanes_of(0));
}

LANES_INLINE lanes boxes_away2(const mesh_four *b, const mesh_spot *a)
{
    lanes x = outside(a->lo.x, a->hi.x, lanes_load(b->lo[0]), lanes_load(b->hi[0]));
    lanes y = outside(a->lo.y, a->hi.y, lanes_load(b->lo[1]), lanes_load(b->hi[1]));
    lanes z = outside(a->lo.z, a->hi.z, lanes_load(b->lo[2]), lanes_load(b->hi[2]));
    return x * x + y * y + z * z;
}

LANES_INLINE lanes3 one_of(lane_mask first, lanes3 a, lane_mask second, lanes3 b, lanes3 c)
{
    return lanes3_choose(first, a, lanes3_choose(second, b, c));
}

/* `away2`: what each corner is from the other triangle's nearest. */
LANES_INLINE corners nearest_first(const lanes3 p[3], const lanes away2[3])
{
    lane_mask first = (away2[0] <= away2[1]) & (away2[0] <= away2[2]), second = away2[1] <= away2[2];
    return (corners){{one_of(first, p[0], second, p[1], p[2]), one_of(first, p[1], second, p[2], p[0]),
        one_of(first, p[2], second, p[0], p[1])}};
}

/* Both triangles by their nearest corners (where several are as near, by some of these). */
LANES_INLINE void order_corners(const row *r, corners *a, corners *b)
{
    lanes from_a[3], from_b[3];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            lanes3 d = lanes3_sub(r->b[k], r->a[i]);
            lanes norm2 = lanes3_dot(d, d);
            from_a[i] = k == 0 ? norm2 : lesser_of(norm2, from_a[i]);
            from_b[k] = i == 0 ? norm2 : lesser_of(norm2, from_b[k]);
        }
    *a = nearest_first(r->a, from_a);
    *b = nearest_first(r->b, from_b);
}

LANES_INLINE lanes foot_of(const lanes3 p[3], lanes3 u)
{
    return lesser_of(lesser_of(lanes3_dot(u, p[0]), lanes3_dot(u, p[1])), lanes3_dot(u, p[2]));
}
LANES_INLINE lanes top_of(const lanes3 p[3], lanes3 u)
{
    return greater_of(greater_of(lanes3_dot(u, p[0]), lanes3_dot(u, p[1])), lanes3_dot(u, p[2]));
}

/* Along a direction of any length, along which A reaches no higher than `top`: what it separates more than those before
 * did. */
LANES_INLINE void try_above(row *r, lanes3 u, lanes top)
{
    lanes gap = foot_of(r->b, u) - top, norm2 = lanes3_dot(u, u), gap2 = gap * gap;
    lane_mask more = (gap > 0) & (gap2 * r->norm2 > r->gap2 * norm2);
    r->gap2 = lanes_choose(more, gap2, r->gap2);
    r->norm2 = lanes_choose(more, norm2, r->norm2);
    r->lead = lanes3_choose(more, u, r->lead);
    r->near &= ~lanes_bits(r->gap2 > r->within2 * r->norm2);
}

LANES_INLINE void try_along(row *r, lanes3 u)
{
    try_above(r, u, top_of(r->a, u));
}

LANES_INLINE lanes3 towards(lanes3 u, lanes3 to)
{
    lanes3 back = {-u.x, -u.y, -u.z};
    return lanes3_choose(lanes3_dot(u, to) < 0, back, u);
}

/* Between the nearest points of an edge of A and one of B (Ericson, Real-Time Collision Detection, 5.1.9), of the edges
 * at the nearest corners, of those that are nearest. It need not be exact: whatever direction comes out is tried for
 * what it proves. */
LANES_INLINE lanes3 between_edges(const corners *a, const corners *b, lanes3 lead)
{
    lanes3 best = lead, u[2], v[2];
    lanes least = lanes_of(INFINITY), uu[2], vv[2], to_a[2], to_b[2], per_uu[2], per_vv[2];
    for (int i = 0; i < 2; i++) {
        u[i] = lanes3_sub(a->at[i + 1], a->at[0]), v[i] = lanes3_sub(b->at[i + 1], b->at[0]);
        uu[i] = lanes3_dot(u[i], u[i]), vv[i] = lanes3_dot(v[i], v[i]);
        to_b[i] = lanes3_dot(u[i], lead), to_a[i] = -lanes3_dot(v[i], lead);
        per_uu[i] = 1 / uu[i], per_vv[i] = 1 / vv[i];
    }
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) {
            lanes uv = lanes3_dot(u[i], v[k]);
            lanes s = share_of((uv * to_a[k] + vv[k] * to_b[i]) / (uu[i] * vv[k] - uv * uv));
            lanes t = share_of((uv * s + to_a[k]) * per_vv[k]);
            s = share_of((uv * t + to_b[i]) * per_uu[i]);
            lanes3 d = {
                lead.x + v[k].x * t - u[i].x * s, lead.y + v[k].y * t - u[i].y * s, lead.z + v[k].z * t - u[i].z * s};
            lanes norm2 = lanes3_dot(d, d);
            lane_mask nearer = norm2 < least;
            least = lanes_choose(nearer, norm2, least);
            best = lanes3_choose(nearer, d, best);
        }
    return best;
}

LANES_INLINE unsigned row_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes boxes2 = boxes_away2(b, a);
    row r;
    corners of_a, of_b;
    r.within2 = lanes_of(within2);
    r.near = near & ~lanes_bits(boxes2 > r.within2);
    if (!r.near) return 0;
    for (int k = 0; k < 3; k++) r.a[k] = spread(a->corner[k]), r.b[k] = load(b->corner[k]);
    lanes3 lo = lanes3_sub(load(b->lo), spread(a->hi)), hi = lanes3_sub(load(b->hi), spread(a->lo));
    lanes3 between = {lo.x + hi.x, lo.y + hi.y, lo.z + hi.z};
    r.lead = between;
    r.gap2 = lanes_of(0), r.norm2 = lanes_of(1);
    try_along(&r, between);
    if (!r.near) return 0;
    order_corners(&r, &of_a, &of_b);
    lanes3 lead = lanes3_sub(of_b.at[0], of_a.at[0]);
    try_along(&r, lead);
    if (!r.near) return 0;
    try_along(&r, towards(load(b->normal), lead));
    try_along(&r, towards(spread(a->normal), lead));
    if (!r.near) return 0;
    try_along(&r, between_edges(&of_a, &of_b, lead));
    lanes_store(out->away2, r.gap2 / r.norm2);
    store(out->lead, r.lead);
    return r.near;
}

LANES_WIDE static unsigned row_near_wide(
    const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return row_near(b, a, near, within2, out);
}

unsigned mesh_row_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return lanes_wide() ? row_near_wide(b, a, near, within2, out) : row_near(b, a, near, within2, out);
}

LANES_INLINE unsigned core_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes away2 = boxes_away2(b, a);
    lanes_store(out->away2, away2);
    return near & ~lanes_bits(away2 > lanes_of(within2));
}

LANES_WIDE static unsigned core_near_wide(
    const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return core_near(b, a, near, within2, out);
}

unsigned mesh_row_near_core(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return lanes_wide() ? core_near_wide(b, a, near, within2, out) : core_near(b, a, near, within2, out);
}

/* ---- a box ---- */

LANES_INLINE lanes beyond(double lo, double hi, lanes x)
{
    return x - lesser_of(greater_of(x, lanes_of(lo)), lanes_of(hi));
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
        least = lanes_choose(nearer, norm2, least);
        lead = lanes3_choose(nearer, d, lead);
    }
    return lead;
}

LANES_INLINE lanes reach_of(double lo, double hi, lanes u)
{
    return greater_of(u * lanes_of(lo), u * lanes_of(hi));
}

LANES_INLINE void try_from_box(row *r, const mesh_spot *a, lanes3 u)
{
    try_above(
        r, u, reach_of(a->lo.x, a->hi.x, u.x) + reach_of(a->lo.y, a->hi.y, u.y) + reach_of(a->lo.z, a->hi.z, u.z));
}

/* Across the box's edges and those of the triangles. */
LANES_INLINE void try_across(row *r, const mesh_spot *a, lanes3 lead)
{
    const lanes none = lanes_of(0);
    for (int k = 0; k < 3 && r->near; k++) {
        lanes3 e = lanes3_sub(r->b[(k + 1) % 3], r->b[k]);
        try_from_box(r, a, towards((lanes3){none, -e.z, e.y}, lead));
        try_from_box(r, a, towards((lanes3){e.z, none, -e.x}, lead));
        try_from_box(r, a, towards((lanes3){-e.y, e.x, none}, lead));
    }
}

LANES_INLINE unsigned box_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes boxes2 = boxes_away2(b, a);
    row r;
    r.within2 = lanes_of(within2);
    r.near = near & ~lanes_bits(boxes2 > r.within2);
    if (!r.near) return 0;
    for (int k = 0; k < 3; k++) r.b[k] = load(b->corner[k]);
    lanes3 lead = r.lead = from_box_to_corner(a, r.b);
    r.gap2 = lanes_of(0), r.norm2 = lanes_of(1);
    try_from_box(&r, a, lead);
    try_from_box(&r, a, towards(load(b->normal), lead));
    if (!r.near) return 0;
    try_across(&r, a, lead);
    lanes_store(out->away2, greater_of(r.gap2 / r.norm2, boxes2));
    store(out->lead, r.lead);
    return r.near;
}

LANES_WIDE static unsigned box_near_wide(
    const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return box_near(b, a, near, within2, out);
}

unsigned mesh_row_near_box(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return lanes_wide() ? box_near_wide(b, a, near, within2, out) : box_near(b, a, near, within2, out);
}

/* ---- levels ---- */

LANES_INLINE void four_levels(const mesh_four *f, vec3 axis, double levels[LANES])
{
    const lanes3 p[3] = {load(f->corner[0]), load(f->corner[1]), load(f->corner[2])};
    lanes_store(levels, foot_of(p, spread(axis)));
}

LANES_WIDE static void four_levels_wide(const mesh_four *f, vec3 axis, double levels[LANES])
{
    four_levels(f, axis, levels);
}

void mesh_four_levels(const mesh_four *f, vec3 axis, double levels[LANES])
{
    if (lanes_wide())
        four_levels_wide(f, axis, levels);
    else
        four_levels(f, axis, levels);
}
