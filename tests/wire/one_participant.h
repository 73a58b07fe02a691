/* one_participant: a test's only participant, on loopback and without multicast, so that nothing leaves the process. */
#ifndef COLLIDED_TESTS_WIRE_ONE_PARTICIPANT_H
#define COLLIDED_TESTS_WIRE_ONE_PARTICIPANT_H

#include "wire_dds/wire_dds_qos.h"

#include <dds/dds.h>

/* Not above 0 if there can be none. Tests that run at the same time have different domains. */
static inline dds_entity_t one_participant(dds_domainid_t domain)
{
    char config[4096];
    if (!wire_dds_config(config, sizeof config, "", WIRE_DDS_ANYBODY)) return -1;
    if (dds_create_domain(domain, config) < 0) return -1;
    return dds_create_participant(domain, NULL, NULL);
}

#endif
