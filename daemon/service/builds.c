/* builds: the threads that build, and their queue. What holds always: a build belongs to the queue until it is ended or
 * abandoned; it holds a reference to all that it reads, so that nothing the tick thread does takes it away; the queue
 * belongs to the tick thread and its threads together, and is freed by the last of them. */
#include "builds.h"

#include "base/log.h"

#include <errno.h>
#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

enum { NICE = 5 };
static const uint64_t SHORT_UNITS = 20000; /* 0.2 s, or a few seconds of the worst */

typedef enum build_state { BUILD_WAITS, BUILD_UNDER_WAY, BUILD_READY } build_state;

struct build {
    build_state state;
    bool abandoned, awaited; /* somebody waits for it: it comes first, and builds_take does not give it */
    int64_t client, id;
    char *client_name;
    build_cost cost;
    geometry_numbers *numbers;
    older_geometry *older;
    size_t older_count;
    built result;
};

typedef struct garbage {
    geometry_numbers *numbers;
    hull *hull;
    mesh *mesh;
    soft_mesh *soft;
} garbage;

struct builds {
    pthread_mutex_t lock; /* guards all below but what is atomic */
    pthread_cond_t work, ready;
    ARRAY(build *)
    all; /* in the order of their coming, but for those that are ready: in the order in which they were */
    ARRAY(garbage) garbage;
    _Atomic size_t ready_count; /* that builds_take may give */
    int64_t last_client;        /* whose build was begun last */
    size_t owners;              /* threads that still look at this, the tick thread among them */
    bool stop, threaded;
    size_t thread_count;
    pthread_t threads[BUILD_THREADS];
    int wake_fd;
    build_watch watch;
    void (*before)(void *context, int64_t id);
    void *before_context;
};

static void free_build(build *of)
{
    geometry_numbers_release(of->numbers);
    for (size_t i = 0; i < of->older_count; i++) geometry_numbers_release(of->older[i].numbers);
    free(of->older);
    free(of->client_name);
    hull_destroy(of->result.hull);
    mesh_destroy(of->result.mesh);
    soft_mesh_destroy(of->result.soft);
    free(of);
}

static void forget_build(builds *b, const build *of)
{
    size_t kept = 0;
    for (size_t i = 0; i < b->all.count; i++)
        if (b->all.at[i] != of) b->all.at[kept++] = b->all.at[i];
    b->all.count = kept;
}

/* ---- one build ---- */

static void carry_out_build(build *of)
{
    for (size_t i = 0; i < of->older_count; i++) {
        if (!geometry_numbers_equal(of->older[i].numbers, of->numbers)) continue;
        of->result = (built){.same = of->older[i].id};
        return;
    }
    build_now(of->numbers, &of->result);
}

/* The next one of the client that comes behind the last one, by their ids; of one client the first that came. What is
 * awaited comes before all. */
static build *choose(const builds *b, bool short_only)
{
    build *next = NULL, *first = NULL;
    for (size_t i = 0; i < b->all.count; i++) {
        build *of = b->all.at[i];
        if (of->state != BUILD_WAITS || (short_only && of->cost.units > SHORT_UNITS)) continue;
        if (of->awaited) return of;
        if (of->client > b->last_client && (!next || of->client < next->client)) next = of;
        if (!first || of->client < first->client) first = of;
    }
    return next ? next : first;
}

static void wake_tick_thread(const builds *b)
{
    const uint64_t one = 1;
    if (write(b->wake_fd, &one, sizeof one) < 0 && errno != EAGAIN) log_error("wake-up: %s", strerror(errno));
}

static void make_ready(builds *b, build *of)
{
    forget_build(b, of);
    array_push(&b->all, of);
    of->state = BUILD_READY;
    if (of->awaited) return;
    b->ready_count++;
    wake_tick_thread(b);
}

static void report_begin(builds *b, const build *of, unsigned thread)
{
    const build_watch *w = &b->watch;
    if (thread < BUILD_THREADS && w->begins) w->begins(w->context, thread, of->client, of->client_name, of->numbers);
}

static void report_end_of_build(builds *b, unsigned thread)
{
    if (thread < BUILD_THREADS && b->watch.ends && !b->stop) b->watch.ends(b->watch.context, thread);
}

/* With the lock, which is given up meanwhile. `thread`: which of them; BUILD_THREADS: the tick thread. */
static void work_on(builds *b, build *of, unsigned thread)
{
    void (*before)(void *, int64_t) = b->before;
    void *context = b->before_context;
    of->state = BUILD_UNDER_WAY;
    b->last_client = of->client;
    report_begin(b, of, thread);
    pthread_mutex_unlock(&b->lock);
    if (before) before(context, of->id);
    carry_out_build(of);
    pthread_mutex_lock(&b->lock);
    report_end_of_build(b, thread);
    if (of->abandoned || b->stop) {
        forget_build(b, of);
        pthread_mutex_unlock(&b->lock);
        free_build(of);
        pthread_mutex_lock(&b->lock);
    } else {
        make_ready(b, of);
    }
    pthread_cond_broadcast(&b->ready);
}

static void burn(const garbage *g)
{
    geometry_numbers_release(g->numbers);
    hull_destroy(g->hull);
    mesh_destroy(g->mesh);
    soft_mesh_destroy(g->soft);
}

static void burn_one(builds *b)
{
    garbage g = b->garbage.at[--b->garbage.count];
    pthread_mutex_unlock(&b->lock);
    burn(&g);
    pthread_mutex_lock(&b->lock);
}

/* ---- the threads ---- */

/* With the lock, which is given up. The last owner frees what is left. */
static void leave_builds(builds *b)
{
    bool last = --b->owners == 0;
    pthread_mutex_unlock(&b->lock);
    if (!last) return;
    for (size_t i = 0; i < b->all.count; i++) free_build(b->all.at[i]);
    for (size_t i = 0; i < b->garbage.count; i++) burn(&b->garbage.at[i]);
    array_free(&b->all);
    array_free(&b->garbage);
    pthread_mutex_destroy(&b->lock);
    pthread_cond_destroy(&b->work);
    pthread_cond_destroy(&b->ready);
    free(b);
}

static void run(builds *b, unsigned thread)
{
    bool short_only = thread == 1;
    setpriority(PRIO_PROCESS, (id_t)syscall(SYS_gettid), NICE);
    pthread_mutex_lock(&b->lock);
    while (!b->stop) {
        build *of = choose(b, short_only);
        if (b->garbage.count)
            burn_one(b);
        else if (of)
            work_on(b, of, thread);
        else
            pthread_cond_wait(&b->work, &b->lock);
    }
    leave_builds(b);
}

static void *run_all(void *context)
{
    run(context, 0);
    return NULL;
}

static void *run_short(void *context)
{
    run(context, 1);
    return NULL;
}

/* When there is something to do for the first time. Of ordinary policy, whatever the tick thread has. With the lock. */
static void start_threads(builds *b)
{
    pthread_attr_t how;
    if (!b->threaded || b->thread_count) return;
    pthread_attr_init(&how);
    pthread_attr_setinheritsched(&how, PTHREAD_EXPLICIT_SCHED);
    pthread_attr_setschedpolicy(&how, SCHED_OTHER);
    while (b->thread_count < BUILD_THREADS &&
           pthread_create(&b->threads[b->thread_count], &how, b->thread_count ? run_short : run_all, b) == 0) {
        b->thread_count++;
        b->owners++;
    }
    pthread_attr_destroy(&how);
    if (!b->thread_count) log_error("no thread to build geometry by: it is built in the tick");
}

builds *builds_create(int wake_fd, bool threads)
{
    builds *b = base_zalloc(1, sizeof *b);
    pthread_condattr_t clock;
    pthread_condattr_init(&clock);
    pthread_condattr_setclock(&clock, CLOCK_MONOTONIC);
    pthread_mutex_init(&b->lock, NULL);
    pthread_cond_init(&b->work, NULL);
    pthread_cond_init(&b->ready, &clock);
    pthread_condattr_destroy(&clock);
    b->wake_fd = wake_fd;
    b->threaded = threads;
    b->owners = 1;
    return b;
}

void builds_destroy(builds *b)
{
    struct timespec until;
    pthread_t threads[BUILD_THREADS];
    if (!b) return;
    pthread_mutex_lock(&b->lock);
    b->stop = true;
    pthread_cond_broadcast(&b->work);
    size_t count = b->thread_count;
    memcpy(threads, b->threads, sizeof threads);
    leave_builds(b);
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec++;
    for (size_t i = 0; i < count; i++)
        if (pthread_timedjoin_np(threads[i], NULL, &until) != 0) pthread_detach(threads[i]);
}

/* ---- what the tick thread asks ---- */

void builds_report(builds *b, const build_watch *watch)
{
    pthread_mutex_lock(&b->lock);
    b->watch = *watch;
    pthread_mutex_unlock(&b->lock);
}

build *builds_add(builds *b, int64_t client, const char *client_name, int64_t id, geometry_numbers *n,
    older_geometry *older, size_t count)
{
    build *of = base_zalloc(1, sizeof *of);
    of->client = client;
    of->client_name = base_strdup(client_name);
    of->id = id;
    of->cost = build_cost_of(n->kind, n->vertex_numbers, n->index_numbers);
    of->numbers = geometry_numbers_keep(n);
    of->older = older;
    of->older_count = count;
    for (size_t i = 0; i < count; i++) geometry_numbers_keep(older[i].numbers);
    pthread_mutex_lock(&b->lock);
    array_push(&b->all, of);
    start_threads(b);
    if (b->threaded && !b->thread_count) work_on(b, of, BUILD_THREADS);
    pthread_cond_broadcast(&b->work);
    pthread_mutex_unlock(&b->lock);
    return of;
}

void builds_abandon(builds *b, build *of)
{
    if (!of) return;
    pthread_mutex_lock(&b->lock);
    of->abandoned = of->state == BUILD_UNDER_WAY;
    bool ours = !of->abandoned;
    if (ours) forget_build(b, of);
    if (of->state == BUILD_READY && !of->awaited) b->ready_count--;
    pthread_mutex_unlock(&b->lock);
    if (!ours) return;
    builds_free(b, NULL, of->result.hull, of->result.mesh, of->result.soft);
    of->result = (built){.same = 0};
    free_build(of);
}

bool builds_ready(const builds *b)
{
    return b && b->ready_count > 0;
}

build *builds_take(builds *b)
{
    build *of = NULL;
    pthread_mutex_lock(&b->lock);
    for (size_t i = 0; i < b->all.count && !of; i++)
        if (b->all.at[i]->state == BUILD_READY && !b->all.at[i]->awaited) of = b->all.at[i];
    if (of) {
        of->awaited = true;
        b->ready_count--;
    }
    pthread_mutex_unlock(&b->lock);
    return of;
}

int64_t build_of(const build *of)
{
    return of->id;
}

static struct timespec in_a_tenth(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    t.tv_nsec += 100000000;
    if (t.tv_nsec >= 1000000000) t.tv_sec++, t.tv_nsec -= 1000000000;
    return t;
}

void builds_wait(builds *b, build *of, void (*alive)(void *context), void *context)
{
    pthread_mutex_lock(&b->lock);
    if (of->state == BUILD_READY && !of->awaited) b->ready_count--;
    of->awaited = true;
    if (!b->thread_count && of->state == BUILD_WAITS) work_on(b, of, BUILD_THREADS);
    while (of->state != BUILD_READY) {
        const struct timespec until = in_a_tenth();
        pthread_cond_broadcast(&b->work);
        pthread_cond_timedwait(&b->ready, &b->lock, &until);
        pthread_mutex_unlock(&b->lock);
        if (alive) alive(context);
        pthread_mutex_lock(&b->lock);
    }
    pthread_mutex_unlock(&b->lock);
}

void builds_end(builds *b, build *of, built *out)
{
    pthread_mutex_lock(&b->lock);
    forget_build(b, of);
    pthread_mutex_unlock(&b->lock);
    *out = of->result;
    of->result = (built){.same = 0};
    free_build(of);
}

static bool is_small(const geometry_numbers *n, const hull *h, const mesh *m, const soft_mesh *f)
{
    enum { SMALL = 4096 }; /* numbers, corners or triangles: freed in less than 0.1 ms */
    return (!n || n->vertex_numbers + n->index_numbers <= SMALL) && (!h || h->vertex_count <= SMALL) &&
           (!m || m->triangle_count <= SMALL) && (!f || soft_mesh_triangle_count(f) <= SMALL);
}

void builds_free(builds *b, geometry_numbers *n, hull *h, mesh *m, soft_mesh *f)
{
    garbage g = {n, h, m, f};
    if (!b->threaded || is_small(n, h, m, f)) {
        burn(&g);
        return;
    }
    pthread_mutex_lock(&b->lock);
    array_push(&b->garbage, g);
    start_threads(b);
    pthread_cond_broadcast(&b->work);
    pthread_mutex_unlock(&b->lock);
}

builds_figures builds_get_figures(builds *b)
{
    builds_figures f = {0};
    pthread_mutex_lock(&b->lock);
    for (size_t i = 0; i < b->all.count; i++) {
        const build *of = b->all.at[i];
        if (of->state == BUILD_READY) continue;
        f.waiting += of->state == BUILD_WAITS;
        f.under_way += of->state == BUILD_UNDER_WAY;
        f.units += of->cost.units;
        f.bytes += of->cost.bytes;
    }
    pthread_mutex_unlock(&b->lock);
    return f;
}

void builds_hold(builds *b, void (*before)(void *context, int64_t id), void *context)
{
    pthread_mutex_lock(&b->lock);
    b->before = before;
    b->before_context = context;
    pthread_mutex_unlock(&b->lock);
}
