#include "site.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char sites[64];

static bool run(const char *line)
{
    return system(line) == 0; /* NOLINT(cert-env33-c): lines of these tests */
}

bool site_make(void)
{
    snprintf(sites, sizeof sites, "/tmp/collided-sites-XXXXXX");
    if (!mkdtemp(sites)) return false;
    setenv("SITES", sites, 1);
    return run("for site in ours theirs; do " MAKE_SITE
               " $SITES/$site robot watcher:subscribe || exit 1; done; " MAKE_SITE
               " --protect sign $SITES/signed && " MAKE_SITE " $SITES/signed robot && ! " MAKE_SITE
               " --protect origin $SITES/signed 2>/dev/null && " MAKE_SITE " --protect origin $SITES/origin robot") &&
           run(MAKE_SITE " --days 10 $SITES/short robot >/dev/null") &&
           run("cd $SITES && " MAKE_SITE
               " revoking robot second watcher:subscribe >/dev/null && cp -r revoking/robot first && " MAKE_SITE
               " --renew revoking >/dev/null && cp -r revoking revoking_before && cd revoking && "
               "mv ../first was_robot_first && cp -r robot was_robot && cp -r watcher was_watcher && "
               "mv was_robot was_robot_first was_watcher .. && " MAKE_SITE " --revoke robot . >/dev/null && " MAKE_SITE
               " --revoke watcher . >/dev/null && " MAKE_SITE " . robot watcher:subscribe >/dev/null && "
               "mv ../was_robot ../was_robot_first ../was_watcher .");
}

void site_remove(void)
{
    if (*sites && !run("rm -rf -- \"$SITES\"")) printf("%s is left behind\n", sites);
}

const char *site_folder(const char *name)
{
    static char folders[4][128];
    static int next;
    next = (next + 1) % 4;
    snprintf(folders[next], sizeof folders[0], "%s/%s", sites, name);
    return folders[next];
}

const char *site_spoiled(const char *name, const char *as, const char *line)
{
    char all[2048];
    snprintf(all, sizeof all, "cp -r $SITES/%s $SITES/%s && cd $SITES/%s && { %s; }", name, as, as, line);
    if (!run(all)) printf("failed: %s\n", all);
    return site_folder(as);
}
