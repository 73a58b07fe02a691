/* verb_replay: hands over to the daemon's own binary, so that a replay runs the very same code. */
#include "verbs.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <unistd.h>

/* "collided" in the folder that this program lies in; "collided" alone (PATH) if it is not there. */
static const char *find_daemon(ctl *c)
{
    char self[PATH_MAX];
    ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
    if (length <= 0) return "collided";
    self[length] = '\0';
    char *slash = strrchr(self, '/');
    if (!slash) return "collided";
    const char *beside = pool_format(&c->pool, "%.*s/collided", (int)(slash - self), self);
    return access(beside, X_OK) == 0 ? beside : "collided";
}

int verb_replay(ctl *c)
{
    const char *file = c->arguments[0];
    if (access(file, R_OK) != 0) return ctl_fail(EX_NOINPUT, "replay: %s: %s", file, strerror(errno));
    const char *daemon = find_daemon(c);
    char *arguments[8] = {(char *)"collided", (char *)"--replay", (char *)file};
    int count = 3;
    if (c->options.workers > 0) {
        arguments[count++] = (char *)"--workers";
        arguments[count++] = pool_format(&c->pool, "%d", (int)c->options.workers);
    }
    if (c->options.json) arguments[count++] = (char *)"--json";
    execvp(daemon, arguments);
    return ctl_fail(EX_UNAVAILABLE, "replay: %s: %s: install collided beside collidectl, or put it into PATH", daemon,
        strerror(errno));
}
