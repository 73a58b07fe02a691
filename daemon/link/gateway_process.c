/* gateway_process: posix_spawn and waitpid of that process id alone. The thread that watches the gateway. */
#include "gateway_process.h"

#include "pipe/pipe.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

bool gateway_program(const char *program, char path[GATEWAY_PATH_MAX], char *why, size_t why_size)
{
    struct stat is;
    int n;
    if (program[0]) {
        n = snprintf(path, GATEWAY_PATH_MAX, "%s", program);
    } else {
        char self[PATH_MAX];
        ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
        if (length < 0) length = 0;
        self[length] = '\0';
        char *slash = strrchr(self, '/');
        if (slash) *slash = '\0';
        n = snprintf(path, GATEWAY_PATH_MAX, "%s/collided-lcm", self);
    }
    if (n > 0 && n < GATEWAY_PATH_MAX && access(path, X_OK) == 0 && stat(path, &is) == 0 && S_ISREG(is.st_mode))
        return true;
    snprintf(why, why_size,
        "%.200s: the LCM gateway is not there, or not a program: do: apt-get install --reinstall collided, or set "
        "gateway",
        path);
    return false;
}

/* The child: signals as by default and unblocked (the daemon blocks them). */
static int spawn(const char *path, char *const arguments[], int pipe_end, int errors_end, pid_t *pid)
{
    posix_spawn_file_actions_t files;
    posix_spawnattr_t attributes;
    sigset_t none, all;
    sigemptyset(&none);
    sigfillset(&all);
    posix_spawn_file_actions_init(&files);
    posix_spawnattr_init(&attributes);
    posix_spawn_file_actions_adddup2(&files, errors_end, STDERR_FILENO);
    posix_spawn_file_actions_adddup2(&files, pipe_end, PIPE_FD);
    posix_spawn_file_actions_addclosefrom_np(&files, PIPE_FD + 1);
    posix_spawnattr_setsigmask(&attributes, &none);
    posix_spawnattr_setsigdefault(&attributes, &all);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    int error = posix_spawn(pid, path, &files, &attributes, arguments, environ);
    posix_spawn_file_actions_destroy(&files);
    posix_spawnattr_destroy(&attributes);
    return error;
}

/* Pairs of descriptors: the pipe, and standard error, of which only our end does not wait. */
static bool make_ends(int ends[2], int errors[2])
{
    if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) return false;
    if (pipe2(errors, O_CLOEXEC) == 0) {
        if (fcntl(errors[0], F_SETFL, O_NONBLOCK) == 0) return true;
        close(errors[0]);
        close(errors[1]);
    }
    close(ends[0]);
    close(ends[1]);
    return false;
}

int gateway_start(const char *path, const char *url, const char *interface, pid_t *pid, int *errors)
{
    int ends[2], words[2];
    if (!make_ends(ends, words)) return -1;
    char *const arguments[] = {(char *)path, (char *)url, (char *)interface, NULL};
    int error = spawn(path, arguments, ends[1], words[1], pid);
    close(ends[1]);
    close(words[1]);
    *errors = words[0];
    if (error == 0) return ends[0];
    close(ends[0]);
    close(words[0]);
    errno = error;
    return -1;
}

static void describe_end(int status, char *how, size_t how_size)
{
    if (WIFSIGNALED(status))
        snprintf(how, how_size, "killed by signal %d (%s)", WTERMSIG(status), strsignal(WTERMSIG(status)));
    else if (WIFEXITED(status) && WEXITSTATUS(status) == PIPE_EXIT_NETWORK)
        snprintf(how, how_size, "the network refuses LCM; its lines above say what to do");
    else
        snprintf(how, how_size, "exit status %d", WIFEXITED(status) ? WEXITSTATUS(status) : -1);
}

int gateway_end(pid_t pid, int patience_ms, char *how, size_t how_size)
{
    int status = 0;
    int pidfd = (int)syscall(SYS_pidfd_open, pid, 0);
    struct pollfd p = {.fd = pidfd, .events = POLLIN};
    if (pidfd < 0 || poll(&p, 1, patience_ms) <= 0) kill(pid, SIGKILL);
    if (pidfd >= 0) close(pidfd);
    while (waitpid(pid, &status, 0) < 0 && errno == EINTR) continue;
    describe_end(status, how, how_size);
    return status;
}
