/* answer_checks: questions about configurations and motions of a robot. */
#ifndef COLLIDED_SERVICE_ANSWER_CHECKS_H
#define COLLIDED_SERVICE_ANSWER_CHECKS_H

#include "service.h"
#include "world/checks.h"

typedef struct check_answer_record { /* freed by the caller: record and names */
    bytes_out record;                /* WIRE_EXTENSION_CHECKED, with its head */
    const char **names;              /* those that its items point to; the world's own */
    uint32_t name_count;
    bool cut; /* there was no time for all of them */
} check_answer_record;

/* Within the patience, which is asked between items. False, and why in `text`, if it is refused. `text` may also say
 * what made the answers undecided. Tick thread. */
bool answer_checks(service *s, const wire_query *q, const world_check_patience *patience, check_answer_record *out,
    char *text, size_t text_size);

#endif
