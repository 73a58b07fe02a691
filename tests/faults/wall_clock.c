/* wall_clock: loaded before the C library's (LD_PRELOAD), it sets the wall clock of a process, and no other clock, by
 * the nanoseconds that stand in the file COLLIDED_WALL_CLOCK. Whoever writes there sets the clock of all that read it.
 */
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

int clock_gettime(clockid_t clock, struct timespec *t);
int pthread_cond_timedwait(pthread_cond_t *c, pthread_mutex_t *m, const struct timespec *until);

typedef int real_clock(clockid_t clock, struct timespec *t);
static real_clock *_Atomic real;
static const _Atomic int64_t *_Atomic offset_ns;

static void find(void)
{
    static const _Atomic int64_t none;
    const char *path = getenv("COLLIDED_WALL_CLOCK");
    int fd = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    void *map = fd < 0 ? MAP_FAILED : mmap(NULL, sizeof(int64_t), PROT_READ, MAP_SHARED, fd, 0);
    atomic_store(&offset_ns, map == MAP_FAILED ? &none : (const _Atomic int64_t *)map);
    atomic_store(&real, (real_clock *)dlsym(RTLD_NEXT, "clock_gettime"));
}

static struct timespec later(const struct timespec *t, int64_t by_ns)
{
    int64_t ns = (int64_t)t->tv_sec * 1000000000 + t->tv_nsec + by_ns;
    if (t->tv_sec > INT64_MAX / 2000000000 || ns < 0) return *t; /* for ever, or at once */
    return (struct timespec){ns / 1000000000, ns % 1000000000};
}

int clock_gettime(clockid_t clock, struct timespec *t)
{
    if (!atomic_load(&real)) find();
    int result = atomic_load(&real)(clock, t);
    if (result != 0 || clock != CLOCK_REALTIME) return result;
    *t = later(t, atomic_load(atomic_load(&offset_ns)));
    return 0;
}

int pthread_cond_timedwait(pthread_cond_t *c, pthread_mutex_t *m, const struct timespec *until)
{
    if (!atomic_load(&real)) find();
    struct timespec t = later(until, -atomic_load(atomic_load(&offset_ns)));
    return pthread_cond_clockwait(c, m, CLOCK_REALTIME, &t);
}
