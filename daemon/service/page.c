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
} family;

static const family FAMILIES[] = {
    {"in_", "messages_in_total", "kind", "messages that came and were well-formed", false},
    {"reject_", "messages_rejected_total", "reason", "messages, or parts of them, that were refused", false},
    {"pairs_by_", "pairs_settled_total", "rung", "pairs in ticks, by the rung of the ladder that settled them", false},
    {"work_of_", "stream_work_units", "stream", "units of the ladder's work a tick, of this subscriber's pairs", true},
    {"lost_client_", "lost_client_bodies", "client", "bodies that stay of a client whose lease ran out", true},
};

typedef struct single {
    const char *name, *help;
    bool gauge;
} single;

static const single SINGLES[] = {
    {"clients", "clients that are known", true},
    {"bodies", "bodies in the world", true},
    {"shapes", "shapes in the world, children of compounds included", true},
    {"stale_bodies", "bodies past their deadline", true},
    {"interests", "interests that stand", true},
    {"pairs", "pairs of shapes whose fat boxes meet", true},
    {"contacts", "contacts that stand", true},
    {"geometries", "hulls, meshes and height fields in the store", true},
    {"lost_clients", "clients whose lease ran out and whose bodies stay", true},
    {"lost_bodies", "bodies of clients whose lease ran out", true},
    {"work", "units of work of the last tick; 0 without a budget", true},
    {"undone", "pairs that the budget left in the last tick", true},
    {"unbounded", "of those, the ones without bounds of their own", true},
    {"undone_ticks", "ticks whose budget left something", false},
    {"other_streams_work", "units of the ladder's work a tick, of subscribers beyond those that are named", true},
    {"last_tick_ns", "duration of the last tick", true},
    {"lock_step_clients", "clients in lock-step with each other", true},
    {"ticks", "ticks", false},
    {"moves", "poses applied", false},
    {"events", "events of the world", false},
    {"narrow_queries", "full queries of the narrow phase", false},
    {"manifolds", "answers with contact points", false},
    {"wide_answers", "answers wider than asked: arithmetic ended", false},
    {"refined_answers", "answers decided beyond doubles", false},
    {"ccd_failures", "proposals of libccd that could not be certified", false},
    {"sweeps", "searches for a time of impact", false},
    {"sweep_queries", "distances and verdicts in searches for a time of impact", false},
    {"sweeps_by_axis", "searches for a time of impact that an axis settled", false},
    {"impacts", "impacts found", false},
    {"foretold", "contacts foretold", false},
    {"undecided_sweeps", "searches for a time of impact whose steps ended", false},
    {"coarse_ways", "ways of bodies with more poses in a tick than are searched one by one", false},
};

__attribute__((format(printf, 2, 3))) static void put(page_text *to, const char *format, ...)
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

static void put_head(page_text *to, const char *name, const char *type, const char *help)
{
    put(to, "# HELP collided_%s %s\n# TYPE collided_%s %s\n", name, help, name, type);
}

static bool begins(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

/* A backslash, a quote or an end of line would end the label. */
static void put_label(page_text *to, const char *name, const char *text)
{
    put(to, "%s=\"", name);
    for (; *text; text++) put(to, strchr("\\\"", *text) ? "\\%c" : "%c", *text == '\n' ? ' ' : *text);
    put(to, "\"");
}

/* Is the last line a figure of that family? Its members follow each other; names that clients chose stand behind. */
static bool goes_on(const page_text *page, const char *family)
{
    char begin[128];
    size_t size = (size_t)snprintf(begin, sizeof begin, "collided_%s{", family), at = page->count;
    while (at > 0 && (at == page->count || page->at[at - 1] != '\n')) at--;
    return page->count - at > size && memcmp(page->at + at, begin, size) == 0;
}

/* A family's head stands before the first of its lines. */
static bool put_member(page_text *to, const char *name, int64_t value)
{
    for (size_t i = 0; i < sizeof FAMILIES / sizeof *FAMILIES; i++) {
        const family *f = &FAMILIES[i];
        if (!begins(name, f->prefix)) continue;
        if (!goes_on(to, f->name)) put_head(to, f->name, f->gauge ? "gauge" : "counter", f->help);
        put(to, "collided_%s{", f->name);
        put_label(to, f->label, name + strlen(f->prefix));
        put(to, "} %" PRId64 "\n", value);
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
    bool time = length > 3 && strcmp(name + length - 3, "_ns") == 0;
    snprintf(as, sizeof as, "%.*s%s%s", (int)(time ? length - 3 : length), name, time ? "_seconds" : "",
        gauge ? "" : "_total");
    put_head(to, as, gauge ? "gauge" : "counter", help ? help : name);
    if (time)
        put(to, "collided_%s %.9g\n", as, 1e-9 * (double)value);
    else
        put(to, "collided_%s %" PRId64 "\n", as, value);
}

void page_histogram(page_text *to, const histogram *h)
{
    uint64_t below = 0;
    put_head(to, h->name, "histogram", h->help);
    for (size_t i = 0; i < h->count; i++) {
        below += h->below[i];
        put(to, "collided_%s_bucket{le=\"%.9g\"} %" PRIu64 "\n", h->name, h->bounds[i], below);
    }
    uint64_t total = histogram_total(h);
    put(to, "collided_%s_bucket{le=\"+Inf\"} %" PRIu64 "\n", h->name, total);
    put(to, "collided_%s_sum %.17g\ncollided_%s_count %" PRIu64 "\n", h->name, h->sum, h->name, total);
}

void page_build_info(page_text *to, const char *release, const char *daemon)
{
    put_head(to, "build_info", "gauge", "always 1: what runs here");
    put(to, "collided_build_info{");
    put_label(to, "release", release);
    put(to, ",");
    put_label(to, "daemon", daemon);
    put(to, "} 1\n");
}
