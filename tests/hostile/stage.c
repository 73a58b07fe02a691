#include "stage.h"

#include "manager.h"
#include "neighbour.h"

#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

static const double WATCHDOG_S = 10, PATIENCE_S = 60, AFTER_S = 1.5;

static double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void sleep_s(double seconds)
{
    struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - (double)(time_t)seconds))};
    nanosleep(&t, NULL);
}

static long resident_mb(pid_t pid)
{
    char path[64];
    long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)pid);
    FILE *f = fopen(path, "r");
    if (!f) return 0;
    if (fscanf(f, "%*s %ld", &pages) != 1) pages = 0; /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return pages * sysconf(_SC_PAGESIZE) / (1024 * 1024);
}

/* How far a stage is. Its processes are forked before the manager has a thread, since a fork may copy a lock that
 * another thread holds (ASan's allocator waited for such a one for ever), and wait for their turn. */
enum { STAGE_FORKED, STAGE_DAEMON_STARTED, STAGE_ATTACKED };

/* A child goes on when the stage is that far. */
static pid_t fork_one(const atomic_int *stage, int begin)
{
    pid_t parent = getpid(), pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (getppid() != parent) _exit(127);
        while (atomic_load(stage) < begin) sleep_s(0.005);
    }
    return pid;
}

static pid_t start_neighbour(const char *uri, const atomic_int *stage, neighbour_report *r)
{
    pid_t pid = fork_one(stage, STAGE_DAEMON_STARTED);
    if (pid == 0) _exit(neighbour_live(uri, r));
    return pid;
}

static pid_t start_attack(const attack *a, const char *uri, const atomic_int *stage, bool full)
{
    pid_t pid = fork_one(stage, STAGE_ATTACKED);
    if (pid != 0) return pid;
    a->run(uri, full);
    exit(0);
}

static void end_process(pid_t pid)
{
    int status;
    if (pid <= 0) return;
    for (double end = now_s() + 10; now_s() < end; sleep_s(0.02))
        if (waitpid(pid, &status, WNOHANG) != 0) return;
    kill(pid, SIGKILL);
    waitpid(pid, &status, 0);
}

static void look_at_memory(manager *m, stage_result *out)
{
    long mb = resident_mb(manager_pid(m));
    if (mb > out->rss_mb) out->rss_mb = mb;
}

static bool wait_until_ready(neighbour_report *r, pid_t neighbour)
{
    for (double end = now_s() + PATIENCE_S; now_s() < end; sleep_s(0.05)) {
        if (atomic_load(&r->ready)) return true;
        if (waitpid(neighbour, NULL, WNOHANG) != 0) return false;
    }
    return false;
}

/* From the attack's beginning until some seconds after its end. */
static void play(pid_t attacker, bool full, manager *m, neighbour_report *r, stage_result *out)
{
    int status = 0;
    double latest = now_s() + (full ? 600 : 120);
    while (waitpid(attacker, &status, WNOHANG) == 0) {
        look_at_memory(m, out);
        if (now_s() > latest) kill(attacker, SIGKILL);
        sleep_s(0.1);
    }
    out->attack_failed = !WIFEXITED(status) || WEXITSTATUS(status) != 0;
    for (double end = now_s() + AFTER_S; now_s() < end; sleep_s(0.1)) look_at_memory(m, out);
    uint64_t rounds = atomic_load(&r->rounds);
    for (double end = now_s() + PATIENCE_S; now_s() < end && atomic_load(&r->rounds) < rounds + 5; sleep_s(0.1)) {
    }
}

static void sum_up(const neighbour_report *r, manager *m, stage_result *out)
{
    out->answer_ms_p99 = neighbour_percentile_ms(&r->answers, 0.99);
    out->event_ms_p99 = neighbour_percentile_ms(&r->events, 0.99);
    out->machine_ms_p99 = neighbour_percentile_ms(&r->machine, 0.99);
    out->longest_tick_ms = 1e-6 * (double)atomic_load(&r->longest_tick_ns);
    out->most_cpu_ms = 1e-6 * (double)atomic_load(&r->most_cpu_ns);
    out->rounds = atomic_load(&r->rounds);
    out->wrong = atomic_load(&r->wrong);
    out->unanswered = atomic_load(&r->unanswered);
    out->restarts = (int)manager_restarts(m);
    snprintf(out->error, sizeof out->error, "%s", r->error);
}

void stage_play(const attack *a, const char *uri, bool full, stage_result *out)
{
    char state[] = "/tmp/collided-hostile-XXXXXX";
    *out = (stage_result){.rss_mb = 0};
    if (!mkdtemp(state)) {
        snprintf(out->error, sizeof out->error, "no folder for the daemon's state");
        return;
    }
    const char *const arguments[] = {
        "--links", uri, "--status-period", "0.1", "--workers", "1", "--log", "error", "--record_dir", state, NULL};
    typedef struct shared {
        neighbour_report report;
        atomic_int stage;
    } shared;
    shared *with = mmap(NULL, sizeof *with, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0); /* zeros */
    if (with == MAP_FAILED) {
        snprintf(out->error, sizeof out->error, "no memory to share");
        return;
    }
    neighbour_report *r = &with->report;
    pid_t neighbour = start_neighbour(uri, &with->stage, r), attacker = start_attack(a, uri, &with->stage, full);
    manager *m = manager_start(arguments, WATCHDOG_S);
    if (m) {
        atomic_store(&with->stage, STAGE_DAEMON_STARTED);
        if (wait_until_ready(r, neighbour)) {
            neighbour_clear(r);
            atomic_store(&with->stage, STAGE_ATTACKED);
            play(attacker, full, m, r, out);
        } else {
            snprintf(r->error, sizeof r->error, "%s", *r->error ? r->error : "the neighbour did not come in");
        }
        sum_up(r, m, out);
    } else {
        snprintf(out->error, sizeof out->error, "the daemon does not start");
    }
    atomic_store(&r->end, true);
    if (attacker > 0 && atomic_load(&with->stage) < STAGE_ATTACKED) { /* it waits for its turn yet */
        kill(attacker, SIGKILL);
        waitpid(attacker, NULL, 0);
    }
    if (!m && neighbour > 0) kill(neighbour, SIGKILL);
    end_process(neighbour);
    if (m) (void)manager_stop(m);
    munmap(with, sizeof *with);
}
