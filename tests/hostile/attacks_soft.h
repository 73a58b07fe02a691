/* attacks_soft: the attacks with soft bodies of attacks.c's table, and what both files need. */
#ifndef COLLIDED_TESTS_HOSTILE_ATTACKS_SOFT_H
#define COLLIDED_TESTS_HOSTILE_ATTACKS_SOFT_H

#include <stdbool.h>

struct collided *attack_enter(const char *uri, const char *name); /* or this process ends */
void attack_wait(struct collided *c, bool full); /* until all is applied or refused, or a time is over */

void attack_soft_crumpled(const char *uri, bool full);
void attack_soft_crowd(const char *uri, bool full);
void attack_soft_large(const char *uri, bool full);

#endif
