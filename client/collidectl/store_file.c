/* store_file: the file and its lock. The file is replaced by rename, so that a crash leaves the old or the new one. One
 * thread. */
#include "store_file.h"

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

static int read_store(store *s, ctl *c)
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
    if (!status) status = read_store(s, c);
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
