/* start: what can be told to be wrong before anything is started, created or announced. Main thread. */
#ifndef COLLIDED_SERVICE_START_H
#define COLLIDED_SERVICE_START_H

#include "config.h"

/* What the environment says and the configuration does not: COLLIDED_SECURITY; and how memory is to be kept. */
void start_environment(config *c);

/* EX_OK, or another status of sysexits.h with one line in `why`: what is wrong and how to mend it. */
int start_check(const config *c, char *why, size_t why_size);

/* What `links = auto` means on this machine, written into c->links: dds://0, and lcm:// where it can be carried. False:
 * lcm:// is left out, for the reason in `why`. Whoever names lcm:// insists: then start_check refuses. */
bool start_choose_links(config *c, char *why, size_t why_size);

#endif
