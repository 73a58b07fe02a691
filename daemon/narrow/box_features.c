/* box_features: the formulas for corners, edges and faces of two boxes (or a segment and a box), and the proof that
 * nothing else is as near (near_features.h). Pure; any thread.
 *
 * A feature of a box: for each of its axes the side that the nearest point lies on, or that it lies between the two.
 * Across an axis along which the box has no extent the side is HIGH. */
#include "box_pair.h"
#include "near_features.h"
#include "scalar.h"

enum { BETWEEN, HIGH, LOW, SIDES };

/* One box: coordinates of its nearest point in its own frame; `free`: the axes along which it lies between. */
typedef struct box_side {
    double half[3], at[3];
    const uint16_t *side;
    int free[3], free_count, fixed; /* fixed: some axis that is not free */
} box_side;

static void put(vec3 v, double out[3])
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

static vec3 take(const double v[3])
{
    return vec(v[0], v[1], v[2]);
}

static bool side_of(const shape *s, const uint16_t *side, uint8_t count, box_side *x)
{
    put(box_sides(s), x->half);
    x->side = side;
    x->free_count = 0;
    if (count != 3) return false;
    for (int i = 0; i < 3; i++) {
        if (side[i] >= SIDES || (x->half[i] == 0 && side[i] != HIGH)) return false;
        x->at[i] = side[i] == HIGH ? x->half[i] : side[i] == LOW ? -x->half[i] : 0;
        if (side[i] == BETWEEN)
            x->free[x->free_count++] = i;
        else
            x->fixed = i;
    }
    return true;
}

static bool lies_between(const box_side *x, double margin)
{
    for (int k = 0; k < x->free_count; k++)
        if (!(fabs(x->at[x->free[k]]) < x->half[x->free[k]] - margin)) return false;
    return true;
}

/* Does the direction, in the box's frame, point out of all the sides that are named? */
static bool points_out(const box_side *x, const double d[3])
{
    for (int i = 0; i < 3; i++) {
        if (x->side[i] == BETWEEN || x->half[i] == 0) continue;
        if (!((x->side[i] == HIGH ? d[i] : -d[i]) > NEAR_SINE_MARGIN)) return false;
    }
    return true;
}

static vec3 unit_along(const double d[3], int axis)
{
    double n[3] = {0, 0, 0};
    n[axis] = d[axis] < 0 ? -1 : 1;
    return take(n);
}

/* A feature of the one box, a corner of the other at `r` from x->at, in x's frame: the corner's coordinates are the
 * nearest point's. The direction to it, unit, has no part along what is free. */
static vec3 settle_corner(box_side *x, vec3 r)
{
    double d[3];
    put(r, d);
    for (int k = 0; k < x->free_count; k++) {
        x->at[x->free[k]] = d[x->free[k]];
        d[x->free[k]] = 0;
    }
    return x->free_count == 2 ? unit_along(d, x->fixed) : direction_of(take(d));
}

/* Two edges, e_i and f: a + s e_i, b + t f with b - a = r. The axis e_i x f has no part i, and is orthogonal to f to the
 * last bit. False when they are almost parallel. */
static bool settle_edges(const unit_pair *p, box_side *x, box_side *y, vec3 r, vec3 *n)
{
    int i = x->free[0], h = (i + 1) % 3, k = (i + 2) % 3, j = y->free[0];
    double f[3], d[3], across[3];
    put(j == 0 ? p->b_in_a.r.x : j == 1 ? p->b_in_a.r.y : p->b_in_a.r.z, f);
    put(r, d);
    double sine2 = f[h] * f[h] + f[k] * f[k], along = vec_dot(r, take(f));
    if (!(sine2 > NEAR_SLIVER2)) return false;
    x->at[i] = (d[i] - f[i] * along) / sine2;
    y->at[j] = x->at[i] * f[i] - along;
    across[i] = 0, across[h] = -f[k], across[k] = f[h];
    *n = direction_of(take(across));
    if (vec_dot(*n, r) < 0) *n = vec_neg(*n);
    return true;
}

static bool settle(const unit_pair *p, box_side *x, box_side *y, vec3 *n)
{
    vec3 r = vec_sub(transform_point(&p->b_in_a, take(y->at)), take(x->at));
    if (x->free_count == 1 && y->free_count == 1) return settle_edges(p, x, y, r, n);
    if (y->free_count == 0) {
        *n = settle_corner(x, r);
        return true;
    }
    vec3 from_b = settle_corner(y, mat_tmul(p->b_in_a.r, vec_neg(r)));
    *n = direction_again(mat_mul(p->b_in_a.r, vec_neg(from_b)));
    return true;
}

static vec3 corner(const double half[3], vec3 d)
{
    return vec(copysign(half[0], d.x), copysign(half[1], d.y), copysign(half[2], d.z));
}

bool box_features_span(const unit_pair *p, const narrow_features *f, span *out)
{
    box_side x, y;
    vec3 n;
    if (!side_of(&p->a, f->a, f->count_a, &x) || !side_of(&p->b, f->b, f->count_b, &y)) return false;
    if (x.free_count + y.free_count > 2 || !settle(p, &x, &y, &n)) return false;
    vec3 back = mat_tmul(p->b_in_a.r, vec_neg(n));
    double in_a[3], in_b[3], margin = NEAR_HEIGHT_MARGIN * p->size;
    put(n, in_a);
    put(back, in_b);
    if (!points_out(&x, in_a) || !points_out(&y, in_b) || !lies_between(&x, margin) || !lies_between(&y, margin))
        return false;
    out->lo = vec_dot(n, vec_sub(transform_point(&p->b_in_a, corner(y.half, back)), corner(x.half, n)));
    if (!(out->lo >= NEAR_LEAST_DISTANCE * p->size)) return false;
    out->axis = n;
    out->point_a = take(x.at);
    out->point_b = transform_point(&p->b_in_a, take(y.at));
    out->hi = max_of(out->lo, vec_norm(vec_sub(out->point_b, out->point_a)));
    out->method = NARROW_BY_SAT;
    return true;
}

static void sides_along(const shape *s, vec3 d, uint16_t side[3], uint8_t *count)
{
    double half[3], along[3];
    put(box_sides(s), half);
    put(d, along);
    for (int i = 0; i < 3; i++) {
        bool between = half[i] > 0 && fabs(along[i]) <= 0.5 * NEAR_SINE_MARGIN;
        side[i] = between ? BETWEEN : half[i] == 0 || along[i] > 0 ? HIGH : LOW;
    }
    *count = 3;
}

void box_features_along(const unit_pair *p, vec3 axis, narrow_features *out)
{
    sides_along(&p->a, axis, out->a, &out->count_a);
    sides_along(&p->b, mat_tmul(p->b_in_a.r, vec_neg(axis)), out->b, &out->count_b);
}
