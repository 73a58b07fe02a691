/* scene: see scene.h. */
#include "scene.h"

#include "geom/bounds.h"
#include "geom/hull.h"
#include "geom/mesh.h"

#include <stdlib.h>
#include <string.h>

/* What distances of simple bodies may be off by, relative to the lengths that enter: of a rotation's columns 16
 * roundoffs, of the products, sums and the root 12 more. */
#define OFF 0x1p-47

/* A box around the core of a shape in its own frame: its middle and half extents. */
typedef struct core_box {
    vec3 middle, half;
} core_box;

static core_box core_box_of(const shape *s)
{
    switch (s->type) {
    case SHAPE_SPHERE:
        return (core_box){VEC_ZERO, VEC_ZERO};
    case SHAPE_CAPSULE:
        return (core_box){VEC_ZERO, vec(0, 0, s->half.z)};
    case SHAPE_HULL:
    case SHAPE_MESH:
    case SHAPE_COMPOUND: {
        shape core = *s;
        core.radius = 0;
        aabb b = shape_bounds(&core, POSE_IDENTITY);
        vec3 half = vec_scale(vec_sub(b.hi, b.lo), 0.5 * (1 + 0x1p-50)), middle = vec_scale(vec_add(b.lo, b.hi), 0.5);
        double more = 0x1p-50 * vec_max_abs(middle);
        return (core_box){middle, vec_add(half, vec(more, more, more))};
    }
    case SHAPE_HALFSPACE:
        return (core_box){VEC_ZERO, VEC_ZERO};
    default:
        return (core_box){VEC_ZERO, s->half};
    }
}

static void write_vec(double out[3], vec3 v)
{
    out[0] = v.x, out[1] = v.y, out[2] = v.z;
}

static scene_obstacle prepare_obstacle(const scene_obstacle_def *d, uint32_t source)
{
    const shape *s = d->shape;
    core_box box = core_box_of(s);
    mat3 r = quat_matrix(quat_unit(d->pose.q));
    vec3 centre = vec_add(mat_mul(r, box.middle), d->pose.p);
    scene_obstacle o = {.source = source, .ignored = {d->ignored[0], d->ignored[1]}};
    write_vec(o.centre, centre);
    write_vec(&o.rotation[0], r.x), write_vec(&o.rotation[3], r.y), write_vec(&o.rotation[6], r.z);
    write_vec(o.half, box.half);
    double size = vec_norm(box.half) + s->radius + d->widen_m;
    o.radius = s->radius + d->widen_m + shape_excess(s);
    o.radius += OFF * (size + vec_norm(centre) + vec_norm(box.middle));
    o.bound = (vec_norm(box.half) + o.radius) * (1 + OFF);
    o.form = s->type == SHAPE_CYLINDER || s->type == SHAPE_CONE ? SCENE_CYLINDER : SCENE_BOX;
    if (s->type == SHAPE_HALFSPACE) o.form = SCENE_HALFSPACE, o.bound = INFINITY;
    return o;
}

typedef struct by_axis {
    double key;
    uint32_t source;
} by_axis;

static int compare_keys(const void *a, const void *b)
{
    const by_axis *x = a, *y = b;
    if (x->key != y->key) return x->key < y->key ? -1 : 1;
    return x->source < y->source ? -1 : x->source > y->source;
}

static void close_group(scene *s, uint32_t first, uint32_t count)
{
    scene_group *g = &s->groups[s->group_count++];
    g->first = first, g->count = count;
    g->ignored[0] = g->ignored[1] = UINT64_MAX;
    double lo[3], hi[3];
    for (int k = 0; k < 3; k++) lo[k] = INFINITY, hi[k] = -INFINITY;
    for (uint32_t i = first; i < first + count; i++)
        for (int k = 0; k < 3; k++) {
            lo[k] = fmin(lo[k], s->obstacles[i].centre[k]);
            hi[k] = fmax(hi[k], s->obstacles[i].centre[k]);
        }
    for (uint32_t i = first; i < first + count; i++)
        for (int k = 0; k < 2; k++) g->ignored[k] &= s->obstacles[i].ignored[k];
    for (int k = 0; k < 3; k++) g->centre[k] = 0.5 * (lo[k] + hi[k]);
    g->bound = 0;
    for (uint32_t i = first; i < first + count; i++) {
        const scene_obstacle *o = &s->obstacles[i];
        vec3 d = vec(o->centre[0] - g->centre[0], o->centre[1] - g->centre[1], o->centre[2] - g->centre[2]);
        g->bound = fmax(g->bound, (vec_norm(d) + o->bound) * (1 + OFF));
    }
    g->bound += OFF * (fabs(g->centre[0]) + fabs(g->centre[1]) + fabs(g->centre[2]));
}

/* Halves along the longest axis, until a group is small enough. */
static void arrange(scene *s, scene_obstacle *at, uint32_t count, by_axis *keys, scene_obstacle *spare)
{
    if (count <= SCENE_GROUP) {
        close_group(s, (uint32_t)(at - s->obstacles), count);
        return;
    }
    double lo[3], hi[3];
    memcpy(lo, at[0].centre, sizeof lo), memcpy(hi, at[0].centre, sizeof hi);
    for (uint32_t i = 1; i < count; i++)
        for (int k = 0; k < 3; k++) lo[k] = fmin(lo[k], at[i].centre[k]), hi[k] = fmax(hi[k], at[i].centre[k]);
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (hi[k] - lo[k] > hi[axis] - lo[axis]) axis = k;
    for (uint32_t i = 0; i < count; i++) keys[i] = (by_axis){at[i].centre[axis], i};
    qsort(keys, count, sizeof *keys, compare_keys);
    memcpy(spare, at, count * sizeof *at);
    for (uint32_t i = 0; i < count; i++) at[i] = spare[keys[i].source];
    uint32_t left = count / 2 / SCENE_GROUP * SCENE_GROUP;
    if (left == 0) left = count / 2;
    arrange(s, at, left, keys, spare);
    arrange(s, at + left, count - left, keys, spare);
}

scene *scene_create(const scene_obstacle_def *defs, size_t count, double reach)
{
    scene *s = base_zalloc(1, sizeof *s);
    s->defs = base_alloc(count + 1, sizeof *s->defs);
    if (count > 0) memcpy(s->defs, defs, count * sizeof *defs);
    s->def_count = count;
    s->obstacles = base_alloc(count + 1, sizeof *s->obstacles);
    s->groups = base_alloc(count + 2, sizeof *s->groups);
    uint32_t bounded = 0, endless = 0;
    for (size_t i = 0; i < count; i++) {
        scene_obstacle o = prepare_obstacle(&defs[i], (uint32_t)i);
        vec3 c = vec(o.centre[0], o.centre[1], o.centre[2]);
        if (o.form == SCENE_HALFSPACE)
            endless++;
        else if (vec_norm(c) * (1 - OFF) - o.bound <= reach)
            s->obstacles[bounded++] = o;
    }
    s->obstacle_count = bounded;
    if (bounded > 0) {
        by_axis *keys = base_alloc(bounded, sizeof *keys);
        scene_obstacle *spare = base_alloc(bounded, sizeof *spare);
        arrange(s, s->obstacles, bounded, keys, spare);
        free(keys);
        free(spare);
    }
    for (size_t i = 0; i < count && endless > 0; i++) {
        if (defs[i].shape->type != SHAPE_HALFSPACE) continue;
        s->obstacles[s->obstacle_count] = prepare_obstacle(&defs[i], (uint32_t)i);
        close_group(s, (uint32_t)s->obstacle_count++, 1);
    }
    return s;
}

void scene_destroy(scene *s)
{
    if (!s) return;
    free(s->defs);
    free(s->obstacles);
    free(s->groups);
    free(s);
}

LANES_INLINE lanes lanes_above_zero(lanes a)
{
    return lanes_choose(a > 0, a, lanes_of(0));
}
LANES_INLINE bool lanes_any(lane_mask m)
{
    return (m[0] | m[1] | m[2] | m[3]) != 0;
}

/* Is the ball around something farther than the clearance from all four balls? */
LANES_INLINE bool is_passed_by(const double centre[3], double bound, const lanes c[3], lanes radius, lanes clearance)
{
    lanes dx = c[0] - centre[0], dy = c[1] - centre[1], dz = c[2] - centre[2];
    lanes within = clearance + radius + bound;
    return !lanes_any((dx * dx + dy * dy + dz * dz < within * within) & (within > 0));
}

/* The distance of four points from a simple body; negative, or zero, within. */
LANES_INLINE lanes distance_to(const scene_obstacle *o, const lanes c[3])
{
    lanes d[3] = {c[0] - o->centre[0], c[1] - o->centre[1], c[2] - o->centre[2]}, local[3];
    for (int k = 0; k < 3; k++)
        local[k] = d[0] * o->rotation[3 * k] + d[1] * o->rotation[3 * k + 1] + d[2] * o->rotation[3 * k + 2];
    if (o->form == SCENE_HALFSPACE) return local[2];
    lanes z = lanes_above_zero(lanes_abs(local[2]) - o->half[2]);
    if (o->form == SCENE_CYLINDER) {
        lanes r = lanes_sqrt(local[0] * local[0] + local[1] * local[1]) - o->half[0];
        r = lanes_above_zero(r);
        return lanes_sqrt(r * r + z * z);
    }
    lanes x = lanes_above_zero(lanes_abs(local[0]) - o->half[0]),
          y = lanes_above_zero(lanes_abs(local[1]) - o->half[1]);
    return lanes_sqrt(x * x + y * y + z * z);
}

LANES_INLINE bool is_ignored(const uint64_t ignored[2], unsigned link)
{
    return ignored[link >> 6] >> (link & 63) & 1;
}

LANES_INLINE void clearance_any(const scene *s, unsigned link, const lanes c[3], const lanes *balls, lanes *clearance)
{
    const lanes radius = *balls;
    lanes best = *clearance;
    for (size_t g = 0; g < s->group_count; g++) {
        const scene_group *group = &s->groups[g];
        if (is_ignored(group->ignored, link) || is_passed_by(group->centre, group->bound, c, radius, best)) continue;
        for (uint32_t i = group->first; i < group->first + group->count; i++) {
            const scene_obstacle *o = &s->obstacles[i];
            if (is_passed_by(o->centre, o->bound, c, radius, best) || is_ignored(o->ignored, link)) continue;
            lanes gap = distance_to(o, c) - o->radius - radius;
            best = lanes_choose(gap < best, gap, best);
        }
    }
    *clearance = best;
}

/* Vectors go by their address: how they are passed otherwise differs between the two kinds of functions. */
static void clearance_plain(const scene *s, unsigned link, const lanes c[3], const lanes *radius, lanes *clearance)
{
    clearance_any(s, link, c, radius, clearance);
}
LANES_WHOLE static void clearance_wide(
    const scene *s, unsigned link, const lanes c[3], const lanes *radius, lanes *clearance)
{
    clearance_any(s, link, c, radius, clearance);
}

void scene_clearance(const scene *s, unsigned link, const lanes centre[3], const lanes *radius, lanes *clearance)
{
    (lanes_wide() ? clearance_wide : clearance_plain)(s, link, centre, radius, clearance);
}

size_t scene_near(
    const scene *s, unsigned link, vec3 centre, double radius, double within, uint32_t *found, size_t most)
{
    const lanes c[3] = {(lanes){0} + centre.x, (lanes){0} + centre.y, (lanes){0} + centre.z};
    const lanes r = (lanes){0} + radius, limit = (lanes){0} + within;
    size_t count = 0;
    for (size_t g = 0; g < s->group_count; g++) {
        const scene_group *group = &s->groups[g];
        if (is_ignored(group->ignored, link) || is_passed_by(group->centre, group->bound, c, r, limit)) continue;
        for (uint32_t i = group->first; i < group->first + group->count; i++) {
            const scene_obstacle *o = &s->obstacles[i];
            if (is_passed_by(o->centre, o->bound, c, r, limit) || is_ignored(o->ignored, link)) continue;
            if ((distance_to(o, c) - o->radius - r)[0] >= within) continue;
            if (count < most) found[count] = i;
            count++;
        }
    }
    return count;
}
