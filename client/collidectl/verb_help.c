/* verb_help: help and version, which need no daemon. */
#include "options.h"
#include "verbs.h"

#include <stdio.h>
#include <sysexits.h>

int verb_help(ctl *c)
{
    const ctl_verb *verb = c->argument_count ? ctl_find_verb(c->arguments[0]) : NULL;
    if (c->argument_count && !verb) return ctl_fail(EX_USAGE, "help: unknown verb '%s'", c->arguments[0]);
    options_help(stdout, verb);
    return EX_OK;
}

int verb_version(ctl *c)
{
    (void)c;
    printf("collidectl %s\n", collided_version());
    return EX_OK;
}
