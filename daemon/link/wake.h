/* wake: one write to the tick thread's eventfd. Any thread; never blocks in practice (an eventfd's counter does not
 * fill). */
#ifndef COLLIDED_LINK_WAKE_H
#define COLLIDED_LINK_WAKE_H

#include <stdint.h>
#include <unistd.h>

static inline void wake(int fd)
{
    const uint64_t one = 1;
    ssize_t n = write(fd, &one, sizeof one);
    (void)n; /* EAGAIN: the counter is full, so the thread is as awake as it gets */
}

#endif
