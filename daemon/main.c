/* collided: the collision daemon. This reads as the life of the process. */
#include "base/log.h"
#include "service/config.h"
#include "service/realtime.h"
#include "service/server.h"
#include "service/signals.h"
#include "service/start.h"
#include "trade/trade.h"
#include "wire/wire.h"

#include <stdio.h>
#include <string.h>
#include <sysexits.h>

static log_level level_of(const char *name)
{
    static const char *const NAMES[] = {"error", "warning", "notice", "info", "debug"};
    for (int i = 0; i < 5; i++)
        if (strcmp(NAMES[i], name) == 0) return (log_level)i;
    return LOG_NOTICE;
}

static void stop(void *context)
{
    server_stop(context);
}

static void end_recording(void *context)
{
    server_end_recording(context);
}

static int fail(int status, const char *why)
{
    fprintf(stderr, "collided: %s\n", why);
    return status;
}

static int answer(const char *asked)
{
    if (strcmp(asked, "help") == 0)
        config_help();
    else
        printf("collided %s, wire version %d\n", COLLIDED_RELEASE, WIRE_VERSION);
    return EX_OK;
}

int main(int argc, char **argv)
{
    config c;
    const char *asked = NULL;
    char why[2048], no_lcm[2048];

    config_default(&c);
    int status = config_arguments(&c, argc, argv, &asked, why, sizeof why);
    if (status < 0) return fail(-status, why);
    if (asked) return answer(asked);
    start_environment(&c);
    bool all_links = start_choose_links(&c, no_lcm, sizeof no_lcm);
    status = start_check(&c, why, sizeof why);
    if (status != EX_OK) return fail(status, why);
    log_setup(c.trade ? LOG_ERROR : level_of(c.log), c.journal);
    if (c.trade) return trade_run(&c);
    if (!all_links) log_notice("links = auto: without LCM: %s", no_lcm);
    status = realtime_apply(&c, why, sizeof why);
    if (status != EX_OK) return fail(status, why);
    signals_block();
    server *s = server_create(&c, why, sizeof why);
    if (!s) return fail(EX_UNAVAILABLE, why);
    signals_watch(stop, end_recording, s);
    status = server_run(s);
    server_destroy(s);
    return status;
}
