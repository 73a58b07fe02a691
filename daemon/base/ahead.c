/* ahead: the thread that touches memory before the tick needs it, and how much of the heap that is. */
#include "ahead.h"

#include "array.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <unistd.h>

#ifndef MADV_POPULATE_WRITE
#define MADV_POPULATE_WRITE 23 /* the C library knows it since glibc 2.35 */
#endif

enum {
    RANGES = 64,     /* that wait; what comes beyond is not touched ahead */
    STEP = 64 << 10, /* bytes in one go: who maps memory meanwhile waits for no more than these, or a wide page */
};

typedef struct range {
    uintptr_t at, end;
} range;

static struct {
    pthread_mutex_t lock;
    pthread_cond_t some;
    pthread_t thread;
    range ranges[RANGES]; /* a ring */
    size_t first, count;
    bool runs, stop, held;
} ahead = {.lock = PTHREAD_MUTEX_INITIALIZER, .some = PTHREAD_COND_INITIALIZER};

/* ---- the thread ---- */

/* A part of the oldest range; false: it is time to end. */
static bool take_step(range *part)
{
    pthread_mutex_lock(&ahead.lock);
    while (!ahead.count && !ahead.stop) pthread_cond_wait(&ahead.some, &ahead.lock);
    bool goes_on = !ahead.stop;
    if (goes_on) {
        range *r = &ahead.ranges[ahead.first];
        uintptr_t end = (r->at / STEP + 1) * STEP;
        *part = (range){r->at, end < r->end ? end : r->end};
        r->at = part->end;
        if (r->at == r->end) {
            ahead.first = (ahead.first + 1) % RANGES;
            ahead.count--;
        }
    }
    pthread_mutex_unlock(&ahead.lock);
    return goes_on;
}

/* What has been unmapped meanwhile is an error that means nothing; what is there already costs next to nothing. */
static void *touch(void *context)
{
    const struct sched_param none = {.sched_priority = 0};
    range part;
    pthread_setschedparam(pthread_self(), SCHED_OTHER, &none); /* it holds up nobody who has a priority */
    while (take_step(&part)) (void)madvise((void *)part.at, part.end - part.at, MADV_POPULATE_WRITE);
    return context;
}

bool ahead_start(void)
{
    sigset_t all, before;
    if (ahead.runs) return false;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before);
    ahead.stop = ahead.held = false;
    ahead.runs = pthread_create(&ahead.thread, NULL, touch, NULL) == 0;
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    if (ahead.runs) pthread_setname_np(ahead.thread, "ahead");
    return ahead.runs;
}

void ahead_stop(void)
{
    if (!ahead.runs) return;
    pthread_mutex_lock(&ahead.lock);
    ahead.stop = true;
    ahead.count = 0;
    pthread_cond_signal(&ahead.some);
    pthread_mutex_unlock(&ahead.lock);
    pthread_join(ahead.thread, NULL);
    ahead.runs = false;
}

void ahead_allow(bool spare)
{
    ahead.held = !spare;
}

void ahead_touch(void *at, size_t bytes)
{
    uintptr_t page = (uintptr_t)sysconf(_SC_PAGESIZE), from = (uintptr_t)at / page * page;
    uintptr_t end = ((uintptr_t)at + bytes + page - 1) / page * page;
    if (!ahead.runs || ahead.held || from == end) return;
    pthread_mutex_lock(&ahead.lock);
    if (ahead.count < RANGES) ahead.ranges[(ahead.first + ahead.count++) % RANGES] = (range){from, end};
    pthread_cond_signal(&ahead.some);
    pthread_mutex_unlock(&ahead.lock);
}

/* ---- the heap ----
 *
 * Where its next memory is, the heap itself says: it is asked for some, which goes back at once. Chunks are smaller
 * than what it maps one by one (start.c). It grows at its end; what lies before has been touched. */

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__) /* their heaps hand out nothing twice */
void ahead_heap(void) {}
#else

enum { CHUNK_LEAST = 512 << 10, CHUNKS = 8, LOOK_EACH = 64 << 10 /* bytes that were handed out */ };
static const size_t LEAD_MOST = 24 << 20;

static struct {
    size_t lead;       /* bytes */
    size_t looked;     /* after so many had been handed out */
    uintptr_t used;    /* up to where it has been handed out */
    uintptr_t touched; /* up to where it has been touched, if that is more */
} heap;

/* Twice what a round took, for a good while: it shrinks by a thousandth a round. */
static size_t lead_after(size_t took)
{
    size_t lead = heap.lead - heap.lead / 1024, want = 2 * took;
    if (want > lead) lead = want;
    return lead < LEAD_MOST ? lead : LEAD_MOST;
}

/* Where `count` chunks lie that it would hand out now, most often in one piece. */
static range next_chunks(size_t count, size_t size)
{
    range all = {UINTPTR_MAX, 0};
    void *chunks[CHUNKS];
    for (size_t i = 0; i < count; i++) {
        chunks[i] = malloc(size);
        uintptr_t at = (uintptr_t)chunks[i];
        if (at && at < all.at) all.at = at;
        if (at && at + size > all.end) all.end = at + size;
    }
    for (size_t i = count; i-- > 0;) free(chunks[i]);
    return all;
}

void ahead_heap(void)
{
    if (!ahead.runs || ahead.held || base_handed_out() - heap.looked < LOOK_EACH) return;
    heap.looked = base_handed_out();
    size_t size = heap.lead / (CHUNKS - 1) > CHUNK_LEAST ? heap.lead / (CHUNKS - 1) : CHUNK_LEAST;
    size_t count = heap.lead / size + 1;
    range next = next_chunks(count, size);
    uintptr_t end_of_heap = (uintptr_t)sbrk(0);
    if (next.end <= next.at || next.end > end_of_heap) return;
    if (heap.touched > end_of_heap) heap.touched = heap.used = end_of_heap; /* the rest went back to the system */
    uintptr_t used = next.end - count * size;
    size_t took = heap.used && used > heap.used ? used - heap.used : 0;
    if (used > heap.used) heap.used = used;
    heap.lead = lead_after(took);
    uintptr_t from = heap.touched > used ? heap.touched : used;
    if (next.end <= from) return;
    ahead_touch((void *)from, next.end - from);
    heap.touched = next.end;
}
#endif
