/* box_revolved: branch and bound over octants of the box and the cosine to the other axis. Pure; any thread.
 *
 * The box stands at the origin along the axes; u is minus the axis of B, t its centre. Along a unit axis m from A
 * towards B, with y = m.u, the cores overlap by
 *     h(m) = sum of half_i |m_i| + f(y) - t.m,   f the support function of B's outline (outline.h).
 * In an octant, with m_i = sign_i n_i and n >= 0, that is v.n + f(y), v_i = half_i - sign_i t_i; and over a strip
 * y1 <= y <= y2 without a kink inside f is nowhere below its chord:
 *     h(m) >= c + w.n,   w = v + slope * (sign u).
 * The least w.n over octant and strip has a closed form: it is at -w / |w|, or the least on a face n_i = 0, or at a
 * corner, or the least on the circle y = y1 or y = y2, or where that meets a face. A chord is off by the square of its
 * width: what falls short of the least h found by more than is allowed is split where the bound is least, which also
 * gives the next h. What the flat ends hold is cut off the range of y. */
#include "box_revolved.h"

#include "outline.h"

enum { CELLS_MAX = 48 /* open at a time */, SPLITS_MAX = 200 };

static const double SHALLOW = 0.05; /* of the size: less depth is found sooner by other means */
static const double NOISE = 64;     /* rounding of a bound, in units of the last place, with room */
static const double SLACK = 1e-12;  /* by which a point may be outside of a strip and still counts for its bound */
static const double OUTSIDE = 1e-9; /* the same of an octant */
static const double EDGE = 0.1;     /* no part of a strip that is split is smaller than this share */

typedef struct scene {
    const unit_pair *p;
    outline b;
    vec3 half, u, t;
    double noise;
} scene;

typedef struct cell {
    mark y1, y2;
    vec3 sign;
    double bound; /* no h in the cell is less */
    double y;     /* where the bound is */
} cell;

typedef struct search {
    const scene *scene;
    double least;
    vec3 axis;     /* where the least h was found */
    double proved; /* of the cells that were closed */
    double short_by, enough;
    uint32_t steps;
    int count;
    cell open[CELLS_MAX];
} search;

static vec3 times(vec3 a, vec3 b)
{
    return vec(a.x * b.x, a.y * b.y, a.z * b.z);
}

static vec3 magnitudes(vec3 v)
{
    return vec(fabs(v.x), fabs(v.y), fabs(v.z));
}

static void take(search *x, vec3 m)
{
    const scene *c = x->scene;
    double y = min_of(max_of(vec_dot(m, c->u), -1), 1);
    double h = vec_dot(c->half, magnitudes(m)) + mark_at(&c->b, y).f - vec_dot(c->t, m);
    if (!(h < x->least)) return;
    x->least = h;
    x->axis = m;
}

/* ---- the bound of a cell ---- */

/* The least w.n so far, over unit n >= 0 with y = n.u in the strip. */
typedef struct lowest {
    vec3 w, u;
    const mark *from, *to;
    double value;
    vec3 n;
} lowest;

static inline bool in_strip(const lowest *l, vec3 n)
{
    double y = vec_dot(n, l->u);
    return y >= l->from->v - SLACK && y <= l->to->v + SLACK;
}

static inline bool in_octant(vec3 n)
{
    return n.x >= -OUTSIDE && n.y >= -OUTSIDE && n.z >= -OUTSIDE;
}

static inline void lower(lowest *l, double value, vec3 n)
{
    if (value < l->value) l->value = value, l->n = n;
}

/* Where no constraint matters, in the octant or on one of its faces: -w / |w| of what w has there. */
static inline bool try_free(lowest *l, vec3 w)
{
    double length = vec_norm(w);
    vec3 n = vec_scale(w, -1 / length);
    bool inside = length > 0 && in_octant(n) && in_strip(l, n);
    if (inside) lower(l, -length, n);
    return inside;
}

static inline void try_corner(lowest *l, vec3 e)
{
    if (in_strip(l, e)) lower(l, vec_dot(l->w, e), e);
}

static inline void try_circle(lowest *l, const mark *y)
{
    double along = vec_dot(l->w, l->u), rest2 = 0;
    vec3 beside = vec_madd(l->w, -along, l->u);
    rest2 = vec_norm2(beside);
    double rest = sqrt(rest2), value = y->v * along - rest * y->sine;
    vec3 n = vec_madd(vec_scale(l->u, y->v), rest > 0 ? -y->sine / rest : 0, beside);
    if (rest <= SLACK || in_octant(n)) lower(l, value, n);
}

/* (a, b): coordinates of u in the face; the two points of the circle y = v there. `put`: a point of the face. */
static inline void try_crossings(lowest *l, const mark *y, double ua, double ub, double wa, double wb, vec3 ea, vec3 eb)
{
    double s2 = ua * ua + ub * ub, q2 = s2 - y->v * y->v;
    if (!(s2 > 0) || q2 < -SLACK) return;
    double q = sqrt(max_of(q2, 0)), per = 1 / s2, slide = SLACK / sqrt(s2);
    for (int side = -1; side <= 1; side += 2) {
        double a = (y->v * ua - side * q * ub) * per, b = (y->v * ub + side * q * ua) * per;
        if (a < -OUTSIDE - slide || b < -OUTSIDE - slide) continue;
        lower(l, wa * a + wb * b - 8 * UNIT_ROUNDOFF * (fabs(wa) + fabs(wb)) / sqrt(s2),
            vec_madd(vec_scale(ea, a), b, eb));
    }
}

static void lowest_of(lowest *l)
{
    const vec3 x = vec(1, 0, 0), y = vec(0, 1, 0), z = vec(0, 0, 1), w = l->w, u = l->u;
    l->value = INFINITY;
    if (try_free(l, w)) return;
    try_free(l, vec(0, w.y, w.z));
    try_free(l, vec(w.x, 0, w.z));
    try_free(l, vec(w.x, w.y, 0));
    try_corner(l, x);
    try_corner(l, y);
    try_corner(l, z);
    const mark *ends[2] = {l->from, l->to};
    for (int i = 0; i < 2; i++) {
        try_circle(l, ends[i]);
        try_crossings(l, ends[i], u.x, u.y, w.x, w.y, x, y);
        try_crossings(l, ends[i], u.y, u.z, w.y, w.z, y, z);
        try_crossings(l, ends[i], u.z, u.x, w.z, w.x, z, x);
    }
}

static double level_of(const search *x)
{
    return min_of(x->least - x->short_by, x->enough);
}

/* The least w.n over an octant: at a corner, or at what of w is negative. */
static inline double least_in_octant(vec3 w)
{
    double least = min_of(w.x, min_of(w.y, w.z));
    if (least >= 0) return least;
    vec3 negative = vec(min_of(w.x, 0), min_of(w.y, 0), min_of(w.z, 0));
    return -vec_norm(negative);
}

/* True: it remains open. */
static bool bound_cell(search *x, cell *q)
{
    const scene *c = x->scene;
    double slope = (q->y2.f - q->y1.f) / (q->y2.v - q->y1.v);
    vec3 u = times(q->sign, c->u), v = vec_sub(c->half, times(q->sign, c->t)), w = vec_madd(v, slope, u);
    double chord = q->y1.f - slope * q->y1.v - c->noise * (c->p->size + fabs(slope)),
           whole = chord + least_in_octant(w);
    if (whole >= level_of(x)) {
        x->proved = min_of(x->proved, whole);
        return false;
    }
    lowest l = {.w = w, .u = u, .from = &q->y1, .to = &q->y2};
    lowest_of(&l);
    if (l.value == INFINITY) return false; /* no direction has such a cosine */
    q->bound = chord + l.value;
    if (q->bound >= level_of(x)) {
        x->proved = min_of(x->proved, q->bound);
        return false;
    }
    double y = vec_dot(l.n, u);
    q->y = min_of(max_of(y, q->y1.v), q->y2.v);
    take(x, direction_of(times(q->sign, l.n)));
    return true;
}

/* ---- search ---- */

/* False: too many cells. */
static bool add(search *x, vec3 sign, mark y1, mark y2)
{
    if (!(y1.v < y2.v)) return true;
    if (x->count == CELLS_MAX) return false;
    cell *q = &x->open[x->count];
    q->sign = sign, q->y1 = y1, q->y2 = y2;
    x->count += bound_cell(x, q);
    x->steps++;
    return true;
}

static bool split(search *x, const cell *q)
{
    double least = EDGE * (q->y2.v - q->y1.v);
    mark mid = mark_at(&x->scene->b, min_of(max_of(q->y, q->y1.v + least), q->y2.v - least));
    return add(x, q->sign, q->y1, mid) && add(x, q->sign, mid, q->y2);
}

static int least_of(const search *x)
{
    int least = 0;
    for (int i = 1; i < x->count; i++)
        if (x->open[i].bound < x->open[least].bound) least = i;
    return least;
}

static bool is_deep(const search *x)
{
    return x->least > SHALLOW * x->scene->p->size;
}

/* Until no cell is below what is allowed. False: too many, or the cores turn out to be apart or nearly so. */
static bool close_cells(search *x)
{
    for (int i = 0; i < SPLITS_MAX && x->count > 0 && is_deep(x); i++) {
        int least = least_of(x);
        cell q = x->open[least];
        if (q.bound >= level_of(x)) {
            x->proved = min_of(x->proved, q.bound);
            return true;
        }
        x->open[least] = x->open[--x->count];
        if (!split(x, &q)) return false;
    }
    return x->count == 0 && is_deep(x);
}

/* ---- the first cells ---- */

static void try_axes(search *x)
{
    const scene *c = x->scene;
    vec3 t = c->t;
    if (vec_norm2(t) > 0) take(x, direction_of(t));
    take(x, vec(t.x < 0 ? -1 : 1, 0, 0));
    take(x, vec(0, t.y < 0 ? -1 : 1, 0));
    take(x, vec(0, 0, t.z < 0 ? -1 : 1));
}

static bool open_cells(search *x)
{
    const scene *c = x->scene;
    end ends[2];
    try_axes(x);
    for (int i = 0; i < 2; i++) {
        double side = 2 * i - 1;
        vec3 n = vec_scale(c->u, side);
        ends[i] = end_of(&c->b, side, n, vec_sub(c->t, unit_pair_support_a(c->p, n, NULL)));
        take(x, n);
    }
    if (!is_deep(x)) return false;
    range at = range_of(&c->b, ends, x->least);
    for (int i = 0; i < 8; i++) {
        vec3 sign = vec(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1);
        for (int k = 0; k < 2; k++) add(x, sign, at.at[k], at.at[k + 1]);
    }
    return true;
}

/* From deepest points of either to such that face each other, where they are not the only ones. */
static void face(const scene *c, span *s)
{
    double slack = c->p->error, depth = -s->lo;
    vec3 a = vec_madd(s->point_b, depth, s->axis), out = vec_sub(magnitudes(a), c->half);
    vec3 b = vec_madd(s->point_a, -depth, s->axis);
    if (out.x <= slack && out.y <= slack && out.z <= slack)
        s->point_a = a;
    else if (outline_holds(&c->b, mat_tmul(c->p->b_in_a.r, vec_sub(b, c->t)), slack))
        s->point_b = b;
}

bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = {.p = p, .b = outline_of(&p->b), .half = p->a.half, .u = vec_neg(p->b_in_a.r.z), .t = p->b_in_a.t};
    c.noise = NOISE * UNIT_ROUNDOFF;
    double rounding = 4 * c.noise * p->size;
    search x;
    x.scene = &c;
    x.least = x.proved = INFINITY;
    x.short_by = max_of(0.5 * goal->tolerance, rounding);
    x.enough = -goal->near;
    x.steps = 0;
    x.count = 0;
    out->axis = VEC_ZERO;
    if (!open_cells(&x) || !close_cells(&x)) return false;
    minkowski m = unit_pair_nearest_along(p, x.axis);
    double lo = vec_dot(x.axis, m.w), hi = max_of(lo, -min_of(x.proved, x.least));
    if (!narrow_goal_reached(goal, lo, hi) && !(hi - lo <= 2 * rounding)) return false;
    *out = (span){.lo = lo,
        .hi = hi,
        .axis = x.axis,
        .point_a = m.a,
        .point_b = m.b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = x.steps};
    face(&c, out);
    return true;
}
