/* store: the file, its lock, and looking things up. The file is replaced by rename, so that a crash leaves the old or
 * the new one. One thread. */
#include "store.h"

#include "loaders/text.h"
#include "store_format.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

enum { STORE_SIZE_MAX = 64 << 20 };

/* ---- the file ---- */

static int make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        int failed = mkdir(path, 0700) != 0 && errno != EEXIST;
        if (failed)
            return ctl_fail(
                EX_CANTCREAT, "%s: %s: set XDG_STATE_HOME to a folder that can be written", path, strerror(errno));
        *slash = '/';
    }
    return 0;
}

static char *find_path(pool *p, const char *as)
{
    const char *state = getenv("XDG_STATE_HOME"), *home = getenv("HOME");
    if (state && *state == '/') return pool_format(p, "%s/collidectl/%s", state, as);
    return home && *home == '/' ? pool_format(p, "%s/.local/state/collidectl/%s", home, as) : NULL;
}

static int lock(store *s, const char *as)
{
    const char *path = pool_format(s->pool, "%s.lock", s->path);
    s->lock = open(path, O_RDWR | O_CREAT | O_CLOEXEC, 0600);
    if (s->lock < 0) return ctl_fail(EX_CANTCREAT, "%s: %s", path, strerror(errno));
    if (flock(s->lock, LOCK_EX | LOCK_NB) == 0) return 0;
    return ctl_fail(EX_TEMPFAIL, "another collidectl is at work as '%s': wait for it, or give another --as", as);
}

static int read_file(store *s, ctl *c)
{
    size_t size;
    if (access(s->path, F_OK) != 0) return 0; /* the first run */
    char *data = text_read_file(s->pool, s->path, STORE_SIZE_MAX, &size, &c->report);
    if (!data) return ctl_fail_loading(c);
    int line = 1;
    for (char *rest = data, *end; *rest; rest = end, line++) {
        end = rest + strcspn(rest, "\n");
        if (*end) *end++ = '\0';
        if (!store_read_line(s, rest))
            return ctl_fail(EX_DATAERR, "%s:%d: is damaged: remove that file and load again", s->path, line);
    }
    return 0;
}

int store_open(store *s, ctl *c)
{
    *s = (store){.pool = &c->pool, .lock = -1};
    s->path = find_path(&c->pool, c->options.as);
    if (!s->path) return ctl_fail(EX_CONFIG, "neither XDG_STATE_HOME nor HOME is set to a whole path");
    int status = make_folders(s->path);
    if (!status) status = lock(s, c->options.as);
    if (!status) status = read_file(s, c);
    if (status) store_close(s);
    return status;
}

int store_save(store *s)
{
    const char *fresh = pool_format(s->pool, "%s.new", s->path);
    FILE *out = fopen(fresh, "we");
    if (!out) return ctl_fail(EX_CANTCREAT, "%s: %s", fresh, strerror(errno));
    store_write(s, out);
    bool ok = fflush(out) == 0 && fsync(fileno(out)) == 0;
    ok = fclose(out) == 0 && ok && rename(fresh, s->path) == 0;
    return ok ? 0 : ctl_fail(EX_IOERR, "%s: %s", s->path, strerror(errno));
}

void store_close(store *s)
{
    if (s->lock >= 0) close(s->lock);
    s->lock = -1;
}

/* ---- bodies ---- */

static size_t place_of(const store *s, const char *name)
{
    size_t i = 0;
    while (i < s->body_count && strcmp(s->bodies[i].name, name) != 0) i++;
    return i;
}

int32_t store_find(const store *s, const char *name)
{
    size_t i = place_of(s, name);
    return i < s->body_count ? s->bodies[i].id : -1;
}

int32_t store_id_for(const store *s, const char *name, int32_t *next)
{
    int32_t id = store_find(s, name);
    return id >= 0 ? id : (*next)++;
}

void store_put(store *s, const char *name, int32_t id)
{
    size_t i = place_of(s, name);
    if (i == s->body_count) {
        s->bodies = store_grow(s->pool, s->bodies, s->body_count, &s->body_room, sizeof *s->bodies);
        s->bodies[s->body_count++].name = pool_copy(s->pool, name);
    }
    s->bodies[i].id = id;
    if (id >= s->next_id) s->next_id = id + 1;
}

/* ---- robots ---- */

store_robot *store_find_robot(const store *s, const char *name)
{
    for (size_t i = 0; i < s->robot_count; i++)
        if (strcmp(s->robots[i].name, name) == 0) return &s->robots[i];
    return NULL;
}

/* A later run may start in another folder. */
static const char *whole(pool *p, const char *path)
{
    char *real = path ? realpath(path, NULL) : NULL;
    const char *copy = pool_copy(p, real ? real : path ? path : "");
    free(real);
    return copy;
}

void store_put_robot(store *s, const robot *r, collided_pose base, const double *values)
{
    const char *prefix = r->source.prefix ? r->source.prefix : "";
    const char *name = pool_format(s->pool, "%s%s", prefix, r->model.name);
    store_robot *to = store_find_robot(s, name);
    if (!to) {
        s->robots = store_grow(s->pool, s->robots, s->robot_count, &s->robot_room, sizeof *s->robots);
        to = &s->robots[s->robot_count++];
    }
    *to = (store_robot){.name = name,
        .urdf = whole(s->pool, r->source.urdf),
        .srdf = whole(s->pool, r->source.srdf),
        .prefix = pool_copy(s->pool, prefix),
        .base = base};
    for (; to->package_count < r->source.package_count && to->package_count < PACKAGES_MAX; to->package_count++)
        to->packages[to->package_count] = (load_package){pool_copy(s->pool, r->source.packages[to->package_count].name),
            whole(s->pool, r->source.packages[to->package_count].path)};
    store_set_values(s, to, r, values);
}

void store_set_values(store *s, store_robot *to, const robot *r, const double *values)
{
    to->joint_count = (size_t)r->model.joint_count;
    to->joints = pool_alloc(s->pool, to->joint_count, sizeof *to->joints);
    to->values = pool_alloc(s->pool, to->joint_count, sizeof *to->values);
    for (size_t i = 0; i < to->joint_count; i++) {
        to->joints[i] = r->model.joints[i].name;
        to->values[i] = values[i];
    }
}
