/* robot_draws: see robot_draws.h. */
#include "robot_draws.h"

#include "geom/random_shapes.h"

#include <stdlib.h>
#include <string.h>

#define HALF_PI 1.5707963267948966

static pose at(double x, double y, double z, double roll)
{
    return (pose){vec(x, y, z), {cos(roll / 2), sin(roll / 2), 0, 0}};
}

static void put_shape(robot_draw *d, uint32_t link, shape s, pose p)
{
    d->shapes[d->shape_count] = s;
    d->placed[d->shape_count] = (check_shape){link, &d->shapes[d->shape_count], p};
    d->shape_count++;
}

static shape rod(double radius, double half)
{
    return (shape){.type = SHAPE_CAPSULE, .radius = radius, .half = {0, 0, half}};
}

static void finish_robot(robot_draw *d)
{
    robot_status status;
    size_t where;
    check_fault fault;
    d->tree = robot_tree_create(d->joints, d->joint_count, &status, &where);
    if (!d->tree) abort();
    d->robot = check_robot_create(d->tree, d->placed, d->shape_count, d->pairs, d->pair_count, &fault);
    if (!d->robot) abort();
}

/* All links that are farther than two joints from each other. */
static void pair_all(robot_draw *d)
{
    for (uint32_t a = 0; a < d->joint_count; a++)
        for (uint32_t b = a + 1; b < d->joint_count; b++) {
            int32_t pa = d->joints[a].parent, pb = d->joints[b].parent;
            int32_t ppb = pb < 0 ? -1 : d->joints[pb].parent;
            if (pb == (int32_t)a || pa == pb || ppb == (int32_t)a || d->pair_count == DRAW_PAIRS) continue;
            d->pairs[d->pair_count++] = (check_pair){a, b};
        }
}

void draw_arm(robot_draw *d)
{
    draw_arm_with_pole(d, 0);
}

void draw_arm_with_pole(robot_draw *d, double length)
{
    memset(d, 0, sizeof *d);
    static const double lower[] = {-2.8973, -1.7628, -2.8973, -3.0718, -2.8973, -0.0175, -2.8973};
    static const double upper[] = {2.8973, 1.7628, 2.8973, -0.0698, 2.8973, 3.7525, 2.8973};
    const pose origins[] = {at(0, 0, 0.333, 0), at(0, 0, 0, -HALF_PI), at(0, -0.316, 0, HALF_PI),
        at(0.0825, 0, 0, HALF_PI), at(-0.0825, 0.384, 0, -HALF_PI), at(0, 0, 0, HALF_PI), at(0.088, 0, 0, HALF_PI)};
    d->joints[0] = (robot_joint){.parent = -1, .type = ROBOT_FIXED, .origin = POSE_IDENTITY, .mimic = -1};
    for (int i = 0; i < 7; i++)
        d->joints[1 + i] = (robot_joint){i, ROBOT_REVOLUTE, origins[i], {0, 0, 1}, lower[i], upper[i], -1, 0, 0};
    pose hand = {{0, 0, 0.107}, {cos(HALF_PI / 4), 0, 0, -sin(HALF_PI / 4)}};
    d->joints[8] = (robot_joint){.parent = 7, .type = ROBOT_FIXED, .origin = hand, .mimic = -1};
    d->joints[9] = (robot_joint){8, ROBOT_PRISMATIC, at(0, 0, 0.0584, 0), {0, 1, 0}, 0, 0.04, -1, 0, 0};
    d->joints[10] = (robot_joint){8, ROBOT_PRISMATIC, at(0, 0, 0.0584, 0), {0, -1, 0}, 0, 0.04, 9, 1, 0};
    d->joint_count = 11;
    uint64_t seed = 5;
    shape wrist = {.type = SHAPE_HULL, .hull = d->hulls[d->hull_count++] = random_hull(&seed, 40, 0.07, true)};
    put_shape(d, 0, (shape){.type = SHAPE_BOX, .half = {0.12, 0.1, 0.07}}, at(-0.05, 0, 0.07, 0));
    put_shape(d, 1, rod(0.06, 0.14), at(0, 0, -0.15, 0));
    put_shape(d, 2, rod(0.06, 0.06), at(0, 0, 0, 0));
    put_shape(d, 3, rod(0.06, 0.075), at(0, 0, -0.145, 0));
    put_shape(d, 4, rod(0.06, 0.06), at(0, 0, 0, 0));
    put_shape(d, 5, (shape){.type = SHAPE_CYLINDER, .half = {0.05, 0.05, 0.1}}, at(0, 0, -0.26, 0));
    put_shape(d, 5, rod(0.025, 0.09), at(0, 0.08, -0.13, 0));
    put_shape(d, 6, wrist, at(0, 0, -0.01, 0));
    put_shape(d, 7, rod(0.04, 0.07), at(0, 0, 0.01, 0));
    put_shape(d, 8, (shape){.type = SHAPE_BOX, .half = {0.03, 0.1, 0.033}, .radius = 0.002}, at(0, 0, 0.033, 0));
    put_shape(d, 9, (shape){.type = SHAPE_BOX, .half = {0.01, 0.0075, 0.027}}, at(0, 0.0075, 0.027, 0));
    put_shape(d, 10, (shape){.type = SHAPE_BOX, .half = {0.01, 0.0075, 0.027}}, at(0, -0.0075, 0.027, 0));
    if (length > 0) put_shape(d, 8, rod(0.001, length / 2), at(0, 0, 0.1 + length / 2, 0));
    pair_all(d);
    finish_robot(d);
}

static shape any_shape(uint64_t *seed, robot_draw *d, double size)
{
    if (prng_bits(seed) % 5 == 0) return rod(0.001, prng_in(seed, 0.1, 1));
    if (prng_bits(seed) % 4 == 0) {
        hull *h = random_hull(seed, 8 + prng_bits(seed) % 30, size, prng_bits(seed) % 2);
        if (h) return d->hulls[d->hull_count++] = h, (shape){.type = SHAPE_HULL, .hull = h};
    }
    return random_plain_shape(seed, size);
}

void draw_robot(uint64_t *seed, robot_draw *d)
{
    memset(d, 0, sizeof *d);
    d->joint_count = 2 + prng_bits(seed) % (DRAW_LINKS - 1);
    for (size_t i = 0; i < d->joint_count; i++) {
        robot_joint *j = &d->joints[i];
        *j = (robot_joint){
            .parent = (int32_t)i - 1, .origin = random_pose(seed, prng_bits(seed) % 4 ? 0.3 : 0), .mimic = -1};
        if (i > 0 && prng_bits(seed) % 4 == 0) j->parent = (int32_t)(prng_bits(seed) % (i + 1)) - 1;
        static const robot_joint_type types[] = {
            ROBOT_REVOLUTE, ROBOT_REVOLUTE, ROBOT_REVOLUTE, ROBOT_CONTINUOUS, ROBOT_PRISMATIC, ROBOT_FIXED};
        j->type = types[prng_bits(seed) % 6];
        j->axis = prng_bits(seed) % 3 ? vec(0, 0, prng_bits(seed) % 2 ? 1 : -2) : random_unit(seed);
        double most = j->type == ROBOT_PRISMATIC ? 0.3 : 3;
        j->lower = -prng_in(seed, 0, most), j->upper = prng_in(seed, 0, most);
        for (size_t k = 0; k < i && j->type != ROBOT_FIXED && prng_bits(seed) % 6 == 0; k++)
            if (d->joints[k].type == j->type && d->joints[k].mimic < 0)
                j->mimic = (int32_t)k, j->factor = prng_in(seed, -1.5, 1.5), j->offset = prng_in(seed, -0.1, 0.1);
        if (prng_bits(seed) % 5 > 0) put_shape(d, (uint32_t)i, any_shape(seed, d, 0.15), random_pose(seed, 0.1));
        if (prng_bits(seed) % 5 == 0) put_shape(d, (uint32_t)i, any_shape(seed, d, 0.1), random_pose(seed, 0.4));
    }
    pair_all(d);
    finish_robot(d);
}

void draw_robot_free(robot_draw *d)
{
    check_robot_destroy(d->robot);
    robot_tree_destroy(d->tree);
    for (size_t i = 0; i < d->hull_count; i++) hull_destroy(d->hulls[i]);
}

void draw_scene(uint64_t *seed, double size, size_t count, scene_draw *out)
{
    memset(out, 0, sizeof *out);
    out->count = count;
    for (size_t i = 0; i < count; i++) {
        shape *s = &out->shapes[i];
        switch (prng_bits(seed) % 4) {
        case 0:
            *s = rod(0.001, prng_in(seed, 0.1, 1));
            break;
        case 1:
            *s = random_plain_shape(seed, 0.5);
            break;
        default:
            *s = (shape){.type = SHAPE_BOX, .half = {prng_in(seed, 0.01, 0.3), prng_in(seed, 0.01, 0.2), 0.05}};
        }
        if (i == 0 && prng_bits(seed) % 4 == 0) *s = (shape){.type = SHAPE_HALFSPACE};
        out->defs[i] = (scene_obstacle_def){.shape = s, .pose = random_pose(seed, size)};
        if (s->type == SHAPE_HALFSPACE) out->defs[i].pose = (pose){{0, 0, -0.8 * size}, {1, 0, 0, 0}};
        if (prng_bits(seed) % 8 == 0) out->defs[i].ignored[0] = prng_bits(seed);
    }
}

void draw_configuration(uint64_t *seed, const robot_tree *tree, double *out)
{
    for (size_t c = 0; c < robot_tree_coordinates(tree); c++) {
        double lower, upper;
        robot_tree_limits(tree, c, &lower, &upper);
        out[c] = prng_in(seed, fmax(lower, -4), fmin(upper, 4));
    }
}

static void lower_bounds(
    const shape *a, pose pa, const shape *b, pose pb, narrow_scratch *scratch, double *lo, double *hi)
{
    narrow_request request = {.facts = NARROW_DISTANCE, .tolerance = 1e-9, .range = INFINITY};
    narrow_result result;
    narrow_query_world(a, pa, b, pb, &request, scratch, &result);
    *lo = fmin(*lo, result.lo);
    *hi = fmin(*hi, result.hi);
}

void draw_distance(const robot_draw *d, const scene_draw *s, const double *coordinates, double *lo, double *hi)
{
    narrow_scratch *scratch = aligned_alloc(64, (narrow_scratch_size() + 63) / 64 * 64);
    pose links[DRAW_LINKS];
    robot_tree_forward(d->tree, coordinates, links);
    *lo = *hi = INFINITY;
    for (size_t i = 0; i < d->shape_count; i++) {
        const check_shape *a = &d->placed[i];
        pose pa = pose_mul(links[a->link], a->pose);
        for (size_t k = 0; k < s->count; k++)
            if (!(s->defs[k].ignored[0] >> a->link & 1))
                lower_bounds(a->shape, pa, s->defs[k].shape, s->defs[k].pose, scratch, lo, hi);
        for (size_t k = 0; k < d->shape_count; k++)
            for (size_t p = 0; p < d->pair_count; p++)
                if (d->pairs[p].a == a->link && d->pairs[p].b == d->placed[k].link)
                    lower_bounds(a->shape, pa, d->placed[k].shape,
                        pose_mul(links[d->placed[k].link], d->placed[k].pose), scratch, lo, hi);
    }
    free(scratch);
}
