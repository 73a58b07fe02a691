/* solid_tree: a tree of boxes, split at the median of the longest side, and the questions that walk it. */
#include "solid_tree.h"

#include "vec3.h"

#include <stdlib.h>

enum { LEAF = 4, DEPTH_MAX = 64 };

typedef struct building {
    solid *s;
    uint32_t node_count;
} building;

static double centre(const solid_triangle *t, int k)
{
    return t->at[0][k] + t->at[1][k] + t->at[2][k];
}

static int by_centre(const void *left, const void *right, void *axis)
{
    int k = *(const int *)axis;
    double a = centre(left, k), b = centre(right, k);
    return a != b ? (a < b ? -1 : 1) : memcmp(left, right, sizeof((const solid_triangle *)left)->at);
}

static uint32_t build(building *b, uint32_t first, uint32_t count)
{
    uint32_t index = b->node_count++;
    solid_node *n = &b->s->nodes[index];
    solid_triangle *t = b->s->triangles + first;
    box_empty(n->lo, n->hi);
    for (uint32_t i = 0; i < count; i++)
        for (int k = 0; k < 3; k++) box_add(n->lo, n->hi, t[i].at[k]);
    n->first = first;
    n->count = count;
    if (count <= LEAF) return index;
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (n->hi[k] - n->lo[k] > n->hi[axis] - n->lo[axis]) axis = k;
    qsort_r(t, count, sizeof *t, by_centre, &axis);
    n->count = 0;
    build(b, first, count / 2);
    n->right = build(b, first + count / 2, count - count / 2);
    return index;
}

void solid_tree_make(pool *p, solid *s)
{
    s->nodes = pool_alloc(p, 2 * s->count + 1, sizeof *s->nodes);
    building b = {s, 0};
    build(&b, 0, (uint32_t)s->count);
}

/* ---- the nearest triangle ---- */

static double box_distance2(const solid_node *n, const double x[3])
{
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double below = n->lo[k] - x[k], above = x[k] - n->hi[k], d = below > above ? below : above;
        sum += d > 0 ? d * d : 0;
    }
    return sum;
}

static double nearest_on_segment(const double a[3], const double b[3], const double x[3], double out[3])
{
    double ab[3], ax[3];
    sub3(b, a, ab);
    sub3(x, a, ax);
    double length2 = dot3(ab, ab), t = length2 > 0 ? dot3(ax, ab) / length2 : 0;
    along3(a, t < 0 ? 0 : t > 1 ? 1 : t, ab, out);
    return distance3(x, out);
}

/* The foot of x on the plane if it is inside of the triangle; otherwise it is on an edge. Each candidate is a point of
 * the triangle, so that the distance is never too small by more than rounding. */
static double nearest_on_triangle(const solid_triangle *t, const double x[3], double out[3])
{
    double u[3], v[3], w[3], n[3], c[3], near[3];
    sub3(t->at[1], t->at[0], u);
    sub3(t->at[2], t->at[0], v);
    sub3(x, t->at[0], w);
    cross3(u, v, n);
    double n2 = dot3(n, n);
    cross3(w, v, c);
    double s = dot3(c, n);
    cross3(u, w, c);
    double r = dot3(c, n);
    if (n2 > 0 && s >= 0 && r >= 0 && s + r <= n2) {
        along3(t->at[0], s / n2, u, out);
        along3(out, r / n2, v, out);
        return distance3(x, out);
    }
    double best = INFINITY;
    for (int k = 0; k < 3; k++) {
        double d = nearest_on_segment(t->at[k], t->at[(k + 1) % 3], x, near);
        if (d >= best) continue;
        best = d;
        memcpy(out, near, sizeof near);
    }
    return best;
}

double solid_nearest(const solid *s, const double x[3], double nearest[3])
{
    uint32_t stack[DEPTH_MAX];
    int depth = 0;
    double best = INFINITY, point[3];
    stack[depth++] = 0;
    while (depth > 0) {
        const solid_node *n = &s->nodes[stack[--depth]];
        if (best < INFINITY && box_distance2(n, x) >= best * best) continue;
        for (uint32_t i = n->first; i < n->first + n->count; i++) {
            double d = nearest_on_triangle(&s->triangles[i], x, point);
            if (d >= best) continue;
            best = d;
            memcpy(nearest, point, sizeof point);
        }
        if (n->count > 0) continue;
        uint32_t left = (uint32_t)(n - s->nodes) + 1, right = n->right;
        bool left_first = box_distance2(&s->nodes[left], x) <= box_distance2(&s->nodes[right], x);
        stack[depth++] = left_first ? right : left;
        stack[depth++] = left_first ? left : right;
    }
    return best;
}

int solid_within(const solid *s, const double x[3], double radius, const solid_triangle **out, int most)
{
    uint32_t stack[DEPTH_MAX];
    int depth = 0, found = 0;
    double point[3];
    stack[depth++] = 0;
    while (depth > 0) {
        const solid_node *n = &s->nodes[stack[--depth]];
        if (box_distance2(n, x) > radius * radius) continue;
        for (uint32_t i = n->first; i < n->first + n->count; i++) {
            if (nearest_on_triangle(&s->triangles[i], x, point) > radius) continue;
            if (found == most) return -1;
            out[found++] = &s->triangles[i];
        }
        if (n->count > 0) continue;
        stack[depth++] = n->right;
        stack[depth++] = (uint32_t)(n - s->nodes) + 1;
    }
    return found;
}

/* ---- inside or outside ---- */

/* How often the triangle, seen along z, winds around x: -1, 0 or 1. Each edge is judged from its lower end to its upper
 * one, so that both triangles at it judge alike: whatever rounding does, it does not open the surface. */
static int winds_around(const solid_triangle *t, const double x[3])
{
    int winds = 0;
    for (int k = 0; k < 3; k++) {
        const double *from = t->at[k], *to = t->at[(k + 1) % 3];
        bool above = from[1] > x[1], rises = to[1] > x[1];
        if (above == rises) continue;
        const double *low = rises ? from : to, *high = rises ? to : from;
        double left = (high[0] - low[0]) * (x[1] - low[1]) - (high[1] - low[1]) * (x[0] - low[0]);
        if (left > 0) winds += rises ? 1 : -1;
    }
    return winds;
}

/* Where is the triangle that winds around x: 1 above, -1 below, 0 unsure. The filter of Shewchuk's orient3d. */
static int height_of(const solid_triangle *t, const double x[3], int winds)
{
    double lo = fmin(t->at[0][2], fmin(t->at[1][2], t->at[2][2])),
           hi = fmax(t->at[0][2], fmax(t->at[1][2], t->at[2][2]));
    if (lo > x[2]) return 1;
    if (hi < x[2]) return -1;
    double d[3][3], det = 0, sum = 0;
    for (int k = 0; k < 3; k++) sub3(t->at[k], x, d[k]);
    for (int k = 0; k < 3; k++) {
        const double *b = d[(k + 1) % 3], *c = d[(k + 2) % 3];
        double first = b[0] * c[1], second = b[1] * c[0];
        det += d[k][2] * (first - second);
        sum += fabs(d[k][2]) * (fabs(first) + fabs(second));
    }
    if (!(fabs(det) > 0x1p-49 * sum)) return 0;
    return (det > 0) == (winds > 0) ? 1 : -1;
}

int solid_side(const solid *s, const double x[3])
{
    uint32_t stack[DEPTH_MAX];
    int depth = 0, around = 0;
    double wide = 0x1p-40 * s->most; /* an edge's rounding must reach both of its triangles */
    stack[depth++] = 0;
    while (depth > 0) {
        const solid_node *n = &s->nodes[stack[--depth]];
        if (x[0] < n->lo[0] - wide || x[0] > n->hi[0] + wide || x[1] < n->lo[1] || x[1] > n->hi[1] || x[2] > n->hi[2])
            continue;
        for (uint32_t i = n->first; i < n->first + n->count; i++) {
            int winds = winds_around(&s->triangles[i], x);
            int height = winds ? height_of(&s->triangles[i], x, winds) : -1;
            if (height == 0) return SOLID_UNSURE;
            if (height > 0) around += winds;
        }
        if (n->count > 0) continue;
        stack[depth++] = n->right;
        stack[depth++] = (uint32_t)(n - s->nodes) + 1;
    }
    return around != 0 ? SOLID_INSIDE : SOLID_OUTSIDE;
}
