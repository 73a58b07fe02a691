/* main: collidectl, the command line of the collision daemon. Parses, runs one verb, cleans up. One thread beside that
 * of the client library. */
#include "options.h"
#include "verbs.h"

#include <stdio.h>
#include <sysexits.h>

static void warn(void *context, const char *text)
{
    (void)context;
    fprintf(stderr, "collidectl: warning: %s\n", text);
}

static void note(void *context, const char *text)
{
    (void)context;
    fprintf(stderr, "collidectl: %s\n", text);
}

static int run(ctl *c, const ctl_verb *verb)
{
    if (!verb && !c->options.help) return ctl_fail(EX_USAGE, "no verb was given: see 'collidectl help'");
    if (c->options.help) {
        options_help(stdout, verb);
        return EX_OK;
    }
    return verb->run(c);
}

int main(int argc, char **argv)
{
    ctl c = {.report = {.warn = warn, .note = note}};
    const ctl_verb *verb;
    int status = options_parse(&c, argc, argv, &verb);
    if (!status) status = run(&c, verb);
    ctl_disconnect(&c);
    pool_free(&c.pool);
    if (fflush(stdout) != 0 && status == EX_OK) status = ctl_fail(EX_IOERR, "standard output cannot be written");
    return status;
}
