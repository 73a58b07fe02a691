/* gateway_process: starts collided-lcm and sees it end. One thread: the one that started it must live as long as it
 * (the kernel kills the gateway when that thread is gone). */
#ifndef COLLIDED_LINK_GATEWAY_PROCESS_H
#define COLLIDED_LINK_GATEWAY_PROCESS_H

#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

enum { GATEWAY_PATH_MAX = 4096 };

/* The program's path: `program`, or collided-lcm beside this executable. False with the reason if it is not there. */
bool gateway_program(const char *program, char path[GATEWAY_PATH_MAX], char *why, size_t why_size);

/* Starts it with one end of a socket pair on PIPE_FD and no other descriptor than the standard ones. The other end, or
 * -1 with errno. *errors: where its standard error comes out; reading it never waits. */
int gateway_start(const char *path, const char *url, const char *interface, pid_t *pid, int *errors);

/* Waits `patience_ms` for its end, then kills it. Its wait status, with one line for people in `how`. */
int gateway_end(pid_t pid, int patience_ms, char *how, size_t how_size);

#endif
