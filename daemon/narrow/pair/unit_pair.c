/* unit_pair: normalisation of two shapes to unit size, their support points, and the bound of the rounding in them.
 *
 * Pure; any thread. The scale is a power of two, so every bit of an answer but the exponent is independent of it. */
#include "unit_pair.h"

#include "core.h"
#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"
#include "geom/round.h"

#include <string.h>

/* A plane has no end, and nothing of its own but its rounding. Hulls without a call: they are asked about most. */
static inline double own_reach(const shape *s)
{
    if (s->type == SHAPE_HULL) return add_up(s->hull->reach, s->radius);
    return shape_is_plane(s) ? s->radius : shape_reach(s);
}

static inline double own_excess(const shape *s)
{
    return s->type == SHAPE_HULL ? s->hull->excess : shape_excess(s);
}

static inline void scale_shape(const shape *s, double scale, shape *out)
{
    out->type = s->type;
    out->radius = s->radius * scale;
    out->deviation = s->deviation;
    out->half = vec_scale(s->half, scale);
    out->hull = s->hull, out->mesh = s->mesh, out->compound = s->compound;
}

/* A degenerate shape becomes the simpler shape that it is (a capsule of length zero is a sphere): fewer cases later,
 * and closed forms for more of them. */
static void unit_pair_reduce(shape *s)
{
    if (s->type == SHAPE_ELLIPSOID && s->half.x == s->half.y && s->half.y == s->half.z) {
        s->radius += s->half.x;
        s->type = SHAPE_SPHERE;
    }
    if (s->type == SHAPE_CONE && s->half.z == 0) s->type = SHAPE_CYLINDER; /* a disc */
    if ((s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE) && s->half.x == 0) s->type = SHAPE_CAPSULE;
    if (s->type == SHAPE_CAPSULE && s->half.z == 0) s->type = SHAPE_SPHERE;
}

/* A ball that is no larger than the tightest curve of a convex surface rolls all along its inside, and the body is the
 * sum of that ball and of what is left (Blaschke, "Kreis und Kugel", 1916). So an ellipsoid is a smaller core with a
 * radius, and is apart from what it touches for as long as its core is. The factor keeps rounding out of it. */
static double shave(shape *s, const shape *other)
{
    if (s->type != SHAPE_ELLIPSOID || other->type > SHAPE_HULL) return 0; /* meshes ask for the core itself */
    double least = min_of(min_of(s->half.x, s->half.y), s->half.z), most = vec_greatest(s->half);
    double ball = most > 0 ? 0.99 * least * (least / most) : 0;
    s->radius += ball;
    return ball;
}

/* A child of a compound is at a pose of its own: its frame, its inverse where the pair is turned round, and the
 * products with the pair's pose come on top. */
#define COMPOUND_SHARE 4

static double error_share(const shape *a, const shape *b)
{
    return a->type == SHAPE_COMPOUND || b->type == SHAPE_COMPOUND ? COMPOUND_SHARE : 1;
}

void unit_pair_init(unit_pair *p, const shape *a, const shape *b, const pose *b_in_a)
{
    double reach_a = own_reach(a), reach_b = own_reach(b);
    unit_of(max_of(max_of(reach_a, reach_b), vec_greatest(b_in_a->p)), &p->unit, &p->scale);
    scale_shape(a, p->scale, &p->a);
    scale_shape(b, p->scale, &p->b);
    p->shaved_a = p->shaved_b = 0;
    if (a->type < SHAPE_HULL || b->type < SHAPE_HULL) {
        unit_pair_reduce(&p->a);
        unit_pair_reduce(&p->b);
        p->shaved_a = shave(&p->a, &p->b);
        p->shaved_b = shave(&p->b, &p->a);
    }
    p->b_in_a.r = quat_matrix(b_in_a->q);
    p->b_in_a.t = vec_scale(b_in_a->p, p->scale);
    p->radius = p->a.radius + p->b.radius;
    p->shell = NULL;
    p->effort = NULL;
    p->apart_along = VEC_ZERO;
    p->remembers = false;
    p->size = reach_a * p->scale + reach_b * p->scale + vec_norm(p->b_in_a.t);
    if (shape_is_plane(a) || shape_is_plane(b))
        p->size *= 2; /* a plane turns about its origin, as far as to where the other is */
    p->error = error_share(a, b) * unit_error(p->size);
    if (p->unit < LEAST_EXACT_UNIT) p->error += LEAST_ERROR * p->scale;
    p->excess = (own_excess(a) + own_excess(b)) * p->scale;
    p->deviation = (a->deviation + b->deviation) * p->scale;
}

vec3 unit_pair_support_a(const unit_pair *p, vec3 direction, uint32_t *hint)
{
    return core_shaved(&p->a, p->scale, p->shaved_a, direction, hint);
}

vec3 unit_pair_support_b(const unit_pair *p, vec3 direction, uint32_t *hint)
{
    return transform_point(
        &p->b_in_a, core_shaved(&p->b, p->scale, p->shaved_b, mat_tmul(p->b_in_a.r, direction), hint));
}

static int64_t support_price(const shape *s)
{
    int64_t price = EFFORT_SUPPORT;
    if (s->type == SHAPE_HULL) price += s->hull->vertex_count / EFFORT_VERTICES;
    for (uint32_t i = 0; s->type == SHAPE_COMPOUND && i < s->compound->child_count; i++)
        price += support_price(&s->compound->children[i].shape);
    return price;
}

int64_t unit_pair_support_price(const unit_pair *p)
{
    return p->effort ? support_price(&p->a) + support_price(&p->b) : 0;
}

void unit_pair_nearest_to(const unit_pair *p, vec3 axis, support_hints *hints, minkowski *m)
{
    vec3 back = mat_tmul(p->b_in_a.r, vec_neg(axis)), a, b_local;
    if (p->a.type == SHAPE_HULL && p->b.type == SHAPE_HULL) {
        a = core_hull(p->a.hull, p->scale, axis, &hints->a);
        b_local = core_hull(p->b.hull, p->scale, back, &hints->b);
        m->vertex_a = hints->a, m->vertex_b = hints->b;
    } else if (p->a.type == SHAPE_BOX && p->b.type == SHAPE_HULL) {
        m->vertex_a = (signbit(axis.x) ? 0 : 1U) | (signbit(axis.y) ? 0 : 2U) | (signbit(axis.z) ? 0 : 4U);
        a = box_corner(p->a.half, m->vertex_a);
        b_local = core_hull(p->b.hull, p->scale, back, &hints->b);
        m->vertex_b = hints->b;
    } else {
        a = core_shaved(&p->a, p->scale, p->shaved_a, axis, &hints->a);
        b_local = core_shaved(&p->b, p->scale, p->shaved_b, back, &hints->b);
        m->vertex_a = m->vertex_b = 0;
    }
    vec3 b = transform_point(&p->b_in_a, b_local);
    m->w = vec_sub(b, a);
    m->a = a;
    m->b = b;
    m->b_local = b_local;
}

minkowski unit_pair_nearest_from(const unit_pair *p, vec3 axis, support_hints *hints)
{
    minkowski m;
    unit_pair_nearest_to(p, axis, hints, &m);
    return m;
}

minkowski unit_pair_nearest_along(const unit_pair *p, vec3 axis)
{
    support_hints hints = NO_HINTS;
    return unit_pair_nearest_from(p, axis, &hints);
}

vec3 vec_unit_orthogonal(vec3 v)
{
    double x = fabs(v.x), y = fabs(v.y), z = fabs(v.z);
    vec3 least = x <= y && x <= z ? vec(1, 0, 0) : y <= z ? vec(0, 1, 0) : vec(0, 0, 1);
    return direction_of(vec_cross(v, least));
}

/* ==== order ==== */

/* The canonical order of two shapes, so that a pair is always computed the same way round. */

static int compare(double x, double y)
{
    return (x > y) - (x < y);
}

static int compare_array(const double *x, const double *y, uint32_t count)
{
    int c = 0;
    for (uint32_t i = 0; i < count && c == 0; i++) c = compare(x[i], y[i]);
    return c;
}

static int compare_hull(const hull *a, const hull *b)
{
    if (a == b) return 0;
    if (a->vertex_count != b->vertex_count) return a->vertex_count < b->vertex_count ? -1 : 1;
    int c = compare_array(a->x, b->x, a->vertex_count);
    if (c == 0) c = compare_array(a->y, b->y, a->vertex_count);
    return c ? c : compare_array(a->z, b->z, a->vertex_count);
}

static int compare_mesh(const mesh *a, const mesh *b)
{
    if (a == b) return 0;
    if (a->triangle_count != b->triangle_count) return a->triangle_count < b->triangle_count ? -1 : 1;
    if (a->vertex_count != b->vertex_count) return a->vertex_count < b->vertex_count ? -1 : 1;
    int c = compare_array(&a->vertices->x, &b->vertices->x, 3 * a->vertex_count);
    return c ? c : memcmp(a->triangles, b->triangles, a->triangle_count * sizeof *a->triangles);
}

static int compare_vec(vec3 a, vec3 b)
{
    int c = compare(a.x, b.x);
    if (c == 0) c = compare(a.y, b.y);
    return c ? c : compare(a.z, b.z);
}

static int compare_compound(const compound *a, const compound *b)
{
    if (a == b) return 0;
    if (a->child_count != b->child_count) return a->child_count < b->child_count ? -1 : 1;
    int c = 0;
    for (uint32_t i = 0; i < a->child_count && c == 0; i++) {
        c = order_shapes(&a->children[i].shape, &b->children[i].shape); /* no child is a compound */
        if (c == 0) c = order_poses(a->children[i].local, b->children[i].local);
        if (c == 0) c = compare(a->children[i].shape.deviation, b->children[i].shape.deviation);
    }
    return c;
}

int order_shapes(const shape *a, const shape *b)
{
    if (a->type != b->type) return a->type < b->type ? -1 : 1;
    int c = compare_vec(a->half, b->half);
    if (c == 0) c = compare(a->radius, b->radius);
    if (c == 0 && a->type == SHAPE_COMPOUND) return compare_compound(a->compound, b->compound);
    if (c || !a->hull) return c;
    c = compare_hull(a->hull, b->hull);
    return c || a->type != SHAPE_MESH ? c : compare_mesh(a->mesh, b->mesh);
}

int order_poses(pose a, pose b)
{
    int c = compare_vec(a.p, b.p);
    if (c == 0) c = compare(a.q.w, b.q.w);
    return c ? c : compare_vec(vec(a.q.x, a.q.y, a.q.z), vec(b.q.x, b.q.y, b.q.z));
}
