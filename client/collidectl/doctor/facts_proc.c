/* facts_proc: proc/net/udp and udp6 for ports and socket inodes, proc/PID/fd for who holds these. */
#include "facts.h"

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { PATH_LENGTH = 512, SOCKETS_MAX = 4096 };

long facts_number(const char *root, const char *path)
{
    char name[PATH_LENGTH];
    long number = -1;
    snprintf(name, sizeof name, "%s%s", root, path);
    FILE *f = fopen(name, "re");
    if (!f) return -1;
    if (fscanf(f, "%ld", &number) != 1) number = -1; /* NOLINT(cert-err34-c): the kernel's own number */
    fclose(f);
    return number;
}

/* Calls `each` for every UDP socket; false if neither file can be read. */
static bool each_socket(
    const char *root, void (*each)(void *context, unsigned port, unsigned long inode), void *context)
{
    bool any = false;
    for (const char *const *table = (const char *const[]){"udp", "udp6", NULL}; *table; table++) {
        char name[PATH_LENGTH], line[512];
        snprintf(name, sizeof name, "%s/proc/net/%s", root, *table);
        FILE *f = fopen(name, "re");
        if (!f) continue;
        any = true;
        while (fgets(line, sizeof line, f)) {
            unsigned port;
            unsigned long inode;
            /* NOLINTNEXTLINE(cert-err34-c): the kernel's own numbers */
            if (sscanf(line, " %*u: %*[0-9A-F]:%4X %*s %*s %*s %*s %*s %*s %*s %lu", &port, &inode) == 2)
                each(context, port, inode);
        }
        fclose(f);
    }
    return any;
}

static void mark(void *context, unsigned port, unsigned long inode)
{
    (void)inode;
    ((facts_ports *)context)->used[port / 8] |= (uint8_t)(1u << port % 8);
}

bool facts_udp_ports(const char *root, facts_ports *out)
{
    memset(out, 0, sizeof *out);
    return each_socket(root, mark, out);
}

bool facts_port_used(const facts_ports *ports, unsigned port)
{
    return ports->used[port / 8] >> port % 8 & 1;
}

/* ---- who holds them ---- */

typedef struct inode_set {
    unsigned from, to;
    unsigned long inodes[SOCKETS_MAX];
    size_t count;
} inode_set;

static void collect(void *context, unsigned port, unsigned long inode)
{
    inode_set *s = context;
    if (port >= s->from && port <= s->to && s->count < SOCKETS_MAX) s->inodes[s->count++] = inode;
}

static int by_number(const void *a, const void *b)
{
    unsigned long x = *(const unsigned long *)a, y = *(const unsigned long *)b;
    return (x > y) - (x < y);
}

static size_t held_by(const char *root, const char *pid, const inode_set *s)
{
    char folder[PATH_LENGTH], path[PATH_LENGTH + 300], target[64];
    size_t held = 0;
    snprintf(folder, sizeof folder, "%s/proc/%s/fd", root, pid);
    DIR *d = opendir(folder);
    if (!d) return 0;
    for (struct dirent *e; (e = readdir(d));) {
        unsigned long inode;
        snprintf(path, sizeof path, "%s/%s", folder, e->d_name);
        ssize_t length = readlink(path, target, sizeof target - 1);
        if (length <= 0) continue;
        target[length] = '\0';
        if (sscanf(target, "socket:[%lu]", &inode) != 1) continue; /* NOLINT(cert-err34-c) */
        held += bsearch(&inode, s->inodes, s->count, sizeof *s->inodes, by_number) != NULL;
    }
    closedir(d);
    return held;
}

static void process_name(const char *root, const char *pid, char *name, size_t size)
{
    char path[PATH_LENGTH];
    snprintf(path, sizeof path, "%s/proc/%s/comm", root, pid);
    snprintf(name, size, "?");
    FILE *f = fopen(path, "re");
    if (!f) return;
    if (fgets(name, (int)size, f)) name[strcspn(name, "\n")] = '\0';
    fclose(f);
}

size_t facts_most_sockets(const char *root, unsigned from, unsigned to, pid_t *pid, char *name, size_t name_size)
{
    static inode_set s; /* one thread calls */
    char folder[PATH_LENGTH];
    size_t most = 0;
    s = (inode_set){.from = from, .to = to};
    each_socket(root, collect, &s);
    qsort(s.inodes, s.count, sizeof *s.inodes, by_number);
    snprintf(folder, sizeof folder, "%s/proc", root);
    DIR *d = opendir(folder);
    if (!d) return 0;
    for (struct dirent *e; (e = readdir(d));) {
        long number = strtol(e->d_name, NULL, 10);
        size_t held = number > 0 && number != getpid() ? held_by(root, e->d_name, &s) : 0;
        if (held <= most) continue;
        most = held;
        *pid = (pid_t)number;
        process_name(root, e->d_name, name, name_size);
    }
    closedir(d);
    return most;
}

static bool same_network(const char *root, const char *pid)
{
    char path[PATH_LENGTH], its[64] = "", ours[64] = "";
    snprintf(path, sizeof path, "%s/proc/%s/ns/net", root, pid);
    ssize_t a = readlink(path, its, sizeof its - 1);
    snprintf(path, sizeof path, "%s/proc/self/ns/net", root);
    ssize_t b = readlink(path, ours, sizeof ours - 1);
    return a > 0 && a == b && strcmp(its, ours) == 0;
}

pid_t facts_process(const char *root, const char *name, pid_t except)
{
    char folder[PATH_LENGTH], its[64];
    pid_t found = 0;
    snprintf(folder, sizeof folder, "%s/proc", root);
    DIR *d = opendir(folder);
    if (!d) return 0;
    for (struct dirent *e; !found && (e = readdir(d));) {
        long number = strtol(e->d_name, NULL, 10);
        if (number <= 0 || number == except) continue;
        process_name(root, e->d_name, its, sizeof its);
        if (strcmp(its, name) == 0 && same_network(root, e->d_name)) found = (pid_t)number;
    }
    closedir(d);
    return found;
}
