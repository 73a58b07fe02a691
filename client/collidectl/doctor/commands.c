/* commands: a daemon that says "host:pid" of itself, as it does unless it was given a name, and whose host is this one,
 * is known down to its command line; of others, only the host is known. */
#include "commands.h"

#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char *command_word(const char *text, char *out, size_t size)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_./:=,@%+-";
    size_t at = 0;
    if (*text && text[strspn(text, plain)] == '\0') {
        snprintf(out, size, "%s", text);
        return out;
    }
    out[at++] = '\'';
    for (; *text && at + 6 < size; text++) {
        if (*text == '\'')
            at += (size_t)snprintf(out + at, size - at, "'\\''");
        else
            out[at++] = *text;
    }
    out[at++] = '\'';
    out[at] = '\0';
    return out;
}

/* ---- which process ---- */

/* "host:pid": true if it is of that form. */
static bool split_name(const char *name, char host[128], long *pid)
{
    const char *colon = strrchr(name, ':');
    char *end;
    if (!colon || colon == name || (size_t)(colon - name) >= 128) return false;
    *pid = strtol(colon + 1, &end, 10);
    snprintf(host, 128, "%.*s", (int)(colon - name), name);
    return *pid > 0 && *end == '\0' && host[strcspn(host, " '\"\\$`;&|<>()")] == '\0';
}

static bool is_here(const char *host)
{
    char ours[128] = "";
    return gethostname(ours, sizeof ours - 1) == 0 && strcmp(ours, host) == 0;
}

static size_t read_proc_file(long pid, const char *file, char *out, size_t size)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%ld/%s", pid, file);
    FILE *f = fopen(path, "re");
    size_t n = f ? fread(out, 1, size - 1, f) : 0;
    if (f) fclose(f);
    out[n] = '\0';
    return n;
}

/* The unit that systemd runs it under; false: none. */
static bool unit_of(long pid, char unit[64])
{
    char groups[1024];
    read_proc_file(pid, "cgroup", groups, sizeof groups);
    char *found = strstr(groups, "collided");
    if (!found || !strstr(found, ".service")) return false;
    snprintf(unit, 64, "%.*s", (int)(strstr(found, ".service") - found), found);
    return strlen(unit) + 8 == strcspn(found, "\n/");
}

/* The words of its command line, for the shell; "" if they cannot be read. */
static void options_of(long pid, char *out, size_t size)
{
    char words[COMMAND_MAX], word[COMMAND_MAX];
    size_t n = read_proc_file(pid, "cmdline", words, sizeof words), at = 0;
    out[0] = '\0';
    for (size_t i = strlen(words) + 1; i < n && at < size; i += strlen(words + i) + 1)
        at += (size_t)snprintf(out + at, size - at, " %s", command_word(words + i, word, sizeof word));
}

/* ---- commands ---- */

void command_end(const ear_daemon *daemon, char out[COMMAND_MAX])
{
    char host[128], unit[64];
    long pid;
    if (!split_name(daemon->name, host, &pid))
        snprintf(out, COMMAND_MAX, "systemctl stop collided   # on the host of %.100s", daemon->name);
    else if (!is_here(host))
        snprintf(out, COMMAND_MAX, "ssh %s kill %ld", host, pid);
    else if (unit_of(pid, unit))
        snprintf(out, COMMAND_MAX, "systemctl stop %s", unit);
    else
        snprintf(out, COMMAND_MAX, "kill %ld", pid);
}

/* A daemon that systemd runs takes its options from a file. */
static void restart_unit(const char *unit, const char *options, const char *key, long value, char out[COMMAND_MAX])
{
    const char *config = strstr(options, " --config ");
    int at = 0;
    if (key)
        at = snprintf(out, COMMAND_MAX, "echo '%s = %ld' >> %.*s; ", key, value,
            config ? (int)strcspn(config + 10, " ") : 100, config ? config + 10 : "/etc/collided/collided.conf");
    snprintf(out + at, (size_t)(COMMAND_MAX - at), "systemctl restart %s", unit);
}

void command_restart(const doctor *d, const ear_daemon *daemon, const char *key, long value, char out[COMMAND_MAX])
{
    char host[128], unit[64], options[COMMAND_MAX], program[PATH_MAX], more[96] = "";
    long pid;
    if (!split_name(daemon->name, host, &pid)) {
        snprintf(out, COMMAND_MAX, "systemctl restart collided   # on the host of %.100s", daemon->name);
        return;
    }
    if (!is_here(host)) {
        snprintf(out, COMMAND_MAX, "ssh %s systemctl restart collided", host);
        return;
    }
    options_of(pid, options, sizeof options);
    if (unit_of(pid, unit)) {
        restart_unit(unit, options, key, value, out);
        return;
    }
    if (key) snprintf(more, sizeof more, " --%s %ld", key, value);
    snprintf(out, COMMAND_MAX, "kill %ld; %.200s%.200s%s", pid,
        command_word(d->options.daemon, program, sizeof program), options, more);
}

void command_ctl(const doctor *d, const char *words, char out[COMMAND_MAX])
{
    const char *said = getenv("COLLIDED_URI");
    char uri[256], interface[64];
    bool known = strcmp(d->options.uri, said && *said ? said : "dds://0") == 0;
    snprintf(out, COMMAND_MAX, "collidectl%s%.200s%s%.40s %.200s", known ? "" : " --connect ",
        known ? "" : command_word(d->options.uri, uri, sizeof uri), *d->options.interface ? " --interface " : "",
        *d->options.interface ? command_word(d->options.interface, interface, sizeof interface) : "", words);
}

void command_start(const doctor *d, char out[COMMAND_MAX])
{
    char program[PATH_MAX], uri[256], interface[64];
    if (access("/lib/systemd/system/collided.service", R_OK) == 0 && access("/run/systemd/system", F_OK) == 0 &&
        strcmp(d->options.uri, "dds://0") == 0 && !*d->options.interface) {
        snprintf(out, COMMAND_MAX, "systemctl start collided");
        return;
    }
    snprintf(out, COMMAND_MAX, "%.200s --links %.200s%s%.40s", command_word(d->options.daemon, program, sizeof program),
        command_word(d->options.uri, uri, sizeof uri), *d->options.interface ? " --interface " : "",
        *d->options.interface ? command_word(d->options.interface, interface, sizeof interface) : "");
}

void command_replace(const doctor *d, char out[COMMAND_MAX])
{
    char host[128], unit[64], start[COMMAND_MAX];
    long known = 0;
    if (d->daemon && !split_name(d->daemon->name, host, &known)) known = 0;
    pid_t pid = facts_process(d->options.system_root, "collided", (pid_t)known);
    if (!pid)
        snprintf(out, COMMAND_MAX, "systemctl restart collided   # on the host of that daemon, after an upgrade");
    else if (unit_of(pid, unit))
        snprintf(out, COMMAND_MAX, "systemctl restart %s", unit);
    else if (d->daemon)
        snprintf(out, COMMAND_MAX, "kill %d", (int)pid);
    else {
        command_start(d, start);
        snprintf(out, COMMAND_MAX, "kill %d; %.490s", (int)pid, start);
    }
}
