/* pieces: Newton's method for the least of the greatest. Pure; any thread.
 *
 * The second derivative of h along the unit sphere is r / |Pn| t t' - h, with t = axis x u (view.across). */
#include "pieces.h"

#include "narrow/math/scalar.h"

enum { NEWTON_MAX = 8 };

static const double KINK_COSINE = 0.7; /* a flat face is tried when its normal is this near */
static const double SURE = 1 - 1e-6;   /* covers the rounding of radii */
static const double SLIM = 1e-5;       /* shorter differences of gradients, and sines, are not divided by */
static const double FLAT = 1e-8;       /* nor smaller areas between gradients */
static const double STRIDE = 0.5;      /* a longer step leaves what the derivatives know */
static const double HOPELESS = -0.2;   /* a piece of three with less weight will be dropped */

/* ---- pieces ---- */

static bool pieces_has_pieces(const shape *s)
{
    return s->type <= SHAPE_CONE || s->type == SHAPE_HULL;
}

bool pieces_apply(const unit_pair *p)
{
    return pieces_has_pieces(&p->a) && pieces_has_pieces(&p->b) && (shape_has_rim(&p->a) || shape_has_rim(&p->b));
}

/* The disc, or the point, that the support point `at` belongs to: its centre and radius. */
static vec3 pieces_centre_of(const shape *s, vec3 at, double *radius)
{
    bool rim = s->type == SHAPE_CYLINDER || (s->type == SHAPE_CONE && at.z < 0);
    *radius = rim ? s->half.x : 0;
    return rim ? vec(0, 0, at.z) : at;
}

static piece piece_of(const unit_pair *p, const minkowski *m)
{
    piece s;
    s.a = pieces_centre_of(&p->a, m->a, &s.ra);
    s.b = transform_point(&p->b_in_a, pieces_centre_of(&p->b, m->b_local, &s.rb));
    return s;
}

static bool knows(const bundle *b, const piece *s)
{
    for (int i = 0; i < b->count; i++)
        if (vec_equal(b->piece[i].a, s->a) && vec_equal(b->piece[i].b, s->b)) return true;
    return false;
}

bool pieces_know(const unit_pair *p, const bundle *b, const minkowski *m)
{
    piece s = piece_of(p, m);
    return knows(b, &s);
}

static int pieces_lowest_of(const bundle *b)
{
    int lowest = 0;
    for (int i = 1; i < b->count; i++)
        if (b->height[i] < b->height[lowest]) lowest = i;
    return lowest;
}

static int lightest_of(const bundle *b)
{
    int lightest = 0;
    for (int i = 1; i < b->count; i++)
        if (b->weight[i] < b->weight[lightest]) lightest = i;
    return lightest;
}

static void drop(bundle *b, int i)
{
    b->count--;
    b->piece[i] = b->piece[b->count];
    b->height[i] = b->height[b->count];
    b->weight[i] = b->weight[b->count];
    b->gradient[i] = b->gradient[b->count];
}

void pieces_add(const unit_pair *p, bundle *b, const minkowski *m)
{
    piece s = piece_of(p, m);
    if (knows(b, &s)) return;
    if (b->count == PIECES_MAX) drop(b, pieces_lowest_of(b));
    b->piece[b->count++] = s;
}

/* ---- along a direction ---- */

/* By its x and y, so that u is orthogonal to the axis however nearly n is parallel to it. */
static void see_disc(view *v, int i, vec3 x, vec3 y)
{
    double along_x = vec_dot(v->n, x), along_y = vec_dot(v->n, y), sine = sqrt(along_x * along_x + along_y * along_y);
    double c = sine > 0 ? along_x / sine : 0, s = sine > 0 ? along_y / sine : 0;
    vec3 across = vec_madd(vec_scale(x, -s), c, y);
    v->sine[i] = sine;
    v->u[i] = vec_madd(vec_scale(x, c), s, y);
    v->across[i] = (plane2){vec_dot(across, v->x), vec_dot(across, v->y)};
}

/* x and y: Duff et al., "Building an Orthonormal Basis, Revisited", 2017. */
view pieces_view(const unit_pair *p, vec3 n)
{
    double sign = copysign(1, n.z), a = -1 / (sign + n.z), b = n.x * n.y * a;
    view v = {.n = n, .x = {1 + sign * n.x * n.x * a, sign * b, -sign * n.x}, .y = {b, sign + n.y * n.y * a, -n.y}};
    if (shape_has_rim(&p->a)) see_disc(&v, 0, vec(1, 0, 0), vec(0, 1, 0));
    if (shape_has_rim(&p->b)) see_disc(&v, 1, p->b_in_a.r.x, p->b_in_a.r.y);
    return v;
}

static vec3 piece_point_a(const piece *s, const view *v)
{
    return vec_madd(s->a, -s->ra, v->u[0]);
}

static vec3 piece_point_b(const piece *s, const view *v)
{
    return vec_madd(s->b, s->rb, v->u[1]);
}

static void pieces_look(bundle *b, const view *v)
{
    for (int i = 0; i < b->count; i++) {
        vec3 w = vec_sub(piece_point_b(&b->piece[i], v), piece_point_a(&b->piece[i], v));
        b->height[i] = vec_dot(w, v->n);
        b->gradient[i] = (plane2){vec_dot(w, v->x), vec_dot(w, v->y)};
    }
}

void pieces_points(const bundle *b, const view *v, vec3 *point_a, vec3 *point_b)
{
    vec3 a = VEC_ZERO, sum = VEC_ZERO;
    for (int i = 0; i < b->count; i++) {
        a = vec_madd(a, b->weight[i], piece_point_a(&b->piece[i], v));
        sum = vec_madd(sum, b->weight[i], piece_point_b(&b->piece[i], v));
    }
    *point_a = a;
    *point_b = sum;
}

void curvature_add(curvature *m, double share, double r, double width, plane2 t)
{
    double k = share * r / width;
    m->xx += k * t.x * t.x;
    m->xy += k * t.x * t.y;
    m->yy += k * t.y * t.y;
}

/* ---- Newton's method ---- */

/* Along the sphere, of the weighted sum of the pieces. */
static curvature second_derivative(const bundle *b, const view *v)
{
    curvature m = {0, 0, 0};
    for (int i = 0; i < b->count; i++) {
        const piece *s = &b->piece[i];
        if (s->ra > 0) curvature_add(&m, b->weight[i], s->ra, v->sine[0], v->across[0]);
        if (s->rb > 0) curvature_add(&m, b->weight[i], s->rb, v->sine[1], v->across[1]);
        m.xx -= b->weight[i] * b->height[i];
        m.yy -= b->weight[i] * b->height[i];
    }
    return m;
}

/* Of one piece: false where it is not a bowl. */
static bool step_of_one(bundle *b, const view *v, plane2 *d)
{
    b->weight[0] = 1;
    curvature m = second_derivative(b, v);
    double whole = m.xx * m.yy - m.xy * m.xy;
    plane2 g = b->gradient[0];
    if (!(m.xx > 0 && whole > SLIM * m.xx * m.xx)) return false;
    *d = (plane2){(m.xy * g.y - m.yy * g.x) / whole, (m.xy * g.x - m.xx * g.y) / whole};
    return true;
}

/* Of two: to where they are equally high, and along that line to its least. */
static bool step_of_two(bundle *b, const view *v, plane2 *d)
{
    plane2 apart = sub2(b->gradient[0], b->gradient[1]);
    double length2 = dot2(apart, apart);
    if (!(length2 > SLIM * SLIM)) return false;
    double length = sqrt(length2);
    plane2 i = {apart.x / length, apart.y / length}, j = {-i.y, i.x};
    b->weight[0] = min_of(max_of(-dot2(b->gradient[1], apart) / length2, 0), 1);
    b->weight[1] = 1 - b->weight[0];
    curvature m = second_derivative(b, v);
    plane2 mj = {m.xx * j.x + m.xy * j.y, m.xy * j.x + m.yy * j.y};
    double jj = dot2(j, mj), ij = dot2(i, mj), along = (b->height[1] - b->height[0]) / length;
    if (!(jj > SLIM)) return false;
    double across = -(dot2(b->gradient[1], j) + ij * along) / jj;
    *d = (plane2){along * i.x + across * j.x, along * i.y + across * j.y};
    return true;
}

/* Of three: to where all are equally high. */
static bool step_of_three(bundle *b, plane2 *d)
{
    plane2 g0 = b->gradient[0], g1 = b->gradient[1], g2 = b->gradient[2], e1 = sub2(g1, g0), e2 = sub2(g2, g0);
    double whole = cross2(e1, e2);
    if (!(fabs(whole) > FLAT)) return false;
    b->weight[0] = cross2(g1, g2) / whole;
    b->weight[1] = cross2(g2, g0) / whole;
    b->weight[2] = 1 - b->weight[0] - b->weight[1]; /* a sum of points must not leave the cores */
    double h1 = b->height[0] - b->height[1], h2 = b->height[0] - b->height[2];
    *d = (plane2){(h1 * e2.y - h2 * e1.y) / whole, (h2 * e1.x - h1 * e2.x) / whole};
    return true;
}

/* Writes the weights, too. */
static bool step(bundle *b, const view *v, plane2 *d)
{
    if (b->count == 1) return step_of_one(b, v, d);
    return b->count == 2 ? step_of_two(b, v, d) : step_of_three(b, d);
}

static bool edge_on(const unit_pair *p, const view *v)
{
    return (shape_has_rim(&p->a) && v->sine[0] < SLIM) || (shape_has_rim(&p->b) && v->sine[1] < SLIM);
}

/* All pieces of the bundle as if all of them held the least; the weights show whether they do. */
static bool pieces_newton(const unit_pair *p, bundle *b, view *v, double near2)
{
    plane2 d;
    for (int i = 0; i < NEWTON_MAX; i++) {
        if (edge_on(p, v) || !step(b, v, &d)) return false;
        if (b->count == 3 && b->weight[lightest_of(b)] < HOPELESS) return true;
        double length2 = dot2(d, d);
        if (!(length2 < STRIDE * STRIDE)) {
            double shorter = STRIDE / sqrt(length2);
            d.x *= shorter, d.y *= shorter;
        }
        *v = pieces_view(p, direction_of(vec_madd(vec_madd(v->n, d.x, v->x), d.y, v->y)));
        pieces_look(b, v);
        if (length2 <= near2) break;
    }
    return !edge_on(p, v) && step(b, v, &d);
}

bool pieces_descend(const unit_pair *p, bundle *b, view *v, double near2)
{
    const view start = *v;
    bundle rest = *b;
    for (pieces_look(&rest, &start); rest.count > 0;) {
        *b = rest;
        *v = start;
        bool found = pieces_newton(p, b, v, near2);
        int least = found ? lightest_of(b) : pieces_lowest_of(&rest); /* where none is found, none has a weight */
        if (found && b->weight[least] > SLIM) return true;
        drop(&rest, least);
    }
    return false;
}

/* ---- flat faces ---- */

static bool find_on(const unit_pair *p, const bundle *b, int disc, vec3 normal, pieces_face *out)
{
    view v = pieces_view(p, normal);
    bundle at = *b;
    v.u[disc] = VEC_ZERO;
    pieces_look(&at, &v);
    int top = 0;
    for (int i = 1; i < at.count; i++)
        if (at.height[i] > at.height[top]) top = i;
    const piece *s = &at.piece[top];
    double r = disc == 0 ? s->ra : s->rb, height = at.height[top];
    vec3 point_a = piece_point_a(s, &v), point_b = piece_point_b(s, &v);
    *out = (pieces_face){normal, height, SURE * r - sqrt(dot2(at.gradient[top], at.gradient[top])),
        disc == 0 ? vec_madd(point_b, -height, normal) : point_a,
        disc == 0 ? point_b : vec_madd(point_a, height, normal)};
    return out->margin > 0;
}

bool pieces_find_face(const unit_pair *p, const bundle *b, vec3 near, pieces_face *out)
{
    const vec3 axes[2] = {vec(0, 0, 1), p->b_in_a.r.z};
    const bool rims[2] = {shape_has_rim(&p->a), shape_has_rim(&p->b)};
    for (int i = 0; i < 2; i++) {
        double cosine = vec_dot(near, axes[i]);
        if (!rims[i] || fabs(cosine) < KINK_COSINE) continue;
        if (find_on(p, b, i, cosine < 0 ? vec_neg(axes[i]) : axes[i], out)) return true;
    }
    return false;
}
