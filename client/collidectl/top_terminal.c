/* top_terminal: see top_terminal.h. ANSI sequences that every terminal since the VT100, and xterm, obeys. */
#include "top_terminal.h"

#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

static volatile sig_atomic_t ended, stop_asked;
static bool entered, has_keys;
static struct termios as_it_was;

bool top_terminal_is_there(void)
{
    const char *kind = getenv("TERM");
    return isatty(STDOUT_FILENO) && kind && *kind && strcmp(kind, "dumb") != 0;
}

/* Another screen, no cursor, lines are cut and not wrapped; keys come at once and are not shown. */
void top_terminal_enter(void)
{
    has_keys = tcgetattr(STDIN_FILENO, &as_it_was) == 0 && tcgetpgrp(STDIN_FILENO) == getpgrp();
    struct termios now = as_it_was;
    now.c_lflag &= ~(tcflag_t)(ICANON | ECHO);
    if (has_keys) tcsetattr(STDIN_FILENO, TCSADRAIN, &now);
    fputs("\033[?1049h\033[?25l\033[?7l\033[H\033[2J", stdout);
    fflush(stdout);
    entered = true;
}

void top_terminal_leave(void)
{
    if (!entered) return;
    fputs("\033[?7h\033[?25h\033[?1049l", stdout);
    fflush(stdout);
    if (has_keys) tcsetattr(STDIN_FILENO, TCSADRAIN, &as_it_was);
    entered = false;
}

void top_terminal_size(size_t *columns, size_t *rows)
{
    struct winsize size;
    bool known = ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col && size.ws_row;
    *columns = known ? size.ws_col : 80;
    *rows = known ? size.ws_row : 24;
}

/* Each line is cleared behind its text, and what is below the last: nothing vanishes that is drawn again. */
void top_terminal_show(const char *page)
{
    fputs("\033[H", stdout);
    for (const char *t = page; *t; t += strcspn(t, "\n"), t += *t == '\n') {
        if (t != page) fputs("\r\n", stdout); /* between lines: one behind the last would scroll */
        fwrite(t, 1, strcspn(t, "\n"), stdout);
        fputs("\033[K", stdout);
    }
    fputs("\033[J", stdout);
    fflush(stdout);
}

static void on_end(int number)
{
    (void)number;
    ended = 1;
}

static void on_stop(int number)
{
    (void)number;
    stop_asked = 1;
}

void top_terminal_catch_signals(void)
{
    struct sigaction action = {.sa_handler = on_end};
    sigaction(SIGINT, &action, NULL);
    sigaction(SIGTERM, &action, NULL);
    sigaction(SIGHUP, &action, NULL);
    sigaction(SIGQUIT, &action, NULL);
    action.sa_handler = on_stop;
    sigaction(SIGTSTP, &action, NULL);
}

bool top_terminal_ended(void)
{
    struct pollfd keys = {.fd = STDIN_FILENO, .events = POLLIN};
    char key;
    while (entered && has_keys && poll(&keys, 1, 0) > 0 && read(STDIN_FILENO, &key, 1) == 1)
        if (key == 'q') ended = 1;
    return ended != 0;
}

bool top_terminal_paused(void)
{
    if (!stop_asked) return false;
    bool was_entered = entered;
    top_terminal_leave();
    stop_asked = 0;
    raise(SIGSTOP);
    if (was_entered) top_terminal_enter();
    return true;
}
