/* A power cut while the daemon records: of the recording that is there which was synced, and nothing else. It replays
 * up to a whole tick, and what is not in it was told within the last moments. */
#include "rig.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static char folder[] = "/tmp/power_cut_XXXXXX", synced[64], left[96], session[96];

static pid_t daemon_that_records(void)
{
    rig_need_network();
    const char *const arguments[] = {"collided", "--links", RIG_DDS, "--status-period", "0.1", "--workers", "1",
        "--log", "warning", "--record", session, NULL};
    setenv("LD_PRELOAD", DISK, 1);
    setenv("DISK_SYNCED", synced, 1);
    pid_t pid = rig_start(COLLIDED, arguments);
    unsetenv("LD_PRELOAD");
    return pid;
}

/* What the replay of what is left says is in it. */
static int64_t replayed_ticks(void)
{
    char command[512], said[4096];
    snprintf(command, sizeof command, "%s --replay %s --json --log error", COLLIDED, left);
    FILE *p = popen(command, "r"); /* NOLINT(cert-env33-c): names of our own */
    assert_non_null(p);
    said[fread(said, 1, sizeof said - 1, p)] = '\0';
    int status = pclose(p);
    const char *ticks = strstr(said, "\"ticks\":");
    if (status != 0 || !ticks) fail_msg("replay: %d: %s", status, said);
    return strtoll(ticks + strlen("\"ticks\":"), NULL, 10);
}

static void what_is_lost_is_of_the_last_moments(void **state)
{
    double reported_s[20000];
    int64_t told_tick[20000], step = 0;
    pid_t daemon = daemon_that_records();
    collided *c = rig_connect(*state, 60, COLLIDED_REMOVE);
    heard h;
    rig_box(c, "table", 0);
    collided_body part = rig_box(c, "part", 0.5);
    rig_watch(c, &h, "part");
    UNTIL(c, RIG_PATIENCE_S, h.touching == 1);
    double until_s = rig_now_s() + 3.7;
    while (rig_now_s() < until_s && step < 19999) {
        rig_move(c, part, 0.5 + 0.0001 * (double)(step % 100), step + 1);
        step++;
        UNTIL(c, RIG_PATIENCE_S, h.step == step);
        reported_s[step] = rig_now_s();
        told_tick[step] = step; /* a step is a tick or more: as many ticks, at least, were there */
    }
    rig_kill(daemon, SIGKILL);
    double cut_s = rig_now_s();
    int64_t ticks = replayed_ticks(), last = 0;
    while (last < step && told_tick[last + 1] <= ticks) last++;
    assert_true(ticks > 0);
    if (last < step && cut_s - reported_s[last + 1] > 2) /* a second, and what a busy machine takes */
        fail_msg("%.2f s are lost: %d ticks of %d steps", cut_s - reported_s[last + 1], (int)ticks, (int)step);
    rig_close(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {OVER(what_is_lost_is_of_the_last_moments, RIG_DDS)};
    char command[128];
    if (!mkdtemp(folder)) return 1;
    snprintf(synced, sizeof synced, "%s", folder);
    snprintf(session, sizeof session, "%s/on/session.lcmlog", folder);
    snprintf(left, sizeof left, "%s/session.lcmlog", folder);
    snprintf(command, sizeof command, "mkdir %s/on", folder);
    bool made = system(command) == 0; /* NOLINT(cert-env33-c): a name of our own */
    if (made) rig_isolate();
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command) != 0 || failed; /* NOLINT(cert-env33-c) */
}
