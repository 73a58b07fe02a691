/* What is asked of the kernel: lists of processors, and that a refusal is told in one line with what to do. Each case
 * runs in a process of its own, because it changes that. */
#include "service/realtime.h"

#include <linux/capability.h>
#include <sched.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <sysexits.h>
#include <unistd.h>

#include <cmocka.h>

static void test_lists(void **state)
{
    (void)state;
    char why[256];
    cpu_set_t set;
    assert_true(realtime_processors("0", &set, why, sizeof why));
    assert_true(CPU_COUNT(&set) == 1 && CPU_ISSET(0, &set));
    assert_true(realtime_processors("2,4-7", &set, why, sizeof why));
    assert_true(CPU_COUNT(&set) == 5 && CPU_ISSET(2, &set) && CPU_ISSET(4, &set) && CPU_ISSET(7, &set));
    assert_true(realtime_processors("63-64,1023", &set, why, sizeof why)); /* as many as the kernel's set holds */
    assert_true(CPU_COUNT(&set) == 3 && CPU_ISSET(64, &set) && CPU_ISSET(1023, &set));
    static const char *const WRONG[] = {"", "a", "-1", "1024", "3-2", "1,", ",1", "1-", "1 2", "99999999999999999999"};
    for (size_t i = 0; i < sizeof WRONG / sizeof *WRONG; i++) {
        *why = '\0';
        assert_false(realtime_processors(WRONG[i], &set, why, sizeof why));
        assert_non_null(strstr(why, "2,4-7"));
    }
}

/* As in a container: root, but not above the limits. */
static bool drop_resource_right(void)
{
    struct __user_cap_header_struct head = {.version = _LINUX_CAPABILITY_VERSION_3};
    struct __user_cap_data_struct rights[2];
    if (syscall(SYS_capget, &head, rights)) return false;
    rights[CAP_TO_INDEX(CAP_SYS_RESOURCE)].effective &= ~CAP_TO_MASK(CAP_SYS_RESOURCE);
    rights[CAP_TO_INDEX(CAP_SYS_RESOURCE)].permitted &= ~CAP_TO_MASK(CAP_SYS_RESOURCE);
    return syscall(SYS_capset, &head, rights) == 0;
}

/* In a process without rights: the status, and whether `why` is one line that holds `advice`. */
static int refused_status(const config *c, const char *advice)
{
    pid_t pid = fork();
    if (pid == 0) {
        char why[512] = "";
        struct rlimit none = {0, 0};
        if (setrlimit(RLIMIT_MEMLOCK, &none) || setrlimit(RLIMIT_RTPRIO, &none)) _exit(1);
        if (geteuid() == 0 && (setgid(65534) || setuid(65534))) _exit(1);
        int status = realtime_apply(c, why, sizeof why);
        _exit(strstr(why, advice) && !strchr(why, '\n') ? status : 1);
    }
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WEXITSTATUS(status);
}

static void test_refusals(void **state)
{
    (void)state;
    config c;
    config_default(&c);
    c.lock_memory = true;
    assert_int_equal(refused_status(&c, "LimitMEMLOCK"), EX_NOPERM);
    config_default(&c);
    c.fifo_priority = 10;
    assert_int_equal(refused_status(&c, "ulimit -r 10"), EX_NOPERM);
    config_default(&c);
    snprintf(c.cpus, sizeof c.cpus, "1023"); /* not there, on any machine that tests run on */
    if (sysconf(_SC_NPROCESSORS_CONF) < 1024) assert_int_equal(refused_status(&c, "taskset"), EX_CONFIG);
    snprintf(c.cpus, sizeof c.cpus, "one");
    assert_int_equal(refused_status(&c, "2,4-7"), EX_CONFIG);
}

/* Forked off: as root, who is above the limit until it becomes another user. */
static int root_status(bool may_raise)
{
    pid_t pid = fork();
    if (pid == 0) {
        config c;
        char why[512] = "";
        struct rlimit little = {65536, 65536};
        config_default(&c);
        c.lock_memory = true;
        if (setrlimit(RLIMIT_MEMLOCK, &little)) _exit(1);
        if (!may_raise && !drop_resource_right()) _exit(1);
        int status = realtime_apply(&c, why, sizeof why);
        if (getrlimit(RLIMIT_MEMLOCK, &little)) _exit(1);
        bool unlimited = little.rlim_cur == RLIM_INFINITY;
        _exit(unlimited == (status == EX_OK) && (status == EX_OK || strstr(why, "LimitMEMLOCK")) ? status : 1);
    }
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    return WEXITSTATUS(status);
}

/* What it may lock now, it has to be able to lock when it has become another user. */
static void test_root_has_no_limit_or_is_refused(void **state)
{
    (void)state;
    if (geteuid() != 0) skip();
    pid_t pid = fork();
    const struct rlimit none = {RLIM_INFINITY, RLIM_INFINITY};
    if (pid == 0) _exit(setrlimit(RLIMIT_MEMLOCK, &none) ? EX_NOPERM : EX_OK); /* this may be a container itself */
    int status;
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(root_status(true), WEXITSTATUS(status));
    assert_int_equal(root_status(false), EX_NOPERM);
}

static void test_nothing_asked(void **state)
{
    (void)state;
    config c;
    char why[16];
    config_default(&c);
    assert_int_equal(realtime_apply(&c, why, sizeof why), EX_OK);
    assert_int_equal(sched_getscheduler(0), SCHED_OTHER);
}

/* The first processor that this process may use is one that it may be pinned to. */
static void test_pinned(void **state)
{
    (void)state;
    cpu_set_t set;
    int status;
    size_t first = 0;
    assert_int_equal(sched_getaffinity(0, sizeof set, &set), 0);
    while (first < CPU_SETSIZE && !CPU_ISSET(first, &set)) first++;
    if (first == CPU_SETSIZE) skip();
    pid_t pid = fork();
    if (pid == 0) {
        config c;
        char why[256];
        config_default(&c);
        snprintf(c.cpus, sizeof c.cpus, "%zu", first);
        bool done = realtime_apply(&c, why, sizeof why) == EX_OK && sched_getaffinity(0, sizeof set, &set) == 0;
        _exit(done && CPU_COUNT(&set) == 1 && CPU_ISSET(first, &set) ? 0 : 1);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
}

/* Where this process has the rights, they are used; where not, that is told. */
static void test_granted_or_told(void **state)
{
    (void)state;
    int status;
    pid_t pid = fork();
    if (pid == 0) {
        config c;
        char why[256] = "";
        config_default(&c);
        c.fifo_priority = 1;
        int applied = realtime_apply(&c, why, sizeof why);
        bool granted = applied == EX_OK && sched_getscheduler(0) == SCHED_FIFO;
        bool told = applied == EX_NOPERM && strstr(why, "ulimit -r") && sched_getscheduler(0) == SCHED_OTHER;
        _exit(granted || told ? 0 : 1);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_int_equal(status, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lists),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_root_has_no_limit_or_is_refused),
        cmocka_unit_test(test_nothing_asked),
        cmocka_unit_test(test_pinned),
        cmocka_unit_test(test_granted_or_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
