/* polytope_depth: the search over a surface (surface.h). Pure; any thread. About 20 kB on the stack. */
#include "polytope_depth.h"

#include "surface.h"

typedef struct search {
    const unit_pair *p;
    surface *s;
    span *best;
    double eps;    /* a point that is no farther out than this is on the facet */
    double proved; /* the least distance of all facets that are final */
    int winner;    /* the final facet with that distance, or NONE */
    double weight[3];
    uint8_t winner_corner[3];
    support_hints hints;
} search;

bool polytope_depth_applies(const unit_pair *p)
{
    bool flat_a = p->a.type <= SHAPE_BOX || p->a.type == SHAPE_HULL;
    return flat_a && (p->b.type <= SHAPE_BOX || p->b.type == SHAPE_HULL);
}

/* ---- search ---- */

static void close_facet(search *x, int f)
{
    double weight[3], distance = measure(x->s, f, weight);
    x->s->bound[f] = INFINITY;
    if (x->winner != NONE && distance >= x->proved) return;
    x->proved = distance;
    x->winner = f;
    for (int i = 0; i < 3; i++) x->weight[i] = weight[i], x->winner_corner[i] = x->s->corner[f][i];
}

/* The support point along the facet's normal: its height is an upper bound of the depth, and it is a new point of the
 * surface, unless the facet is one of the polytopes' difference. */
LANES_INLINE bool refine(search *x, int f)
{
    surface *s = x->s;
    vec3 n = vec(s->nx[f], s->ny[f], s->nz[f]), axis = vec_neg(n);
    minkowski *m = &s->point[s->point_count];
    *m = unit_pair_nearest_from(x->p, axis, &x->hints);
    double height = vec_dot(n, m->w);
    x->best->iterations++;
    if (-height > x->best->lo) x->best->lo = -height, x->best->axis = axis;
    if (height - s->offset[f] > x->eps) return expand(s, x->eps);
    close_facet(x, f);
    return true;
}

static void write_witnesses(const search *x)
{
    simplex s = {.count = 3};
    for (int i = 0; i < 3; i++) {
        s.v[i] = x->s->point[x->winner_corner[i]];
        s.weight[i] = x->weight[i];
    }
    simplex_witness(&s, &x->best->point_a, &x->best->point_b);
}

/* False when the surface cannot be grown any more. *least: what all facets are away from the origin. */
LANES_INLINE bool run(search *x, const narrow_goal *goal, double *least)
{
    for (;;) {
        surface *s = x->s;
        double bound = least_bound(s);
        *least = min_of(bound, x->winner == NONE ? INFINITY : x->proved);
        double height = -x->best->lo;
        if (height - *least <= x->p->error || narrow_goal_reached(goal, x->best->lo, -*least)) return true;
        if (bound == INFINITY) return true;
        int f = nearest_of(s, bound);
        bool estimated = bound == s->offset[f] - PLANE_SLACK;
        if (estimated && s->offset[f] > height - PLANE_SLACK && x->winner != NONE) {
            double weight[3];
            s->bound[f] = measure(s, f, weight);
        } else if (!refine(x, f)) {
            return false;
        }
    }
}

LANES_INLINE bool search_from(search *x, const narrow_goal *goal, const simplex *from, double *least)
{
    return start_tetrahedron(x->s, from) && run(x, goal, least);
}

LANES_WIDE static bool search_wide(search *x, const narrow_goal *goal, const simplex *from, double *least)
{
    return search_from(x, goal, from, least);
}

static bool search_narrow(search *x, const narrow_goal *goal, const simplex *from, double *least)
{
    return search_from(x, goal, from, least);
}

bool polytope_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    surface s;
    search x = {.p = p, .s = &s, .best = out, .eps = 4 * UNIT_ROUNDOFF * p->size, .winner = NONE, .hints = NO_HINTS};
    const span before = *out;
    double least;
    if (start->simplex.count < 4 || start->state != GJK_INSIDE) return false;
    bool found = (wide ? search_wide : search_narrow)(&x, goal, &start->simplex, &least);
    if (!found || x.winner == NONE) {
        uint32_t iterations = out->iterations;
        *out = before;
        out->iterations = iterations;
        return false;
    }
    out->method = NARROW_BY_EPA;
    out->hi = max_of(out->lo, min_of(out->hi, -least));
    write_witnesses(&x);
    return true;
}

bool polytope_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    return polytope_depth_by(lanes_wide(), p, goal, start, out);
}
