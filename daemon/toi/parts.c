/* toi_parts: boxes of hierarchies and what lies in them, as shapes. Pure; any thread. */
#include "parts.h"

#include "geom/compound.h"
#include "geom/round.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/core.h"
#include "narrow/pair/unit_pair.h"

bool toi_parts_apply(const shape *a, const shape *b)
{
    return a->type != SHAPE_HALFSPACE && (a->type >= SHAPE_CONVEX_COUNT || b->type >= SHAPE_CONVEX_COUNT);
}

/* A box from corner to corner, in m. */
static void be_box(toi_part *p, vec3 lo, vec3 hi)
{
    vec3 centre = vec_scale(vec_add(lo, hi), 0.5), half = vec_max(vec_sub(hi, centre), vec_sub(centre, lo));
    p->shape = (shape){.type = SHAPE_BOX,
        .radius = p->whole->radius + shape_excess(p->whole),
        .half = vec_scale(half, 1 + 4 * UNIT_ROUNDOFF)};
    p->local = (pose){centre, {1, 0, 0, 0}};
    p->size = shape_reach(&p->shape);
    p->is_leaf = false;
    p->form = TOI_PART_BOX;
    p->centre = centre;
    p->side[0] = vec(p->shape.half.x, 0, 0);
    p->side[1] = vec(0, p->shape.half.y, 0);
    p->side[2] = vec(0, 0, p->shape.half.z);
    p->margin = p->shape.radius;
}

/* The extents of a convex shape: those of its box, in its own frame. */
static void be_shape(toi_part *p)
{
    const vec3 axes[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    vec3 middle = VEC_ZERO;
    mat3 r = quat_matrix(p->local.q);
    p->size = shape_reach(&p->shape);
    p->form = p->shape.type == SHAPE_BOX ? TOI_PART_BOX : TOI_PART_SHAPE;
    p->margin = p->shape.radius + shape_excess(&p->shape);
    for (int k = 0; k < 3; k++) {
        double hi = vec_dot(axes[k], core_support(&p->shape, 1, axes[k], NULL));
        double lo = vec_dot(axes[k], core_support(&p->shape, 1, vec_neg(axes[k]), NULL));
        middle = vec_madd(middle, 0.5 * (lo + hi), axes[k]);
        p->side[k] = mat_mul(r, vec_scale(axes[k], 0.5 * (hi - lo)));
    }
    p->centre = vec_add(mat_mul(r, middle), p->local.p);
}

/* Boxes of meshes are turned as their patches lie. */
static void be_turned(toi_part *p, const mesh_node *n, uint32_t c, double unit)
{
    p->centre = vec_scale(vec(n->centre[0][c], n->centre[1][c], n->centre[2][c]), unit);
    p->normal = vec_scale(vec(n->normal[0][c], n->normal[1][c], n->normal[2][c]), unit);
    for (int k = 0; k < 2; k++) p->side[k] = vec_scale(vec(n->side[k][0][c], n->side[k][1][c], n->side[k][2][c]), unit);
    p->side[2] = vec_scale(p->normal, (double)n->half[c]);
}

/* ---- meshes ---- */

static vec3 toi_part_corner_of(const float side[3][MESH_WIDTH], int child, double unit)
{
    return vec(side[0][child] * unit, side[1][child] * unit, side[2][child] * unit);
}

static void be_mesh_node(toi_part *p, const shape *whole, uint32_t node)
{
    const mesh_node *n = &whole->mesh->nodes[node];
    double unit = whole->mesh->unit;
    *p = (toi_part){.whole = whole, .node = node, .child = TOI_WHOLE_NODE};
    vec3 lo = toi_part_corner_of(n->lo, 0, unit), hi = toi_part_corner_of(n->hi, 0, unit);
    for (int k = 1; k < n->used; k++) {
        lo = vec_min(lo, toi_part_corner_of(n->lo, k, unit));
        hi = vec_max(hi, toi_part_corner_of(n->hi, k, unit));
    }
    be_box(p, lo, hi);
}

/* A triangle in the clothes of a flat hull. */
static void be_triangle(toi_part *p, const shape *whole, uint32_t triangle)
{
    *p = (toi_part){.whole = whole, .local = POSE_IDENTITY, .is_leaf = true};
    double reach = 0, most = 0;
    for (int k = 0; k < 8; k++) {
        vec3 v = mesh_corner(whole->mesh, triangle, k < 3 ? k : 2);
        p->x[k] = v.x;
        p->y[k] = v.y;
        p->z[k] = v.z;
        reach = max_of(reach, length_up(v));
        most = max_of(most, vec_greatest(v));
    }
    p->flat = (hull){.vertex_count = 3,
        .padded_count = 8,
        .x = p->x,
        .y = p->y,
        .z = p->z,
        .reach = reach,
        .max_abs = most,
        .dimension = 2};
    p->shape = (shape){.type = SHAPE_HULL, .radius = whole->radius, .deviation = whole->deviation, .hull = &p->flat};
    p->size = reach;
    p->form = TOI_PART_TRIANGLE;
    p->margin = whole->radius;
    vec3 u = vec(p->x[0], p->y[0], p->z[0]), v = vec(p->x[1], p->y[1], p->z[1]), w = vec(p->x[2], p->y[2], p->z[2]);
    p->centre = vec_scale(vec_add(vec_add(u, v), w), 1.0 / 3);
    p->normal = vec_cross(vec_sub(v, u), vec_sub(w, u));
}

static int mesh_children(const toi_part *p, toi_part *out)
{
    const mesh_node *n = &p->whole->mesh->nodes[p->node];
    double unit = p->whole->mesh->unit;
    if (p->child != TOI_WHOLE_NODE) { /* the triangles of one child */
        for (int k = 0; k < n->count[p->child]; k++) be_triangle(&out[k], p->whole, n->first[p->child] + (uint32_t)k);
        return n->count[p->child];
    }
    for (uint32_t k = 0; k < n->used; k++) {
        bool inner = n->count[k] == 0;
        out[k] =
            (toi_part){.whole = p->whole, .node = inner ? n->first[k] : p->node, .child = inner ? TOI_WHOLE_NODE : k};
        be_box(&out[k], toi_part_corner_of(n->lo, (int)k, unit), toi_part_corner_of(n->hi, (int)k, unit));
        be_turned(&out[k], n, k, unit);
    }
    return n->used;
}

/* ---- compounds ---- */

static void be_child(toi_part *p, const shape *whole, uint32_t child)
{
    const compound_child *c = &whole->compound->children[child];
    *p = (toi_part){.whole = whole, .shape = c->shape, .local = c->local, .is_leaf = true};
    p->shape.radius += whole->radius;
    p->shape.deviation += whole->deviation;
    be_shape(p);
}

static void be_compound_node(toi_part *p, const shape *whole, uint32_t node)
{
    const compound_node *n = &whole->compound->nodes[node];
    if (n->right == 0) {
        be_child(p, whole, n->child);
        return;
    }
    *p = (toi_part){.whole = whole, .node = node};
    be_box(p, n->lo, n->hi);
}

static int compound_children(const toi_part *p, toi_part *out)
{
    be_compound_node(&out[0], p->whole, p->node + 1);
    be_compound_node(&out[1], p->whole, p->whole->compound->nodes[p->node].right);
    return 2;
}

/* ---- any shape ---- */

void toi_part_root(const shape *whole, toi_part *out)
{
    if (whole->type == SHAPE_MESH) {
        be_mesh_node(out, whole, 0);
        return;
    }
    if (whole->type == SHAPE_COMPOUND) {
        be_compound_node(out, whole, 0);
        return;
    }
    *out = (toi_part){.whole = whole, .shape = *whole, .local = POSE_IDENTITY, .is_leaf = true};
    be_shape(out);
}

int toi_part_children(const toi_part *p, toi_part *out)
{
    return p->whole->type == SHAPE_MESH ? mesh_children(p, out) : compound_children(p, out);
}
