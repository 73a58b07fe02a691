/* signals: one thread in sigwait. */
#include "signals.h"

#include "base/log.h"

#include <pthread.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>
#include <unistd.h>

static struct {
    void (*stop)(void *context);
    void (*end_recording)(void *context);
    void *context;
} watcher;

static void awaited_signals(sigset_t *set)
{
    sigemptyset(set);
    sigaddset(set, SIGTERM);
    sigaddset(set, SIGINT);
    sigaddset(set, SIGUSR1); /* ends the recording alone */
}

static int next_ending(const sigset_t *set)
{
    int number = 0;
    while (sigwait(set, &number) == 0 && number == SIGUSR1) watcher.end_recording(watcher.context);
    return number;
}

void signals_block(void)
{
    sigset_t set;
    awaited_signals(&set);
    sigaddset(&set, SIGPIPE); /* a closed pipe is an error of write, not the end */
    sigaddset(&set, SIGXFSZ); /* and so is a recording that may not grow (ulimit -f) */
    sigaddset(&set, SIGHUP);
    pthread_sigmask(SIG_BLOCK, &set, NULL);
}

static void *wait_for_signals(void *unused)
{
    (void)unused;
    sigset_t set;
    awaited_signals(&set);
    int number = next_ending(&set);
    log_notice("signal %d: ending in order; a second one ends at once", number);
    watcher.stop(watcher.context);
    _exit(128 + next_ending(&set));
}

void signals_watch(void (*stop)(void *context), void (*end_recording)(void *context), void *context)
{
    pthread_t thread;
    watcher.stop = stop;
    watcher.end_recording = end_recording;
    watcher.context = context;
    if (pthread_create(&thread, NULL, wait_for_signals, NULL) != 0) {
        log_error("no thread for signals: out of resources");
        exit(71); /* EX_OSERR */
    }
    pthread_detach(thread);
}
