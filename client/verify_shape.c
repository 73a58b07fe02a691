/* verify_shape: support and distance of single shapes. All shapes are a convex core within whose radius all points
 * count; the functions on the core work in its own frame. */
#include "verify_shape.h"

#include <math.h>

static real larger(real a, real b)
{
    return a > b ? a : b;
}
static real outside(real x, real half)
{
    return larger(fabs(x) - half, 0);
} /* of [-half, half] */

/* ---- placing ---- */

typedef struct quat {
    real w, x, y, z;
} quat;

static bool quat_of(const collided_pose *pose, quat *q)
{
    const double *o = pose->orientation;
    if (!all_finite(pose->position, 3) || !all_finite(o, 4)) return false;
    real norm = sqrt(o[0] * o[0] + o[1] * o[1] + o[2] * o[2] + o[3] * o[3]);
    if (!(fabs(norm - 1) < 1e-3)) return false;
    real by = 1 / norm;
    *q = (quat){o[0] * by, o[1] * by, o[2] * by, o[3] * by};
    return true;
}

/* First b, then a. */
static quat product(quat a, quat b)
{
    return (quat){a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x, a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w};
}

/* Where it turns the axis of the coordinates (0, 1, 2) to. */
static vec column(quat q, int axis)
{
    if (axis == 0)
        return (vec){1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y)};
    if (axis == 1)
        return (vec){2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x)};
    return (vec){2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)};
}

/* v + 2 w (q x v) + 2 q x (q x v), q being the vector part. */
static vec turned(quat q, vec v)
{
    vec u = {q.x, q.y, q.z};
    vec t = scale(2, cross(u, v));
    return add(v, add(scale(q.w, t), cross(u, t)));
}

static vec out_of_shape(const placed *p, vec v)
{
    return add(add(scale(v.x, p->columns[0]), scale(v.y, p->columns[1])), scale(v.z, p->columns[2]));
}

static bool is_sized(const collided_shape *s)
{
    return all_finite(s->half, 3) && isfinite(s->radius) && s->radius >= 0 && isfinite(s->deviation) &&
           s->deviation >= 0 && s->half[0] >= 0 && s->half[1] >= 0 && s->half[2] >= 0;
}

/* The child stands where its own pose puts it in the compound's frame. */
static bool placed_child(const placed *whole, size_t index, placed *out)
{
    const collided_shape *child = &whole->shape->children[index];
    quat local;
    bool fits = (unsigned)child->type < COLLIDED_HULL && child->type != COLLIDED_HALFSPACE;
    if (!fits || !is_sized(child) || !quat_of(&child->pose, &local)) return false;
    out->shape = child;
    out->points = NULL;
    out->point_count = 0;
    out->prepared = NULL;
    out->body = whole->body;
    out->rounding = whole->shape->radius;
    for (int i = 0; i < 3; i++) out->columns[i] = out_of_shape(whole, column(local, i));
    out->origin = add(whole->origin, out_of_shape(whole, vec_of(child->pose.position)));
    return true;
}

static bool has_children(const placed *whole)
{
    placed child;
    if (!whole->shape->children || !whole->shape->child_count) return false;
    for (size_t i = 0; i < whole->shape->child_count; i++)
        if (!placed_child(whole, i, &child)) return false;
    return true;
}

bool placed_make(placed *p, const collided_shape *shape, const collided_pose *body, hull_points points)
{
    quat world, local;
    bool is_hull = shape->type == COLLIDED_HULL;
    bool concave = shape->type == COLLIDED_MESH || shape->type == COLLIDED_HEIGHT_FIELD || shape->type == COLLIDED_SOFT;
    if (concave || !is_sized(shape) || !quat_of(body, &world) || !quat_of(&shape->pose, &local)) return false;
    if (is_hull && (!points.at || !points.count)) return false;
    p->shape = shape;
    p->points = points.at;
    p->point_count = is_hull ? points.count : 0;
    p->prepared = points.prepared;
    p->body = vec_of(body->position);
    p->rounding = 0;
    quat both = product(world, local);
    for (int i = 0; i < 3; i++) p->columns[i] = column(both, i);
    p->origin = turned(world, vec_of(shape->pose.position));
    return shape->type != COLLIDED_COMPOUND || has_children(p);
}

static vec into_shape(const placed *p, vec v)
{
    return (vec){dot(p->columns[0], v), dot(p->columns[1], v), dot(p->columns[2], v)};
}

static const real FACE_DEPTH = 1e-7; /* of the points' size: so far below the highest belong to the face */

static real face_depth(const placed *p)
{
    return FACE_DEPTH * sqrt(p->reach2);
}

bool placed_look(placed *p, vec n)
{
    if (!p->point_count) return true;
    if (p->prepared) {
        p->reach2 = p->prepared->reach2;
        prepared_look(p->prepared, into_shape(p, n), face_depth(p), &p->prepared_scan);
        p->top = p->prepared_scan.top;
        return true;
    }
    points_look(p->points, p->point_count, into_shape(p, n), &p->scan);
    p->top = p->scan.top;
    p->reach2 = p->scan.reach2;
    return p->scan.finite;
}

vec placed_normal(const placed *p)
{
    return p->columns[2];
}

/* The greatest of what a function says of the children. */
typedef real child_measure(const placed *p, vec v);
static real greatest(const placed *whole, child_measure *measure, vec v)
{
    real best = -INFINITY;
    for (size_t i = 0; i < whole->shape->child_count; i++) {
        placed child;
        if (placed_child(whole, i, &child)) best = larger(best, measure(&child, v));
    }
    return best;
}

static real reach_of_child(const placed *p, vec unused)
{
    (void)unused;
    return placed_reach(p);
}

real placed_reach(const placed *p)
{
    if (p->shape->type == COLLIDED_COMPOUND) return greatest(p, reach_of_child, p->origin);
    vec half = vec_of(p->shape->half);
    real core2 = dot(half, half);
    if (p->point_count) core2 = larger(core2, p->reach2);
    return length(p->origin) + sqrt(core2) + p->shape->radius + p->rounding;
}

/* ---- support of the core along a direction in its frame ---- */

static real core_support(const placed *p, vec d)
{
    const double *h = p->shape->half;
    real rho = sqrt(d.x * d.x + d.y * d.y);
    switch (p->shape->type) {
    case COLLIDED_SPHERE:
        return 0;
    case COLLIDED_CAPSULE:
        return h[2] * fabs(d.z);
    case COLLIDED_BOX:
        return h[0] * fabs(d.x) + h[1] * fabs(d.y) + h[2] * fabs(d.z);
    case COLLIDED_CYLINDER:
        return h[0] * rho + h[2] * fabs(d.z);
    case COLLIDED_CONE:
        return larger(h[2] * d.z, h[0] * rho - h[2] * d.z);
    case COLLIDED_ELLIPSOID:
        return length((vec){h[0] * d.x, h[1] * d.y, h[2] * d.z});
    case COLLIDED_HALFSPACE:
        return 0;
    case COLLIDED_HULL:
        return p->top;
    case COLLIDED_MESH: /* placed_make takes neither */
    case COLLIDED_HEIGHT_FIELD:
    case COLLIDED_SOFT:
    case COLLIDED_COMPOUND: /* its children are asked */
        break;
    }
    return INFINITY;
}

real placed_support(const placed *p, vec n)
{
    if (p->shape->type == COLLIDED_COMPOUND) return greatest(p, placed_support, n);
    return dot(n, p->origin) + core_support(p, into_shape(p, n)) + p->shape->radius + p->rounding;
}

/* ---- distance of a point from the core, in its frame ---- */

static real length_of(real x, real y)
{
    return sqrt(x * x + y * y);
}

/* In the half plane (distance from the axis, height) the cone is the triangle of rim (r, -h), apex (0, h) and (0, -h),
 * which may be flat, a segment or a point. */
static real cone_distance(vec q, real r, real h)
{
    real rho = length_of(q.x, q.y), square = r * r + 4 * h * h;
    if (fabs(q.z) <= h && rho <= r && (h == 0 || rho <= r * ((h - q.z) / (2 * h)))) return 0;
    real base = length_of(larger(rho - r, 0), q.z + h);
    real along =
        square > 0 ? (-r * (rho - r) + 2 * h * (q.z + h)) / square : 0; /* on the slant from rim (0) to apex (1) */
    along = along < 0 ? 0 : along > 1 ? 1 : along;
    real slant = length_of(rho - (1 - along) * r, q.z + h - along * 2 * h);
    return base < slant ? base : slant;
}

/* Of q from where the line to the centre meets the surface: not less than its distance, and 0 inside. Infinite where a
 * flat ellipsoid lets no such point be found. */
static real radial_distance(vec q, const double a[3])
{
    const real p[] = {q.x, q.y, q.z};
    real sum = 0;
    for (int i = 0; i < 3; i++) sum += p[i] != 0 ? p[i] / a[i] * (p[i] / a[i]) : 0;
    return sum <= 1 ? 0 : sum < INFINITY ? length(q) * (1 - 1 / sqrt(sum)) : INFINITY;
}

/* The closest point of the surface is x_i = a_i^2 q_i / (a_i^2 + t), with t where sum (x_i / a_i)^2 = 1 (Eberly,
 * Distance from a Point to an Ellipsoid). The sum falls with t, so bisection finds it. */
static real ellipsoid_distance(vec q, const double a[3])
{
    const real p[] = {q.x, q.y, q.z};
    real low = 0, high = 0;
    for (int i = 0; i < 3; i++) high += a[i] * fabs(p[i]);
    for (int step = 0; step < 160; step++) {
        real t = (low + high) / 2, sum = 0;
        for (int i = 0; i < 3; i++) {
            real x = p[i] != 0 && a[i] != 0 ? a[i] * p[i] / (a[i] * a[i] + t) : 0;
            sum += x * x;
        }
        if (sum > 1)
            low = t;
        else
            high = t;
    }
    real square = 0;
    for (int i = 0; i < 3; i++) {
        if (p[i] == 0) continue;
        real away = a[i] != 0 ? p[i] * high / (a[i] * a[i] + high) : p[i]; /* flat along that axis */
        square += away * away;
    }
    return sqrt(square);
}

/* ---- hulls: the point of a hull that is nearest to the origin, by GJK over all sub-simplices ---- */

typedef struct simplex {
    vec at[4];
    int count;
} simplex;

static real det3(vec a, vec b, vec c)
{
    return dot(a, cross(b, c));
}

/* Nearest point to the origin of the plane, line or point through the vertices chosen by `mask`; false unless it lies
 * within them. The normal equations of at most three unknowns, by Cramer's rule, and again for what that leaves: of
 * thin triangles and flat tetrahedra it leaves much. */
static bool nearest_inside(const simplex *s, unsigned mask, vec *nearest)
{
    enum { ROUNDS = 3 };
    vec y[4];
    int n = 0;
    for (int i = 0; i < s->count; i++)
        if (mask >> i & 1) y[n++] = s->at[i];
    vec e[3] = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    for (int i = 1; i < n; i++) e[i - 1] = sub(y[i], y[0]);
    /* Unused unknowns get the identity, so that one formula serves all. */
    vec row[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < n - 1; i++) row[i] = (vec){dot(e[i], e[0]), dot(e[i], e[1]), dot(e[i], e[2])};
    vec c0 = {row[0].x, row[1].x, row[2].x}, c1 = {row[0].y, row[1].y, row[2].y}, c2 = {row[0].z, row[1].z, row[2].z};
    real det = det3(c0, c1, c2);
    if (!(det > 0)) return false; /* Gram determinants are positive; zero: the vertices are degenerate */
    real w[3] = {0, 0, 0};
    *nearest = y[0];
    for (int round = 0; round < ROUNDS; round++) {
        vec b = {-dot(e[0], *nearest), -dot(e[1], *nearest), -dot(e[2], *nearest)};
        const real more[] = {det3(b, c1, c2) / det, det3(c0, b, c2) / det, det3(c0, c1, b) / det};
        *nearest = y[0];
        for (int i = 0; i < n - 1; i++) {
            w[i] += more[i];
            *nearest = add(*nearest, scale(w[i], e[i]));
        }
    }
    return w[0] >= 0 && w[1] >= 0 && w[2] >= 0 && w[0] + w[1] + w[2] <= 1;
}

/* The simplex shrinks to the vertices that carry its nearest point. */
static vec shrink(simplex *s)
{
    vec best = s->at[s->count - 1], v;
    unsigned kept = 1u << (s->count - 1);
    for (unsigned mask = 1; mask < 1u << s->count; mask++) {
        if (!nearest_inside(s, mask, &v) || !(dot(v, v) < dot(best, best))) continue;
        best = v;
        kept = mask;
    }
    simplex smaller = {.count = 0};
    for (int i = 0; i < s->count; i++)
        if (kept >> i & 1) smaller.at[smaller.count++] = s->at[i];
    *s = smaller;
    return best;
}

static vec hull_point(const placed *p, vec q, vec d)
{
    vec best = {0, 0, 0};
    real most = -INFINITY;
    for (size_t i = 0; i < p->point_count; i++) {
        vec v = sub(vec_of(p->points + 3 * i), q);
        if (dot(v, d) <= most) continue;
        most = dot(v, d);
        best = v;
    }
    return best;
}

/* Each step's point is in the hull, so that stopping early gives a distance that is too large, never one too small. */
static real hull_distance(const placed *p, vec q)
{
    enum { STEPS = 256 };
    simplex s = {.at = {sub(vec_of(p->points), q)}, .count = 1};
    vec v = s.at[0];
    for (int step = 0; step < STEPS && s.count < 4; step++) {
        vec w = hull_point(p, q, scale(-1, v));
        real gain = dot(v, v) - dot(v, w);
        if (!(gain > 4 * (real)0x1p-53 * dot(v, v))) break;
        s.at[s.count++] = w;
        vec closer = shrink(&s);
        if (!(dot(closer, closer) < dot(v, v))) break;
        v = closer;
    }
    return length(v);
}

/* Is q not farther than `slack` from one of the triangles (or from the corner or edge) that the points highest along n
 * make? They are the face on which witness points lie, so that for these no search is needed. */
enum { FACE_MOST = 6 };
static bool near_segment(vec q, vec a, vec b, real slack)
{
    vec e = sub(b, a), d = sub(q, a);
    real s = dot(d, e) / dot(e, e);
    s = s > 0 ? s < 1 ? s : 1 : 0; /* of equal points: 0 */
    return length(sub(d, scale(s, e))) <= slack;
}

static bool near_triangle(vec q, vec a, vec b, vec c, real slack)
{
    vec n = cross(sub(b, a), sub(c, a)), d = sub(q, a);
    real n2 = dot(n, n), beta = dot(cross(d, sub(c, a)), n), gamma = dot(cross(sub(b, a), d), n);
    bool inside = beta >= 0 && gamma >= 0 && beta + gamma <= n2 && n2 > 0;
    return inside && fabs(dot(d, n)) <= slack * sqrt(n2);
}

static bool near_face(const placed *p, vec q, real slack)
{
    vec v[FACE_MOST];
    int count = p->prepared ? prepared_on_top(p->prepared, &p->prepared_scan, face_depth(p), v, FACE_MOST)
                            : points_on_top(p->points, p->point_count, &p->scan, face_depth(p), v, FACE_MOST);
    for (int i = 0; i < count; i++) {
        if (length(sub(q, v[i])) <= slack) return true;
        for (int k = 0; k < i; k++) {
            if (near_segment(q, v[i], v[k], slack)) return true;
            for (int l = 0; l < k; l++)
                if (near_triangle(q, v[i], v[k], v[l], slack)) return true;
        }
    }
    return false;
}

static real core_distance(const placed *p, vec q)
{
    const double *h = p->shape->half;
    real rho = sqrt(q.x * q.x + q.y * q.y);
    switch (p->shape->type) {
    case COLLIDED_SPHERE:
        return length(q);
    case COLLIDED_CAPSULE:
        return length_of(rho, outside(q.z, h[2]));
    case COLLIDED_BOX:
        return length((vec){outside(q.x, h[0]), outside(q.y, h[1]), outside(q.z, h[2])});
    case COLLIDED_CYLINDER:
        return length_of(outside(rho, h[0]), outside(q.z, h[2]));
    case COLLIDED_CONE:
        return cone_distance(q, h[0], h[2]);
    case COLLIDED_ELLIPSOID:
        return ellipsoid_distance(q, h);
    case COLLIDED_HALFSPACE:
        return larger(q.z, 0);
    case COLLIDED_HULL:
        return hull_distance(p, q);
    case COLLIDED_MESH: /* placed_make takes neither */
    case COLLIDED_HEIGHT_FIELD:
    case COLLIDED_SOFT:
    case COLLIDED_COMPOUND: /* its children are asked */
        break;
    }
    return INFINITY;
}

static bool convex_holds(const placed *p, vec world, vec n, real slack)
{
    vec q = into_shape(p, sub(sub(world, p->body), p->origin));
    real radius = p->shape->radius + p->rounding, reach = radius + slack;
    if (p->shape->type == COLLIDED_ELLIPSOID && radial_distance(q, p->shape->half) <= reach) return true;
    if (p->shape->type == COLLIDED_HULL) {
        vec d = into_shape(p, n);
        if (near_face(p, sub(q, scale(radius, d)), slack)) return true;
    }
    return core_distance(p, q) <= reach;
}

/* A point of several children is as near to what is meant as the best of them says. */
bool placed_holds(const placed *p, vec world, vec n, real slack, real *deviation)
{
    *deviation = p->shape->deviation;
    if (p->shape->type != COLLIDED_COMPOUND) return convex_holds(p, world, n, slack);
    real least = INFINITY;
    for (size_t i = 0; i < p->shape->child_count; i++) {
        placed child;
        if (placed_child(p, i, &child) && child.shape->deviation < least && convex_holds(&child, world, n, slack))
            least = child.shape->deviation;
    }
    *deviation += least;
    return least < INFINITY;
}
