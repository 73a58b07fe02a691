/* signals: blocked in every thread, and waited for by one. The first SIGTERM or SIGINT asks for an orderly end, a
 * second one ends the process at once. SIGUSR1 ends the recording: who may send it is an operator of this machine. */
#ifndef COLLIDED_SERVICE_SIGNALS_H
#define COLLIDED_SERVICE_SIGNALS_H

/* Before any other thread is started. */
void signals_block(void);
/* Both are called with `context` in the waiting thread. */
void signals_watch(void (*stop)(void *context), void (*end_recording)(void *context), void *context);

#endif
