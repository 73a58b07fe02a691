/* link_lcm: LCM, "lcm://udpm://ADDRESS:PORT?ttl=0", by way of the process collided-lcm: one crafted datagram kills a
 * process that uses liblcm, so that no process with the world in it does. The link starts the gateway, watches it, and
 * starts it again when it has died; bodies, streams and what waits to be sent live on this side of the pipe. */
#ifndef COLLIDED_LINK_LCM_H
#define COLLIDED_LINK_LCM_H

#include "link.h"

extern const link_ops link_lcm_ops;

/* Process id of the gateway that runs now, 0 while there is none. Any thread. */
int link_lcm_gateway_pid(const struct link *l);

#endif
