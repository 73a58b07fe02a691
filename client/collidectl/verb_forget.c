/* verb_forget: ends what a lost client left. Takes its number for a moment, with the wish that its bodies go, and
 * leaves in order. */
#include "verbs.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sysexits.h>

static bool is_number(const char *text)
{
    return strlen(text) == 16 && strspn(text, "0123456789abcdef") == 16 && strtoull(text, NULL, 16) != 0;
}

/* The daemon's word for it: a client that lives must not be driven out. */
static int check_client_is_lost(ctl *c, const char *number)
{
    char counter[32];
    collided_daemon_status s;
    int status = ctl_check(c, collided_get_status(c->client, c->options.timeout_s, &s), "forget");
    if (status) return status;
    snprintf(counter, sizeof counter, "lost_client_%s", number);
    for (size_t i = 0; i < s.counter_count; i++)
        if (strcmp(s.counters[i].name, counter) == 0) return 0;
    return ctl_fail(
        EX_DATAERR, "forget: the daemon has no bodies of a lost client %s: see 'collidectl doctor'", number);
}

int verb_forget(ctl *c)
{
    const char *number = c->arguments[0];
    if (!is_number(number))
        return ctl_fail(EX_USAGE, "forget: '%s': must be a client's number, 16 hex digits, as doctor tells it", number);
    int status = ctl_connect_guest(c);
    if (!status) status = check_client_is_lost(c, number);
    ctl_disconnect(c);
    if (!status) status = ctl_connect_as(c, (int64_t)strtoull(number, NULL, 16), COLLIDED_REMOVE);
    return status; /* leaving removes them */
}
