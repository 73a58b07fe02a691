/* A disk that is full, and a file that may not grow, while the daemon records: the recording ends, which is counted
 * once, and the world goes on. */
#include "rig.h"

#include <errno.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <unistd.h>

static char folder[] = "/tmp/disk_full_XXXXXX", path[64];
static bool mounted;

static bool write_line(const char *file, const char *line)
{
    FILE *f = fopen(file, "w");
    bool written = f && fputs(line, f) >= 0;
    return f && fclose(f) == 0 && written;
}

/* A file system of 64 KiB that only we, and whom we start, can see. Its files want a group that exists here. */
static void mount_small_disk(gid_t group)
{
    char map[64];
    snprintf(map, sizeof map, "0 %u 1", (unsigned)group);
    bool made =
        mkdtemp(folder) != NULL && write_line("/proc/self/setgroups", "deny") && write_line("/proc/self/gid_map", map);
    snprintf(path, sizeof path, "%s/recording", folder);
    mounted = made && unshare(CLONE_NEWNS) == 0 && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
              mount("tmpfs", folder, "tmpfs", 0, "size=64k") == 0;
    if (!mounted) printf("skipped: no small file system can be mounted here: %s\n", strerror(errno));
}

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
    if (!mounted) skip();
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
    gid_t group = getgid(); /* before it is mapped */
    if (rig_isolate()) mount_small_disk(group);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    if (mounted) umount(folder);
    rmdir(folder);
    return failed;
}
