/* urdf_tree: links and joints must be a tree. A link that no joint moves is a root, and there is exactly one; what
 * cannot be reached from it hangs in a ring. */
#include "urdf.h"

static bool give_each_link_its_joint(urdf *u, load_report *r)
{
    for (int i = 0; i < u->joint_count; i++) {
        const urdf_joint *j = &u->joints[i];
        urdf_link *child = &u->links[j->child];
        if (child->joint >= 0)
            return load_fail(r, "%s:%d: the link '%s' has two parents: joints '%s' and '%s'", u->file, j->line,
                child->name, u->joints[child->joint].name, j->name);
        child->joint = i;
    }
    return true;
}

static bool find_root(urdf *u, load_report *r)
{
    u->root = -1;
    for (int i = 0; i < u->link_count; i++) {
        if (u->links[i].joint >= 0) continue;
        if (u->root >= 0)
            return load_fail(r, "%s:%d: two links have no parent, '%s' and '%s': connect them by a joint", u->file,
                u->links[i].line, u->links[u->root].name, u->links[i].name);
        u->root = i;
    }
    if (u->root >= 0) return true;
    if (u->link_count == 0) return load_fail(r, "%s: has no links", u->file);
    return load_fail(r, "%s:%d: the joints form a ring: no link is without a parent", u->file, u->links[0].line);
}

/* Breadth first from the root; `order` serves as the queue. */
static bool order_joints(urdf *u, pool *p, load_report *r)
{
    bool *reached = pool_alloc(p, (size_t)u->link_count, sizeof *reached);
    u->order = pool_alloc(p, (size_t)u->joint_count, sizeof *u->order);
    int count = 0;
    for (int done = -1; done < count; done++) {
        int link = done < 0 ? u->root : u->joints[u->order[done]].child;
        reached[link] = true;
        for (int i = 0; i < u->joint_count; i++)
            if (u->joints[i].parent == link) u->order[count++] = i;
    }
    for (int i = 0; i < u->link_count; i++)
        if (!reached[i])
            return load_fail(
                r, "%s:%d: the link '%s' hangs in a ring of joints", u->file, u->links[i].line, u->links[i].name);
    return true;
}

static bool check_mimics(const urdf *u, load_report *r)
{
    for (int i = 0; i < u->joint_count; i++) {
        int steps = 0;
        for (int j = i; j >= 0; j = u->joints[j].mimic)
            if (steps++ > u->joint_count)
                return load_fail(
                    r, "%s:%d: joint '%s' mimics itself through others", u->file, u->joints[i].line, u->joints[i].name);
    }
    return true;
}

bool urdf_make_tree(urdf *u, pool *p, load_report *r)
{
    return give_each_link_its_joint(u, r) && find_root(u, r) && order_joints(u, p, r) && check_mimics(u, r);
}
