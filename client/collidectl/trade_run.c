/* trade_run: the daemon's program as a child; its lines become rows, its progress one line of the terminal. */
#include "trade.h"

#include "loaders/text.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <sysexits.h>
#include <unistd.h>

enum { FIELDS_MAX = 17, ROW_FIELDS = 16, ROWS_MAX = 4096 };

typedef struct reading {
    ctl *c;
    trade *to;
    size_t room;
    bool begun, ended, tty;
} reading;

/* ---- the child ---- */

static void become_daemon(ctl *c, const char *daemon, const char *file, int out)
{
    char *arguments[8] = {(char *)"collided", (char *)"--replay", (char *)file, (char *)"--trade"};
    if (c->options.workers > 0) {
        arguments[4] = (char *)"--workers";
        arguments[5] = pool_format(&c->pool, "%d", (int)c->options.workers);
    }
    dup2(out, STDOUT_FILENO);
    close(out);
    execvp(daemon, arguments);
    ctl_fail(EX_UNAVAILABLE, "trade: %s: %s: install collided beside collidectl, or put it into PATH", daemon,
        strerror(errno));
    _exit(EX_UNAVAILABLE);
}

/* NULL after saying why not. */
static FILE *start(ctl *c, const char *file, pid_t *child)
{
    int ends[2];
    const char *daemon = ctl_find_daemon(c);
    fflush(stdout);
    if (pipe(ends) != 0 || (*child = fork()) < 0) {
        ctl_fail(EX_OSERR, "trade: no process can be started: %s", strerror(errno));
        return NULL;
    }
    if (*child == 0) {
        close(ends[0]);
        become_daemon(c, daemon, file, ends[1]);
    }
    close(ends[1]);
    return fdopen(ends[0], "r");
}

int trade_end_of(pid_t child)
{
    int status;
    while (waitpid(child, &status, 0) < 0)
        if (errno != EINTR) return -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1 - WTERMSIG(status);
}

static int end_of_daemon(pid_t child)
{
    int status = trade_end_of(child);
    if (status >= 0) return status;
    return status == -1 ? EX_OSERR : ctl_fail(EX_SOFTWARE, "trade: collided was ended by signal %d", -1 - status);
}

/* ---- its lines ---- */

static void show_share(const reading *r, double share)
{
    if (r->tty) fprintf(stderr, "\rtrade: %3.0f %% of %.0f ticks", 100 * share, r->to->ticks);
}

static void clear_progress(const reading *r)
{
    if (r->tty) fputs("\r\033[K", stderr);
}

/* A bound that was not found makes an error without end. */
static bool take_number_field(const char *text, double *to)
{
    if (strcmp(text, "inf") == 0) *to = INFINITY;
    return strcmp(text, "inf") == 0 || text_number(text, to);
}

static bool take_row(reading *r, char **field, int count)
{
    double n[ROW_FIELDS];
    trade *t = r->to;
    if (count != ROW_FIELDS || t->row_count == ROWS_MAX) return false;
    for (int i = 3; i < ROW_FIELDS; i++)
        if (!take_number_field(field[i], &n[i])) return false;
    if (t->row_count == r->room) {
        trade_row *more = pool_alloc(&r->c->pool, 2 * r->room + 64, sizeof *more);
        if (t->row_count) memcpy(more, t->rows, t->row_count * sizeof *more);
        t->rows = more;
        r->room = 2 * r->room + 64;
    }
    t->rows[t->row_count++] = (trade_row){.pair = pool_copy(&r->c->pool, field[1]),
        .accuracy = pool_copy(&r->c->pool, field[2]),
        .measured = n[3],
        .time_mean_s = 1e-9 * n[4],
        .time_p99_s = 1e-9 * n[5],
        .errors = n[6],
        .error_max_m = n[7],
        .error_mean_m = n[8],
        .outside = n[9],
        .events = n[10],
        .missed = n[11],
        .false_ones = n[12],
        .bytes_per_s = n[13],
        .tick_mean_s = 1e-9 * n[14],
        .tick_p99_s = 1e-9 * n[15]};
    t->levels += strcmp(field[1], "all") == 0;
    return true;
}

static bool take_numbers(char **field, int count, double **to, int numbers)
{
    if (count != numbers + 1) return false;
    for (int i = 0; i < numbers; i++)
        if (!text_number(field[i + 1], to[i])) return false;
    return true;
}

static bool take_line(reading *r, char *line)
{
    char *field[FIELDS_MAX], *rest = NULL;
    double share;
    trade *t = r->to;
    int count = 0;
    line[strcspn(line, "\n")] = '\0';
    for (char *f = strtok_r(line, "\t", &rest); f && count < FIELDS_MAX; f = strtok_r(NULL, "\t", &rest))
        field[count++] = f;
    if (!count) return false;
    if (!r->begun) return r->begun = count == 2 && !strcmp(field[0], "trade") && !strcmp(field[1], "2");
    if (!strcmp(field[0], "session"))
        return take_numbers(field, count, (double *[]){&t->ticks, &t->seconds, &t->subscriptions, &t->left_out}, 4);
    if (!strcmp(field[0], "answers")) return take_numbers(field, count, (double *[]){&t->answers, &t->measured}, 2);
    if (!strcmp(field[0], "row")) return take_row(r, field, count);
    if (!strcmp(field[0], "end")) return r->ended = true;
    bool reported = !strcmp(field[0], "progress") && take_numbers(field, count, (double *[]){&share}, 1);
    if (reported) show_share(r, share);
    return reported;
}

static bool take_all(reading *r, FILE *from)
{
    char *line = NULL;
    size_t room = 0;
    bool good = true;
    while (good && getline(&line, &room, from) > 0) good = take_line(r, line);
    free(line);
    return good;
}

int trade_run(ctl *c, const char *file, trade *out)
{
    pid_t child;
    *out = (trade){.ticks = 0};
    reading r = {.c = c, .to = out, .tty = isatty(STDERR_FILENO)};
    FILE *from = start(c, file, &child);
    if (!from) return EX_OSERR;
    bool good = take_all(&r, from);
    fclose(from); /* one that still writes is ended by that */
    clear_progress(&r);
    int status = end_of_daemon(child);
    if (good && status) return status; /* it has said why */
    if (good && r.ended && out->levels && out->levels <= TRADE_LEVELS_MAX && out->row_count % out->levels == 0)
        return 0;
    return ctl_fail(EX_UNAVAILABLE, "trade: %s answers in another way: use collided and collidectl of one release",
        ctl_find_daemon(c));
}
