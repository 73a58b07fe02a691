/* Any bytes as a YAML scene: refused with one line, or bodies and robots. No file is opened. */
#include "fuzz.h"

#include "loaders/scene.h"

#include <string.h>

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    pool p = {0};
    load_report r = {.error = ""};
    scene s;
    bool good = scene_parse(&s, &p, (const char *)data, size, "fuzz.yaml", &r);
    PROMISE(good == !r.error[0] && !strchr(r.error, '\n'));
    for (size_t i = 0; good && i < s.robot_count; i++)
        for (size_t k = 0; k < s.robots[i].joint_count; k++) PROMISE(s.robots[i].joints[k]);
    pool_free(&p);
    return 0;
}
