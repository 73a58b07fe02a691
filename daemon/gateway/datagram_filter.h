/* datagram_filter: which datagrams liblcm gets to see. Called while the process starts; one thread. */
#ifndef COLLIDED_GATEWAY_DATAGRAM_FILTER_H
#define COLLIDED_GATEWAY_DATAGRAM_FILTER_H

#include <stdbool.h>
#include <stdint.h>

/* From now on the kernel drops what is no datagram of LCM before this socket gets it, and counts it
 * (datagram_drops). False, with errno: the kernel does not take the filter. */
bool datagram_filter_attach(int fd);

/* Datagrams that came for this socket and that it never got, since it was opened: no datagrams of LCM, or more than its
 * buffer holds. Wraps around; 0 where the kernel does not tell. */
uint32_t datagram_drops(int fd);

#endif
