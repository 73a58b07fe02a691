/* loop: one descriptor that is readable when collided_poll has something to do. It is an epoll descriptor over what the
 * caller's thread sleeps on, and a timer for what has to be asked for again if it does not come. */
#include "loop.h"

#include <errno.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/timerfd.h>
#include <unistd.h>

void loop_begin(collided *c)
{
    c->loop = c->loop_timer = -1;
}

void loop_end(collided *c)
{
    if (c->loop >= 0) (void)close(c->loop);
    if (c->loop_timer >= 0) (void)close(c->loop_timer);
    loop_begin(c);
}

static bool watch(collided *c, int fd)
{
    struct epoll_event event = {.events = EPOLLIN};
    return fd >= 0 && epoll_ctl(c->loop, EPOLL_CTL_ADD, fd, &event) == 0;
}

int collided_fd(collided *c)
{
    if (c->loop >= 0) return c->loop;
    c->loop = epoll_create1(EPOLL_CLOEXEC);
    c->loop_timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
    bool made = c->loop >= 0 && watch(c, c->link->ops->fd(c->link, TRANSPORT_STREAMS)) && watch(c, c->caller_wake) &&
                watch(c, c->loop_timer);
    if (!made) {
        (void)session_fail(c, COLLIDED_TRANSPORT, "no descriptor for event loops: %s", strerror(errno));
        loop_end(c);
        return -1;
    }
    loop_set_timer(c);
    return c->loop;
}

void loop_take_wakes(collided *c)
{
    uint64_t count;
    if (c->loop < 0) return;
    ssize_t size = read(c->caller_wake, &count, sizeof count);
    (void)size; /* mostly nothing has */
}

/* A daemon that falls silent is told by collided_poll as well: so it has to be called then, and once a second while
 * none is heard. */
static int64_t silence_ns(collided *c)
{
    pthread_mutex_lock(&c->lock);
    int64_t until = c->last_seen_ns + SESSION_SILENCE_NS, soonest = session_monotonic_ns() + NS_PER_S;
    pthread_mutex_unlock(&c->lock);
    return until > soonest ? until : soonest;
}

void loop_set_timer(collided *c)
{
    if (c->loop < 0) return;
    int64_t due = stream_next_ns(c), silence = silence_ns(c);
    if (silence < due) due = silence;
    if (due < 1) due = 1; /* 0 would be: never */
    struct itimerspec when = {.it_value = {.tv_sec = due / NS_PER_S, .tv_nsec = due % NS_PER_S}};
    (void)timerfd_settime(c->loop_timer, TFD_TIMER_ABSTIME, &when, NULL); /* which also forgets that it has expired */
}
