/* recall: see recall.h. */
#include "recall.h"

#include <sysexits.h>

int recall_robot(
    ctl *c, const store *s, const char *verb, const char *name, store_robot **of, robot *out, double **values)
{
    *of = store_find_robot(s, name);
    if (!*of)
        return ctl_fail(
            EX_DATAERR, "%s: no robot '%s' was loaded as '%s': load its URDF first", verb, name, c->options.as);
    const store_robot *from = *of;
    robot_source *source = pool_alloc(&c->pool, 1, sizeof *source);
    *source = (robot_source){.urdf = from->urdf,
        .srdf = *from->srdf ? from->srdf : NULL,
        .prefix = from->prefix,
        .packages = from->packages,
        .package_count = from->package_count};
    if (!robot_load(out, &c->pool, source, &c->report)) return ctl_fail_loading(c);
    *values = pool_alloc(&c->pool, (size_t)out->model.joint_count, sizeof **values);
    robot_default_values(out, *values);
    for (size_t i = 0; i < from->joint_count; i++) {
        int joint = urdf_find_joint(&out->model, from->joints[i]);
        if (joint >= 0) (*values)[joint] = from->values[i];
    }
    return 0;
}
