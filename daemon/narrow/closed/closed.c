/* closed: formulas for points, segments, boxes, bodies of revolution and half-spaces. Pure; any thread. */
#include "closed.h"

#include "formulas.h"

bool closed_sphere_sphere(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    return formula_sphere_sphere(p, out);
}

bool closed_sphere_capsule(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    return formula_sphere_capsule(p, out);
}

bool closed_sphere_box(const unit_pair *p, const narrow_goal *goal, span *out)
{
    (void)goal;
    return formula_sphere_box(p, out);
}

static void keep_nearer(const segments *g, double s_a, double s_b, span *out)
{
    span s = *out;
    take_points(g, s_a, s_b, &s);
    if (s.hi < out->hi) *out = s;
}

/* The four ends against the other segment, and the two lines against each other: the least is the distance. */
static void nearest_of_ends(const segments *g, span *out)
{
    for (int i = -1; i <= 1; i += 2) {
        keep_nearer(g, i * g->ha, clamp_to(i * g->ha * g->ab - g->bt, g->hb), out);
        keep_nearer(g, clamp_to(g->at + i * g->hb * g->ab, g->ha), i * g->hb, out);
    }
}

bool closed_capsule_capsule(const unit_pair *p, const narrow_goal *goal, span *out)
{
    segments g = segments_of(p);
    if (formula_capsule_capsule(p, &g, out)) return true;
    nearest_of_ends(&g, out);
    out->lo = separation(&g, out->axis);
    return out->hi - out->lo <= max_of(goal->tolerance, p->error);
}

/* The profile of a body of revolution in the half-plane (radius, z), from the axis round to the axis: corners, and the
 * edges between them, none of which is without length. A disc has two, back to back. */
typedef struct profile {
    int edges;
    double r[4], z[4];
} profile;

static profile profile_of(const shape *s)
{
    double r = s->half.x, h = s->half.z;
    if (s->type == SHAPE_CONE || h == 0) return (profile){2, {0, r, 0}, {s->type == SHAPE_CONE ? h : 0, -h, -h}};
    return (profile){3, {0, r, r, 0}, {h, h, -h, -h}};
}

/* Of an edge as a point sees it: how high the point is above its line, how far it is past its beginning and past its
 * end, and the outward normal. However short it is, an edge has a direction. */
typedef struct edge_view {
    double height, past_begin, past_end, nr, nz;
} edge_view;

static edge_view edge_seen(const profile *f, int i, double r, double z)
{
    vec3 e = direction_of(vec(f->r[i + 1] - f->r[i], f->z[i + 1] - f->z[i], 0));
    double dr = r - f->r[i], dz = z - f->z[i], next_r = r - f->r[i + 1], next_z = z - f->z[i + 1];
    return (edge_view){dz * e.x - dr * e.y, dr * e.x + dz * e.y, next_r * e.x + next_z * e.y, -e.y, e.x};
}

/* Signed distance of the point (r, z) from the profile, and the unit direction (*nr, *nz) in which it leaves.
 *
 * Outside: of the nearest point. That is in an edge, beyond which the point is; or at a corner, of which the point is
 * past both edges. That is asked of the very vector from the corner to the point, however short it is: so the direction
 * is always one of the corner's normals, and proves the distance. Inside: of the nearest line of an edge, for the
 * profile is convex; rounding may also have put a point there that is as near to the outline as that. */
static double profile_distance(const profile *f, double r, double z, double *nr, double *nz)
{
    double inside = -INFINITY, outside = INFINITY, out_r = 0, out_z = 1;
    bool past = true; /* of the edge before, as is `before` */
    double before = -INFINITY;
    for (int i = 0; i <= f->edges; i++) {
        edge_view e = i < f->edges ? edge_seen(f, i, r, z) : (edge_view){.height = -INFINITY};
        double cr = r - f->r[i], cz = z - f->z[i], corner = sqrt(cr * cr + cz * cz);
        bool above = before >= 0 || e.height >= 0;
        if (past && above && e.past_begin <= 0 && corner > 0 && corner < outside)
            outside = corner, out_r = cr / corner, out_z = cz / corner;
        if (e.height >= 0 && e.past_begin > 0 && e.past_end < 0 && e.height < outside)
            outside = e.height, out_r = e.nr, out_z = e.nz;
        if (e.height > inside) inside = e.height, *nr = e.nr, *nz = e.nz;
        past = e.past_end >= 0, before = e.height;
    }
    if (inside < 0 || !(outside > 0) || isinf(outside)) return inside;
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
