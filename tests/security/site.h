/* site: certificates for the tests, made by script/make_site in a folder of this process's own, and spoiled copies. */
#ifndef COLLIDED_TESTS_SECURITY_SITE_H
#define COLLIDED_TESTS_SECURITY_SITE_H

#include <stdbool.h>

/* Sites "ours" and "theirs": daemon, robot, watcher:subscribe; "signed" and "origin", protected so: daemon, robot.
 * "short": its certificates last ten days.
 * "revoking": robot and watcher were revoked and made anew, was_robot, was_robot_first (before a renewal) and
 * was_watcher are what they had; "revoking_before" is the site before that. False if they cannot be made. */
bool site_make(void);
void site_remove(void);
const char *site_folder(const char *name); /* "ours/robot"; valid until the fourth call after it */
/* A copy of a folder, changed by a shell line that runs in it: $SITES is where the sites are. */
const char *site_spoiled(const char *name, const char *as, const char *line);

#endif
