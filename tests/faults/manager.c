/* manager: poll on the socket, the process and the wish to stop; what the test asks for is behind a lock. */
#include "manager.h"

#include "rig.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/pidfd.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

extern char **environ;

enum { MANAGERS_MAX = 4, ARGUMENTS_MAX = 64, ENVIRONMENT_MAX = 512 };
/* TimeoutStartSec and TimeoutStopSec of the unit, the first for a machine that has ten other things to do. */
static const double START_S = 120, STOP_S = 10;

struct manager {
    pthread_t thread;
    pthread_mutex_t lock; /* guards what stands in the second part */
    char program[512], folder[64], notify[108], log[80];
    char *arguments[ARGUMENTS_MAX + 2], *environment[ENVIRONMENT_MAX + 4], own[3][160];
    double watchdog_s, pause_s;
    int socket, stop; /* stop: an eventfd */
    pid_t parent;

    pid_t pid;
    bool ready, ended, kill; /* kill: it is not asked to end, but killed */
    unsigned starts, killed;
    int status; /* of the last one, as waitpid has it */
    double longest_silence_s;
};

static manager *managers[MANAGERS_MAX]; /* NULL = free; the test's thread */

/* ---- the thread ---- */

/* Restart=on-failure, and RestartPreventExitStatus of the unit. */
static bool is_mended_by_a_restart(int status)
{
    static const int FINAL[] = {0, 64, 66, 71, 72, 73, 77, 78};
    if (!WIFEXITED(status)) return true;
    for (size_t i = 0; i < sizeof FINAL / sizeof *FINAL; i++)
        if (WEXITSTATUS(status) == FINAL[i]) return false;
    return true;
}

/* In the child, between fork and exec: system calls alone. */
static void become_the_daemon(const manager *m)
{
    const struct rlimit none = {0, 0};
    int log = open(m->log, O_WRONLY | O_CREAT | O_APPEND, 0600);
    prctl(PR_SET_PDEATHSIG, SIGKILL); /* of the thread that started it */
    setrlimit(RLIMIT_CORE, &none);
    if (log < 0 || dup2(log, STDERR_FILENO) < 0) _exit(127);
    if (getppid() == m->parent) execve(m->program, m->arguments, m->environment);
    _exit(127);
}

static pid_t start_once(manager *m)
{
    pid_t pid = fork();
    if (pid == 0) become_the_daemon(m);
    pthread_mutex_lock(&m->lock);
    m->pid = pid < 0 ? 0 : pid;
    m->ready = false;
    m->starts++;
    pthread_mutex_unlock(&m->lock);
    return pid;
}

static bool has_line(const char *text, const char *line)
{
    size_t length = strlen(line);
    for (const char *at = text; at; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL)
        if (strncmp(at, line, length) == 0 && (at[length] == '\0' || at[length] == '\n')) return true;
    return false;
}

/* One datagram; "" if it is not from the daemon itself (NotifyAccess=main). */
static void hear(const manager *m, pid_t pid, char *text, size_t size)
{
    char control[CMSG_SPACE(sizeof(struct ucred))];
    struct iovec part = {text, size - 1};
    struct msghdr message = {
        .msg_iov = &part, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    ssize_t got = recvmsg(m->socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    struct cmsghdr *c = got < 0 ? NULL : CMSG_FIRSTHDR(&message);
    struct ucred from = {0};
    if (c && c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_CREDENTIALS) memcpy(&from, CMSG_DATA(c), sizeof from);
    text[from.pid == pid ? got : 0] = '\0';
}

typedef struct life { /* of one daemon */
    pid_t pid;
    int process;        /* a pidfd */
    double deadline_s;  /* then a signal is sent */
    double last_seen_s; /* the last sign of life */
    int sent;           /* the last signal: 0, SIGTERM, SIGABRT or SIGKILL */
    bool ready;
} life;

static void listen_to(manager *m, life *l)
{
    char text[4096];
    double now = rig_now_s();
    hear(m, l->pid, text, sizeof text);
    bool becomes_ready = !l->ready && has_line(text, "READY=1");
    if (!becomes_ready && !has_line(text, "WATCHDOG=1")) return;
    l->ready |= becomes_ready;
    pthread_mutex_lock(&m->lock);
    m->ready = l->ready;
    if (!becomes_ready && now - l->last_seen_s > m->longest_silence_s) m->longest_silence_s = now - l->last_seen_s;
    pthread_mutex_unlock(&m->lock);
    l->last_seen_s = now;
    if (l->ready && !l->sent) l->deadline_s = m->watchdog_s > 0 ? now + m->watchdog_s : 1e300;
}

static void send_signal(manager *m, life *l, int number)
{
    if (number == SIGABRT && l->ready) {
        pthread_mutex_lock(&m->lock);
        m->killed++;
        if (rig_now_s() - l->last_seen_s > m->longest_silence_s) m->longest_silence_s = rig_now_s() - l->last_seen_s;
        pthread_mutex_unlock(&m->lock);
    }
    kill(l->pid, number);
    l->sent = number;
    l->deadline_s = rig_now_s() + STOP_S;
}

static bool is_to_be_killed(manager *m)
{
    pthread_mutex_lock(&m->lock);
    bool killed = m->kill;
    pthread_mutex_unlock(&m->lock);
    return killed;
}

/* Until the daemon has ended; its status. */
static int live_through(manager *m, pid_t pid, bool *stopped)
{
    life l = {.pid = pid, .process = pidfd_open(pid, 0), .deadline_s = rig_now_s() + START_S};
    int status = 0;
    for (;;) {
        struct pollfd on[] = {{l.process, POLLIN, 0}, {m->socket, POLLIN, 0}, {*stopped ? -1 : m->stop, POLLIN, 0}};
        double left_s = l.deadline_s - rig_now_s();
        if (poll(on, 3, left_s <= 0 ? 0 : left_s > 1 ? 1000 : (int)(1e3 * left_s) + 1) < 0 && errno != EINTR) break;
        if (on[0].revents) break;
        if (on[1].revents) listen_to(m, &l);
        if (on[2].revents) {
            *stopped = true;
            send_signal(m, &l, is_to_be_killed(m) ? SIGKILL : SIGTERM);
        } else if (rig_now_s() >= l.deadline_s) {
            send_signal(m, &l, l.sent ? SIGKILL : SIGABRT);
        }
    }
    waitpid(pid, &status, 0);
    close(l.process);
    return status;
}

static void *supervise(void *context)
{
    manager *m = context;
    bool stopped = false, again = true;
    while (!stopped && again) {
        pid_t pid = start_once(m);
        int status = pid < 0 ? 71 << 8 : live_through(m, pid, &stopped);
        again = is_mended_by_a_restart(status);
        pthread_mutex_lock(&m->lock);
        m->pid = 0;
        m->ready = false;
        m->ended = stopped || !again;
        m->status = status;
        pthread_mutex_unlock(&m->lock);
        struct pollfd stop = {m->stop, POLLIN, 0};
        if (!stopped && again) stopped = poll(&stop, 1, (int)(1e3 * m->pause_s)) > 0;
    }
    return NULL;
}

/* ---- the test's thread ---- */

static void open_socket(manager *m)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int yes = 1;
    memcpy(at.sun_path, m->notify, sizeof at.sun_path);
    m->socket = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    assert_true(m->socket >= 0);
    assert_int_equal(setsockopt(m->socket, SOL_SOCKET, SO_PASSCRED, &yes, sizeof yes), 0);
    assert_int_equal(bind(m->socket, (const struct sockaddr *)&at, sizeof at), 0);
}

/* Made here, since a child of a process with threads may not allocate before its exec. */
static void make_environment(manager *m)
{
    size_t count = 0, own = 0;
    snprintf(m->own[own++], sizeof m->own[0], "NOTIFY_SOCKET=%s", m->notify);
    snprintf(m->own[own++], sizeof m->own[0], "RUNTIME_DIRECTORY=%s", m->folder);
    if (m->watchdog_s > 0)
        snprintf(m->own[own++], sizeof m->own[0], "WATCHDOG_USEC=%lld", (long long)(1e6 * m->watchdog_s));
    for (char **e = environ; *e && count < ENVIRONMENT_MAX; e++)
        if (strncmp(*e, "NOTIFY_SOCKET=", 14) && strncmp(*e, "RUNTIME_DIRECTORY=", 18) && strncmp(*e, "WATCHDOG_", 9))
            m->environment[count++] = *e;
    for (size_t i = 0; i < own; i++) m->environment[count++] = m->own[i];
}

manager *manager_start_program(const char *program, const char *const *arguments, double watchdog_s, double pause_s)
{
    int slot = 0;
    while (slot < MANAGERS_MAX && managers[slot]) slot++;
    assert_true(slot < MANAGERS_MAX);
    manager *m = calloc(1, sizeof *m);
    assert_non_null(m);
    snprintf(m->program, sizeof m->program, "%s", program);
    snprintf(m->folder, sizeof m->folder, "/tmp/manager.XXXXXX");
    assert_non_null(mkdtemp(m->folder));
    snprintf(m->notify, sizeof m->notify, "%s/notify", m->folder);
    snprintf(m->log, sizeof m->log, "%s/log", m->folder);
    m->watchdog_s = watchdog_s;
    m->pause_s = pause_s;
    m->parent = getpid();
    m->arguments[0] = m->program;
    for (size_t i = 0; arguments[i]; i++) {
        assert_true(i < ARGUMENTS_MAX);
        m->arguments[i + 1] = strdup(arguments[i]);
    }
    open_socket(m);
    make_environment(m);
    m->stop = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    pthread_mutex_init(&m->lock, NULL);
    assert_int_equal(pthread_create(&m->thread, NULL, supervise, m), 0);
    return managers[slot] = m;
}

manager *manager_start(const char *const *arguments, double watchdog_s)
{
    return manager_start_program(COLLIDED, arguments, watchdog_s, MANAGER_PAUSE_S);
}

/* A value of the second part, read under the lock. */
#define READ(type, name, value)                                                                                        \
    type name(manager *m)                                                                                              \
    {                                                                                                                  \
        pthread_mutex_lock(&m->lock);                                                                                  \
        type read = (value);                                                                                           \
        pthread_mutex_unlock(&m->lock);                                                                                \
        return read;                                                                                                   \
    }
READ(pid_t, manager_pid, m->pid)
READ(unsigned, manager_restarts, m->starts ? m->starts - 1 : 0)
READ(unsigned, manager_killed, m->killed)
READ(bool, manager_is_ready, m->ready)
READ(bool, manager_has_ended, m->ended)
READ(double, manager_longest_silence_s, m->longest_silence_s)

const char *manager_folder(manager *m)
{
    return m->folder;
}

bool manager_said(manager *m, const char *text)
{
    char line[4096];
    bool said = false;
    FILE *f = fopen(m->log, "re");
    while (f && !said && fgets(line, sizeof line, f)) said = strstr(line, text) != NULL;
    if (f) fclose(f);
    return said;
}

void manager_show(manager *m)
{
    char line[4096];
    FILE *f = fopen(m->log, "re");
    while (f && fgets(line, sizeof line, f)) fputs(line, stdout);
    if (f) fclose(f);
}

void manager_await(manager *m, unsigned restarts, double seconds)
{
    double end = rig_now_s() + seconds;
    while (manager_restarts(m) < restarts || !manager_is_ready(m)) {
        if (manager_has_ended(m) || rig_now_s() > end) {
            manager_show(m);
            fail_msg("no daemon is ready after %u restarts and %g s", restarts, seconds);
        }
        usleep(2000);
    }
}

static void remove_folder(const char *folder)
{
    char command[128];
    snprintf(command, sizeof command, "rm -rf -- %s", folder);
    if (system(command) != 0) printf("%s stays\n", folder); /* NOLINT(cert-env33-c): a name of mkdtemp's */
}

static int end(manager *m, bool at_once)
{
    uint64_t one = 1;
    pthread_mutex_lock(&m->lock);
    m->kill = at_once;
    pthread_mutex_unlock(&m->lock);
    if (write(m->stop, &one, sizeof one) != sizeof one) abort();
    pthread_join(m->thread, NULL);
    int status = m->status;
    close(m->stop);
    close(m->socket);
    remove_folder(m->folder);
    for (size_t i = 1; m->arguments[i]; i++) free(m->arguments[i]);
    pthread_mutex_destroy(&m->lock);
    for (int i = 0; i < MANAGERS_MAX; i++)
        if (managers[i] == m) managers[i] = NULL;
    free(m);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

int manager_stop(manager *m)
{
    return end(m, false);
}

int manager_end_all(void **state)
{
    for (int i = 0; i < MANAGERS_MAX; i++)
        if (managers[i]) end(managers[i], true);
    return rig_end_all(state);
}
