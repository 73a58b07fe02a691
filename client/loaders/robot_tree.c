/* robot_tree: see robot_tree.h. Link 0 is the root, fixed to the base; the others follow in the URDF's order of joints,
 * each behind its parent. */
#include "robot_tree.h"
#include "rigid.h"

#include <string.h>

enum { JOINTS_MAX = 128, TRAVEL_MAX = 1000000 /* m, of a slide without limits */ };

static const collided_joint_type types[] = {[URDF_FIXED] = COLLIDED_JOINT_FIXED,
    [URDF_REVOLUTE] = COLLIDED_JOINT_REVOLUTE,
    [URDF_CONTINUOUS] = COLLIDED_JOINT_CONTINUOUS,
    [URDF_PRISMATIC] = COLLIDED_JOINT_PRISMATIC};

static const char *body_of_link(const robot *r, int link, pool *p)
{
    return r->model.links[link].shape_count > 0 ? robot_body_name(r, link, p) : NULL;
}

/* The joint at the end of a chain of mimics, and what becomes of its value on the way. */
static void resolve_mimic(const urdf *u, const urdf_joint *j, const int *place, collided_joint *out)
{
    double factor = j->mimic_factor, offset = j->mimic_offset;
    int of = j->mimic;
    for (; u->joints[of].mimic >= 0; of = u->joints[of].mimic) {
        offset += factor * u->joints[of].mimic_offset;
        factor *= u->joints[of].mimic_factor;
    }
    out->mimics = true;
    out->mimic = place[of];
    out->factor = factor;
    out->offset = offset;
}

static void make_joint(const urdf *u, const urdf_joint *j, const int *place, collided_joint *out)
{
    *out = (collided_joint){.parent = u->links[j->parent].joint < 0 ? 0 : place[u->links[j->parent].joint],
        .type = types[j->type],
        .origin = j->origin,
        .lower = j->lower,
        .upper = j->upper};
    memcpy(out->axis, j->axis, sizeof out->axis);
    if (!j->limited && j->type == URDF_REVOLUTE) out->type = COLLIDED_JOINT_CONTINUOUS;
    if (!j->limited && j->type == URDF_PRISMATIC) out->lower = -TRAVEL_MAX, out->upper = TRAVEL_MAX;
    if (j->mimic >= 0 && j->type != URDF_FIXED) resolve_mimic(u, j, place, out);
}

bool robot_make_tree(const robot *r, collided_pose base, pool *p, robot_checked *out, load_report *report)
{
    const urdf *u = &r->model;
    if (u->link_count > JOINTS_MAX)
        return load_fail(report, "%s: %d links: a check takes at most %d", u->file, u->link_count, JOINTS_MAX);
    collided_joint *joints = pool_alloc(p, (size_t)u->link_count, sizeof *joints);
    int *place = pool_alloc(p, (size_t)u->joint_count + 1, sizeof *place);
    out->joints = pool_alloc(p, (size_t)u->joint_count + 1, sizeof *out->joints);
    out->coordinates = 0;
    joints[0] = (collided_joint){.parent = -1, .origin = rigid_identity(), .body = body_of_link(r, u->root, p)};
    for (int i = 0; i < u->joint_count; i++) place[u->order[i]] = i + 1;
    for (int i = 0; i < u->joint_count; i++) {
        collided_joint *j = &joints[i + 1];
        make_joint(u, &u->joints[u->order[i]], place, j);
        j->body = body_of_link(r, u->joints[u->order[i]].child, p);
        if (j->type != COLLIDED_JOINT_FIXED && !j->mimics) out->joints[out->coordinates++] = u->order[i];
    }
    out->robot = (collided_robot){joints, (size_t)u->joint_count + 1, base};
    return true;
}

void robot_configuration(const robot_checked *t, const double *values, double *out)
{
    for (size_t i = 0; i < t->coordinates; i++) out[i] = values[t->joints[i]];
}
