/* wire_dds_leave: a thread that deletes, and one that waits for it, but not for ever. The thread that deletes has
 * nothing but the domain's number, so that it can be left behind. */
#include "wire_dds_leave.h"

#include <dds/dds.h>
#include <pthread.h>
#include <time.h>

static void *delete_domain(void *context)
{
    (void)dds_delete((dds_entity_t)(intptr_t)context);
    return NULL;
}

bool wire_dds_leave(int32_t domain)
{
    pthread_t deleting;
    struct timespec until;
    if (domain <= 0) return true;
    if (pthread_create(&deleting, NULL, delete_domain, (void *)(intptr_t)domain) != 0) return false;
    (void)clock_gettime(CLOCK_REALTIME, &until); /* joining by the monotonic clock is unknown to thread sanitizers */
    until.tv_sec += WIRE_DDS_LEAVE_S;
    if (pthread_timedjoin_np(deleting, NULL, &until) == 0) return true;
    (void)pthread_detach(deleting);
    return false;
}
