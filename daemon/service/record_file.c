/* record_file: what is between the tick thread and the file's own is under the lock: the queue, and how the file
 * stands. The lock is held for as long as it takes to hand a piece over. */
#include "record_file.h"

#include "base/clock.h"
#include "wire/wire_log.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/statvfs.h>
#include <time.h>
#include <unistd.h>

enum {
    BESIDE_MAX = 1000,       /* names that are tried */
    QUEUE_MAX = 128 << 20,   /* bytes: some seconds of a busy session while a disk stands still */
    JOINED_MAX = 1 << 20,    /* bytes: ticks that wait are written by one call, up to so many */
    PATH_ROOM = 4096 + 2048, /* a folder and a name, as they are configured */
};

static const int64_t SYNC_NS = 1000000000;

typedef struct piece {
    struct piece *next;
    bytes_out bytes;
    state_parts state;                  /* or one of these, ... */
    size_t counted;                     /* bytes of it, in `queued` */
    bool ends_whole;                    /* behind a tick; not: what a recording in the middle begins with */
    int64_t first_record, timestamp_us; /* ... framed by the thread */
} piece;

struct record_file {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t came, gone; /* to the thread: there is work. From it: it stands otherwise, or the queue is shorter */
    /* under the lock */
    piece *first, *last;
    size_t queued; /* bytes; a state, most of which is borrowed, does not count */
    record_file_stand stand;
    bool closing, closed; /* no more comes; the thread has ended */
    char path[PATH_ROOM], why[PATH_ROOM + 256];
    const char *option;
    size_t asked_bytes; /* of room; 0: for none, or it is there, ... */
    bytes_out room;     /* ... here */
    /* the tick thread's */
    bytes_out tick;       /* what the tick that is on has said */
    char seen[PATH_ROOM]; /* `path`, as it was when this thread looked last */
    /* the thread's */
    record_terms terms;
    char asked[PATH_ROOM]; /* terms.path */
    int fd;
    int64_t size, whole; /* bytes in the file; those up to the end of its last whole tick */
    bool failed;         /* nothing more is written */
    bool unsynced;       /* some of them are not on the disk yet */
    int64_t since_ns;    /* the first of those was written then, monotonic */
};

/* ---- the thread ---- */

/* Told once, by the first who knows. Any of the two threads. */
static void end_with(record_file *f, const char *option, const char *why)
{
    pthread_mutex_lock(&f->lock);
    if (f->stand != RECORD_FILE_ENDED) {
        snprintf(f->why, sizeof f->why, "%s", why);
        f->option = option;
        f->stand = RECORD_FILE_ENDED;
    }
    pthread_cond_broadcast(&f->gone);
    pthread_mutex_unlock(&f->lock);
}

static void end_with_error(record_file *f, const char *doing)
{
    char why[PATH_ROOM + 128];
    snprintf(why, sizeof why, "%s%s%s", doing, *doing ? ": " : "", strerror(errno));
    end_with(f, "", why);
}

static void folder_of_path(const char *path, char folder[PATH_ROOM])
{
    snprintf(folder, PATH_ROOM, "%s", path);
    char *slash = strrchr(folder, '/');
    if (!slash)
        snprintf(folder, PATH_ROOM, ".");
    else if (slash == folder)
        slash[1] = '\0';
    else
        *slash = '\0';
}

static bool is_recording(const char *name)
{
    size_t length = strlen(name), ending = strlen(".lcmlog");
    return length > ending && strcmp(name + length - ending, ".lcmlog") == 0;
}

static int64_t recordings_in(const char *folder)
{
    int64_t count = 0;
    DIR *d = opendir(folder);
    for (const struct dirent *e = d ? readdir(d) : NULL; e; e = readdir(d)) count += is_recording(e->d_name);
    if (d) closedir(d);
    return count;
}

/* So that a power cut leaves its name. Where a file system knows no such thing, there is nothing to be done. */
static bool sync_folder(const char *folder)
{
    int d = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    bool synced = d >= 0 && (fsync(d) == 0 || errno == EINVAL || errno == EROFS);
    if (d >= 0) close(d);
    return synced;
}

static bool make_file(record_file *f, char path[PATH_ROOM])
{
    enum { FLAGS = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, MODE = 0666 };
    snprintf(path, PATH_ROOM, "%s", f->asked);
    f->fd = open(path, FLAGS, MODE);
    for (int n = 1; f->fd < 0 && errno == EEXIST && f->terms.beside && n < BESIDE_MAX; n++) {
        if (snprintf(path, PATH_ROOM, "%s.%d", f->asked, n) >= PATH_ROOM) break;
        f->fd = open(path, FLAGS, MODE);
    }
    return f->fd >= 0;
}

/* Free would be less than what is to stay free, with so many bytes more. */
static bool is_too_full(const record_file *f, size_t more)
{
    struct statvfs v;
    if (fstatvfs(f->fd, &v) != 0 || v.f_blocks == 0) return false;
    double unit = (double)v.f_frsize, left = unit * (double)v.f_bavail - (double)more;
    return left < f->terms.keep_free * unit * (double)v.f_blocks;
}

static void say_too_full(record_file *f)
{
    char why[PATH_ROOM + 128];
    snprintf(
        why, sizeof why, "record_keep_free = %g %% is reached: the disk has no more to give", 100 * f->terms.keep_free);
    end_with(f, "record_keep_free", why);
}

static bool open_piece(record_file *f)
{
    char path[PATH_ROOM], folder[PATH_ROOM], why[PATH_ROOM + 128];
    folder_of_path(f->asked, folder);
    if (f->terms.most_files && recordings_in(folder) >= f->terms.most_files) {
        snprintf(why, sizeof why, "record_max_files = %" PRId64 " is reached: move some out of %s", f->terms.most_files,
            folder);
        end_with(f, "record_max_files", why);
        return false;
    }
    if (!make_file(f, path)) {
        end_with_error(f, path);
        return false;
    }
    if (!sync_folder(folder)) {
        end_with_error(f, folder);
        return false;
    }
    if (f->terms.keep_free > 0 && is_too_full(f, 0)) {
        say_too_full(f);
        unlink(path); /* nothing is in it */
        return false;
    }
    pthread_mutex_lock(&f->lock);
    memcpy(f->path, path, sizeof f->path);
    if (f->stand == RECORD_FILE_OPENING) f->stand = RECORD_FILE_OPEN;
    pthread_cond_broadcast(&f->gone);
    pthread_mutex_unlock(&f->lock);
    return true;
}

static int write_all(void *context, const uint8_t *bytes, size_t size)
{
    const record_file *f = context;
    while (size) {
        ssize_t n = write(f->fd, bytes, size);
        if (n < 0 && errno == EINTR) continue;
        if (n == 0) errno = ENOSPC;
        if (n <= 0) return -1;
        bytes += n;
        size -= (size_t)n;
    }
    return 0;
}

/* Framed into memory, so that it is written by large calls. */
static int put_to_bytes(void *context, const uint8_t *bytes, size_t size)
{
    bytes_put(context, bytes, size);
    return 0;
}

static bool has_room_for_bytes(record_file *f, size_t more)
{
    char why[128];
    if (f->size + (int64_t)more > f->terms.most_bytes) {
        snprintf(why, sizeof why, "record_max_size = %" PRId64 " MiB is reached", f->terms.most_bytes >> 20);
        end_with(f, "record_max_size", why);
        return false;
    }
    if (!(f->terms.keep_free > 0) || !is_too_full(f, more)) return true;
    say_too_full(f);
    return false;
}

static bool write_bytes(record_file *f, const bytes_out *bytes)
{
    if (!f->unsynced) f->since_ns = clock_monotonic_ns();
    f->unsynced = true;
    if (write_all(f, bytes->at, bytes->count) != 0) {
        end_with_error(f, "");
        return false;
    }
    f->size += (int64_t)bytes->count;
    return true;
}

/* It may be far larger than what is to be in memory twice. */
static bool write_state(record_file *f, piece *p)
{
    state_parts *all = &p->state;
    bytes_out framed = {0};
    if (!has_room_for_bytes(f, all->size + all->size / 256)) return false;
    uint8_t *some = base_alloc(WIRE_LOG_PIECE_BYTES, 1);
    wire_log_writer *w = wire_log_to(put_to_bytes, &framed, p->first_record);
    uint64_t hash = state_parts_hash(all);
    bool good = w != NULL;
    while (good && all->read < all->size) {
        size_t offset = all->read, size = state_parts_read(all, some, WIRE_LOG_PIECE_BYTES);
        wire_log_state_piece(w, p->timestamp_us, offset, all->size, hash, some, size);
        if (framed.count < JOINED_MAX && all->read < all->size) continue;
        good = write_bytes(f, &framed);
        framed.count = 0;
    }
    wire_log_close(w);
    array_free(&framed);
    free(some);
    return good;
}

static bool write_piece(record_file *f, piece *p)
{
    if (p->state.size) return write_state(f, p);
    if (!has_room_for_bytes(f, p->bytes.count) || !write_bytes(f, &p->bytes)) return false;
    if (p->ends_whole) f->whole = f->size;
    return true;
}

static bool sync_file(record_file *f)
{
    f->unsynced = false;
    if (fdatasync(f->fd) == 0 || errno == EINVAL || errno == EROFS) return true;
    end_with_error(f, "");
    return false;
}

/* What a recording begins with is worth nothing without its first tick. */
static bool is_syncable(const record_file *f)
{
    return f->unsynced && f->whole == f->size;
}

static bool no_more_comes(const record_file *f)
{
    return f->closing || f->stand == RECORD_FILE_ENDED;
}

/* The next piece, or NULL when it is time to sync, or to end. With the lock. */
static piece *next_piece(record_file *f)
{
    while (!f->first && !no_more_comes(f)) {
        int64_t due_ns = f->since_ns + SYNC_NS;
        if (is_syncable(f) && clock_monotonic_ns() >= due_ns) return NULL;
        struct timespec until = {.tv_sec = due_ns / 1000000000, .tv_nsec = due_ns % 1000000000};
        if (is_syncable(f))
            pthread_cond_timedwait(&f->came, &f->lock, &until);
        else
            pthread_cond_wait(&f->came, &f->lock);
    }
    piece *p = f->first;
    if (!p) return NULL;
    f->first = p->next;
    if (!f->first) f->last = NULL;
    return p;
}

static void free_piece(piece *p)
{
    array_free(&p->bytes);
    state_parts_free(&p->state, NULL);
    free(p);
}

/* What was handed over before an end is written all the same, if the disk takes it. */
static void write_and_sync(record_file *f)
{
    for (bool more = true; more;) {
        pthread_mutex_lock(&f->lock);
        piece *p = next_piece(f);
        more = p || !no_more_comes(f);
        pthread_mutex_unlock(&f->lock);
        if (p) f->failed |= !write_piece(f, p);
        if (is_syncable(f) && !f->failed && clock_monotonic_ns() >= f->since_ns + SYNC_NS) f->failed |= !sync_file(f);
        more &= !f->failed;
        if (!p) continue;
        pthread_mutex_lock(&f->lock);
        f->queued -= p->counted;
        pthread_cond_broadcast(&f->gone);
        pthread_mutex_unlock(&f->lock);
        free_piece(p);
    }
    if (f->failed && ftruncate(f->fd, f->whole) != 0) end_with_error(f, "its last tick is cut off");
    if (f->unsynced) sync_file(f);
}

/* Touched, page by page: whoever fills it finds it there. */
static bytes_out make_bytes(size_t size)
{
    bytes_out room = {0};
    array_reserve(&room, size);
    memset(room.at, 0, room.capacity);
    return room;
}

static void make_room_of_state(record_file *f)
{
    pthread_mutex_lock(&f->lock);
    while (!f->asked_bytes && !f->first && !no_more_comes(f)) pthread_cond_wait(&f->came, &f->lock);
    size_t size = f->asked_bytes;
    pthread_mutex_unlock(&f->lock);
    if (!size) return;
    bytes_out room = make_bytes(size);
    pthread_mutex_lock(&f->lock);
    f->room = room;
    f->asked_bytes = 0;
    pthread_mutex_unlock(&f->lock);
}

static void *keep_file(void *context)
{
    record_file *f = context;
    if (open_piece(f)) {
        make_room_of_state(f);
        write_and_sync(f);
    }
    if (f->fd >= 0 && close(f->fd) != 0) end_with_error(f, "");
    pthread_mutex_lock(&f->lock);
    f->closed = true;
    pthread_cond_broadcast(&f->gone);
    pthread_mutex_unlock(&f->lock);
    return NULL;
}

/* ---- the tick thread ---- */

static void make_condition(pthread_cond_t *c)
{
    pthread_condattr_t by;
    pthread_condattr_init(&by);
    pthread_condattr_setclock(&by, CLOCK_MONOTONIC);
    pthread_cond_init(c, &by);
    pthread_condattr_destroy(&by);
}

static void free_record_file(record_file *f)
{
    for (piece *p = f->first, *next; p; p = next) {
        next = p->next;
        free_piece(p);
    }
    array_free(&f->tick);
    array_free(&f->room);
    pthread_cond_destroy(&f->came);
    pthread_cond_destroy(&f->gone);
    pthread_mutex_destroy(&f->lock);
    free(f);
}

record_file *record_file_begin(const record_terms *terms)
{
    record_file *f = base_zalloc(1, sizeof *f);
    f->fd = -1;
    f->terms = *terms;
    f->option = "";
    snprintf(f->asked, sizeof f->asked, "%s", terms->path);
    memcpy(f->path, f->asked, sizeof f->path);
    memcpy(f->seen, f->asked, sizeof f->seen);
    f->terms.path = f->asked;
    pthread_mutex_init(&f->lock, NULL);
    make_condition(&f->came);
    make_condition(&f->gone);
    int error = pthread_create(&f->thread, NULL, keep_file, f);
    if (!error) return f;
    free_record_file(f);
    errno = error;
    return NULL;
}

/* Waits, with the lock, until something has changed, or for that long in all: false when that is over. */
static bool wait_gone(record_file *f, int wait_ms, int64_t since_ns)
{
    int64_t until_ns = since_ns + (int64_t)wait_ms * 1000000;
    struct timespec until = {.tv_sec = until_ns / 1000000000, .tv_nsec = until_ns % 1000000000};
    if (wait_ms < 0) return pthread_cond_wait(&f->gone, &f->lock) == 0;
    return wait_ms > 0 && pthread_cond_timedwait(&f->gone, &f->lock, &until) == 0;
}

record_file_stand record_file_look(record_file *f, int wait_ms)
{
    int64_t since_ns = clock_monotonic_ns();
    pthread_mutex_lock(&f->lock);
    while (f->stand == RECORD_FILE_OPENING && wait_gone(f, wait_ms, since_ns)) {
    }
    record_file_stand stand = f->stand;
    memcpy(f->seen, f->path, sizeof f->seen);
    pthread_mutex_unlock(&f->lock);
    return stand;
}

const char *record_file_path(const record_file *f)
{
    return f->seen;
}

const char *record_file_why(const record_file *f, const char **option)
{
    *option = f->option;
    return f->why;
}

void record_file_ask_room(record_file *f, size_t state_bytes)
{
    pthread_mutex_lock(&f->lock);
    f->asked_bytes = state_bytes;
    pthread_cond_signal(&f->came);
    pthread_mutex_unlock(&f->lock);
}

bool record_file_take_room(record_file *f, bytes_out *state)
{
    pthread_mutex_lock(&f->lock);
    bool there = f->room.capacity > 0;
    if (there) {
        *state = f->room;
        f->room = (bytes_out){0};
    }
    pthread_mutex_unlock(&f->lock);
    return there;
}

int record_file_put(void *file, const uint8_t *bytes, size_t size)
{
    record_file *f = file;
    bytes_put(&f->tick, bytes, size);
    return 0;
}

/* With the lock; the bytes become the queue's. */
static void append(record_file *f, piece p)
{
    piece *at = base_alloc(1, sizeof *at);
    *at = p;
    at->next = NULL;
    if (f->last)
        f->last->next = at;
    else
        f->first = at;
    f->last = at;
    pthread_cond_signal(&f->came);
}

/* With the lock. Many small ticks are joined, and what they were put together in is used again. */
static void hand_over(record_file *f)
{
    size_t size = f->tick.count;
    piece *last = f->last;
    if (!size) return;
    f->queued += size;
    if (last && last->ends_whole && last->bytes.count + size <= JOINED_MAX) {
        bytes_put(&last->bytes, f->tick.at, size);
        last->counted += size;
        f->tick.count = 0;
        return;
    }
    append(f, (piece){.bytes = f->tick, .counted = size, .ends_whole = true});
    f->tick = (bytes_out){0};
}

/* With the lock: what is in the middle of a tick, or of what a recording begins with. */
static void hand_over_part(record_file *f)
{
    if (!f->tick.count) return;
    f->queued += f->tick.count;
    append(f, (piece){.bytes = f->tick, .counted = f->tick.count});
    f->tick = (bytes_out){0};
}

void record_file_put_state(record_file *f, state_parts *state, int64_t first_record, int64_t timestamp_us)
{
    pthread_mutex_lock(&f->lock);
    hand_over_part(f);
    append(f, (piece){.state = *state, .first_record = first_record, .timestamp_us = timestamp_us});
    pthread_mutex_unlock(&f->lock);
    *state = (state_parts){.size = 0};
}

static void end_behind(record_file *f)
{
    char why[128];
    snprintf(why, sizeof why, "the disk does not keep up: %d MiB wait to be written", QUEUE_MAX >> 20);
    end_with(f, "", why);
}

bool record_file_part(record_file *f)
{
    pthread_mutex_lock(&f->lock);
    bool full = f->queued > QUEUE_MAX;
    if (full || f->stand == RECORD_FILE_ENDED)
        f->tick.count = 0;
    else
        hand_over_part(f);
    bool more = f->queued < QUEUE_MAX / 4;
    pthread_mutex_unlock(&f->lock);
    if (full) end_behind(f);
    return more;
}

void record_file_tick(record_file *f, bool may_wait)
{
    pthread_mutex_lock(&f->lock);
    while (may_wait && f->queued > QUEUE_MAX && f->stand != RECORD_FILE_ENDED) wait_gone(f, -1, 0);
    bool full = f->queued > QUEUE_MAX;
    if (full || f->stand == RECORD_FILE_ENDED)
        f->tick.count = 0;
    else
        hand_over(f);
    pthread_mutex_unlock(&f->lock);
    if (full) end_behind(f);
}

bool record_file_close(record_file *f, int wait_ms)
{
    int64_t since_ns = clock_monotonic_ns();
    pthread_mutex_lock(&f->lock);
    if (!f->closing && f->stand != RECORD_FILE_ENDED) hand_over(f);
    f->closing = true;
    pthread_cond_signal(&f->came);
    while (!f->closed && wait_gone(f, wait_ms, since_ns)) {
    }
    bool closed = f->closed;
    pthread_mutex_unlock(&f->lock);
    if (!closed) return false;
    pthread_join(f->thread, NULL);
    free_record_file(f);
    return true;
}
