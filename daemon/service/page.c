/* page: names, types and words for Prometheus. */
#include "page.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

typedef struct family {
    const char *prefix; /* of the figure's name in Status */
    const char *name, *label, *help;
    bool gauge;
    const char
        *label_after; /* the label's text is 16 digits and '_', and this one's is what follows; NULL: it has none */
} family;

/* The first that fits counts. */
static const family FAMILIES[] = {
    {"in_", "messages_in_total", "kind", "messages that came and were well-formed", false, NULL},
    {"reject_", "messages_rejected_total", "reason", "messages, or parts of them, that were refused", false, NULL},
    {"pairs_by_", "pairs_settled_total", "stage", "pairs in ticks, by the stage of the cascade that settled them",
        false, NULL},
    {"work_of_", "stream_work_units", "stream", "units of the cascade's work a tick, of this subscriber's pairs", true,
        NULL},
    {"events_of_", "stream_events_total", "stream", "events reported on this stream", false, NULL},
    {"contacts_of_", "stream_contacts", "stream", "pairs that touch, as this stream was told", true, NULL},
    {"unknown_of_", "stream_unknown_pairs", "stream", "pairs of this stream of which nothing can be said", true, NULL},
    {"nearest_nm_of_", "stream_nearest_nanometres", "stream",
        "least distance of the pairs that touch or are near, its lower bound; negative: depth", true, NULL},
    {"soonest_ns_of_", "stream_soonest_impact_seconds", "stream", "until the first predicted contact may be", true,
        NULL},
    {"oldest_pose_ns_of_", "stream_oldest_pose_seconds", "stream", "age of the oldest pose that this stream rests on",
        true, NULL},
    {"brief_cut_of_", "stream_brief_cut", "stream", "1: these figures are of the first 20,000 pairs of this stream",
        true, NULL},
    {"behind_of_", "stream_messages_behind", "stream", "messages of this stream that its subscriber has not read", true,
        NULL},
    {"lost_client_", "lost_client_bodies", "client", "bodies that stay of a client whose lease ran out", true, NULL},
    {"client_name_", "client_info", "client", "always 1: the name of a client", true, "name"},
    {"client_bodies_", "client_bodies", "client", "bodies of a client in the world", true, NULL},
    {"client_left_", "client_left", "client", "1: the client left in order, and its bodies stay", true, NULL},
    {"client_silent_ns_", "client_silent_seconds", "client", "since the last sign of life of a client", true, NULL},
    {"client_pose_age_ns_", "client_pose_age_seconds", "client", "since the stamp of the newest pose of a client", true,
        NULL},
    {"client_poses_", "client_poses_total", "client", "poses that a client sent", false, NULL},
    {"client_spent_ms_", "client_spent_milliseconds_total", "client",
        "expected work of the commands and queries of a client", false, NULL},
    {"client_pending_", "client_pending_bodies", "client", "bodies of a client that wait for a geometry", true, NULL},
    {"pending_body_ns_", "pending_body_seconds", "body", "since it waits for a geometry; of the first of them", true,
        NULL},
    {"client_work_", "client_work_units", "client", "units of the cascade's work a tick, of a client's subscriptions",
        true, NULL},
};

typedef struct single {
    const char *name, *help;
    bool gauge;
} single;

static const single SINGLES[] = {
    {"ready", "1 once the world is whole, until the daemon ends", true},
    {"limits_reached", "1 for a minute after a limit was reached", true},
    {"clients", "clients that are known", true},
    {"bodies", "bodies in the world", true},
    {"soft_bodies", "soft bodies in the world", true},
    {"soft_vertices", "vertices of all soft bodies, each counted for 2048 at least", true},
    {"soft_waiting", "soft bodies whose newest frame waits for its step", true},
    {"soft_steps", "steps of soft bodies that were found out", false},
    {"soft_unfinished", "steps of soft bodies that took more work than a step may: unknown, never free", false},
    {"frames_skipped", "frames of vertices that a newer one replaced before their step", false},
    {"shapes", "shapes in the world, children of compounds included", true},
    {"stale_bodies", "bodies past their deadline", true},
    {"subscriptions", "subscriptions that stand", true},
    {"pairs", "pairs of shapes whose fat boxes meet", true},
    {"pending_pairs",
        "pairs, at least, whose bodies have changed since they were decided or searched for impacts, or not looked for "
        "yet",
        true},
    {"bodies_with_pending_pairs", "bodies of which some pairs are pending, or that are yet to go with their client",
        true},
    {"sliced_ticks", "ticks that left something pending, or went on with it", false},
    {"pairs_left_out", "pairs that are not looked at: there are max_pairs of them already, or no memory for more",
        true},
    {"suspects", "commands that are refused for a while: a daemon was killed while it carried them out", true},
    {"memory_resident_bytes", "memory of the daemon that is resident", true},
    {"memory_limit_bytes", "memory that it may have resident (memory_limit); 0: none is kept", true},
    {"contacts", "contacts that stand", true},
    {"geometries", "hulls, meshes and height fields in the store", true},
    {"waiting_messages", "messages that wait for their participant's share of work", true},
    {"purses", "participants, or clients where nobody is told apart, that have a share", true},
    {"waiting_bytes", "memory that these take", true},
    {"lost_clients", "clients whose lease ran out and whose bodies stay", true},
    {"lost_bodies", "bodies of clients whose lease ran out", true},
    {"work", "units of work of the last tick; 0 without a budget", true},
    {"undone", "pairs that the budget left in the last tick", true},
    {"unbounded", "of those, the ones without bounds of their own", true},
    {"undone_ticks", "ticks whose budget left something", false},
    {"other_streams_work", "units of the cascade's work a tick, of subscribers beyond those that are named", true},
    {"last_tick_ns", "duration of the last tick", true},
    {"round_longest_ns", "the longest round of the loop since the start: receiving, ticks, answers", true},
    {"round_most_cpu_ns", "processor time of the loop's own thread in its most laborious round since the start", true},
    {"streams", "streams that stand", true},
    {"streams_behind", "streams whose subscriber has not read what waits for it", true},
    {"certificate_days", "days until the first certificate of the security folder expires", true},
    {"clients_unheard", "clients that are alive while what they publish does not come", true},
    {"streams_starving", "of those, the ones whose subscriber reads too little", true},
    {"waiting_commands", "commands that wait for a geometry", true},
    {"pending_bodies", "bodies that wait for a geometry", true},
    {"pending_geometries", "geometries that have come and are being built", true},
    {"pending_build_work", "units of work of those, about 5 us each", true},
    {"pending_build_bytes", "bytes that those take, about", true},
    {"budget_ns", "time that a tick may take; 0 without a budget", true},
    {"latency_p50_ns", "half of the latencies since the last Status were at most this", true},
    {"latency_p90_ns", "nine of ten latencies since the last Status were at most this", true},
    {"latency_p99_ns", "99 of 100 latencies since the last Status were at most this", true},
    {"latency_most_ns", "the largest latency since the last Status", true},
    {"tick_p50_ns", "half of the ticks since the last Status took at most this", true},
    {"tick_p90_ns", "nine of ten ticks since the last Status took at most this", true},
    {"tick_p99_ns", "99 of 100 ticks since the last Status took at most this", true},
    {"tick_most_ns", "the longest tick since the last Status", true},
    {"lock_step_clients", "clients in lock-step with each other", true},
    {"ticks", "ticks since the start", false},
    {"moves", "poses applied", false},
    {"events", "events of the world", false},
    {"narrow_queries", "full queries of the narrow phase", false},
    {"manifolds", "answers with contact points", false},
    {"wide_answers", "answers wider than asked: arithmetic, or the effort of a query, ended", false},
    {"refined_answers", "answers decided beyond doubles", false},
    {"ccd_failures", "proposals of libccd that could not be certified", false},
    {"sweeps", "searches for a time of impact", false},
    {"sweep_queries", "distances and verdicts in searches for a time of impact", false},
    {"sweeps_by_axis", "searches for a time of impact that an axis settled", false},
    {"impacts", "impacts found", false},
    {"predicted", "contacts predicted", false},
    {"undecided_sweeps", "searches for a time of impact whose steps ended", false},
    {"dropped_motions", "bodies that waited for so long that motions of theirs were dropped, not searched for impacts",
        false},
    {"coarse_motions", "motions of bodies with more poses in a tick than are searched one by one", false},
};

__attribute__((format(printf, 2, 3))) static void put_text(page_text *to, const char *format, ...)
{
    char line[512];
    va_list words;
    va_start(words, format);
    int size = vsnprintf(line, sizeof line, format, words);
    va_end(words);
    size_t used = size < 0 ? 0 : (size_t)size < sizeof line ? (size_t)size : sizeof line - 1;
    array_reserve(to, to->count + used);
    memcpy(to->at + to->count, line, used);
    to->count += used;
}

static void put_family_head(page_text *to, const char *name, const char *type, const char *help)
{
    put_text(to, "# HELP collided_%s %s\n# TYPE collided_%s %s\n", name, help, name, type);
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* A backslash, a quote or an end of line would end the label. */
static void put_label(page_text *to, const char *name, const char *text)
{
    put_text(to, "%s=\"", name);
    for (; *text; text++) put_text(to, strchr("\\\"", *text) ? "\\%c" : "%c", *text == '\n' ? ' ' : *text);
    put_text(to, "\"");
}

/* Is the last line a figure of that family? Its members follow each other; names that clients chose stand behind. */
static bool family_goes_on(const page_text *page, const char *family)
{
    char begin[128];
    size_t size = (size_t)snprintf(begin, sizeof begin, "collided_%s{", family), at = page->count;
    while (at > 0 && (at == page->count || page->at[at - 1] != '\n')) at--;
    return page->count - at > size && memcmp(page->at + at, begin, size) == 0;
}

static bool ends_in(const char *text, size_t length, const char *with)
{
    size_t size = strlen(with);
    return length >= size && strncmp(text + length - size, with, size) == 0;
}

static void put_value(page_text *to, bool time, int64_t value)
{
    if (time)
        put_text(to, " %.9g\n", 1e-9 * (double)value);
    else
        put_text(to, " %" PRId64 "\n", value);
}

static void put_labels(page_text *to, const family *f, const char *text)
{
    enum { ID_DIGITS = 16 };
    put_text(to, "{");
    if (f->label_after && strlen(text) > ID_DIGITS) {
        char id[ID_DIGITS + 1] = "";
        memcpy(id, text, ID_DIGITS);
        put_label(to, f->label, id);
        put_text(to, ",");
        put_label(to, f->label_after, text + ID_DIGITS + 1);
    } else {
        put_label(to, f->label, text);
    }
    put_text(to, "}");
}

static bool is_time(const char *prefix)
{
    size_t size = strlen(prefix);
    return ends_in(prefix, size, "_ns_") || ends_in(prefix, size, "_ns_of_");
}

/* A family's head stands before the first of its lines. */
static bool put_member(page_text *to, const char *name, int64_t value)
{
    for (size_t i = 0; i < sizeof FAMILIES / sizeof *FAMILIES; i++) {
        const family *f = &FAMILIES[i];
        if (!begins(name, f->prefix)) continue;
        if (!family_goes_on(to, f->name)) put_family_head(to, f->name, f->gauge ? "gauge" : "counter", f->help);
        put_text(to, "collided_%s", f->name);
        put_labels(to, f, name + strlen(f->prefix));
        put_value(to, is_time(f->prefix), value);
        return true;
    }
    return false;
}

void page_number(page_text *to, const char *name, const char *help, int64_t value)
{
    bool gauge = false;
    char as[96];
    if (put_member(to, name, value)) return;
    for (size_t i = 0; i < sizeof SINGLES / sizeof *SINGLES; i++) {
        if (strcmp(SINGLES[i].name, name) != 0) continue;
        gauge = SINGLES[i].gauge;
        help = SINGLES[i].help;
    }
    size_t length = strlen(name);
    bool time = ends_in(name, length, "_ns");
    snprintf(as, sizeof as, "%.*s%s%s", (int)(time ? length - 3 : length), name, time ? "_seconds" : "",
        gauge ? "" : "_total");
    put_family_head(to, as, gauge ? "gauge" : "counter", help ? help : name);
    put_text(to, "collided_%s", as);
    put_value(to, time, value);
}

void page_histogram(page_text *to, const histogram *h)
{
    uint64_t below = 0;
    put_family_head(to, h->name, "histogram", h->help);
    for (size_t i = 0; i < h->count; i++) {
        below += h->below[i];
        put_text(to, "collided_%s_bucket{le=\"%.9g\"} %" PRIu64 "\n", h->name, h->bounds[i], below);
    }
    uint64_t total = histogram_total(h);
    put_text(to, "collided_%s_bucket{le=\"+Inf\"} %" PRIu64 "\n", h->name, total);
    put_text(to, "collided_%s_sum %.17g\ncollided_%s_count %" PRIu64 "\n", h->name, h->sum, h->name, total);
}

void page_build_info(page_text *to, const char *release, const char *daemon)
{
    put_family_head(to, "build_info", "gauge", "always 1: what runs here");
    put_text(to, "collided_build_info{");
    put_label(to, "release", release);
    put_text(to, ",");
    put_label(to, "daemon", daemon);
    put_text(to, "} 1\n");
}
