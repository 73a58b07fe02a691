/* rig: fork and exec, /proc, and a network namespace. One thread; the client library has its own. */
#include "rig.h"

#include <errno.h>
#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

enum { PROCESSES_MAX = 256, CLIENTS_MAX = 16 };
static pid_t running[PROCESSES_MAX];   /* 0 = free */
static collided *clients[CLIENTS_MAX]; /* NULL = free */
static bool isolated;

double rig_now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* ---- a network of our own ---- */

static bool write_line(const char *path, const char *line)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);
    if (fd < 0) return false;
    bool written = write(fd, line, strlen(line)) == (ssize_t)strlen(line);
    close(fd);
    return written;
}

bool rig_isolate(void)
{
    char map[64], group_map[64];
    snprintf(map, sizeof map, "0 %u 1", (unsigned)getuid());
    snprintf(group_map, sizeof group_map, "0 %u 1", (unsigned)getgid());
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        printf("skipped: this system does not permit a network namespace: %s\n", strerror(errno));
        return false;
    }
    isolated = write_line("/proc/self/uid_map", map) && write_line("/proc/self/setgroups", "deny") &&
               write_line("/proc/self/gid_map", group_map) &&
               system("PATH=/usr/sbin:/sbin:/usr/bin:/bin; ip link set lo up && ip link set lo multicast on && "
                      "ip route add 224.0.0.0/4 dev lo") == 0; /* NOLINT(cert-env33-c): a fixed line */
    if (!isolated) printf("skipped: loopback of the new network namespace cannot be set up\n");
    return isolated;
}

bool rig_small_disk(char folder[64], int kib)
{
    char options[32];
    snprintf(options, sizeof options, "size=%dk", kib);
    strcpy(folder, "/tmp/collided-disk-XXXXXX");
    if (mkdtemp(folder) && unshare(CLONE_NEWNS) == 0 && mount("none", "/", NULL, MS_REC | MS_PRIVATE, NULL) == 0 &&
        mount("tmpfs", folder, "tmpfs", 0, options) == 0)
        return true;
    printf("no small file system can be mounted here: %s\n", strerror(errno));
    *folder = '\0';
    return false;
}

void rig_need_network(void)
{
    if (!isolated) skip();
}

/* ---- processes ---- */

pid_t rig_start(const char *program, const char *const *arguments)
{
    int slot = 0;
    while (slot < PROCESSES_MAX && running[slot]) slot++;
    assert_true(slot < PROCESSES_MAX);
    pid_t parent = getpid(), pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL); /* a test that is ended leaves nobody behind */
        if (getppid() == parent) execv(program, (char *const *)(uintptr_t)arguments);
        _exit(127);
    }
    running[slot] = pid;
    return pid;
}

static void forget(pid_t pid)
{
    for (int i = 0; i < PROCESSES_MAX; i++)
        if (running[i] == pid) running[i] = 0;
}

#define ORDINARY "collided", "--links", RIG_LINKS, "--status-period", "0.1", "--workers", "1", "--log", "warning"

/* Ready when a first client has heard it: the caller's rig_connect waits for that. */
pid_t rig_daemon(const char *option, const char *value)
{
    rig_need_network();
    const char *const arguments[] = {ORDINARY, option, value, NULL};
    return rig_start(COLLIDED, arguments);
}

double rig_pair_lease_s(void)
{
    return getenv("COLLIDED_NIGHTLY") ? 0.1 : 0.3;
}

pid_t rig_one_of_a_pair(const char *option)
{
    return rig_one_of_a_pair_of(rig_pair_lease_s(), option);
}

pid_t rig_one_of_a_pair_of(double lease_s, const char *option)
{
    char lease[32];
    rig_need_network();
    snprintf(lease, sizeof lease, "%g", lease_s);
    const char *const arguments[] = {ORDINARY, "--standby=yes", "--standby_lease", lease, option, NULL};
    return rig_start(COLLIDED, arguments);
}

pid_t rig_self(const char *role, const char *uri, const char *argument)
{
    const char *const arguments[] = {"client", role, uri, argument, NULL};
    return rig_start("/proc/self/exe", arguments);
}

int rig_wait(pid_t pid, double seconds)
{
    int status;
    double end = rig_now_s() + seconds;
    while (waitpid(pid, &status, WNOHANG) == 0) {
        if (rig_now_s() > end) fail_msg("process %d has not ended within %g s", (int)pid, seconds);
        usleep(2000);
    }
    forget(pid);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

void rig_kill(pid_t pid, int number)
{
    assert_int_equal(kill(pid, number), 0);
    if (number == SIGKILL) assert_int_equal(rig_wait(pid, RIG_PATIENCE_S), 128 + SIGKILL);
}

int rig_end_all(void **state)
{
    (void)state;
    for (int i = 0; i < CLIENTS_MAX; i++)
        if (clients[i]) rig_close(clients[i]);
    for (int i = 0; i < PROCESSES_MAX; i++) {
        if (!running[i]) continue;
        kill(running[i], SIGKILL);
        waitpid(running[i], NULL, 0);
        running[i] = 0;
    }
    return 0;
}

bool rig_alive(pid_t pid)
{
    return waitpid(pid, NULL, WNOHANG) == 0;
}

bool rig_has_ended(pid_t pid)
{
    siginfo_t info = {0};
    return waitid(P_PID, (id_t)pid, &info, WEXITED | WNOHANG | WNOWAIT) != 0 || info.si_pid == pid;
}

/* Whichever of its threads made the child. */
pid_t rig_child(pid_t parent)
{
    char command[128];
    int child = 0;
    snprintf(command, sizeof command, "cat /proc/%d/task/*/children", (int)parent);
    FILE *f = popen(command, "r"); /* NOLINT(cert-env33-c): a fixed line with a number */
    assert_non_null(f);
    if (fscanf(f, "%d", &child) != 1) child = 0; /* NOLINT(cert-err34-c): the kernel's own number */
    pclose(f);
    return child;
}

bool rig_has_thread(pid_t pid, const char *name)
{
    char command[160];
    snprintf(command, sizeof command, "grep -qsx '%s' /proc/%d/task/*/comm", name, (int)pid);
    return system(command) == 0; /* NOLINT(cert-env33-c): a fixed line with a number */
}

long rig_resident_kb(pid_t pid)
{
    char path[64];
    long pages = 0;
    snprintf(path, sizeof path, "/proc/%d/statm", (int)pid);
    FILE *f = fopen(path, "r");
    assert_non_null(f);
    assert_int_equal(fscanf(f, "%*s %ld", &pages), 1); /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return pages * (sysconf(_SC_PAGESIZE) / 1024);
}

/* ---- clients ---- */

collided *rig_connect(const char *uri, double lease_s, collided_on_loss on_loss)
{
    collided_def def = collided_def_default();
    def.lease_s = lease_s;
    def.connect_timeout_s = RIG_PATIENCE_S;
    def.on_loss = on_loss;
    collided *c = collided_connect(uri, &def);
    if (!c) fail_msg("%s: %s", uri, collided_connect_error());
    int slot = 0;
    while (slot < CLIENTS_MAX && clients[slot]) slot++;
    assert_true(slot < CLIENTS_MAX);
    return clients[slot] = c;
}

void rig_close(collided *c)
{
    for (int i = 0; i < CLIENTS_MAX; i++)
        if (clients[i] == c) clients[i] = NULL;
    collided_close(c);
}

collided_body rig_box(collided *c, const char *name, double x)
{
    collided_shape shape = collided_box(1, 1, 1);
    collided_body_def def = collided_body_def_default();
    def.name = name;
    def.pose.position[0] = x;
    def.shapes = &shape;
    def.shape_count = 1;
    collided_body body = collided_create_body(c, &def);
    if (body.id == COLLIDED_NONE) fail_msg("%s: %s", name, collided_error(c));
    return body;
}

collided_status rig_move(collided *c, collided_body body, double x, int64_t step)
{
    const double position[3] = {x, 0, 0}, orientation[4] = {1, 0, 0, 0};
    collided_status status = collided_publish(c, 1, &body, position, orientation, NULL, NULL, 0, step);
    collided_flush(c);
    return status;
}

static void count_event(heard *h, const collided_event *e)
{
    if ((size_t)e->kind >= HEARD_KINDS) fail_msg("an event of kind %d", (int)e->kind);
    h->kinds[e->kind]++;
    snprintf(h->cause[e->kind], sizeof h->cause[0], "%s", e->cause);
    if (e->kind == COLLIDED_BEGIN) h->touching++;
    if (e->kind == COLLIDED_END) h->touching--;
}

static void on_batch(void *context, const collided_batch *b)
{
    heard *h = context;
    if (b->starved) return;
    h->batches++;
    h->epoch = b->epoch;
    h->batch = b->batch;
    h->lost += b->lost;
    h->closing = b->closing;
    if (b->step > h->step) h->step = b->step;
    if (b->snapshot) {
        h->snapshots++;
        h->touching = 0;
    }
    for (size_t i = 0; i < b->event_count; i++) count_event(h, &b->events[i]);
}

void rig_watch(collided *c, heard *h, const char *name)
{
    *h = (heard){0};
    collided_subscription_def def = collided_subscription_def_default();
    def.select_a = name;
    def.callback = on_batch;
    def.context = h;
    assert_int_not_equal(collided_subscribe(c, &def).id, COLLIDED_NONE);
}

int64_t rig_counter(collided *c, const char *name)
{
    collided_daemon_status s;
    if (collided_get_status(c, RIG_PATIENCE_S, &s) != COLLIDED_OK) fail_msg("status: %s", collided_error(c));
    for (size_t i = 0; i < s.counter_count; i++)
        if (strcmp(s.counters[i].name, name) == 0) return s.counters[i].value;
    fail_msg("no counter %s", name);
    return 0;
}
