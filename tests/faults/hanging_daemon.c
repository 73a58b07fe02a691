/* The daemon, whose thread that ticks stands still for ever at a Body that is named "hang...", and is ended by a fault
 * at one that is named "fault...": a stand-in for commands that are not known yet to do so. */
#include "base/log.h"
#include "service/config.h"
#include "service/server.h"
#include "service/service.h"
#include "service/signals.h"

#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void hang(void *context, const wire_message *m)
{
    (void)context;
    if (m->kind != WIRE_BODY || m->body.removed) return;
    if (strncmp(m->body.name, "fault", 5) == 0) raise(SIGSYS); /* a sanitizer does not take that one */
    if (strncmp(m->body.name, "hang", 4) != 0) return;
    char path[256];
    snprintf(path, sizeof path, "%s/hangs", getenv("RUNTIME_DIRECTORY"));
    close(open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600)); /* for who waits for it */
    for (;;) pause();
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
    if (config_arguments(&c, argc, argv, &asked, why, sizeof why) != 0) return 64;
    log_setup(LOG_NOTICE, false);
    signals_block();
    server *s = server_create(&c, why, sizeof why);
    if (!s) {
        fprintf(stderr, "%s\n", why);
        return 69;
    }
    server_service(s)->on_command = hang;
    signals_watch(stop, stop, s); /* nobody asks for the end of a recording */
    int status = server_run(s);
    server_destroy(s);
    return status;
}
