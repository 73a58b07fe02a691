/* epa: expanding polytope, from the simplex on which GJK ended to the bracketed depth. Pure but for its scratch.
 *
 * The surface is closed and oriented at all times: an expansion first finds what the new point sees (a flood over the
 * neighbours), checks that its horizon is one simple loop, and only then replaces it by a cone. What cannot be expanded
 * ends the search with the bracket that it has. */
#include "epa.h"

#include "narrow/curved/curved.h"
#include "narrow/math/scalar.h"

enum { NONE = UINT16_MAX, DOMES_MAX = 8, RAISES_MAX = 16 };

/* A triangle with a greater sine (squared) has a normal that is sure to 1e-10, so that its plane less the slack, in
 * units in which the pair is about 1 large, is never farther from the origin than it. */
#define SURE_SINE2 1e-8
#define PLANE_SLACK 1e-9

/* The quadratic bound is skipped for directions whose depth exceeds the best by this factor. */
static const double PROMISING = 1.1;
/* It is also skipped if the support point lies above the facet by more than this share of the size. */
static const double RIPE = 0.01;

typedef struct expansion {
    const unit_pair *p;
    epa_scratch *e;
    span *best;
    double eps;       /* a point that is no farther out than this is on the facet */
    epa_facet winner; /* whose nearest point gives the witnesses of best->lo; */
    support_hints hints;
    bool won;        /* false: they are those that the search began with */
    bool domed;      /* the witnesses are those of the last dome that lowered the depth, already in *best */
    bool curved;     /* domes may be raised */
    uint32_t raises; /* how often that was tried */
    int dome_count;
    dome dome[DOMES_MAX];
} expansion;

static vec3 vertex_at(const epa_scratch *e, uint16_t i)
{
    return e->vertex[i].w;
}

/* The support point along the unit direction `n` (from the origin outward); its height is an upper bound of the depth.
 * `facet`, if any, gives the witnesses. */
static minkowski epa_probe(expansion *x, vec3 n, const epa_facet *facet)
{
    minkowski m = unit_pair_nearest_from(x->p, vec_neg(n), &x->hints);
    double height = vec_dot(n, m.w);
    x->best->iterations++;
    if (-height > x->best->lo) {
        x->best->lo = -height;
        x->best->axis = vec_neg(n);
        if (facet) x->winner = *facet;
        x->won = x->won || facet;
        x->domed = false;
    }
    return m;
}

static void epa_write_witnesses(const expansion *x)
{
    simplex s = {.count = 3};
    if (!x->won || x->domed) return;
    for (int i = 0; i < 3; i++) {
        s.v[i] = x->e->vertex[x->winner.vertex[i]];
        s.weight[i] = x->winner.weight[i];
    }
    simplex_witness(&s, &x->best->point_a, &x->best->point_b);
}

static void epa_measure(epa_scratch *e, epa_facet *f)
{
    vec3 p0 = vertex_at(e, f->vertex[0]), p1 = vertex_at(e, f->vertex[1]), p2 = vertex_at(e, f->vertex[2]);
    f->measured = true;
    e->distance[f - e->facet] = triangle_nearest(p0, p1, p2, f->weight, &f->normal, &f->axis);
}

/* For most facets, which are never the nearest, the distance of their plane is enough; it is less than theirs. */
static void estimate(epa_scratch *e, epa_facet *f)
{
    vec3 p0 = vertex_at(e, f->vertex[0]), p1 = vertex_at(e, f->vertex[1]), p2 = vertex_at(e, f->vertex[2]);
    vec3 n = triangle_normal(p0, p1, p2);
    double norm2 = vec_norm2(n), edges2 = vec_norm2(vec_sub(p1, p0)) * vec_norm2(vec_sub(p2, p1));
    if (!(norm2 > SURE_SINE2 * edges2)) {
        epa_measure(e, f);
        return;
    }
    f->measured = false;
    f->normal = vec_scale(n, 1 / sqrt(norm2));
    e->distance[f - e->facet] = vec_dot(f->normal, p0) - PLANE_SLACK;
}

static uint16_t append_facet(epa_scratch *e)
{
    for (uint32_t k = 1; k < EPA_LANES; k++) e->distance[e->facet_count + k] = INFINITY;
    return (uint16_t)e->facet_count++;
}

static uint16_t add_facet(epa_scratch *e, uint16_t v0, uint16_t v1, uint16_t v2)
{
    uint16_t index = e->free_count ? e->free[--e->free_count] : append_facet(e);
    epa_facet *f = &e->facet[index];
    f->vertex[0] = v0, f->vertex[1] = v1, f->vertex[2] = v2;
    f->neighbour[0] = f->neighbour[1] = f->neighbour[2] = NONE;
    f->visit = 0;
    f->final = false;
    estimate(e, f);
    return index;
}

static int epa_edge_of(const epa_facet *f, uint16_t v0, uint16_t v1)
{
    for (int i = 0; i < 3; i++)
        if (f->vertex[i] == v0 && f->vertex[(i + 1) % 3] == v1) return i;
    return -1;
}

static void set_neighbours(epa_scratch *e, uint16_t facet, int n0, int n1, int n2)
{
    e->facet[facet].neighbour[0] = (uint16_t)n0;
    e->facet[facet].neighbour[1] = (uint16_t)n1;
    e->facet[facet].neighbour[2] = (uint16_t)n2;
}

static double height_over(const expansion *x, const epa_facet *f, vec3 w)
{
    return vec_dot(f->normal, vec_sub(w, vertex_at(x->e, f->vertex[0])));
}

static bool sees(const expansion *x, const epa_facet *f, vec3 w)
{
    return height_over(x, f, w) > x->eps;
}

/* Also removes a facet in whose plane `w` lies, if the new facet at the edge of `seen` would be folded over it. */
static bool sees_across(const expansion *x, const epa_facet *seen, int edge, const epa_facet *f, vec3 w)
{
    double height = height_over(x, f, w);
    if (!(fabs(height) <= x->eps)) return height > 0;
    vec3 p = vertex_at(x->e, seen->vertex[edge]), q = vertex_at(x->e, seen->vertex[(edge + 1) % 3]);
    return vec_dot(triangle_normal(p, q, w), f->normal) < 0;
}

/* Marks what `w` sees, starting at `seed`, by this round's number; their indices go to e->visible. */
static uint32_t flood(const expansion *x, uint16_t seed, vec3 w)
{
    epa_scratch *e = x->e;
    uint32_t count = 0;
    e->round++;
    e->facet[seed].visit = e->round;
    e->visible[count++] = seed;
    for (uint32_t next = 0; next < count; next++)
        for (int k = 0; k < 3; k++) {
            const epa_facet *seen = &e->facet[e->visible[next]];
            uint16_t j = seen->neighbour[k];
            if (e->facet[j].visit == e->round || !sees_across(x, seen, k, &e->facet[j], w)) continue;
            e->facet[j].visit = e->round;
            e->visible[count++] = j;
        }
    return count;
}

static bool on_horizon(const epa_scratch *e, const epa_facet *f, int edge)
{
    return e->facet[f->neighbour[edge]].visit != e->round;
}

/* The number of edges of the horizon; 0 when it is not one simple loop through distinct vertices. */
static uint32_t horizon_length(epa_scratch *e, uint32_t visible_count)
{
    uint32_t length = 0, start = NONE;
    for (uint32_t i = 0; i < visible_count; i++) {
        const epa_facet *f = &e->facet[e->visible[i]];
        for (int k = 0; k < 3; k++) {
            if (!on_horizon(e, f, k)) continue;
            uint16_t v = f->vertex[k];
            if (e->horizon_round[v] == e->round) return 0;
            e->horizon_round[v] = e->round;
            e->horizon[v] = f->vertex[(k + 1) % 3];
            start = v;
            length++;
        }
    }
    uint32_t walked = 0, v = start;
    do {
        if (v == NONE || e->horizon_round[v] != e->round) return 0;
        v = e->horizon[v];
        walked++;
    } while (v != start && walked <= length);
    return walked == length ? length : 0;
}

/* Replaces the facets that `m` sees by the cone from `m` over the horizon. Returns false if there is no memory for it,
 * or if the horizon is not a loop. */
static bool epa_expand(expansion *x, uint16_t seed, const minkowski *m)
{
    epa_scratch *e = x->e;
    uint32_t visible_count = flood(x, seed, m->w), length = horizon_length(e, visible_count);
    if (length == 0 || e->vertex_count == EPA_VERTICES_MAX) return false;
    if (e->facet_count - e->free_count + length > EPA_FACETS_MAX) return false;
    uint16_t apex = (uint16_t)e->vertex_count++, first = NONE;
    e->vertex[apex] = *m;
    e->horizon_round[apex] = 0;
    for (uint32_t i = 0; i < visible_count; i++) {
        for (int k = 0; k < 3; k++) {
            const epa_facet *f = &e->facet[e->visible[i]];
            if (!on_horizon(e, f, k)) continue;
            uint16_t v0 = f->vertex[k], v1 = f->vertex[(k + 1) % 3], outer = f->neighbour[k];
            uint16_t added = add_facet(e, v0, v1, apex);
            e->facet[added].neighbour[0] = outer;
            e->facet[outer].neighbour[epa_edge_of(&e->facet[outer], v1, v0)] = added;
            e->horizon[v0] = added;
            first = v0;
        }
    }
    uint16_t v = first;
    do { /* each new facet's second edge (v1, apex) meets the third edge (apex, v1) of the next */
        epa_facet *f = &e->facet[e->horizon[v]];
        uint16_t next = f->vertex[1];
        f->neighbour[1] = e->horizon[next];
        e->facet[e->horizon[next]].neighbour[2] = e->horizon[v];
        v = next;
    } while (v != first);
    for (uint32_t i = 0; i < visible_count; i++) {
        e->distance[e->visible[i]] = INFINITY;
        e->free[e->free_count++] = e->visible[i];
    }
    return true;
}

/* The point of B - A farthest from what there is so far, among those in `count` directions; false when none is farther
 * out than rounding, or when a direction already proves that there is no depth. */
static bool add_farthest(expansion *x, const vec3 *directions, int count, vec3 origin, vec3 along)
{
    epa_scratch *e = x->e;
    minkowski far = {.w = VEC_ZERO};
    double most = 0;
    for (int i = 0; i < count; i++) {
        minkowski m = epa_probe(x, directions[i], NULL);
        vec3 r = vec_sub(m.w, origin);
        double away = vec_norm(vec_madd(r, -vec_dot(r, along), along));
        if (away > most) most = away, far = m;
    }
    e->vertex[e->vertex_count++] = far;
    return most > x->eps && x->best->lo < -x->eps;
}

/* Extends a simplex of one point, at the origin within rounding, to two points, and one of two points to three. */
static bool grow_to_triangle(expansion *x)
{
    epa_scratch *e = x->e;
    if (e->vertex_count == 1) {
        const vec3 six[6] = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
        if (!add_farthest(x, six, 6, vertex_at(e, 0), VEC_ZERO)) return false;
    }
    if (e->vertex_count == 2) {
        vec3 along = direction_of(vec_sub(vertex_at(e, 1), vertex_at(e, 0))), u = vec_unit_orthogonal(along);
        vec3 v = vec_cross(along, u), four[4] = {u, vec_neg(u), v, vec_neg(v)};
        if (!add_farthest(x, four, 4, vertex_at(e, 0), along)) return false;
    }
    return true;
}

/* Both sides of a triangle through the origin; if B - A has no extent on one of them, the depth is zero. */
static bool start_bipyramid(expansion *x)
{
    epa_scratch *e = x->e;
    vec3 p0 = vertex_at(e, 0), n = direction_of(triangle_normal(p0, vertex_at(e, 1), vertex_at(e, 2)));
    if (!(vec_norm2(n) > 0)) return false;
    minkowski above = epa_probe(x, n, NULL), below = epa_probe(x, vec_neg(n), NULL);
    if (vec_dot(n, vec_sub(above.w, p0)) <= x->eps || vec_dot(n, vec_sub(p0, below.w)) <= x->eps) return false;
    e->vertex[3] = above;
    e->vertex[4] = below;
    e->vertex_count = 5;
    for (uint16_t i = 0; i < 3; i++) {
        uint16_t next = (uint16_t)((i + 1) % 3);
        add_facet(e, i, next, 3);
        add_facet(e, next, i, 4);
    }
    for (uint16_t i = 0; i < 3; i++) {
        int next = 2 * ((i + 1) % 3), last = 2 * ((i + 2) % 3);
        set_neighbours(e, (uint16_t)(2 * i), 2 * i + 1, next, last);
        set_neighbours(e, (uint16_t)(2 * i + 1), 2 * i, last + 1, next + 1);
    }
    return true;
}

static void epa_start_tetrahedron(epa_scratch *e)
{
    vec3 p0 = vertex_at(e, 0), n = vec_cross(vec_sub(vertex_at(e, 1), p0), vec_sub(vertex_at(e, 2), p0));
    uint16_t a = 0, b = 1; /* so that 2 and 3 see the facet a, b, . counter-clockwise from outside */
    if (vec_dot(n, vec_sub(vertex_at(e, 3), p0)) > 0) a = 1, b = 0;
    add_facet(e, a, b, 2);
    add_facet(e, b, a, 3);
    add_facet(e, b, 3, 2);
    add_facet(e, 3, a, 2);
    set_neighbours(e, 0, 1, 2, 3);
    set_neighbours(e, 1, 0, 3, 2);
    set_neighbours(e, 2, 1, 3, 0);
    set_neighbours(e, 3, 1, 0, 2);
}

/* A closed surface of points of B - A around the origin; false when it is flat there: no depth beyond rounding. */
static bool start_surface(expansion *x, const simplex *s)
{
    epa_scratch *e = x->e;
    e->vertex_count = e->facet_count = e->free_count = e->round = 0;
    for (int i = 0; i < s->count; i++) e->vertex[e->vertex_count++] = s->v[i];
    if (s->count == 4)
        epa_start_tetrahedron(e);
    else if (!grow_to_triangle(x) || !start_bipyramid(x))
        return false;
    for (uint32_t i = 0; i < e->vertex_count; i++) e->horizon_round[i] = 0;
    return true;
}

/* Distances to triangles have no sign: they bound the depth only while the origin is inside. It is in a tetrahedron
 * that GJK found it in, and, within rounding, in what was begun around a point that is as near to it as rounding can
 * tell. */
static bool encloses(const expansion *x, const gjk_result *start)
{
    const epa_scratch *e = x->e;
    if (start->state == GJK_INSIDE || start->span.hi <= 2 * x->eps) return true;
    for (uint32_t i = 0; i < e->facet_count; i++) {
        const uint16_t *v = e->facet[i].vertex;
        if (origin_volume(vertex_at(e, v[0]), vertex_at(e, v[1]), vertex_at(e, v[2])) < 0) return false;
    }
    return true;
}

/* The two least distances of all facets, by four columns side by side, which the compiler makes vectors of. */
typedef struct nearest_two {
    double least, second;
} nearest_two;

static nearest_two least_distances(const epa_scratch *e)
{
    double least[EPA_LANES] = {INFINITY, INFINITY, INFINITY, INFINITY};
    double second[EPA_LANES] = {INFINITY, INFINITY, INFINITY, INFINITY};
    for (uint32_t i = 0; i < e->facet_count; i += EPA_LANES)
        for (uint32_t k = 0; k < EPA_LANES; k++) {
            double distance = e->distance[i + k];
            second[k] = min_of(max_of(distance, least[k]), second[k]);
            least[k] = min_of(distance, least[k]);
        }
    nearest_two all = {least[0], second[0]};
    for (int k = 1; k < EPA_LANES; k++) {
        all.second = min_of(max_of(all.least, least[k]), min_of(all.second, second[k]));
        all.least = min_of(all.least, least[k]);
    }
    return all;
}

/* The first facet within rounding of the least distance that can still be expanded. */
static uint16_t first_within(const epa_scratch *e, double least)
{
    double limit = least + 4 * UNIT_ROUNDOFF;
    for (uint32_t i = 0; i < e->facet_count; i++)
        if (e->distance[i] <= limit && !e->facet[i].final) return (uint16_t)i;
    return NONE;
}

/* The nearest facet of those that can still be expanded; *least is the least distance of all. What was only estimated
 * is measured when it comes to be the nearest; so *least is a distance that was measured. */
static uint16_t nearest_facet(epa_scratch *e, double *least)
{
    for (;;) {
        nearest_two all = least_distances(e);
        uint16_t nearest = first_within(e, all.least);
        *least = all.least;
        if (nearest == NONE || e->facet[nearest].measured) return nearest;
        bool alone = e->distance[nearest] == all.least;
        epa_measure(e, &e->facet[nearest]);
        if (!alone || e->distance[nearest] > all.second) continue;
        *least = e->distance[nearest];
        return nearest;
    }
}

/* ---- domes (curved.h): where B - A is curved ---- */

/* A dome that is this close to the truth ends the search. */
static double epa_close_enough(const expansion *x, const narrow_goal *goal)
{
    double lo = x->best->lo, width = 0.5 * goal->tolerance;
    return max_of(narrow_goal_reached(goal, lo, lo + width) ? width : 0, x->p->error);
}

/* A facet that a dome covers is not nearer than the depth that the dome proves, or than the one found so far. */
static bool epa_settle_by(expansion *x, uint16_t index, const dome *d)
{
    epa_scratch *e = x->e;
    epa_facet *f = &e->facet[index];
    double depth = min_of(d->depth, -x->best->lo);
    vec3 nearest = vec_scale(f->axis, e->distance[index]);
    const vec3 w[3] = {vertex_at(e, f->vertex[0]), vertex_at(e, f->vertex[1]), vertex_at(e, f->vertex[2])};
    if (!(depth > e->distance[index]) || !dome_covers(d, w, nearest, depth, x->p->size)) return false;
    e->distance[index] = depth;
    f->final = true;
    return true;
}

static bool epa_settle(expansion *x, uint16_t index)
{
    for (int i = 0; i < x->dome_count; i++)
        if (epa_settle_by(x, index, &x->dome[i])) return true;
    return false;
}

static bool within_domes(const expansion *x, vec3 n)
{
    for (int i = 0; i < x->dome_count; i++)
        if (vec_dot(x->dome[i].direction, n) >= x->dome[i].cosine) return true;
    return false;
}

/* Tries a dome if `m`, the farthest point along the facet's normal, lies on known pieces. Returns true if a dome was
 * found and covers the facet. */
static bool epa_raise_over(expansion *x, uint16_t index, const minkowski *m, const narrow_goal *goal)
{
    const epa_facet *f = &x->e->facet[index];
    if (x->dome_count == DOMES_MAX || x->raises == RAISES_MAX || within_domes(x, f->normal)) return false;
    double height = vec_dot(f->normal, m->w), above = height - vec_dot(f->normal, vertex_at(x->e, f->vertex[0]));
    if (height > -PROMISING * x->best->lo || above > RIPE * x->p->size) return false;
    bundle pieces;
    pieces.count = 0;
    for (int i = 0; i < 3; i++) pieces_add(x->p, &pieces, &x->e->vertex[f->vertex[i]]);
    if (!pieces_know(x->p, &pieces, m)) return false;
    dome *d = &x->dome[x->dome_count];
    x->raises++;
    if (!dome_raise(x->p, &pieces, f->normal, epa_close_enough(x, goal), d)) return false;
    double before = x->best->lo;
    epa_probe(x, d->direction, f);
    if (d->depth < -x->best->lo - epa_close_enough(x, goal)) return false;
    if (x->best->lo > before) {
        x->best->point_a = d->point_a;
        x->best->point_b = d->point_b;
        x->domed = true;
    }
    x->dome_count++;
    return epa_settle_by(x, index, d);
}

/* Tries the facet's normal, then the direction of its nearest point (the better one for a sliver). */
static void epa_refine(expansion *x, uint16_t index, const narrow_goal *goal)
{
    const epa_facet f = x->e->facet[index];
    const vec3 directions[2] = {f.normal, f.axis};
    for (int i = 0; i < 2; i++) {
        if (!(vec_norm2(directions[i]) > 0) || (i == 1 && vec_equal(directions[0], directions[1]))) continue;
        minkowski m = epa_probe(x, directions[i], &f);
        if (i == 0 && x->curved && epa_raise_over(x, index, &m, goal)) return;
        if (sees(x, &f, m.w) && epa_expand(x, index, &m)) return;
    }
    x->e->facet[index].final = true;
}

void epa_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, epa_scratch *scratch, span *out)
{
    *out = start->span;
    out->method = NARROW_BY_EPA;
    expansion x;
    x.p = p;
    x.e = scratch;
    x.best = out;
    x.eps = 4 * UNIT_ROUNDOFF * p->size;
    x.won = x.domed = false;
    x.curved = pieces_apply(p);
    x.raises = 0;
    x.dome_count = 0;
    x.hints = NO_HINTS;
    if (!start_surface(&x, &start->simplex) || !encloses(&x, start)) return;
    /* a bound once proved stays proved; when rounding has begun to fold the surface there is nothing more to gain */
    double least = 0, proved = 0;
    const int64_t price = EFFORT_FACET + unit_pair_support_price(p);
    for (;;) {
        uint16_t f = nearest_facet(scratch, &least);
        if (least < proved - x.eps && x.dome_count == 0) break;
        proved = max_of(proved, least);
        if (-out->lo - proved <= p->error || narrow_goal_reached(goal, out->lo, -proved) || f == NONE) break;
        if (p->effort && !effort_spend(p->effort, price)) break;
        if (!epa_settle(&x, f)) epa_refine(&x, f, goal);
    }
    out->hi = max_of(out->lo, min_of(out->hi, -proved));
    epa_write_witnesses(&x);
}
