/* health: the parts that a Status is made of. Tick thread. */
#ifndef COLLIDED_SERVICE_HEALTH_H
#define COLLIDED_SERVICE_HEALTH_H

#include "service.h"
#include "sheet.h"

/* health_clients.c. The work of each client since the last Status stands in session.work, and is told and cleared. */
void health_add_clients(service *s, sheet *t);
void health_add_lost(const service *s, sheet *t);

#endif
