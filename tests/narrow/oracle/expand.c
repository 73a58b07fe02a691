/* expand: an inner polytope of W, grown at its facet nearest to the origin until no other can be nearer.
 *
 * Facets are kept in one list, and each step looks at all of them: which are visible from the new point is found
 * without following neighbours, so a wrong neighbour cannot exist. The origin need not be inside at the start: facets
 * that it is outside of have a negative offset and are grown first. */
#include "expand.h"

#include "body.h"

enum { FACETS_MAX = 4 * EXPAND_STEPS_MAX, POINTS_MAX = EXPAND_STEPS_MAX + 4 };

typedef struct facet {
    int v[3]; /* counter-clockwise seen from outside */
    qvec normal;
    quad offset; /* distance of its plane from the origin, negative when the origin is outside */
    bool visible;
} facet;

typedef struct inner {
    qvec points[POINTS_MAX];
    int point_count;
    facet facets[FACETS_MAX];
    int facet_count;
    quad tolerance; /* nearer to a plane than this is on it */
    quad enough;    /* bounds closer than this end the search */
} inner;

static void add_facet(inner *p, int i, int j, int k)
{
    facet f = {.v = {i, j, k}};
    qvec a = p->points[i];
    f.normal = q_unit(q_cross(q_sub(p->points[j], a), q_sub(p->points[k], a)));
    f.offset = q_dot(f.normal, a);
    p->facets[p->facet_count++] = f;
}

/* Of the lowest points along d and -d, the one farther from the plane (or the line, or the point) that has height 0. */
static qvec farther(const oracle_body *a, const oracle_body *b, expand_lowest *lowest, qvec d, qvec origin)
{
    qvec low = lowest(a, b, d), high = lowest(a, b, q_neg(d));
    return q_abs(q_dot(d, q_sub(low, origin))) > q_abs(q_dot(d, q_sub(high, origin))) ? low : high;
}

static qvec across(qvec d) /* some unit vector orthogonal to d */
{
    quad x = q_abs(d.x), y = q_abs(d.y), z = q_abs(d.z);
    qvec least = x <= y && x <= z ? qv(1, 0, 0) : y <= z ? qv(0, 1, 0) : qv(0, 0, 1);
    return q_unit(q_cross(d, least));
}

static qvec off_line(const oracle_body *a, const oracle_body *b, expand_lowest *lowest, const qvec *w)
{
    qvec along = q_unit(q_sub(w[1], w[0])), side = across(along);
    qvec first = farther(a, b, lowest, side, w[0]);
    qvec second = farther(a, b, lowest, q_cross(along, side), w[0]);
    quad reach_first = q_norm(q_cross(along, q_sub(first, w[0])));
    return reach_first > q_norm(q_cross(along, q_sub(second, w[0]))) ? first : second;
}

static bool start(inner *p, const oracle_body *a, const oracle_body *b, expand_lowest *lowest)
{
    qvec *w = p->points;
    const qvec axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (int i = 0; i < 3; i++) { /* the axis along which W is longest */
        qvec low = lowest(a, b, axes[i]), high = lowest(a, b, q_neg(axes[i]));
        if (i == 0 || q_norm(q_sub(high, low)) > q_norm(q_sub(w[1], w[0]))) w[0] = low, w[1] = high;
    }
    if (q_norm(q_sub(w[1], w[0])) <= p->tolerance) return false;
    w[2] = off_line(a, b, lowest, w);
    qvec n = q_unit(q_cross(q_sub(w[1], w[0]), q_sub(w[2], w[0])));
    w[3] = farther(a, b, lowest, n, w[0]);
    quad height = q_dot(n, q_sub(w[3], w[0]));
    if (q_norm(q_cross(q_unit(q_sub(w[1], w[0])), q_sub(w[2], w[0]))) <= p->tolerance) return false;
    if (q_abs(height) <= p->tolerance) return false;
    int j = height < 0 ? 1 : 2, k = height < 0 ? 2 : 1; /* outward: away from w[3] */
    p->point_count = 4;
    add_facet(p, 0, j, k);
    add_facet(p, 0, k, 3);
    add_facet(p, k, j, 3);
    add_facet(p, j, 0, 3);
    return true;
}

static const facet *nearest_facet(const inner *p)
{
    const facet *best = &p->facets[0];
    for (int i = 1; i < p->facet_count; i++)
        if (p->facets[i].offset < best->offset) best = &p->facets[i];
    return best;
}

/* Is the edge i -> j of a visible facet on the horizon: no visible facet has it the other way round? */
static bool on_horizon(const inner *p, int visible_count, int i, int j)
{
    for (int f = 0; f < visible_count; f++)
        for (int e = 0; e < 3; e++)
            if (p->facets[f].v[e] == j && p->facets[f].v[(e + 1) % 3] == i) return false;
    return true;
}

static int visible_first(inner *p, qvec w)
{
    int count = 0;
    for (int i = 0; i < p->facet_count; i++) {
        if (q_dot(p->facets[i].normal, w) - p->facets[i].offset <= p->tolerance) continue;
        facet swap = p->facets[count];
        p->facets[count++] = p->facets[i];
        p->facets[i] = swap;
    }
    return count;
}

/* Replaces the facets that see w by a cone from their horizon to w. false: no room. */
static bool grow(inner *p, qvec w)
{
    int visible = visible_first(p, w), apex = p->point_count, old_count = p->facet_count;
    if (apex == POINTS_MAX || old_count + visible + 2 > FACETS_MAX) return false;
    p->points[p->point_count++] = w;
    for (int f = 0; f < visible; f++)
        for (int e = 0; e < 3; e++) {
            int i = p->facets[f].v[e], j = p->facets[f].v[(e + 1) % 3];
            if (p->facet_count < FACETS_MAX && on_horizon(p, visible, i, j)) add_facet(p, i, j, apex);
        }
    for (int f = visible - 1; f >= 0; f--) p->facets[f] = p->facets[--p->facet_count];
    return true;
}

static void expand(inner *p, const oracle_body *a, const oracle_body *b, expand_lowest *lowest, int steps, quad *lo,
    quad *hi, qvec *axis)
{
    *hi = INFINITY;
    for (int step = 0; step < steps; step++) {
        const facet *f = nearest_facet(p);
        qvec n = f->normal, w = lowest(a, b, q_neg(n));
        quad outer = q_dot(n, w);
        *lo = f->offset;
        if (outer < *hi) {
            *hi = outer;
            *axis = q_neg(n);
        }
        if (*hi - *lo <= p->enough || *hi < 0 || !grow(p, w)) return;
    }
}

bool expand_depth(
    const oracle_body *a, const oracle_body *b, expand_lowest *lowest, int steps, quad *lo, quad *hi, qvec *axis)
{
    inner *p = body_allocate(1, sizeof *p);
    p->tolerance = (quad)1e-22 * oracle_size(a, b);
    p->enough = (quad)1e-20 * oracle_size(a, b);
    bool solid = start(p, a, b, lowest);
    if (solid) expand(p, a, b, lowest, steps, lo, hi, axis);
    free(p);
    return solid;
}
