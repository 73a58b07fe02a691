/* verb_status: the daemon's health, limits and counters. Serves as a health check by its exit status. */
#include "json.h"
#include "verbs.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sysexits.h>
#include <time.h>

static void print_status_json(const collided_daemon_status *s)
{
    json j = {.out = stdout};
    json_open(&j, NULL, '{');
    json_text(&j, "health", s->health);
    json_text(&j, "daemon", s->daemon);
    json_text(&j, "release", s->release);
    json_text(&j, "links", s->links);
    json_text(&j, "limits", s->limits);
    json_integer(&j, "epoch", s->epoch);
    json_integer(&j, "tick", s->tick);
    json_integer(&j, "stamp_ns", s->stamp_ns);
    json_integer(&j, "started_ns", s->started_ns);
    json_open(&j, "counters", '{');
    for (size_t i = 0; i < s->counter_count; i++) json_integer(&j, s->counters[i].name, s->counters[i].value);
    json_close(&j, '}');
    json_close(&j, '}');
    json_end_line(&j);
}

/* The counters that stand under a title of their own: the prefix of their names. */
static const char *const prefixes[] = {"pairs_by_", "work_of_", "pending_body_ns_"};

static bool has_prefix(const char *name, const char *prefix)
{
    return strncmp(name, prefix, strlen(prefix)) == 0;
}

/* NULL: all others. */
static bool belongs(const char *name, const char *prefix)
{
    if (prefix) return has_prefix(name, prefix);
    for (size_t i = 0; i < sizeof prefixes / sizeof *prefixes; i++)
        if (has_prefix(name, prefixes[i])) return false;
    return true;
}

static void print_group(const collided_daemon_status *s, const char *title, const char *prefix)
{
    size_t width = 0, cut = prefix ? strlen(prefix) : 0;
    for (size_t i = 0; i < s->counter_count; i++)
        if (belongs(s->counters[i].name, prefix)) {
            size_t length = strlen(s->counters[i].name) - cut;
            width = length > width ? length : width;
        }
    if (width) puts(title);
    for (size_t i = 0; i < s->counter_count; i++)
        if (belongs(s->counters[i].name, prefix))
            printf("  %-*s %12" PRId64 "\n", (int)width, s->counters[i].name + cut, s->counters[i].value);
}

static void print_table(const collided_daemon_status *s)
{
    printf("%-10s %s\n", "health", s->health);
    printf("%-10s %s, release %s\n", "daemon", s->daemon, s->release);
    printf("%-10s %s\n", "links", s->links);
    printf("%-10s %s\n", "limits", *s->limits ? s->limits : "none reached");
    printf("%-10s %" PRId64 ", tick %" PRId64 "\n", "epoch", s->epoch, s->tick);
    printf("%-10s %.1f s\n", "up", 1e-9 * (double)(s->stamp_ns - s->started_ns));
    print_group(s, "counters", NULL);
    print_group(s, "pairs by stage, since the start", "pairs_by_");
    print_group(s, "bodies that wait for their geometry, for so long (ns)", "pending_body_ns_");
    print_group(s, "work of subscribers, units a tick (about ns)", "work_of_");
}

/* The counter of that name, or a number that none has. */
static int64_t find_counter(const collided_daemon_status *s, const char *prefix, const char *stream)
{
    size_t cut = strlen(prefix);
    for (size_t i = 0; i < s->counter_count; i++)
        if (has_prefix(s->counters[i].name, prefix) && strcmp(s->counters[i].name + cut, stream) == 0)
            return s->counters[i].value;
    return INT64_MIN;
}

static int64_t count_of(const collided_daemon_status *s, const char *name)
{
    int64_t value = find_counter(s, name, "");
    return value > 0 ? value : 0;
}

/* What an operator watches of one stream; what the daemon does not tell of it is left out. */
static void print_stream(const collided_daemon_status *s, const char *stream)
{
    int64_t nearest_nm = find_counter(s, "nearest_nm_of_", stream),
            soonest_ns = find_counter(s, "soonest_ns_of_", stream),
            oldest_ns = find_counter(s, "oldest_pose_ns_of_", stream), unknown = find_counter(s, "unknown_of_", stream),
            cut = find_counter(s, "brief_cut_of_", stream);
    printf("%s: %" PRId64 " contacts", stream, find_counter(s, "contacts_of_", stream));
    if (unknown > 0) printf(", %" PRId64 " pairs unknown", unknown);
    if (nearest_nm != INT64_MIN) printf(", nearest %.3f mm", 1e-6 * (double)nearest_nm);
    if (soonest_ns != INT64_MIN) printf(", impact possible in %.2f s", 1e-9 * (double)soonest_ns);
    if (oldest_ns != INT64_MIN) printf(", oldest pose %.1f ms", 1e-6 * (double)oldest_ns);
    puts(cut > 0 ? " (of its first 20,000 pairs)" : "");
}

static void print_brief(const collided_daemon_status *s)
{
    printf("%s: %" PRId64 " bodies of %" PRId64 " clients, %" PRId64 " contacts%s%s\n", s->health,
        count_of(s, "bodies"), count_of(s, "clients"), count_of(s, "contacts"), *s->limits ? "; " : "", s->limits);
    for (size_t i = 0; i < s->counter_count; i++)
        if (has_prefix(s->counters[i].name, "contacts_of_"))
            print_stream(s, s->counters[i].name + strlen("contacts_of_"));
}

static bool is_ready(const collided_daemon_status *s)
{
    return strcmp(s->health, "ready") == 0;
}

static int ask(ctl *c, collided_daemon_status *s)
{
    time_t end = time(NULL) + (time_t)ceil(c->options.wait_s);
    for (;;) {
        int status = ctl_check(c, collided_get_status(c->client, c->options.timeout_s, s), "status");
        if (status || is_ready(s) || time(NULL) >= end) return status;
        nanosleep(&(struct timespec){0, 100000000}, NULL);
    }
}

int verb_status(ctl *c)
{
    if (c->options.wait_s > c->options.timeout_s) c->options.timeout_s = c->options.wait_s;
    int status = ctl_connect_guest(c);
    collided_daemon_status s = {0};
    if (!status) status = ask(c, &s);
    if (status) return status;
    if (c->options.json)
        print_status_json(&s);
    else if (c->options.brief)
        print_brief(&s);
    else
        print_table(&s);
    return is_ready(&s)
               ? EX_OK
               : ctl_fail(EX_TEMPFAIL, "the daemon is %s, not ready%s%s", s.health, *s.limits ? ": " : "", s.limits);
}
