/* rim_newton: two parts along a direction, and Newton's method to the one in which they are farthest apart. Pure; any
 * thread.
 *
 * Along n the gap between a disc of A (centre a, radius r) and one of B (b, s) is
 *     g(n) = n.(b - a) - r |Pa n| - s |Pb n| = n.w,   w = (b - s Pb n / |Pb n|) - (a + r Pa n / |Pa n|),
 * P the projection along the disc's axis. Along the unit sphere its gradient is w - g n, and its second derivative
 * -(g + r / |Pa n| ta ta' + s / |Pb n| tb tb'), t = the unit vector orthogonal to n and to the disc's axis. */
#include "rim_newton.h"

#include "scalar.h"

enum { APPROACH_MAX = 8, LAST_MAX = 3, CELLS_TRIED = 3 };

/* Of the size, unless said otherwise. */
static const double SHORT = 0x1p-10;   /* edges and sides are longer than this */
static const double CROSS = 0x1p-10;   /* sine of the angle between two edges, or sides */
static const double CELL = 0x1p-16;    /* directions */
static const double BORDER = 0x1p-26;  /* directions */
static const double EVEN = 0x1p-50;    /* what must be equally high is */
static const double LEFT = 0x1p-30;    /* the most that the next step would be */
static const double SERIES2 = 0x1p-18; /* square of a step, of which three terms of a series are enough */
static const double NEAR2 = 0x1p-24;   /* square of the last step of the approach */
static const double STRIDE = 0.5;      /* a longer step leaves what the derivatives know */

/* ---- two parts along a direction ---- */

typedef struct look { /* at a part: the top of each disc along a direction */
    vec3 top[2];
    vec3 t;     /* unit, orthogonal to the direction and to the axis of the discs */
    double per; /* 1 / sine of the angle between these */
} look;

/* `out`: unit, outward. False: along the axis of its rims. A is the one in whose frame all is. */
static inline bool look_at_a(const rim_part *a, vec3 out, look *l)
{
    l->t = VEC_ZERO;
    l->per = 1;
    l->top[0] = a->centre[0], l->top[1] = a->centre[1];
    if (!a->has_rim) return true;
    double sine2 = out.x * out.x + out.y * out.y;
    if (!(sine2 > 0.25 * RIM_SINE * RIM_SINE)) return false;
    double per = 1 / sqrt(sine2), c = per * out.x, s = per * out.y;
    l->per = per;
    l->t = vec(-s, c, 0);
    l->top[0].x += a->radius[0] * c, l->top[0].y += a->radius[0] * s;
    l->top[1].x += a->radius[1] * c, l->top[1].y += a->radius[1] * s;
    return true;
}

static inline bool look_at_b(const rim_part *b, vec3 out, look *l)
{
    l->t = VEC_ZERO;
    l->per = 1;
    l->top[0] = b->centre[0], l->top[1] = b->centre[1];
    if (!b->has_rim) return true;
    double along_x = vec_dot(out, b->x), along_y = vec_dot(out, b->y), sine2 = along_x * along_x + along_y * along_y;
    if (!(sine2 > 0.25 * RIM_SINE * RIM_SINE)) return false;
    double per = 1 / sqrt(sine2), c = per * along_x, s = per * along_y;
    vec3 u = vec_madd(vec_scale(b->x, c), s, b->y);
    l->per = per;
    l->t = vec_madd(vec_scale(b->y, c), -s, b->x);
    l->top[0] = vec_madd(l->top[0], b->radius[0], u);
    l->top[1] = vec_madd(l->top[1], b->radius[1], u);
    return true;
}

/* One disc each. With x = ta.d and y = tb.d, (g + alpha ta ta' + beta tb tb') d = q becomes two equations. */
static void step_free(const rim_part *a, const rim_part *b, const look *of_a, const look *of_b, rim_stand *s)
{
    vec3 w = vec_sub(of_b->top[0], of_a->top[0]), q;
    double g = vec_dot(w, s->n), alpha = a->radius[0] * of_a->per, beta = b->radius[0] * of_b->per;
    double c = vec_dot(of_a->t, of_b->t);
    q = vec_madd(w, -g, s->n);
    double qa = vec_dot(of_a->t, q), qb = vec_dot(of_b->t, q);
    double whole = (g + alpha) * (g + beta) - alpha * beta * c * c;
    double x = ((g + beta) * qa - beta * c * qb) / whole, y = ((g + alpha) * qb - alpha * c * qa) / whole;
    s->lo = g;
    s->share_a = s->share_b = s->uneven = 0;
    s->step = vec_scale(vec_madd(vec_madd(q, -alpha * x, of_a->t), -beta * y, of_b->t), 1 / g);
}

/* Two discs of one of them: w0 and w1 are equally high along the line, and along it the gap is greatest. */
static bool step_on_line(
    const rim_part *a, const rim_part *b, const look *of_a, const look *of_b, double size, rim_stand *s)
{
    vec3 n = s->n, w0 = vec_sub(of_b->top[0], of_a->top[0]);
    bool two_a = a->discs == 2;
    vec3 w1 = two_a ? vec_sub(of_b->top[0], of_a->top[1]) : vec_sub(of_b->top[1], of_a->top[0]);
    double g0 = vec_dot(w0, n), g1 = vec_dot(w1, n);
    vec3 apart = vec_madd(vec_sub(w0, w1), g1 - g0, n);
    double length2 = vec_norm2(apart);
    if (!(length2 > SHORT * SHORT * size * size)) return false;
    double per = 1 / length2, along = (g1 - g0) * per, first = -vec_dot(w1, apart) * per, second = 1 - first;
    vec3 j = vec_cross(n, apart); /* as long as that */
    double alpha = (two_a ? first * a->radius[0] + second * a->radius[1] : a->radius[0]) * of_a->per;
    double beta = (two_a ? b->radius[0] : first * b->radius[0] + second * b->radius[1]) * of_b->per;
    double aj = vec_dot(of_a->t, j), bj = vec_dot(of_b->t, j);
    double g = first * g0 + second * g1;
    double ij = alpha * vec_dot(of_a->t, apart) * aj + beta * vec_dot(of_b->t, apart) * bj;
    double jj = g * length2 + max_of(alpha, 0) * aj * aj + max_of(beta, 0) * bj * bj;
    double across = (vec_dot(w1, j) - ij * along) / jj;
    s->lo = min_of(g0, g1);
    s->uneven = fabs(g1 - g0);
    s->share_a = two_a ? second : 0;
    s->share_b = two_a ? 0 : second;
    s->step = vec_madd(vec_scale(apart, along), across, j);
    return jj > 0;
}

/* Two discs of each: the direction is that along which all are equally high. */
static bool step_to_crossing(const look *of_a, const look *of_b, double size, rim_stand *s)
{
    vec3 n = s->n, w = vec_sub(of_b->top[0], of_a->top[0]);
    vec3 ea = vec_sub(of_a->top[1], of_a->top[0]), eb = vec_sub(of_b->top[0], of_b->top[1]);
    double whole = vec_dot(n, vec_cross(ea, eb)), a2 = vec_norm2(ea), b2 = vec_norm2(eb),
           least = SHORT * SHORT * size * size;
    if (!(a2 > least && b2 > least && whole * whole > CROSS * CROSS * a2 * b2)) return false;
    double g = vec_dot(w, n), ga = g - vec_dot(ea, n), gb = g - vec_dot(eb, n), per = 1 / whole;
    s->share_a = vec_dot(n, vec_cross(w, eb)) * per;
    s->share_b = vec_dot(n, vec_cross(ea, w)) * per;
    s->lo = min_of(min_of(g, ga), min_of(gb, ga + gb - g));
    s->uneven = max_of(fabs(ga - g), fabs(gb - g));
    s->step = vec_scale(vec_madd(vec_scale(vec_cross(eb, n), ga - g), gb - g, vec_cross(n, ea)), per);
    return true;
}

static vec3 between(const rim_part *x, const look *l, double share)
{
    return x->discs == 1 ? l->top[0] : vec_madd(l->top[0], share, vec_sub(l->top[1], l->top[0]));
}

/* Along s->n. False: no place for these features. */
static bool stand_at(const rim_part *a, const rim_part *b, double size, rim_stand *s)
{
    look of_a, of_b;
    if (!look_at_a(a, s->n, &of_a) || !look_at_b(b, vec_neg(s->n), &of_b)) return false;
    if (a->discs == 2 && b->discs == 2) {
        if (!step_to_crossing(&of_a, &of_b, size, s)) return false;
    } else if (a->discs == 2 || b->discs == 2) {
        if (!step_on_line(a, b, &of_a, &of_b, size, s)) return false;
    } else {
        step_free(a, b, &of_a, &of_b, s);
    }
    s->point_a = between(a, &of_a, s->share_a);
    s->point_b = between(b, &of_b, s->share_b);
    return s->lo > 0;
}

/* ---- Newton's method ---- */

/* |n + step|^2 = 1 + |step|^2: of a short step the root is its series. */
static inline void take_step(rim_stand *s, double length2)
{
    if (length2 < SERIES2) {
        s->n = vec_scale(vec_add(s->n, s->step), 1 - length2 * (0.5 - 0.375 * length2));
        return;
    }
    double shorter = length2 > STRIDE * STRIDE ? STRIDE / sqrt(length2) : 1;
    s->n = direction_of(vec_madd(s->n, shorter, s->step));
}

/* From anywhere to nearly there. */
static bool approach(const rim_part *a, const rim_part *b, double size, rim_stand *s)
{
    for (int i = 0; i < APPROACH_MAX; i++) {
        if (!stand_at(a, b, size, s)) return false;
        double length2 = vec_norm2(s->step);
        take_step(s, length2);
        if (length2 <= NEAR2) return true;
    }
    return false;
}

/* The multiple of CELL that is the nearest, as sums are rounded. */
static inline double cell_of(double x)
{
    const double first = 0x1.8p52 * CELL;
    return (x + first) - first;
}

static inline bool in_cell(double x, double cell)
{
    return fabs(x - cell) <= 0.5 * CELL - BORDER;
}

/* From the centre of the cell that s->n is in; then that is the place. False: not found; and it may be in another cell.
 */
static bool arrive(const rim_part *a, const rim_part *b, double size, rim_stand *s)
{
    vec3 cell = vec(cell_of(s->n.x), cell_of(s->n.y), cell_of(s->n.z));
    s->n = direction_of(cell);
    for (int i = 0; i < LAST_MAX; i++) {
        if (!stand_at(a, b, size, s)) return false;
        double length2 = vec_norm2(s->step);
        if (i && length2 <= LEFT * LEFT && s->uneven <= EVEN * size)
            return in_cell(s->n.x, cell.x) && in_cell(s->n.y, cell.y) && in_cell(s->n.z, cell.z);
        take_step(s, length2);
    }
    return false;
}

bool rim_stand_between(const rim_part *a, const rim_part *b, double size, rim_stand *s)
{
    if (!approach(a, b, size, s)) return false;
    for (int i = 0; i < CELLS_TRIED; i++)
        if (arrive(a, b, size, s)) return true;
    return false;
}

/* ---- faces ---- */

bool rim_stand_on_face(const rim_part *face, const rim_part *other, double sign, rim_stand *s)
{
    look l;
    vec3 in = vec_neg(face->axis);
    if (other->is_face || other->discs == 2 || !(sign > 0 ? look_at_b : look_at_a)(other, in, &l)) return false;
    double gap = vec_dot(face->axis, vec_sub(l.top[0], face->centre[0]));
    vec3 foot = vec_madd(l.top[0], -gap, face->axis);
    s->n = vec_scale(face->axis, sign);
    s->point_a = sign > 0 ? foot : l.top[0];
    s->point_b = sign > 0 ? l.top[0] : foot;
    s->lo = gap;
    return true;
}
