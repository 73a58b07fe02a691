/* never_path: up from both links to the first that both hang from. */
#include "never_path.h"

#include "loaders/rigid.h"

#include <string.h>

static const double ONCE_AROUND = 0x1.921fb54442d19p+1; /* pi, rounded up */

static int parent(const urdf *u, int link)
{
    return u->links[link].joint < 0 ? -1 : u->joints[u->links[link].joint].parent;
}

static bool hangs_from(const urdf *u, int link, int root)
{
    for (; link >= 0; link = parent(u, link))
        if (link == root) return true;
    return false;
}

static bool add_variable(never_path *p, int joint, double lo, double hi, never_joint *out)
{
    for (int i = 0; i < p->variable_count; i++)
        if (p->variable_joint[i] == joint) {
            out->variable = i;
            return true;
        }
    p->variable_joint[p->variable_count] = joint;
    p->lo[p->variable_count] = lo;
    p->hi[p->variable_count] = hi;
    out->variable = p->variable_count++;
    return true;
}

/* What one that mimics a joint without limits comes to is not bounded; where it turns, once around is all the same. */
static bool add_joint(never_path *p, int joint, bool upward)
{
    const urdf_joint *own = &p->u->joints[joint];
    if (own->type == URDF_FIXED) return !own->stands_still;
    if (p->joint_count == NEVER_JOINTS_MAX) return false;
    never_joint *j = &p->joints[p->joint_count++];
    *j = (never_joint){.joint = joint, .factor = 1, .upward = upward};
    int root = joint;
    for (; p->u->joints[root].mimic >= 0; root = p->u->joints[root].mimic) {
        j->offset += j->factor * p->u->joints[root].mimic_offset;
        j->factor *= p->u->joints[root].mimic_factor;
    }
    const urdf_joint *free_one = &p->u->joints[root];
    if (free_one->limited) return add_variable(p, root, free_one->lower, free_one->upper, j);
    j->factor = 1;
    j->offset = 0;
    return own->type != URDF_PRISMATIC && add_variable(p, joint, -ONCE_AROUND, ONCE_AROUND, j);
}

bool never_path_make(const urdf *u, int a, int b, never_path *out)
{
    int down[NEVER_JOINTS_MAX], count = 0;
    *out = (never_path){.u = u, .a = a, .b = b};
    int common = a;
    for (; !hangs_from(u, b, common); common = parent(u, common))
        if (!add_joint(out, u->links[common].joint, true)) return false;
    out->common = common;
    for (int link = b; link != common; link = parent(u, link)) {
        const urdf_joint *j = &u->joints[u->links[link].joint];
        if (j->type == URDF_FIXED && !j->stands_still) continue;
        if (count == NEVER_JOINTS_MAX) return false;
        down[count++] = u->links[link].joint;
    }
    while (count > 0)
        if (!add_joint(out, down[--count], false)) return false;
    return true;
}

static collided_pose moved(const urdf_joint *j, double value)
{
    collided_pose motion = rigid_identity();
    if (j->type == URDF_PRISMATIC)
        for (int k = 0; k < 3; k++) motion.position[k] = value * j->axis[k];
    else if (j->type != URDF_FIXED)
        rigid_about(j->axis, value, motion.orientation);
    return collided_pose_product(j->origin, motion);
}

/* Pose of a link in the common link's frame; fills in the joints on its way, which are numbered from there. */
static collided_pose place_branch(const never_path *p, const double *variables, int link, bool upward, never_place *out)
{
    int way[URDF_LINKS_MAX], count = 0;
    for (int at = link; at != p->common; at = parent(p->u, at)) way[count++] = p->u->links[at].joint;
    collided_pose pose = rigid_identity();
    while (count-- > 0) {
        const urdf_joint *j = &p->u->joints[way[count]];
        double value = 0;
        for (int i = 0; i < p->joint_count; i++) {
            const never_joint *own = &p->joints[i];
            if (own->joint != way[count] || own->upward != upward) continue;
            value = own->factor * variables[own->variable] + own->offset;
            collided_pose frame = collided_pose_product(pose, j->origin);
            memcpy(out->origin[i], frame.position, sizeof frame.position);
            rigid_rotate(frame.orientation, j->axis, out->axis[i]);
        }
        pose = collided_pose_product(pose, moved(j, value));
    }
    return pose;
}

void never_path_place(const never_path *p, const double *variables, never_place *out)
{
    out->a = place_branch(p, variables, p->a, true, out);
    out->b = place_branch(p, variables, p->b, false, out);
}
