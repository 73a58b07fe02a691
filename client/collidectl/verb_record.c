/* verb_record: starts a recording on the daemon and ends it at SIGINT, or after --seconds. */
#include "verbs.h"

#include <stdio.h>
#include <string.h>
#include <sysexits.h>

int verb_record(ctl *c)
{
    const char *name = c->arguments[0];
    if (!*name || strchr(name, '/')) return ctl_fail(EX_USAGE, "record: '%s': must be a plain name without '/'", name);
    int status = ctl_connect_guest(c);
    if (status) return status;
    collided_result result = {0};
    ctl_catch_signals();
    status = ctl_check(c, collided_record(c->client, name, c->options.timeout_s, &result), "record");
    if (status) return status;
    printf("recording: %s\n", result.text ? result.text : name);
    fflush(stdout);
    collided_result_free(&result);
    status = ctl_poll(c, c->options.seconds);
    result = (collided_result){0};
    int ended = ctl_check(c, collided_record(c->client, NULL, c->options.timeout_s, &result), "record: ending it");
    if (!ended) printf("recorded: %s\n", result.text ? result.text : name);
    collided_result_free(&result);
    return status ? status : ended;
}
