/* The daemon, whose thread that ticks stands still for ever at a Body that is named "hang...", and is ended by a fault
 * at one that is named "fault...". Its threads that build do the same where the folder that is told by
 * RUNTIME_DIRECTORY has a file "build_hangs", "build_faults", or "build_fills", for one that finds no memory. A
 * stand-in for what is not known yet to do so. */
#include "base/array.h"
#include "base/log.h"
#include "service/builds.h"
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

static bool is_there(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", getenv("RUNTIME_DIRECTORY"), name);
    return access(path, F_OK) == 0;
}

static void make(const char *name)
{
    char path[256];
    snprintf(path, sizeof path, "%s/%s", getenv("RUNTIME_DIRECTORY"), name);
    close(open(path, O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
}

static void fail_to_build(void *context, int64_t id)
{
    (void)context;
    (void)id;
    if (is_there("build_faults")) raise(SIGSYS);
    if (is_there("build_fills")) free(base_alloc(SIZE_MAX / 2, 1));
    if (!is_there("build_hangs")) return;
    make("hangs");
    while (is_there("build_hangs")) usleep(1000);
}

static void hang(void *context, const wire_message *m)
{
    (void)context;
    if (m->kind != WIRE_BODY || m->body.removed) return;
    if (strncmp(m->body.name, "fault", 5) == 0) raise(SIGSYS); /* a sanitizer does not take that one */
    if (strncmp(m->body.name, "hang", 4) != 0) return;
    make("hangs"); /* for who waits for it */
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
    builds_hold(server_service(s)->builds, fail_to_build, NULL);
    signals_watch(stop, stop, s); /* nobody asks for the end of a recording */
    int status = server_run(s);
    server_destroy(s);
    return status;
}
