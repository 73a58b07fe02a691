/* ahead: memory that will be needed next is touched beside the tick. The kernel clears a page when it is touched for
 * the first time, and on a virtual machine the host may have to find it first: 10 to 20 us a page of 4 KiB, up to 8 ms
 * one of 2 MiB. A tick that takes up 10 MB would spend 50 ms on that alone. So a thread touches what comes next: of the
 * heap as much as twice what a round has lately taken, of an array that grows in place (array.h) a share of its size.
 *
 * Nothing hangs on it but time: memory that this has not touched is touched by whoever needs it. Without ahead_start
 * (replays, tests) nothing is done. Where MADV_POPULATE_WRITE is unknown (Linux before 5.14), neither. */
#ifndef COLLIDED_BASE_AHEAD_H
#define COLLIDED_BASE_AHEAD_H

#include <stdbool.h>
#include <stddef.h>

/* Starts and ends the thread; once a process, from the thread whose heap it is. False: there is no such thread, or it
 * runs already, for another server of this process. */
bool ahead_start(void);
void ahead_stop(void);

/* Is there memory to spare? At first there is. The thread that began. */
void ahead_allow(bool spare);

/* Will be needed soon: mapped, or, if it is not, passed over. What is in there stays. Any thread; never waits. */
void ahead_touch(void *at, size_t bytes);

/* After a round: the heap's next memory, if the round took some. The thread that began. */
void ahead_heap(void);

#endif
