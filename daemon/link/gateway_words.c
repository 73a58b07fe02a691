/* gateway_words: a descriptor that is never waited for. The thread that watches the gateway. */
#include "gateway_words.h"

#include "base/log.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static void end_line(gateway_words *w)
{
    w->line[w->used] = '\0';
    if (w->used && !w->keep)
        log_error("%s", w->line);
    else if (w->used && !*w->first)
        memcpy(w->first, w->line, w->used + 1);
    w->used = 0;
}

void gateway_words_begin(gateway_words *w, int fd, bool keep)
{
    *w = (gateway_words){.fd = fd, .keep = keep};
}

/* A line that is too long goes on as another one. */
bool gateway_words_read(gateway_words *w)
{
    char text[1024];
    ssize_t n = read(w->fd, text, sizeof text);
    if (n < 0) return errno == EAGAIN || errno == EINTR;
    for (ssize_t i = 0; i < n; i++) {
        if (text[i] == '\n' || w->used == sizeof w->line - 1) end_line(w);
        if (text[i] != '\n') w->line[w->used++] = text[i];
    }
    return n > 0;
}

void gateway_words_report(gateway_words *w)
{
    w->keep = false;
    if (*w->first) log_error("%s", w->first);
    w->first[0] = '\0';
}

/* The gateway has ended: what is left is in the pipe, and a pipe holds 64 kB. */
void gateway_words_end(gateway_words *w)
{
    enum { READS_MOST = 64 };
    for (int i = 0; i < READS_MOST && w->fd >= 0 && gateway_words_read(w); i++) continue;
    end_line(w);
    if (w->fd >= 0) close(w->fd);
    w->fd = -1;
}
