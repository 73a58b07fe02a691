/* Any bytes as a URDF: refused with one line, or the tree that urdf.h promises. */
#include "fuzz.h"

#include "loaders/urdf.h"

#include <string.h>

/* One root; every other link is the child of one joint, which comes after the joint that leads to its parent. */
static void expect_tree(const urdf *u)
{
    bool *reached = calloc((size_t)u->link_count, sizeof *reached);
    PROMISE(u->link_count >= 1 && u->link_count <= URDF_LINKS_MAX && u->joint_count == u->link_count - 1);
    PROMISE(u->root >= 0 && u->root < u->link_count && u->links[u->root].joint == -1);
    reached[u->root] = true;
    for (int i = 0; i < u->joint_count; i++) {
        const urdf_joint *j = &u->joints[u->order[i]];
        PROMISE(reached[j->parent] && !reached[j->child]);
        PROMISE(u->links[j->child].joint == u->order[i]);
        PROMISE(j->mimic >= -1 && j->mimic < u->joint_count);
        reached[j->child] = true;
    }
    free(reached);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pool p = {0};
    load_report r = {.error = ""};
    urdf u;
    bool good = urdf_parse(&u, &p, (const char *)data, size, "fuzz.urdf", &r);
    PROMISE(good == !r.error[0] && !strchr(r.error, '\n'));
    if (good) expect_tree(&u);
    pool_free(&p);
    return 0;
}
