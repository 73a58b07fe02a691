/* start: looks at limits, files and links, and changes nothing. Main thread. What it cannot see, that a port is taken
 * or a disk full, is found by whoever opens it. */
#include "start.h"

#include "link/link_open.h"
#include "privileges.h"
#include "service.h"

#include <errno.h>
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sysexits.h>
#include <unistd.h>

/* Files that an idle daemon has open over DDS and LCM are 20 to 30; each further link takes as many. */
enum { FILES_LEAST = 64 };

static int check_limits(char *why, size_t why_size)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) != 0 || files.rlim_cur >= FILES_LEAST) return EX_OK;
    snprintf(why, why_size, "only %lu files may be open, %d are needed: do: ulimit -n 1024 (or LimitNOFILE=1024)",
        (unsigned long)files.rlim_cur, FILES_LEAST);
    return EX_OSERR;
}

/* The status for a file that cannot be made, with errno's reason. */
static int cannot_create(const char *key, const char *path, const char *mend, char *why, size_t why_size)
{
    int error = errno;
    snprintf(why, why_size, "%s = \"%s\": %s: %s", key, path, strerror(error), mend);
    return error == EACCES || error == EPERM ? EX_NOPERM : EX_CANTCREAT;
}

/* `folder`: where what the option names is, or is to be made. */
static int check_folder(const char *key, const char *value, const char *folder, char *why, size_t why_size)
{
    struct stat is;
    if (stat(folder, &is) != 0) return cannot_create(key, value, "create its folder, or mount its disk", why, why_size);
    errno = ENOTDIR;
    if (S_ISDIR(is.st_mode) && access(folder, W_OK | X_OK) == 0) return EX_OK;
    return cannot_create(key, value, "name a folder in which this user may write", why, why_size);
}

static int check_record(const char *path, char *why, size_t why_size)
{
    char folder[CONFIG_TEXT_MAX];
    struct stat is;
    if (!*path) return EX_OK;
    if (lstat(path, &is) == 0) {
        errno = EEXIST;
        return cannot_create("record", path, "move it away, or choose another name", why, why_size);
    }
    snprintf(folder, sizeof folder, "%s", path);
    char *slash = strrchr(folder, '/');
    if (slash) slash[slash == folder] = '\0';
    return check_folder("record", path, slash ? folder : ".", why, why_size);
}

static int check_replay(const char *path, char *why, size_t why_size)
{
    struct stat is;
    bool there = access(path, R_OK) == 0 && stat(path, &is) == 0;
    if (there && S_ISREG(is.st_mode)) return EX_OK;
    snprintf(why, why_size, "replay = \"%s\": %s: name a recording that this user may read", path,
        there ? "not a file" : strerror(errno));
    return EX_NOINPUT;
}

typedef char link_key[LINK_KEY_MAX];

static int check_link(const char *uri, const config *c, link_key *keys, size_t *count, char *why, size_t why_size)
{
    link_options options = {.interface = c->interface, .security = c->security, .program = c->gateway};
    if (*count == LINKS_MAX) {
        snprintf(why, why_size, "links = \"%.200s\": more than %d: leave some out", c->links, LINKS_MAX);
        return EX_CONFIG;
    }
    int status = link_check(uri, &options, keys[*count], why, why_size);
    for (size_t i = 0; status == EX_OK && i < *count; i++) {
        if (strcmp(keys[i], keys[*count]) != 0) continue;
        snprintf(why, why_size, "links = \"%.200s\": %s is there twice: leave one out", c->links, uri);
        return EX_CONFIG;
    }
    ++*count;
    return status;
}

static int check_links(const config *c, char *why, size_t why_size)
{
    char list[CONFIG_TEXT_MAX], *rest = NULL;
    link_key keys[LINKS_MAX];
    size_t count = 0;
    snprintf(list, sizeof list, "%s", c->links);
    for (char *uri = strtok_r(list, " ,", &rest); uri; uri = strtok_r(NULL, " ,", &rest)) {
        int status = check_link(uri, c, keys, &count, why, why_size);
        if (status != EX_OK) return status;
    }
    if (count) return EX_OK;
    snprintf(why, why_size, "links = \"\": nobody could be heard: name dds://DOMAIN, lcm:// or both");
    return EX_CONFIG;
}

/* A large batch of poses is copied by the transport, and freed. That memory is kept for the next one: given back to the
 * system each time, its pages would be cleared each time. */
static void keep_memory(void)
{
    enum { LARGEST = 4 << 20, KEPT = 64 << 20 }; /* bytes; beyond, an array that grows is not copied: its pages move */
    mallopt(M_MMAP_THRESHOLD, LARGEST);
    mallopt(M_TRIM_THRESHOLD, KEPT);
}

void start_environment(config *c)
{
    keep_memory();
    const char *security = getenv("COLLIDED_SECURITY");
    if (!*c->security && security) snprintf(c->security, sizeof c->security, "%s", security);
}

bool start_choose_links(config *c, char *why, size_t why_size)
{
    link_key key;
    link_options options = {.interface = c->interface, .program = c->gateway};
    if (strcmp(c->links, "auto") != 0 || *c->replay) return true;
    bool closed = *c->security != '\0';
    bool lcm = !closed && link_check("lcm://", &options, key, why, why_size) == EX_OK;
    if (closed) snprintf(why, why_size, "security is set up, and LCM has none");
    snprintf(c->links, sizeof c->links, "%s", lcm ? "dds://0 lcm://" : "dds://0");
    return lcm;
}

int start_check(const config *c, char *why, size_t why_size)
{
    int status = check_limits(why, why_size);
    if (status == EX_OK) status = privileges_check(c->user, why, why_size);
    if (status == EX_OK && *c->record) status = check_record(c->record, why, why_size);
    if (status == EX_OK && *c->runtime_dir)
        status = check_folder("runtime_dir", c->runtime_dir, c->runtime_dir, why, why_size);
    if (status == EX_OK && *c->record_dir)
        status = check_folder("record_dir", c->record_dir, c->record_dir, why, why_size);
    if (status != EX_OK) return status;
    if (*c->replay_pipe && (!*c->replay || c->trade)) {
        snprintf(why, why_size, "replay_pipe = \"%.40s\": what is served is a recording: name one by replay",
            c->replay_pipe);
        return EX_CONFIG;
    }
    if (c->trade && !*c->replay) {
        snprintf(why, why_size, "trade = yes: what is compared is a recording: name one by replay");
        return EX_CONFIG;
    }
    return *c->replay ? check_replay(c->replay, why, why_size) : check_links(c, why, why_size);
}
