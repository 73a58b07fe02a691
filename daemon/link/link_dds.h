/* link_dds: Cyclone DDS, "dds://DOMAIN". One participant; the topics, their quality of service and the configuration
 * are those of wire/dds/wire_dds_qos.h. Clients are lost by DDS liveliness; a stream's readers are seen as they match.
 */
#ifndef COLLIDED_LINK_DDS_H
#define COLLIDED_LINK_DDS_H

#include "link.h"

extern const link_ops link_dds_ops;

#endif
