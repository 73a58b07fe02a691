/* suspect: the file has room for what is carried out and built now, and for what daemons have died over. It is believed
 * only as far as its numbers make sense: a damaged file is begun anew. */
#include "suspect.h"

#include "base/array.h"
#include "base/clock.h"
#include "base/hash.h"
#include "base/log.h"
#include "clients.h"
#include "service.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

enum { SUSPECTS_MAX = 32, NAME_KEPT = 96 };
static const uint64_t MAGIC = UINT64_C(0x3274636570737573); /* "suspect2" */
static const int64_t SECOND_NS = 1000000000;
static const int64_t FIRST_NS = 60 * 1000000000LL, MOST_NS = 3600 * 1000000000LL;
static const int64_t FORGIVEN_NS = 86400 * 1000000000LL; /* after so long without another death */

typedef enum doing { DOING_NOTHING, DOING_COMMAND, DOING_TICK } doing;

typedef struct culprit { /* a command; of a tick (kind WIRE_NOTHING) whoever most of it came from */
    int64_t client, sequence;
    uint64_t content; /* a hash of it, but for who sends it and when; 0 of a tick */
    int64_t since_ns; /* monotonic: it was begun, or of one that is kept, a daemon died over it last */
    int64_t until_ns; /* monotonic: it is refused; 0: not yet */
    int32_t object;
    uint32_t times; /* that a daemon died over it; 0: this place is free */
    uint8_t kind;   /* a wire_kind */
    char client_name[NAME_KEPT], name[NAME_KEPT];
} culprit;

typedef struct under_way { /* of a thread that builds */
    _Atomic uint32_t is_on;
    culprit what; /* while it is: a Geometry, its sequence 0 */
} under_way;

typedef struct suspect_file {
    uint64_t magic, size;
    _Atomic uint32_t running;       /* 0: it ended in order */
    _Atomic int32_t end_signal;     /* that ended it; 0: none that can be seen ... */
    _Atomic uint32_t end_in_build;  /* ... in a build of thread so much - 1; 0: in none ... */
    _Atomic uint32_t end_of_memory; /* ... for want of memory */
    _Atomic uint32_t doing;
    culprit now; /* while it does something */
    under_way builds[BUILD_THREADS];
    culprit kept[SUSPECTS_MAX];
} suspect_file;

typedef struct suspect_watch {
    suspect_file *file;
    int fd;
    bool some;                          /* are refused, or were lately */
    int64_t counted, counted_now, most; /* commands of one client in this tick: whose, how many; the most of one ... */
    int64_t busiest;                    /* ... and whose; 0: nobody's */
    bytes_out scratch;                  /* a command, encoded */
} suspect_watch;

/* ---- fatal signals ---- */

static suspect_file *of_process; /* for the handler: there is one daemon in a process that keeps a file */
static const int FATAL[] = {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGSYS};
enum { FATAL_COUNT = sizeof FATAL / sizeof *FATAL };

static _Thread_local uint32_t in_build; /* this thread's number + 1; 0: it builds nothing */

/* SA_RESETHAND: the second time, as soon as this one returns, it ends the process as if there were no handler. */
static void note_signal(int number)
{
    if (of_process) {
        atomic_store(&of_process->end_in_build, in_build);
        atomic_store(&of_process->end_of_memory, base_is_out_of_memory());
        atomic_store(&of_process->end_signal, number);
    }
    raise(number);
}

/* A sanitizer's own handlers stay. */
static void watch_signals(suspect_file *f)
{
    struct sigaction there, note = {.sa_handler = note_signal, .sa_flags = (int)SA_RESETHAND};
    of_process = f;
    for (int i = 0; i < FATAL_COUNT; i++)
        if (sigaction(FATAL[i], NULL, &there) == 0 && !(there.sa_flags & SA_SIGINFO) && there.sa_handler == SIG_DFL)
            sigaction(FATAL[i], &note, NULL);
}

/* ---- what a command is ---- */

static void keep_name(char to[NAME_KEPT], const char *text)
{
    size_t length = text ? strnlen(text, NAME_KEPT - 1) : 0;
    if (length) memcpy(to, text, length);
    to[length] = '\0';
}

static const char *name_of_object(const wire_message *m)
{
    return m->kind == WIRE_BODY           ? m->body.name
           : m->kind == WIRE_SUBSCRIPTION ? m->subscription.select_a
           : m->kind == WIRE_QUERY        ? m->query.name_a
           : m->kind == WIRE_CLIENT       ? m->client.name
                                          : "";
}

static uint64_t content_of_geometry(uint8_t kind, int64_t hash)
{
    return hash_words(HASH_START ^ kind, &hash, sizeof hash);
}

/* Poses change from one announcement to the next. */
static uint64_t content_of(suspect_watch *w, const wire_message *m)
{
    static const double nowhere[7] = {0, 0, 0, 1, 0, 0, 0};
    wire_message bare = *m;
    if (m->kind == WIRE_GEOMETRY) return content_of_geometry(m->geometry.kind, m->geometry.hash);
    if (m->kind == WIRE_BODY) {
        bare.body.client = bare.body.sequence = bare.body.stamp_ns = 0;
        bare.body.stamp_is_now = 0;
        if (bare.body.pose.count == 7) bare.body.pose.at = nowhere;
    } else if (m->kind == WIRE_SUBSCRIPTION) {
        bare.subscription.client = bare.subscription.sequence = 0;
    } else if (m->kind == WIRE_QUERY) {
        bare.query.client = bare.query.sequence = 0;
    } else {
        return 1;
    }
    size_t size = wire_lcm_size(&bare);
    array_reserve(&w->scratch, size);
    return hash_words(HASH_START, w->scratch.at, wire_lcm_encode(&bare, w->scratch.at, size)) | 1;
}

static const char *client_name(service *s, int64_t client)
{
    const session *c = client ? session_find(s, client) : NULL;
    return c ? c->name : "";
}

/* ---- while it runs ---- */

static void count_client(suspect_watch *w, int64_t client)
{
    w->counted_now = client == w->counted ? w->counted_now + 1 : 1;
    w->counted = client;
    if (w->counted_now <= w->most) return;
    w->most = w->counted_now;
    w->busiest = client;
}

static void note_command(service *s, const wire_message *m)
{
    suspect_watch *w = s->suspects;
    culprit *now = &w->file->now;
    wire_origin(m, &now->client, &now->sequence, &now->object);
    now->kind = (uint8_t)m->kind;
    now->content = content_of(w, m);
    now->since_ns = s->monotonic_ns;
    if (m->kind == WIRE_GEOMETRY)
        snprintf(now->name, sizeof now->name, "%016" PRIx64, (uint64_t)m->geometry.hash);
    else
        keep_name(now->name, name_of_object(m));
    keep_name(now->client_name, client_name(s, now->client));
    if (m->kind != WIRE_QUERY) count_client(w, now->client);
    atomic_store_explicit(&w->file->doing, DOING_COMMAND, memory_order_release);
}

void suspect_begin(service *s, const wire_message *m)
{
    if (s->suspects) note_command(s, m);
    if (s->on_command) s->on_command(s->on_command_context, m);
}

void suspect_begin_tick(service *s)
{
    suspect_watch *w = s->suspects;
    if (!w) return;
    culprit *now = &w->file->now;
    now->client = w->busiest;
    now->sequence = now->object = 0;
    now->kind = WIRE_NOTHING;
    now->content = 0;
    now->since_ns = s->monotonic_ns;
    now->name[0] = '\0';
    keep_name(now->client_name, client_name(s, now->client));
    w->counted = w->counted_now = w->most = w->busiest = 0;
    atomic_store_explicit(&w->file->doing, DOING_TICK, memory_order_release);
}

void suspect_end(service *s)
{
    if (s->suspects) atomic_store_explicit(&s->suspects->file->doing, DOING_NOTHING, memory_order_release);
}

static void build_begins(
    void *context, unsigned thread, int64_t client, const char *client_name, const geometry_numbers *n)
{
    under_way *u = &((suspect_file *)context)->builds[thread];
    u->what = (culprit){.client = client,
        .content = content_of_geometry(n->kind, n->hash),
        .since_ns = clock_monotonic_ns(),
        .kind = WIRE_GEOMETRY};
    keep_name(u->what.client_name, client_name);
    snprintf(u->what.name, sizeof u->what.name, "%016" PRIx64, (uint64_t)n->hash);
    atomic_store_explicit(&u->is_on, 1, memory_order_release);
    in_build = thread + 1;
}

static void build_ends(void *context, unsigned thread)
{
    in_build = 0;
    atomic_store_explicit(&((suspect_file *)context)->builds[thread].is_on, 0, memory_order_release);
}

/* ---- what daemons have died over ---- */

static void report_of_culprit(const culprit *c, char *text, size_t size)
{
    if (c->kind == WIRE_NOTHING && !c->client)
        snprintf(text, size, "a tick in which no client had announced anything");
    else if (c->kind == WIRE_NOTHING)
        snprintf(text, size, "a tick, most of whose commands came from client %016" PRIx64 " \"%s\"",
            (uint64_t)c->client, c->client_name);
    else if (c->kind == WIRE_GEOMETRY && !c->sequence)
        snprintf(text, size, "the building of Geometry \"%s\" of client %016" PRIx64 " \"%s\"", c->name,
            (uint64_t)c->client, c->client_name);
    else
        snprintf(text, size, "%s %" PRId64 " (\"%s\") of client %016" PRIx64 " \"%s\"",
            wire_kind_name((wire_kind)c->kind), c->sequence, c->name, (uint64_t)c->client, c->client_name);
}

static bool is_of(const culprit *c, int64_t client, const char *name)
{
    return c->client == client || (*name && strcmp(c->client_name, name) == 0);
}

/* Its place among those that are kept: its own, a free one, or that of who has been quiet for the longest time. */
static culprit *place_for(suspect_file *f, const culprit *c)
{
    culprit *place = &f->kept[0];
    for (int i = 0; i < SUSPECTS_MAX; i++) {
        culprit *k = &f->kept[i];
        if (k->times && k->kind == c->kind && k->content == c->content && is_of(k, c->client, c->client_name)) return k;
        if (place->times && (!k->times || k->since_ns < place->since_ns)) place = k;
    }
    *place = *c;
    place->times = 0;
    place->until_ns = 0;
    return place;
}

static int64_t penalty_ns(uint32_t times)
{
    int64_t ns = FIRST_NS;
    for (uint32_t i = 1; i < times && ns < MOST_NS; i++) ns *= 2;
    return ns < MOST_NS ? ns : MOST_NS;
}

static void hold_against(suspect_file *f, culprit *c, bool sure, const char *how)
{
    char what[512];
    c->client_name[NAME_KEPT - 1] = c->name[NAME_KEPT - 1] = '\0';
    report_of_culprit(c, what, sizeof what);
    culprit *k = place_for(f, c);
    k->client = c->client;
    k->sequence = c->sequence;
    k->object = c->object;
    memcpy(k->client_name, c->client_name, sizeof k->client_name);
    k->since_ns = clock_monotonic_ns();
    if (k->times < UINT32_MAX) k->times++;
    bool is_held = (sure || k->times > 1) && (k->kind != WIRE_NOTHING || k->client);
    k->until_ns = is_held ? k->since_ns + penalty_ns(k->times) : 0;
    const char *refused = k->kind == WIRE_NOTHING ? "bodies and subscriptions of that client are" : "it is";
    if (is_held)
        log_warning("the daemon before this one was killed (%s) while it carried out %s, %u time(s) so far: %s refused "
                    "for %" PRId64 " s",
            how, what, k->times, refused, penalty_ns(k->times) / SECOND_NS);
    else
        log_warning("the daemon before this one was killed (%s) while it carried out %s: that may be chance, and is "
                    "held against nobody unless it happens again",
            how, what);
}

static bool some_is_built(suspect_file *f)
{
    bool some = false;
    for (int i = 0; i < BUILD_THREADS; i++) some |= atomic_load(&f->builds[i].is_on) != 0;
    return some;
}

/* Where it is not known who did it: false if nothing was under way. */
static bool judge_all(suspect_file *f, bool sure, bool with_builds, const char *how)
{
    uint32_t doing = atomic_load(&f->doing);
    bool some = doing == DOING_COMMAND || doing == DOING_TICK;
    if (some) hold_against(f, &f->now, sure && doing == DOING_COMMAND, how);
    for (int i = 0; i < BUILD_THREADS && with_builds; i++) {
        if (!atomic_load(&f->builds[i].is_on)) continue;
        hold_against(f, &f->builds[i].what, false, how);
        some = true;
    }
    return some;
}

static void judge(suspect_file *f)
{
    char how[80];
    int number = atomic_load(&f->end_signal);
    uint32_t in_build_of = atomic_load(&f->end_in_build);
    bool seen = number > 0 && number < NSIG, memory_ended = seen && atomic_load(&f->end_of_memory);
    if (seen)
        snprintf(how, sizeof how, "signal %d, %s%s", number, strsignal(number), memory_ended ? ": out of memory" : "");
    else
        snprintf(how, sizeof how, "by SIGKILL, or with its machine");
    if (seen && in_build_of >= 1 && in_build_of <= BUILD_THREADS)
        hold_against(f, &f->builds[in_build_of - 1].what, true, how);
    else if (!judge_all(f, seen && !(memory_ended && some_is_built(f)), !seen || memory_ended, how))
        log_warning("the daemon before this one was killed (%s), not while it carried out a command", how);
}

/* The clock begins anew with the machine, and the file may be older. */
static void mend_kept(suspect_watch *w)
{
    int64_t now = clock_monotonic_ns();
    w->some = false;
    for (int i = 0; i < SUSPECTS_MAX; i++) {
        culprit *k = &w->file->kept[i];
        k->client_name[NAME_KEPT - 1] = k->name[NAME_KEPT - 1] = '\0';
        if (k->since_ns > now) k->since_ns = now;
        if (k->until_ns > now + MOST_NS) k->until_ns = now + MOST_NS;
        if (k->kind >= WIRE_KIND_COUNT || now - k->since_ns > FORGIVEN_NS) *k = (culprit){.times = 0};
        w->some |= k->times && k->until_ns > now;
    }
}

/* ---- the file ---- */

static int warn_of_file(const char *path)
{
    log_warning("%s: %s: what this daemon carries out will not be known after a crash", path, strerror(errno));
    return -1;
}

static int open_suspect_file(suspect_watch *w, const char *path)
{
    struct stat is;
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK, 0600);
    if (fd < 0) return warn_of_file(path);
    errno = EINVAL;
    bool good = fstat(fd, &is) == 0 && S_ISREG(is.st_mode) && flock(fd, LOCK_EX | LOCK_NB) == 0;
    /* Room for all of it: a store into a page for which the disk has none would be the end. */
    if (good && (errno = posix_fallocate(fd, 0, sizeof(suspect_file))) != 0) good = false;
    void *at = good ? mmap(NULL, sizeof(suspect_file), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0) : MAP_FAILED;
    if (at == MAP_FAILED) {
        int result = warn_of_file(path);
        close(fd);
        return result;
    }
    w->file = at;
    w->fd = fd;
    return 0;
}

/* systemd may name several, divided by colons. */
static bool runtime_folder(const service *s, char *folder, size_t size)
{
    const char *given = *s->config.runtime_dir ? s->config.runtime_dir : getenv("RUNTIME_DIRECTORY");
    if (s->replaying || !given || !*given) return false;
    int length = *s->config.runtime_dir ? (int)strlen(given) : (int)strcspn(given, ":");
    return snprintf(folder, size, "%.*s", length, given) < (int)size;
}

void suspect_open(service *s)
{
    suspect_watch opened = {.some = false}, *w = &opened;
    char folder[CONFIG_TEXT_MAX], path[CONFIG_TEXT_MAX + 32];
    if (!runtime_folder(s, folder, sizeof folder)) return;
    snprintf(path, sizeof path, "%s/carried_out", folder);
    if (open_suspect_file(w, path) != 0) return;
    suspect_file *f = w->file;
    bool whole = f->magic == MAGIC && f->size == sizeof *f;
    if (!whole) {
        memset(f, 0, sizeof *f);
        f->magic = MAGIC;
        f->size = sizeof *f;
    } else if (atomic_load(&f->running)) {
        judge(f);
    }
    mend_kept(w);
    atomic_store(&f->doing, DOING_NOTHING);
    for (int i = 0; i < BUILD_THREADS; i++) atomic_store(&f->builds[i].is_on, 0);
    atomic_store(&f->end_signal, 0);
    atomic_store(&f->end_in_build, 0);
    atomic_store(&f->end_of_memory, 0);
    atomic_store(&f->running, 1);
    s->suspects = base_alloc(1, sizeof *w);
    *s->suspects = opened;
    watch_signals(f);
    builds_report(s->builds, &(build_watch){build_begins, build_ends, f});
}

void suspect_close(service *s)
{
    suspect_watch *w = s->suspects;
    if (!w) return;
    atomic_store(&w->file->running, 0);
    of_process = NULL;
    munmap(w->file, sizeof *w->file);
    close(w->fd);
    array_free(&w->scratch);
    free(w);
    s->suspects = NULL;
}

/* ---- who is refused ---- */

static bool is_refused_for(suspect_watch *w, const culprit *k, const wire_message *m, uint64_t *content)
{
    if (k->kind == WIRE_NOTHING) return m->kind == WIRE_BODY || m->kind == WIRE_SUBSCRIPTION;
    if (k->kind != m->kind) return false;
    if (!*content) *content = content_of(w, m);
    return k->content == *content;
}

static bool takes_back(const wire_message *m)
{
    return (m->kind == WIRE_BODY && m->body.removed) || (m->kind == WIRE_SUBSCRIPTION && m->subscription.removed) ||
           (m->kind == WIRE_GEOMETRY && m->geometry.removed) || (m->kind == WIRE_CLIENT && m->client.removed);
}

bool suspect_refuses(service *s, const wire_message *m, wire_refusal *why)
{
    suspect_watch *w = s->suspects;
    int64_t client, sequence;
    int32_t object;
    uint64_t content = 0;
    if (!w || !w->some || takes_back(m)) return false;
    wire_origin(m, &client, &sequence, &object);
    const char *name = client_name(s, client);
    w->some = false;
    for (int i = 0; i < SUSPECTS_MAX; i++) {
        const culprit *k = &w->file->kept[i];
        if (!k->times || k->until_ns <= s->monotonic_ns) continue;
        w->some = true;
        if (!is_of(k, client, name) || !is_refused_for(w, k, m, &content)) continue;
        why->reason = WIRE_LIMIT;
        snprintf(why->text, sizeof why->text,
            "suspect: a daemon was killed over it, %u time(s): refused for %" PRId64 " s more", k->times,
            (k->until_ns - s->monotonic_ns) / SECOND_NS + 1);
        metric_count(s->count.suspects_refused, 1);
        return true;
    }
    return false;
}

size_t suspect_count(const service *s)
{
    const suspect_watch *w = s->suspects;
    size_t count = 0;
    for (int i = 0; w && w->some && i < SUSPECTS_MAX; i++) {
        const culprit *k = &w->file->kept[i];
        count += k->times && k->until_ns > s->monotonic_ns;
    }
    return count;
}

void suspect_describe(const service *s, char *text, size_t size)
{
    const suspect_watch *w = s->suspects;
    char what[512];
    text[0] = '\0';
    for (int i = 0; w && w->some && i < SUSPECTS_MAX; i++) {
        const culprit *k = &w->file->kept[i];
        if (!k->times || k->until_ns <= s->monotonic_ns) continue;
        report_of_culprit(k, what, sizeof what);
        snprintf(text, size, "suspect: a daemon was killed over %.300s; refused for %" PRId64 " s", what,
            (k->until_ns - s->monotonic_ns) / SECOND_NS + 1);
        return;
    }
}
