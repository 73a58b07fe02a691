/* manager: a stand-in for the service manager, as the unit in daemon/systemd has it: it starts a daemon, hears what it
 * tells (NOTIFY_SOCKET), sends SIGABRT to one that gave no sign of life in time (WATCHDOG_USEC), starts it again after
 * a pause when it failed, and keeps its RUNTIME_DIRECTORY over these restarts. A thread for each daemon; all functions
 * are for the test's thread. In a network namespace only what is started after rig_isolate is in it. */
#ifndef COLLIDED_TESTS_FAULTS_MANAGER_H
#define COLLIDED_TESTS_FAULTS_MANAGER_H

#include <stdbool.h>
#include <sys/types.h>

typedef struct manager manager;

/* Starts COLLIDED with these arguments (without its own name; ended by NULL) and watches over it from then on. With
 * watchdog_s = 0 it need give no sign of life. It dumps no core. */
manager *manager_start(const char *const *arguments, double watchdog_s);
/* The same of another program, and with a pause before each restart in place of MANAGER_PAUSE_S. */
manager *manager_start_program(const char *program, const char *const *arguments, double watchdog_s, double pause_s);
#define MANAGER_PAUSE_S 0.2

pid_t manager_pid(manager *m);                   /* of the daemon that runs; 0: none does at this moment */
unsigned manager_restarts(manager *m);           /* starts after the first one */
unsigned manager_killed(manager *m);             /* by the watchdog */
bool manager_is_ready(manager *m);               /* the daemon that runs has said READY=1 */
bool manager_has_ended(manager *m);              /* in order, or with an exit status that a restart does not mend */
double manager_longest_silence_s(manager *m);    /* between two signs of life of a daemon that was ready */
const char *manager_folder(manager *m);          /* of the daemon: its RUNTIME_DIRECTORY, and what it wrote as "log" */
bool manager_said(manager *m, const char *text); /* is it in the log, of all that were started? */
void manager_show(manager *m);                   /* the log, to standard output */

/* Waits for a daemon that is ready after so many restarts at least; fails the test if none is within that time. */
void manager_await(manager *m, unsigned restarts, double seconds);

/* Ends the daemon in order (with SIGKILL if it does not within 10 s) and removes the folder. Its exit status, or 128 +
 * the signal that ended it. */
int manager_stop(manager *m);
/* For the teardown of a test: all that still run, with SIGKILL, and then rig_end_all. */
int manager_end_all(void **state);

#endif
