/* top on a terminal: it follows another size, says when the daemon is gone, and leaves all as it was, however it ends;
 * and without a terminal, plain lines. The terminal is a pseudo-terminal whose other end is the test. */
#include "run.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <sysexits.h>
#include <termios.h>
#include <time.h>
#include <unistd.h>

typedef struct terminal {
    int master, slave;
    struct termios before;
    pid_t child;
    char text[1 << 16]; /* all that was written to it */
    size_t size;
} terminal;

static terminal the_terminal;

static void resize(const terminal *t, unsigned short columns, unsigned short rows)
{
    const struct winsize size = {.ws_col = columns, .ws_row = rows};
    assert_int_equal(ioctl(t->master, TIOCSWINSZ, &size), 0);
}

static terminal *start(const char *option)
{
    terminal *t = &the_terminal;
    *t = (terminal){.master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC)};
    assert_true(t->master >= 0 && grantpt(t->master) == 0 && unlockpt(t->master) == 0);
    t->slave = open(ptsname(t->master), O_RDWR | O_NOCTTY | O_CLOEXEC);
    assert_true(t->slave >= 0);
    resize(t, 80, 24);
    assert_int_equal(tcgetattr(t->slave, &t->before), 0);
    setenv("TERM", "xterm", 1);
    t->child = fork();
    assert_true(t->child >= 0);
    if (t->child == 0) {
        setsid();
        ioctl(t->slave, TIOCSCTTY, 0);
        dup2(t->slave, STDIN_FILENO);
        dup2(t->slave, STDOUT_FILENO);
        int nowhere = open("/dev/null", O_WRONLY);
        dup2(nowhere, STDERR_FILENO);
        execl(COLLIDECTL_FAKED, "collidectl", "top", option, (char *)NULL);
        _exit(127);
    }
    return t;
}

static double now_s(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Reads until `words` have been written behind `from`; where they end. */
static size_t await(terminal *t, size_t from, const char *words)
{
    for (double end = now_s() + 60; now_s() < end;) {
        struct pollfd reading = {.fd = t->master, .events = POLLIN};
        char *found = memmem(t->text + from, t->size - from, words, strlen(words));
        if (found) return (size_t)(found - t->text) + strlen(words);
        assert_true(t->size < sizeof t->text);
        if (poll(&reading, 1, 100) <= 0) continue;
        ssize_t got = read(t->master, t->text + t->size, sizeof t->text - t->size);
        if (got > 0) t->size += (size_t)got;
    }
    fail_msg("never written: %s", words);
    return 0;
}

/* It has ended with that status; its screen is gone, the cursor is back, and the settings are those from before. */
static void ends(terminal *t, size_t from, int expected)
{
    int status;
    struct termios after;
    await(t, from, "\033[?7h\033[?25h\033[?1049l");
    assert_int_equal(waitpid(t->child, &status, 0), t->child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), expected);
    assert_int_equal(tcgetattr(t->slave, &after), 0);
    assert_int_equal(after.c_lflag, t->before.c_lflag);
    assert_int_equal(after.c_iflag, t->before.c_iflag);
    close(t->master);
    close(t->slave);
}

/* Of the next view: lines have an end between them, and none behind the last, which would scroll. */
static int lines_of_next(terminal *t, size_t *at)
{
    int lines = 1;
    size_t begin = await(t, *at, "\033[H\033[1mcollided  ready, host:1");
    *at = await(t, begin, "\033[J");
    for (size_t i = begin; i < *at; i++) lines += t->text[i] == '\n';
    return lines;
}

static void press(const terminal *t, char key)
{
    assert_int_equal(write(t->master, &key, 1), 1);
}

static void it_draws_on_a_screen_of_its_own_and_follows_its_size(void **state)
{
    (void)state;
    terminal *t = start(NULL);
    size_t at = await(t, 0, "\033[?1049h\033[?25l");
    at = await(t, at, "collided  ready, host:1");
    at = await(t, at, "CLIENT");
    resize(t, 30, 2);
    int tries = 0;
    while (lines_of_next(t, &at) != 2) assert_true(++tries < 50); /* one may have been begun before */
    press(t, 3);                                                  /* Ctrl-C, which the terminal makes a signal of */
    ends(t, at, EX_OK);
}

static void q_ends_it(void **state)
{
    (void)state;
    terminal *t = start(NULL);
    size_t at = await(t, 0, "collided  ready");
    press(t, 'q');
    ends(t, at, EX_OK);
}

static int unheard_s(terminal *t, size_t *at)
{
    size_t number = await(t, *at, "NOT HEARD for ");
    *at = await(t, number, " s: it is looked for");
    return atoi(t->text + number);
}

static void a_daemon_that_is_gone_is_told_and_looked_for(void **state)
{
    (void)state;
    setenv("FAKE_DIES", "4", 1);
    terminal *t = start(NULL);
    size_t at = await(t, 0, "collided  ready");
    int first = unheard_s(t, &at), later = first;
    at = await(t, at, "collided  ready, host:1");     /* what was known */
    while (later == first) later = unheard_s(t, &at); /* it goes on */
    assert_true(first >= 1 && later > first);
    kill(t->child, SIGTERM);
    ends(t, at, EX_OK);
    unsetenv("FAKE_DIES");
}

static void stopping_it_gives_the_terminal_back_meanwhile(void **state)
{
    (void)state;
    struct termios meanwhile;
    terminal *t = start(NULL);
    size_t at = await(t, 0, "collided  ready");
    press(t, 26); /* Ctrl-Z */
    at = await(t, at, "\033[?25h\033[?1049l");
    int status;
    assert_int_equal(waitpid(t->child, &status, WUNTRACED), t->child);
    assert_true(WIFSTOPPED(status));
    assert_int_equal(tcgetattr(t->slave, &meanwhile), 0);
    assert_int_equal(meanwhile.c_lflag, t->before.c_lflag);
    kill(t->child, SIGCONT);
    at = await(t, at, "\033[?1049h");
    at = await(t, at, "collided  ready");
    press(t, 'q');
    ends(t, at, EX_OK);
}

static void without_a_terminal_it_prints_plain_lines(void **state)
{
    (void)state;
    static run r;
    run_program(COLLIDECTL_FAKED, "top --once", &r);
    assert_int_equal(r.status, EX_OK);
    assert_non_null(strstr(r.out, "collided  ready, host:1, release 0.1"));
    assert_null(strchr(r.out, '\033'));
    bool twice = false;
    for (int tries = 0; tries < 10 && !twice; tries++) { /* a busy machine may find the time for one only */
        run_program(COLLIDECTL_FAKED, "top --seconds 1.6", &r);
        assert_int_equal(r.status, EX_OK);
        char *first = strstr(r.out, "collided  ready");
        assert_non_null(first);
        assert_null(strchr(r.out, '\033'));
        twice = strstr(first + 1, "\n\ncollided  ready");
    }
    assert_true(twice);
    run_program(COLLIDECTL_FAKED, "top --once --json", &r);
    assert_int_equal(strncmp(r.out, "{\"health\":\"ready\",\"unheard_s\":0,", 31), 0);
    assert_true(strchr(r.out, '\n') == r.out + strlen(r.out) - 1);
    setenv("FAKE_DIES", "0", 1);
    run_program(COLLIDECTL_FAKED, "top --once", &r);
    assert_int_equal(r.status, EX_UNAVAILABLE);
    assert_non_null(strstr(r.err, "no longer heard"));
    unsetenv("FAKE_DIES");
}

static int set_health(void **state)
{
    setenv("FAKE_HEALTH", "ready", 1);
    return run_make_state(state);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(it_draws_on_a_screen_of_its_own_and_follows_its_size),
        cmocka_unit_test(q_ends_it),
        cmocka_unit_test(a_daemon_that_is_gone_is_told_and_looked_for),
        cmocka_unit_test(stopping_it_gives_the_terminal_back_meanwhile),
        cmocka_unit_test(without_a_terminal_it_prints_plain_lines),
    };
    return cmocka_run_group_tests(tests, set_health, run_remove_state);
}
