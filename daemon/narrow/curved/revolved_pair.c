/* revolved_pair: branch and bound over the cosines between a direction and the two axes. Pure; any thread.
 *
 * A stands at the origin about z; u is minus B's axis, t its centre. Along a unit axis m from A towards B let x = m.z
 * and y = m.u. The cores overlap by
 *     h(m) = f_A(x) + f_B(y) - t.m,
 * f the support function of the outline: h |x| + r sqrt(1 - x^2) of a cylinder, max(h x, r sqrt(1 - x^2) - h x) of a
 * cone, h |x| of a capsule's segment. The depth is the least h. Between its kinks f is concave: over a cell
 * x1 <= x <= x2, y1 <= y <= y2 without kinks inside it is nowhere below its chords, so that
 *     h(m) >= c + w.m,   w = slope_A z + slope_B u - t.
 * The least w.m over the cell has a closed form: it is at -w / |w|, or the least on one of the circles x = x1, x = x2,
 * y = y1, y = y2, or where two of them meet. Chords are exact at the corners of a cell, where the least h often is (two
 * sides that cross), and off by the square of its width elsewhere. Cells whose bound falls short of the least h found
 * by more than is allowed are split where the bound is least, which also gives the next h.
 *
 * What the flat ends hold (revolved.h) is cut off the ranges of x and y.
 *
 * Directions come in pairs that mirror each other in the plane of the axes, e the part along that plane across z; of a
 * pair only that with the greater t.m matters. */
#include "narrow/convex/gjk.h"
#include "revolved.h"

enum { CELLS_MAX = 48 /* open at a time */, SPLITS_MAX = 200 };

static const double PARALLEL =
    0.01;                          /* sine of the angle between the axes; below, corners of cells are ill-conditioned */
static const double SHALLOW = 0.1; /* of the size: less depth is found sooner by other means */
static const double NOISE = 64;    /* rounding of a bound, in units of the last place: a dozen operations, rounded up */
static const double OFF = 16;      /* of e, in units of the last place of |y| + |g x|: derived at try_corner */
static const double SLACK = 1e-12; /* by which a point may be outside of a cell and still counts for its bound */
static const double EDGE = 0.1;    /* no part of a cell that is split is smaller than this share */

typedef struct scene {
    const unit_pair *p;
    outline a, b;
    double g, s;       /* cosine and sine between z and u */
    vec3 u, across;    /* across: unit, u without its part along z; the third is z x across */
    double tz, ta, tk; /* t along z and across, and its size along the third */
    double side;       /* on which side of the plane t is */
} scene;

typedef struct cell {
    mark x1, x2, y1, y2;
    double bound;        /* no h in the cell is less */
    double x, y;         /* where the bound is */
    double gap_x, gap_y; /* by how much the outlines are above their chords there */
} cell;

typedef struct search {
    const scene *scene;
    double least, x, y; /* the least h found, and where */
    double proved;      /* of the cells that were closed */
    double short_by, enough;
    uint32_t steps;
    int count;
    cell open[CELLS_MAX];
} search;

static scene revolved_scene_of(const unit_pair *p)
{
    vec3 u = vec_neg(p->b_in_a.r.z), t = p->b_in_a.t;
    double s = sqrt(u.x * u.x + u.y * u.y);
    scene at = {.p = p, .a = outline_of(&p->a), .b = outline_of(&p->b), .g = u.z, .s = s, .u = u};
    if (!(s > PARALLEL)) return at;
    at.across = vec(u.x / s, u.y / s, 0);
    double k = t.y * at.across.x - t.x * at.across.y;
    at.tz = t.z;
    at.ta = t.x * at.across.x + t.y * at.across.y;
    at.tk = fabs(k);
    at.side = k < 0 ? -1 : 1;
    return at;
}

/* The direction with these cosines, on the side of t. */
static vec3 direction_at(const scene *c, double x, double y)
{
    if (fabs(x) == 1) return vec(0, 0, x);
    if (fabs(y) == 1) return vec_scale(c->u, y);
    double e = (y - c->g * x) / c->s, k = c->side * sqrt(max_of(1 - x * x - e * e, 0));
    return direction_of(vec(e * c->across.x - k * c->across.y, e * c->across.y + k * c->across.x, x));
}

/* ---- the bound of a cell ---- */

static inline bool revolved_between(double v, const mark *from, const mark *to)
{
    return v >= from->v - SLACK && v <= to->v + SLACK;
}

typedef struct lowest {
    double value, x, y;
} lowest;

static inline void lower(lowest *l, double value, double x, double y)
{
    if (value < l->value) *l = (lowest){value, x, y};
}

/* w by its parts: along z, across, along u, and in the plane of the axes orthogonal to u. */
typedef struct slope {
    double z, across, u, other;
} slope;

static inline void try_circle(
    lowest *l, const scene *c, const mark *at, double along, double beside, const mark *from, const mark *to, bool of_x)
{
    double rest = sqrt(beside * beside + c->tk * c->tk), value = at->v * along - rest * at->sine;
    double other = rest > 0 ? at->v * c->g - c->s * at->sine * beside / rest : from->v;
    if (rest > SLACK && !revolved_between(other, from, to)) return;
    lower(l, value, of_x ? at->v : other, of_x ? other : at->v);
}

/* Of all only e is divided by the sine of the angle between the axes. What its rounding may be is held against the
 * bound there, so that all else, and corners where it is none (two sides that cross: x = y = 0), lose nothing where
 * axes are nearly parallel. u may be 3 u longer than 1, so g and s may be; s has 2 u of its own; product, difference
 * and quotient have one each: less than 12 u (|y| + |g x|) / s. */
static inline void try_corner(lowest *l, const scene *c, const slope *w, const mark *x, const mark *y)
{
    double gx = c->g * x->v, e = (y->v - gx) / c->s, off = OFF * UNIT_ROUNDOFF * (fabs(y->v) + fabs(gx)) / c->s;
    double k2 = 1 - x->v * x->v - e * e + NOISE * UNIT_ROUNDOFF + off * (2 * fabs(e) + off);
    if (k2 >= 0) lower(l, x->v * w->z + e * w->across - off * fabs(w->across) - c->tk * sqrt(k2), x->v, y->v);
}

static lowest lowest_on_rim(const scene *c, const slope *w, const cell *q)
{
    lowest l = {INFINITY, q->x1.v, q->y1.v};
    try_circle(&l, c, &q->x1, w->z, w->across, &q->y1, &q->y2, true);
    try_circle(&l, c, &q->x2, w->z, w->across, &q->y1, &q->y2, true);
    try_circle(&l, c, &q->y1, w->u, w->other, &q->x1, &q->x2, false);
    try_circle(&l, c, &q->y2, w->u, w->other, &q->x1, &q->x2, false);
    try_corner(&l, c, w, &q->x1, &q->y1);
    try_corner(&l, c, w, &q->x1, &q->y2);
    try_corner(&l, c, w, &q->x2, &q->y1);
    try_corner(&l, c, w, &q->x2, &q->y2);
    return l;
}

static double gap_above(const outline *o, const mark *from, double slope, double v)
{
    mark at = mark_at(o, v);
    return max_of(at.f - from->f - slope * (v - from->v), 0);
}

static double revolved_inside(double v, const mark *from, const mark *to)
{
    return min_of(max_of(v, from->v), to->v);
}

static void bound_cell(const scene *c, cell *q)
{
    double slope_a = (q->x2.f - q->x1.f) / (q->x2.v - q->x1.v), slope_b = (q->y2.f - q->y1.f) / (q->y2.v - q->y1.v);
    slope w = {.z = slope_a + slope_b * c->g - c->tz, .across = slope_b * c->s - c->ta};
    w.u = w.z * c->g + w.across * c->s;
    w.other = w.z * c->s - w.across * c->g;
    double length = sqrt(w.z * w.z + w.across * w.across + c->tk * c->tk);
    lowest l = {-length, -w.z / length, -w.u / length};
    if (!(length > SLACK) || !revolved_between(l.x, &q->x1, &q->x2) || !revolved_between(l.y, &q->y1, &q->y2))
        l = lowest_on_rim(c, &w, q);
    double chords = q->x1.f - slope_a * q->x1.v + q->y1.f - slope_b * q->y1.v;
    q->bound = chords + l.value - NOISE * UNIT_ROUNDOFF * (c->p->size + fabs(slope_a) + fabs(slope_b));
    q->x = revolved_inside(l.x, &q->x1, &q->x2);
    q->y = revolved_inside(l.y, &q->y1, &q->y2);
    q->gap_x = gap_above(&c->a, &q->x1, slope_a, q->x);
    q->gap_y = gap_above(&c->b, &q->y1, slope_b, q->y);
}

/* ---- search ---- */

static void take(search *x, double h, double cosine_a, double cosine_b)
{
    if (!(h < x->least)) return;
    x->least = h;
    x->x = cosine_a;
    x->y = cosine_b;
}

/* False: too many cells. */
static bool add(search *x, mark x1, mark x2, mark y1, mark y2)
{
    if (!(x1.v < x2.v && y1.v < y2.v)) return true;
    if (x->count == CELLS_MAX) return false;
    cell *q = &x->open[x->count];
    q->x1 = x1, q->x2 = x2, q->y1 = y1, q->y2 = y2;
    bound_cell(x->scene, q);
    x->steps++;
    if (q->bound == INFINITY) return true; /* no direction has such cosines */
    take(x, q->bound + q->gap_x + q->gap_y, q->x, q->y);
    x->count++;
    return true;
}

static double split_at(double v, const mark *from, const mark *to)
{
    double least = EDGE * (to->v - from->v);
    return min_of(max_of(v, from->v + least), to->v - least);
}

static bool split(search *x, const cell *q)
{
    const scene *c = x->scene;
    if (q->gap_x >= q->gap_y) {
        mark mid = mark_at(&c->a, split_at(q->x, &q->x1, &q->x2));
        return add(x, q->x1, mid, q->y1, q->y2) && add(x, mid, q->x2, q->y1, q->y2);
    }
    mark mid = mark_at(&c->b, split_at(q->y, &q->y1, &q->y2));
    return add(x, q->x1, q->x2, q->y1, mid) && add(x, q->x1, q->x2, mid, q->y2);
}

static int revolved_least_of(const search *x)
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
        int least = revolved_least_of(x);
        cell q = x->open[least];
        if (q.bound >= min_of(x->least - x->short_by, x->enough)) {
            x->proved = min_of(x->proved, q.bound);
            return true;
        }
        x->open[least] = x->open[--x->count];
        if (!split(x, &q)) return false;
    }
    return x->count == 0 && is_deep(x);
}

/* ---- the first cells ---- */

/* h along the direction with these cosines, if there is one. */
static void try_cosines(search *x, double cosine_a, double cosine_b)
{
    const scene *c = x->scene;
    double e = (cosine_b - c->g * cosine_a) / c->s, k2 = 1 - cosine_a * cosine_a - e * e;
    mark a = mark_at(&c->a, cosine_a), b = mark_at(&c->b, cosine_b);
    if (k2 >= 0) take(x, a.f + b.f - cosine_a * c->tz - e * c->ta - sqrt(k2) * c->tk, cosine_a, cosine_b);
}

static bool open_cells(search *x)
{
    const scene *c = x->scene;
    end a[2], b[2];
    double away = sqrt(c->tz * c->tz + c->ta * c->ta + c->tk * c->tk);
    if (away > 0) try_cosines(x, c->tz / away, (c->tz * c->g + c->ta * c->s) / away);
    try_cosines(x, c->a.kink, c->b.kink);
    if (!is_deep(x)) return false;
    for (int i = 0; i < 2; i++) {
        double side = 2 * i - 1;
        vec3 n = vec(0, 0, side), v = vec_scale(c->u, side);
        a[i] = end_of(&c->a, side, n, unit_pair_support_b(c->p, vec_neg(n), NULL));
        b[i] = end_of(&c->b, side, v, vec_sub(c->p->b_in_a.t, unit_pair_support_a(c->p, v, NULL)));
        take(x, a[i].h, side, side * c->g);
        take(x, b[i].h, side * c->g, side);
    }
    if (!is_deep(x)) return false;
    range at_a = range_of(&c->a, a, x->least), at_b = range_of(&c->b, b, x->least);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++) add(x, at_a.at[i], at_a.at[i + 1], at_b.at[k], at_b.at[k + 1]);
    return true;
}

bool revolved_pair_measure(const unit_pair *p, const narrow_goal *goal, span *out)
{
    scene c = revolved_scene_of(p);
    search x;
    out->axis = VEC_ZERO;
    if (!(c.s > PARALLEL)) return false;
    double rounding = 4 * (NOISE + OFF / c.s) * UNIT_ROUNDOFF * p->size;
    x.scene = &c;
    x.least = x.proved = INFINITY;
    x.x = x.y = 0;
    x.short_by = max_of(0.5 * goal->tolerance, rounding);
    x.enough = -goal->near;
    x.steps = 0;
    x.count = 0;
    if (!open_cells(&x) || !close_cells(&x)) return false;
    vec3 axis = direction_at(&c, x.x, x.y);
    minkowski m = unit_pair_nearest_along(p, axis);
    double lo = vec_dot(axis, m.w);
    double hi = max_of(lo, -min_of(x.proved, x.least));
    if (!narrow_goal_reached(goal, lo, hi) && !(hi - lo <= 2 * rounding)) return false;
    *out = (span){.lo = lo, .hi = hi, .axis = axis, .method = NARROW_BY_CLOSED_FORM, .iterations = x.steps};
    if (!witness_facing(p, &m, out) && goal->near == -INFINITY) witness_deepest(p, out);
    return true;
}
