/* Where the two shapes of a walk are, as each other's boxes see them; the axis, and the parts that are visited. Pure;
 * any thread. */
#include "mesh_place.h"

#include "narrow/pair/core.h"

/* Two boxes are opened together where neither mesh is more than this times as large as the other, nor farther away than
 * ALONE_FAR times its size: elsewhere floats are better of one box at a time. */
#define ALONE_RATIO 16
#define ALONE_FAR 64

static void wear(triangle_part *t, shape *s)
{
    t->hull =
        (hull){.vertex_count = 3, .padded_count = TRIANGLE_PADDED, .x = t->x, .y = t->y, .z = t->z, .dimension = 2};
    *s = (shape){.type = SHAPE_HULL, .radius = s->radius, .hull = &t->hull};
}

static void put_on(triangle_part *t, const mesh *m, uint32_t triangle)
{
    for (int k = 0; k < TRIANGLE_PADDED; k++) {
        vec3 v = mesh_corner(m, triangle, k % 3);
        t->x[k] = v.x;
        t->y[k] = v.y;
        t->z[k] = v.z;
    }
}

void mesh_walk_dress(mesh_walk *w)
{
    put_on(&w->flat_b, w->mb, w->triangle_b);
    if (w->ma) put_on(&w->flat_a, w->ma, w->triangle_a);
}

static void set_turn(mesh_turn *turn, const transform *t, double size_from, double size_to)
{
    double ratio = size_from / size_to;
    turn->r = (mat3){vec_scale(t->r.x, ratio), vec_scale(t->r.y, ratio), vec_scale(t->r.z, ratio)};
    turn->t = vec_scale(t->t, 1 / size_to);
    turn->ratio = (float)ratio;
    put3(turn->column[0], t->r.x);
    put3(turn->column[1], t->r.y);
    put3(turn->column[2], t->r.z);
}

static double extent_of(const mesh_walk *w, vec3 d)
{
    return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
}

/* The box of a convex A as B's nodes see it. */
static void box_whole(mesh_walk *w)
{
    mesh_other *o = &w->whole_other;
    vec3 half = vec_scale(vec_sub(w->whole.hi, w->whole.lo), 0.5), middle = vec_add(w->whole.lo, half);
    vec3 centre = vec_scale(transform_point(&w->a_in_b, middle), 1 / w->size_b);
    const double halves[3] = {half.x / w->size_b, half.y / w->size_b, half.z / w->size_b};
    const vec3 axes[3] = {w->a_in_b.r.x, w->a_in_b.r.y, w->a_in_b.r.z};
    double reach = vec_sum_magnitudes(centre);
    for (int k = 0; k < 3; k++) {
        vec3 side = vec_scale(axes[k], halves[k]);
        put3(o->side[k], side);
        put3(o->square[k], axes[k]);
        o->halves[k] = (float)halves[k];
        reach += vec_sum_magnitudes(side);
    }
    put3(o->centre, centre);
    o->far = !(reach < FLOAT_FAR);
    o->slack = (float)(FLOAT_SLACK * (4 + reach));
    o->flat = false;
}

static void spot_whole(mesh_walk *w)
{
    const vec3 x = {1, 0, 0}, y = {0, 1, 0}, z = {0, 0, 1};
    w->whole.hi = vec(extent_of(w, x), extent_of(w, y), extent_of(w, z));
    w->whole.lo = vec(-extent_of(w, vec_neg(x)), -extent_of(w, vec_neg(y)), -extent_of(w, vec_neg(z)));
}

static void forget_stands(mesh_stand *stands)
{
    for (int i = 0; i < MESH_STANDS; i++) stands[i].node = MESH_WHOLE;
}

static void forget_faces(mesh_walk *w)
{
    for (int i = 0; i < MESH_FACES; i++) w->faced[i] = MESH_WHOLE;
}

static void forget_leaves(mesh_box *known)
{
    for (int i = 0; i < MESH_LEAVES; i++) known[i].node = MESH_WHOLE;
}

void mesh_walk_init(mesh_walk *w, const unit_pair *p, const shape *a, const shape *b)
{
    w->part = *p;
    w->whole_a = p->a;
    w->whole_b = p->b;
    w->ma = a->type == SHAPE_MESH ? a->mesh : NULL;
    w->mb = b->mesh;
    w->size_a = w->ma ? w->ma->unit * p->scale : 0;
    w->size_b = w->mb->unit * p->scale;
    w->visits = w->aims = 0;
    w->effort = p->effort;
    w->unseen = INFINITY;
    if (w->ma) {
        wear(&w->flat_a, &w->part.a);
        forget_leaves(w->known_a);
        forget_stands(w->stands_a);
        forget_stands(w->stands_b);
    } else {
        spot_whole(w);
    }
    wear(&w->flat_b, &w->part.b);
    vec3 x = p->b_in_a.r.x, y = p->b_in_a.r.y, z = p->b_in_a.r.z;
    w->a_in_b.r = (mat3){{x.x, y.x, z.x}, {x.y, y.y, z.y}, {x.z, y.z, z.z}};
    mesh_walk_move(w, p->b_in_a.t);
}

void mesh_walk_move(mesh_walk *w, vec3 position)
{
    w->part.b_in_a.t = position;
    w->a_in_b.t = vec_neg(mat_mul(w->a_in_b.r, position));
    w->within = INFINITY;
    w->axis = w->b_axis = VEC_ZERO;
    w->whole_level = 0;
    w->aimed = w->whole_other.aimed = false;
    w->aims++;
    w->triangle_a = w->triangle_b = MESH_NO_TRIANGLE;
    forget_leaves(w->known_b);
    if (w->ma) {
        set_turn(&w->into_a, &w->part.b_in_a, w->size_b, w->size_a);
        set_turn(&w->into_b, &w->a_in_b, w->size_a, w->size_b);
        double ratio = w->size_a / w->size_b, reach = vec_sum_magnitudes(w->into_b.t) + 8 * ratio;
        w->opens_both = ratio <= ALONE_RATIO && ratio * ALONE_RATIO >= 1 && reach < ALONE_FAR;
        forget_faces(w);
        w->open_slack = (float)(FLOAT_SLACK * (4 + reach));
    } else {
        w->opens_both = false;
        box_whole(w);
    }
}

static void aim_whole(mesh_walk *w)
{
    mesh_other *o = &w->whole_other;
    w->whole_level = extent_of(w, w->axis);
    o->aimed = true;
    memcpy(o->axis, w->axis_in_b, sizeof o->axis);
    o->level = (float)((w->whole_level - vec_dot(w->axis, w->part.b_in_a.t)) / w->size_b);
}

void mesh_walk_aim(mesh_walk *w, vec3 axis)
{
    w->axis = axis;
    w->aimed = true;
    w->aims++;
    put3(w->axis_in_a, vec_neg(axis));
    w->b_axis = mat_tmul(w->part.b_in_a.r, axis);
    put3(w->axis_in_b, w->b_axis);
    if (w->ma)
        w->origin_level = (float)(-vec_dot(axis, w->part.b_in_a.t) / w->size_b);
    else
        aim_whole(w);
}

double mesh_walk_top_a(const mesh_walk *w, vec3 d)
{
    if (!w->ma) return vec_dot(d, core_support(&w->whole_a, w->part.scale, d, NULL));
    double top = -INFINITY;
    for (int k = 0; k < 3; k++) top = max_of(top, vec_dot(d, w->spot_a->corner[k]));
    return top;
}

double mesh_walk_foot_b(const mesh_walk *w, vec3 d)
{
    double foot = INFINITY;
    for (int k = 0; k < 3; k++) foot = min_of(foot, vec_dot(d, w->spot_b->corner[k]));
    return foot;
}
