/* The walk over one or two hierarchies of boxes. Pure; any thread.
 *
 * The bound of two boxes is signed: their distance or, where they overlap, minus the least overlap along the axes of a
 * frame. Whatever is in them is no nearer and no deeper: a translation that separates the boxes separates the parts. */
#include "compound_pair.h"
#include "geom/bounds.h"
#include "narrow/contact/manifold.h"
#include "narrow/math/scalar.h"
#include "narrow/pair/unit_pair.h"

enum { STACK = 2 * COMPOUND_DEPTH_MAX + 2 };

typedef struct entry {
    uint32_t a, b; /* nodes */
    double bound;
} entry;

static compound_box compound_box_of(const compound_side *s, uint32_t node, double scale)
{
    if (!s->compound) return s->only;
    const compound_node *n = &s->compound->nodes[node];
    vec3 lo = vec_scale(n->lo, 0.5 * scale), hi = vec_scale(n->hi, 0.5 * scale), half = vec_sub(hi, lo);
    return (compound_box){vec_add(lo, hi), {half.x + s->rounding, half.y + s->rounding, half.z + s->rounding}};
}

static compound_side compound_side_of(const shape *s, double scale)
{
    compound_side out = {.whole = s};
    if (s->type == SHAPE_COMPOUND) {
        out.compound = s->compound;
        out.rounding = s->radius * scale;
    } else if (s->type != SHAPE_HALFSPACE) {
        aabb box = shape_bounds(s, POSE_IDENTITY);
        vec3 lo = vec_scale(box.lo, 0.5 * scale), hi = vec_scale(box.hi, 0.5 * scale);
        out.only = (compound_box){vec_add(lo, hi), vec_sub(hi, lo)};
    }
    return out;
}

void compound_walk_init(
    compound_walk *w, const unit_pair *p, const shape *a, const shape *b, pose b_in_a, narrow_ask *ask)
{
    *w = (compound_walk){.a = compound_side_of(a, p->scale),
        .b = compound_side_of(b, p->scale),
        .plane = a->type == SHAPE_HALFSPACE,
        .b_in_a = b_in_a,
        .placed = p->b_in_a,
        .scale = p->scale,
        .unit = p->unit,
        .error = p->error,
        .size = p->size,
        .within = INFINITY,
        .effort = p->effort,
        .ask = ask};
    const mat3 *r = &p->b_in_a.r;
    w->spread = (mat3){vec_magnitudes(r->x), vec_magnitudes(r->y), vec_magnitudes(r->z)};
}

void compound_walk_move(compound_walk *w, vec3 position)
{
    w->placed.t = position;
    w->b_in_a.p = vec_scale(position, w->unit);
}

/* ---- bounds ---- */

static double beyond_zero(double x)
{
    return max_of(x, 0);
}

static double signed_gap(vec3 apart, vec3 reach)
{
    double x = fabs(apart.x) - reach.x, y = fabs(apart.y) - reach.y, z = fabs(apart.z) - reach.z;
    double most = max_of(max_of(x, y), z);
    if (most <= 0) return most;
    return vec_norm(vec(beyond_zero(x), beyond_zero(y), beyond_zero(z)));
}

/* Seen from A; and where that does not settle it, from B. */
static double bound_of(const compound_walk *w, const compound_box *a, const compound_box *b)
{
    const transform *t = &w->placed;
    vec3 centre = transform_point(t, b->centre), half = mat_mul(w->spread, b->half);
    if (w->plane) return centre.z - half.z - w->a.whole->radius * w->scale - w->error;
    vec3 apart = vec_sub(centre, a->centre);
    double seen_from_a = signed_gap(apart, vec_add(a->half, half)) - w->error;
    if (seen_from_a > w->within) return seen_from_a;
    double seen_from_b = signed_gap(mat_tmul(t->r, apart), vec_add(b->half, mat_tmul(w->spread, a->half)));
    return max_of(seen_from_a, seen_from_b - w->error);
}

/* ---- the walk ---- */

static bool is_leaf(const compound_side *s, uint32_t node)
{
    return !s->compound || !s->compound->nodes[node].right;
}

static double compound_span_of(const compound_box *b)
{
    return b->half.x + b->half.y + b->half.z;
}

static bool opens_a(const compound_walk *w, const entry *e)
{
    if (is_leaf(&w->a, e->a)) return false;
    if (is_leaf(&w->b, e->b)) return true;
    compound_box a = compound_box_of(&w->a, e->a, w->scale), b = compound_box_of(&w->b, e->b, w->scale);
    return compound_span_of(&a) > compound_span_of(&b);
}

static entry entry_of(const compound_walk *w, uint32_t a, uint32_t b)
{
    compound_box box_a = compound_box_of(&w->a, a, w->scale), box_b = compound_box_of(&w->b, b, w->scale);
    return (entry){a, b, bound_of(w, &box_a, &box_b)};
}

static bool is_left_out(compound_walk *w, const entry *e)
{
    if (!(e->bound > w->within)) return false;
    w->left_out = min_of(w->left_out, e->bound);
    return true;
}

/* The nearer half comes on top. */
static uint32_t open_entry(compound_walk *w, const entry *e, entry *stack, uint32_t open)
{
    bool a = opens_a(w, e);
    uint32_t node = a ? e->a : e->b, right = (a ? w->a : w->b).compound->nodes[node].right;
    entry near = a ? entry_of(w, node + 1, e->b) : entry_of(w, e->a, node + 1);
    entry far = a ? entry_of(w, right, e->b) : entry_of(w, e->a, right);
    if (far.bound < near.bound) {
        entry swap = near;
        near = far;
        far = swap;
    }
    if (!is_left_out(w, &far)) stack[open++] = far;
    if (!is_left_out(w, &near)) stack[open++] = near;
    return open;
}

/* The effort has ended. */
static void compound_leave_all(compound_walk *w, const entry *e, uint32_t count)
{
    w->cut = true;
    for (uint32_t i = 0; i < count; i++) w->left_out = min_of(w->left_out, e[i].bound);
}

static uint32_t compound_part_at(const compound_side *s, uint32_t node)
{
    return s->compound ? s->compound->nodes[node].child : 0;
}

void compound_walk_run(compound_walk *w, double within, compound_visit *visit, void *context)
{
    entry stack[STACK];
    uint32_t open = 0;
    w->within = within;
    w->left_out = INFINITY;
    w->cut = false;
    entry root = entry_of(w, 0, 0);
    if (!is_left_out(w, &root)) stack[open++] = root;
    while (open) {
        entry e = stack[--open];
        if (is_left_out(w, &e)) continue;
        if (!effort_spend(w->effort, EFFORT_BOXES)) {
            compound_leave_all(w, stack, open + 1);
            return;
        }
        if (!is_leaf(&w->a, e.a) || !is_leaf(&w->b, e.b)) {
            open = open_entry(w, &e, stack, open);
            continue;
        }
        w->visits++;
        if (!visit(w, compound_part_at(&w->a, e.a), compound_part_at(&w->b, e.b), context)) return;
    }
}

/* ---- parts ---- */

uint32_t compound_part_count(const compound_side *s)
{
    return s->compound ? s->compound->child_count : 1;
}

shape compound_part(const compound_side *s, uint32_t part, pose *local)
{
    *local = POSE_IDENTITY;
    if (!s->compound) return *s->whole;
    shape out = s->compound->children[part].shape;
    out.radius += s->whole->radius;
    out.deviation += s->whole->deviation;
    *local = s->compound->children[part].local;
    return out;
}

static bool is_placed(const compound_side *s, uint32_t part)
{
    return s->compound && !s->compound->children[part].at_origin;
}

pose compound_parts_pose(const compound_walk *w, uint32_t part_a, uint32_t part_b, bool *composed)
{
    pose out = w->b_in_a;
    if (is_placed(&w->b, part_b)) out = pose_mul(out, w->b.compound->children[part_b].local);
    if (is_placed(&w->a, part_a)) out = pose_relative(w->a.compound->children[part_a].local, out);
    *composed = is_placed(&w->a, part_a) || is_placed(&w->b, part_b);
    if (*composed) out.q = quat_unit(out.q);
    return out;
}

static pose inverse(pose p)
{
    quat q = quat_conj(p.q);
    return (pose){vec_neg(quat_rotate(q, p.p)), q};
}

/* From the frame of the part that was asked first to A's; `turn` brings B's part back to second place. */
static void bring_to_a(narrow_result *r, pose frame, bool turn)
{
    transform t = pose_transform(frame);
    r->axis = direction_again(mat_mul(t.r, turn ? vec_neg(r->axis) : r->axis));
    vec3 first = transform_point(&t, r->point_a), second = transform_point(&t, r->point_b);
    r->point_a = turn ? second : first;
    r->point_b = turn ? first : second;
    for (uint32_t i = 0; i < r->manifold.count; i++) {
        manifold_point *p = &r->manifold.points[i];
        p->point = transform_point(&t, p->point);
        if (turn) p->feature = feature_turned(p->feature);
    }
}

int64_t compound_vertices(const shape *a, const shape *b)
{
    return (a->type == SHAPE_HULL ? a->hull->vertex_count : 0) + (b->type == SHAPE_HULL ? b->hull->vertex_count : 0);
}

void compound_parts_query(const compound_walk *w, uint32_t part_a, uint32_t part_b, const narrow_request *request,
    narrow_scratch *scratch, narrow_result *out)
{
    bool composed;
    pose local_a, local_b, relative = compound_parts_pose(w, part_a, part_b, &composed);
    shape a = compound_part(&w->a, part_a, &local_a), b = compound_part(&w->b, part_b, &local_b);
    if (order_shapes(&a, &b) > 0) {
        pose back = inverse(relative);
        w->ask(&b, &a, &back, request, scratch, out);
        bring_to_a(out, pose_mul(local_a, relative), true);
    } else {
        w->ask(&a, &b, &relative, request, scratch, out);
        if (is_placed(&w->a, part_a)) bring_to_a(out, local_a, false);
    }
    int64_t vertices = compound_vertices(&a, &b);
    int64_t steps = out->iterations * (EFFORT_PARTS_STEP + vertices);
    effort_spend(w->effort, EFFORT_PARTS + steps + vertices * EFFORT_PARTS_VERTICES);
    bool rounded = (w->a.rounding > 0 || w->b.rounding > 0);
    double widening = composed || rounded ? w->error * w->unit : 0;
    out->lo -= widening;
    out->hi += widening;
}
