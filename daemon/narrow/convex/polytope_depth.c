/* polytope_depth: the search over a surface (surface.h). Pure; any thread. About 20 kB on the stack. */
#include "polytope_depth.h"

#include "features.h"
#include "surface.h"

#include <string.h>

enum { CLOSED_MAX = 8, BOX_CORNERS = 8 };

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
    uint8_t closed[CLOSED_MAX][3]; /* corners of the final facets: see facets_are_in */
    double closed_at[CLOSED_MAX];  /* their distances */
    int closed_count;              /* CLOSED_MAX + 1: more than that */
} search;

bool polytope_depth_applies(const unit_pair *p)
{
    bool flat_a = p->a.type <= SHAPE_BOX || p->a.type == SHAPE_HULL;
    return flat_a && (p->b.type <= SHAPE_BOX || p->b.type == SHAPE_HULL);
}

/* ---- search ---- */

static void note_closed(search *x, int f, double distance)
{
    if (x->closed_count < CLOSED_MAX) {
        for (int i = 0; i < 3; i++) x->closed[x->closed_count][i] = x->s->corner[f][i];
        x->closed_at[x->closed_count] = distance;
    }
    if (x->closed_count <= CLOSED_MAX) x->closed_count++;
}

static void polytope_close_facet(search *x, int f)
{
    double weight[3], distance = measure(x->s, f, weight);
    x->s->bound[f] = INFINITY;
    note_closed(x, f, distance);
    if (x->winner != NONE && distance >= x->proved) return;
    x->proved = distance;
    x->winner = f;
    for (int i = 0; i < 3; i++) x->weight[i] = weight[i], x->winner_corner[i] = x->s->corner[f][i];
}

/* The support point along the facet's normal: its height is an upper bound of the depth, and it is a new point of the
 * surface, unless the facet is one of the polytopes' difference. */
LANES_INLINE bool polytope_refine(search *x, int f)
{
    surface *s = x->s;
    vec3 n = vec(s->nx[f], s->ny[f], s->nz[f]), axis = vec_neg(n);
    minkowski *m = &s->point[s->point_count];
    unit_pair_nearest_to(x->p, axis, &x->hints, m);
    double height = vec_dot(n, m->w);
    x->best->iterations++;
    if (-height > x->best->lo) x->best->lo = -height, x->best->axis = axis;
    if (height - s->offset[f] > x->eps) return expand(s, x->eps);
    polytope_close_facet(x, f);
    return true;
}

static void polytope_write_witnesses(const search *x)
{
    const minkowski *m[3];
    vec3 a = VEC_ZERO, b = VEC_ZERO;
    for (int i = 0; i < 3; i++) {
        m[i] = &x->s->point[x->winner_corner[i]];
        a = vec_madd(a, x->weight[i], m[i]->a);
        b = vec_madd(b, x->weight[i], m[i]->b);
    }
    x->best->point_a = a;
    x->best->point_b = b;
    if (x->p->a.type >= SHAPE_BOX && x->p->b.type == SHAPE_HULL) hull_features_of_facet(x->p, m, &x->best->nearest);
}

/* ---- the surface, remembered ---- */

/* The facets that live, over the points that they have. */
static void save(const surface *s, narrow_shell *to)
{
    uint8_t place[POINTS_MAX];
    int points = 0, facets = 0;
    memset(place, UINT8_MAX, sizeof place);
    for (int f = 0; f < s->facet_count; f++) {
        if (s->offset[f] == INFINITY) continue;
        for (int k = 0; k < 3; k++) {
            uint8_t i = s->corner[f][k];
            if (place[i] == UINT8_MAX) {
                to->vertex_a[points] = (uint16_t)s->point[i].vertex_a;
                to->vertex_b[points] = (uint16_t)s->point[i].vertex_b;
                place[i] = (uint8_t)points++;
            }
            to->corner[k][facets] = place[i];
        }
        facets++;
    }
    to->point_count = (uint8_t)points;
    to->facet_count = (uint8_t)facets;
    for (; facets % LANES; facets++)
        for (int k = 0; k < 3; k++) to->corner[k][facets] = to->corner[k][0];
}

static bool load_points(const unit_pair *p, const narrow_shell *from, surface *s)
{
    uint32_t count_a = p->a.type == SHAPE_BOX ? BOX_CORNERS : p->a.hull->vertex_count;
    s->point_count = from->point_count;
    if (s->point_count < 4 || s->point_count >= POINTS_MAX) return false;
    for (int i = 0; i < s->point_count; i++) {
        if (from->vertex_a[i] >= count_a || from->vertex_b[i] >= p->b.hull->vertex_count) return false;
        s->point[i] = hull_pair_of(p, from->vertex_a[i], from->vertex_b[i]);
    }
    return true;
}

/* Four facets with their planes. -1 in the lanes of those that are no slivers and have the origin on their inner side.
 */
LANES_INLINE lane_mask load_four(const narrow_shell *from, surface *s, int i)
{
    planes planes;
    four_planes(
        gather(s, from->corner[0] + i), gather(s, from->corner[1] + i), gather(s, from->corner[2] + i), 0, &planes);
    lanes offset = lanes_load(planes.offset);
    lanes_store(s->nx + i, lanes_load(planes.nx));
    lanes_store(s->ny + i, lanes_load(planes.ny));
    lanes_store(s->nz + i, lanes_load(planes.nz));
    lanes_store(s->offset + i, offset);
    lanes_store(s->bound + i, offset - lanes_of(PLANE_SLACK));
    lane_mask sure;
    memcpy(&sure, planes.sure, sizeof sure);
    return sure & (offset > lanes_of(0));
}

/* Their planes alone: see link_facets. The shell is filled up to a multiple of LANES with a facet that there is. */
LANES_INLINE bool load_facets(const narrow_shell *from, surface *s)
{
    lane_mask good = ~(lane_mask){0, 0, 0, 0};
    int count = from->facet_count;
    s->star = true;
    s->facet_count = count;
    if (count < 4 || count > FACETS_MAX) return false;
    clear_block(s, (count - 1) / BLOCK * BLOCK);
    for (int i = 0; i < count; i += LANES) good &= load_four(from, s, i);
    for (int i = count; i % LANES; i++) {
        s->nx[i] = s->ny[i] = s->nz[i] = 0;
        s->offset[i] = s->bound[i] = INFINITY;
    }
    return lanes_bits(good) == 15;
}

/* What is only of use to a surface that grows. */
static void link_facets(const narrow_shell *from, surface *s)
{
    for (int f = 0; f < s->facet_count; f++) {
        uint8_t u = from->corner[0][f], v = from->corner[1][f], w = from->corner[2][f];
        s->corner[f][0] = u, s->corner[f][1] = v, s->corner[f][2] = w;
        s->left_of[u][v] = s->left_of[v][w] = s->left_of[w][u] = (uint8_t)f;
    }
}

static bool is_one_of(uint32_t vertex, const uint16_t *set, uint8_t count)
{
    for (uint8_t i = 0; i < count; i++)
        if (set[i] == vertex) return true;
    return false;
}

static bool is_on_sides(uint32_t corner, const uint16_t side[3])
{
    for (int k = 0; k < 3; k++)
        if (side[k] == (corner >> k & 1 ? NEAR_LOW : NEAR_HIGH)) return false;
    return true;
}

static bool point_is_in(const unit_pair *p, const minkowski *m, const narrow_features *f)
{
    bool in = p->a.type == SHAPE_BOX ? is_on_sides(m->vertex_a, f->a) : is_one_of(m->vertex_a, f->a, f->count_a);
    return in && is_one_of(m->vertex_b, f->b, f->count_b);
}

static bool polytope_is_in(const unit_pair *p, const surface *s, const uint8_t corner[3], const narrow_features *f)
{
    for (int k = 0; k < 3; k++)
        if (!point_is_in(p, &s->point[corner[k]], f)) return false;
    return true;
}

/* The facets in F's plane are as near as F: nothing more is to be known of them. */
static void set_aside(const unit_pair *p, surface *s, const narrow_features *f)
{
    const narrow_shell *from = p->shell;
    uint64_t in = 0;
    for (int i = 0; i < s->point_count; i++) in |= (uint64_t)point_is_in(p, &s->point[i], f) << i;
    for (int i = 0; i < s->facet_count; i++)
        if (in >> from->corner[0][i] & in >> from->corner[1][i] & in >> from->corner[2][i] & 1) s->bound[i] = INFINITY;
}

/* Are the final facets that are not farther than this all in F's plane? */
static bool facets_are_in(const search *x, const narrow_features *f, double within)
{
    if (x->closed_count > CLOSED_MAX) return false;
    for (int i = 0; i < x->closed_count; i++)
        if (!(x->closed_at[i] >= within) && !polytope_is_in(x->p, x->s, x->closed[i], f)) return false;
    return true;
}

/* Until all facets are at least so much farther than the winner. *grown: by one or more. */
LANES_INLINE bool grow(search *x, double margin, bool *grown)
{
    for (bool linked = false;; linked = true) {
        double bound = least_bound(x->s);
        if (x->winner != NONE && bound >= x->proved + margin) return true;
        if (bound == INFINITY) return x->winner != NONE;
        if (!linked) link_facets(x->p->shell, x->s);
        if (!polytope_refine(x, nearest_of(x->s, bound))) return false;
        *grown = true;
    }
}

/* The facet's distance from the origin, which its formula puts in the middle. */
static double polytope_depth_of(const span *s)
{
    return -0.5 * (s->lo + s->hi);
}

/* F is `nearest`, or what grows to be the nearest facet. */
LANES_INLINE bool search_again(search *x, const narrow_goal *goal, const narrow_features *nearest, span *out)
{
    const unit_pair *p = x->p;
    double margin = NEAR_DEPTH_MARGIN * p->size;
    narrow_features f = *nearest;
    bool grown = false;
    if (!load_points(p, p->shell, x->s) || !load_facets(p->shell, x->s)) return false;
    bool same = near_features_span(p, goal, &f, out);
    if (same) {
        set_aside(p, x->s, &f);
        x->winner = 0, x->proved = polytope_depth_of(out);
    }
    if (!grow(x, margin, &grown)) return false;
    if (!same) {
        polytope_write_witnesses(x);
        f = x->best->nearest;
        f.deep = true;
        if (!near_features_span(p, goal, &f, out) || !(x->proved >= polytope_depth_of(out) - p->error)) return false;
    }
    if (!facets_are_in(x, &f, margin + polytope_depth_of(out))) return false;
    if (grown) save(x->s, p->shell);
    return true;
}

LANES_TWINS(LANES_WIDE, bool, search_again, search_again,
    (search *const x, const narrow_goal *goal, const narrow_features *nearest, span *out), (x, goal, nearest, out));

bool polytope_depth_again(const unit_pair *p, const narrow_goal *goal, const narrow_features *nearest, span *out)
{
    surface s;
    span grown = {.lo = -INFINITY}; /* what growing finds is of use if the facet is another one */
    search x = {.p = p, .s = &s, .best = &grown, .eps = 4 * UNIT_ROUNDOFF * p->size, .winner = NONE, .hints = NO_HINTS};
    if (!p->shell || !nearest->deep || !near_features_reach_depths(p, goal)) return false;
    return LANES_CHOSEN(search_again)(&x, goal, nearest, out);
}

/* ---- from nothing ---- */

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
        } else if (!polytope_refine(x, f)) {
            return false;
        }
    }
}

LANES_INLINE bool polytope_search_from(search *x, const narrow_goal *goal, const simplex *from, double *least)
{
    return start_tetrahedron(x->s, from) && run(x, goal, least);
}

LANES_TWINS(LANES_WIDE, bool, polytope_search, polytope_search_from,
    (search *const x, const narrow_goal *goal, const simplex *from, double *least), (x, goal, from, least));

/* The answer of a search that has ended well. */
static void polytope_report(search *x, double least)
{
    span *out = x->best;
    out->method = NARROW_BY_EPA;
    out->hi = max_of(out->lo, min_of(out->hi, -least));
    polytope_write_witnesses(x);
    if (x->p->shell) save(x->s, x->p->shell);
}

bool polytope_depth_by(bool wide, const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    surface s;
    search x = {.p = p, .s = &s, .best = out, .eps = 4 * UNIT_ROUNDOFF * p->size, .winner = NONE, .hints = NO_HINTS};
    const span before = *out;
    double least;
    if (start->simplex.count < 4 || start->state != GJK_INSIDE) return false;
    bool found = (wide ? polytope_search_wide : polytope_search_narrow)(&x, goal, &start->simplex, &least);
    if (!found || x.winner == NONE) {
        uint32_t iterations = out->iterations;
        *out = before;
        out->iterations = iterations;
        return false;
    }
    polytope_report(&x, least);
    return true;
}

bool polytope_depth(const unit_pair *p, const narrow_goal *goal, const gjk_result *start, span *out)
{
    return polytope_depth_by(lanes_wide(), p, goal, start, out);
}

/* ---- from four corners ---- */

/* Of points that turn like x, y, z seen from the first. */
static const narrow_shell TETRAHEDRON = {
    .point_count = 4, .facet_count = 4, .corner = {{1, 0, 0, 0}, {2, 2, 1, 3}, {3, 1, 3, 2}}};

LANES_INLINE bool polytope_search_corners(search *x, const narrow_goal *goal, double *least)
{
    if (!load_facets(&TETRAHEDRON, x->s)) return false;
    link_facets(&TETRAHEDRON, x->s);
    return run(x, goal, least) && x->winner != NONE;
}

LANES_TWINS(LANES_WIDE, bool, search_corners, polytope_search_corners,
    (search *const x, const narrow_goal *goal, double *least), (x, goal, least));

bool polytope_depth_from(const unit_pair *p, const narrow_goal *goal, const hull_corners *holds, span *out)
{
    surface s;
    search x = {.p = p, .s = &s, .best = out, .eps = 4 * UNIT_ROUNDOFF * p->size, .winner = NONE, .hints = NO_HINTS};
    double least;
    for (int i = 0; i < 4; i++) s.point[i] = hull_pair_of(p, holds->a[i], holds->b[i]);
    vec3 w = s.point[0].w;
    if (!(vec_dot(triangle_normal(w, s.point[1].w, s.point[2].w), vec_sub(s.point[3].w, w)) > 0))
        s.point[0] = hull_pair_of(p, holds->a[1], holds->b[1]), s.point[1] = hull_pair_of(p, holds->a[0], holds->b[0]);
    s.point_count = TETRAHEDRON.point_count;
    *out = (span){.lo = -INFINITY, .hi = INFINITY};
    if (!LANES_CHOSEN(search_corners)(&x, goal, &least)) return false;
    if (!(out->lo <= -NEAR_LEAST_DEPTH * p->size)) return false;
    polytope_report(&x, least);
    return true;
}
