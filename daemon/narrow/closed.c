/* closed: formulas for points, segments, boxes, bodies of revolution and half-spaces. Pure; any thread. */
#include "closed.h"

#include "scalar.h"

/* The same number proves both bounds. */
static bool exact(span *out, double distance, vec3 axis, vec3 point_a, vec3 point_b)
{
    *out = (span){.lo = distance,
        .hi = distance,
        .axis = axis,
        .point_a = point_a,
        .point_b = point_b,
        .method = NARROW_BY_CLOSED_FORM,
        .iterations = 1};
    return true;
}

/* v without its part along the unit vector u; twice, because the first pass leaves what cancelled. */
static vec3 orthogonal_part(vec3 v, vec3 u)
{
    v = vec_madd(v, -vec_dot(v, u), u);
    return vec_madd(v, -vec_dot(v, u), u);
}

static vec3 unit_or(vec3 v, vec3 otherwise)
{
    vec3 n = direction_of(v);
    return vec_norm2(n) > 0 ? n : otherwise;
}

/* Where v is zero, some direction orthogonal to u. */
static vec3 unit_or_across(vec3 v, vec3 u)
{
    vec3 n = direction_of(v);
    return vec_norm2(n) > 0 ? n : vec_unit_orthogonal(u);
}

bool closed_sphere_sphere(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 t = p->b_in_a.t;
    return exact(out, vec_norm(t), unit_or(t, vec(1, 0, 0)), VEC_ZERO, t);
}

bool closed_sphere_capsule(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 u = p->b_in_a.r.z, t = p->b_in_a.t;
    double h = p->b.half.z, s = clamp_to(-vec_dot(t, u), h);
    vec3 v = vec_madd(t, s, u), n = fabs(s) < h ? orthogonal_part(v, u) : v;
    return exact(out, vec_norm(v), unit_or_across(n, u), VEC_ZERO, v);
}

/* Two segments: p_a(s) = s a, p_b(s) = t + s b, with unit a, b and |s| <= h. */
typedef struct segments {
    vec3 a, b, t;
    double ha, hb;
} segments;

/* Keeps the nearer of *out and the two points at (s_a, s_b); `axis` is theirs, up to its sign and length. */
static void keep_nearer(const segments *g, double s_a, double s_b, span *out)
{
    vec3 point_a = vec_scale(g->a, s_a), point_b = vec_madd(g->t, s_b, g->b), v = vec_sub(point_b, point_a);
    double norm = vec_norm(v);
    if (!(norm < out->hi)) return;
    bool inner_a = fabs(s_a) < g->ha, inner_b = fabs(s_b) < g->hb;
    vec3 across = vec_cross(g->a, g->b), n = v;
    if (inner_a && inner_b && vec_norm2(across) > 0)
        n = vec_dot(across, v) < 0 ? vec_neg(across) : across;
    else if (inner_a)
        n = orthogonal_part(v, g->a);
    else if (inner_b)
        n = orthogonal_part(v, g->b);
    out->hi = norm;
    out->axis = unit_or_across(n, g->a);
    out->point_a = point_a;
    out->point_b = point_b;
}

/* Of the two segments along a unit axis from A towards B: by their ends. */
static double separation(const segments *g, vec3 axis)
{
    return vec_dot(axis, g->t) - fabs(vec_dot(axis, g->a)) * g->ha - fabs(vec_dot(axis, g->b)) * g->hb;
}

/* The nearest points of the two lines, the one on B moved into its segment, and the point of A's that is nearest to
 * that: right, but where rounding blurs the angle between the two. */
static void nearest_on_lines(const segments *g, double ab, double at, double bt, double sine2, span *out)
{
    double s_a = sine2 > 0 ? clamp_to((at - ab * bt) / sine2, g->ha) : 0, s_b = s_a * ab - bt;
    if (fabs(s_b) > g->hb) {
        s_b = clamp_to(s_b, g->hb);
        s_a = clamp_to(at + s_b * ab, g->ha);
    }
    keep_nearer(g, s_a, s_b, out);
    out->iterations = 1;
}

/* The four ends against the other segment, and the two lines against each other: the least is the distance. */
static void nearest_of_ends(const segments *g, double ab, double at, double bt, span *out)
{
    for (int i = -1; i <= 1; i += 2) {
        keep_nearer(g, i * g->ha, clamp_to(i * g->ha * ab - bt, g->hb), out);
        keep_nearer(g, clamp_to(at + i * g->hb * ab, g->ha), i * g->hb, out);
    }
}

bool closed_capsule_capsule(const unit_pair *p, const narrow_goal *goal, span *out)
{
    segments g = {vec(0, 0, 1), p->b_in_a.r.z, p->b_in_a.t, p->a.half.z, p->b.half.z};
    double ab = g.b.z, at = g.t.z, bt = vec_dot(g.b, g.t), sine2 = g.b.x * g.b.x + g.b.y * g.b.y;
    out->hi = INFINITY;
    out->method = NARROW_BY_CLOSED_FORM;
    nearest_on_lines(&g, ab, at, bt, sine2, out);
    out->lo = separation(&g, out->axis);
    if (out->hi - out->lo <= 0.25 * p->error) return true;
    nearest_of_ends(&g, ab, at, bt, out);
    out->lo = separation(&g, out->axis);
    return out->hi - out->lo <= max_of(goal->tolerance, p->error);
}

static double *component(vec3 *v, int i)
{
    return i == 0 ? &v->x : i == 1 ? &v->y : &v->z;
}

/* The face through which a point inside the box leaves soonest; ties: x before y before z. */
static int nearest_face(vec3 c, vec3 half, double *depth)
{
    double room[3] = {half.x - fabs(c.x), half.y - fabs(c.y), half.z - fabs(c.z)};
    int least = room[1] < room[0] ? 1 : 0;
    if (room[2] < room[least]) least = 2;
    *depth = room[least];
    return least;
}

bool closed_sphere_box(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    const transform *box = &p->b_in_a;
    vec3 h = p->b.half, c = vec_neg(mat_tmul(box->r, box->t)); /* the point, in the box's frame */
    vec3 q = vec(clamp_to(c.x, h.x), clamp_to(c.y, h.y), clamp_to(c.z, h.z)), v = vec_sub(q, c);
    double distance = vec_norm(v);
    vec3 axis = direction_of(v);
    if (!(distance > 0)) {
        int i = nearest_face(c, h, &distance);
        double side = *component(&c, i) >= 0 ? 1 : -1;
        *component(&q, i) = side * *component(&h, i);
        *component(&axis, i) = -side;
        distance = -distance;
    }
    vec3 axis_in_a = mat_mul(box->r, axis);
    return exact(out, distance, axis_in_a, VEC_ZERO, vec_scale(axis_in_a, distance));
}

/* The profile of a body of revolution in the half-plane (radius, z), from the axis round to the axis. */
typedef struct profile {
    int count;
    double r[4], z[4];
} profile;

static profile profile_of(const shape *s)
{
    double r = s->half.x, h = s->half.z;
    if (s->type == SHAPE_CONE) return (profile){3, {0, r, 0}, {h, -h, -h}};
    return (profile){4, {0, r, r, 0}, {h, h, -h, -h}};
}

/* Signed distance of the point (r, z) from the profile, and the unit direction (*nr, *nz) in which it leaves. Outside:
 * the nearest point of the edges. Inside: the nearest of the edges' lines (the profile is convex). */
static double profile_distance(const profile *f, double r, double z, double *nr, double *nz)
{
    double inside = -INFINITY, outside = INFINITY, out_r = 0, out_z = 1;
    for (int i = 0; i + 1 < f->count; i++) {
        double er = f->r[i + 1] - f->r[i], ez = f->z[i + 1] - f->z[i], ee = er * er + ez * ez;
        double dr = r - f->r[i], dz = z - f->z[i], length = sqrt(ee);
        if (!(length > 0)) continue;
        double height = (dz * er - dr * ez) / length; /* along the outward normal (-ez, er) */
        if (height > inside) inside = height, *nr = -ez / length, *nz = er / length;
        double s = min_of(max_of((dr * er + dz * ez) / ee, 0), 1), vr = dr - s * er, vz = dz - s * ez;
        double norm = s > 0 && s < 1 ? fabs(height) : sqrt(vr * vr + vz * vz);
        if (norm < outside) {
            outside = norm;
            bool straight = s > 0 && s < 1;
            out_r = straight ? -ez / length : vr / norm;
            out_z = straight ? er / length : vz / norm;
        }
    }
    if (inside <= 0) return inside;
    *nr = out_r, *nz = out_z;
    return outside;
}

bool closed_sphere_revolved(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    profile f = profile_of(&p->b);
    vec3 c = vec_neg(mat_tmul(p->b_in_a.r, p->b_in_a.t));
    vec3 radial = unit_or(vec(c.x, c.y, 0), vec(1, 0, 0));
    double nr = 0, nz = 1, distance = profile_distance(&f, vec_norm(vec(c.x, c.y, 0)), c.z, &nr, &nz);
    vec3 axis = mat_mul(p->b_in_a.r, vec(-nr * radial.x, -nr * radial.y, -nz));
    return exact(out, distance, axis, VEC_ZERO, vec_scale(axis, distance));
}

bool closed_any_halfspace(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 axis = vec_neg(p->b_in_a.r.z), point = unit_pair_support_a(p, axis, NULL);
    double distance = vec_dot(axis, vec_sub(p->b_in_a.t, point));
    return exact(out, distance, axis, point, vec_madd(point, distance, axis));
}

bool closed_halfspace_any(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 axis = vec(0, 0, 1), point = unit_pair_support_b(p, vec(0, 0, -1), NULL);
    return exact(out, point.z, axis, vec(point.x, point.y, 0), point);
}

/* Planes that are not parallel meet: no translation separates. Parallel, back to back: the slab between (or shared). */
bool closed_halfspace_halfspace(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    vec3 n = p->b_in_a.r.z, t = p->b_in_a.t;
    bool opposite = n.z < 0 && fabs(n.x) <= 4 * UNIT_ROUNDOFF && fabs(n.y) <= 4 * UNIT_ROUNDOFF;
    return exact(out, opposite ? t.z : -INFINITY, vec(0, 0, 1), vec(t.x, t.y, 0), t);
}
