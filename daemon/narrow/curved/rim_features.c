/* rim_features: the features that two bodies are nearest at, and the proof that it is these. Pure; any thread. */
#include "curved.h"

#include "narrow/convex/features.h"
#include "narrow/math/scalar.h"

/* ---- rim parts ---- */

/* The features of a box, a capsule, a cylinder or a cone: what they are, which directions leave the body there, and
 * which one a point is on. A feature is named by its sides, three small numbers: of a box (or a capsule, which is one
 * without width) for each of its axes between, high or low; of a body of revolution that along its axis, whether it is
 * the flat end, and 0. */

enum { BETWEEN, HIGH, LOW, SIDES }; /* along an axis of a box, or along that of a body of revolution */
enum { ROUND, FLAT };               /* a body of revolution: its rim or apex, or its flat end */

static const double SIGN[SIDES] = {0, 1, -1};
static const double LEAN = 0x1p-13; /* sine of the angle by which n points out of other faces, ends and sides */

#define RIM_SINE 0x1p-11 /* between n and the axis of a rim: the least */

/* ---- what it is ---- */

/* A feature in A's frame: one disc or two, or a face. */
typedef struct rim_part {
    int discs;
    vec3 centre[2];
    double radius[2];
    vec3 x, y;    /* unit, orthogonal: the plane of the discs */
    vec3 axis;    /* of the discs; of a face its outward normal */
    bool has_rim; /* one of the radii is above 0 */
    bool is_face;
} rim_part;

typedef struct sides { /* of a box: of what lies between, at is 0 */
    double half[3], side[3];
    int free;
} sides;

static bool rim_sides_of(const shape *s, const uint16_t side[3], sides *x)
{
    bool right = true;
    vec_to(shape_core_half(s), x->half);
    x->free = 0;
    for (int i = 0; i < 3; i++) {
        right &= side[i] < SIDES && (side[i] == HIGH || x->half[i] > 0);
        x->side[i] = SIGN[right ? side[i] : 0];
        x->free += x->side[i] == 0;
    }
    return right;
}

/* A corner, an edge or a face of A. */
static bool rim_part_of_box(const shape *s, const uint16_t side[3], rim_part *out)
{
    sides x;
    if (!rim_sides_of(s, side, &x) || x.free > 2) return false;
    vec3 middle = vec(x.side[0] * x.half[0], x.side[1] * x.half[1], x.side[2] * x.half[2]);
    *out = (rim_part){.discs = 1, .centre = {middle}};
    if (x.free == 1) {
        int i = x.side[0] == 0 ? 0 : x.side[1] == 0 ? 1 : 2;
        out->discs = 2;
        out->centre[0] = vec_add(middle, vec_on_axis(i, -x.half[i]));
        out->centre[1] = vec_add(middle, vec_on_axis(i, x.half[i]));
    }
    if (x.free == 2) {
        out->is_face = true;
        out->axis = vec(x.side[0], x.side[1], x.side[2]);
    }
    return true;
}

static bool part_of_revolved(const shape *s, const uint16_t side[3], rim_part *out)
{
    bool cone = s->type == SHAPE_CONE, high = side[0] == HIGH;
    if (side[0] >= SIDES || side[1] > FLAT || side[2]) return false;
    if (side[1] == FLAT && (side[0] == BETWEEN || (cone && high))) return false;
    vec3 top = vec(0, 0, s->half.z), bottom = vec(0, 0, -s->half.z);
    double r = s->half.x, r_top = cone ? 0 : r;
    *out = (rim_part){.discs = 1,
        .x = vec(1, 0, 0),
        .y = vec(0, 1, 0),
        .axis = vec(0, 0, 1),
        .has_rim = !(cone && high),
        .is_face = side[1] == FLAT};
    out->centre[0] = high ? top : bottom;
    out->radius[0] = high ? r_top : r;
    if (side[0] == BETWEEN) {
        out->discs = 2;
        out->centre[1] = top;
        out->radius[1] = r_top;
    }
    if (out->is_face && !high) out->axis = vec(0, 0, -1);
    return true;
}

/* In the body's own frame. False: it has no such feature, or `side` names what is none. */
static bool rim_part_of(const shape *s, const uint16_t side[3], uint8_t count, rim_part *out)
{
    if (count != 3) return false;
    return shape_has_rim(s) ? part_of_revolved(s, side, out) : rim_part_of_box(s, side, out);
}

/* From its own frame, where z is the axis of the discs. */
static inline void rim_part_place(const transform *t, rim_part *x)
{
    for (int i = 0; i < x->discs; i++) x->centre[i] = transform_point(t, x->centre[i]);
    x->axis = x->axis.z < 0 ? vec_neg(t->r.z) : t->r.z;
    x->x = t->r.x, x->y = t->r.y;
}

/* ---- does a direction point out of a body as its feature wants? ---- */

static bool box_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    double half[3], d[3];
    bool right = true;
    vec_to(shape_core_half(s), half);
    vec_to(out, d);
    for (int i = 0; i < 3; i++) right &= side[i] == BETWEEN || SIGN[side[i]] * d[i] > LEAN || half[i] == 0;
    return right;
}

/* By how much the upper end's support point is above the lower end's, as the sine of an angle. */
static double upward(const shape *s, vec3 out)
{
    if (s->type == SHAPE_CYLINDER) return out.z;
    double r = s->half.x, h = 2 * s->half.z, slant = sqrt(r * r + h * h);
    return slant > 0 ? (h * out.z - r * sqrt(out.x * out.x + out.y * out.y)) / slant : 0;
}

static bool revolved_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    double up = upward(s, out);
    bool apex = s->type == SHAPE_CONE && side[0] == HIGH;
    bool leaves = side[1] == FLAT || apex || out.x * out.x + out.y * out.y > RIM_SINE * RIM_SINE;
    return leaves && (side[0] == BETWEEN || (side[0] == HIGH ? up > LEAN : up < -LEAN));
}

/* `out`: unit, outward, in the body's frame. Does it point out of the body as the feature wants, and away from all that
 * is not of it, by a margin? */
static bool rim_part_holds(const shape *s, const uint16_t side[3], vec3 out)
{
    return shape_has_rim(s) ? revolved_holds(s, side, out) : box_holds(s, side, out);
}

static bool box_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    double half[3], d[3];
    bool may = true;
    vec_to(shape_core_half(s), half);
    vec_to(out, d);
    for (int i = 0; i < 3; i++) {
        bool between = half[i] > 0 && fabs(d[i]) <= off;
        may &= half[i] == 0 ? side[i] == HIGH : side[i] == BETWEEN ? between : SIGN[side[i]] * d[i] > LEAN - off;
    }
    return may;
}

static bool revolved_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    double up = upward(s, out), sine = sqrt(out.x * out.x + out.y * out.y);
    bool apex = s->type == SHAPE_CONE && side[0] == HIGH;
    if (side[1] == FLAT ? apex || side[0] == BETWEEN || sine > off : !apex && sine < RIM_SINE - off) return false;
    return side[0] == BETWEEN ? fabs(up) <= off : (side[0] == HIGH ? up : -up) > LEAN - off;
}

/* Can the direction that a strict feature has be within `off`, an angle, of this one? */
static bool rim_part_may_be(const shape *s, const uint16_t side[3], vec3 out, double off)
{
    return shape_has_rim(s) ? revolved_may_be(s, side, out, off) : box_may_be(s, side, out, off);
}

/* ---- which one is at a point? ---- */

/* Is a point of a face's plane inside of the face, by more than the margin? */
static bool rim_part_contains(const shape *s, const uint16_t side[3], vec3 at, double margin)
{
    double half[3], x[3];
    if (shape_has_rim(s)) {
        double r = s->half.x - margin;
        return r > 0 && at.x * at.x + at.y * at.y < r * r;
    }
    bool inside = true;
    vec_to(shape_core_half(s), half);
    vec_to(at, x);
    for (int i = 0; i < 3; i++) inside &= side[i] != BETWEEN || fabs(x[i]) < half[i] - margin;
    return inside;
}

/* The feature that a point of the surface is on, to within `near`, and that `out` leaves the body by. */
static void rim_part_at(const shape *s, vec3 at, vec3 out, double near, uint16_t side[3])
{
    double half[3], x[3];
    vec_to(shape_core_half(s), half);
    vec_to(at, x);
    if (shape_has_rim(s)) {
        bool cone = s->type == SHAPE_CONE, end = s->half.z - fabs(at.z) <= near;
        double r = s->half.x - near, across2 = at.x * at.x + at.y * at.y;
        side[0] = !end ? BETWEEN : at.z > 0 ? HIGH : LOW;
        bool flat = !cone || side[0] == LOW;
        side[1] = end && flat && fabs(out.z) > 0.7 && across2 < r * r ? FLAT : ROUND;
        side[2] = 0;
        return;
    }
    for (int i = 0; i < 3; i++)
        side[i] = half[i] == 0 || half[i] - x[i] <= near ? HIGH : half[i] + x[i] <= near ? LOW : BETWEEN;
}

/* Of a flat end its rim; false: it is none. */
static bool rim_part_make_round(const shape *s, uint16_t side[3])
{
    bool flat = shape_has_rim(s) && side[1] == FLAT;
    if (flat) side[1] = ROUND;
    return flat;
}

/* ---- all of them ---- */

/* 27 of a box; of a body of revolution three, and its two flat ends. */
static uint32_t rim_part_count(const shape *s)
{
    return shape_has_rim(s) ? 6 : 27;
}

static void rim_part_numbered(const shape *s, uint32_t i, uint16_t side[3])
{
    uint32_t base = shape_has_rim(s) ? 2 : 3;
    side[0] = (uint16_t)(shape_has_rim(s) ? i / base : i % base);
    side[1] = (uint16_t)(shape_has_rim(s) ? i % base : i / 3 % 3);
    side[2] = (uint16_t)(shape_has_rim(s) ? 0 : i / 9);
}

/* ---- rim newton ---- */

/* Two parts along a direction, and Newton's method to the one in which they are farthest apart.
 *
 * Along n the gap between a disc of A (centre a, radius r) and one of B (b, s) is
 *     g(n) = n.(b - a) - r |Pa n| - s |Pb n| = n.w,   w = (b - s Pb n / |Pb n|) - (a + r Pa n / |Pa n|),
 * P the projection along the disc's axis. Along the unit sphere its gradient is w - g n, and its second derivative
 * -(g + r / |Pa n| ta ta' + s / |Pb n| tb tb'), t = the unit vector orthogonal to n and to the disc's axis. */

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

typedef struct rim_stand { /* both parts along n, unit, from A towards B; and the next step */
    vec3 n, point_a, point_b;
    double lo, share_a, share_b; /* of the second discs */
    double uneven;               /* the difference of what should be equally high */
    vec3 step;                   /* orthogonal to n */
} rim_stand;

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

static vec3 rim_between(const rim_part *x, const look *l, double share)
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
    s->point_a = rim_between(a, &of_a, s->share_a);
    s->point_b = rim_between(b, &of_b, s->share_b);
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

/* Where Newton's method ends from s->n, to the last bits by the cell and the features alone (curved.h). `size`:
 * the pair's. False: not found. */
static bool rim_stand_between(const rim_part *a, const rim_part *b, double size, rim_stand *s)
{
    if (!approach(a, b, size, s)) return false;
    for (int i = 0; i < CELLS_TRIED; i++)
        if (arrive(a, b, size, s)) return true;
    return false;
}

/* ---- faces ---- */

/* `other` along the normal of `face`; `sign`: 1 when the face is A's. False: `other` is no corner, apex or rim. Fills
 * n, the points and lo. */
static bool rim_stand_on_face(const rim_part *face, const rim_part *other, double sign, rim_stand *s)
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

/* ---- rim features ---- */

/* Of the size, unless said otherwise. */
static const double SHARE = 0x1p-13;  /* of an edge: how far inside of it a point is */
static const double INSIDE = 0x1p-13; /* of a face */
static const double CLOSED = 0x1p-48; /* of bounds */
static const double ON = 0x1p-30;     /* points are on a side to within this */

/* ---- the proof ---- */

static bool rim_is_inside(const rim_part *x, double share)
{
    return x->discs == 1 || (share > SHARE && share < 1 - SHARE);
}

static vec3 in_frame_of_b(const unit_pair *p, vec3 at)
{
    return mat_tmul(p->b_in_a.r, vec_sub(at, p->b_in_a.t));
}

/* From s->n. */
static bool find_stand(const unit_pair *p, const narrow_features *f, rim_stand *s)
{
    rim_part a, b;
    double margin = INSIDE * p->size;
    if (!rim_part_of(&p->a, f->a, f->count_a, &a) || !rim_part_of(&p->b, f->b, f->count_b, &b)) return false;
    rim_part_place(&p->b_in_a, &b);
    if (a.is_face) return rim_stand_on_face(&a, &b, 1, s) && rim_part_contains(&p->a, f->a, s->point_a, margin);
    if (b.is_face)
        return rim_stand_on_face(&b, &a, -1, s) && rim_part_contains(&p->b, f->b, in_frame_of_b(p, s->point_b), margin);
    return rim_stand_between(&a, &b, p->size, s) && rim_is_inside(&a, s->share_a) && rim_is_inside(&b, s->share_b);
}

/* The answer, if `f` (of which nothing is believed) is strict, and Newton's method finds it from there. */
static bool features_span(const unit_pair *p, const narrow_goal *goal, const narrow_features *f, vec3 from, span *out)
{
    rim_stand s;
    s.n = from;
    if (!find_stand(p, f, &s) || !(s.lo >= NEAR_LEAST_DISTANCE * p->size)) return false;
    if (!rim_part_holds(&p->a, f->a, s.n) || !rim_part_holds(&p->b, f->b, mat_tmul(p->b_in_a.r, vec_neg(s.n))))
        return false;
    double hi = max_of(vec_norm(vec_sub(s.point_b, s.point_a)), s.lo);
    if (!(hi - s.lo <= CLOSED * p->size)) return false;
    *out = (span){.lo = s.lo,
        .hi = hi,
        .axis = s.n,
        .point_a = s.point_a,
        .point_b = s.point_b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = 1,
        .nearest = *f};
    return hi + 2 * p->error <= goal->far; /* or else a search may have ended beyond it */
}

bool rim_features_recall(
    const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, vec3 axis, span *out)
{
    return !nearest->deep && features_span(p, goal, nearest, direction_again(axis), out);
}

/* ---- which features? ---- */

bool rim_features_find_at(const unit_pair *p, const narrow_goal *goal, const span *s, span *out)
{
    narrow_features f = {.count_a = 3, .count_b = 3};
    double near = ON * p->size;
    rim_part_at(&p->a, s->point_a, s->axis, near, f.a);
    rim_part_at(&p->b, in_frame_of_b(p, s->point_b), mat_tmul(p->b_in_a.r, vec_neg(s->axis)), near, f.b);
    if (features_span(p, goal, &f, s->axis, out)) return true;
    bool a = rim_part_make_round(&p->a, f.a), b = rim_part_make_round(&p->b, f.b);
    return (a || b) && features_span(p, goal, &f, s->axis, out);
}

double rim_features_angle(const span *s)
{
    return sqrt(2 * max_of(s->hi - s->lo, 0) / s->hi) + 0x1p-30;
}

bool rim_features_find_along(const unit_pair *p, const narrow_goal *goal, const span *s, span *out)
{
    narrow_features f = {.count_a = 3, .count_b = 3};
    vec3 back = mat_tmul(p->b_in_a.r, vec_neg(s->axis));
    double off = rim_features_angle(s);
    for (uint32_t i = 0; i < rim_part_count(&p->a); i++) {
        rim_part_numbered(&p->a, i, f.a);
        if (!rim_part_may_be(&p->a, f.a, s->axis, off)) continue;
        for (uint32_t k = 0; k < rim_part_count(&p->b); k++) {
            rim_part_numbered(&p->b, k, f.b);
            if (rim_part_may_be(&p->b, f.b, back, off) && features_span(p, goal, &f, s->axis, out)) return true;
        }
    }
    return false;
}

bool rim_features_at(const unit_pair *p, const narrow_goal *goal, span *s)
{
    span out;
    if (!rim_features_apply(p, goal) || !(s->hi >= NEAR_LEAST_DISTANCE * p->size) ||
        !rim_features_find_at(p, goal, s, &out))
        return false;
    out.iterations = 1;
    *s = out;
    return true;
}
