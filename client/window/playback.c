/* playback: the child, its commands and its lines. */
#include "playback.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

enum { CHILD_A = 3, CHILD_B = 4 };

typedef struct ends { /* ours and the child's: of A, B, and standard input and output */
    int a[2], b[2], in[2], out[2];
} ends;

static bool open_ends(ends *e)
{
    const ends none = {{-1, -1}, {-1, -1}, {-1, -1}, {-1, -1}};
    *e = none;
    return socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, e->a) == 0 &&
           socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, e->b) == 0 &&
           socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, e->in) == 0 && pipe2(e->out, O_CLOEXEC) == 0;
}

static void close_ends(const ends *e)
{
    const int *all[] = {e->a, e->b, e->in, e->out};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++)
            if (all[i][k] >= 0) close(all[i][k]);
}

/* Between fork and exec. First out of the way of 0 to 4, then there, without close-on-exec. */
static void become_child(const ends *e, const char *daemon, const char *file, long workers)
{
    char count[32];
    int from[] = {e->in[0], e->out[1], e->a[1], e->b[1]};
    static const int TO[] = {STDIN_FILENO, STDOUT_FILENO, CHILD_A, CHILD_B};
    for (int i = 0; i < 4; i++) from[i] = fcntl(from[i], F_DUPFD_CLOEXEC, 10);
    for (int i = 0; i < 4; i++)
        if (dup2(from[i], TO[i]) < 0) _exit(71);
    snprintf(count, sizeof count, "%ld", workers > 0 ? workers : 1);
    char *arguments[] = {(char *)"collided", (char *)"--replay", (char *)file, (char *)"--replay_pipe", (char *)"3,4",
        (char *)"--log", (char *)"error", (char *)"--workers", count, NULL};
    execvp(daemon, arguments);
    fprintf(stderr, "%s: %s: install collided beside this program, or put it into PATH\n", daemon, strerror(errno));
    _exit(69);
}

/* ---- what the child says ---- */

/* The number that comes next, behind a space. */
static bool take_number(const char **at, int64_t *to)
{
    char *end;
    errno = 0;
    if (**at != ' ') return false;
    *to = strtoll(*at + 1, &end, 10);
    bool is = end != *at + 1 && !errno;
    *at = end;
    return is;
}

static bool take_place(playback *p, const char *at)
{
    static const char *const NAMES[] = {"paused", "playing", "seeking", "ended"};
    if (!take_number(&at, &p->at_ns) || !take_number(&at, &p->tick) || *at != ' ') return false;
    size_t length = strcspn(++at, " ");
    if (!at[length]) return false;
    p->speed = strtod(at + length, NULL);
    for (int i = 0; i < 4; i++) {
        if (strlen(NAMES[i]) != length || strncmp(NAMES[i], at, length) != 0) continue;
        p->state = (playback_state)i;
        return true;
    }
    return false;
}

static bool take_line(playback *p, const char *line)
{
    const char *rest = line + strcspn(line, " ");
    size_t word = (size_t)(rest - line);
    int64_t done = 0;
    if (word == 7 && strncmp(line, "damaged", word) == 0) {
        snprintf(p->damaged, sizeof p->damaged, "%s", *rest ? rest + 1 : "");
        return true;
    }
    if (word == 4 && strncmp(line, "done", word) == 0) {
        bool is = take_number(&rest, &done);
        p->done = (unsigned)done;
        return is;
    }
    if (word == 9 && strncmp(line, "recording", word) == 0)
        return take_number(&rest, &p->begin_ns) && take_number(&rest, &p->end_ns) && take_number(&rest, &p->ticks);
    bool took = word == 2 && strncmp(line, "at", word) == 0 && take_place(p, rest);
    p->known |= took;
    return took;
}

static void take_octets(playback *p, const char *at, size_t size)
{
    for (size_t i = 0; i < size && !p->gone; i++) {
        if (at[i] != '\n') {
            if (p->line_size < sizeof p->line - 1) p->line[p->line_size++] = at[i];
            continue;
        }
        p->line[p->line_size] = '\0';
        p->line_size = 0;
        p->gone = !take_line(p, p->line);
    }
}

void playback_poll(playback *p)
{
    char text[4096];
    ssize_t n = 1;
    while (!p->gone && n > 0) {
        n = read(p->answers, text, sizeof text);
        if (n > 0) take_octets(p, text, (size_t)n);
        if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) p->gone = true;
    }
}

bool playback_rests(const playback *p)
{
    return p->done == p->sent && (p->state == PLAYBACK_PAUSED || p->state == PLAYBACK_ENDED);
}

/* ---- its life ---- */

void playback_program(char program[PLAYBACK_PROGRAM_MAX])
{
    ssize_t n = readlink("/proc/self/exe", program, PLAYBACK_PROGRAM_MAX - sizeof "collided");
    program[n > 0 ? n : 0] = '\0';
    char *slash = strrchr(program, '/');
    if (slash) memcpy(slash + 1, "collided", sizeof "collided");
    if (!slash || access(program, X_OK) != 0) memcpy(program, "collided", sizeof "collided");
}

bool playback_open(playback *p, const char *daemon, const char *file, long workers, char *why, size_t why_size)
{
    ends e;
    *p = (playback){.child = -1, .commands = -1, .answers = -1, .pipe = {-1, -1}};
    *why = '\0';
    fflush(stdout);
    if (!open_ends(&e) || (p->child = fork()) < 0) {
        snprintf(why, why_size, "no process can be started: %s", strerror(errno));
        close_ends(&e);
        return false;
    }
    if (p->child == 0) become_child(&e, daemon, file, workers);
    p->pipe[0] = e.a[0];
    p->pipe[1] = e.b[0];
    p->commands = e.in[1];
    p->answers = e.out[0];
    e.a[0] = e.b[0] = e.in[1] = e.out[0] = -1;
    close_ends(&e);
    (void)fcntl(p->answers, F_SETFL, O_NONBLOCK);
    snprintf(p->uri, sizeof p->uri, "pipe://%d,%d", p->pipe[0], p->pipe[1]);
    while (!p->known && !p->gone) {
        (void)poll(&(struct pollfd){.fd = p->answers, .events = POLLIN}, 1, -1);
        playback_poll(p);
    }
    return !p->gone;
}

const char *playback_take_uri(playback *p)
{
    p->pipe[0] = p->pipe[1] = -1;
    return p->uri;
}

static void command(playback *p, const char *text)
{
    size_t size = strlen(text);
    p->sent++;
    while (size && p->commands >= 0) {
        ssize_t n = send(p->commands, text, size, MSG_NOSIGNAL);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) break;
        text += n;
        size -= (size_t)n;
    }
    if (size) p->gone = true;
}

void playback_play(playback *p, double speed)
{
    char text[64];
    snprintf(text, sizeof text, "play %.17g\n", speed);
    command(p, text);
}

void playback_step(playback *p)
{
    command(p, "step\n");
}

void playback_pause(playback *p)
{
    command(p, "pause\n");
}

void playback_seek(playback *p, int64_t ns)
{
    char text[64];
    snprintf(text, sizeof text, "to %" PRId64 "\n", ns);
    command(p, text);
}

int playback_close(playback *p)
{
    int status = 0;
    int *const all[] = {&p->commands, &p->answers, &p->pipe[0], &p->pipe[1]};
    for (size_t i = 0; i < sizeof all / sizeof all[0]; i++) {
        if (*all[i] >= 0) close(*all[i]);
        *all[i] = -1;
    }
    if (p->child <= 0) return 71;
    while (waitpid(p->child, &status, 0) < 0)
        if (errno != EINTR) return 71;
    p->child = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}
