/* tree: see tree.h. Inside, each link's frame is turned so that its joint's axis is the z-axis: a joint then mixes two
 * columns of the rotation, and no more. */
#include "tree.h"

#include "base/array.h"
#include "turn.h"

#include <stdlib.h>
#include <string.h>

typedef struct tree_joint {
    robot_joint given;
    int32_t coordinate; /* whose value it takes; -1 = fixed */
    double factor, offset;
    quat inner;      /* from the link's frame to the turned one */
    transform fixed; /* the turned frame at value 0 in the parent's turned frame */
    double step;     /* m: how far the origin of the link can be from that of its parent */
    unsigned depth;  /* links from the base, this one included */
} tree_joint;

struct robot_tree {
    size_t links, coordinates;
    tree_joint joints[ROBOT_LINKS_MAX];
    uint8_t joint_of[ROBOT_LINKS_MAX];
};

const char *robot_status_text(robot_status status)
{
    static const char *const texts[] = {
        [ROBOT_OK] = "is in order",
        [ROBOT_NO_LINKS] = "has no links",
        [ROBOT_TOO_MANY_LINKS] = "has more links than 128",
        [ROBOT_BAD_PARENT] = "has a parent that does not come before it",
        [ROBOT_BAD_TYPE] = "has a type that is not known",
        [ROBOT_BAD_ORIGIN] = "has an origin that is no pose, or too far away",
        [ROBOT_BAD_AXIS] = "has an axis that is no direction",
        [ROBOT_BAD_LIMITS] = "has limits that are no range",
        [ROBOT_BAD_MIMIC] = "mimics a joint that does not move by itself",
    };
    return texts[status];
}

static bool is_movable(robot_joint_type type)
{
    return type != ROBOT_FIXED;
}

static bool has_limits(robot_joint_type type)
{
    return type == ROBOT_REVOLUTE || type == ROBOT_PRISMATIC;
}

static robot_status check_joint(const robot_joint *joints, size_t i, size_t count)
{
    const robot_joint *j = &joints[i];
    if (j->parent < -1 || j->parent >= (int32_t)i) return ROBOT_BAD_PARENT;
    if ((unsigned)j->type > ROBOT_PRISMATIC) return ROBOT_BAD_TYPE;
    double norm2 = quat_norm2(j->origin.q);
    if (!vec_finite(j->origin.p) || !(vec_norm(j->origin.p) <= ROBOT_SIZE_MAX) || !(fabs(norm2 - 1) <= 2e-6))
        return ROBOT_BAD_ORIGIN;
    if (!is_movable(j->type)) return j->mimic < 0 ? ROBOT_OK : ROBOT_BAD_MIMIC;
    if (!vec_finite(j->axis) || !(vec_max_abs(j->axis) > 0)) return ROBOT_BAD_AXIS;
    double most = j->type == ROBOT_PRISMATIC ? ROBOT_SIZE_MAX : TURN_ANGLE_MAX;
    if (has_limits(j->type) && !(j->lower >= -most && j->lower <= j->upper && j->upper <= most))
        return ROBOT_BAD_LIMITS;
    if (j->mimic < 0) return ROBOT_OK;
    if (j->mimic >= (int32_t)count || !is_movable(joints[j->mimic].type) || joints[j->mimic].mimic >= 0)
        return ROBOT_BAD_MIMIC;
    return fabs(j->factor) <= 1e6 && fabs(j->offset) <= most ? ROBOT_OK : ROBOT_BAD_MIMIC;
}

/* The turn that takes a unit axis to z. */
static quat turn_to_z(vec3 axis)
{
    if (axis.z <= -0.5) { /* by way of x: half a turn about it takes -z to z */
        quat rest = turn_to_z(vec(axis.x, -axis.y, -axis.z));
        return quat_mul(rest, (quat){0, 1, 0, 0});
    }
    return quat_unit((quat){1 + axis.z, axis.y, -axis.x, 0});
}

/* How far the joint's own value can shift its link. */
static double travel(const robot_joint *j)
{
    return j->type == ROBOT_PRISMATIC ? fmax(fabs(j->lower), fabs(j->upper)) : 0;
}

static void prepare(robot_tree *t, size_t i)
{
    tree_joint *j = &t->joints[i];
    const robot_joint *g = &j->given;
    j->inner = is_movable(g->type) ? turn_to_z(vec_unit(g->axis)) : (quat){1, 0, 0, 0};
    quat outer = g->parent < 0 ? (quat){1, 0, 0, 0} : t->joints[g->parent].inner;
    pose fixed = {
        quat_rotate(outer, g->origin.p), quat_mul(outer, quat_mul(quat_unit(g->origin.q), quat_conj(j->inner)))};
    j->fixed = pose_transform(fixed);
    j->step = (vec_norm(g->origin.p) + travel(g)) * (1 + 0x1p-40);
    j->depth = g->parent < 0 ? 1 : t->joints[g->parent].depth + 1;
}

robot_tree *robot_tree_create(const robot_joint *joints, size_t count, robot_status *status, size_t *where)
{
    *where = 0;
    *status = count == 0 ? ROBOT_NO_LINKS : count > ROBOT_LINKS_MAX ? ROBOT_TOO_MANY_LINKS : ROBOT_OK;
    for (size_t i = 0; i < count && *status == ROBOT_OK; i++) *status = check_joint(joints, *where = i, count);
    if (*status != ROBOT_OK) return NULL;
    robot_tree *t = base_zalloc(1, sizeof *t);
    t->links = count;
    for (size_t i = 0; i < count; i++) {
        tree_joint *j = &t->joints[i];
        j->given = joints[i];
        j->coordinate = -1;
        j->factor = 1;
        if (is_movable(joints[i].type) && joints[i].mimic < 0) {
            t->joint_of[t->coordinates] = (uint8_t)i;
            j->coordinate = (int32_t)t->coordinates++;
        }
    }
    for (size_t i = 0; i < count; i++) {
        tree_joint *j = &t->joints[i];
        if (is_movable(joints[i].type) && joints[i].mimic >= 0) {
            j->coordinate = t->joints[joints[i].mimic].coordinate;
            j->factor = joints[i].factor;
            j->offset = joints[i].offset;
        }
        prepare(t, i);
    }
    return t;
}

void robot_tree_destroy(robot_tree *t)
{
    free(t);
}

size_t robot_tree_links(const robot_tree *t)
{
    return t->links;
}
size_t robot_tree_coordinates(const robot_tree *t)
{
    return t->coordinates;
}
size_t robot_tree_joint_of(const robot_tree *t, size_t coordinate)
{
    return t->joint_of[coordinate];
}
quat robot_tree_inner(const robot_tree *t, size_t link)
{
    return t->joints[link].inner;
}

void robot_tree_limits(const robot_tree *t, size_t coordinate, double *lower, double *upper)
{
    const robot_joint *j = &t->joints[t->joint_of[coordinate]].given;
    *lower = has_limits(j->type) ? j->lower : -TURN_ANGLE_MAX;
    *upper = has_limits(j->type) ? j->upper : TURN_ANGLE_MAX;
}

size_t robot_tree_beyond(const robot_tree *t, const double *coordinates)
{
    for (size_t c = 0; c < t->coordinates; c++) {
        double lower, upper;
        robot_tree_limits(t, c, &lower, &upper);
        if (!(coordinates[c] >= lower - 1e-9 && coordinates[c] <= upper + 1e-9)) return c;
    }
    return SIZE_MAX;
}

static lanes value_lanes(const tree_joint *j, const lanes *coordinates)
{
    return coordinates[j->coordinate] * j->factor + j->offset;
}

/* out = parent times fixed. */
LANES_INLINE void mount(const robot_frames *parent, const transform *fixed, robot_frames *out)
{
    for (int k = 0; k < 3; k++) {
        const lanes *x = &parent->x[k], *y = &parent->y[k], *z = &parent->z[k];
        out->x[k] = *x * fixed->r.x.x + *y * fixed->r.x.y + *z * fixed->r.x.z;
        out->y[k] = *x * fixed->r.y.x + *y * fixed->r.y.y + *z * fixed->r.y.z;
        out->z[k] = *x * fixed->r.z.x + *y * fixed->r.z.y + *z * fixed->r.z.z;
        out->p[k] = parent->p[k] + (*x * fixed->t.x + *y * fixed->t.y + *z * fixed->t.z);
    }
}

LANES_INLINE void forward_any(const robot_tree *t, const lanes *coordinates, robot_frames *out)
{
    const lanes zero = {0}, one = zero + 1;
    const robot_frames base = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}, {zero, zero, zero}};
    for (size_t i = 0; i < t->links; i++) {
        const tree_joint *j = &t->joints[i];
        robot_frames *f = &out[i];
        mount(j->given.parent < 0 ? &base : &out[j->given.parent], &j->fixed, f);
        if (j->coordinate < 0) continue;
        lanes value = value_lanes(j, coordinates);
        if (j->given.type == ROBOT_PRISMATIC) {
            for (int k = 0; k < 3; k++) f->p[k] += f->z[k] * value;
            continue;
        }
        lanes s, c;
        turn_sin_cos(value, &s, &c);
        for (int k = 0; k < 3; k++) {
            lanes x = f->x[k], y = f->y[k];
            f->x[k] = x * c + y * s;
            f->y[k] = y * c - x * s;
        }
    }
}

static void forward_plain(const robot_tree *t, const lanes *coordinates, robot_frames *out)
{
    forward_any(t, coordinates, out);
}

LANES_WHOLE static void forward_wide(const robot_tree *t, const lanes *coordinates, robot_frames *out)
{
    forward_any(t, coordinates, out);
}

void robot_tree_forward_lanes(const robot_tree *t, const lanes *coordinates, robot_frames *out)
{
    (lanes_wide() ? forward_wide : forward_plain)(t, coordinates, out);
}

void robot_tree_forward(const robot_tree *t, const double *coordinates, pose *out)
{
    for (size_t i = 0; i < t->links; i++) {
        const tree_joint *j = &t->joints[i];
        pose at = {j->given.origin.p, quat_unit(j->given.origin.q)};
        if (j->coordinate >= 0) {
            double value = coordinates[j->coordinate] * j->factor + j->offset;
            vec3 axis = vec_unit(j->given.axis);
            if (j->given.type == ROBOT_PRISMATIC) {
                at.p = vec_add(at.p, quat_rotate(at.q, vec_scale(axis, value)));
            } else {
                lanes s, c, half = {0.5 * value, 0, 0, 0};
                turn_sin_cos(half, &s, &c);
                at.q = quat_mul(at.q, (quat){c[0], axis.x * s[0], axis.y * s[0], axis.z * s[0]});
            }
        }
        out[i] = j->given.parent < 0 ? at : pose_mul(out[j->given.parent], at);
        out[i].q = quat_settled(out[i].q);
    }
}

size_t robot_tree_unusable(const robot_tree *t, const double *coordinates)
{
    for (size_t i = 0; i < t->links; i++) {
        const tree_joint *j = &t->joints[i];
        if (j->coordinate < 0) continue;
        double value = coordinates[j->coordinate] * j->factor + j->offset;
        double most = j->given.type == ROBOT_PRISMATIC ? ROBOT_SIZE_MAX : TURN_ANGLE_MAX;
        if (!(fabs(value) <= most)) return (size_t)j->coordinate;
    }
    return SIZE_MAX;
}

void robot_tree_velocities(const robot_tree *t, const double *rates, const pose *at, vec3 *linear, vec3 *angular)
{
    for (size_t i = 0; i < t->links; i++) {
        const tree_joint *j = &t->joints[i];
        int32_t parent = j->given.parent;
        vec3 turn = parent < 0 ? VEC_ZERO : angular[parent];
        vec3 arm = parent < 0 ? at[i].p : vec_sub(at[i].p, at[parent].p);
        linear[i] = vec_add(parent < 0 ? VEC_ZERO : linear[parent], vec_cross(turn, arm));
        angular[i] = turn;
        if (j->coordinate < 0) continue;
        vec3 own = vec_scale(quat_rotate(at[i].q, vec_unit(j->given.axis)), rates[j->coordinate] * j->factor);
        vec3 *moved = j->given.type == ROBOT_PRISMATIC ? &linear[i] : &angular[i];
        *moved = vec_add(*moved, own);
    }
}

double robot_tree_reach(const robot_tree *t, size_t link, double reach)
{
    for (int32_t i = (int32_t)link; i >= 0; i = t->joints[i].given.parent) reach += t->joints[i].step;
    return reach * (1 + 0x1p-40);
}

double robot_tree_slack(const robot_tree *t, size_t link, double reach)
{
    return 64 * 0x1p-53 * t->joints[link].depth * robot_tree_reach(t, link, reach);
}

static robot_lever lever_of(const tree_joint *j, double arm)
{
    bool turns = j->given.type != ROBOT_PRISMATIC;
    return (robot_lever){(uint32_t)j->coordinate, fabs(j->factor), turns ? arm * (1 + 0x1p-40) : 1, turns};
}

/* From the link of the point towards the base the arm grows by each step: the origin of a link lies on the axis of its
 * joint. On the other side of the first link that both hang at, the joints come in the opposite order, and so do the
 * steps. */
size_t robot_tree_levers(const robot_tree *t, int32_t from, uint32_t link, double reach, robot_lever *out)
{
    bool above[ROBOT_LINKS_MAX] = {false};
    for (int32_t i = from; i >= 0; i = t->joints[i].given.parent) above[i] = true;
    robot_lever behind[ROBOT_LINKS_MAX];
    size_t behind_count = 0, before_count = 0, count = 0;
    double arm = reach;
    int32_t meet = (int32_t)link;
    for (; meet >= 0 && !above[meet]; meet = t->joints[meet].given.parent) {
        if (t->joints[meet].coordinate >= 0) behind[behind_count++] = lever_of(&t->joints[meet], arm);
        arm += t->joints[meet].step;
    }
    int32_t chain[ROBOT_LINKS_MAX];
    for (int32_t i = from; i >= 0 && i != meet; i = t->joints[i].given.parent) chain[before_count++] = i;
    robot_lever before[ROBOT_LINKS_MAX];
    size_t filled = 0;
    for (size_t k = before_count; k-- > 0;) { /* from where both hang towards `from` */
        const tree_joint *j = &t->joints[chain[k]];
        arm += j->step;
        if (j->coordinate >= 0) before[filled++] = lever_of(j, arm);
    }
    while (filled-- > 0) out[count++] = before[filled];
    while (behind_count-- > 0) out[count++] = behind[behind_count];
    return count;
}

double robot_levers_bend(const robot_lever *levers, size_t count, const double *change)
{
    double bend = 0, before = 0; /* turns between the first link and here */
    for (size_t i = 0; i < count; i++) {
        double rate = fabs(change[levers[i].coordinate]) * levers[i].factor;
        bend += rate * levers[i].arm * ((levers[i].turns ? rate : 0) + 2 * before);
        if (levers[i].turns) before += rate;
    }
    return bend * (1 + 0x1p-40);
}

double robot_levers_way(const robot_lever *levers, size_t count, const double *change)
{
    double way = 0;
    for (size_t i = 0; i < count; i++) way += fabs(change[levers[i].coordinate]) * levers[i].factor * levers[i].arm;
    return way * (1 + 0x1p-40);
}
