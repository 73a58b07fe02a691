/* box_features: the formulas for corners, edges and faces of two boxes (or a segment and a box), and the proof that
 * nothing else is as near (features.h). Pure; any thread.
 *
 * A feature of a box: for each of its axes the side that the nearest point lies on, or that it lies between the two.
 * Across an axis along which the box has no extent the side is HIGH. */
#include "box_facing.h"
#include "features.h"
#include "narrow/closed/closed.h"
#include "narrow/math/scalar.h"

/* ---- box facing ---- */

/* Two boxes in lanes, for near_features.c, which tries features one by one. */

LANES_INLINE bool box_features_span_of(const unit_pair *p, const narrow_features *f, span *out)
{
    const struct {
        vec3 half_a, half_b, t;
        double after;
    } x = {p->a.half, p->b.half, p->b_in_a.t, 0};
    const struct {
        mat3 turn;
        double after;
    } b = {p->b_in_a.r, 0};
    box_lanes of = box_lanes_of(&x.half_a, &x.half_b, &x.t, &b.turn, 1);
    box_facing m;
    narrow_features same = *f;
    if (!box_facing_of(&of, p->size, 0, &same, &m)) return false;
    out->lo = m.lo, out->hi = m.hi;
    out->axis = vec(m.axis[0], m.axis[1], m.axis[2]);
    out->point_a = vec(m.point_a[0], m.point_a[1], m.point_a[2]);
    out->point_b = vec(m.point_b[0], m.point_b[1], m.point_b[2]);
    out->method = NARROW_BY_SAT;
    return true;
}

LANES_TWINS(LANES_WHOLE, bool, span, box_features_span_of, (const unit_pair *p, const narrow_features *f, span *out),
    (p, f, out));

bool box_facing_span(const unit_pair *p, const narrow_features *f, span *out)
{
    return LANES_CHOSEN(span)(p, f, out);
}

/* ---- box features ---- */

enum { BETWEEN, HIGH, LOW, SIDES };

/* One box: `side` is 1, -1, or 0 for between; `at` the nearest point in its own frame, as far as its sides say. */
typedef struct box_side {
    double half[3], side[3], at[3];
    int free; /* axes along which it lies between */
} box_side;

typedef struct meeting {
    box_side a, b;
    vec3 n, back; /* unit: from A towards B in A's frame, from B towards A in B's */
    vec3 point_a, point_b;
    double apart;
} meeting;

static inline bool box_features_side_of(const shape *s, const uint16_t *side, box_side *x)
{
    static const double SIGN[SIDES] = {0, 1, -1};
    bool right = true;
    vec_to(s->type == SHAPE_BOX ? s->half : box_sides(s), x->half);
    x->free = 0;
    for (int i = 0; i < 3; i++) {
        right &= side[i] < SIDES && (side[i] == HIGH || x->half[i] > 0);
        x->side[i] = SIGN[right ? side[i] : 0];
        x->at[i] = x->side[i] * x->half[i];
        x->free += x->side[i] == 0;
    }
    return right;
}

/* Does it lie between its sides where it is said to, and the direction, in its frame, point out of the others? */
static inline bool box_features_holds(const box_side *x, vec3 direction, double margin)
{
    double d[3];
    bool right = true;
    vec_to(direction, d);
    for (int i = 0; i < 3; i++) {
        double out = x->side[i] * d[i], in = x->half[i] - fabs(x->at[i]);
        right &= x->side[i] == 0 ? in > margin : out > NEAR_SINE_MARGIN || x->half[i] == 0;
    }
    return right;
}

/* A feature of the one box, and a corner of the other at `corner` in its frame: between the sides the corner's
 * coordinates are the nearest point's. The unit direction to it, which has no part there. */
static inline vec3 settle_corner(box_side *x, vec3 corner, double *apart)
{
    double q[3];
    vec_to(corner, q);
    for (int i = 0; i < 3; i++) x->at[i] = x->side[i] == 0 ? q[i] : x->at[i];
    vec3 d = vec_sub(corner, vec_from(x->at));
    *apart = vec_norm(d);
    return vec_scale(d, 1 / *apart);
}

static int free_axis(const box_side *x)
{
    return x->side[0] == 0 ? 0 : x->side[1] == 0 ? 1 : 2;
}

/* Two edges, e_i and f: a + s e_i, b + t f with b - a = r. The axis e_i x f has no part i, and is orthogonal to f to
 * the last bit. False when they are almost parallel. */
static bool settle_edges(const transform *b_in_a, meeting *m)
{
    int i = free_axis(&m->a), h = (i + 1) % 3, k = (i + 2) % 3, j = free_axis(&m->b);
    vec3 edge = j == 0 ? b_in_a->r.x : j == 1 ? b_in_a->r.y : b_in_a->r.z;
    vec3 r = vec_sub(transform_point(b_in_a, vec_from(m->b.at)), vec_from(m->a.at));
    double f[3], d[3], across[3];
    vec_to(edge, f);
    vec_to(r, d);
    double sine2 = f[h] * f[h] + f[k] * f[k], along = vec_dot(r, edge);
    if (!(sine2 > NEAR_SLIVER2)) return false;
    m->a.at[i] = (d[i] - f[i] * along) / sine2;
    m->b.at[j] = m->a.at[i] * f[i] - along;
    across[i] = 0, across[h] = -f[k], across[k] = f[h];
    m->n = direction_of(vec_from(across));
    if (vec_dot(m->n, r) < 0) m->n = vec_neg(m->n);
    m->point_a = vec_from(m->a.at);
    m->point_b = transform_point(b_in_a, vec_from(m->b.at));
    m->back = mat_tmul(b_in_a->r, vec_neg(m->n));
    m->apart = vec_norm(vec_sub(m->point_b, m->point_a));
    return true;
}

static inline bool box_features_settle(const transform *b_in_a, meeting *m)
{
    if (m->b.free == 0) {
        m->point_b = transform_point(b_in_a, vec_from(m->b.at));
        m->n = settle_corner(&m->a, m->point_b, &m->apart);
        m->back = mat_tmul(b_in_a->r, vec_neg(m->n));
        m->point_a = vec_from(m->a.at);
        return m->a.free <= 2;
    }
    if (m->a.free == 0) {
        m->point_a = vec_from(m->a.at);
        m->back = settle_corner(&m->b, mat_tmul(b_in_a->r, vec_sub(m->point_a, b_in_a->t)), &m->apart);
        m->n = direction_again(mat_mul(b_in_a->r, vec_neg(m->back)));
        m->point_b = transform_point(b_in_a, vec_from(m->b.at));
        return m->b.free <= 2;
    }
    return m->a.free == 1 && m->b.free == 1 && settle_edges(b_in_a, m);
}

/* How far it reaches from its centre along a direction in its frame. */
static inline double box_features_reach_along(const box_side *x, vec3 d)
{
    return x->half[0] * fabs(d.x) + x->half[1] * fabs(d.y) + x->half[2] * fabs(d.z);
}

bool box_features_span(const unit_pair *p, const narrow_features *f, span *out)
{
    const transform *t = &p->b_in_a;
    meeting m;
    if (f->count_a != 3 || f->count_b != 3 || !box_features_side_of(&p->a, f->a, &m.a) ||
        !box_features_side_of(&p->b, f->b, &m.b))
        return false;
    if (!box_features_settle(t, &m)) return false;
    double margin = NEAR_HEIGHT_MARGIN * p->size;
    if (!box_features_holds(&m.a, m.n, margin) || !box_features_holds(&m.b, m.back, margin)) return false;
    out->lo = vec_dot(m.n, t->t) - box_features_reach_along(&m.a, m.n) - box_features_reach_along(&m.b, m.back);
    if (!(out->lo >= NEAR_LEAST_DISTANCE * p->size)) return false;
    out->axis = m.n;
    out->point_a = m.point_a;
    out->point_b = m.point_b;
    out->hi = max_of(out->lo, m.apart);
    out->method = NARROW_BY_SAT;
    return true;
}

static void box_features_sides_along(const shape *s, vec3 d, uint16_t side[3], uint8_t *count)
{
    double half[3], along[3];
    vec_to(box_sides(s), half);
    vec_to(d, along);
    for (int i = 0; i < 3; i++) {
        bool between = half[i] > 0 && fabs(along[i]) <= 0.5 * NEAR_SINE_MARGIN;
        side[i] = between ? BETWEEN : half[i] == 0 || along[i] > 0 ? HIGH : LOW;
    }
    *count = 3;
}

void box_features_along(const unit_pair *p, vec3 axis, narrow_features *out)
{
    box_features_sides_along(&p->a, axis, out->a, &out->count_a);
    box_features_sides_along(&p->b, mat_tmul(p->b_in_a.r, vec_neg(axis)), out->b, &out->count_b);
}
