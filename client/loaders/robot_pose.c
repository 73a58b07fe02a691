/* robot_pose: forward kinematics. Pure; any thread. */
#include "rigid.h"
#include "robot.h"

/* urdf_make_tree saw to it that chains of mimic joints end. */
double robot_joint_value(const robot *b, int joint, const double *values)
{
    const urdf *u = &b->model;
    const urdf_joint *j = &u->joints[joint];
    if (j->mimic < 0) return values[joint];
    double factor = j->mimic_factor, offset = j->mimic_offset;
    for (joint = j->mimic; u->joints[joint].mimic >= 0; joint = u->joints[joint].mimic) {
        offset += factor * u->joints[joint].mimic_offset;
        factor *= u->joints[joint].mimic_factor;
    }
    return factor * values[joint] + offset;
}

static collided_pose joint_motion(const urdf_joint *j, double value)
{
    collided_pose motion = rigid_identity();
    switch (j->type) {
    case URDF_FIXED:
        break;
    case URDF_REVOLUTE:
    case URDF_CONTINUOUS:
        rigid_about(j->axis, value, motion.orientation);
        break;
    case URDF_PRISMATIC:
        for (int i = 0; i < 3; i++) motion.position[i] = value * j->axis[i];
        break;
    }
    return motion;
}

void robot_forward(const robot *b, const double *values, collided_pose *links)
{
    const urdf *u = &b->model;
    links[u->root] = rigid_identity();
    for (int i = 0; i < u->joint_count; i++) {
        const urdf_joint *j = &u->joints[u->order[i]];
        collided_pose motion = joint_motion(j, robot_joint_value(b, u->order[i], values));
        links[j->child] = collided_pose_product(links[j->parent], collided_pose_product(j->origin, motion));
    }
}

size_t robot_body_count(const robot *b)
{
    size_t count = 0;
    for (int i = 0; i < b->model.link_count; i++) count += b->model.links[i].shape_count > 0;
    return count;
}

void robot_body_poses(const robot *b, collided_pose base, const double *values, collided_pose *out)
{
    pool work = {0};
    collided_pose *links = pool_alloc(&work, (size_t)b->model.link_count, sizeof *links);
    robot_forward(b, values, links);
    for (int i = 0; i < b->model.link_count; i++)
        if (b->model.links[i].shape_count > 0) *out++ = collided_pose_product(base, links[i]);
    pool_free(&work);
}
