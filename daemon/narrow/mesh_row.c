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

typedef struct row {
    lanes3 a[3], b[3]; /* corners */
    lanes3 lead;
    lanes away2, within2;
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

/* Between the nearest of their corners. */
LANES_INLINE lanes3 between_corners(const row *r)
{
    lanes3 lead = lanes3_sub(r->b[0], r->a[0]);
    lanes least = lanes3_dot(lead, lead);
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            if (i == 0 && k == 0) continue;
            lanes3 d = lanes3_sub(r->b[k], r->a[i]);
            lanes norm2 = lanes3_dot(d, d);
            lane_mask nearer = norm2 < least;
            least = lanes_choose(nearer, norm2, least);
            lead = lanes3_choose(nearer, d, lead);
        }
    return lead;
}

/* Between the nearest points of an edge of A and one of B (Ericson, Real-Time Collision Detection, 5.1.9), of those
 * that are nearest. It need not be exact: whatever direction comes out is tried for what it proves. */
LANES_INLINE lanes3 between_edges(const row *r)
{
    lanes3 edge_b[3], best = {lanes_of(0), lanes_of(0), lanes_of(0)};
    lanes norm2_b[3], per_b[3], least = lanes_of(INFINITY);
    for (int k = 0; k < 3; k++) {
        edge_b[k] = lanes3_sub(r->b[(k + 1) % 3], r->b[k]);
        norm2_b[k] = lanes3_dot(edge_b[k], edge_b[k]);
        per_b[k] = 1 / norm2_b[k];
    }
    for (int i = 0; i < 3; i++) {
        lanes3 u = lanes3_sub(r->a[(i + 1) % 3], r->a[i]);
        lanes norm2_a = lanes3_dot(u, u), per_a = 1 / norm2_a;
        for (int k = 0; k < 3; k++) {
            lanes3 v = edge_b[k], w = lanes3_sub(r->a[i], r->b[k]);
            lanes uv = lanes3_dot(u, v), uw = lanes3_dot(u, w), vw = lanes3_dot(v, w);
            lanes s = share_of((uv * vw - norm2_b[k] * uw) / (norm2_a * norm2_b[k] - uv * uv));
            lanes t = share_of((uv * s + vw) * per_b[k]);
            s = share_of((uv * t - uw) * per_a);
            lanes3 d = {v.x * t - u.x * s - w.x, v.y * t - u.y * s - w.y, v.z * t - u.z * s - w.z};
            lanes norm2 = lanes3_dot(d, d);
            lane_mask nearer = norm2 < least;
            least = lanes_choose(nearer, norm2, least);
            best = lanes3_choose(nearer, d, best);
        }
    }
    return best;
}

/* Along a direction of any length: what it separates more than those before did. */
LANES_INLINE void try_along(row *r, lanes3 u)
{
    lanes top = greater_of(greater_of(lanes3_dot(u, r->a[0]), lanes3_dot(u, r->a[1])), lanes3_dot(u, r->a[2]));
    lanes foot = lesser_of(lesser_of(lanes3_dot(u, r->b[0]), lanes3_dot(u, r->b[1])), lanes3_dot(u, r->b[2]));
    lanes gap = foot - top, norm2 = lanes3_dot(u, u), away2 = gap * gap / norm2;
    lane_mask more = (gap > 0) & (away2 > r->away2);
    r->away2 = lanes_choose(more, away2, r->away2);
    r->lead = lanes3_choose(more, u, r->lead);
    r->near &= ~lanes_bits(r->away2 > r->within2);
}

LANES_INLINE lanes3 towards(lanes3 u, lanes3 to)
{
    lanes3 back = {-u.x, -u.y, -u.z};
    return lanes3_choose(lanes3_dot(u, to) < 0, back, u);
}

LANES_INLINE unsigned row_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    row r = {.within2 = lanes_of(within2), .away2 = lanes_of(0)};
    lanes boxes2 = boxes_away2(b, a);
    r.near = near & ~lanes_bits(boxes2 > r.within2);
    if (!r.near) return 0;
    for (int k = 0; k < 3; k++) r.a[k] = spread(a->corner[k]), r.b[k] = load(b->corner[k]);
    r.lead = between_corners(&r);
    try_along(&r, r.lead);
    if (!r.near) return 0;
    lanes3 lo = lanes3_sub(load(b->lo), spread(a->hi)), hi = lanes3_sub(load(b->hi), spread(a->lo));
    lanes3 between = {lo.x + hi.x, lo.y + hi.y, lo.z + hi.z};
    try_along(&r, towards(load(b->normal), between));
    try_along(&r, towards(spread(a->normal), between));
    if (!r.near) return 0;
    try_along(&r, between_edges(&r));
    lanes_store(out->away2, greater_of(r.away2, boxes2));
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

LANES_INLINE unsigned boxes_near(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    lanes away2 = boxes_away2(b, a);
    lanes_store(out->away2, away2);
    return near & ~lanes_bits(away2 > lanes_of(within2));
}

LANES_WIDE static unsigned boxes_near_wide(
    const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return boxes_near(b, a, near, within2, out);
}

unsigned mesh_row_near_boxes(const mesh_four *b, const mesh_spot *a, unsigned near, double within2, mesh_row *out)
{
    return lanes_wide() ? boxes_near_wide(b, a, near, within2, out) : boxes_near(b, a, near, within2, out);
}
