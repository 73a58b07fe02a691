/* collided: the collision daemon. This reads as the life of the process. */
#include "base/log.h"
#include "service/config.h"
#include "service/server.h"
#include "service/signals.h"
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

int main(int argc, char **argv)
{
    config c;
    const char *asked = NULL;
    char why[2048];

    config_default(&c);
    if (config_arguments(&c, argc, argv, &asked, why, sizeof why) < 0) {
        fprintf(stderr, "collided: %s\n", why);
        return EX_CONFIG;
    }
    if (asked && strcmp(asked, "help") == 0) {
        config_help();
        return EX_OK;
    }
    if (asked) {
        printf("collided %s, wire version %d\n", COLLIDED_RELEASE, WIRE_VERSION);
        return EX_OK;
    }
    log_setup(level_of(c.log), c.journal);
    signals_block();
    server *s = server_create(&c, why, sizeof why);
    if (!s) {
        fprintf(stderr, "collided: %s\n", why);
        return EX_UNAVAILABLE;
    }
    signals_watch(stop, s);
    int status = server_run(s);
    server_destroy(s);
    return status;
}
