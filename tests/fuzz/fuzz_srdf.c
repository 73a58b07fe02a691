/* Any bytes as an SRDF for a small arm: refused with one line, or only links and joints that the arm has. */
#include "fuzz.h"

#include "loaders/srdf.h"

#include <string.h>

static const char arm[] = "<robot name='arm'><link name='a'/><link name='b'/><link name='c'/>"
                          "<joint name='ab' type='revolute'><parent link='a'/><child link='b'/>"
                          "<limit lower='-1' upper='1'/></joint>"
                          "<joint name='bc' type='fixed'><parent link='b'/><child link='c'/></joint></robot>";

static void expect_known_names(const srdf *s, const urdf *u)
{
    for (int i = 0; i < s->state_count; i++)
        for (int k = 0; k < s->states[i].value_count; k++) {
            int joint = s->states[i].values[k].joint;
            PROMISE(joint >= 0 && joint < u->joint_count);
        }
    for (int i = 0; i < s->disabled_count; i++) {
        const srdf_disabled *d = &s->disabled[i];
        PROMISE(d->link1 >= 0 && d->link1 < u->link_count && d->link2 >= 0 && d->link2 < u->link_count);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pool p = {0};
    load_report r = {.error = ""};
    urdf u;
    srdf s;
    PROMISE(urdf_parse(&u, &p, arm, sizeof arm - 1, "arm.urdf", &r));
    bool good = srdf_parse(&s, &p, &u, (const char *)data, size, "fuzz.srdf", &r);
    PROMISE(good == !r.error[0] && !strchr(r.error, '\n'));
    if (good) expect_known_names(&s, &u);
    pool_free(&p);
    return 0;
}
