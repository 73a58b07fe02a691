/* bench: getopt, clock, /proc and a namespace. One thread; processes that were started end with this one. */
#include "bench.h"

#include <errno.h>
#include <fcntl.h>
#include <getopt.h>
#include <math.h>
#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

bool bench_parse(int argc, char **argv, double seconds, double seconds_full, bench_options *out)
{
    static const struct option known[] = {{"json", no_argument, NULL, 'j'}, {"full", no_argument, NULL, 'f'},
        {"seconds", required_argument, NULL, 's'}, {"bodies", required_argument, NULL, 'b'}, {NULL, 0, NULL, 0}};
    *out = (bench_options){.seconds = seconds};
    for (int c = 0; c != '?' && (c = getopt_long(argc, argv, "", known, NULL)) != -1;) {
        if (c == 'j') out->json = true;
        if (c == 'f') out->seconds = seconds_full;
        if (c == 's') out->seconds = strtod(optarg, NULL);
        if (c == 'b') out->bodies = strtol(optarg, NULL, 10);
        if (c == '?') optind = argc + 1;
    }
    if (optind == argc && out->seconds >= 0.1 && out->seconds <= 3600 && out->bodies >= 0 && out->bodies <= 65536)
        return true;
    fprintf(stderr, "usage: %s [--json] [--full] [--seconds 0.1..3600] [--bodies 1..65536]\n", argv[0]);
    return false;
}

/* ---- time ---- */

static int64_t clock_ns(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

int64_t bench_now_ns(void)
{
    return clock_ns(CLOCK_MONOTONIC);
}

int64_t bench_wall_ns(void)
{
    return clock_ns(CLOCK_REALTIME);
}

void bench_sleep_until(int64_t monotonic_ns)
{
    struct timespec t = {monotonic_ns / 1000000000, monotonic_ns % 1000000000};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) == EINTR) continue;
}

/* ---- samples ---- */

bool bench_samples_init(bench_samples *s, size_t capacity)
{
    *s = (bench_samples){.at_ns = calloc(capacity, sizeof(int64_t)), .capacity = capacity};
    return s->at_ns != NULL;
}

void bench_samples_add(bench_samples *s, int64_t ns)
{
    if (s->count == s->capacity) abort();
    s->at_ns[s->count++] = ns;
}

static int ascending(const void *a, const void *b)
{
    int64_t x = *(const int64_t *)a, y = *(const int64_t *)b;
    return (x > y) - (x < y);
}

double bench_percentile_us(bench_samples *s, double share)
{
    if (!s->count) return NAN;
    qsort(s->at_ns, s->count, sizeof *s->at_ns, ascending);
    size_t rank = (size_t)ceil(share * (double)s->count);
    return 1e-3 * (double)s->at_ns[rank ? rank - 1 : 0];
}

void bench_samples_free(bench_samples *s)
{
    free(s->at_ns);
    *s = (bench_samples){0};
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

bool bench_isolate(void)
{
    char map[64];
    snprintf(map, sizeof map, "0 %u 1", (unsigned)getuid());
    if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) {
        fprintf(stderr, "no network namespace: %s\n", strerror(errno));
        return false;
    }
    if (write_line("/proc/self/uid_map", map) &&
        system("PATH=/usr/sbin:/sbin:/usr/bin:/bin; ip link set lo up && ip link set lo multicast on && "
               "ip route add 224.0.0.0/4 dev lo") == 0) /* NOLINT(cert-env33-c): a fixed line */
        return true;
    fprintf(stderr, "loopback of the new network namespace cannot be set up\n");
    return false;
}

/* ---- processes ---- */

pid_t bench_start(const char *program, const char *const *arguments)
{
    pid_t parent = getpid(), pid = fork();
    if (pid == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        if (getppid() == parent) execv(program, (char *const *)(uintptr_t)arguments);
        _exit(127);
    }
    return pid;
}

void bench_end(pid_t pid)
{
    if (pid <= 0) return;
    kill(pid, SIGTERM);
    for (int i = 0; i < 500; i++) {
        if (waitpid(pid, NULL, WNOHANG) != 0) return;
        usleep(10000);
    }
    fprintf(stderr, "process %d did not end within 5 s: killed\n", (int)pid);
    kill(pid, SIGKILL);
    waitpid(pid, NULL, 0);
}

/* utime and stime are the 14th and 15th fields; the second, the name in brackets, may hold anything. */
static double process_cpu_s(pid_t pid)
{
    char path[64], line[1024];
    unsigned long user, system;
    snprintf(path, sizeof path, "/proc/%d/stat", (int)pid);
    FILE *f = fopen(path, "r");
    if (!f) return NAN;
    size_t size = fread(line, 1, sizeof line - 1, f);
    fclose(f);
    line[size] = '\0';
    const char *at = strrchr(line, ')');
    if (!at || sscanf(at + 1, " %*c %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %lu %lu", &user, &system) != 2)
        return NAN; /* NOLINT(cert-err34-c): the kernel's own numbers */
    return (double)(user + system) / (double)sysconf(_SC_CLK_TCK);
}

double bench_cpu_s(pid_t pid)
{
    char command[64];
    int child;
    double sum = process_cpu_s(pid);
    snprintf(command, sizeof command, "cat /proc/%d/task/*/children", (int)pid);
    FILE *f = popen(command, "r"); /* NOLINT(cert-env33-c): a fixed line with a number */
    if (!f) return NAN;
    while (fscanf(f, "%d", &child) == 1) sum += process_cpu_s(child); /* NOLINT(cert-err34-c): the kernel's */
    pclose(f);
    return sum;
}
