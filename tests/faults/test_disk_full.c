/* A disk that is full, and a file that may not grow, while the daemon records: the recording ends, which is counted
 * once, and the world goes on. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

static char folder[64], path[80]; /* folder "": no small disk can be had */

/* More than any of the two takes; then what the world is told must still be right. */
static void outlive_the_recording(pid_t daemon, const char *uri)
{
    collided *c = rig_connect(uri, 10, COLLIDED_REMOVE);
    heard h;
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    int64_t step = 0;
    for (; step < 2000; step += 50) {
        for (int i = 1; i <= 50; i++) rig_move(c, part, 0.5 + 0.0001 * (double)i, step + i);
        UNTIL(c, RIG_PATIENCE_S, h.step == step + 50);
    }
    UNTIL(c, RIG_PATIENCE_S, rig_counter(c, "record_failures") == 1);
    rig_move(c, part, 3, ++step);
    UNTIL(c, RIG_PATIENCE_S, h.touching == 0 && h.step == step);
    assert_int_equal(h.lost, 0);
    assert_int_equal(rig_counter(c, "record_failures"), 1);
    rig_close(c);
    rig_kill(daemon, SIGTERM);
    assert_int_equal(rig_wait(daemon, RIG_PATIENCE_S), 0);
}

static void the_world_goes_on_when_the_disk_is_full(void **state)
{
    rig_need_network();
    if (!*folder) skip();
    outlive_the_recording(rig_daemon("--record", path), *state);
    assert_int_equal(unlink(path), 0);
}

static void the_world_goes_on_when_the_file_may_not_grow(void **state)
{
    char here[] = "/tmp/file_size_XXXXXX", file[64];
    struct rlimit before, little;
    rig_need_network();
    assert_non_null(mkdtemp(here));
    snprintf(file, sizeof file, "%s/recording", here);
    getrlimit(RLIMIT_FSIZE, &before);
    little = (struct rlimit){64 << 10, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &little);
    pid_t daemon = rig_daemon("--record", file);
    setrlimit(RLIMIT_FSIZE, &before);
    outlive_the_recording(daemon, *state);
    assert_int_equal(unlink(file), 0);
    rmdir(here);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(the_world_goes_on_when_the_disk_is_full, RIG_DDS),
        OVER(the_world_goes_on_when_the_file_may_not_grow, RIG_DDS)};
    if (rig_isolate() && rig_small_disk(folder, 64)) snprintf(path, sizeof path, "%s/recording", folder);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (*folder) umount(folder);
    if (*folder) rmdir(folder);
    return failed;
}
