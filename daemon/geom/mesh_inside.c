/* Is a point inside of a solid mesh? Its winding number, counted along the ray from it towards +z. Pure; any thread.
 *
 * The ray is moved aside by (e, e^2, 0) for an infinitely small e (Edelsbrunner and Muecke, "Simulation of simplicity",
 * 1990), so that it never meets an edge or a corner, and both triangles of an edge see it on the same side. Signs come
 * from doubles where those suffice and from exact sums where they do not. The point is not on the surface, so whether
 * a triangle that the ray's line meets is above it is never a tie. */
#include "expansion.h"
#include "mesh_steps.h"

/* Shewchuk's bounds for the determinants in doubles are (3 + 16 u) u and (7 + 56 u) u of the sums of magnitudes. */
#define FILTER_2 0x1p-51
#define FILTER_3 0x1p-50

typedef struct difference { /* a - b, exactly: hi + lo */
    double e[2];            /* the lesser first */
} difference;

static difference minus(double a, double b)
{
    difference d;
    expansion_two_sum(a, -b, &d.e[1], &d.e[0]);
    return d;
}

/* e += sign * p * q */
static int add_product(int n, double *e, const difference *p, const difference *q, double sign)
{
    n = expansion_add_scaled(n, e, 2, p->e, sign * q->e[0]);
    return expansion_add_scaled(n, e, 2, p->e, sign * q->e[1]);
}

static int sign_of_cross(const difference *px, const difference *qy, const difference *py, const difference *qx)
{
    double e[16];
    int n = add_product(0, e, px, qy, 1);
    return expansion_sign(add_product(n, e, py, qx, -1), e);
}

bool mesh_points_in_line(vec3 p, vec3 q, vec3 r)
{
    difference px = minus(p.x, r.x), py = minus(p.y, r.y), pz = minus(p.z, r.z);
    difference qx = minus(q.x, r.x), qy = minus(q.y, r.y), qz = minus(q.z, r.z);
    return sign_of_cross(&px, &qy, &py, &qx) == 0 && sign_of_cross(&py, &qz, &pz, &qy) == 0 &&
           sign_of_cross(&pz, &qx, &px, &qz) == 0;
}

/* On which side of the line from p to q, seen along z, is c? 1: to its left. Ties by the move aside. */
static int side_of_line(vec3 p, vec3 q, vec3 c)
{
    double left = (p.x - c.x) * (q.y - c.y), right = (p.y - c.y) * (q.x - c.x), value = left - right;
    if (fabs(value) > FILTER_2 * (fabs(left) + fabs(right))) return value > 0 ? 1 : -1;
    difference px = minus(p.x, c.x), py = minus(p.y, c.y), qx = minus(q.x, c.x), qy = minus(q.y, c.y);
    int sign = sign_of_cross(&px, &qy, &py, &qx);
    if (sign) return sign;
    if (p.y != q.y) return p.y > q.y ? 1 : -1; /* the value grows with c.x by p.y - q.y */
    return (q.x > p.x) - (q.x < p.x);          /* and with c.y by q.x - p.x */
}

/* The determinant of three differences by its first column: e += column * (y1 z2 - z1 y2). */
static int add_minor(int n, double *e, const difference *x, const difference *y1, const difference *z1,
    const difference *y2, const difference *z2)
{
    double minor[16];
    int m = add_product(0, minor, y1, z2, 1);
    m = add_product(m, minor, z1, y2, -1);
    n = expansion_add_scaled(n, e, m, minor, x->e[0]);
    return expansion_add_scaled(n, e, m, minor, x->e[1]);
}

/* The sign of det(p - c, q - c, r - c): 1 where c is below the plane of p, q, r that are counter-clockwise seen from
 * above, along -z. */
static int below_plane(vec3 p, vec3 q, vec3 r, vec3 c)
{
    vec3 a = vec_sub(p, c), b = vec_sub(q, c), d = vec_sub(r, c);
    double t[6] = {b.y * d.z, b.z * d.y, d.y * a.z, d.z * a.y, a.y * b.z, a.z * b.y};
    double value = a.x * (t[0] - t[1]) + b.x * (t[2] - t[3]) + d.x * (t[4] - t[5]);
    double sum = fabs(a.x) * (fabs(t[0]) + fabs(t[1])) + fabs(b.x) * (fabs(t[2]) + fabs(t[3])) +
                 fabs(d.x) * (fabs(t[4]) + fabs(t[5]));
    if (fabs(value) > FILTER_3 * sum) return value > 0 ? 1 : -1;
    difference ax = minus(p.x, c.x), ay = minus(p.y, c.y), az = minus(p.z, c.z);
    difference bx = minus(q.x, c.x), by = minus(q.y, c.y), bz = minus(q.z, c.z);
    difference dx = minus(r.x, c.x), dy = minus(r.y, c.y), dz = minus(r.z, c.z);
    double e[192];
    int n = add_minor(0, e, &ax, &by, &bz, &dy, &dz);
    n = add_minor(n, e, &bx, &dy, &dz, &ay, &az);
    n = add_minor(n, e, &dx, &ay, &az, &by, &bz);
    return expansion_sign(n, e);
}

/* Is all of a triangle to one side of the ray, or below where it begins? Strictly, so that the move aside does not
 * matter. */
static bool is_beside(vec3 p, vec3 q, vec3 r, vec3 c)
{
    return (p.x < c.x && q.x < c.x && r.x < c.x) || (p.x > c.x && q.x > c.x && r.x > c.x) ||
           (p.y < c.y && q.y < c.y && r.y < c.y) || (p.y > c.y && q.y > c.y && r.y > c.y) ||
           (p.z < c.z && q.z < c.z && r.z < c.z);
}

/* 1 or -1 if the ray from c passes through the triangle, by the way it faces; 0 if it does not. */
static int crossing(const mesh *m, uint32_t t, vec3 c)
{
    const vec3 *at = m->corners + 3 * (size_t)t;
    double scale = 1 / m->unit; /* a power of two: exact */
    vec3 p = vec_scale(at[0], scale), q = vec_scale(at[1], scale), r = vec_scale(at[2], scale);
    if (is_beside(p, q, r, c) || m->triangles[t].form > MESH_SEAM) return 0;
    int side = side_of_line(p, q, c);
    if (side == 0 || side_of_line(q, r, c) != side || side_of_line(r, p, c) != side) return 0;
    return below_plane(p, q, r, c) == side ? side : 0;
}

static bool ray_meets(const mesh_node *n, int child, vec3 c)
{
    return n->lo[0][child] <= c.x && c.x <= n->hi[0][child] && n->lo[1][child] <= c.y && c.y <= n->hi[1][child] &&
           c.z <= n->hi[2][child];
}

bool mesh_inside(const mesh *m, vec3 point)
{
    uint32_t stack[MESH_WIDTH * MESH_DEPTH_MAX], open = 0;
    int winding = 0;
    vec3 c = vec_scale(point, 1 / m->unit);
    if (!m->solid) return false;
    stack[open++] = 0;
    while (open) {
        const mesh_node *n = &m->nodes[stack[--open]];
        for (int i = 0; i < n->used; i++) {
            if (!ray_meets(n, i, c)) continue;
            if (n->count[i] == 0) stack[open++] = n->first[i];
            for (uint32_t t = n->first[i]; t < n->first[i] + n->count[i]; t++) winding += crossing(m, t, c);
        }
    }
    return winding != 0;
}
