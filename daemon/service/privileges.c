/* setgroups, setgid, setuid, in this order: the first two need what the third gives up. glibc applies them to all
 * threads. */
#include "privileges.h"

#include "base/log.h"

#include <errno.h>
#include <grp.h>
#include <pwd.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/prctl.h>
#include <sysexits.h>
#include <unistd.h>

int privileges_check(const char *user, char *why, size_t why_size)
{
    if (!*user) return EX_OK;
    const struct passwd *who = getpwnam(user); /* nothing else runs yet */
    if (!who) {
        snprintf(why, why_size, "user = \"%.60s\": there is no such user: useradd --system makes one", user);
        return EX_CONFIG;
    }
    if (geteuid() == 0 || geteuid() == who->pw_uid) return EX_OK;
    snprintf(why, why_size,
        "user = \"%.60s\": only root can become another user: start it as that one, or leave it out", user);
    return EX_NOPERM;
}

static bool become(const struct passwd *who)
{
    return initgroups(who->pw_name, who->pw_gid) == 0 && setgid(who->pw_gid) == 0 && setuid(who->pw_uid) == 0;
}

/* Of this thread and those that it will start: so it comes before them. */
void privileges_no_more(void)
{
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) log_warning("PR_SET_NO_NEW_PRIVS: %s", strerror(errno));
}

void privileges_report(const char *user)
{
    if (geteuid() == 0 && !*user)
        log_notice("this is root: user = NAME in the configuration, or the systemd unit, lets it run as another");
}

int privileges_drop(const char *user, char *why, size_t why_size)
{
    if (geteuid() != 0 || !*user) return 0; /* it is that user already, or stays root */
    const struct passwd *who = getpwnam(user);
    if (who && become(who) && (who->pw_uid == 0 || setuid(0) != 0)) return 0;
    snprintf(why, why_size, "user = \"%.60s\": %s", user, who ? strerror(errno) : "there is no such user any more");
    return -1;
}
