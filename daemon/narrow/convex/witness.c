/* witness: deepest points of overlapping cores. A depth search proves an axis by support points, but the points that
 * it interpolates may belong to an older facet, or to another of several equally deep ones. Pure; any thread. */
#include "gjk.h"

#include "narrow/math/scalar.h"

/* ---- facing ---- */

/* The parts of two cores that lie on their support planes along an axis, and the points where two of them cross. For
 * boxes, capsules, cylinders and cones such a part is a point, a segment, a rectangle or a disc, so that this is a
 * closed form. At the least depth the parts, brought onto each other along the axis, have a point in common: else the
 * axis could be turned to lessen the depth. */

/* What of a core is within the slack of its support plane: at + x along[0] + y along[1], |x|, |y| <= 1, the two
 * orthogonal and zero where there is no extent; or a disc. */
typedef struct part {
    vec3 at, along[2];
    double norm2[2]; /* of `along` */
    double radius;   /* of a disc; else 0 */
    vec3 normal;     /* of a disc, unit */
} part;

static part facing_part_at(vec3 at)
{
    return (part){.at = at};
}

static part part_disc(double z, double radius)
{
    return (part){.at = vec(0, 0, z), .radius = radius, .normal = vec(0, 0, 1)};
}

static part part_segment(vec3 at, vec3 along)
{
    return (part){.at = at, .along = {along}, .norm2 = {vec_norm2(along)}};
}

/* ---- parts of cores, in their frames ---- */

/* Whichever side the box is highest on stays, however wide the slack. */
static part facing_part_of_box(vec3 half, vec3 d, double slack)
{
    const double h[3] = {half.x, half.y, half.z}, n[3] = {d.x, d.y, d.z};
    int top = fabs(d.x) >= fabs(d.y) ? 0 : 1, count = 0;
    if (fabs(d.z) > fabs(n[top])) top = 2;
    double at[3];
    part out = {.radius = 0};
    for (int i = 0; i < 3; i++) {
        double side[3] = {0, 0, 0};
        bool level = i != top && 4 * h[i] * fabs(n[i]) <= slack;
        at[i] = level ? 0 : copysign(h[i], n[i]);
        if (!level) continue;
        side[i] = h[i];
        out.along[count] = vec(side[0], side[1], side[2]);
        out.norm2[count++] = h[i] * h[i];
    }
    out.at = vec(at[0], at[1], at[2]);
    return out;
}

static part part_of_cylinder(vec3 half, vec3 d, double slack)
{
    double r = half.x, h = half.z, sine = sqrt(d.x * d.x + d.y * d.y), per = sine > 0 ? r / sine : 0;
    vec3 rim = vec(per * d.x, per * d.y, copysign(h, d.z));
    if (2 * h * fabs(d.z) <= slack) return part_segment(vec(rim.x, rim.y, 0), vec(0, 0, h));
    return 2 * r * sine <= slack ? part_disc(rim.z, r) : facing_part_at(rim);
}

static part part_of_cone(vec3 half, vec3 d, double slack)
{
    double r = half.x, h = half.z, sine = sqrt(d.x * d.x + d.y * d.y), per = sine > 0 ? r / sine : 0;
    double lead = 2 * h * d.z - r * sine; /* of the apex */
    vec3 rim = vec(per * d.x, per * d.y, -h);
    if (fabs(lead) <= slack) return part_segment(vec(0.5 * rim.x, 0.5 * rim.y, 0), vec(-0.5 * rim.x, -0.5 * rim.y, h));
    if (lead > 0) return facing_part_at(vec(0, 0, h));
    return d.z < 0 && 2 * r * sine <= slack ? part_disc(-h, r) : facing_part_at(rim);
}

static bool has_part(const shape *s)
{
    return s->type >= SHAPE_CAPSULE && s->type <= SHAPE_CONE;
}

static part part_of(const shape *s, vec3 d, double slack)
{
    if (s->type == SHAPE_BOX) return facing_part_of_box(s->half, d, slack);
    if (s->type == SHAPE_CONE) return part_of_cone(s->half, d, slack);
    return part_of_cylinder(vec(s->type == SHAPE_CAPSULE ? 0 : s->half.x, 0, s->half.z), d, slack);
}

static part part_turned(part q, const transform *t)
{
    q.at = transform_point(t, q.at);
    for (int i = 0; i < 2; i++)
        if (q.norm2[i] > 0) q.along[i] = mat_mul(t->r, q.along[i]);
    if (q.radius > 0) q.normal = mat_mul(t->r, q.normal);
    return q;
}

/* ---- where two of them cross ---- */

static double facing_inside(double v)
{
    return min_of(max_of(v, -1), 1);
}

static vec3 nearest_of_disc(const part *q, vec3 to)
{
    vec3 d = vec_sub(to, q->at);
    d = vec_madd(d, -vec_dot(d, q->normal), q->normal);
    double length = vec_norm(d);
    return length > q->radius ? vec_madd(q->at, q->radius / length, d) : vec_add(q->at, d);
}

static vec3 facing_nearest_of(const part *q, vec3 to)
{
    if (q->radius > 0) return nearest_of_disc(q, to);
    vec3 d = vec_sub(to, q->at), at = q->at;
    for (int i = 0; i < 2; i++)
        if (q->norm2[i] > 0) at = vec_madd(at, facing_inside(vec_dot(d, q->along[i]) / q->norm2[i]), q->along[i]);
    return at;
}

/* The middle of what of a segment is in a part with two extents, or in as much of the plane as one extent leaves. */
static vec3 middle_within(const part *segment, const part *q)
{
    double from = -1, to = 1;
    vec3 d = vec_sub(segment->at, q->at);
    for (int i = 0; i < 2; i++) {
        if (!(q->norm2[i] > 0)) continue;
        double at = vec_dot(d, q->along[i]), way = vec_dot(segment->along[0], q->along[i]);
        if (!(fabs(way) > 0)) continue;
        double one = (-q->norm2[i] - at) / way, other = (q->norm2[i] - at) / way;
        from = max_of(from, min_of(one, other));
        to = min_of(to, max_of(one, other));
    }
    return vec_madd(segment->at, facing_inside(0.5 * (from + to)), segment->along[0]);
}

static const double PARALLEL = 0x1p-40; /* square of the sine between two segments that do not cross */

/* Of two segments the point of the first where they are nearest; where they are parallel, the middle of what faces. */
static vec3 cross_at(const part *a, const part *b)
{
    double both = vec_dot(a->along[0], b->along[0]), whole = a->norm2[0] * b->norm2[0] - both * both;
    if (!(whole > PARALLEL * a->norm2[0] * b->norm2[0])) return middle_within(a, b);
    vec3 d = vec_sub(b->at, a->at);
    double along_a = vec_dot(d, a->along[0]), along_b = vec_dot(d, b->along[0]);
    double x = facing_inside((along_a * b->norm2[0] - along_b * both) / whole);
    return vec_madd(a->at, x, a->along[0]);
}

static int extents(const part *q)
{
    return (q->norm2[0] > 0) + (q->norm2[1] > 0);
}

/* A point of `a` that `b` has, too, if there is one. */
static vec3 meeting(const part *a, const part *b)
{
    int of_a = extents(a), of_b = extents(b);
    if (a->radius > 0) return facing_nearest_of(b, a->at);
    if (b->radius > 0 || of_b == 0) return facing_nearest_of(a, b->at);
    if (of_a == 0) return a->at;
    if (of_a == 1) return of_b == 1 ? cross_at(a, b) : middle_within(a, b);
    return of_b == 1 ? middle_within(b, a) : facing_nearest_of(a, b->at);
}

/* Moves s->point_a and s->point_b to points of the cores that are not lower along s->axis than the support points by
 * more than `slack`, and of which one faces the other as nearly as there are such points. False: one of the cores is of
 * another kind; *s is as it was. */
static bool facing_points(const unit_pair *p, double slack, span *s)
{
    if (!has_part(&p->a) || !has_part(&p->b)) return false;
    part a = part_of(&p->a, s->axis, slack);
    part b = part_of(&p->b, mat_tmul(p->b_in_a.r, vec_neg(s->axis)), slack);
    b = part_turned(b, &p->b_in_a);
    b.at = vec_madd(b.at, -s->lo, s->axis);
    vec3 at = meeting(&a, &b), on_b = facing_nearest_of(&b, at);
    s->point_a = facing_nearest_of(&a, on_b);
    s->point_b = vec_madd(on_b, s->lo, s->axis);
    return true;
}

/* ---- witness ---- */

static void apart_by(const unit_pair *p, double way, span *s)
{
    unit_pair apart = *p;
    vec3 shift = vec_scale(s->axis, way);
    apart.b_in_a.t = vec_add(p->b_in_a.t, shift);
    double closely = 0.25 * (s->hi - s->lo);
    narrow_goal exactly = {closely, closely, INFINITY, -INFINITY, INFINITY, INFINITY, false};
    gjk_result touch;
    gjk_distance(&apart, &exactly, s->axis, &touch);
    s->point_a = touch.span.point_a;
    s->point_b = vec_sub(touch.span.point_b, shift);
    s->iterations += touch.span.iterations;
}

void witness_apart(const unit_pair *p, span *s)
{
    apart_by(p, -s->lo, s);
}

/* How far the two points together fall short of the support planes, of which `top` holds a point each. */
static double shortfall(const span *s, const minkowski *top)
{
    return max_of(vec_dot(s->axis, vec_sub(top->a, s->point_a)), vec_dot(s->axis, vec_sub(s->point_b, top->b)));
}

/* Of the size: how far apart, across the axis, two points that face each other may be. */
#define ASIDE 0x1p-10

/* As a share of the size: the gap at which a search finds where two curved cores are nearest. */
#define CURVED_GAP 0x1p-32

/* The slack of the points: support planes are known to no better. */
static double facing_slack_of(const unit_pair *p, const span *s)
{
    return (s->hi - s->lo) + p->error;
}

static bool are_deepest(const unit_pair *p, const span *s, const minkowski *top)
{
    return shortfall(s, top) <= facing_slack_of(p, s) && span_aside(s) <= ASIDE * p->size;
}

static void search_deepest(const unit_pair *p, const minkowski *top, span *s)
{
    double slack = facing_slack_of(p, s);
    witness_apart(p, s);
    if (shortfall(s, top) <= slack) return;
    const double gaps[] = {
        2 * slack, CURVED_GAP * p->size}; /* rounding has them overlap still, or hides where they touch */
    for (int i = 0; i < 2; i++) {
        apart_by(p, gaps[i] - s->lo, s);
        if (shortfall(s, top) <= 2 * gaps[i]) return;
    }
    s->point_a = top->a;
    s->point_b = top->b;
}

void witness_deepest(const unit_pair *p, span *s)
{
    minkowski top = unit_pair_nearest_along(p, s->axis);
    if (are_deepest(p, s, &top)) return;
    if (facing_points(p, facing_slack_of(p, s), s) && are_deepest(p, s, &top)) return;
    search_deepest(p, &top, s);
}

bool witness_facing(const unit_pair *p, const minkowski *top, span *s)
{
    if (facing_points(p, facing_slack_of(p, s), s) && are_deepest(p, s, top)) return true;
    s->point_a = top->a;
    s->point_b = top->b;
    return false;
}
