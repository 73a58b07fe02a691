/* log: formats a line on the stack and hands it to the kernel in one write, so that lines of several threads do not
 * mix. Any thread. A message from outside cannot break the line: control characters are shown as '?'. */
#include "log.h"

#include "clock.h"

#include <errno.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { LINE_BYTES = 1024 }; /* a longer line is cut and ends in "..." */

typedef struct line {
    char text[LINE_BYTES];
    size_t length;
} line;

static log_level most_printed = LOG_INFO;
static bool with_journal_prefix;

static const struct {
    const char *name;
    int syslog; /* syslog(3) priority */
} levels[] = {
    [LOG_ERROR] = {"error", 3},
    [LOG_WARNING] = {"warning", 4},
    [LOG_NOTICE] = {"notice", 5},
    [LOG_INFO] = {"info", 6},
    [LOG_DEBUG] = {"debug", 7},
};

void log_setup(log_level most, int journal)
{
    most_printed = most;
    with_journal_prefix = journal != 0;
}

static void line_vadd(line *l, const char *format, va_list arguments)
{
    static const char cut[] = "...";
    size_t room = LINE_BYTES - 1 - l->length; /* the last byte is for the newline */
    int wanted = vsnprintf(l->text + l->length, room, format, arguments);
    if (wanted < 0) return;
    bool fits = (size_t)wanted < room;
    l->length += fits ? (size_t)wanted : room - 1;
    if (!fits) memcpy(l->text + l->length - (sizeof cut - 1), cut, sizeof cut - 1);
}

__attribute__((format(printf, 2, 3))) static void line_add(line *l, const char *format, ...)
{
    va_list arguments;
    va_start(arguments, format);
    line_vadd(l, format, arguments);
    va_end(arguments);
}

static void line_print(line *l)
{
    for (size_t i = 0; i < l->length; i++)
        if ((unsigned char)l->text[i] < ' ' || l->text[i] == 0x7f) l->text[i] = '?';
    l->text[l->length++] = '\n';
    for (size_t done = 0; done < l->length;) {
        ssize_t n = write(STDERR_FILENO, l->text + done, l->length - done);
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return; /* standard error is closed or full: there is nobody left to tell */
        done += (size_t)n;
    }
}

/* Whether this line may be printed, as the how-manieth of its second, and how many were left out before it. Threads
 * that meet at the turn of a second may print a few lines more than the burst; none is lost uncounted. */
static bool site_admits(log_site *site, uint32_t *turn, uint32_t *muted)
{
    int64_t now = clock_monotonic_ns() / 1000000000 + 1; /* never 0, the second of a new site */
    int64_t second = site->second;
    if (second != now && atomic_compare_exchange_strong(&site->second, &second, now)) site->printed = 0;
    *turn = site->printed++;
    if (*turn >= LOG_BURST) {
        site->muted++;
        return false;
    }
    *muted = atomic_exchange(&site->muted, 0);
    return true;
}

void log_write(log_site *site, log_level level, const char *format, ...)
{
    uint32_t turn, muted;
    if (level > most_printed || !site_admits(site, &turn, &muted)) return;

    line l = {.length = 0};
    if (with_journal_prefix) line_add(&l, "<%d>", levels[level].syslog);
    line_add(&l, "%s: ", levels[level].name);
    /* The remarks come first: a cut must not take them. */
    if (muted) line_add(&l, "(%u like this were left out) ", muted);
    if (turn == LOG_BURST - 1) line_add(&l, "(more like this are left out until the second is over) ");
    va_list arguments;
    va_start(arguments, format);
    line_vadd(&l, format, arguments);
    va_end(arguments);
    line_print(&l);
}
