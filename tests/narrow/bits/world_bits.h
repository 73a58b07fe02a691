/* world_bits: the hash of all that a world tells about bodies of every convex type that jump about, with contacts,
 * manifolds, impacts and predictions. All numbers come from cases.h: no function of the C library is in them. Of the
 * ticks only one in `part`. */
#ifndef BITS_WORLD_BITS_H
#define BITS_WORLD_BITS_H

#include <stdint.h>

uint64_t world_bits(unsigned workers, int part);

#endif
