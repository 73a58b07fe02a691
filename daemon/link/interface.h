/* interface: network interfaces of this machine, by name or address. Any thread. */
#ifndef COLLIDED_LINK_INTERFACE_H
#define COLLIDED_LINK_INTERFACE_H

#include <stdbool.h>
#include <stddef.h>

/* True for "" too, which stands for loopback. Otherwise `why` names the interfaces that there are. */
bool interface_is_there(const char *interface, char *why, size_t why_size);

#endif
