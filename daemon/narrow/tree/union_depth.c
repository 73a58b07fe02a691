/* The least translation out of a union of Minkowski differences. Pure; any thread. */
#include "union_depth.h"

#include "geom/compound.h"
#include "geom/hull.h"
#include "geom/mesh.h"
#include "narrow/math/scalar.h"

/* By how many times that the planes of a hull may reach beyond it, at its sharp corners. */
static const double UNEVEN = 16;

/* Lengths in units of the pair. */
static const double INSIDE = 0x1p-38;   /* a translation this far inside of a difference is inside */
static const double ROUNDING = 0x1p-34; /* what a bound may be off by: systems of planes are solved to 2^16 roundoffs */
static const double BORDERLINE = 0x1p-30;                 /* of the products of the test for edges */
static const double SAME_NORMAL = 0x1p-40;                /* squared distance of unit normals */
static const double PARALLEL = 0x1p-80, SLIVER = 0x1p-40; /* squared sines of two edges */
static const double FEASIBLE = 0x1p-42;                   /* by which a constraint may be missed */
static const double MARGIN = 0x1p-34;
static const double DEPENDENT = 0x1p-32, MISSED = 0x1p-13;

enum { STEPS_MAX = 40, LEAVES_MAX = 64, TRIES_MAX = 5, DIVE_MAX = 16, WORK_A_TRY = 3000 };

/* ---- sides ---- */

static bool has_space(const union_side *s, uint32_t points, uint32_t faces, uint32_t edges)
{
    return s->part_count < UNION_SIDE_PARTS && s->point_count + points <= UNION_POINTS_MAX &&
           s->face_count + faces <= UNION_FACES_MAX && s->edge_count + edges <= UNION_EDGES_MAX;
}

static union_part *begin_part(union_side *s)
{
    union_part *p = &s->parts[s->part_count++];
    *p = (union_part){.lo = {INFINITY, INFINITY, INFINITY},
        .hi = {-INFINITY, -INFINITY, -INFINITY},
        .first_point = s->point_count,
        .first_face = s->face_count,
        .first_edge = s->edge_count};
    return p;
}

static void put_point(union_side *s, union_part *p, vec3 at)
{
    s->points[s->point_count++] = at;
    p->point_count++;
    p->lo = vec_min(p->lo, at);
    p->hi = vec_max(p->hi, at);
}

static double union_top_of(const union_side *s, const union_part *p, vec3 n)
{
    const vec3 *at = s->points + p->first_point;
    double top = -INFINITY;
    for (uint32_t i = 0; i < p->point_count; i++) top = max_of(top, vec_dot(n, at[i]));
    return top;
}

static void put_face(union_side *s, union_part *p, vec3 normal)
{
    s->normals[s->face_count] = normal;
    s->tops[s->face_count++] = union_top_of(s, p, normal);
    p->face_count++;
}

/* Points and faces by their numbers in the part. */
static void put_edge(union_side *s, union_part *p, uint32_t v0, uint32_t v1, uint32_t f0, uint32_t f1)
{
    union_edge *e = &s->edges[s->edge_count++];
    e->from = (uint16_t)(p->first_point + v0);
    e->along = vec_sub(s->points[p->first_point + v1], s->points[p->first_point + v0]);
    e->face[0] = (uint16_t)(p->first_face + f0);
    e->face[1] = (uint16_t)(p->first_face + f1);
    e->between = p->flat ? VEC_ZERO : vec_cross(s->normals[e->face[1]], s->normals[e->face[0]]);
    p->edge_count++;
}

static vec3 placed(const transform *t, vec3 v)
{
    return t ? transform_point(t, v) : v;
}
static vec3 turned_by(const transform *t, vec3 v)
{
    return t ? mat_mul(t->r, v) : v;
}

/* How far corners of its faces are below them, where facets that are not quite in one plane were made one. */
static double unevenness(const hull *h)
{
    double most = 0;
    for (uint32_t i = 0; i < h->face_count; i++) {
        const hull_face *f = &h->faces[i];
        for (uint32_t k = f->first; k < f->first + f->count; k++)
            most = max_of(most, f->offset - vec_dot(f->normal, hull_vertex(h, h->face_vertices[k])));
    }
    return most;
}

static bool put_hull(union_side *s, const hull *h, double scale, const transform *t)
{
    if (h->dimension < 3 || !has_space(s, h->vertex_count, h->face_count, h->edge_count)) return false;
    union_part *p = begin_part(s);
    for (uint32_t i = 0; i < h->vertex_count; i++) put_point(s, p, placed(t, vec_scale(hull_vertex(h, i), scale)));
    for (uint32_t i = 0; i < h->face_count; i++) put_face(s, p, turned_by(t, h->faces[i].normal));
    for (uint32_t i = 0; i < h->edge_count; i++)
        put_edge(s, p, h->edges[i].v0, h->edges[i].v1, h->edges[i].f0, h->edges[i].f1);
    s->slack = max_of(s->slack, UNEVEN * unevenness(h) * scale);
    return true;
}

static bool put_box(union_side *s, vec3 half, const transform *t)
{
    if (!has_space(s, 8, 6, 12) || !(min_of(half.x, min_of(half.y, half.z)) > 0)) return false;
    union_part *p = begin_part(s);
    for (uint32_t i = 0; i < 8; i++) put_point(s, p, placed(t, box_corner(half, i)));
    for (int k = 0; k < 6; k++) put_face(s, p, turned_by(t, vec_on_axis(k / 2, k & 1 ? 1 : -1)));
    for (uint32_t axis = 0; axis < 3; axis++)
        for (uint32_t k = 0; k < 4; k++) {
            uint32_t u = (axis + 1) % 3, v = (axis + 2) % 3, low = (k & 1) << u | (k >> 1) << v;
            put_edge(s, p, low, low | 1u << axis, 2 * u + (k & 1), 2 * v + (k >> 1));
        }
    return true;
}

static bool put_segment(union_side *s, double half, const transform *t)
{
    if (!has_space(s, 2, 0, 1)) return false;
    union_part *p = begin_part(s);
    p->flat = true;
    put_point(s, p, placed(t, vec(0, 0, -half)));
    if (!(half > 0)) return true;
    put_point(s, p, placed(t, vec(0, 0, half)));
    put_edge(s, p, 0, 1, 0, 0);
    return true;
}

static bool put_mesh(union_side *s, const mesh *m, double scale, const transform *t)
{
    for (uint32_t i = 0; i < m->piece_count; i++) {
        double others = s->slack;
        s->slack = 0;
        if (!put_hull(s, m->pieces[i].hull, scale, t)) return false;
        s->slack = max_of(others, s->slack + m->pieces[i].slack * scale);
    }
    return m->piece_count > 0;
}

static bool put_shape(union_side *side, const shape *s, double scale, const transform *place)
{
    switch (s->type) {
    case SHAPE_SPHERE:
        return put_segment(side, 0, place);
    case SHAPE_CAPSULE:
        return put_segment(side, s->half.z, place);
    case SHAPE_BOX:
        return put_box(side, s->half, place);
    case SHAPE_HULL:
        return put_hull(side, s->hull, scale, place);
    case SHAPE_MESH:
        return put_mesh(side, s->mesh, scale, place);
    default:
        return false;
    }
}

static void clear_side(union_side *side)
{
    side->part_count = side->point_count = side->face_count = side->edge_count = 0;
    side->slack = 0;
}

bool union_side_of_children(union_side *side, const compound *c, double scale, const transform *place, double *rounding)
{
    clear_side(side);
    *rounding = INFINITY;
    for (uint32_t i = 0; i < c->child_count; i++) {
        const compound_child *child = &c->children[i];
        transform t = {child->place.r, vec_scale(child->place.t, scale)};
        if (place) {
            t.t = transform_point(place, t.t);
            t.r = (mat3){mat_mul(place->r, t.r.x), mat_mul(place->r, t.r.y), mat_mul(place->r, t.r.z)};
        }
        *rounding = min_of(*rounding, child->shape.radius * scale);
        shape part = child->shape;
        part.half = vec_scale(part.half, scale);
        if (part.type == SHAPE_MESH || part.deviation > 0 || !put_shape(side, &part, scale, &t)) return false;
    }
    return true;
}

bool union_side_init(union_side *side, const shape *s, double scale, const transform *place)
{
    clear_side(side);
    return put_shape(side, s, scale, place);
}

/* ---- the facets of a difference ---- */

typedef struct facets {
    union_scratch *u;
    const union_part *a, *b;
    union_pair *pair;
    double within; /* planes beyond it do not matter */
    double shrink; /* by which they come inward */
    uint32_t work;
    bool full, apart;
} facets;

static void put_plane(facets *f, vec3 normal, double offset)
{
    union_scratch *u = f->u;
    offset -= f->shrink;
    if (offset < -f->within) f->apart = true;
    if (offset > f->within || f->apart) return;
    if (u->plane_count == UNION_PLANES_MAX) {
        f->full = true;
        return;
    }
    u->planes[u->plane_count++] = (union_plane){normal, offset};
    f->pair->count++;
}

static void faces_of_difference(facets *f)
{
    const union_side *a = &f->u->a, *b = &f->u->b;
    for (uint32_t i = f->a->first_face; i < f->a->first_face + f->a->face_count && !f->apart; i++)
        put_plane(f, a->normals[i], a->tops[i] + union_top_of(b, f->b, vec_neg(a->normals[i])));
    for (uint32_t i = f->b->first_face; i < f->b->first_face + f->b->face_count && !f->apart; i++)
        put_plane(f, vec_neg(b->normals[i]), b->tops[i] + union_top_of(a, f->a, vec_neg(b->normals[i])));
    f->work += f->a->face_count * f->b->point_count / 4 + f->b->face_count * f->a->point_count / 4;
}

static bool is_known_normal(const facets *f, vec3 n)
{
    const union_plane *p = f->u->planes + f->pair->first;
    for (uint32_t i = 0; i < f->pair->count; i++)
        if (vec_norm2(vec_sub(p[i].normal, n)) < SAME_NORMAL) return true;
    return false;
}

/* A facet that is there, or may be but for rounding, or is a sliver of which the normal is not known well: then its
 * height is that of the whole difference, which is right for any normal. */
static void put_edges(facets *f, const union_edge *e, const union_edge *g, vec3 outward, bool sure)
{
    const union_side *a = &f->u->a, *b = &f->u->b;
    vec3 n = vec_cross(e->along, g->along);
    double norm2 = vec_norm2(n), area2 = vec_norm2(e->along) * vec_norm2(g->along);
    if (!(norm2 > PARALLEL * area2)) return;
    n = vec_scale(n, 1 / sqrt(norm2));
    if (vec_dot(n, outward) < 0) n = vec_neg(n);
    if (sure && norm2 > SLIVER * area2) {
        put_plane(f, n, vec_dot(n, vec_sub(a->points[e->from], b->points[g->from])));
    } else if (!is_known_normal(f, n)) {
        put_plane(f, n, union_top_of(a, f->a, n) + union_top_of(b, f->b, vec_neg(n)));
        f->work += (f->a->point_count + f->b->point_count) / 4;
    }
}

/* Do the arcs of normals of an edge of P and of one of -Q cross? (Gregorius, "The separating axis test between convex
 * polyhedra", 2013.) */
static void edges_of_difference(facets *f)
{
    const union_side *a = &f->u->a, *b = &f->u->b;
    for (uint32_t i = f->a->first_edge; i < f->a->first_edge + f->a->edge_count && !f->apart; i++) {
        const union_edge *e = &a->edges[i];
        vec3 n0 = a->normals[e->face[0]], n1 = a->normals[e->face[1]], x = e->between;
        for (uint32_t k = f->b->first_edge; k < f->b->first_edge + f->b->edge_count; k++) {
            const union_edge *g = &b->edges[k];
            double c = vec_dot(b->normals[g->face[0]], x), d = vec_dot(b->normals[g->face[1]], x);
            if (c * d > BORDERLINE) continue;
            double p = vec_dot(n0, g->between), q = vec_dot(n1, g->between);
            if (p * q > BORDERLINE || c * q > BORDERLINE) continue;
            bool sure = c * d < -BORDERLINE && p * q < -BORDERLINE && c * q < -BORDERLINE;
            put_edges(f, e, g, vec_add(n0, n1), sure);
        }
    }
    f->work += f->a->edge_count * f->b->edge_count / 2;
}

/* One of them a segment: its facets lie beside the edges of the other whose normals are on both sides of it. */
static void edges_beside_segment(facets *f, bool a_is_flat)
{
    const union_side *a = &f->u->a, *b = &f->u->b;
    const union_side *solid = a_is_flat ? b : a;
    const union_part *part = a_is_flat ? f->b : f->a, *flat = a_is_flat ? f->a : f->b;
    if (!flat->edge_count) return;
    const union_edge *s = &(a_is_flat ? a : b)->edges[flat->first_edge];
    for (uint32_t k = part->first_edge; k < part->first_edge + part->edge_count && !f->apart; k++) {
        const union_edge *e = &solid->edges[k];
        vec3 n0 = solid->normals[e->face[0]], n1 = solid->normals[e->face[1]], out = vec_add(n0, n1);
        if (vec_dot(n0, s->along) * vec_dot(n1, s->along) > BORDERLINE * vec_norm2(s->along)) continue;
        if (a_is_flat)
            put_edges(f, s, e, vec_neg(out), false);
        else
            put_edges(f, e, s, out, false);
    }
    f->work += part->edge_count * 4;
}

/* Of what is proven to be solid of the parts: their supports are less by `shrink` at most, and what is inside of all
 * facets by that is inside along all directions. */
static uint32_t make_planes(union_scratch *u, union_pair *pair, double within, double shrink)
{
    facets f = {.u = u,
        .a = &u->a.parts[pair->part_a],
        .b = &u->b.parts[pair->part_b],
        .pair = pair,
        .within = within,
        .shrink = shrink};
    pair->made = true;
    pair->first = pair->last = u->plane_count;
    faces_of_difference(&f);
    if (f.a->flat || f.b->flat)
        edges_beside_segment(&f, f.a->flat);
    else
        edges_of_difference(&f);
    pair->dead = f.full || f.apart;
    if (pair->dead) u->plane_count = pair->first;
    return f.work;
}

/* ---- the nearest point beyond some planes ---- */

typedef struct program {
    uint32_t count;
    vec3 normal[UNION_PLANES_A_NODE];
    double offset[UNION_PLANES_A_NODE];
    uint32_t active[3], active_count;
    double weight[3]; /* of the active ones, >= 0 */
    vec3 x;
} program;

static void drop_active(program *p, uint32_t k)
{
    p->active_count--;
    for (; k < p->active_count; k++) {
        p->active[k] = p->active[k + 1];
        p->weight[k] = p->weight[k + 1];
    }
}

/* n = z + sum of share[k] times the active normals, z across all of them. */
static vec3 across_active(const program *p, vec3 n, double share[3])
{
    vec3 a[3];
    for (uint32_t k = 0; k < p->active_count; k++) a[k] = p->normal[p->active[k]];
    if (p->active_count == 0) return n;
    if (p->active_count == 1) {
        share[0] = vec_dot(a[0], n);
        return vec_madd(n, -share[0], a[0]);
    }
    vec3 side = vec_cross(a[0], a[1]);
    double sine2 = vec_norm2(side), n0 = vec_dot(a[0], n), n1 = vec_dot(a[1], n), c = vec_dot(a[0], a[1]);
    if (p->active_count == 2) {
        share[0] = (n0 - c * n1) / sine2;
        share[1] = (n1 - c * n0) / sine2;
        return vec_scale(side, vec_dot(side, n) / sine2);
    }
    double det = vec_dot(side, a[2]);
    share[0] = vec_dot(n, vec_cross(a[1], a[2])) / det;
    share[1] = vec_dot(n, vec_cross(a[2], a[0])) / det;
    share[2] = vec_dot(n, side) / det;
    return VEC_ZERO;
}

/* Goldfarb and Idnani, "A numerically stable dual method for solving strictly convex quadratic programs", 1983: the
 * length of x grows from step to step and is a lower bound at each. False: there is no point beyond all planes. */
static bool solve(program *p)
{
    p->x = VEC_ZERO;
    p->active_count = 0;
    for (int steps = 0; steps < STEPS_MAX;) {
        uint32_t worst = p->count;
        double missed = FEASIBLE;
        for (uint32_t i = 0; i < p->count; i++) {
            double by = p->offset[i] - vec_dot(p->normal[i], p->x);
            if (by > missed) missed = by, worst = i;
        }
        if (worst == p->count) return true;
        double weight = 0;
        for (bool added = false; !added; steps++) {
            double share[3] = {0}, least = INFINITY;
            uint32_t leaving = 3;
            vec3 n = p->normal[worst], z = across_active(p, n, share);
            for (uint32_t k = 0; k < p->active_count; k++)
                if (share[k] > 0 && p->weight[k] / share[k] < least) least = p->weight[k] / share[k], leaving = k;
            double z2 = vec_dot(z, n);
            double full = z2 > DEPENDENT ? (p->offset[worst] - vec_dot(n, p->x)) / z2 : INFINITY;
            if (isinf(full) && isinf(least)) return missed < MISSED; /* left out: the bound stays one */
            double step = min_of(full, least);
            if (full < INFINITY) p->x = vec_madd(p->x, step, z);
            for (uint32_t k = 0; k < p->active_count; k++) p->weight[k] = max_of(p->weight[k] - step * share[k], 0);
            weight += step;
            if (full <= least) {
                p->active[p->active_count] = worst;
                p->weight[p->active_count++] = weight;
                added = true;
            } else {
                drop_active(p, leaving);
            }
            if (steps > STEPS_MAX) return true;
        }
    }
    return true;
}

/* ---- the heap ---- */

static void push(union_scratch *u, const union_node *node)
{
    uint32_t at = u->node_count++;
    for (; at > 0 && u->nodes[(at - 1) / 2].length > node->length; at = (at - 1) / 2)
        u->nodes[at] = u->nodes[(at - 1) / 2];
    u->nodes[at] = *node;
}

static union_node pop(union_scratch *u)
{
    union_node top = u->nodes[0], last = u->nodes[--u->node_count];
    uint32_t at = 0;
    for (;;) {
        uint32_t child = 2 * at + 1;
        if (child >= u->node_count) break;
        if (child + 1 < u->node_count && u->nodes[child + 1].length < u->nodes[child].length) child++;
        if (!(u->nodes[child].length < last.length)) break;
        u->nodes[at] = u->nodes[child];
        at = child;
    }
    u->nodes[at] = last;
    return top;
}

/* ---- the search ---- */

typedef struct union_search {
    union_scratch *u;
    double length; /* of the shortest way that is known */
    double shrink;
    double floor; /* least bound of the regions that were given up */
    uint32_t work, work_max, tries;
    union_try *try_way;
    void *context;
} union_search;

/* How far inside of the difference the translation is; negative as soon as it is outside. */
static double inside_by(union_scratch *u, union_pair *pair, vec3 way, uint32_t *work)
{
    double least = INFINITY;
    const union_plane *last = &u->planes[pair->last];
    if (pair->count && last->offset - vec_dot(last->normal, way) <= INSIDE) return -1;
    for (uint32_t i = pair->first; i < pair->first + pair->count; i++) {
        double by = u->planes[i].offset - vec_dot(u->planes[i].normal, way);
        if (by <= INSIDE) {
            pair->last = i;
            *work += 1 + (i - pair->first) / 8;
            return -1;
        }
        least = min_of(least, by);
    }
    *work += 1 + pair->count / 8;
    return least;
}

/* How far the boxes of two parts overlap, along the axes of the frame. */
static double box_depth(const union_scratch *u, const union_pair *pair, vec3 way)
{
    const union_part *a = &u->a.parts[pair->part_a], *b = &u->b.parts[pair->part_b];
    vec3 up = vec_sub(vec_sub(a->hi, b->lo), way), down = vec_add(vec_sub(b->hi, a->lo), way);
    return min_of(min_of(min_of(up.x, up.y), min_of(up.z, down.x)), min_of(down.y, down.z));
}

/* Before its planes are made: is there a face of either part along which the translation parts them, by so much? */
static bool is_outside_by_faces(union_search *s, union_pair *pair, vec3 way, double by)
{
    const union_scratch *u = s->u;
    const union_part *a = &u->a.parts[pair->part_a], *b = &u->b.parts[pair->part_b];
    uint32_t count = a->face_count + b->face_count;
    for (uint32_t i = 0; i < count; i++) {
        uint32_t face = (pair->last + i) % count, of_b = face - a->face_count;
        bool first = face < a->face_count;
        vec3 n = first ? u->a.normals[a->first_face + face] : vec_neg(u->b.normals[b->first_face + of_b]);
        double top = first ? u->a.tops[a->first_face + face] + union_top_of(&u->b, b, vec_neg(n))
                           : u->b.tops[b->first_face + of_b] + union_top_of(&u->a, a, n);
        s->work += 1 + (first ? b : a)->point_count / 8;
        if (vec_dot(n, way) - (top - s->shrink) < by) continue;
        pair->last = face;
        return true;
    }
    return false;
}

/* A difference that the translation is inside of: the deepest of those of which the planes are made, or else the first
 * by the overlap of boxes, of which they are made now. NULL: it is in none, or the work is done. */
static union_pair *some_difference(union_search *s, vec3 way)
{
    union_scratch *u = s->u;
    union_pair *best = NULL;
    double most = 0;
    for (uint32_t i = 0; i < u->pair_count; i++) {
        union_pair *pair = &u->pairs[i];
        pair->depth = pair->made ? 0 : box_depth(u, pair, way);
        if (!pair->made || pair->dead) continue;
        double by = inside_by(u, pair, way, &s->work);
        if (by > most) most = by, best = pair;
    }
    s->work += u->pair_count / 4;
    while (!best && s->work < s->work_max) {
        union_pair *next = NULL;
        most = 0;
        for (uint32_t i = 0; i < u->pair_count; i++)
            if (u->pairs[i].depth > most) next = &u->pairs[i], most = next->depth;
        s->work += u->pair_count / 8;
        if (!next) break;
        next->depth = 0;
        if (is_outside_by_faces(s, next, way, -INSIDE)) continue;
        s->work += make_planes(u, next, s->length, s->shrink);
        if (!next->dead && inside_by(u, next, way, &s->work) > 0) best = next;
    }
    return best;
}

static void give_up(union_search *s, double length)
{
    s->floor = min_of(s->floor, length);
}

/* The region beyond one plane more. False: it has nothing shorter than what is known. The point of the node's region
 * that is nearest to the origin is x, so that any other point y of it has |y|^2 >= |x|^2 + |y - x|^2. */
static bool child_of_node(union_search *s, const union_node *node, uint32_t plane, union_node *out)
{
    union_scratch *u = s->u;
    program p = {.count = 0};
    union_node child = {.plane_count = 0};
    double beyond = u->planes[plane].offset - vec_dot(u->planes[plane].normal, node->way);
    double least2 =
        max_of(node->length * node->length + beyond * beyond, u->planes[plane].offset * u->planes[plane].offset);
    if (least2 * (1 - 0x1p-40) >= s->length * s->length) return false;
    s->work += 16;
    for (uint32_t i = 0; i < node->plane_count; i++) {
        if (node->planes[i] == plane) { /* it was beyond this plane already: rounding ends here */
            give_up(s, node->length);
            return false;
        }
        bool spare = node->plane_count == UNION_PLANES_A_NODE && !(node->active >> i & 1);
        if (spare && p.count + 1 + (node->plane_count - i) > UNION_PLANES_A_NODE) continue;
        child.planes[p.count] = node->planes[i];
        p.normal[p.count] = u->planes[node->planes[i]].normal;
        p.offset[p.count++] = u->planes[node->planes[i]].offset;
    }
    if (p.count == UNION_PLANES_A_NODE) p.count--;
    child.planes[p.count] = (uint16_t)plane;
    p.normal[p.count] = u->planes[plane].normal;
    p.offset[p.count++] = u->planes[plane].offset;
    if (!solve(&p)) return false;
    child.plane_count = (uint8_t)p.count;
    for (uint32_t k = 0; k < p.active_count; k++) child.active |= (uint16_t)(1u << p.active[k]);
    child.way = p.x;
    child.length = max_of(vec_norm(p.x), node->length);
    *out = child;
    return child.length < s->length;
}

static void add_children(union_search *s, const union_node *node, const union_pair *pair)
{
    union_scratch *u = s->u;
    union_node child;
    s->work += 1 + pair->count / 4;
    for (uint32_t i = pair->first; i < pair->first + pair->count; i++) {
        if (!child_of_node(s, node, i, &child)) continue;
        if (u->node_count == UNION_NODES_MAX)
            give_up(s, child.length);
        else
            push(u, &child);
    }
}

static void list_pairs(union_scratch *u)
{
    u->pair_count = u->plane_count = u->node_count = 0;
    for (uint32_t i = 0; i < u->a.part_count; i++)
        for (uint32_t k = 0; k < u->b.part_count && u->pair_count < UNION_PAIRS_MAX; k++)
            u->pairs[u->pair_count++] = (union_pair){.part_a = (uint16_t)i, .part_b = (uint16_t)k};
}

/* How far outside of the difference, at most INFINITY; *plane: along which of its facets. */
static double outside_by(const union_scratch *u, const union_pair *pair, vec3 way, uint32_t *plane)
{
    double most = -INFINITY;
    for (uint32_t i = pair->first; i < pair->first + pair->count; i++) {
        double by = vec_dot(u->planes[i].normal, way) - u->planes[i].offset;
        if (by > most) most = by, *plane = i;
    }
    return most;
}

static void add_wide(const union_scratch *u, program *p, uint32_t plane, double margin)
{
    p->normal[p->count] = u->planes[plane].normal;
    p->offset[p->count++] = u->planes[plane].offset + margin;
}

/* A way out that keeps `margin` from all differences: it slides along none of them, so that rounding does not hide that
 * it is one. False: it would have to fit in between two. */
static bool keep_clear(union_search *s, const union_node *leaf, double margin, vec3 *way)
{
    union_scratch *u = s->u;
    program p = {.count = 0};
    for (uint32_t i = 0; i < leaf->plane_count; i++)
        if (leaf->active >> i & 1) add_wide(u, &p, leaf->planes[i], margin);
    for (bool all = false; !all;) {
        all = true;
        if (!solve(&p)) return false;
        for (uint32_t i = 0; i < u->pair_count; i++) {
            union_pair *pair = &u->pairs[i];
            uint32_t plane = 0;
            if (!pair->made && box_depth(u, pair, p.x) > -margin && !is_outside_by_faces(s, pair, p.x, margin))
                s->work += make_planes(u, pair, s->length, s->shrink);
            if (pair->dead || !pair->made || !pair->count) continue;
            s->work += 1 + pair->count / 8;
            if (outside_by(u, pair, p.x, &plane) >= margin - 2 * FEASIBLE) continue;
            if (p.count == UNION_PLANES_A_NODE) return false;
            add_wide(u, &p, plane, margin);
            all = false;
            break;
        }
    }
    *way = p.x;
    return true;
}

/* A way out from where the node has come to, tried on the shapes. */
static void try_leaf(union_search *s, const union_node *leaf)
{
    vec3 way = leaf->way;
    if (s->tries == TRIES_MAX) return;
    if (!keep_clear(s, leaf, 2 * s->shrink + MARGIN, &way)) return;
    double length = s->try_way(s->context, way);
    s->tries++;
    s->work += WORK_A_TRY;
    if (!(length < s->length)) return;
    s->length = length;
}

/* From difference to difference by the nearest facet: some way out, that is short more often than not. */
static void dive(union_search *s)
{
    union_node node = {.length = 0}, child;
    for (int depth = 0; depth < DIVE_MAX && s->work < s->work_max / 2; depth++) {
        union_node best = {.length = INFINITY};
        union_pair *pair = some_difference(s, node.way);
        if (!pair && s->work < s->work_max) try_leaf(s, &node);
        if (!pair) return;
        for (uint32_t i = pair->first; i < pair->first + pair->count; i++)
            if (child_of_node(s, &node, i, &child) && child.length < best.length) best = child;
        if (best.length == INFINITY) return;
        node = best;
    }
}

union_bounds union_depth(union_scratch *u, double within, const narrow_goal *goal, double error, uint32_t work,
    union_try *try_way, void *context)
{
    union_search s = {
        .u = u, .length = within, .floor = INFINITY, .work_max = work, .try_way = try_way, .context = context};
    const union_node all = {.length = 0};
    s.shrink = u->a.slack + u->b.slack + error;
    int leaves = 0;
    list_pairs(u);
    dive(&s);
    push(u, &all);
    s.floor = INFINITY;
    while (u->node_count && s.work < work) {
        union_node node = pop(u);
        double least = min_of(node.length, s.floor);
        if (!(node.length < s.length) || narrow_goal_reached(goal, -s.length, ROUNDING - least)) {
            push(u, &node);
            break;
        }
        union_pair *pair = some_difference(&s, node.way);
        if (pair) {
            add_children(&s, &node, pair);
            continue;
        }
        give_up(&s, node.length);
        if (s.work >= work || ++leaves > LEAVES_MAX || s.tries == TRIES_MAX) break;
        try_leaf(&s, &node);
    }
    double known = u->node_count ? min_of(u->nodes[0].length, s.floor) : s.floor;
    return (union_bounds){max_of(min_of(known, s.length) - ROUNDING, 0), s.length, s.work};
}
