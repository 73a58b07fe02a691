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

#include "lanes.h"
#include "outline.h"

enum { CELLS_MAX = 48 /* open at a time */, SPLITS_MAX = 200 };

static const double SHALLOW = 0.1;  /* of the size: less depth is found sooner by other means */
static const double NOISE = 64;     /* rounding of a bound, in units of the last place, with room */
static const double SLACK = 1e-12;  /* by which a point may be outside of a strip and still counts for its bound */
static const double OUTSIDE = 1e-9; /* the same of an octant */
static const double EDGE = 0.1;     /* no part of a strip that is split is smaller than this share */

/* What the faces x, y; y, z; z, x (and x, y again) of all octants share: of u in them the length, squared and inverse,
 * and by how much a point may be outside and a value off because it is short. Where it is zero, y is the same all over.
 */
typedef struct faces {
    double s2[LANES], per_s2[LANES], outside[LANES], blur[LANES];
} faces;

typedef struct scene {
    const unit_pair *p;
    outline b;
    vec3 half, u, t;
    double noise;
    faces faces;
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
    bool wide;
    int count;
    cell open[CELLS_MAX];
} search;

static faces faces_of(vec3 u)
{
    const double along[LANES + 1] = {u.x, u.y, u.z, u.x, u.y};
    faces f;
    for (int k = 0; k < LANES; k++) {
        double s2 = along[k] * along[k] + along[k + 1] * along[k + 1], per = s2 > 0 ? 1 / sqrt(s2) : 0;
        f.s2[k] = s2 > 0 ? s2 : -1;
        f.per_s2[k] = per * per;
        f.outside[k] = -OUTSIDE - SLACK * per;
        f.blur[k] = 8 * UNIT_ROUNDOFF * per;
    }
    return f;
}

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

/* A cell, for the search of its least w.n over unit n >= 0 with n.u in the strip. What may be the least is looked at
 * side by side and without branches: which of it is in the cell is anybody's guess. */
typedef struct corner_case {
    vec3 w, u;
    const mark *from, *to;
    double u_xyz[LANES], w_xyz[LANES]; /* x, y, z, x */
    double value;                      /* the least so far, ... */
    vec3 n;                            /* ... and where */
} corner_case;

LANES_INLINE lane_mask in_strip(const corner_case *q, lanes y)
{
    return (y >= lanes_of(q->from->v - SLACK)) & (y <= lanes_of(q->to->v + SLACK));
}

LANES_INLINE lanes3 spread(vec3 v)
{
    return (lanes3){lanes_of(v.x), lanes_of(v.y), lanes_of(v.z)};
}

/* Is any of those values whose mask is set less than what there is? *best: they, and INFINITY for the others. */
LANES_INLINE bool is_lower(const corner_case *q, lane_mask valid, lanes value, lanes *best)
{
    *best = lanes_choose(valid, value, lanes_of(INFINITY));
    return lanes_bits(*best < lanes_of(q->value)) != 0;
}

LANES_INLINE void take_least(corner_case *q, lanes best, lanes3 n)
{
    for (int k = 0; k < LANES; k++)
        if (best[k] < q->value) q->value = best[k], q->n = vec(n.x[k], n.y[k], n.z[k]);
}

/* Where no constraint matters, in the octant or on one of its faces: -w / |w| of what w has there. */
LANES_INLINE void try_free(corner_case *q)
{
    vec3 w = q->w;
    lanes3 part = {{w.x, 0, w.x, w.x}, {w.y, w.y, 0, w.y}, {w.z, w.z, w.z, 0}};
    lanes length = lanes_sqrt(lanes3_dot(part, part)), per = -1 / length, outside = lanes_of(-OUTSIDE);
    lanes3 n = {part.x * per, part.y * per, part.z * per};
    lane_mask valid = (n.x >= outside) & (n.y >= outside) & (n.z >= outside) & in_strip(q, lanes3_dot(n, spread(q->u)));
    lanes best;
    if (is_lower(q, valid & (length > lanes_of(0)), -length, &best)) take_least(q, best, n);
}

LANES_INLINE void try_corners(corner_case *q)
{
    lanes u = lanes_load(q->u_xyz), w = lanes_load(q->w_xyz);
    lanes best;
    if (is_lower(q, in_strip(q, u), w, &best)) take_least(q, best, (lanes3){{1, 0, 0, 1}, {0, 1, 0, 0}, {0, 0, 1, 0}});
}

LANES_INLINE void try_circles(corner_case *q)
{
    double along = vec_dot(q->w, q->u);
    vec3 beside = vec_madd(q->w, -along, q->u);
    double rest = vec_norm(beside), per = rest > 0 ? -1 / rest : 0;
    lanes v = {q->from->v, q->to->v, q->from->v, q->to->v}, outside = lanes_of(-OUTSIDE);
    lanes sine = {q->from->sine, q->to->sine, q->from->sine, q->to->sine}, part = sine * per;
    lanes3 n = {v * q->u.x + part * beside.x, v * q->u.y + part * beside.y, v * q->u.z + part * beside.z};
    lane_mask valid = (n.x >= outside) & (n.y >= outside) & (n.z >= outside);
    lanes best;
    if (is_lower(q, valid | (lanes_of(rest) <= lanes_of(SLACK)), v * along - sine * rest, &best))
        take_least(q, best, n);
}

/* The circle y = v and the faces x, y; y, z; z, x: two points each. */
LANES_INLINE void try_crossings(corner_case *q, const faces *f, double v)
{
    vec3 u = q->u, w = q->w;
    lanes ua = lanes_load(q->u_xyz), ub = {u.y, u.z, u.x, u.y}, wa = lanes_load(q->w_xyz), wb = {w.y, w.z, w.x, w.y};
    lanes q2 = lanes_load(f->s2) - v * v, zero = lanes_of(0), outside = lanes_load(f->outside);
    lanes reach = lanes_sqrt(lanes_choose(q2 > zero, q2, zero)), per = lanes_load(f->per_s2);
    lanes sizes = lanes_choose(wa < zero, -wa, wa) + lanes_choose(wb < zero, -wb, wb);
    lanes blur = sizes * lanes_load(f->blur), va = v * ua, vb = v * ub;
    lane_mask there = q2 >= lanes_of(-SLACK);
    for (int side = -1; side <= 1; side += 2, reach = -reach) {
        lanes a = (va + reach * ub) * per, b = (vb - reach * ua) * per, best;
        if (is_lower(q, there & (a >= outside) & (b >= outside), wa * a + wb * b - blur, &best))
            take_least(q, best, (lanes3){{a[0], 0, b[2], a[0]}, {b[0], a[1], 0, b[0]}, {0, b[1], a[2], 0}});
    }
}

LANES_INLINE void find_least(corner_case *q, const faces *f)
{
    q->value = INFINITY;
    try_free(q);
    try_corners(q);
    try_circles(q);
    try_crossings(q, f, q->from->v);
    try_crossings(q, f, q->to->v);
}

LANES_WIDE static void find_least_wide(corner_case *q, const faces *f)
{
    find_least(q, f);
}

static void find_least_narrow(corner_case *q, const faces *f)
{
    find_least(q, f);
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
    corner_case l = {w, u, &q->y1, &q->y2, {u.x, u.y, u.z, u.x}, {w.x, w.y, w.z, w.x}, 0, w};
    (x->wide ? find_least_wide : find_least_narrow)(&l, &c->faces);
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
    if (!is_deep(x)) return;
    take(x, vec(t.x < 0 ? -1 : 1, 0, 0));
    take(x, vec(0, t.y < 0 ? -1 : 1, 0));
    take(x, vec(0, 0, t.z < 0 ? -1 : 1));
}

static bool open_cells(search *x)
{
    const scene *c = x->scene;
    end ends[2];
    try_axes(x);
    if (!is_deep(x)) return false;
    for (int i = 0; i < 2; i++) {
        double side = 2 * i - 1;
        vec3 n = vec_scale(c->u, side);
        ends[i] = end_of(&c->b, side, n, vec_sub(c->t, unit_pair_support_a(c->p, n, NULL)));
        take(x, n);
    }
    if (!is_deep(x)) return false;
    range at = range_of(&c->b, ends, x->least);
    vec3 first = vec(copysign(1, c->t.x), copysign(1, c->t.y), copysign(1, c->t.z)); /* likely to hold the least */
    for (int i = 0; i < 8; i++) {
        vec3 sign = times(first, vec(i & 1 ? -1 : 1, i & 2 ? -1 : 1, i & 4 ? -1 : 1));
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

static scene scene_of(const unit_pair *p)
{
    scene c = {.p = p, .b = outline_of(&p->b), .half = p->a.half, .u = vec_neg(p->b_in_a.r.z), .t = p->b_in_a.t};
    c.noise = NOISE * UNIT_ROUNDOFF;
    c.faces = faces_of(c.u);
    return c;
}

bool box_revolved_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = scene_of(p);
    double rounding = 4 * c.noise * p->size;
    search x;
    x.scene = &c;
    x.least = x.proved = INFINITY;
    x.short_by = max_of(0.5 * goal->tolerance, rounding);
    x.enough = -goal->near;
    x.steps = 0;
    x.wide = lanes_wide();
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
