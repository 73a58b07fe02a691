/* verb_replay: hands over to the daemon's own binary, so that a replay runs the very same code. */
#include "verbs.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

int verb_replay(ctl *c)
{
    const char *file = c->arguments[0];
    if (access(file, R_OK) != 0) return ctl_fail(EX_NOINPUT, "replay: %s: %s", file, strerror(errno));
    const char *daemon = ctl_find_daemon(c);
    char *arguments[10] = {(char *)"collided", (char *)"--replay", (char *)file};
    int count = 3;
    if (c->options.workers > 0) {
        arguments[count++] = (char *)"--workers";
        arguments[count++] = pool_format(&c->pool, "%d", (int)c->options.workers);
    }
    if (c->options.speed > 0) {
        arguments[count++] = (char *)"--replay_speed";
        arguments[count++] = pool_format(&c->pool, "%.17g", c->options.speed);
    }
    if (c->options.json) arguments[count++] = (char *)"--json";
    execvp(daemon, arguments);
    return ctl_fail(EX_UNAVAILABLE, "replay: %s: %s: install collided beside collidectl, or put it into PATH", daemon,
        strerror(errno));
}
