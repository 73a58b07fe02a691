/* raw_lcm: what LCM alone takes for the same payload: as many bytes as a PoseBatch out and as an EventBatch with one
 * event back, neither encoded nor decoded. Two processes, liblcm in both, with the client library's buffer. */
#ifndef COLLIDED_TESTS_BENCH_RAW_LCM_H
#define COLLIDED_TESTS_BENCH_RAW_LCM_H

#include <stdint.h>

/* The other process: answers until it is ended. Non-zero if LCM fails. Multicast: only in a network of its own. */
int raw_lcm_echo(void);

typedef struct raw_lcm raw_lcm;
raw_lcm *raw_lcm_open(uint32_t poses); /* NULL, told on stderr, if no echo is there within ten seconds */
int64_t raw_lcm_round_ns(raw_lcm *r, int64_t timeout_ns); /* -1 = no answer in time */
void raw_lcm_close(raw_lcm *r);

#endif
